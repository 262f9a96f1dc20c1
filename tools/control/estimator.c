#include "tools/control/estimator.h"

#include "tools/control/estimator_internal.h"

/* ---- start --------------------------------------------------------------------------------- */

static double deviation_of(const estimator_parameter *p)
{
    return p->deviation > 0 ? fmin(p->deviation, estimator_uniform(p)) : estimator_uniform(p);
}

/* Sample 0, with z, u as they are. */
static void begin(estimator *x, const double *inputs)
{
    estimator_record *first = &x->record[0];
    for (int i = 0; i < x->slots; i++) {
        memset(x->record[i].state, ESTIMATOR_NONE, sizeof x->record[i].state);
        x->record[i].grow = 1;
    }
    for (int i = 0; i < x->settings.sensors; i++) {
        estimator_sensor_record *s = &x->sensor[i];
        s->row = s->next = s->count = 0;
        s->last = 0;
        s->process = 1;
        s->used = s->missing = s->not_finite = s->late = s->outliers = 0;
        memset(s->innovation, 0, (size_t)s->width * sizeof *s->innovation);
    }
    x->sample = x->at = x->flags = 0;
    x->checked = -1;
    x->outside = 0;
    x->process = x->doubt = 1;
    x->doubted = 0;
    estimator_look_ahead(x);
    memcpy(first->until, inputs, (size_t)x->inputs * sizeof *inputs);
    memcpy(first->z, x->z, (size_t)x->n * sizeof *x->z);
    memcpy(first->u, x->u, (size_t)(x->n * x->stride) * sizeof *x->u);
}

int estimator_start(estimator *x, const double *state, const double *inputs,
                    const double *by_parameters)
{
    const estimator_settings *s = &x->settings;
    const int states = x->states;
    if (!estimator_is_answer(x, 1, state) || !estimator_is_usable((size_t)x->inputs, inputs)) {
        return ESTIMATOR_BAD_START;
    }
    memcpy(x->z, state, (size_t)states * sizeof *state);
    memset(x->u, 0, (size_t)(x->n * x->stride) * sizeof *x->u);
    for (int i = 0; i < states; i++) {
        x->u[i * x->stride + i] = s->deviation[i];
    }
    for (int k = 0; k < s->parameters; k++) {
        const estimator_parameter *p = &s->parameter[k];
        const double value = fmin(p->high, fmax(p->low, inputs[p->input]));
        double *row = x->u + (states + k) * x->stride;
        x->z[states + k] = estimator_coordinate(p, value);
        row[states + k] = deviation_of(p);
        for (int i = 0; i < states && by_parameters; i++) {
            row[i] =
                by_parameters[i * s->parameters + k] * estimator_slope(p, value) * row[states + k];
        }
    }
    small_triangle(x->n, x->n, x->u);
    begin(x, inputs);
    return 0;
}

/* ---- samples ------------------------------------------------------------------------------- */

/* Goes on from the first sample that has anything new to the last one that can have been seen. */
static void catch_up(estimator *x)
{
    int64_t from = x->at + 1;
    for (int64_t i = x->at; i >= 0 && i > x->sample - x->slots; i--) {
        const unsigned char *state = estimator_record_of(x, i)->state;
        from = memchr(state, ESTIMATOR_FRESH, ESTIMATOR_SENSORS_MAX) ? i : from;
    }
    if (from <= x->at) {
        const estimator_record *at = estimator_record_of(x, from);
        memcpy(x->z, at->z, (size_t)x->n * sizeof *x->z);
        memcpy(x->u, at->u, (size_t)(x->n * x->stride) * sizeof *x->u);
        x->at = from;
        estimator_take(x, estimator_record_of(x, from));
    }
    while (x->at < x->sample - x->shortest) {
        estimator_go_on(x, estimator_record_of(x, x->at));
        estimator_record *at = estimator_record_of(x, ++x->at);
        memcpy(at->z, x->z, (size_t)x->n * sizeof *x->z);
        memcpy(at->u, x->u, (size_t)(x->n * x->stride) * sizeof *x->u);
        estimator_take(x, at);
    }
}

/* A copy of values that is good to use: quaternions of length 1. */
static bool take_values(const estimator_sensor *sensor, const double *values, double *good)
{
    const int count = sensor->look.values;
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

int estimator_measure(estimator *x, int sensor, int age, const double *values)
{
    if (sensor < 0 || sensor >= x->settings.sensors) {
        return x->flags |= ESTIMATOR_BAD_CALL, ESTIMATOR_BAD_CALL;
    }
    const estimator_sensor *from = &x->settings.sensor[sensor];
    estimator_sensor_record *record = &x->sensor[sensor];
    const int64_t sample = x->sample - (age < 0 ? from->delay : age);
    double good[ESTIMATOR_VALUES_MAX];
    int flag = 0;
    if (sample < 0 || sample <= x->sample - x->slots) {
        flag = ESTIMATOR_LATE;
        record->late++;
    } else if (estimator_record_of(x, sample)->state[sensor] >= ESTIMATOR_USED) {
        flag = ESTIMATOR_BAD_CALL;
    } else if (!take_values(from, values, good)) {
        flag = ESTIMATOR_NOT_FINITE;
        record->not_finite++;
        if (estimator_record_of(x, sample)->state[sensor] == ESTIMATOR_NONE) {
            estimator_record_of(x, sample)->state[sensor] = ESTIMATOR_UNUSABLE;
        }
    } else {
        estimator_record *at = estimator_record_of(x, sample);
        memcpy(at->values + record->offset, good, (size_t)from->look.values * sizeof *good);
        at->state[sensor] = ESTIMATOR_FRESH;
    }
    x->flags |= flag;
    return flag;
}

/* Once a sample: what should have arrived by it. */
static void count_missing(estimator *x)
{
    for (int i = 0; i < x->settings.sensors && x->checked < x->sample; i++) {
        const estimator_sensor *sensor = &x->settings.sensor[i];
        const int64_t taken = x->sample - sensor->delay,
                      every = sensor->every > 0 ? sensor->every : 1;
        if (taken >= 0 && taken % every == sensor->phase % every &&
            estimator_record_of(x, taken)->state[i] == ESTIMATOR_NONE) {
            x->flags |= ESTIMATOR_MISSING;
            x->sensor[i].missing++;
        }
    }
    x->checked = x->sample;
}

static int take_flags(estimator *x)
{
    const int flags = x->flags;
    x->flags = 0;
    return flags;
}

int estimator_update(estimator *x)
{
    count_missing(x);
    catch_up(x);
    estimator_look_ahead(x);
    for (int i = 0; i < x->settings.sensors; i++) {
        const estimator_consistency now = estimator_sensor_now(x, i);
        if (now.count == x->settings.window && !(now.low <= now.mean && now.mean <= now.high)) {
            x->flags |= ESTIMATOR_INCONSISTENT;
        }
    }
    return take_flags(x);
}

int estimator_predict(estimator *x, const double *inputs, const double *after)
{
    const size_t size = (size_t)x->inputs * sizeof *inputs;
    count_missing(x);
    catch_up(x); /* a record that is used again has been taken */
    estimator_record *from = estimator_record_of(x, x->sample), *to;
    double *ends = from->inputs;
    memcpy(ends, inputs, size);
    memcpy(ends + x->inputs, after ? after : inputs, size);
    for (int k = 0; k < x->settings.parameters; k++) {
        const int input = x->settings.parameter[k].input;
        ends[input] = ends[x->inputs + input] = 0;
    }
    if (!estimator_is_usable(2 * (size_t)x->inputs, ends)) {
        x->flags |= ESTIMATOR_BAD_INPUTS;
        memcpy(ends, from->until, size);
        memcpy(ends + x->inputs, from->until, size);
    }
    from->moves = memcmp(ends, ends + x->inputs, size) != 0;
    to = estimator_record_of(x, ++x->sample);
    memmove(to->until, ends + x->inputs, size);
    memset(to->state, ESTIMATOR_NONE, sizeof to->state);
    to->grow = 1;
    catch_up(x); /* before measurements arrive: the answer to them is quicker */
    estimator_look_ahead(x);
    return take_flags(x);
}

/* ---- answers ------------------------------------------------------------------------------- */

int64_t estimator_sample(const estimator *x)
{
    return x->sample;
}

const double *estimator_state(const estimator *x)
{
    return x->ahead;
}

double estimator_parameter_now(const estimator *x, int i)
{
    return estimator_value(&x->settings.parameter[i], x->z[x->states + i]);
}

double estimator_parameter_deviation(const estimator *x, int i)
{
    const estimator_parameter *p = &x->settings.parameter[i];
    const double now = fmin(x->doubt * estimator_deviation(x, x->states + i), estimator_uniform(p));
    return now * (p->low > 0 ? estimator_parameter_now(x, i) : 0.5 * (p->high - p->low));
}

const double *estimator_inputs(const estimator *x)
{
    memcpy(x->now, estimator_record_of(x, x->sample)->until, (size_t)x->inputs * sizeof *x->now);
    for (int k = 0; k < x->settings.parameters; k++) {
        x->now[x->settings.parameter[k].input] = estimator_parameter_now(x, k);
    }
    return x->now;
}

void estimator_covariance(const estimator *x, double *p)
{
    for (int i = 0; i < x->n; i++) {
        for (int k = 0; k < x->n; k++) {
            double sum = 0;
            for (int j = 0; j <= i && j <= k; j++) {
                sum += x->u[j * x->stride + i] * x->u[j * x->stride + k];
            }
            p[i * x->n + k] = sum;
        }
    }
}

double estimator_outside(const estimator *x)
{
    return x->outside;
}

double estimator_process(const estimator *x)
{
    return x->process;
}

double estimator_doubt(const estimator *x)
{
    return x->doubt;
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

estimator_consistency estimator_sensor_now(const estimator *x, int sensor)
{
    const estimator_sensor_record *from = &x->sensor[sensor];
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
