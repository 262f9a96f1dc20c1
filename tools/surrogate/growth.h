/* Whether small deviations of a robot at rest, or of a map of one step, die out. */
#ifndef SURROGATE_GROWTH_H
#define SURROGATE_GROWTH_H

#include "physics/chain/reduced.h"

/* Spectral radius of a map [n][n], by squares of it that are scaled; room [2][n][n]. Not finite
 * where the map is not. ad_dense_load has been called. */
double surrogate_growth(ad_pool *pool, size_t n, const double *map, double *room);

/* By how much the largest of small deviations from where the robot rests with its inputs in the
 * middle grows within a step (s); infinite: no rest is found from its start. Up to SURROGATE_STABLE
 * they die out or stay. */
#define SURROGATE_STABLE (1 + 1e-6)
ad_status surrogate_rest_growth(ad_pool *pool, reduced_rod *rod, double step, double *result,
                                ad_error *error);

/* What makes a robot stable, for messages. */
extern const char surrogate_steadier[];

#endif
