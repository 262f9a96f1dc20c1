/* One step by itself, with its derivatives. */
#include "physics/chain/modes_step_internal.h"

#include "physics/numerics/processor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- linear systems ------------------------------------------------------------------------ */

/* The rows of stage i: matrix of the accelerations of all stages. Leaves the residual of the stage
 * in collocation->residual and its derivatives in collocation->by_q, collocation->by_v. */
static ad_status stage_rows(collocation *collocation, int i, double t, double h,
                            const double *inputs, const double *q, const double *v, int columns,
                            double *rows, ad_error *error)
{
    const collocation_method *by = &collocation->by;
    modes *m = collocation->m;
    const int n = collocation->size, width = m->width;
    ad_status status = collocation_at(collocation, i, t, h, inputs, error);
    if (status != AD_OK) {
        return status;
    }
    collocation_stage(collocation, i, h, q, v);
    modes_linearise(m, collocation->q, collocation->v, collocation->a + i * n,
                    collocation->residual, collocation->by_q, collocation->by_v);
    for (int r = 0; r < n; r++) {
        const double *M = m->mass + r * width, *K = collocation->by_q + r * width,
                     *D = collocation->by_v + r * width;
        for (int j = 0; j < by->rule.stages; j++) {
            const double once = h * by->rule.matrix[i][j], twice = h * h * by->square[i][j];
            for (int k = 0; k < n; k++) {
                rows[r * columns + j * n + k] = (i == j ? M[k] : 0) + once * D[k] + twice * K[k];
            }
        }
    }
    collocation_branch_rows(collocation, i, h, columns, rows);
    return AD_OK;
}

/* By elimination: for the sizes of a step twice as quick as a library. */
FOR_EACH_PROCESSOR bool collocation_eliminate(int n, int columns, double *rows)
{
    for (int i = 0; i < n; i++) {
        int best = i;
        for (int r = i + 1; r < n; r++) {
            best = fabs(rows[r * columns + i]) > fabs(rows[best * columns + i]) ? r : best;
        }
        for (int c = 0; c < columns && best != i; c++) {
            const double other = rows[i * columns + c];
            rows[i * columns + c] = rows[best * columns + c];
            rows[best * columns + c] = other;
        }
        if (!(fabs(rows[i * columns + i]) > 0)) {
            return false;
        }
        for (int r = i + 1; r < n; r++) {
            const double by = rows[r * columns + i] / rows[i * columns + i];
            for (int c = i + 1; c < columns; c++) {
                rows[r * columns + c] -= by * rows[i * columns + c];
            }
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        const double by = 1 / rows[i * columns + i];
        for (int c = n; c < columns; c++) {
            rows[i * columns + c] *= by;
        }
        for (int r = 0; r < i; r++) {
            const double factor = rows[r * columns + i];
            for (int c = n; c < columns; c++) {
                rows[r * columns + c] -= factor * rows[i * columns + c];
            }
        }
    }
    return true;
}

/* ---- Newton's method with the matrix of every stage ---------------------------------------- */

/* Where the derivatives of one stage do not do: masses of modes that hardly move anything change by
 * more than themselves within a step, and friction of tendons that begin to stick or to slide. */
static ad_status newton_exact(collocation *collocation, double t, double h, const double *inputs,
                              double tolerance, const double *q, const double *v, bool *failed,
                              ad_error *error)
{
    modes *m = collocation->m;
    const size_t rubs = (size_t)m->rod->frictions * (size_t)m->points;
    const int full = 12, steps = rubs > 0 ? 40 : 8; /* half steps do not go to and fro */
    const int n = collocation->size, all = collocation->by.rule.stages * n, columns = all + 1;
    *failed = true;
    collocation->formed_step = 0;
    memset(collocation->dual, 0, (size_t)collocation->by.rule.stages * rubs * sizeof(modes_dual));
    for (int step = 0; step < steps && *failed; step++) {
        for (int i = 0; i < collocation->by.rule.stages; i++) {
            double *rows = collocation->exact + i * n * columns;
            m->friction.dual = collocation->dual + (size_t)i * rubs;
            ad_status status = stage_rows(collocation, i, t, h, inputs, q, v, columns, rows, error);
            m->friction.dual = NULL;
            if (status != AD_OK) {
                return status;
            }
            for (int r = 0; r < n; r++) {
                rows[r * columns + all] = -collocation->residual[r];
            }
        }
        collocation->counts.matrices += collocation->by.rule.stages;
        if (!collocation_eliminate(all, columns, collocation->exact)) {
            return AD_OK;
        }
        for (int k = 0; k < all; k++) {
            collocation->change[k] =
                (step < full ? 1 : 0.5) * collocation->exact[k * columns + all];
        }
        *failed = !(collocation_change(collocation, h) <= tolerance);
    }
    return AD_OK;
}

/* ---- one step ------------------------------------------------------------------------------ */

/* Accelerations of a step that starts from nothing but q and v. */
static ad_status solve_once(collocation *collocation, double t, double h, const double *inputs,
                            double tolerance, const double *q, const double *v, const double *d,
                            ad_error *error)
{
    bool slow, failed = true;
    const size_t size =
        (size_t)(collocation->by.rule.stages * collocation->size) * sizeof *collocation->a;
    const bool rubs = collocation->m->rod->frictions > 0; /* one matrix does not do */
    memset(collocation->a, 0, size);
    ad_status status = collocation_branch_begin(collocation, t, h, inputs, d, error);
    status = status == AD_OK && !rubs ? collocation_form(collocation, t, h, inputs, q, v, error)
                                      : status;
    if (status == AD_OK && !rubs && collocation_factor(collocation, h)) {
        status =
            collocation_iterate(collocation, t, h, inputs, tolerance, q, v, &slow, &failed, error);
    }
    if (status == AD_OK && failed) {
        memset(collocation->a, 0, size);
        status = newton_exact(collocation, t, h, inputs, tolerance, q, v, &failed, error);
    }
    return status == AD_OK && failed
               ? ad_fail(error, AD_NOT_FINITE, "a step of %g from t = %g is too long", h, t)
               : status;
}

ad_status collocation_once(collocation *collocation, double t, double h, const double *inputs,
                           const double *after, double tolerance, double *q, double *v, double *d,
                           ad_error *error)
{
    collocation->after = after;
    collocation->asks_power = false;
    ad_status status = solve_once(collocation, t, h, inputs, tolerance, q, v, d, error);
    if (status == AD_OK) {
        collocation_finish(collocation, h, q, v, d);
    }
    collocation->after = NULL;
    return status;
}

/* ---- derivatives --------------------------------------------------------------------------- */

/* Beside the matrix: minus the derivatives of the residual by q, v, d, inputs, ends of some. */
static ad_status derivative_rows(collocation *collocation, int i, double t, double h,
                                 const double *inputs, collocation_ends ends, const double *q,
                                 const double *v, int columns, double *rows, double *by_inputs,
                                 ad_error *error)
{
    modes *m = collocation->m;
    const int n = collocation->size, width = m->width, all = collocation->by.rule.stages * n;
    const int states = 2 * n + m->branch.count;
    const double late = collocation->by.rule.nodes[i] * h;
    ad_status status = stage_rows(collocation, i, t, h, inputs, q, v, columns, rows, error);
    if (status == AD_OK && m->inputs > 0) {
        status = modes_by_inputs(m, t + late, collocation->q, collocation->v,
                                 collocation->a + i * n, by_inputs, error);
    }
    for (int r = 0; r < n; r++) {
        double *row = rows + r * columns + all;
        for (int c = 0; c < n; c++) {
            row[c] = -collocation->by_q[r * width + c];
            row[n + c] =
                -collocation->by_v[r * width + c] - late * collocation->by_q[r * width + c];
        }
        for (int k = 2 * n; k < states; k++) {
            row[k] = 0;
        }
        for (int k = 0; k < m->inputs; k++) {
            row[states + k] = -by_inputs[r * m->inputs + k];
        }
        for (int k = 0; k < ends.count; k++) {
            row[states + m->inputs + k] =
                -collocation->by.rule.nodes[i] * by_inputs[r * m->inputs + ends.first + k];
        }
    }
    collocation_branch_derivatives(collocation, i, ends, columns, all + n, rows);
    return status;
}

/* to [count] += by times a row of changes. */
static void add_row(int count, double by, const double *row, double *to)
{
    for (int c = 0; c < count && by != 0; c++) {
        to[c] += by * row[c];
    }
}

/* How q, v at the end of the step change, by how the accelerations do: rows [stages][size] that
 * begin in a column of `accelerated`; in place of those at the start. */
static void change_state(const collocation *collocation, double h, const double *accelerated,
                         int stride, int count, double *change)
{
    const collocation_method *method = &collocation->by;
    const int n = collocation->size, last = method->rule.stages - 1;
    for (int k = 0; k < n; k++) {
        double *q = change + k * count, *v = change + (n + k) * count;
        add_row(count, h, v, q);
        for (int j = 0; j <= last; j++) {
            const double *a = accelerated + (j * n + k) * stride;
            add_row(count, h * h * method->square[last][j], a, q);
            add_row(count, h * method->rule.weights[j], a, v);
        }
    }
}

/* The same of d, before that of q and v. */
static void change_branches(const collocation *collocation, double h, collocation_ends ends,
                            const double *accelerated, int stride, int count, double *change)
{
    const modes *m = collocation->m;
    const int n = m->size, s = collocation->by.rule.stages;
    double *d = change + 2 * n * count, *input = d + m->branch.count * count;
    for (int b = 0; b < m->branch.count; b++, d += count) {
        const int k = m->branch.mode[b];
        const double left = collocation->branch.left[(s - 1) * n + k];
        for (int c = 0; c < count; c++) {
            d[c] *= left;
        }
        add_row(count, collocation_branch_by_rate(collocation, s - 1, k), change + (n + k) * count,
                d);
        for (int p = 0; p < m->inputs + ends.count; p++) {
            const bool is_end = p >= m->inputs;
            add_row(count,
                    collocation_branch_by_input(collocation, s - 1, k,
                                                is_end ? ends.first + p - m->inputs : p, is_end),
                    input + p * count, d);
        }
        for (int l = 0; l < s; l++) {
            double by = 0;
            for (int j = 0; j < s; j++) {
                by += h * collocation->branch.by[((s - 1) * s + j) * n + k] *
                      collocation->by.rule.matrix[j][l];
            }
            add_row(count, by, accelerated + (l * n + k) * stride, d);
        }
    }
}

/* Inputs that nothing changes along: a bit each. */
static uint64_t resting(const collocation *collocation, collocation_ends ends, int count,
                        const double *change)
{
    const int inputs = collocation->m->inputs;
    uint64_t result = 0;
    for (int k = 0; k < inputs; k++) {
        const bool ends_too = k >= ends.first && k < ends.first + ends.count;
        bool rests = true;
        for (int c = 0; c < count && rests; c++) {
            rests = change[k * count + c] == 0 &&
                    !(ends_too && change[(inputs + k - ends.first) * count + c] != 0);
        }
        result |= rests ? UINT64_C(1) << k : 0;
    }
    return result;
}

size_t collocation_along_room(const collocation *collocation, int ends, int count)
{
    const size_t n = (size_t)collocation->size, inputs = (size_t)collocation->m->inputs;
    const size_t all = (size_t)collocation->by.rule.stages * n;
    const size_t known = 2 * n + (size_t)collocation->m->branch.count + inputs + (size_t)ends;
    return all * (all + (size_t)count) + n * (all + known + inputs);
}

/* The rows of all stages: the matrix, and behind it what changes along each. */
static ad_status along_rows(collocation *collocation, double t, double h, const double *inputs,
                            collocation_ends ends, const double *q, const double *v, int count,
                            const double *change, double *room, ad_error *error)
{
    const int n = collocation->size, stages = collocation->by.rule.stages, all = stages * n;
    const int known = 2 * n + collocation->m->branch.count + collocation->m->inputs + ends.count;
    const int columns = all + known, width = all + count;
    double *rows = room + (size_t)all * (size_t)width, *by_inputs = rows + n * columns;
    ad_status status = AD_OK;
    for (int i = 0; i < stages && status == AD_OK; i++) {
        status = derivative_rows(collocation, i, t, h, inputs, ends, q, v, columns, rows, by_inputs,
                                 error);
        for (int r = 0; r < n; r++) {
            double *to = room + (i * n + r) * width;
            memcpy(to, rows + r * columns, (size_t)all * sizeof *to);
            memset(to + all, 0, (size_t)count * sizeof *to);
        }
        for (int k = 0; k < known; k++) {
            const double *along = change + k * count;
            int first = 0, end = count;
            for (; first < end && along[first] == 0; first++) {
            }
            for (; end > first && along[end - 1] == 0; end--) {
            }
            for (int r = 0; r < n && first < end; r++) {
                add_row(end - first, rows[r * columns + all + k], along + first,
                        room + (i * n + r) * width + all + first);
            }
        }
    }
    return status;
}

ad_status collocation_along(collocation *collocation, double t, double h, const double *inputs,
                            const double *after, collocation_ends ends, const double *q,
                            const double *v, const double *d, int count, double *room,
                            double *change, ad_error *error)
{
    modes *m = collocation->m;
    const int states = 2 * collocation->size + m->branch.count;
    const int stages = collocation->by.rule.stages, all = stages * collocation->size;
    const uint64_t unasked = m->unasked;
    m->unasked |= resting(collocation, ends, count, change + states * count);
    collocation->after = after;
    ad_status status = collocation_branch_begin(collocation, t, h, inputs, d, error);
    status =
        status == AD_OK ? collocation_branch_by_inputs(collocation, t, h, inputs, error) : status;
    for (int i = 0; i < stages && status == AD_OK; i++) {
        collocation_branch_stretch(collocation, i, h, v);
    }
    status = status == AD_OK
                 ? along_rows(collocation, t, h, inputs, ends, q, v, count, change, room, error)
                 : status;
    collocation->after = NULL;
    m->unasked = unasked;
    if (status == AD_OK && !collocation_eliminate(all, all + count, room)) {
        status = ad_fail(error, AD_NOT_FINITE, "the derivative of a step is singular");
    }
    if (status == AD_OK) {
        change_branches(collocation, h, ends, room + all, all + count, count, change);
        change_state(collocation, h, room + all, all + count, count, change);
    }
    return status;
}
