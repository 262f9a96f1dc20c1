/* SOAP: Adam where there is no matrix, in the eigenvectors of a quadratic's Hessian where there is
 * one. */
#include "optim_testing.h"

#include "optim/optimizer.h"

enum { N = 4, COUNT = N * N + 1 };

/* |A W B|^2 / 2 + w^2 / 2 with A and B turned by 0.5 rad in planes of two, and stretched: no entry
 * of W is along an eigenvector. */
static void stretch(const double *sizes, double angle, double m[N][N])
{
    for (int i = 0; i < N; i += 2) {
        for (int k = 0; k < 2; k++) {
            const double c = cos(angle), s = sin(angle);
            m[i + k][i] = sizes[i + k] * (k ? -s : c);
            m[i + k][i + 1] = sizes[i + k] * (k ? c : s);
        }
    }
}

static double turned(size_t count, const double *x, double *gradient)
{
    static const double a_sizes[N] = {1, 0.03, 0.3, 0.01}, b_sizes[N] = {1, 0.1, 0.5, 0.02};
    double a[N][N] = {{0}}, b[N][N] = {{0}}, y[N][N] = {{0}}, value = 0;
    stretch(a_sizes, 0.5, a);
    stretch(b_sizes, -0.9, b);
    for (int i = 0; i < N * N * N * N; i++) {
        const int p = i / (N * N * N), q = i / (N * N) % N, j = i / N % N, k = i % N;
        y[p][q] += a[p][j] * x[j * N + k] * b[q][k];
    }
    memset(gradient, 0, count * sizeof *gradient);
    for (int p = 0; p < N; p++) {
        for (int q = 0; q < N; q++) {
            value += y[p][q] * y[p][q] / 2;
            for (int j = 0; j < N * N; j++) {
                gradient[j] += a[p][j / N] * y[p][q] * b[q][j % N];
            }
        }
    }
    gradient[count - 1] = x[count - 1];
    return value + x[count - 1] * x[count - 1] / 2;
}

static void begin(double *x)
{
    for (int i = 0; i < COUNT; i++) {
        x[i] = 1 + 0.3 * i * (i % 3 - 1);
    }
}

static optim_settings settings_of(optim_method method, int steps)
{
    static const optim_matrix whole = {0, N, N};
    optim_settings s = optim_settings_defaults(method);
    s.schedule = OPTIM_SCHEDULE_COSINE;
    s.learning_rate = 0.05;
    s.warmup_steps = 5;
    s.decay_steps = steps;
    s.final_fraction = 0;
    s.beta1 = s.beta2 = 0.95; /* of Adam, too */
    s.matrices = &whole;
    s.matrix_count = 1;
    return s;
}

static double run_for(const optim_settings *s, int steps, double *x)
{
    problem p = make_problem(turned, COUNT);
    const optim_target target = {objective, &p, NULL};
    double start[COUNT], gradient[COUNT];
    begin(start);
    optim_optimizer *o = optim_create(COUNT, start, s, NULL);
    assert_non_null(o);
    for (int i = 0; i < steps; i++) {
        assert_int_equal(optim_step(o, &target), OPTIM_RUNNING);
    }
    memcpy(x, optim_x(o), COUNT * sizeof *x);
    optim_free(o);
    return turned(COUNT, x, gradient);
}

/* After as many steps the value is a hundredth of Adam's: small eigenvalues of the Hessian are
 * products of small ones of both sides, which Adam's entries mix. */
static void test_faster(void **state)
{
    (void)state;
    enum { STEPS = 400 };
    double x[COUNT];
    const optim_settings soap = settings_of(OPTIM_SOAP, STEPS),
                         adam = settings_of(OPTIM_ADAM, STEPS);
    const double with = run_for(&soap, STEPS, x), without = run_for(&adam, STEPS, x);
    if (!(with < 1e-2 * without)) {
        fail_msg("SOAP %.3g, Adam %.3g", with, without);
    }
}

/* Without matrices it is Adam, one step later: the first gradient only makes bases. */
static void test_adam(void **state)
{
    (void)state;
    double x[COUNT], y[COUNT];
    optim_settings soap = settings_of(OPTIM_SOAP, 50), adam = settings_of(OPTIM_ADAM, 50);
    soap.matrix_count = 0;
    soap.schedule = adam.schedule = OPTIM_SCHEDULE_CONSTANT;
    soap.warmup_steps = adam.warmup_steps = 0;
    run_for(&soap, 21, x);
    run_for(&adam, 20, y);
    for (int i = 0; i < COUNT; i++) {
        assert_near(x[i], y[i], 1e-14);
    }
}

/* The same products by a function of the caller's. */
static void multiply(void *context, bool transpose_a, bool transpose_b, size_t m, size_t n,
                     size_t k, const double *a, const double *b, double beta, double *c)
{
    ++*(int *)context;
    for (size_t i = 0; i < m * n; i++) {
        double sum = 0;
        for (size_t l = 0; l < k; l++) {
            sum += a[transpose_a ? l * m + i / n : i / n * k + l] *
                   b[transpose_b ? i % n * k + l : l * n + i % n];
        }
        c[i] = sum + (beta != 0 ? beta * c[i] : 0);
    }
}

static void test_products(void **state)
{
    (void)state;
    int calls = 0;
    double x[COUNT], y[COUNT];
    optim_settings s = settings_of(OPTIM_SOAP, 40);
    run_for(&s, 40, x);
    s.multiply = multiply;
    s.context = &calls;
    run_for(&s, 40, y);
    assert_memory_equal(x, y, sizeof x);
    assert_true(calls > 40 * 6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faster),
        cmocka_unit_test(test_adam),
        cmocka_unit_test(test_products),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
