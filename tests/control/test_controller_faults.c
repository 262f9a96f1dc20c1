/* Predictive control with faults: states that are missing, not finite, outside; a model without an
 * answer; programs without the time they need; late calls; settings that are none. Whatever
 * happens, inputs are finite and keep their limits. */
#include "allocations.h"
#include "control_testing.h"
#include "random_numbers.h"

#include <float.h>

static const double rest[2] = {0};

typedef struct loop {
    controller *c;
    controller_sample sample;
    double reference[HORIZON], u[1];
} loop;

static void make_loop(loop *x, const controller_settings *settings)
{
    x->c = make_controller(settings);
    x->sample = (controller_sample){.state = rest, .reference = x->reference};
    for (int i = 0; i < HORIZON; i++) {
        x->reference[i] = 0.5;
    }
}

/* Flags of a feedback; the input has to be within limits whatever they are. */
static int feedback(loop *x, const double *state)
{
    const double before = x->u[0];
    int flags;

    x->sample.state = state;
    flags = controller_feedback(x->c, &x->sample, x->u);
    assert_true(x->u[0] >= -8.0 && x->u[0] <= 8.0);
    assert_true(fabs(x->u[0] - before) <= 2.0 + 8 * DBL_EPSILON);
    return flags;
}

/* Without states the plan is made for those the model foresees, and so is what it would be with
 * them; after `coast` samples the input is held; then a state is enough. */
static void test_missing(void **state)
{
    const double bad[2] = {0.1, NAN};
    controller_settings settings = pendulum_settings();
    loop x = {0}, y = {0};
    double now[2] = {0}, inputs[2] = {0, 1}, held;

    (void)state;
    settings.coast = 6;
    make_loop(&x, &settings);
    make_loop(&y, &settings);
    assert_int_equal(feedback(&y, NULL), CONTROLLER_STATE | CONTROLLER_HELD); /* from the first */
    free(y.c);
    y.u[0] = 0.0;
    make_loop(&y, &settings);
    for (int k = 0; k < 10; k++) {
        double next[2][5];
        const bool lost = k >= 2 && k < 8;

        inputs[0] = x.u[0];
        assert_int_equal(feedback(&x, now), 0);
        assert_int_equal(feedback(&y, !lost        ? now
                                      : k % 2 == 0 ? NULL
                                                   : bad),
                         lost ? CONTROLLER_STATE : 0);
        assert_memory_equal(x.u, y.u, sizeof x.u);
        (void)controller_prepare(x.c);
        pendulum_step(0.05, now, inputs, next);
        now[0] = next[0][0];
        now[1] = next[1][0];
    }
    for (int k = 0; k < 6; k++) {
        assert_int_equal(feedback(&y, NULL), CONTROLLER_STATE);
    }
    held = y.u[0];
    for (int k = 0; k < 30; k++) {
        assert_int_equal(feedback(&y, NULL), CONTROLLER_STATE | CONTROLLER_HELD);
        assert_true(y.u[0] == held);
        assert_int_equal(controller_prepare(y.c), 0);
    }
    assert_int_equal(feedback(&y, now), 0);
    free(x.c);
    free(y.c);
}

static void test_outside(void **state)
{
    const double far[2] = {2.5, 0};
    controller_settings settings = pendulum_settings();
    loop x = {0};

    (void)state;
    make_loop(&x, &settings);
    assert_int_equal(feedback(&x, far), CONTROLLER_OUTSIDE);
    free(x.c);
    settings.outside = 1.2;
    x.u[0] = 0.0;
    make_loop(&x, &settings);
    assert_int_equal(feedback(&x, rest), 0);
    assert_int_equal(feedback(&x, far), CONTROLLER_STATE | CONTROLLER_OUTSIDE);
    free(x.c);
}

/* Whichever call of the model fails, the plan goes on as it was, and the next sample is well. */
static void test_model(void **state)
{
    (void)state;
    for (int i = 0; i < 2 * 40; i++) {
        controller_settings settings = pendulum_settings();
        loop x = {0};
        double planned;
        int flags, prepared;
        long calls;

        the_pendulum.silent = i % 2 == 1;
        make_loop(&x, &settings);
        for (int k = 0; k < 3; k++) {
            assert_int_equal(feedback(&x, rest), 0);
            assert_int_equal(controller_prepare(x.c), 0);
        }
        planned = controller_plan(x.c)[0];
        the_pendulum.failing = the_pendulum.calls + 1 + i / 2;
        calls = the_pendulum.failing;
        flags = feedback(&x, rest);
        if (flags != 0) {
            assert_int_equal(flags, CONTROLLER_MODEL);
            assert_true(x.u[0] == planned);
        }
        prepared = controller_prepare(x.c);
        assert_true(prepared == 0 || prepared == CONTROLLER_MODEL);
        flags = feedback(&x, rest);
        assert_true(flags == 0 || the_pendulum.calls >= calls);
        the_pendulum.failing = 0;
        assert_int_equal(feedback(&x, rest), 0);
        assert_int_equal(feedback(&x, rest), 0);
        free(x.c);
    }
}

/* With a tenth of the iterations it needs, it comes to the same end later. */
static void test_limit(void **state)
{
    controller_settings settings = pendulum_settings();
    loop x = {0};
    double now[2] = {0};
    int flags = 0;

    (void)state;
    settings.qp_limit = 2;
    make_loop(&x, &settings);
    for (int k = 0; k < 150; k++) {
        const double inputs[2] = {x.u[0], 1};
        double next[2][5];

        flags = feedback(&x, now);
        if (k == 0) {
            assert_int_equal(flags, CONTROLLER_QP_LIMIT);
            assert_true(x.u[0] > 0.0); /* on the way, not where it was */
        }
        pendulum_step(0.05, now, inputs, next);
        now[0] = next[0][0];
        now[1] = next[1][0];
    }
    assert_int_equal(flags, 0);
    assert_near(now[0], 0.5, 1e-3); /* but for what `effort` asks for */
    free(x.c);
}

static void test_sample(void **state)
{
    double others[2] = {NAN, 1.3};
    controller_settings settings = pendulum_settings();
    loop x = {0};

    (void)state;
    make_loop(&x, &settings);
    x.sample.others = others; /* of a controlled input nothing is read */
    assert_int_equal(feedback(&x, rest), 0);
    others[1] = NAN;
    x.reference[3] = -INFINITY;
    assert_int_equal(feedback(&x, rest), CONTROLLER_OTHERS | CONTROLLER_REFERENCE);
    free(x.c);
}

/* Samples in which no call came are as those without a state. */
static void test_late(void **state)
{
    controller_settings settings = pendulum_settings();
    loop x = {0}, y = {0};

    (void)state;
    for (int delay = 0; delay < 3; delay++) {
        double planned[3];

        settings.delay = delay;
        settings.offset = 0.3;
        x.u[0] = y.u[0] = 0.0;
        make_loop(&x, &settings);
        make_loop(&y, &settings);
        assert_int_equal(feedback(&x, rest), 0);
        assert_int_equal(feedback(&y, rest), 0);
        memcpy(planned, controller_plan(x.c), sizeof planned);
        controller_skip(x.c, 3);
        controller_applied(x.c, 0, &planned[2]); /* which it knew */
        for (int i = 0; i < 3; i++) {
            /* y makes new plans, and is told that the old one was applied */
            assert_int_equal(feedback(&y, NULL), CONTROLLER_STATE);
            controller_applied(y.c, 0, &planned[i]);
            y.u[0] = planned[i];
        }
        x.u[0] = planned[2];
        assert_int_equal(feedback(&x, NULL), CONTROLLER_STATE);
        assert_int_equal(feedback(&y, NULL), CONTROLLER_STATE);
        assert_near(x.u[0], y.u[0], 1e-3); /* one iteration each, from other plans */
        controller_skip(x.c, 1000000000);
        (void)controller_prepare(x.c);
        x.u[0] = controller_plan(x.c)[0];
        assert_int_equal(feedback(&x, NULL), CONTROLLER_STATE | CONTROLLER_HELD);
        assert_int_equal(feedback(&x, rest), 0);
        free(x.c);
        free(y.c);
    }
}

/* Anything at any time. */
static void test_anything(void **state)
{
    uint64_t seed = 9;

    (void)state;
    for (int run = 0; run < 12; run++) {
        const double upper[1] = {0.3}, soft[1] = {100};
        controller_settings settings = pendulum_settings();
        loop x = {0};

        settings.delay = run % 3;
        settings.horizon = 1 + run;
        settings.moves = 1 + run / 2;
        settings.offset = 0.5;
        settings.soft_upper = upper;
        settings.soft_weight = soft;
        settings.qp_limit = run < 6 ? 0 : 5;
        make_loop(&x, &settings);
        for (int k = 0; k < 150; k++) {
            const double strange[5] = {0, NAN, INFINITY, 1e300, -1e6};
            double now[2], measured[1], others[2];

            now[0] = random_in(&seed, -3, 3) + strange[random_below(&seed, 12) % 10 % 5];
            now[1] = random_in(&seed, -9, 9);
            measured[0] = strange[random_below(&seed, 5)];
            others[0] = strange[random_below(&seed, 5)];
            others[1] = random_in(&seed, 0, 2) + strange[random_below(&seed, 5) % 4];
            x.sample.measured = random_below(&seed, 2) ? measured : NULL;
            x.sample.others = others;
            x.reference[random_below(&seed, HORIZON)] = strange[random_below(&seed, 5)];
            the_pendulum.failing = the_pendulum.calls + random_below(&seed, 40);
            the_pendulum.silent = random_below(&seed, 2);
            (void)feedback(&x, random_below(&seed, 4) ? now : NULL);
            (void)controller_prepare(x.c);
        }
        free(x.c);
    }
}

/* Nothing is allocated, nothing written beyond the memory that was asked for, and the same calls
 * give the same bits in any memory. */
static void test_memory(void **state)
{
    controller_settings settings = pendulum_settings();
    double answers[2][30];

    (void)state;
    for (int i = 0; i < 2; i++) {
        const size_t size = controller_size(&settings);
        unsigned char *memory = malloc(size + 32);
        long before;
        loop x = {0};

        memset(memory, i % 2 == 0 ? 0xff : 0x55, size + 32);
        before = allocations;
        make_loop(&x, &settings);
        free(x.c);
        assert_int_equal(allocations, before + 1); /* of make_controller */
        x.c = controller_init(memory + 16, &settings);
        for (int k = 0; k < 30; k++) {
            const double now[2] = {0.01 * k, 0.1};

            (void)feedback(&x, now);
            (void)controller_prepare(x.c);
            answers[i % 2][k] = x.u[0];
        }
        assert_int_equal(allocations, before + 1);
        for (int k = 0; k < 16; k++) {
            assert_true(memory[k] == memory[0] && memory[size + 16 + k] == memory[0]);
        }
        free(memory);
        if (i % 2 == 1) {
            assert_memory_equal(answers[0], answers[1], sizeof answers[0]);
        }
    }
}

static void refuse(const controller_settings *settings, const char *part)
{
    const char *wrong = controller_refusal(settings);

    assert_non_null(wrong);
    assert_non_null(strstr(wrong, part));
}

static void test_refusals(void **state)
{
    const controller_settings good = pendulum_settings();
    const double nothing[1] = {NAN}, high[1] = {9};
    const int wrong_input[1] = {2};
    controller_settings s = good;

    (void)state;
    assert_null(controller_refusal(&good));
#define REFUSED(field, value, part)                                                                \
    s = good;                                                                                      \
    s.field = value;                                                                               \
    refuse(&s, part)
    REFUSED(observation.values, 0, "model and observation");
    REFUSED(horizon, 0, "horizon");
    REFUSED(moves, 21, "moves");
    REFUSED(qp_limit, -1, "limits");
    REFUSED(inputs, wrong_input, "does not have");
    REFUSED(upper, nothing, "finite");
    REFUSED(lower, high, "below");
    REFUSED(rate, rest, "rates");
    REFUSED(effort, nothing, "weights of inputs");
    REFUSED(rest, high, "at rest");
    REFUSED(weight, nothing, "what is seen");
    REFUSED(soft_upper, high, "positive weight");
    REFUSED(soft_lower, nothing, "soft limit");
    REFUSED(offset, 2, "offset");
    REFUSED(others, NULL, "others");
#undef REFUSED
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_missing),  cmocka_unit_test(test_outside),
        cmocka_unit_test(test_model),    cmocka_unit_test(test_limit),
        cmocka_unit_test(test_sample),   cmocka_unit_test(test_late),
        cmocka_unit_test(test_anything), cmocka_unit_test(test_memory),
        cmocka_unit_test(test_refusals)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
