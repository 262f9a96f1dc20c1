#include "tools/control/small_matrix.h"

#include <math.h>
#include <string.h>

typedef double lanes __attribute__((vector_size(SMALL_MATRIX_LANES * sizeof(double)),
                                    aligned(sizeof(double)), may_alias));

/* ---- products ------------------------------------------------------------------------------ */

enum { BLOCK = 4 }; /* rows at a time, each with a sum of its own */

/* c [m][n] of a[i row + j column] and b, whose rows, as those of c, are `stride` apart. */
SMALL_FOR_EACH_PROCESSOR static void multiply(int m, int k, int stride, const double *a, int row,
                                              int column, const double *b, double *c)
{
    for (int i = 0; i < m; i += BLOCK) {
        const int rows = m - i < BLOCK ? m - i : BLOCK;
        const double *a0 = a + i * row, *a1 = a0 + (rows > 1 ? row : 0);
        const double *a2 = a1 + (rows > 2 ? row : 0), *a3 = a2 + (rows > 3 ? row : 0);
        for (int first = 0; first < stride; first += SMALL_MATRIX_LANES) {
            const double *x = b + first;
            lanes sum[BLOCK] = {{0}, {0}, {0}, {0}};
            for (int j = 0; j < k; j++) {
                const lanes y = *(const lanes *)(x + j * stride);
                sum[0] += a0[j * column] * y;
                sum[1] += a1[j * column] * y;
                sum[2] += a2[j * column] * y;
                sum[3] += a3[j * column] * y;
            }
            for (int r = 0; r < rows; r++) {
                *(lanes *)(c + (i + r) * stride + first) = sum[r];
            }
        }
    }
}

void small_matrix_product(int m, int k, int n, const double *a, const double *b, double *c)
{
    multiply(m, k, small_matrix_stride(n), a, small_matrix_stride(k), 1, b, c);
}

void small_matrix_product_in(int stride, int m, int k, const double *a, const double *b, double *c)
{
    multiply(m, k, stride, a, stride, 1, b, c);
}

void small_matrix_product_transposed(int m, int k, int n, const double *a, const double *b,
                                     double *c)
{
    multiply(k, m, small_matrix_stride(n), a, 1, small_matrix_stride(k), b, c);
}

/* ---- triangles ----------------------------------------------------------------------------- */

/* Sum over rows of at[i] block[i], a few of them at a time. */
static inline __attribute__((always_inline)) void sum_rows(int rows, int stride, const double *at,
                                                           const double *block, lanes *result)
{
    lanes sum[4] = {{0}, {0}, {0}, {0}};
    int i = 0;
    for (; i + 3 < rows; i += 4) {
        for (int k = 0; k < 4; k++) {
            sum[k] += at[(i + k) * stride] * *(const lanes *)(block + (i + k) * stride);
        }
    }
    for (; i < rows; i++) {
        sum[0] += at[i * stride] * *(const lanes *)(block + i * stride);
    }
    *result = (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/* Reflection j: x - v (v^T x) 2/|v|^2 with v = column j from row j on, less what it becomes. */
SMALL_FOR_EACH_PROCESSOR static void reflect(int rows, int stride, double *a, int j)
{
    double *from = a + j * stride, *v = from + j;
    const int left = rows - j, begin = j / SMALL_MATRIX_LANES * SMALL_MATRIX_LANES;
    lanes by[SMALL_MATRIX_MOST / SMALL_MATRIX_LANES];
    const double first = *v;
    sum_rows(left, stride, v, from + begin, &by[0]);
    const double square = by[0][j - begin];
    if (!(square > 0)) { /* a column of zeros, or no numbers at all */
        return;
    }
    const double norm = copysign(sqrt(square), first), head = first + norm;
    const double scale = 1 / (norm * head); /* 2/|v|^2 */
    for (int b = begin; b < stride; b += SMALL_MATRIX_LANES) {
        const int at = (b - begin) / SMALL_MATRIX_LANES;
        if (at > 0) {
            sum_rows(left, stride, v, from + b, &by[at]);
        }
        by[at] = (by[at] + norm * *(const lanes *)(from + b)) * scale;
    }
    *v = head;
    for (int i = 0; i < left; i++) {
        const double x = v[i * stride];
        for (int b = begin; b < stride; b += SMALL_MATRIX_LANES) {
            *(lanes *)(from + i * stride + b) -= x * by[(b - begin) / SMALL_MATRIX_LANES];
        }
        v[i * stride] = 0;
    }
    *v = -norm;
}

void small_matrix_triangle(int rows, int n, double *a)
{
    const int stride = small_matrix_stride(n);
    for (int j = 0; j < n; j++) {
        reflect(rows, stride, a, j);
    }
    for (int i = 0; i < n; i++) {
        if (a[i * stride + i] < 0) {
            for (int k = i; k < n; k++) {
                a[i * stride + k] = -a[i * stride + k];
            }
        }
    }
}

SMALL_FOR_EACH_PROCESSOR static int factor_upper(int n, double *a)
{
    const int stride = small_matrix_stride(n);
    for (int k = 0; k < n; k++) {
        double *row = a + k * stride;
        if (!(row[k] > 0)) {
            return k + 1;
        }
        const double root = sqrt(row[k]);
        for (int c = 0; c < k; c++) {
            row[c] = 0;
        }
        row[k] = root;
        for (int c = k + 1; c < n; c++) {
            row[c] /= root;
        }
        for (int i = k + 1; i < n; i++) {
            const double by = row[i];
            for (int c = i; c < n; c++) {
                a[i * stride + c] -= by * row[c];
            }
        }
    }
    return 0;
}

int small_matrix_cholesky(int n, double *a)
{
    return factor_upper(n, a);
}

/* ---- solutions ----------------------------------------------------------------------------- */

void small_matrix_solve_transposed(int n, const double *u, double *x)
{
    const int stride = small_matrix_stride(n);
    for (int i = 0; i < n; i++) {
        x[i] /= u[i * stride + i];
        for (int k = i + 1; k < n; k++) {
            x[k] -= u[i * stride + k] * x[i];
        }
    }
}

/* to -= by from, rows of vectors. */
static inline __attribute__((always_inline)) void subtract(int stride, double by,
                                                           const double *from, double *to)
{
    for (int b = 0; b < stride; b += SMALL_MATRIX_LANES) {
        *(lanes *)(to + b) -= by * *(const lanes *)(from + b);
    }
}

SMALL_FOR_EACH_PROCESSOR static void solve_rows(int n, const double *u, int width, double *x)
{
    const int stride = small_matrix_stride(n);
    for (int pass = 0; pass < 2; pass++) { /* U^T, then U */
        for (int step = 0; step < n; step++) {
            const int i = pass ? n - 1 - step : step;
            for (int k = pass ? i + 1 : 0; k < (pass ? n : i); k++) {
                subtract(width, pass ? u[i * stride + k] : u[k * stride + i], x + k * width,
                         x + i * width);
            }
            for (int b = 0; b < width; b++) {
                x[i * width + b] /= u[i * stride + i];
            }
        }
    }
}

void small_matrix_solve_factored(int n, const double *u, int columns, double *x)
{
    solve_rows(n, u, small_matrix_stride(columns), x);
}
