#include "tools/train/stage_optimizer.h"

#include "autodiff/dense.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MATRICES = NN_HIDDEN_MAX + 2 };

struct optimizer {
    int stage;    /* as training.stages[] counts them */
    size_t count; /* of parameters */
    optim_method method;
    optim_optimizer *own;
    linear_model *model;      /* Gauss-Newton's */
    double *tried, *gradient; /* [count], of the last trial, where J may be kept: its */
    double value;             /* gradient costs nothing beside its value */
    bool has_tried;
    const optimizer_objective *objective; /* of the step at hand */
    optim_matrix matrices[MATRICES];      /* of the network, for methods that ask */
};

/* ---- from the settings of a stage ---------------------------------------------------------- */

static void multiply(void *context, bool transpose_a, bool transpose_b, size_t m, size_t n,
                     size_t k, const double *a, const double *b, double beta, double *c)
{
    ad_dense_multiply(context, transpose_a, transpose_b, m, n, k, a, b, beta, c);
}

static ad_status check_stage(const train_stage *stage, int number, problem *p, ad_error *error)
{
    const size_t count = problem_parameters(p), most = optim_count_max(stage->optim.method);
    if (optim_method_needs(stage->optim.method) == OPTIM_NEEDS_SQUARES) {
        linear_model_info plan;
        return linear_model_plan(p, stage, number, &plan, error);
    }
    if (count > most) {
        return ad_fail(error, AD_BAD_INPUT,
                       "training.stages[%d].optimizer: %s keeps a triangle of parameters^2 / 2 "
                       "numbers, %.1f GB for the %zu parameters of this network; allowed: at most "
                       "%zu parameters; make network.hidden smaller, or take lbfgs",
                       number, optim_method_name(stage->optim.method),
                       1e-9 * optim_bytes(&stage->optim, count), count, most);
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

static ad_status list_matrices(optimizer *o, optim_settings *settings, const problem *p,
                               ad_pool *pool, ad_error *error)
{
    const nn_view *views;
    int count = problem_views(p, &views);
    for (int i = 0; i < count && settings->matrix_count < MATRICES; i++) {
        if (views[i].columns > 1) {
            o->matrices[settings->matrix_count++] =
                (optim_matrix){views[i].offset, (size_t)views[i].rows, (size_t)views[i].columns};
        }
    }
    settings->matrices = o->matrices;
    settings->multiply = multiply;
    settings->context = pool;
    return ad_dense_load(error);
}

static ad_status make(optimizer *o, const train_stage *stage, problem *p, ad_pool *pool,
                      const double *x, ad_error *error)
{
    optim_settings settings = optim_settings_own(&stage->optim);
    const char *why;
    linear_model_info plan;
    ad_status status = AD_OK;
    if (optim_method_reads(o->method) & OPTIM_READS_MATRICES) {
        status = list_matrices(o, &settings, p, pool, error);
    }
    if (optim_method_needs(o->method) == OPTIM_NEEDS_SQUARES) {
        status = linear_model_plan(p, stage, o->stage, &plan, error);
        if (status == AD_OK) {
            status = linear_model_create(p, &plan, pool, &o->model, error);
        }
        o->tried = calloc(2 * o->count, sizeof *o->tried);
        o->gradient = o->tried ? o->tried + o->count : NULL;
        if (status == AD_OK && !o->tried) {
            status = ad_fail(error, AD_NO_MEMORY, "training.stages[%d]: out of memory", o->stage);
        }
    }
    if (status != AD_OK) {
        return status;
    }
    o->own = optim_create(o->count, x, &settings, &why);
    return o->own ? AD_OK : ad_fail(error, AD_NO_MEMORY, "training.stages[%d]: %s", o->stage, why);
}

ad_status optimizer_create(const train_settings *settings, int stage, problem *p, ad_pool *pool,
                           const double *x, optimizer **result, ad_error *error)
{
    const train_stage *chosen = &settings->stages[stage];
    *result = NULL;
    optimizer *o = calloc(1, sizeof *o);
    if (!o) {
        return ad_fail(error, AD_NO_MEMORY, "training.stages[%d]: out of memory", stage);
    }
    o->stage = stage;
    o->count = problem_parameters(p);
    o->method = chosen->optim.method;
    ad_status status = make(o, chosen, p, pool, x, error);
    if (status != AD_OK) {
        optimizer_free(o);
        return status;
    }
    *result = o;
    return AD_OK;
}

void optimizer_free(optimizer *o)
{
    if (o) {
        optim_free(o->own);
        linear_model_free(o->model);
        free(o->tried);
        free(o);
    }
}

/* ---- at work ------------------------------------------------------------------------------- */

static int evaluate(void *context, const double *x, double *value)
{
    optimizer *o = context;
    const optimizer_objective *f = o->objective;
    if (!linear_model_keeps(o->model)) {
        return f->value(f->context, x, value, NULL);
    }
    const int code = f->value(f->context, x, value, o->gradient);
    memcpy(o->tried, x, o->count * sizeof *x);
    o->value = *value;
    o->has_tried = code == OPTIM_OBJECTIVE_OK;
    return code;
}

static int linearize(void *context, const double *x, double *value, double *jtr, double *diagonal)
{
    const optimizer *o = context;
    return o->objective->linearize(o->objective->context, o->model, x, value, jtr, diagonal);
}

static int solve(void *context, double damping, const double *scale, double *step)
{
    return linear_model_solve(((const optimizer *)context)->model, damping, scale, step);
}

static int refresh(void *context, const double *x, double *value, double *jtr)
{
    optimizer *o = context;
    int code = OPTIM_OBJECTIVE_OK;
    if (!o->has_tried || memcmp(x, o->tried, o->count * sizeof *x) != 0) {
        code = evaluate(o, x, &o->value);
    }
    *value = o->value;
    for (size_t i = 0; code == OPTIM_OBJECTIVE_OK && i < o->count; i++) {
        jtr[i] = o->gradient[i] / 2;
    }
    linear_model_refresh(o->model, jtr);
    return code;
}

optim_status optimizer_step(optimizer *o, const optimizer_objective *objective)
{
    const bool keeps = o->model && linear_model_keeps(o->model);
    const optim_linear_model model = {o, evaluate, linearize, solve, keeps ? refresh : NULL};
    const optim_target target = {objective->value, objective->context, &model};
    o->objective = objective;
    const optim_status status = optim_step(o->own, &target);
    o->objective = NULL;
    return status;
}

optim_optimizer *optimizer_method(const optimizer *o)
{
    return o->own;
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
    const optim_info info = optim_inspect(o->own);
    const linear_model_info model = linear_model_inspect(o->model);
    int n = snprintf(text, 160, "%lld of %lld trial steps refused", (long long)info.refused,
                     (long long)info.refused + info.steps);
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
    if (optim_method_reads(o->method) &
        OPTIM_READS_RATE) { /* the one key that may change on the way */
        snprintf(advice, 160,
                 "resume with a smaller training.stages[%d].learning_rate, or with "
                 "clip_norm or warmup_steps",
                 o->stage);
    } else {
        snprintf(advice, 160, "%s", optim_advice(o->method));
    }
}
