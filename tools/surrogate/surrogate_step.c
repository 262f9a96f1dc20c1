#include "tools/surrogate/surrogate_step.h"

#include "autodiff/tanh.h"
#include "physics/solve/processor.h"

#include <math.h>
#include <string.h>

enum { STEP_LANES = 8 };
typedef double step_lanes
    __attribute__((vector_size(STEP_LANES * sizeof(double)), aligned(sizeof(double)), may_alias));

/* ---- sizes --------------------------------------------------------------------------------- */

/* Where the numbers are, and widths of the two halves of a layer. */
typedef struct step_parts {
#define STEP_FIELD(name, count) const double *name;
    SURROGATE_STEP_NUMBERS(STEP_FIELD)
#undef STEP_FIELD
    const double *network;
} step_parts;

static int all_inputs(const surrogate_step *m)
{
    return m->ramps ? 2 * m->inputs : m->inputs;
}

static int blocks_of(const surrogate_step *m)
{
    return 1 + 2 * m->slow_count;
}

static size_t find_parts(const surrogate_step *of, step_parts *parts)
{
    const size_t n = (size_t)of->states, m = (size_t)all_inputs(of), c = (size_t)of->drives;
    const size_t blocks = (size_t)blocks_of(of);
    size_t at = 0;
#define STEP_PLACE(name, count)                                                                    \
    parts->name = of->numbers ? of->numbers + at : NULL;                                           \
    at += (size_t)(count);
    SURROGATE_STEP_NUMBERS(STEP_PLACE)
#undef STEP_PLACE
    parts->network = of->numbers ? of->numbers + at : NULL;
    return at;
}

/* Inputs or outputs of layer `at`, the last one among them: even ones, or odd ones. Without a
 * mirror all are even. */
static int layer_inputs(const surrogate_step *m, int at, bool odd)
{
    if (at > 0) {
        return m->mirrors ? m->width[at - 1] / 2 : odd ? 0 : m->width[at - 1];
    }
    return m->mirrors ? m->pairs + (odd ? m->odds : m->evens)
           : odd      ? 0
                      : 2 * m->pairs + m->evens + m->odds;
}

static int layer_outputs(const surrogate_step *m, int at, bool odd)
{
    if (at < m->layers) {
        return layer_inputs(m, at + 1, odd);
    }
    return m->mirrors ? m->out_pairs + (odd ? m->out_odds : m->out_evens)
           : odd      ? 0
                      : 2 * m->out_pairs + m->out_evens + m->out_odds;
}

size_t surrogate_step_parameters(const surrogate_step *m)
{
    size_t all = 0;
    for (int at = 0; at <= m->layers && m->layers > 0; at++) {
        all += (size_t)((layer_inputs(m, at, false) + 1) * layer_outputs(m, at, false) +
                        layer_inputs(m, at, true) * layer_outputs(m, at, true));
    }
    return all;
}

size_t surrogate_step_numbers(const surrogate_step *m)
{
    step_parts parts;
    return find_parts(m, &parts) + surrogate_step_parameters(m);
}

static int coordinates(const surrogate_step *m)
{
    return 2 * m->pairs + m->evens + m->odds;
}

static int outputs(const surrogate_step *m)
{
    return 2 * m->out_pairs + m->out_evens + m->out_odds;
}

static int widest(const surrogate_step *m)
{
    int most = coordinates(m) > outputs(m) ? coordinates(m) : outputs(m);
    for (int i = 0; i < m->layers; i++) {
        most = m->width[i] > most ? m->width[i] : most;
    }
    return most;
}

/* Padded to whole vectors. */
static int padded(int count)
{
    return (count + STEP_LANES - 1) / STEP_LANES * STEP_LANES;
}

/* Parts of the work, rows of lanes or of columns: name, count. */
#define STEP_WORK(X)                                                                               \
    X(z, coordinates(m) * STEP_LANES)                                                              \
    X(a, most *STEP_LANES)                                                                         \
    X(b, most *STEP_LANES)                                                                         \
    X(moved, blocks_of(m) * (m->states + all_inputs(m)) * STEP_LANES)                              \
    X(linear, m->states *STEP_LANES)                                                               \
    X(g, 2 * STEP_LANES) /* the frame: cosine and sine, shortened */                               \
    X(rho, STEP_LANES)                                                                             \
    /* of one state */                                                                             \
    X(framed, outputs(m)) /* the outputs before they are turned back */                            \
    X(kept, units)        /* of the hidden layers */                                               \
    X(by, most *columns)  /* derivatives */                                                        \
    X(by_too, most *columns)                                                                       \
    X(by_linear, (m->states + all_inputs(m)) * m->states)

typedef struct step_work {
#define STEP_FIELD(name, count) double *name;
    STEP_WORK(STEP_FIELD)
#undef STEP_FIELD
} step_work;

static size_t divide(const surrogate_step *m, double *work, step_work *x)
{
    const int most = padded(widest(m)), columns = padded(outputs(m));
    int units = 0;
    size_t at = 0;
    for (int i = 0; i < m->layers; i++) {
        units += m->width[i];
    }
#define STEP_PLACE(name, count)                                                                    \
    x->name = work ? work + at : NULL;                                                             \
    at += (size_t)(count);
    STEP_WORK(STEP_PLACE)
#undef STEP_PLACE
    return at;
}

size_t surrogate_step_work(const surrogate_step *m)
{
    step_work x;
    return divide(m, NULL, &x);
}

/* ---- products ------------------------------------------------------------------------------ */

/* Of one state: outputs in vectors from o on, the last of which ends with the last output and so
 * may find some twice; sums of several vectors at once do not wait for each other. */
PROCESSOR_INLINE void multiply_one(int vectors, int inputs, int outputs, int o, const double *w,
                                   const double *bias, const double *x, double *y)
{
    step_lanes sum[4] = {{0}};
    int at[4];
    for (int v = 0; v < vectors; v++) {
        at[v] =
            o + v * STEP_LANES < outputs - STEP_LANES ? o + v * STEP_LANES : outputs - STEP_LANES;
        if (bias) {
            memcpy(&sum[v], bias + at[v], sizeof *sum);
        }
    }
    for (int i = 0; i < inputs; i++) {
        const double *row = w + i * outputs;
        for (int v = 0; v < vectors; v++) {
            sum[v] += x[i] * *(const step_lanes *)(const void *)(row + at[v]);
        }
    }
    for (int v = 0; v < vectors; v++) {
        memcpy(y + at[v], &sum[v], sizeof *sum);
    }
}

/* y [outputs][lanes] = bias + w^T x for w [inputs][outputs], x [inputs][lanes]; the same sums in
 * the same order for any number of lanes. */
PROCESSOR_INLINE void multiply(int lanes, int inputs, int outputs, const double *w,
                               const double *bias, const double *x, double *y)
{
    int o = 0;
    if (lanes == 1) {
        for (; outputs >= STEP_LANES && o < outputs; o += 4 * STEP_LANES) {
            const int left = outputs - o;
            if (left > 3 * STEP_LANES) {
                multiply_one(4, inputs, outputs, o, w, bias, x, y);
            } else if (left > 2 * STEP_LANES) {
                multiply_one(3, inputs, outputs, o, w, bias, x, y);
            } else if (left > STEP_LANES) {
                multiply_one(2, inputs, outputs, o, w, bias, x, y);
            } else {
                multiply_one(1, inputs, outputs, o, w, bias, x, y);
            }
        }
        for (; o < outputs; o++) {
            double sum = bias ? bias[o] : 0;
            for (int i = 0; i < inputs; i++) {
                sum += x[i] * w[i * outputs + o];
            }
            y[o] = sum;
        }
        return;
    }
    for (; outputs >= 4 && o < outputs; o += 4) { /* the last ones end with the last output */
        step_lanes sum[4] = {{0}};
        const int at = o < outputs - 4 ? o : outputs - 4;
        for (int k = 0; k < 4 && bias; k++) {
            sum[k] += bias[at + k];
        }
        for (int i = 0; i < inputs; i++) {
            const step_lanes now = *(const step_lanes *)(const void *)(x + i * STEP_LANES);
            const double *row = w + i * outputs + at;
            for (int k = 0; k < 4; k++) {
                sum[k] += row[k] * now;
            }
        }
        memcpy(y + at * STEP_LANES, sum, sizeof sum);
    }
    for (; o < outputs; o++) {
        step_lanes sum = {0};
        sum += bias ? bias[o] : 0;
        for (int i = 0; i < inputs; i++) {
            sum += w[i * outputs + o] * *(const step_lanes *)(const void *)(x + i * STEP_LANES);
        }
        memcpy(y + o * STEP_LANES, &sum, sizeof sum);
    }
}

/* One layer: x [even inputs, then odd ones][lanes]; y likewise. Returns what follows its numbers.
 */
PROCESSOR_INLINE const double *layer(const surrogate_step *m, int lanes, int at,
                                     const double *numbers, const double *x, double *y)
{
    const int in = layer_inputs(m, at, false), out = layer_outputs(m, at, false);
    const int in_odd = layer_inputs(m, at, true), out_odd = layer_outputs(m, at, true);
    const double *bias = numbers + in * out, *odd = bias + out;
    multiply(lanes, in, out, numbers, bias, x, y);
    multiply(lanes, in_odd, out_odd, odd, NULL, x + in * lanes, y + out * lanes);
    return odd + in_odd * out_odd;
}

/* Units of y [width][lanes], sums and differences of what a mirror exchanges; kept (or NULL) are
 * the units themselves. */
PROCESSOR_INLINE void activate(const surrogate_step *m, int lanes, int width, double *y,
                               double *kept)
{
    const int half = m->mirrors ? width / 2 * lanes : 0;
    for (int i = 0; i < half; i++) {
        const double even = y[i], odd = y[half + i];
        y[i] = even + odd;
        y[half + i] = even - odd;
    }
    for (int i = 0; i < width * lanes; i++) {
        y[i] = ad_tanh_number(y[i]);
    }
    if (kept) {
        memcpy(kept, y, (size_t)(width * lanes) * sizeof *y);
    }
    for (int i = 0; i < half; i++) {
        const double one = 0.5 * y[i], other = 0.5 * y[half + i];
        y[i] = one + other;
        y[half + i] = one - other;
    }
}

/* ---- values -------------------------------------------------------------------------------- */

/* Where output `k` of states stands among the network's. */
PROCESSOR_INLINE int output_of(const surrogate_step *m, int slot)
{
    return slot < m->pairs       ? slot
           : slot < 2 * m->pairs ? slot - m->pairs + m->out_pairs
           : slot < 2 * m->pairs + m->evens
               ? slot - 2 * m->pairs + 2 * m->out_pairs
               : slot - 2 * m->pairs - m->evens + 2 * m->out_pairs + m->out_evens;
}

/* (p + iq)(c + is) in place. */
PROCESSOR_INLINE void turn(int lanes, const double *c, const double *s, double sign, double *p,
                           double *q)
{
    for (int l = 0; l < lanes; l++) {
        const double re = p[l] * c[l] - sign * (q[l] * s[l]);
        q[l] = p[l] * (sign * s[l]) + q[l] * c[l];
        p[l] = re;
    }
}

/* z in the frame becomes the network's inputs x->a, in the order of layer(). */
PROCESSOR_INLINE void enter_frame(const surrogate_step *m, int lanes, const step_parts *parts,
                                  step_work *x)
{
    const int p = m->pairs, rest = m->evens + m->odds;
    double *im = x->z + p * lanes;
    for (int l = 0; l < lanes; l++) {
        x->g[l] = 1;
        x->g[lanes + l] = 0;
    }
    for (int l = 0; l < lanes && m->turns; l++) {
        double re = 0, up = 0;
        for (int k = 0; k < p; k++) {
            re += parts->lead[k] * x->z[k * lanes + l];
            up += parts->lead[k] * im[k * lanes + l];
        }
        const double rho = sqrt(re * re + up * up + m->soft * m->soft);
        x->rho[l] = rho;
        x->g[l] = re / rho;
        x->g[lanes + l] = -up / rho;
    }
    memcpy(x->a, x->z, (size_t)((2 * p + rest) * lanes) * sizeof *x->a);
    for (int k = 0; k < p && m->turns; k++) {
        turn(lanes, x->g, x->g + lanes, 1, x->a + k * lanes, x->a + (p + k) * lanes);
    }
    if (m->mirrors) { /* first components and evens, then second ones and odds */
        const size_t row = (size_t)lanes * sizeof *x->b;
        memcpy(x->b, x->a + p * lanes, (size_t)p * row);
        memmove(x->a + p * lanes, x->a + 2 * p * lanes, (size_t)m->evens * row);
        memcpy(x->a + (p + m->evens) * lanes, x->b, (size_t)p * row);
    }
}

/* What layer() leaves in x->a becomes [first components, second ones, evens, odds], turned back. */
PROCESSOR_INLINE void leave_frame(const surrogate_step *m, int lanes, step_work *x)
{
    const int p = m->out_pairs;
    if (m->mirrors) {
        const size_t row = (size_t)lanes * sizeof *x->b;
        memcpy(x->b, x->a + p * lanes, (size_t)m->out_evens * row);
        memmove(x->a + p * lanes, x->a + (p + m->out_evens) * lanes, (size_t)p * row);
        memcpy(x->a + 2 * p * lanes, x->b, (size_t)m->out_evens * row);
    }
    if (lanes == 1) {
        memcpy(x->framed, x->a, (size_t)outputs(m) * sizeof *x->framed);
    }
    for (int k = 0; k < p && m->turns; k++) {
        turn(lanes, x->g, x->g + lanes, -1, x->a + k * lanes, x->a + (p + k) * lanes);
    }
}

/* The network's outputs in x->a for coordinates x->z. */
PROCESSOR_INLINE void network(const surrogate_step *m, int lanes, const step_parts *parts,
                              step_work *x)
{
    const double *numbers = parts->network;
    double *kept = x->kept;
    enter_frame(m, lanes, parts, x);
    for (int at = 0; at <= m->layers; at++) {
        double *swap = x->a;
        numbers = layer(m, lanes, at, numbers, x->a, x->b);
        if (at < m->layers) {
            activate(m, lanes, m->width[at], x->b, lanes == 1 ? kept : NULL);
            kept += m->width[at];
        }
        x->a = x->b;
        x->b = swap;
    }
}

/* Coordinates x->z of `lanes` states, and in x->moved how far states and inputs are from the
 * centers; rows beyond `count` repeat the last one. */
PROCESSOR_INLINE void enter(const surrogate_step *m, int lanes, int count, const step_parts *parts,
                            step_work *x, const double *states, const double *inputs,
                            const double *after)
{
    const int n = m->states, all = all_inputs(m), given = m->inputs;
    for (int l = 0; l < lanes; l++) {
        const int row = l < count ? l : count - 1;
        for (int k = 0; k < n; k++) {
            const double moved = states[row * n + k] - parts->state_center[k];
            x->moved[k * lanes + l] = moved;
            x->z[m->state_slot[k] * lanes + l] = moved / parts->state_scale[k];
        }
        for (int i = 0; i < all; i++) {
            const double *u =
                i < given ? inputs + row * given + i : after + row * given + i - given;
            x->moved[(n + i) * lanes + l] = *u - parts->input_center[i];
        }
    }
    for (int j = 0; j < m->slow_count; j++) { /* times c and c^2 */
        const int size = (n + all) * lanes, i = m->slow[j];
        const double half = 0.5 * (parts->input_high[i] - parts->input_low[i]);
        double *to = x->moved + (1 + 2 * j) * size;
        for (int k = 0; k < size; k++) {
            const double c = x->moved[(n + i) * lanes + k % lanes] / half;
            to[k] = c * x->moved[k];
            to[size + k] = c * to[k];
        }
    }
    multiply(lanes, all, m->drives, parts->input_map, NULL, x->moved + n * lanes, x->a);
    for (int k = 0; k < m->drives; k++) {
        memcpy(x->z + m->input_slot[k] * lanes, x->a + k * lanes, (size_t)lanes * sizeof *x->z);
    }
}

PROCESSOR_INLINE void step_tile(const surrogate_step *m, int lanes, int count,
                                const step_parts *parts, step_work *x, const double *states,
                                const double *inputs, const double *after, double *next)
{
    const int n = m->states;
    enter(m, lanes, count, parts, x, states, inputs, after);
    multiply(lanes, blocks_of(m) * (n + all_inputs(m)), n, parts->linear, parts->next_center,
             x->moved, x->linear);
    if (m->layers > 0) {
        network(m, lanes, parts, x);
        leave_frame(m, lanes, x);
        for (int r = 0; r < n; r++) {
            const double *correction = x->a + output_of(m, m->state_slot[r]) * lanes;
            for (int l = 0; l < lanes; l++) {
                x->linear[r * lanes + l] += parts->state_scale[r] * correction[l];
            }
        }
    }
    for (int l = 0; l < lanes && l < count; l++) {
        for (int r = 0; r < n; r++) {
            next[l * n + r] = x->linear[r * lanes + l];
        }
    }
}

FOR_EACH_PROCESSOR static void step_one(const surrogate_step *m, const step_parts *parts,
                                        step_work *x, const double *state, const double *inputs,
                                        const double *after, double *next)
{
    step_tile(m, 1, 1, parts, x, state, inputs, after, next);
}

FOR_EACH_PROCESSOR static void step_many(const surrogate_step *m, int count,
                                         const step_parts *parts, step_work *x,
                                         const double *states, const double *inputs,
                                         const double *after, double *next)
{
    step_tile(m, STEP_LANES, count, parts, x, states, inputs, after, next);
}

/* ---- derivatives, of one state ------------------------------------------------------------- */

/* to [rows][columns] = w [rows][outputs] from [outputs][columns]; rows: a constant, at most 4. */
PROCESSOR_INLINE void multiply_tile(int rows, int outputs, int columns, const double *w,
                                    const double *from, double *to)
{
    for (int c = 0; c < columns; c += STEP_LANES) {
        step_lanes sum[4] = {{0}};
        for (int o = 0; o < outputs; o++) {
            const step_lanes now = *(const step_lanes *)(const void *)(from + o * columns + c);
            for (int k = 0; k < rows; k++) {
                sum[k] += w[k * outputs + o] * now;
            }
        }
        for (int k = 0; k < rows; k++) {
            memcpy(to + k * columns + c, &sum[k], sizeof sum[k]);
        }
    }
}

/* Rows [columns] of derivatives of all outputs, one row by each number. to [inputs] = w from for
 * from [outputs]. */
PROCESSOR_INLINE void multiply_rows(int inputs, int outputs, int columns, const double *w,
                                    const double *from, double *to)
{
    int i = 0;
    for (; i + 4 <= inputs; i += 4) {
        multiply_tile(4, outputs, columns, w + i * outputs, from, to + i * columns);
    }
    for (; i < inputs; i++) {
        multiply_tile(1, outputs, columns, w + i * outputs, from, to + i * columns);
    }
}

/* Back through units whose values are kept [width]. */
PROCESSOR_INLINE void differentiate_units(const surrogate_step *m, int width, int columns,
                                          const double *kept, double *by)
{
    const int half = width / 2;
    for (int i = 0; i < (m->mirrors ? half : width); i++) {
        const double slope = 1 - kept[i] * kept[i];
        double *row = by + i * columns, *odd = by + (half + i) * columns;
        if (!m->mirrors) {
            for (int c = 0; c < columns; c++) {
                row[c] *= slope;
            }
            continue;
        }
        const double other = 1 - kept[half + i] * kept[half + i];
        const double same = 0.5 * (slope + other), cross = 0.5 * (slope - other);
        for (int c = 0; c < columns; c++) {
            const double even = row[c], was = odd[c];
            row[c] = same * even + cross * was;
            odd[c] = cross * even + same * was;
        }
    }
}

/* x->by becomes derivatives of the outputs in the frame, as layer() orders both, by its inputs. */
PROCESSOR_INLINE void differentiate_network(const surrogate_step *m, int columns,
                                            const step_parts *parts, step_work *x)
{
    const double *numbers[SURROGATE_LAYERS_MAX + 1], *at = parts->network, *kept = x->kept;
    for (int l = 0; l <= m->layers; l++) {
        numbers[l] = at;
        at += (layer_inputs(m, l, false) + 1) * layer_outputs(m, l, false) +
              layer_inputs(m, l, true) * layer_outputs(m, l, true);
    }
    for (int l = 0; l < m->layers; l++) {
        kept += m->width[l];
    }
    for (int l = m->layers; l >= 0; l--) {
        const int in = layer_inputs(m, l, false), out = layer_outputs(m, l, false);
        const int in_odd = layer_inputs(m, l, true), out_odd = layer_outputs(m, l, true);
        const double *odd = numbers[l] + (in + 1) * out;
        double *swap = x->by;
        if (l == m->layers) { /* the weights themselves */
            memset(x->by_too, 0, (size_t)((in + in_odd) * columns) * sizeof *x->by);
            for (int i = 0; i < in + in_odd; i++) {
                const double *row = i < in ? numbers[l] + i * out : odd + (i - in) * out_odd;
                memcpy(x->by_too + i * columns + (i < in ? 0 : out), row,
                       (size_t)(i < in ? out : out_odd) * sizeof *row);
            }
        } else {
            multiply_rows(in, out, columns, numbers[l], x->by, x->by_too);
            multiply_rows(in_odd, out_odd, columns, odd, x->by + out * columns,
                          x->by_too + in * columns);
        }
        x->by = x->by_too;
        x->by_too = swap;
        if (l > 0) {
            kept -= m->width[l - 1];
            differentiate_units(m, m->width[l - 1], columns, kept, x->by);
        }
    }
}

/* Columns in the order [first components, second ones, evens, odds] and rows likewise, by z in the
 * frame; with a mirror layer() has another order of both. */
PROCESSOR_INLINE void reorder(const surrogate_step *m, int columns, step_work *x)
{
    const int p = m->pairs, q = m->out_pairs, count = coordinates(m), outs = outputs(m);
    double *swap = x->by;
    for (int i = 0; i < count && m->mirrors; i++) {
        const int row = i < p ? i : i < 2 * p ? i + m->evens : i < 2 * p + m->evens ? i - p : i;
        for (int o = 0; o < outs; o++) {
            const int column = o < q                      ? o
                               : o < 2 * q                ? o + m->out_evens
                               : o < 2 * q + m->out_evens ? o - q
                                                          : o;
            x->by_too[i * columns + o] = x->by[row * columns + column];
        }
    }
    if (m->mirrors) {
        x->by = x->by_too;
        x->by_too = swap;
    }
}

/* What the frame adds: pairs of inputs and outputs turn, and the frame moves with its leading pair.
 */
PROCESSOR_INLINE void differentiate_frame(const surrogate_step *m, int columns,
                                          const step_parts *parts, step_work *x)
{
    const int p = m->pairs, q = m->out_pairs, outs = outputs(m), count = coordinates(m);
    const double c = x->g[0], s = x->g[1], rho = x->rho[0];
    /* derivatives of c and s by the leading pair */
    const double by_w[2][2] = {{(1 - c * c) / rho, c * s / rho}, {-c * s / rho, (s * s - 1) / rho}};
    double *by_c = x->by_too, *by_s = by_c + columns;
    memset(by_c, 0, (size_t)(2 * columns) * sizeof *by_c);
    for (int k = 0; k < p; k++) {
        const double re = x->z[k], im = x->z[p + k];
        double *one = x->by + k * columns, *other = x->by + (p + k) * columns;
        for (int o = 0; o < outs; o++) {
            by_c[o] += one[o] * re + other[o] * im;
            by_s[o] += other[o] * re - one[o] * im;
            const double turned = one[o] * c + other[o] * s;
            other[o] = other[o] * c - one[o] * s;
            one[o] = turned;
        }
    }
    for (int i = 0; i < count + 2; i++) { /* outputs times c - is */
        double *row = i < count ? x->by + i * columns : by_c + (i - count) * columns;
        for (int k = 0; k < q; k++) {
            const double re = row[k], im = row[q + k];
            row[k] = re * c + im * s;
            row[q + k] = im * c - re * s;
        }
    }
    for (int k = 0; k < q; k++) { /* and their own turn */
        by_c[k] += x->framed[k];
        by_s[k] += x->framed[q + k];
        by_c[q + k] += x->framed[q + k];
        by_s[q + k] -= x->framed[k];
    }
    for (int k = 0; k < p; k++) {
        for (int o = 0; o < outs; o++) {
            x->by[k * columns + o] +=
                parts->lead[k] * (by_c[o] * by_w[0][0] + by_s[o] * by_w[1][0]);
            x->by[(p + k) * columns + o] +=
                parts->lead[k] * (by_c[o] * by_w[0][1] + by_s[o] * by_w[1][1]);
        }
    }
}

/* x->by_linear: derivatives [n + inputs][n] of the linear map. */
PROCESSOR_INLINE void differentiate_linear(const surrogate_step *m, const step_parts *parts,
                                           step_work *x)
{
    const int n = m->states, rows = n + all_inputs(m), size = rows * n;
    memcpy(x->by_linear, parts->linear, (size_t)size * sizeof *x->by_linear);
    for (int j = 0; j < m->slow_count; j++) {
        const int i = m->slow[j];
        const double half = 0.5 * (parts->input_high[i] - parts->input_low[i]);
        const double c = x->moved[n + i] / half;
        const double *one = parts->linear + (1 + 2 * j) * size, *two = one + size;
        double *by_slow = x->by_linear + (n + i) * n;
        for (int k = 0; k < size; k++) {
            x->by_linear[k] += c * (one[k] + c * two[k]);
        }
        for (int k = 0; k < rows; k++) {
            for (int r = 0; r < n; r++) {
                by_slow[r] += x->moved[k] * (one[k * n + r] + 2 * c * two[k * n + r]) / half;
            }
        }
    }
}

/* From x->by, derivatives of outputs in the world by coordinates, to those of the state. */
PROCESSOR_INLINE void collect(const surrogate_step *m, int columns, const step_parts *parts,
                              const step_work *x, double *by_state, double *by_inputs)
{
    const int n = m->states, all = all_inputs(m);
    for (int r = 0; r < n; r++) {
        const int o = output_of(m, m->state_slot[r]);
        for (int k = 0; k < n && by_state; k++) {
            const double moved = m->layers > 0 ? x->by[m->state_slot[k] * columns + o] : 0;
            by_state[r * n + k] =
                x->by_linear[k * n + r] + parts->state_scale[r] * moved / parts->state_scale[k];
        }
        for (int i = 0; i < m->inputs && by_inputs; i++) {
            double sum = 0;
            for (int end = i; end < all; end += m->inputs) {
                double moved = 0;
                for (int k = 0; k < m->drives && m->layers > 0; k++) {
                    moved += parts->input_map[end * m->drives + k] *
                             x->by[m->input_slot[k] * columns + o];
                }
                sum += x->by_linear[(n + end) * n + r] + parts->state_scale[r] * moved;
            }
            by_inputs[r * m->inputs + i] = sum;
        }
    }
}

FOR_EACH_PROCESSOR static void step_derivatives(const surrogate_step *m, const step_parts *parts,
                                                step_work *x, const double *state,
                                                const double *inputs, const double *after,
                                                double *next, double *by_state, double *by_inputs)
{
    const int columns = padded(outputs(m));
    step_tile(m, 1, 1, parts, x, state, inputs, after, next);
    if (m->layers > 0) {
        differentiate_network(m, columns, parts, x);
        reorder(m, columns, x);
        if (m->turns) {
            differentiate_frame(m, columns, parts, x);
        }
    }
    differentiate_linear(m, parts, x);
    collect(m, columns, parts, x, by_state, by_inputs);
}

/* ---- steps --------------------------------------------------------------------------------- */

int surrogate_step_advance(const surrogate_step *m, double *work, int count, double h,
                           const double *states, const double *inputs, const double *after,
                           double *next, double *by_state, double *by_inputs)
{
    const int n = m->states, inputs_count = m->inputs;
    const bool derive = by_state || by_inputs;
    step_parts parts;
    step_work x;
    if (fabs(h - m->step) > 1e-9 * m->step || (after && !m->ramps)) {
        return 2;
    }
    after = m->ramps && !after ? inputs : after;
    find_parts(m, &parts);
    divide(m, work, &x);
    for (int i = 0; i < count;) {
        const double *state = states + i * n, *u = inputs + i * inputs_count;
        const double *end = after ? after + i * inputs_count : NULL;
        const int lanes = derive || count - i < STEP_LANES / 2 ? 1 : STEP_LANES;
        if (derive) {
            step_derivatives(m, &parts, &x, state, u, end, next + i * n,
                             by_state ? by_state + i * n * n : NULL,
                             by_inputs ? by_inputs + i * n * inputs_count : NULL);
        } else if (lanes == 1) {
            step_one(m, &parts, &x, state, u, end, next + i * n);
        } else {
            step_many(m, count - i, &parts, &x, state, u, end, next + i * n);
        }
        i += lanes;
    }
    double sum = 0; /* not finite if any number is */
    for (int i = 0; i < count * n; i++) {
        sum += 0 * next[i];
    }
    return sum == 0 ? 0 : 1;
}

double surrogate_step_outside(const surrogate_step *m, const double *state, const double *inputs)
{
    step_parts parts;
    double most = 0;
    find_parts(m, &parts);
    for (int k = 0; k < m->states + m->inputs; k++) {
        const int i = k - m->states;
        const double here = k < m->states
                                ? fabs(state[k] - parts.state_center[k]) / parts.state_range[k]
                                : fabs(2 * inputs[i] - parts.input_low[i] - parts.input_high[i]) /
                                      (parts.input_high[i] - parts.input_low[i]);
        if (!(here <= most)) {
            most = isnan(here) ? INFINITY : here;
        }
    }
    return most;
}
