/* The motion of a beam: at every instant at rest under its loads less inertia and drag, by the
 * linear system of beam_system.h; steps of time by Radau IIA (gauss.h), whose stages are solved
 * together, equal between instants where something jumps. */
#ifndef PHYSICS_SOLVE_BEAM_MOTION_H
#define PHYSICS_SOLVE_BEAM_MOTION_H

#include "physics/solve/beam_system.h"

enum { BEAM_MOTION_NODES_MAX = 128 };

/* Added to the foundation of the system, and to the loads in turn, lest a beam that is free to move
 * make it singular. */
static const double BEAM_MOTION_STIFFENING = 1;

/* *steps equal steps from the initial state to the end of the duration, or more where something
 * jumps in between: receives how many. At times [count], ascending: fields
 * [count][2][places][BEAM_ROWS], y and y_t. `system` has the beam's stiffening. AD_NO_MEMORY,
 * AD_NOT_FINITE, and what the tape says of formulas. */
ad_status beam_motion_solve(const solve_beam *beam, beam_system *system, long *steps, size_t count,
                            const double *times, double *fields, ad_error *error);

#endif
