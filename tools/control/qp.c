#include "tools/control/qp_internal.h"
#include "tools/control/small.h"

#include <math.h>
#include <string.h>

static size_t qp_layout(const qp_settings *s, void *memory, qp *x)
{
    const size_t n = (size_t)s->variables;
    const size_t m = (size_t)s->rows;
    const size_t stride = (size_t)small_stride(s->variables);
    const size_t most = n + m + 1;
    size_t used = 0;

    (void)small_take(memory, &used, 1, sizeof(qp));
    x->U = small_take(memory, &used, n * stride, sizeof(double));
    x->inverse = small_take(memory, &used, n * stride, sizeof(double));
    x->columns = small_take(memory, &used, n * stride, sizeof(double));
    x->work = small_take(memory, &used, stride, sizeof(double));
    x->x0 = small_take(memory, &used, stride, sizeof(double));
    x->x = small_take(memory, &used, stride, sizeof(double));
    x->best = small_take(memory, &used, stride, sizeof(double));
    x->start = small_take(memory, &used, m, sizeof(double));
    x->length = small_take(memory, &used, m, sizeof(double));
    x->M = small_take(memory, &used, most * stride, sizeof(double));
    x->L = small_take(memory, &used, most * most, sizeof(double));
    x->D = small_take(memory, &used, most, sizeof(double));
    x->gap = small_take(memory, &used, most, sizeof(double));
    x->soft = small_take(memory, &used, most, sizeof(double));
    x->now = small_take(memory, &used, most, sizeof(double));
    x->next = small_take(memory, &used, most, sizeof(double));
    x->all = small_take(memory, &used, n + m, sizeof(double));
    x->row = small_take(memory, &used, most, sizeof(int));
    x->side = small_take(memory, &used, n + m, sizeof(int));
    return used;
}

size_t qp_size(const qp_settings *settings)
{
    qp x;

    return qp_layout(settings, NULL, &x);
}

qp *qp_init(void *memory, const qp_settings *settings)
{
    qp *x = memory;

    memset(memory, 0, qp_size(settings));
    (void)qp_layout(settings, memory, x);
    x->n = settings->variables;
    x->m = settings->rows;
    x->stride = small_stride(x->n);
    x->most = x->n + x->m + 1;
    x->limit = settings->iterations > 0 ? settings->iterations : 10 + 3 * (x->n + x->m);
    x->tolerance = settings->tolerance > 0 ? settings->tolerance : 1e-10;
    return x;
}

/* Nothing is active at first. */
static void qp_forget(qp *x)
{
    memset(x->side, 0, (x->n + x->m) * sizeof *x->side);
    memset(x->all, 0, (x->n + x->m) * sizeof *x->all);
}

void qp_shift(qp *x, int first, int count, int by)
{
    memmove(x->side + first, x->side + first + by, (count - by) * sizeof *x->side);
    memmove(x->all + first, x->all + first + by, (count - by) * sizeof *x->all);
}

int qp_iterations(const qp *x)
{
    return x->iterations;
}

int qp_iterations_most(const qp *x)
{
    return x->limit + x->most;
}

const double *qp_multipliers(const qp *x)
{
    return x->all;
}

SMALL_FOR_EACH_PROCESSOR static bool qp_invert(qp *x)
{
    const int n = x->n;
    const int stride = x->stride;

    memset(x->inverse, 0, (size_t)n * stride * sizeof *x->inverse);
    memset(x->columns, 0, (size_t)n * stride * sizeof *x->columns);
    for (int i = 0; i < n; i++) {
        double *row = x->inverse + i * stride;

        row[i] = 1.0;
        for (int k = i; k < n; k++) {
            const double *u = x->U + k * stride;

            row[k] /= u[k];
            for (int j = k + 1; j < n; j++) {
                row[j] -= row[k] * u[j];
            }
        }
        for (int k = i; k < n; k++) {
            if (!isfinite(row[k])) {
                return false;
            }
            x->columns[k * stride + i] = row[k];
        }
    }
    return true;
}

qp_status qp_factor(qp *x, const double *H)
{
    const int n = x->n;
    const int stride = x->stride;

    x->factored = false;
    memcpy(x->U, H, (size_t)n * stride * sizeof *H);
    if (small_cholesky(n, x->U) != 0) {
        return QP_BAD;
    }
    x->factored = qp_invert(x);
    return x->factored ? QP_SOLVED : QP_BAD;
}

/* x0 = -H^-1 g, and where it is in the rows of A. */
SMALL_FOR_EACH_PROCESSOR static bool qp_unconstrained(qp *x, const double *g)
{
    bool finite = true;

    qp_combine(x->n, x->stride, g, x->inverse, x->work);
    qp_combine(x->n, x->stride, x->work, x->columns, x->x0);
    for (int i = 0; i < x->n; i++) {
        x->x0[i] = -x->x0[i];
        finite = finite && isfinite(x->x0[i]);
    }
    for (int i = 0; i < x->m; i++) {
        const double *row = x->bounds->A + i * x->stride;

        x->start[i] = small_dot(x->stride, row, x->x0);
        x->length[i] = sqrt(small_dot(x->stride, row, row));
        finite = finite && isfinite(x->start[i]) && isfinite(x->length[i]);
    }
    return finite;
}

static bool qp_bounds_good(const qp *x)
{
    const qp_bounds *b = x->bounds;

    for (int i = 0; i < x->n; i++) {
        if (!(b->lower[i] <= b->upper[i])) {
            return false;
        }
    }
    for (int i = 0; i < x->m; i++) {
        if (!(b->row_lower[i] <= b->row_upper[i]) || (b->softness && !(b->softness[i] >= 0.0))) {
            return false;
        }
    }
    return true;
}

/* By how much a value lies beyond a bound, if by more than the tolerance. */
static double qp_beyond(const qp *x, double value, double lower, double upper, double length,
                        int *side)
{
    const double over = value - upper;
    const double under = lower - value;
    const double most = over > under ? over : under;
    const double bound = over > under ? upper : lower;

    *side = over > under ? 1 : -1;
    return most > x->tolerance * fmax(length, fabs(bound)) ? most / length : 0.0;
}

/* The row that x violates most, or -1. */
SMALL_FOR_EACH_PROCESSOR static int qp_worst(const qp *x, int *worst_side)
{
    const qp_bounds *b = x->bounds;
    double worst = 0.0;
    int result = -1;

    for (int i = 0; i < x->n + x->m; i++) {
        const int r = i - x->n;
        double beyond;
        int side;

        if (x->side[i] != 0) {
            continue;
        }
        if (r < 0) {
            beyond = qp_beyond(x, x->x[i], b->lower[i], b->upper[i], 1.0, &side);
        } else {
            const double length = x->length[r] > 0.0 ? x->length[r] : 1.0;
            const double value = small_dot(x->stride, b->A + r * x->stride, x->x);

            beyond = qp_beyond(x, value, b->row_lower[r], b->row_upper[r], length, &side);
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
static double qp_blocking(const qp *x, const double *rate, double least_rate, int *blocking)
{
    double t = INFINITY;

    *blocking = -1;
    for (int i = 0; i < x->active; i++) {
        const double towards = -rate[i] * x->side[x->row[i]];

        if (towards > least_rate && fabs(x->now[i]) < t * towards) {
            t = fabs(x->now[i]) / towards;
            *blocking = i;
        }
    }
    return t;
}

/* Adds a violated row; those on which it depends give way. False: none can, no point is allowed. */
static bool qp_add(qp *x, int row, int side)
{
    double multiplier = 0.0;

    while (!qp_append(x, row, side, multiplier)) {
        double *rate = x->next;
        double t;
        int blocking;

        /* m = sum of c m_i: the multiplier grows with its side, the others lose c times it. */
        for (int i = 0; i < x->active; i++) {
            rate[i] = x->soft[i] > 0.0 ? 0.0 : -side * rate[i];
        }
        t = qp_blocking(x, rate, 1e-10, &blocking);
        if (blocking < 0) {
            return false;
        }
        for (int i = 0; i < x->active; i++) {
            x->now[i] += t * rate[i];
        }
        multiplier += t * side;
        qp_drop(x, blocking);
        x->iterations++;
    }
    return true;
}

static qp_status qp_iterate(qp *x)
{
    memcpy(x->best, x->x0, x->stride * sizeof *x->best);
    for (;; x->iterations++) {
        int blocking = -1;
        double t = 1.0;

        if (x->iterations >= x->limit) {
            return QP_LIMIT;
        }
        qp_target(x);
        for (int i = 0; i < x->active; i++) {
            if (x->next[i] * x->side[x->row[i]] < 0.0) {
                const double part = x->now[i] / (x->now[i] - x->next[i]);

                if (part < t || blocking < 0) {
                    t = part;
                    blocking = i;
                }
            }
        }
        for (int i = 0; i < x->active; i++) {
            x->now[i] = blocking < 0 ? x->next[i] : x->now[i] + t * (x->next[i] - x->now[i]);
        }
        if (blocking >= 0) {
            qp_drop(x, blocking);
        } else {
            int side = 0;
            int row;

            qp_point(x);
            row = qp_worst(x, &side);
            if (row < 0) {
                qp_refine(x);
                return QP_SOLVED;
            }
            memcpy(x->best, x->x, x->stride * sizeof *x->best);
            if (!qp_add(x, row, side)) {
                return QP_INFEASIBLE;
            }
        }
    }
}

/* The rows that were active are so at first, with their multipliers. */
static void qp_warm(qp *x)
{
    x->active = 0;
    for (int i = 0; i < x->n + x->m; i++) {
        const int side = x->side[i];

        x->side[i] = 0;
        if (side != 0 && isfinite(qp_bound(x, i, side))) {
            (void)qp_append(x, i, side, x->all[i] * side > 0.0 ? x->all[i] : 0.0);
        }
    }
}

static double qp_cut(double value, double lower, double upper)
{
    return value < lower ? lower : value > upper ? upper : value;
}

/* The derivative by t of the cost of soft rows at from + t (to - from); `start` and `length` are
 * what the rows are at the ends. */
static double qp_soft_slope(const qp *x, double t)
{
    const qp_bounds *b = x->bounds;
    double slope = 0.0;

    for (int r = 0; r < x->m; r++) {
        const double rate = x->length[r] - x->start[r];
        const double value = x->start[r] + t * rate;
        const double beyond =
            fmax(value - b->row_upper[r], 0.0) - fmax(b->row_lower[r] - value, 0.0);

        slope += qp_soft(x, r) ? beyond * rate / b->softness[r] : 0.0;
    }
    return slope;
}

/* From `inside`, where all hard bounds hold, towards `best` as far as they hold and the cost, which
 * is convex, falls. */
static void qp_towards(qp *x, const double *inside, double *result)
{
    const qp_bounds *b = x->bounds;
    double high = 1.0;
    double low = 0.0;
    double slope = 0.0; /* without soft rows at 0, and by t */
    double curvature = 0.0;

    for (int i = 0; i < x->n + x->m; i++) {
        const int r = i - x->n;
        const double *row = r < 0 ? x->U + i * x->stride : b->A + r * x->stride;
        double from = 0.0;
        double to = 0.0;
        double room;

        for (int j = 0; j < x->n; j++) {
            from += row[j] * (r < 0 ? inside[j] - x->x0[j] : inside[j]);
            to += row[j] * (r < 0 ? x->best[j] - x->x0[j] : x->best[j]);
        }
        if (r < 0) {
            slope += from * (to - from);
            curvature += (to - from) * (to - from);
            from = inside[i];
            to = x->best[i];
        } else {
            x->start[r] = from;
            x->length[r] = to;
        }
        room = to > from ? qp_bound(x, i, 1) - from : from - qp_bound(x, i, -1);
        if (fabs(to - from) * high > room && !(r >= 0 && qp_soft(x, r))) {
            high = room > 0.0 ? room / fabs(to - from) : 0.0;
        }
    }
    low = slope + high * curvature + qp_soft_slope(x, high) > 0.0 ? 0.0 : high;
    for (int i = 0; i < 50; i++) {
        const double t = 0.5 * (low + high);

        if (slope + t * curvature + qp_soft_slope(x, t) > 0.0) {
            high = t;
        } else {
            low = t;
        }
    }
    for (int i = 0; i < x->n; i++) {
        result[i] = qp_cut(inside[i] + low * (x->best[i] - inside[i]), b->lower[i], b->upper[i]);
    }
}

qp_status qp_solve(qp *x, const double *g, const qp_bounds *bounds, const double *inside,
                   double *result)
{
    qp_status status;

    x->bounds = bounds;
    x->iterations = 0;
    x->least = false;
    if (!x->factored || !qp_bounds_good(x) || !qp_unconstrained(x, g)) {
        for (int i = 0; i < x->n; i++) {
            result[i] =
                inside != NULL ? inside[i] : qp_cut(0.0, bounds->lower[i], bounds->upper[i]);
        }
        qp_forget(x);
        return QP_BAD;
    }
    qp_warm(x);
    status = qp_iterate(x);
    if (status == QP_INFEASIBLE) {
        qp_forget(x);
        x->active = 0;
        x->least = true;
        status = qp_iterate(x) == QP_LIMIT ? QP_LIMIT : QP_INFEASIBLE;
    }
    memset(x->all, 0, (x->n + x->m) * sizeof *x->all);
    for (int i = 0; i < x->active; i++) {
        x->all[x->row[i]] = x->now[i];
    }
    if (status == QP_LIMIT && inside != NULL) {
        qp_towards(x, inside, result);
        return status;
    }
    for (int i = 0; i < x->n; i++) {
        result[i] =
            qp_cut(status == QP_LIMIT ? x->best[i] : x->x[i], bounds->lower[i], bounds->upper[i]);
    }
    return status;
}
