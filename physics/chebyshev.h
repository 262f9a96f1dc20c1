/* Fields of s as polynomials through their values at Chebyshev's points, the ends of the rod among
 * them: what one window of time hands on to the next. */
#ifndef PHYSICS_CHEBYSHEV_H
#define PHYSICS_CHEBYSHEV_H

#include "physics/rod.h"

/* fields [rows], one row each and at most ROD_WINDOW_ROWS: polynomials of s in [0, 1] of a `degree`
 * that divides ROD_WINDOW_DEGREE, through values [ROD_WINDOW_DEGREE + 1][rows]. A field that is 0
 * at every point is the constant 0. */
void chebyshev_fields(ad_value s, const double *values, int rows, int degree, ad_value *fields);

/* Largest error at those points of such polynomials, of rows `first` to first + count - 1. */
double chebyshev_misfit(const double *values, int rows, int first, int count, int degree);

/* The other way: values of fields [rows], one row each, of the input s, the first of the tape; of
 * parameters, and of no other input. */
ad_status chebyshev_sample(int rows, const ad_value *fields, const double *parameters,
                           ad_pool *pool, double *values, ad_error *error);

#endif
