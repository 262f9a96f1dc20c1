/* Robots in steps (cpinn.h), in C: as many as one by one, what is refused. From Python:
 * test_python_envs.py. */
#include "near.h"

#include "cpinn.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define ARM "configs/robots/soft_arm_control.yaml"

enum { MEMBERS = 70, INPUTS = 4, STATES_MAX = 16 };

static const char *const few[] = {"surrogate.modes=[1, 1, 1, 1]"};

static cpinn_stepper *open_arm(int threads)
{
    cpinn_stepper *robot = NULL;
    ad_error error;
    if (cpinn_stepper_file(ARM, 1, few, 0, threads, &robot, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return robot;
}

static void test_steps(void **state)
{
    (void)state;
    static double inputs[MEMBERS][INPUTS], rest[MEMBERS * STATES_MAX], one[STATES_MAX];
    static double next[2][MEMBERS * STATES_MAX];
    cpinn_stepper *robots[2] = {open_arm(1), open_arm(2)};
    ad_error error;
    const size_t n = (size_t)cpinn_stepper_states(robots[0]);
    assert_in_range(n, 2, STATES_MAX);
    assert_int_equal(cpinn_stepper_inputs(robots[0]), INPUTS);
    assert_string_equal(cpinn_stepper_input(robots[0], 3)->name, "stiffness");
    assert_null(cpinn_stepper_input(robots[0], INPUTS));
    assert_true(cpinn_stepper_is_slow(robots[0], 3) && !cpinn_stepper_is_slow(robots[0], 0));
    assert_near(cpinn_stepper_step(robots[0]), 0.02, 0);
    for (int i = 0; i < MEMBERS; i++) {
        for (int k = 0; k < 3; k++) {
            inputs[i][k] = 4 + 3.9 * sin(i + 2 * k);
        }
        inputs[i][3] = 1;
    }
    cpinn_stepper_rest(robots[0], MEMBERS, inputs[0], rest);
    for (int i = 0; i < MEMBERS; i++) {
        inputs[i][0] *= 0.5;
    }
    rest[3 * n] = NAN;
    for (int k = 0; k < 2; k++) {
        assert_int_equal(cpinn_stepper_advance(robots[k], MEMBERS, rest, inputs[0], NULL, next[k],
                                               NULL, NULL, &error),
                         AD_OK);
    }
    for (size_t i = 0; i < MEMBERS; i++) {
        cpinn_stepper_advance(robots[1], 1, rest + i * n, inputs[i], NULL, one, NULL, NULL, &error);
        assert_true(isnan(one[0]) == (i == 3));
        if (i != 3) {
            assert_memory_equal(one, next[0] + i * n, n * sizeof *one);
            assert_memory_equal(one, next[1] + i * n, n * sizeof *one);
        }
    }
    inputs[1][2] = 8.1; /* of 0 to 8 */
    assert_int_equal(cpinn_stepper_advance(robots[0], MEMBERS, rest, inputs[0], NULL, next[0], NULL,
                                           NULL, &error),
                     AD_BAD_ARGUMENT);
    assert_string_equal(error.message, "inputs of member 1: force3 is 8.1; allowed: 0 to 8");
    cpinn_stepper_rest(robots[0], 2, inputs[0], rest);
    assert_true(isfinite(rest[0]) && isnan(rest[n]));
    cpinn_stepper_free(robots[0]);
    cpinn_stepper_free(robots[1]);
}

static void test_refused(void **state)
{
    (void)state;
    cpinn_stepper *robot = NULL;
    ad_error error;
    cpinn_stepper_free(NULL);
    assert_int_equal(cpinn_stepper_file("configs/elastica.yaml", 0, NULL, 0, 1, &robot, &error),
                     AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "a one-step model is of scenes in motion"));
    assert_int_equal(cpinn_stepper_open("configs", 1, &robot, &error), AD_IO);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_steps),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
