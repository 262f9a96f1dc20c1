/* What a collocated solution leaves undone between its points: the equations y_s = f(s, y) in
 * integral form, on the panels of what is given (quadrature.h) and on points that are denser than
 * those of the solution. A linear solve turns this defect into an error.
 *
 * Defect correction: Stetter, Numer. Math. 29 (1978); Ascher, Mattheij, Russell, Numerical Solution
 * of Boundary Value Problems for ODEs (1995), section 5.5. */
#ifndef PHYSICS_SOLVE_DEFECT_H
#define PHYSICS_SOLVE_DEFECT_H

#include "physics/local/quadrature.h"
#include "physics/solve/elements.h"

/* rate [n][rows] = f(s [n], y [n][rows]) */
typedef struct solve_equations {
    ad_status (*rate)(const void *context, size_t n, const double *s, const double *y, double *rate,
                      ad_error *error);
    const void *context;
} solve_equations;

/* Of an element with y as values [stages + 2][rows] at its beginning, its points and its end:
 * residual [stages + 1][rows], at its points and its end y less that at its beginning less the
 * integral of f from there by the quadrature. AD_NO_MEMORY, errors of f. */
ad_status solve_defect(const solve_quadrature *quadrature, const solve_equations *equations,
                       const solve_elements *mesh, int element, const double *values,
                       double *residual, ad_error *error);

#endif
