/* Loads of a whole rod or beam at rest against its ends: what a shape leaves out is found. */
#include "jump_testing.h"

#include <math.h>

/* A straight rod along z, or a beam, without force and moment: the answer of a solver that has not
 * seen a load. */
static ad_status straight(const void *context, size_t n, const double *s, double *values,
                          ad_error *error)
{
    const scene *given = context;
    int columns = solution_columns(given);
    (void)error;
    memset(values, 0, (size_t)columns * n * sizeof *values);
    for (size_t i = 0; i < n && !scene_is_beam(given); i++) {
        values[2 * n + i] = s[i]; /* z, qw, v3 */
        values[3 * n + i] = values[9 * n + i] = 1;
    }
    return AD_OK;
}

/* Of sums of absolute values; bending and length are 1. */
static void assert_rest(const scene *given, double force, double moment, double size)
{
    double balance;
    ad_error error;
    assert_int_equal(solve_balance(given, straight, given, &balance, &error), AD_OK);
    assert_near(balance, fmax(force, moment) / (1 + size), 1e-13);
    verdict said = {0};
    solve_judge_balance(balance, 1e-10, &said);
    assert_int_equal(verdict_worst(&said),
                     fmax(force, moment) > 0 ? VERDICT_LOADS_OUT_OF_BALANCE : VERDICT_NONE);
}

/* Bands of any width, anywhere. */
static void test_bands(void **state)
{
    (void)state;
    for (double width = 0.3; width > 1e-4; width /= 7) {
        double at = 0.61803, force = 2 * width, moment = force * (at + width / 2);
        char text[80];
        snprintf(text, sizeof text, "where((s-%.17g)*(%.17g-s), -2, 0)", at, at + width);
        scene given = slender_scene(1, 1, 1), beam = given;
        assert_rest(&given, 0, 0, 0);
        set_quantities(given.loads.force, 3, (const char *const[]){text, "0", "0"});
        assert_rest(&given, force, moment, force + moment);
        given.loads.frame = SCENE_FOLLOWER;
        assert_rest(&given, force, moment, force + moment);
        beam.rod.model = SCENE_EULER_BERNOULLI;
        beam.beam.force = Q((const char *)text);
        double balance;
        ad_error error;
        assert_int_equal(solve_balance(&beam, straight, &beam, &balance, &error), AD_OK);
        assert_true(balance > 0.05 * width); /* in a deflection of the beam's own */
    }
}

/* What acts at places, the end among them; a support takes what acts on it. */
static void test_places(void **state)
{
    (void)state;
    const double F[3] = {0, 0.3, 0}, T[3] = {0.2, 0, 0}, k[3] = {4, 0, 0};
    scene given = slender_scene(1, 1, 1);
    add_point(&given, 0.25, SCENE_DEAD, F, NULL);
    assert_rest(&given, 0.3, 0.3 * 0.25, 0.3 * 1.25);
    given = slender_scene(1, 1, 1);
    add_point(&given, 0.25, SCENE_FOLLOWER, NULL, T);
    assert_rest(&given, 0, 0.2, 0.2);
    for (int end = 0; end < 2; end++) {
        given = slender_scene(1, 1, 1);
        set_numbers(add_spring(&given, end, k, NULL)->anchor, 3, (double[]){0.1, 0, end});
        assert_rest(&given, end ? 0.4 : 0, end ? 0.4 : 0, end ? 0.8 : 0);
    }
    given = slender_scene(1, 1, 1);
    load_tip(&given, F, T);
    assert_rest(&given, 0.3, fabs(0.2 - 0.3), 0.3 + 0.3 + 0.2);
    for (int held = 0; held < 2; held++) { /* an end that slides along the force, or across it */
        given = slender_scene(1, 1, 1);
        load_tip(&given, F, NULL);
        given.end.type = SCENE_ROLLER;
        set_numbers(given.end.position, 3, (double[]){0, 0, 1});
        set_numbers(held ? given.end.across : given.end.along, 3, (double[]){0, 1, 0});
        assert_rest(&given, held ? 0 : 0.3, held ? 0 : 0.3, held ? 0 : 0.6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_bands), cmocka_unit_test(test_places)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
