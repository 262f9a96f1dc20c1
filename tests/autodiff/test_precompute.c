/* What depends on points alone is taken out of a program, and the program's results stay. */
#include "ad_testing.h"

enum { POINTS = 77, FIXED_MAX = 8 };

/* The tape of a little scene: a network's output against a forcing of s and t, weights per point.
 */
typedef struct little_scene {
    ad_tape *tape;
    ad_value s, t, weight, parameter;
    ad_value outputs[2]; /* loss, gradient */
} little_scene;

static little_scene record(void)
{
    little_scene c = {.tape = ad_tape_create()};
    c.s = ad_input(c.tape, "s", 1);
    c.t = ad_input(c.tape, "t", 1);
    c.weight = ad_input(c.tape, "weight", 1);
    c.parameter = ad_parameter(c.tape, "p", 1, 0);
    ad_value forcing = ad_mul(ad_sin(ad_scale(c.t, 3)), ad_exp(ad_square(c.s)));
    ad_value rate = ad_derivative(forcing, c.t, 2);
    ad_value y = ad_tanh(ad_mul(c.parameter, c.s));
    ad_value residual = ad_sub(ad_add(ad_derivative(y, c.s, 1), rate), forcing);
    c.outputs[0] = ad_sum_points(ad_mul(ad_sin(c.weight), ad_square(residual)));
    ad_reverse(c.outputs[0], 1, &c.parameter, AD_SUMMED, &c.outputs[1]);
    assert_tape_ok(c.tape);
    return c;
}

static ad_program *compile(ad_pool *pool, int count, const ad_value *outputs)
{
    ad_program *program;
    ad_error error = {AD_OK, ""};
    if (ad_compile(count, outputs, NULL, pool, &program, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return program;
}

static void run(ad_program *program, const double *const *inputs, double *const *outputs)
{
    double parameter = 0.7;
    ad_run r = {.points = POINTS, .inputs = inputs, .parameters = &parameter, .outputs = outputs};
    assert_int_equal(ad_execute(program, &r, NULL), AD_OK);
}

static void fill(double numbers[3][POINTS])
{
    uint64_t state = 7;
    for (int i = 0; i < 3 * POINTS; i++) {
        numbers[i / POINTS][i % POINTS] = random_in(&state, 0.1, 0.9);
    }
}

static void test_results_stay(void **state)
{
    (void)state;
    static double points[3][POINTS], kept[FIXED_MAX][POINTS];
    double loss[2], gradient[2];
    const double *inputs[3 + FIXED_MAX] = {points[0], points[1], points[2]};
    double *fixed_out[FIXED_MAX];
    little_scene c = record();
    ad_pool *pool = ad_pool_create(1);
    fill(points);
    ad_program *whole = compile(pool, 2, c.outputs);
    run(whole, inputs, (double *[]){&loss[0], &gradient[0]});

    ad_value fixed[FIXED_MAX];
    int count;
    assert_int_equal(ad_precompute(2, c.outputs, 1, &c.weight, 1, FIXED_MAX, fixed, &count), AD_OK);
    assert_int_equal(count, 2); /* rate and forcing; sin(weight) may change */
    for (int i = 0; i < count; i++) {
        assert_int_equal(ad_rows(fixed[i]), 1);
        fixed_out[i] = kept[i];
        inputs[3 + i] = kept[i];
    }
    ad_program *once = compile(pool, count, fixed), *often = compile(pool, 2, c.outputs);
    run(once, inputs, fixed_out);
    run(often, inputs, (double *[]){&loss[1], &gradient[1]});
    /* the same operations but for contractions across the cut: a few roundings of 77 terms */
    assert_true(fabs(loss[1] - loss[0]) < 1e-13 * fabs(loss[0]));
    assert_true(fabs(gradient[1] - gradient[0]) < 1e-13 * fabs(gradient[0]));
    assert_true(ad_program_inspect(often).instructions < ad_program_inspect(whole).instructions);
    ad_program_free(whole);
    ad_program_free(once);
    ad_program_free(often);
    ad_pool_free(pool);
    ad_tape_free(c.tape);
}

static void test_limits(void **state)
{
    (void)state;
    ad_value fixed[FIXED_MAX];
    int count;
    little_scene c = record();
    int loss = c.outputs[0].id;
    assert_int_equal(ad_precompute(2, c.outputs, 1, &c.weight, 1, 0, fixed, &count), AD_OK);
    assert_int_equal(count, 0); /* no rows to spend */
    assert_int_equal(c.outputs[0].id, loss);
    assert_int_equal(ad_precompute(2, c.outputs, 1, &c.weight, 1000, FIXED_MAX, fixed, &count),
                     AD_OK);
    assert_int_equal(count, 0); /* nothing is worth it */
    ad_value all[3] = {c.s, c.t, c.weight};
    assert_int_equal(ad_precompute(2, c.outputs, 3, all, 1, FIXED_MAX, fixed, &count), AD_OK);
    assert_int_equal(count, 0); /* every input may change */
    ad_tape_free(c.tape);
}

static void test_failed_tape(void **state)
{
    (void)state;
    ad_value fixed[FIXED_MAX];
    int count = 5;
    little_scene c = record();
    ad_tape_fail(c.tape, AD_BAD_ARGUMENT, "on purpose");
    assert_int_equal(ad_precompute(2, c.outputs, 0, NULL, 1, FIXED_MAX, fixed, &count),
                     AD_BAD_ARGUMENT);
    assert_int_equal(count, 0);
    ad_tape_free(c.tape);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_results_stay),
        cmocka_unit_test(test_limits),
        cmocka_unit_test(test_failed_tape),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
