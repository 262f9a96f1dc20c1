#include "tools/train/least_squares.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const fit_kind descent;

enum { ITEM_NAME = 96 };

static void make_settings(least_squares *ls)
{
    static const char *const names[] = {"step", "window",   "stage",   "seconds",
                                        "loss", "held_out", "damping", "gradient_norm"};
    *ls->settings = train_settings_default();
    train_stage *stage = &ls->settings->stages[0];
    ls->settings->name = ls->name;
    ls->settings->stage_count = 1;
    ls->settings->output_every = ls->every;
    ls->settings->checkpoint_every = 5 * ls->every;
    ls->settings->checkpoint_seconds = 10;
    stage->optim = optim_settings_defaults(OPTIM_GAUSS_NEWTON);
    stage->optim.scaling = ls->scaling;
    stage->optim.gradient_tolerance = 0;
    stage->steps = ls->steps;
    stage->stop_held_out_ratio = 0;
    ls->fit = fit_of(ls->settings, NULL, &descent, ls);
    ls->fit.windows = ls->descents;
    ls->fit.text_item = "fit/text";
    ls->fit.rows.columns = (int)(sizeof names / sizeof *names);
    memcpy(ls->fit.rows.names, names, sizeof names);
}

ad_status least_squares_create(least_squares *ls, ad_error *error)
{
    AD_TAKE(ls, jtj, ls->count * ls->count);
    AD_TAKE(ls, jtr, ls->count);
    AD_TAKE(ls, start, ls->count);
    AD_TAKE(ls, settings, 1);
    ls->factor = ad_dense_factor_create(ls->count);
    ls->pool = ad_pool_create(1);
    if (ls->memory.is_short || !ls->factor || !ls->pool) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a fit of %zu numbers", ls->count);
    }
    make_settings(ls);
    return ad_dense_load(error);
}

void least_squares_clear(least_squares *ls)
{
    ad_dense_factor_free(ls->factor);
    ad_pool_free(ls->pool);
    optim_free(ls->by);
    fit_free(&ls->fit);
    ad_memory_free(&ls->memory);
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

ad_status least_squares_inverse(least_squares *ls, double *inverse, ad_error *error)
{
    if (ad_dense_cholesky(ls->pool, ls->jtj, NULL, ls->factor)) {
        return ad_fail(error, AD_NOT_FINITE, "what is learned is not determined");
    }
    memset(inverse, 0, ls->count * ls->count * sizeof *inverse);
    for (size_t i = 0; i < ls->count; i++) {
        inverse[i * ls->count + i] = 1;
        ad_dense_cholesky_solve(ls->factor, inverse + i * ls->count);
    }
    return AD_OK;
}

/* ---- as a fit ------------------------------------------------------------------------------ */

static ad_status start(void *of, ad_error *error)
{
    least_squares *ls = of;
    const char *why = NULL;
    optim_free(ls->by);
    ls->by = ls->fit.by = NULL;
    const ad_status status = ls->begin(ls->context, ls->start, error);
    ls->again = false;
    if (status == AD_OK) {
        ls->by = optim_create(ls->count, ls->start, &ls->settings->stages[0].optim, &why);
        ls->fit.by = ls->by;
    }
    return status != AD_OK ? status : ls->by ? AD_OK : ad_fail(error, AD_NO_MEMORY, "fit: %s", why);
}

static ad_status step(void *of, optim_status *status, bool *taken, ad_error *error)
{
    least_squares *ls = of;
    const optim_linear_model model = {ls, evaluate, linearize, least_squares_solve, NULL};
    (void)taken;
    *status = optim_step(ls->by, &(optim_target){.model = &model});
    return ls->judge(ls->context, *status, error);
}

static ad_status row(void *of, ad_error *error)
{
    fit *f = &((least_squares *)of)->fit;
    const double row[] = {
        (double)f->at.step, f->at.window + 1, f->at.stage + 1, fit_seconds(f), f->loss,
        f->held_out,        f->rate,          f->gradient_norm};
    return history_add(&f->rows, row, error);
}

static double trained(const void *of, size_t row)
{
    return history_value(&((const least_squares *)of)->fit.rows, row, "loss");
}

static ad_status end(void *of, optim_status status, bool *again, ad_error *error)
{
    (void)status, (void)error;
    *again = ((const least_squares *)of)->again;
    return AD_OK;
}

static ad_status turn(void *of, ad_error *error)
{
    least_squares *ls = of;
    return ls->turn ? ls->turn(ls->context, error) : AD_OK;
}

/* ---- in a checkpoint ----------------------------------------------------------------------- */

static ad_status put(void *of, checkpoint *file, ad_error *error)
{
    least_squares *ls = of;
    optim_array arrays[OPTIM_STATE_CAPACITY];
    const int count = ls->state(ls->context, arrays);
    const size_t one = 1;
    (void)error;
    checkpoint_put_uint64(file, "fit/digest", &ls->digest, 1, &one);
    checkpoint_put_integer(file, "training/window", ls->fit.at.window);
    for (int i = 0; i < count; i++) {
        char name[ITEM_NAME];
        snprintf(name, sizeof name, "fit/%s", arrays[i].name);
        checkpoint_put_doubles(file, name, arrays[i].data, 1, &arrays[i].count);
    }
    return AD_OK;
}

static ad_status get_state(void *of, const checkpoint *file, ad_error *error)
{
    least_squares *ls = of;
    optim_array arrays[OPTIM_STATE_CAPACITY];
    const int count = ls->state(ls->context, arrays);
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < count; i++) {
        char name[ITEM_NAME];
        snprintf(name, sizeof name, "fit/%s", arrays[i].name);
        status = checkpoint_get_doubles(file, name, arrays[i].data, arrays[i].count, error);
    }
    return status;
}

/* What a descent begins from may be kept, and changes what is: it is got again behind. */
static ad_status get(void *of, const checkpoint *file, bool *at_work, ad_error *error)
{
    least_squares *ls = of;
    int64_t window;
    uint64_t digest;
    ad_status status = checkpoint_get_uint64(file, "fit/digest", &digest, 1, error);
    if (status == AD_OK && digest != ls->digest) {
        return ad_fail(error, AD_BAD_INPUT,
                       "checkpoint: it was fitted to other data; give those, or another folder");
    }
    (void)at_work;
    if (status != AD_OK ||
        (status = checkpoint_get_integer(file, "training/window", 0, ls->fit.windows - 1, &window,
                                         error)) != AD_OK) {
        return status;
    }
    ls->fit.at.window = (int)window;
    return get_state(ls, file, error);
}

static const fit_kind descent = {.start = start,
                                 .step = step,
                                 .row = row,
                                 .trained = trained,
                                 .end = end,
                                 .turn = turn,
                                 .put = put,
                                 .get = get,
                                 .got = get_state};

ad_status least_squares_run(least_squares *ls, const least_squares_runner *runner, ad_error *error)
{
    if (runner) {
        return runner->run(runner->context, ls, error);
    }
    ad_status status = fit_start(&ls->fit, error);
    while (status == AD_OK && ls->fit.state == FIT_RUNNING) {
        status = fit_step(&ls->fit, error);
    }
    return status;
}
