/* Legendre-Gauss-Lobatto points on [-1, 1]: quadrature, differentiation, interpolation.
 *
 * Sources: Canuto, Hussaini, Quarteroni, Zang, Spectral Methods (2006), section 2.3; barycentric
 * weights (-1)^j sqrt(w_j): Wang, Huybrechs, Vandewalle, Math. Comp. 83 (2014). */
#ifndef PHYSICS_LOCAL_LOBATTO_H
#define PHYSICS_LOCAL_LOBATTO_H

#include <stddef.h>

enum { LOBATTO_DEGREE_MAX = 64 };

/* Points x [degree + 1], ascending, -1 and 1 among them; weights [degree + 1] of the quadrature
 * that is exact to degree 2 degree - 1. 1 <= degree <= LOBATTO_DEGREE_MAX. */
void solve_lobatto_points(int degree, double *x, double *weights);

/* derivative [i][j] of the j-th Lagrange polynomial at x_i, row-major. */
void solve_lobatto_derivative(int degree, const double *x, double *derivative);

/* Values [degree + 1] of the Lagrange polynomials at a point of [-1, 1]. */
void solve_lobatto_interpolation(int degree, const double *x, const double *weights, double at,
                                 double *values);

#endif
