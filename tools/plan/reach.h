/* Configurations whose tip is at a given place, by the solver: from random ones, steps of Levenberg
 * and Marquardt with the derivative of the shape, within the ranges. */
#ifndef PLAN_REACH_H
#define PLAN_REACH_H

#include "tools/plan/plan_robot.h"

typedef struct reach {
    size_t count;
    double configuration[PLAN_BATCH * PLAN_VARIABLES_MAX]; /* [count][variables], by distance from
                                                            * `from`, in parts of the ranges */
    double nearest;                                        /* m, of any tip that was tried */
} reach;

/* tip [3]; within tolerance, m. Errors of the solver. */
ad_status reach_tip(plan_exact *shapes, const double tip[3], double tolerance, const double *from,
                    uint64_t seed, reach *result, ad_error *error);

#endif
