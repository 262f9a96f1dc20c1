/* Settings, memory and the numbers that follow from settings. */
#include "tools/control/estimator_internal.h"

/* ---- chi-squared --------------------------------------------------------------------------- */

/* The chance of less than x: the regularized incomplete gamma function P(n/2, x/2), by its series
 * or by the continued fraction of the rest (Abramowitz and Stegun 6.5.29, 6.5.31). */
static double chance_below(double n, double x)
{
    const double a = 0.5 * n, y = 0.5 * x, factor = exp(a * log(y) - y - lgamma(a));
    if (y < a + 1) {
        double term = 1 / a, sum = term;
        for (int k = 1; k < 100000 && term > 1e-16 * sum; k++) {
            term *= y / (a + k);
            sum += term;
        }
        return factor * sum;
    }
    double b = y + 1 - a, c = 1e300, d = 1 / b, f = d; /* Lentz */
    for (int k = 1; k < 100000; k++) {
        const double by = -k * (k - a);
        b += 2;
        d = 1 / (by * d + b);
        c = b + by / c;
        f *= c * d;
        if (fabs(c * d - 1) < 1e-15) {
            break;
        }
    }
    return 1 - factor * f;
}

/* Exceeded with the given chance by the sum of squares of n standard normal numbers. */
static double chi_squared(double n, double chance)
{
    double low = 0, high = n + 1;
    while (1 - chance_below(n, high) > chance && high < 1e9) {
        high *= 2;
    }
    for (int k = 0; k < 80; k++) {
        const double middle = 0.5 * (low + high);
        *(1 - chance_below(n, middle) > chance ? &low : &high) = middle;
    }
    return 0.5 * (low + high);
}

/* ---- parameters ---------------------------------------------------------------------------- */

double estimator_coordinate(const estimator_parameter *p, double value)
{
    return p->low > 0 ? log(value) : (2 * value - p->low - p->high) / (p->high - p->low);
}

double estimator_value(const estimator_parameter *p, double z)
{
    const double value = p->low > 0 ? exp(z) : 0.5 * (p->low + p->high + z * (p->high - p->low));
    return fmin(p->high, fmax(p->low, value));
}

double estimator_slope(const estimator_parameter *p, double value)
{
    return p->low > 0 ? value : 0.5 * (p->high - p->low);
}

double estimator_uniform(const estimator_parameter *p)
{
    return (estimator_coordinate(p, p->high) - estimator_coordinate(p, p->low)) / sqrt(12);
}

/* ---- settings and memory ------------------------------------------------------------------- */

static int width_of(const estimator_sensor *sensor)
{
    return sensor->rotations ? sensor->observation.values / 4 * 3 : sensor->observation.values;
}

static const char *refuse_sensor(const estimator_settings *s, const estimator_sensor *sensor)
{
    const int values = sensor->observation.values;
    if (values < 1 || values > ESTIMATOR_VALUES_MAX || (sensor->rotations && values % 4 != 0)) {
        return "values of a sensor; allowed: 1 to 24, of rotations 4 each";
    }
    if (!sensor->observation.see || sensor->observation.states != s->model.states) {
        return "a sensor that looks at other states";
    }
    if (sensor->every < 0 || sensor->phase < 0 || sensor->delay < 0 || sensor->delay > 10000 ||
        sensor->depends < 0 || sensor->depends > s->model.states) {
        return "every, phase, delay, depends of a sensor; allowed: not negative";
    }
    for (int i = 0; i < width_of(sensor); i++) {
        if (!(sensor->noise[i] > 0 && sensor->noise[i] < 1e100)) {
            return "noise of a sensor; allowed: above 0";
        }
    }
    return NULL;
}

const char *estimator_refusal(const estimator_settings *s)
{
    const int n = s->model.states + s->parameters;
    if (s->model.states < 1 || s->parameters < 0 || s->parameters > ESTIMATOR_PARAMETERS_MAX ||
        n >= SMALL_MATRIX_MOST) {
        return "states and parameters; allowed: 1 to 127 in all, 16 parameters";
    }
    if (s->sensors < 0 || s->sensors > ESTIMATOR_SENSORS_MAX || s->late < 0 || s->late > 10000) {
        return "sensors, late; allowed: at most 16 sensors, late not negative";
    }
    if (!(s->model.step > 0) || !(s->alpha >= 0) || !(s->beta >= 0) || !(s->kappa >= 0) ||
        !(s->adapt >= 0 && s->adapt < 1e6) || !(s->gate >= 0 && s->gate < 1) || s->patience < 0 ||
        s->window < 0 || s->window > ESTIMATOR_WINDOW_MAX) {
        return "step, alpha, beta, kappa, adapt, gate, patience or window";
    }
    if (!(s->period >= 0 && s->period <= s->model.step) ||
        (s->period > 0 && s->period < s->model.step && !s->model.shorter)) {
        return "period; allowed: the model's step, or less if it has shorter ones";
    }
    for (int i = 0; i < s->model.states; i++) {
        if (!(s->deviation[i] > 0 && s->deviation[i] < 1e100) ||
            !(s->process[i] >= 0 && s->process[i] < 1e100)) {
            return "deviation, process; allowed: above 0, not negative";
        }
    }
    for (int i = 0; i < s->parameters; i++) {
        const estimator_parameter *p = &s->parameter[i];
        if (p->input < 0 || p->input >= s->model.inputs || !(p->low < p->high) ||
            !(p->deviation >= 0) || !(p->walk >= 0)) {
            return "a parameter; allowed: one of the inputs, low < high";
        }
    }
    for (int i = 0; i < s->sensors; i++) {
        const char *why = refuse_sensor(s, &s->sensor[i]);
        if (why) {
            return why;
        }
    }
    return NULL;
}

/* Takes numbers from memory; base NULL: counts alone. */
typedef struct carving {
    double *base;
    size_t used;
} carving;

static double *carve(carving *from, int count)
{
    double *at = from->base ? from->base + from->used : NULL;
    from->used +=
        (size_t)(count + SMALL_MATRIX_LANES - 1) / SMALL_MATRIX_LANES * SMALL_MATRIX_LANES;
    return at;
}

static void set_sizes(estimator *estimator, const estimator_settings *settings)
{
    estimator_settings *s = &estimator->settings;
    int delay = 0;
    *s = *settings;
    s->gate = s->gate > 0 ? s->gate : 1e-6;
    s->adapt = s->adapt > 0 ? fmax(1, s->adapt) : 100;
    s->patience = s->patience > 0 ? s->patience : 10;
    s->window = s->window > 0 ? s->window : 50;
    s->period = s->period > 0 ? s->period : s->model.step;
    estimator->states = s->model.states;
    estimator->inputs = s->model.inputs;
    estimator->n = estimator->states + s->parameters;
    estimator->stride = small_matrix_stride(estimator->n);
    estimator->kept = estimator->n * estimator->stride + s->model.doubts;
    estimator->sigma = s->alpha > 0 ? sigma_points_of(estimator->n, s->alpha, s->beta, s->kappa)
                                    : sigma_points_of(estimator->n, 1, 0, 0);
    estimator->values = estimator->most = 0;
    estimator->shortest = s->sensors > 0 ? s->sensor[0].delay : 0;
    for (int i = 0; i < s->sensors; i++) {
        const estimator_sensor *sensor = &s->sensor[i];
        estimator->sensor[i] =
            (estimator_sensor_record){.width = width_of(sensor), .offset = estimator->values};
        estimator->values += sensor->observation.values;
        estimator->most = sensor->observation.values > estimator->most ? sensor->observation.values
                                                                       : estimator->most;
        delay = sensor->delay > delay ? sensor->delay : delay;
        estimator->shortest =
            sensor->delay < estimator->shortest ? sensor->delay : estimator->shortest;
    }
    estimator->slots = delay + s->late + 1;
}

static void carve_all(estimator *estimator, carving *from, estimator_record *record)
{
    const int points = 2 * estimator->n + 1, apart = small_matrix_stride(estimator->most);
    estimator->z = carve(from, estimator->n);
    estimator->u = carve(from, estimator->kept);
    estimator->now = carve(from, estimator->inputs);
    estimator->ahead = carve(from, estimator->states);
    estimator->states_at = carve(from, points * estimator->states);
    estimator->next = carve(from, points * estimator->states);
    estimator->inputs_at = carve(from, 2 * points * estimator->inputs);
    estimator->seen = carve(from, points * estimator->most);
    estimator->mean = carve(from, estimator->most + estimator->n);
    estimator->rows = carve(from, (3 * estimator->n + 1) * estimator->stride);
    estimator->d = carve(from, estimator->n * apart);
    estimator->b = carve(from, (estimator->n + 1) * apart);
    estimator->room = carve(from, sigma_room(estimator->n, estimator->most));
    estimator->before = carve(from, estimator->n);
    estimator->unknown = carve(
        from, estimator->settings.model.doubts > 0 ? 3 * estimator->n * estimator->stride : 0);
    for (int i = 0; i < estimator->settings.sensors; i++) {
        estimator->sensor[i].window = carve(from, estimator->settings.window);
        estimator->sensor[i].innovation = carve(from, estimator->sensor[i].width);
        estimator->sensor[i].normal = carve(from, estimator->sensor[i].width);
        estimator->sensor[i].normals =
            carve(from, estimator->settings.window * estimator->sensor[i].width);
    }
    for (int i = 0; i < estimator->slots; i++) {
        estimator_record r = {.grow = 1};
        r.z = carve(from, estimator->n);
        r.u = carve(from, estimator->kept);
        r.until = carve(from, estimator->inputs);
        r.inputs = carve(from, 2 * estimator->inputs);
        r.values = carve(from, estimator->values);
        if (record) {
            record[i] = r;
        }
    }
}

static size_t rounded(size_t bytes)
{
    return (bytes + 63) / 64 * 64;
}

size_t estimator_size(const estimator_settings *settings)
{
    estimator x;
    carving count = {NULL, 0};
    set_sizes(&x, settings);
    carve_all(&x, &count, NULL);
    return 64 + rounded(sizeof x) + rounded((size_t)x.slots * sizeof *x.record) +
           count.used * sizeof(double);
}

estimator *estimator_init(void *memory, const estimator_settings *settings)
{
    unsigned char *at = (unsigned char *)memory + (64 - (uintptr_t)memory % 64) % 64;
    estimator *x = (estimator *)(void *)at;
    memset(memory, 0, estimator_size(settings));
    set_sizes(x, settings);
    x->record = (estimator_record *)(void *)(at + rounded(sizeof *x));
    carving from = {(double *)(void *)((unsigned char *)x->record +
                                       rounded((size_t)x->slots * sizeof *x->record)),
                    0};
    carve_all(x, &from, x->record);
    for (int i = 0; i < settings->sensors; i++) {
        estimator_sensor_record *sensor = &x->sensor[i];
        const double n = (double)sensor->width * x->settings.window;
        sensor->gate = chi_squared(sensor->width, x->settings.gate);
        sensor->low = chi_squared(n, 0.9995) / n;
        sensor->high = chi_squared(n, 0.0005) / n;
        sensor->bias_high = chi_squared(sensor->width, 0.001) / sensor->width;
    }
    return x;
}
