/* A ~ (A Q) (Q^T A Q)^-1 (A Q)^T for an orthonormal Q of random directions. With the Cholesky
 * factor L of Q^T A Q this is B B^T, B = A Q L^-T; the eigenvectors of B B^T are those of the small
 * matrix that an orthonormal basis of B's columns leaves. Vectors are rows here. */
#include "internal.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct optim_nystrom {
    size_t count, rank;
    double *q;           /* [rank][count] */
    double *u;           /* [rank][count] */
    double *core, *turn; /* [rank][rank], work */
    double *lambda;      /* [rank] */
    double *row;         /* [rank], work */
};

void optim_nystrom_free(optim_nystrom *n)
{
    free(n);
}

static void add_multiple(size_t count, double factor, const double *x, double *y)
{
    for (size_t i = 0; i < count; i++) {
        y[i] += factor * x[i];
    }
}

/* Rows become orthonormal, a row that depends on earlier ones 0; a [rank][rank]: rows before =
 * a times rows after, a lower triangle. By Gram-Schmidt, twice. */
static void orthonormalise(const optim_nystrom *n, double *rows, double *a)
{
    memset(a, 0, n->rank * n->rank * sizeof *a);
    for (size_t i = 0; i < n->rank; i++) {
        double *row = rows + i * n->count;
        const double before = sqrt(optim_dot(n->count, row, row));
        for (size_t k = 0; k < 2 * i; k++) {
            const size_t j = k % i;
            const double along = optim_dot(n->count, row, rows + j * n->count);
            a[i * n->rank + j] += along;
            add_multiple(n->count, -along, rows + j * n->count, row);
        }
        const double length = sqrt(optim_dot(n->count, row, row));
        const double by = length > 100 * DBL_EPSILON * before ? 1 / length : 0;
        a[i * n->rank + i] = by > 0 ? length : 0;
        for (size_t k = 0; k < n->count; k++) {
            row[k] *= by;
        }
    }
}

optim_nystrom *optim_nystrom_create(size_t count, size_t rank, const double *random)
{
    const optim_part parts[] = {
        OPTIM_WORK(optim_nystrom, q, rank, count),   OPTIM_WORK(optim_nystrom, u, rank, count),
        OPTIM_WORK(optim_nystrom, core, rank, rank), OPTIM_WORK(optim_nystrom, turn, rank, rank),
        OPTIM_WORK(optim_nystrom, lambda, 1, rank),  OPTIM_WORK(optim_nystrom, row, 1, rank)};
    optim_nystrom *n = optim_room_create(sizeof *n, sizeof parts / sizeof *parts, parts);
    if (!n) {
        return NULL;
    }
    n->count = count;
    n->rank = rank;
    memcpy(n->q, random, rank * count * sizeof *random);
    orthonormalise(n, n->q, n->core);
    return n;
}

/* ---- a new A ---- */

/* Rows of u, A Q, become rows of B. A direction that A hardly sees beside the others is left out:
 * where rounding stands for its part of A Q. So this factor of a matrix of at most some 80 rows is
 * not that of a dense library: a pivot lost in rounding is taken as 0, where others give up. */
static void divide_by_factor(optim_nystrom *n)
{
    const size_t rank = n->rank;
    double *l = n->core, trace = 0;
    for (size_t i = 0; i < rank; i++) {
        for (size_t j = 0; j <= i; j++) {
            l[i * rank + j] = optim_dot(n->count, n->u + i * n->count, n->q + j * n->count);
        }
        trace += l[i * rank + i];
    }
    for (size_t i = 0; i < rank; i++) {
        for (size_t j = 0; j <= i; j++) {
            double sum = l[i * rank + j];
            for (size_t k = 0; k < j; k++) {
                sum -= l[i * rank + k] * l[j * rank + k];
            }
            const double pivot = l[j * rank + j];
            l[i * rank + j] = j < i                            ? (pivot > 0 ? sum / pivot : 0)
                              : sum > 50 * DBL_EPSILON * trace ? sqrt(sum)
                                                               : 0;
        }
        const double pivot = l[i * rank + i];
        double *row = n->u + i * n->count;
        for (size_t j = 0; j < i; j++) {
            add_multiple(n->count, -l[i * rank + j], n->u + j * n->count, row);
        }
        for (size_t k = 0; k < n->count; k++) {
            row[k] = pivot > 0 ? row[k] / pivot : 0;
        }
    }
}

/* One rotation of Jacobi's method for the symmetric core: entry (i, j) becomes 0. */
static void rotate(optim_nystrom *n, size_t i, size_t j)
{
    const size_t rank = n->rank;
    double *a = n->core;
    const double off = a[i * rank + j];
    const double ratio = (a[j * rank + j] - a[i * rank + i]) / (2 * off);
    const double tangent = (ratio >= 0 ? 1 : -1) / (fabs(ratio) + hypot(1, ratio));
    const double cosine = 1 / hypot(1, tangent), sine = tangent * cosine;
    for (size_t k = 0; k < rank; k++) {
        const double left = a[k * rank + i], right = a[k * rank + j];
        a[k * rank + i] = cosine * left - sine * right;
        a[k * rank + j] = sine * left + cosine * right;
    }
    for (size_t k = 0; k < rank; k++) {
        const double upper = a[i * rank + k], lower = a[j * rank + k];
        a[i * rank + k] = cosine * upper - sine * lower;
        a[j * rank + k] = sine * upper + cosine * lower;
        const double first = n->turn[i * rank + k], second = n->turn[j * rank + k];
        n->turn[i * rank + k] = cosine * first - sine * second;
        n->turn[j * rank + k] = sine * first + cosine * second;
    }
}

/* core = turn^T diag turn; diag stays in core. */
static void diagonalise(optim_nystrom *n)
{
    enum { SWEEPS = 30 };
    const size_t rank = n->rank;
    double trace = 0;
    memset(n->turn, 0, rank * rank * sizeof *n->turn);
    for (size_t i = 0; i < rank; i++) {
        n->turn[i * rank + i] = 1;
        trace += n->core[i * rank + i];
    }
    int turned = 1;
    for (int sweep = 0; sweep < SWEEPS && turned; sweep++) {
        turned = 0;
        for (size_t i = 0; i < rank; i++) {
            for (size_t j = i + 1; j < rank; j++) {
                if (fabs(n->core[i * rank + j]) > DBL_EPSILON * DBL_EPSILON * trace) {
                    rotate(n, i, j);
                    turned = 1;
                }
            }
        }
    }
}

/* lambda falls, rows of turn with it. */
static void sort(optim_nystrom *n)
{
    const size_t rank = n->rank;
    for (size_t i = 0; i < rank; i++) {
        n->lambda[i] = fmax(n->core[i * rank + i], 0);
    }
    for (size_t i = 0; i < rank; i++) {
        size_t top = i;
        for (size_t j = i + 1; j < rank; j++) {
            top = n->lambda[j] > n->lambda[top] ? j : top;
        }
        const double lambda = n->lambda[i];
        n->lambda[i] = n->lambda[top];
        n->lambda[top] = lambda;
        for (size_t k = 0; k < rank; k++) {
            const double entry = n->turn[i * rank + k];
            n->turn[i * rank + k] = n->turn[top * rank + k];
            n->turn[top * rank + k] = entry;
        }
    }
}

/* Rows of u become turn times rows of u. */
static void turn_rows(optim_nystrom *n)
{
    for (size_t c = 0; c < n->count; c++) {
        for (size_t i = 0; i < n->rank; i++) {
            n->row[i] = n->u[i * n->count + c];
        }
        for (size_t i = 0; i < n->rank; i++) {
            n->u[i * n->count + c] = optim_dot(n->rank, n->turn + i * n->rank, n->row);
        }
    }
}

int optim_nystrom_update(optim_nystrom *n, optim_product product, void *context)
{
    const size_t rank = n->rank;
    for (size_t i = 0; i < rank; i++) {
        const int code = product(context, n->q + i * n->count, n->u + i * n->count);
        if (code != 0) {
            return code;
        }
    }
    divide_by_factor(n);
    double *a = n->turn; /* B = a u */
    orthonormalise(n, n->u, a);
    for (size_t i = 0; i < rank; i++) { /* core = a^T a */
        for (size_t j = 0; j < rank; j++) {
            double sum = 0;
            for (size_t k = 0; k < rank; k++) {
                sum += a[k * rank + i] * a[k * rank + j];
            }
            n->core[i * rank + j] = sum;
        }
    }
    diagonalise(n);
    sort(n);
    turn_rows(n);
    return 0;
}

/* ---- what it is for ---- */

const double *optim_nystrom_eigenvalues(const optim_nystrom *n)
{
    return n->lambda;
}

void optim_nystrom_diagonal(const optim_nystrom *n, double *diagonal)
{
    memset(diagonal, 0, n->count * sizeof *diagonal);
    for (size_t i = 0; i < n->rank; i++) {
        const double *u = n->u + i * n->count;
        for (size_t k = 0; k < n->count; k++) {
            diagonal[k] += n->lambda[i] * u[k] * u[k];
        }
    }
}

void optim_nystrom_apply(const optim_nystrom *n, double damping, const double *r, double *z)
{
    const double last = n->lambda[n->rank - 1] + damping;
    memcpy(z, r, n->count * sizeof *z);
    for (size_t i = 0; i < n->rank; i++) {
        const double *u = n->u + i * n->count;
        const double along = optim_dot(n->count, u, r);
        if (n->lambda[i] + damping > 0) {
            add_multiple(n->count, (last / (n->lambda[i] + damping) - 1) * along, u, z);
        }
    }
}
