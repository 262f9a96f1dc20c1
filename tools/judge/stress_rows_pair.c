/* Scenes without a closed form: the network's error is its distance from the solver, the solver's
 * what it says itself. */
#include "tools/judge/stress_rows.h"

#define SHEARED                                                                                    \
    "rod:\n"                                                                                       \
    "  model: cosserat\n"                                                                          \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [40, 60], axial: 100, bending: [1, 2], torsion: 0.7}\n"                  \
    "  inertia: {mass_per_length: 1, rotary: [1e-2, 2e-2, 3e-2]}\n"                                \
    "reference: solve\n"
#define PULLED  SHEARED "loads: {tip: {force: [1, 0, 1e4]}}\n"
#define AGREED  SOLVED(1e-6, "two programs that share no equation")
#define IN_STEP SOLVED(1e-4, "two programs that share no equation")

static const stress_row rows[] = {
    {"pair/space", SHEARED "loads: {tip: {force: [3, 4, -2], moment: [0, 1, 1]}}\n", .quick = true,
     PINN = AGREED, SOLVER = EXACT},
    {"pair/heavy-hook", SHEARED "loads: {gravity: [20, 0, -20]}\n",
     .overrides = {"rod.rest.curvature=[0, 6, 2]"}, PINN = AGREED, SOLVER = EXACT},
    {"pair/follower", SHEARED "loads: {tip: {force: [8, 3, 0], frame: follower}}\n",
     PINN = FLUTTERS(1e-6, "two programs that share no equation"), SOLVER = FLUTTERS_EXACT},
    {"pair/pulled-1e4", PULLED, .overrides = {"rod.stiffness.shear=[400, 600]"},
     PINN = DIGITS("stretched a hundredfold"),
     SOLVER = WARNED(VERDICT_STRAIN_LARGE, "no linear law holds a hundredfold")},
    {"pair/tension-buckling", PULLED,
     BOTH(WARNED(VERDICT_UNSTABLE, "softer in shear than in stretch it gives way under tension"))},
    {"pair/ends",
     SHEARED "boundary: {end: {type: clamped, position: [0.2, 0.1, 0.8], "
             "rotation: [0.9, 0.2, 0.3, 0.2]}}\n",
     PINN = AGREED, SOLVER = EXACT},
    {"pair/whirl", SHEARED IN_ONE "loads: {tip: {force: [t^2, sin(3*t)^2, 0]}}\n", .seconds = 60,
     .is_long = true, PINN = IN_STEP, SOLVER = SOLVED(1e-6, "what it was asked for")},
    {"pair/drag-1e3", SHEARED IN_ONE "loads: {drag: 1000, tip: {force: [5*t^2, 0, 0]}}\n",
     .seconds = 60, PINN = IN_STEP, SOLVER = SOLVED(1e-6, "what it was asked for")},
};
const stress_group stress_pairs = GROUP("By network and solver, without a closed form", rows);
