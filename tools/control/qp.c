#include "tools/control/qp_internal.h"
#include "tools/control/small_matrix.h"

#include <math.h>
#include <string.h>

static size_t qp_layout(const qp_settings *s, void *memory, qp *x)
{
    const size_t n = (size_t)s->variables;
    const size_t m = (size_t)s->rows;
    const size_t stride = (size_t)small_matrix_stride(s->variables);
    const size_t most = n + m + 1;
    size_t used = 0;

    (void)small_matrix_take(memory, &used, 1, sizeof(qp));
    x->U = small_matrix_take(memory, &used, n * stride, sizeof(double));
    x->inverse = small_matrix_take(memory, &used, n * stride, sizeof(double));
    x->columns = small_matrix_take(memory, &used, n * stride, sizeof(double));
    x->work = small_matrix_take(memory, &used, stride, sizeof(double));
    x->x0 = small_matrix_take(memory, &used, stride, sizeof(double));
    x->x = small_matrix_take(memory, &used, stride, sizeof(double));
    x->best = small_matrix_take(memory, &used, stride, sizeof(double));
    x->start = small_matrix_take(memory, &used, m, sizeof(double));
    x->length = small_matrix_take(memory, &used, m, sizeof(double));
    x->M = small_matrix_take(memory, &used, most * stride, sizeof(double));
    x->L = small_matrix_take(memory, &used, most * most, sizeof(double));
    x->D = small_matrix_take(memory, &used, most, sizeof(double));
    x->gap = small_matrix_take(memory, &used, most, sizeof(double));
    x->soft = small_matrix_take(memory, &used, most, sizeof(double));
    x->now = small_matrix_take(memory, &used, most, sizeof(double));
    x->next = small_matrix_take(memory, &used, most, sizeof(double));
    x->all = small_matrix_take(memory, &used, n + m, sizeof(double));
    x->row = small_matrix_take(memory, &used, most, sizeof(int));
    x->side = small_matrix_take(memory, &used, n + m, sizeof(int));
    return used;
}

size_t qp_size(const qp_settings *settings)
{
    qp x;

    return qp_layout(settings, NULL, &x);
}

qp *qp_init(void *memory, const qp_settings *settings)
{
    qp *qp = memory;

    memset(memory, 0, qp_size(settings));
    (void)qp_layout(settings, memory, qp);
    qp->n = settings->variables;
    qp->m = settings->rows;
    qp->stride = small_matrix_stride(qp->n);
    qp->most = qp->n + qp->m + 1;
    qp->limit = settings->iterations > 0 ? settings->iterations : 10 + 3 * (qp->n + qp->m);
    qp->tolerance = settings->tolerance > 0 ? settings->tolerance : 1e-10;
    return qp;
}

/* Nothing is active at first. */
static void qp_forget(qp *qp)
{
    memset(qp->side, 0, (qp->n + qp->m) * sizeof *qp->side);
    memset(qp->all, 0, (qp->n + qp->m) * sizeof *qp->all);
}

void qp_shift(qp *qp, int first, int count, int by)
{
    memmove(qp->side + first, qp->side + first + by, (count - by) * sizeof *qp->side);
    memmove(qp->all + first, qp->all + first + by, (count - by) * sizeof *qp->all);
}

int qp_iterations(const qp *qp)
{
    return qp->iterations;
}

int qp_iterations_most(const qp *qp)
{
    return qp->limit + qp->most;
}

const double *qp_multipliers(const qp *qp)
{
    return qp->all;
}

SMALL_FOR_EACH_PROCESSOR static bool qp_invert(qp *qp)
{
    const int n = qp->n;
    const int stride = qp->stride;

    memset(qp->inverse, 0, (size_t)n * stride * sizeof *qp->inverse);
    memset(qp->columns, 0, (size_t)n * stride * sizeof *qp->columns);
    for (int i = 0; i < n; i++) {
        double *row = qp->inverse + i * stride;

        row[i] = 1.0;
        for (int k = i; k < n; k++) {
            const double *u = qp->U + k * stride;

            row[k] /= u[k];
            for (int j = k + 1; j < n; j++) {
                row[j] -= row[k] * u[j];
            }
        }
        for (int k = i; k < n; k++) {
            if (!isfinite(row[k])) {
                return false;
            }
            qp->columns[k * stride + i] = row[k];
        }
    }
    return true;
}

qp_status qp_factor(qp *qp, const double *H)
{
    const int n = qp->n;
    const int stride = qp->stride;

    qp->factored = false;
    memcpy(qp->U, H, (size_t)n * stride * sizeof *H);
    if (small_matrix_cholesky(n, qp->U) != 0) {
        return QP_BAD;
    }
    qp->factored = qp_invert(qp);
    return qp->factored ? QP_SOLVED : QP_BAD;
}

/* x0 = -H^-1 g, and where it is in the rows of A. */
SMALL_FOR_EACH_PROCESSOR static bool qp_unconstrained(qp *qp, const double *g)
{
    bool finite = true;

    qp_combine(qp->n, qp->stride, g, qp->inverse, qp->work);
    qp_combine(qp->n, qp->stride, qp->work, qp->columns, qp->x0);
    for (int i = 0; i < qp->n; i++) {
        qp->x0[i] = -qp->x0[i];
        finite = finite && isfinite(qp->x0[i]);
    }
    for (int i = 0; i < qp->m; i++) {
        const double *row = qp->bounds->A + i * qp->stride;

        qp->start[i] = small_matrix_dot(qp->stride, row, qp->x0);
        qp->length[i] = sqrt(small_matrix_dot(qp->stride, row, row));
        finite = finite && isfinite(qp->start[i]) && isfinite(qp->length[i]);
    }
    return finite;
}

static bool qp_bounds_good(const qp *qp)
{
    const qp_bounds *b = qp->bounds;

    for (int i = 0; i < qp->n; i++) {
        if (!(b->lower[i] <= b->upper[i])) {
            return false;
        }
    }
    for (int i = 0; i < qp->m; i++) {
        if (!(b->row_lower[i] <= b->row_upper[i]) || (b->softness && !(b->softness[i] >= 0.0))) {
            return false;
        }
    }
    return true;
}

/* By how much a value lies beyond a bound, if by more than the tolerance. */
static double qp_beyond(const qp *qp, double value, double lower, double upper, double length,
                        int *side)
{
    const double over = value - upper;
    const double under = lower - value;
    const double most = over > under ? over : under;
    const double bound = over > under ? upper : lower;

    *side = over > under ? 1 : -1;
    return most > qp->tolerance * fmax(length, fabs(bound)) ? most / length : 0.0;
}

/* The row that x violates most, or -1. */
SMALL_FOR_EACH_PROCESSOR static int qp_worst(const qp *qp, int *worst_side)
{
    const qp_bounds *b = qp->bounds;
    double worst = 0.0;
    int result = -1;

    for (int i = 0; i < qp->n + qp->m; i++) {
        const int r = i - qp->n;
        double beyond;
        int side;

        if (qp->side[i] != 0) {
            continue;
        }
        if (r < 0) {
            beyond = qp_beyond(qp, qp->x[i], b->lower[i], b->upper[i], 1.0, &side);
        } else {
            const double length = qp->length[r] > 0.0 ? qp->length[r] : 1.0;
            const double value = small_matrix_dot(qp->stride, b->A + r * qp->stride, qp->x);

            beyond = qp_beyond(qp, value, b->row_lower[r], b->row_upper[r], length, &side);
        }
        if (beyond > worst) {
            worst = beyond;
            result = i;
            *worst_side = side;
        }
    }
    return result;
}

/* How far multipliers may go from `now` by `rate` until the first of them would change its sign,
 * and which one. */
static double qp_blocking(const qp *qp, const double *rate, double least_rate, int *blocking)
{
    double t = INFINITY;

    *blocking = -1;
    for (int i = 0; i < qp->active; i++) {
        const double towards = -rate[i] * qp->side[qp->row[i]];

        if (towards > least_rate && fabs(qp->now[i]) < t * towards) {
            t = fabs(qp->now[i]) / towards;
            *blocking = i;
        }
    }
    return t;
}

/* Adds a violated row; those on which it depends give way. False: none can, no point is allowed. */
static bool qp_add(qp *qp, int row, int side)
{
    double multiplier = 0.0;

    while (!qp_append(qp, row, side, multiplier)) {
        double *rate = qp->next;
        double t;
        int blocking;

        /* m = sum of c m_i: the multiplier grows with its side, the others lose c times it. */
        for (int i = 0; i < qp->active; i++) {
            rate[i] = qp->soft[i] > 0.0 ? 0.0 : -side * rate[i];
        }
        t = qp_blocking(qp, rate, 1e-10, &blocking);
        if (blocking < 0) {
            return false;
        }
        for (int i = 0; i < qp->active; i++) {
            qp->now[i] += t * rate[i];
        }
        multiplier += t * side;
        qp_drop(qp, blocking);
        qp->iterations++;
    }
    return true;
}

static qp_status qp_iterate(qp *qp)
{
    memcpy(qp->best, qp->x0, qp->stride * sizeof *qp->best);
    for (;; qp->iterations++) {
        int blocking = -1;
        double t = 1.0;

        if (qp->iterations >= qp->limit) {
            return QP_LIMIT;
        }
        qp_target(qp);
        for (int i = 0; i < qp->active; i++) {
            if (qp->next[i] * qp->side[qp->row[i]] < 0.0) {
                const double part = qp->now[i] / (qp->now[i] - qp->next[i]);

                if (part < t || blocking < 0) {
                    t = part;
                    blocking = i;
                }
            }
        }
        for (int i = 0; i < qp->active; i++) {
            qp->now[i] = blocking < 0 ? qp->next[i] : qp->now[i] + t * (qp->next[i] - qp->now[i]);
        }
        if (blocking >= 0) {
            qp_drop(qp, blocking);
        } else {
            int side = 0;
            int row;

            qp_point(qp);
            row = qp_worst(qp, &side);
            if (row < 0) {
                qp_refine(qp);
                return QP_SOLVED;
            }
            memcpy(qp->best, qp->x, qp->stride * sizeof *qp->best);
            if (!qp_add(qp, row, side)) {
                return QP_INFEASIBLE;
            }
        }
    }
}

/* The rows that were active are so at first, with their multipliers. */
static void qp_warm(qp *qp)
{
    qp->active = 0;
    for (int i = 0; i < qp->n + qp->m; i++) {
        const int side = qp->side[i];

        qp->side[i] = 0;
        if (side != 0 && isfinite(qp_bound(qp, i, side))) {
            (void)qp_append(qp, i, side, qp->all[i] * side > 0.0 ? qp->all[i] : 0.0);
        }
    }
}

static double qp_cut(double value, double lower, double upper)
{
    return value < lower ? lower : value > upper ? upper : value;
}

/* The derivative by t of the cost of soft rows at from + t (to - from); `start` and `length` are
 * what the rows are at the ends. */
static double qp_soft_slope(const qp *qp, double t)
{
    const qp_bounds *b = qp->bounds;
    double slope = 0.0;

    for (int r = 0; r < qp->m; r++) {
        const double rate = qp->length[r] - qp->start[r];
        const double value = qp->start[r] + t * rate;
        const double beyond =
            fmax(value - b->row_upper[r], 0.0) - fmax(b->row_lower[r] - value, 0.0);

        slope += qp_soft(qp, r) ? beyond * rate / b->softness[r] : 0.0;
    }
    return slope;
}

/* From `inside`, where all hard bounds hold, towards `best` as far as they hold and the cost, which
 * is convex, falls. */
static void qp_towards(qp *qp, const double *inside, double *result)
{
    const qp_bounds *b = qp->bounds;
    double high = 1.0;
    double low = 0.0;
    double slope = 0.0; /* without soft rows at 0, and by t */
    double curvature = 0.0;

    for (int i = 0; i < qp->n + qp->m; i++) {
        const int r = i - qp->n;
        const double *row = r < 0 ? qp->U + i * qp->stride : b->A + r * qp->stride;
        double from = 0.0;
        double to = 0.0;
        double room;

        for (int j = 0; j < qp->n; j++) {
            from += row[j] * (r < 0 ? inside[j] - qp->x0[j] : inside[j]);
            to += row[j] * (r < 0 ? qp->best[j] - qp->x0[j] : qp->best[j]);
        }
        if (r < 0) {
            slope += from * (to - from);
            curvature += (to - from) * (to - from);
            from = inside[i];
            to = qp->best[i];
        } else {
            qp->start[r] = from;
            qp->length[r] = to;
        }
        room = to > from ? qp_bound(qp, i, 1) - from : from - qp_bound(qp, i, -1);
        if (fabs(to - from) * high > room && !(r >= 0 && qp_soft(qp, r))) {
            high = room > 0.0 ? room / fabs(to - from) : 0.0;
        }
    }
    low = slope + high * curvature + qp_soft_slope(qp, high) > 0.0 ? 0.0 : high;
    for (int i = 0; i < 50; i++) {
        const double t = 0.5 * (low + high);

        if (slope + t * curvature + qp_soft_slope(qp, t) > 0.0) {
            high = t;
        } else {
            low = t;
        }
    }
    for (int i = 0; i < qp->n; i++) {
        result[i] = qp_cut(inside[i] + low * (qp->best[i] - inside[i]), b->lower[i], b->upper[i]);
    }
}

qp_status qp_solve(qp *qp, const double *g, const qp_bounds *bounds, const double *inside,
                   double *result)
{
    qp_status status;

    qp->bounds = bounds;
    qp->iterations = 0;
    qp->least = false;
    if (!qp->factored || !qp_bounds_good(qp) || !qp_unconstrained(qp, g)) {
        for (int i = 0; i < qp->n; i++) {
            result[i] =
                inside != NULL ? inside[i] : qp_cut(0.0, bounds->lower[i], bounds->upper[i]);
        }
        qp_forget(qp);
        return QP_BAD;
    }
    qp_warm(qp);
    status = qp_iterate(qp);
    if (status == QP_INFEASIBLE) {
        qp_forget(qp);
        qp->active = 0;
        qp->least = true;
        status = qp_iterate(qp) == QP_LIMIT ? QP_LIMIT : QP_INFEASIBLE;
    }
    memset(qp->all, 0, (qp->n + qp->m) * sizeof *qp->all);
    for (int i = 0; i < qp->active; i++) {
        qp->all[qp->row[i]] = qp->now[i];
    }
    if (status == QP_LIMIT && inside != NULL) {
        qp_towards(qp, inside, result);
        return status;
    }
    for (int i = 0; i < qp->n; i++) {
        result[i] =
            qp_cut(status == QP_LIMIT ? qp->best[i] : qp->x[i], bounds->lower[i], bounds->upper[i]);
    }
    return status;
}
