#include "tools/train/optimizer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct kind kind;

struct optimizer {
    const kind *kind;
    int stage; /* as training.stages[] counts them */
    size_t count;
    problem *problem;
    ad_pool *pool;
    linear_model *model;                  /* Gauss-Newton's */
    void *own;                            /* optim_adam, optim_lbfgs, ... */
    double gradient_norm;                 /* Gauss-Newton's: where its matrix was made */
    const optimizer_objective *objective; /* of the step at hand */
};

/* One row per optimiser. */
struct kind {
    ad_status (*create)(optimizer *o, const train_stage *stage, const double *x, const char **why,
                        ad_error *error);
    void (*free)(void *own);
    optim_status (*step)(optimizer *o, const optimizer_objective *objective);
    void (*objective_changed)(void *own);
    const double *(*x)(const void *own);
    const double *(*best_x)(const void *own);
    optimizer_info (*inspect)(const optimizer *o);
    int (*state)(void *own, optim_array *arrays, int capacity);
    const char *(*state_check)(const void *own);
    size_t count_max;  /* of parameters; 0: any number */
    const char *keeps; /* why there is a limit */
    double bytes;      /* of memory, in multiples of parameters^2 */
    const char *advice;
};

/* The functions of optim/ that all have, seen through void *. */
#define ADAPT(name)                                                                                \
    static void name##_free(void *own)                                                             \
    {                                                                                              \
        optim_##name##_free(own);                                                                  \
    }                                                                                              \
    static void name##_objective_changed(void *own)                                                \
    {                                                                                              \
        optim_##name##_objective_changed(own);                                                     \
    }                                                                                              \
    static const double *name##_x(const void *own)                                                 \
    {                                                                                              \
        return optim_##name##_x(own);                                                              \
    }                                                                                              \
    static int name##_state(void *own, optim_array *arrays, int capacity)                          \
    {                                                                                              \
        return optim_##name##_state(own, arrays, capacity);                                        \
    }                                                                                              \
    static const char *name##_state_check(const void *own)                                         \
    {                                                                                              \
        return optim_##name##_state_check(own);                                                    \
    }

ADAPT(adam)
ADAPT(lbfgs)
ADAPT(gauss_newton)
ADAPT(ssbroyden)

#define ADAPTED(name)                                                                              \
    .create = name##_create, .free = name##_free, .step = name##_step, .x = name##_x,              \
    .objective_changed = name##_objective_changed, .inspect = name##_inspect,                      \
    .state = name##_state, .state_check = name##_state_check

/* ---- Adam ---------------------------------------------------------------------------------- */

static ad_status adam_create(optimizer *o, const train_stage *stage, const double *x,
                             const char **why, ad_error *error)
{
    (void)error;
    o->own = optim_adam_create(o->count, x, &stage->adam, why);
    return AD_OK;
}

static optim_status adam_step(optimizer *o, const optimizer_objective *objective)
{
    return optim_adam_step(o->own, objective->value, objective->context);
}

/* Its steps may climb. */
static const double *adam_best_x(const void *own)
{
    return isfinite(optim_adam_get_info(own).best_value) ? optim_adam_best_x(own)
                                                         : optim_adam_x(own);
}

static optimizer_info adam_inspect(const optimizer *o)
{
    const optim_adam_info info = optim_adam_get_info(o->own);
    return (optimizer_info){info.value, info.gradient_norm, info.learning_rate};
}

/* ---- L-BFGS -------------------------------------------------------------------------------- */

static ad_status lbfgs_create(optimizer *o, const train_stage *stage, const double *x,
                              const char **why, ad_error *error)
{
    (void)error;
    o->own = optim_lbfgs_create(o->count, x, &stage->lbfgs, why);
    return AD_OK;
}

static optim_status lbfgs_step(optimizer *o, const optimizer_objective *objective)
{
    return optim_lbfgs_step(o->own, objective->value, objective->context);
}

static optimizer_info lbfgs_inspect(const optimizer *o)
{
    const optim_descent_info info = optim_lbfgs_get_info(o->own);
    return (optimizer_info){info.value, info.gradient_norm, info.step};
}

/* ---- Gauss-Newton -------------------------------------------------------------------------- */

static ad_status gauss_newton_create(optimizer *o, const train_stage *stage, const double *x,
                                     const char **why, ad_error *error)
{
    optim_gauss_newton_settings settings = stage->gauss_newton;
    settings.gradient_tolerance = stage->lbfgs.descent.gradient_tolerance;
    settings.function_tolerance = stage->lbfgs.descent.function_tolerance;
    settings.step_tolerance = stage->lbfgs.descent.step_tolerance;
    linear_model_info plan;
    ad_status status = linear_model_plan(o->problem, stage, o->stage, &plan, error);
    if (status == AD_OK) {
        status = linear_model_create(o->problem, &plan, o->pool, &o->model, error);
    }
    if (status == AD_OK) {
        o->own = optim_gauss_newton_create(o->count, x, &settings, why);
    }
    return status;
}

static double norm(const double *x, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += x[i] * x[i];
    }
    return sqrt(sum);
}

static int evaluate(void *context, const double *x, double *value)
{
    const optimizer *o = context;
    return o->objective->value(o->objective->context, x, value, NULL);
}

/* With a note of the gradient of |r|^2, 2 J^T r. */
static int linearize(void *context, const double *x, double *value, double *jtr, double *diagonal)
{
    optimizer *o = context;
    const int code =
        o->objective->linearize(o->objective->context, o->model, x, value, jtr, diagonal);
    if (code == OPTIM_OBJECTIVE_OK) {
        o->gradient_norm = 2 * norm(jtr, o->count);
    }
    return code;
}

static int solve(void *context, double damping, const double *scale, double *step)
{
    const optimizer *o = context;
    return linear_model_solve(o->model, damping, scale, step);
}

static int refresh(void *context, const double *x, double *value, double *jtr)
{
    optimizer *o = context;
    const int code = o->objective->value(o->objective->context, x, value, jtr);
    for (size_t i = 0; code == OPTIM_OBJECTIVE_OK && i < o->count; i++) {
        jtr[i] /= 2;
    }
    linear_model_refresh(o->model, jtr);
    o->gradient_norm = 2 * norm(jtr, o->count);
    return code;
}

static optim_status gauss_newton_step(optimizer *o, const optimizer_objective *objective)
{
    const optim_linear_model model = {o, evaluate, linearize, solve,
                                      linear_model_keeps(o->model) ? refresh : NULL};
    o->objective = objective;
    const optim_status status = optim_gauss_newton_step(o->own, &model);
    o->objective = NULL;
    return status;
}

static optimizer_info gauss_newton_inspect(const optimizer *o)
{
    const optim_gauss_newton_info info = optim_gauss_newton_get_info(o->own);
    return (optimizer_info){info.value, o->gradient_norm, info.damping};
}

/* ---- self-scaled Broyden ------------------------------------------------------------------- */

static ad_status ssbroyden_create(optimizer *o, const train_stage *stage, const double *x,
                                  const char **why, ad_error *error)
{
    (void)error;
    o->own = optim_ssbroyden_create(o->count, x, &stage->lbfgs.descent, why);
    return AD_OK;
}

static optim_status ssbroyden_step(optimizer *o, const optimizer_objective *objective)
{
    return optim_ssbroyden_step(o->own, objective->value, objective->context);
}

static optimizer_info ssbroyden_inspect(const optimizer *o)
{
    const optim_descent_info info = optim_ssbroyden_get_info(o->own);
    return (optimizer_info){info.value, info.gradient_norm, info.step};
}

/* ---- the table ----------------------------------------------------------------------------- */

/* Where best_x is x, the value never rises. */
static const kind kinds[TRAIN_OPTIMIZER_COUNT] = {
    [TRAIN_ADAM] = {ADAPTED(adam), .best_x = adam_best_x,
                    .advice = "--resume with a smaller --set training.stages[%d].learning_rate, "
                              "or with clip_norm or warmup_steps"},
    [TRAIN_LBFGS] = {ADAPTED(lbfgs), .best_x = lbfgs_x,
                     .advice = "more steps of adam before, or a smaller maximum_step"},
    [TRAIN_GAUSS_NEWTON] = {ADAPTED(gauss_newton), .best_x = gauss_newton_x,
                            .advice = "more steps of adam before, or a larger initial_damping"},
    [TRAIN_SSBROYDEN] = {ADAPTED(ssbroyden), .best_x = ssbroyden_x,
                         .count_max = OPTIM_SSBROYDEN_COUNT_MAX,
                         .keeps = "a triangle of parameters^2 / 2 numbers", .bytes = 4,
                         .advice = "more steps of adam before, or a smaller maximum_step"},
};

static ad_status check_stage(const train_stage *stage, int number, problem *p, ad_error *error)
{
    const kind *k = &kinds[stage->optimizer];
    const size_t count = problem_parameters(p);
    if (stage->optimizer == TRAIN_GAUSS_NEWTON) {
        linear_model_info plan;
        return linear_model_plan(p, stage, number, &plan, error);
    }
    if (k->count_max && count > k->count_max) {
        return ad_fail(error, AD_BAD_INPUT,
                       "training.stages[%d].optimizer: %s keeps %s, %.1f GB for the %zu "
                       "parameters of this network; allowed: at most %zu parameters; make "
                       "network.hidden smaller, or take lbfgs",
                       number, train_optimizer_name(stage->optimizer), k->keeps,
                       1e-9 * k->bytes * (double)count * (double)count, count, k->count_max);
    }
    return AD_OK;
}

ad_status optimizer_check(const train_settings *settings, problem *p, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < settings->stage_count; i++) {
        status = check_stage(&settings->stages[i], i, p, error);
    }
    return status;
}

ad_status optimizer_create(const train_settings *settings, int stage, problem *p, ad_pool *pool,
                           const double *x, optimizer **result, ad_error *error)
{
    const train_stage *chosen = &settings->stages[stage];
    const char *why = "out of memory";
    *result = NULL;
    optimizer *o = calloc(1, sizeof *o);
    ad_status status = AD_OK;
    if (o) {
        *o = (optimizer){.kind = &kinds[chosen->optimizer],
                         .stage = stage,
                         .count = problem_parameters(p),
                         .problem = p,
                         .pool = pool,
                         .gradient_norm = NAN};
        status = o->kind->create(o, chosen, x, &why, error);
    }
    if (!o || !o->own) {
        optimizer_free(o);
        return status != AD_OK
                   ? status
                   : ad_fail(error, AD_NO_MEMORY, "training.stages[%d]: %s", stage, why);
    }
    *result = o;
    return AD_OK;
}

void optimizer_free(optimizer *o)
{
    if (o) {
        o->kind->free(o->own);
        linear_model_free(o->model);
        free(o);
    }
}

/* ---- at work ------------------------------------------------------------------------------- */

optim_status optimizer_step(optimizer *o, const optimizer_objective *objective)
{
    return o->kind->step(o, objective);
}

void optimizer_objective_changed(optimizer *o)
{
    o->kind->objective_changed(o->own);
}

const double *optimizer_x(const optimizer *o)
{
    return o->kind->x(o->own);
}

const double *optimizer_best_x(const optimizer *o)
{
    return o->kind->best_x(o->own);
}

optimizer_info optimizer_inspect(const optimizer *o)
{
    return o->kind->inspect(o);
}

void optimizer_describe(const optimizer *o, char text[160])
{
    text[0] = '\0';
    if (o->model) {
        const linear_model_info info = linear_model_inspect(o->model);
        linear_model_describe(&info, text);
    }
}

void optimizer_account(const optimizer *o, char text[160])
{
    text[0] = '\0';
    if (!o->model) {
        return;
    }
    const optim_gauss_newton_info info = optim_gauss_newton_get_info(o->own);
    const linear_model_info model = linear_model_inspect(o->model);
    const int64_t refused = info.rejected + info.not_finite + info.unsolved;
    int n = snprintf(text, 160, "%lld of %lld trial steps refused", (long long)refused,
                     (long long)(refused + info.iterations));
    if (info.unsolved) {
        n += snprintf(text + n, 160 - (size_t)n, ", %lld as the matrix was not positive definite",
                      (long long)info.unsolved);
    }
    if (model.solves) {
        snprintf(text + n, 160 - (size_t)n, ", %.0f products of conjugate gradients each",
                 (double)model.iterations / (double)model.solves);
    }
}

void optimizer_advise(const optimizer *o, char advice[160])
{
    snprintf(advice, 160, o->kind->advice, o->stage);
}

int optimizer_state(optimizer *o, optim_array *arrays)
{
    return o->kind->state(o->own, arrays, OPTIM_STATE_CAPACITY);
}

const char *optimizer_state_check(const optimizer *o)
{
    return o->kind->state_check(o->own);
}
