/* Configurations whose tip is at a given place, and points somewhere, by the solver: from random
 * ones, steps of Levenberg and Marquardt with the derivative of the shape, within the ranges. */
#ifndef PLAN_REACH_H
#define PLAN_REACH_H

#include "tools/plan/plan_robot.h"

typedef struct reach_goal {
    double tip[3], tolerance;   /* within so much, m */
    double direction[3], angle; /* of length 1; rad; NaN: any */
} reach_goal;

typedef struct reach {
    size_t count;
    double configuration[PLAN_BATCH * PLAN_VARIABLES_MAX]; /* [count][variables], by distance from
                                                            * `from`, in parts of the ranges */
    double nearest, angle; /* m, rad, of the tip that came nearest to both; no direction: 0 */
} reach;

/* Errors of the solver. */
ad_status reach_tip(plan_exact *shapes, const reach_goal *goal, const double *from, uint64_t seed,
                    reach *result, ad_error *error);

#endif
