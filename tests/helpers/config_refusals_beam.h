/* Scenes of beams that do not make one, or have what only rods in space have, and the other way
 * round; the exact line each is refused with. */
#ifndef TESTS_CONFIG_REFUSALS_BEAM_H
#define TESTS_CONFIG_REFUSALS_BEAM_H

#include "config_refusals_scene.h"

/* What follows begins on line 5. */
#define BEAM                                                                                       \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  model: euler_bernoulli\n"                                                                   \
    "  stiffness: {bending: [1, 1]}\n"
#define STOUT                                                                                      \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  model: timoshenko\n"                                                                        \
    "  stiffness: {bending: [1, 1], shear: [9, 9]}\n"                                              \
    "  inertia: {mass_per_length: 1, rotary: [0.1, 0, 0]}\n"

static const refusal beam_refusals[] = {
    {KIRCHHOFF "beam: {force: 1}\n", NULL,
     "scene.yaml:5:15: beam.force: belongs to a beam of small deflection; leave it out, or take "
     "rod.model euler_bernoulli or timoshenko"},
    {KIRCHHOFF "reference: {deflection: s}\n", NULL,
     "scene.yaml:5:25: reference.deflection: is that of a beam; for a rod in space give "
     "reference.analytic or reference.file"},
    {BEAM "  inertia: {mass_per_length: 1}\n"
          "loads: {gravity: [0, 0, -9.81]}\n",
     NULL,
     "scene.yaml:6:18: loads.gravity: acts on a rod in space; a beam has its weight across the "
     "axis in beam.force"},
    {BEAM "  inertia: {mass_per_length: 1}\n"
          "time: {duration: 1}\n"
          "beam: {initial: {deflection: s}}\n",
     NULL,
     "scene.yaml:7:30: beam.initial.deflection: does not meet the ends at t = 0; allowed: a state "
     "that does, or enforcement.initial soft"},
    {BEAM "loads: {force: [0, 1, 0]}\n", NULL,
     "scene.yaml:5:16: loads.force: acts on a rod in space; a beam has beam.force, beam.moment, "
     "beam.base, beam.tip and loads.drag"},
    {BEAM "loads: {quadratic_drag: 1}\n", NULL,
     "scene.yaml:5:25: loads.quadratic_drag: acts on a rod in space; a beam has beam.force, "
     "beam.moment, beam.base, beam.tip and loads.drag"},
    {BEAM "loads: {tip: {force: [0, 1, 0]}}\n", NULL,
     "scene.yaml:5:14: loads.tip: acts on a rod in space; a beam has beam.force, beam.moment, "
     "beam.base, beam.tip and loads.drag"},
    {BEAM "loads: {units: EI}\n", NULL,
     "scene.yaml:5:16: loads.units: scales the loads of rods in space; those of a beam are in SI"},
    {BEAM "motion: planar\n", NULL,
     "scene.yaml:5:9: motion: belongs to a rod in space; leave it out, or take another rod.model"},
    {BEAM "initial: {velocity: [0, s, 0]}\n", NULL,
     "scene.yaml:5:21: initial.velocity: is that of a rod in space; a beam has beam.initial"},
    {BEAM "manufactured: {position: [0, 0, s], angles: [s, 0, 0]}\n", NULL,
     "scene.yaml:5:15: manufactured: makes loads of a rod in space; for a beam give beam.force and "
     "reference.deflection"},
    {BEAM "boundary: {start: {position: [0, 0, 1]}}\n", NULL,
     "scene.yaml:5:30: boundary.start.position: places a rod in space; a beam deflects along d2 "
     "from its straight axis, leave it out"},
    {BEAM "boundary: {start: {type: driven}}\n", NULL,
     "scene.yaml:5:26: boundary.start.type: driven ends and rollers are for rods in space; "
     "allowed for a beam: clamped, pinned, guided, free, loaded"},
    {BEAM "boundary: {start: {type: pinned}}\n", NULL,
     "scene.yaml:5:11: boundary: a static beam with these ends is free to move; clamp one, pin "
     "both, or give beam.foundation"},
    {BEAM "boundary: {end: {type: loaded}}\n", NULL,
     "scene.yaml:5:24: boundary.end.type: loaded, but no load is given there; say free"},
    {BEAM "boundary: {end: {type: free}}\n"
          "beam: {tip: {force: 1}}\n",
     NULL,
     "scene.yaml:6:13: beam.tip: acts on an end of another type; allowed: an end of type loaded"},
    {BEAM "beam: {tip: {force: s}}\n", NULL,
     "scene.yaml:5:21: beam.tip.force: depends on s, but it belongs to one end; allowed: a formula "
     "of t"},
    {BEAM "beam: {force: t}\n", NULL,
     "scene.yaml:5:15: beam.force: nothing takes a formula of time at rest: a rod at rest does not "
     "change in time; allowed: a scene without it, or with time.duration"},
    {BEAM "beam: {force: [0, 1, 0]}\n", NULL,
     "scene.yaml:5:15: beam.force: is a list; allowed: a number or a formula, in N/m"},
    {BEAM "beam: {force: 1 +}\n", NULL,
     "scene.yaml:5:15: beam.force: column 4 of '1 +': the formula ends where a number, a name or ( "
     "is expected"},
    {BEAM "beam: {foundation: s - 0.5}\n", NULL,
     "scene.yaml:5:20: beam.foundation: must be finite and >= 0 all along"},
    {BEAM "beam: {initial: {deflection: s^2}}\n", NULL,
     "scene.yaml:5:30: beam.initial.deflection: nothing takes a given state at t = 0 at rest: a "
     "rod at rest does not change in time; allowed: a scene without it, or with time.duration"},
    {BEAM "reference: {analytic: elastica}\n", NULL,
     "scene.yaml:5:23: reference.analytic: is a shape of rods in space; for a beam give "
     "reference.deflection"},
    {BEAM "reference: {deflection: t}\n", NULL,
     "scene.yaml:5:25: reference.deflection: depends on t, but the scene is static; give "
     "time.duration, or a formula without t"},
    {BEAM "reference: {deflection: s, file: nowhere.csv}\n", NULL,
     "scene.yaml:5:25: reference.deflection: given beside another reference; allowed: one of them"},
    {BEAM "  inertia: {mass_per_length: 1, rotary: [1, 1, 1]}\n", NULL,
     "scene.yaml:5:41: rod.inertia.rotary: euler_bernoulli has no rotary inertia; leave it out, or "
     "take timoshenko"},
    {BEAM "  inertia: {mass_per_length: 1}\n"
          "time: {duration: 1, windows: 2}\n"
          "formulation: displacement\n",
     NULL,
     "scene.yaml:6:30: time.windows: the strong form of euler_bernoulli needs four derivatives of "
     "the state that a window hands on, too many for rounding; allowed: 1, or formulation mixed"},
    {BEAM "  inertia: {mass_per_length: 1}\n"
          "time: {duration: 1}\n"
          "beam: {initial: {deflection: 1 + s}}\n",
     NULL,
     "scene.yaml:7:30: beam.initial.deflection: does not meet the ends at t = 0; allowed: a state "
     "that does, or enforcement.initial soft"},
    {BEAM "  inertia: {mass_per_length: 1}\n"
          "time: {duration: 1}\n"
          "beam: {initial: {slope: s}}\n",
     NULL,
     "scene.yaml:7:25: beam.initial.slope: follows from the deflection, since this beam has no "
     "rotary inertia; leave it out"},
    {BEAM "time: {duration: 1}\n", NULL,
     "scene.yaml:2:3: rod.inertia.mass_per_length: missing; a dynamic scene needs the rod's mass"},
    {BEAM "  rest: {curvature: [1, 0, 0]}\n", NULL,
     "scene.yaml:5:21: rod.rest.curvature: belongs to a rod in space; leave it out, or take "
     "another rod.model"},
    {BEAM "  damping: {curvature: [1, 0, 0]}\n", NULL,
     "scene.yaml:5:24: rod.damping.curvature: belongs to a rod in space; a beam is damped by "
     "loads.drag"},
    {STOUT "beam: {initial: {deflection: s}}\n", NULL,
     "scene.yaml:6:30: beam.initial.deflection: nothing takes a given state at t = 0 at rest: a "
     "rod at rest does not change in time; allowed: a scene without it, or with time.duration"},
    {"rod:\n"
     "  length: 1\n"
     "  model: euler_bernoulli\n"
     "  stiffness: {bending: [1, 1], torsion: 0.8}\n",
     NULL,
     "scene.yaml:4:41: rod.stiffness.torsion: contradicts rod.model, which locks this strain; "
     "leave it out, or take model cosserat"},
    {"rod:\n"
     "  length: 1\n"
     "  model: euler_bernoulli\n"
     "  stiffness: {bending: [1, 1], shear: [9, 9]}\n",
     NULL,
     "scene.yaml:4:39: rod.stiffness.shear: contradicts rod.model, which locks this strain; leave "
     "it out, or take model cosserat"},
    {"rod:\n"
     "  length: 1\n"
     "  model: timoshenko\n"
     "  stiffness: {bending: [1, 1]}\n",
     NULL,
     "scene.yaml:4:14: rod.stiffness.shear: missing; give rod.section and rod.material, or this "
     "stiffness itself"},
    {"rod:\n"
     "  length: 1\n"
     "  model: euler_bernoulli\n"
     "  stiffness: {bending: [.inf, 1]}\n",
     NULL,
     "scene.yaml:4:24: rod.stiffness.bending: the rod's bending stiffness is inf N m^2, beyond "
     "what can be computed with; allowed: 1e-60 to 1e+60"},
    {"rod:\n"
     "  length: 1\n"
     "  model: timoshenko\n"
     "  stiffness: {bending: [1, 1], shear: [9, .inf]}\n"
     "formulation: displacement\n",
     NULL,
     "scene.yaml:5:14: formulation: displacement computes the shear from its strain and needs "
     "finite stiffness; allowed for this beam: mixed"},
};

#endif
