#include "tools/control/control_settings.h"

#include "physics/scene/support.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

control_settings control_settings_default(void)
{
    control_settings x;
    memset(&x, 0, sizeof x);
    x.environment = ENVIRONMENT_DEFAULT;
    x.track_at = x.radius = x.task.radius = x.period = x.duration = NAN;
    x.tolerance_rms = x.tolerance_worst = NAN;
    for (int k = 0; k < 3; k++) {
        x.task.centre[k] = x.task.normal[k] = NAN;
    }
    for (int i = 0; i < CONTROL_POINTS_MAX; i++) {
        x.task.points[i].stay = 1;
        x.task.points[i].position[0] = NAN;
    }
    for (int i = 0; i < CONTROL_MEASUREMENTS_MAX; i++) {
        x.measurements[i] = (control_measurement){.at = NAN, .noise = NAN, .every = 1};
    }
    for (int i = 0; i < CONTROL_LIMITS_MAX; i++) {
        x.limits[i] = (control_limit){.at = NAN, .axis = 3, .low = NAN, .high = NAN};
    }
    for (int i = 0; i < CONTROL_FAULTS_MAX; i++) {
        x.faults[i].measurement = -1;
    }
    x.plant_modes[0] = 0;
    x.task.frequency = 0.5;
    x.task.travel = 0.5;
    x.task.approach = 1;
    x.horizon = 12;
    x.weight_rate = 100; /* of twelve robots: tools/bench/control.sh */
    x.weight_effort = 1e-4;
    x.accuracy = NAN;
    x.offset = 0.05;
    x.delay = 1;
    x.seed = 1;
    return x;
}

surrogate_settings control_model_of(const surrogate_settings *given)
{
    surrogate_settings x = *given;
    if (isnan(x.step)) {
        x.step = 0.02;
        x.input_count = x.parameter_count = 0;
    }
    return x;
}

static ad_status blame(char key[TRAIN_KEY_MAX], ad_error *error, const char *path, int index,
                       const char *last, const char *problem)
{
    if (index >= 0) {
        snprintf(key, TRAIN_KEY_MAX, "control.%s[%d]%s%s", path, index, *last ? "." : "", last);
    } else {
        snprintf(key, TRAIN_KEY_MAX, "control.%s", path);
    }
    return ad_fail(error, AD_BAD_INPUT, "%s", problem);
}

/* ---- parameters ---------------------------------------------------------------------------- */

control_role control_role_of(const control_settings *settings, const surrogate_settings *model,
                             const char *name)
{
    return strchr(name, '.') ? CONTROL_FIXED /* the state of an input with a memory */
           : surrogate_is_among(settings->estimate_count, settings->estimate, name)
               ? CONTROL_ESTIMATED
           : model->input_count > 0 && !surrogate_is_among(model->input_count, model->inputs, name)
               ? CONTROL_FIXED
           : surrogate_is_among(model->parameter_count, model->parameters, name) ? CONTROL_FIXED
                                                                                 : CONTROL_INPUT;
}

static ad_status resolve_estimate(control_settings *settings, const surrogate_settings *model,
                                  const scene *of, bool given, char key[TRAIN_KEY_MAX],
                                  ad_error *error)
{
    char problem[300];
    if (!given) {
        settings->estimate_count = model->parameter_count;
        memcpy(settings->estimate, model->parameters, sizeof settings->estimate);
    }
    for (int i = 0; i < settings->estimate_count; i++) {
        const char *name = settings->estimate[i];
        const bool known = scene_parameter_find(of, name) >= 0;
        if (settings->walk_count == 1) {
            settings->walk[i] = settings->walk[0];
        }
        if (!known || surrogate_is_among(i, settings->estimate, name) ||
            surrogate_is_among(model->input_count, model->inputs, name)) {
            snprintf(problem, sizeof problem,
                     "%.60s is %s; allowed: names of parameters with a range that are no inputs, "
                     "once each",
                     name,
                     !known ? "no parameter with a range"
                     : surrogate_is_among(model->input_count, model->inputs, name)
                         ? "one of surrogate.inputs"
                         : "there twice");
            return blame(key, error, "estimate", i, "", problem);
        }
    }
    if (settings->walk_count > 1 && settings->walk_count != settings->estimate_count) {
        return blame(key, error, "walk", -1, "",
                     "has not as many numbers as estimate; allowed: one for each, or one");
    }
    return AD_OK;
}

/* Where a list of the scene has its number of an input: in the order of surrogate.inputs. */
static int place_of(const surrogate_settings *model, const char *name, int otherwise)
{
    int i = 0;
    while (i < model->input_count && strcmp(model->inputs[i], name) != 0) {
        i++;
    }
    return i < model->input_count ? i : otherwise;
}

/* The limits of inputs: one number for each, within its range; they become those of parameters in
 * the order of the scene. */
static ad_status check_inputs(control_settings *settings, const surrogate_settings *model,
                              const scene *of, char key[TRAIN_KEY_MAX], ad_error *error)
{
    const int counts[2] = {settings->low_count, settings->high_count};
    const char *const names[2] = {"limits.low", "limits.high"};
    const control_settings as_given = *settings;
    char problem[300];
    int count = 0;
    for (int k = 0; k < of->parameter_count; k++) {
        const scene_parameter *p = &of->parameters[k];
        if (control_role_of(settings, model, p->name) != CONTROL_INPUT) {
            continue;
        }
        const int at = place_of(model, p->name, count);
        for (int end = 0; end < 2; end++) {
            const double value = (end ? as_given.high : as_given.low)[at];
            if (at < counts[end] && !scene_parameter_holds(p, value)) {
                snprintf(problem, sizeof problem,
                         "is outside the range of %.60s; allowed: %g to %g", p->name, p->low,
                         p->high);
                return blame(key, error, names[end], at, "", problem);
            }
        }
        settings->low[count] = counts[0] > 0 ? as_given.low[at] : p->low;
        settings->high[count] = counts[1] > 0 ? as_given.high[at] : p->high;
        settings->rate[count] = settings->rate_count == 0
                                    ? INFINITY
                                    : as_given.rate[settings->rate_count == 1 ? 0 : at];
        if (!(settings->low[count] < settings->high[count])) {
            return blame(key, error, "limits.high", counts[1] > 0 ? at : -1, "",
                         "is not above limits.low; allowed: a range for every input");
        }
        count++;
    }
    if (count == 0) {
        return blame(key, error, "estimate", -1, "",
                     "leaves no input; allowed: at least one parameter with a range that an "
                     "actuator sets");
    }
    for (int end = 0; end < 3; end++) {
        const int given = end == 2 ? settings->rate_count : counts[end];
        if (given != 0 && given != count && !(end == 2 && given == 1)) {
            snprintf(problem, sizeof problem,
                     "has %d numbers, and there are %d inputs; allowed: "
                     "one for each",
                     given, count);
            return blame(key, error, end == 2 ? "limits.rate" : names[end], -1, "", problem);
        }
    }
    for (int k = 0; k < settings->rate_count; k++) {
        if (!(as_given.rate[k] > 0)) {
            return blame(key, error, "limits.rate", k, "", "is not positive; allowed: numbers > 0");
        }
    }
    settings->low_count = settings->high_count = count;
    return AD_OK;
}

/* ---- the rest ------------------------------------------------------------------------------ */

static ad_status check_task(control_settings *settings, double length, char key[TRAIN_KEY_MAX],
                            ad_error *error)
{
    control_task *task = &settings->task;
    task->radius = isnan(task->radius) ? length / 10 : task->radius;
    if (task->path == CONTROL_POINTS && task->point_count == 0) {
        return blame(key, error, "task.path", -1, "",
                     "is points, and there are none; give task.points");
    }
    if (task->path == CONTROL_FILE && !task->file) {
        return blame(key, error, "task.path", -1, "", "is file, and there is none; give task.file");
    }
    if (task->path != CONTROL_POINTS && task->point_count > 0) {
        return blame(key, error, "task.points", -1, "",
                     "are given, but task.path is not points; give that, or leave them out");
    }
    if (task->path != CONTROL_FILE && task->file) {
        return blame(key, error, "task.file", -1, "",
                     "is given, but task.path is not file; give that, or leave it out");
    }
    for (int i = 0; i < task->point_count; i++) {
        if (isnan(task->points[i].position[0])) {
            return blame(key, error, "task.points", i, "position",
                         "missing; allowed: a list of 3 numbers, in m");
        }
    }
    if (task->normal[0] == 0 && task->normal[1] == 0 && task->normal[2] == 0) {
        return blame(key, error, "task.normal", -1, "", "is 0; allowed: a direction");
    }
    return AD_OK;
}

static ad_status check_place(double *at, double usual, double length, const char *list, int index,
                             char key[TRAIN_KEY_MAX], ad_error *error)
{
    char problem[120];
    *at = isnan(*at) ? usual : *at;
    if (*at <= length * (1 + 1e-12)) {
        *at = fmin(*at, length);
        return AD_OK;
    }
    snprintf(problem, sizeof problem, "is %g m along a rod of %g m; allowed: 0 to %g", *at, length,
             length);
    return blame(key, error, index < 0 ? "track.at" : list, index, "at", problem);
}

static ad_status check_clearance(const control_settings *settings, int i, char *key,
                                 ad_error *error)
{
    const control_limit *l = &settings->limits[i];
    for (int k = 0; k < i; k++) {
        if (settings->limits[k].what == CONTROL_CLEARANCE) {
            return blame(key, error, "constraints", i, "what", "is given twice; allowed: once");
        }
    }
    if (!(l->low >= 0) || !isnan(l->high)) {
        return blame(key, error, "constraints", i, isnan(l->high) ? "low" : "high",
                     "is of a clearance; allowed: low alone, at least 0 m");
    }
    if (!settings->environment.file) {
        return blame(key, error, "environment.file", -1, "",
                     "is not given, and a clearance is constrained; allowed: .stl, .obj");
    }
    return isnan(settings->radius)
               ? blame(key, error, "radius", -1, "",
                       "is not given, and a clearance is constrained; allowed: a number >= 0 (m)")
               : AD_OK;
}

static ad_status check_lists(control_settings *settings, double length, char key[TRAIN_KEY_MAX],
                             ad_error *error)
{
    static const double usual_noise[] = {2e-4, 0.01, 0.01, 0.01, 0.1, 0.1, 0.01};
    ad_status status = AD_OK;
    if (settings->measurement_count == 0) {
        settings->measurement_count = 1;
    }
    for (int i = 0; i < settings->measurement_count && status == AD_OK; i++) {
        control_measurement *m = &settings->measurements[i];
        m->noise = isnan(m->noise) ? usual_noise[m->what] : m->noise;
        status = check_place(&m->at, settings->track_at, length, "measurements", i, key, error);
    }
    for (int i = 0; i < settings->limit_count && status == AD_OK; i++) {
        control_limit *l = &settings->limits[i];
        status = check_place(&l->at, length, length, "constraints", i, key, error);
        if (status == AD_OK && l->what == CONTROL_CLEARANCE) {
            status = check_clearance(settings, i, key, error);
        }
        if (status == AD_OK && l->what == OBSERVATION_ROTATION) {
            status = blame(key, error, "constraints", i, "what",
                           "is a rotation, which has no axes; allowed: direction, or any other");
        }
        if (status == AD_OK && !(isnan(l->low) || l->low < l->high || isnan(l->high))) {
            status =
                blame(key, error, "constraints", i, "high", "is not above low; allowed: a range");
        }
        if (status == AD_OK && isnan(l->low) && isnan(l->high)) {
            status = blame(key, error, "constraints", i, "", "has neither low nor high; give one");
        }
    }
    for (int i = 0; i < settings->fault_count && status == AD_OK; i++) {
        if (settings->faults[i].measurement >= settings->measurement_count) {
            status = blame(key, error, "faults", i, "measurement",
                           "is none of the measurements; allowed: their numbers from 0, or -1");
        }
    }
    return status;
}

/* What a rod that moves through its port shows: up to the first place that anything is at, no place
 * stays where it is on the rod. */
static ad_status check_fed(const control_settings *settings, const scene *rod_scene,
                           char key[TRAIN_KEY_MAX], ad_error *error)
{
    const double to = rod_scene->feed.to, beyond = (1 - 1e-9) * to;
    ad_status status = AD_OK;
    if (to > 0 && settings->track_at < beyond) {
        status = blame(key, error, "track.at", -1, "",
                       "is on what the port lets out; allowed: the tip, or beyond what is on it");
    }
    for (int i = 0; i < settings->measurement_count + settings->limit_count && to > 0; i++) {
        const int k = i - settings->measurement_count;
        const control_measurement *m = &settings->measurements[k < 0 ? i : 0];
        const bool strains =
            k < 0 && (m->what == OBSERVATION_CURVATURE || m->what == OBSERVATION_STRAIN);
        const double at = k < 0 ? m->at : settings->limits[k].at;
        const bool strain_limit = k >= 0 && (settings->limits[k].what == OBSERVATION_CURVATURE ||
                                             settings->limits[k].what == OBSERVATION_STRAIN);
        if (status == AD_OK && (at < beyond || ((strains || strain_limit) && at <= to))) {
            status = blame(key, error, k < 0 ? "measurements" : "constraints", k < 0 ? i : k, "at",
                           "is on what the port lets out; allowed: the tip, but for strains, or "
                           "beyond what is on the rod");
        }
    }
    return status;
}

/* Of the length, what a place may be off its path by where the scene does not say. */
static const double RMS = 0.02, WORST = 0.05;

ad_status control_settings_resolve(control_settings *settings, const surrogate_settings *model,
                                   const scene *rod_scene, bool estimate_given,
                                   char key[TRAIN_KEY_MAX], ad_error *error)
{
    const double length = scene_length(rod_scene);
    const char *found = "";
    ad_error reason;
    if (support_check(rod_scene, SUPPORT_ONE_STEP, &found, &reason) != AD_OK) {
        snprintf(key, TRAIN_KEY_MAX, "%s", found);
        return ad_fail(error, AD_BAD_INPUT, "%s", reason.message);
    }
    if (settings->model == CONTROL_LINEAR && rod_scene->memory_count > 0) {
        return blame(key, error, "model", -1, "",
                     "is linear, and inputs have plays or lags; allowed: reduced");
    }
    ad_status status = resolve_estimate(settings, model, rod_scene, estimate_given, key, error);
    status = status == AD_OK ? check_inputs(settings, model, rod_scene, key, error) : status;
    status = status == AD_OK
                 ? check_place(&settings->track_at, length, length, "track", -1, key, error)
                 : status;
    status = status == AD_OK ? check_task(settings, length, key, error) : status;
    status = status == AD_OK ? check_lists(settings, length, key, error) : status;
    status = status == AD_OK ? check_fed(settings, rod_scene, key, error) : status;
    settings->period = isnan(settings->period) ? model->step : settings->period;
    settings->tolerance_rms =
        isnan(settings->tolerance_rms) ? RMS * length : settings->tolerance_rms;
    if (isnan(settings->tolerance_worst)) {
        settings->tolerance_worst = fmax(WORST * length, WORST / RMS * settings->tolerance_rms);
    }
    if (status == AD_OK && settings->period > model->step * (1 + 1e-12)) {
        char problem[120];
        snprintf(problem, sizeof problem, "is above the step of the model; allowed: up to %g s",
                 model->step);
        status = blame(key, error, "period", -1, "", problem);
    }
    const bool eight =
        settings->task.path == CONTROL_EIGHT; /* up and down it goes twice as often */
    const double fastest = (eight ? 0.25 : 0.5) / model->step;
    if (status == AD_OK && (eight || settings->task.path == CONTROL_CIRCLE) &&
        settings->task.frequency >= fastest) {
        char problem[120];
        snprintf(problem, sizeof problem, "is too high for steps of %g s; allowed: below %g Hz",
                 model->step, fastest);
        status = blame(key, error, "task.frequency", -1, "", problem);
    }
    if (status == AD_OK && settings->residual && settings->model == CONTROL_LINEAR) {
        status = blame(key, error, "residual", -1, "",
                       "is beside a model that is not linear; allowed: another control.model");
    }
    return status;
}
