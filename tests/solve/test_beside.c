/* Bodies whose centre of mass lies beside the axis: equilibrium with their weight, a pendulum whose
 * period is known, a free rod that tumbles. */
#include "motion_testing.h"

#include "physics/numerics/quaternion.h"
#include "physics/solve/modes_motion.h"
#include "physics/solve/static.h"

#include <stdio.h>
#include <string.h>

/* ---- at rest --------------------------------------------------------------------------------- */

/* m(0) = (r(L) + R c) x W, with what the solution itself says of r(L) and R. */
static void test_weight(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [500, 500], axial: 1600, bending: [1, 1], torsion: 0.8}\n"
        "  inertia: {mass_per_length: 1.0e-12, rotary: [0, 0, 0]}\n"
        "bodies: [{at: 1, mass: 0.2, offset: [0.3, -0.2, 0.4]}]\n"
        "boundary: {start: {type: clamped}}\n"
        "loads: {gravity: [3, -2, 5]}\n";
    static const double c[3] = {0.3, -0.2, 0.4}, W[3] = {0.6, -0.4, 1}, s[2] = {0, 1};
    const solve_settings settings = {.tolerance = 1e-10};
    ad_error error = {.message = ""};
    static_solution *shape = NULL;
    solve_state at[2];
    double R[3][3], arm[3], moment[3];
    solved x;
    make_rod(&x, "weight.yaml", text);
    if (static_solve(x.rod, &settings, NULL, &shape, &x.report, &error) != AD_OK ||
        static_at(shape, 2, s, at, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    rotation_matrix(at[1].rotation, R);
    to_world(R, c, arm);
    for (int i = 0; i < 3; i++) {
        arm[i] += at[1].position[i];
    }
    vector_cross(arm, W, moment);
    print_message("moment at the base: %.1e off\n", distance(at[0].moment, moment));
    assert_true(distance(at[0].moment, moment) < 1e-9); /* ten tolerances */
    static_free(shape);
    free_solved(&x);
}

/* ---- in motion ------------------------------------------------------------------------------- */

/* Arithmetic-geometric mean; K(k) = pi/2 over that of 1 and sqrt(1 - k^2). */
static double mean_of(double a, double b)
{
    for (int i = 0; i < 10; i++) {
        const double middle = (a + b) / 2;
        b = sqrt(a * b);
        a = middle;
    }
    return a;
}

/* A stiff rod on a pin, let go level with a body below its tip. Its centre of mass swings by the
 * angle theta to either side of the vertical with the period 4 sqrt(I/(M g d)) K(sin(theta/2)). It
 * bends by some M g L^2/EI = 1e-5. */
static void test_pendulum(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [1e7, 1e7], axial: 1e7, bending: [1e6, 1e6], torsion: 1e6}\n"
        "  inertia: {mass_per_length: 0.5, rotary: [1.0e-3, 1.0e-3, 1.0e-3]}\n"
        "bodies: [{at: 1, mass: 0.7, offset: [0.4, 0, 0.1], inertia: [0.01, 0.02, 0.03]}]\n"
        "boundary: {start: {type: pinned}}\n"
        "initial: {position: [s, 0, 0], rotation: [1, 0, 1, 0]}\n"
        "loads: {gravity: [0, 0, -9.81]}\n"
        "time: {duration: 3, windows: 4}\n";
    const double rod = 0.5, body = 0.7, along = 1.1, below = 0.4, g = 9.81, tip = 1;
    const double inertia = rod / 3 + 1e-3 + body * (along * along + below * below) + 0.02;
    const double x_moment = rod / 2 + body * along, z_moment = body * below;
    const double mgd = g * hypot(x_moment, z_moment), theta = atan2(x_moment, z_moment);
    const double K = acos(-1) / 2 / mean_of(1, cos(theta / 2));
    const double period = 4 * sqrt(inertia / mgd) * K;
    /* after half a period it is as far on the other side */
    const double other[3] = {cos(-acos(-1) + 2 * (acos(-1) / 2 - theta)), 0,
                             sin(-acos(-1) + 2 * (acos(-1) / 2 - theta))};
    const double level[3] = {1, 0, 0};
    const solve_settings settings = {.tolerance = 1e-7, .modes = {1, 0, 0, 0}};
    ad_error error = {.message = ""};
    modes_solution *motion = NULL;
    solve_state found[2];
    solved x;
    make_rod(&x, "pendulum.yaml", text);
    const double times[2] = {period / 2 / x.rod->scales.time, period / x.rod->scales.time};
    assert_int_equal(modes_motion_solve(x.rod, &settings, 2, times, &motion, &x.report, &error),
                     AD_OK);
    solve(&x, 7, 1e-7, 2, times);
    for (size_t i = 0; i < 2; i++) {
        const double *is = i ? level : other;
        assert_int_equal(modes_motion_at(motion, i, 1, &tip, &found[i], &error), AD_OK);
        const double by_modes = distance(found[i].position, is);
        const double by_nodes = distance(state_at(&x, i, 1).position, is);
        print_message("pendulum: modes %.1e, nodes %.1e\n", by_modes, by_nodes);
        assert_true(by_modes < 1e-5 && by_nodes < 1e-5);
    }
    modes_motion_free(motion);
    free_solved(&x);
}

/* Free of loads the centre of mass goes straight on, and no energy is lost. */
static void test_tumbling(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [40, 50], axial: 90, bending: [1, 1], torsion: 0.8}\n"
        "  inertia: {mass_per_length: 1, rotary: [0.03, 0.02, 0.05]}\n"
        "bodies: [{at: 0.5, mass: 0.5, offset: [0.2, 0.1, -0.1], inertia: [0.01, 0.02, 0.03]}]\n"
        "boundary: {start: {type: free}, end: {type: free}}\n"
        "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0], velocity: [0, '0.5 - s', 0],\n"
        "          angular_velocity: [1, 0, 0]}\n"
        "time: {duration: 2}\n";
    static const double c[3] = {0.2, 0.1, -0.1}, times[2] = {1, 2}, body = 0.5, all = 1.5;
    static const double first[3] = {0.5 * 0.2, 0.5 * 0.1, 1 * 0.5 + 0.5 * 0.4}; /* times all */
    static const double momentum[3] = {0, 0.5 * 0.1, 0.5 * 0.1}; /* of the body: w x c */
    const double at_first = 1 / 24.0 + 0.03 / 2 + 0.5 * (0.1 * 0.1 + 0.1 * 0.1) / 2 + 0.01 / 2;
    enum { PIECES = 32 }; /* Simpson's rule */
    solved x;
    make_rod(&x, "tumbling.yaml", text);
    solve(&x, 17, 1e-8, 2, times);
    for (size_t i = 0; i < 2; i++) {
        double sum[3] = {0}, is[3], R[3][3], beside[3];
        for (int k = 0; k <= PIECES; k++) {
            const double weight = (k % PIECES == 0 ? 1 : k % 2 ? 4 : 2) / (3.0 * PIECES);
            const solve_state at = state_at(&x, i, (double)k / PIECES);
            for (int j = 0; j < 3; j++) {
                sum[j] += weight * at.position[j] / all;
            }
        }
        const solve_state middle = state_at(&x, i, 0.5);
        rotation_matrix(middle.rotation, R);
        to_world(R, c, beside);
        for (int j = 0; j < 3; j++) {
            sum[j] += body * (middle.position[j] + beside[j]) / all;
            is[j] = (first[j] + times[i] * momentum[j]) / all;
        }
        const solve_energy *energy = &dynamic_energies(x.motion)[i];
        const double lost = at_first - energy->kinetic - energy->strain;
        print_message("tumbling: centre %.1e, energy %.1e of %.2g\n", distance(sum, is), lost,
                      at_first);
        assert_true(distance(sum, is) < 1e-7);     /* ten tolerances */
        assert_true(fabs(lost) < 1e-6 * at_first); /* of two hundred steps */
    }
    free_solved(&x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_weight),
                                       cmocka_unit_test(test_pendulum),
                                       cmocka_unit_test(test_tumbling)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
