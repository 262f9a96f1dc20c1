/* Elementwise loops, compiled once per instruction set and chosen at run time. Private. */
#ifndef AD_KERNELS_H
#define AD_KERNELS_H

#include "autodiff/tape/tape.h"

/* Row `r` of an operand starts at `at + r * stride`: one number per point, or, for an operand that
 * is uniform, a single number. */
typedef struct kernel_operand {
    const double *at;
    ptrdiff_t stride;
} kernel_operand;

enum { PANEL = 24, TILE = PANEL * PANEL }; /* columns of a panel; numbers of a tile */

/* out[r][j] = op(x[0][r][j], ...) for r < rows, j < points; points is a multiple of 8, rows of
 * `out` and of per-point operands are aligned to 64 bytes. */
typedef void (*kernel)(int rows, int points, double *out, ptrdiff_t stride, const kernel_operand *x,
                       int whole, double number);

enum { KERNEL_MASKS = 1 << AD_ARITY_MAX };

/* Single-threaded; see products.c. */
typedef struct product_set {
    /* c[m][n] = a b, or += where `add`: a[i][l] at a + i row + l column, i < m, l < k; rows of b
     * are aligned to 64 bytes and may be read up to the next multiple of 8 numbers */
    void (*multiply)(int m, int n, int k, const double *a, ptrdiff_t row, ptrdiff_t column,
                     const double *b, ptrdiff_t b_stride, double *c, ptrdiff_t c_stride, bool add);
    /* sum[m][k] += y x^T over the first `points` of m rows of y and k rows of x; rows of x as
     * those of b */
    void (*add_outer_sum)(int m, int k, int points, const double *y, ptrdiff_t y_stride,
                          const double *x, ptrdiff_t x_stride, double *sum);
    /* out[j * stride + r] = x[r][j]; points and stride are multiples of 8, `out` and rows of x are
     * aligned to 64 bytes */
    void (*transpose)(int rows, int points, double *out, ptrdiff_t stride, kernel_operand x);
    /* Panels [depth][PANEL] hold PANEL columns of a matrix; they are aligned to 64 bytes, as are
     * square tiles [PANEL][PANEL]. */
    /* c[i][j] += sum over k of a[k][i] b[k][j], or -= it, summed from k = 0 on */
    void (*multiply_panels)(size_t depth, const double *a, const double *b, bool subtract,
                            double *c);
    /* out[k][j] = sum over i < count of by[i][k] x[i][k][j] */
    void (*combine_panels)(int count, size_t depth, const double *const *by, const double *const *x,
                           double *out);
    /* x = u^-T x for an upper triangle u; the numbers below it are not read */
    void (*solve_tile)(const double *u, double *x);
} product_set;

typedef struct kernel_set {
    const char *name, *flags; /* the compiler's, for this instruction set */
    /* by operation and by which operands are uniform: bit i set for operand i */
    kernel loops[OP_ELEMENTWISE_END][KERNEL_MASKS];
    /* sum[r] += sum over the first `points` of x[r], in an order fixed by `points` alone */
    void (*sum_points)(int rows, int points, double *sum, kernel_operand x);
    /* out[k * stride + j] += y[j] x[k][j] for k < columns, j < points; operands per point; nothing
     * need be aligned */
    void (*add_outer)(int columns, int points, double *out, ptrdiff_t stride, const double *y,
                      kernel_operand x);
    const product_set *products;
} kernel_set;

extern const kernel_set ad_kernels_baseline;
#if defined(__x86_64__)
extern const kernel_set ad_kernels_avx2;
extern const kernel_set ad_kernels_avx512;
#endif

/* The widest set this processor runs. */
const kernel_set *ad_kernels_select(void);

#endif
