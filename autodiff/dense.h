/* Dense linear algebra for optimisers and solvers: products and factors of large matrices, dealt to
 * the threads of a pool by tiles that depend on the sizes alone, so that results have the same bits
 * for any number of threads. Symmetric matrices [n][n] are upper triangles, row-major; the lower
 * ones are neither read nor written. Nothing allocates but what is called create. */
#ifndef AD_DENSE_H
#define AD_DENSE_H

#include "autodiff/ad.h"

/* Once before anything else here; AD_NO_BLAS stands in `error` when there is no library. */
ad_status ad_dense_load(ad_error *error);

/* The processor that OpenBLAS' kernels are made for, as it names it ("SkylakeX"): results in their
 * last digits depend on it. OPENBLAS_CORETYPE in the environment chooses. "": none is loaded. */
const char *ad_dense_kernels(void);

/* c[n][n] = a^T a for a[rows][n]. */
void ad_dense_gram(ad_pool *pool, size_t rows, size_t n, const double *a, double *c);

/* c[m][n] = a b + beta c; `a` is stored [k][m] where it is to be transposed, `b` [n][k]. */
void ad_dense_multiply(ad_pool *pool, bool transpose_a, bool transpose_b, size_t m, size_t n,
                       size_t k, const double *a, const double *b, double beta, double *c);

/* Room for the Cholesky factor of a matrix of order n >= 1; NULL: out of memory. */
typedef struct ad_dense_factor ad_dense_factor;
ad_dense_factor *ad_dense_factor_create(size_t n);
void ad_dense_factor_free(ad_dense_factor *factor); /* NULL is fine */

/* Factor the matrix plus diag(shift[n]), or without shift when it is NULL; 0, or not when that is
 * not positive definite to rounding. Ranks of the pool (ranks.h) share the work, so all of them
 * have to call it; each ends with the whole factor. */
int ad_dense_cholesky(ad_pool *pool, const double *matrix, const double *shift,
                      ad_dense_factor *factor);

/* x[n]: the right side, then the solution. */
void ad_dense_cholesky_solve(const ad_dense_factor *factor, double *x);

/* The step of a damped least squares problem: (matrix + damping diag(scale[n])) step = -gradient,
 * step and gradient [n]; it is also where the shift is kept until it is factored. 0, or not as
 * above. */
int ad_dense_damped_step(ad_pool *pool, const double *matrix, const double *gradient,
                         double damping, const double *scale, size_t n, ad_dense_factor *factor,
                         double *step);

/* LU factors with partial pivoting of a general matrix [n][n], column-major, in place, by the
 * calling thread alone; pivots [n]. 0, or not when the matrix is singular or holds a NaN. */
int ad_dense_lu(size_t n, double *matrix, int *pivots);

/* x: `count` right sides [n] one after another, then the solutions. */
void ad_dense_lu_solve(size_t n, size_t count, const double *factor, const int *pivots, double *x);

/* Orthonormal combinations of the columns a[n][rows], rows >= n: the first column comes first, then
 * always that of which most is left (QR factors with column pivoting), until what is left of any
 * is shorter than `least`. Row i of coefficients [n][n] says how the i-th combination is made;
 * returns how many there are. a is overwritten; order [n], work [AD_DENSE_BASIS_WORK(n)]. */
#define AD_DENSE_BASIS_WORK(n) (4 * (size_t)(n) + 1)
size_t ad_dense_basis(size_t rows, size_t n, double *a, double least, double *coefficients,
                      int *order, double *work);

/* The triangle R of QR factors of a[n][rows], column-major with `stride` between columns: it is
 * left in the first rows, what is below is 0. By the calling thread alone; work
 * [AD_DENSE_TRIANGLE_WORK(n)]. */
#define AD_DENSE_TRIANGLE_WORK(columns) (65 * (size_t)(columns))
void ad_dense_triangle(size_t rows, size_t n, double *a, size_t stride, double *work);

/* Adds rows to such a triangle r[columns][n], of n columns and more to its right: b[columns][rows],
 * column-major both. The first n columns of b become 0, to be read as such whatever is left there;
 * the others of both are transformed with them. */
void ad_dense_triangle_add(size_t n, size_t rows, size_t columns, double *r, size_t r_stride,
                           double *b, size_t b_stride, double *work);

/* How many eigenvalues of a symmetric matrix [n][n] are negative; it is overwritten, pivots [n]. */
int ad_dense_negative(size_t n, double *matrix, int *pivots);

/* A small symmetric matrix a [n][n], all of it, becomes diagonal, and rows of v [n][n] its
 * eigenvectors; what is small beside the rest keeps its digits where the matrix is scaled well. By
 * Jacobi's method (Golub & Van Loan, Matrix Computations, 4th ed., 8.5), without a library. */
void ad_dense_diagonalize(size_t n, double *a, double *v);

/* Eigenvalues of a general matrix [n][n], column-major, which is overwritten: real, imaginary [n],
 * work [AD_DENSE_EIGEN_WORK(n)]. 0, or not when they are not found. */
#define AD_DENSE_EIGEN_WORK(n) (3 * (size_t)(n) + 1)
int ad_dense_eigenvalues(size_t n, double *matrix, double *real, double *imaginary, double *work);

#endif
