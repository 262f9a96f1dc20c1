/* The rows that are active, and L D L' of them. */
#include "tools/control/qp_internal.h"
#include "tools/control/small.h"

#include <math.h>
#include <string.h>

static const double qp_dependent = 1e-12; /* of a row: what is left of |m|^2 */
static const double qp_expensive = 1e-6;  /* softness of hard rows that cannot be met, by |m|^2 */

SMALL_FOR_EACH_PROCESSOR static void combine_rows(int count, int stride, const double *weights,
                                                  const double *rows, double *result)
{
    memset(result, 0, stride * sizeof *result);
    for (int i = 0; i < count; i++) {
        const double *row = rows + i * stride;

        for (int j = 0; j < stride; j++) {
            result[j] += weights[i] * row[j];
        }
    }
}

void qp_combine(int count, int stride, const double *weights, const double *rows, double *result)
{
    combine_rows(count, stride, weights, rows, result);
}

double qp_bound(const qp *x, int row, int side)
{
    const qp_bounds *b = x->bounds;

    if (row < x->n) {
        return side > 0 ? b->upper[row] : b->lower[row];
    }
    return side > 0 ? b->row_upper[row - x->n] : b->row_lower[row - x->n];
}

bool qp_soft(const qp *x, int r)
{
    return x->bounds->softness != NULL && x->bounds->softness[r] > 0.0;
}

/* m of a row, behind those of the active ones; its length squared. */
static double qp_direction(qp *x, int row)
{
    double *m = x->M + x->active * x->stride;

    if (row < x->n) {
        memcpy(m, x->inverse + row * x->stride, x->stride * sizeof *m);
    } else {
        qp_combine(x->n, x->stride, x->bounds->A + (row - x->n) * x->stride, x->inverse, m);
    }
    return small_dot(x->stride, m, m);
}

/* v [active] by (L D)^-1 and by L'^-1. */
static void qp_forward(const qp *x, double *v)
{
    for (int i = 0; i < x->active; i++) {
        const double *column = x->L + i * x->most;

        for (int j = i + 1; j < x->active; j++) {
            v[j] -= column[j] * v[i];
        }
        v[i] /= x->D[i];
    }
}

static void qp_backward(const qp *x, double *v)
{
    for (int i = x->active - 1; i >= 0; i--) {
        const double *column = x->L + i * x->most;

        for (int j = i + 1; j < x->active; j++) {
            v[i] -= column[j] * v[j];
        }
    }
}

/* Adds a row with a multiplier to the active ones. False: it depends on them, as
 * m = sum of next [active] times their m. */
SMALL_FOR_EACH_PROCESSOR static bool append_row(qp *x, int row, int side, double multiplier)
{
    const int k = x->active;
    const double *m = x->M + k * x->stride;
    const double squared = qp_direction(x, row);
    double *l = x->next;
    double soft = 0.0;
    double rest;

    if (row >= x->n) {
        soft = x->bounds->softness == NULL ? 0.0 : x->bounds->softness[row - x->n];
        soft = soft == 0.0 && x->least ? qp_expensive * squared : soft;
    }
    for (int i = 0; i < k; i++) {
        l[i] = small_dot(x->stride, x->M + i * x->stride, m);
    }
    qp_forward(x, l);
    rest = squared + soft;
    for (int i = 0; i < k; i++) {
        rest -= l[i] * l[i] * x->D[i];
    }
    if (soft == 0.0 && !(rest > qp_dependent * squared)) {
        qp_backward(x, l);
        return false;
    }
    for (int i = 0; i < k; i++) {
        x->L[i * x->most + k] = l[i];
    }
    x->D[k] = rest;
    x->soft[k] = soft;
    x->gap[k] = qp_bound(x, row, side) - (row < x->n ? x->x0[row] : x->start[row - x->n]);
    x->now[k] = multiplier;
    x->row[k] = row;
    x->side[row] = side;
    x->active++;
    return true;
}

bool qp_append(qp *x, int row, int side, double multiplier)
{
    return append_row(x, row, side, multiplier);
}

/* Drops active row i; L D L' of the later ones gains what the row took (Gill, Golub, Murray,
 * Saunders 1974, method C1). */
void qp_drop(qp *x, int i)
{
    const int k = --x->active;
    const size_t most = x->most;
    const size_t later = (k - i) * sizeof *x->D;
    double *column = x->next;
    double alpha = x->D[i];

    x->side[x->row[i]] = 0;
    memcpy(column + i, x->L + i * most + i + 1, later);
    memmove(x->M + i * x->stride, x->M + (i + 1) * x->stride,
            (size_t)(k - i) * x->stride * sizeof *x->M);
    for (int c = 0; c < i; c++) {
        memmove(x->L + c * most + i, x->L + c * most + i + 1, later);
    }
    for (int c = i; c < k; c++) {
        memcpy(x->L + c * most + c + 1, x->L + (c + 1) * most + c + 2, (k - c - 1) * sizeof *x->L);
    }
    memmove(x->D + i, x->D + i + 1, later);
    memmove(x->gap + i, x->gap + i + 1, later);
    memmove(x->soft + i, x->soft + i + 1, later);
    memmove(x->now + i, x->now + i + 1, later);
    memmove(x->row + i, x->row + i + 1, (k - i) * sizeof *x->row);
    for (int c = i; c < k; c++) {
        const double p = column[c];
        const double d = x->D[c] + alpha * p * p;
        const double beta = p * alpha / d;
        double *l = x->L + c * most;

        alpha *= x->D[c] / d;
        x->D[c] = d;
        for (int r = c + 1; r < k; r++) {
            column[r] -= p * l[r];
            l[r] += beta * column[r];
        }
    }
}

/* next = the multipliers with which all active rows hold exactly. */
void qp_target(qp *x)
{
    for (int i = 0; i < x->active; i++) {
        x->next[i] = -x->gap[i];
    }
    qp_forward(x, x->next);
    qp_backward(x, x->next);
}

/* x of the multipliers `now`. */
void qp_point(qp *x)
{
    qp_combine(x->active, x->stride, x->now, x->M, x->work);
    qp_combine(x->n, x->stride, x->work, x->columns, x->x);
    for (int i = 0; i < x->n; i++) {
        x->x[i] = x->x0[i] - x->x[i];
    }
}

/* One step of iterative refinement: updates of L D L' add up errors. */
void qp_refine(qp *x)
{
    bool good = true;

    qp_combine(x->active, x->stride, x->now, x->M, x->work);
    for (int i = 0; i < x->active; i++) {
        x->next[i] = -x->gap[i] - x->soft[i] * x->now[i] -
                     small_dot(x->stride, x->M + i * x->stride, x->work);
    }
    qp_forward(x, x->next);
    qp_backward(x, x->next);
    for (int i = 0; i < x->active; i++) {
        x->next[i] += x->now[i];
        good = good && x->next[i] * x->side[x->row[i]] >= 0.0;
    }
    if (good) {
        memcpy(x->now, x->next, x->active * sizeof *x->now);
        qp_point(x);
    }
}
