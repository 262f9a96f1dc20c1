/* Friction of tendons against their guides while they are pulled, so that all of a tendon slides
 * towards its beginning: by Coulomb's law its tension T falls along its path p as
 *
 *   T' = -mu |t'| T,   t = p'/|p'|,
 *
 * t in the world, to T(0) exp(-mu phi) with the angle phi that the path has turned up to there, the
 * kinks among it that it has where strains jump (Euler and Eytelwein). Forces between tendon and
 * guide are within the section, so that all else is as it is without friction. */
#ifndef PHYSICS_SOLVE_STATIC_FRICTION_H
#define PHYSICS_SOLVE_STATIC_FRICTION_H

#include "physics/solve/static_system.h"

#include <sundials/sundials_context.h>

typedef struct static_friction static_friction;

/* Of a rod with frictions; the system must outlive it. NULL: out of memory. */
static_friction *static_friction_create(static_system *system, SUNContext sundials);
void static_friction_free(static_friction *friction);

/* How equilibria of given angles are found. */
typedef bool static_friction_given(void *context, double *y, long *steps);

/* y: the guess, then the equilibrium of which the angles of the system are, to rounding. By fixed
 * points with Anderson's acceleration (KINSOL). false: not converged, and the angles are as before.
 */
bool static_friction_solve(static_friction *friction, static_friction_given *solve, void *context,
                           double *y, long *steps);

/* The angles of a coarse system as those of one whose elements are parts of its elements. */
void static_friction_refine(static_system *coarse, static_system *fine);

/* A handler of KINSOL's errors: what it returns says all of them. */
void static_kinsol_say_nothing(int code, const char *module, const char *function, char *text,
                               void *context);

#endif
