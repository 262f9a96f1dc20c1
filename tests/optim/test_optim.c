/* Optimisers in general: settings, schedules, allocations, state. */
#include "allocations.h"
#include "optim_testing.h"

/* ---- schedules, texts, settings ---- */

static void test_schedules(void **state)
{
    (void)state;
    const double pi = 3.14159265358979323846, rounding = 1e-15; /* a few ulp of rates below 2 */
    optim_settings s = optim_settings_defaults(OPTIM_ADAM);
    s.learning_rate = 2;
    assert_near(optim_schedule_rate(&s, 0), 2, 0);
    assert_near(optim_schedule_rate(&s, 1000000), 2, 0);
    s.warmup_steps = 4;
    s.decay_steps = 100;
    for (int kind = 0; kind < OPTIM_SCHEDULE_COUNT; kind++) {
        s.schedule = (optim_schedule_kind)kind;
        for (int step = 0; step <= 4; step++) { /* full rate exactly at the end of the warm-up */
            assert_near(optim_schedule_rate(&s, step), 2 * (step + 1) / 5.0, rounding);
        }
    }
    s.schedule = OPTIM_SCHEDULE_COSINE;
    s.final_fraction = 0.1;
    assert_near(optim_schedule_rate(&s, 4 + 50), 2 * 0.55, rounding);
    assert_near(optim_schedule_rate(&s, 4 + 25), 2 * (0.1 + 0.45 * (1 + cos(pi / 4))), rounding);
    assert_near(optim_schedule_rate(&s, 4 + 100), 0.2, rounding);
    assert_near(optim_schedule_rate(&s, INT64_MAX), 0.2, rounding);
    s.schedule = OPTIM_SCHEDULE_EXPONENTIAL;
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
    optim_settings a = optim_settings_defaults(OPTIM_ADAM);
    ASSERT_NAMED(optim_settings_check, a, beta1, "beta1", -0.1, 1, NAN);
    ASSERT_NAMED(optim_settings_check, a, beta2, "beta2", -0.1, 1, NAN);
    ASSERT_NAMED(optim_settings_check, a, epsilon, "epsilon", 0, -1, INFINITY, NAN);
    ASSERT_NAMED(optim_settings_check, a, clip_norm, "clip_norm", -1, INFINITY, NAN);
    ASSERT_NAMED(optim_settings_check, a, gradient_tolerance, "gradient_tolerance", -1, INFINITY,
                 NAN);
    ASSERT_NAMED(optim_settings_check, a, schedule, "schedule", OPTIM_SCHEDULE_COUNT, 77);
    ASSERT_NAMED(optim_settings_check, a, learning_rate, "learning_rate", 0, -1, INFINITY, NAN);
    ASSERT_NAMED(optim_settings_check, a, warmup_steps, "warmup_steps", -1);
    ASSERT_NAMED(optim_settings_check, a, decay_steps, "decay_steps", 0, -5);
    ASSERT_NAMED(optim_settings_check, a, final_fraction, "final_fraction", -0.1, 1.1, NAN);
    ASSERT_NAMED(optim_settings_check, a, decay_factor, "decay_factor", 0, 1.1, NAN);
    optim_settings l = optim_settings_defaults(OPTIM_LBFGS);
    ASSERT_NAMED(optim_settings_check, l, memory, "memory", 0, -1, 1001);
    ASSERT_NAMED(optim_settings_check, l, sufficient_decrease, "sufficient_decrease", 0, 0.5, NAN);
    ASSERT_NAMED(optim_settings_check, l, curvature, "curvature", 1e-4, 1, NAN);
    ASSERT_NAMED(optim_settings_check, l, maximum_line_evaluations, "maximum_line_evaluations", 1,
                 1001);
    ASSERT_NAMED(optim_settings_check, l, maximum_step, "maximum_step", 0, -1, INFINITY, NAN);
    ASSERT_NAMED(optim_settings_check, l, gradient_tolerance, "gradient_tolerance", -1, INFINITY,
                 NAN);
    ASSERT_NAMED(optim_settings_check, l, function_tolerance, "function_tolerance", -1, 1, NAN);
    ASSERT_NAMED(optim_settings_check, l, step_tolerance, "step_tolerance", -1, 1, NAN);
    ASSERT_NAMED(optim_settings_check, l, curvature_threshold, "curvature_threshold", -1, 1, NAN);
}

static void test_create_refuses(void **state)
{
    (void)state;
    const double bad_x[2] = {0, NAN}, x[2] = {0, 0};
    const char *why = NULL;
    optim_settings a = optim_settings_defaults(OPTIM_ADAM);
    optim_settings l = optim_settings_defaults(OPTIM_LBFGS);
    assert_null(create_adam(2, bad_x, &a, &why));
    assert_non_null(strstr(why, "finite"));
    assert_null(create_lbfgs(2, bad_x, &l, &why));
    assert_non_null(strstr(why, "finite"));
    assert_null(create_adam(0, x, &a, &why));
    assert_non_null(strstr(why, "count"));
    assert_null(create_lbfgs(0, x, &l, &why));
    assert_non_null(strstr(why, "count"));
    a.beta1 = 2;
    l.memory = 0;
    assert_null(create_adam(2, x, &a, &why));
    assert_non_null(strstr(why, "beta1"));
    assert_null(create_lbfgs(2, x, &l, NULL));
    optim_free(NULL);
    optim_free(NULL);
}

/* Every allocation of create fails once: no crash, no leak (run under ASan), and a reason. Steps
 * allocate nothing. */
static void test_allocation(void **state)
{
    (void)state;
    const optim_settings a = optim_settings_defaults(OPTIM_ADAM);
    const optim_settings l = optim_settings_defaults(OPTIM_LBFGS);
    double x[10];
    classic_start(10, x);
    for (int kind = 0; kind < 2; kind++) {
        problem p = make_problem(rosenbrock, 10);
        optim_optimizer *adam = NULL;
        optim_optimizer *lbfgs = NULL;
        long n = 0;
        while (!adam && !lbfgs) {
            const char *why = NULL;
            allocations = 0;
            failing_allocation = ++n;
            adam = kind ? NULL : create_adam(10, x, &a, &why);
            lbfgs = kind ? create_lbfgs(10, x, &l, &why) : NULL;
            failing_allocation = 0;
            assert_true(adam || lbfgs || (why && strcmp(why, "out of memory") == 0));
        }
        assert_true(n > 2); /* the hook is linked in */
        allocations = 0;
        for (int i = 0; i < 20; i++) {
            assert_int_equal(adam ? step_by(adam, objective, &p) : step_by(lbfgs, objective, &p),
                             OPTIM_RUNNING);
        }
        assert_int_equal(allocations, 0);
        optim_free(adam);
        optim_free(lbfgs);
    }
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
    optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
    settings.schedule = OPTIM_SCHEDULE_COSINE;
    settings.learning_rate = 0.02;
    settings.warmup_steps = 5;
    settings.decay_steps = 60;
    settings.final_fraction = 0.1;
    settings.clip_norm = 10;
    for (size_t k = 0; k < sizeof save_after / sizeof save_after[0]; k++) {
        problem p = make_problem(chained_rosenbrock, 20);
        optim_array a[OPTIM_STATE_CAPACITY], b[OPTIM_STATE_CAPACITY];
        optim_optimizer *one = create_adam(20, x, &settings, NULL);
        optim_optimizer *two = create_adam(20, zero, &settings, NULL);
        for (int i = 0; i < save_after[k]; i++) {
            step_by(one, objective, &p);
        }
        const int count = optim_state(one, a);
        copy_state(b, a, optim_state(two, b), count);
        assert_null(optim_state_check(two));
        for (int i = 0; i < 50; i++) {
            assert_int_equal(step_by(one, objective, &p), OPTIM_RUNNING);
            assert_int_equal(step_by(two, objective, &p), OPTIM_RUNNING);
            assert_same_state(a, b, count);
        }
        optim_free(one);
        optim_free(two);
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
        optim_optimizer *one = make_lbfgs(20, x, 7);
        optim_optimizer *two = make_lbfgs(20, zero, 7);
        run(one, &p, save_after[k]);
        const int count = optim_state(one, a);
        copy_state(b, a, optim_state(two, b), count);
        assert_null(optim_state_check(two));
        for (int i = 0; i < 50; i++) {
            assert_int_equal(run(one, &p, 1), OPTIM_RUNNING);
            assert_int_equal(run(two, &p, 1), OPTIM_RUNNING);
            assert_same_state(a, b, count);
        }
        optim_free(one);
        optim_free(two);
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
    optim_optimizer *lbfgs = make_lbfgs(4, x, 3);
    run(lbfgs, &p, 5);
    const int count = optim_state(lbfgs, a);
    assert_int_equal(optim_state(lbfgs, a), count);
    for (int i = 0; i < count - 1; i++) {
        const double good = a[i].data[0];
        a[i].data[0] = NAN;
        assert_int_equal(strncmp(optim_state_check(lbfgs), a[i].name, strlen(a[i].name)), 0);
        a[i].data[0] = good;
        assert_null(optim_state_check(lbfgs));
    }
    assert_string_equal(a[count - 1].name, "scalars");
    int stopped = 0;
    for (size_t i = 0; i < a[count - 1].count; i++) {
        double *scalar = a[count - 1].data + i;
        const double good = *scalar;
        *scalar = -1.5; /* no counter; but a value, best value or step may be */
        if (optim_state_check(lbfgs)) {
            assert_int_equal(run(lbfgs, &p, 1), OPTIM_BAD_STATE);
            stopped++;
        }
        *scalar = good;
    }
    assert_int_equal(stopped, (int)a[count - 1].count - 3);
    optim_free(lbfgs);
    const optim_settings settings = optim_settings_defaults(OPTIM_ADAM);
    optim_optimizer *adam = create_adam(4, x, &settings, NULL);
    const int adam_count = optim_state(adam, a);
    for (int i = 0; i < adam_count; i++) {
        const double good = a[i].data[0];
        a[i].data[0] = NAN;
        assert_int_equal(strncmp(optim_state_check(adam), a[i].name, strlen(a[i].name)), 0);
        a[i].data[0] = good;
    }
    a[adam_count - 1].data[0] = 0.5;
    assert_int_equal(step_by(adam, objective, &p), OPTIM_BAD_STATE);
    optim_free(adam);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_schedules),    cmocka_unit_test(test_status_texts),
        cmocka_unit_test(test_validators),   cmocka_unit_test(test_create_refuses),
        cmocka_unit_test(test_allocation),   cmocka_unit_test(test_resume_adam),
        cmocka_unit_test(test_resume_lbfgs), cmocka_unit_test(test_bad_state),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
