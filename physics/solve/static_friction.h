/* Friction of tendons against their guides. By Coulomb's law the tension T of a tendon changes
 * along its path p by no more than
 *
 *   |T'| <= mu |t'| T,   t = p'/|p'|,
 *
 * t in the world, and by just that where it slides (Euler and Eytelwein). A tendon that is pulled
 * from no tension on slides towards its beginning all along, and has T(0) exp(-mu phi) with the
 * angle phi that the path has turned up to there, the kinks among it that it has where strains
 * jump. Afterwards it keeps its tension where that is within the law, and slides, from its
 * beginning on, where it is not:
 *
 *   log T(s) = max(log T(s-) - mu dphi, min(log T(s-) + mu dphi, log T_before(s))),
 *
 * at constant angles a play of log T(0) of the threshold mu phi(s). So it holds what sheaths with
 * tendons are known for, a tension at the end that follows after a dead band alone (Kaneko,
 * Yamashita, Tanie, ICAR 1991; Agrawal, Peine, Yao, IEEE Trans. Robotics 26 (2010) 1051). That what
 * sticks keeps its tension is exact where nothing but the tendon bends the rod there, and otherwise
 * the law of a tendon that is soft beside the rod. Forces between tendon and guide are within the
 * section, so that all else is as it is without friction. */
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

/* What tendons had before is what they have in `earlier`, an equilibrium of the same robot, which
 * must outlive the system. AD_BAD_ARGUMENT: of another one; AD_NO_MEMORY. */
ad_status static_friction_follow(static_system *system, const static_system *earlier,
                                 ad_error *error);

/* The tension of a tendon, an actuator, at s; by EI/L^2. */
double static_friction_tension(const static_system *system, int tendon, double s);

/* A handler of KINSOL's errors: what it returns says all of them. */
void static_kinsol_say_nothing(int code, const char *module, const char *function, char *text,
                               void *context);

#endif
