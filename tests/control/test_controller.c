/* Predictive control: on a linear system the answers of Riccati's equation, on a pendulum those of
 * a program for nonlinear optimisation; gradients against differences; delay, offset. */
#include "control_testing.h"
#include "random_numbers.h"

#include <float.h>

/* ---- linear systems ------------------------------------------------------------------------ */

enum { N = 5, M = 2, V = 2 };

typedef struct linear {
    double a[N][N], b[N][M], c[V][N];
} linear;

static int linear_advance(void *context, int count, double h, const double *states,
                          const double *inputs, const double *after, double *next, double *by_state,
                          double *by_inputs)
{
    const linear *x = context;

    (void)h;
    (void)after;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < N; k++) {
            double sum = 0.0;

            for (int j = 0; j < N; j++) {
                sum += x->a[k][j] * states[i * N + j];
            }
            for (int j = 0; j < M; j++) {
                sum += x->b[k][j] * inputs[i * M + j];
            }
            next[i * N + k] = sum;
        }
        if (by_state != NULL) {
            memcpy(by_state + i * N * N, x->a, sizeof x->a);
            memcpy(by_inputs + i * N * M, x->b, sizeof x->b);
        }
    }
    return 0;
}

static int linear_see(void *context, int count, const double *states, const double *inputs,
                      double *values, double *by_state)
{
    const linear *x = context;

    (void)inputs;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < V; k++) {
            values[i * V + k] = 0.0;
            for (int j = 0; j < N; j++) {
                values[i * V + k] += x->c[k][j] * states[i * N + j];
            }
        }
        if (by_state != NULL) {
            memcpy(by_state + i * V * N, x->c, sizeof x->c);
        }
    }
    return 0;
}

static linear random_linear(void)
{
    linear x;
    uint64_t seed = 7;

    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            x.a[i][j] = (i == j ? 0.9 : 0.0) + random_in(&seed, -0.2, 0.2);
        }
        for (int j = 0; j < M; j++) {
            x.b[i][j] = random_in(&seed, -1.0, 1.0);
        }
        for (int k = 0; k < V; k++) {
            x.c[k][i] = random_in(&seed, -1.0, 1.0);
        }
    }
    return x;
}

/* gain [M][N]: u = -gain x with which the first of `left` steps is best, by Riccati's recursion
 * from the end: P = C'WC, then A'PA - A'PB gain + C'WC, gain = (R + B'PB)^-1 B'PA. */
static void riccati(const linear *x, const double *weight, double terminal, const double *effort,
                    int left, double gain[M][N])
{
    double p[N][N] = {{0}};

    for (int step = 0; step < left; step++) {
        double pa[N][N] = {{0}}, pb[N][M] = {{0}}, s[M][M] = {{0}}, k[M][N] = {{0}};
        double next[N][N] = {{0}};
        double det;

        for (int i = 0; i < N; i++) {
            for (int j = 0; j < N; j++) {
                for (int v = 0; v < V; v++) {
                    p[i][j] += (step == 0 ? terminal : 1.0) * weight[v] * x->c[v][i] * x->c[v][j];
                }
            }
        }
        for (int i = 0; i < N * N * N; i++) {
            pa[i / N / N][i / N % N] += p[i / N / N][i % N] * x->a[i % N][i / N % N];
        }
        for (int i = 0; i < N * M * N; i++) {
            pb[i / N / M][i / N % M] += p[i / N / M][i % N] * x->b[i % N][i / N % M];
        }
        for (int i = 0; i < M; i++) {
            s[i][i] = effort[i];
            for (int j = 0; j < M; j++) {
                for (int l = 0; l < N; l++) {
                    s[i][j] += x->b[l][i] * pb[l][j];
                }
            }
            for (int j = 0; j < N; j++) {
                for (int l = 0; l < N; l++) {
                    k[i][j] += x->b[l][i] * pa[l][j];
                }
            }
        }
        det = s[0][0] * s[1][1] - s[0][1] * s[1][0];
        for (int j = 0; j < N; j++) {
            gain[0][j] = (s[1][1] * k[0][j] - s[0][1] * k[1][j]) / det;
            gain[1][j] = (s[0][0] * k[1][j] - s[1][0] * k[0][j]) / det;
        }
        for (int i = 0; i < N; i++) {
            for (int j = 0; j < N; j++) {
                for (int l = 0; l < N; l++) {
                    next[i][j] += x->a[l][i] * pa[l][j];
                }
                for (int l = 0; l < M; l++) {
                    next[i][j] -= k[l][i] * gain[l][j];
                }
            }
        }
        memcpy(p, next, sizeof p);
    }
}

/* The whole plan is that of Riccati's gains. What is added to the diagonal of the program, 1e-9 of
 * it, is gone after two iterations. */
static void test_linear(void **state)
{
    linear x = random_linear();
    const int inputs[M] = {1, 0};
    const double others[M] = {0}, lower[M] = {-50, -50}, upper[M] = {150, 50};
    const double weight[V] = {2, 0.5}, effort[M] = {30, 20}, rest[M] = {0};
    const controller_settings settings = {
        .model = {.context = &x, .states = N, .inputs = M, .step = 1, .advance = linear_advance},
        .observation = {&x, N, M, V, linear_see},
        .horizon = 12,
        .iterations = 2,
        .controlled = M,
        .inputs = inputs,
        .others = others,
        .lower = lower,
        .upper = upper,
        .rest = rest,
        .weight = weight,
        .effort = effort,
        .terminal = 5};
    controller *c = make_controller(&settings);
    const double r[M] = {effort[1] / 1e4, effort[0] / 4e4}; /* in the model's order, by span^2 */
    double now[N] = {1, -2, 0.5, 3, -1}, reference[12 * V] = {0}, u[M], next[N];
    const controller_sample sample = {.state = now, .reference = reference};

    (void)state;
    assert_int_equal(controller_feedback(c, &sample, u), 0);
    for (int i = 0; i < 12; i++) {
        const double *move = i == 0 ? u : controller_plan(c) + (i - 1) * M;
        double gain[M][N], best[M] = {0};

        riccati(&x, weight, 5, r, 12 - i, gain);
        for (int j = 0; j < M; j++) {
            for (int k = 0; k < N; k++) {
                best[j] -= gain[j][k] * now[k];
            }
            assert_near(move[1 - j], best[j], 1e-9);
        }
        assert_int_equal(linear_advance(&x, 1, 1, now, best, NULL, next, NULL, NULL), 0);
        memcpy(now, next, sizeof now);
    }
    free(c);
}

/* Far from where it is to be, every input goes as fast as it may, from what acts now on: the limit
 * is to the move before, not to the first. Where it is active, it holds to the last digits. */
static void test_rate(void **state)
{
    linear x = random_linear();
    const int inputs[M] = {0, 1};
    const double others[M] = {0}, lower[M] = {-50, -50}, upper[M] = {50, 50}, rate[M] = {0.3, 0.2};
    const double weight[V] = {2, 0.5}, last[M] = {1, -2}, now[N] = {0};
    const controller_settings settings = {
        .model = {.context = &x, .states = N, .inputs = M, .step = 1, .advance = linear_advance},
        .observation = {&x, N, M, V, linear_see},
        .horizon = 4,
        .iterations = 2,
        .controlled = M,
        .inputs = inputs,
        .others = others,
        .lower = lower,
        .upper = upper,
        .rate = rate,
        .weight = weight};
    controller *c = make_controller(&settings);
    double reference[4 * V], u[M];
    const controller_sample sample = {.state = now, .reference = reference};

    (void)state;
    for (int i = 0; i < 4 * V; i++) {
        reference[i] = 1e3;
    }
    controller_applied(c, 0, last);
    assert_int_equal(controller_feedback(c, &sample, u), 0);
    for (int j = 0; j < M; j++) {
        double before = last[j];

        for (int i = 0; i < 3; i++) {
            const double move = i == 0 ? u[j] : controller_plan(c)[(i - 1) * M + j];

            assert_near(fabs(move - before), rate[j], 1e-9);
            before = move;
        }
        assert_near(fabs(before - last[j]), 3 * rate[j], 1e-9);
    }
    free(c);
}

/* ---- the pendulum -------------------------------------------------------------------------- */

/* By casadi 3.8.2 and Ipopt to 1e-14, single shooting: the limit of the rate is active in moves 1
 * to 3, the soft limit of 0.65 rad, 0.7 with a margin of 0.05, is exceeded, the rest is free. */
static const double best_moves[15] = {7.752325710008761,  6.092156052442727, 4.092156052443024,
                                      2.092156052444473,  0.850542430721187, 0.5989383302921534,
                                      1.2335686460670374, 2.486834153452084, 3.9821813927254683,
                                      5.254613629873515,  5.96803346421181,  6.1419688108430295,
                                      6.033204727122041,  5.922348559519168, 6.003477206410985};
static const double best_cost = 1.4328364111673844;

typedef struct nonlinear {
    controller_settings settings;
    double smooth[1], upper[1], margin[1], soft[1], rest[1], others[2], start[2], last[1];
    double reference[HORIZON];
    controller_sample sample;
} nonlinear;

static void make_nonlinear(nonlinear *x)
{
    *x = (nonlinear){.smooth = {2},
                     .upper = {0.7},
                     .margin = {0.05},
                     .soft = {1e3},
                     .others = {0, 1.3},
                     .start = {0.3, 1.0},
                     .last = {7}};
    x->settings = pendulum_settings();
    x->settings.delay = 0;
    x->settings.terminal = 3;
    x->settings.smooth = x->smooth;
    x->settings.soft_upper = x->upper;
    x->settings.soft_weight = x->soft;
    x->settings.rest = x->rest;
    for (int i = 0; i < HORIZON; i++) {
        x->reference[i] = 0.6 + 0.01 * i;
    }
    x->sample = (controller_sample){
        .state = x->start, .others = x->others, .reference = x->reference, .margin = x->margin};
}

static double move_of(const controller *c, const double *u, int i)
{
    return i == 0 ? u[0] : controller_plan(c)[i - 1];
}

/* Gauss-Newton converges linearly, the faster the smaller what remains of the cost. */
static void test_nonlinear(void **state)
{
    nonlinear x;
    double u[1];
    double before = 1.0;
    controller *c;

    (void)state;
    make_nonlinear(&x);
    for (int iterations = 2; iterations <= 32; iterations *= 4) {
        double worst = 0.0;

        x.settings.iterations = iterations;
        c = make_controller(&x.settings);
        controller_applied(c, 0, x.last);
        assert_int_equal(controller_feedback(c, &x.sample, u), CONTROLLER_SOFT);
        for (int i = 0; i < 15; i++) {
            worst = fmax(worst, fabs(move_of(c, u, i) - best_moves[i]));
        }
        assert_true(worst < 0.3 * before || worst < 1e-7); /* Ipopt's own answer is good to 1e-8 */
        before = worst;
        if (iterations == 32) {
            assert_near(worst, 0.0, 1e-7);
            assert_near(controller_cost(c), best_cost, 1e-9);
        }
        free(c);
    }
}

/* The true cost of a plan, by steps of the model one after the other. */
static double true_cost(const nonlinear *x, const double *moves)
{
    const double span = 16.0;
    double now[2] = {x->start[0], x->start[1]};
    double cost = 0.0;

    for (int i = 0; i < HORIZON; i++) {
        const double u = moves[i < 15 ? i : 14];
        const double last = i == 0 ? x->last[0] : moves[i <= 15 ? i - 1 : 14];
        const double inputs[2] = {u, x->others[1]};
        const double change = (u - last) / span;
        double next[2][5], error, over;

        pendulum_step(0.05, now, inputs, next);
        now[0] = next[0][0];
        now[1] = next[1][0];
        error = now[0] - x->reference[i];
        over = fmax(now[0] - (x->upper[0] - x->margin[0]), 0.0);
        cost += 0.5 * 10 * (i == HORIZON - 1 ? x->settings.terminal : 1.0) * error * error +
                0.5 * x->soft[0] * over * over + 0.5 * x->smooth[0] * change * change +
                0.5 * 0.01 * (u / span) * (u / span);
    }
    return cost;
}

/* Where nothing limits a move, the true cost does not change with it: differences of it, whose own
 * error is 1e-16/1e-5, are what is left of derivatives through model, look and horizon. */
static void test_gradient(void **state)
{
    nonlinear x;
    double u[1], moves[15];
    controller *c;

    (void)state;
    make_nonlinear(&x);
    x.settings.iterations = 40;
    x.settings.rate = NULL;
    c = make_controller(&x.settings);
    controller_applied(c, 0, x.last);
    (void)controller_feedback(c, &x.sample, u);
    for (int i = 0; i < 15; i++) {
        moves[i] = move_of(c, u, i);
    }
    assert_near(controller_cost(c), true_cost(&x, moves), 1e-12);
    for (int i = 0; i < 15; i++) {
        const double middle = moves[i];
        double difference;

        moves[i] = middle + 1e-5;
        difference = true_cost(&x, moves);
        moves[i] = middle - 1e-5;
        difference = (difference - true_cost(&x, moves)) / 2e-5;
        moves[i] = middle;
        assert_true(fabs(middle) < 8.0);
        assert_near(difference, 0.0, 1e-9);
    }
    free(c);
}

/* With a delay of one sample the plan is that of no delay from where the state will be. */
static void test_delay(void **state)
{
    nonlinear x;
    const double pending[1] = {5};
    const double inputs[2] = {5, 1.3};
    double next[2][5], later[2], u[1], v[1];
    controller *c, *d;

    (void)state;
    make_nonlinear(&x);
    c = make_controller(&x.settings);
    x.settings.delay = 1;
    d = make_controller(&x.settings);
    controller_applied(c, 0, pending);
    controller_applied(d, 0, pending);
    (void)controller_feedback(d, &x.sample, v);
    pendulum_step(0.05, x.start, inputs, next);
    later[0] = next[0][0];
    later[1] = next[1][0];
    x.sample.state = later;
    (void)controller_feedback(c, &x.sample, u);
    assert_memory_equal(u, v, sizeof u);
    assert_memory_equal(controller_plan(c), controller_plan(d), HORIZON * sizeof *u);
    free(c);
    free(d);
}

/* A closed loop with a torque the model does not know; returns the last angle. Inputs keep their
 * limits. */
static double closed_loop(const controller_settings *settings, int samples, double angle)
{
    controller *c = make_controller(settings);
    double now[2] = {0}, reference[HORIZON], u[1] = {0}, applied[1] = {0};
    const controller_sample sample = {.state = now, .measured = now, .reference = reference};

    for (int i = 0; i < HORIZON; i++) {
        reference[i] = angle;
    }
    for (int k = 0; k < samples; k++) {
        double next[2][5], inputs[2];

        (void)controller_feedback(c, &sample, u);
        assert_int_equal(controller_prepare(c), 0);
        assert_true(fabs(u[0]) <= 8.0 && fabs(u[0] - applied[0]) <= 2.0 + 8 * DBL_EPSILON);
        inputs[0] = applied[0] + 1.0;
        inputs[1] = 1.3;
        pendulum_step(0.05, now, inputs, next);
        now[0] = next[0][0];
        now[1] = next[1][0];
        applied[0] = u[0];
    }
    free(c);
    return now[0];
}

static void test_offset(void **state)
{
    controller_settings settings = pendulum_settings();

    (void)state;
    settings.effort = NULL;
    assert_true(fabs(closed_loop(&settings, 200, 0.5) - 0.5) > 0.01);
    settings.offset = 0.2;
    assert_near(closed_loop(&settings, 200, 0.5), 0.5, 1e-6);
}

/* A value without a wish, and one whose weight is 0: the same plan. */
static void test_no_wish(void **state)
{
    nonlinear x;
    const double none[1] = {0};
    double u[1], v[1];
    controller *c, *d;

    (void)state;
    make_nonlinear(&x);
    c = make_controller(&x.settings);
    x.settings.weight = none;
    d = make_controller(&x.settings);
    (void)controller_feedback(d, &x.sample, v);
    for (int i = 0; i < HORIZON; i++) {
        x.reference[i] = NAN;
    }
    (void)controller_feedback(c, &x.sample, u);
    assert_memory_equal(u, v, sizeof u);
    assert_memory_equal(controller_plan(c), controller_plan(d), HORIZON * sizeof *u);
    free(c);
    free(d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_linear),    cmocka_unit_test(test_rate),
        cmocka_unit_test(test_nonlinear), cmocka_unit_test(test_gradient),
        cmocka_unit_test(test_delay),     cmocka_unit_test(test_offset),
        cmocka_unit_test(test_no_wish)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
