/* Equilibria under loads that have no energy: followers, and dead moments in space. Vibrations
 * about them are judged, at critical loads that are known. */
#include "jump_testing.h"

#include "physics/solve/stability.h"

static const double L = 2, EI = 3;

/* Upright, of 1 kg/m and hardly any rotary inertia. */
static scene column(scene_motion motion)
{
    scene given = slender_scene(L, EI, 2);
    given.motion = motion;
    set_numbers(given.rod.rotary_inertia, 3, (double[]){1e-7, 1e-7, 2e-7});
    return given;
}

/* P and the weight p L, downwards; in EI/L^2. */
static scene pressed(double P, double p, scene_frame frame, scene_motion motion)
{
    scene given = column(motion);
    if (P != 0) {
        load_tip(&given, (double[]){0, 0, -P * EI / (L * L)}, NULL);
        given.loads.tip.frame = frame;
        for (int i = 0; i < 3; i++) {
            given.loads.tip.moment[i] = Q(NULL);
        }
    }
    if (p != 0) {
        set_numbers(given.loads.gravity, 3, (double[]){0, 0, -p * EI / (L * L * L)});
    }
    return given;
}

/* Of the straight column, which is an equilibrium under all these loads. */
static stability look(const scene *given)
{
    enum { N = STABILITY_POINTS, COLUMNS = sizeof(rod_values) / sizeof(double) };
    static double values[COLUMNS * N];
    double s[N];
    stability found = {.modes = -1};
    assert_int_equal(stability_points(given, s, NULL), AD_OK);
    for (int i = 0; i < N; i++) {
        const rod_values at = {.r = {0, 0, s[i]}, .q = {1}, .v = {0, 0, 1}};
        for (int column = 0; column < COLUMNS; column++) {
            values[column * N + i] = ((const double *)&at)[column];
        }
    }
    assert_int_equal(stability_of_motion(given, values, &found, NULL), AD_OK);
    assert_string_equal(found.unknown, "");
    return found;
}

/* The least load in EI/L^2 at which `of` is lost, below 40; what is found just beyond. */
static double critical(scene of(double load), stability *there)
{
    double low = 0, high = 40;
    for (int step = 0; step < 17; step++) {
        const double middle = (low + high) / 2;
        const scene given = of(middle);
        const stability found = look(&given);
        *there = stability_is_lost(&found) ? found : *there;
        *(stability_is_lost(&found) ? &high : &low) = middle;
    }
    return (low + high) / 2;
}

static scene euler(double P)
{
    return pressed(P, 0, SCENE_DEAD, SCENE_PLANAR);
}

static scene greenhill(double p)
{
    return pressed(0, p, SCENE_DEAD, SCENE_SPATIAL);
}

static scene beck(double P)
{
    return pressed(P, 0, SCENE_FOLLOWER, SCENE_PLANAR);
}

static scene beck_in_space(double P)
{
    return pressed(P, 0, SCENE_FOLLOWER, SCENE_SPATIAL);
}

static scene beck_damped(double P)
{
    scene given = beck(P);
    given.rod.relaxation_time = Q(1e-3 * L * L / sqrt(EI));
    return given;
}

/* Where loads have an energy vibrations say what the second variation does: Euler's pi^2/4, and
 * 7.83735 of a column under its own weight (Greenhill 1881). Off by less than
 * the 3e-4 to which 17 halvings tell it. */
static void test_energy(void **state)
{
    (void)state;
    stability there = {.modes = -1};
    assert_near(critical(euler, &there), PI * PI / 4, 5e-4);
    assert_true(there.frequency == 0);
    assert_near(critical(greenhill, &there), 7.83735, 5e-4);
}

/* Beck 1952: flutter at 20.0509, at 11.016 (EI/rhoA)^(1/2)/L^2; a ratio of 0.01, below which
 * nothing is called lost, is met 1e-3 beyond. With a little damping of the material 10.94
 * (Bolotin 1963, Nonconservative Problems of the Theory of Elastic Stability). */
static void test_beck(void **state)
{
    (void)state;
    stability there = {.modes = -1};
    assert_near(critical(beck, &there), 20.0509, 4e-3);
    assert_near(there.frequency * L * L / sqrt(EI), 11.016, 0.02);
    assert_true(there.growth > 0 && !there.damped);
    assert_near(critical(beck_in_space, &there), 20.0509, 4e-3);
    assert_near(critical(beck_damped, &there), 10.94, 0.03);
    assert_true(there.damped);
}

/* Clamped, pushed down at an end that slides along it. */
static scene pushed(double P, scene_end_type type)
{
    scene given = pressed(P, 0, SCENE_FOLLOWER, SCENE_PLANAR);
    given.end.type = type;
    set_numbers(given.end.position, 3, (double[]){0, 0, L});
    set_numbers(given.end.along, 3, (double[]){0, 0, 1});
    if (type == SCENE_GUIDED) {
        set_numbers(given.end.rotation, 4, (double[]){1, 0, 0, 0});
    }
    return given;
}

static scene rolling(double P)
{
    return pushed(P, SCENE_ROLLER);
}

static scene guided(double P)
{
    return pushed(P, SCENE_GUIDED);
}

/* What holds the end takes what is across of a follower, so Euler's loads remain: tan x = x and 4
 * pi^2 (Timoshenko and Gere 1961, 2.4), without flutter. Vibrations are those that leave the end
 * where it is held. */
static void test_held_end(void **state)
{
    (void)state;
    stability there = {.modes = -1};
    assert_near(critical(rolling, &there), 20.190728556, 5e-4);
    assert_true(there.frequency == 0);
    assert_near(critical(guided, &there), 39.4784176, 5e-4);
    assert_true(there.frequency == 0);
}

static verdict judged(const scene *given)
{
    const solved x = solve_rest_of(given);
    const solve_settings settings = solve_settings_default(given);
    verdict result = {0};
    solution_verdict(x.solution, given, &settings, &x.report, &result);
    solution_free(x.solution);
    return result;
}

/* A column beyond its critical weight, pushed aside by a moment or a follower that hardly count;
 * and below it. */
static void test_pushed_aside(void **state)
{
    (void)state;
    for (int i = 0; i < 6; i++) {
        const bool heavy = i % 2;
        scene given = pressed(0, heavy ? 12 : 6, SCENE_DEAD, SCENE_SPATIAL);
        load_tip(&given, i < 2 ? NULL : (double[]){1e-3, 2e-4, 0},
                 i < 2 ? (double[]){1e-3, 0, 0} : NULL);
        given.loads.tip.frame = i / 2 == 1 ? SCENE_FOLLOWER : SCENE_DEAD;
        for (int k = 0; k < 3 && i >= 2; k++) {
            given.loads.tip.moment[k] = Q(NULL);
        }
        const verdict found = judged(&given);
        const bool bent = i >= 4; /* dead forces lead along the true path */
        assert_int_equal(verdict_has(&found, VERDICT_UNSTABLE), heavy && !bent);
        assert_false(verdict_has(&found, VERDICT_STABILITY_OPEN));
    }
}

/* What vibrations by strain modes cannot take is said. */
static void test_not_known(void **state)
{
    (void)state;
    scene given = column(SCENE_SPATIAL);
    given.rod.model = SCENE_COSSERAT; /* it stretches */
    set_numbers(given.rod.shear_stiffness, 2, (double[]){1e3, 1e3});
    given.rod.axial_stiffness = Q(1e3);
    given.end = given.start;
    given.start = (scene_end){.type = SCENE_FREE};
    set_numbers(given.end.position, 3, (double[]){0, 0, L});
    scene_point *point = add_point(&given, 1, SCENE_FOLLOWER, (double[]){0.1, 0, 0}, NULL);
    verdict found = judged(&given);
    assert_true(verdict_has(&found, VERDICT_STABILITY_OPEN));
    assert_int_equal(verdict_outcome_of(&found), VERDICT_SOLVED);
    point->load.frame = SCENE_DEAD;
    found = judged(&given);
    assert_false(verdict_has(&found, VERDICT_STABILITY_OPEN));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_energy),    cmocka_unit_test(test_beck),
        cmocka_unit_test(test_held_end),  cmocka_unit_test(test_pushed_aside),
        cmocka_unit_test(test_not_known),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
