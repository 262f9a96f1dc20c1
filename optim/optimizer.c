#include "optimizer.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct method method;

struct optim_optimizer {
    const method *method;
    void *own; /* optim_adam, optim_lbfgs, ... */
};

/* One row per method. */
struct method {
    void *(*create)(size_t count, const double *x, const optim_settings *s, const char **why);
    void (*free)(void *own);
    optim_status (*step)(void *own, const optim_target *target);
    void (*objective_changed)(void *own);
    const double *(*x)(const void *own);
    const double *(*best_x)(const void *own);
    optim_info (*inspect)(const void *own);
    int (*state)(void *own, optim_array *arrays, int capacity);
    const char *(*state_check)(const void *own);
    const char *(*check)(const optim_settings *s);
    size_t count_max;
    const char *advice;
};

/* The functions that all have, seen through void *. */
#define ADAPT(name, settings)                                                                      \
    static void *name##_create(size_t count, const double *x, const optim_settings *s,             \
                               const char **why)                                                   \
    {                                                                                              \
        return optim_##name##_create(count, x, &s->settings, why);                                 \
    }                                                                                              \
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

ADAPT(adam, adam)
ADAPT(lbfgs, lbfgs)
ADAPT(gauss_newton, gauss_newton)
ADAPT(ssbroyden, ssbroyden)
ADAPT(soap, soap)

#define ADAPTED(name)                                                                              \
    .create = name##_create, .free = name##_free, .step = name##_step, .x = name##_x,              \
    .objective_changed = name##_objective_changed, .inspect = name##_inspect,                      \
    .state = name##_state, .state_check = name##_state_check, .check = name##_check

/* ---- Adam ---- */

static const char *adam_check(const optim_settings *s)
{
    return optim_adam_check(&s->adam);
}

static optim_status adam_step(void *own, const optim_target *target)
{
    return optim_adam_step(own, target->objective, target->context);
}

/* Its steps may climb. */
static const double *adam_best_x(const void *own)
{
    return isfinite(optim_adam_get_info(own).best_value) ? optim_adam_best_x(own)
                                                         : optim_adam_x(own);
}

static optim_info adam_info(optim_adam_info info)
{
    return (optim_info){.value = info.value,
                        .gradient_norm = info.gradient_norm,
                        .rate = info.learning_rate,
                        .steps = info.steps,
                        .evaluations = info.evaluations};
}

static optim_info adam_inspect(const void *own)
{
    return adam_info(optim_adam_get_info(own));
}

/* ---- SOAP ---- */

static const char *soap_check(const optim_settings *s)
{
    return optim_soap_check(&s->soap);
}

static optim_status soap_step(void *own, const optim_target *target)
{
    return optim_soap_step(own, target->objective, target->context);
}

static const double *soap_best_x(const void *own)
{
    return optim_soap_best_x(own);
}

static optim_info soap_inspect(const void *own)
{
    return adam_info(optim_soap_get_info(own));
}

/* ---- along lines ---- */

static optim_info descent_info(optim_descent_info info)
{
    return (optim_info){.value = info.value,
                        .gradient_norm = info.gradient_norm,
                        .rate = info.step,
                        .steps = info.iterations,
                        .evaluations = info.evaluations};
}

static const char *lbfgs_check(const optim_settings *s)
{
    return optim_lbfgs_check(&s->lbfgs);
}

static optim_status lbfgs_step(void *own, const optim_target *target)
{
    return optim_lbfgs_step(own, target->objective, target->context);
}

static optim_info lbfgs_inspect(const void *own)
{
    return descent_info(optim_lbfgs_get_info(own));
}

static const char *ssbroyden_check(const optim_settings *s)
{
    return optim_descent_check(&s->ssbroyden);
}

static optim_status ssbroyden_step(void *own, const optim_target *target)
{
    return optim_ssbroyden_step(own, target->objective, target->context);
}

static optim_info ssbroyden_inspect(const void *own)
{
    return descent_info(optim_ssbroyden_get_info(own));
}

/* ---- Gauss-Newton ---- */

static const char *gauss_newton_check(const optim_settings *s)
{
    return optim_gauss_newton_check(&s->gauss_newton);
}

static optim_status gauss_newton_step(void *own, const optim_target *target)
{
    return optim_gauss_newton_step(own, target->model);
}

static optim_info gauss_newton_inspect(const void *own)
{
    const optim_gauss_newton_info info = optim_gauss_newton_get_info(own);
    return (optim_info){.value = info.value,
                        .gradient_norm = info.gradient_norm,
                        .rate = info.damping,
                        .steps = info.iterations,
                        .evaluations = info.evaluations,
                        .refused = info.rejected + info.not_finite + info.unsolved,
                        .unsolved = info.unsolved};
}

/* ---- the table ---- */

/* Where best_x is x, the value never rises. */
static const method methods[OPTIM_METHOD_COUNT] = {
    [OPTIM_ADAM] = {ADAPTED(adam), .best_x = adam_best_x,
                    .advice = "a smaller learning_rate, or clip_norm or warmup_steps"},
    [OPTIM_LBFGS] = {ADAPTED(lbfgs), .best_x = lbfgs_x,
                     .advice = "more steps of adam before, or a smaller maximum_step"},
    [OPTIM_GAUSS_NEWTON] = {ADAPTED(gauss_newton), .best_x = gauss_newton_x,
                            .advice = "more steps of adam before, or a larger initial_damping"},
    [OPTIM_SSBROYDEN] = {ADAPTED(ssbroyden), .best_x = ssbroyden_x,
                         .count_max = OPTIM_SSBROYDEN_COUNT_MAX,
                         .advice = "more steps of adam before, or a smaller maximum_step"},
    [OPTIM_SOAP] = {ADAPTED(soap), .best_x = soap_best_x,
                    .advice = "a smaller learning_rate, or clip_norm or warmup_steps"},
};

static const char *const names[OPTIM_METHOD_COUNT] = {
#define NAME(code, name) name,
    OPTIM_METHOD_LIST(NAME)
#undef NAME
};

const char *optim_method_name(optim_method method)
{
    return (unsigned)method < OPTIM_METHOD_COUNT ? names[method] : "unknown";
}

optim_method optim_method_of(const char *name)
{
    int method = 0;
    while (method < OPTIM_METHOD_COUNT && strcmp(names[method], name) != 0) {
        method++;
    }
    return (optim_method)method;
}

optim_settings optim_settings_defaults(optim_method method)
{
    return (optim_settings){.method = method,
                            .adam = optim_adam_defaults(),
                            .lbfgs = optim_lbfgs_defaults(),
                            .gauss_newton = optim_gauss_newton_defaults(),
                            .ssbroyden = optim_descent_defaults(),
                            .soap = optim_soap_defaults()};
}

const char *optim_settings_check(const optim_settings *settings)
{
    return (unsigned)settings->method < OPTIM_METHOD_COUNT
               ? methods[settings->method].check(settings)
               : "method must be adam, lbfgs, gauss_newton, ssbroyden or soap";
}

optim_optimizer *optim_create(size_t count, const double *x, const optim_settings *settings,
                              const char **why)
{
    const char *problem = optim_settings_check(settings);
    optim_optimizer *o = problem ? NULL : calloc(1, sizeof *o);
    if (o) {
        o->method = &methods[settings->method];
        o->own = o->method->create(count, x, settings, &problem);
    } else if (!problem) {
        problem = "out of memory";
    }
    if (o && !o->own) {
        free(o);
        o = NULL;
    }
    if (why) {
        *why = problem;
    }
    return o;
}

void optim_free(optim_optimizer *o)
{
    if (o) {
        o->method->free(o->own);
        free(o);
    }
}

optim_status optim_step(optim_optimizer *o, const optim_target *target)
{
    return o->method->step(o->own, target);
}

void optim_objective_changed(optim_optimizer *o)
{
    o->method->objective_changed(o->own);
}

const double *optim_x(const optim_optimizer *o)
{
    return o->method->x(o->own);
}

const double *optim_best_x(const optim_optimizer *o)
{
    return o->method->best_x(o->own);
}

optim_info optim_inspect(const optim_optimizer *o)
{
    return o->method->inspect(o->own);
}

const char *optim_advice(optim_method method)
{
    return methods[method].advice;
}

double optim_bytes(const optim_settings *settings, size_t count)
{
    const double n = (double)count;
    switch (settings->method) {
    case OPTIM_LBFGS:
        return 8 * n * (2 * settings->lbfgs.memory + 7);
    case OPTIM_SSBROYDEN:
        return 8 * n * (0.5 * (n + 1) + 10);
    default:
        return 8 * n * 6;
    }
}

size_t optim_count_max(optim_method method)
{
    return methods[method].count_max ? methods[method].count_max : SIZE_MAX;
}

int optim_state(optim_optimizer *o, optim_array *arrays)
{
    return o->method->state(o->own, arrays, OPTIM_STATE_CAPACITY);
}

const char *optim_state_check(const optim_optimizer *o)
{
    return o->method->state_check(o->own);
}
