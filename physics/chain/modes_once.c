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

size_t collocation_derivative_room(const collocation *collocation)
{
    const size_t n = (size_t)collocation->size, all = (size_t)collocation->by.rule.stages * n;
    const size_t states = 2 * n + (size_t)collocation->m->branch.count;
    return all * (all + states + 2 * (size_t)collocation->m->inputs) +
           n * (size_t)collocation->m->inputs;
}

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

/* How q, v at the end of the step change, by how the accelerations do: rows [stages][size] that
 * have `width` columns of them, and those at the start, [2 size][width]; in place. */
static void change_state(const collocation *collocation, double h, const double *accelerated,
                         int stride, int width, double *change)
{
    const collocation_method *method = &collocation->by;
    const int n = collocation->size, last = method->rule.stages - 1;
    for (int k = 0; k < n; k++) {
        double *q = change + k * width, *v = change + (n + k) * width;
        for (int c = 0; c < width; c++) {
            q[c] += h * v[c];
            for (int j = 0; j <= last; j++) {
                const double a = accelerated[(j * n + k) * stride + c];
                q[c] += h * h * method->square[last][j] * a;
                v[c] += h * method->rule.weights[j] * a;
            }
        }
    }
}

/* Rows of d at the end of the step, from those of accelerations in `room`. */
static void branch_rows(const collocation *collocation, double h, collocation_ends ends,
                        int columns, const double *room, double *by)
{
    const modes *m = collocation->m;
    const int n = m->size, s = collocation->by.rule.stages, inputs = m->inputs;
    const int states = 2 * n + m->branch.count, wanted = states + inputs + ends.count;
    for (int b = 0; b < m->branch.count; b++) {
        const int k = m->branch.mode[b];
        double *to = by + (2 * n + b) * wanted, accelerated[COLLOCATION_STAGES_MAX] = {0};
        for (int l = 0; l < s; l++) {
            for (int j = 0; j < s; j++) {
                accelerated[l] += h * collocation->branch.by[((s - 1) * s + j) * n + k] *
                                  collocation->by.rule.matrix[j][l];
            }
        }
        for (int c = 0; c < wanted; c++) {
            const int p = c - states;
            to[c] = c == n + k       ? collocation_branch_by_rate(collocation, s - 1, k)
                    : c == 2 * n + b ? collocation->branch.left[(s - 1) * n + k]
                    : p < 0          ? 0
                                     : collocation_branch_by_input(collocation, s - 1, k,
                                                          p < inputs ? p : ends.first + p - inputs,
                                                                   p >= inputs);
            for (int l = 0; l < s; l++) {
                to[c] += accelerated[l] * room[(l * n + k) * columns + s * n + c];
            }
        }
    }
}

ad_status collocation_derivatives(collocation *collocation, double t, double h,
                                  const double *inputs, const double *after, collocation_ends ends,
                                  const double *q, const double *v, const double *d, double *room,
                                  double *by, ad_error *error)
{
    const int n = collocation->size, all = collocation->by.rule.stages * n,
              wanted = 2 * n + collocation->m->branch.count + collocation->m->inputs + ends.count;
    const int columns = all + wanted;
    double *by_inputs = room + all * columns;
    collocation->after = after;
    ad_status status = collocation_branch_begin(collocation, t, h, inputs, d, error);
    status =
        status == AD_OK ? collocation_branch_by_inputs(collocation, t, h, inputs, error) : status;
    for (int i = 0; i < collocation->by.rule.stages && status == AD_OK; i++) {
        collocation_branch_stretch(collocation, i, h, v);
    }
    for (int i = 0; i < collocation->by.rule.stages && status == AD_OK; i++) {
        status = derivative_rows(collocation, i, t, h, inputs, ends, q, v, columns,
                                 room + i * n * columns, by_inputs, error);
    }
    collocation->after = NULL;
    if (status == AD_OK && !collocation_eliminate(all, columns, room)) {
        status = ad_fail(error, AD_NOT_FINITE, "the derivative of a step is singular");
    }
    if (status == AD_OK) {
        memset(by, 0, (size_t)(2 * n) * (size_t)wanted * sizeof *by);
        for (int k = 0; k < 2 * n; k++) {
            by[k * wanted + k] = 1;
        }
        change_state(collocation, h, room + all, columns, wanted, by);
    }
    if (status == AD_OK) {
        branch_rows(collocation, h, ends, columns, room, by);
    }
    return status;
}

size_t collocation_along_room(const collocation *collocation, int count)
{
    const size_t n = (size_t)collocation->size, inputs = (size_t)collocation->m->inputs;
    const size_t all = (size_t)collocation->by.rule.stages * n;
    return all * (all + (size_t)count) + n * (all + 2 * n + 2 * inputs);
}

ad_status collocation_along(collocation *collocation, double t, double h, int count,
                            const double *q, const double *v, double *room, double *change,
                            ad_error *error)
{
    const int n = collocation->size, stages = collocation->by.rule.stages, all = stages * n;
    const int inputs = collocation->m->inputs, known = 2 * n + inputs, columns = all + known;
    double *rows = room + (size_t)all * (size_t)(all + count), *by_inputs = rows + n * columns;
    double now[SCENE_PARAMETERS_MAX];
    ad_status status = AD_OK;
    modes_commands(collocation->m, now);
    for (int i = 0; i < stages && status == AD_OK; i++) {
        status = derivative_rows(collocation, i, t, h, now, (collocation_ends){0, 0}, q, v, columns,
                                 rows, by_inputs, error);
        for (int r = 0; r < n; r++) {
            const double *from = rows + r * columns;
            double *to = room + (i * n + r) * (all + count);
            memcpy(to, from, (size_t)all * sizeof *to);
            memset(to + all, 0, (size_t)count * sizeof *to);
            for (int k = 0; k < known; k++) {
                for (int c = 0; c < count && from[all + k] != 0; c++) {
                    to[all + c] += from[all + k] * change[k * count + c];
                }
            }
        }
    }
    if (status == AD_OK && !collocation_eliminate(all, all + count, room)) {
        status = ad_fail(error, AD_NOT_FINITE, "the derivative of a step is singular");
    }
    if (status == AD_OK) {
        change_state(collocation, h, room + all, all + count, count, change);
    }
    return status;
}
