/* The scene in numbers for classical solvers: scales, loads, ends, initial state. */
#include "config_testing.h"
#include "rod_testing.h"

#include "physics/local/rod_model.h"

static const double rounding = 1e-13; /* some ten operations on numbers up to 100 */

static solve_rod *rod_of(const config *settings)
{
    ad_error error = {.message = ""};
    solve_rod *rod = NULL;
    if (solve_rod_create(&settings->scene, &rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return rod;
}

static const char numbers[] =
    "rod:\n"
    "  model: cosserat\n"
    "  length: 2\n"
    "  stiffness: {shear: [40, .inf], axial: 90, bending: [1.2, 0.8], torsion: 0.5}\n"
    "  inertia: {mass_per_length: 3, rotary: [0.03, 0.02, 0.05]}\n"
    "  rest: {strain: [0.1, 0, 1], curvature: [0.5*s, 0, 2]}\n"
    "  damping: {strain: [0.6, 0, 0.8], curvature: [0.03, 0.02, 0.01]}\n"
    "boundary: {start: {type: driven, position: [0, t^2, 0], rotation: [cos(t), 0, 0, sin(t)]}}\n"
    "loads:\n"
    "  gravity: [0, 0, -10]\n"
    "  drag: 0.7\n"
    "  force: [s*t, 0, 4]\n"
    "  frame: follower\n"
    "  tip: {moment: [0, 6, 0], force: [t, 0, 0]}\n"
    "time: {duration: 3}\n"
    "enforcement: {initial: soft}\n";

/* L = 2, EI = 0.8: force 0.2, moment 0.4, time 4 sqrt(3/0.8). */
static void test_numbers(void **state)
{
    (void)state;
    config *settings = read_config("numbers.yaml", numbers, 0, NULL);
    solve_rod *rod = rod_of(settings);
    double time = 4 * sqrt(3 / 0.8);
    const double s[2] = {0, 0.75};
    solve_section made[2];
    assert_int_equal(solve_rod_sections(rod, 2, s, made, NULL), AD_OK);
    assert_near(made[0].compliance[0], 0.2 / 40, rounding);
    assert_near(made[0].compliance[1], 0, 0); /* locked */
    assert_near(made[0].stiffness[1], 0, 0);
    assert_near(made[0].compliance[3], 0.8 / 1.2, rounding);
    assert_near(made[0].stiffness[5], 0.5 / 0.8, rounding);
    assert_near(made[0].mass, 1, 0);
    assert_near(rod->duration, 3 / time, rounding);
    assert_near(made[0].rotary_inertia[0], 0.03 / (3 * 4), rounding); /* rhoI / (rhoA L^2) */
    assert_near(made[0].damping[0], 0.6 / (0.2 * time), rounding);
    assert_near(made[0].damping[5], 0.01 / (0.8 * time), rounding);
    double along[2 * ACTING_ALONG_MAX];
    const double *end = along + rod->along.numbers;
    assert_int_equal(rod->along.count, 3);
    assert_true(rod->along.law[1] == LAW_FORCE && rod->along.law[2] == LAW_FOLLOWER_FORCE);
    assert_true(rod->along_moves && rod->along.follows);
    assert_int_equal(solve_rod_along(rod, 2, s, 1 / time, along, NULL), AD_OK);
    assert_near(along[0], 0.7 * 4 / (time * 0.2), rounding);
    assert_near(along[1], 0, 0);
    assert_near(end[2 + 2], -3 * 10 * 2 / 0.2, 1e-12); /* rhoA g L^3/EI */
    assert_near(end[2 + 3], 1.5 * 2 / 0.2, rounding);
    assert_near(along[2 + 3], 0, 0);
    assert_near(along[2 + 5], 4 * 2 / 0.2, rounding);

    solve_rest rest[2];
    assert_int_equal(solve_rod_rest(rod, 2, s, 0, rest, NULL), AD_OK);
    assert_near(rest[1].strain[0], 0.1, rounding);
    assert_near(rest[1].curvature[0], 2 * 0.5 * 1.5, rounding);
    assert_near(rest[0].curvature[2], 4, rounding);
    solve_rod_free(rod);
    config_free(settings);
}

/* Turning about d3 by 2t rad and accelerating by 2 m/s^2, dimensionless; the tip is pulled. */
static void test_ends(void **state)
{
    (void)state;
    config *settings = read_config("numbers.yaml", numbers, 0, NULL);
    solve_rod *rod = rod_of(settings);
    double time = rod->scales.time;
    solve_end_state start, end;
    assert_int_equal(solve_rod_end(rod, 0, 0.5 / time, &start, NULL), AD_OK);
    assert_int_equal(solve_rod_end(rod, 1, 0.5 / time, &end, NULL), AD_OK);
    assert_true(rod->ends[0].hold.directions && rod->ends[0].holds_rotation);
    assert_false(rod->ends[1].hold.directions || rod->ends[1].holds_rotation);
    const acting *acts = &rod->jumps.at[0].acting;
    assert_int_equal(rod->jumps.count, 1);
    assert_true(acts->count == 2 && acts->law[0] == LAW_FORCE && acts->law[1] == LAW_MOMENT);
    assert_near(start.position[1], 0.25 / 2, rounding);
    assert_near(start.velocity[1], 1.0 / 2 * time, rounding);
    assert_near(start.acceleration[1], 2.0 / 2 * time * time, 1e-12);
    assert_near(start.rotation[3], sin(0.5), rounding);
    assert_near(start.spin[2], 2 * time, 1e-12);
    assert_near(start.spin_rate[2], 0, 1e-11);
    assert_near(end.moment[1], 6 / 0.4, rounding);
    assert_near(end.force[0], 0.5 / 0.2, rounding);
    solve_rod_free(rod);
    config_free(settings);
}

/* The initial state is the unstressed helix from the clamp: at rest, strains v*, u*. */
static void test_initial(void **state)
{
    (void)state;
    config *settings = read_config("numbers.yaml", numbers, 0, NULL);
    solve_rod *rod = rod_of(settings);
    const double h = 1e-5, s[3] = {0.5 - h, 0.5, 0.5 + h};
    solve_initial at[3];
    assert_int_equal(solve_rod_initial(rod, 3, s, at, NULL), AD_OK);
    const double *q = at[1].rotation;
    double turn[4];
    for (int i = 0; i < 4; i++) {
        turn[i] = (at[2].rotation[i] - at[0].rotation[i]) / (2 * h);
    }
    double twist = 2 * (q[0] * turn[3] - q[3] * turn[0] - q[1] * turn[2] + q[2] * turn[1]);
    assert_near(twist, 4, 1e-8); /* h^2 and rounding over h */
    assert_near(at[1].velocity[1], 0, 0);
    assert_near(at[1].spin[0], 0, 0);
    solve_rod_free(rod);
    config_free(settings);
}

/* The loads of a manufactured scene balance its exact state: N_s + f + R f_body = rhoA r_tt + c r_t
 * by differences along s and t. */
static void test_manufactured(void **state)
{
    (void)state;
    config *settings = read_config("configs/manufactured_dynamic.yaml", NULL, 0, NULL);
    solve_rod *rod = rod_of(settings);
    const double h = 1e-4, s = 0.6, t = 0.4;
    recorded r = begin(&rod->scene);
    rod_state exact = rod_manufactured(&rod->scene, r.s, r.t);
    const double points_s[5] = {s - h, s + h, s, s, s}, points_t[5] = {t, t, t - h, t + h, t};
    double *force = evaluate_at(exact.force, 5, points_s, points_t, NULL);
    double *position = evaluate_at(exact.position, 5, points_s, points_t, NULL);
    double velocity[3], outside[6] = {0}, along[ACTING_ALONG_MAX];
    static const double upright[4] = {1};
    for (int i = 0; i < 3; i++) {
        velocity[i] = (position[5 * i + 3] - position[5 * i + 2]) / (2 * h);
    }
    solve_rod_along(rod, 1, &s, t, along, NULL);
    acting_wrench(&rod->along, along, (acting_on){upright, upright, velocity}, ACTING_ALL, 1,
                  outside);
    for (int i = 0; i < 3; i++) {
        const double *n = force + 5 * i, *x = position + 5 * i;
        double acceleration = (x[2] - 2 * x[4] + x[3]) / (h * h);
        double sum = (n[1] - n[0]) / (2 * h) + outside[i] - acceleration;
        assert_near(sum, 0, 1e-5); /* differences of second order, rounding over h^2 */
    }
    solve_end_state start;
    solve_rod_end(rod, 0, t, &start, NULL);
    assert_near(start.position[0], 0, 0);
    free(force);
    free(position);
    ad_tape_free(r.tape);
    solve_rod_free(rod);
    config_free(settings);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_ends),
        cmocka_unit_test(test_initial),
        cmocka_unit_test(test_manufactured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
