/* A rod whose load and stiffness are inputs, for tests of rollouts. */
#ifndef TESTS_ROLLOUTS_TESTING_H
#define TESTS_ROLLOUTS_TESTING_H

#define ARM(e)                                                                                     \
    "parameters: {p: {range: [-2, 3]}, e: " e "}\n"                                                \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [30*e, 40*e], axial: 50*e, bending: [e, 1.5*e], torsion: 0.8*e}\n"       \
    "  inertia: {mass_per_length: 1, rotary: [0.01, 0.02, 0.03]}\n"                                \
    "  damping: {strain: [0.1, 0.1, 0.1], curvature: [0.05, 0.05, 0.05]}\n"                        \
    "boundary: {start: {type: clamped}, end: {type: loaded}}\n"                                    \
    "loads: {tip: {force: [p, 0.5, 0]}}\n"                                                         \
    "time: {duration: 1}\n"

#endif
