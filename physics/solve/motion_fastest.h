/* The fastest vibration of a mesh, which limits explicit steps of time. */
#ifndef PHYSICS_SOLVE_MOTION_FASTEST_H
#define PHYSICS_SOLVE_MOTION_FASTEST_H

#include "physics/solve/motion.h"

/* Power iteration with d rate/d state. */
typedef struct fastest fastest;

/* Borrows m. AD_NO_MEMORY. */
ad_status motion_fastest_create(motion *m, fastest **result, ad_error *error);
void motion_fastest_free(fastest *f);

/* rad per unit of time, at a state [motion_size] and the time that the motion is at; some
 * per cent below the true one. It begins where the last call ended, so that a few rounds do where
 * the state has changed little. */
double motion_fastest_at(fastest *f, const double *state, int rounds);

/* At the initial state and t = 0. */
ad_status motion_fastest_at_start(fastest *f, double *frequency, ad_error *error);

#endif
