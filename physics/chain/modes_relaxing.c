/* Maxwell branches in a step of a reduced rod. */
#include "physics/chain/modes_step_internal.h"

#include <string.h>

/* left, by of mode k. */
static void solve_stages(collocation *collocation, int k, double h)
{
    enum { S = COLLOCATION_STAGES_MAX };
    const int s = collocation->by.rule.stages, n = collocation->size, columns = 2 * s + 1;
    collocation_branch *to = &collocation->branch;
    double rows[S * (2 * S + 1)];
    for (int i = 0; i < s; i++) {
        double *row = rows + i * columns;
        for (int j = 0; j < s; j++) {
            const double a = h * collocation->by.rule.matrix[i][j];
            row[j] = (i == j) + a * to->rate[j * n + k];
            row[s + 1 + j] = a;
        }
        row[s] = 1;
    }
    collocation_eliminate(s, columns, rows); /* as regular as 1 + h A/T is */
    for (int i = 0; i < s; i++) {
        to->left[i * n + k] = rows[i * columns + s];
        for (int j = 0; j < s; j++) {
            to->by[(i * s + j) * n + k] = rows[i * columns + s + 1 + j];
        }
    }
}

ad_status collocation_branch_begin(collocation *collocation, double t, double h,
                                   const double *inputs, const double *d, ad_error *error)
{
    const modes *m = collocation->m;
    const size_t n = (size_t)m->size;
    const int s = collocation->by.rule.stages;
    collocation_branch *to = &collocation->branch;
    ad_status status = AD_OK;
    for (int i = 0; i < s && m->branch.count > 0 && status == AD_OK; i++) {
        status = collocation_at(collocation, i, t, h, inputs, error);
        memcpy(to->rate + (size_t)i * n, m->branch.rate, n * sizeof *to->rate);
        memcpy(to->rest_rate + (size_t)i * n, m->branch.rest_rate, n * sizeof *to->rest_rate);
    }
    for (int i = 0; i < m->branch.count && status == AD_OK; i++) {
        const int k = m->branch.mode[i];
        to->start[k] = d[k];
        if (!modes_branch_as_before(m, i)) {
            solve_stages(collocation, k, h);
            continue;
        }
        const int from = m->branch.mode[i - 1];
        for (int j = 0; j < s * s; j++) {
            to->by[(size_t)j * n + (size_t)k] = to->by[(size_t)j * n + (size_t)from];
        }
        for (int j = 0; j < s; j++) {
            to->left[(size_t)j * n + (size_t)k] = to->left[(size_t)j * n + (size_t)from];
        }
    }
    return status;
}

/* The rate of mode k at stage j, with that of the rest shape. */
static double strain_rate(const collocation *collocation, int j, int k, double h, const double *v)
{
    const int n = collocation->size;
    double sum = 0;
    for (int l = 0; l < collocation->by.rule.stages; l++) {
        sum += collocation->by.rule.matrix[j][l] * collocation->a[l * n + k];
    }
    return v[k] + h * sum + collocation->branch.rest_rate[j * n + k];
}

void collocation_branch_stretch(collocation *collocation, int i, double h, const double *v)
{
    modes *m = collocation->m;
    const int n = collocation->size, s = collocation->by.rule.stages;
    const collocation_branch *by = &collocation->branch;
    for (int c = 0; c < m->branch.count; c++) {
        const int k = m->branch.mode[c];
        double *to = &by->stretch[i * n + k];
        *to = by->left[i * n + k] * by->start[k];
        for (int j = 0; j < s; j++) {
            *to += by->by[(i * s + j) * n + k] * strain_rate(collocation, j, k, h, v);
        }
    }
    modes_stretch(m, by->stretch + i * n);
}

void collocation_branch_form(collocation *collocation, int stage)
{
    const modes *m = collocation->m;
    const collocation_branch *to = &collocation->branch;
    if (m->branch.count > 0) {
        memcpy(to->matrix, m->branch.by, (size_t)(m->size * m->width) * sizeof *to->matrix);
        memcpy(to->relaxing, to->rate + stage * m->size, (size_t)m->size * sizeof *to->relaxing);
    }
}

/* Of an eigenvalue l of A a rate v makes a stretch h l v/(1 + h l/T). */
void collocation_branch_system(const collocation *collocation, double complex first,
                               double complex second, collocation_factors *f)
{
    const modes *m = collocation->m;
    const int n = m->size;
    for (int c = 0; c < m->branch.count; c++) {
        const int k = m->branch.mode[c];
        const double complex by = second / (1 + first * collocation->branch.relaxing[k]);
        for (int i = 0; i < n; i++) {
            const double stiffness = collocation->branch.matrix[i * m->width + k];
            f->re[i * n + k] += creal(by) * stiffness;
            f->im[i * n + k] += cimag(by) * stiffness;
        }
    }
}

void collocation_branch_rows(collocation *collocation, int i, double h, int columns, double *rows)
{
    const modes *m = collocation->m;
    const int n = m->size, s = collocation->by.rule.stages;
    for (int c = 0; c < m->branch.count; c++) {
        const int k = m->branch.mode[c];
        for (int l = 0; l < s; l++) {
            double by = 0;
            for (int j = 0; j < s; j++) {
                by +=
                    collocation->branch.by[(i * s + j) * n + k] * collocation->by.rule.matrix[j][l];
            }
            for (int r = 0; r < n; r++) {
                rows[r * columns + l * n + k] += h * by * m->branch.by[r * m->width + k];
            }
        }
    }
}

ad_status collocation_branch_by_inputs(collocation *collocation, double t, double h,
                                       const double *inputs, ad_error *error)
{
    modes *m = collocation->m;
    ad_status status = AD_OK;
    for (int i = 0; i < collocation->by.rule.stages && m->branch.count > 0 && status == AD_OK;
         i++) {
        const int at = i * m->inputs * m->size;
        status = collocation_at(collocation, i, t, h, inputs, error);
        status = status == AD_OK
                     ? modes_branch_by_inputs(m, m->time, collocation->branch.rate_by + at,
                                              collocation->branch.rest_by + at, error)
                     : status;
    }
    return status;
}

double collocation_branch_by_rate(const collocation *collocation, int i, int k)
{
    const int n = collocation->size, s = collocation->by.rule.stages;
    double sum = 0;
    for (int j = 0; j < s; j++) {
        sum += collocation->branch.by[(i * s + j) * n + k];
    }
    return sum;
}

double collocation_branch_by_input(const collocation *collocation, int i, int k, int p, bool is_end)
{
    const int n = collocation->size, s = collocation->by.rule.stages;
    const collocation_branch *by = &collocation->branch;
    double sum = 0;
    for (int j = 0; j < s; j++) {
        const int at = (j * collocation->m->inputs + p) * n + k;
        sum += by->by[(i * s + j) * n + k] * (is_end ? collocation->by.rule.nodes[j] : 1) *
               (by->rest_by[at] - by->rate_by[at] * by->stretch[j * n + k]);
    }
    return sum;
}

void collocation_branch_derivatives(const collocation *collocation, int i, collocation_ends ends,
                                    int columns, int by_v, double *rows)
{
    const modes *m = collocation->m;
    const int n = m->size, b = m->branch.count, inputs = m->inputs;
    for (int c = 0; c < b; c++) {
        const int k = m->branch.mode[c];
        const double *matrix = m->branch.by + k;
        const double rate = collocation_branch_by_rate(collocation, i, k);
        for (int r = 0; r < n; r++) {
            double *row = rows + r * columns + by_v;
            row[k] -= matrix[r * m->width] * rate;
            row[n + c] -= matrix[r * m->width] * collocation->branch.left[i * n + k];
        }
        for (int p = 0; p < inputs + ends.count; p++) {
            const bool is_end = p >= inputs;
            const double by = collocation_branch_by_input(
                collocation, i, k, is_end ? ends.first + p - inputs : p, is_end);
            for (int r = 0; r < n; r++) {
                rows[r * columns + by_v + n + b + p] -= matrix[r * m->width] * by;
            }
        }
    }
}

void collocation_branch_finish(const collocation *collocation, double *d)
{
    const modes *m = collocation->m;
    const int last = (collocation->by.rule.stages - 1) * m->size; /* the step ends there */
    for (int c = 0; c < m->branch.count; c++) {
        d[m->branch.mode[c]] = collocation->branch.stretch[last + m->branch.mode[c]];
    }
}

void collocation_branch_keep(collocation *collocation, double h, const double *d, const double *v)
{
    const modes *m = collocation->m;
    const collocation_branch *to = &collocation->branch;
    const int n = m->size;
    for (int i = 0; i < collocation->by.rule.stages && m->branch.count > 0; i++) {
        collocation_branch_stretch(collocation, i, h, v);
        for (int c = 0; c < m->branch.count; c++) {
            const int k = m->branch.mode[c];
            to->from[k] = d[k];
            to->change[i * n + k] =
                strain_rate(collocation, i, k, h, v) - to->rate[i * n + k] * to->stretch[i * n + k];
        }
    }
}

void collocation_branch_within(const collocation *collocation, const double *integral, double *d)
{
    const modes *m = collocation->m;
    const collocation_branch *by = &collocation->branch;
    for (int c = 0; c < m->branch.count; c++) {
        const int k = m->branch.mode[c];
        d[k] = by->from[k];
        for (int j = 0; j < collocation->by.rule.stages; j++) {
            d[k] += collocation->last_step * integral[j] * by->change[j * m->size + k];
        }
    }
}
