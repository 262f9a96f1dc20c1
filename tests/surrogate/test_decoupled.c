/* Models whose network knows nothing of time: they begin at their state, derivatives against
 * difference quotients; the loss by the rod's equations: its gradient, and that the rod's own
 * motion satisfies it. */
#include "near.h"
#include "rollouts_testing.h"

#include "nn/rng.h"
#include "physics/chain/reduced.h"
#include "tools/prepare/prepare.h"
#include "tools/surrogate/physics_loss.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char arm[] = ARM("{range: [0.8, 1.3]}");
static const int modes[4] = {1, 0, 1, 0};

enum { STATES = 6, INPUTS = 2, STEPS = 12 };

typedef struct example {
    config *given;
    excitation_rollouts motions;
    decoupled m;
    double *numbers, *parameters, *work;
    size_t count; /* of parameters */
} example;

static example make(int terms, bool ramps)
{
    ad_error error = {.message = ""};
    example x = {.m = {.states = STATES,
                       .inputs = INPUTS,
                       .ramps = ramps,
                       .terms = terms,
                       .step = 0.02,
                       .layers = 2,
                       .width = {5, 7}}};
    excitation_settings settings = excitation_settings_default();
    memcpy(settings.modes, modes, sizeof modes);
    settings.step = x.m.step;
    settings.steps = STEPS;
    settings.count = 6;
    settings.linear = ramps;
    settings.shortest = 0.02;
    settings.longest = 0.2;
    ad_pool *pool = ad_pool_create(1);
    x.numbers = calloc(decoupled_numbers(&x.m), sizeof *x.numbers);
    x.work = calloc(decoupled_work(&x.m), sizeof *x.work);
    x.m.numbers = x.numbers;
    if (prepare_read("arm.yaml", arm, 0, NULL, &x.given, &error) != AD_OK ||
        excitation_run(&x.given->scene, &settings, pool, &x.motions, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    physics_prepare(&x.given->scene, &x.motions, 3, &x.m, x.numbers);
    assert_int_equal(x.motions.states, STATES);
    x.count = decoupled_parameters(&x.m);
    x.parameters = x.numbers + decoupled_numbers(&x.m) - x.count;
    nn_rng random = nn_rng_seed(9);
    for (size_t k = 0; k < x.count; k++) { /* so that the network says something */
        x.parameters[k] += 0.2 * nn_rng_normal(&random);
    }
    ad_pool_free(pool);
    return x;
}

static void discard(example *x)
{
    free(x->numbers);
    free(x->work);
    excitation_free(&x->motions);
    config_free(x->given);
}

static double largest(int n, const double *a)
{
    double most = 0;
    for (int i = 0; i < n; i++) {
        most = fmax(most, fabs(a[i]));
    }
    return most;
}

/* ---- the model ----------------------------------------------------------------------------- */

static void test_curves(void **state)
{
    (void)state;
    const double h = 1e-6;
    for (int terms = 1; terms <= 3; terms += 2) {
        example x = make(terms, false);
        double a[4 * 3 * STATES], y[STATES], rate[STATES], ends[2][STATES],
            to[4 * 3 * STATES] = {0};
        double by_y[STATES], by_rate[STATES];
        nn_rng random = nn_rng_seed(4);
        const int outputs = decoupled_outputs(&x.m);
        for (int k = 0; k < outputs; k++) {
            a[k] = nn_rng_normal(&random);
        }
        for (int j = 0; j < STATES; j++) {
            by_y[j] = nn_rng_normal(&random);
            by_rate[j] = nn_rng_normal(&random);
        }
        decoupled_curve(&x.m, a, 0, y, NULL);
        assert_true(largest(STATES, y) == 0); /* exactly */
        decoupled_curve(&x.m, a, 0.4, y, rate);
        decoupled_curve_adjoint(&x.m, a, 0.4, by_y, by_rate, to);
        decoupled_curve(&x.m, a, 0.4 - h, ends[0], NULL);
        decoupled_curve(&x.m, a, 0.4 + h, ends[1], NULL);
        for (int j = 0; j < STATES; j++) {
            assert_near(rate[j], (ends[1][j] - ends[0][j]) / (2 * h), 1e-8);
        }
        for (int k = 0; k < outputs; k++) {
            double sums[2] = {0, 0};
            const double kept = a[k];
            for (int side = 0; side < 2; side++) {
                a[k] = kept + (side ? h : -h);
                decoupled_curve(&x.m, a, 0.4, y, rate);
                for (int j = 0; j < STATES; j++) {
                    sums[side] += by_y[j] * y[j] + by_rate[j] * rate[j];
                }
            }
            a[k] = kept;
            assert_near(to[k], (sums[1] - sums[0]) / (2 * h), 2e-8);
        }
        discard(&x);
    }
}

static void check_derivatives(example *x, double h, const double *state, const double *inputs,
                              const double *after)
{
    double next[STATES], A[STATES * STATES], B[STATES * INPUTS], ends[2][STATES], at[STATES];
    double u[2][INPUTS];
    assert_int_equal(decoupled_advance(&x->m, x->work, 1, h, state, inputs, after, next, A, B), 0);
    for (int c = 0; c < STATES + INPUTS; c++) {
        const double size = c < STATES ? x->numbers[STATES + c] : 1, by = 1e-5 * size;
        for (int side = 0; side < 2; side++) {
            memcpy(at, state, sizeof at);
            memcpy(u[0], inputs, sizeof u[0]);
            memcpy(u[1], after ? after : inputs, sizeof u[1]);
            for (int end = 0; end < 2; end++) {
                *(c < STATES ? &at[c] : &u[end][c - STATES]) +=
                    (end == 0 || c >= STATES) ? (side ? by : -by) : 0;
            }
            assert_int_equal(decoupled_advance(&x->m, x->work, 1, h, at, u[0], after ? u[1] : NULL,
                                               ends[side], NULL, NULL),
                             0);
        }
        for (int r = 0; r < STATES; r++) {
            const double scale = x->numbers[STATES + r] / size;
            const double derivative = c < STATES ? A[r * STATES + c] : B[r * INPUTS + c - STATES];
            assert_near(derivative / scale, (ends[1][r] - ends[0][r]) / (2 * by) / scale, 1e-7);
        }
    }
}

static void test_advance(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        const bool ramps = kind & 2;
        example x = make(kind & 1 ? 2 : 1, ramps);
        const double *from = x.motions.state + 3 * STATES, *u = x.motions.input + 3 * INPUTS;
        const double *after = ramps ? u + INPUTS : NULL, h = x.m.step;
        double next[STATES], none[STATES];
        check_derivatives(&x, h, from, u, after);
        check_derivatives(&x, 0.3 * h, from, u, after);
        assert_int_equal(
            decoupled_advance(&x.m, x.work, 1, 1e-9 * h, from, u, NULL, next, NULL, NULL), 0);
        for (int j = 0; j < STATES; j++) { /* at the begin of the step it is the state */
            assert_near(next[j], from[j], 1e-6 * x.numbers[STATES + j]);
        }
        assert_int_equal(
            decoupled_advance(&x.m, x.work, 1, 1.1 * h, from, u, NULL, next, NULL, NULL), 1);
        assert_int_equal(decoupled_advance(&x.m, x.work, 1, h, from, u, u, next, NULL, NULL),
                         !ramps);
        next[0] = NAN;
        assert_int_equal(decoupled_advance(&x.m, x.work, 1, h, next, u, NULL, none, NULL, NULL), 1);
        assert_true(decoupled_outside(&x.m, next, u) > 1);
        assert_true(decoupled_outside(&x.m, from, u) <= 1 + 1e-12);
        discard(&x);
    }
}

/* ---- the loss ------------------------------------------------------------------------------ */

static physics_loss *loss_of(const example *x, const physics_loss_settings *settings, ad_pool *pool)
{
    ad_error error = {.message = ""};
    physics_loss *loss = NULL;
    if (physics_loss_create(&x->given->scene, modes, &x->motions, &x->m, settings, pool, &loss,
                            &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return loss;
}

static void check_gradient(example *x, const physics_loss_settings *settings)
{
    ad_pool *pools[2] = {ad_pool_create(1), ad_pool_create(2)};
    physics_loss *loss = loss_of(x, settings, pools[0]), *again = loss_of(x, settings, pools[1]);
    double *gradient = calloc(2 * x->count, sizeof *gradient), value, other, worst = 0, size = 0;
    physics_loss_draw(loss, 5);
    physics_loss_draw(again, 5);
    assert_int_equal(physics_loss_evaluate(loss, x->parameters, &value, gradient), 0);
    assert_int_equal(physics_loss_evaluate(again, x->parameters, &other, gradient + x->count), 0);
    assert_true(value > 0 && value == other);
    assert_memory_equal(gradient, gradient + x->count, x->count * sizeof *gradient);
    for (size_t k = 0; k < x->count; k += 1 + x->count / 60) {
        const double kept = x->parameters[k], h = 1e-5;
        double ends[2];
        for (int side = 0; side < 2; side++) {
            x->parameters[k] = kept + (side ? h : -h);
            assert_int_equal(physics_loss_evaluate(loss, x->parameters, &ends[side], NULL), 0);
        }
        x->parameters[k] = kept;
        worst = fmax(worst, fabs(gradient[k] - (ends[1] - ends[0]) / (2 * h)));
        size = fmax(size, fabs(gradient[k]));
    }
    print_message("terms %d ramps %d: %.1e\n", x->m.terms, x->m.ramps, worst / size);
    assert_true(worst < 1e-6 * size); /* of difference quotients 1e-8 */
    physics_loss_draw(loss, 6);
    assert_int_equal(physics_loss_evaluate(loss, x->parameters, &other, NULL), 0);
    assert_true((settings->batch > 0) == (other != value));
    physics_loss_free(loss);
    physics_loss_free(again);
    ad_pool_free(pools[0]);
    ad_pool_free(pools[1]);
    free(gradient);
}

static void test_gradients(void **state)
{
    (void)state;
    const physics_loss_settings settings[] = {{.batch = 8, .seed = 2}, {.most = 9, .seed = 2}};
    for (int kind = 0; kind < 2; kind++) {
        example x = make(kind + 1, kind);
        for (size_t i = 0; i < sizeof settings / sizeof *settings; i++) {
            check_gradient(&x, &settings[i]);
        }
        discard(&x);
    }
}

/* Nodes of steps, which know no solution, beside the rod's own motion: the end is that of one step
 * of Radau's method, and nodes are near the motion that is solved in 64 parts, where inputs jump as
 * well. */
static void test_nodes(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    example x = make(0, false);
    const reduced_settings of = {.modes = {1, 0, 1, 0}, .newton = 1e-12};
    reduced_rod *rod = NULL;
    ad_pool *pool = ad_pool_create(2);
    const size_t rows = (size_t)x.motions.count * STEPS;
    double *nodes = calloc(rows * DECOUPLED_NODES * STATES, sizeof *nodes), most = 0, size = 0;
    assert_int_equal(reduced_create(&x.given->scene, &of, &rod, &error), AD_OK);
    assert_int_equal(
        physics_collocate(&x.given->scene, modes, &x.motions, &x.m, pool, nodes, &error), AD_OK);
    for (size_t row = 0; row < rows; row++) {
        const size_t from = row / STEPS * (STEPS + 1) + row % STEPS;
        const double *begin = x.motions.state + from * STATES;
        const double *u = x.motions.input + from * INPUTS, *scale = x.numbers + STATES;
        double at[STATES], whole[STATES];
        memcpy(at, begin, sizeof at);
        assert_int_equal(reduced_step(rod, 0, x.m.step, begin, u, whole, NULL, NULL, &error),
                         AD_OK);
        for (int i = 0; i < DECOUPLED_NODES; i++) {
            const double t = decoupled_nodes[i] - (i ? decoupled_nodes[i - 1] : 0);
            const double *node = nodes + (row * DECOUPLED_NODES + (size_t)i) * STATES;
            for (int p = 0; p < 64; p++) {
                assert_int_equal(
                    reduced_step(rod, 0, t * x.m.step / 64, at, u, at, NULL, NULL, &error), AD_OK);
            }
            for (int j = 0; j < STATES / 2; j++) {
                most = fmax(most, fabs(node[j] - at[j]) / scale[j]);
                size = fmax(size, fabs(at[j] - begin[j]) / scale[j]);
            }
            for (int j = 0; j < STATES && i == 2; j++) {
                assert_near(node[j], whole[j], 1e-9 * scale[j]);
            }
        }
    }
    print_message("nodes are off by %.1e of moves by %.1e\n", most, size);
    assert_true(most < 0.02 * size);
    free(nodes);
    reduced_free(rod);
    ad_pool_free(pool);
    discard(&x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_curves),
        cmocka_unit_test(test_advance),
        cmocka_unit_test(test_gradients),
        cmocka_unit_test(test_nodes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
