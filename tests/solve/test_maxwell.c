/* Rods whose material has a Maxwell branch: a vibration with the roots of its cubic, the relaxation
 * of a strain that is held, the loss of a cycle over the frequency, and the balance of energy. All
 * by stretch alone, which is linear: closed forms are exact, or as far as waves are fast. */
#include "motion_testing.h"

#include <stdio.h>

#define ROD                                                                                        \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [1, 1], axial: %g, bending: [1, 1], torsion: 1}\n"                       \
    "  inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.01]}\n"                                \
    "  material: {relaxation_time: %g, maxwell: {ratio: %g, time: %g}}\n"                          \
    "boundary: {start: {type: clamped}%s}\n"

/* The unit of time is that of the scene: length, EI and mass per length are 1. */
static void make(solved *x, double axial, double viscous, double ratio, double time,
                 const char *end, const char *more)
{
    char text[1024];
    snprintf(text, sizeof text, ROD "%s", axial, viscous, ratio, time, end, more);
    make_rod(x, "maxwell.yaml", text);
}

/* q_tt + w^2 (q + viscous q_t + ratio (q - z)) = 0, time z_t = q - z, q = z = 1 at rest at first:
 * A exp(r t) + exp(c t) (B cos(d t) + C sin(d t)), with the roots r, c +- i d of
 * time x^3 + (1 + w^2 viscous time) x^2 + w^2 (viscous + (1 + ratio) time) x + w^2. */
static double vibration(double w, double viscous, double ratio, double time, double t)
{
    const double k2 = (1 + w * w * viscous * time) / time;
    const double k1 = w * w * (viscous + (1 + ratio) * time) / time, k0 = w * w / time;
    double r = -1 / time;
    for (int i = 0; i < 60; i++) {
        r -= (((r + k2) * r + k1) * r + k0) / ((3 * r + 2 * k2) * r + k1);
    }
    const double c = -0.5 * (k2 + r), d = sqrt(-k0 / r - c * c), size = c * c + d * d;
    const double A = (size - w * w) / (r * r - 2 * c * r + size), B = 1 - A;
    const double C = -(r * A + c * B) / d;
    return A * exp(r * t) + exp(c * t) * (B * cos(d * t) + C * sin(d * t));
}

static void test_vibration(void **state)
{
    (void)state;
    enum { TIMES = 5 };
    static const double times[TIMES] = {0.4, 0.9, 1.7, 2.6, 4}, axial = 4, stretched = 0.1;
    static const double cases[][3] = {{0, 0.5, 0.3}, {0.02, 2, 0.1}, {0, 1, 20}};
    const double w = acos(-1) / 2 * sqrt(axial), tolerance = 1e-6;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const double viscous = cases[k][0], ratio = cases[k][1], time = cases[k][2];
        double worst = 0;
        solved x;
        make(&x, axial, viscous, ratio, time, "",
             "initial: {position: [0, 0, 's + 0.1*sin(pi*s/2)'], rotation: [1, 0, 0, 0]}\n"
             "time: {duration: 4}\n");
        solve(&x, 0, tolerance, TIMES, times);
        for (size_t i = 0; i < TIMES; i++) {
            const double is = state_at(&x, i, 1).position[2] - 1;
            worst =
                fmax(worst, fabs(is - stretched * vibration(w, viscous, ratio, time, times[i])));
        }
        print_message("ratio %g, time %g: error %.1e, estimate %.1e, energy off by %.1e\n", ratio,
                      time, worst, x.report.estimate, x.report.energy_mismatch);
        assert_true(worst <= x.report.estimate && x.report.estimate_l2 <= tolerance);
        assert_true(x.report.energy_mismatch <= 1e-4); /* as steps without a branch keep it */
        free_solved(&x);
    }
}

/* Of an end that moves by e(t) a force axial (e + ratio z), z = integral of e_t exp(-(t - u)/time):
 * waves, which are 100 times faster than what moves the end, add (1/100)^2 of it. */
static void test_relaxation(void **state)
{
    (void)state;
    enum { TIMES = 4, PARTS = 2000 };
    static const double times[TIMES] = {0.5, 1, 2, 4}, axial = 1e4, ratio = 0.5, time = 1.5;
    solved x;
    make(&x, axial, 0, ratio, time,
         ", end: {type: driven, rotation: [1, 0, 0, 0], position: [0, 0, '1 + where(t - 1, 0.01, "
         "0.01*(10 - 15*t + 6*t^2)*t^3)']}",
         "time: {duration: 4}\n");
    solve(&x, 0, 1e-7, TIMES, times);
    for (size_t i = 0; i < TIMES; i++) {
        const double t = times[i], most = fmin(t, 1), h = most / PARTS;
        double z = 0;
        for (int k = 0; k < PARTS; k++) {
            const double u = (k + 0.5) * h;
            z += h * 0.3 * u * u * (1 - u) * (1 - u) * exp(-(t - u) / time);
        }
        const double e = most * most * most * (10 - 15 * most + 6 * most * most) * 0.01;
        const double force = axial * (e + ratio * z), is = state_at(&x, i, 1).force[2];
        print_message("t = %g: %g, exact %g\n", t, is, force);
        assert_true(fabs(is - force) <= 1e-4 * axial * 0.01);
    }
    free_solved(&x);
}

/* A cycle of strain e sin(w t) takes pi ratio axial e^2 w time/(1 + (w time)^2): the loss factor
 * is the largest near w time = 1. */
static void test_loss(void **state)
{
    (void)state;
    static const double axial = 1e4, ratio = 0.2, time = 0.5, by_time[] = {0.5, 1, 3};
    const double pi = acos(-1);
    for (int k = 0; k < 3; k++) {
        const double w = by_time[k] / time, cycle = 2 * pi / w, from = 12 * time;
        const double times[] = {from, from + cycle};
        char end[200], more[200];
        solved x;
        snprintf(end, sizeof end,
                 ", end: {type: driven, rotation: [1, 0, 0, 0], position: [0, 0, '1 + "
                 "0.01*sin(%.17g*t)']}",
                 w);
        snprintf(more, sizeof more,
                 "initial: {velocity: [0, 0, '%.17g*s']}\ntime: {duration: %.17g}\n", 0.01 * w,
                 times[1]);
        make(&x, axial, 0, ratio, time, end, more);
        solve(&x, 0, 1e-7, 2, times);
        const solve_energy *at = dynamic_energies(x.motion);
        const double lost = at[1].dissipated - at[0].dissipated;
        const double exact = pi * ratio * axial * 1e-4 * by_time[k] / (1 + by_time[k] * by_time[k]);
        print_message("w time = %g: %g, exact %g\n", by_time[k], lost, exact);
        assert_true(fabs(lost - exact) <= 1e-3 * exact);
        free_solved(&x);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_vibration),
        cmocka_unit_test(test_relaxation),
        cmocka_unit_test(test_loss),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
