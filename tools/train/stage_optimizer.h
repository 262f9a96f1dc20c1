/* The optimiser of a stage of training: one of optim/optimizer.h with the settings of the stage,
 * and for Gauss-Newton the linear model of the problem. */
#ifndef TOOLS_TRAIN_STAGE_OPTIMIZER_H
#define TOOLS_TRAIN_STAGE_OPTIMIZER_H

#include "autodiff/ad.h"
#include "tools/train/linear_model.h"

typedef struct optimizer optimizer;

/* What is minimised; an optimiser calls the one that it needs. */
typedef struct optimizer_objective {
    optim_objective value;
    /* linear_model_linearize, of a sum of squares with the same value */
    int (*linearize)(void *context, linear_model *model, const double *x, double *value,
                     double *jtr, double *diagonal);
    void *context;
} optimizer_objective;

/* Is the optimiser of every stage made for so many parameters? AD_BAD_INPUT names the first stage
 * for which it is not. */
ad_status optimizer_check(const train_settings *settings, problem *p, ad_error *error);

/* The optimiser of training.stages[stage] at x[parameters of p], which is copied. */
ad_status optimizer_create(const train_settings *settings, int stage, problem *p, ad_pool *pool,
                           const double *x, optimizer **result, ad_error *error);
void optimizer_free(optimizer *o); /* NULL is fine */

optim_status optimizer_step(optimizer *o, const optimizer_objective *objective);

/* What optim/optimizer.h tells of it: points, info, state. Owned by the optimiser. */
optim_optimizer *optimizer_method(const optimizer *o);

/* How its steps are computed, in a few words; empty when there is nothing to tell. */
void optimizer_describe(const optimizer *o, char text[160]);

/* What went other than smoothly so far, in a few words; empty when nothing did. */
void optimizer_account(const optimizer *o, char text[160]);

/* What to try when a number is not finite, for one who resumes the run. */
void optimizer_advise(const optimizer *o, char advice[160]);

#endif
