/* Prediction by the model and correction by measurements. */
#include "tools/control/estimator_internal.h"

static int keep_in_range(estimator *estimator)
{
    int flags = 0;
    for (int i = 0; i < estimator->settings.parameters; i++) {
        const estimator_parameter *p = &estimator->settings.parameter[i];
        double *z = &estimator->z[estimator->states + i];
        const double low = estimator_coordinate(p, p->low), high = estimator_coordinate(p, p->high);
        flags |= *z <= low || *z >= high ? ESTIMATOR_AT_EDGE : 0;
        *z = fmin(high, fmax(low, *z));
    }
    return flags;
}

/* Inputs of points [1 + 2 count]: given ones, and the points' parameters. */
static void spread_inputs(const estimator *estimator, int count, const double *given,
                          double *inputs)
{
    const double by = sqrt(estimator->sigma.c);
    for (int i = 0; i < 1 + 2 * count; i++) {
        memcpy(inputs + i * estimator->inputs, given, (size_t)estimator->inputs * sizeof *inputs);
    }
    for (int k = 0; k < estimator->settings.parameters; k++) {
        const estimator_parameter *p = &estimator->settings.parameter[k];
        const double z = estimator->z[estimator->states + k];
        inputs[p->input] = estimator_value(p, z);
        for (int j = 0; j < count; j++) {
            const double off = by * estimator->u[j * estimator->stride + estimator->states + k];
            inputs[(1 + 2 * j) * estimator->inputs + p->input] = estimator_value(p, z + off);
            inputs[(2 + 2 * j) * estimator->inputs + p->input] = estimator_value(p, z - off);
        }
    }
}

/* ---- prediction ---------------------------------------------------------------------------- */

static void scale_column(estimator *estimator, int column, double by)
{
    for (int j = 0; j <= column; j++) {
        estimator->u[j * estimator->stride + column] *= by;
    }
}

double estimator_deviation(const estimator *estimator, int i)
{
    double square = 0;
    for (int j = 0; j <= i; j++) {
        square += estimator->u[j * estimator->stride + i] * estimator->u[j * estimator->stride + i];
    }
    return sqrt(square);
}

double estimator_deviation_along(const estimator *estimator, const double *by)
{
    double square = 0;
    for (int j = 0; j < estimator->states; j++) {
        double sum = 0;
        for (int i = j; i < estimator->states; i++) {
            sum += estimator->u[j * estimator->stride + i] * by[i];
        }
        square += sum * sum;
    }
    return sqrt(square);
}

static double largest(const estimator *estimator, int i)
{
    const estimator_settings *s = &estimator->settings;
    return i >= estimator->states ? estimator_uniform(&s->parameter[i - estimator->states])
           : s->largest           ? s->largest[i]
                                  : 100 * s->deviation[i];
}

static void limit(estimator *estimator)
{
    for (int i = 0; i < estimator->n; i++) {
        const double most = largest(estimator, i), now = estimator_deviation(estimator, i);
        if (now > most) {
            scale_column(estimator, i, most / now);
        }
    }
}

/* Whether the model may be followed to next [states]. */
static bool is_known(estimator *estimator, const double *next, const double *inputs)
{
    const one_step *model = &estimator->settings.model;
    estimator->outside = model->outside ? model->outside(model->context, next, inputs) : 0;
    return estimator->outside <= 2;
}

bool estimator_is_answer(const estimator *estimator, int count, const double *states)
{
    bool good = true;
    for (int k = 0; k < estimator->states; k++) {
        const double most = 1e12 * largest(estimator, k);
        for (int i = 0; i < count; i++) {
            good &= fabs(states[i * estimator->states + k]) <= most;
        }
    }
    return good;
}

static bool advance(estimator *estimator, int count, const double *after)
{
    const one_step *model = &estimator->settings.model;
    return model->advance(model->context, count, estimator->settings.period, estimator->states_at,
                          estimator->inputs_at, after, estimator->next, NULL, NULL) == 0 &&
           estimator_is_answer(estimator, count, estimator->next);
}

/* Without an answer for all points. */
static void coast(estimator *estimator, const double *after)
{
    estimator->flags |= ESTIMATOR_NO_ANSWER | ESTIMATOR_INFLATED;
    if (advance(estimator, 1, after) &&
        is_known(estimator, estimator->next, estimator->inputs_at)) {
        memcpy(estimator->z, estimator->next, (size_t)estimator->states * sizeof *estimator->z);
    }
    for (int i = 0; i < estimator->states; i++) {
        scale_column(estimator, i, 1.1);
    }
}

/* Of a parameter by sqrt(s). One that is positive, a stiffness, changes slowly: 0.3 %, with which
 * 50 measurements a second find it to 0.2 % and follow it within a second. Others are loads, which
 * come and go at once: 3 % of half the range, and more where innovations ask for it. */
static double walk_of(const estimator *estimator, const estimator_parameter *p)
{
    return p->walk > 0 ? p->walk : p->low > 0 ? 0.003 : 0.03 * estimator->process;
}

/* What the model does not know of itself where the mean was: by what its points became, rows
 * d = A u of a derivative A. */
static bool doubt(estimator *estimator, const double *d)
{
    const one_step *model = &estimator->settings.model;
    const int n = estimator->n, stride = estimator->stride, states = estimator->states;
    double *unknown = estimator->unknown, *by = unknown + n * stride, *turned = by + n * stride;
    small_matrix_product_transposed(n, n, n, estimator->u, d, turned);
    small_matrix_solve_factored(n, estimator->u, n, turned);
    for (int r = 0; r < states; r++) {
        for (int c = 0; c < states; c++) {
            by[r * states + c] = turned[c * stride + r];
        }
    }
    return estimator_is_usable((size_t)states * (size_t)states, by) &&
           model->doubt(model->context, estimator->settings.period, estimator->states_at,
                        estimator->inputs_at, by, estimator->u + n * stride, unknown) == 0 &&
           estimator_is_usable((size_t)states * (size_t)states, unknown);
}

/* The root, an upper triangle noise [n][n], of what the model leaves out of a step: by `process`
 * and walks, and what it does not know itself where the mean was. Where rounding leaves no root
 * this is taken as large as it may be along any axis. */
static void leave_out(estimator *estimator, const double *d, double *noise)
{
    const estimator_settings *s = &estimator->settings;
    const int n = estimator->n, stride = estimator->stride, states = estimator->states;
    const double *unknown = estimator->unknown;
    const bool doubts = s->model.doubts > 0 && doubt(estimator, d);
    for (int bounds = 0; bounds < 2; bounds++) {
        memset(noise, 0, (size_t)(n * stride) * sizeof *noise);
        for (int i = 0; i < n; i++) {
            const double left_out = i < states ? estimator->process * s->process[i]
                                               : walk_of(estimator, &s->parameter[i - states]);
            const double root = sqrt(s->period) * left_out;
            const double most = bounds && i < states ? states * unknown[i * states + i] : 0;
            noise[i * stride + i] = !doubts  ? root
                                    : bounds ? sqrt(root * root + most)
                                             : root * root;
            for (int k = i; k < states && doubts && !bounds; k++) {
                noise[i * stride + k] += unknown[i * states + k];
            }
        }
        if (!doubts || (!bounds && small_matrix_cholesky(n, noise) == 0)) {
            return;
        }
    }
}

void estimator_go_on(estimator *estimator, const estimator_record *from)
{
    const int n = estimator->n, stride = estimator->stride, states = estimator->states;
    double *after = estimator->inputs_at + (2 * n + 1) * estimator->inputs;
    sigma_spread(&estimator->sigma, n, states, estimator->z, estimator->u, estimator->states_at);
    spread_inputs(estimator, n, from->inputs, estimator->inputs_at);
    if (from->moves) {
        spread_inputs(estimator, n, from->inputs + estimator->inputs, after);
    }
    double *mean = estimator->mean;
    bool known = advance(estimator, 2 * n + 1, from->moves ? after : NULL);
    if (known) {
        sigma_gather(&estimator->sigma, n, states, stride, estimator->next, mean, estimator->rows,
                     estimator->rows + n * stride);
        known = is_known(estimator, mean, estimator->inputs_at);
    }
    if (!known) {
        coast(estimator, from->moves ? after : NULL);
    } else {
        leave_out(estimator, estimator->rows, estimator->rows + (2 * n + 1) * stride);
        for (int i = 0; i < n; i++) {
            for (int k = states; k < n; k++) {
                estimator->rows[i * stride + k] = estimator->u[i * stride + k];
            }
        }
        small_matrix_triangle(3 * n + 1, n, estimator->rows);
        memcpy(estimator->u, estimator->rows, (size_t)(n * stride) * sizeof *estimator->u);
        memcpy(estimator->z, mean, (size_t)states * sizeof *mean);
    }
    limit(estimator);
    estimator->flags |= estimator->outside > 1 ? ESTIMATOR_OUTSIDE : 0;
}

void estimator_look_ahead(estimator *estimator)
{
    const size_t size = (size_t)estimator->states * sizeof *estimator->ahead;
    memcpy(estimator->ahead, estimator->z, size);
    for (int64_t i = estimator->at; i < estimator->sample; i++) {
        const estimator_record *from = estimator_record_of(estimator, i);
        double *after = estimator->inputs_at + estimator->inputs;
        spread_inputs(estimator, 0, from->inputs, estimator->inputs_at);
        spread_inputs(estimator, 0, from->inputs + estimator->inputs, after);
        memcpy(estimator->states_at, estimator->ahead, size);
        if (advance(estimator, 1, from->moves ? after : NULL) &&
            is_known(estimator, estimator->next, estimator->inputs_at)) {
            memcpy(estimator->ahead, estimator->next, size);
        } else {
            estimator->flags |= ESTIMATOR_NO_ANSWER;
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
static bool look_at(estimator *estimator, const estimator_sensor *sensor, int count,
                    const estimator_record *at, const double *values, double *innovation)
{
    const one_observation *observation = &sensor->observation;
    const int width = sensor->rotations ? observation->values / 4 * 3 : observation->values;
    double first[ESTIMATOR_VALUES_MAX];
    sigma_spread(&estimator->sigma, count, estimator->states, estimator->z, estimator->u,
                 estimator->states_at);
    spread_inputs(estimator, count, at->until, estimator->inputs_at);
    if (observation->see(observation->context, 1 + 2 * count, estimator->states_at,
                         estimator->inputs_at, estimator->seen, NULL) != 0 ||
        !estimator_is_usable((size_t)(1 + 2 * count) * observation->values, estimator->seen)) {
        return false;
    }
    memcpy(first, estimator->seen, (size_t)observation->values * sizeof *first);
    if (sensor->rotations) {
        flatten(1 + 2 * count, observation->values, estimator->seen);
    }
    sigma_gather(&estimator->sigma, count, width, small_matrix_stride(width), estimator->seen,
                 estimator->mean, estimator->d, estimator->b);
    for (int i = 0; i < width / 3 && sensor->rotations; i++) {
        rotation_between(first + 4 * i, values + 4 * i, innovation + 3 * i);
    }
    for (int i = 0; i < width; i++) {
        innovation[i] = (sensor->rotations ? innovation[i] : values[i]) - estimator->mean[i];
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
static void adapt(estimator *estimator, estimator_sensor_record *sensor)
{
    enum { WINDOWS = 10 }; /* of measurements, in which doubts last */
    const double rate = 0.01 * sensor->width * (fmin(sensor->last, 5) - 1);
    sensor->process = fmin(estimator->settings.adapt, fmax(1, sensor->process * exp(rate)));
    estimator->process = 1;
    for (int i = 0; i < estimator->settings.sensors; i++) {
        estimator->process = fmax(estimator->process, estimator->sensor[i].process);
    }
    estimator->doubted += estimator->doubted < (long)WINDOWS * estimator->settings.window;
    estimator->doubt += (estimator->process - estimator->doubt) / (double)estimator->doubted;
}

static void take_sensor(estimator *estimator, estimator_record *at, int which)
{
    const estimator_sensor *sensor = &estimator->settings.sensor[which];
    estimator_sensor_record *record = &estimator->sensor[which];
    const bool is_new = at->state[which] == ESTIMATOR_FRESH;
    const int count = sensor->depends > 0 ? sensor->depends : estimator->n;
    const double gate = is_new ? record->gate : INFINITY;
    if (!look_at(estimator, sensor, count, at, at->values + record->offset, record->innovation)) {
        estimator->flags |= ESTIMATOR_NO_ANSWER;
        at->state[which] = ESTIMATOR_UNUSABLE;
        return;
    }
    const double square = sigma_correct(
        &estimator->sigma, count, record->width, estimator->d, estimator->b, sensor->noise,
        record->innovation, gate, estimator->z, estimator->u, record->normal, estimator->room);
    estimator->flags |= keep_in_range(estimator);
    if (!is_new) {
        return;
    }
    record->last = square / record->width;
    adapt(estimator, record);
    if (square <= gate) {
        at->state[which] = ESTIMATOR_USED;
        remember(record, estimator->settings.window, square);
        return;
    }
    at->state[which] = ESTIMATOR_REFUSED;
    record->outliers++;
    estimator->flags |= ESTIMATOR_OUTLIER;
    if (++record->row > estimator->settings.patience) {
        at->grow = 1.5;
        estimator->flags |= ESTIMATOR_INFLATED;
    }
}

void estimator_take(estimator *estimator, estimator_record *at)
{
    for (int i = 0; i < estimator->settings.sensors; i++) {
        if (at->state[i] == ESTIMATOR_FRESH || at->state[i] == ESTIMATOR_USED) {
            take_sensor(estimator, at, i);
        }
    }
    for (int i = 0; i < estimator->states && at->grow > 1; i++) {
        scale_column(estimator, i, at->grow);
    }
}
