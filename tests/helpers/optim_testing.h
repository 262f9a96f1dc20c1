/* For tests of optim/: objectives that log what they were asked, and can misbehave. */
#ifndef TESTS_OPTIM_TESTING_H
#define TESTS_OPTIM_TESTING_H

#include "near.h"
#include "optim/optimizer.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

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

static inline problem make_problem(formula f, size_t count)
{
    return (problem){.f = f, .count = count, .lowest = INFINITY};
}

static inline int objective(void *context, const double *x, double *value, double *gradient)
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
static inline double eigenvalue(size_t count, size_t i)
{
    return pow(1e6, (double)i / (double)(count - 1));
}

static inline double diagonal_quadratic(size_t count, const double *x, double *gradient)
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
static inline double turned_quadratic(size_t count, const double *x, double *gradient)
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
static inline double rosenbrock(size_t count, const double *x, double *gradient)
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
static inline double chained_rosenbrock(size_t count, const double *x, double *gradient)
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
static inline double barrier(size_t count, const double *x, double *gradient)
{
    double value = 0;
    for (size_t i = 0; i < count; i++) {
        value += x[i] - log(x[i]);
        gradient[i] = 1 - 1 / x[i];
    }
    return value;
}

static inline double falling_line(size_t count, const double *x, double *gradient)
{
    double value = 0;
    for (size_t i = 0; i < count; i++) {
        value -= x[i];
        gradient[i] = -1;
    }
    return value;
}

static inline double falling_exponential(size_t count, const double *x, double *gradient)
{
    (void)count;
    gradient[0] = -exp(x[0]);
    return gradient[0];
}

static inline double hyperbolic_cosine(size_t count, const double *x, double *gradient)
{
    (void)count;
    gradient[0] = sinh(x[0] - 3);
    return cosh(x[0] - 3);
}

/* f(0) = 0, f'(0) = -1, f(1) = -1e-5, f'(1) = 0.5: x = 1 is lower and flatter, but not by enough.
 */
static inline double shallow_cubic(size_t count, const double *x, double *gradient)
{
    (void)count;
    const double a = 1.49997, b = -0.49998;
    gradient[0] = -1 + x[0] * (2 * a + 3 * b * x[0]);
    return x[0] * (-1 + x[0] * (a + b * x[0]));
}

/* Gradients of the hand-computed Adam steps, chosen by where the first step has led. */
static inline double two_gradients(size_t count, const double *x, double *gradient)
{
    static const double table[2][3] = {{1, -2, 0.5}, {3, 1, -0.5}};
    memcpy(gradient, table[x[0] != 0], count * sizeof *gradient);
    return 0;
}

static inline void classic_start(size_t count, double *x)
{
    for (size_t i = 0; i < count; i++) {
        x[i] = i % 2 ? 1 : -1.2;
    }
}

static inline double dot(size_t count, const double *a, const double *b)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

static inline double distance(size_t count, const double *a, const double *b)
{
    double largest = 0;
    for (size_t i = 0; i < count; i++) {
        largest = fmax(largest, fabs(a[i] - b[i]));
    }
    return largest;
}

static inline void assert_below(double got, double bound)
{
    if (!(got < bound)) {
        fail_msg("got %.17g, wanted less than %g", got, bound);
    }
}

/* ---- methods by their own settings ---- */

#define CREATE(code, field)                                                                        \
    static inline optim_optimizer *create_##field(size_t count, const double *x,                   \
                                                  const optim_settings *given, const char **why)   \
    {                                                                                              \
        optim_settings settings = *given;                                                          \
        settings.method = code;                                                                    \
        return optim_create(count, x, &settings, why);                                             \
    }
CREATE(OPTIM_ADAM, adam)
CREATE(OPTIM_LBFGS, lbfgs)
CREATE(OPTIM_SSBROYDEN, ssbroyden)

static inline optim_status step_by(optim_optimizer *o, optim_objective f, void *context)
{
    return optim_step(o, &(optim_target){.objective = f, .context = context});
}

/* Where the lowest value was found, trial points among them. */
static inline const double *best_x_of(optim_optimizer *o)
{
    optim_array arrays[OPTIM_STATE_CAPACITY];
    const int count = optim_state(o, arrays);
    int i = 0;
    while (i < count && strcmp(arrays[i].name, "best_x") != 0) {
        i++;
    }
    assert_true(i < count);
    return arrays[i].data;
}

static inline optim_status run(optim_optimizer *lbfgs, problem *p, int steps)
{
    optim_status status = OPTIM_RUNNING;
    for (int i = 0; i < steps && status == OPTIM_RUNNING; i++) {
        status = step_by(lbfgs, objective, p);
    }
    return status;
}

static inline optim_optimizer *make_lbfgs(size_t count, const double *x, int memory)
{
    optim_settings settings = optim_settings_defaults(OPTIM_LBFGS);
    settings.memory = memory;
    optim_optimizer *lbfgs = create_lbfgs(count, x, &settings, NULL);
    assert_non_null(lbfgs);
    return lbfgs;
}

/* Value and gradient of the state have to be those of the objective at the current point. */
static inline void assert_consistent(optim_optimizer *lbfgs, const problem *p)
{
    double gradient[MAX_COUNT];
    optim_array arrays[OPTIM_STATE_CAPACITY];
    const double value = p->f(p->count, optim_x(lbfgs), gradient);
    const double stated = optim_inspect(lbfgs).value;
    assert_memory_equal(&value, &stated, sizeof value);
    optim_state(lbfgs, arrays);
    assert_string_equal(arrays[1].name, "gradient");
    assert_memory_equal(arrays[1].data, gradient, p->count * sizeof *gradient);
    /* At most MAX_COUNT squares, summed in another order. */
    const double norm = sqrt(dot(p->count, gradient, gradient));
    assert_near(optim_inspect(lbfgs).gradient_norm, norm, 1e-13 * norm);
}

#endif
