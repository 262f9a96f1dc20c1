/* Within tools/surrogate: one step of a trained model, inline for each way in which it is compiled.
 */
#ifndef STEP_MAP_H
#define STEP_MAP_H

#include "autodiff/run/tanh.h"
#include "physics/numerics/processor.h"
#include "tools/surrogate/surrogate_step.h"

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

PROCESSOR_INLINE int step_all_inputs(const surrogate_step *m)
{
    return m->ramps ? 2 * m->inputs : m->inputs;
}

PROCESSOR_INLINE int step_blocks_of(const surrogate_step *m)
{
    return 1 + 2 * m->slow_count;
}

PROCESSOR_INLINE size_t step_find_parts(const surrogate_step *of, step_parts *parts)
{
    const size_t n = (size_t)of->states, m = (size_t)step_all_inputs(of), c = (size_t)of->drives;
    const size_t blocks = (size_t)step_blocks_of(of);
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
PROCESSOR_INLINE int step_layer_inputs(const surrogate_step *m, int at, bool odd)
{
    if (at > 0) {
        return m->mirrors ? m->width[at - 1] / 2 : odd ? 0 : m->width[at - 1];
    }
    return m->mirrors ? m->pairs + (odd ? m->odds : m->evens)
           : odd      ? 0
                      : 2 * m->pairs + m->evens + m->odds;
}

PROCESSOR_INLINE int step_layer_outputs(const surrogate_step *m, int at, bool odd)
{
    if (at < m->layers) {
        return step_layer_inputs(m, at + 1, odd);
    }
    return m->mirrors ? m->out_pairs + (odd ? m->out_odds : m->out_evens)
           : odd      ? 0
                      : 2 * m->out_pairs + m->out_evens + m->out_odds;
}

PROCESSOR_INLINE int step_coordinates(const surrogate_step *m)
{
    return 2 * m->pairs + m->evens + m->odds;
}

PROCESSOR_INLINE int step_outputs(const surrogate_step *m)
{
    return 2 * m->out_pairs + m->out_evens + m->out_odds;
}

PROCESSOR_INLINE int step_widest(const surrogate_step *m)
{
    int most = step_coordinates(m) > step_outputs(m) ? step_coordinates(m) : step_outputs(m);
    for (int i = 0; i < m->layers; i++) {
        most = m->width[i] > most ? m->width[i] : most;
    }
    return most;
}

/* Padded to whole vectors. */
PROCESSOR_INLINE int step_padded(int count)
{
    return (count + STEP_LANES - 1) / STEP_LANES * STEP_LANES;
}

/* Parts of the work, rows of lanes or of columns: name, count. */
#define STEP_WORK(X)                                                                               \
    X(z, step_coordinates(m) * STEP_LANES)                                                         \
    X(a, most *STEP_LANES)                                                                         \
    X(b, most *STEP_LANES)                                                                         \
    X(moved, step_blocks_of(m) * (m->states + step_all_inputs(m)) * STEP_LANES)                    \
    X(linear, m->states *STEP_LANES)                                                               \
    X(g, 2 * STEP_LANES) /* the frame: cosine and sine, shortened */                               \
    X(rho, STEP_LANES)                                                                             \
    /* of one state */                                                                             \
    X(framed, step_outputs(m)) /* the outputs before they are turned back */                       \
    X(kept, units)             /* of the hidden layers */                                          \
    X(by, most *columns)       /* derivatives */                                                   \
    X(by_too, most *columns)                                                                       \
    X(by_linear, (m->states + step_all_inputs(m)) * m->states)

typedef struct step_work {
#define STEP_FIELD(name, count) double *name;
    STEP_WORK(STEP_FIELD)
#undef STEP_FIELD
} step_work;

PROCESSOR_INLINE size_t step_divide(const surrogate_step *m, double *work, step_work *to)
{
    const int most = step_padded(step_widest(m)), columns = step_padded(step_outputs(m));
    int units = 0;
    size_t at = 0;
    for (int i = 0; i < m->layers; i++) {
        units += m->width[i];
    }
#define STEP_PLACE(name, count)                                                                    \
    to->name = work ? work + at : NULL;                                                            \
    at += (size_t)(count);
    STEP_WORK(STEP_PLACE)
#undef STEP_PLACE
    return at;
}

/* ---- products ------------------------------------------------------------------------------ */

/* Of one state: outputs in vectors from o on, the last of which ends with the last output and so
 * may find some twice; sums of several vectors at once do not wait for each other. */
PROCESSOR_INLINE void step_multiply_one(int vectors, int inputs, int outputs, int o,
                                        const double *w, const double *bias, const double *x,
                                        double *y)
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
PROCESSOR_INLINE void step_multiply(int lanes, int inputs, int outputs, const double *w,
                                    const double *bias, const double *x, double *y)
{
    int o = 0;
    if (lanes == 1) {
        for (; outputs >= STEP_LANES && o < outputs; o += 4 * STEP_LANES) {
            const int left = outputs - o;
            if (left > 3 * STEP_LANES) {
                step_multiply_one(4, inputs, outputs, o, w, bias, x, y);
            } else if (left > 2 * STEP_LANES) {
                step_multiply_one(3, inputs, outputs, o, w, bias, x, y);
            } else if (left > STEP_LANES) {
                step_multiply_one(2, inputs, outputs, o, w, bias, x, y);
            } else {
                step_multiply_one(1, inputs, outputs, o, w, bias, x, y);
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
PROCESSOR_INLINE const double *step_layer(const surrogate_step *m, int lanes, int at,
                                          const double *numbers, const double *x, double *y)
{
    const int in = step_layer_inputs(m, at, false), out = step_layer_outputs(m, at, false);
    const int in_odd = step_layer_inputs(m, at, true), out_odd = step_layer_outputs(m, at, true);
    const double *bias = numbers + in * out, *odd = bias + out;
    step_multiply(lanes, in, out, numbers, bias, x, y);
    step_multiply(lanes, in_odd, out_odd, odd, NULL, x + in * lanes, y + out * lanes);
    return odd + in_odd * out_odd;
}

/* Units of y [width][lanes], sums and differences of what a mirror exchanges; kept (or NULL) are
 * the units themselves. */
PROCESSOR_INLINE void step_activate(const surrogate_step *m, int lanes, int width, double *y,
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
PROCESSOR_INLINE int step_output_of(const surrogate_step *m, int slot)
{
    return slot < m->pairs       ? slot
           : slot < 2 * m->pairs ? slot - m->pairs + m->out_pairs
           : slot < 2 * m->pairs + m->evens
               ? slot - 2 * m->pairs + 2 * m->out_pairs
               : slot - 2 * m->pairs - m->evens + 2 * m->out_pairs + m->out_evens;
}

/* (p + iq)(c + is) in place. */
PROCESSOR_INLINE void step_turn(int lanes, const double *c, const double *s, double sign, double *p,
                                double *q)
{
    for (int l = 0; l < lanes; l++) {
        const double re = p[l] * c[l] - sign * (q[l] * s[l]);
        q[l] = p[l] * (sign * s[l]) + q[l] * c[l];
        p[l] = re;
    }
}

/* z in the frame becomes the network's inputs work->a, in the order of step_layer(). */
PROCESSOR_INLINE void step_enter_frame(const surrogate_step *m, int lanes, const step_parts *parts,
                                       step_work *work)
{
    const int p = m->pairs, rest = m->evens + m->odds;
    double *im = work->z + p * lanes;
    for (int l = 0; l < lanes; l++) {
        work->g[l] = 1;
        work->g[lanes + l] = 0;
    }
    for (int l = 0; l < lanes && m->turns; l++) {
        double re = 0, up = 0;
        for (int k = 0; k < p; k++) {
            re += parts->lead[k] * work->z[k * lanes + l];
            up += parts->lead[k] * im[k * lanes + l];
        }
        const double rho = sqrt(re * re + up * up + m->soft * m->soft);
        work->rho[l] = rho;
        work->g[l] = re / rho;
        work->g[lanes + l] = -up / rho;
    }
    memcpy(work->a, work->z, (size_t)((2 * p + rest) * lanes) * sizeof *work->a);
    for (int k = 0; k < p && m->turns; k++) {
        step_turn(lanes, work->g, work->g + lanes, 1, work->a + k * lanes,
                  work->a + (p + k) * lanes);
    }
    if (m->mirrors) { /* first components and evens, then second ones and odds */
        const size_t row = (size_t)lanes * sizeof *work->b;
        memcpy(work->b, work->a + p * lanes, (size_t)p * row);
        memmove(work->a + p * lanes, work->a + 2 * p * lanes, (size_t)m->evens * row);
        memcpy(work->a + (p + m->evens) * lanes, work->b, (size_t)p * row);
    }
}

/* What step_layer() leaves in work->a becomes [first components, second ones, evens, odds], turned
 * back. */
PROCESSOR_INLINE void step_leave_frame(const surrogate_step *m, int lanes, step_work *work)
{
    const int p = m->out_pairs;
    if (m->mirrors) {
        const size_t row = (size_t)lanes * sizeof *work->b;
        memcpy(work->b, work->a + p * lanes, (size_t)m->out_evens * row);
        memmove(work->a + p * lanes, work->a + (p + m->out_evens) * lanes, (size_t)p * row);
        memcpy(work->a + 2 * p * lanes, work->b, (size_t)m->out_evens * row);
    }
    if (lanes == 1) {
        memcpy(work->framed, work->a, (size_t)step_outputs(m) * sizeof *work->framed);
    }
    for (int k = 0; k < p && m->turns; k++) {
        step_turn(lanes, work->g, work->g + lanes, -1, work->a + k * lanes,
                  work->a + (p + k) * lanes);
    }
}

/* The network's outputs in work->a for coordinates work->z. */
PROCESSOR_INLINE void step_network(const surrogate_step *m, int lanes, const step_parts *parts,
                                   step_work *work)
{
    const double *numbers = parts->network;
    double *kept = work->kept;
    step_enter_frame(m, lanes, parts, work);
    for (int at = 0; at <= m->layers; at++) {
        double *swap = work->a;
        numbers = step_layer(m, lanes, at, numbers, work->a, work->b);
        if (at < m->layers) {
            step_activate(m, lanes, m->width[at], work->b, lanes == 1 ? kept : NULL);
            kept += m->width[at];
        }
        work->a = work->b;
        work->b = swap;
    }
}

/* Coordinates work->z of `lanes` states, and in work->moved how far states and inputs are from the
 * centers; rows beyond `count` repeat the last one. */
PROCESSOR_INLINE void step_enter(const surrogate_step *m, int lanes, int count,
                                 const step_parts *parts, step_work *work, const double *states,
                                 const double *inputs, const double *after)
{
    const int n = m->states, all = step_all_inputs(m), given = m->inputs;
    for (int l = 0; l < lanes; l++) {
        const int row = l < count ? l : count - 1;
        for (int k = 0; k < n; k++) {
            const double moved = states[row * n + k] - parts->state_center[k];
            work->moved[k * lanes + l] = moved;
            work->z[m->state_slot[k] * lanes + l] = moved / parts->state_scale[k];
        }
        for (int i = 0; i < all; i++) {
            const double *u =
                i < given ? inputs + row * given + i : after + row * given + i - given;
            work->moved[(n + i) * lanes + l] = *u - parts->input_center[i];
        }
    }
    for (int j = 0; j < m->slow_count; j++) { /* times c and c^2 */
        const int size = (n + all) * lanes, i = m->slow[j];
        const double half = 0.5 * (parts->input_high[i] - parts->input_low[i]);
        double *to = work->moved + (1 + 2 * j) * size;
        for (int k = 0; k < size; k++) {
            const double c = work->moved[(n + i) * lanes + k % lanes] / half;
            to[k] = c * work->moved[k];
            to[size + k] = c * to[k];
        }
    }
    step_multiply(lanes, all, m->drives, parts->input_map, NULL, work->moved + n * lanes, work->a);
    for (int k = 0; k < m->drives; k++) {
        memcpy(work->z + m->input_slot[k] * lanes, work->a + k * lanes,
               (size_t)lanes * sizeof *work->z);
    }
}

PROCESSOR_INLINE void step_tile(const surrogate_step *m, int lanes, int count,
                                const step_parts *parts, step_work *work, const double *states,
                                const double *inputs, const double *after, double *next)
{
    const int n = m->states;
    step_enter(m, lanes, count, parts, work, states, inputs, after);
    step_multiply(lanes, step_blocks_of(m) * (n + step_all_inputs(m)), n, parts->linear,
                  parts->next_center, work->moved, work->linear);
    if (m->layers > 0) {
        step_network(m, lanes, parts, work);
        step_leave_frame(m, lanes, work);
        for (int r = 0; r < n; r++) {
            const double *correction = work->a + step_output_of(m, m->state_slot[r]) * lanes;
            for (int l = 0; l < lanes; l++) {
                work->linear[r * lanes + l] += parts->state_scale[r] * correction[l];
            }
        }
    }
    for (int l = 0; l < lanes && l < count; l++) {
        for (int r = 0; r < n; r++) {
            next[l * n + r] = work->linear[r * lanes + l];
        }
    }
}

/* One step as surrogate_step_advance has it, with derivatives unless NULL. */
void surrogate_step_differentiate(const surrogate_step *m, const step_parts *parts, step_work *work,
                                  const double *state, const double *inputs, const double *after,
                                  double *next, double *by_state, double *by_inputs);

#endif
