/* Columns on springs and with joints, at critical loads that are known in closed form. Elements of
 * 1/512 have them within 0.1%. */
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
    assert_int_equal(stability_points(given, at, NULL), AD_OK);
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

/* ---- a twisted ring -------------------------------------------------------------------------- */

/* A straight rod of length 1 bent into a ring about x and twisted by `twist`, clamped where it
 * closes: M = B k e_x + C tau t, N = C tau k e_x. In how many directions its energy falls. */
static int ways_of_ring(double B, double C, double twist)
{
    enum { N = STABILITY_POINTS, COLUMNS = sizeof(rod_values) / sizeof(double) };
    double s[N], values[COLUMNS * N];
    const double k = 2 * PI;
    int ways = -2;
    scene given = slender_scene(1, B, C);
    given.end = given.start;
    given.motion = SCENE_SPATIAL;
    assert_int_equal(stability_points(&given, s, NULL), AD_OK);
    for (int i = 0; i < N; i++) {
        double a = cos(k * s[i] / 2), b = sin(k * s[i] / 2); /* bent about x, then twisted */
        double c = cos(twist * s[i] / 2), d = sin(twist * s[i] / 2);
        const double cosine = cos(twist * s[i]), sine = sin(twist * s[i]);
        const rod_values at = {.r = {0, (cos(k * s[i]) - 1) / k, sin(k * s[i]) / k},
                               .q = {a * c, b * c, -b * d, a * d},
                               .v = {0, 0, 1},
                               .u = {k * cosine, -k * sine, twist},
                               .n = {C * twist * k * cosine, -C * twist * k * sine, 0},
                               .m = {B * k * cosine, -B * k * sine, C * twist}};
        for (int column = 0; column < COLUMNS; column++) {
            values[column * N + i] = ((const double *)&at)[column];
        }
    }
    assert_int_equal(stability_count(&given, values, &ways, NULL), AD_OK);
    return ways;
}

/* It writhes beyond the twist 2 pi 3^(1/2) B/C (Zajac 1962, J. Appl. Mech. 29). */
static void test_twisted_ring(void **state)
{
    (void)state;
    for (int i = 0; i < 3; i++) {
        const double B = 2, C = (double[]){1, 1.6, 3}[i], critical = 2 * PI * sqrt(3) * B / C;
        double low = 0.5 * critical, high = 1.2 * critical;
        assert_int_equal(ways_of_ring(B, C, 0), 0);
        for (int step = 0; step < 20; step++) {
            double twist = (low + high) / 2;
            bool stable = ways_of_ring(B, C, twist) == 0;
            low = stable ? twist : low;
            high = stable ? high : twist;
        }
        print_message("a ring of B/C %g writhes at %.9g of Zajac's twist\n", B / C, low / critical);
        assert_near(low / critical, 1, 5e-4); /* by the square of the elements: 2.6e-4 */
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_twisted_ring),    cmocka_unit_test(test_held_tip),
        cmocka_unit_test(test_turning_base),    cmocka_unit_test(test_on_springs_alone),
        cmocka_unit_test(test_joint_and_point),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
