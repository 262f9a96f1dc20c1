/* Friction of tendons in motion, by strain modes: the tension along a path in space, the loop of
 * slow commands beside the closed form of tendons that stick, what friction takes, derivatives, and
 * steps of jumping commands. */
#include "fewer.h"
#include "modes_testing.h"
#include "near.h"
#include "temporary_folder.h"

#include "physics/chain/reduced.h"
#include "physics/solve/modes_motion.h"
#include "tools/library/cpinn.h"

#include <stdio.h>
#include <string.h>

/* ---- at a state ---------------------------------------------------------------------------- */

enum { SETS = 6, MOST = 64 };

/* Tendons across a joint and where strains jump, one of given displacement. */
static const char *const rubbing[SETS] = {
    "tendons[0].friction=0.4",    "tendons[0].creep_speed=0.05",  "tendons[1].friction=0.7",
    "tendons[1].creep_speed=0.1", "tendons[1].displacement=0.12", "tendons[2].friction=0.2"};

/* Difference quotients leave 1e-10; a sign that is wrong in any part leaves 4e-5 and more. */
static void test_derivatives(void **state)
{
    (void)state;
    const double off = worst_derivative(4, NULL, SETS, rubbing);
    print_message("derivatives: %.1e\n", off);
    assert_true(off < 1e-9);
}

/* The tangent of tendon 1 of that scene at s, world. */
static void tangent_at(const modes *m, double s, double tangent[3])
{
    ad_error error = {.message = ""};
    modes_places *places = NULL;
    solve_state at;
    double turned[3], path[3], q[4], R[3][3];
    const double r[3] = {-0.03, 0.02 * (1 + s), 0}, slope[3] = {0, 0.02, 0};
    assert_int_equal(modes_places_create(m, 1, &s, &places, &error), AD_OK);
    modes_samples(m, places, &at);
    modes_places_free(places);
    vector_cross(at.curvature, r, turned);
    for (int k = 0; k < 3; k++) {
        path[k] = at.strain[k] + turned[k] + slope[k];
    }
    memcpy(q, at.rotation, sizeof q);
    rotation_matrix(q, R);
    to_world(R, path, tangent);
}

static double angle_between(const double a[3], const double b[3])
{
    double across[3];
    vector_cross(a, b, across);
    return atan2(sqrt(vector_dot(across, across)), vector_dot(a, b));
}

/* Where all of it slides in towards the beginning the tension is exp(-friction angle), with the
 * angle by which the path turns in space, the joint's kink among it: by 600 tangents, whose sum of
 * angles is off by the square of their distance. */
static void test_capstan(void **state)
{
    (void)state;
    enum { TANGENTS = 300 };
    const char *const sets[] = {"tendons[1].friction=0.7", "tendons[1].creep_speed=1e-7"};
    const double edges[3] = {0, 0.6, 1}, beyond = 1e-7;
    reduced_test x =
        make_with("everything.yaml", everything, modes_counts_of(2, 2, 2, 2), 4, 2, sets);
    double q[MOST], v[MOST] = {0}, residual[MOST], angle = 0, last[3] = {0}, next[3];
    ad_error error = {.message = ""};
    unsigned seed = 5;
    assert_int_equal(modes_at(x.m, 0.3, NULL, &error), AD_OK);
    for (int a = 0; a < x.m->size; a++) {
        q[a] = 0.3 * noise(&seed);
        v[a] = x.m->mode[a].strain == MODES_V + 2 && x.m->mode[a].degree == 0 ? -1 : 0;
    }
    modes_shape(x.m, q, v, NULL);
    modes_forces(x.m, false, residual);
    for (int piece = 0; piece < 2; piece++) {
        for (int i = 0; i <= TANGENTS; i++) {
            const double s = edges[piece] + (edges[piece + 1] - edges[piece]) * i / TANGENTS;
            tangent_at(x.m, i == 0 ? s + beyond : s, next);
            angle += piece + i > 0 ? angle_between(last, next) : 0;
            memcpy(last, next, sizeof last);
        }
    }
    const double left = x.m->friction.left[(x.m->points - 1) * x.m->rod->actuators + 1];
    print_message("angle %.8f, by the tension %.8f\n", angle, -log(left) / 0.7);
    assert_true(angle > 0.8);
    assert_near(-log(left) / 0.7, angle, 2e-6);
    discard(&x);
}

#define WIRE_OF(more)                                                                              \
    "rod: {model: kirchhoff, length: 0.2, section: {shape: circle, radius: 5.0e-4}, material: "    \
    "{youngs_modulus: 6.0e10, poissons_ratio: 0.3, density: 6450" more "}}\n"
#define WIRE WIRE_OF("")

/* In any motion friction takes power, and what is left of that of the drive goes to the rod: summed
 * otherwise, to what Gauss' points leave. */
static void test_power(void **state)
{
    (void)state;
    static const char text[] =
        WIRE "tendons: [{offset: [0.008, 0], tension: 2, friction: 0.5, creep_speed: 0.5},\n"
             "  {offset: [0, '0.006*(1 - s)'], tension: 1, friction: 0.9, creep_speed: 0.5}]\n"
             "time: {duration: 1}\n";
    reduced_test x = make("power.yaml", text, modes_counts_of(4, 2, 0, 0), 4);
    double q[MOST], v[MOST], residual[MOST];
    unsigned seed = 5;
    for (int time = 0; time < 20; time++) {
        double load, dissipation, power = 0;
        for (int a = 0; a < x.m->size; a++) {
            q[a] = 2 * noise(&seed);
            v[a] = 2 * noise(&seed);
        }
        modes_shape(x.m, q, v, NULL);
        modes_forces(x.m, false, residual);
        modes_power_now(x.m, &load, &dissipation);
        for (int p = 0; p < x.m->points; p++) {
            for (int c = 0; c < MODES_STRAINS; c++) {
                power -= x.m->point[p].weight * x.m->point[p].pull[c] * x.m->point[p].rate[c];
            }
        }
        assert_true(dissipation > 0);
        assert_near(load - dissipation, power, 1e-3 * dissipation);
    }
    discard(&x);
}

/* ---- slow commands ------------------------------------------------------------------------- */

static const double LENGTH = 0.2, MU = 0.5, LEVER = 0.008, DURATION = 4;

static double bending(void)
{
    return 60e9 * PI * pow(0.0005, 4) / 4;
}

static double pull_at(double t)
{
    return 2 * pow(sin(0.5 * PI * t), 2);
}

enum { PLACES = 201, TIMES = 81 };

/* How far a rod without other loads turns whose tendon sticks: 1/T(s) is a play of 1/T(0) with the
 * threshold mu y s/EI (test_rubbing.c). */
static void stick(double turned[TIMES])
{
    enum { BETWEEN = 20 };
    const double rate = LEVER / bending();
    double inverse[PLACES];
    for (int i = 0; i < PLACES; i++) {
        inverse[i] = INFINITY;
    }
    for (int k = 0; k <= (TIMES - 1) * BETWEEN; k++) {
        const double pull = fmax(1e-12, pull_at(DURATION * k / ((TIMES - 1) * BETWEEN)));
        double sum = 0;
        for (int i = 0; i < PLACES; i++) {
            const double threshold = MU * rate * LENGTH * i / (PLACES - 1);
            inverse[i] = fmax(1 / pull - threshold, fmin(1 / pull + threshold, inverse[i]));
            sum += (i % (PLACES - 1) ? 1 : 0.5) / inverse[i];
        }
        if (k % BETWEEN == 0) {
            turned[k / BETWEEN] = rate * sum * LENGTH / (PLACES - 1);
        }
    }
}

/* Of the second cycle: the area of the loop of tension and length. */
static double loop_of(const double turned[TIMES])
{
    double area = 0;
    for (int i = TIMES / 2; i + 1 < TIMES; i++) {
        const double t = DURATION * i / (TIMES - 1), next = DURATION * (i + 1) / (TIMES - 1);
        area += 0.5 * (pull_at(t) + pull_at(next)) * LEVER * (turned[i + 1] - turned[i]);
    }
    return area;
}

/* What is found of a creep speed: the largest error of the turn, rad, and the loop's area over that
 * of a tendon that sticks. */
static void cycle(double creep, const double exact[TIMES], double *off, double *area)
{
    char text[1024];
    ad_error error = {.message = ""};
    const solve_settings settings = {.tolerance = 1e-4, .modes = {10, 0, 0, 0}};
    double times[TIMES], turned[TIMES], before = 0;
    modes_solution *motion = NULL;
    solve_report report;
    solved x;
    snprintf(text, sizeof text,
             WIRE "tendons: [{offset: [0.008, 0], tension: '2*sin(0.5*pi*t)^2', friction: 0.5, "
                  "creep_speed: %g}]\ntime: {duration: %g}\n",
             creep, DURATION);
    make_rod(&x, "cycle.yaml", text);
    for (int i = 0; i < TIMES; i++) {
        times[i] = DURATION * i / (TIMES - 1) / x.rod->scales.time;
    }
    assert_int_equal(modes_motion_solve(x.rod, &settings, TIMES, times, &motion, &report, &error),
                     AD_OK);
    const solve_energy *energy = modes_motion_energies(motion);
    *off = 0;
    for (int i = 0; i < TIMES; i++) {
        const double s = 1;
        solve_state at;
        assert_int_equal(modes_motion_at(motion, (size_t)i, 1, &s, &at, &error), AD_OK);
        turned[i] = 2 * atan2(at.rotation[2], at.rotation[0]);
        *off = fmax(*off, fabs(turned[i] - exact[i]));
        assert_true(energy[i].dissipated >= before);
        before = energy[i].dissipated;
    }
    *area = loop_of(turned) / loop_of(exact);
    const double lost = (energy[TIMES - 1].dissipated - energy[TIMES / 2].dissipated) *
                        x.rod->scales.force * LENGTH;
    print_message("creep %.1e m/s: turn off by %.4f of %.3f rad, loop %.4f of the exact one, "
                  "dissipated %.4f, energy off by %.1e, %ld steps\n",
                  creep, *off, exact[TIMES / 4], *area, lost / loop_of(exact),
                  report.energy_mismatch, report.time_steps);
    assert_near(lost, loop_of(turned), 5e-3 * lost); /* trapezoids; inertia gives back */
    assert_true(report.energy_mismatch < 1e-3);
    modes_motion_free(motion);
    free_solved(&x);
}

/* Within 80 units of time, in which the tendon slides by 7 mm and back. The law has the loop of
 * tendons that stick in the limit: errors fall as the root of the creep speed, to what ten modes
 * leave of a kink. The second is the default. */
static void test_loop(void **state)
{
    (void)state;
    double exact[TIMES], off[2], area[2];
    stick(exact);
    for (int i = 0; i < 2; i++) {
        cycle(i ? 3.8e-5 : 3.8e-4, exact, &off[i], &area[i]);
    }
    assert_true(off[0] < 0.04 && off[1] < 0.4 * off[0]);
    assert_true(fabs(area[1] - 1) < 0.05 && fabs(area[1] - 1) < 0.4 * fabs(area[0] - 1));
}

/* ---- steps --------------------------------------------------------------------------------- */

static const char arm[] =
    "parameters: {pull1: {range: [0, 8]}, pull2: {range: [0, 8]}, mu: {range: [0.05, 0.6]}}\n"
    "rod: {model: cosserat, length: 0.2, section: {shape: circle, radius: 0.007}, material: "
    "{youngs_modulus: 6.0e6, poissons_ratio: 0.45, density: 1150, relaxation_time: 0.02}}\n"
    "boundary: {start: {type: clamped}}\n"
    "tendons: [{offset: [0.012, 0], tension: pull1, friction: mu},\n"
    "  {offset: [-0.006, 0.01], tension: pull2, friction: mu}]\n"
    "time: {duration: 1, windows: 1}\n";

static reduced_rod *make_arm(config **given, const char *override, double newton)
{
    const double tip = 0.2;
    const reduced_settings settings = {.count = 1, .s = &tip, .newton = newton};
    ad_error error = {.message = ""};
    reduced_rod *rod = NULL;
    if (prepare_read("arm.yaml", arm, override != NULL, &override, given, &error) != AD_OK ||
        reduced_create(&(*given)->scene, &settings, &rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return rod;
}

/* Steps of 20 ms in which tensions jump anywhere: Newton's method finds each, and beside steps of 1
 * ms the tip is off by no more than 1e-2 of the length, as much as without friction. */
static void test_jumps(void **state)
{
    (void)state;
    enum { STEPS = 60, FINE = 20 };
    double x[MOST], fine[MOST], inputs[3] = {3, 2, 0.3}, off = 0;
    ad_error error = {.message = ""};
    unsigned seed = 2;
    config *given = NULL;
    reduced_rod *rod = make_arm(&given, NULL, 0);
    reduced_place at, fine_at;
    assert_int_equal(reduced_initial(rod, inputs, x, &error), AD_OK);
    for (int i = 0; i < FEWER(STEPS); i++) {
        for (int k = 0; k < 2 && i % 5 == 0; k++) {
            inputs[k] = 8 * (noise(&seed) + 0.5);
        }
        memcpy(fine, x, sizeof fine);
        assert_int_equal(reduced_step(rod, 0, 0.02, x, inputs, x, NULL, NULL, &error), AD_OK);
        for (int k = 0; k < FINE; k++) {
            assert_int_equal(
                reduced_step(rod, 0, 0.02 / FINE, fine, inputs, fine, NULL, NULL, &error), AD_OK);
        }
        assert_int_equal(reduced_output(rod, 0, x, inputs, &at, NULL, &error), AD_OK);
        assert_int_equal(reduced_output(rod, 0, fine, inputs, &fine_at, NULL, &error), AD_OK);
        off = fmax(off, distance(at.position, fine_at.position));
    }
    print_message("steps of 20 ms: the tip is off by %.1e m at most\n", off);
    assert_true(off < 2e-3);
    reduced_free(rod);
    config_free(given);
}

/* Derivatives of a step by its state, the tensions and the coefficient, beside differences of
 * fourth order of steps that Newton's method ends at 1e-13. */
static void test_steps(void **state)
{
    (void)state;
    static const double at[4] = {-2, -1, 1, 2}, weight[4] = {1, -8, 8, -1};
    double x[MOST], next[MOST], ends[4][MOST], S[MOST * MOST], T[3 * MOST], inputs[3] = {5, 2, 0.4};
    double worst = 0, size = 0;
    ad_error error = {.message = ""};
    config *given = NULL;
    reduced_rod *rod = make_arm(&given,
                                "tendons=[{offset: [0.012, 0], tension: pull1, friction: mu, "
                                "creep_speed: 0.02}, {offset: [-0.006, 0.01], tension: "
                                "pull2, friction: mu, creep_speed: 0.02}]",
                                1e-13);
    const int n = reduced_states(rod);
    assert_int_equal(reduced_initial(rod, inputs, x, &error), AD_OK);
    inputs[0] = 3;
    assert_int_equal(reduced_step(rod, 0, 0.02, x, inputs, x, NULL, NULL, &error), AD_OK);
    inputs[0] = 6;
    assert_int_equal(reduced_step(rod, 0, 0.02, x, inputs, next, S, T, &error), AD_OK);
    for (int c = 0; c < n + 3; c++) {
        double *to = c < n ? &x[c] : &inputs[c - n], by = c < n ? 3e-5 * (1 + fabs(*to)) : 1e-4;
        const double kept = *to;
        for (int i = 0; i < 4; i++) {
            *to = kept + at[i] * by;
            assert_int_equal(reduced_step(rod, 0, 0.02, x, inputs, ends[i], NULL, NULL, &error),
                             AD_OK);
        }
        *to = kept;
        double off = 0, most = 0;
        for (int r = 0; r < n; r++) {
            double quotient = 0;
            for (int i = 0; i < 4; i++) {
                quotient += weight[i] * ends[i][r] / (12 * by);
            }
            off = fmax(off, fabs(quotient - (c < n ? S[r * n + c] : T[r * 3 + c - n])));
            most = fmax(most, fabs(quotient));
        }
        worst = fmax(worst, off / most);
        size = fmax(size, most);
    }
    print_message("derivatives of a step: %.1e of %.1e\n", worst, size);
    assert_true(worst < 1e-7);
    reduced_free(rod);
    config_free(given);
}

/* ---- unknown ------------------------------------------------------------------------------- */

#define UNKNOWN "parameters: {pull: {range: [0, 3]}, mu: {identify: 0.2, range: [0.05, 1]}}\n"
#define PULLED  "tendons: [{offset: [0.008, 0], tension: pull, friction: mu}]\n"

/* The coefficient from the files, and its deviation. */
static double find(const char *text, double *deviation)
{
    cpinn_unknowns *found = NULL;
    ad_error error = {.message = ""};
    FILE *to = fopen(at("scene.yaml"), "w");
    assert_non_null(to);
    fputs(text, to);
    fclose(to);
    if (cpinn_identify_file(at("scene.yaml"), 0, NULL, 1, &found, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    const double value = cpinn_unknowns_value(found, 0);
    *deviation = cpinn_unknowns_deviation(found, 0);
    cpinn_unknowns_free(found);
    return value;
}

/* Pulled from no tension on the rod turns by log(1 + mu y T s/EI)/mu: T' = -mu T^2 y/EI. */
static void test_unknown_at_rest(void **state)
{
    (void)state;
    enum { PARTS = 2000 };
    double deviation;
    FILE *to = fopen(at("tips.csv"), "w");
    assert_non_null(to);
    fputs("pull,s,x,y,z\n", to);
    for (double pull = 0.5; pull < 3; pull += 0.5) {
        double x = 0, z = 0;
        for (int i = 0; i < PARTS; i++) {
            const double s = LENGTH * (i + 0.5) / PARTS;
            const double turn = log1p(MU * LEVER * pull * s / bending()) / MU;
            x += LENGTH / PARTS * sin(turn);
            z += LENGTH / PARTS * cos(turn);
        }
        fprintf(to, "%g,%g,%.12g,0,%.12g\n", pull, LENGTH, x, z);
    }
    fclose(to);
    const double mu =
        find(UNKNOWN WIRE PULLED "data: [{quantity: position, file: tips.csv, noise: 1.0e-4}]\n",
             &deviation);
    print_message("at rest: %.8f +- %.1e\n", mu, deviation);
    assert_near(mu, MU, 1e-5); /* sums over parts leave 1e-8 of a length */
}

#define DAMPED "motion: planar\n" WIRE_OF(", relaxation_time: 0.02")

/* From a recording of 20 samples, pulled and released within 0.3 s, of a motion with more modes:
 * what those it has leave is a part of the deviation for a noise of 0.3 mm. */
static void test_unknown_in_motion(void **state)
{
    (void)state;
    enum { SAMPLES = 21 };
    static const char *const tension = "'where(0.15 - t, 12*t, 3.6 - 12*t)'";
    const solve_settings settings = {.tolerance = 1e-4, .modes = {8, 0, 0, 0}};
    double times[SAMPLES], deviation;
    char text[1024];
    ad_error error = {.message = ""};
    modes_solution *motion = NULL;
    solve_report report;
    solved x;
    snprintf(text, sizeof text,
             DAMPED "tendons: [{offset: [0.008, 0], tension: %s, friction: 0.5}]\n"
                    "time: {duration: 0.3}\n",
             tension);
    make_rod(&x, "recorded.yaml", text);
    for (int i = 0; i < SAMPLES; i++) {
        times[i] = 0.3 * i / (SAMPLES - 1) / x.rod->scales.time;
    }
    assert_int_equal(modes_motion_solve(x.rod, &settings, SAMPLES, times, &motion, &report, &error),
                     AD_OK);
    FILE *to = fopen(at("recorded.csv"), "w");
    assert_non_null(to);
    fputs("s,t,pull,x,y,z\n", to);
    for (int i = 0; i < SAMPLES; i++) {
        const double s = 1, t = 0.3 * i / (SAMPLES - 1);
        solve_state seen;
        assert_int_equal(modes_motion_at(motion, (size_t)i, 1, &s, &seen, &error), AD_OK);
        fprintf(to, "%g,%.12g,%.12g,%.12g,%.12g,%.12g\n", LENGTH, t,
                t < 0.15 ? 12 * t : 3.6 - 12 * t, LENGTH * seen.position[0],
                LENGTH * seen.position[1], LENGTH * seen.position[2]);
    }
    fclose(to);
    modes_motion_free(motion);
    free_solved(&x);
    const double mu = find(UNKNOWN DAMPED PULLED
                           "time: {duration: 0.3}\n"
                           "data: [{quantity: position, file: recorded.csv, noise: 3.0e-4}]\n",
                           &deviation);
    print_message("in motion: %.8f +- %.1e\n", mu, deviation);
    assert_near(mu, MU, deviation);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_derivatives), cmocka_unit_test(test_capstan),
        cmocka_unit_test(test_power),       cmocka_unit_test(test_jumps),
        cmocka_unit_test(test_steps),       cmocka_unit_test(test_unknown_at_rest)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_loop),
                                       cmocka_unit_test(test_unknown_in_motion)};
    return run_with_alike(tests, alike, make_directory, remove_directory);
}
