/* Newton's method with line search on a static system: KINSOL (Hindmarsh et al., ACM TOMS 31, 2005)
 * with the system's own linear algebra. */
#ifndef TOOLS_SOLVE_NEWTON_H
#define TOOLS_SOLVE_NEWTON_H

#include "tools/solve/static_system.h"

typedef struct newton newton;

/* The system must outlive it. */
ad_status newton_create(static_system *system, newton **result, ad_error *error);
void newton_free(newton *x);

/* y [unknowns]: the guess, then the solution, to rounding. false: not converged, and y is what was
 * reached. Adds to *steps. */
bool newton_solve(newton *x, double *y, long *steps);

#endif
