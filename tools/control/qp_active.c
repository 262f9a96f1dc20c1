/* The rows that are active, and L D L' of them. */
#include "tools/control/qp_internal.h"
#include "tools/control/small_matrix.h"

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

double qp_bound(const qp *qp, int row, int side)
{
    const qp_bounds *b = qp->bounds;

    if (row < qp->n) {
        return side > 0 ? b->upper[row] : b->lower[row];
    }
    return side > 0 ? b->row_upper[row - qp->n] : b->row_lower[row - qp->n];
}

bool qp_soft(const qp *qp, int r)
{
    return qp->bounds->softness != NULL && qp->bounds->softness[r] > 0.0;
}

/* m of a row, behind those of the active ones; its length squared. */
static double qp_direction(qp *qp, int row)
{
    double *m = qp->M + qp->active * qp->stride;

    if (row < qp->n) {
        memcpy(m, qp->inverse + row * qp->stride, qp->stride * sizeof *m);
    } else {
        qp_combine(qp->n, qp->stride, qp->bounds->A + (row - qp->n) * qp->stride, qp->inverse, m);
    }
    return small_matrix_dot(qp->stride, m, m);
}

/* v [active] by (L D)^-1 and by L'^-1. */
static void qp_forward(const qp *qp, double *v)
{
    for (int i = 0; i < qp->active; i++) {
        const double *column = qp->L + i * qp->most;

        for (int j = i + 1; j < qp->active; j++) {
            v[j] -= column[j] * v[i];
        }
        v[i] /= qp->D[i];
    }
}

static void qp_backward(const qp *qp, double *v)
{
    for (int i = qp->active - 1; i >= 0; i--) {
        const double *column = qp->L + i * qp->most;

        for (int j = i + 1; j < qp->active; j++) {
            v[i] -= column[j] * v[j];
        }
    }
}

/* Adds a row with a multiplier to the active ones. False: it depends on them, as
 * m = sum of next [active] times their m. */
SMALL_FOR_EACH_PROCESSOR static bool append_row(qp *qp, int row, int side, double multiplier)
{
    const int k = qp->active;
    const double *m = qp->M + k * qp->stride;
    const double squared = qp_direction(qp, row);
    double *l = qp->next;
    double soft = 0.0;
    double rest;

    if (row >= qp->n) {
        soft = qp->bounds->softness == NULL ? 0.0 : qp->bounds->softness[row - qp->n];
        soft = soft == 0.0 && qp->least ? qp_expensive * squared : soft;
    }
    for (int i = 0; i < k; i++) {
        l[i] = small_matrix_dot(qp->stride, qp->M + i * qp->stride, m);
    }
    qp_forward(qp, l);
    rest = squared + soft;
    for (int i = 0; i < k; i++) {
        rest -= l[i] * l[i] * qp->D[i];
    }
    if (soft == 0.0 && !(rest > qp_dependent * squared)) {
        qp_backward(qp, l);
        return false;
    }
    for (int i = 0; i < k; i++) {
        qp->L[i * qp->most + k] = l[i];
    }
    qp->D[k] = rest;
    qp->soft[k] = soft;
    qp->gap[k] = qp_bound(qp, row, side) - (row < qp->n ? qp->x0[row] : qp->start[row - qp->n]);
    qp->now[k] = multiplier;
    qp->row[k] = row;
    qp->side[row] = side;
    qp->active++;
    return true;
}

bool qp_append(qp *qp, int row, int side, double multiplier)
{
    return append_row(qp, row, side, multiplier);
}

/* Drops active row i; L D L' of the later ones gains what the row took (Gill, Golub, Murray,
 * Saunders 1974, method C1). */
void qp_drop(qp *qp, int i)
{
    const int k = --qp->active;
    const size_t most = qp->most;
    const size_t later = (k - i) * sizeof *qp->D;
    double *column = qp->next;
    double alpha = qp->D[i];

    qp->side[qp->row[i]] = 0;
    memcpy(column + i, qp->L + i * most + i + 1, later);
    memmove(qp->M + i * qp->stride, qp->M + (i + 1) * qp->stride,
            (size_t)(k - i) * qp->stride * sizeof *qp->M);
    for (int c = 0; c < i; c++) {
        memmove(qp->L + c * most + i, qp->L + c * most + i + 1, later);
    }
    for (int c = i; c < k; c++) {
        memcpy(qp->L + c * most + c + 1, qp->L + (c + 1) * most + c + 2,
               (k - c - 1) * sizeof *qp->L);
    }
    memmove(qp->D + i, qp->D + i + 1, later);
    memmove(qp->gap + i, qp->gap + i + 1, later);
    memmove(qp->soft + i, qp->soft + i + 1, later);
    memmove(qp->now + i, qp->now + i + 1, later);
    memmove(qp->row + i, qp->row + i + 1, (k - i) * sizeof *qp->row);
    for (int c = i; c < k; c++) {
        const double p = column[c];
        const double d = qp->D[c] + alpha * p * p;
        const double beta = p * alpha / d;
        double *l = qp->L + c * most;

        alpha *= qp->D[c] / d;
        qp->D[c] = d;
        for (int r = c + 1; r < k; r++) {
            column[r] -= p * l[r];
            l[r] += beta * column[r];
        }
    }
}

/* next = the multipliers with which all active rows hold exactly. */
void qp_target(qp *qp)
{
    for (int i = 0; i < qp->active; i++) {
        qp->next[i] = -qp->gap[i];
    }
    qp_forward(qp, qp->next);
    qp_backward(qp, qp->next);
}

/* x of the multipliers `now`. */
void qp_point(qp *qp)
{
    qp_combine(qp->active, qp->stride, qp->now, qp->M, qp->work);
    qp_combine(qp->n, qp->stride, qp->work, qp->columns, qp->x);
    for (int i = 0; i < qp->n; i++) {
        qp->x[i] = qp->x0[i] - qp->x[i];
    }
}

/* One step of iterative refinement: updates of L D L' add up errors. */
void qp_refine(qp *qp)
{
    bool good = true;

    qp_combine(qp->active, qp->stride, qp->now, qp->M, qp->work);
    for (int i = 0; i < qp->active; i++) {
        qp->next[i] = -qp->gap[i] - qp->soft[i] * qp->now[i] -
                      small_matrix_dot(qp->stride, qp->M + i * qp->stride, qp->work);
    }
    qp_forward(qp, qp->next);
    qp_backward(qp, qp->next);
    for (int i = 0; i < qp->active; i++) {
        qp->next[i] += qp->now[i];
        good = good && qp->next[i] * qp->side[qp->row[i]] >= 0.0;
    }
    if (good) {
        memcpy(qp->now, qp->next, qp->active * sizeof *qp->now);
        qp_point(qp);
    }
}
