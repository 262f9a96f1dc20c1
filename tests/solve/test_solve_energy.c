/* Energy of rods by the classical solver, in SI units: closed forms, and the balance of motions. */
#include "near.h"

#include "physics/solve/solve.h"
#include "tools/prepare/prepare.h"

#include <stdio.h>

#define PI 3.14159265358979323846

typedef struct solved {
    config *settings;
    solution *solution;
    solve_report report;
    solve_energy energy; /* at the end */
} solved;

/* At 11 times. */
static void solve(solved *x, const char *path, const char *text, int nodes, double tolerance)
{
    ad_error error = {.message = ""};
    solve_settings settings = {.nodes = nodes, .tolerance = tolerance};
    double times[11];
    *x = (solved){0};
    if (prepare_read(path, text, 0, NULL, &x->settings, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    const scene *given = &x->settings->scene;
    for (int i = 0; i < 11; i++) {
        times[i] = scene_duration(given) * i / 10;
    }
    if (solution_create(given, &settings, 11, times, &x->solution, &x->report, &error) != AD_OK ||
        solution_energy(x->solution, scene_duration(given), &x->energy, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

static void free_solved(solved *x)
{
    solution_free(x->solution);
    config_free(x->settings);
}

/* ---- closed forms -------------------------------------------------------------------------- */

/* A bar that hangs from its end, stretched by F at the other and by f along it. */
static void test_stretched(void **state)
{
    (void)state;
    const double length = 2, axial = 300, F = 7, f = 5;
    static const char text[] =
        "rod:\n"
        "  length: 2\n"
        "  stiffness: {shear: [100, 100], axial: 300, bending: [1, 1], torsion: 1}\n"
        "loads: {force: [0, 0, 5], tip: {force: [0, 0, 7]}}\n";
    double strain = length * (F * F + F * f * length + f * f * length * length / 3) / (2 * axial);
    solved x;
    solve(&x, "stretched.yaml", text, 6, 1e-10);
    assert_near(x.energy.strain, strain, 1e-12 * strain); /* rounding */
    assert_near(x.energy.work, 2 * strain, 1e-12 * strain);
    assert_near(x.energy.kinetic, 0, 0);
    assert_true(isnan(x.energy.mismatch) && isnan(x.report.energy_mismatch));
    free_solved(&x);
}

/* A couple rolls a rod up to a circle. In space it has no potential. */
static void test_rolled_up(void **state)
{
    (void)state;
    static const char text[] =
        "rod: {model: kirchhoff, length: 2, stiffness: {bending: [3, 3], torsion: 1}}\n"
        "loads: {tip: {moment: [3*pi, 0, 0]}}\n";
    double strain = 0.5 * 3 * PI * PI * 2;
    solved x;
    solve(&x, "circle.yaml", text, 24, 1e-10);
    assert_near(x.energy.strain, strain, 1e-11 * strain); /* of the Newton steps */
    assert_true(isnan(x.energy.work));
    free_solved(&x);
}

/* A free rod is pushed through a fluid, while a wave of torsion in it decays by its damping. Both
 * equations are linear; the wave's is J A'' + B k^2 A' + C k^2 A = 0. */
static void test_damped(void **state)
{
    (void)state;
    const double length = 2, mass = 1.5, drag = 0.8, f = 3, start = 2, t = 0.8;
    const double J = 0.01, C = 0.5, B = 0.004, amplitude = 0.9, k = PI / 2;
    static const char text[] =
        "rod:\n"
        "  length: 2\n"
        "  stiffness: {shear: [40, 50], axial: 90, bending: [1.2, 0.8], torsion: 0.5}\n"
        "  inertia: {mass_per_length: 1.5, rotary: [0.007, 0.003, 0.01]}\n"
        "  damping: {curvature: [0, 0, 0.004]}\n"
        "boundary: {start: {type: free}, end: {type: free}}\n"
        "loads: {force: [3, 0, 0], drag: 0.8}\n"
        "initial:\n"
        "  position: [0, 0, s]\n"
        "  rotation: [cos(0.45*cos(pi*s/2)), 0, 0, sin(0.45*cos(pi*s/2))]\n"
        "  velocity: [2, 0, 0]\n"
        "time: {duration: 0.8}\n";
    double final = f / drag, fading = exp(-drag * t / mass);
    double speed = final + (start - final) * fading;
    double work = f * length * (final * t + (start - final) * (1 - fading) * mass / drag);
    double decay = B * k * k / (2 * J), bare = sqrt(C / J) * k;
    double frequency = sqrt(bare * bare - decay * decay), left = amplitude * exp(-decay * t);
    double angle = left * (cos(frequency * t) + decay / frequency * sin(frequency * t));
    double turning = -left * bare * bare / frequency * sin(frequency * t);
    double kinetic = 0.5 * length * (mass * speed * speed + J * turning * turning / 2);
    double strain = 0.25 * length * C * k * k * angle * angle;
    double initial = 0.5 * length * (mass * start * start + C * k * k * amplitude * amplitude / 2);
    solved x;
    solve(&x, "damped.yaml", text, 13, 1e-8);
    const solve_energy *e = &x.energy;
    print_message("damped: out of balance by %.1e\n", x.report.energy_mismatch);
    /* Some hundred steps to 1e-8 of some 10 J, whose errors hardly add up. */
    assert_near(e->kinetic, kinetic, 1e-6);
    assert_near(e->strain, strain, 1e-6);
    assert_near(e->work, work, 1e-6);
    assert_near(e->dissipated, initial + work - kinetic - strain, 1e-6);
    assert_true(strain > 0.01 && e->dissipated > 3); /* so that each counts */
    free_solved(&x);
}

/* ---- balance ------------------------------------------------------------------------------- */

/* Out of balance by no more than a step may be off, times `steps`. */
static void check_balance(const char *path, int nodes, double tolerance, double steps, solved *x)
{
    solve(x, path, NULL, nodes, tolerance);
    double mismatch = x->report.energy_mismatch;
    print_message("%s, steps to %.0e: out of balance by %.1e\n", path, tolerance, mismatch);
    assert_true(mismatch < steps * tolerance);
}

/* Neither loads nor damping: what there is stays. */
static void test_conserved(void **state)
{
    (void)state;
    const double tolerances[2] = {1e-6, 1e-9}; /* explicit steps, by the scene's many vibrations */
    for (int i = 0; i < 2; i++) {
        solved x;
        check_balance("configs/cases/spinning.yaml", 13, tolerances[i], 30, &x);
        assert_near(x.energy.work, 0, 0);
        assert_near(x.energy.dissipated, 0, 0);
        free_solved(&x);
    }
}

/* Implicit steps. */
static void test_forced(void **state)
{
    (void)state;
    const double tolerances[2] = {1e-5, 1e-7};
    for (int i = 0; i < 2; i++) {
        solved x;
        check_balance("configs/cantilever_dynamic.yaml", 17, tolerances[i], 10, &x);
        assert_near(x.energy.dissipated, 0, 0);
        free_solved(&x);
    }
}

/* Every kind of load and of damping at once; ends that are driven, which in exact motion neither
 * put energy in nor take any out. */
static void test_driven(void **state)
{
    (void)state;
    solved x;
    check_balance("configs/manufactured_dynamic.yaml", 13, 1e-6, 10, &x);
    assert_true(x.energy.dissipated > 0.1);
    free_solved(&x);
    check_balance("configs/cases/travelling_helix.yaml", 13, 1e-8, 100, &x);
    assert_near(x.energy.work, 0, 1e-5 * x.energy.kinetic); /* of 13 nodes */
    free_solved(&x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_stretched), cmocka_unit_test(test_rolled_up),
        cmocka_unit_test(test_damped),    cmocka_unit_test(test_conserved),
        cmocka_unit_test(test_forced),    cmocka_unit_test(test_driven),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
