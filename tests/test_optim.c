/* Tests of optim/. Link with -Wl,--wrap=malloc,--wrap=calloc: allocation failures are injected. */
#include "../optim/optim.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- allocation hooks ---- */

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);

static long allocations;
static long failing_allocation; /* 1, 2, 3, ...; 0: none */

void *__wrap_malloc(size_t size)
{
    return ++allocations == failing_allocation ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return ++allocations == failing_allocation ? NULL : __real_calloc(count, size);
}

/* ---- objectives ---- */

enum { MAX_COUNT = 100 };

typedef double (*formula)(size_t count, const double *x, double *gradient);

/* An objective with a log of what it was asked, which can misbehave at chosen evaluations. */
typedef struct problem {
    formula f;
    size_t count;
    long evaluations;
    long misbehave_from; /* evaluation, counted from 1; 0: never */
    enum { STOP, CODE_NOT_FINITE, NAN_VALUE, NAN_GRADIENT, INF_VALUE, WRONG_GRADIENT } misbehaviour;
    double lowest;
    double lowest_x[MAX_COUNT];
} problem;

static problem make_problem(formula f, size_t count)
{
    return (problem){.f = f, .count = count, .lowest = INFINITY};
}

static int objective(void *context, const double *x, double *value, double *gradient)
{
    problem *p = context;
    const int misbehaves = ++p->evaluations >= p->misbehave_from && p->misbehave_from > 0;
    *value = p->f(p->count, x, gradient);
    if (!misbehaves || p->misbehaviour == WRONG_GRADIENT) {
        if (*value < p->lowest) {
            p->lowest = *value;
            memcpy(p->lowest_x, x, p->count * sizeof *x);
        }
        for (size_t i = 0; misbehaves && i < p->count; i++) {
            gradient[i] = -gradient[i];
        }
        return OPTIM_OBJECTIVE_OK;
    }
    if (p->misbehaviour == NAN_VALUE || p->misbehaviour == INF_VALUE) {
        *value = p->misbehaviour == NAN_VALUE ? (double)NAN : (double)INFINITY;
    } else if (p->misbehaviour == NAN_GRADIENT) {
        gradient[p->count - 1] = NAN;
    }
    return p->misbehaviour == STOP              ? OPTIM_OBJECTIVE_STOP
           : p->misbehaviour == CODE_NOT_FINITE ? OPTIM_OBJECTIVE_NOT_FINITE
                                                : OPTIM_OBJECTIVE_OK;
}

/* Eigenvalues spread evenly in the exponent from 1 to 1e6; minimiser x_i = sin(i + 1). */
static double eigenvalue(size_t count, size_t i)
{
    return pow(1e6, (double)i / (double)(count - 1));
}

static double diagonal_quadratic(size_t count, const double *x, double *gradient)
{
    double value = 0;
    for (size_t i = 0; i < count; i++) {
        const double r = x[i] - sin((double)i + 1);
        gradient[i] = eigenvalue(count, i) * r;
        value += 0.5 * r * gradient[i];
    }
    return value;
}

/* The same seen in axes turned by the reflection Q = I - 2 u u^T, u = (1, ..., 1) / sqrt(n). */
static double turned_quadratic(size_t count, const double *x, double *gradient)
{
    double mean = 0, value = 0;
    for (size_t i = 0; i < count; i++) {
        mean += (x[i] - sin((double)i + 1)) / (double)count;
    }
    double mean_gradient = 0;
    for (size_t i = 0; i < count; i++) {
        const double r = x[i] - sin((double)i + 1) - 2 * mean;
        gradient[i] = eigenvalue(count, i) * r;
        value += 0.5 * r * gradient[i];
        mean_gradient += gradient[i] / (double)count;
    }
    for (size_t i = 0; i < count; i++) {
        gradient[i] -= 2 * mean_gradient;
    }
    return value;
}

/* Extended Rosenbrock function, More, Garbow & Hillstrom 1981, no. 21; minimum 0 at (1, ..., 1). */
static double rosenbrock(size_t count, const double *x, double *gradient)
{
    double value = 0;
    for (size_t i = 0; i + 1 < count; i += 2) {
        const double a = x[i + 1] - x[i] * x[i], b = 1 - x[i];
        value += 100 * a * a + b * b;
        gradient[i] = -400 * a * x[i] - 2 * b;
        gradient[i + 1] = 200 * a;
    }
    return value;
}

/* Chained Rosenbrock function: every variable is tied to the next. */
static double chained_rosenbrock(size_t count, const double *x, double *gradient)
{
    double value = 0;
    memset(gradient, 0, count * sizeof *gradient);
    for (size_t i = 0; i + 1 < count; i++) {
        const double a = x[i + 1] - x[i] * x[i], b = 1 - x[i];
        value += 100 * a * a + b * b;
        gradient[i] += -400 * a * x[i] - 2 * b;
        gradient[i + 1] += 200 * a;
    }
    return value;
}

/* NaN wherever some x_i < 0; minimum n at (1, ..., 1). */
static double barrier(size_t count, const double *x, double *gradient)
{
    double value = 0;
    for (size_t i = 0; i < count; i++) {
        value += x[i] - log(x[i]);
        gradient[i] = 1 - 1 / x[i];
    }
    return value;
}

static double falling_line(size_t count, const double *x, double *gradient)
{
    double value = 0;
    for (size_t i = 0; i < count; i++) {
        value -= x[i];
        gradient[i] = -1;
    }
    return value;
}

static double falling_exponential(size_t count, const double *x, double *gradient)
{
    (void)count;
    gradient[0] = -exp(x[0]);
    return gradient[0];
}

static double hyperbolic_cosine(size_t count, const double *x, double *gradient)
{
    (void)count;
    gradient[0] = sinh(x[0] - 3);
    return cosh(x[0] - 3);
}

/* f(0) = 0, f'(0) = -1, f(1) = -1e-5, f'(1) = 0.5: x = 1 is lower and flatter, but not by enough.
 */
static double shallow_cubic(size_t count, const double *x, double *gradient)
{
    (void)count;
    const double a = 1.49997, b = -0.49998;
    gradient[0] = -1 + x[0] * (2 * a + 3 * b * x[0]);
    return x[0] * (-1 + x[0] * (a + b * x[0]));
}

/* Gradients of the hand-computed Adam steps, chosen by where the first step has led. */
static double two_gradients(size_t count, const double *x, double *gradient)
{
    static const double table[2][3] = {{1, -2, 0.5}, {3, 1, -0.5}};
    memcpy(gradient, table[x[0] != 0], count * sizeof *gradient);
    return 0;
}

static void classic_start(size_t count, double *x)
{
    for (size_t i = 0; i < count; i++) {
        x[i] = i % 2 ? 1 : -1.2;
    }
}

static double dot(size_t count, const double *a, const double *b)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

static double distance(size_t count, const double *a, const double *b)
{
    double largest = 0;
    for (size_t i = 0; i < count; i++) {
        largest = fmax(largest, fabs(a[i] - b[i]));
    }
    return largest;
}

static void assert_near(double got, double wanted, double tolerance)
{
    if (!(fabs(got - wanted) <= tolerance)) {
        fail_msg("got %.17g, wanted %.17g within %g", got, wanted, tolerance);
    }
}

static void assert_below(double got, double bound)
{
    if (!(got < bound)) {
        fail_msg("got %.17g, wanted less than %g", got, bound);
    }
}

static optim_status run(optim_lbfgs *lbfgs, problem *p, int steps)
{
    optim_status status = OPTIM_RUNNING;
    for (int i = 0; i < steps && status == OPTIM_RUNNING; i++) {
        status = optim_lbfgs_step(lbfgs, objective, p);
    }
    return status;
}

static optim_lbfgs *make_lbfgs(size_t count, const double *x, int memory)
{
    optim_lbfgs_settings settings = optim_lbfgs_defaults();
    settings.memory = memory;
    optim_lbfgs *lbfgs = optim_lbfgs_create(count, x, &settings, NULL);
    assert_non_null(lbfgs);
    return lbfgs;
}

/* Value and gradient of the state have to be those of the objective at the current point. */
static void assert_consistent(optim_lbfgs *lbfgs, const problem *p)
{
    double gradient[MAX_COUNT];
    optim_array arrays[OPTIM_STATE_CAPACITY];
    const double value = p->f(p->count, optim_lbfgs_x(lbfgs), gradient);
    const double stated = optim_lbfgs_get_info(lbfgs).value;
    assert_memory_equal(&value, &stated, sizeof value);
    optim_lbfgs_state(lbfgs, arrays, OPTIM_STATE_CAPACITY);
    assert_string_equal(arrays[1].name, "gradient");
    assert_memory_equal(arrays[1].data, gradient, p->count * sizeof *gradient);
}

/* ---- schedules, texts, settings ---- */

static void test_schedules(void **state)
{
    (void)state;
    const double pi = 3.14159265358979323846, rounding = 1e-15; /* a few ulp of rates below 2 */
    optim_schedule s = optim_schedule_defaults();
    s.learning_rate = 2;
    assert_near(optim_schedule_rate(&s, 0), 2, 0);
    assert_near(optim_schedule_rate(&s, 1000000), 2, 0);
    s.warmup_steps = 4;
    s.decay_steps = 100;
    for (int kind = 0; kind < OPTIM_SCHEDULE_COUNT; kind++) {
        s.kind = (optim_schedule_kind)kind;
        for (int step = 0; step <= 4; step++) { /* full rate exactly at the end of the warm-up */
            assert_near(optim_schedule_rate(&s, step), 2 * (step + 1) / 5.0, rounding);
        }
        assert_int_equal(optim_schedule_kind_of(optim_schedule_kind_name(s.kind)), kind);
    }
    assert_int_equal(optim_schedule_kind_of("linear"), OPTIM_SCHEDULE_COUNT);
    s.kind = OPTIM_SCHEDULE_COSINE;
    s.final_fraction = 0.1;
    assert_near(optim_schedule_rate(&s, 4 + 50), 2 * 0.55, rounding);
    assert_near(optim_schedule_rate(&s, 4 + 25), 2 * (0.1 + 0.45 * (1 + cos(pi / 4))), rounding);
    assert_near(optim_schedule_rate(&s, 4 + 100), 0.2, rounding);
    assert_near(optim_schedule_rate(&s, INT64_MAX), 0.2, rounding);
    s.kind = OPTIM_SCHEDULE_EXPONENTIAL;
    s.decay_factor = 0.25;
    assert_near(optim_schedule_rate(&s, 4 + 50), 1, rounding);
    assert_near(optim_schedule_rate(&s, 4 + 300), 2 * 0.015625, rounding);
}

static void test_status_texts(void **state)
{
    (void)state;
    for (int i = 0; i < OPTIM_STATUS_COUNT; i++) {
        const char *text = optim_status_text((optim_status)i);
        assert_int_equal(text[strlen(text) - 1], '.');
        for (int j = 0; j < i; j++) {
            assert_string_not_equal(optim_status_name((optim_status)i),
                                    optim_status_name((optim_status)j));
        }
    }
    assert_string_equal(optim_status_name(OPTIM_STATUS_COUNT), "unknown status");
}

/* Puts each bad number into the field; the check has to name it, and to pass afterwards. */
#define ASSERT_NAMED(check, settings, field, name, ...)                                            \
    do {                                                                                           \
        const double bad[] = {__VA_ARGS__};                                                        \
        for (size_t i_ = 0; i_ < sizeof bad / sizeof bad[0]; i_++) {                               \
            const __typeof__(settings) good_ = settings;                                           \
            settings.field = (__typeof__(settings.field))bad[i_];                                  \
            const char *problem_ = check(&settings);                                               \
            assert_non_null(problem_);                                                             \
            assert_int_equal(strncmp(problem_, name " must", strlen(name " must")), 0);            \
            settings = good_;                                                                      \
        }                                                                                          \
        assert_null(check(&settings));                                                             \
    } while (0)

static void test_validators(void **state)
{
    (void)state;
    optim_adam_settings a = optim_adam_defaults();
    ASSERT_NAMED(optim_adam_check, a, beta1, "beta1", -0.1, 1, NAN);
    ASSERT_NAMED(optim_adam_check, a, beta2, "beta2", -0.1, 1, NAN);
    ASSERT_NAMED(optim_adam_check, a, epsilon, "epsilon", 0, -1, INFINITY, NAN);
    ASSERT_NAMED(optim_adam_check, a, clip_norm, "clip_norm", -1, INFINITY, NAN);
    ASSERT_NAMED(optim_adam_check, a, gradient_tolerance, "gradient_tolerance", -1, INFINITY, NAN);
    ASSERT_NAMED(optim_adam_check, a, schedule.kind, "schedule kind", OPTIM_SCHEDULE_COUNT, 77);
    ASSERT_NAMED(optim_adam_check, a, schedule.learning_rate, "learning_rate", 0, -1, INFINITY,
                 NAN);
    ASSERT_NAMED(optim_adam_check, a, schedule.warmup_steps, "warmup_steps", -1);
    ASSERT_NAMED(optim_adam_check, a, schedule.decay_steps, "decay_steps", 0, -5);
    ASSERT_NAMED(optim_adam_check, a, schedule.final_fraction, "final_fraction", -0.1, 1.1, NAN);
    ASSERT_NAMED(optim_adam_check, a, schedule.decay_factor, "decay_factor", 0, 1.1, NAN);
    optim_lbfgs_settings l = optim_lbfgs_defaults();
    ASSERT_NAMED(optim_lbfgs_check, l, memory, "memory", 0, -1, 1001);
    ASSERT_NAMED(optim_lbfgs_check, l, sufficient_decrease, "sufficient_decrease", 0, 0.5, NAN);
    ASSERT_NAMED(optim_lbfgs_check, l, curvature, "curvature", 1e-4, 1, NAN);
    ASSERT_NAMED(optim_lbfgs_check, l, maximum_line_evaluations, "maximum_line_evaluations", 1,
                 1001);
    ASSERT_NAMED(optim_lbfgs_check, l, maximum_step, "maximum_step", 0, -1, INFINITY, NAN);
    ASSERT_NAMED(optim_lbfgs_check, l, gradient_tolerance, "gradient_tolerance", -1, INFINITY, NAN);
    ASSERT_NAMED(optim_lbfgs_check, l, function_tolerance, "function_tolerance", -1, 1, NAN);
    ASSERT_NAMED(optim_lbfgs_check, l, step_tolerance, "step_tolerance", -1, 1, NAN);
    ASSERT_NAMED(optim_lbfgs_check, l, curvature_threshold, "curvature_threshold", -1, 1, NAN);
}

static void test_create_refuses(void **state)
{
    (void)state;
    const double bad_x[2] = {0, NAN}, x[2] = {0, 0};
    const char *why = NULL;
    optim_adam_settings a = optim_adam_defaults();
    optim_lbfgs_settings l = optim_lbfgs_defaults();
    assert_null(optim_adam_create(2, bad_x, &a, &why));
    assert_non_null(strstr(why, "finite"));
    assert_null(optim_lbfgs_create(2, bad_x, &l, &why));
    assert_non_null(strstr(why, "finite"));
    assert_null(optim_adam_create(0, x, &a, &why));
    assert_non_null(strstr(why, "count"));
    assert_null(optim_lbfgs_create(0, x, &l, &why));
    assert_non_null(strstr(why, "count"));
    a.beta1 = 2;
    l.memory = 0;
    assert_null(optim_adam_create(2, x, &a, &why));
    assert_non_null(strstr(why, "beta1"));
    assert_null(optim_lbfgs_create(2, x, &l, NULL));
    optim_adam_free(NULL);
    optim_lbfgs_free(NULL);
}

/* Every allocation of create fails once: no crash, no leak (run under ASan), and a reason. Steps
 * allocate nothing. */
static void test_allocation(void **state)
{
    (void)state;
    const optim_adam_settings a = optim_adam_defaults();
    const optim_lbfgs_settings l = optim_lbfgs_defaults();
    double x[10];
    classic_start(10, x);
    for (int kind = 0; kind < 2; kind++) {
        problem p = make_problem(rosenbrock, 10);
        optim_adam *adam = NULL;
        optim_lbfgs *lbfgs = NULL;
        long n = 0;
        while (!adam && !lbfgs) {
            const char *why = NULL;
            allocations = 0;
            failing_allocation = ++n;
            adam = kind ? NULL : optim_adam_create(10, x, &a, &why);
            lbfgs = kind ? optim_lbfgs_create(10, x, &l, &why) : NULL;
            failing_allocation = 0;
            assert_true(adam || lbfgs || (why && strcmp(why, "out of memory") == 0));
        }
        assert_true(n > 6); /* the hook is linked in */
        allocations = 0;
        for (int i = 0; i < 20; i++) {
            assert_int_equal(adam ? optim_adam_step(adam, objective, &p)
                                  : optim_lbfgs_step(lbfgs, objective, &p),
                             OPTIM_RUNNING);
        }
        assert_int_equal(allocations, 0);
        optim_adam_free(adam);
        optim_lbfgs_free(lbfgs);
    }
}

/* ---- Adam ---- */

/* Two steps from x = 0 with rate 0.1, beta 0.9 and 0.999, epsilon 1e-8 and the gradients of
 * two_gradients; wanted numbers from algorithm 1 in 40-digit decimal arithmetic. */
static void test_adam_by_hand(void **state)
{
    (void)state;
    static const double wanted[2][3] = {
        {-0.099999999000000010, 0.099999999500000003, -0.099999998000000040},
        {-0.19177811048766837, 0.12663370329756864, -0.094736840210526354}};
    const double x[3] = {0, 0, 0};
    problem p = make_problem(two_gradients, 3);
    optim_adam_settings settings = optim_adam_defaults();
    settings.schedule.learning_rate = 0.1;
    optim_adam *adam = optim_adam_create(3, x, &settings, NULL);
    for (int step = 0; step < 2; step++) {
        assert_int_equal(optim_adam_step(adam, objective, &p), OPTIM_RUNNING);
        for (int i = 0; i < 3; i++) { /* 1 - 0.999 loses 3 digits of the 16 */
            assert_near(optim_adam_x(adam)[i], wanted[step][i], 1e-13);
        }
    }
    const optim_adam_info info = optim_adam_get_info(adam);
    assert_int_equal(info.steps, 2);
    assert_near(info.gradient_norm, sqrt(10.25), 1e-15);
    optim_adam_free(adam);
}

/* With both betas 0 a step is rate * g / (|g| + epsilon), so a large epsilon shows the clipping:
 * the gradient (3, 4), of norm 5, has to arrive as (0.6, 0.8). */
static void test_adam_clipping(void **state)
{
    (void)state;
    optim_adam_settings settings = optim_adam_defaults();
    settings.beta1 = settings.beta2 = 0;
    settings.epsilon = 1;
    settings.clip_norm = 1;
    settings.schedule.learning_rate = 1;
    problem p = make_problem(diagonal_quadratic, 2);
    const double at[2] = {sin(1) + 3, sin(2) + 4e-6};
    optim_adam *adam = optim_adam_create(2, at, &settings, NULL);
    assert_int_equal(optim_adam_step(adam, objective, &p), OPTIM_RUNNING);
    /* 1e6 * rounding of sin(2) + 4e-6 is 1e-10. */
    assert_near(optim_adam_x(adam)[0], at[0] - 0.6 / 1.6, 1e-9);
    assert_near(optim_adam_x(adam)[1], at[1] - 0.8 / 1.8, 1e-9);
    optim_adam_free(adam);
}

/* Condition 1e6 along the axes: Adam scales each axis by itself. */
static void test_adam_quadratic(void **state)
{
    (void)state;
    enum { COUNT = 20 };
    double x[COUNT] = {0}, minimiser[COUNT];
    for (int i = 0; i < COUNT; i++) {
        minimiser[i] = sin(i + 1.0);
    }
    optim_adam_settings settings = optim_adam_defaults();
    settings.schedule = (optim_schedule){OPTIM_SCHEDULE_EXPONENTIAL, 0.05, 10, 1000, 0, 0.05};
    problem p = make_problem(diagonal_quadratic, COUNT);
    optim_adam *adam = optim_adam_create(COUNT, x, &settings, NULL);
    for (int step = 0; step < 6000; step++) {
        assert_int_equal(optim_adam_step(adam, objective, &p), OPTIM_RUNNING);
    }
    /* Adam stays within about one step of the minimum, and the last rate is 0.05^7 = 8e-10. */
    assert_below(distance(COUNT, optim_adam_x(adam), minimiser), 1e-8);
    optim_adam_free(adam);
}

static void test_adam_best(void **state)
{
    (void)state;
    double x[4];
    classic_start(4, x);
    optim_adam_settings settings = optim_adam_defaults();
    settings.schedule.learning_rate = 0.5; /* far too large: the value goes up and down */
    problem p = make_problem(rosenbrock, 4);
    optim_adam *adam = optim_adam_create(4, x, &settings, NULL);
    int above = 0;
    for (int step = 0; step < 200; step++) {
        assert_int_equal(optim_adam_step(adam, objective, &p), OPTIM_RUNNING);
        above += optim_adam_get_info(adam).value > p.lowest;
        assert_true(optim_adam_get_info(adam).best_value == p.lowest);
        assert_memory_equal(optim_adam_best_x(adam), p.lowest_x, sizeof x);
    }
    assert_true(above > 20); /* so that best and current did differ */
    optim_adam_objective_changed(adam);
    assert_true(optim_adam_get_info(adam).best_value == INFINITY);
    optim_adam_free(adam);
}

static void test_adam_endings(void **state)
{
    (void)state;
    static const optim_status wanted[] = {
        [STOP] = OPTIM_STOPPED_BY_OBJECTIVE, [CODE_NOT_FINITE] = OPTIM_NOT_FINITE,
        [NAN_VALUE] = OPTIM_NOT_FINITE,      [NAN_GRADIENT] = OPTIM_NOT_FINITE,
        [INF_VALUE] = OPTIM_NOT_FINITE,
    };
    const optim_adam_settings settings = optim_adam_defaults();
    double x[2];
    classic_start(2, x);
    for (int how = STOP; how <= INF_VALUE; how++) {
        problem p = make_problem(rosenbrock, 2);
        p.misbehave_from = 4;
        p.misbehaviour = how;
        optim_adam *adam = optim_adam_create(2, x, &settings, NULL);
        for (int step = 0; step < 3; step++) {
            assert_int_equal(optim_adam_step(adam, objective, &p), OPTIM_RUNNING);
        }
        const double before[2] = {optim_adam_x(adam)[0], optim_adam_x(adam)[1]};
        assert_int_equal(optim_adam_step(adam, objective, &p), wanted[how]);
        assert_memory_equal(optim_adam_x(adam), before, sizeof before);
        assert_int_equal(optim_adam_get_info(adam).steps, 3);
        assert_int_equal(optim_adam_get_info(adam).evaluations, 4);
        optim_adam_free(adam);
    }
    const double minimum[2] = {1, 1};
    problem p = make_problem(rosenbrock, 2);
    optim_adam *adam = optim_adam_create(2, minimum, &settings, NULL);
    assert_int_equal(optim_adam_step(adam, objective, &p), OPTIM_GRADIENT_TOLERANCE);
    optim_adam_free(adam);
    optim_adam_settings huge = settings; /* the next point overflows */
    huge.schedule.learning_rate = 1e308;
    adam = optim_adam_create(2, (double[2]){1e308, 0}, &huge, NULL);
    problem line = make_problem(falling_line, 2);
    assert_int_equal(optim_adam_step(adam, objective, &line), OPTIM_NOT_FINITE);
    assert_true(optim_adam_x(adam)[0] == 1e308);
    optim_adam_free(adam);
}

/* ---- L-BFGS ---- */

/* Runs to the end; every step has to satisfy the strong Wolfe conditions, N&W (3.7), computed here
 * from the points alone, and the bookkeeping has to hold. Returns the evaluations spent. */
static long check_every_step(formula f, size_t count, const double *x, int memory, double *result)
{
    problem p = make_problem(f, count);
    double before[MAX_COUNT], g0[MAX_COUNT], g1[MAX_COUNT], s[MAX_COUNT];
    optim_lbfgs *lbfgs = make_lbfgs(count, x, memory);
    optim_status status = OPTIM_RUNNING;
    for (int step = 1; step <= 2000 && status == OPTIM_RUNNING; step++) {
        memcpy(before, optim_lbfgs_x(lbfgs), count * sizeof *before);
        status = optim_lbfgs_step(lbfgs, objective, &p);
        const double f0 = f(count, before, g0), f1 = f(count, optim_lbfgs_x(lbfgs), g1);
        assert_consistent(lbfgs, &p);
        assert_true(optim_lbfgs_get_info(lbfgs).best_value == p.lowest);
        assert_memory_equal(optim_lbfgs_best_x(lbfgs), p.lowest_x, count * sizeof *x);
        if (status == OPTIM_GRADIENT_TOLERANCE) {
            break; /* steps as small as rounding, too short to check */
        }
        assert_int_equal(optim_lbfgs_get_info(lbfgs).iterations, step);
        for (size_t i = 0; i < count; i++) {
            s[i] = optim_lbfgs_x(lbfgs)[i] - before[i];
        }
        /* x1 - x0 carries a rounding of 1e-16 |x|, and the slopes that times |g|. */
        const double slope = dot(count, g0, s);
        const double rounding = 1e-15 * (sqrt(dot(count, g0, g0)) + sqrt(dot(count, g1, g1))) *
                                (1 + sqrt(dot(count, before, before)));
        assert_true(f1 <= f0 + 1e-4 * slope + 1e-4 * rounding);
        assert_true(fabs(dot(count, g1, s)) <= 0.9 * fabs(slope) + rounding);
    }
    assert_int_equal(status, OPTIM_GRADIENT_TOLERANCE);
    memcpy(result, optim_lbfgs_best_x(lbfgs), count * sizeof *result);
    const optim_lbfgs_info info = optim_lbfgs_get_info(lbfgs);
    assert_int_equal(info.evaluations, p.evaluations);
    assert_int_equal(info.resets, 0);
    assert_true(info.best_value == p.lowest);
    optim_lbfgs_free(lbfgs);
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
    optim_lbfgs *lbfgs = make_lbfgs(100, x, 50);
    while (optim_lbfgs_get_info(lbfgs).best_value >= 1e-12 && p.evaluations < 650) {
        assert_int_equal(optim_lbfgs_step(lbfgs, objective, &p), OPTIM_RUNNING);
    }
    assert_below(chained_rosenbrock(100, optim_lbfgs_best_x(lbfgs), g), 1e-12);
    optim_lbfgs_free(lbfgs);
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
    optim_lbfgs_settings settings = optim_lbfgs_defaults();
    settings.memory = 400;
    settings.gradient_tolerance = 1e-9;
    problem p = make_problem(turned_quadratic, 50);
    optim_lbfgs *lbfgs = optim_lbfgs_create(50, x, &settings, NULL);
    assert_int_equal(run(lbfgs, &p, 400), OPTIM_GRADIENT_TOLERANCE);
    assert_below(distance(50, optim_lbfgs_x(lbfgs), minimiser), 1e-8); /* sqrt(50) * 1e-9 */
    optim_lbfgs_free(lbfgs);
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
    optim_lbfgs *lbfgs = make_lbfgs(N, x, MEMORY);
    optim_array a[OPTIM_STATE_CAPACITY];
    optim_lbfgs_state(lbfgs, a, OPTIM_STATE_CAPACITY);
    run(lbfgs, &p, 1);
    for (int iteration = 1; iteration < 12; iteration++) {
        assert_int_equal(optim_lbfgs_get_info(lbfgs).skipped, 0);
        const int pairs = iteration < MEMORY ? iteration : MEMORY;
        assert_int_equal(optim_lbfgs_get_info(lbfgs).pairs, pairs);
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
        assert_int_equal(optim_lbfgs_step(lbfgs, objective, &p), OPTIM_RUNNING);
        for (int i = 0; i < N; i++) { /* matrices of condition 1e3 to 1e4 cost 4 of 16 digits */
            const double taken = (a[0].data[i] - before[i]) / optim_lbfgs_get_info(lbfgs).step;
            assert_near(taken, d[i], 1e-10 * sqrt(dot(N, d, d)) + 1e-13);
        }
    }
    optim_lbfgs_free(lbfgs);
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
    optim_lbfgs *lbfgs = make_lbfgs(1, (double[1]){50}, 10);
    assert_int_equal(run(lbfgs, &p, 1), OPTIM_RUNNING);
    assert_int_equal(p.evaluations, 2); /* the slope falls to 1 / e of what it was: accepted */
    assert_near(optim_lbfgs_x(lbfgs)[0], 49, 1e-14);
    optim_lbfgs_free(lbfgs);
    problem q = make_problem(shallow_cubic, 1);
    lbfgs = make_lbfgs(1, (double[1]){0}, 10);
    /* x = 1 is refused, -1e-5 > -c1; the cubic interpolation then is the function itself. */
    assert_int_equal(run(lbfgs, &q, 1), OPTIM_GRADIENT_TOLERANCE);
    assert_int_equal(q.evaluations, 3);
    optim_lbfgs_free(lbfgs);
}

static void test_lbfgs_starts_at_minimum(void **state)
{
    (void)state;
    const double x[2] = {1, 1};
    problem p = make_problem(rosenbrock, 2);
    optim_lbfgs *lbfgs = make_lbfgs(2, x, 10);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(optim_lbfgs_step(lbfgs, objective, &p), OPTIM_GRADIENT_TOLERANCE);
        assert_int_equal(optim_lbfgs_get_info(lbfgs).evaluations, 1);
        assert_memory_equal(optim_lbfgs_x(lbfgs), x, sizeof x);
    }
    optim_lbfgs_free(lbfgs);
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
        optim_lbfgs *lbfgs = make_lbfgs(10, x, 10);
        const optim_status status = run(lbfgs, &p, 200);
        assert_true(status == OPTIM_GRADIENT_TOLERANCE || status == OPTIM_FUNCTION_TOLERANCE ||
                    status == OPTIM_LINE_SEARCH_FAILED); /* rounding of the value 10 */
        for (int i = 0; i < 10; i++) { /* flat to rounding of the value: sqrt(10 * 2e-16) */
            assert_near(optim_lbfgs_x(lbfgs)[i], 1, 1e-7);
        }
        assert_consistent(lbfgs, &p);
        optim_lbfgs_free(lbfgs);
    }
}

static void test_lbfgs_unbounded(void **state)
{
    (void)state;
    problem p = make_problem(falling_line, 3);
    optim_lbfgs *lbfgs = make_lbfgs(3, (double[3]){0, 0, 0}, 10);
    assert_int_equal(run(lbfgs, &p, 100), OPTIM_UNBOUNDED);
    const double *x = optim_lbfgs_x(lbfgs);
    assert_near(sqrt(dot(3, x, x)), 1e10, 1); /* maximum_step */
    assert_consistent(lbfgs, &p);
    optim_lbfgs_free(lbfgs);
    /* The second trial is the last finite one: its decrease is kept, with its gradient. */
    problem r = make_problem(falling_line, 3);
    r.misbehave_from = 4;
    r.misbehaviour = NAN_GRADIENT;
    lbfgs = make_lbfgs(3, (double[3]){0, 0, 0}, 10);
    assert_int_equal(run(lbfgs, &r, 100), OPTIM_NO_FINITE_STEP);
    assert_true(optim_lbfgs_get_info(lbfgs).value == r.lowest && r.lowest < -1);
    assert_consistent(lbfgs, &r);
    optim_lbfgs_free(lbfgs);
    /* Overflows before it gets that far. */
    problem q = make_problem(falling_exponential, 1);
    lbfgs = make_lbfgs(1, (double[1]){0}, 10);
    assert_int_equal(run(lbfgs, &q, 100), OPTIM_LINE_SEARCH_FAILED);
    assert_true(isfinite(optim_lbfgs_x(lbfgs)[0]) && optim_lbfgs_get_info(lbfgs).value < -1e100);
    assert_consistent(lbfgs, &q);
    optim_lbfgs_free(lbfgs);
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
            optim_lbfgs *lbfgs = make_lbfgs(10, x, 5);
            const optim_status status = run(lbfgs, &p, 100);
            const optim_lbfgs_info info = optim_lbfgs_get_info(lbfgs);
            if (how == STOP) {
                assert_int_equal(status, OPTIM_STOPPED_BY_OBJECTIVE);
            } else if (how == WRONG_GRADIENT) {
                assert_int_equal(status, OPTIM_LINE_SEARCH_FAILED);
                assert_true(info.resets >= 1);
            } else if (from == 1) {
                assert_int_equal(status, OPTIM_NOT_FINITE);
            } else {
                /* Only the very first line search may have seen a finite trial before. */
                const int any_finite = info.iterations == 0 && from > 2;
                assert_true(status == OPTIM_NO_FINITE_STEP ||
                            (any_finite && status == OPTIM_LINE_SEARCH_FAILED));
                assert_int_equal(info.resets, info.iterations > 0);
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
            optim_lbfgs_free(lbfgs);
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
        optim_lbfgs_settings settings = optim_lbfgs_defaults();
        settings.gradient_tolerance = kind == 0 ? 1e-3 : 0;
        settings.function_tolerance = kind == 1 ? 1e-2 : 0;
        settings.step_tolerance = kind == 2 ? 1e-3 : 0;
        problem p = make_problem(rosenbrock, 10);
        optim_lbfgs *lbfgs = optim_lbfgs_create(10, x, &settings, NULL);
        assert_int_equal(run(lbfgs, &p, 100), wanted[kind]);
        if (kind == 0) {
            assert_true(optim_lbfgs_get_info(lbfgs).gradient_max <= 1e-3);
        }
        optim_lbfgs_free(lbfgs);
    }
}

/* A threshold that nearly every pair misses: pairs are dropped, and the run still descends. */
static void test_lbfgs_skips(void **state)
{
    (void)state;
    double x[10];
    classic_start(10, x);
    optim_lbfgs_settings settings = optim_lbfgs_defaults();
    settings.curvature_threshold = 0.9;
    problem p = make_problem(rosenbrock, 10);
    optim_lbfgs *lbfgs = optim_lbfgs_create(10, x, &settings, NULL);
    for (int i = 0; i < 50; i++) {
        const double before = optim_lbfgs_get_info(lbfgs).value;
        assert_int_equal(optim_lbfgs_step(lbfgs, objective, &p), OPTIM_RUNNING);
        assert_true(optim_lbfgs_get_info(lbfgs).value < before);
        const optim_lbfgs_info info = optim_lbfgs_get_info(lbfgs);
        assert_int_equal(info.pairs + info.skipped, info.iterations);
    }
    assert_true(optim_lbfgs_get_info(lbfgs).skipped > 10);
    optim_lbfgs_free(lbfgs);
}

/* After a change of the objective the run is that of a new optimiser at the same point. */
static void test_lbfgs_objective_changed(void **state)
{
    (void)state;
    double x[10];
    classic_start(10, x);
    problem first = make_problem(rosenbrock, 10);
    problem second = make_problem(chained_rosenbrock, 10);
    optim_lbfgs *lbfgs = make_lbfgs(10, x, 5);
    assert_int_equal(run(lbfgs, &first, 12), OPTIM_RUNNING);
    optim_lbfgs_objective_changed(lbfgs);
    assert_int_equal(optim_lbfgs_get_info(lbfgs).pairs, 0);
    optim_lbfgs *fresh = make_lbfgs(10, optim_lbfgs_x(lbfgs), 5);
    for (int i = 0; i < 20; i++) {
        assert_int_equal(run(lbfgs, &second, 1), run(fresh, &second, 1));
        assert_memory_equal(optim_lbfgs_x(lbfgs), optim_lbfgs_x(fresh), sizeof x);
        assert_true(optim_lbfgs_get_info(lbfgs).best_value ==
                    optim_lbfgs_get_info(fresh).best_value);
    }
    optim_lbfgs_free(lbfgs);
    optim_lbfgs_free(fresh);
}

/* ---- state ---- */

static void copy_state(const optim_array *to, const optim_array *from, int count, int other_count)
{
    assert_int_equal(count, other_count);
    assert_true(count <= OPTIM_STATE_CAPACITY);
    for (int i = 0; i < count; i++) {
        assert_string_equal(to[i].name, from[i].name);
        assert_int_equal(to[i].count, from[i].count);
        memcpy(to[i].data, from[i].data, to[i].count * sizeof(double));
    }
}

static void assert_same_state(const optim_array *a, const optim_array *b, int count)
{
    for (int i = 0; i < count; i++) {
        assert_memory_equal(a[i].data, b[i].data, a[i].count * sizeof(double));
    }
}

/* Saved after so many steps: before the first, with the ring of 7 part full, full, wrapped. */
static const int save_after[] = {0, 1, 2, 6, 7, 8, 13, 14, 15, 40};

static void test_resume_adam(void **state)
{
    (void)state;
    double x[20], zero[20] = {0};
    classic_start(20, x);
    optim_adam_settings settings = optim_adam_defaults();
    settings.schedule = (optim_schedule){OPTIM_SCHEDULE_COSINE, 0.02, 5, 60, 0.1, 1};
    settings.clip_norm = 10;
    for (size_t k = 0; k < sizeof save_after / sizeof save_after[0]; k++) {
        problem p = make_problem(chained_rosenbrock, 20);
        optim_array a[OPTIM_STATE_CAPACITY], b[OPTIM_STATE_CAPACITY];
        optim_adam *one = optim_adam_create(20, x, &settings, NULL);
        optim_adam *two = optim_adam_create(20, zero, &settings, NULL);
        for (int i = 0; i < save_after[k]; i++) {
            optim_adam_step(one, objective, &p);
        }
        const int count = optim_adam_state(one, a, OPTIM_STATE_CAPACITY);
        copy_state(b, a, optim_adam_state(two, b, OPTIM_STATE_CAPACITY), count);
        assert_null(optim_adam_state_check(two));
        for (int i = 0; i < 50; i++) {
            assert_int_equal(optim_adam_step(one, objective, &p), OPTIM_RUNNING);
            assert_int_equal(optim_adam_step(two, objective, &p), OPTIM_RUNNING);
            assert_same_state(a, b, count);
        }
        optim_adam_free(one);
        optim_adam_free(two);
    }
}

static void test_resume_lbfgs(void **state)
{
    (void)state;
    double x[20], zero[20] = {0};
    classic_start(20, x);
    for (size_t k = 0; k < sizeof save_after / sizeof save_after[0]; k++) {
        problem p = make_problem(chained_rosenbrock, 20);
        optim_array a[OPTIM_STATE_CAPACITY], b[OPTIM_STATE_CAPACITY];
        optim_lbfgs *one = make_lbfgs(20, x, 7);
        optim_lbfgs *two = make_lbfgs(20, zero, 7);
        run(one, &p, save_after[k]);
        const int count = optim_lbfgs_state(one, a, OPTIM_STATE_CAPACITY);
        copy_state(b, a, optim_lbfgs_state(two, b, OPTIM_STATE_CAPACITY), count);
        assert_null(optim_lbfgs_state_check(two));
        for (int i = 0; i < 50; i++) {
            assert_int_equal(run(one, &p, 1), OPTIM_RUNNING);
            assert_int_equal(run(two, &p, 1), OPTIM_RUNNING);
            assert_same_state(a, b, count);
        }
        optim_lbfgs_free(one);
        optim_lbfgs_free(two);
    }
}

/* NaN in any one number of a restored state is found; a scalar that could lead out of bounds also
 * stops the step. */
static void test_bad_state(void **state)
{
    (void)state;
    double x[4];
    classic_start(4, x);
    problem p = make_problem(rosenbrock, 4);
    optim_array a[OPTIM_STATE_CAPACITY];
    optim_lbfgs *lbfgs = make_lbfgs(4, x, 3);
    run(lbfgs, &p, 5);
    const int count = optim_lbfgs_state(lbfgs, a, OPTIM_STATE_CAPACITY);
    assert_int_equal(optim_lbfgs_state(lbfgs, a, 2), count);
    for (int i = 0; i < count - 1; i++) {
        const double good = a[i].data[0];
        a[i].data[0] = NAN;
        assert_int_equal(strncmp(optim_lbfgs_state_check(lbfgs), a[i].name, strlen(a[i].name)), 0);
        a[i].data[0] = good;
        assert_null(optim_lbfgs_state_check(lbfgs));
    }
    assert_string_equal(a[count - 1].name, "scalars");
    int stopped = 0;
    for (size_t i = 0; i < a[count - 1].count; i++) {
        double *scalar = a[count - 1].data + i;
        const double good = *scalar;
        *scalar = -1.5; /* no counter; but a value, best value or step may be */
        if (optim_lbfgs_state_check(lbfgs)) {
            assert_int_equal(run(lbfgs, &p, 1), OPTIM_BAD_STATE);
            stopped++;
        }
        *scalar = good;
    }
    assert_int_equal(stopped, (int)a[count - 1].count - 3);
    optim_lbfgs_free(lbfgs);
    const optim_adam_settings settings = optim_adam_defaults();
    optim_adam *adam = optim_adam_create(4, x, &settings, NULL);
    const int adam_count = optim_adam_state(adam, a, OPTIM_STATE_CAPACITY);
    for (int i = 0; i < adam_count; i++) {
        const double good = a[i].data[0];
        a[i].data[0] = NAN;
        assert_int_equal(strncmp(optim_adam_state_check(adam), a[i].name, strlen(a[i].name)), 0);
        a[i].data[0] = good;
    }
    a[adam_count - 1].data[0] = 0.5;
    assert_int_equal(optim_adam_step(adam, objective, &p), OPTIM_BAD_STATE);
    optim_adam_free(adam);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_schedules),        cmocka_unit_test(test_status_texts),
        cmocka_unit_test(test_validators),       cmocka_unit_test(test_create_refuses),
        cmocka_unit_test(test_allocation),       cmocka_unit_test(test_adam_by_hand),
        cmocka_unit_test(test_adam_clipping),    cmocka_unit_test(test_adam_quadratic),
        cmocka_unit_test(test_adam_best),        cmocka_unit_test(test_adam_endings),
        cmocka_unit_test(test_lbfgs_rosenbrock), cmocka_unit_test(test_lbfgs_quadratic),
        cmocka_unit_test(test_lbfgs_direction),  cmocka_unit_test(test_lbfgs_one_variable),
        cmocka_unit_test(test_lbfgs_first_step), cmocka_unit_test(test_lbfgs_starts_at_minimum),
        cmocka_unit_test(test_lbfgs_nan_region), cmocka_unit_test(test_lbfgs_unbounded),
        cmocka_unit_test(test_lbfgs_endings),    cmocka_unit_test(test_lbfgs_tolerances),
        cmocka_unit_test(test_lbfgs_skips),      cmocka_unit_test(test_lbfgs_objective_changed),
        cmocka_unit_test(test_resume_adam),      cmocka_unit_test(test_resume_lbfgs),
        cmocka_unit_test(test_bad_state),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
