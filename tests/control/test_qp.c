/* Quadratic programs: random ones against the conditions of optimality, which are necessary and
 * sufficient; one against another program; degenerate, impossible, interrupted and bad ones. */
#include "near.h"
#include "random_numbers.h"
#include "tools/control/qp.h"
#include "tools/control/small_matrix.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 40, WIDE = 40, ROWS = 60 };

typedef struct program {
    int n, m, stride;
    double H[MOST * WIDE], g[MOST], A[ROWS * WIDE];
    double lower[MOST], upper[MOST], row_lower[ROWS], row_upper[ROWS], softness[ROWS];
    double inside[MOST], x[MOST];
    qp_bounds bounds;
    qp *qp;
} program;

static double drawn(uint64_t *seed)
{
    return random_in(seed, -1.0, 1.0);
}

static program *make(int n, int m, int limit)
{
    const qp_settings settings = {.variables = n, .rows = m, .iterations = limit};
    program *p = calloc(1, sizeof *p);

    p->n = n;
    p->m = m;
    p->stride = small_matrix_stride(n);
    p->bounds = (qp_bounds){.lower = p->lower,
                            .upper = p->upper,
                            .A = p->A,
                            .row_lower = p->row_lower,
                            .row_upper = p->row_upper,
                            .softness = p->softness};
    p->qp = qp_init(malloc(qp_size(&settings)), &settings);
    for (int i = 0; i < n; i++) {
        p->lower[i] = -INFINITY;
        p->upper[i] = INFINITY;
    }
    return p;
}

static void discard(program *p)
{
    free(p->qp);
    free(p);
}

/* H of B'B with a smallest eigenvalue of at least 0.01. */
static void random_hessian(program *p, uint64_t *seed)
{
    double b[MOST * MOST];

    for (int i = 0; i < p->n * p->n; i++) {
        b[i] = drawn(seed);
    }
    for (int i = 0; i < p->n; i++) {
        for (int j = 0; j < p->n; j++) {
            double sum = i == j ? 0.01 : 0.0;

            for (int k = 0; k < p->n; k++) {
                sum += b[k * p->n + i] * b[k * p->n + j];
            }
            p->H[i * p->stride + j] = sum;
        }
    }
}

/* Bounds around a point that is allowed; a third of the rows are soft and need not be met there,
 * some are equations, some are those before them again. */
static void random_bounds(program *p, uint64_t *seed)
{
    for (int i = 0; i < p->n; i++) {
        p->inside[i] = 0.3 * drawn(seed);
        p->lower[i] =
            drawn(seed) > 0.6 ? -INFINITY : p->inside[i] - 0.5 * random_in(seed, 0.0, 1.0);
        p->upper[i] = p->inside[i] + 0.5 * random_in(seed, 0.0, 1.0);
    }
    for (int r = 0; r < p->m; r++) {
        double *row = p->A + r * p->stride;
        double at = 0.0;
        const double kind = random_in(seed, 0.0, 1.0);

        for (int j = 0; j < p->n; j++) {
            row[j] = r > 0 && kind < 0.15 ? row[j - p->stride] : drawn(seed);
            at += row[j] * p->inside[j];
        }
        p->row_lower[r] = at - random_in(seed, 0.0, 1.0);
        p->row_upper[r] = kind > 0.9 ? INFINITY : at + 0.3 * random_in(seed, 0.0, 1.0);
        p->softness[r] = kind > 0.3 && kind < 0.6 ? 0.1 * random_in(seed, 0.0, 1.0) : 0.0;
        if (p->softness[r] > 0.0) {
            p->row_lower[r] -= 0.5;
            p->row_upper[r] -= 0.5;
        } else if (kind < 0.1) {
            p->row_lower[r] = p->row_upper[r] = at;
        }
    }
}

/* How far value is beyond its bounds, or with a multiplier from the one it belongs to. */
static double off_bounds(double value, double lower, double upper, double multiplier)
{
    const double beyond = fmax(fmax(lower - value, value - upper), 0.0);

    if (multiplier != 0.0) {
        return fabs(value - (multiplier > 0.0 ? upper : lower));
    }
    return beyond;
}

/* The largest violation of the conditions of Karush, Kuhn and Tucker, by their sizes. */
static double off_optimum(const program *p)
{
    const double *multiplier = qp_multipliers(p->qp);
    double size = 1.0;
    double worst = 0.0;

    for (int i = 0; i < p->n + p->m; i++) {
        size = fmax(size, fabs(multiplier[i]));
    }
    for (int i = 0; i < p->n; i++) {
        double gradient = p->g[i] + multiplier[i];

        for (int j = 0; j < p->n; j++) {
            gradient += p->H[i * p->stride + j] * p->x[j];
        }
        for (int r = 0; r < p->m; r++) {
            gradient += p->A[r * p->stride + i] * multiplier[p->n + r];
        }
        worst = fmax(worst, fabs(gradient) / size);
        worst = fmax(worst, off_bounds(p->x[i], p->lower[i], p->upper[i], multiplier[i]));
    }
    for (int r = 0; r < p->m; r++) {
        double value = -p->softness[r] * multiplier[p->n + r];

        for (int j = 0; j < p->n; j++) {
            value += p->A[r * p->stride + j] * p->x[j];
        }
        worst =
            fmax(worst, off_bounds(value, p->row_lower[r], p->row_upper[r], multiplier[p->n + r]));
    }
    return worst;
}

static double cost(const program *p, const double *x)
{
    double sum = 0.0;

    for (int i = 0; i < p->n; i++) {
        sum += p->g[i] * x[i];
        for (int j = 0; j < p->n; j++) {
            sum += 0.5 * x[i] * p->H[i * p->stride + j] * x[j];
        }
    }
    for (int r = 0; r < p->m; r++) {
        double value = 0.0;

        for (int j = 0; j < p->n; j++) {
            value += p->A[r * p->stride + j] * x[j];
        }
        value = fmax(fmax(p->row_lower[r] - value, value - p->row_upper[r]), 0.0);
        sum += p->softness[r] > 0.0 ? 0.5 * value * value / p->softness[r] : 0.0;
    }
    return sum;
}

/* Each program three times, with other gradients: bounds are met to the 1e-10 that is asked for,
 * the rest is rounding, 1e-16 by a condition of up to 1e5. */
static void test_optimal(void **state)
{
    uint64_t seed = 1;

    (void)state;
    for (int i = 0; i < 400; i++) {
        const int n = 1 + random_below(&seed, MOST);
        program *p = make(n, random_below(&seed, ROWS), 0);

        random_hessian(p, &seed);
        random_bounds(p, &seed);
        assert_int_equal(qp_factor(p->qp, p->H), QP_SOLVED);
        for (int change = 0; change < 3; change++) {
            for (int j = 0; j < n; j++) {
                p->g[j] = change == 0 ? 10.0 * drawn(&seed) : p->g[j] + 0.5 * drawn(&seed);
            }
            assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, p->inside, p->x), QP_SOLVED);
            assert_true(off_optimum(p) < 1e-9);
        }
        assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, NULL, p->x), QP_SOLVED);
        assert_int_equal(qp_iterations(p->qp), 0); /* started where it had ended */
        discard(p);
    }
}

static program *small_example(void)
{
    const double H[4][4] = {{4, 1, 0, -1}, {1, 3, 0.5, 0}, {0, 0.5, 2, 0.25}, {-1, 0, 0.25, 1.5}};
    const double g[4] = {-8, 3, -1, 6};
    const double A[2][4] = {{1, 1, 0, 0}, {0, 1, -1, 2}};
    program *p = make(4, 2, 0);

    memcpy(p->g, g, sizeof g);
    for (int i = 0; i < 4; i++) {
        memcpy(p->H + i * p->stride, H[i], sizeof H[i]);
        p->lower[i] = -1.0;
        p->upper[i] = 1.0;
    }
    for (int r = 0; r < 2; r++) {
        memcpy(p->A + r * p->stride, A[r], sizeof A[r]);
    }
    p->row_lower[0] = -0.5;
    p->row_lower[1] = -1.0;
    p->row_upper[0] = 0.4;
    p->row_upper[1] = 0.75;
    return p;
}

/* By quadprog 0.1.14, the method of Goldfarb and Idnani as Turlach has it. */
static void test_another_program(void **state)
{
    const double x[4] = {1, -0.6, -0.38095238095238093, -0.39047619047619087};
    const double multiplier[6] = {4.05952380952381, 0, 0, 0, 0.15, -2.1595238095238094};
    program *p = small_example();

    (void)state;
    assert_int_equal(qp_factor(p->qp, p->H), QP_SOLVED);
    assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, NULL, p->x), QP_SOLVED);
    for (int i = 0; i < 4; i++) {
        assert_near(p->x[i], x[i], 1e-12);
    }
    for (int i = 0; i < 6; i++) {
        assert_near(qp_multipliers(p->qp)[i], multiplier[i], 1e-12);
    }
    assert_true(off_optimum(p) < 1e-12);
    discard(p);
}

/* A vertex of three variables where all of many rows meet. */
static void test_degenerate(void **state)
{
    uint64_t seed = 5;

    (void)state;
    for (int i = 0; i < 100; i++) {
        program *p = make(3, 40, 0);

        for (int j = 0; j < 3; j++) {
            p->H[j * p->stride + j] = 1.0;
            p->g[j] = -1.0;
            p->upper[j] = 0.5;
        }
        for (int r = 0; r < 40; r++) {
            double sum = 0.0;

            for (int j = 0; j < 3; j++) {
                p->A[r * p->stride + j] = random_in(&seed, 0.0, 1.0);
                sum += p->A[r * p->stride + j];
            }
            p->row_lower[r] = -INFINITY;
            p->row_upper[r] = 0.5 * sum; /* of the vertex (0.5, 0.5, 0.5) */
        }
        assert_int_equal(qp_factor(p->qp, p->H), QP_SOLVED);
        assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, NULL, p->x), QP_SOLVED);
        assert_true(off_optimum(p) < 1e-9);
        for (int j = 0; j < 3; j++) {
            assert_near(p->x[j], 0.5, 1e-9);
        }
        discard(p);
    }
}

/* x + y <= -3 and x - y >= 1, x + y >= 3 within [-1, 1]: the least squares of the violation are at
 * x + y = 0; of those without preference (x - y >= 1 holds on a line) the cheapest is x = 0.5. */
static void test_impossible(void **state)
{
    program *p = make(2, 3, 0);
    const double A[3][2] = {{1, 1}, {1, -1}, {1, 1}};

    (void)state;
    for (int i = 0; i < 2; i++) {
        p->H[i * p->stride + i] = 1.0;
        p->lower[i] = -1.0;
        p->upper[i] = 1.0;
        p->inside[i] = 0.0;
    }
    for (int r = 0; r < 3; r++) {
        memcpy(p->A + r * p->stride, A[r], sizeof A[r]);
        p->row_lower[r] = r == 0 ? -INFINITY : r == 1 ? 1.0 : 3.0;
        p->row_upper[r] = r == 0 ? -3.0 : INFINITY;
    }
    assert_int_equal(qp_factor(p->qp, p->H), QP_SOLVED);
    assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, p->inside, p->x), QP_INFEASIBLE);
    assert_near(p->x[0], 0.5, 1e-5); /* the penalty is 1e6, not infinite */
    assert_near(p->x[1], -0.5, 1e-5);
    p->row_lower[2] = -3.0; /* and now it is possible */
    p->row_upper[0] = -0.5;
    assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, p->inside, p->x), QP_SOLVED);
    assert_near(p->x[0], 0.25, 1e-12);
    assert_near(p->x[1], -0.75, 1e-12);
    assert_true(off_optimum(p) < 1e-12);
    discard(p);
}

/* However few iterations: the answer is allowed, and not worse than what was known. */
static void test_interrupted(void **state)
{
    uint64_t seed = 3;
    int interrupted = 0;

    (void)state;
    for (int i = 0; i < 200; i++) {
        program *p = make(20, 30, 1 + i % 12);
        qp_status status;

        random_hessian(p, &seed);
        random_bounds(p, &seed);
        for (int j = 0; j < p->n; j++) {
            p->g[j] = 10.0 * drawn(&seed);
        }
        assert_int_equal(qp_factor(p->qp, p->H), QP_SOLVED);
        status = qp_solve(p->qp, p->g, &p->bounds, p->inside, p->x);
        interrupted += status == QP_LIMIT;
        assert_true(status == QP_SOLVED || status == QP_LIMIT);
        assert_true(qp_iterations(p->qp) <= 2 + i % 12 + p->n); /* rows that give way come on top */
        assert_true(cost(p, p->x) <= cost(p, p->inside) + 1e-12);
        for (int j = 0; j < p->n; j++) {
            assert_true(p->lower[j] <= p->x[j] && p->x[j] <= p->upper[j]);
        }
        for (int r = 0; r < p->m; r++) {
            double value = 0.0;

            for (int j = 0; j < p->n; j++) {
                value += p->A[r * p->stride + j] * p->x[j];
            }
            assert_true(p->softness[r] > 0.0 ||
                        (value > p->row_lower[r] - 1e-9 && value < p->row_upper[r] + 1e-9));
        }
        discard(p);
    }
    assert_true(interrupted > 150);
}

static void test_bad(void **state)
{
    program *p = small_example();

    (void)state;
    assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, NULL, p->x), QP_BAD); /* no H yet */
    p->H[0] = -1.0;
    assert_int_equal(qp_factor(p->qp, p->H), QP_BAD);
    p->H[0] = NAN;
    assert_int_equal(qp_factor(p->qp, p->H), QP_BAD);
    p->H[0] = 4.0;
    assert_int_equal(qp_factor(p->qp, p->H), QP_SOLVED);
    p->g[1] = NAN;
    p->lower[2] = 0.25;
    assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, NULL, p->x), QP_BAD);
    assert_near(p->x[0], 0.0, 0.0);
    assert_near(p->x[2], 0.25, 0.0);
    p->g[1] = 3.0;
    p->row_lower[1] = 2.0; /* above the upper one */
    p->inside[3] = 0.5;
    assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, p->inside, p->x), QP_BAD);
    assert_near(p->x[3], 0.5, 0.0);
    p->row_lower[1] = -1.0;
    p->lower[2] = -1.0;
    p->A[2] = INFINITY;
    assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, NULL, p->x), QP_BAD);
    p->A[2] = 0.0;
    assert_int_equal(qp_solve(p->qp, p->g, &p->bounds, NULL, p->x), QP_SOLVED);
    assert_true(off_optimum(p) < 1e-12);
    discard(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_optimal),     cmocka_unit_test(test_another_program),
        cmocka_unit_test(test_degenerate),  cmocka_unit_test(test_impossible),
        cmocka_unit_test(test_interrupted), cmocka_unit_test(test_bad)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
