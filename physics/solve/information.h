/* What measurements say of unknown numbers: standard deviations, correlations, and the combinations
 * of which they say nothing.
 *
 * Unknowns are counted in parts of their ranges (scene_parameter_fraction), from 0 to 1. With the
 * measurements' residuals over their standard deviations, J their derivatives by the unknowns, the
 * information is J^T J, and its inverse the covariance of the estimate (Gauss-Newton, Bard,
 * Nonlinear Parameter Estimation, 1974, ch. 7). */
#ifndef PHYSICS_SOLVE_INFORMATION_H
#define PHYSICS_SOLVE_INFORMATION_H

#include "physics/scene/scene.h"

/* A number that is only known to lie in its range, uniformly, has this standard deviation, as part
 * of the range: what measurements leave more uncertain than that they do not tell. */
static const double SOLVE_UNTOLD = 0.28867513459481287; /* 12^(-1/2) */

/* Unknowns are usually called poorly identifiable above a collinearity index of 10 to 15 (Brun,
 * Reichert & Kuensch, Water Resour. Res. 37 (2001) 1015). */
static const double SOLVE_COLLINEAR = 15;

typedef struct solve_information {
    int count;
    double deviation[SCENE_PARAMETERS_MAX]; /* standard, in parts of the range; NaN: held */
    double correlation[SCENE_PARAMETERS_MAX][SCENE_PARAMETERS_MAX]; /* NaN of those held */
    int untold; /* directions along which the standard deviation is above SOLVE_UNTOLD */
    double direction[SCENE_PARAMETERS_MAX][SCENE_PARAMETERS_MAX]; /* [untold][count], unit, the
                                                                   * least known first */
    /* 1 over the root of the least eigenvalue of J^T J with columns of J of length 1, and its
     * direction [count], unit: by so much is it less known than its unknowns are one by one */
    double collinearity, valley[SCENE_PARAMETERS_MAX];
} solve_information;

/* From J^T J [count][count], both triangles; held [count] are taken as known. */
solve_information solve_information_of(int count, const double *matrix, const bool *held);

/* A direction for people, at values [count] of the parameters [count] in SI: "stiffness +10 %, load
 * +10 %", the change of each by so much of the direction that no value changes by more than a
 * tenth, or of one that is 0 by a tenth of its range; without those that hardly change. */
void solve_information_text(const scene_parameter *const *parameters, int count,
                            const double *values, const double *direction, char *text, size_t size);

#endif
