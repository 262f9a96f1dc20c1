/* Prediction by the model and correction by measurements. */
#include "tools/control/estimator_internal.h"

static int keep_in_range(estimator *x)
{
    int flags = 0;
    for (int i = 0; i < x->settings.parameters; i++) {
        const estimator_parameter *p = &x->settings.parameter[i];
        double *z = &x->z[x->states + i];
        const double low = estimator_coordinate(p, p->low), high = estimator_coordinate(p, p->high);
        flags |= *z <= low || *z >= high ? ESTIMATOR_AT_EDGE : 0;
        *z = fmin(high, fmax(low, *z));
    }
    return flags;
}

/* Inputs of points [1 + 2 count]: given ones, and the points' parameters. */
static void spread_inputs(const estimator *x, int count, const double *given, double *inputs)
{
    const double by = sqrt(x->sigma.c);
    for (int i = 0; i < 1 + 2 * count; i++) {
        memcpy(inputs + i * x->inputs, given, (size_t)x->inputs * sizeof *inputs);
    }
    for (int k = 0; k < x->settings.parameters; k++) {
        const estimator_parameter *p = &x->settings.parameter[k];
        const double z = x->z[x->states + k];
        inputs[p->input] = estimator_value(p, z);
        for (int j = 0; j < count; j++) {
            const double off = by * x->u[j * x->stride + x->states + k];
            inputs[(1 + 2 * j) * x->inputs + p->input] = estimator_value(p, z + off);
            inputs[(2 + 2 * j) * x->inputs + p->input] = estimator_value(p, z - off);
        }
    }
}

/* ---- prediction ---------------------------------------------------------------------------- */

static void scale_column(estimator *x, int column, double by)
{
    for (int j = 0; j <= column; j++) {
        x->u[j * x->stride + column] *= by;
    }
}

double estimator_deviation(const estimator *x, int i)
{
    double square = 0;
    for (int j = 0; j <= i; j++) {
        square += x->u[j * x->stride + i] * x->u[j * x->stride + i];
    }
    return sqrt(square);
}

static double largest(const estimator *x, int i)
{
    const estimator_settings *s = &x->settings;
    return i >= x->states ? estimator_uniform(&s->parameter[i - x->states])
           : s->largest   ? s->largest[i]
                          : 100 * s->deviation[i];
}

static void limit(estimator *x)
{
    for (int i = 0; i < x->n; i++) {
        const double most = largest(x, i), now = estimator_deviation(x, i);
        if (now > most) {
            scale_column(x, i, most / now);
        }
    }
}

/* Whether the model may be followed to next [states]. */
static bool is_known(estimator *x, const double *next, const double *inputs)
{
    const one_step *model = &x->settings.model;
    x->outside = model->outside ? model->outside(model->context, next, inputs) : 0;
    return x->outside <= 2;
}

bool estimator_is_answer(const estimator *x, int count, const double *states)
{
    bool good = true;
    for (int k = 0; k < x->states; k++) {
        const double most = 1e12 * largest(x, k);
        for (int i = 0; i < count; i++) {
            good &= fabs(states[i * x->states + k]) <= most;
        }
    }
    return good;
}

static bool advance(estimator *x, int count, const double *after)
{
    const one_step *model = &x->settings.model;
    return model->advance(model->context, count, x->settings.period, x->states_at, x->inputs_at,
                          after, x->next, NULL, NULL) == 0 &&
           estimator_is_answer(x, count, x->next);
}

/* Without an answer for all points. */
static void coast(estimator *x, const double *after)
{
    x->flags |= ESTIMATOR_NO_ANSWER | ESTIMATOR_INFLATED;
    if (advance(x, 1, after) && is_known(x, x->next, x->inputs_at)) {
        memcpy(x->z, x->next, (size_t)x->states * sizeof *x->z);
    }
    for (int i = 0; i < x->states; i++) {
        scale_column(x, i, 1.1);
    }
}

/* Of a parameter by sqrt(s). One that is positive, a stiffness, changes slowly: 0.3 %, with which
 * 50 measurements a second find it to 0.2 % and follow it within a second. Others are loads, which
 * come and go at once: 3 % of half the range, and more where innovations ask for it. */
static double walk_of(const estimator *x, const estimator_parameter *p)
{
    return p->walk > 0 ? p->walk : p->low > 0 ? 0.003 : 0.03 * x->process;
}

void estimator_go_on(estimator *x, const estimator_record *from)
{
    const estimator_settings *s = &x->settings;
    const int n = x->n, stride = x->stride, states = x->states;
    const double root = sqrt(s->period);
    double *after = x->inputs_at + (2 * n + 1) * x->inputs;
    sigma_spread(&x->sigma, n, states, x->z, x->u, x->states_at);
    spread_inputs(x, n, from->inputs, x->inputs_at);
    if (from->moves) {
        spread_inputs(x, n, from->inputs + x->inputs, after);
    }
    double *mean = x->mean;
    bool known = advance(x, 2 * n + 1, from->moves ? after : NULL);
    if (known) {
        sigma_gather(&x->sigma, n, states, stride, x->next, mean, x->rows, x->rows + n * stride);
        known = is_known(x, mean, x->inputs_at);
    }
    if (!known) {
        coast(x, from->moves ? after : NULL);
    } else {
        double *noise = x->rows + (2 * n + 1) * stride;
        memset(noise, 0, (size_t)(n * stride) * sizeof *noise);
        for (int i = 0; i < n; i++) {
            const double left_out =
                i < states ? x->process * s->process[i] : walk_of(x, &s->parameter[i - states]);
            noise[i * stride + i] = root * left_out;
            for (int k = states; k < n; k++) {
                x->rows[i * stride + k] = x->u[i * stride + k];
            }
        }
        small_triangle(3 * n + 1, n, x->rows);
        memcpy(x->u, x->rows, (size_t)(n * stride) * sizeof *x->u);
        memcpy(x->z, mean, (size_t)states * sizeof *mean);
    }
    limit(x);
    x->flags |= x->outside > 1 ? ESTIMATOR_OUTSIDE : 0;
}

void estimator_look_ahead(estimator *x)
{
    const size_t size = (size_t)x->states * sizeof *x->ahead;
    memcpy(x->ahead, x->z, size);
    for (int64_t i = x->at; i < x->sample; i++) {
        const estimator_record *from = estimator_record_of(x, i);
        double *after = x->inputs_at + x->inputs;
        spread_inputs(x, 0, from->inputs, x->inputs_at);
        spread_inputs(x, 0, from->inputs + x->inputs, after);
        memcpy(x->states_at, x->ahead, size);
        if (advance(x, 1, from->moves ? after : NULL) && is_known(x, x->next, x->inputs_at)) {
            memcpy(x->ahead, x->next, size);
        } else {
            x->flags |= ESTIMATOR_NO_ANSWER;
        }
    }
}

/* ---- correction ---------------------------------------------------------------------------- */

/* to [3]: the rotation vector, about the axes of `from`, that leads from one unit quaternion to
 * another; of the two ways, the shorter. */
static void rotation_between(const double *from, const double *other, double *to)
{
    const double w =
        from[0] * other[0] + from[1] * other[1] + from[2] * other[2] + from[3] * other[3];
    double v[3];
    for (int i = 0; i < 3; i++) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        v[i] = from[0] * other[1 + i] - other[0] * from[1 + i] -
               (from[1 + j] * other[1 + k] - from[1 + k] * other[1 + j]);
    }
    const double sine = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const double by = sine > 1e-8 ? 2 * atan2(sine, fabs(w)) / sine : 2;
    for (int i = 0; i < 3; i++) {
        to[i] = copysign(by, w) * v[i];
    }
}

/* Values of points [count][values], rotations, as rotation vectors off those of the first. */
static void flatten(int count, int values, double *seen)
{
    double first[ESTIMATOR_VALUES_MAX];
    memcpy(first, seen, (size_t)values * sizeof *first);
    for (int i = 0; i < count * values / 4; i++) {
        rotation_between(first + i % (values / 4) * 4, seen + i * 4, seen + i * 3);
    }
}

/* What points see; then mean, d, b, and the innovation of values. */
static bool look_at(estimator *x, const estimator_sensor *sensor, int count,
                    const estimator_record *at, const double *values, double *innovation)
{
    const one_look *look = &sensor->look;
    const int width = sensor->rotations ? look->values / 4 * 3 : look->values;
    double first[ESTIMATOR_VALUES_MAX];
    sigma_spread(&x->sigma, count, x->states, x->z, x->u, x->states_at);
    spread_inputs(x, count, at->until, x->inputs_at);
    if (look->see(look->context, 1 + 2 * count, x->states_at, x->inputs_at, x->seen, NULL) != 0 ||
        !estimator_is_usable((size_t)(1 + 2 * count) * look->values, x->seen)) {
        return false;
    }
    memcpy(first, x->seen, (size_t)look->values * sizeof *first);
    if (sensor->rotations) {
        flatten(1 + 2 * count, look->values, x->seen);
    }
    sigma_gather(&x->sigma, count, width, small_stride(width), x->seen, x->mean, x->d, x->b);
    for (int i = 0; i < width / 3 && sensor->rotations; i++) {
        rotation_between(first + 4 * i, values + 4 * i, innovation + 3 * i);
    }
    for (int i = 0; i < width; i++) {
        innovation[i] = (sensor->rotations ? innovation[i] : values[i]) - x->mean[i];
    }
    return true;
}

static void remember(estimator_sensor_record *sensor, int window, double square)
{
    double *place = &sensor->window[sensor->next];
    *place = square / sensor->width;
    memcpy(sensor->normals + sensor->next * sensor->width, sensor->normal,
           (size_t)sensor->width * sizeof *sensor->normal);
    sensor->next = (sensor->next + 1) % window;
    sensor->count += sensor->count < window;
    sensor->used++;
    sensor->row = 0;
}

/* What the model leaves out is as large as makes normalised innovations 1 in the mean, or less, of
 * each sensor: more after larger ones, less after smaller ones, within about 30 measurements of
 * three numbers. */
static void adapt(estimator *x, estimator_sensor_record *sensor)
{
    enum { WINDOWS = 10 }; /* of measurements, in which doubts last */
    const double rate = 0.01 * sensor->width * (fmin(sensor->last, 5) - 1);
    sensor->process = fmin(x->settings.adapt, fmax(1, sensor->process * exp(rate)));
    x->process = 1;
    for (int i = 0; i < x->settings.sensors; i++) {
        x->process = fmax(x->process, x->sensor[i].process);
    }
    x->doubted += x->doubted < (long)WINDOWS * x->settings.window;
    x->doubt += (x->process - x->doubt) / (double)x->doubted;
}

static void take_sensor(estimator *x, estimator_record *at, int which)
{
    const estimator_sensor *sensor = &x->settings.sensor[which];
    estimator_sensor_record *record = &x->sensor[which];
    const bool is_new = at->state[which] == ESTIMATOR_FRESH;
    const int count = sensor->depends > 0 ? sensor->depends : x->n;
    const double gate = is_new ? record->gate : INFINITY;
    if (!look_at(x, sensor, count, at, at->values + record->offset, record->innovation)) {
        x->flags |= ESTIMATOR_NO_ANSWER;
        at->state[which] = ESTIMATOR_UNUSABLE;
        return;
    }
    const double square =
        sigma_correct(&x->sigma, count, record->width, x->d, x->b, sensor->noise,
                      record->innovation, gate, x->z, x->u, record->normal, x->room);
    x->flags |= keep_in_range(x);
    if (!is_new) {
        return;
    }
    record->last = square / record->width;
    adapt(x, record);
    if (square <= gate) {
        at->state[which] = ESTIMATOR_USED;
        remember(record, x->settings.window, square);
        return;
    }
    at->state[which] = ESTIMATOR_REFUSED;
    record->outliers++;
    x->flags |= ESTIMATOR_OUTLIER;
    if (++record->row > x->settings.patience) {
        at->grow = 1.5;
        x->flags |= ESTIMATOR_INFLATED;
    }
}

void estimator_take(estimator *x, estimator_record *at)
{
    for (int i = 0; i < x->settings.sensors; i++) {
        if (at->state[i] == ESTIMATOR_FRESH || at->state[i] == ESTIMATOR_USED) {
            take_sensor(x, at, i);
        }
    }
    for (int i = 0; i < x->states && at->grow > 1; i++) {
        scale_column(x, i, at->grow);
    }
}
