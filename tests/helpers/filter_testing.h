/* For tests of filters: linear models, what is seen of them, normal random numbers, and Kalman's
 * filter as textbooks have it, by covariances. */
#ifndef TESTS_FILTER_TESTING_H
#define TESTS_FILTER_TESTING_H

#include "near.h"
#include "random_numbers.h"

#include "tools/control/estimator.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { FILTER_STATES = 24 };

typedef struct linear_model {
    int n;
    double a[FILTER_STATES][FILTER_STATES], b[FILTER_STATES]; /* one input */
    int fails; /* advance with more points than this has no answer */
} linear_model;

static __attribute__((noinline, unused)) int
linear_advance(void *context, int count, double h, const double *states, const double *inputs,
               const double *after, double *next, double *by_state, double *by_inputs)
{
    const linear_model *x = context;
    (void)h;
    (void)by_state;
    (void)by_inputs;
    for (int i = 0; i < count; i++) {
        for (int r = 0; r < x->n; r++) {
            double sum = x->b[r] * 0.5 * (inputs[i] + (after ? after[i] : inputs[i]));
            for (int c = 0; c < x->n; c++) {
                sum += x->a[r][c] * states[i * x->n + c];
            }
            next[i * x->n + r] = sum;
        }
    }
    return x->fails > 0 && count > x->fails;
}

typedef struct linear_observation {
    int n, values;
    double h[3][FILTER_STATES];
} linear_observation;

static __attribute__((noinline, unused)) int linear_see(void *context, int count,
                                                        const double *states, const double *inputs,
                                                        double *values, double *by_state)
{
    const linear_observation *x = context;
    (void)inputs;
    (void)by_state;
    for (int i = 0; i < count * x->values; i++) {
        values[i] = 0;
        for (int c = 0; c < x->n; c++) {
            values[i] += x->h[i % x->values][c] * states[i / x->values * x->n + c];
        }
    }
    return 0;
}

/* Of mean 0 and variance 1 (Box and Muller). */
static inline double random_normal(uint64_t *seed)
{
    const double u = 1 - random_in(seed, 0, 1), v = random_in(seed, 0, 1);
    return sqrt(-2 * log(u)) * cos(6.283185307179586 * v);
}

typedef struct kalman {
    int n;
    double x[FILTER_STATES], p[FILTER_STATES][FILTER_STATES];
} kalman;

/* x = F x + g, P = F P F^T + diag(q) */
static inline void kalman_predict(kalman *k, double (*f)[FILTER_STATES], const double *g,
                                  const double *q)
{
    double x[FILTER_STATES], fp[FILTER_STATES][FILTER_STATES];
    for (int i = 0; i < k->n; i++) {
        x[i] = g[i];
        for (int j = 0; j < k->n; j++) {
            x[i] += f[i][j] * k->x[j];
            fp[i][j] = 0;
            for (int c = 0; c < k->n; c++) {
                fp[i][j] += f[i][c] * k->p[c][j];
            }
        }
    }
    for (int i = 0; i < k->n; i++) {
        k->x[i] = x[i];
        for (int j = 0; j < k->n; j++) {
            k->p[i][j] = i == j ? q[i] : 0;
            for (int c = 0; c < k->n; c++) {
                k->p[i][j] += fp[i][c] * f[j][c];
            }
        }
    }
}

/* One number y = h x with variance r; returns nu^2/S. Several numbers: one after the other, as
 * their noises are independent. */
static inline double kalman_correct(kalman *k, const double *h, double y, double r)
{
    double ph[FILTER_STATES], s = r, nu = y;
    for (int i = 0; i < k->n; i++) {
        ph[i] = 0;
        for (int c = 0; c < k->n; c++) {
            ph[i] += k->p[i][c] * h[c];
        }
    }
    for (int i = 0; i < k->n; i++) {
        s += h[i] * ph[i];
        nu -= h[i] * k->x[i];
    }
    for (int i = 0; i < k->n; i++) {
        k->x[i] += ph[i] * nu / s;
        for (int j = 0; j < k->n; j++) {
            k->p[i][j] -= ph[i] * ph[j] / s;
        }
    }
    return nu * nu / s;
}

/* A filter in memory of its own; free(memory). */
typedef struct filter_test {
    void *memory;
    estimator *x;
} filter_test;

static inline filter_test make_filter(const estimator_settings *settings)
{
    filter_test made;
    const char *why = estimator_refusal(settings);
    if (why) {
        fail_msg("%s", why);
    }
    made.memory = malloc(estimator_size(settings));
    assert_non_null(made.memory);
    made.x = estimator_init(made.memory, settings);
    return made;
}

/* ---- an example ---------------------------------------------------------------------------- */

enum { N = 4 };

/* Two masses with springs and dampers, sampled; position of one and velocity of the other seen. */
static const linear_model masses = {.n = N,
                                    .a = {{0.97, 0.02, 0.19, 0.01},
                                          {0.02, 0.98, 0.01, 0.2},
                                          {-0.3, 0.15, 0.9, 0.05},
                                          {0.15, -0.2, 0.05, 0.92}},
                                    .b = {0.02, 0, 0.2, 0.01}};
static const linear_observation first_place = {.n = N, .values = 2, .h = {{1}, {0.5, 0.5}}};
static const linear_observation second_speed = {.n = N, .values = 1, .h = {{0, 0, 0, 1}}};
static const double noise_of_place[2] = {0.1, 0.2}, noise_of_speed[1] = {0.05};
static const double at_start[N] = {1, 0.5, 0.3, 0.2}, left_out[N] = {0.01, 0.01, 0.1, 0.05};

typedef struct linear_test {
    linear_model model;
    linear_observation observation[2];
    estimator_sensor sensor[2];
    estimator_settings settings;
} linear_test;

static inline void make_linear(linear_test *x, double alpha, double beta)
{
    memset(x, 0, sizeof *x);
    x->model = masses;
    x->observation[0] = first_place;
    x->observation[1] = second_speed;
    x->sensor[0] = (estimator_sensor){.observation = {&x->observation[0], N, 0, 2, linear_see},
                                      .noise = noise_of_place,
                                      .every = 2,
                                      .phase = 1,
                                      .depends = 2};
    x->sensor[1] = (estimator_sensor){.observation = {&x->observation[1], N, 0, 1, linear_see},
                                      .noise = noise_of_speed};
    x->settings = (estimator_settings){.model = {.context = &x->model,
                                                 .states = N,
                                                 .inputs = 1,
                                                 .step = 1,
                                                 .advance = linear_advance},
                                       .sensors = 2,
                                       .sensor = x->sensor,
                                       .deviation = at_start,
                                       .process = left_out,
                                       .adapt = 1,
                                       .alpha = alpha,
                                       .beta = beta};
}

static inline double input_at(int k)
{
    return sin(0.3 * k);
}

/* What a sensor measures of the true state. */
static inline void measure(const linear_test *x, int which, const double *truth, uint64_t *seed,
                           double *values)
{
    linear_see((void *)&x->observation[which], 1, truth, NULL, values, NULL);
    for (int i = 0; i < x->observation[which].values; i++) {
        values[i] += x->sensor[which].noise[i] * random_normal(seed);
    }
}

static inline void go_on(const linear_test *x, double u, uint64_t *seed, double *truth)
{
    double next[N];
    linear_advance((void *)&x->model, 1, 1, truth, &u, NULL, next, NULL, NULL);
    for (int i = 0; i < N; i++) {
        truth[i] = next[i] + left_out[i] * random_normal(seed);
    }
}

#endif
