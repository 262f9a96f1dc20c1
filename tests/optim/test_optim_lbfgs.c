/* L-BFGS: its steps against the strong Wolfe conditions and the dense matrix, how it ends. */
#include "optim_testing.h"

/* Runs to the end; every step has to satisfy the strong Wolfe conditions, N&W (3.7), computed here
 * from the points alone, and the bookkeeping has to hold. Returns the evaluations spent. */
static long check_every_step(formula f, size_t count, const double *x, int memory, double *result)
{
    problem p = make_problem(f, count);
    double before[MAX_COUNT], g0[MAX_COUNT], g1[MAX_COUNT], s[MAX_COUNT];
    optim_optimizer *lbfgs = make_lbfgs(count, x, memory);
    optim_status status = OPTIM_RUNNING;
    for (int step = 1; step <= 2000 && status == OPTIM_RUNNING; step++) {
        memcpy(before, optim_x(lbfgs), count * sizeof *before);
        status = step_by(lbfgs, objective, &p);
        const double f0 = f(count, before, g0), f1 = f(count, optim_x(lbfgs), g1);
        assert_consistent(lbfgs, &p);
        assert_true(optim_inspect(lbfgs).best_value == p.lowest);
        assert_memory_equal(best_x_of(lbfgs), p.lowest_x, count * sizeof *x);
        if (status == OPTIM_GRADIENT_TOLERANCE) {
            break; /* steps as small as rounding, too short to check */
        }
        assert_int_equal(optim_inspect(lbfgs).steps, step);
        for (size_t i = 0; i < count; i++) {
            s[i] = optim_x(lbfgs)[i] - before[i];
        }
        /* x1 - x0 carries a rounding of 1e-16 |x|, and the slopes that times |g|. */
        const double slope = dot(count, g0, s);
        const double rounding = 1e-15 * (sqrt(dot(count, g0, g0)) + sqrt(dot(count, g1, g1))) *
                                (1 + sqrt(dot(count, before, before)));
        assert_true(f1 <= f0 + 1e-4 * slope + 1e-4 * rounding);
        assert_true(fabs(dot(count, g1, s)) <= 0.9 * fabs(slope) + rounding);
    }
    assert_int_equal(status, OPTIM_GRADIENT_TOLERANCE);
    memcpy(result, best_x_of(lbfgs), count * sizeof *result);
    const optim_info info = optim_inspect(lbfgs);
    assert_int_equal(info.evaluations, p.evaluations);
    assert_int_equal(info.resets, 0);
    assert_true(info.best_value == p.lowest);
    optim_free(lbfgs);
    return p.evaluations;
}

/* The bounds on evaluations are 1.5 times what SciPy 1.17.1 (L-BFGS-B, maxcor 10, gtol 1e-12,
 * ftol 0) spends from the same start: 47, 50 and 652. */
static void test_lbfgs_rosenbrock(void **state)
{
    (void)state;
    double x[MAX_COUNT], result[MAX_COUNT], ones[MAX_COUNT];
    for (int i = 0; i < MAX_COUNT; i++) {
        ones[i] = 1;
    }
    classic_start(MAX_COUNT, x);
    assert_true(check_every_step(rosenbrock, 2, x, 10, result) <= 71);
    assert_true(check_every_step(rosenbrock, 100, x, 10, result) <= 75);
    /* |g| <= 1e-12 and the smallest eigenvalue at (1, 1) is 0.4: x is within 1e-11. */
    assert_below(distance(100, result, ones), 1e-11);
    assert_true(check_every_step(chained_rosenbrock, 100, x, 10, result) <= 978);
    assert_below(distance(100, result, ones), 1e-11);
    double g[MAX_COUNT]; /* the value is already below 1e-12 well before the end */
    problem p = make_problem(chained_rosenbrock, 100);
    optim_optimizer *lbfgs = make_lbfgs(100, x, 50);
    while (optim_inspect(lbfgs).best_value >= 1e-12 && p.evaluations < 650) {
        assert_int_equal(step_by(lbfgs, objective, &p), OPTIM_RUNNING);
    }
    assert_below(chained_rosenbrock(100, best_x_of(lbfgs), g), 1e-12);
    optim_free(lbfgs);
}

/* A memory above the number of iterations keeps the whole history; with less, inexact searches
 * take thousands of iterations at condition 1e6. */
static void test_lbfgs_quadratic(void **state)
{
    (void)state;
    double x[50] = {0}, minimiser[50], result[50];
    for (int i = 0; i < 50; i++) {
        minimiser[i] = sin(i + 1.0);
    }
    /* |g_i| <= 1e-12 and lambda_min = 1. */
    check_every_step(diagonal_quadratic, 50, x, 400, result);
    assert_below(distance(50, result, minimiser), 1e-11);
    /* In turned axes the gradient itself is rounded by 1e6 * 1e-16 * |x - c|: stop above that. */
    optim_settings settings = optim_settings_defaults(OPTIM_LBFGS);
    settings.memory = 400;
    settings.gradient_tolerance = 1e-9;
    problem p = make_problem(turned_quadratic, 50);
    optim_optimizer *lbfgs = create_lbfgs(50, x, &settings, NULL);
    assert_int_equal(run(lbfgs, &p, 400), OPTIM_GRADIENT_TOLERANCE);
    assert_below(distance(50, optim_x(lbfgs), minimiser), 1e-8); /* sqrt(50) * 1e-9 */
    optim_free(lbfgs);
}

/* The direction of a step against -H g with the dense BFGS matrix, N&W (6.17), built from the pairs
 * oldest first, starting from gamma I: before, when and after the ring of 4 wraps. */
static void test_lbfgs_direction(void **state)
{
    (void)state;
    enum { N = 6, MEMORY = 4 };
    double x[N], h[N][N], hy[N], before[N], d[N];
    classic_start(N, x);
    x[0] = 0.3;
    problem p = make_problem(chained_rosenbrock, N);
    optim_optimizer *lbfgs = make_lbfgs(N, x, MEMORY);
    optim_array a[OPTIM_STATE_CAPACITY];
    optim_state(lbfgs, a);
    run(lbfgs, &p, 1);
    for (int iteration = 1; iteration < 12; iteration++) {
        assert_int_equal(optim_inspect(lbfgs).skipped, 0);
        const int pairs = iteration < MEMORY ? iteration : MEMORY;
        assert_int_equal(optim_inspect(lbfgs).pairs, pairs);
        const double *newest_s = a[3].data + (iteration - 1) % MEMORY * N;
        const double *newest_y = a[4].data + (iteration - 1) % MEMORY * N;
        const double gamma = dot(N, newest_s, newest_y) / dot(N, newest_y, newest_y);
        for (int i = 0; i < N * N; i++) {
            h[i / N][i % N] = i / N == i % N ? gamma : 0;
        }
        for (int k = iteration - pairs; k < iteration; k++) {
            const double *s = a[3].data + k % MEMORY * N, *y = a[4].data + k % MEMORY * N;
            const double rho = 1 / dot(N, s, y);
            for (int i = 0; i < N; i++) {
                hy[i] = dot(N, h[i], y);
            }
            const double factor = rho * rho * dot(N, y, hy) + rho;
            for (int i = 0; i < N * N; i++) {
                const int r = i / N, c = i % N;
                h[r][c] += factor * s[r] * s[c] - rho * (hy[r] * s[c] + s[r] * hy[c]);
            }
        }
        for (int i = 0; i < N; i++) {
            d[i] = -dot(N, h[i], a[1].data);
        }
        memcpy(before, a[0].data, sizeof before);
        assert_int_equal(step_by(lbfgs, objective, &p), OPTIM_RUNNING);
        for (int i = 0; i < N; i++) { /* matrices of condition 1e3 to 1e4 cost 4 of 16 digits */
            const double taken = (a[0].data[i] - before[i]) / optim_inspect(lbfgs).rate;
            assert_near(taken, d[i], 1e-10 * sqrt(dot(N, d, d)) + 1e-13);
        }
    }
    optim_free(lbfgs);
}

static void test_lbfgs_one_variable(void **state)
{
    (void)state;
    double result[1];
    check_every_step(hyperbolic_cosine, 1, (double[1]){0}, 10, result);
    assert_near(result[0], 3, 1e-7); /* the best value cannot resolve x beyond sqrt(2e-16) */
    check_every_step(hyperbolic_cosine, 1, (double[1]){50}, 10, result);
    assert_near(result[0], 3, 1e-7);
}

/* The first trial point lies at unit distance, and has to pass the test of sufficient decrease. */
static void test_lbfgs_first_step(void **state)
{
    (void)state;
    problem p = make_problem(hyperbolic_cosine, 1);
    optim_optimizer *lbfgs = make_lbfgs(1, (double[1]){50}, 10);
    assert_int_equal(run(lbfgs, &p, 1), OPTIM_RUNNING);
    assert_int_equal(p.evaluations, 2); /* the slope falls to 1 / e of what it was: accepted */
    assert_near(optim_x(lbfgs)[0], 49, 1e-14);
    optim_free(lbfgs);
    problem q = make_problem(shallow_cubic, 1);
    lbfgs = make_lbfgs(1, (double[1]){0}, 10);
    /* x = 1 is refused, -1e-5 > -c1; the cubic interpolation then is the function itself. */
    assert_int_equal(run(lbfgs, &q, 1), OPTIM_GRADIENT_TOLERANCE);
    assert_int_equal(q.evaluations, 3);
    optim_free(lbfgs);
}

static void test_lbfgs_starts_at_minimum(void **state)
{
    (void)state;
    const double x[2] = {1, 1};
    problem p = make_problem(rosenbrock, 2);
    optim_optimizer *lbfgs = make_lbfgs(2, x, 10);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(step_by(lbfgs, objective, &p), OPTIM_GRADIENT_TOLERANCE);
        assert_int_equal(optim_inspect(lbfgs).evaluations, 1);
        assert_memory_equal(optim_x(lbfgs), x, sizeof x);
    }
    optim_free(lbfgs);
}

/* From 1e-6 the gradient, -1e6, points over the whole finite region; from 20 the first steps, grown
 * to the left, cross into the NaN at x < 0. */
static void test_lbfgs_nan_region(void **state)
{
    (void)state;
    static const double starts[] = {1e-6, 20, 3};
    for (size_t k = 0; k < 3; k++) {
        double x[10];
        for (int i = 0; i < 10; i++) {
            x[i] = starts[k] * (1 + 0.3 * i);
        }
        problem p = make_problem(barrier, 10);
        optim_optimizer *lbfgs = make_lbfgs(10, x, 10);
        const optim_status status = run(lbfgs, &p, 200);
        assert_true(status == OPTIM_GRADIENT_TOLERANCE || status == OPTIM_FUNCTION_TOLERANCE ||
                    status == OPTIM_LINE_SEARCH_FAILED); /* rounding of the value 10 */
        for (int i = 0; i < 10; i++) { /* flat to rounding of the value: sqrt(10 * 2e-16) */
            assert_near(optim_x(lbfgs)[i], 1, 1e-7);
        }
        assert_consistent(lbfgs, &p);
        optim_free(lbfgs);
    }
}

static void test_lbfgs_unbounded(void **state)
{
    (void)state;
    problem p = make_problem(falling_line, 3);
    optim_optimizer *lbfgs = make_lbfgs(3, (double[3]){0, 0, 0}, 10);
    assert_int_equal(run(lbfgs, &p, 100), OPTIM_UNBOUNDED);
    const double *x = optim_x(lbfgs);
    assert_near(sqrt(dot(3, x, x)), 1e10, 1); /* maximum_step */
    assert_consistent(lbfgs, &p);
    optim_free(lbfgs);
    /* The second trial is the last finite one: its decrease is kept, with its gradient. */
    problem r = make_problem(falling_line, 3);
    r.misbehave_from = 4;
    r.misbehaviour = NAN_GRADIENT;
    lbfgs = make_lbfgs(3, (double[3]){0, 0, 0}, 10);
    assert_int_equal(run(lbfgs, &r, 100), OPTIM_NO_FINITE_STEP);
    assert_true(optim_inspect(lbfgs).value == r.lowest && r.lowest < -1);
    assert_consistent(lbfgs, &r);
    optim_free(lbfgs);
    /* Overflows before it gets that far. */
    problem q = make_problem(falling_exponential, 1);
    lbfgs = make_lbfgs(1, (double[1]){0}, 10);
    assert_int_equal(run(lbfgs, &q, 100), OPTIM_LINE_SEARCH_FAILED);
    assert_true(isfinite(optim_x(lbfgs)[0]) && optim_inspect(lbfgs).value < -1e100);
    assert_consistent(lbfgs, &q);
    optim_free(lbfgs);
}

/* The objective misbehaves for good from the first, second, or a later evaluation on. */
static void test_lbfgs_endings(void **state)
{
    (void)state;
    double x[10];
    classic_start(10, x);
    for (int how = STOP; how <= WRONG_GRADIENT; how++) {
        for (long from = how == WRONG_GRADIENT ? 20 : 1; from < 25; from++) {
            problem p = make_problem(rosenbrock, 10);
            p.misbehave_from = from;
            p.misbehaviour = how;
            optim_optimizer *lbfgs = make_lbfgs(10, x, 5);
            const optim_status status = run(lbfgs, &p, 100);
            const optim_info info = optim_inspect(lbfgs);
            if (how == STOP) {
                assert_int_equal(status, OPTIM_STOPPED_BY_OBJECTIVE);
            } else if (how == WRONG_GRADIENT) {
                assert_int_equal(status, OPTIM_LINE_SEARCH_FAILED);
                assert_true(info.resets >= 1);
            } else if (from == 1) {
                assert_int_equal(status, OPTIM_NOT_FINITE);
            } else {
                /* Only the very first line search may have seen a finite trial before. */
                const int any_finite = info.steps == 0 && from > 2;
                assert_true(status == OPTIM_NO_FINITE_STEP ||
                            (any_finite && status == OPTIM_LINE_SEARCH_FAILED));
                assert_int_equal(info.resets, info.steps > 0);
                assert_true(info.evaluations < from + 2 * 25); /* the budget of two searches */
            }
            assert_true(info.best_value == p.lowest);
            if (from > 1 && how != WRONG_GRADIENT) {
                assert_consistent(lbfgs, &p);
                assert_true(info.value >= info.best_value);
            }
            p.misbehave_from = 0; /* the run can go on */
            assert_int_equal(how == WRONG_GRADIENT ? OPTIM_GRADIENT_TOLERANCE : run(lbfgs, &p, 200),
                             OPTIM_GRADIENT_TOLERANCE);
            optim_free(lbfgs);
        }
    }
}

static void test_lbfgs_tolerances(void **state)
{
    (void)state;
    double x[10];
    classic_start(10, x);
    for (int kind = 0; kind < 3; kind++) {
        static const optim_status wanted[] = {OPTIM_GRADIENT_TOLERANCE, OPTIM_FUNCTION_TOLERANCE,
                                              OPTIM_STEP_TOLERANCE};
        optim_settings settings = optim_settings_defaults(OPTIM_LBFGS);
        settings.gradient_tolerance = kind == 0 ? 1e-3 : 0;
        settings.function_tolerance = kind == 1 ? 1e-2 : 0;
        settings.step_tolerance = kind == 2 ? 1e-3 : 0;
        problem p = make_problem(rosenbrock, 10);
        optim_optimizer *lbfgs = create_lbfgs(10, x, &settings, NULL);
        assert_int_equal(run(lbfgs, &p, 100), wanted[kind]);
        if (kind == 0) {
            assert_true(optim_inspect(lbfgs).gradient_max <= 1e-3);
        }
        optim_free(lbfgs);
    }
}

/* A threshold that nearly every pair misses: pairs are dropped, and the run still descends. */
static void test_lbfgs_skips(void **state)
{
    (void)state;
    double x[10];
    classic_start(10, x);
    optim_settings settings = optim_settings_defaults(OPTIM_LBFGS);
    settings.curvature_threshold = 0.9;
    problem p = make_problem(rosenbrock, 10);
    optim_optimizer *lbfgs = create_lbfgs(10, x, &settings, NULL);
    for (int i = 0; i < 50; i++) {
        const double before = optim_inspect(lbfgs).value;
        assert_int_equal(step_by(lbfgs, objective, &p), OPTIM_RUNNING);
        assert_true(optim_inspect(lbfgs).value < before);
        const optim_info info = optim_inspect(lbfgs);
        assert_int_equal(info.pairs + info.skipped, info.steps);
    }
    assert_true(optim_inspect(lbfgs).skipped > 10);
    optim_free(lbfgs);
}

/* After a change of the objective the run is that of a new optimiser at the same point. */
static void test_lbfgs_objective_changed(void **state)
{
    (void)state;
    double x[10];
    classic_start(10, x);
    problem first = make_problem(rosenbrock, 10);
    problem second = make_problem(chained_rosenbrock, 10);
    optim_optimizer *lbfgs = make_lbfgs(10, x, 5);
    assert_int_equal(run(lbfgs, &first, 12), OPTIM_RUNNING);
    optim_objective_changed(lbfgs);
    assert_int_equal(optim_inspect(lbfgs).pairs, 0);
    optim_optimizer *fresh = make_lbfgs(10, optim_x(lbfgs), 5);
    for (int i = 0; i < 20; i++) {
        assert_int_equal(run(lbfgs, &second, 1), run(fresh, &second, 1));
        assert_memory_equal(optim_x(lbfgs), optim_x(fresh), sizeof x);
        assert_true(optim_inspect(lbfgs).best_value == optim_inspect(fresh).best_value);
    }
    optim_free(lbfgs);
    optim_free(fresh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lbfgs_rosenbrock), cmocka_unit_test(test_lbfgs_quadratic),
        cmocka_unit_test(test_lbfgs_direction),  cmocka_unit_test(test_lbfgs_one_variable),
        cmocka_unit_test(test_lbfgs_first_step), cmocka_unit_test(test_lbfgs_starts_at_minimum),
        cmocka_unit_test(test_lbfgs_nan_region), cmocka_unit_test(test_lbfgs_unbounded),
        cmocka_unit_test(test_lbfgs_endings),    cmocka_unit_test(test_lbfgs_tolerances),
        cmocka_unit_test(test_lbfgs_skips),      cmocka_unit_test(test_lbfgs_objective_changed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
