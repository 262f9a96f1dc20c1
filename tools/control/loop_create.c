#include "tools/control/loop_internal.h"

#include "tools/surrogate/excite.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- models -------------------------------------------------------------------------------- */

static ad_status create_models(control_loop *x, ad_error *error)
{
    const loop_setup *of = &x->of;
    const int *modes = of->model->modes;
    const reduced_settings settings = {.modes = {modes[0], modes[1], modes[2], modes[3]}};
    ad_status status = reduced_create(of->nominal, &settings, &x->rod, error);
    if (status != AD_OK) {
        return status;
    }
    x->states = reduced_states(x->rod);
    x->parameters = reduced_inputs(x->rod);
    x->by_step = reduced_one_step(x->rod, x->step);
    if (x->control.model == CONTROL_SURROGATE) {
        x->by_step = *of->surrogate;
    }
    if (x->control.residual && x->control.model != CONTROL_LINEAR) {
        status = residual_read(x->control.residual, &x->by_step, &x->beyond, error);
        if (status != AD_OK) {
            return status;
        }
        x->by_step = residual_one_step(x->beyond);
    }
    x->by_period = x->by_step;
    if (x->control.model == CONTROL_SURROGATE && of->inner) {
        x->by_period = *of->inner;
    }
    const bool whole = fabs(x->by_period.step - x->period) <= 1e-9 * x->period;
    if (!whole && !x->by_period.shorter) {
        return ad_fail(error, AD_BAD_INPUT,
                       "control.period: %g s, and the trained model has steps of %g s alone; "
                       "allowed: that, an inner model of the period, a kind with shorter "
                       "steps, or control.model: reduced",
                       x->period, x->by_period.step);
    }
    x->by_period.step = x->period;
    if (x->by_period.states != x->states || x->by_step.states != x->states ||
        x->by_step.inputs != x->parameters) {
        return ad_fail(error, AD_BAD_INPUT,
                       "the trained model has %d states and %d inputs, the scene %d and %d",
                       x->by_step.states, x->by_step.inputs, x->states, x->parameters);
    }
    return AD_OK;
}

/* Of the reduced rod where it rests at the start. */
static ad_status linearise(control_loop *x, ad_error *error)
{
    const double lengths[2] = {x->period, x->step};
    one_step *const models[2] = {&x->by_period, &x->by_step};
    const one_step rod = reduced_one_step(x->rod, x->step);
    ad_status status = AD_OK;
    for (int i = 0; i < 2 && status == AD_OK && x->control.model == CONTROL_LINEAR; i++) {
        status = linear_step_create(&rod, lengths[i], x->numbers, x->middle, &x->linear[i], error);
        if (status == AD_OK) {
            *models[i] = linear_one_step(x->linear[i]);
        }
    }
    return status;
}

/* Of every state in motions of the model over the ranges of its inputs, rms. */
static ad_status find_sizes(const control_loop *x, double *size, ad_error *error)
{
    const scene *nominal = x->of.nominal;
    excite_settings settings = excite_settings_default();
    excite_rollouts motions = {0};
    memcpy(settings.modes, x->of.model->modes, sizeof settings.modes);
    settings.step = x->step;
    settings.steps = 40;
    settings.count = 6;
    for (int k = 0; k < nominal->parameter_count; k++) {
        const control_role role =
            control_role_of(&x->control, x->of.model, nominal->parameters[k].name);
        settings.constant |= role == CONTROL_INPUT ? 0 : 1U << k;
    }
    ad_pool *pool = ad_pool_create(1);
    ad_status status = pool ? excite_run(nominal, &settings, pool, &motions, error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    ad_pool_free(pool);
    const size_t n = (size_t)x->states;
    for (size_t k = 0; k < n && status == AD_OK; k++) {
        double sum = 0, count = 0;
        for (int r = 0; r < motions.count; r++) {
            for (int i = 0; i <= motions.done[r]; i++) {
                const double value =
                    motions.state[((size_t)r * ((size_t)motions.steps + 1) + (size_t)i) * n + k];
                sum += value * value;
                count++;
            }
        }
        size[k] = sqrt(sum / count);
    }
    excite_free(&motions);
    return status;
}

/* Deviations and process noise of the filter. */
static ad_status fill_numbers(control_loop *x, ad_error *error)
{
    const size_t n = (size_t)x->states;
    double *size = x->numbers + 3 * n;
    const ad_status status = find_sizes(x, size, error);
    if (status == AD_OK) {
        look_noise(x->states / 2, size, x->numbers + n, x->numbers + 2 * n);
    }
    return status;
}

/* ---- what is seen -------------------------------------------------------------------------- */

static ad_status see(const control_loop *x, look_what what, double at, look **result,
                     ad_error *error)
{
    const look_sensor sensor = {.what = what, .count = 1, .s = &at};
    return look_create(x->of.nominal, x->of.model->modes, &sensor, result, error);
}

static ad_status create_looks(control_loop *x, ad_error *error)
{
    const control_settings *c = &x->control;
    view *seen = &x->seen;
    ad_status status = AD_OK;
    x->values = 3 + c->limit_count;
    seen->inputs = x->parameters;
    for (int i = 0; i <= c->limit_count && status == AD_OK; i++) {
        const control_limit *l = i > 0 ? &c->limits[i - 1] : NULL;
        status = see(x, l ? l->what : LOOK_POSITION, l ? l->at : c->track_at, &x->looks[i], error);
        if (status == AD_OK) {
            seen->part[i] =
                (struct view_part){look_of(x->looks[i]), l ? l->axis - 1 : 0, l ? 1 : 3};
            seen->parts++;
        }
    }
    if (status == AD_OK) {
        seen->room = calloc(view_room(seen), sizeof *seen->room);
        status = seen->room ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    }
    for (int i = 0; i < c->measurement_count && status == AD_OK; i++) {
        const control_measurement *m = &c->measurements[i];
        status = see(x, m->what, m->at, &x->sensors[i], error);
        if (status == AD_OK) {
            for (int k = 0; k < 4; k++) {
                x->noise[i][k] = m->noise;
            }
            x->sensor[i] = (estimator_sensor){.look = look_of(x->sensors[i]),
                                              .rotations = m->what == LOOK_ROTATION,
                                              .noise = x->noise[i],
                                              .every = m->every,
                                              .delay = m->delay,
                                              .depends = look_depends_on(x->sensors[i])};
        }
    }
    return status;
}

/* ---- filter and controllers ---------------------------------------------------------------- */

static void fill_filter(control_loop *x)
{
    const control_settings *c = &x->control;
    const scene *nominal = x->of.nominal;
    const size_t n = (size_t)x->states;
    for (int i = 0; i < c->estimate_count; i++) {
        for (int k = 0; k < nominal->parameter_count; k++) {
            const scene_parameter *p = &nominal->parameters[k];
            if (strcmp(p->name, c->estimate[i]) == 0) {
                x->parameter[i] = (estimator_parameter){
                    .input = k, .low = p->low, .high = p->high, .walk = c->walk[i]};
            }
        }
    }
    x->settings.estimator = (estimator_settings){.model = x->by_period,
                                                 .parameters = c->estimate_count,
                                                 .sensors = c->measurement_count,
                                                 .parameter = x->parameter,
                                                 .sensor = x->sensor,
                                                 .deviation = x->numbers + n,
                                                 .process = x->numbers + 2 * n};
}

/* One in the unit of what is seen, as large as control->accuracy of the place. */
static double accuracy_of(const control_loop *x, look_what what)
{
    const double a = x->control.accuracy, length = scene_length(x->of.nominal);
    return what == LOOK_POSITION           ? a
           : what == LOOK_VELOCITY         ? a / x->step
           : what == LOOK_CURVATURE        ? a / (length * length)
           : what == LOOK_ANGULAR_VELOCITY ? a / (length * x->step)
                                           : a / length;
}

/* What the controllers borrow. */
static void fill_plan(control_loop *x)
{
    enum { FIRM = 10 }; /* a constraint costs so many times as much as the place */
    const control_settings *c = &x->control;
    for (int i = 0; i < x->input_count; i++) {
        x->plan.rate[i] = c->rate[i] * x->step;
        x->plan.turns[i] = c->rate[i] * x->period;
        x->plan.rest[i] = x->middle[x->inputs[i]];
        x->plan.smooth[i] = c->weight_rate;
        x->plan.effort[i] = c->weight_effort;
    }
    for (int i = 0; i < x->values; i++) {
        const control_limit *l = i < 3 ? NULL : &c->limits[i - 3];
        x->plan.weight[i] = l ? 0 : 1 / (c->accuracy * c->accuracy);
        x->plan.low[i] = l && !isnan(l->low) ? l->low : -INFINITY;
        x->plan.high[i] = l && !isnan(l->high) ? l->high : INFINITY;
        x->plan.soft[i] = l ? FIRM / pow(accuracy_of(x, l->what), 2) : 1;
    }
}

static void fill_controller(control_loop *x)
{
    const control_settings *c = &x->control;
    fill_plan(x);
    x->settings.controller = (controller_settings){.model = x->by_step,
                                                   .look = view_of(&x->seen),
                                                   .horizon = c->horizon,
                                                   .delay = x->ratio == 1 ? c->delay : 0,
                                                   .controlled = x->input_count,
                                                   .inputs = x->inputs,
                                                   .others = x->middle,
                                                   .lower = c->low,
                                                   .upper = c->high,
                                                   .rate = x->plan.rate,
                                                   .rest = x->plan.rest,
                                                   .smooth = x->plan.smooth,
                                                   .effort = x->plan.effort,
                                                   .weight = x->plan.weight,
                                                   .soft_lower = x->plan.low,
                                                   .soft_upper = x->plan.high,
                                                   .soft_weight = x->plan.soft,
                                                   .offset = c->offset};
}

static ad_status create_regulator(control_loop *x, ad_error *error)
{
    int which[CONTROL_INPUTS_MAX];
    double *by = x->numbers + 4 * (size_t)x->states;
    fill_filter(x);
    fill_controller(x);
    x->settings.turns = x->ratio;
    x->settings.delay = x->control.delay;
    x->settings.rate = x->ratio > 1 ? x->plan.turns : NULL;
    const char *refused = regulator_refusal(&x->settings);
    if (refused) {
        return ad_fail(error, AD_BAD_INPUT, "control: filter or controller refuse: %s", refused);
    }
    void *memory = malloc(regulator_size(&x->settings));
    if (!memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for filter and controller");
    }
    x->both = regulator_init(memory, &x->settings);
    for (int i = 0; i < x->control.estimate_count; i++) {
        which[i] = x->parameter[i].input;
    }
    const ad_status status = resting_derivatives(x->rest, x->middle, x->numbers,
                                                 x->control.estimate_count, which, by, error);
    if (status == AD_OK) {
        regulator_start(x->both, x->numbers, x->middle, by);
    }
    return status;
}

/* ---- the record ---------------------------------------------------------------------------- */

static void name(control_loop *x, const char *format, const char *of, int k)
{
    snprintf(x->names[x->columns++], LOOP_NAME, format, of, "xyz"[k]);
}

static ad_status create_record(control_loop *x, ad_error *error)
{
    static const char *const places[] = {"reference", "true", "estimated"};
    const control_settings *c = &x->control;
    snprintf(x->names[x->columns++], LOOP_NAME, "t");
    for (int i = 0; i < 9; i++) {
        name(x, "%s_%c", places[i / 3], i % 3);
    }
    for (int i = 0; i < x->input_count; i++) {
        name(x, "input_%.50s", x->of.nominal->parameters[x->inputs[i]].name, 0);
    }
    for (int i = 0; i < c->estimate_count; i++) {
        name(x, "estimate_%.50s", c->estimate[i], 0);
        name(x, "deviation_%.50s", c->estimate[i], 0);
    }
    for (int i = 0; i < c->measurement_count; i++) {
        for (int k = 0; k < (c->measurements[i].what == LOOK_ROTATION ? 4 : 3); k++) {
            snprintf(x->names[x->columns++], LOOP_NAME, "measured%d_%d", i, k);
        }
        snprintf(x->names[x->columns++], LOOP_NAME, "innovation%d", i);
    }
    for (int i = 0; i < c->estimate_count; i++) {
        name(x, "truth_%.50s", c->estimate[i], 0);
    }
    for (int i = 0; i < c->limit_count; i++) {
        snprintf(x->names[x->columns++], LOOP_NAME, "constraint%d", i);
    }
    static const char *const last[] = {"filter_seconds", "control_seconds", "filter_flags",
                                       "control_flags"};
    for (int i = 0; i < 4; i++) {
        name(x, "%s", last[i], 0);
    }
    x->samples = (long)floor(c->duration / x->period + 1e-9) + 1;
    x->record = calloc((size_t)x->samples * (size_t)x->columns, sizeof *x->record);
    return x->record ? loop_shapes_create(x, error)
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for a record");
}

/* ---- all of it ----------------------------------------------------------------------------- */

static ad_status begin(control_loop *x, ad_error *error)
{
    const control_settings *c = &x->control;
    const scene *nominal = x->of.nominal;
    const double ratio = x->step / x->period;
    x->ratio = (int)fmax(1, round(ratio));
    if (fabs(ratio - x->ratio) > 1e-6 * ratio || x->ratio > 1000) {
        return ad_fail(error, AD_BAD_INPUT,
                       "control.period: %g s; allowed: a step of the model, %g s, or a part of it "
                       "that fits in a whole number of times, up to 1000",
                       x->period, x->step);
    }
    for (int k = 0; k < nominal->parameter_count; k++) {
        const char *of = nominal->parameters[k].name;
        if (control_role_of(c, x->of.model, of) == CONTROL_INPUT) {
            x->inputs[x->input_count++] = k;
        }
    }
    return resting_create(nominal, x->of.model, c, &x->rest, error);
}

static ad_status rest(control_loop *x, ad_error *error)
{
    const size_t n = (size_t)x->states;
    x->numbers = calloc(n * (4 + (size_t)x->control.estimate_count) + 1, sizeof *x->numbers);
    if (!x->numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    }
    resting_middle(x->rest, x->middle);
    ad_status status = resting_settle(x->rest, x->middle, x->numbers, error);
    status = status == AD_OK ? linearise(x, error) : status;
    status = status == AD_OK ? fill_numbers(x, error) : status;
    return status == AD_OK ? resting_place_task(x->rest, &x->control.task, &x->reach, error)
                           : status;
}

/* Where the robot starts, and the path from there. */
static ad_status lay_path(control_loop *x, ad_error *error)
{
    double start[3], inputs[SCENE_PARAMETERS_MAX];
    control_settings *c = &x->control;
    memcpy(inputs, x->middle, sizeof inputs);
    ad_status status = plant_start(x->robot, inputs, (uint64_t)c->seed, error);
    status = status == AD_OK ? plant_place(x->robot, start, error) : status;
    status = status == AD_OK ? task_path_create(&c->task, start, &x->path, error) : status;
    if (status == AD_OK && isnan(c->duration)) {
        const double end = task_path_end(x->path);
        c->duration = end > 0 ? end : c->task.approach + 5;
    }
    if (status == AD_OK &&
        floor(c->duration / x->period + 1e-9) * x->period < c->task.approach - 1e-9 * x->period) {
        return ad_fail(error, AD_BAD_INPUT,
                       "control.duration: %g s, and errors are told after control.task.approach, "
                       "%g s; allowed: at least so long",
                       c->duration, c->task.approach);
    }
    return status == AD_OK ? plant_divide(x->robot, c->duration, error) : status;
}

ad_status loop_create(const loop_setup *setup, control_loop **result, ad_error *error)
{
    static ad_status (*const parts[])(control_loop * x, ad_error * error) = {
        begin, create_models, rest, create_looks, create_regulator};
    control_loop *x = calloc(1, sizeof *x);
    *result = NULL;
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    }
    x->of = *setup;
    x->control = *setup->control;
    x->step = setup->model->step;
    x->period = x->control.period;
    ad_status status = AD_OK;
    for (size_t i = 0; i < sizeof parts / sizeof *parts && status == AD_OK; i++) {
        status = parts[i](x, error);
    }
    status = status == AD_OK
                 ? plant_create(setup->plant, setup->nominal, &x->control, &x->robot, error)
                 : status;
    status = status == AD_OK ? lay_path(x, error) : status;
    status = status == AD_OK ? create_record(x, error) : status;
    if (status != AD_OK) {
        loop_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void loop_free(control_loop *x)
{
    if (!x) {
        return;
    }
    for (int i = 0; i <= CONTROL_LIMITS_MAX; i++) {
        look_free(x->looks[i]);
    }
    for (int i = 0; i < CONTROL_MEASUREMENTS_MAX; i++) {
        look_free(x->sensors[i]);
    }
    linear_step_free(x->linear[0]);
    linear_step_free(x->linear[1]);
    residual_free(x->beyond);
    reduced_free(x->rod);
    resting_free(x->rest);
    plant_free(x->robot);
    task_path_free(x->path);
    free(x->both);
    free(x->seen.room);
    free(x->numbers);
    free(x->record);
    loop_shapes_free(x);
    free(x);
}

const control_task *loop_task(const control_loop *x)
{
    return &x->control.task;
}

int loop_columns(const control_loop *x)
{
    return x->columns;
}

const char *loop_column_name(const control_loop *x, int i)
{
    return x->names[i];
}

const double *loop_column(const control_loop *x, int i)
{
    return x->record + (size_t)i * (size_t)x->samples;
}

loop_parts loop_parts_of(const control_loop *x)
{
    loop_parts parts = {.settings = &x->settings,
                        .linear = {x->linear[0], x->linear[1]},
                        .seen = &x->seen,
                        .state = x->numbers,
                        .inputs = x->middle,
                        .by_parameters = x->numbers + 4 * (size_t)x->states};
    for (int i = 0; i < x->control.measurement_count; i++) {
        parts.sensors[i] = look_kinematics(x->sensors[i]);
    }
    for (int i = 0; i < x->seen.parts; i++) {
        parts.looks[i] = look_kinematics(x->looks[i]);
    }
    return parts;
}
