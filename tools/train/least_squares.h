/* Levenberg-Marquardt for fits of some hundred unknowns that sum J^T J and J^T r themselves: of a
 * law, of a residual, of unknowns to measurements. */
#ifndef TOOLS_TRAIN_LEAST_SQUARES_H
#define TOOLS_TRAIN_LEAST_SQUARES_H

#include "autodiff/dense.h"
#include "optim/optimizer.h"

typedef struct least_squares least_squares;
struct least_squares {
    size_t count;
    optim_scaling scaling;
    /* |r(x)|^2; where `to` is not NULL, adds J^T J, both triangles, and J^T r to its own, which are
     * 0. Returns what an optim_objective does. */
    int (*sum)(void *context, const double *x, double *value, least_squares *to);
    void *context;
    double *jtj, *jtr; /* [count][count], [count], where they were last asked for */
    ad_pool *pool;     /* of one thread */
    ad_dense_factor *factor;
    optim_optimizer *by; /* of least_squares_begin: point and value */
};

/* Allocates; the caller has filled in what comes before jtj, the rest is 0. Either way clear frees
 * what there is. */
ad_status least_squares_create(least_squares *ls, ad_error *error);
void least_squares_clear(least_squares *ls);

/* Sets off from x[count]; and a step, without a tolerance of the gradient. */
ad_status least_squares_begin(least_squares *ls, const double *x, ad_error *error);
optim_status least_squares_next(least_squares *ls);

/* step[count] with the last J, a linear model's `solve`. */
int least_squares_solve(void *ls, double damping, const double *scale, double *step);

#endif
