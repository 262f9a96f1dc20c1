#include "tools/train/least_squares.h"

#include <stdlib.h>
#include <string.h>

ad_status least_squares_create(least_squares *ls, ad_error *error)
{
    ls->jtj = malloc(ls->count * ls->count * sizeof *ls->jtj);
    ls->jtr = malloc(ls->count * sizeof *ls->jtr);
    ls->factor = ad_dense_factor_create(ls->count);
    ls->pool = ad_pool_create(1);
    return ls->jtj && ls->jtr && ls->factor && ls->pool
               ? ad_dense_load(error)
               : ad_fail(error, AD_NO_MEMORY, "out of memory for a fit of %zu numbers", ls->count);
}

void least_squares_clear(least_squares *ls)
{
    free(ls->jtj);
    free(ls->jtr);
    ad_dense_factor_free(ls->factor);
    ad_pool_free(ls->pool);
    optim_free(ls->by);
}

static int evaluate(void *context, const double *x, double *value)
{
    const least_squares *ls = context;
    return ls->sum(ls->context, x, value, NULL);
}

static int linearize(void *context, const double *x, double *value, double *jtr, double *diagonal)
{
    least_squares *ls = context;
    memset(ls->jtj, 0, ls->count * ls->count * sizeof *ls->jtj);
    memset(ls->jtr, 0, ls->count * sizeof *ls->jtr);
    const int code = ls->sum(ls->context, x, value, ls);
    memcpy(jtr, ls->jtr, ls->count * sizeof *jtr);
    for (size_t i = 0; i < ls->count; i++) {
        diagonal[i] = ls->jtj[i * ls->count + i];
    }
    return code;
}

int least_squares_solve(void *of, double damping, const double *scale, double *step)
{
    const least_squares *ls = of;
    return ad_dense_damped_step(ls->pool, ls->jtj, ls->jtr, damping, scale, ls->count, ls->factor,
                                step);
}

ad_status least_squares_begin(least_squares *ls, const double *x, ad_error *error)
{
    optim_settings settings = optim_settings_defaults(OPTIM_GAUSS_NEWTON);
    const char *why = NULL;
    settings.scaling = ls->scaling;
    settings.gradient_tolerance = 0;
    optim_free(ls->by);
    ls->by = optim_create(ls->count, x, &settings, &why);
    return ls->by ? AD_OK : ad_fail(error, AD_NO_MEMORY, "fit: %s", why);
}

optim_status least_squares_next(least_squares *ls)
{
    const optim_linear_model model = {ls, evaluate, linearize, least_squares_solve, NULL};
    return optim_step(ls->by, &(optim_target){.model = &model});
}
