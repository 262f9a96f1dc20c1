/* Tendons and chambers on rods in motion by the classical solver: a known motion, accelerations and
 * power. */
#include "tendon_testing.h"

#include "physics/numerics/quaternion.h"
#include "physics/solve/motion.h"

#include <string.h>

/* Of the motion that is known. */
static scene soft_arm(void)
{
    scene made = robot(0.2, 1e6, 1e6 / 2.9, 0.005);
    made.rod.density = Q(1100.0);
    made.duration = Q(0.5);
    add_tendon(&made, 0.008, 0, 0);
    made.tendons[0].tension = Q("0.3*where(0.1-t, sin(5*pi*t)^2, 1)");
    return made;
}

/* ---- refusals ------------------------------------------------------------------------------ */

static void test_refusals(void **state)
{
    (void)state;
    const char *key = NULL;
    ad_error error;
    scene given = soft_arm();
    const solve_settings by_nodes = {.method = SOLVE_COLLOCATION},
                         by_modes = {.method = SOLVE_MODES};
    given.tendons[0].friction = Q(0.1);
    assert_int_equal(scene_check(&given, &key, &error), AD_OK);
    assert_int_equal(solve_check(&given, &by_nodes, false, &key, &error), AD_BAD_ARGUMENT);
    assert_string_equal(key, "tendons[0].friction");
    assert_int_equal(solve_check(&given, &by_modes, false, &key, &error), AD_OK);
    assert_int_equal(solve_settings_default(&given).method, SOLVE_MODES);
    given = soft_arm();
    given.tendons[0].tension = Q(NULL);
    given.tendons[0].displacement = Q(0.01);
    assert_int_equal(scene_check(&given, &key, &error), AD_BAD_INPUT);
    assert_string_equal(key, "tendons[0].displacement");
    given.tendons[0].stiffness = Q(100.0);
    assert_int_equal(scene_check(&given, &key, &error), AD_OK);
}

/* ---- in motion ------------------------------------------------------------------------------- */

/* Of spectral elements, to 6e-10 m: t, tip, middle. */
static const double ramp[][7] = {
    {0.05, 0.0033297606636050136, 0, 0.19943684896728783, -0.0006179686656230741, 0,
     0.0998055249045323},
    {0.1, 0.01832147273928049, 0, 0.1954162513534742, -0.004850494975295453, 0,
     0.09946400302389234},
    {0.15, 0.03256146920760809, 0, 0.19229162358325702, -0.0007875461584294158, 0,
     0.09952286632162514},
    {0.2, 0.0455170199849158, 0, 0.19213412968554644, 0.01227082419031583, 0, 0.09871101361488073},
    {0.25, 0.07366058316006663, 0, 0.17847876168285381, 0.017163047563325578, 0,
     0.0975406008166043},
    {0.3, 0.09896679823991827, 0, 0.1590588271455805, 0.024309520411363635, 0, 0.09519109680474605},
    {0.35, 0.11698740793950757, 0, 0.1493747059932455, 0.03808862720483849, 0, 0.08991165876378174},
    {0.4, 0.13188854037799766, 0, 0.1314938554165853, 0.04435181469813947, 0, 0.0860385275538506},
    {0.45, 0.13917914874963766, 0, 0.10891325512839602, 0.044334222134869664, 0,
     0.08484298261352412},
    {0.5, 0.1432533071511709, 0, 0.10482601300667403, 0.04773962230516934, 0, 0.08262081081416231}};

enum { TIMES = sizeof ramp / sizeof *ramp };

static double ramp_error(double tolerance, solve_report *report)
{
    double times[TIMES], worst = 0;
    scene given = soft_arm();
    for (int i = 0; i < TIMES; i++) {
        times[i] = ramp[i][0];
    }
    solved x = solve(&given, TIMES, times, tolerance);
    for (int i = 0; i < TIMES; i++) {
        for (int k = 0; k < 6; k++) {
            double pose[7];
            pose_at(&x, k < 3 ? 0.2 : 0.1, times[i], pose);
            worst = fmax(worst, fabs(pose[k % 3] - ramp[i][1 + k]));
        }
    }
    solution_free(x.solution);
    *report = x.report;
    return worst;
}

/* By default, in 0.5 s: what the tolerance allows over what is reached, a few 1e-9 m. */
static void test_ramp(void **state)
{
    (void)state;
    scene given = soft_arm();
    solve_report report;
    double tolerance = solve_settings_default(&given).tolerance;
    double error = ramp_error(tolerance, &report);
    print_message("off by %.1e m, estimate %.1e, energy %.1e\n", error, report.estimate,
                  report.energy_mismatch);
    assert_true(error < 1e-8 && report.estimate <= tolerance);
    assert_true(report.energy_mismatch < 10 * tolerance);
}

/* A motion that is chosen, under loads by the tape, of a damped rod with all that pulls. */
static scene chosen_motion(void)
{
    static const char *const angles[3] = {"2*s*sin(9*t)", "sin(5*s)*cos(7*t)", "9*s^2*t"};
    scene given = robot(0.3, 2e6, 0.7e6, 0.01);
    given.rod.density = Q(1000.0);
    given.rod.viscosity = Q(2000.0);
    given.duration = Q(0.1);
    given.end.type = SCENE_LOADED;
    given.manufactured.position[0] = Q("s^2*t");
    given.manufactured.position[1] = Q("0.1*s*sin(4*s)*cos(9*t)");
    given.manufactured.position[2] = Q("s*(1-0.05*sin(8*t))");
    set_quantities(given.manufactured.angles, 3, angles);
    given.tendon_count = given.chamber_count = 1;
    given.tendons[0] = (scene_tendon){.offset = {Q("0.008*cos(10*s)"), Q("0.008*sin(10*s)")},
                                      .tension = Q("3*(1+sin(20*t))")};
    given.chambers[0] = (scene_chamber){
        .offset = {Q("0.01*s"), Q(0.004)}, .pressure = Q("3e4*t"), .area = Q("1e-4*(1+s)")};
    return given;
}

/* The tension of a tendon of stiffness k that is pulled by d, by its length in a state. */
static double tension_in(motion *m, const double *state, const double offset[2], double k, double d)
{
    enum { NODES_MAX = 64 };
    const double *s = motion_points(m), *weights = motion_weights(m);
    solve_state at[NODES_MAX];
    double longer = d;
    motion_samples(m, state, motion_nodes(m), s, at);
    for (size_t i = 0; i < motion_nodes(m); i++) {
        const double r[3] = {offset[0], offset[1], 0};
        double p[3];
        vector_cross(at[i].curvature, r, p);
        for (int j = 0; j < 3; j++) {
            p[j] += at[i].strain[j];
        }
        longer += weights[i] * (sqrt(vector_dot(p, p)) - 1);
    }
    return k * fmax(0, longer);
}

/* What a tendon of stiffness k puts into the rod while it is held is what its own energy T^2/(2 k)
 * loses; a slack one does nothing. By differences of fourth order along the motion. */
static void test_stiffness(void **state)
{
    (void)state;
    enum { DEGREE = 16, NODES = DEGREE + 1, ROWS = MOTION_ROWS };
    const double displacement[2] = {0.01, -0.05};
    for (int slack = 0; slack < 2; slack++) {
        scene given = soft_arm();
        given.tendons[0].tension = Q(NULL);
        given.tendons[0].displacement = Q(displacement[slack]);
        given.tendons[0].stiffness = Q(80.0);
        given.motion = SCENE_SPATIAL;
        ad_error error = {.message = ""};
        solve_rod *rod;
        motion *m;
        double now[NODES * ROWS], rate[NODES * ROWS], moved[NODES * ROWS], change = 0;
        assert_int_equal(solve_rod_create(&given, &rod, &error), AD_OK);
        assert_int_equal(motion_create(rod, 1e8, 1, NULL, DEGREE, &m, &error), AD_OK);
        const double k = 80 * rod->scales.length / rod->scales.force;
        const double d = displacement[slack] / rod->scales.length;
        const double offset[2] = {0.008 / rod->scales.length, 0};
        assert_int_equal(motion_at(m, 0, &error), AD_OK);
        assert_int_equal(motion_initial(m, now, &error), AD_OK);
        for (int i = 0; i < NODES; i++) { /* somewhere, and moving */
            double s = motion_points(m)[i], *to = now + i * ROWS;
            to[MOTION_R] += 0.1 * s * s;
            to[MOTION_Q + 2] += 0.05 * s;
            to[MOTION_V] += s * s;
            to[MOTION_V + 1] += 0.3 * s * s;
            to[MOTION_W] += 0.2 * s;
            to[MOTION_W + 1] += 2 * s;
        }
        motion_prescribe(m, now);
        motion_rate(m, now, rate);
        for (int i = 0; i < 4; i++) {
            static const double by[4] = {-2, -1, 1, 2}, weights[4] = {1, -8, 8, -1};
            const double step = 1e-4;
            for (int j = 0; j < NODES * ROWS; j++) {
                moved[j] = now[j] + step * by[i] * rate[j];
            }
            double tension = tension_in(m, moved, offset, k, d);
            change += weights[i] * tension * tension / (2 * k) / (12 * step);
        }
        double power = motion_power_of(m, now).load;
        assert_true((fabs(power) > 0.1) == !slack);
        assert_near(power, -change, 1e-8 * fmax(1, fabs(power)));
        motion_free(m);
        solve_rod_free(rod);
    }
}

/* In the state of that motion the accelerations are those of that motion, and power is the rate of
 * energy: by differences of fourth order along the motion that the rate begins. */
static void test_rate(void **state)
{
    (void)state;
    enum { ELEMENTS = 2, DEGREE = 16, NODES = ELEMENTS * DEGREE + 1, ROWS = MOTION_ROWS };
    const scene given = chosen_motion();
    ad_error error = {.message = ""};
    solve_rod *rod;
    motion *m;
    solve_end_state exact[NODES];
    double now[NODES * ROWS], rate[NODES * ROWS], moved[NODES * ROWS], energy = 0;
    assert_int_equal(solve_rod_create(&given, &rod, &error), AD_OK);
    assert_int_equal(motion_create(rod, 1e8, ELEMENTS, NULL, DEGREE, &m, &error), AD_OK);
    double t = 0.6 * rod->duration;
    assert_int_equal(solve_rod_manufactured(rod, NODES, motion_points(m), t, exact, &error), AD_OK);
    assert_int_equal(motion_at(m, t, &error), AD_OK);
    for (int i = 0; i < NODES; i++) { /* r, q, r_t, w are in the order of a state */
        memcpy(now + i * ROWS, &exact[i], ROWS * sizeof *now);
    }
    motion_rate(m, now, rate);
    for (int i = 1; i < NODES; i++) {
        for (int k = 0; k < 3; k++) {
            assert_near(rate[i * ROWS + MOTION_V + k], exact[i].acceleration[k], 1e-5);
            assert_near(rate[i * ROWS + MOTION_W + k], exact[i].spin_rate[k], 1e-3);
        }
    }
    const double step = 1e-4, share[4] = {1, -8, 8, -1};
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < NODES * ROWS; k++) {
            moved[k] = now[k] + step * (i < 2 ? i - 2 : i - 1) * rate[k];
        }
        motion_energy at = motion_energy_of(m, moved);
        energy += share[i] * (at.kinetic + at.strain) / (12 * step);
    }
    motion_power power = motion_power_of(m, now);
    print_message("energy grows by %.12g, %.12g of it by loads\n", energy, power.load);
    assert_near(power.load - power.dissipation, energy, 1e-8 * fabs(energy));
    motion_free(m);
    solve_rod_free(rod);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_refusals), cmocka_unit_test(test_ramp),
                                       cmocka_unit_test(test_rate),
                                       cmocka_unit_test(test_stiffness)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
