/* A rod in motion for tests, with all that one can have. */
#ifndef EVERYTHING_H
#define EVERYTHING_H

/* Segments with a joint, tendons of given tension and displacement (one is slack), chamber, bodies,
 * springs, a foundation, drag of both kinds, loads dead and following, damping, a driven start; of
 * parameters p and e, usually 200 and 1. */
#define EVERYTHING(parameters, duration)                                                           \
    "parameters: {" parameters "}\n"                                                               \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [30*e, 40*e], axial: 50*e, bending: [e, 1.5*e], torsion: 0.8*e}\n"       \
    "  inertia: {mass_per_length: 1, rotary: [0.01, 0.02, 0.03]}\n"                                \
    "  rest: {curvature: [0.2, 0, 0.1*s]}\n"                                                       \
    "  damping: {strain: [0.1, 0.1, 0.1], curvature: [0.05, 0.05, 0.05]}\n"                        \
    "segments: [{length: 0.6}, {length: 0.4, turn: [0.3, 0.4, 0]}]\n"                              \
    "boundary:\n"                                                                                  \
    "  start: {type: driven, position: [0.1*sin(2*t)^2, 0, 0.05*t^2],\n"                           \
    "          rotation: [cos(t^2), 0.6*sin(t^2), 0, 0.8*sin(t^2)]}\n"                             \
    "  end: {type: loaded}\n"                                                                      \
    "tendons: [{offset: [0.03*(1+s), 0.02], end: 0.6, tension: 2*(p/200)},\n"                      \
    "  {offset: [-0.03, 0.02*(1+s)], displacement: 0.1*(p/200), stiffness: 20*e},\n"               \
    "  {offset: [0.02, -0.03], end: 0.6, displacement: -0.3, stiffness: 20}]\n"                    \
    "chambers: [{offset: [-0.02, 0.03], pressure: 10*p, area: 1.0e-3}]\n"                          \
    "bodies: [{at: 1, mass: 0.2, offset: [0.05, -0.04, 0.06], inertia: [0.01, 0.02, 0.03]}, {at: " \
    "0.6, mass: 0.1}]\n"                                                                           \
    "springs: [{at: 1, stiffness: [3, 1, 2], turning: [0.2, 0.2, 0.2]}]\n"                         \
    "loads:\n"                                                                                     \
    "  gravity: [1, -2, -3]\n"                                                                     \
    "  buoyancy: 0.2\n"                                                                            \
    "  drag: 0.3\n"                                                                                \
    "  quadratic_drag: 0.2\n"                                                                      \
    "  fluid: {along: [0.1, 0.02, 0.01], across: [0.2, 0.04, 0.1],\n"                              \
    "          added_mass: 0.3 + 0.2*s}\n"                                                         \
    "  magnetic: {moment: [0.1, 0.05, 0.3*s], field: [0.2, -0.3, 0.1*p/200],\n"                    \
    "             gradient: [0.2, -0.3, 0.1, 0.2, -0.1]}\n"                                        \
    "  foundation: [1, 2, 3]\n"                                                                    \
    "  frame: follower\n"                                                                          \
    "  force: [0.3, 0.2*s, 0.1*p/200]\n"                                                           \
    "  moment: [0.02, 0.03, 0.01]\n"                                                               \
    "  tip: {force: [0.2*cos(t), 0.1, 0.3], moment: [0.1, 0, 0.05], frame: follower}\n"            \
    "time: {duration: " duration "}\n"

#endif
