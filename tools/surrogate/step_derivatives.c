/* Derivatives of one step by state and inputs. */
#include "tools/surrogate/step_map.h"

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

/* work->by becomes derivatives of the outputs in the frame, as step_layer() orders both, by its
 * inputs. */
PROCESSOR_INLINE void differentiate_network(const surrogate_step *m, int columns,
                                            const step_parts *parts, step_work *work)
{
    const double *numbers[SURROGATE_LAYERS_MAX + 1], *at = parts->network, *kept = work->kept;
    for (int l = 0; l <= m->layers; l++) {
        numbers[l] = at;
        at += (step_layer_inputs(m, l, false) + 1) * step_layer_outputs(m, l, false) +
              step_layer_inputs(m, l, true) * step_layer_outputs(m, l, true);
    }
    for (int l = 0; l < m->layers; l++) {
        kept += m->width[l];
    }
    for (int l = m->layers; l >= 0; l--) {
        const int in = step_layer_inputs(m, l, false), out = step_layer_outputs(m, l, false);
        const int in_odd = step_layer_inputs(m, l, true), out_odd = step_layer_outputs(m, l, true);
        const double *odd = numbers[l] + (in + 1) * out;
        double *swap = work->by;
        if (l == m->layers) { /* the weights themselves */
            memset(work->by_too, 0, (size_t)((in + in_odd) * columns) * sizeof *work->by);
            for (int i = 0; i < in + in_odd; i++) {
                const double *row = i < in ? numbers[l] + i * out : odd + (i - in) * out_odd;
                memcpy(work->by_too + i * columns + (i < in ? 0 : out), row,
                       (size_t)(i < in ? out : out_odd) * sizeof *row);
            }
        } else {
            multiply_rows(in, out, columns, numbers[l], work->by, work->by_too);
            multiply_rows(in_odd, out_odd, columns, odd, work->by + out * columns,
                          work->by_too + in * columns);
        }
        work->by = work->by_too;
        work->by_too = swap;
        if (l > 0) {
            kept -= m->width[l - 1];
            differentiate_units(m, m->width[l - 1], columns, kept, work->by);
        }
    }
}

/* Columns in the order [first components, second ones, evens, odds] and rows likewise, by z in the
 * frame; with a mirror step_layer() has another order of both. */
PROCESSOR_INLINE void reorder(const surrogate_step *m, int columns, step_work *work)
{
    const int p = m->pairs, q = m->out_pairs, count = step_coordinates(m), outs = step_outputs(m);
    double *swap = work->by;
    for (int i = 0; i < count && m->mirrors; i++) {
        const int row = i < p ? i : i < 2 * p ? i + m->evens : i < 2 * p + m->evens ? i - p : i;
        for (int o = 0; o < outs; o++) {
            const int column = o < q                      ? o
                               : o < 2 * q                ? o + m->out_evens
                               : o < 2 * q + m->out_evens ? o - q
                                                          : o;
            work->by_too[i * columns + o] = work->by[row * columns + column];
        }
    }
    if (m->mirrors) {
        work->by = work->by_too;
        work->by_too = swap;
    }
}

/* What the frame adds: pairs of inputs and outputs turn, and the frame moves with its leading pair.
 */
PROCESSOR_INLINE void differentiate_symmetry(const surrogate_step *m, int columns,
                                             const step_parts *parts, step_work *work)
{
    const int p = m->pairs, q = m->out_pairs, outs = step_outputs(m), count = step_coordinates(m);
    const double c = work->g[0], s = work->g[1], rho = work->rho[0];
    /* derivatives of c and s by the leading pair */
    const double by_w[2][2] = {{(1 - c * c) / rho, c * s / rho}, {-c * s / rho, (s * s - 1) / rho}};
    double *by_c = work->by_too, *by_s = by_c + columns;
    memset(by_c, 0, (size_t)(2 * columns) * sizeof *by_c);
    for (int k = 0; k < p; k++) {
        const double re = work->z[k], im = work->z[p + k];
        double *one = work->by + k * columns, *other = work->by + (p + k) * columns;
        for (int o = 0; o < outs; o++) {
            by_c[o] += one[o] * re + other[o] * im;
            by_s[o] += other[o] * re - one[o] * im;
            const double turned = one[o] * c + other[o] * s;
            other[o] = other[o] * c - one[o] * s;
            one[o] = turned;
        }
    }
    for (int i = 0; i < count + 2; i++) { /* outputs times c - is */
        double *row = i < count ? work->by + i * columns : by_c + (i - count) * columns;
        for (int k = 0; k < q; k++) {
            const double re = row[k], im = row[q + k];
            row[k] = re * c + im * s;
            row[q + k] = im * c - re * s;
        }
    }
    for (int k = 0; k < q; k++) { /* and their own turn */
        by_c[k] += work->framed[k];
        by_s[k] += work->framed[q + k];
        by_c[q + k] += work->framed[q + k];
        by_s[q + k] -= work->framed[k];
    }
    for (int k = 0; k < p; k++) {
        for (int o = 0; o < outs; o++) {
            work->by[k * columns + o] +=
                parts->lead[k] * (by_c[o] * by_w[0][0] + by_s[o] * by_w[1][0]);
            work->by[(p + k) * columns + o] +=
                parts->lead[k] * (by_c[o] * by_w[0][1] + by_s[o] * by_w[1][1]);
        }
    }
}

/* work->by_linear: derivatives [n + inputs][n] of the linear map. */
PROCESSOR_INLINE void differentiate_linear(const surrogate_step *m, const step_parts *parts,
                                           step_work *work)
{
    const int n = m->states, rows = n + step_all_inputs(m), size = rows * n;
    memcpy(work->by_linear, parts->linear, (size_t)size * sizeof *work->by_linear);
    for (int j = 0; j < m->slow_count; j++) {
        const int i = m->slow[j];
        const double half = 0.5 * (parts->input_high[i] - parts->input_low[i]);
        const double c = work->moved[n + i] / half;
        const double *one = parts->linear + (1 + 2 * j) * size, *two = one + size;
        double *by_slow = work->by_linear + (n + i) * n;
        for (int k = 0; k < size; k++) {
            work->by_linear[k] += c * (one[k] + c * two[k]);
        }
        for (int k = 0; k < rows; k++) {
            for (int r = 0; r < n; r++) {
                by_slow[r] += work->moved[k] * (one[k * n + r] + 2 * c * two[k * n + r]) / half;
            }
        }
    }
}

/* From work->by, derivatives of outputs in the world by coordinates, to those of the state. */
PROCESSOR_INLINE void collect(const surrogate_step *m, int columns, const step_parts *parts,
                              const step_work *work, double *by_state, double *by_inputs)
{
    const int n = m->states, all = step_all_inputs(m);
    for (int r = 0; r < n; r++) {
        const int o = step_output_of(m, m->state_slot[r]);
        for (int k = 0; k < n && by_state; k++) {
            const double moved = m->layers > 0 ? work->by[m->state_slot[k] * columns + o] : 0;
            by_state[r * n + k] =
                work->by_linear[k * n + r] + parts->state_scale[r] * moved / parts->state_scale[k];
        }
        for (int i = 0; i < m->inputs && by_inputs; i++) {
            double sum = 0;
            for (int end = i; end < all; end += m->inputs) {
                double moved = 0;
                for (int k = 0; k < m->drives && m->layers > 0; k++) {
                    moved += parts->input_map[end * m->drives + k] *
                             work->by[m->input_slot[k] * columns + o];
                }
                sum += work->by_linear[(n + end) * n + r] + parts->state_scale[r] * moved;
            }
            by_inputs[r * m->inputs + i] = sum;
        }
    }
}

FOR_EACH_PROCESSOR static void step_derivatives(const surrogate_step *m, const step_parts *parts,
                                                step_work *work, const double *state,
                                                const double *inputs, const double *after,
                                                double *next, double *by_state, double *by_inputs)
{
    const int columns = step_padded(step_outputs(m));
    step_tile(m, 1, 1, parts, work, state, inputs, after, next);
    if (m->layers > 0) {
        differentiate_network(m, columns, parts, work);
        reorder(m, columns, work);
        if (m->turns) {
            differentiate_symmetry(m, columns, parts, work);
        }
    }
    differentiate_linear(m, parts, work);
    collect(m, columns, parts, work, by_state, by_inputs);
}

void surrogate_step_differentiate(const surrogate_step *m, const step_parts *parts, step_work *work,
                                  const double *state, const double *inputs, const double *after,
                                  double *next, double *by_state, double *by_inputs)
{
    step_derivatives(m, parts, work, state, inputs, after, next, by_state, by_inputs);
}
