/* Linear systems by products alone, with a matrix whose eigenvalues and eigenvectors are known. */
#include "allocations.h"
#include "near.h"
#include "optim/optim.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { COUNT = 150, RANK = 20, LEADING = 12 };

/* H diag(lambda) H, H = I - 2 h h^T. Stops at a product if it is told to. */
typedef struct matrix {
    double lambda[COUNT], h[COUNT];
    int products, stop_at;
} matrix;

/* LEADING eigenvalues 10^6, 10^5.5, ..., the others `rest` and falling. */
static matrix make_matrix(double rest)
{
    matrix m = {.products = 0};
    double sum = 0;
    for (int i = 0; i < COUNT; i++) {
        m.lambda[i] = i < LEADING ? pow(10, 6 - 0.5 * i) : rest / (i - LEADING + 1);
        m.h[i] = sin(1 + 0.7 * i);
        sum += m.h[i] * m.h[i];
    }
    for (int i = 0; i < COUNT; i++) {
        m.h[i] /= sqrt(sum);
    }
    return m;
}

static void reflect(const matrix *m, const double *x, double *y)
{
    double sum = 0;
    for (int i = 0; i < COUNT; i++) {
        sum += m->h[i] * x[i];
    }
    for (int i = 0; i < COUNT; i++) {
        y[i] = x[i] - 2 * sum * m->h[i];
    }
}

static int product(void *context, const double *x, double *y)
{
    matrix *m = context;
    double middle[COUNT];
    if (++m->products == m->stop_at) {
        return 7;
    }
    reflect(m, x, middle);
    for (int i = 0; i < COUNT; i++) {
        middle[i] *= m->lambda[i];
    }
    reflect(m, middle, y);
    return 0;
}

static const double *random_numbers(void)
{
    static double numbers[RANK * COUNT];
    uint64_t state = 1;
    for (int i = 0; i < RANK * COUNT; i++) {
        numbers[i] = 0;
        for (int k = 0; k < 4; k++) { /* near enough to normal */
            state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
            numbers[i] += (double)(state >> 11) * 0x1p-53 - 0.5;
        }
    }
    return numbers;
}

static void test_low_rank(void **state)
{
    (void)state;
    matrix m = make_matrix(0);
    optim_nystrom *n = optim_nystrom_create(COUNT, RANK, random_numbers());
    double diagonal[COUNT], unit[COUNT] = {0}, image[COUNT];
    assert_int_equal(optim_nystrom_update(n, product, &m), 0);
    assert_int_equal(m.products, RANK);
    const double *lambda = optim_nystrom_eigenvalues(n);
    for (int i = 0; i < RANK; i++) {
        /* of a matrix of this rank it is exact, to rounding beside the largest */
        assert_near(lambda[i], m.lambda[i], 1e-8 * m.lambda[0]);
        assert_true(lambda[i] >= 0 && (i == 0 || lambda[i] <= lambda[i - 1]));
    }
    optim_nystrom_diagonal(n, diagonal);
    for (int i = 0; i < COUNT; i++) {
        unit[i] = 1;
        product(&m, unit, image);
        assert_near(diagonal[i], image[i], 1e-8 * m.lambda[0]);
        unit[i] = 0;
    }
    optim_nystrom_free(n);
}

static void test_solve(void **state)
{
    (void)state;
    const double rests[] = {0, 1};
    for (int i = 0; i < 2; i++) {
        matrix m = make_matrix(rests[i]);
        double b[COUNT], x[COUNT], image[COUNT];
        optim_nystrom *n = optim_nystrom_create(COUNT, RANK, random_numbers());
        optim_cg *cg = optim_cg_create(COUNT);
        for (int k = 0; k < COUNT; k++) {
            b[k] = cos(0.3 * k);
        }
        assert_int_equal(optim_nystrom_update(n, product, &m), 0);
        m.products = 0;
        const long before = allocations;
        optim_cg_result found = optim_cg_solve(cg, product, &m, 0.01, n, b, 1e-10, 100, x);
        assert_int_equal(allocations, before);
        assert_int_equal(found.code, 0);
        assert_int_equal(found.iterations, m.products);
        assert_true(found.residual <= 1e-10);
        /* the matrix is that of the preconditioner, or some eigenvalues below 1.01 are left;
         * without it the condition is 1e8 */
        assert_true(found.iterations <= (i == 0 ? 3 : 60));
        product(&m, x, image);
        for (int k = 0; k < COUNT; k++) {
            assert_near(image[k] + 0.01 * x[k], b[k], 1e-5);
        }
        optim_nystrom_free(n);
        optim_cg_free(cg);
    }
}

static void test_ends(void **state)
{
    (void)state;
    matrix m = make_matrix(1);
    double b[COUNT] = {1}, x[COUNT];
    optim_nystrom *n = optim_nystrom_create(COUNT, RANK, random_numbers());
    optim_cg *cg = optim_cg_create(COUNT);
    m.stop_at = 5;
    assert_int_equal(optim_nystrom_update(n, product, &m), 7);
    assert_int_equal(optim_nystrom_update(n, product, &m), 0);
    m.products = 0;
    m.stop_at = 3;
    optim_cg_result found = optim_cg_solve(cg, product, &m, 1e-6, n, b, 0, 100, x);
    assert_int_equal(found.code, 7);
    assert_int_equal(found.iterations, 2);
    m.stop_at = 0;
    found = optim_cg_solve(cg, product, &m, 1e-6, n, b, 0, 4, x);
    assert_int_equal(found.iterations, 4);
    b[0] = 0; /* nothing to do */
    found = optim_cg_solve(cg, product, &m, 1e-6, n, b, 1e-3, 100, x);
    assert_int_equal(found.iterations, 0);
    assert_true(x[0] == 0 && found.residual == 0);
    memset(m.lambda, 0, sizeof m.lambda); /* nothing but the damping */
    b[0] = 1;
    assert_int_equal(optim_nystrom_update(n, product, &m), 0);
    found = optim_cg_solve(cg, product, &m, 0.5, n, b, 1e-12, 100, x);
    assert_near(x[0], 2, 1e-14);
    optim_nystrom_free(n);
    optim_cg_free(cg);
}

static void test_allocations(void **state)
{
    (void)state;
    optim_nystrom *n = NULL;
    optim_cg *cg = NULL;
    const double *numbers = random_numbers();
    for (long k = 1; !n; k++) {
        assert_true(k < 20);
        allocations = 0;
        failing_allocation = k;
        n = optim_nystrom_create(COUNT, RANK, numbers);
        failing_allocation = 0;
    }
    for (long k = 1; !cg; k++) {
        assert_true(k < 20);
        allocations = 0;
        failing_allocation = k;
        cg = optim_cg_create(COUNT);
        failing_allocation = 0;
    }
    optim_nystrom_free(n);
    optim_cg_free(cg);
    optim_nystrom_free(NULL);
    optim_cg_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_low_rank),
        cmocka_unit_test(test_solve),
        cmocka_unit_test(test_ends),
        cmocka_unit_test(test_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
