#include "autodiff/dense.h"

#include "autodiff/run/blas.h"
#include "autodiff/run/execute.h"
#include "autodiff/run/rank_exchange.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

ad_status ad_dense_load(ad_error *error)
{
    return ad_blas_load(error) ? AD_OK : ad_blas_status();
}

const char *ad_dense_kernels(void)
{
    const blas *library = ad_blas_load(NULL);
    return library ? library->core : "";
}

/* ---- a^T a ------------------------------------------------------------------------------------
 */

enum { WIDE = 192 }; /* columns of a tile of c */

typedef struct gram {
    const blas *library;
    size_t rows, n, count; /* count: tiles in a row of c */
    const double *a;
    double *c;
} gram;

/* Item of the triangle of tiles. */
static void gram_tile(void *context, int item, int thread)
{
    const gram *g = context;
    size_t row = 0, column = (size_t)item;
    (void)thread;
    for (; column >= g->count - row; row++) { /* a row has count - row tiles */
        column -= g->count - row;
    }
    column += row;
    size_t first = row * g->n / g->count, left = column * g->n / g->count;
    int height = (int)((row + 1) * g->n / g->count - first), n = (int)g->n;
    int width = (int)((column + 1) * g->n / g->count - left);
    double *to = g->c + first * g->n + left;
    if (row == column) {
        g->library->syrk(BLAS_ROW_MAJOR, BLAS_UPPER, BLAS_TRANSPOSED, height, (int)g->rows, 1,
                         g->a + first, n, 0, to, n);
    } else {
        g->library->gemm(BLAS_ROW_MAJOR, BLAS_TRANSPOSED, BLAS_NORMAL, height, width, (int)g->rows,
                         1, g->a + first, n, g->a + left, n, 0, to, n);
    }
}

void ad_dense_gram(ad_pool *pool, size_t rows, size_t n, const double *a, double *c)
{
    gram g = {ad_blas_load(NULL), rows, n, (n + WIDE - 1) / WIDE, a, c};
    ad_pool_run(pool, (int)(g.count * (g.count + 1) / 2), gram_tile, &g);
}

/* ---- a b ---------------------------------------------------------------------------------------
 */

enum { HIGH = 64 }; /* rows of c at a time */

typedef struct general {
    const blas *library;
    bool transpose_a, transpose_b;
    size_t m, n, k;
    const double *a, *b;
    double beta, *c;
} general;

static void general_rows(void *context, int item, int thread)
{
    const general *g = context;
    const size_t first = HIGH * (size_t)item, left = g->m - first;
    const int rows = (int)(left < HIGH ? left : HIGH), n = (int)g->n, k = (int)g->k;
    (void)thread;
    g->library->gemm(BLAS_ROW_MAJOR, g->transpose_a ? BLAS_TRANSPOSED : BLAS_NORMAL,
                     g->transpose_b ? BLAS_TRANSPOSED : BLAS_NORMAL, rows, n, k, 1,
                     g->a + first * (g->transpose_a ? 1 : g->k), g->transpose_a ? (int)g->m : k,
                     g->b, g->transpose_b ? k : n, g->beta, g->c + first * g->n, n);
}

void ad_dense_multiply(ad_pool *pool, bool transpose_a, bool transpose_b, size_t m, size_t n,
                       size_t k, const double *a, const double *b, double beta, double *c)
{
    general g = {ad_blas_load(NULL), transpose_a, transpose_b, m, n, k, a, b, beta, c};
    ad_pool_run(pool, (int)((m + HIGH - 1) / HIGH), general_rows, &g);
}

/* ---- Cholesky: matrix = u^T u ------------------------------------------------------------------
 * u is kept by columns in panels of PANEL columns, each of which ends with its square tile on the
 * diagonal. Rows are found BAND tiles at a time. Among ranks panels go around; those through which
 * the diagonal of a band goes become everyone's first, and so at the end all are. ScaLAPACK, SLATE
 * and PETSc keep the matrix itself in parts and would factor larger ones, but add up in an order
 * that follows from the number of processes, by whichever BLAS is there: other bits. */

enum { BAND = 4, CHUNK = 128 }; /* CHUNK rows of two panels fit into the L1 cache */

struct ad_dense_factor {
    const kernel_set *kernels;
    size_t n, panels;
    double *numbers; /* tile i of panel j is number j (j + 1) / 2 + i */
};

/* The rows at hand. */
typedef struct band {
    const ad_dense_factor *factor;
    const double *matrix, *shift;
    share *share;
    size_t first, end; /* tiles */
} band;

ad_dense_factor *ad_dense_factor_create(size_t n)
{
    ad_dense_factor *factor = calloc(1, sizeof *factor);
    void *numbers = NULL;
    size_t panels = (n + PANEL - 1) / PANEL;
    if (!factor || posix_memalign(&numbers, 64, panels * (panels + 1) / 2 * TILE * 8) != 0) {
        free(factor);
        return NULL;
    }
    *factor = (ad_dense_factor){ad_kernels_select(), n, panels, numbers};
    return factor;
}

void ad_dense_factor_free(ad_dense_factor *factor)
{
    if (factor) {
        free(factor->numbers);
        free(factor);
    }
}

static double *tile(const ad_dense_factor *f, size_t i, size_t j)
{
    return f->numbers + (j * (j + 1) / 2 + i) * TILE;
}

/* ---- whose panels they are ---- */

static size_t ranks_of(const band *b)
{
    return b->share->ranks ? (size_t)b->share->ranks->count : 1;
}

/* The first panel of this rank from `panel` on. */
static size_t own_from(const band *b, size_t panel)
{
    const size_t ranks = ranks_of(b), rank = ranks > 1 ? (size_t)b->share->ranks->rank : 0;
    return panel + (rank + ranks - panel % ranks) % ranks;
}

/* Of those beyond the diagonal. */
static size_t own_panel(const band *b, size_t which)
{
    return own_from(b, b->end) + ranks_of(b) * which;
}

static int own_panels(const band *b)
{
    const size_t first = own_from(b, b->end), end = b->factor->panels, ranks = ranks_of(b);
    return first < end ? (int)((end - first + ranks - 1) / ranks) : 0;
}

/* The panels of the diagonal become everyone's. They lie one after the other, and ranks have to be
 * in order. */
static void share_diagonal(const band *b)
{
    const size_t ranks = ranks_of(b);
    for (size_t from = b->first, to; from < b->end && ranks > 1; from = to) {
        size_t *bounds = b->share->bounds;
        const size_t rank = from % ranks;
        to = minimum(from + ranks - rank, b->end);
        for (size_t i = 0; i <= ranks; i++) {
            size_t panel = i < rank ? from : minimum(from + i - rank, to);
            bounds[i] = (panel * (panel + 1) - from * (from + 1)) / 2 * TILE;
        }
        b->share->ranks->gather(b->share->ranks->context, bounds, tile(b->factor, 0, from));
    }
}

/* ---- factoring ---- */

/* The tiles of one row of tiles; columns beyond n are those of the unit matrix. */
static void load_tiles(void *context, int item, int thread)
{
    const band *b = context;
    const ad_dense_factor *f = b->factor;
    const size_t row = (size_t)item, own = own_from(b, row), step = ranks_of(b);
    (void)thread;
    for (size_t i = row * PANEL; i < (row + 1) * PANEL; i++) {
        for (size_t j = own; j < f->panels; j += step) {
            double *to = tile(f, row, j) + i % PANEL * PANEL;
            size_t left = j * PANEL, from = i > left ? i : left;
            size_t end = left + PANEL < f->n ? left + PANEL : f->n;
            memset(to, 0, PANEL * sizeof *to);
            if (i < f->n) {
                memcpy(to + (from - left), b->matrix + i * f->n + from, (end - from) * sizeof *to);
            }
        }
        if (own == row) {
            double *pivot = tile(f, row, row) + i % PANEL * (PANEL + 1);
            *pivot = i >= f->n ? 1 : *pivot + (b->shift ? b->shift[i] : 0);
        }
    }
}

/* Take from the band of a panel what all rows above it give. */
static void update_panel(void *context, int item, int thread)
{
    const band *b = context;
    const ad_dense_factor *f = b->factor;
    const size_t diagonal = b->end - b->first, depth = b->first * PANEL;
    const size_t which = (size_t)item,
                 j = which < diagonal ? b->first + which : own_panel(b, which - diagonal);
    (void)thread;
    for (size_t k = 0; k < depth; k += CHUNK) {
        const size_t rows = minimum(depth - k, CHUNK);
        for (size_t i = b->first; i < b->end && i <= j; i++) {
            f->kernels->products->multiply_panels(rows, tile(f, 0, i) + k * PANEL,
                                                  tile(f, 0, j) + k * PANEL, true, tile(f, i, j));
        }
    }
}

/* One row of u after the other, in place; false: a pivot is not positive. */
static bool factor_tile(double *u)
{
    for (int i = 0; i < PANEL; i++) {
        double pivot = u[i * PANEL + i];
        if (!(pivot > 0 && isfinite(pivot))) {
            return false;
        }
        double by = sqrt(pivot);
        for (int j = i; j < PANEL; j++) {
            u[i * PANEL + j] /= by;
        }
        for (int k = i + 1; k < PANEL; k++) {
            for (int j = k; j < PANEL; j++) {
                u[k * PANEL + j] -= u[i * PANEL + k] * u[i * PANEL + j];
            }
        }
    }
    return true;
}

/* The band of panel j, once those of the panels of its diagonal are found. */
static bool finish(const band *b, size_t j)
{
    const ad_dense_factor *f = b->factor;
    bool ok = true;
    for (size_t i = b->first; i < b->end && i <= j && ok; i++) {
        f->kernels->products->multiply_panels((i - b->first) * PANEL, tile(f, b->first, i),
                                              tile(f, b->first, j), true, tile(f, i, j));
        if (i < j) {
            f->kernels->products->solve_tile(tile(f, i, i), tile(f, i, j));
        } else {
            ok = factor_tile(tile(f, i, i));
        }
    }
    return ok;
}

static void finish_panel(void *context, int item, int thread)
{
    const band *b = context;
    (void)thread;
    finish(b, own_panel(b, (size_t)item));
}

int ad_dense_cholesky(ad_pool *pool, const double *matrix, const double *shift,
                      ad_dense_factor *factor)
{
    band b = {.factor = factor, .matrix = matrix, .shift = shift};
    b.share = ad_pool_get_share(pool);
    ad_pool_run(pool, (int)factor->panels, load_tiles, &b);
    for (b.first = 0; b.first < factor->panels; b.first = b.end) {
        b.end = minimum(b.first + BAND, factor->panels);
        share_diagonal(&b);
        ad_pool_run(pool, (int)(b.end - b.first) + own_panels(&b), update_panel, &b);
        for (size_t j = b.first; j < b.end; j++) {
            if (!finish(&b, j)) {
                return 1;
            }
        }
        ad_pool_run(pool, own_panels(&b), finish_panel, &b);
    }
    return 0;
}

/* u^T z = x, from above. */
static void solve_down(const ad_dense_factor *f, size_t j, double *x)
{
    size_t left = j * PANEL, width = f->n - left < PANEL ? f->n - left : PANEL;
    double sum[PANEL] = {0};
    const double *u = tile(f, 0, j);
    for (size_t k = 0; k < left; k++) {
        for (size_t i = 0; i < PANEL; i++) {
            sum[i] += u[k * PANEL + i] * x[k];
        }
    }
    u += left * PANEL;
    for (size_t i = 0; i < width; i++) {
        x[left + i] = (x[left + i] - sum[i]) / u[i * PANEL + i];
        for (size_t k = i + 1; k < PANEL; k++) {
            sum[k] += u[i * PANEL + k] * x[left + i];
        }
    }
}

/* u y = z, from below: y of panel j, and what it takes from the rows above. */
static void solve_up(const ad_dense_factor *f, size_t j, double *x)
{
    enum { PARTS = 8 }; /* sums that do not wait for each other */
    size_t left = j * PANEL, width = f->n - left < PANEL ? f->n - left : PANEL;
    double found[PANEL] = {0};
    const double *u = tile(f, j, j);
    for (size_t i = width; i-- > 0;) {
        double sum = x[left + i];
        for (size_t k = i + 1; k < width; k++) {
            sum -= u[i * PANEL + k] * found[k];
        }
        x[left + i] = found[i] = sum / u[i * PANEL + i];
    }
    u = tile(f, 0, j);
    for (size_t k = 0; k < left; k++) {
        double part[PARTS] = {0};
        for (size_t i = 0; i < PANEL; i += PARTS) {
            for (size_t p = 0; p < PARTS; p++) {
                part[p] += u[k * PANEL + i + p] * found[i + p];
            }
        }
        x[k] -= ((part[0] + part[1]) + (part[2] + part[3])) +
                ((part[4] + part[5]) + (part[6] + part[7]));
    }
}

void ad_dense_cholesky_solve(const ad_dense_factor *factor, double *x)
{
    for (size_t j = 0; j < factor->panels; j++) {
        solve_down(factor, j, x);
    }
    for (size_t j = factor->panels; j-- > 0;) {
        solve_up(factor, j, x);
    }
}

int ad_dense_damped_step(ad_pool *pool, const double *matrix, const double *gradient,
                         double damping, const double *scale, size_t n, ad_dense_factor *factor,
                         double *step)
{
    for (size_t i = 0; i < n; i++) {
        step[i] = damping * scale[i];
    }
    if (ad_dense_cholesky(pool, matrix, step, factor) != 0) {
        return 1;
    }
    for (size_t i = 0; i < n; i++) {
        step[i] = -gradient[i];
    }
    ad_dense_cholesky_solve(factor, step);
    return 0;
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
void ad_dense_triangle(size_t rows, size_t n, double *a, size_t stride, double *work)
{
    const int height = (int)rows, width = (int)n, step = (int)stride;
    const int space = (int)(AD_DENSE_TRIANGLE_WORK(n) - n);
    int info = 0;
    if (rows > 0) {
        ad_blas_load(NULL)->geqrf(&height, &width, a, &step, work, work + n, &space, &info);
    }
    for (size_t j = 0; j < n && j + 1 < rows; j++) {
        memset(a + j * stride + j + 1, 0, (rows - j - 1) * sizeof *a);
    }
}

void ad_dense_triangle_add(size_t n, size_t rows, size_t columns, double *r, size_t r_stride,
                           double *b, size_t b_stride, double *work)
{
    const blas *blas = ad_blas_load(NULL);
    const int width = (int)n, height = (int)rows, more = (int)(columns - n), full = 0;
    const int step_r = (int)r_stride, step_b = (int)b_stride, block = width < 32 ? width : 32;
    double *factors = work, *space = work + 32 * n;
    int info = 0;
    if (rows == 0 || n == 0) {
        return;
    }
    blas->tpqrt(&height, &width, &full, &block, r, &step_r, b, &step_b, factors, &block, space,
                &info);
    if (more > 0) {
        blas->tpmqrt("L", "T", &height, &more, &width, &full, &block, b, &step_b, factors, &block,
                     r + n * r_stride, &step_r, b + n * b_stride, &step_b, space, &info);
    }
}

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

int ad_dense_eigenvalues(size_t n, double *matrix, double *real, double *imaginary, double *work)
{
    int size = (int)n, room = (int)AD_DENSE_EIGEN_WORK(n), one = 1, info = 0;
    double unused;
    ad_blas_load(NULL)->geev("N", "N", &size, matrix, &size, real, imaginary, &unused, &one,
                             &unused, &one, work, &room, &info);
    return info;
}

/* ---- Jacobi's method ------------------------------------------------------------------------- */

/* a[p][q] vanishes. */
static void rotate(size_t n, double *a, double *v, size_t p, size_t q)
{
    const double tau = (a[q * n + q] - a[p * n + p]) / (2 * a[p * n + q]);
    const double t = (tau >= 0 ? 1 : -1) / (fabs(tau) + hypot(1, tau));
    const double c = 1 / hypot(1, t), s = t * c;
    for (size_t k = 0; k < n; k++) {
        const double x = a[k * n + p], y = a[k * n + q];
        a[k * n + p] = c * x - s * y;
        a[k * n + q] = s * x + c * y;
    }
    double *const rows[2][2] = {{a + p * n, a + q * n}, {v + p * n, v + q * n}};
    for (size_t i = 0; i < 2; i++) {
        for (size_t k = 0; k < n; k++) {
            const double x = rows[i][0][k], y = rows[i][1][k];
            rows[i][0][k] = c * x - s * y;
            rows[i][1][k] = s * x + c * y;
        }
    }
}

void ad_dense_diagonalize(size_t n, double *a, double *v)
{
    enum { SWEEPS = 60 };
    bool rotated = true;
    for (size_t i = 0; i < n * n; i++) {
        v[i] = i % (n + 1) == 0;
    }
    for (int sweep = 0; rotated && sweep < SWEEPS; sweep++) {
        rotated = false;
        for (size_t p = 0; p < n; p++) {
            for (size_t q = p + 1; q < n; q++) {
                const double size = sqrt(fabs(a[p * n + p] * a[q * n + q]));
                if (fabs(a[p * n + q]) > DBL_EPSILON * size) {
                    rotate(n, a, v, p, q);
                    rotated = true;
                }
            }
        }
    }
}
