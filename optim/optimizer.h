/* Any of the minimisers of optim.h behind one interface, chosen by name.
 *
 *     const char *why;
 *     optim_settings settings = optim_settings_defaults(OPTIM_LBFGS);
 *     optim_optimizer *o = optim_create(count, start, &settings, &why);
 *     const optim_target target = {.objective = objective, .context = context};
 *     while (optim_step(o, &target) == OPTIM_RUNNING) {
 *     }
 *     memcpy(result, optim_best_x(o), count * sizeof *result);
 *     optim_free(o);
 */
#ifndef OPTIM_OPTIMIZER_H
#define OPTIM_OPTIMIZER_H

#include "optim/methods.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What is minimised: Gauss-Newton asks the model, every other method the objective. */
typedef struct optim_target {
    optim_objective objective;
    void *context; /* of the objective */
    const optim_linear_model *model;
} optim_target;

/* What is not said of a method is 0. */
typedef struct optim_info {
    double value; /* at the current point, +infinity before the first evaluation; Adam's, SOAP's:
                   * before their last update, since they evaluate, then move */
    double gradient_norm; /* the same, before clipping; Gauss-Newton's, |2 J^T r|: before its last
                           * step, NaN: not yet known, also after a restore */
    double gradient_max;  /* largest component of that gradient, not of Adam's and SOAP's */
    double best_value;    /* lowest value evaluated, trial points included; +infinity before the
                           * first. Not of Gauss-Newton, whose value never rises */
    double rate;   /* Adam, SOAP: the learning rate; L-BFGS, SSBroyden: the multiple of the search
                    * direction taken last; Gauss-Newton: the damping for the next step, as added to
                    * the diagonal, not in units */
    double step;   /* Gauss-Newton: 2-norm of the last step */
    int64_t steps; /* completed; along lines each ended in a strong Wolfe point */
    int64_t evaluations; /* of the value, with or without derivatives */
    int64_t refused;     /* trial steps of Gauss-Newton that were not taken: the following three */
    int64_t rejected, not_finite, unsolved; /* did not lower the value; led to where it is not
                                             * finite; dampings for which the model found no step */
    int64_t pairs;   /* along lines: pairs (s, y) that the model is made of */
    int64_t skipped; /* pairs dropped by curvature_threshold */
    int64_t resets;  /* models dropped after a failed line search */
} optim_info;

typedef struct optim_optimizer optim_optimizer;

/* Copies x[count] and the settings. Returns NULL when something is wrong and then sets *why (unless
 * why is NULL) to a static text; nothing is left allocated. The optimiser owns a copy of its point.
 * Steps allocate nothing, and all sums run in a fixed order, so equal state and an equal objective
 * give equal bits. */
optim_optimizer *optim_create(size_t count, const double *x, const optim_settings *settings,
                              const char **why);
void optim_free(optim_optimizer *o); /* NULL is fine */

/* One step, as optim.h says of the method. */
optim_status optim_step(optim_optimizer *o, const optim_target *target);

/* Has to be called between steps when the objective has become another function (new loss weights,
 * new points), since values of two functions do not compare. The next step evaluates the current
 * point anew, and the best point is forgotten. */
void optim_objective_changed(optim_optimizer *o);

const double *optim_x(const optim_optimizer *o); /* [count], the current point */

/* [count], the best point that a step has started from or ended at; it means something while the
 * objective's values compare. */
const double *optim_best_x(const optim_optimizer *o);
optim_info optim_inspect(const optim_optimizer *o);

/* Fills at most OPTIM_STATE_CAPACITY rows and returns how many there are. After a restore: NULL, or
 * a static text saying which array holds an impossible number. */
int optim_state(optim_optimizer *o, optim_array *arrays);
const char *optim_state_check(const optim_optimizer *o);

#ifdef __cplusplus
}
#endif

#endif
