/* Linear complementarity: numbers that are not negative, each of which is 0 or has a row that is
 * met. */
#ifndef PHYSICS_LOCAL_COMPLEMENT_H
#define PHYSICS_LOCAL_COMPLEMENT_H

#include "physics/scene/scene.h"

enum { COMPLEMENT_MAX = SCENE_TENDONS_MAX + 6 };

/* x [count], at most COMPLEMENT_MAX, with matrix x = right in the rows of the first `open` numbers
 * and of those that are greater than 0, and right - matrix x <= `most` in the others, which are 0:
 * by active sets (Lawson and Hanson 1974, ch. 23). matrix [count][count], row by row. false:
 * singular, or no such numbers are found. ad_dense_load comes before. */
bool solve_complement(int count, int open, const double *matrix, const double *right, double most,
                      double *x);

/* Numbers x [count], at most COMPLEMENT_MAX, that equations depend on linearly, become those with
 * which these are met best, by least squares; all but the first `open` are not negative. columns
 * [count + 1][rows], their numbers `apart` from one another: what each does, and what is missing
 * with the x that is given. */
void solve_complement_fit(int rows, int count, int open, int apart, const double *columns,
                          double *x);

#endif
