/* Rods whose material has a Maxwell branch: a vibration with the roots of its cubic, the relaxation
 * of a strain that is held, creep, the loss of a cycle over the frequency, and the balance of
 * energy. These by stretch alone, which is linear: closed forms are exact, or as far as waves are
 * fast. Modes agree with nodes; derivatives of the reduced rod with differences. */
#include "fewer.h"
#include "motion_testing.h"

#include "autodiff/dense.h"
#include "physics/chain/reduced.h"
#include "physics/solve/modes_motion.h"

#include <complex.h>
#include <stdio.h>
#include <string.h>

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

/* One place of a motion by strain modes, as many as the tolerance asks for. */
static void solve_modes(solved *x, double tolerance, size_t count, const double *times, double s,
                        solve_state *out)
{
    ad_error error = {.message = ""};
    solve_settings settings = {.tolerance = tolerance};
    modes_solution *motion = NULL;
    ad_status status =
        modes_motion_solve(x->rod, &settings, count, times, &motion, &x->report, &error);
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        status = modes_motion_at(motion, i, 1, &s, &out[i], &error);
    }
    modes_motion_free(motion);
    if (status != AD_OK) {
        fail_msg("%s", error.message);
    }
}

static void test_vibration(void **state)
{
    (void)state;
    enum { TIMES = 5 };
    static const double times[TIMES] = {0.4, 0.9, 1.7, 2.6, 4}, axial = 4, stretched = 0.1;
    static const double cases[][3] = {{0, 0.5, 0.3}, {0.02, 2, 0.1}, {0, 1, 20}};
    const double w = acos(-1) / 2 * sqrt(axial), tolerance = 1e-6;
    for (size_t k = 0; k < 2 * sizeof cases / sizeof *cases; k++) {
        const double *given = cases[k / 2], viscous = given[0], ratio = given[1], time = given[2];
        const bool by_modes = k % 2;
        double worst = 0;
        solve_state at[TIMES];
        solved x;
        make(&x, axial, viscous, ratio, time, "",
             "initial: {position: [0, 0, 's + 0.1*sin(pi*s/2)'], rotation: [1, 0, 0, 0]}\n"
             "time: {duration: 4}\n");
        if (by_modes) {
            solve_modes(&x, tolerance, TIMES, times, 1, at);
        } else {
            solve(&x, 0, tolerance, TIMES, times);
        }
        for (size_t i = 0; i < TIMES; i++) {
            const double is = (by_modes ? at[i] : state_at(&x, i, 1)).position[2] - 1;
            worst =
                fmax(worst, fabs(is - stretched * vibration(w, viscous, ratio, time, times[i])));
        }
        print_message("%s, ratio %g, time %g: error %.1e, estimate %.1e, energy off by %.1e\n",
                      by_modes ? "modes" : "nodes", ratio, time, worst, x.report.estimate,
                      x.report.energy_mismatch);
        assert_true(worst <= x.report.estimate && x.report.estimate_l2 <= tolerance);
        assert_true(x.report.energy_mismatch <= 1e-4); /* as steps without a branch keep it */
        free_solved(&x);
    }
}

/* Of an end that moves by e(t) a force axial (e + ratio z), z = integral of e_t exp(-(t - u)/time):
 * waves, which are 100 times faster than what moves the end, add (1/100)^2 of it. Places to 1e-8
 * hold forces, which are axial times their slopes, to less than that. */
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
    solve(&x, 0, 1e-8, TIMES, times);
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

/* Modes and nodes of a rod that bends, twists and stretches, whose rest shape moves and whose
 * branch is that of a part: they differ by their estimates, and energy is kept. */
static void test_methods(void **state)
{
    (void)state;
    enum { TIMES = 3 };
    static const double times[TIMES] = {0.2, 0.5, 0.9}, tolerance = 1e-5; /* 0.95: the end */
    static const char text[] =
        "rod:\n"
        "  length: 0.3\n"
        "  section: {shape: circle, radius: 0.008}\n"
        "  material: {youngs_modulus: 2.0e+6, poissons_ratio: 0.45, density: 1100,\n"
        "    relaxation_time: 0.005}\n"
        "  rest: {curvature: [0, '3*sin(6*t)', 2]}\n"
        "segments:\n"
        "  - {length: 0.15, material: {maxwell: {ratio: 0.5 + s, time: 0.08}}}\n"
        "  - {length: 0.15}\n"
        "boundary: {start: {type: clamped}}\n"
        "loads: {gravity: [0, 4, -9.81]}\n"
        "time: {duration: 0.5}\n";
    solve_state at[TIMES];
    solved x;
    double apart = 0, estimate = 0;
    make_rod(&x, "methods.yaml", text);
    solve(&x, 0, tolerance, TIMES, times);
    estimate = x.report.estimate;
    assert_true(x.report.energy_mismatch <= 1e-5);
    solve_modes(&x, tolerance, TIMES, times, 1, at);
    for (size_t i = 0; i < TIMES; i++) {
        apart = fmax(apart, distance(at[i].position, state_at(&x, i, 1).position));
    }
    print_message("apart %.1e, estimates %.1e and %.1e, energy off by %.1e\n", apart, estimate,
                  x.report.estimate, x.report.energy_mismatch);
    assert_true(apart <= estimate + x.report.estimate);
    assert_true(x.report.energy_mismatch <= 1e-6);
    free_solved(&x);
}

/* ---- the reduced rod ----------------------------------------------------------------------- */

#define OPEN                                                                                       \
    "parameters: {c: {range: [0.1, 2]}, T: {range: [0.02, 4]}, f: {range: [-1, 1]},\n"             \
    "  k: {range: [1, 3]}}\n"                                                                      \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [20, 20], axial: 100*k, bending: [k, k], torsion: 1}\n"                  \
    "  inertia: {mass_per_length: %g, rotary: [%g, %g, %g]}\n"                                     \
    "  rest: {curvature: [0, %s, 0]}\n"                                                            \
    "  material: {maxwell: {ratio: c, time: T}}\n"                                                 \
    "boundary: {start: {type: clamped}}\n"

enum { INPUTS = 4, RATIO = 0, TIME = 1, STATES = 32 };

static reduced_rod *reduced_of(config **settings, double mass, const char *bent, const char *more,
                               const int modes[4])
{
    char text[1024];
    ad_error error = {.message = ""};
    static const double tip = 1;
    reduced_settings of = {.count = 1, .s = &tip, .newton = 1e-13};
    reduced_rod *rod = NULL;
    memcpy(of.modes, modes, sizeof of.modes);
    snprintf(text, sizeof text, OPEN "%s", mass, mass / 100, mass / 100, mass / 100, bent, more);
    if (prepare_read("reduced.yaml", text, 0, NULL, settings, &error) != AD_OK ||
        reduced_create(&(*settings)->scene, &of, &rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_true(reduced_states(rod) <= STATES);
    return rod;
}

static const char pulled[] = "loads: {tip: {force: [0, 0, f]}}\ntime: {duration: 1, windows: 1}\n";

/* A force f that is there from t = 0 on stretches to f/K (1 - ratio/(1 + ratio) exp(-t/T')), T' =
 * (1 + ratio) T: waves, 500 times faster than a step, are damped by the method. */
static void test_creep(void **state)
{
    (void)state;
    const double inputs[INPUTS] = {0.8, 0.3, 1, 1}, h = 0.02;
    const double longer = (1 + inputs[RATIO]) * inputs[TIME], jump = inputs[RATIO] / longer;
    ad_error error;
    config *settings;
    reduced_rod *rod = reduced_of(&settings, 1e-4, "0", pulled, (int[4]){0, 0, 1, 0});
    double x[STATES] = {0}, worst = 0;
    assert_int_equal(reduced_states(rod), 3);
    for (int i = 1; i <= 60; i++) {
        reduced_place tip;
        assert_int_equal(reduced_step(rod, 0, h, x, inputs, x, NULL, NULL, &error), AD_OK);
        assert_int_equal(reduced_output(rod, 0, x, inputs, &tip, NULL, &error), AD_OK);
        const double is = tip.position[2] - 1;
        const double exact = 0.01 * (1 - jump * inputs[TIME] * exp(-i * h / longer));
        worst = i > 3 ? fmax(worst, fabs(is - exact)) : worst; /* waves of the jump */
    }
    print_message("creep: %.1e of 0.01\n", worst);
    assert_true(worst <= 1e-5 * 0.01);
    reduced_free(rod);
    config_free(settings);
}

/* To a force f exp(i w t) the tip answers with f/K', K' = K (1 + ratio i w T/(1 + i w T)): inertia
 * changes that by (w/frequency)^2, below 1e-5. By the derivatives of the rate. */
static void test_modulus(void **state)
{
    (void)state;
    static const double by_time[] = {0.2, 1, 4};
    const double inputs[INPUTS] = {0.8, 0.3, 0, 1};
    ad_error error;
    config *settings;
    reduced_rod *rod = reduced_of(&settings, 1e-4, "0", pulled, (int[4]){0, 0, 2, 0});
    enum { N = 6 };
    double x[N] = {0}, rate[N], A[N * N], B[N * INPUTS];
    assert_int_equal(reduced_states(rod), N);
    assert_int_equal(reduced_rate(rod, 0, x, inputs, rate, A, B, &error), AD_OK);
    assert_int_equal(ad_dense_load(&error), AD_OK);
    for (int k = 0; k < 3; k++) {
        const double w = by_time[k] / inputs[TIME];
        double matrix[4 * N * N] = {0}, right[2 * N] = {0};
        int pivots[2 * N];
        for (int r = 0; r < N; r++) { /* (i w - A) x = B, real and imaginary parts */
            for (int c = 0; c < N; c++) {
                matrix[c * 2 * N + r] = matrix[(N + c) * 2 * N + N + r] = -A[r * N + c];
            }
            matrix[(N + r) * 2 * N + r] = -w;
            matrix[r * 2 * N + N + r] = w;
            right[r] = B[r * INPUTS + 2];
        }
        assert_int_equal(ad_dense_lu(2 * N, matrix, pivots), 0);
        ad_dense_lu_solve(2 * N, 1, matrix, pivots, right);
        const double complex modulus = 1 / (right[0] + I * right[N]); /* all stretch alike */
        const double complex wt = I * by_time[k];
        const double complex exact = 100 * (1 + inputs[RATIO] * wt / (1 + wt));
        print_message("w T = %g: loss factor %g, exact %g\n", by_time[k],
                      cimag(modulus) / creal(modulus), cimag(exact) / creal(exact));
        assert_true(cabs(modulus - exact) <= 1e-4 * cabs(exact));
    }
    reduced_free(rod);
    config_free(settings);
}

/* Differences of order 4 of rates and steps, by the state and every input: by the branch's, too,
 * which change between the ends of the step. */
static void test_derivatives(void **state)
{
    (void)state;
    static const double by[4] = {-2, -1, 1, 2}, weight[4] = {1. / 12, -8. / 12, 8. / 12, -1. / 12};
    const double step = 0.02, time = 0.1;
    ad_error error;
    config *settings;
    reduced_rod *rod =
        reduced_of(&settings, 1, "'0.2*sin(3*t)*k'",
                   "loads: {tip: {force: [0, f, f]}}\ntime: {duration: 1, windows: 1}\n"
                   "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0]}\n",
                   (int[4]){2, 1, 1, 1});
    const int n = reduced_states(rod);
    double x[STATES], inputs[INPUTS] = {0.8, 0.3, 0.2, 1.5}, after[INPUTS] = {1.1, 0.2, 0.3, 1.6};
    double rate[STATES], next[STATES], A[STATES * STATES], B[STATES * INPUTS];
    double S[STATES * STATES], T[STATES * INPUTS], worst = 0;
    for (int k = 0; k < n; k++) {
        const int modes = reduced_modes(rod);
        x[k] = (k / modes == 1 ? 0.1 : 0.02) * sin(k + 1);
    }
    assert_int_equal(reduced_rate(rod, time, x, inputs, rate, A, B, &error), AD_OK);
    assert_int_equal(reduced_step_linear(rod, time, step, x, inputs, after, next, S, T, &error),
                     AD_OK);
    for (int c = 0; c < n + INPUTS; c++) {
        const bool of_state = c < n;
        double *to = of_state ? &x[c] : &inputs[c - n], *also = of_state ? NULL : &after[c - n];
        const double kept = *to, h = of_state ? 1e-4 : 1e-3, kept_after = also ? *also : 0;
        for (int which = 0; which < 2; which++) {
            const double *exact = which ? (of_state ? S : T) : of_state ? A : B;
            double quotient[STATES] = {0}, value[STATES], off = 0, size = 0;
            for (int i = 0; i < 4; i++) {
                *to = kept + by[i] * h;
                if (also) {
                    *also = kept_after + by[i] * h;
                }
                assert_int_equal(
                    which ? reduced_step_linear(rod, time, step, x, inputs, after, value, NULL,
                                                NULL, &error)
                          : reduced_rate(rod, time, x, inputs, value, NULL, NULL, &error),
                    AD_OK);
                for (int r = 0; r < n; r++) {
                    quotient[r] += weight[i] / h * value[r];
                }
            }
            *to = kept;
            if (also) {
                *also = kept_after;
            }
            for (int r = 0; r < n; r++) {
                const double is = exact[of_state ? r * n + c : r * INPUTS + c - n];
                off = fmax(off, fabs(is - quotient[r]));
                size = fmax(size, fabs(quotient[r]));
            }
            worst = fmax(worst, off / (size + 1e-3));
            if (!(off <= 1e-7 * (size + 1e-3))) {
                fail_msg("%s, column %d: %.1e of %.1e", which ? "step" : "rate", c, off, size);
            }
        }
    }
    print_message("derivatives: %.1e\n", worst);
    reduced_free(rod);
    config_free(settings);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_methods),
        cmocka_unit_test(test_creep),
        cmocka_unit_test(test_derivatives),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_vibration),
        cmocka_unit_test(test_relaxation),
        cmocka_unit_test(test_loss),
        cmocka_unit_test(test_modulus),
    };
    return run_with_alike(tests, alike, NULL, NULL);
}
