/* Newton's method with line search on a static system: KINSOL (Hindmarsh et al., ACM TOMS 31, 2005)
 * with the system's own linear algebra. */
#ifndef PHYSICS_SOLVE_STATIC_NEWTON_H
#define PHYSICS_SOLVE_STATIC_NEWTON_H

#include "physics/solve/static_system.h"

typedef struct static_newton static_newton;

/* The system must outlive it. */
ad_status static_newton_create(static_system *system, static_newton **result, ad_error *error);
void static_newton_free(static_newton *newton);

/* y [unknowns]: the guess, then the solution, to rounding. false: not converged, and y is what was
 * reached. Adds to *steps. */
bool static_newton_solve(static_newton *newton, double *y, long *steps);

/* Of absolute values x [count]; not a number if one is none. */
double static_newton_largest(size_t count, const double *x);

#endif
