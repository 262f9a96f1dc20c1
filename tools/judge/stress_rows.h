/* What the tables of rows share. */
#ifndef TOOLS_JUDGE_STRESS_ROWS_H
#define TOOLS_JUDGE_STRESS_ROWS_H

#include "tools/judge/stress.h"

/* L = EI = rhoA = 1, along +z with d1 along +x unless the scene turns it; the rotary inertia is
 * that of a round rod, length over radius 50. */
#define ROD                                                                                        \
    "rod:\n"                                                                                       \
    "  model: kirchhoff\n"                                                                         \
    "  length: 1\n"                                                                                \
    "  stiffness: {bending: [1, 1], torsion: 1}\n"                                                 \
    "  inertia: {mass_per_length: 1, rotary: [0, 0, 0]}\n"
#define ALONG_X    "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}\n"
#define BESIDE     "reference: {file: reference.csv}\n"
#define ELASTICA   "reference: {analytic: elastica}\n"
#define ROLLUP     "reference: {analytic: rollup}\n"
#define HELIX      "reference: {analytic: helix}\n"
#define IN_ONE     "time: {duration: 1}\n"
#define PULL       ROD "loads: {tip: {force: [1, 0, 0]}}\n" ELASTICA
#define PULL_MOVED ROD IN_ONE "loads: {tip: {force: [t^2, 0, 0]}}\n"

#define PINN   .expected[JUDGE_NETWORK]
#define SOLVER .expected[JUDGE_SOLVER]
/* Of both methods. */
#define BOTH(what) .expected = {what, what}
#define SOLVED(limit, because)                                                                     \
    {                                                                                              \
        VERDICT_SOLVED, .bound = (limit), .why = (because)                                         \
    }
#define REFUSED(what, because)                                                                     \
    {                                                                                              \
        VERDICT_REFUSED, .text = (what), .why = (because)                                          \
    }
#define STOPPED(what, because)                                                                     \
    {                                                                                              \
        VERDICT_STOPPED, .text = (what), .why = (because)                                          \
    }
#define WARNED(because_of, because)                                                                \
    {                                                                                              \
        VERDICT_WARNING, .reason = (because_of), .why = (because)                                  \
    }
/* An equilibrium that is found, and not stable: the rod has no damping, and its load follows it or
 * is a moment in space. */
#define FLUTTERS(limit, because)                                                                   \
    {                                                                                              \
        VERDICT_WARNING, .reason = VERDICT_UNSTABLE, .bound = (limit), .why = (because)            \
    }
#define FLUTTERS_EXACT FLUTTERS(1e-9, "1e-10 is asked for; it flutters without damping")
/* A network at rest that reaches some digits and says so. */
#define DIGITS(because) WARNED(VERDICT_ESTIMATE_ABOVE_TOLERANCE, because)
#define GROUP(what, list)                                                                          \
    {                                                                                              \
        what, list, (int)(sizeof(list) / sizeof *(list))                                           \
    }

/* Errors of position that a user may count on, and what is usual. */
#define AT_REST   SOLVED(1e-6, "smooth at rest: 1e-9 is usual")
#define IN_MOTION SOLVED(1e-4, "smooth motion: 1e-6 to 1e-5 is usual")

/* Of the solver. */
#define EXACT SOLVED(1e-9, "1e-10 is asked for; files have ten digits")

#endif
