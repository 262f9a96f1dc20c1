/* Rods in motion by strain modes: derivatives against difference quotients, frequencies in closed
 * form, the full solver, energy; steps and what is seen of a rod for filters and controllers. */
#include "allocations.h"
#include "fewer.h"
#include "law_testing.h"
#include "modes_testing.h"

#include "autodiff/dense.h"
#include "physics/chain/reduced.h"
#include "physics/solve/modes_motion.h"

#include <stdlib.h>
#include <string.h>

/* ---- equations ----------------------------------------------------------------------------- */

static void test_derivatives(void **state)
{
    (void)state;
    const scene_law law = random_law(SCENE_SYMMETRY_POINT, false, 3); /* beyond its stiffness */
    for (int i = 0; i < 2; i++) {
        const double few = worst_derivative(0, i ? &law : NULL, 0, NULL);
        const double more = worst_derivative(4, i ? &law : NULL, 0, NULL);
        print_message("derivatives: %.1e, with more points %.1e\n", few, more);
        assert_true(few < 3e-8);
        assert_true(more < 1e-9); /* difference quotients leave 1e-10 */
    }
}

/* The first frequencies of a slender clamped rod, w = (beta L)^2 sqrt(EI/(rhoA L^4)). */
static void test_frequencies(void **state)
{
    (void)state;
    static const double beta[3] = {1.8751040687119611, 4.694091132974175, 7.854757438237613};
    static const char slender[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8},\n"
        "      inertia: {mass_per_length: 1, rotary: [1.0e-9, 1.0e-9, 1.0e-9]}}\n"
        "boundary: {start: {type: clamped}}\n"
        "time: {duration: 1}\n";
    enum { N = 12 };
    reduced_test x = make("slender.yaml", slender, modes_counts_of(N, 0, 0, 0), 4);
    double by_q[4 * N * N], by_v[4 * N * N], q[2 * N] = {0}, residual[2 * N];
    double found[3][N];
    const int width = x.m->width;
    assert_int_equal(modes_size(x.m), 2 * N);
    modes_shape(x.m, q, q, q);
    modes_forces(x.m, true, residual);
    modes_mass(x.m);
    modes_derivatives(x.m, by_q, by_v);
    for (int i = 0; i < 3; i++) { /* inverse iteration about the first direction, deflated */
        double *y = found[i], omega = 0;
        for (int k = 0; k < N; k++) {
            y[k] = 1.0 / (1 + k + i);
        }
        for (int round = 0; round < 60; round++) {
            double right[N], K[N * N], size = 0;
            int pivots[N];
            for (int j = 0; j < i; j++) {
                double part = 0;
                for (int r = 0; r < N; r++) {
                    for (int c = 0; c < N; c++) {
                        part += found[j][r] * x.m->mass[r * width + c] * y[c];
                    }
                }
                for (int k = 0; k < N; k++) {
                    y[k] -= part * found[j][k];
                }
            }
            for (int r = 0; r < N; r++) {
                right[r] = 0;
                for (int c = 0; c < N; c++) {
                    right[r] += x.m->mass[r * width + c] * y[c];
                    K[c * N + r] = by_q[r * width + c];
                }
            }
            assert_int_equal(ad_dense_lu(N, K, pivots), 0);
            ad_dense_lu_solve(N, 1, K, pivots, right);
            for (int r = 0; r < N; r++) {
                for (int c = 0; c < N; c++) {
                    size += right[r] * x.m->mass[r * width + c] * right[c];
                }
            }
            omega = pow(size, -0.25);
            for (int k = 0; k < N; k++) {
                y[k] = right[k] / sqrt(size);
            }
        }
        print_message("frequency %d: %.12g of %.12g\n", i, omega, beta[i] * beta[i]);
        assert_true(fabs(omega / (beta[i] * beta[i]) - 1) < 1e-7); /* rotary inertia: 1e-8 */
    }
    discard(&x);
}

/* ---- motions ------------------------------------------------------------------------------- */

static double difference(const char *path, const int *counts, double tolerance,
                         const dynamic_solution *full, double *mismatch)
{
    ad_error error = {.message = ""};
    enum { TIMES = 5, PLACES = 9 };
    solved x;
    modes_solution *motion = NULL;
    solve_settings settings = {.tolerance = tolerance};
    double times[TIMES], s[PLACES], worst = 0;
    make_rod(&x, path, NULL);
    for (int i = 0; i < 4 && counts; i++) {
        settings.modes[i] = counts[i];
    }
    for (int i = 0; i < TIMES; i++) {
        times[i] = x.rod->duration * (i + 1) / TIMES;
    }
    for (int i = 0; i < PLACES; i++) {
        s[i] = (double)i / (PLACES - 1);
    }
    if (modes_motion_solve(x.rod, &settings, TIMES, times, &motion, &x.report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (size_t i = 0; i < TIMES; i++) {
        solve_state a[PLACES], b[PLACES];
        assert_int_equal(modes_motion_at(motion, i, PLACES, s, a, &error), AD_OK);
        assert_int_equal(dynamic_at(full, i, PLACES, s, b, &error), AD_OK);
        for (int k = 0; k < PLACES; k++) {
            worst = fmax(worst, distance(a[k].position, b[k].position));
        }
    }
    *mismatch = x.report.energy_mismatch;
    if (!counts) {
        assert_true(x.report.estimate_l2 <= tolerance);
    }
    modes_motion_free(motion);
    free_solved(&x);
    return worst;
}

/* As modes grow the motion becomes that of spectral elements; the error that is asked for is met.
 */
static void compare_with_full(const char *path, double last)
{
    static const int counts[4][4] = {{2, 1, 2, 1}, {4, 1, 3, 2}, {7, 1, 5, 5}, {10, 1, 7, 8}};
    const double times[5] = {0.2, 0.4, 0.6, 0.8, 1};
    double at[5], before = INFINITY, mismatch;
    solved full;
    make_rod(&full, path, NULL);
    for (int i = 0; i < 5; i++) {
        at[i] = times[i] * full.rod->duration;
    }
    solve(&full, 0, 1e-6, 5, at);
    for (int i = 0; i < 4; i++) {
        const double error = difference(path, counts[i], 1e-6, full.motion, &mismatch);
        print_message("%s, modes %d,%d,%d,%d: %.1e, energy %.1e\n", path, counts[i][0],
                      counts[i][1], counts[i][2], counts[i][3], error, mismatch);
        assert_true(error < 0.5 * before);
        assert_true(mismatch < 1e-4);
        before = error;
    }
    assert_true(before < last);
    const double error = difference(path, NULL, 1e-4, full.motion, &mismatch);
    print_message("%s, tolerance 1e-4: %.1e\n", path, error);
    assert_true(error < SOLVE_PEAK * 1e-4);
    free_solved(&full);
}

static void test_full_solver(void **state)
{
    (void)state;
    compare_with_full("configs/cantilever_dynamic.yaml", 3e-6);
    compare_with_full("configs/robots/tendon_in_motion.yaml", 1e-5);
}

/* Two modes of curvature in a plane, under gravity: Lagrange's equations of the angle's polynomial,
 * written in numpy with sums over 40 points of Gauss, by scipy's DOP853 to 1e-12. */
static void test_plane(void **state)
{
    (void)state;
    static const char falling[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8},\n"
        "      inertia: {mass_per_length: 1, rotary: [1.0e-3, 1.0e-3, 2.0e-3]}}\n"
        "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}\n"
        "loads: {gravity: [0, 0, -3]}\n"
        "time: {duration: 2}\n";
    const double exact[3] = {0.967903069752, 0, -0.233130064591}, tip = 1, end = 2;
    const solve_settings settings = {.tolerance = 1e-9, .modes = {2, 0, 0, 0}};
    ad_error error = {.message = ""};
    modes_solution *motion = NULL;
    solve_state found;
    solved x;
    make_rod(&x, "falling.yaml", falling);
    assert_int_equal(modes_motion_solve(x.rod, &settings, 1, &end, &motion, &x.report, &error),
                     AD_OK);
    assert_int_equal(modes_motion_at(motion, 0, 1, &tip, &found, &error), AD_OK);
    print_message("in a plane: %.1e from scipy\n", distance(found.position, exact));
    assert_true(distance(found.position, exact) < 1e-10); /* steps of 1e-9 */
    modes_motion_free(motion);
    free_solved(&x);
}

/* A stiff rod that hangs from a pin and is let go level swings as a rigid one, whose period is
 * 4 sqrt(2 L / (3 g)) K(sin(pi/4)). It bends by some 1e-6. */
static void test_pendulum(void **state)
{
    (void)state;
    static const char hanging[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1.0e5, 1.0e5], torsion: 1.0e5},\n"
        "      inertia: {mass_per_length: 1, rotary: [1.0e-7, 1.0e-7, 2.0e-7]}}\n"
        "boundary: {start: {type: pinned}}\n"
        "initial: {position: [s, 0, 0], rotation: [1, 0, 1, 0]}\n"
        "loads: {gravity: [0, 0, -9.81]}\n"
        "time: {duration: 2, windows: 1}\n";
    const double K = 1.8540746773013719, tip = 1, level[3] = {1, 0, 0};
    const double period = 4 * sqrt(2 / (3 * 9.81)) * K;
    const solve_settings settings = {.tolerance = 1e-7, .modes = {1, 0, 0, 0}};
    ad_error error = {.message = ""};
    modes_solution *motion = NULL;
    solve_state found[2];
    solved x;
    make_rod(&x, "hanging.yaml", hanging);
    const double times[2] = {period / 2 / x.rod->scales.time, period / x.rod->scales.time};
    assert_int_equal(modes_motion_solve(x.rod, &settings, 2, times, &motion, &x.report, &error),
                     AD_OK);
    for (size_t i = 0; i < 2; i++) {
        assert_int_equal(modes_motion_at(motion, i, 1, &tip, &found[i], &error), AD_OK);
    }
    const double other[3] = {-1, 0, 0};
    print_message("pendulum: %.1e, %.1e\n", distance(found[0].position, other),
                  distance(found[1].position, level));
    assert_true(distance(found[0].position, other) < 1e-5);
    assert_true(distance(found[1].position, level) < 1e-5);
    modes_motion_free(motion);
    free_solved(&x);
}

/* A Kirchhoff rod that swings freely for some twenty periods of its first mode: what Radau's method
 * takes is below a millionth. */
static void test_energy(void **state)
{
    (void)state;
    static const char swinging[] =
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 0.8},\n"
        "      inertia: {mass_per_length: 1, rotary: [1.0e-4, 1.0e-4, 2.0e-4]}}\n"
        "boundary: {start: {type: clamped}}\n"
        "initial: {velocity: [0.5*s^2, 0.2*s^2, 0], angular_velocity: [-0.4*s, s, 0]}\n"
        "time: {duration: 35}\n";
    ad_error error = {.message = ""};
    reduced_test x = make("swinging.yaml", swinging, modes_counts_of(4, 2, 0, 0), 0);
    modes_solution *motion = NULL;
    solve_report report;
    const solve_settings settings = {.tolerance = 1e-7, .modes = {4, 2, 0, 0}};
    const double times[2] = {17.5, 35};
    assert_int_equal(modes_motion_solve(x.rod, &settings, 2, times, &motion, &report, &error),
                     AD_OK);
    const solve_energy *energy = modes_motion_energies(motion);
    print_message("energy: %.1e of %.3g lost after 20 periods\n", energy[1].mismatch,
                  report.energy);
    assert_true(report.energy > 0.01);
    assert_true(report.energy_mismatch < 1e-6);
    modes_motion_free(motion);
    discard(&x);
}

/* ---- for filters and controllers ------------------------------------------------------------ */

static void assert_quotient(const char *what, int rows, int columns, int column, double by,
                            const double *low, const double *high, const double *derivative,
                            double tolerance)
{
    double worst = 0, size = 0;
    for (int r = 0; r < rows; r++) {
        const double quotient = (high[r] - low[r]) / by;
        worst = fmax(worst, fabs(quotient - derivative[r * columns + column]));
        size = fmax(size, fabs(quotient));
    }
    if (!(worst <= tolerance * (1 + size))) {
        fail_msg("%s, column %d: %.2e of %.2e", what, column, worst, size);
    }
}

enum { STATES = 32, INPUTS = 2 };

/* Positions, world turns, velocities, spins [12]; turns as those from `from`. */
static void seen(const reduced_place *x, const reduced_place *from, double *to)
{
    double turn[4], body[3], R[3][3], q[4];
    quaternion_quotient(from->rotation, x->rotation, turn);
    for (int k = 0; k < 3; k++) {
        body[k] = 2 * copysign(turn[1 + k], turn[1 + k] * turn[0]);
        to[k] = x->position[k];
        to[6 + k] = x->velocity[k];
        to[9 + k] = x->angular_velocity[k];
    }
    memcpy(q, from->rotation, sizeof q);
    rotation_matrix(q, R);
    to_world(R, body, to + 3);
}

static void test_reduced(void **state)
{
    (void)state;
    const double places[2] = {0.45, 1}, h = 1e-5, step = 0.05, t = 0.2;
    const reduced_settings settings = {.modes = {2, 1, 1, 1}, .count = 2, .s = places};
    ad_error error = {.message = ""};
    config *given = NULL;
    reduced_rod *rod = NULL;
    double x[STATES], inputs[INPUTS] = {170, 1.3}, rate[STATES], A[STATES * STATES];
    double B[STATES * INPUTS], S[STATES * STATES], T[STATES * INPUTS], next[STATES];
    double C[2 * 12 * STATES], ends[2][STATES], looks[2][24];
    reduced_place at[2], now[2];
    unsigned seed = 3;
    if (prepare_read("everything.yaml", everything, 0, NULL, &given, &error) != AD_OK ||
        reduced_create(&given->scene, &settings, &rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    const int n = reduced_states(rod);
    assert_true(n <= STATES);
    assert_int_equal(reduced_inputs(rod), INPUTS);
    assert_string_equal(reduced_input(rod, 1)->name, "e");
    assert_int_equal(reduced_initial(rod, inputs, x, &error), AD_OK);
    for (int k = 0; k < n; k++) {
        x[k] += 0.2 * noise(&seed);
    }
    assert_int_equal(reduced_rate(rod, t, x, inputs, rate, A, B, &error), AD_OK);
    assert_int_equal(reduced_step(rod, t, step, x, inputs, next, S, T, &error), AD_OK);
    assert_int_equal(reduced_output(rod, t, x, inputs, at, C, &error), AD_OK);
    const long before = allocations;
    for (int c = 0; c < n + INPUTS; c++) {
        double *to = c < n ? &x[c] : &inputs[c - n];
        const double kept = *to;
        const double *derivatives[2] = {c < n ? A : B, c < n ? S : T};
        const int columns = c < n ? n : INPUTS, column = c < n ? c : c - n;
        double by = 0;
        for (int which = 0; which < 2; which++) {
            by = (which ? 100 : 1) * h * (c < n ? 1 : kept);
            for (int side = 0; side < 2; side++) {
                *to = kept + (side ? by : -by);
                assert_int_equal(
                    which ? reduced_step(rod, t, step, x, inputs, ends[side], NULL, NULL, &error)
                          : reduced_rate(rod, t, x, inputs, ends[side], NULL, NULL, &error),
                    AD_OK);
            }
            /* Newton's method in a step stops at 1e-6 */
            assert_quotient(which ? "step" : "rate", n, columns, column, 2 * by, ends[0], ends[1],
                            derivatives[which], which ? 1e-2 : 1e-6);
        }
        by = h;
        for (int side = 0; side < 2 && c < n; side++) {
            *to = kept + (side ? by : -by);
            assert_int_equal(reduced_output(rod, t, x, inputs, now, NULL, &error), AD_OK);
            seen(&now[0], &at[0], looks[side]);
            seen(&now[1], &at[1], looks[side] + 12);
        }
        if (c < n) {
            assert_quotient("output", 24, n, c, 2 * by, looks[0], looks[1], C, 1e-6);
        }
        *to = kept;
    }
    assert_int_equal(reduced_settle(rod, t, inputs, next, &error), AD_OK);
    next[0] = NAN; /* no answer, but no undefined one either */
    assert_int_equal(reduced_rate(rod, t, next, inputs, rate, NULL, NULL, &error), AD_NOT_FINITE);
    assert_int_equal(reduced_step(rod, t, step, next, inputs, x, NULL, NULL, &error),
                     AD_NOT_FINITE);
    assert_int_equal(reduced_settle(rod, t, inputs, next, &error), AD_NOT_FINITE);
    assert_int_equal(allocations, before);
    reduced_free(rod);
    config_free(given);
}

/* The lowest frequency of a rod near rest: inverse iteration of M^-1 K = -d(rate)/d(modes). */
static double lowest_frequency(reduced_rod *rod, const double *inputs)
{
    enum { MODES_MAX = 12 };
    ad_error error = {.message = ""};
    const int n = reduced_states(rod), half = n / 2;
    double x[2 * MODES_MAX], rate[2 * MODES_MAX], A[4 * MODES_MAX * MODES_MAX];
    double matrix[MODES_MAX * MODES_MAX], y[MODES_MAX], size = 0;
    int pivots[MODES_MAX];
    assert_true(half <= MODES_MAX);
    assert_int_equal(reduced_initial(rod, inputs, x, &error), AD_OK);
    assert_int_equal(reduced_rate(rod, 0, x, inputs, rate, A, NULL, &error), AD_OK);
    for (int r = 0; r < half; r++) {
        y[r] = 1;
        for (int c = 0; c < half; c++) {
            matrix[c * half + r] = -A[(half + r) * n + c];
        }
    }
    assert_int_equal(ad_dense_load(&error), AD_OK);
    assert_int_equal(ad_dense_lu(half, matrix, pivots), 0);
    for (int round = 0; round < 60; round++) {
        ad_dense_lu_solve(half, 1, matrix, pivots, y);
        size = 0;
        for (int k = 0; k < half; k++) {
            size = fmax(size, fabs(y[k]));
        }
        for (int k = 0; k < half; k++) {
            y[k] /= size;
        }
    }
    return sqrt(1 / size);
}

/* beta of a clamped beam with a mass mu rhoA L at its tip: 1 + cos cosh + mu beta (cos sinh - sin
 * cosh) = 0. */
static double loaded_beta(double mu)
{
    double low = 0.1, high = 1.9;
    for (int i = 0; i < 60; i++) {
        const double b = 0.5 * (low + high);
        const double off = cos(b) * sinh(b) - sin(b) * cosh(b);
        *(1 + cos(b) * cosh(b) + mu * b * off > 0 ? &low : &high) = b;
    }
    return low;
}

/* A body's mass and inertia, and a foundation, as inputs: frequencies in closed form, derivatives
 * against differences, and the rod that has these numbers. */
static void test_bodies_as_inputs(void **state)
{
    (void)state;
    static const char arm[] =
        "parameters: {m: %s, k: %s}\n"
        "rod:\n  model: kirchhoff\n  length: 1\n  section: {shape: circle, radius: 2.0e-4}\n"
        "  material: {youngs_modulus: 1.0e9, poissons_ratio: 0.3, density: 1000}\n"
        "boundary: {start: {type: clamped}}\n"
        "bodies: [{at: 1, mass: m, inertia: [%s*m, %s*m, %s*m]}]\n"
        "loads: {foundation: [k, k, 0]}\n"
        "time: {duration: 1}\n";
    const double radius = 2e-4, area = PI * radius * radius, rhoA = 1000 * area;
    const double unit = sqrt(1e9 * area * radius * radius / 4 / rhoA), tip = 1, h = 1e-4;
    const reduced_settings settings = {.modes = {5, 0, 0, 0}, .count = 1, .s = &tip};
    const double masses[3] = {0, 0.3, 2};
    ad_error error = {.message = ""};
    for (int heavy = 0; heavy < 2; heavy++) { /* without and with inertia of the body */
        const char *j = heavy ? "0.01" : "0";
        char text[800], m[40], k[40];
        reduced_rod *rods[2];
        config *given[2];
        const double inputs[2] = {0.7 * rhoA, 0.4 * rhoA * unit * unit};
        for (int which = 0; which < 2; which++) {
            snprintf(m, sizeof m, which ? "%.17g" : "{range: [0, %.17g]}",
                     which ? inputs[0] : 3 * rhoA);
            snprintf(k, sizeof k, which ? "%.17g" : "{range: [0, %.17g]}",
                     which ? inputs[1] : 9 * rhoA * unit * unit);
            snprintf(text, sizeof text, arm, m, k, j, j, j);
            if (prepare_read("arm.yaml", text, 0, NULL, &given[which], &error) != AD_OK ||
                reduced_create(&given[which]->scene, &settings, &rods[which], &error) != AD_OK) {
                fail_msg("%s", error.message);
            }
        }
        for (int i = 0; i < 3 && !heavy; i++) {
            const double at[2] = {masses[i] * rhoA, 0}, beta = loaded_beta(masses[i]);
            const double omega = lowest_frequency(rods[0], at), is = beta * beta * unit;
            print_message("tip mass %g: %.10g of %.10g\n", masses[i], omega, is);
            assert_true(fabs(omega / is - 1) < 1e-6); /* five modes; rotary inertia: 1e-8 */
        }
        if (!heavy) { /* a uniform foundation leaves the shape: omega^2 + k/rhoA */
            const double at[2] = {0, 5 * rhoA * unit * unit}, beta = loaded_beta(0);
            const double is = unit * sqrt(pow(beta, 4) + 5);
            assert_true(fabs(lowest_frequency(rods[0], at) / is - 1) < 1e-6);
        }
        const int n = reduced_states(rods[0]);
        double x[STATES], rate[2][STATES], A[STATES * STATES], B[STATES * INPUTS];
        unsigned seed = 5;
        for (int i = 0; i < n; i++) {
            x[i] = 0.4 * noise(&seed);
        }
        assert_int_equal(reduced_rate(rods[0], 0, x, inputs, rate[0], A, B, &error), AD_OK);
        assert_int_equal(reduced_rate(rods[1], 0, x, NULL, rate[1], NULL, NULL, &error), AD_OK);
        for (int i = 0; i < n; i++) { /* condition of the mass: 1e3 */
            assert_true(fabs(rate[1][i] - rate[0][i]) <= 1e-10 * (1 + fabs(rate[0][i])));
        }
        for (int c = 0; c < INPUTS; c++) {
            double at[2] = {inputs[0], inputs[1]};
            for (int side = 0; side < 2; side++) {
                at[c] = inputs[c] * (1 + (side ? h : -h));
                assert_int_equal(reduced_rate(rods[0], 0, x, at, rate[side], NULL, NULL, &error),
                                 AD_OK);
            }
            for (int i = 0; i < n; i++) { /* by a change of all of it */
                rate[0][i] *= inputs[c];
                rate[1][i] *= inputs[c];
                B[i * INPUTS + c] *= inputs[c];
            }
            assert_quotient(c ? "foundation" : "mass", n, INPUTS, c, 2 * h * inputs[c], rate[0],
                            rate[1], B, 1e-5);
        }
        for (int which = 0; which < 2; which++) {
            reduced_free(rods[which]);
            config_free(given[which]);
        }
    }
}

/* Without memory there is an error and no leak. */
static void test_memory(void **state)
{
    (void)state;
    const double tip = 1;
    const reduced_settings settings = {.modes = {1, 1, 1, 1}, .count = 1, .s = &tip};
    ad_error error = {.message = ""};
    ad_status status = AD_NO_MEMORY;
    config *given = NULL;
    reduced_rod *rod = NULL;
    assert_int_equal(prepare_read("everything.yaml", everything, 0, NULL, &given, &error), AD_OK);
    for (long n = 1; status == AD_NO_MEMORY && n < 100000; n += 1 + n / 20) {
        allocations = 0;
        failing_allocation = n;
        status = reduced_create(&given->scene, &settings, &rod, &error);
        failing_allocation = 0;
        assert_true(status == AD_OK || (status == AD_NO_MEMORY && !rod));
    }
    assert_int_equal(status, AD_OK);
    reduced_free(rod);
    config_free(given);
}

/* A motion in two halves, with what is seen of the first as the start of the second, in as many
 * modes: what is seen lies 1/100 of the length apart and goes through polynomials of degree 5. */
static void test_from_seen(void **state)
{
    (void)state;
    enum { SEEN = 101, COLUMNS = 25 };
    static const char arm[] =
        "rod:\n  length: 0.6\n  section: {shape: circle, radius: 0.03}\n"
        "  material: {youngs_modulus: 1.0e6, poissons_ratio: 0.5, density: 1000}\n"
        "  damping: {strain: [10, 10, 10], curvature: [0.02, 0.02, 0.02]}\n"
        "boundary: {start: {type: clamped}}\n"
        "loads: {gravity: [-9.81, -3, 0]}\n";
    ad_error error = {.message = ""};
    solve_settings settings = {.tolerance = 1e-9, .method = SOLVE_MODES, .modes = {6, 3, 4, 4}};
    solve_seen seen[SEEN];
    double s[SEEN], t[SEEN], values[COLUMNS * SEEN], tip[2][3];
    const double times[3] = {0.2, 0.4, 0.2}; /* the first half, the whole, the second half */
    for (int i = 0; i < 3; i++) {
        char text[600];
        config *all = NULL;
        solution *solved = NULL;
        solve_report report;
        snprintf(text, sizeof text, "%stime: {duration: %g}\n", arm, times[i]);
        settings.from = seen;
        settings.from_count = i == 2 ? SEEN : 0;
        for (int k = 0; k < SEEN; k++) {
            s[k] = 0.6 * k / (SEEN - 1);
            t[k] = times[i];
        }
        if (prepare_read("arm.yaml", text, 0, NULL, &all, &error) != AD_OK ||
            solution_create(&all->scene, &settings, 1, t, &solved, &report, &error) != AD_OK ||
            solution_evaluate(solved, COLUMNS, SEEN, s, t, values, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        for (int k = 0; k < SEEN && i == 0; k++) {
            double *to = seen[k].position; /* x to qz, then vx to w3 */
            seen[k].s = s[k];
            for (int c = 0; c < 13; c++) {
                to[c] = values[(c < 7 ? c : c + 12) * SEEN + k];
            }
        }
        for (int c = 0; c < 3 && i > 0; c++) {
            tip[i - 1][c] = values[c * SEEN + SEEN - 1];
        }
        solution_free(solved);
        config_free(all);
    }
    print_message("in two halves: %.1e m\n", distance(tip[0], tip[1]));
    assert_true(distance(tip[0], tip[1]) < 1e-7); /* measured: see the distance of rows */
}

/* A chosen motion, whose loads all terms of the equations ask for, and whose start moves and turns.
 */
static void test_manufactured(void **state)
{
    (void)state;
    static const char *const changes[] = {
        "manufactured.position[0]=0.3*s^2*cos(2*t) + 0.1*s^3 + 0.1*t^2",
        "manufactured.angles[0]=0.7*sin(pi*s/2)*cos(2*t) + 0.4*s^2 + 0.2*t",
        "boundary.start.type=driven"};
    solve_report report = solve_report_blank();
    config *of = NULL;
    solution *made = NULL;
    double at[3], off = 0;
    ad_error error = {.message = ""};
    if (prepare_read("configs/manufactured_dynamic.yaml", NULL, 3, changes, &of, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    solve_settings settings = solve_settings_default(&of->scene);
    settings.method = SOLVE_MODES;
    settings.tolerance = 1e-6;
    if (solution_create(&of->scene, &settings, 1, (double[]){1}, &made, &report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (int i = 0; i <= 10; i++) {
        const double s = i / 10.0, t = 1;
        const double exact[3] = {0.3 * s * s * cos(2 * t) + 0.1 * s * s * s + 0.1 * t * t,
                                 0.2 * s * s * sin(3 * t), s + 0.05 * s * s * sin(t)};
        assert_int_equal(solution_evaluate(made, 3, 1, &s, &t, at, &error), AD_OK);
        off = fmax(off, distance(at, exact));
    }
    print_message("manufactured: off by %.1e, estimate %.1e\n", off, report.estimate);
    assert_true(off < 1e-5); /* a moving start; the motion is unstable, and its end the worst */
    solution_free(made);
    config_free(of);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_derivatives), cmocka_unit_test(test_frequencies),
        cmocka_unit_test(test_plane),       cmocka_unit_test(test_pendulum),
        cmocka_unit_test(test_reduced),     cmocka_unit_test(test_memory),
        cmocka_unit_test(test_from_seen),   cmocka_unit_test(test_bodies_as_inputs),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_manufactured),
                                       cmocka_unit_test(test_full_solver),
                                       cmocka_unit_test(test_energy)};
    return run_with_alike(tests, alike, NULL, NULL);
}
