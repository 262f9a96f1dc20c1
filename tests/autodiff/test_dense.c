/* Products and factors of dense matrices: against plain loops, bits for any number of threads. */
#include "autodiff/dense.h"

#include "ad_testing.h"

enum { ROWS = 700, ORDER = 611 }; /* several tiles, none of them full */

static double *random_matrix(size_t count)
{
    uint64_t seed = 17;
    double *a = new_numbers(count);
    for (size_t i = 0; i < count; i++) {
        a[i] = random_in(&seed, -1, 1);
    }
    return a;
}

/* The lower triangle is marked: nothing may touch it. */
static double *gram_of(const double *a, size_t rows, size_t n, int threads)
{
    ad_pool *pool = ad_pool_create(threads);
    double *c = new_numbers(n * n);
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < i; j++) {
            c[i * n + j] = -7;
        }
    }
    ad_dense_gram(pool, rows, n, a, c);
    ad_pool_free(pool);
    return c;
}

static void test_gram(void **state)
{
    (void)state;
    double *a = random_matrix((size_t)ROWS * ORDER);
    double *one = gram_of(a, ROWS, ORDER, 1), *three = gram_of(a, ROWS, ORDER, 3);
    assert_memory_equal(one, three, (size_t)ORDER * ORDER * sizeof *one);
    for (size_t i = 0; i < ORDER; i += 13) {
        for (size_t j = 0; j < ORDER; j++) {
            double sum = 0;
            for (size_t k = 0; k < ROWS; k++) {
                sum += a[k * ORDER + i] * a[k * ORDER + j];
            }
            /* two orders of summing 700 products below 1 */
            assert_near(one[i * ORDER + j], j < i ? -7 : sum, 1e-11);
        }
    }
    free(a);
    free(one);
    free(three);
}

/* Solutions of equations whose right side was made from a known one, for orders of one panel, of
 * whole ones, of several bands; the shift makes up for what the diagonal lacks. */
static void test_cholesky(void **state)
{
    (void)state;
    const size_t orders[] = {1, 5, 24, 120, ORDER};
    for (int o = 0; o < 5; o++) {
        size_t n = orders[o];
        double *a = random_matrix(ROWS * n), *right = new_numbers(n), *shift = new_numbers(n);
        double *matrix = gram_of(a, ROWS, n, 1), *solutions[2] = {NULL, NULL};
        for (size_t i = 0; i < n; i++) {
            for (size_t j = 0; j < n; j++) {
                right[i] += (j < i ? matrix[j * n + i] : matrix[i * n + j]) * sin((double)j);
            }
            shift[i] = 1 + (double)i;
            matrix[i * n + i] -= shift[i];
        }
        for (int t = 0; t < 2; t++) {
            ad_pool *pool = ad_pool_create(1 + 2 * t);
            ad_dense_factor *factor = ad_dense_factor_create(n);
            solutions[t] = new_numbers(n);
            memcpy(solutions[t], right, n * sizeof *right);
            assert_int_equal(ad_dense_cholesky(pool, matrix, shift, factor), 0);
            ad_dense_cholesky_solve(factor, solutions[t]);
            ad_dense_factor_free(factor);
            ad_pool_free(pool);
        }
        assert_memory_equal(solutions[0], solutions[1], n * sizeof(double));
        for (size_t i = 0; i < n; i++) {
            /* the condition of 700 by 611 random numbers squared, below 1e4, times rounding */
            assert_near(solutions[0][i], sin((double)i), 1e-10);
        }
        free(a);
        free(right);
        free(shift);
        free(matrix);
        free(solutions[0]);
        free(solutions[1]);
    }
}

/* Whatever tile the trouble is in, it is told, not stepped over. */
static void test_no_factor(void **state)
{
    (void)state;
    ad_pool *pool = ad_pool_create(2);
    const size_t at[] = {0, 250, ORDER - 1};
    const double bad[] = {-1, 0, (double)NAN};
    double *matrix = new_numbers((size_t)ORDER * ORDER);
    ad_dense_factor *factor = ad_dense_factor_create(ORDER);
    for (int k = 0; k < 3; k++) {
        for (int b = 0; b < 3; b++) {
            memset(matrix, 0, (size_t)ORDER * ORDER * sizeof *matrix);
            for (size_t i = 0; i < ORDER; i++) {
                matrix[i * ORDER + i] = i == at[k] ? bad[b] : 2;
            }
            assert_int_not_equal(ad_dense_cholesky(pool, matrix, NULL, factor), 0);
        }
    }
    ad_dense_factor_free(factor);
    free(matrix);
    ad_pool_free(pool);
}

/* A matrix with small pivots on its diagonal, and two right sides made from known solutions. */
static void test_lu(void **state)
{
    (void)state;
    enum { N = 60 };
    double *matrix = random_matrix(N * N), right[2 * N] = {0};
    int pivots[N];
    for (int i = 0; i < N; i++) {
        matrix[i * (N + 1)] *= 1e-12;
    }
    for (int k = 0; k < 2; k++) {
        for (int j = 0; j < N; j++) {
            for (int i = 0; i < N; i++) { /* column-major */
                right[k * N + i] += matrix[j * N + i] * sin(j + 7.0 * k);
            }
        }
    }
    assert_int_equal(ad_dense_lu(N, matrix, pivots), 0);
    ad_dense_lu_solve(N, 2, matrix, pivots, right);
    for (int i = 0; i < 2 * N; i++) {
        /* the condition of 60 by 60 random numbers, some 1e3, times rounding */
        assert_near(right[i], sin(i % N + 7.0 * (i / N)), 1e-11);
    }
    memset(matrix, 0, N * N * sizeof *matrix);
    assert_int_not_equal(ad_dense_lu(N, matrix, pivots), 0);
    matrix[3] = (double)NAN;
    assert_int_not_equal(ad_dense_lu(N, matrix, pivots), 0);
    free(matrix);
}

/* Powers of x at the nodes of a midpoint rule, 1 first, and twice each: as many combinations as
 * powers, the first of them 1, orthonormal to rounding times 1 / least. */
static void test_basis(void **state)
{
    (void)state;
    enum { POWERS = 6, N = 2 * POWERS, ROWS = 50 };
    double a[N * ROWS], kept[N * ROWS], c[N * N], work[AD_DENSE_BASIS_WORK(N)];
    int order[N];
    for (int i = 0; i < N * ROWS; i++) {
        kept[i] = a[i] = pow((i % ROWS + 0.5) / ROWS, i / ROWS % POWERS) / sqrt(ROWS);
    }
    assert_int_equal(ad_dense_basis(ROWS, N, a, 1e-10, c, order, work), POWERS);
    double q[POWERS][ROWS] = {{0}};
    for (int k = 0; k < POWERS * N; k++) {
        for (int r = 0; r < ROWS; r++) {
            q[k / N][r] += c[k] * kept[k % N * ROWS + r];
        }
    }
    for (int i = 0; i < POWERS; i++) {
        for (int j = 0; j < POWERS; j++) {
            double product = 0;
            for (int r = 0; r < ROWS; r++) {
                product += q[i][r] * q[j][r];
            }
            assert_near(product, i == j, 1e-11); /* coefficients are up to 1e5 */
        }
    }
    for (int j = 0; j < N; j++) {
        assert_near(fabs(c[j]), j == 0, 1e-14);
    }
}

/* S^T D S has as many negative eigenvalues as D (Sylvester). Zeros on the diagonal need pivots of
 * two. */
static void test_inertia(void **state)
{
    (void)state;
    enum { N = 40 };
    double *s = random_matrix(N * N), matrix[N * N] = {0};
    int pivots[N];
    for (int negative = 0; negative <= N; negative += 8) {
        memset(matrix, 0, sizeof matrix);
        for (int k = 0; k < N; k++) {
            for (int i = 0; i < N * N; i++) {
                matrix[i] += (k < negative ? -1 : 1) * s[k * N + i / N] * s[k * N + i % N];
            }
        }
        assert_int_equal(ad_dense_negative(N, matrix, pivots), negative);
    }
    memset(matrix, 0, sizeof matrix);
    for (int i = 0; i < N; i++) { /* eigenvalues 1 and -1, N/2 times each */
        matrix[i * N + (i ^ 1)] = 1;
    }
    assert_int_equal(ad_dense_negative(N, matrix, pivots), N / 2);
    free(s);
}

/* Sums of products of columns are those of all rows, however they became a triangle. */
static void test_triangle(void **state)
{
    (void)state;
    enum { N = 40, MORE = 3, WIDE = N + MORE, FIRST = 70, SECOND = 33 };
    double *a = random_matrix(WIDE * FIRST), *b = random_matrix(WIDE * SECOND);
    double gram[WIDE * WIDE] = {0}, *work = new_numbers(AD_DENSE_TRIANGLE_WORK(WIDE));
    for (int i = 0; i < WIDE; i++) {
        for (int j = 0; j < WIDE; j++) {
            for (int k = 0; k < FIRST; k++) {
                gram[i * WIDE + j] += a[i * FIRST + k] * a[j * FIRST + k];
            }
            for (int k = 0; k < SECOND; k++) {
                gram[i * WIDE + j] += b[i * SECOND + k] * b[j * SECOND + k];
            }
        }
    }
    ad_dense_triangle(FIRST, WIDE, a, FIRST, work);
    for (int j = 0; j < WIDE; j++) {
        for (int i = j + 1; i < FIRST; i++) {
            assert_true(a[j * FIRST + i] == 0);
        }
    }
    /* the first N columns alone: what is right of them goes along, in both */
    ad_dense_triangle_add(N, SECOND, WIDE, a, FIRST, b, SECOND, work);
    for (int i = 0; i < WIDE; i++) {
        for (int j = 0; j < WIDE; j++) {
            double sum = 0;
            for (int k = 0; k <= (i < j ? i : j); k++) {
                sum += a[i * FIRST + k] * a[j * FIRST + k];
            }
            for (int k = 0; k < SECOND && i >= N && j >= N; k++) {
                sum += b[i * SECOND + k] * b[j * SECOND + k];
            }
            assert_near(sum, gram[i * WIDE + j], 1e-12); /* sums of some 100 products */
        }
    }
    free(a);
    free(b);
    free(work);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gram),      cmocka_unit_test(test_basis),
        cmocka_unit_test(test_inertia),   cmocka_unit_test(test_cholesky),
        cmocka_unit_test(test_no_factor), cmocka_unit_test(test_lu),
        cmocka_unit_test(test_triangle),
    };
    ad_error error;
    if (ad_dense_load(&error) != AD_OK) {
        return 1;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
