/* Small matrices against their definitions. Numbers are of size 1 and sums of at most 60 products:
 * rounding is below 1e-13 where conditions are a few hundred. */
#include "near.h"
#include "random_numbers.h"

#include "tools/control/small_matrix.h"

#include <string.h>

enum { MOST = 40, STRIDE = 40, ROWS = 60 };

static void fill(uint64_t *seed, int rows, int n, double *a)
{
    memset(a, 0, (size_t)(rows * small_matrix_stride(n)) * sizeof *a);
    for (int i = 0; i < rows * n; i++) {
        a[i / n * small_matrix_stride(n) + i % n] = random_in(seed, -1, 1);
    }
}

/* a^T b of columns i, k. */
static double gram(int rows, int stride, const double *a, int i, int k)
{
    double sum = 0;
    for (int r = 0; r < rows; r++) {
        sum += a[r * stride + i] * a[r * stride + k];
    }
    return sum;
}

static void test_products(void **state)
{
    static double a[ROWS * STRIDE], b[ROWS * STRIDE], c[ROWS * STRIDE];
    uint64_t seed = 1;
    (void)state;
    for (int n = 1; n <= MOST; n += 6) {
        const int m = n / 2 + 1, k = n / 3 + 2, inner = small_matrix_stride(k),
                  stride = small_matrix_stride(n);
        fill(&seed, m, k, a);
        fill(&seed, ROWS, n, b);
        small_matrix_product(m, k, n, a, b, c);
        for (int i = 0; i < m * n; i++) {
            double sum = 0;
            for (int j = 0; j < k; j++) {
                sum += a[i / n * inner + j] * b[j * stride + i % n];
            }
            assert_near(c[i / n * stride + i % n], sum, 1e-13);
        }
        small_matrix_product_transposed(m, k, n, a, b, c);
        for (int i = 0; i < k * n; i++) {
            double sum = 0;
            for (int j = 0; j < m; j++) {
                sum += a[j * inner + i / n] * b[j * stride + i % n];
            }
            assert_near(c[i / n * stride + i % n], sum, 1e-13);
        }
    }
}

static void test_triangle(void **state)
{
    static double a[ROWS * STRIDE], r[ROWS * STRIDE];
    uint64_t seed = 2;
    (void)state;
    for (int n = 1; n <= MOST; n++) {
        const int stride = small_matrix_stride(n), rows = n + (int)(random_bits(&seed) % 20);
        fill(&seed, rows, n, a);
        if (n > 3) { /* columns that are 0 or depend on others leave a triangle all the same */
            for (int i = 0; i < rows; i++) {
                a[i * stride + 1] = 0;
                a[i * stride + 3] = 2 * a[i * stride];
            }
        }
        memcpy(r, a, sizeof r);
        small_matrix_triangle(rows, n, r);
        for (int i = 0; i < n; i++) {
            assert_true(r[i * stride + i] >= 0);
            for (int k = 0; k < stride; k++) {
                if (k < i || k >= n) {
                    assert_true(r[i * stride + k] == 0);
                } else {
                    assert_near(gram(n, stride, r, i, k), gram(rows, stride, a, i, k), 1e-13);
                }
            }
        }
    }
}

/* A = B^T B of 60 rows: conditions below a few hundred. */
static void test_cholesky_and_solutions(void **state)
{
    static double b[ROWS * STRIDE], u[STRIDE * STRIDE], right[STRIDE * 8], x[STRIDE];
    uint64_t seed = 3;
    (void)state;
    for (int n = 1; n <= MOST; n++) {
        const int stride = small_matrix_stride(n);
        double at[MOST];
        fill(&seed, ROWS, n, b);
        for (int i = 0; i < n * stride; i++) {
            u[i] = i % stride < n ? gram(ROWS, stride, b, i / stride, i % stride) : 0;
        }
        assert_int_equal(small_matrix_cholesky(n, u), 0);
        for (int i = 0; i < n; i++) {
            for (int k = 0; k < n; k++) {
                assert_near(gram(n, stride, u, i, k), gram(ROWS, stride, b, i, k), 1e-12);
            }
            at[i] = random_in(&seed, -1, 1);
        }
        for (int i = 0; i < n; i++) { /* U^T at, and A at in columns 0 and 2 */
            x[i] = 0;
            memset(right + 8 * i, 0, 8 * sizeof *right);
            for (int k = 0; k < n; k++) {
                x[i] += u[k * stride + i] * at[k];
                right[8 * i] += gram(ROWS, stride, b, i, k) * at[k];
            }
            right[8 * i + 2] = -right[8 * i];
        }
        small_matrix_solve_factored(n, u, 3, right);
        for (int i = 0; i < n; i++) {
            assert_near(right[8 * i], at[i], 1e-11);
            assert_near(right[8 * i + 2], -at[i], 1e-11);
        }
        small_matrix_solve_transposed(n, u, x);
        for (int i = 0; i < n; i++) {
            assert_near(x[i], at[i], 1e-12);
        }
    }
    memset(u, 0, sizeof u);
    u[0] = 4;
    u[1] = 2;
    u[8 + 1] = 1; /* a pivot of 0 */
    assert_int_equal(small_matrix_cholesky(2, u), 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_products),
                                       cmocka_unit_test(test_triangle),
                                       cmocka_unit_test(test_cholesky_and_solutions)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
