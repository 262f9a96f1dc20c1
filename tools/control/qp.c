#include "tools/control/qp.h"

#include "tools/control/small.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* With H = U'U, x0 = -H^-1 g and y = U(x - x0) the program is a least distance,
 *
 *   minimise 1/2 |y|^2   for   m_i y <= b_i - a_i x0,   m_i = a_i U^-1,
 *
 * which is solved by y = -sum of multipliers times m_i over the active rows, where
 * (M M' + softness) multipliers = -(b - A x0). A multiplier is negative where a lower bound holds.
 * Bounds of x are rows with a_i = e_i: number i < variables; row r of A has number variables + r.
 */
struct qp {
    int n, m, stride, most; /* most: of active rows */
    int limit, iterations, active;
    double tolerance;
    bool factored, least;    /* least: hard rows of A are expensive soft ones */
    const qp_bounds *bounds; /* while it is solved */
    double *inverse;         /* [n][stride] U^-1, an upper triangle */
    double *columns;         /* [n][stride] the same transposed */
    double *work;            /* [n][stride] U, then [stride] */
    double *x0, *x, *best;   /* [stride]; best: the last solution with some of the rows left out */
    double *start;           /* [m] A x0 */
    double *length;          /* [m] |a_i| */
    double *M;               /* [most][stride] of active rows */
    double *L, *D;           /* M M' + softness = L D L'; columns of L [most][most], D [most] */
    double *gap, *soft;      /* [most] b - a x0 and softness of active rows */
    double *now, *next;      /* [most] multipliers of active rows */
    double *all;             /* [n + m] multipliers */
    int *row;                /* [most] numbers of active rows */
    int *side;               /* [n + m] 1: the upper bound is active, -1: the lower, 0: none */
};

static const double qp_dependent = 1e-12; /* of a row: what is left of |m|^2 */
static const double qp_expensive = 1e-6;  /* softness of hard rows that cannot be met, by |m|^2 */

static size_t qp_layout(const qp_settings *s, void *memory, qp *x)
{
    const size_t n = (size_t)s->variables;
    const size_t m = (size_t)s->rows;
    const size_t stride = (size_t)small_stride(s->variables);
    const size_t most = n + m + 1;
    size_t used = 0;

    (void)small_take(memory, &used, 1, sizeof(qp));
    x->inverse = small_take(memory, &used, n * stride, sizeof(double));
    x->columns = small_take(memory, &used, n * stride, sizeof(double));
    x->work = small_take(memory, &used, n * stride, sizeof(double));
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

void qp_forget(qp *x)
{
    memset(x->side, 0, (size_t)(x->n + x->m) * sizeof *x->side);
    memset(x->all, 0, (size_t)(x->n + x->m) * sizeof *x->all);
}

int qp_iterations(const qp *x)
{
    return x->iterations;
}

const double *qp_multipliers(const qp *x)
{
    return x->all;
}

qp_status qp_factor(qp *x, const double *H)
{
    const int n = x->n;
    const int stride = x->stride;

    x->factored = false;
    memcpy(x->work, H, (size_t)n * (size_t)stride * sizeof *H);
    if (small_cholesky(n, x->work) != 0) {
        return QP_BAD;
    }
    memset(x->inverse, 0, (size_t)n * (size_t)stride * sizeof *x->inverse);
    memset(x->columns, 0, (size_t)n * (size_t)stride * sizeof *x->columns);
    for (int i = 0; i < n; i++) {
        double *row = x->inverse + (size_t)i * (size_t)stride;

        row[i] = 1.0;
        for (int k = i; k < n; k++) {
            const double *u = x->work + (size_t)k * (size_t)stride;

            row[k] /= u[k];
            for (int j = k + 1; j < n; j++) {
                row[j] -= row[k] * u[j];
            }
        }
        for (int k = i; k < n; k++) {
            if (!isfinite(row[k])) {
                return QP_BAD;
            }
            x->columns[(size_t)k * (size_t)stride + (size_t)i] = row[k];
        }
    }
    x->factored = true;
    return QP_SOLVED;
}

/* result [stride] = sum of weights [count] times rows [count][stride]. */
static void qp_combine(int count, int stride, const double *weights, const double *rows,
                       double *result)
{
    memset(result, 0, (size_t)stride * sizeof *result);
    for (int i = 0; i < count; i++) {
        const double *row = rows + (size_t)i * (size_t)stride;

        for (int j = 0; j < stride; j++) {
            result[j] += weights[i] * row[j];
        }
    }
}

/* x0 = -H^-1 g, and where it is in the rows of A. */
static bool qp_unconstrained(qp *x, const double *g)
{
    bool finite = true;

    qp_combine(x->n, x->stride, g, x->inverse, x->work);
    qp_combine(x->n, x->stride, x->work, x->columns, x->x0);
    for (int i = 0; i < x->n; i++) {
        x->x0[i] = -x->x0[i];
        finite = finite && isfinite(x->x0[i]);
    }
    for (int i = 0; i < x->m; i++) {
        const double *row = x->bounds->A + (size_t)i * (size_t)x->stride;

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

static double qp_bound(const qp *x, int row, int side)
{
    const qp_bounds *b = x->bounds;

    if (row < x->n) {
        return side > 0 ? b->upper[row] : b->lower[row];
    }
    return side > 0 ? b->row_upper[row - x->n] : b->row_lower[row - x->n];
}

/* m of a row, behind those of the active ones; its length squared. */
static double qp_direction(qp *x, int row)
{
    double *m = x->M + (size_t)x->active * (size_t)x->stride;

    if (row < x->n) {
        memcpy(m, x->inverse + (size_t)row * (size_t)x->stride, (size_t)x->stride * sizeof *m);
    } else {
        qp_combine(x->n, x->stride, x->bounds->A + (size_t)(row - x->n) * (size_t)x->stride,
                   x->inverse, m);
    }
    return small_dot(x->stride, m, m);
}

/* v [active] by L^-1 and by L'^-1. */
static void qp_forward(const qp *x, double *v)
{
    for (int i = 0; i < x->active; i++) {
        const double *column = x->L + (size_t)i * (size_t)x->most;

        for (int j = i + 1; j < x->active; j++) {
            v[j] -= column[j] * v[i];
        }
    }
}

static void qp_backward(const qp *x, double *v)
{
    for (int i = x->active - 1; i >= 0; i--) {
        const double *column = x->L + (size_t)i * (size_t)x->most;

        for (int j = i + 1; j < x->active; j++) {
            v[i] -= column[j] * v[j];
        }
    }
}

/* Adds a row with a multiplier to the active ones. False: it depends on them, as
 * m = sum of next [active] times their m. */
static bool qp_append(qp *x, int row, int side, double multiplier)
{
    const int k = x->active;
    const double *m = x->M + (size_t)k * (size_t)x->stride;
    const double squared = qp_direction(x, row);
    double *l = x->next;
    double soft = 0.0;
    double rest;

    if (row >= x->n) {
        soft = x->bounds->softness == NULL ? 0.0 : x->bounds->softness[row - x->n];
        soft = soft == 0.0 && x->least ? qp_expensive * squared : soft;
    }
    for (int i = 0; i < k; i++) {
        l[i] = small_dot(x->stride, x->M + (size_t)i * (size_t)x->stride, m);
    }
    qp_forward(x, l);
    rest = squared + soft;
    for (int i = 0; i < k; i++) {
        rest -= l[i] * l[i] / x->D[i];
        l[i] /= x->D[i];
    }
    if (soft == 0.0 && !(rest > qp_dependent * squared)) {
        qp_backward(x, l);
        return false;
    }
    for (int i = 0; i < k; i++) {
        x->L[(size_t)i * (size_t)x->most + (size_t)k] = l[i];
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

/* Drops active row i; L D L' of the later ones gains what the row took (Gill, Golub, Murray,
 * Saunders 1974, method C1). */
static void qp_drop(qp *x, int i)
{
    const int k = --x->active;
    const size_t most = (size_t)x->most;
    const size_t later = (size_t)(k - i) * sizeof *x->D;
    double *column = x->next;
    double alpha = x->D[i];

    x->side[x->row[i]] = 0;
    memcpy(column + i, x->L + (size_t)i * most + (size_t)i + 1, later);
    memmove(x->M + (size_t)i * (size_t)x->stride, x->M + (size_t)(i + 1) * (size_t)x->stride,
            (size_t)(k - i) * (size_t)x->stride * sizeof *x->M);
    for (int c = 0; c < i; c++) {
        memmove(x->L + (size_t)c * most + i, x->L + (size_t)c * most + i + 1, later);
    }
    for (int c = i; c < k; c++) {
        memcpy(x->L + (size_t)c * most + c + 1, x->L + (size_t)(c + 1) * most + c + 2,
               (size_t)(k - c - 1) * sizeof *x->L);
    }
    memmove(x->D + i, x->D + i + 1, later);
    memmove(x->gap + i, x->gap + i + 1, later);
    memmove(x->soft + i, x->soft + i + 1, later);
    memmove(x->now + i, x->now + i + 1, later);
    memmove(x->row + i, x->row + i + 1, (size_t)(k - i) * sizeof *x->row);
    for (int c = i; c < k; c++) {
        const double p = column[c];
        const double d = x->D[c] + alpha * p * p;
        const double beta = p * alpha / d;
        double *l = x->L + (size_t)c * most;

        alpha *= x->D[c] / d;
        x->D[c] = d;
        for (int r = c + 1; r < k; r++) {
            column[r] -= p * l[r];
            l[r] += beta * column[r];
        }
    }
}

/* next = the multipliers with which all active rows hold exactly. */
static void qp_target(qp *x)
{
    for (int i = 0; i < x->active; i++) {
        x->next[i] = -x->gap[i];
    }
    qp_forward(x, x->next);
    for (int i = 0; i < x->active; i++) {
        x->next[i] /= x->D[i];
    }
    qp_backward(x, x->next);
}

/* x of the multipliers `now`. */
static void qp_point(qp *x)
{
    qp_combine(x->active, x->stride, x->now, x->M, x->work);
    qp_combine(x->n, x->stride, x->work, x->columns, x->x);
    for (int i = 0; i < x->n; i++) {
        x->x[i] = x->x0[i] - x->x[i];
    }
}

/* One step of iterative refinement: updates of L D L' add up errors. */
static void qp_refine(qp *x)
{
    bool good = true;

    qp_combine(x->active, x->stride, x->now, x->M, x->work);
    for (int i = 0; i < x->active; i++) {
        x->next[i] = -x->gap[i] - x->soft[i] * x->now[i] -
                     small_dot(x->stride, x->M + (size_t)i * (size_t)x->stride, x->work);
    }
    qp_forward(x, x->next);
    for (int i = 0; i < x->active; i++) {
        x->next[i] /= x->D[i];
    }
    qp_backward(x, x->next);
    for (int i = 0; i < x->active; i++) {
        x->next[i] += x->now[i];
        good = good && x->next[i] * x->side[x->row[i]] >= 0.0;
    }
    if (good) {
        memcpy(x->now, x->next, (size_t)x->active * sizeof *x->now);
        qp_point(x);
    }
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
static int qp_worst(const qp *x, int *worst_side)
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
            const double value = small_dot(x->stride, b->A + (size_t)r * (size_t)x->stride, x->x);

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
    memcpy(x->best, x->x0, (size_t)x->stride * sizeof *x->best);
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
            memcpy(x->best, x->x, (size_t)x->stride * sizeof *x->best);
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

/* From `inside`, where all hard bounds hold, towards `best`, which is better than any allowed
 * point, as far as they hold: the cost is convex and falls on the whole way. */
static void qp_towards(const qp *x, const double *inside, double *result)
{
    const qp_bounds *b = x->bounds;
    double t = 1.0;

    for (int i = 0; i < x->n + x->m; i++) {
        const int r = i - x->n;
        const double *row = b->A + (size_t)(r < 0 ? 0 : r) * (size_t)x->stride;
        double from = r < 0 ? inside[i] : 0.0;
        double to = r < 0 ? x->best[i] : small_dot(x->stride, row, x->best);
        double room;

        if (r >= 0 && b->softness != NULL && b->softness[r] > 0.0) {
            continue;
        }
        for (int j = 0; r >= 0 && j < x->n; j++) {
            from += row[j] * inside[j];
        }
        room = to > from ? qp_bound(x, i, 1) - from : from - qp_bound(x, i, -1);
        if (fabs(to - from) * t > room) {
            t = room > 0.0 ? room / fabs(to - from) : 0.0;
        }
    }
    for (int i = 0; i < x->n; i++) {
        result[i] = qp_cut(inside[i] + t * (x->best[i] - inside[i]), b->lower[i], b->upper[i]);
    }
}

static qp_status qp_bad(qp *x, const qp_bounds *bounds, const double *inside, double *result)
{
    for (int i = 0; i < x->n; i++) {
        result[i] = inside != NULL ? inside[i] : qp_cut(0.0, bounds->lower[i], bounds->upper[i]);
    }
    qp_forget(x);
    return QP_BAD;
}

qp_status qp_solve(qp *x, const double *g, const qp_bounds *bounds, const double *inside,
                   double *result)
{
    qp_status status;

    x->bounds = bounds;
    x->iterations = 0;
    x->least = false;
    if (!x->factored || !qp_bounds_good(x) || !qp_unconstrained(x, g)) {
        return qp_bad(x, bounds, inside, result);
    }
    qp_warm(x);
    status = qp_iterate(x);
    if (status == QP_INFEASIBLE) {
        qp_forget(x);
        x->active = 0;
        x->least = true;
        status = qp_iterate(x) == QP_LIMIT ? QP_LIMIT : QP_INFEASIBLE;
    }
    memset(x->all, 0, (size_t)(x->n + x->m) * sizeof *x->all);
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
