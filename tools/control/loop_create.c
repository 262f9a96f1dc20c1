#include "tools/control/loop_internal.h"

#include "tools/surrogate/excitation.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- models -------------------------------------------------------------------------------- */

static ad_status create_models(control_loop *loop, ad_error *error)
{
    const loop_setup *of = &loop->of;
    const int *modes = of->model->modes;
    const reduced_settings settings = {.modes = {modes[0], modes[1], modes[2], modes[3]}};
    ad_status status = reduced_create(of->nominal, &settings, &loop->rod, error);
    if (status != AD_OK) {
        return status;
    }
    loop->states = reduced_all_states(loop->rod);
    loop->parameters = reduced_inputs(loop->rod);
    loop->by_step = reduced_one_step(loop->rod, loop->step);
    if (loop->control.model == CONTROL_SURROGATE) {
        loop->by_step = *of->surrogate;
    }
    if (loop->control.residual && loop->control.model != CONTROL_LINEAR) {
        status = residual_read(loop->control.residual, &loop->by_step, of->nominal->parameters,
                               &loop->beyond, error);
        if (status != AD_OK) {
            return status;
        }
        loop->by_step = residual_one_step(loop->beyond);
    }
    loop->by_period = loop->by_step;
    if (loop->control.model == CONTROL_SURROGATE && of->inner) {
        loop->by_period = *of->inner;
    }
    const bool whole = fabs(loop->by_period.step - loop->period) <= 1e-9 * loop->period;
    if (!whole && !loop->by_period.shorter) {
        return ad_fail(error, AD_BAD_INPUT,
                       "control.period: %g s, and the trained model has steps of %g s alone; "
                       "allowed: that, an inner model of the period, a kind with shorter "
                       "steps, or control.model: reduced",
                       loop->period, loop->by_period.step);
    }
    loop->by_period.step = loop->period;
    if (loop->by_period.states != loop->states || loop->by_step.states != loop->states ||
        loop->by_step.inputs != loop->parameters) {
        return ad_fail(error, AD_BAD_INPUT,
                       "the trained model has %d states and %d inputs, the scene %d and %d",
                       loop->by_step.states, loop->by_step.inputs, loop->states, loop->parameters);
    }
    return AD_OK;
}

/* Of the reduced rod where it rests at the start. */
static ad_status linearise(control_loop *loop, ad_error *error)
{
    const double lengths[2] = {loop->period, loop->step};
    one_step *const models[2] = {&loop->by_period, &loop->by_step};
    const one_step rod = reduced_one_step(loop->rod, loop->step);
    ad_status status = AD_OK;
    for (int i = 0; i < 2 && status == AD_OK && loop->control.model == CONTROL_LINEAR; i++) {
        status = linear_step_create(&rod, lengths[i], loop->numbers, loop->middle, &loop->linear[i],
                                    error);
        if (status == AD_OK) {
            *models[i] = linear_one_step(loop->linear[i]);
        }
    }
    return status;
}

/* Of every state in motions of the model over the ranges of its inputs, rms. */
static ad_status find_sizes(const control_loop *loop, double *size, ad_error *error)
{
    const scene *nominal = loop->of.nominal;
    excitation_settings settings = excitation_settings_default();
    excitation_rollouts motions = {0};
    memcpy(settings.modes, loop->of.model->modes, sizeof settings.modes);
    settings.step = loop->step;
    settings.steps = 40;
    settings.count = 6;
    for (int k = 0; k < nominal->parameter_count; k++) {
        const control_role role =
            control_role_of(&loop->control, loop->of.model, nominal->parameters[k].name);
        settings.constant |= role == CONTROL_INPUT ? 0 : 1U << k;
    }
    ad_pool *pool = ad_pool_create(1);
    ad_status status = pool ? excitation_run(nominal, &settings, pool, &motions, error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    ad_pool_free(pool);
    const size_t n = (size_t)reduced_states(loop->rod);
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
    excitation_free(&motions);
    return status;
}

void loop_fill_noise(control_loop *loop)
{
    const size_t n = (size_t)loop->states, moving = (size_t)reduced_states(loop->rod);
    const size_t modes = (size_t)reduced_modes(loop->rod);
    double *size = loop->numbers + 3 * n, *deviation = loop->numbers + n, *process = deviation + n;
    observation_noise((int)modes, size, deviation, process);
    for (size_t k = 2 * modes; k < moving; k++) { /* not seen, but for what it does to the modes */
        deviation[k] = fmax(0.1 * size[k], 1e-6 * deviation[0]);
        process[k] = 0.01 * deviation[k];
    }
    for (size_t k = moving; k < n; k++) { /* known but for where it began */
        const scene_parameter *p =
            reduced_input(loop->rod, scene_given_count(loop->of.nominal) + (int)(k - moving));
        deviation[k] = 1e-3 * (p->high - p->low);
        process[k] = 1e-6 * (p->high - p->low);
    }
}

/* Deviations and process noise of the filter. */
static ad_status fill_numbers(control_loop *loop, ad_error *error)
{
    const size_t n = (size_t)loop->states;
    double *size = loop->numbers + 3 * n;
    const ad_status status = find_sizes(loop, size, error);
    if (status == AD_OK) {
        loop_fill_noise(loop);
    }
    return status;
}

/* ---- what is seen -------------------------------------------------------------------------- */

static ad_status see(const control_loop *loop, observation_what what, double at,
                     observation **result, ad_error *error)
{
    const observation_sensor sensor = {.what = what, .count = 1, .s = &at};
    return observation_create(loop->of.nominal, loop->of.model->modes, &sensor, result, error);
}

/* What is constrained at places along the rod, as one number. */
static ad_status see_clearance(control_loop *loop, int part, ad_error *error)
{
    enum { PLACES = 12 };
    const scene *nominal = loop->of.nominal;
    const control_limit *l = &loop->control.limits[part - 1];
    clearance_observation *x = &loop->clearance;
    const double length = scene_length(nominal);
    double s[PLACES];
    for (int i = 0; i < PLACES; i++) {
        s[i] = length * (i + 1) / PLACES;
    }
    const observation_sensor sensor = {.what = OBSERVATION_POSITION, .count = PLACES, .s = s};
    const ad_status status = observation_create(nominal, loop->of.model->modes, &sensor,
                                                &loop->observations[part], error);
    if (status != AD_OK) {
        return status;
    }
    *x = (clearance_observation){.places = observation_of(loop->observations[part]),
                                 .surface = loop->of.around->surface,
                                 .radius = loop->control.radius,
                                 .smooth = fmax(l->low / 10, 1e-3 * length)};
    x->room = calloc(clearance_observation_room(&x->places), sizeof *x->room);
    loop->clearance_part = part;
    return x->room ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
}

static ad_status create_looks(control_loop *loop, ad_error *error)
{
    const control_settings *c = &loop->control;
    task_observation *seen = &loop->seen;
    ad_status status = AD_OK;
    loop->values = 3 + c->limit_count;
    seen->inputs = loop->parameters;
    for (int i = 0; i <= c->limit_count && status == AD_OK; i++) {
        const control_limit *l = i > 0 ? &c->limits[i - 1] : NULL;
        const bool clear = l && l->what == CONTROL_CLEARANCE;
        status = clear ? see_clearance(loop, i, error)
                       : see(loop, l ? (observation_what)l->what : OBSERVATION_POSITION,
                             l ? l->at : c->track_at, &loop->observations[i], error);
        if (status == AD_OK && clear) {
            seen->part[seen->parts++] =
                (struct task_observation_part){clearance_observation_of(&loop->clearance), 0, 1};
        } else if (status == AD_OK) {
            seen->part[i] = (struct task_observation_part){observation_of(loop->observations[i]),
                                                           l ? l->axis - 1 : 0, l ? 1 : 3};
            seen->parts++;
        }
    }
    if (status == AD_OK) {
        seen->room = calloc(task_observation_room(seen), sizeof *seen->room);
        status = seen->room ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    }
    for (int i = 0; i < c->measurement_count && status == AD_OK; i++) {
        const control_measurement *m = &c->measurements[i];
        status = see(loop, m->what, m->at, &loop->sensors[i], error);
        if (status == AD_OK) {
            for (int k = 0; k < 4; k++) {
                loop->noise[i][k] = m->noise;
            }
            loop->sensor[i] =
                (estimator_sensor){.observation = observation_of(loop->sensors[i]),
                                   .rotations = m->what == OBSERVATION_ROTATION,
                                   .noise = loop->noise[i],
                                   .every = m->every,
                                   .delay = m->delay,
                                   .depends = observation_depends_on(loop->sensors[i])};
        }
    }
    return status;
}

/* ---- filter and controllers ---------------------------------------------------------------- */

static ad_status fill_filter(control_loop *loop, ad_error *error)
{
    (void)error;
    const control_settings *c = &loop->control;
    const scene *nominal = loop->of.nominal;
    const size_t n = (size_t)loop->states;
    for (int i = 0; i < c->estimate_count; i++) {
        for (int k = 0; k < nominal->parameter_count; k++) {
            const scene_parameter *p = &nominal->parameters[k];
            if (strcmp(p->name, c->estimate[i]) == 0) {
                loop->parameter[i] = (estimator_parameter){
                    .input = k, .low = p->low, .high = p->high, .walk = c->walk[i]};
            }
        }
    }
    loop->settings.estimator = (estimator_settings){.model = loop->by_period,
                                                    .parameters = c->estimate_count,
                                                    .sensors = c->measurement_count,
                                                    .parameter = loop->parameter,
                                                    .sensor = loop->sensor,
                                                    .deviation = loop->numbers + n,
                                                    .process = loop->numbers + 2 * n};
    return AD_OK;
}

/* One in the unit of what is seen, as large as control->accuracy of the place. */
static double accuracy_of(const control_loop *loop, int what)
{
    const double a = loop->control.accuracy, length = scene_length(loop->of.nominal);
    return what == OBSERVATION_POSITION || what == CONTROL_CLEARANCE ? a
           : what == OBSERVATION_VELOCITY                            ? a / loop->step
           : what == OBSERVATION_CURVATURE                           ? a / (length * length)
           : what == OBSERVATION_ANGULAR_VELOCITY                    ? a / (length * loop->step)
                                                                     : a / length;
}

/* What the controllers borrow. */
static void fill_plan(control_loop *loop)
{
    enum { FIRM = 10, HARD = 100 }; /* constraints, walls cost so many times as much as the place */
    const control_settings *c = &loop->control;
    for (int i = 0; i < loop->input_count; i++) {
        loop->plan.rate[i] = c->rate[i] * loop->step;
        loop->plan.turns[i] = c->rate[i] * loop->period;
        loop->plan.rest[i] = loop->middle[loop->inputs[i]];
        loop->plan.smooth[i] = c->weight_rate;
        loop->plan.effort[i] = c->weight_effort;
    }
    for (int i = 0; i < loop->values; i++) {
        const control_limit *l = i < 3 ? NULL : &c->limits[i - 3];
        loop->plan.weight[i] = l ? 0 : 1 / (c->accuracy * c->accuracy);
        loop->plan.low[i] = l && !isnan(l->low) ? l->low : -INFINITY;
        loop->plan.high[i] = l && !isnan(l->high) ? l->high : INFINITY;
        loop->plan.soft[i] =
            l ? (l->what == CONTROL_CLEARANCE ? HARD : FIRM) / pow(accuracy_of(loop, l->what), 2)
              : 1;
    }
}

static void fill_controller(control_loop *loop)
{
    const control_settings *c = &loop->control;
    fill_plan(loop);
    loop->settings.controller =
        (controller_settings){.model = loop->by_step,
                              .observation = task_observation_of(&loop->seen),
                              .horizon = c->horizon,
                              .delay = loop->ratio == 1 ? c->delay : 0,
                              .controlled = loop->input_count,
                              .inputs = loop->inputs,
                              .others = loop->middle,
                              .lower = c->low,
                              .upper = c->high,
                              .rate = loop->plan.rate,
                              .rest = loop->plan.rest,
                              .smooth = loop->plan.smooth,
                              .effort = loop->plan.effort,
                              .weight = loop->plan.weight,
                              .soft_lower = loop->plan.low,
                              .soft_upper = loop->plan.high,
                              .soft_weight = loop->plan.soft,
                              .offset = c->offset};
}

ad_status loop_begin(control_loop *loop, const double *inputs, ad_error *error)
{
    const size_t n = (size_t)loop->states, m = (size_t)loop->parameters;
    const int count = loop->control.estimate_count;
    double *state = loop->numbers, *by = state + 4 * n;
    int which[CONTROL_INPUTS_MAX];
    for (int i = 0; i < count; i++) {
        which[i] = loop->parameter[i].input;
    }
    double *all = loop->beyond ? malloc(n * m * sizeof *all) : NULL;
    if (loop->beyond && !all) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    }
    if (all && residual_settle(loop->beyond, loop->period, inputs, state, all)) {
        for (size_t i = 0; i < n * (size_t)count; i++) {
            by[i] = all[i / (size_t)count * m + (size_t)which[i % (size_t)count]];
        }
        free(all);
        return AD_OK;
    }
    free(all);
    return equilibria_derivatives(loop->rest, inputs, state, count, which, by, error);
}

static ad_status create_regulator(control_loop *loop, ad_error *error)
{
    fill_controller(loop);
    loop->settings.turns = loop->ratio;
    loop->settings.delay = loop->control.delay;
    loop->settings.rate = loop->ratio > 1 ? loop->plan.turns : NULL;
    const char *refused = regulator_refusal(&loop->settings);
    if (refused) {
        return ad_fail(error, AD_BAD_INPUT, "control: filter or controller refuse: %s", refused);
    }
    void *memory = malloc(regulator_size(&loop->settings));
    if (!memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for filter and controller");
    }
    loop->both = regulator_init(memory, &loop->settings);
    const ad_status status = loop_begin(loop, loop->middle, error);
    if (status == AD_OK) {
        regulator_start(loop->both, loop->numbers, loop->middle,
                        loop->numbers + 4 * (size_t)loop->states);
    }
    return status;
}

/* ---- the record ---------------------------------------------------------------------------- */

static void name(control_loop *loop, const char *format, const char *of, int k)
{
    snprintf(loop->names[loop->columns++], LOOP_NAME, format, of, "xyz"[k]);
}

static ad_status create_record(control_loop *loop, ad_error *error)
{
    static const char *const places[] = {"reference", "true", "estimated"};
    const control_settings *c = &loop->control;
    snprintf(loop->names[loop->columns++], LOOP_NAME, "t");
    for (int i = 0; i < 9; i++) {
        name(loop, "%s_%c", places[i / 3], i % 3);
    }
    for (int i = 0; i < loop->input_count; i++) {
        name(loop, "input_%.50s", loop->of.nominal->parameters[loop->inputs[i]].name, 0);
    }
    for (int i = 0; i < c->estimate_count; i++) {
        name(loop, "estimate_%.50s", c->estimate[i], 0);
        name(loop, "deviation_%.50s", c->estimate[i], 0);
    }
    for (int i = 0; i < c->measurement_count; i++) {
        for (int k = 0; k < (c->measurements[i].what == OBSERVATION_ROTATION ? 4 : 3); k++) {
            snprintf(loop->names[loop->columns++], LOOP_NAME, "measured%d_%d", i, k);
        }
        snprintf(loop->names[loop->columns++], LOOP_NAME, "innovation%d", i);
    }
    for (int i = 0; i < c->estimate_count; i++) {
        name(loop, "truth_%.50s", c->estimate[i], 0);
    }
    for (int i = 0; i < c->limit_count; i++) {
        snprintf(loop->names[loop->columns++], LOOP_NAME, "constraint%d", i);
    }
    static const char *const last[] = {"filter_seconds", "control_seconds", "filter_flags",
                                       "control_flags"};
    for (int i = 0; i < 4; i++) {
        name(loop, "%s", last[i], 0);
    }
    loop->samples = (long)floor(c->duration / loop->period + 1e-9) + 1;
    loop->record = calloc((size_t)loop->samples * (size_t)loop->columns, sizeof *loop->record);
    return loop->record ? loop_shapes_create(loop, error)
                        : ad_fail(error, AD_NO_MEMORY, "out of memory for a record");
}

/* ---- all of it ----------------------------------------------------------------------------- */

static ad_status begin(control_loop *loop, ad_error *error)
{
    const control_settings *c = &loop->control;
    const scene *nominal = loop->of.nominal;
    const double ratio = loop->step / loop->period;
    loop->ratio = (int)fmax(1, round(ratio));
    if (fabs(ratio - loop->ratio) > 1e-6 * ratio || loop->ratio > 1000) {
        return ad_fail(error, AD_BAD_INPUT,
                       "control.period: %g s; allowed: a step of the model, %g s, or a part of it "
                       "that fits in a whole number of times, up to 1000",
                       loop->period, loop->step);
    }
    for (int k = 0; k < nominal->parameter_count; k++) {
        const char *of = nominal->parameters[k].name;
        if (control_role_of(c, loop->of.model, of) == CONTROL_INPUT) {
            loop->inputs[loop->input_count++] = k;
        }
    }
    return equilibria_create(nominal, loop->of.model, c, &loop->rest, error);
}

static ad_status rest(control_loop *loop, ad_error *error)
{
    const size_t n = (size_t)loop->states;
    loop->numbers =
        calloc(n * (4 + (size_t)loop->control.estimate_count) + 1, sizeof *loop->numbers);
    if (!loop->numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    }
    equilibria_middle(loop->rest, loop->middle);
    ad_status status = equilibria_settle(loop->rest, loop->middle, loop->numbers, error);
    return status == AD_OK ? linearise(loop, error) : status;
}

/* What cannot be reached at rest pulls on the inputs until they jump from one end of their ranges
 * to the other, unless its square costs as little as the inputs do. */
static ad_status place_task(control_loop *loop, ad_error *error)
{
    const double usual = 1e-3; /* m */
    control_settings *c = &loop->control;
    const ad_status status = equilibria_place_task(loop->rest, &c->task, &loop->reach, error);
    c->accuracy = isnan(c->accuracy) ? fmax(usual, loop->reach.held) : c->accuracy;
    return status;
}

/* Where the robot starts, and the path from there. */
static ad_status lay_path(control_loop *loop, ad_error *error)
{
    double start[3], inputs[SCENE_PARAMETERS_MAX];
    control_settings *c = &loop->control;
    memcpy(inputs, loop->middle, sizeof inputs);
    ad_status status = plant_start(loop->robot, inputs, (uint64_t)c->seed, error);
    status = status == AD_OK ? plant_place(loop->robot, start, error) : status;
    status = status == AD_OK ? task_path_create(&c->task, start, &loop->path, error) : status;
    if (status == AD_OK && isnan(c->duration)) {
        const double end = task_path_end(loop->path);
        c->duration = end > 0 ? end : c->task.approach + 5;
    }
    if (status == AD_OK && floor(c->duration / loop->period + 1e-9) * loop->period <
                               c->task.approach - 1e-9 * loop->period) {
        return ad_fail(error, AD_BAD_INPUT,
                       "control.duration: %g s, and errors are told after control.task.approach, "
                       "%g s; allowed: at least so long",
                       c->duration, c->task.approach);
    }
    return status == AD_OK ? plant_divide(loop->robot, c->duration, error) : status;
}

typedef ad_status loop_part(control_loop *loop, ad_error *error);

static ad_status create(const loop_setup *setup, size_t count, loop_part *const *parts,
                        control_loop **result, ad_error *error)
{
    control_loop *loop = calloc(1, sizeof *loop);
    *result = NULL;
    if (!loop) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a loop");
    }
    loop->of = *setup;
    loop->control = *setup->control;
    loop->step = setup->model->step;
    loop->period = loop->control.period;
    ad_status status = AD_OK;
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        status = parts[i](loop, error);
    }
    if (status != AD_OK) {
        loop_free(loop);
        return status;
    }
    *result = loop;
    return AD_OK;
}

static ad_status create_plant(control_loop *loop, ad_error *error)
{
    return plant_create(loop->of.plant, loop->of.nominal, &loop->control, loop->of.around,
                        &loop->robot, error);
}

ad_status loop_create(const loop_setup *setup, control_loop **result, ad_error *error)
{
    static loop_part *const parts[] = {begin,        create_models, rest,         fill_numbers,
                                       place_task,   create_looks,  fill_filter,  create_regulator,
                                       create_plant, lay_path,      create_record};
    return create(setup, sizeof parts / sizeof *parts, parts, result, error);
}

ad_status loop_create_filter(const loop_setup *setup, control_loop **result, ad_error *error)
{
    static loop_part *const parts[] = {begin, create_models, rest, create_looks, fill_filter};
    return create(setup, sizeof parts / sizeof *parts, parts, result, error);
}

void loop_free(control_loop *loop)
{
    if (!loop) {
        return;
    }
    for (int i = 0; i <= CONTROL_LIMITS_MAX; i++) {
        observation_free(loop->observations[i]);
    }
    for (int i = 0; i < CONTROL_MEASUREMENTS_MAX; i++) {
        observation_free(loop->sensors[i]);
    }
    linear_step_free(loop->linear[0]);
    linear_step_free(loop->linear[1]);
    residual_free(loop->beyond);
    reduced_free(loop->rod);
    equilibria_free(loop->rest);
    plant_free(loop->robot);
    task_path_free(loop->path);
    free(loop->both);
    free(loop->seen.room);
    free(loop->clearance.room);
    free(loop->numbers);
    free(loop->record);
    loop_shapes_free(loop);
    free(loop);
}

const control_task *loop_task(const control_loop *loop)
{
    return &loop->control.task;
}

int loop_columns(const control_loop *loop)
{
    return loop->columns;
}

const char *loop_column_name(const control_loop *loop, int i)
{
    return loop->names[i];
}

const double *loop_column(const control_loop *loop, int i)
{
    return loop->record + (size_t)i * (size_t)loop->samples;
}

loop_parts loop_parts_of(const control_loop *loop)
{
    loop_parts parts = {.settings = &loop->settings,
                        .linear = {loop->linear[0], loop->linear[1]},
                        .seen = &loop->seen,
                        .state = loop->numbers,
                        .inputs = loop->middle,
                        .by_parameters = loop->numbers + 4 * (size_t)loop->states};
    for (int i = 0; i < loop->control.measurement_count; i++) {
        parts.sensors[i] = observation_kinematics(loop->sensors[i]);
    }
    for (int i = 0; i < loop->seen.parts; i++) {
        parts.observations[i] = observation_kinematics(loop->observations[i]);
    }
    parts.clearance = loop->clearance_part > 0 ? &loop->clearance : NULL;
    parts.clearance_part = loop->clearance_part;
    return parts;
}
