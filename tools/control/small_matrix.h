/* Dense linear algebra of 1 to 100 unknowns for filters and controllers: no allocation, no library,
 * the same bits on any processor. Matrices are row by row, rows
 * small_matrix_stride(columns) apart, at most SMALL_MATRIX_MOST. What a row has beyond its columns
 * has to be finite, and is 0 for results of sums of products with it. */
#ifndef CONTROL_SMALL_MATRIX_H
#define CONTROL_SMALL_MATRIX_H

#include <stddef.h>

enum { SMALL_MATRIX_LANES = 8, SMALL_MATRIX_MOST = 128 /* columns */ };

/* Loops compiled for the widest vectors of the processor at hand, unless a compiler's options say
 * which; for static functions only. */
/* ThreadSanitizer does not survive what chooses between them; clang's says so in this way. */
#if defined(__has_feature)
#if __has_feature(thread_sanitizer) && !defined(__SANITIZE_THREAD__)
#define __SANITIZE_THREAD__ 1
#endif
#endif
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__AVX512F__) &&                      \
    !defined(__SANITIZE_THREAD__)
#define SMALL_FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define SMALL_FOR_EACH_PROCESSOR
#endif

/* The next multiple of SMALL_MATRIX_LANES: of rows that loops take in whole vectors. */
static inline int small_matrix_stride(int columns)
{
    return (columns + SMALL_MATRIX_LANES - 1) / SMALL_MATRIX_LANES * SMALL_MATRIX_LANES;
}

/* Memory in pieces of `count` times `size` bytes, which begin at multiples of 64 from `used` on;
 * without memory they are only counted. */
static inline void *small_matrix_take(void *memory, size_t *used, size_t count, size_t size)
{
    void *result = memory == NULL ? NULL : (unsigned char *)memory + *used;

    *used += (count * size + 63) / 64 * 64;
    return result;
}

/* a'b of rows of `count` numbers, a multiple of SMALL_MATRIX_LANES: in lanes, as vectors take it.
 */
static inline double small_matrix_dot(int count, const double *a, const double *b)
{
    double lanes[SMALL_MATRIX_LANES] = {0};

    for (int i = 0; i < count; i += SMALL_MATRIX_LANES) {
        for (int j = 0; j < SMALL_MATRIX_LANES; j++) {
            lanes[j] += a[i + j] * b[i + j];
        }
    }
    return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) +
           ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

/* Rows of vectors side by side: c [m][n] = a [m][k] b [k][n], and c [k][n] = a^T [k][m] b [m][n];
 * c is neither a nor b. */
void small_matrix_product(int m, int k, int n, const double *a, const double *b, double *c);
/* c [m][stride] = a [m][k of stride] b [k][stride]. */
void small_matrix_product_in(int stride, int m, int k, const double *a, const double *b, double *c);
void small_matrix_product_transposed(int m, int k, int n, const double *a, const double *b,
                                     double *c);

/* R in the upper triangle of a [rows][n], with a diagonal that is not negative, R^T R = A^T A, by
 * reflections (Householder); rows 0..n-1 are R with zeros below the diagonal, what was in the
 * others is lost. rows >= n. */
void small_matrix_triangle(int rows, int n, double *a);

/* U of a positive definite A = U^T U, from the upper triangle of a [n][n] into it; below it zeros.
 * Returns 0, or 1 + i: pivot i is not positive, and a is not defined. */
int small_matrix_cholesky(int n, double *a);

/* With the upper triangle U [n][n], whose diagonal is not 0, in place of the right side: U^T x = b
 * of a vector x [n], and U^T U X = B of a matrix X [n][columns]. */
void small_matrix_solve_transposed(int n, const double *u, double *x);
void small_matrix_solve_factored(int n, const double *u, int columns, double *x);

#endif
