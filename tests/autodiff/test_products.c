/* Products of a tile, by every instruction set of this processor, against plain loops. */
#include "ad_testing.h"
#include "kernel_sets.h"

#include <float.h>

/* Rows, columns, inner dimension: below, at and above the blocks, strips and parts of products.c.
 */
static const int shapes[][3] = {{1, 8, 1},     {7, 24, 64},   {8, 40, 2},    {9, 64, 7},
                                {64, 240, 64}, {64, 320, 64}, {17, 120, 33}, {33, 8, 300},
                                {3, 16, 120},  {5, 32, 121},  {13, 48, 241}};
enum { SHAPES = sizeof shapes / sizeof *shapes, GAP = 8 };

/* Numbers aligned as rows of a tile are. */
static double *new_rows(size_t rows, size_t stride, int count, uint64_t *seed)
{
    void *memory = NULL;
    assert_int_equal(posix_memalign(&memory, 64, (rows * stride + GAP) * sizeof(double)), 0);
    double *a = memory;
    for (size_t i = 0; i < rows * stride; i++) {
        a[i] = (int)(i % stride) < count ? random_in(seed, -1, 1) : NAN; /* nothing reads a gap */
    }
    return a;
}

/* Two orders of summing k products below 1, and one number of at most 1 more. */
static double rounding(int k)
{
    return 2 * (k + 2) * (k + 1) * DBL_EPSILON;
}

static void check_multiply(const product_set *products, const int *shape, bool turned, bool add)
{
    const int m = shape[0], n = shape[1], k = shape[2], stride = n + GAP;
    uint64_t seed = 5;
    double *a = new_rows((size_t)m, (size_t)k, k, &seed);
    double *b = new_rows((size_t)k, (size_t)stride, n, &seed);
    double *c = new_rows((size_t)m, (size_t)stride, n, &seed);
    double *before = new_numbers((size_t)m * (size_t)stride);
    memcpy(before, c, (size_t)m * (size_t)stride * sizeof *c);
    const int row = turned ? 1 : k, column = turned ? m : 1;
    products->multiply(m, n, k, a, row, column, b, stride, c, stride, add);
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < n; j++) {
            double sum = add ? before[i * stride + j] : 0;
            for (int l = 0; l < k; l++) {
                sum += a[i * row + l * column] * b[l * stride + j];
            }
            assert_near(c[i * stride + j], sum, rounding(k));
        }
        for (int j = n; j < stride; j++) {
            assert_true(isnan(c[i * stride + j]));
        }
    }
    free(a);
    free(b);
    free(c);
    free(before);
}

static void test_multiply(void **state)
{
    (void)state;
    const kernel_set *sets[KERNEL_SETS_MAX];
    for (int count = kernel_sets(sets), s = 0; s < count; s++) {
        for (int i = 0; i < 4 * SHAPES; i++) {
            check_multiply(sets[s]->products, shapes[i / 4], i & 1, i & 2);
        }
    }
}

/* The bits of a number depend on its row and column alone: a tile may be computed in pieces. */
static void test_pieces(void **state)
{
    (void)state;
    enum { M = 21, N = 88, K = 130 };
    const kernel_set *sets[KERNEL_SETS_MAX];
    uint64_t seed = 9;
    double *a = new_rows(M, K, K, &seed), *b = new_rows(K, N, N, &seed);
    double *whole = new_rows(M, N, N, &seed), *part = new_rows(M, N, N, &seed);
    for (int count = kernel_sets(sets), s = 0; s < count; s++) {
        const product_set *products = sets[s]->products;
        products->multiply(M, N, K, a, K, 1, b, N, whole, N, false);
        for (int width = 8; width < N; width += 16) {
            products->multiply(5, width, K, a, K, 1, b, N, part, N, false);
            products->multiply(5, N - width, K, a, K, 1, b + width, N, part + width, N, false);
            products->multiply(M - 5, N, K, a + 5 * K, K, 1, b, N, part + 5 * N, N, false);
            assert_memory_equal(whole, part, M * N * sizeof *whole);
        }
    }
    free(a);
    free(b);
    free(whole);
    free(part);
}

static void check_outer_sum(const product_set *products, const int *shape, int points)
{
    const int m = shape[0], k = shape[2], stride = (points + 7) / 8 * 8;
    uint64_t seed = 7;
    double *y = new_rows((size_t)m, (size_t)stride, points, &seed);
    double *x = new_rows((size_t)k, (size_t)stride, points, &seed);
    double *sum = new_numbers((size_t)m * (size_t)k + 1);
    for (int i = 0; i <= m * k; i++) {
        sum[i] = 0.5;
    }
    products->add_outer_sum(m, k, points, y, stride, x, stride, sum);
    for (int i = 0; i < m * k; i++) {
        double expected = 0.5;
        for (int j = 0; j < points; j++) {
            expected += y[i / k * stride + j] * x[i % k * stride + j];
        }
        assert_near(sum[i], expected, rounding(points));
    }
    assert_true(sum[m * k] == 0.5);
    free(y);
    free(x);
    free(sum);
}

static void test_outer_sum(void **state)
{
    (void)state;
    const kernel_set *sets[KERNEL_SETS_MAX];
    for (int count = kernel_sets(sets), s = 0; s < count; s++) {
        for (int i = 0; i < SHAPES; i++) {
            check_outer_sum(sets[s]->products, shapes[i], shapes[i][1]);
            check_outer_sum(sets[s]->products, shapes[i], shapes[i][1] - 3); /* a last tile */
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_multiply),
        cmocka_unit_test(test_pieces),
        cmocka_unit_test(test_outer_sum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
