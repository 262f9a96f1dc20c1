/* Levenberg-Marquardt.
 * The Cholesky factors are made here, so that nothing but optim/ is under test. */
#include "allocations.h"
#include "optim/optimizer.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- Cholesky: matrix = U^T U ---- */

static int factor(size_t n, double *u)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++) {
            for (size_t j = i; j < n; j++) {
                u[i * n + j] -= u[k * n + i] * u[k * n + j];
            }
        }
        if (!(u[i * n + i] > 0)) {
            return 1;
        }
        const double root = sqrt(u[i * n + i]);
        for (size_t j = i; j < n; j++) {
            u[i * n + j] /= root;
        }
    }
    return 0;
}

static void solve(size_t n, const double *u, double *x)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++) {
            x[i] -= u[k * n + i] * x[k];
        }
        x[i] /= u[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++) {
            x[i] -= u[i * n + k] * x[k];
        }
        x[i] /= u[i * n + i];
    }
}

static optim_optimizer *create_gauss_newton(size_t count, const double *x,
                                            const optim_settings *given, const char **why)
{
    optim_settings settings = *given;
    settings.method = OPTIM_GAUSS_NEWTON;
    return optim_create(count, x, &settings, why);
}

/* ---- problems ---- */

enum { ROWS_MAX = 40, UNKNOWNS_MAX = 8 };

/* r[rows] and, when it is not NULL, j[rows][count]. */
typedef void (*residuals)(const double *x, double *r, double *j);

typedef struct fit {
    residuals f;
    size_t rows, count;
    long evaluations;
    long bad_from; /* evaluation, counted from 1; 0: never */
    int bad_code;
    double jtj[UNKNOWNS_MAX * UNKNOWNS_MAX], jtr[UNKNOWNS_MAX];
    long models; /* how many times J was computed */
} fit;

static int evaluate(fit *p, const double *x, double *r, double *j, double *value)
{
    if (++p->evaluations >= p->bad_from && p->bad_from > 0) {
        return p->bad_code;
    }
    p->f(x, r, j);
    *value = 0;
    for (size_t i = 0; i < p->rows; i++) {
        *value += r[i] * r[i];
    }
    return OPTIM_OBJECTIVE_OK;
}

static int sum_of_squares(void *context, const double *x, double *value)
{
    double r[ROWS_MAX];
    return evaluate(context, x, r, NULL, value);
}

static int linearize(void *context, const double *x, double *value, double *jtr, double *diagonal)
{
    fit *p = context;
    double r[ROWS_MAX], j[ROWS_MAX * UNKNOWNS_MAX] = {0};
    const int code = evaluate(p, x, r, j, value);
    p->models++;
    for (size_t a = 0; code == OPTIM_OBJECTIVE_OK && a < p->count; a++) {
        p->jtr[a] = 0;
        for (size_t i = 0; i < p->rows; i++) {
            p->jtr[a] += j[i * p->count + a] * r[i];
        }
        for (size_t b = 0; b < p->count; b++) {
            p->jtj[a * p->count + b] = 0;
            for (size_t i = 0; i < p->rows; i++) {
                p->jtj[a * p->count + b] += j[i * p->count + a] * j[i * p->count + b];
            }
        }
        jtr[a] = p->jtr[a];
        diagonal[a] = p->jtj[a * p->count + a];
    }
    return code;
}

/* By the normal equations. */
static int find_step(void *context, double damping, const double *scale, double *step)
{
    fit *p = context;
    double matrix[UNKNOWNS_MAX * UNKNOWNS_MAX];
    memcpy(matrix, p->jtj, p->count * p->count * sizeof *matrix);
    for (size_t i = 0; i < p->count; i++) {
        matrix[i * p->count + i] += damping * scale[i];
        step[i] = -p->jtr[i];
    }
    if (factor(p->count, matrix) != 0) {
        return 1;
    }
    solve(p->count, matrix, step);
    return 0;
}

/* J^T r at x beside J^T J where it is. */
static int refresh(void *context, const double *x, double *value, double *jtr)
{
    fit *p = context;
    double r[ROWS_MAX], j[ROWS_MAX * UNKNOWNS_MAX] = {0};
    const int code = evaluate(p, x, r, j, value);
    for (size_t a = 0; code == OPTIM_OBJECTIVE_OK && a < p->count; a++) {
        jtr[a] = 0;
        for (size_t i = 0; i < p->rows; i++) {
            jtr[a] += j[i * p->count + a] * r[i];
        }
        p->jtr[a] = jtr[a];
    }
    return code;
}

static optim_linear_model model_of(fit *p)
{
    return (optim_linear_model){p, sum_of_squares, linearize, find_step, NULL};
}

/* A polynomial through values of it: r_i = sum_k x_k t_i^k - p(t_i). */
static void linear(const double *x, double *r, double *j)
{
    for (int i = 0; i < 10; i++) {
        double t = i / 9.0, power = 1;
        r[i] = -(1 + 2 * t - 3 * t * t);
        for (int k = 0; k < 3; k++, power *= t) {
            r[i] += x[k] * power;
            if (j) {
                j[3 * i + k] = power;
            }
        }
    }
}

static void rosenbrock(const double *x, double *r, double *j)
{
    r[0] = 10 * (x[1] - x[0] * x[0]);
    r[1] = 1 - x[0];
    if (j) {
        const double rows[4] = {-20 * x[0], 10, -1, 0};
        memcpy(j, rows, sizeof rows);
    }
}

/* NIST StRD, Misra1a (lower difficulty): y = b1 (1 - exp(-b2 x)). */
static void misra1a(const double *b, double *r, double *j)
{
    static const double data[14][2] = {{10.07E0, 77.6E0},  {14.73E0, 114.9E0}, {17.94E0, 141.1E0},
                                       {23.93E0, 190.8E0}, {29.61E0, 239.9E0}, {35.18E0, 289.0E0},
                                       {40.02E0, 332.8E0}, {44.82E0, 378.4E0}, {50.76E0, 434.8E0},
                                       {55.05E0, 477.3E0}, {61.01E0, 536.8E0}, {66.40E0, 593.1E0},
                                       {75.47E0, 689.1E0}, {81.78E0, 760.0E0}};
    for (int i = 0; i < 14; i++) {
        const double e = exp(-b[1] * data[i][1]);
        r[i] = b[0] * (1 - e) - data[i][0];
        if (j) {
            j[2 * i] = 1 - e;
            j[2 * i + 1] = b[0] * data[i][1] * e;
        }
    }
}

/* Only the sum of the first two unknowns counts, and the third not at all. */
static void deficient(const double *x, double *r, double *j)
{
    for (int i = 0; i < 4; i++) {
        r[i] = (i + 1) * (x[0] + x[1] - 2) + 0.1 * pow(x[0] + x[1] - 2, 2);
        if (j) {
            j[3 * i] = j[3 * i + 1] = i + 1 + 0.2 * (x[0] + x[1] - 2);
            j[3 * i + 2] = 0;
        }
    }
}

/* Root of log x = -5 from the right: full steps jump to where there is no logarithm. */
static void logarithm(const double *x, double *r, double *j)
{
    r[0] = log(x[0]) + 5;
    if (j) {
        j[0] = 1 / x[0];
    }
}

static void constant(const double *x, double *r, double *j)
{
    r[0] = 1 + 0 * x[0];
    if (j) {
        j[0] = -1; /* a lie: no step lowers the value */
    }
}

static optim_optimizer *make(fit *p, const double *x, optim_scaling scaling, double damping)
{
    optim_settings settings = optim_settings_defaults(OPTIM_GAUSS_NEWTON);
    settings.scaling = scaling;
    settings.initial_damping = damping;
    const char *why = "";
    optim_optimizer *gn = create_gauss_newton(p->count, x, &settings, &why);
    assert_non_null(gn);
    assert_null(why);
    return gn;
}

static optim_status step_of(optim_optimizer *gn, fit *p)
{
    const optim_linear_model model = model_of(p);
    return optim_step(gn, &(optim_target){.model = &model});
}

/* Steps until something stops it; the value never rises. */
static optim_status minimise(optim_optimizer *gn, fit *p, int most)
{
    optim_status status = OPTIM_RUNNING;
    double before = INFINITY;
    for (int i = 0; i < most && status == OPTIM_RUNNING; i++) {
        status = step_of(gn, p);
        const double value = optim_inspect(gn).value;
        assert_true(value <= before);
        before = value;
    }
    return status;
}

#define EACH_SCALING(s) for (int s = 0; s < OPTIM_SCALING_COUNT; s++)

/* ---- tests ---- */

static void test_linear(void **state)
{
    (void)state;
    const double start[3] = {5, -7, 9}, expected[3] = {1, 2, -3};
    EACH_SCALING(s)
    {
        fit p = {linear, 10, 3, 0, 0, 0, {0}, {0}, 0};
        optim_optimizer *gn = make(&p, start, (optim_scaling)s, 1e-14);
        minimise(gn, &p, 2);
        for (int i = 0; i < 3; i++) { /* the condition of J^T J, 5e3, times rounding, squared */
            assert_true(fabs(optim_x(gn)[i] - expected[i]) < 1e-10);
        }
        optim_free(gn);
    }
}

static void test_rosenbrock(void **state)
{
    (void)state;
    const double start[2] = {-1.2, 1};
    EACH_SCALING(s)
    {
        fit p = {rosenbrock, 2, 2, 0, 0, 0, {0}, {0}, 0};
        optim_optimizer *gn = make(&p, start, (optim_scaling)s, 1e-3);
        assert_int_equal(minimise(gn, &p, 100), OPTIM_GRADIENT_TOLERANCE);
        /* the gradient's tolerance over the smallest eigenvalue of the Hessian, 0.4, and twice that
         * along the valley */
        assert_true(fabs(optim_x(gn)[0] - 1) < 1e-11);
        assert_true(fabs(optim_x(gn)[1] - 1) < 1e-11);
        optim_info info = optim_inspect(gn);
        assert_true(info.steps < 60 && info.rejected > 0);
        assert_int_equal(info.evaluations, p.evaluations);
        optim_free(gn);
    }
}

/* Certified: b1 = 2.3894212918E+02, b2 = 5.5015643181E-04, residual sum of
 * squares 1.2455138894E-01, from both certified starts. Eight digits is what least squares in
 * double precision promises. */
static void test_misra1a(void **state)
{
    (void)state;
    const double starts[2][2] = {{500, 0.0001}, {250, 0.0005}};
    for (int i = 0; i < 2; i++) {
        fit p = {misra1a, 14, 2, 0, 0, 0, {0}, {0}, 0};
        optim_optimizer *gn = make(&p, starts[i], OPTIM_SCALING_DIAGONAL, 1e-3);
        minimise(gn, &p, 100);
        const double *b = optim_x(gn);
        assert_true(fabs(b[0] / 2.3894212918E+02 - 1) < 1e-8);
        assert_true(fabs(b[1] / 5.5015643181E-04 - 1) < 1e-8);
        assert_true(fabs(optim_inspect(gn).value / 1.2455138894E-01 - 1) < 1e-9);
        optim_free(gn);
    }
}

static void test_rank_deficient(void **state)
{
    (void)state;
    const double start[3] = {4, 1, 7};
    EACH_SCALING(s)
    {
        fit p = {deficient, 4, 3, 0, 0, 0, {0}, {0}, 0};
        /* below rounding: the first matrix may well have no factor */
        optim_optimizer *gn = make(&p, start, (optim_scaling)s, 1e-18);
        minimise(gn, &p, 50);
        const double *x = optim_x(gn);
        assert_true(fabs(x[0] + x[1] - 2) < 1e-7);
        assert_true(x[2] == 7); /* no residual depends on it */
        assert_true(isfinite(x[0]) && isfinite(x[1]));
        assert_true(optim_inspect(gn).unsolved > 0);
        optim_free(gn);
    }
}

static void test_not_finite(void **state)
{
    (void)state;
    const double start = 3, wrong = -1;
    fit p = {logarithm, 1, 1, 0, 0, 0, {0}, {0}, 0};
    optim_optimizer *gn = make(&p, &start, OPTIM_SCALING_DIAGONAL, 1e-6);
    minimise(gn, &p, 100);
    assert_true(fabs(optim_x(gn)[0] - exp(-5)) < 1e-12);
    assert_true(optim_inspect(gn).not_finite > 0);
    optim_free(gn);

    gn = make(&p, &wrong, OPTIM_SCALING_DIAGONAL, 1e-6);
    assert_int_equal(step_of(gn, &p), OPTIM_NOT_FINITE);
    assert_true(optim_x(gn)[0] == wrong);
    optim_free(gn);

    fit q = {rosenbrock, 2, 2, 0, 3, OPTIM_OBJECTIVE_NOT_FINITE, {0}, {0}, 0}; /* every trial */
    const double x[2] = {-1.2, 1};
    gn = make(&q, x, OPTIM_SCALING_IDENTITY, 1e-3);
    assert_int_equal(step_of(gn, &q), OPTIM_NO_FINITE_STEP);
    assert_memory_equal(optim_x(gn), x, sizeof x);
    q.bad_from = 0;
    assert_int_equal(minimise(gn, &q, 100), OPTIM_GRADIENT_TOLERANCE); /* it may be called again */
    optim_free(gn);
}

static void test_endings(void **state)
{
    (void)state;
    const double x[3] = {-1.2, 1, 0};
    fit lie = {constant, 1, 1, 0, 0, 0, {0}, {0}, 0};
    optim_optimizer *gn = make(&lie, x, OPTIM_SCALING_IDENTITY, 1e-3);
    assert_int_equal(minimise(gn, &lie, 10), OPTIM_DAMPING_OVERFLOW);
    assert_true(optim_x(gn)[0] == x[0]);
    optim_free(gn);

    for (long at = 1; at <= 3; at++) { /* value, matrix, trial */
        fit stop = {rosenbrock, 2, 2, 0, at, OPTIM_OBJECTIVE_STOP, {0}, {0}, 0};
        gn = make(&stop, x, OPTIM_SCALING_IDENTITY, 1e-3);
        assert_int_equal(step_of(gn, &stop), OPTIM_STOPPED_BY_OBJECTIVE);
        assert_int_equal(stop.evaluations, at);
        assert_memory_equal(optim_x(gn), x, 2 * sizeof *x);
        optim_free(gn);
    }

    optim_settings settings = optim_settings_defaults(OPTIM_GAUSS_NEWTON);
    fit p = {misra1a, 14, 2, 0, 0, 0, {0}, {0}, 0};
    const double b[2] = {250, 0.0005};
    settings.gradient_tolerance = 0;
    settings.function_tolerance = 1e-3;
    gn = create_gauss_newton(2, b, &settings, NULL);
    assert_int_equal(minimise(gn, &p, 100), OPTIM_FUNCTION_TOLERANCE);
    optim_free(gn);
    settings.function_tolerance = 0;
    settings.step_tolerance = 1e-3;
    gn = create_gauss_newton(2, b, &settings, NULL);
    assert_int_equal(minimise(gn, &p, 100), OPTIM_STEP_TOLERANCE);
    optim_free(gn);
}

static void test_resume(void **state)
{
    (void)state;
    const double start[2] = {-1.2, 1};
    for (int from = 0; from < 12; from++) {
        fit p = {rosenbrock, 2, 2, 0, 0, 0, {0}, {0}, 0};
        optim_optimizer *whole = make(&p, start, OPTIM_SCALING_IDENTITY, 1e-3);
        optim_optimizer *again = make(&p, start, OPTIM_SCALING_IDENTITY, 1e-3);
        minimise(whole, &p, from);
        optim_array a[OPTIM_STATE_CAPACITY], b[OPTIM_STATE_CAPACITY];
        const int count = optim_state(whole, a);
        assert_int_equal(optim_state(again, b), count);
        for (int i = 0; i < count; i++) {
            memcpy(b[i].data, a[i].data, a[i].count * sizeof *a[i].data);
        }
        assert_null(optim_state_check(again));
        for (int i = from; i < 14; i++) {
            assert_int_equal(step_of(whole, &p), step_of(again, &p));
            for (int k = 0; k < count; k++) {
                assert_memory_equal(a[k].data, b[k].data, a[k].count * sizeof *a[k].data);
            }
        }
        for (size_t i = 0; i < b[1].count; i++) { /* no scalar may hold anything */
            const double kept = b[1].data[i];
            b[1].data[i] = -1;
            if (optim_state_check(again)) {
                assert_int_equal(step_of(again, &p), OPTIM_BAD_STATE);
            }
            b[1].data[i] = kept;
        }
        b[0].data[0] = NAN;
        assert_non_null(optim_state_check(again));
        optim_free(whole);
        optim_free(again);
    }
}

static void test_settings(void **state)
{
    (void)state;
    const double x[2] = {0, NAN};
    const char *why = NULL;
    optim_settings good = optim_settings_defaults(OPTIM_GAUSS_NEWTON), bad[8];
    assert_null(optim_settings_check(&good));
    for (int i = 0; i < 8; i++) {
        bad[i] = good;
    }
    bad[0].scaling = OPTIM_SCALING_COUNT;
    bad[1].initial_damping = 0;
    bad[2].maximum_damping = bad[2].initial_damping;
    bad[3].gradient_tolerance = NAN;
    bad[4].function_tolerance = 1;
    bad[5].step_tolerance = -1;
    bad[6].damping_increase = 1;
    bad[7].damping_decrease = 1;
    for (int i = 0; i < 8; i++) {
        assert_non_null(optim_settings_check(&bad[i]));
        assert_null(create_gauss_newton(1, x, &bad[i], &why));
        assert_ptr_equal(why, optim_settings_check(&bad[i]));
    }
    assert_null(create_gauss_newton(2, x, &good, &why));
    assert_string_equal(why, "the starting point x must be finite");
    assert_null(create_gauss_newton(0, x, &good, &why));
    assert_string_equal(why, "count must be at least 1");
}

static void test_allocations(void **state)
{
    (void)state;
    const double start[2] = {-1.2, 1};
    const optim_settings settings = optim_settings_defaults(OPTIM_GAUSS_NEWTON);
    optim_optimizer *gn = NULL;
    for (long i = 1; !gn; i++) {
        assert_true(i < 20);
        allocations = 0;
        failing_allocation = i;
        const char *why = NULL;
        gn = create_gauss_newton(2, start, &settings, &why);
        failing_allocation = 0;
        if (!gn) {
            assert_string_equal(why, "out of memory");
        }
    }
    fit p = {rosenbrock, 2, 2, 0, 0, 0, {0}, {0}, 0};
    allocations = 0;
    minimise(gn, &p, 100);
    assert_int_equal(allocations, 0);
    optim_free(gn);
    optim_free(NULL);
}

/* ---- the chord method ---- */

/* Nearly linear, with residuals of some 1e-5 at their least sum of squares. */
static void bent(const double *x, double *r, double *j)
{
    for (int i = 0; i < 12; i++) {
        const double t = i / 11.0, wave = sin(x[0] * t + x[1]);
        r[i] = x[0] * t + x[1] + 0.05 * wave - t - 1e-4 * t * t;
        if (j) {
            j[2 * i] = t * (1 + 0.05 * cos(x[0] * t + x[1]));
            j[2 * i + 1] = 1 + 0.05 * cos(x[0] * t + x[1]);
        }
    }
}

static optim_status chord_step(optim_optimizer *gn, fit *p)
{
    const optim_linear_model model = {p, sum_of_squares, linearize, find_step, refresh};
    return optim_step(gn, &(optim_target){.model = &model});
}

/* The same minimiser with J computed fewer times than steps are taken; 1e-8: where
 * a sum of squares of 1e-10 no longer falls by 1e-16 of it, the point is known far better. */
static void test_chord(void **state)
{
    (void)state;
    const double from[2] = {40, -30};
    fit kept = {.f = bent, .rows = 12, .count = 2}, anew = kept;
    optim_optimizer *by_chord = make(&kept, from, OPTIM_SCALING_IDENTITY, 1e-12);
    optim_optimizer *by_newton = make(&anew, from, OPTIM_SCALING_IDENTITY, 1e-12);
    int steps = 0;
    while (chord_step(by_chord, &kept) == OPTIM_RUNNING && steps < 50) {
        steps++;
    }
    minimise(by_newton, &anew, 50);
    assert_true(steps >= 3 && kept.models < steps && kept.models < anew.models);
    for (int i = 0; i < 2; i++) {
        const double x = optim_x(by_chord)[i], y = optim_x(by_newton)[i];
        assert_true(fabs(x - y) < 1e-8);
    }
    optim_free(by_chord);
    optim_free(by_newton);
}

/* Where J is far from what it was the old one is given up, in the same step. */
static void test_chord_given_up(void **state)
{
    (void)state;
    fit p = {.f = rosenbrock, .rows = 2, .count = 2};
    optim_optimizer *gn = make(&p, (double[]){-1.2, 1}, OPTIM_SCALING_IDENTITY, 1e-3);
    for (int i = 0; i < 60 && chord_step(gn, &p) == OPTIM_RUNNING; i++) {
    }
    assert_true(fabs(optim_x(gn)[0] - 1) < 1e-6);
    assert_true(fabs(optim_x(gn)[1] - 1) < 1e-6);
    optim_free(gn);
}

/* From the state before any step, the next ones have the same bits: J is made anew where it was. */
static void test_chord_resumed(void **state)
{
    (void)state;
    enum { STEPS = 5, ARRAYS = 3 };
    const double from[2] = {40, -30};
    for (int at = 0; at < STEPS; at++) {
        fit p = {.f = bent, .rows = 12, .count = 2}, q = p;
        optim_optimizer *gn = make(&p, from, OPTIM_SCALING_IDENTITY, 1e-12);
        optim_optimizer *again = make(&q, (double[]){0, 0}, OPTIM_SCALING_IDENTITY, 1e-12);
        optim_array a[ARRAYS], b[ARRAYS];
        for (int i = 0; i < at; i++) {
            chord_step(gn, &p);
        }
        assert_int_equal(optim_state(gn, a), ARRAYS);
        assert_int_equal(optim_state(again, b), ARRAYS);
        for (int i = 0; i < ARRAYS; i++) {
            memcpy(b[i].data, a[i].data, a[i].count * sizeof(double));
        }
        assert_null(optim_state_check(again));
        for (int i = at; i < STEPS; i++) {
            assert_int_equal(chord_step(gn, &p), chord_step(again, &q));
            for (int k = 0; k < ARRAYS; k++) {
                assert_memory_equal(a[k].data, b[k].data, a[k].count * sizeof(double));
            }
        }
        optim_free(gn);
        optim_free(again);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_chord),          cmocka_unit_test(test_chord_given_up),
        cmocka_unit_test(test_chord_resumed),  cmocka_unit_test(test_linear),
        cmocka_unit_test(test_rosenbrock),     cmocka_unit_test(test_misra1a),
        cmocka_unit_test(test_rank_deficient), cmocka_unit_test(test_not_finite),
        cmocka_unit_test(test_endings),        cmocka_unit_test(test_resume),
        cmocka_unit_test(test_settings),       cmocka_unit_test(test_allocations),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
