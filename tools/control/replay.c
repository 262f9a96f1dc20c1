#include "tools/control/replay.h"

#include "autodiff/memory.h"
#include "physics/numerics/clock.h"
#include "tools/control/loop_internal.h"
#include "tools/control/marker_drift.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rollouts begin so many times in the span of one. */
enum { ROLLOUTS = 10 };

/* Of a period: samples are evenly spaced. */
static const double EVEN = 1e-3;

typedef struct replay {
    control_loop *loop; /* its models and sensors */
    replay_settings settings;
    marker_drift drift;
    one_step model; /* that of the loop, or with drift */
    one_observation eye[MARKER_DRIFT_MAX];
    estimator_sensor sensor[MARKER_DRIFT_MAX];
    double *numbers; /* [3][states] start, deviation, process of the filter; [states][estimates] */
    estimator *filter;
    const solve_inputs *inputs;
    replay_report *report;
    int markers;
    double *seen;     /* [samples][markers][3] as measured; NaN: nothing */
    double *state;    /* [2][states] of a rollout */
    size_t ahead;     /* samples */
    size_t counts[2]; /* of numbers that are judged: one sample ahead, many */
    ad_memory memory;
} replay;

/* ---- the record ---------------------------------------------------------------------------- */

static bool is_of(const solve_measured *set, size_t row, const solve_inputs *inputs)
{
    return set->inputs && set->inputs[row] == inputs;
}

static ad_status find_period(const solve_inputs *inputs, double ahead, control_settings *control,
                             ad_error *error)
{
    const double *t = inputs->t, span = t[inputs->count - 1] - t[0];
    const double period = inputs->count > 1 ? span / (double)(inputs->count - 1) : 0;
    for (size_t k = 1; k < inputs->count; k++) {
        if (fabs(t[k] - t[k - 1] - period) > EVEN * period) {
            return ad_fail(error, AD_BAD_INPUT,
                           "sample %zu of the recording is %g s after the one before, others %g; "
                           "allowed: evenly spaced samples",
                           k + 1, t[k] - t[k - 1], period);
        }
    }
    if (!(span >= 2 * ahead)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "the recording lasts %g s; allowed: at least twice as long as predictions, "
                       "%g s",
                       span, ahead);
    }
    control->period = period;
    return AD_OK;
}

/* A sensor for each set of the recording, at the place of its rows. */
static ad_status find_sensors(int sets, const solve_measured *measured, const solve_inputs *inputs,
                              control_settings *control, ad_error *error)
{
    control->measurement_count = control->limit_count = control->fault_count = 0;
    for (int i = 0; i < sets; i++) {
        const solve_measured *set = &measured[i];
        double at = NAN;
        for (size_t row = 0; row < set->rows; row++) {
            if (is_of(set, row, inputs) && !isnan(at) && set->s[row] != at) {
                return ad_fail(error, AD_BAD_INPUT,
                               "a marker is at s = %g m, and at %g m later; allowed: one place for "
                               "each entry of data",
                               at, set->s[row]);
            }
            at = is_of(set, row, inputs) ? set->s[row] : at;
        }
        if (isnan(at)) {
            continue;
        }
        if (set->columns != 3 || set->column[0] != 0 || set->view) {
            return ad_fail(error, AD_BAD_INPUT,
                           "a replay takes positions alone, of the axis, in the axes of the scene, "
                           "without delay");
        }
        if (control->measurement_count == CONTROL_MEASUREMENTS_MAX) {
            return ad_fail(error, AD_BAD_INPUT, "more than %d markers; allowed: as many at most",
                           CONTROL_MEASUREMENTS_MAX);
        }
        control->measurements[control->measurement_count++] = (control_measurement){
            .what = OBSERVATION_POSITION, .at = at, .noise = set->noise[0], .every = 1};
    }
    return AD_OK;
}

/* What was seen at each sample. */
static ad_status fill_seen(replay *x, int sets, const solve_measured *measured, ad_error *error)
{
    const solve_inputs *inputs = x->inputs;
    const size_t width = 3 * (size_t)x->markers;
    size_t marker = 0;
    AD_TAKE(x, seen, inputs->count * width);
    if (x->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu samples", inputs->count);
    }
    for (size_t k = 0; k < inputs->count * width; k++) {
        x->seen[k] = NAN;
    }
    for (int i = 0; i < sets; i++) {
        const solve_measured *set = &measured[i];
        bool any = false;
        for (size_t row = 0; row < set->rows; row++) {
            if (is_of(set, row, inputs)) {
                const double sample = (set->t[row] - inputs->t[0]) / x->loop->period;
                double *to = x->seen + (size_t)lround(sample) * width + 3 * marker;
                for (size_t c = 0; c < 3; c++) {
                    to[c] = set->values[c * set->rows + row];
                }
                any = true;
            }
        }
        marker += any;
    }
    return AD_OK;
}

/* ---- the filter ---------------------------------------------------------------------------- */

/* All parameters at a sample: recorded inputs, and what else the file says, but for what is
 * estimated. */
static void inputs_of(const replay *x, size_t sample, double *inputs)
{
    const size_t width = (size_t)x->loop->parameters;
    const scene *nominal = x->loop->of.nominal;
    memcpy(inputs, x->inputs->values + sample * width, width * sizeof *inputs);
    memset(inputs + scene_given_count(nominal), 0,
           (size_t)nominal->memory_count * sizeof *inputs); /* the model has them in its state */
    for (int i = 0; i < x->loop->control.estimate_count; i++) {
        const int k = x->loop->parameter[i].input;
        inputs[k] = x->filter ? estimator_parameter_now(x->filter, i) : x->loop->middle[k];
    }
}

/* Deviations and process noise of the filter, by how large states are along the recording. */
static ad_status find_sizes(replay *x, ad_error *error)
{
    control_loop *loop = x->loop;
    const one_step *model = &loop->by_period;
    const size_t n = (size_t)loop->states, count = x->inputs->count;
    double now[SCENE_PARAMETERS_MAX], after[SCENE_PARAMETERS_MAX], *size = loop->numbers + 3 * n;
    memcpy(x->state, loop->numbers, n * sizeof *x->state);
    memset(size, 0, n * sizeof *size);
    for (size_t k = 0; k + 1 < count; k++) {
        inputs_of(x, k, now);
        inputs_of(x, k + 1, after);
        if (model->advance(model->context, 1, loop->period, x->state, now, after, x->state + n,
                           NULL, NULL)) {
            return ad_fail(error, AD_NOT_FINITE, "the model has no step from t = %g s on",
                           x->inputs->t[k]);
        }
        memcpy(x->state, x->state + n, n * sizeof *x->state);
        for (size_t i = 0; i < n; i++) {
            size[i] += x->state[i] * x->state[i] / (double)(count - 1);
        }
    }
    for (size_t i = 0; i < n; i++) {
        size[i] = sqrt(size[i]);
    }
    loop_fill_noise(loop);
    return AD_OK;
}

/* Settings of the filter, with offsets of markers behind the states where these drift. */
static estimator_settings settings_of(replay *x, size_t states, size_t all, size_t estimates)
{
    const control_loop *loop = x->loop;
    estimator_settings settings = loop->settings.estimator;
    double *deviation = x->numbers + all, *process = deviation + all, *by = process + all;
    const double walked = x->settings.drift * sqrt(x->settings.fade > 0 ? x->settings.fade / 2 : 1);
    for (size_t k = 0; k < all; k++) {
        const bool drifts = k >= states;
        x->numbers[k] = drifts ? 0 : loop->numbers[k];
        deviation[k] = drifts ? walked : loop->numbers[states + k]; /* of a second, if for ever */
        process[k] = drifts ? x->settings.drift : loop->numbers[2 * states + k];
    }
    for (size_t k = 0; k < all * estimates; k++) {
        by[k] = k < states * estimates ? loop->numbers[4 * states + k] : 0;
    }
    for (int m = 0; m < x->markers; m++) {
        x->sensor[m] = loop->sensor[m];
        x->sensor[m].observation = x->eye[m];
        x->sensor[m].depends = all > states ? 0 : loop->sensor[m].depends;
    }
    settings.model = x->model;
    settings.sensor = x->sensor;
    settings.deviation = deviation;
    settings.process = process;
    return settings;
}

/* Where markers drift, with their offsets. */
static void choose_model(replay *x)
{
    const bool drifts = x->settings.drift > 0;
    x->drift = (marker_drift){
        .model = x->loop->by_period, .markers = x->markers, .fade = x->settings.fade};
    AD_TAKE(x, drift.room, x->loop->states * x->loop->states);
    for (int m = 0; m < x->markers; m++) {
        x->drift.eye[m].observation = x->loop->sensor[m].observation;
        x->eye[m] = drifts ? marker_drift_see(&x->drift, m) : x->loop->sensor[m].observation;
    }
    x->model = drifts ? marker_drift_model(&x->drift) : x->loop->by_period;
}

static ad_status start(replay *x, ad_error *error)
{
    control_loop *loop = x->loop;
    const int count = loop->control.estimate_count;
    const size_t n = (size_t)loop->states, all = (size_t)x->model.states;
    double inputs[SCENE_PARAMETERS_MAX];
    inputs_of(x, 0, inputs);
    ad_status status = equilibria_settle(loop->rest, inputs, loop->numbers, error);
    status = status == AD_OK ? find_sizes(x, error) : status;
    if (status == AD_OK) {
        status = loop_begin(loop, inputs, error);
    }
    AD_TAKE(x, numbers, all * (3 + (size_t)count));
    if (status == AD_OK && x->memory.is_short) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a filter");
    }
    if (status != AD_OK) {
        return status;
    }
    const estimator_settings settings = settings_of(x, n, all, (size_t)count);
    const char *refused = estimator_refusal(&settings);
    if (status == AD_OK && refused) {
        return ad_fail(error, AD_BAD_INPUT, "the filter refuses: %s", refused);
    }
    void *filter =
        status == AD_OK ? ad_memory_take(&x->memory, estimator_size(&settings), 1) : NULL;
    if (!filter) {
        return status == AD_OK ? ad_fail(error, AD_NO_MEMORY, "out of memory for a filter")
                               : status;
    }
    x->filter = estimator_init(filter, &settings);
    estimator_start(x->filter, x->numbers, inputs, x->numbers + 3 * all);
    return AD_OK;
}

/* ---- judging ------------------------------------------------------------------------------- */

/* Adds what a state misses of the markers at a sample, and how far they are from where they were
 * at another one. */
static void judge(const replay *x, const double *state, size_t sample, size_t before, double *off,
                  double *still, size_t *count)
{
    const size_t width = 3 * (size_t)x->markers;
    const double *seen = x->seen + sample * width, *then = x->seen + before * width;
    double inputs[SCENE_PARAMETERS_MAX];
    inputs_of(x, sample, inputs);
    for (size_t m = 0; m < (size_t)x->markers; m++) {
        const one_observation *eye = &x->eye[m];
        double place[3], miss = 0, moved = 0;
        const bool good = eye->see(eye->context, 1, state, inputs, place, NULL) == 0;
        for (size_t c = 0; c < 3; c++) {
            miss += pow(good ? place[c] - seen[3 * m + c] : INFINITY, 2);
            moved += pow(seen[3 * m + c] - then[3 * m + c], 2);
        }
        if (!isnan(miss) && !isnan(moved)) {
            *off += miss;
            *still += moved;
            ++*count;
        }
    }
}

/* From what the filter knows at a sample on, by the model alone. */
static void roll_out(replay *x, size_t sample)
{
    const one_step *model = &x->model;
    const size_t n = (size_t)model->states;
    double now[SCENE_PARAMETERS_MAX], after[SCENE_PARAMETERS_MAX];
    double *state = x->state, *next = state + n;
    bool good = true;
    memcpy(state, estimator_state(x->filter), n * sizeof *state);
    for (size_t k = sample; k < sample + x->ahead && good; k++) {
        inputs_of(x, k, now);
        inputs_of(x, k + 1, after);
        good = model->advance(model->context, 1, x->loop->period, state, now, after, next, NULL,
                              NULL) == 0;
        memcpy(state, next, n * sizeof *state);
    }
    for (size_t k = 0; k < n && !good; k++) {
        state[k] = INFINITY;
    }
    judge(x, state, sample + x->ahead, sample, &x->report->ahead, &x->report->ahead_still,
          &x->counts[1]);
    x->report->rollouts++;
}

static void take(replay *x, size_t sample)
{
    const size_t width = 3 * (size_t)x->markers;
    double now[SCENE_PARAMETERS_MAX], after[SCENE_PARAMETERS_MAX];
    if (sample > x->ahead) {
        judge(x, estimator_state(x->filter), sample, sample - 1, &x->report->step,
              &x->report->step_still, &x->counts[0]);
    }
    const double begin = clock_seconds(CLOCK_MONOTONIC);
    for (int m = 0; m < x->markers; m++) {
        const double *values = x->seen + sample * width + 3 * (size_t)m;
        if (!isnan(values[0] + values[1] + values[2])) {
            estimator_measure(x->filter, m, 0, values);
        }
    }
    estimator_update(x->filter);
    double spent = clock_seconds(CLOCK_MONOTONIC) - begin;
    const size_t every = x->ahead > ROLLOUTS ? x->ahead / ROLLOUTS : 1;
    if (sample >= x->ahead && sample % every == 0 && sample + x->ahead < x->inputs->count) {
        roll_out(x, sample);
    }
    if (sample + 1 < x->inputs->count) {
        const double again = clock_seconds(CLOCK_MONOTONIC);
        inputs_of(x, sample, now);
        inputs_of(x, sample + 1, after);
        estimator_predict(x->filter, now, after);
        spent += clock_seconds(CLOCK_MONOTONIC) - again;
    }
    x->report->seconds += spent / (double)x->inputs->count;
}

static void conclude(replay *x)
{
    replay_report *report = x->report;
    const control_loop *loop = x->loop;
    double *const sums[4] = {&report->step, &report->step_still, &report->ahead,
                             &report->ahead_still};
    for (int i = 0; i < 4; i++) {
        *sums[i] = sqrt(*sums[i] / (double)x->counts[i / 2]);
    }
    for (int m = 0; m < x->markers; m++) {
        report->noise += 3 * pow(loop->control.measurements[m].noise, 2) / x->markers;
        report->refused += (long)estimator_sensor_now(x->filter, m).outliers;
    }
    report->noise = sqrt(report->noise);
    report->samples = x->inputs->count;
    report->judged = x->counts[0];
    report->period = loop->period;
    report->doubt = estimator_doubt(x->filter);
    report->residual = residual_reached(loop->beyond);
    for (int i = 0; i < loop->control.estimate_count; i++) {
        report->estimate[i] = estimator_parameter_now(x->filter, i);
        report->deviation[i] = estimator_parameter_deviation(x->filter, i);
        report->recorded[i] = x->inputs->values[loop->parameter[i].input];
    }
}

/* ---- all of it ----------------------------------------------------------------------------- */

static ad_status run(replay *x, int sets, const solve_measured *measured, ad_error *error)
{
    x->markers = x->loop->control.measurement_count;
    x->ahead = (size_t)fmax(1, round(x->settings.ahead / x->loop->period));
    choose_model(x);
    const size_t n = (size_t)x->model.states;
    AD_TAKE(x, state, 2 * n);
    ad_status status = x->state ? fill_seen(x, sets, measured, error)
                                : ad_fail(error, AD_NO_MEMORY, "out of memory for a replay");
    status = status == AD_OK ? start(x, error) : status;
    for (size_t k = 0; k < x->inputs->count && status == AD_OK; k++) {
        take(x, k);
    }
    if (status == AD_OK) {
        conclude(x);
    }
    return status;
}

ad_status replay_run(const loop_setup *setup, int sets, const solve_measured *measured,
                     const solve_inputs *inputs, const replay_settings *settings,
                     replay_report *report, ad_error *error)
{
    replay x = {.inputs = inputs, .settings = *settings, .report = report};
    control_settings control = *setup->control;
    loop_setup of = *setup;
    *report = (replay_report){.samples = 0};
    of.control = &control;
    ad_status status = find_period(inputs, settings->ahead, &control, error);
    status = status == AD_OK ? find_sensors(sets, measured, inputs, &control, error) : status;
    status = status == AD_OK ? loop_create_filter(&of, &x.loop, error) : status;
    status = status == AD_OK ? run(&x, sets, measured, error) : status;
    ad_memory_free(&x.memory);
    loop_free(x.loop);
    return status;
}
