/* The optimiser at work on a stage of training, whichever the stage names, behind one interface.
 * What differs from one to the next is one row of a table in optimizer.c. */
#ifndef TOOLS_TRAIN_OPTIMIZER_H
#define TOOLS_TRAIN_OPTIMIZER_H

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

typedef struct optimizer_info {
    double loss; /* at the current point; Adam's: before its last update */
    double
        gradient_norm; /* at the current point; Adam's and Gauss-Newton's: before the last step */
    double rate; /* Adam: the learning rate; L-BFGS, SSBroyden: the step length of the last line
                  * search; Gauss-Newton: the damping */
} optimizer_info;

/* Is the optimiser of every stage made for so many parameters? AD_BAD_INPUT names the first stage
 * for which it is not. */
ad_status optimizer_check(const train_settings *settings, problem *p, ad_error *error);

/* The optimiser of training.stages[stage] at x[parameters of p], which is copied. */
ad_status optimizer_create(const train_settings *settings, int stage, problem *p, ad_pool *pool,
                           const double *x, optimizer **result, ad_error *error);
void optimizer_free(optimizer *o); /* NULL is fine */

optim_status optimizer_step(optimizer *o, const optimizer_objective *objective);
void optimizer_objective_changed(optimizer *o);

const double *optimizer_x(const optimizer *o); /* [count], the current point */

/* [count], the best point that a step has started from or ended at; it means something while the
 * objective's values compare. */
const double *optimizer_best_x(const optimizer *o);
optimizer_info optimizer_inspect(const optimizer *o);

/* How its steps are computed, in a few words; empty when there is nothing to tell. */
void optimizer_describe(const optimizer *o, char text[160]);

/* What went other than smoothly so far, in a few words; empty when nothing did. */
void optimizer_account(const optimizer *o, char text[160]);

/* What to try when a number is not finite, for one who resumes the run. */
void optimizer_advise(const optimizer *o, char advice[160]);

/* As optim_adam_state, with room for OPTIM_STATE_CAPACITY, and optim_adam_state_check. */
int optimizer_state(optimizer *o, optim_array *arrays);
const char *optimizer_state_check(const optimizer *o);

#endif
