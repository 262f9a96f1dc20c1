/* For tests of controllers: a pendulum with an input torque and a damping that another input
 * scales, by four steps of Runge and Kutta's method with exact derivatives, of which the first
 * state is seen. */
#ifndef TESTS_CONTROL_TESTING_H
#define TESTS_CONTROL_TESTING_H

#include "near.h"
#include "tools/control/controller.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { HORIZON = 20, STEPS = 4 };

typedef struct pendulum {
    long calls;
    long failing; /* the call that has no answer; 0: none */
    bool silent;  /* it answers NaN instead of an error */
} pendulum;

static pendulum the_pendulum;

/* rate [2][5]: angle, angular velocity, each with derivatives by state and inputs behind it. */
static inline void pendulum_rate(const double x[2][5], const double *u, double rate[2][5])
{
    for (int k = 0; k < 5; k++) {
        rate[0][k] = x[1][k];
        rate[1][k] =
            -9.81 * (k == 0 ? sin(x[0][0]) : cos(x[0][0]) * x[0][k]) - 0.5 * u[1] * x[1][k];
    }
    rate[1][0] += u[0];
    rate[1][3] += 1.0;
    rate[1][4] += -0.5 * x[1][0];
}

static inline void pendulum_add(double x[2][5], double h, double rate[2][5], double sum[2][5])
{
    for (int i = 0; i < 10; i++) {
        sum[i / 5][i % 5] = x[i / 5][i % 5] + h * rate[i / 5][i % 5];
    }
}

static inline void pendulum_step(double h, const double *state, const double *u, double x[2][5])
{
    double k[4][2][5], between[2][5];

    memset(x, 0, 10 * sizeof x[0][0]);
    for (int i = 0; i < 2; i++) {
        x[i][0] = state[i];
        x[i][1 + i] = 1.0;
    }
    for (int step = 0; step < STEPS; step++) {
        const double q = h / STEPS;

        pendulum_rate((const double(*)[5])x, u, k[0]);
        pendulum_add(x, q / 2, k[0], between);
        pendulum_rate((const double(*)[5])between, u, k[1]);
        pendulum_add(x, q / 2, k[1], between);
        pendulum_rate((const double(*)[5])between, u, k[2]);
        pendulum_add(x, q, k[2], between);
        pendulum_rate((const double(*)[5])between, u, k[3]);
        pendulum_add(x, q / 6, k[0], x);
        pendulum_add(x, q / 3, k[1], x);
        pendulum_add(x, q / 3, k[2], x);
        pendulum_add(x, q / 6, k[3], x);
    }
}

static inline int pendulum_advance(void *context, int count, double h, const double *states,
                                   const double *inputs, const double *after, double *next,
                                   double *by_state, double *by_inputs)
{
    pendulum *p = context;
    const bool fails = ++p->calls == p->failing;

    (void)after;
    for (int i = 0; i < count; i++) {
        double x[2][5];

        pendulum_step(h, states + 2 * i, inputs + 2 * i, x);
        for (int k = 0; k < 2; k++) {
            next[2 * i + k] = fails ? NAN : x[k][0];
            for (int j = 0; by_state != NULL && j < 2; j++) {
                by_state[4 * i + 2 * k + j] = x[k][1 + j];
                by_inputs[4 * i + 2 * k + j] = x[k][3 + j];
            }
        }
    }
    return fails && !p->silent;
}

static inline int pendulum_see(void *context, int count, const double *states, const double *inputs,
                               double *values, double *by_state)
{
    (void)context;
    (void)inputs;
    for (int i = 0; i < count; i++) {
        values[i] = states[2 * i];
        if (by_state != NULL) {
            by_state[2 * i] = 1.0;
            by_state[2 * i + 1] = 0.0;
        }
    }
    return 0;
}

/* Outside is what turns further than 2 rad. */
static inline double pendulum_outside(void *context, const double *state, const double *inputs)
{
    (void)context;
    (void)inputs;
    return fabs(state[0]) / 2.0;
}

static const int the_input[1] = {0};
static const double the_others[2] = {0, 1}, the_lower[1] = {-8}, the_upper[1] = {8};
static const double the_rate[1] = {2}, the_weight[1] = {10}, the_smooth[1] = {0.1};
static const double the_effort[1] = {0.01};

static inline controller_settings pendulum_settings(void)
{
    memset(&the_pendulum, 0, sizeof the_pendulum);
    return (controller_settings){.model = {.context = &the_pendulum,
                                           .states = 2,
                                           .inputs = 2,
                                           .step = 0.05,
                                           .advance = pendulum_advance,
                                           .outside = pendulum_outside},
                                 .observation = {NULL, 2, 2, 1, pendulum_see},
                                 .horizon = HORIZON,
                                 .moves = 15,
                                 .delay = 1,
                                 .controlled = 1,
                                 .inputs = the_input,
                                 .others = the_others,
                                 .lower = the_lower,
                                 .upper = the_upper,
                                 .rate = the_rate,
                                 .weight = the_weight,
                                 .smooth = the_smooth,
                                 .effort = the_effort};
}

static inline controller *make_controller(const controller_settings *settings)
{
    assert_null(controller_refusal(settings));
    return controller_init(malloc(controller_size(settings)), settings);
}

#endif
