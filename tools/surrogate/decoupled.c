#include "tools/surrogate/decoupled.h"

#include <math.h>
#include <string.h>

/* Radau's points of order 5, as those of the reduced rod's steps. */
const double decoupled_nodes[DECOUPLED_NODES] = {0.15505102572168219, 0.64494897427831781, 1};

/* ---- sizes --------------------------------------------------------------------------------- */

typedef struct decoupled_parts {
#define DECOUPLED_FIELD(name, count) const double *name;
    DECOUPLED_NUMBERS(DECOUPLED_FIELD)
#undef DECOUPLED_FIELD
    const double *network;
} decoupled_parts;

static decoupled_parts split(const decoupled *m)
{
    const size_t n = (size_t)m->states, inputs = (size_t)m->inputs;
    const double *at = m->numbers;
    decoupled_parts x;
#define DECOUPLED_TAKE(name, count)                                                                \
    x.name = at;                                                                                   \
    at += (count);
    DECOUPLED_NUMBERS(DECOUPLED_TAKE)
#undef DECOUPLED_TAKE
    x.network = at;
    return x;
}

int decoupled_given(const decoupled *m)
{
    return m->ramps ? 2 * m->inputs : m->inputs;
}

int decoupled_outputs(const decoupled *m)
{
    return m->states * 4 * m->terms;
}

size_t decoupled_parameters(const decoupled *m)
{
    size_t count = 0, in = (size_t)m->states + decoupled_given(m);
    for (int l = 0; l <= m->layers; l++) {
        const size_t out = (size_t)(l < m->layers ? m->width[l] : decoupled_outputs(m));
        count += out * (in + 1);
        in = out;
    }
    return count;
}

size_t decoupled_numbers(const decoupled *m)
{
    const size_t n = (size_t)m->states, inputs = (size_t)m->inputs;
    size_t count = decoupled_parameters(m);
#define DECOUPLED_COUNT(name, number) count += (number);
    DECOUPLED_NUMBERS(DECOUPLED_COUNT)
#undef DECOUPLED_COUNT
    return count;
}

/* Inputs of the network. */
static size_t first_of(const decoupled *m)
{
    return (size_t)m->states + decoupled_given(m);
}

static size_t widest(const decoupled *m)
{
    int most = 0;
    for (int l = 0; l < m->layers; l++) {
        most = m->width[l] > most ? m->width[l] : most;
    }
    return (size_t)most;
}

static size_t hidden_units(const decoupled *m)
{
    size_t sum = 0;
    for (int l = 0; l < m->layers; l++) {
        sum += (size_t)m->width[l];
    }
    return sum;
}

size_t decoupled_work(const decoupled *m)
{
    const size_t n = (size_t)m->states, first = first_of(m), wide = widest(m);
    return first + hidden_units(m) + (size_t)decoupled_outputs(m) + n + 2 * wide * first +
           n * wide + n * first;
}

/* ---- the network --------------------------------------------------------------------------- */

/* to [rows] = weights [rows][columns] from + biases. */
static void dense(size_t rows, size_t columns, const double *weights, const double *from,
                  double *to)
{
    const double *biases = weights + rows * columns;
    for (size_t r = 0; r < rows; r++) {
        double sums[4] = {biases[r], 0, 0, 0};
        const double *row = weights + r * columns;
        size_t c = 0;
        for (; c + 4 <= columns; c += 4) {
            for (size_t k = 0; k < 4; k++) {
                sums[k] += row[c + k] * from[c + k];
            }
        }
        for (; c < columns; c++) {
            sums[0] += row[c] * from[c];
        }
        to[r] = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    }
}

void decoupled_network(const decoupled *m, const double *parameters, const double *z,
                       const double *v, double *hidden, double *a)
{
    double first[256];
    const size_t n = (size_t)m->states, given = (size_t)decoupled_given(m);
    const double *from = first;
    size_t in = n + given;
    memcpy(first, z, n * sizeof *z);
    memcpy(first + n, v, given * sizeof *v);
    for (int l = 0; l < m->layers; l++) {
        const size_t out = (size_t)m->width[l];
        dense(out, in, parameters, from, hidden);
        for (size_t k = 0; k < out; k++) {
            hidden[k] = tanh(hidden[k]);
        }
        parameters += out * (in + 1);
        from = hidden;
        hidden += out;
        in = out;
    }
    dense((size_t)decoupled_outputs(m), in, parameters, from, a);
}

/* ---- curves -------------------------------------------------------------------------------- */

void decoupled_curve(const decoupled *m, const double *a, double t, double *y, double *rate)
{
    const int n = m->states;
    for (int j = 0; j < n; j++) {
        double sum = 0, change = 0;
        for (int i = 0; i < m->terms; i++) {
            const double *of = a + 4 * (j * m->terms + i);
            const double decay = exp(-of[3] * t), angle = of[1] * t + of[2], s = sin(angle);
            sum += of[0] * (decay * s - sin(of[2]));
            change += rate ? of[0] * decay * (of[1] * cos(angle) - of[3] * s) : 0;
        }
        y[j] = sum;
        if (rate) {
            rate[j] = change;
        }
    }
}

/* Of one damped sine with numbers alpha, beta, gamma, delta: by_y times dy plus by_rate times dy'.
 */
static void sine_adjoint(const double of[4], double t, double by_y, double by_rate, double to[4])
{
    const double decay = exp(-of[3] * t), angle = of[1] * t + of[2];
    const double s = decay * sin(angle), c = decay * cos(angle), turn = of[1] * c - of[3] * s;
    to[0] += by_y * (s - sin(of[2])) + by_rate * turn;
    to[1] += of[0] * (by_y * t * c + by_rate * (c - t * (of[1] * s + of[3] * c)));
    to[2] += of[0] * (by_y * (c - cos(of[2])) - by_rate * (of[1] * s + of[3] * c));
    to[3] += of[0] * (-by_y * t * s - by_rate * (t * turn + s));
}

void decoupled_curve_adjoint(const decoupled *m, const double *a, double t, const double *by_y,
                             const double *by_rate, double *to_a)
{
    const int n = m->states;
    for (int j = 0; j < n; j++) {
        const double of_y = by_y ? by_y[j] : 0, of_rate = by_rate ? by_rate[j] : 0;
        for (int i = 0; i < m->terms; i++) {
            const int at = 4 * (j * m->terms + i);
            sine_adjoint(a + at, t, of_y, of_rate, to_a + at);
        }
    }
}

/* ---- steps --------------------------------------------------------------------------------- */

typedef struct room {
    double *given; /* [first]: z, v */
    double *hidden, *a, *y;
    double *by[2]; /* [widest][first] of hidden units by z, v */
    double *out;   /* [n][widest] of y by the last hidden units */
    double *to;    /* [n][first] */
} room;

static room room_of(const decoupled *m, double *work)
{
    const size_t n = (size_t)m->states, first = first_of(m), wide = widest(m);
    room x;
    x.given = work;
    x.hidden = x.given + first;
    x.a = x.hidden + hidden_units(m);
    x.y = x.a + decoupled_outputs(m);
    x.by[0] = x.y + n;
    x.by[1] = x.by[0] + wide * first;
    x.out = x.by[1] + wide * first;
    x.to = x.out + n * wide;
    return x;
}

/* parts->to = derivatives of z at the end by z, v at the begin. */
static void differentiate(const decoupled *m, const decoupled_parts *parts, double t, const room *r)
{
    const size_t n = (size_t)m->states, first = first_of(m);
    const double *weights = parts->network, *hidden = r->hidden;
    double *by = r->by[0], *before = r->by[1];
    size_t in = first;
    for (int l = 0; l < m->layers; l++) {
        const size_t out = (size_t)m->width[l];
        memset(by, 0, out * first * sizeof *by);
        for (size_t i = 0; i < out; i++) {
            const double slope = 1 - hidden[i] * hidden[i];
            for (size_t k = 0; k < in; k++) {
                const double factor = slope * weights[i * in + k];
                if (l == 0) {
                    by[i * first + k] = factor;
                    continue;
                }
                for (size_t c = 0; c < first; c++) {
                    by[i * first + c] += factor * before[k * first + c];
                }
            }
        }
        weights += out * (in + 1);
        hidden += out;
        in = out;
        double *const other = by;
        by = before;
        before = other;
    }
    /* rows of the last layer, folded by dy/da */
    memset(r->out, 0, n * in * sizeof *r->out);
    for (size_t j = 0; j < n; j++) {
        for (size_t i = 0; i < (size_t)m->terms; i++) {
            const size_t row = 4 * (j * (size_t)m->terms + i);
            double of[4] = {0};
            sine_adjoint(r->a + row, t, 1, 0, of);
            for (size_t p = 0; p < 4; p++) {
                for (size_t k = 0; k < in && of[p] != 0; k++) {
                    r->out[j * in + k] += of[p] * weights[(row + p) * in + k];
                }
            }
        }
    }
    for (size_t j = 0; j < n; j++) {
        for (size_t c = 0; c < first; c++) {
            r->to[j * first + c] = c == j;
        }
        for (size_t k = 0; k < in; k++) {
            for (size_t c = 0; c < first; c++) {
                r->to[j * first + c] += r->out[j * in + k] * before[k * first + c];
            }
        }
    }
}

static void scale_derivatives(const decoupled *m, const decoupled_parts *parts, const room *r,
                              double *by_state, double *by_inputs)
{
    const size_t n = (size_t)m->states, inputs = (size_t)m->inputs, first = first_of(m);
    for (size_t j = 0; j < n; j++) {
        const double *row = r->to + j * first, scale = parts->state_scale[j];
        for (size_t c = 0; c < n && by_state; c++) {
            by_state[j * n + c] = scale * row[c] / parts->state_scale[c];
        }
        for (size_t c = 0; c < inputs && by_inputs; c++) { /* both ends of a ramp together */
            const double both = row[n + c] + (m->ramps ? row[n + inputs + c] : 0);
            by_inputs[j * inputs + c] = scale * both / parts->input_scale[c];
        }
    }
}

int decoupled_advance(const decoupled *m, double *work, int count, double h, const double *states,
                      const double *inputs, const double *after, double *next, double *by_state,
                      double *by_inputs)
{
    const decoupled_parts x = split(m);
    const room r = room_of(m, work);
    const size_t n = (size_t)m->states, number = (size_t)m->inputs;
    const double t = h / m->step;
    if (!(t > 0 && t <= 1 + 1e-9) || (after && !m->ramps)) {
        return 1;
    }
    double *z = r.given, *v = z + n;
    for (size_t i = 0; i < (size_t)count; i++) {
        const double *state = states + i * n, *u = inputs + i * number;
        const double *end = after ? after + i * number : u;
        double sum = 0;
        for (size_t j = 0; j < n; j++) {
            z[j] = (state[j] - x.state_center[j]) / x.state_scale[j];
        }
        for (size_t k = 0; k < number; k++) { /* what is known of the end is that of this step */
            v[k] = (u[k] - x.input_center[k]) / x.input_scale[k];
            if (m->ramps) {
                v[number + k] = v[k] + (end[k] - u[k]) / t / x.input_scale[k];
            }
        }
        decoupled_network(m, x.network, z, v, r.hidden, r.a);
        decoupled_curve(m, r.a, t, r.y, NULL);
        for (size_t j = 0; j < n; j++) {
            next[i * n + j] = state[j] + x.state_scale[j] * r.y[j];
            sum += next[i * n + j];
        }
        if (!isfinite(sum)) {
            return 1;
        }
        if (by_state || by_inputs) {
            differentiate(m, &x, t, &r);
            scale_derivatives(m, &x, &r, by_state ? by_state + i * n * n : NULL,
                              by_inputs ? by_inputs + i * n * number : NULL);
        }
    }
    return 0;
}

double decoupled_outside(const decoupled *m, const double *state, const double *inputs)
{
    const decoupled_parts x = split(m);
    double most = 0;
    for (int j = 0; j < m->states; j++) {
        const double z = fabs(state[j] - x.state_center[j]) / x.state_scale[j];
        most = fmax(most, isnan(z) ? INFINITY : z / x.state_range[j]);
    }
    for (int k = 0; k < m->inputs; k++) { /* the scale is half of the range */
        const double v = fabs(inputs[k] - x.input_center[k]) / x.input_scale[k];
        most = fmax(most, isnan(v) ? INFINITY : v);
    }
    return most;
}
