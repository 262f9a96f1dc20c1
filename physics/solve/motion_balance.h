/* Whether a motion that is known, such as that of a network, is one of bodies: energy and momentum
 * of the rod against power and forces of all that acts on it.
 *
 * Position, rotation and their rates are sampled at the nodes of motion.h, and energy, power and
 * forces are those of its equations. So neither the points of a network nor its equations have any
 * part in it. What is at rest has loads that add up to nothing instead: solve_balance (solve.h). */
#ifndef PHYSICS_SOLVE_MOTION_BALANCE_H
#define PHYSICS_SOLVE_MOTION_BALANCE_H

#include "physics/solve/solve.h"

/* The largest that is missing at any time since the first; infinite where the motion is not a
 * number; NaN: not known. */
typedef struct motion_balance {
    double energy; /* kinetic + strain + dissipated - work, as in solve_energy, over the largest */
    double momentum; /* less the impulses of loads, springs and of what holds ends, over what a rod
                      * with that largest energy, all of it kinetic, could have */
} motion_balance;

/* Of the rod of a scene in motion that passes scene_check and the check of its model, from the
 * first of times [count], s, ascending, to the last: the motion is smooth between two of them.
 * What a rest shape that jumps at one of them does counts as work. Not known (NaN) without rotary
 * inertia, with a Maxwell branch, whose memory no motion tells, and where ends that move hold a rod
 * with locked strains. AD_NO_MEMORY, errors of formulas and of the motion. */
ad_status motion_balance_of(const scene *rod_scene, int count, const double *times,
                            solve_known_motion *motion, void *context, motion_balance *result,
                            ad_error *error);

#endif
