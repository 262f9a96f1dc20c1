#include "tools/control/loop_internal.h"

#include "physics/numerics/clock.h"
#include "physics/numerics/sort.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DELAYS = 21 };

/* A measurement on its way. */
typedef struct taken {
    double values[4];
    int count;
    bool lost;
} taken;

typedef struct running {
    control_loop *x;
    loop_report *report;
    long k;
    double t;
    double reference[3], place[3], estimated[3];
    double applied[SCENE_PARAMETERS_MAX], next[CONTROL_INPUTS_MAX];
    taken on_way[CONTROL_MEASUREMENTS_MAX][DELAYS];
    double seconds[2]; /* of the filter, of the controller */
    int flags[2];
    double before[CONTROL_INPUTS_MAX], change[CONTROL_INPUTS_MAX]; /* by ranges, a sample ago */
    double innovations[CONTROL_MEASUREMENTS_MAX];
    long used[CONTROL_MEASUREMENTS_MAX];
    long windows[CONTROL_MEASUREMENTS_MAX], beyond[CONTROL_MEASUREMENTS_MAX][LOOP_BOUNDS];
    double *rows; /* [horizon][LOOP_SEEN] wanted */
} running;

/* ---- faults -------------------------------------------------------------------------------- */

static bool happens(const running *r, control_fault_kind kind, int measurement)
{
    const control_settings *c = &r->x->control;
    bool any = false;
    for (int i = 0; i < c->fault_count; i++) {
        const control_fault *f = &c->faults[i];
        const double end = f->from + fmax(f->lasts, r->x->period / 2);
        any = any || (f->kind == kind && (f->measurement < 0 || f->measurement == measurement) &&
                      r->t >= f->from - r->x->period / 2 && r->t < end);
    }
    return any;
}

/* ---- a sample ------------------------------------------------------------------------------ */

static ad_status take_measurements(running *r, ad_error *error)
{
    const control_settings *c = &r->x->control;
    ad_status status = AD_OK;
    for (int i = 0; i < c->measurement_count && status == AD_OK; i++) {
        taken *now = &r->on_way[i][r->k % DELAYS];
        now->lost = true;
        if (r->k % c->measurements[i].every != 0) {
            continue;
        }
        status = plant_measure(r->x->robot, i, now->values, &now->count, error);
        now->lost = plant_loses(r->x->robot, i) || happens(r, CONTROL_LOST, i);
        for (int k = 0; k < now->count; k++) {
            now->values[k] = happens(r, CONTROL_NOT_A_NUMBER, i) ? NAN
                             : happens(r, CONTROL_WILD, i)
                                 ? now->values[k] + scene_length(r->x->of.nominal)
                                 : now->values[k];
        }
    }
    return status;
}

static void filter(running *r)
{
    control_loop *loop = r->x;
    const control_settings *c = &loop->control;
    const double start = clock_seconds(CLOCK_MONOTONIC);
    r->flags[0] = 0;
    for (int i = 0; i < c->measurement_count; i++) {
        const int delay = c->measurements[i].delay;
        const taken *then = &r->on_way[i][(r->k + DELAYS - delay) % DELAYS];
        if (r->k >= delay && !then->lost) {
            r->flags[0] |= regulator_measure(loop->both, i, delay, then->values);
        }
    }
    r->flags[0] |= regulator_filter(loop->both);
    r->seconds[0] = clock_seconds(CLOCK_MONOTONIC) - start;
}

static void wish(running *r)
{
    const control_loop *loop = r->x;
    const int v = loop->values;
    const double from = r->t + loop->control.delay * loop->period;
    for (int i = 0; i < loop->control.horizon; i++) {
        double *row = r->rows + (size_t)(i * v);
        task_path_at(loop->path, from + (i + 1) * loop->step, row);
        for (int k = 3; k < v; k++) {
            row[k] = NAN;
        }
    }
}

/* A late answer is what the last plan goes on with. The long part, what is prepared for the next
 * sample, counts as the controller's but for the filter's prediction. */
static void control(running *r)
{
    control_loop *loop = r->x;
    const double start = clock_seconds(CLOCK_MONOTONIC);
    r->flags[1] = 0;
    if (happens(r, CONTROL_LATE, -1)) {
        (void)regulator_late(loop->both, false, r->next);
        r->report->late++;
    } else {
        wish(r);
        r->flags[1] = regulator_plan(loop->both, r->rows, r->next) >> REGULATOR_CONTROLLER;
    }
    const double planned = clock_seconds(CLOCK_MONOTONIC);
    regulator_predict(loop->both);
    const double predicted = clock_seconds(CLOCK_MONOTONIC);
    regulator_prepare(loop->both);
    r->seconds[0] += predicted - planned;
    r->seconds[1] = clock_seconds(CLOCK_MONOTONIC) - start - (predicted - planned);
}

static void apply(running *r)
{
    for (int i = 0; i < r->x->input_count; i++) {
        r->applied[r->x->inputs[i]] = r->next[i];
    }
}

/* ---- the record ---------------------------------------------------------------------------- */

static void judge_constraints(running *r, const double *values)
{
    const control_settings *c = &r->x->control;
    for (int i = 0; i < c->limit_count; i++) {
        const control_limit *l = &c->limits[i];
        const double under = isnan(l->low) ? 0 : fmax(0, l->low - values[i]);
        const double over = isnan(l->high) ? 0 : fmax(0, values[i] - l->high);
        r->report->violation[i] = fmax(r->report->violation[i], fmax(under, over));
        r->report->violated[i] += under + over > 0;
    }
}

/* How inputs move, by the last samples' ones. */
static void judge_changes(running *r)
{
    const control_loop *loop = r->x;
    const control_settings *c = &loop->control;
    loop_report *report = r->report;
    for (int i = 0; i < loop->input_count; i++) {
        const double at = r->applied[loop->inputs[i]] / (c->high[i] - c->low[i]);
        const double change = at - r->before[i], turn = change - r->change[i];
        report->change[0] += r->k > 0 ? fabs(change) / loop->input_count : 0;
        report->change[1] = r->k > 0 ? fmax(report->change[1], fabs(change)) : 0;
        report->jitter += r->k > 1 ? 0.5 * fabs(turn) / loop->input_count : 0;
        r->before[i] = at;
        r->change[i] = change;
    }
}

static void judge(running *r)
{
    const control_loop *loop = r->x;
    const control_settings *c = &loop->control;
    loop_report *report = r->report;
    double off = 0;
    bool saturated = false;
    for (int k = 0; k < 3; k++) {
        off += pow(r->place[k] - r->reference[k], 2);
    }
    off = sqrt(off);
    if (r->t < c->task.approach - 1e-9 * loop->period) {
        report->approach = fmax(report->approach, off);
    } else {
        report->rms += off * off;
        report->worst = fmax(report->worst, off);
        report->judged++;
    }
    report->diverged = report->diverged || !(off < scene_length(loop->of.nominal));
    for (int i = 0; i < loop->input_count; i++) {
        const double at = r->applied[loop->inputs[i]], near = 1e-9 * (c->high[i] - c->low[i]);
        saturated = saturated || at < c->low[i] + near || at > c->high[i] - near;
    }
    report->saturated += saturated;
    judge_changes(r);
    for (int i = 0; i < LOOP_FLAGS; i++) {
        report->filter_flags[i] += r->flags[0] >> i & 1;
        report->control_flags[i] += r->flags[1] >> i & 1;
    }
}

/* Whether the innovations are those of a model that is right. */
static void judge_innovations(running *r)
{
    const control_loop *loop = r->x;
    const estimator *filtered = regulator_estimator(loop->both);
    for (int i = 0; i < loop->control.measurement_count; i++) {
        const estimator_consistency now = estimator_sensor_now(filtered, i);
        const bool whole = now.count == loop->settings.estimator.window || now.used > now.count;
        if (!whole || now.used == r->used[i]) {
            continue;
        }
        r->windows[i]++;
        r->beyond[i][LOOP_SQUARE] += now.mean > now.high;
        r->beyond[i][LOOP_BIAS] += now.bias > now.bias_high;
        r->beyond[i][LOOP_CORRELATION] += fabs(now.correlation) > now.correlation_high;
    }
}

static void put(const running *r, int *column, int count, const double *values)
{
    const control_loop *loop = r->x;
    for (int i = 0; i < count; i++) {
        loop->record[(size_t)(*column)++ * (size_t)loop->samples + (size_t)r->k] = values[i];
    }
}

static ad_status write_down(running *r, ad_error *error)
{
    const control_loop *loop = r->x;
    const control_settings *c = &loop->control;
    const double seconds[4] = {r->seconds[0], r->seconds[1], r->flags[0], r->flags[1]};
    double limited[CONTROL_LIMITS_MAX];
    int at = 0;
    judge_innovations(r); /* before used changes */
    put(r, &at, 1, &r->t);
    put(r, &at, 3, r->reference);
    put(r, &at, 3, r->place);
    put(r, &at, 3, r->estimated);
    for (int i = 0; i < loop->input_count; i++) {
        put(r, &at, 1, &r->applied[loop->inputs[i]]);
    }
    for (int i = 0; i < c->estimate_count; i++) {
        const double known[2] = {estimator_parameter_now(regulator_estimator(loop->both), i),
                                 estimator_parameter_deviation(regulator_estimator(loop->both), i)};
        put(r, &at, 2, known);
    }
    for (int i = 0; i < c->measurement_count; i++) {
        const taken *now = &r->on_way[i][r->k % DELAYS];
        const double nothing[4] = {NAN, NAN, NAN, NAN};
        const int count = c->measurements[i].what == OBSERVATION_ROTATION ? 4 : 3;
        const estimator_consistency said = estimator_sensor_now(regulator_estimator(loop->both), i);
        const double last = said.used > r->used[i] ? said.last : NAN;
        r->innovations[i] += said.used > r->used[i] ? last : 0;
        r->used[i] = said.used;
        put(r, &at, count, now->lost ? nothing : now->values);
        put(r, &at, 1, &last);
    }
    for (int i = 0; i < c->estimate_count; i++) {
        put(r, &at, 1, &loop->of.truth[loop->parameter[i].input]);
    }
    const ad_status status = plant_limited(loop->robot, limited, error);
    judge_constraints(r, limited);
    put(r, &at, c->limit_count, limited);
    put(r, &at, 4, seconds);
    return status;
}

static ad_status sample(running *r, ad_error *error)
{
    control_loop *loop = r->x;
    r->t = r->k * loop->period;
    task_path_at(loop->path, r->t, r->reference);
    ad_status status = plant_place(loop->robot, r->place, error);
    status = status == AD_OK ? take_measurements(r, error) : status;
    if (status != AD_OK) {
        return status;
    }
    filter(r);
    const estimator *filtered = regulator_estimator(loop->both);
    const one_observation seen = observation_of(loop->observations[0]);
    if (seen.see(seen.context, 1, estimator_state(filtered), estimator_inputs(filtered),
                 r->estimated, NULL) != 0) {
        r->estimated[0] = r->estimated[1] = r->estimated[2] = NAN;
    }
    status = loop_shapes_take(loop, r->k, error);
    if (status != AD_OK) {
        return status;
    }
    control(r);
    if (loop->control.delay == 0) {
        apply(r);
    }
    judge(r);
    status = write_down(r, error);
    status = status == AD_OK ? plant_step(loop->robot, loop->period, r->applied, error) : status;
    apply(r);
    return status;
}

/* ---- all samples --------------------------------------------------------------------------- */

/* Median and worst of `first`, and of its sum with `second` (or NULL). */
static void times(const double *first, const double *second, long count, double *room,
                  double result[2])
{
    for (long i = 0; i < count; i++) {
        room[i] = first[i] + (second ? second[i] : 0);
    }
    sort_ascending((size_t)count, room);
    result[0] = count > 0 ? room[count / 2] : NAN;
    result[1] = count > 0 ? room[count - 1] : NAN;
}

static void conclude(running *r, double *room)
{
    const control_loop *loop = r->x;
    const control_settings *c = &loop->control;
    loop_report *report = r->report;
    const double *filtered = loop_column(loop, loop->columns - 4);
    const double *controlled = loop_column(loop, loop->columns - 3);
    report->rms = sqrt(report->rms / (double)report->judged);
    report->doubt = estimator_doubt(regulator_estimator(loop->both));
    report->residual = residual_reached(loop->beyond);
    report->saturated /= (double)report->done;
    report->change[0] /= fmax(1, (double)report->done - 1);
    report->jitter /= fmax(1, (double)report->done - 2);
    times(filtered, NULL, report->done, room, report->filter);
    times(controlled, NULL, report->done, room, report->control);
    times(filtered, controlled, report->done, room, report->both);
    for (int i = 0; i < c->limit_count; i++) {
        report->violated[i] /= (double)report->done;
    }
    for (int i = 0; i < c->measurement_count; i++) {
        report->innovation[i] = r->innovations[i] / (double)r->used[i];
        for (int k = 0; k < LOOP_BOUNDS && r->windows[i] > 0; k++) {
            const double part = (double)r->beyond[i][k] / (double)r->windows[i];
            report->beyond[k] = fmax(report->beyond[k], part);
        }
    }
    for (int i = 0; i < c->estimate_count; i++) {
        report->estimate[i] = estimator_parameter_now(regulator_estimator(loop->both), i);
        report->deviation[i] = estimator_parameter_deviation(regulator_estimator(loop->both), i);
        report->truth[i] = loop->of.truth[loop->parameter[i].input];
    }
}

/* The same inputs once more, for a robot of one mode more of each: the place that is called true is
 * as far off that of the rod. */
static ad_status judge_modes(running *r, ad_error *error)
{
    control_loop *loop = r->x;
    loop_report *report = r->report;
    control_settings more = loop->control;
    plant *finer = NULL;
    double inputs[SCENE_PARAMETERS_MAX], place[3], sum = 0;
    long k = 0;
    for (int i = 0; i < 4; i++) {
        more.plant_modes[i]++;
    }
    ad_status status =
        plant_create(loop->of.plant, loop->of.nominal, &more, loop->of.around, &finer, error);
    memcpy(inputs, loop->middle, sizeof inputs);
    status = status == AD_OK ? plant_start(finer, inputs, 0, error) : status;
    status = status == AD_OK ? plant_divide(finer, loop->control.duration, error) : status;
    for (; k < report->done && status == AD_OK; k++) {
        double off = 0;
        status = plant_place(finer, place, error);
        for (int i = 0; i < 3; i++) {
            off += pow(place[i] - loop_column(loop, LOOP_TRUE_PLACE + i)[k], 2);
        }
        for (int i = 0; i < loop->input_count; i++) {
            inputs[loop->inputs[i]] = loop_column(loop, LOOP_INPUTS + i)[k];
        }
        sum += off;
        report->modes_worst = fmax(report->modes_worst, sqrt(off));
        status = status == AD_OK ? plant_step(finer, loop->period, inputs, error) : status;
    }
    plant_free(finer);
    if (status == AD_NOT_FINITE) {
        report->modes_worst = NAN;
        return AD_OK;
    }
    report->modes = sqrt(sum / (double)k);
    return status;
}

ad_status loop_run(control_loop *loop, loop_report *report, ad_error *error)
{
    const size_t rows = (size_t)loop->control.horizon * LOOP_SEEN;
    running *r = calloc(1, sizeof *r);
    double *room = calloc(rows + (size_t)loop->samples, sizeof *room);
    ad_status status = r && room ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    memset(report, 0, sizeof *report);
    report->samples = loop->samples;
    report->reach = loop->reach.rms;
    report->reach_worst = loop->reach.worst;
    if (status == AD_OK) {
        *r = (running){.x = loop, .report = report, .rows = room};
        memcpy(r->applied, loop->middle, sizeof r->applied);
        for (int i = 0; i < loop->input_count; i++) {
            r->next[i] = loop->middle[loop->inputs[i]];
        }
    }
    while (status == AD_OK && r->k < loop->samples && !report->diverged) {
        status = sample(r, error);
        report->done += status == AD_OK;
        r->k++;
    }
    if (status == AD_NOT_FINITE) {
        report->diverged = true;
        status = AD_OK;
    }
    report->modes = report->modes_worst = NAN;
    if (status == AD_OK) {
        conclude(r, room + rows);
        status = report->diverged ? AD_OK : judge_modes(r, error);
    }
    free(r);
    free(room);
    return status;
}
