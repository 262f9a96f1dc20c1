#include "autodiff/dense.h"

#include "autodiff/program.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 192, SMALL = 2 * BLOCK };

/* Work on an upper triangle cut into tiles. */
typedef struct tiled {
    const blas *library;
    size_t n, count; /* of tiles in a row */
    double *matrix;
    size_t k;        /* factor: the step; gram: rows of a */
    const double *a; /* gram */
} tiled;

typedef struct span {
    size_t first;
    int count;
} span;

static span tile_span(const tiled *t, size_t tile)
{
    size_t first = tile * t->n / t->count;
    return (span){first, (int)((tile + 1) * t->n / t->count - first)};
}

static tiled tiles_of(size_t n, double *matrix)
{
    return (tiled){ad_blas_load(NULL), n, (n + BLOCK - 1) / BLOCK, matrix, 0, NULL};
}

/* Tile `item` of the triangle of tiles whose rows and columns begin at `first`. */
static void locate(const tiled *t, size_t first, size_t item, size_t *row, size_t *column)
{
    size_t width = t->count - first, i = 0;
    for (; item >= width - i; i++) {
        item -= width - i;
    }
    *row = first + i;
    *column = first + i + item;
}

ad_status ad_dense_load(ad_error *error)
{
    return ad_blas_load(error) ? AD_OK : AD_NO_BLAS;
}

/* tile(i, j) = alpha a_i^T a_j + beta tile(i, j), for columns i and j of rows of stride n. */
static void product(const tiled *t, size_t i, size_t j, int rows, const double *from, double alpha,
                    double beta)
{
    span r = tile_span(t, i), c = tile_span(t, j);
    double *to = t->matrix + r.first * t->n + c.first;
    int n = (int)t->n;
    if (i == j) {
        t->library->syrk(BLAS_ROW_MAJOR, BLAS_UPPER, BLAS_TRANSPOSED, r.count, rows, alpha,
                         from + r.first, n, beta, to, n);
        return;
    }
    t->library->gemm(BLAS_ROW_MAJOR, BLAS_TRANSPOSED, BLAS_NORMAL, r.count, c.count, rows, alpha,
                     from + r.first, n, from + c.first, n, beta, to, n);
}

static void gram_tile(void *context, int item, int thread)
{
    const tiled *t = context;
    size_t row, column;
    (void)thread;
    locate(t, 0, (size_t)item, &row, &column);
    product(t, row, column, (int)t->k, t->a, 1, 0);
}

void ad_dense_gram(ad_pool *pool, size_t rows, size_t n, const double *a, double *c)
{
    tiled t = tiles_of(n, c);
    t.k = rows;
    t.a = a;
    ad_pool_run(pool, (int)(t.count * (t.count + 1) / 2), gram_tile, &t);
}

/* ---- Cholesky: a row-major upper triangle is LAPACK's lower one --------------------------------
 */

static void solve_tile(void *context, int item, int thread)
{
    const tiled *t = context;
    span r = tile_span(t, t->k), c = tile_span(t, t->k + 1 + (size_t)item);
    (void)thread;
    t->library->trsm(BLAS_ROW_MAJOR, BLAS_LEFT, BLAS_UPPER, BLAS_TRANSPOSED, BLAS_NON_UNIT, r.count,
                     c.count, 1, t->matrix + r.first * (t->n + 1), (int)t->n,
                     t->matrix + r.first * t->n + c.first, (int)t->n);
}

static void update_tile(void *context, int item, int thread)
{
    const tiled *t = context;
    size_t row, column;
    span r = tile_span(t, t->k);
    (void)thread;
    locate(t, t->k + 1, (size_t)item, &row, &column);
    product(t, row, column, r.count, t->matrix + r.first * t->n, -1, 1);
}

/* OpenBLAS lets a NaN pass for a pivot. */
static int factor_block(const blas *library, size_t stride, int size, double *matrix)
{
    int n = (int)stride, info = 0;
    library->potrf("L", &size, matrix, &n, &info);
    for (size_t i = 0; i < (size_t)size && info == 0; i++) {
        info = !(matrix[i * (stride + 1)] > 0);
    }
    return info;
}

int ad_dense_cholesky(ad_pool *pool, size_t n, double *matrix)
{
    tiled t = tiles_of(n, matrix);
    if (n <= SMALL) {
        return factor_block(t.library, n, (int)n, matrix);
    }
    for (t.k = 0; t.k < t.count; t.k++) {
        span s = tile_span(&t, t.k);
        if (factor_block(t.library, n, s.count, matrix + s.first * (n + 1)) != 0) {
            return 1;
        }
        int left = (int)(t.count - t.k - 1);
        if (left > 0) {
            ad_pool_run(pool, left, solve_tile, &t);
            ad_pool_run(pool, left * (left + 1) / 2, update_tile, &t);
        }
    }
    return 0;
}

void ad_dense_cholesky_solve(size_t n, const double *factor, double *x)
{
    int size = (int)n, one = 1, info = 0;
    ad_blas_load(NULL)->potrs("L", &size, &one, factor, &size, x, &size, &info);
}

/* ---- LU ---------------------------------------------------------------------------------------
 */

int ad_dense_lu(size_t n, double *matrix, int *pivots)
{
    int size = (int)n, info = 0;
    ad_blas_load(NULL)->getrf(&size, &size, matrix, &size, pivots, &info);
    for (size_t i = 0; i < n && info == 0; i++) {
        info = isnan(matrix[i * (n + 1)]) != 0;
    }
    return info;
}

void ad_dense_lu_solve(size_t n, size_t count, const double *factor, const int *pivots, double *x)
{
    int size = (int)n, columns = (int)count, info = 0;
    ad_blas_load(NULL)->getrs("N", &size, &columns, factor, &size, pivots, x, &size, &info);
}

/* ---- QR ---------------------------------------------------------------------------------------
 */

/* Columns whose part across those before is at least so long. */
static size_t rank_of(size_t rows, size_t n, const double *r, double least)
{
    size_t rank = 0;
    while (rank < n && fabs(r[rank * rows + rank]) > least) {
        rank++;
    }
    return rank;
}

size_t ad_dense_basis(size_t rows, size_t n, double *a, double least, double *coefficients,
                      int *order, double *work)
{
    int height = (int)rows, width = (int)n, space = 3 * width + 1, info = 0;
    for (size_t i = 0; i < n; i++) {
        order[i] = i == 0;
    }
    ad_blas_load(NULL)->geqp3(&height, &width, a, &height, order, work, work + n, &space, &info);
    int rank = (int)rank_of(rows, n, a, least);
    ad_blas_load(NULL)->trtri("U", "N", &rank, a, &height, &info);
    memset(coefficients, 0, n * n * sizeof *coefficients);
    for (size_t j = 0; j < (size_t)rank; j++) {
        for (size_t i = 0; i <= j; i++) {
            coefficients[j * n + (size_t)order[i] - 1] = a[j * rows + i];
        }
    }
    return (size_t)rank;
}

/* ---- inertia ----------------------------------------------------------------------------------
 */

/* Bunch and Kaufman's factors keep the inertia; each of their blocks of two has one eigenvalue of
 * either sign, and is marked by negative pivots. */
int ad_dense_negative(size_t n, double *matrix, int *pivots)
{
    int size = (int)n, info = 0, count = 0;
    ad_blas_load(NULL)->sytf2("L", &size, matrix, &size, pivots, &info);
    for (size_t i = 0; i < n; i++) {
        if (pivots[i] > 0) {
            count += matrix[i * (n + 1)] < 0;
        } else {
            count++;
            i++;
        }
    }
    return count;
}
