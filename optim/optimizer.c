#include "internal.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

struct optim_optimizer {
    const optim_kind *kind;
    void *own;
};

static const optim_kind *const kinds[OPTIM_METHOD_COUNT] = {
    [OPTIM_ADAM] = &optim_adam_kind,
    [OPTIM_LBFGS] = &optim_lbfgs_kind,
    [OPTIM_GAUSS_NEWTON] = &optim_gauss_newton_kind,
    [OPTIM_SSBROYDEN] = &optim_ssbroyden_kind,
    [OPTIM_SOAP] = &optim_soap_kind};

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
               ? kinds[settings->method]->check(settings)
               : "method must be adam, lbfgs, gauss_newton, ssbroyden or soap";
}

optim_optimizer *optim_create(size_t count, const double *x, const optim_settings *settings,
                              const char **why)
{
    const char *problem = optim_check_start(optim_settings_check(settings), count, x);
    if (!problem && count > optim_count_max(settings->method)) {
        problem = "count must be in [1, 10000]: the matrix has count^2 / 2 numbers";
    }
    optim_optimizer *o = problem ? NULL : calloc(1, sizeof *o);
    if (o) {
        o->kind = kinds[settings->method];
        o->own = o->kind->create(count, x, settings);
    }
    if (o && !o->own) {
        free(o);
        o = NULL;
    }
    if (why) {
        *why = problem || o ? problem : "out of memory";
    }
    return o;
}

void optim_free(optim_optimizer *o)
{
    if (o) {
        o->kind->free(o->own);
        free(o);
    }
}

optim_status optim_step(optim_optimizer *o, const optim_target *target)
{
    return o->kind->step(o->own, target);
}

void optim_objective_changed(optim_optimizer *o)
{
    o->kind->objective_changed(o->own);
}

const double *optim_x(const optim_optimizer *o)
{
    return o->kind->x(o->own);
}

const double *optim_best_x(const optim_optimizer *o)
{
    return o->kind->best_x ? o->kind->best_x(o->own) : o->kind->x(o->own);
}

optim_info optim_inspect(const optim_optimizer *o)
{
    return o->kind->inspect(o->own);
}

const char *optim_advice(optim_method method)
{
    return kinds[method]->advice;
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
    return kinds[method]->count_max ? kinds[method]->count_max : SIZE_MAX;
}

int optim_state(optim_optimizer *o, optim_array *arrays)
{
    return o->kind->state(o->own, arrays, OPTIM_STATE_CAPACITY);
}

const char *optim_state_check(const optim_optimizer *o)
{
    return o->kind->state_check(o->own);
}
