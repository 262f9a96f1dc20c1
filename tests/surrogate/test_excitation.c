/* Excitations stay within ranges and have the kinds they say; rollouts are the same for any number
 * of threads and rollouts, and what is between instants is what the reduced rod does. */
#include "near.h"
#include "rollouts_testing.h"

#include "physics/chain/reduced.h"
#include "tools/prepare/prepare.h"
#include "tools/surrogate/excitation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char arm[] = ARM("{range: [0.5, 2], scale: log}");

static config *read_scene(void)
{
    ad_error error = {.message = ""};
    config *given = NULL;
    if (prepare_read("arm.yaml", arm, 0, NULL, &given, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return given;
}

static excitation_settings small_settings(void)
{
    excitation_settings settings = excitation_settings_default();
    const int modes[4] = {1, 1, 1, 1};
    memcpy(settings.modes, modes, sizeof modes);
    settings.step = 0.05;
    settings.steps = 20;
    settings.count = 10;
    settings.constant = 2;
    return settings;
}

static void test_draws(void **state)
{
    (void)state;
    enum { STEPS = 2000 };
    static double inputs[(STEPS + 1) * 2];
    config *given = read_scene();
    const scene_parameter *ranges = given->scene.parameters;
    excitation_settings settings = small_settings();
    settings.steps = STEPS;
    for (int kind = 0; kind < EXCITATION_KIND_COUNT; kind++) {
        double low = INFINITY, high = -INFINITY, jump = 0;
        int at_ends = 0, moves = 0;
        settings.only = kind;
        excitation_draw(2, ranges, &settings, 3, inputs);
        for (int k = 0; k <= STEPS; k++) {
            const double p = inputs[2 * k], before = inputs[2 * (k > 0 ? k - 1 : 0)];
            assert_true(p >= ranges[0].low && p <= ranges[0].high);
            assert_true(inputs[2 * k + 1] == inputs[1]); /* constant */
            low = fmin(low, p);
            high = fmax(high, p);
            jump = fmax(jump, fabs(p - before));
            at_ends += p == ranges[0].low || p == ranges[0].high;
            moves += p != before;
        }
        assert_true(inputs[1] >= ranges[1].low && inputs[1] <= ranges[1].high);
        assert_true(low < -1.5 && high > 2.5); /* all of the range is seen */
        assert_true(jump > 1);
        assert_true(kind != EXCITATION_BANG || at_ends == STEPS + 1);
        if (kind == EXCITATION_STEPS || kind == EXCITATION_BANG) {
            assert_in_range(moves, STEPS / 50, STEPS / 4);
        } else if (kind != EXCITATION_MIXED) {
            assert_true(moves > STEPS / 2);
        }
    }
    config_free(given);
}

static excitation_rollouts run(const config *given, const excitation_settings *settings,
                               int threads)
{
    ad_error error = {.message = ""};
    excitation_rollouts result;
    ad_pool *pool = ad_pool_create(threads);
    assert_non_null(pool);
    if (excitation_run(&given->scene, settings, pool, &result, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    ad_pool_free(pool);
    return result;
}

static void test_same(void **state)
{
    (void)state;
    config *given = read_scene();
    excitation_settings settings = small_settings();
    for (int linear = 0; linear < 2; linear++) {
        settings.linear = linear;
        settings.first = 0;
        settings.count = 10;
        excitation_rollouts one = run(given, &settings, 1), two = run(given, &settings, 2);
        settings.first = 7;
        settings.count = 1;
        excitation_rollouts seventh = run(given, &settings, 1);
        const size_t states = (size_t)(21 * one.states), inputs = 21 * 2;
        assert_memory_equal(one.state, two.state, 10 * states * sizeof *one.state);
        assert_memory_equal(one.input, two.input, 10 * inputs * sizeof *one.input);
        assert_memory_equal(one.state + 7 * states, seventh.state, states * sizeof *one.state);
        assert_memory_equal(one.input + 7 * inputs, seventh.input, inputs * sizeof *one.input);
        for (int i = 0; i < 10; i++) {
            assert_int_equal(one.done[i], 20);
        }
        assert_int_equal(one.lost, 0);
        excitation_free(&one);
        excitation_free(&two);
        excitation_free(&seventh);
    }
    config_free(given);
}

/* A step with inputs that move linearly against 512 with inputs that are held. */
static void test_linear(void **state)
{
    (void)state;
    enum { PARTS = 512 };
    config *given = read_scene();
    ad_error error = {.message = ""};
    excitation_settings settings = small_settings();
    settings.linear = true;
    settings.only = EXCITATION_RAMPS;
    settings.count = 1;
    settings.steps = 2;
    excitation_rollouts motion = run(given, &settings, 1);
    const reduced_settings modes = {.modes = {1, 1, 1, 1}};
    reduced_rod *rod = NULL;
    double x[16], held[16], moved = 0, off = 0;
    assert_int_equal(reduced_create(&given->scene, &modes, &rod, &error), AD_OK);
    const int n = motion.states;
    assert_true(n <= 16);
    memcpy(x, motion.state, (size_t)n * sizeof *x);
    for (int p = 0; p < PARTS; p++) {
        const double part = (p + 0.5) / PARTS, h = settings.step / PARTS;
        const double u[2] = {motion.input[0] + part * (motion.input[2] - motion.input[0]),
                             motion.input[1]};
        assert_int_equal(reduced_step(rod, p * h, h, x, u, x, NULL, NULL, &error), AD_OK);
    }
    assert_int_equal(
        reduced_step(rod, 0, settings.step, motion.state, motion.input, held, NULL, NULL, &error),
        AD_OK);
    for (int k = 0; k < n; k++) {
        off = fmax(off, fabs(motion.state[n + k] - x[k]));
        moved = fmax(moved, fabs(held[k] - x[k]));
    }
    print_message("linear: %.1e, held: %.1e\n", off, moved);
    assert_true(off < 1e-4 * moved); /* 512 steps of held inputs leave 4e-6 */
    reduced_free(rod);
    excitation_free(&motion);
    config_free(given);
}

/* A step that is far too long for the rod is taken in parts and said to be. */
static void test_parts(void **state)
{
    (void)state;
    config *given = read_scene();
    excitation_settings settings = small_settings();
    settings.step = 20;
    settings.steps = 5;
    settings.count = 6;
    settings.only = EXCITATION_BANG;
    excitation_rollouts x = run(given, &settings, 2);
    print_message("parts: %ld of 30, lost %ld\n", x.substepped, x.lost);
    int done = 0;
    for (int i = 0; i < 6; i++) {
        done += x.done[i];
    }
    assert_true(x.lost > 0 || done == 30);
    for (int i = 0; i < done && i < x.done[0] * x.states; i++) {
        assert_true(isfinite(x.state[i]));
    }
    excitation_free(&x);
    config_free(given);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_draws),
        cmocka_unit_test(test_same),
        cmocka_unit_test(test_linear),
        cmocka_unit_test(test_parts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
