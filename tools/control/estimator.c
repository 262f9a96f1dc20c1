#include "tools/control/estimator.h"

#include "tools/control/estimator_internal.h"

/* ---- start --------------------------------------------------------------------------------- */

static double deviation_of(const estimator_parameter *p)
{
    return p->deviation > 0 ? fmin(p->deviation, estimator_uniform(p)) : estimator_uniform(p);
}

/* Sample 0, with z, u as they are. */
static void begin(estimator *estimator, const double *inputs)
{
    estimator_record *first = &estimator->record[0];
    for (int i = 0; i < estimator->slots; i++) {
        memset(estimator->record[i].state, ESTIMATOR_NONE, sizeof estimator->record[i].state);
        estimator->record[i].grow = 1;
    }
    for (int i = 0; i < estimator->settings.sensors; i++) {
        estimator_sensor_record *s = &estimator->sensor[i];
        s->row = s->next = s->count = 0;
        s->last = 0;
        s->process = 1;
        s->used = s->missing = s->not_finite = s->late = s->outliers = 0;
        memset(s->innovation, 0, (size_t)s->width * sizeof *s->innovation);
    }
    estimator->sample = estimator->at = estimator->flags = 0;
    estimator->checked = -1;
    estimator->outside = 0;
    estimator->process = estimator->doubt = 1;
    estimator->doubted = 0;
    estimator_look_ahead(estimator);
    memcpy(first->until, inputs, (size_t)estimator->inputs * sizeof *inputs);
    memcpy(first->z, estimator->z, (size_t)estimator->n * sizeof *estimator->z);
    memcpy(first->u, estimator->u, (size_t)estimator->kept * sizeof *estimator->u);
}

int estimator_start(estimator *estimator, const double *state, const double *inputs,
                    const double *by_parameters)
{
    const estimator_settings *s = &estimator->settings;
    const int states = estimator->states;
    if (!estimator_is_answer(estimator, 1, state) ||
        !estimator_is_usable((size_t)estimator->inputs, inputs)) {
        return ESTIMATOR_BAD_START;
    }
    memcpy(estimator->z, state, (size_t)states * sizeof *state);
    memset(estimator->u, 0, (size_t)estimator->kept * sizeof *estimator->u);
    for (int i = 0; i < states; i++) {
        estimator->u[i * estimator->stride + i] = s->deviation[i];
    }
    for (int k = 0; k < s->parameters; k++) {
        const estimator_parameter *p = &s->parameter[k];
        const double value = fmin(p->high, fmax(p->low, inputs[p->input]));
        double *row = estimator->u + (states + k) * estimator->stride;
        estimator->z[states + k] = estimator_coordinate(p, value);
        row[states + k] = deviation_of(p);
        for (int i = 0; i < states && by_parameters; i++) {
            row[i] =
                by_parameters[i * s->parameters + k] * estimator_slope(p, value) * row[states + k];
        }
    }
    small_matrix_triangle(estimator->n, estimator->n, estimator->u);
    if (s->model.doubts > 0) {
        s->model.doubt(s->model.context, s->period, state, inputs, NULL,
                       estimator->u + estimator->n * estimator->stride, NULL);
    }
    begin(estimator, inputs);
    return 0;
}

/* ---- samples ------------------------------------------------------------------------------- */

/* Goes on from the first sample that has anything new to the last one that can have been seen. */
static void catch_up(estimator *estimator)
{
    int64_t from = estimator->at + 1;
    for (int64_t i = estimator->at; i >= 0 && i > estimator->sample - estimator->slots; i--) {
        const unsigned char *state = estimator_record_of(estimator, i)->state;
        from = memchr(state, ESTIMATOR_FRESH, ESTIMATOR_SENSORS_MAX) ? i : from;
    }
    if (from <= estimator->at) {
        const estimator_record *at = estimator_record_of(estimator, from);
        memcpy(estimator->z, at->z, (size_t)estimator->n * sizeof *estimator->z);
        memcpy(estimator->u, at->u, (size_t)estimator->kept * sizeof *estimator->u);
        estimator->at = from;
        estimator_take(estimator, estimator_record_of(estimator, from));
    }
    while (estimator->at < estimator->sample - estimator->shortest) {
        estimator_go_on(estimator, estimator_record_of(estimator, estimator->at));
        estimator_record *at = estimator_record_of(estimator, ++estimator->at);
        memcpy(at->z, estimator->z, (size_t)estimator->n * sizeof *estimator->z);
        memcpy(at->u, estimator->u, (size_t)estimator->kept * sizeof *estimator->u);
        estimator_take(estimator, at);
    }
}

/* A copy of values that is good to use: quaternions of length 1. */
static bool take_values(const estimator_sensor *sensor, const double *values, double *good)
{
    const int count = sensor->observation.values;
    memcpy(good, values, (size_t)count * sizeof *good);
    if (!estimator_is_usable((size_t)count, values)) {
        return false;
    }
    for (int i = 0; i < count && sensor->rotations; i += 4) {
        const double *q = values + i;
        const double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (!(fabs(norm - 1) < 0.01)) {
            return false;
        }
        for (int k = 0; k < 4; k++) {
            good[i + k] = q[k] / norm;
        }
    }
    return true;
}

int estimator_measure(estimator *estimator, int sensor, int age, const double *values)
{
    if (sensor < 0 || sensor >= estimator->settings.sensors) {
        return estimator->flags |= ESTIMATOR_BAD_CALL, ESTIMATOR_BAD_CALL;
    }
    const estimator_sensor *from = &estimator->settings.sensor[sensor];
    estimator_sensor_record *record = &estimator->sensor[sensor];
    const int64_t sample = estimator->sample - (age < 0 ? from->delay : age);
    double good[ESTIMATOR_VALUES_MAX];
    int flag = 0;
    if (sample < 0 || sample <= estimator->sample - estimator->slots) {
        flag = ESTIMATOR_LATE;
        record->late++;
    } else if (estimator_record_of(estimator, sample)->state[sensor] >= ESTIMATOR_USED) {
        flag = ESTIMATOR_BAD_CALL;
    } else if (!take_values(from, values, good)) {
        flag = ESTIMATOR_NOT_FINITE;
        record->not_finite++;
        if (estimator_record_of(estimator, sample)->state[sensor] == ESTIMATOR_NONE) {
            estimator_record_of(estimator, sample)->state[sensor] = ESTIMATOR_UNUSABLE;
        }
    } else {
        estimator_record *at = estimator_record_of(estimator, sample);
        memcpy(at->values + record->offset, good, (size_t)from->observation.values * sizeof *good);
        at->state[sensor] = ESTIMATOR_FRESH;
    }
    estimator->flags |= flag;
    return flag;
}

/* Once a sample: what should have arrived by it. */
static void count_missing(estimator *estimator)
{
    for (int i = 0; i < estimator->settings.sensors && estimator->checked < estimator->sample;
         i++) {
        const estimator_sensor *sensor = &estimator->settings.sensor[i];
        const int64_t taken = estimator->sample - sensor->delay,
                      every = sensor->every > 0 ? sensor->every : 1;
        if (taken >= 0 && taken % every == sensor->phase % every &&
            estimator_record_of(estimator, taken)->state[i] == ESTIMATOR_NONE) {
            estimator->flags |= ESTIMATOR_MISSING;
            estimator->sensor[i].missing++;
        }
    }
    estimator->checked = estimator->sample;
}

static int take_flags(estimator *estimator)
{
    const int flags = estimator->flags;
    estimator->flags = 0;
    return flags;
}

int estimator_update(estimator *estimator)
{
    count_missing(estimator);
    catch_up(estimator);
    estimator_look_ahead(estimator);
    for (int i = 0; i < estimator->settings.sensors; i++) {
        const estimator_consistency now = estimator_sensor_now(estimator, i);
        if (now.count == estimator->settings.window &&
            !(now.low <= now.mean && now.mean <= now.high)) {
            estimator->flags |= ESTIMATOR_INCONSISTENT;
        }
    }
    return take_flags(estimator);
}

int estimator_predict(estimator *estimator, const double *inputs, const double *after)
{
    const size_t size = (size_t)estimator->inputs * sizeof *inputs;
    count_missing(estimator);
    catch_up(estimator); /* a record that is used again has been taken */
    estimator_record *from = estimator_record_of(estimator, estimator->sample), *to;
    double *ends = from->inputs;
    memcpy(ends, inputs, size);
    memcpy(ends + estimator->inputs, after ? after : inputs, size);
    for (int k = 0; k < estimator->settings.parameters; k++) {
        const int input = estimator->settings.parameter[k].input;
        ends[input] = ends[estimator->inputs + input] = 0;
    }
    if (!estimator_is_usable(2 * (size_t)estimator->inputs, ends)) {
        estimator->flags |= ESTIMATOR_BAD_INPUTS;
        memcpy(ends, from->until, size);
        memcpy(ends + estimator->inputs, from->until, size);
    }
    from->moves = memcmp(ends, ends + estimator->inputs, size) != 0;
    to = estimator_record_of(estimator, ++estimator->sample);
    memmove(to->until, ends + estimator->inputs, size);
    memset(to->state, ESTIMATOR_NONE, sizeof to->state);
    to->grow = 1;
    catch_up(estimator); /* before measurements arrive: the answer to them is quicker */
    estimator_look_ahead(estimator);
    return take_flags(estimator);
}

/* ---- answers ------------------------------------------------------------------------------- */

int64_t estimator_sample(const estimator *estimator)
{
    return estimator->sample;
}

const double *estimator_state(const estimator *estimator)
{
    return estimator->ahead;
}

double estimator_parameter_now(const estimator *estimator, int i)
{
    return estimator_value(&estimator->settings.parameter[i], estimator->z[estimator->states + i]);
}

double estimator_parameter_deviation(const estimator *estimator, int i)
{
    const estimator_parameter *p = &estimator->settings.parameter[i];
    const double now =
        fmin(estimator->doubt * estimator_deviation(estimator, estimator->states + i),
             estimator_uniform(p));
    return now * (p->low > 0 ? estimator_parameter_now(estimator, i) : 0.5 * (p->high - p->low));
}

const double *estimator_inputs(const estimator *estimator)
{
    memcpy(estimator->now, estimator_record_of(estimator, estimator->sample)->until,
           (size_t)estimator->inputs * sizeof *estimator->now);
    for (int k = 0; k < estimator->settings.parameters; k++) {
        estimator->now[estimator->settings.parameter[k].input] =
            estimator_parameter_now(estimator, k);
    }
    return estimator->now;
}

void estimator_covariance(const estimator *estimator, double *p)
{
    for (int i = 0; i < estimator->n; i++) {
        for (int k = 0; k < estimator->n; k++) {
            double sum = 0;
            for (int j = 0; j <= i && j <= k; j++) {
                sum += estimator->u[j * estimator->stride + i] *
                       estimator->u[j * estimator->stride + k];
            }
            p[i * estimator->n + k] = sum;
        }
    }
}

double estimator_outside(const estimator *estimator)
{
    return estimator->outside;
}

double estimator_process(const estimator *estimator)
{
    return estimator->process;
}

double estimator_doubt(const estimator *estimator)
{
    return estimator->doubt;
}

/* Bias and correlation of the innovations of a window. */
static void compare_in_row(const estimator_sensor_record *from, estimator_consistency *to)
{
    const int width = from->width, count = from->count;
    double products = 0, squares = 0, bias = 0;
    for (int k = 0; k < width; k++) {
        const double *normal = from->normals + k;
        double sum = 0;
        for (int i = 0; i < count; i++) { /* the oldest follows the newest one in memory */
            const double now = normal[i * width],
                         before = normal[(i > 0 ? i - 1 : count - 1) * width];
            sum += now;
            squares += now * now;
            products += i == from->next % count ? 0 : now * before;
        }
        bias += sum * sum / count;
    }
    to->bias = count > 0 ? bias / width : 0;
    to->correlation = squares > 0 ? products / squares : 0;
    to->bias_high = from->bias_high;
    to->correlation_high = ESTIMATOR_ONCE_IN_1000 / sqrt((double)(count > 0 ? count * width : 1));
}

estimator_consistency estimator_sensor_now(const estimator *estimator, int sensor)
{
    const estimator_sensor_record *from = &estimator->sensor[sensor];
    estimator_consistency now;
    double sum = 0;
    for (int i = 0; i < from->count; i++) {
        sum += from->window[i];
    }
    now = (estimator_consistency){.last = from->last,
                                  .mean = from->count > 0 ? sum / from->count : 0,
                                  .low = from->low,
                                  .high = from->high,
                                  .count = from->count,
                                  .used = from->used,
                                  .missing = from->missing,
                                  .not_finite = from->not_finite,
                                  .late = from->late,
                                  .outliers = from->outliers};
    compare_in_row(from, &now);
    return now;
}
