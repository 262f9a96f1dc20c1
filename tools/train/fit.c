#include "tools/train/fit.h"

#include "autodiff/ranks.h"
#include "physics/numerics/clock.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ROWS_APART = 5, ITEM_NAME = 96 };
static const double usual_ratio = 100; /* where the stage does not stop for it */

fit fit_of(const train_settings *settings, const ad_ranks *ranks, const fit_kind *kind, void *of)
{
    const double now = clock_seconds(CLOCK_MONOTONIC);
    return (fit){.settings = settings,
                 .ranks = ranks,
                 .kind = kind,
                 .of = of,
                 .windows = 1,
                 .at.part = 1,
                 .loss = NAN,
                 .gradient_norm = NAN,
                 .held_out = NAN,
                 .error = NAN,
                 .points = NAN,
                 .held_out_ratio = NAN,
                 .started = now,
                 .stage_started = now,
                 .still = NAN,
                 .best_held_out = INFINITY};
}

void fit_free(fit *f)
{
    history_free(&f->rows);
}

ad_status fit_start(fit *f, ad_error *error)
{
    f->steps = f->settings->stages[f->at.stage].steps;
    const ad_status status = f->kind->start(f->of, error);
    f->stage_started = clock_seconds(CLOCK_MONOTONIC);
    f->state = f->steps > 0 ? f->state : FIT_OVER; /* of a fit that shall only begin */
    return status;
}

static double clock_of(const fit *f)
{
    return isnan(f->still) ? clock_seconds(CLOCK_MONOTONIC) : f->still;
}

double fit_seconds(const fit *f)
{
    return clock_of(f) - f->started;
}

double fit_stage_seconds(const fit *f)
{
    return f->state == FIT_OVER ? 0 : clock_of(f) - f->stage_started;
}

ad_status fit_add_row(fit *f, ad_error *error)
{
    const bool runs = isnan(f->still);
    f->still = runs ? clock_seconds(CLOCK_MONOTONIC) : f->still;
    const ad_status status = f->kind->row(f->of, error);
    if (runs) {
        const double passed = clock_seconds(CLOCK_MONOTONIC) - f->still;
        f->started += passed;
        f->stage_started += passed;
        f->still = NAN;
    }
    return status;
}

/* ---- interpolation --------------------------------------------------------------------------- */

int fit_row_window(const fit *f, size_t row)
{
    const double window = f->windows == 1 ? 1 : history_value(&f->rows, row, "window");
    return window >= 1 && window <= f->windows ? (int)window - 1 : 0;
}

/* The held-out loss of rows to come has nothing to do with that of those before. */
static void forget_held_out(fit *f)
{
    f->best_held_out = INFINITY;
    f->rows_apart = 0;
}

void fit_watch(fit *f, size_t row)
{
    const history *h = &f->rows;
    const double stage = history_value(h, row, "stage"); /* from 1; of a file, it may be anything */
    const double held_out = history_value(h, row, "held_out");
    const double part = history_value(h, row, "load_factor");
    const bool known = stage >= 1 && stage <= f->settings->stage_count;
    const double limit = known ? f->settings->stages[(int)stage - 1].stop_held_out_ratio : 0;
    const double trained = f->kind->trained(f->of, row);
    const bool other_loads =
        row > 0 && part != history_value(h, row - 1, "load_factor") && part > 0;
    if (row > 0 && (other_loads || fit_row_window(f, row) != fit_row_window(f, row - 1))) {
        forget_held_out(f);
    } else if (row > 0 && stage != history_value(h, row - 1, "stage")) {
        f->rows_apart = 0;
    }
    f->held_out_ratio = held_out / trained;
    f->interpolates =
        held_out > (limit > 0 ? limit : usual_ratio) * trained && held_out > FIT_ROUNDING_LOSS;
    f->rows_apart = f->interpolates && held_out >= f->best_held_out ? f->rows_apart + 1 : 0;
    f->best_held_out = fmin(f->best_held_out, held_out);
}

/* ---- stepping ------------------------------------------------------------------------------ */

static const char *reason_to_end(fit *f, optim_status status)
{
    const train_stage *stage = &f->settings->stages[f->at.stage];
    const bool runs = status == OPTIM_RUNNING;
    double passed = fit_stage_seconds(f); /* the clock of the first rank counts */
    if (f->reason) {
        return f->reason;
    }
    if (runs && f->error < stage->stop_error) {
        return "stop.error reached";
    }
    if (runs && stage->stop_held_out_ratio > 0 && f->rows_apart >= ROWS_APART) {
        snprintf(f->apart, sizeof f->apart,
                 "held-out loss %.1e times the training loss: the network interpolates its points",
                 f->held_out_ratio);
        return f->apart;
    }
    if (!runs) {
        return optim_status_name(status);
    }
    if (f->loss < stage->stop_loss) {
        return "stop.loss reached";
    }
    if (stage->stop_seconds > 0) {
        ad_ranks_first(f->ranks, 1, &passed);
    }
    return stage->stop_seconds > 0 && passed > stage->stop_seconds ? "stop.seconds reached"
           : f->at.stage_step >= f->steps                          ? "steps done"
                                                                   : NULL;
}

static ad_status end_stage(fit *f, const char *why, optim_status status, ad_error *error)
{
    bool again = false;
    f->ended = why;
    ad_status result = f->kind->end(f->of, status, &again, error);
    f->by = NULL;
    if (result != AD_OK) {
        return result;
    }
    if (again) {
        forget_held_out(f);
        return fit_start(f, error);
    }
    f->at.stage++;
    f->at.stage_step = 0;
    f->rows_apart = 0;
    if (f->at.stage < f->settings->stage_count) {
        return fit_start(f, error);
    }
    if (f->at.window + 1 == f->windows) {
        f->state = FIT_OVER;
    } else { /* other parameters, another loss */
        forget_held_out(f);
        f->at.window++;
        f->at.window_step = 0;
        f->at.stage = 0;
    }
    result = f->kind->turn ? f->kind->turn(f->of, error) : AD_OK;
    if (f->state == FIT_OVER) { /* also where the kind wants no other window */
        f->at.window = f->before.window;
        f->at.stage = f->settings->stage_count;
    }
    return result == AD_OK && f->state == FIT_RUNNING ? fit_start(f, error) : result;
}

ad_status fit_step(fit *f, ad_error *error)
{
    bool taken = true;
    optim_status status = OPTIM_RUNNING;
    f->before = f->at;
    f->reason = NULL;
    ad_status result = f->kind->step(f->of, &status, &taken, error);
    if (taken) {
        const optim_info done = optim_inspect(f->by);
        f->loss = done.value;
        f->gradient_norm = done.gradient_norm;
        f->rate = done.rate;
    }
    if (result != AD_OK || !taken) {
        return result;
    }
    f->at.step++;
    f->at.window_step++;
    f->at.stage_step++;
    const char *end = reason_to_end(f, status);
    if (end || f->at.step == 1 || f->at.step % f->settings->output_every == 0) {
        result = fit_add_row(f, error);
        if (result == AD_OK) {
            fit_watch(f, f->rows.count - 1);
        }
        end = end ? end : reason_to_end(f, status); /* the error is known only now */
    }
    result = result == AD_OK && end ? end_stage(f, end, status, error) : result;
    f->still = f->state == FIT_OVER ? clock_seconds(CLOCK_MONOTONIC) : NAN;
    return result;
}

char *train_origin_text(const train_origin *origin)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = origin->write ? open_memstream(&text, &size) : NULL;
    if (!file) {
        return NULL;
    }
    ad_status status = origin->write(origin->context, file);
    if (fclose(file) != 0 || status != AD_OK) {
        free(text);
        return NULL;
    }
    return text;
}

void train_origin_put(const train_origin *origin, const char *item, checkpoint *file)
{
    char *text = train_origin_text(origin);
    checkpoint_put_text(file, item, text); /* NULL is refused and remembered */
    free(text);
}

/* ---- in a checkpoint ----------------------------------------------------------------------- */

static void put_place(const fit *f, checkpoint *file)
{
    optim_array arrays[OPTIM_STATE_CAPACITY];
    const int count = f->by ? optim_state(f->by, arrays) : 0;
    checkpoint_put_integer(file, "training/step", f->at.step);
    checkpoint_put_integer(file, "training/stage", f->at.stage);
    checkpoint_put_integer(file, "training/stage_step", f->at.stage_step);
    checkpoint_put_double(file, "training/seconds", fit_seconds(f));
    checkpoint_put_double(file, "training/stage_seconds", fit_stage_seconds(f));
    for (int i = 0; i < count; i++) {
        char name[ITEM_NAME];
        snprintf(name, sizeof name, "optimizer/%s", arrays[i].name);
        checkpoint_put_doubles(file, name, arrays[i].data, 1, &arrays[i].count);
    }
    if (f->windows > 1) {
        checkpoint_put_integer(file, "training/window_step", f->at.window_step);
    }
}

static ad_status get_seconds(const checkpoint *file, const char *name, double *value,
                             ad_error *error)
{
    ad_status status = checkpoint_get_doubles(file, name, value, 1, error);
    return status == AD_OK && !(*value >= 0 && isfinite(*value))
               ? ad_fail(error, AD_BAD_INPUT, "checkpoint: %s is %g; 0 or more is possible", name,
                         *value)
               : status;
}

static ad_status get_place(fit *f, const checkpoint *file, ad_error *error)
{
    const int stages = f->settings->stage_count;
    fit_place *at = &f->at;
    int64_t stage;
    double seconds, stage_seconds;
    ad_status status;
    if ((status = checkpoint_get_integer(file, "training/step", 0, INT64_MAX - 1, &at->step,
                                         error)) != AD_OK ||
        (status = checkpoint_get_integer(file, "training/stage", 0, stages, &stage, error)) !=
            AD_OK ||
        (status = checkpoint_get_integer(file, "training/stage_step", 0, at->step, &at->stage_step,
                                         error)) != AD_OK ||
        (status = get_seconds(file, "training/seconds", &seconds, error)) != AD_OK ||
        (status = get_seconds(file, "training/stage_seconds", &stage_seconds, error)) != AD_OK) {
        return status;
    }
    at->window_step = at->step;
    at->stage = (int)stage;
    f->state = at->stage == stages ? FIT_OVER : FIT_RUNNING;
    f->still = f->state == FIT_OVER ? f->started : NAN;
    f->started -= seconds;
    f->stage_started = clock_seconds(CLOCK_MONOTONIC) - stage_seconds;
    return f->windows > 1 ? checkpoint_get_integer(file, "training/window_step", 0, at->step,
                                                   &at->window_step, error)
                          : AD_OK;
}

static ad_status go_on(fit *f, bool at_work, const checkpoint *file, ad_error *error)
{
    optim_array arrays[OPTIM_STATE_CAPACITY];
    const double started = f->stage_started;
    if (f->state == FIT_OVER) {
        return AD_OK;
    }
    ad_status status = fit_start(f, error);
    f->stage_started = started;
    const int count = status == AD_OK && at_work ? optim_state(f->by, arrays) : 0;
    for (int i = 0; status == AD_OK && i < count; i++) {
        char name[ITEM_NAME];
        snprintf(name, sizeof name, "optimizer/%s", arrays[i].name);
        status = checkpoint_get_doubles(file, name, arrays[i].data, arrays[i].count, error);
    }
    const char *why = status == AD_OK && count > 0 ? optim_state_check(f->by) : NULL;
    return why ? ad_fail(error, AD_BAD_INPUT, "checkpoint: %s", why) : status;
}

static ad_status get_rows(fit *f, const checkpoint *file, ad_error *error)
{
    const ad_status status = history_get(&f->rows, file, error);
    for (size_t row = 0; status == AD_OK && row < f->rows.count; row++) {
        fit_watch(f, row);
    }
    if (status == AD_OK && f->rows.count > 0) {
        const size_t last = f->rows.count - 1;
        if (history_value(&f->rows, last, "stage") != f->at.stage + 1 ||
            fit_row_window(f, last) != f->at.window) {
            f->rows_apart = 0; /* the stage at work has no rows yet */
        }
        f->loss = history_value(&f->rows, last, "loss");
        f->held_out = history_value(&f->rows, last, "held_out");
        f->error = history_value(&f->rows, last, "error");
    }
    return status;
}

ad_status fit_save(fit *f, const file_place *place, ad_error *error)
{
    checkpoint *file = checkpoint_create(CPINN_VERSION);
    if (!file) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a checkpoint");
    }
    if (f->origin) {
        train_origin_put(f->origin, f->text_item, file);
    }
    put_place(f, file);
    history_put(&f->rows, file);
    ad_status status = f->kind->put(f->of, file, error);
    status = status == AD_OK && place ? checkpoint_write(file, place, error) : status;
    checkpoint_free(file);
    return status;
}

ad_status fit_restore(fit *f, const checkpoint *file, ad_error *error)
{
    bool at_work = true;
    ad_status status = get_place(f, file, error);
    status = status == AD_OK ? f->kind->get(f->of, file, &at_work, error) : status;
    status = status == AD_OK ? go_on(f, at_work, file, error) : status;
    status = status == AD_OK ? get_rows(f, file, error) : status;
    return status == AD_OK && f->kind->got ? f->kind->got(f->of, file, error) : status;
}
