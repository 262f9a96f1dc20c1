/* The error of a collocated rod at rest by what it leaves undone between its points: the equations
 * in integral form, on the panels of what is given (quadrature.h) and on points that are denser
 * than those of the solution, and one linear solve that turns this defect into an error.
 *
 * Defect correction: Stetter, Numer. Math. 29 (1978); Ascher, Mattheij, Russell, Numerical Solution
 * of Boundary Value Problems for ODEs (1995), section 5.5. */
#ifndef PHYSICS_SOLVE_STATIC_DEFECT_H
#define PHYSICS_SOLVE_STATIC_DEFECT_H

#include "physics/solve/static_system.h"

/* error_of_y: largest of the position, in lengths, and of the turn about the tangent, rad, at the
 * points of a system that is solved by y and factored there or near it. Infinite where it is not
 * finite. AD_NO_MEMORY, errors of what is given. */
ad_status static_defect(static_system *x, const solve_quadrature *quadrature, const double *y,
                        double *error_of_y, ad_error *error);

#endif
