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

#include "optim/optim.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One row per method: code, name. */
#define OPTIM_METHOD_LIST(X)                                                                       \
    X(OPTIM_ADAM, "adam")                                                                          \
    X(OPTIM_LBFGS, "lbfgs")                                                                        \
    X(OPTIM_GAUSS_NEWTON, "gauss_newton")                                                          \
    X(OPTIM_SSBROYDEN, "ssbroyden")                                                                \
    X(OPTIM_SOAP, "soap")

typedef enum optim_method {
#define OPTIM_METHOD_ENUM(code, name) code,
    OPTIM_METHOD_LIST(OPTIM_METHOD_ENUM)
#undef OPTIM_METHOD_ENUM
        OPTIM_METHOD_COUNT
} optim_method;

/* Name of a method, never NULL; method of a name, or OPTIM_METHOD_COUNT when there is none. */
const char *optim_method_name(optim_method method);
optim_method optim_method_of(const char *name);

/* The method, and the settings of that one; the others are not read. */
typedef struct optim_settings {
    optim_method method;
    optim_adam_settings adam;
    optim_lbfgs_settings lbfgs;
    optim_gauss_newton_settings gauss_newton;
    optim_descent_settings ssbroyden;
    optim_soap_settings soap;
} optim_settings;

optim_settings optim_settings_defaults(optim_method method);
const char *optim_settings_check(const optim_settings *settings);

/* What is minimised: Gauss-Newton asks the model, every other method the objective. */
typedef struct optim_target {
    optim_objective objective;
    void *context; /* of the objective */
    const optim_linear_model *model;
} optim_target;

typedef struct optim_info {
    double value;         /* at the current point; Adam's: before its last update */
    double gradient_norm; /* the same; Gauss-Newton's: before its last step. NaN: not yet known */
    double rate;   /* Adam, SOAP: the learning rate; L-BFGS, SSBroyden: the length of the last line
                    * search; Gauss-Newton: the damping */
    int64_t steps; /* completed */
    int64_t evaluations; /* of the value, with or without derivatives */
    int64_t refused;     /* trial steps of Gauss-Newton that were not taken, ... */
    int64_t unsolved;    /* ... of these where the model found no step */
} optim_info;

typedef struct optim_optimizer optim_optimizer;

/* As optim_adam_create. */
optim_optimizer *optim_create(size_t count, const double *x, const optim_settings *settings,
                              const char **why);
void optim_free(optim_optimizer *o); /* NULL is fine */

/* One step, as optim_adam_step and the others say it. */
optim_status optim_step(optim_optimizer *o, const optim_target *target);

/* Has to be called between steps when the objective has become another function. */
void optim_objective_changed(optim_optimizer *o);

const double *optim_x(const optim_optimizer *o); /* [count], the current point */

/* [count], the best point that a step has started from or ended at; it means something while the
 * objective's values compare. */
const double *optim_best_x(const optim_optimizer *o);
optim_info optim_inspect(const optim_optimizer *o);

/* What to try, in a few words, when a number is not finite. */
const char *optim_advice(optim_method method);

/* Bytes for `count` parameters, and the most parameters that the method is made for. */
double optim_bytes(const optim_settings *settings, size_t count);
size_t optim_count_max(optim_method method);

/* As optim_adam_state, with room for OPTIM_STATE_CAPACITY rows, and optim_adam_state_check. */
int optim_state(optim_optimizer *o, optim_array *arrays);
const char *optim_state_check(const optim_optimizer *o);

#ifdef __cplusplus
}
#endif

#endif
