/* Cubic splines along samples: twice continuously differentiable. */
#ifndef PHYSICS_NUMERICS_SPLINE_H
#define PHYSICS_NUMERICS_SPLINE_H

#include <stddef.h>

/* slope [count] at each of the samples y [count] at t [count], ascending, of the spline through
 * them whose first two pieces are one cubic, and the last two ("not a knot": de Boor, A Practical
 * Guide to Splines, 1978, ch. 4). Two samples have a line, three a parabola. Between samples it is
 * Hermite's cubic. room [count]. */
void spline_slopes(size_t count, const double *t, const double *y, double *slope, double *room);

/* By how much independent errors put samples off a smooth function, their standard deviation: of
 * each five samples the combination that no cubic changes. Of samples of a function that is smooth
 * it is of the fourth order of their distance. 0 of fewer than five. */
double spline_noise(size_t count, const double *t, const double *y);

/* The smoothest samples [count], of the least integral of the square of the second derivative,
 * whose root of the mean square distance from y is `noise` (Reinsch, Numer. Math. 10, 1967); y
 * itself of noise 0 or fewer than five samples. room [6 count]. */
void spline_smooth(size_t count, const double *t, const double *y, double noise, double *smooth,
                   double *room);

/* Between two samples that are h apart, at a part of the way: y by Hermite's cubic, and its first
 * two derivatives. */
static inline void spline_between(const double y[2], const double slope[2], double h, double part,
                                  double out[3])
{
    const double chord = h > 0 ? (y[1] - y[0]) / h : 0;
    const double second = 3 * chord - 2 * slope[0] - slope[1];
    const double third = slope[0] + slope[1] - 2 * chord;
    out[0] = y[0] + part * h * (slope[0] + part * (second + part * third));
    out[1] = slope[0] + part * (2 * second + 3 * part * third);
    out[2] = h > 0 ? (2 * second + 6 * part * third) / h : 0;
}

#endif
