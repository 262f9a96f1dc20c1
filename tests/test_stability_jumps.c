/* Columns on springs and with joints, at critical loads that are known in closed form. On elements
 * of 1/128 they are within 0.1%. */
#include "jump_testing.h"

#include "physics/solve/stability.h"

static const double L = 2, EI = 3;

/* Upright, pushed down by P at its end; in space and, where its formulas show it, in a plane. */
static scene column(double P, scene_motion motion)
{
    scene given = slender_scene(L, EI, 2);
    given.motion = motion;
    load_tip(&given, (double[]){0, 0, -P}, NULL);
    for (int i = 0; i < 3; i++) {
        given.loads.tip.moment[i] = Q(NULL);
    }
    return given;
}

static int ways_of(const scene *given)
{
    double at[STABILITY_POINTS], values[sizeof(rod_values) / sizeof(double) * STABILITY_POINTS];
    int columns = sizeof(rod_values) / sizeof(double), ways = -2;
    solved x = solve_rest_of(given);
    stability_points(given, at);
    assert_int_equal(
        solution_evaluate(x.solution, columns, STABILITY_POINTS, at, NULL, values, NULL), AD_OK);
    assert_int_equal(stability_count(given, values, &ways, NULL), AD_OK);
    solution_free(x.solution);
    return ways;
}

/* Clamped, its end on springs of stiffness k: tan(x)/x = 1 - x^2 EI/k L^3, P = x^2 EI/L^2
 * (Timoshenko and Gere 1961, Theory of Elastic Stability, 2.2). */
static void test_held_tip(void **state)
{
    (void)state;
    for (int i = 0; i < 3; i++) {
        const double k = (double[]){0.5, 4, 1e5}[i];
        double low = PI / 2, high = 4.4934095, x = 0;
        for (int step = 0; step < 60; step++) { /* tan rises from -infinity there */
            x = (low + high) / 2;
            bool below = tan(x) / x < 1 - x * x * EI / (k * L * L * L);
            low = below ? x : low;
            high = below ? high : x;
        }
        for (int side = 0; side < 2; side++) {
            scene given = column((side ? 1.005 : 0.995) * x * x * EI / (L * L), SCENE_SPATIAL);
            add_spring(&given, L, (double[]){k, k, 0}, NULL);
            assert_int_equal(ways_of(&given), side ? 2 : 0); /* to both sides */
            given = column((side ? 1.005 : 0.995) * x * x * EI / (L * L), SCENE_PLANAR);
            add_spring(&given, L, (double[]){k, k, 0}, NULL);
            assert_int_equal(ways_of(&given), side ? 1 : 0);
        }
    }
}

/* Pinned on a spring that turns by c: x tan x = c L/EI. */
static void test_turning_base(void **state)
{
    (void)state;
    const double c = 1.7;
    double low = 0, high = PI / 2;
    for (int step = 0; step < 60; step++) {
        double x = (low + high) / 2;
        bool below = x * tan(x) < c * L / EI;
        low = below ? x : low;
        high = below ? high : x;
    }
    for (int side = 0; side < 2; side++) {
        scene given = column((side ? 1.005 : 0.995) * low * low * EI / (L * L), SCENE_PLANAR);
        given.start.type = SCENE_PINNED;
        given.start.rotation[0] = Q(NULL);
        add_spring(&given, 0, NULL, (double[]){c, c, c});
        assert_int_equal(ways_of(&given), side);
    }
}

/* A stiff rod on springs alone, k across at both ends: it tilts under k L/2; and a soft one on
 * stiff springs bends under Euler's load, pi^2 EI/L^2. */
static void test_on_springs_alone(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        double k = i ? 1e5 : 1e-2, critical = i ? PI * PI * EI / (L * L) : k * L / 2;
        for (int side = 0; side < 2; side++) {
            scene given = column((side ? 1.005 : 0.995) * critical, SCENE_PLANAR);
            given.start = (scene_end){.type = SCENE_FREE};
            add_spring(&given, 0, (double[]){k, k, 10}, NULL);
            add_spring(&given, L, (double[]){k, k, 0}, NULL);
            assert_int_equal(ways_of(&given), side);
        }
    }
}

/* A joint that twists a round column, and a load within it: that of the part below. */
static void test_joint_and_point(void **state)
{
    (void)state;
    const double a = 1.1, euler = PI * PI * EI / (4 * a * a);
    for (int side = 0; side < 2; side++) {
        scene given = column(0, SCENE_SPATIAL);
        given.end.type = SCENE_FREE;
        add_segment(&given, 0.7, NULL);
        add_segment(&given, L - 0.7, (double[]){0, 0, 1.1});
        add_point(&given, a, SCENE_DEAD, (double[]){0, 0, -(side ? 1.005 : 0.995) * euler}, NULL);
        assert_int_equal(ways_of(&given), 2 * side);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_held_tip),
        cmocka_unit_test(test_turning_base),
        cmocka_unit_test(test_on_springs_alone),
        cmocka_unit_test(test_joint_and_point),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
