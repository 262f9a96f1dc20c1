/* Adam: steps by hand, clipping, the best point, how it ends. */
#include "optim_testing.h"

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
    optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
    settings.learning_rate = 0.1;
    optim_optimizer *adam = create_adam(3, x, &settings, NULL);
    for (int step = 0; step < 2; step++) {
        assert_int_equal(step_by(adam, objective, &p), OPTIM_RUNNING);
        for (int i = 0; i < 3; i++) { /* 1 - 0.999 loses 3 digits of the 16 */
            assert_near(optim_x(adam)[i], wanted[step][i], 1e-13);
        }
    }
    const optim_info info = optim_inspect(adam);
    assert_int_equal(info.steps, 2);
    assert_near(info.gradient_norm, sqrt(10.25), 1e-15);
    optim_free(adam);
}

/* With both betas 0 a step is rate * g / (|g| + epsilon), so a large epsilon shows the clipping:
 * the gradient (3, 4), of norm 5, has to arrive as (0.6, 0.8). */
static void test_adam_clipping(void **state)
{
    (void)state;
    optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
    settings.beta1 = settings.beta2 = 0;
    settings.epsilon = 1;
    settings.clip_norm = 1;
    settings.learning_rate = 1;
    problem p = make_problem(diagonal_quadratic, 2);
    const double at[2] = {sin(1) + 3, sin(2) + 4e-6};
    optim_optimizer *adam = create_adam(2, at, &settings, NULL);
    assert_int_equal(step_by(adam, objective, &p), OPTIM_RUNNING);
    /* 1e6 * rounding of sin(2) + 4e-6 is 1e-10. */
    assert_near(optim_x(adam)[0], at[0] - 0.6 / 1.6, 1e-9);
    assert_near(optim_x(adam)[1], at[1] - 0.8 / 1.8, 1e-9);
    optim_free(adam);
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
    optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
    settings.schedule = OPTIM_SCHEDULE_EXPONENTIAL;
    settings.learning_rate = 0.05;
    settings.warmup_steps = 10;
    settings.decay_steps = 1000;
    settings.decay_factor = 0.05;
    problem p = make_problem(diagonal_quadratic, COUNT);
    optim_optimizer *adam = create_adam(COUNT, x, &settings, NULL);
    for (int step = 0; step < 6000; step++) {
        assert_int_equal(step_by(adam, objective, &p), OPTIM_RUNNING);
    }
    /* Adam stays within about one step of the minimum, and the last rate is 0.05^7 = 8e-10. */
    assert_below(distance(COUNT, optim_x(adam), minimiser), 1e-8);
    optim_free(adam);
}

static void test_adam_best(void **state)
{
    (void)state;
    double x[4];
    classic_start(4, x);
    optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
    settings.learning_rate = 0.5; /* far too large: the value goes up and down */
    problem p = make_problem(rosenbrock, 4);
    optim_optimizer *adam = create_adam(4, x, &settings, NULL);
    int above = 0;
    for (int step = 0; step < 200; step++) {
        assert_int_equal(step_by(adam, objective, &p), OPTIM_RUNNING);
        above += optim_inspect(adam).value > p.lowest;
        assert_true(optim_inspect(adam).best_value == p.lowest);
        assert_memory_equal(best_x_of(adam), p.lowest_x, sizeof x);
    }
    assert_true(above > 20); /* so that best and current did differ */
    optim_objective_changed(adam);
    assert_true(optim_inspect(adam).best_value == INFINITY);
    optim_free(adam);
}

static void test_adam_endings(void **state)
{
    (void)state;
    static const optim_status wanted[] = {
        [STOP] = OPTIM_STOPPED_BY_OBJECTIVE, [CODE_NOT_FINITE] = OPTIM_NOT_FINITE,
        [NAN_VALUE] = OPTIM_NOT_FINITE,      [NAN_GRADIENT] = OPTIM_NOT_FINITE,
        [INF_VALUE] = OPTIM_NOT_FINITE,
    };
    const optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
    double x[2];
    classic_start(2, x);
    for (int how = STOP; how <= INF_VALUE; how++) {
        problem p = make_problem(rosenbrock, 2);
        p.misbehave_from = 4;
        p.misbehaviour = how;
        optim_optimizer *adam = create_adam(2, x, &settings, NULL);
        for (int step = 0; step < 3; step++) {
            assert_int_equal(step_by(adam, objective, &p), OPTIM_RUNNING);
        }
        const double before[2] = {optim_x(adam)[0], optim_x(adam)[1]};
        assert_int_equal(step_by(adam, objective, &p), wanted[how]);
        assert_memory_equal(optim_x(adam), before, sizeof before);
        assert_int_equal(optim_inspect(adam).steps, 3);
        assert_int_equal(optim_inspect(adam).evaluations, 4);
        optim_free(adam);
    }
    const double minimum[2] = {1, 1};
    problem p = make_problem(rosenbrock, 2);
    optim_optimizer *adam = create_adam(2, minimum, &settings, NULL);
    assert_int_equal(step_by(adam, objective, &p), OPTIM_GRADIENT_TOLERANCE);
    optim_free(adam);
}

/* The third point overflows: the point, the moments and the number of steps stay those of the
 * second, so that a checkpoint written then is good. */
static void test_adam_overflow(void **state)
{
    (void)state;
    optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
    settings.learning_rate = 0.75e308; /* what each step adds to x under a slope of -1 */
    optim_optimizer *adam = create_adam(1, (double[1]){0}, &settings, NULL);
    problem line = make_problem(falling_line, 1);
    for (int step = 0; step < 2; step++) {
        assert_int_equal(step_by(adam, objective, &line), OPTIM_RUNNING);
    }
    static const char *const wanted[3] = {"x", "mean", "square"};
    optim_array arrays[OPTIM_STATE_CAPACITY];
    optim_state(adam, arrays);
    double before[3];
    for (int i = 0; i < 3; i++) {
        assert_string_equal(arrays[i].name, wanted[i]);
        before[i] = arrays[i].data[0];
    }
    assert_true(before[0] > 0 && before[1] < 0 && before[2] > 0);
    assert_int_equal(step_by(adam, objective, &line), OPTIM_NOT_FINITE);
    optim_state(adam, arrays);
    for (int i = 0; i < 3; i++) {
        assert_memory_equal(arrays[i].data, &before[i], sizeof before[i]);
    }
    assert_int_equal(optim_inspect(adam).steps, 2);
    assert_null(optim_state_check(adam));
    optim_free(adam);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_adam_by_hand),   cmocka_unit_test(test_adam_clipping),
        cmocka_unit_test(test_adam_quadratic), cmocka_unit_test(test_adam_best),
        cmocka_unit_test(test_adam_endings),   cmocka_unit_test(test_adam_overflow),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
