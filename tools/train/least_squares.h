/* Levenberg-Marquardt for fits of some hundred unknowns that sum J^T J and J^T r themselves: of a
 * law, of a residual, of unknowns to measurements. Descents from one start after another are the
 * windows of a fit. */
#ifndef TOOLS_TRAIN_LEAST_SQUARES_H
#define TOOLS_TRAIN_LEAST_SQUARES_H

#include "autodiff/dense.h"
#include "autodiff/memory.h"
#include "tools/train/fit.h"

typedef struct least_squares least_squares;
struct least_squares {
    size_t count;
    optim_scaling scaling;
    /* |r(x)|^2; where `to` is not NULL, adds J^T J, both triangles, and J^T r to its own, which are
     * 0. Returns what an optim_objective does. */
    int (*sum)(void *context, const double *x, double *value, least_squares *to);
    /* x[count] where the descent fit.at.window begins. */
    ad_status (*begin)(void *context, double *x, ad_error *error);
    /* After a step that ended with this status, before it counts: looks at optim_x(by), and may set
     * fit.held_out, fit.error and fit.reason. Of a step that is the last `again` has the descent
     * begin once more, where begin says, which sees it. */
    ad_status (*judge)(void *context, optim_status status, ad_error *error);
    /* fit_kind; NULL: all descents are made. */
    ad_status (*turn)(void *context, ad_error *error);
    /* What a checkpoint keeps beside the optimiser, at most OPTIM_STATE_CAPACITY. */
    int (*state)(void *context, optim_array *arrays);
    void *context;
    const char *name;
    uint64_t digest;            /* of the data: what goes on from a checkpoint has the same */
    int every, descents, steps; /* steps between rows of history, and of a descent at most */

    double *jtj, *jtr; /* [count][count], [count], where they were last asked for */
    ad_pool *pool;     /* of one thread */
    ad_dense_factor *factor;
    optim_optimizer *by; /* of the descent at work */
    bool again;
    double *start; /* [count] */
    train_settings *settings;
    fit fit;
    ad_memory memory;
};

/* Allocates; the caller has filled in what comes before jtj, the rest is 0. Either way clear frees
 * what there is. */
ad_status least_squares_create(least_squares *ls, ad_error *error);
void least_squares_clear(least_squares *ls);

/* Who makes the steps, from fit_start or fit_restore on, and may leave it before it is over:
 * what was to be found is then not touched. */
typedef struct least_squares_runner {
    ad_status (*run)(void *context, least_squares *ls, ad_error *error);
    void *context;
} least_squares_runner;

/* All descents to their ends, or by a runner if it is not NULL. */
ad_status least_squares_run(least_squares *ls, const least_squares_runner *runner, ad_error *error);

/* step[count] with the last J, a linear model's `solve`. */
int least_squares_solve(void *ls, double damping, const double *scale, double *step);

/* inverse[count][count] of jtj. AD_NOT_FINITE: it is not positive definite. */
ad_status least_squares_inverse(least_squares *ls, double *inverse, ad_error *error);

#endif
