/* Motions of rods by the classical solver: exact solutions, published histories, what a rod
 * conserves. Error bounds are some three times what is measured where no other reason is given. */
#include "allocations.h"
#include "fewer.h"
#include "motion_testing.h"

#include "physics/numerics/quaternion.h"

#include <stdio.h>
#include <string.h>

/* ---- manufactured solution ----------------------------------------------------------------- */

/* Largest error of the position at the end of the time, in SI units as in the configuration. */
static double manufactured_error(int nodes, double tolerance, long *steps)
{
    solved x;
    make_rod(&x, "configs/manufactured_dynamic.yaml", NULL);
    double t = 1, worst = 0;
    solve(&x, nodes, tolerance, 1, (double[]){x.rod->duration});
    for (int i = 0; i <= 20; i++) {
        double s = i / 20.0;
        const double exact[3] = {0.3 * s * s * cos(2 * t) + 0.1 * s * s * s,
                                 0.2 * s * s * sin(3 * t), s + 0.05 * s * s * sin(t)};
        solve_state state = state_at(&x, 0, s);
        worst = fmax(worst, distance(state.position, exact));
    }
    *steps = x.report.time_steps;
    free_solved(&x);
    return worst;
}

/* Every term of the equations, damping and drag among them. */
static void test_order_in_space(void **state)
{
    (void)state;
    const int nodes[4] = {6, 9, 12, 17};
    double error[4];
    long steps;
    for (int i = 0; i < (WATCHED ? 3 : 4); i++) {
        error[i] = manufactured_error(nodes[i], i < 3 ? 1e-7 : 1e-10, &steps);
        print_message("%d nodes: %.1e\n", nodes[i], error[i]);
    }
    /* Faster than any power: three nodes more gain a factor that itself grows. */
    assert_true(error[1] < error[0] / 10);
    assert_true(error[2] < error[1] / 20);
    /* The motion is unstable: a hundred times what steps are allowed, whose number turns on the
     * rounding of the kernels that OpenBLAS chose. */
    assert_true(WATCHED || error[3] < 1e-8);
}

/* The slope of log(error) over log(steps) by least squares over many tolerances: how many steps one
 * of them takes turns on rounding, and five of them leave 0.5 of the slope to chance. */
static void test_order_in_time(void **state)
{
    (void)state;
    enum { RUNS = WATCHED ? 5 : 13 };
    double x[RUNS], y[RUNS], mean_x = 0, mean_y = 0, above = 0, below = 0;
    for (int i = 0; i < RUNS; i++) {
        long steps;
        double error = manufactured_error(17, 1e-6 * pow(10, -0.25 * i), &steps);
        print_message("%ld steps: %.1e\n", steps, error);
        x[i] = log((double)steps);
        y[i] = log(error);
        mean_x += x[i] / RUNS;
        mean_y += y[i] / RUNS;
    }
    for (int i = 0; i < RUNS; i++) {
        above -= (x[i] - mean_x) * (y[i] - mean_y);
        below += (x[i] - mean_x) * (x[i] - mean_x);
    }
    print_message("order %.2f\n", above / below);
    assert_true(above / below > 3.8); /* 5, of stiff vibrations less: stages have order 2 */
}

/* What steps of one length, as many as `steps`, leave at the end; of positions, on the same mesh as
 * `fine` [nodes][MOTION_ROWS]. */
static double steps_error(motion *m, double duration, integrate_method method, int steps,
                          const double *fine, double *state)
{
    ad_error error = {.message = ""};
    integrate_settings settings = {method, .tolerance = 1e-10, .step = duration / steps};
    integrate_counts counts;
    solve_energy energy;
    double worst = 0;
    if (motion_integrate(m, &settings, 1, &duration, state, &energy, &counts, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (size_t i = 0; fine && i < motion_nodes(m) * MOTION_ROWS; i += MOTION_ROWS) {
        worst = fmax(worst, distance(state + i, fine + i));
    }
    return worst;
}

/* The stated order, where steps are small beside every vibration: of a stout rod. */
static void test_order_of_steps(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [3, 4], axial: 5, bending: [1, 1.5], torsion: 0.8}\n"
        "  inertia: {mass_per_length: 1, rotary: [0.2, 0.3, 0.4]}\n"
        "  damping: {strain: [0.1, 0.1, 0.1], curvature: [0.05, 0.05, 0.05]}\n"
        "boundary: {start: {type: clamped}}\n"
        "loads: {drag: 0.3, tip: {force: [2*sin(3*t), cos(2*t), 1], frame: follower}}\n"
        "time: {duration: 1}\n";
    const double nominal[2] = {[INTEGRATE_IMPLICIT] = 5, [INTEGRATE_EXPLICIT] = 4};
    double fine[5 * MOTION_ROWS], now[5 * MOTION_ROWS];
    ad_error error = {.message = ""};
    motion *m = NULL;
    solved x;
    make_rod(&x, "stout.yaml", text);
    if (motion_create(x.rod, 1, 1, NULL, 4, &m, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    steps_error(m, x.rod->duration, INTEGRATE_EXPLICIT, 1024, NULL, fine);
    for (int method = 0; method < 2; method++) {
        double coarse = steps_error(m, x.rod->duration, method, 64, fine, now);
        double half = steps_error(m, x.rod->duration, method, 128, fine, now);
        print_message("64 steps: %.1e, 128: %.1e, order %.2f of %.0f\n", coarse, half,
                      log2(coarse / half), nominal[method]);
        assert_near(log2(coarse / half), nominal[method], 0.2);
    }
    motion_free(m);
    free_solved(&x);
}

/* ---- published histories ------------------------------------------------------------------- */

/* D8a: the reference is good to 6e-12, and printed in full. Source: as configs/reference. */
static void test_loaded_cantilever(void **state)
{
    (void)state;
    static const double exact[5][3] = {{0.9988439902064237, 0, -0.03222181208313791},
                                       {0.9485131881798559, 0, -0.27545702514688936},
                                       {0.6382390929857518, 0, -0.7099332427270912},
                                       {0.1913752426799292, 0, -0.8675003714495297},
                                       {0.28976971024616704, 0, -0.8563839622444808}};
    solved x;
    make_rod(&x, "configs/cantilever_dynamic.yaml", NULL);
    solve(&x, 29, 1e-8, 5, (double[]){0.2, 0.4, 0.6, 0.8, 1});
    double worst = 0;
    for (size_t i = 0; i < 5; i++) {
        solve_state tip = state_at(&x, i, 1);
        worst = fmax(worst, distance(tip.position, exact[i]));
    }
    print_message("D8a: %.1e, %ld steps\n", worst, x.report.time_steps);
    assert_true(worst < 1e-9);
    const solve_energy *energy = dynamic_energies(x.motion);
    for (int i = 0; i < 5; i++) {
        assert_near(energy[i].kinetic + energy[i].strain, energy[i].work, 1e-7); /* ten steps */
        assert_near(energy[i].dissipated, 0, 0);
    }
    free_solved(&x);
}

/* D8d: released under its weight. That starts waves with kinks, which no polynomial follows fast:
 * the error falls as nodes^-3, to 8e-8 with 65 nodes; the reference is good to 4e-8. */
static void test_released_cantilever(void **state)
{
    (void)state;
    static const double exact[4][3] = {{0.73238223572757, 0, -0.6372451867290297},
                                       {0.6607374177176036, 0, -0.6957865193311547},
                                       {1.0000502889251002, 0, -0.00928638644000164},
                                       {0.8018599762047774, 0, -0.5649794239790529}};
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness:\n"
        "    shear: [545.4545454545455, 545.4545454545455]\n"
        "    axial: 1600\n"
        "    bending: [1, 1]\n"
        "    torsion: 0.7692307692307692\n"
        "  inertia: {mass_per_length: 1, rotary: [0.000625, 0.000625, 0.00125]}\n"
        "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}\n"
        "loads: {gravity: [0, 0, -5]}\n"
        "time: {duration: 2}\n";
    solved x;
    make_rod(&x, "released.yaml", text);
    solve(&x, 17, 1e-6, 4, (double[]){0.5, 1, 1.5, 2});
    double worst = 0;
    for (size_t i = 0; i < 4; i++) {
        solve_state tip = state_at(&x, i, 1);
        worst = fmax(worst, distance(tip.position, exact[i]));
    }
    print_message("D8d: %.1e, %ld steps\n", worst, x.report.time_steps);
    assert_true(worst < 2e-5);
    free_solved(&x);
}

/* ---- exact motions ------------------------------------------------------------------------- */

/* D4: a torsion wave of 6 rad, exact at any amplitude. */
static void test_torsion_wave(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [500, 500], axial: 1600, bending: [1, 1], torsion: 0.8}\n"
        "  inertia: {mass_per_length: 1, rotary: [0.0006, 0.0006, 0.00125]}\n"
        "initial:\n"
        "  position: [0, 0, s]\n"
        "  rotation: [cos(3*sin(pi*s/2)), 0, 0, sin(3*sin(pi*s/2))]\n"
        "time: {duration: 0.1}\n";
    solved x;
    make_rod(&x, "torsion.yaml", text);
    double t = 0.1, c = sqrt(0.8 / 0.00125), worst = 0;
    solve(&x, 33, 1e-8, 1, &t);
    for (int i = 0; i <= 10; i++) {
        double s = i / 10.0, half = 3 * sin(PI * s / 2) * cos(PI * c * t / 2);
        const double exact[4] = {cos(half), 0, 0, sin(half)};
        double apart[4];
        solve_state at = state_at(&x, 0, s);
        quaternion_quotient(at.rotation, exact, apart);
        worst = fmax(worst, 2 * hypot(hypot(apart[1], apart[2]), apart[3]));
    }
    print_message("D4: %.1e rad\n", worst);
    assert_true(worst < 4e-6); /* spins reach 200, of which a step may lose 1e-8 */
    free_solved(&x);
}

/* D5: a free rod that spins about d1, stretched by it; once round. */
static void test_spinning_rod(void **state)
{
    (void)state;
    const double axial = 90, mass = 1.3, rate = 4, k = rate * sqrt(mass / axial);
    char text[1024];
    snprintf(text, sizeof text,
             "rod:\n"
             "  length: 1\n"
             "  stiffness: {shear: [40, 50], axial: %g, bending: [1, 1], torsion: 0.5}\n"
             "  inertia: {mass_per_length: %g, rotary: [0.03, 0.02, 0.05]}\n"
             "boundary: {start: {type: free}, end: {type: free}}\n"
             "initial:\n"
             "  position: [0, 0, sin(%.17g*(s-0.5))/%.17g]\n"
             "  rotation: [1, 0, 0, 0]\n"
             "  velocity: [0, -%g*sin(%.17g*(s-0.5))/%.17g, 0]\n"
             "  angular_velocity: [%g, 0, 0]\n"
             "time: {duration: %.17g}\n",
             axial, mass, k, k * cos(k / 2), rate, k, k * cos(k / 2), rate, 2 * PI / rate);
    solved x;
    make_rod(&x, "spinning.yaml", text);
    solve(&x, 13, 1e-8, 1, (double[]){x.rod->duration});
    double worst = 0;
    for (int i = 0; i <= 10; i++) {
        double s = i / 10.0;
        const double exact[3] = {0, 0, sin(k * (s - 0.5)) / (k * cos(k / 2))};
        solve_state at = state_at(&x, 0, s);
        worst = fmax(worst, distance(at.position, exact));
    }
    print_message("D5: %.1e\n", worst);
    assert_true(worst < 1e-7);
    free_solved(&x);
}

/* D6: a helix that travels along itself with speed c and turns about and along its axis u, free of
 * loads; both ends are driven. */
static const double helix_u[3] = {1, -2, 3}, helix_c = 1.5, helix_d = 0.4;
static const double helix_v[3] = {0.018880647336480105, -0.029739776951672858, 1.05770887166236};

/* Parts of v along u and across it, and u x v/|u|. */
static double helix_parts(double along[3], double across[3], double aside[3])
{
    double k = sqrt(vector_dot(helix_u, helix_u));
    vector_cross(helix_u, helix_v, aside);
    for (int i = 0; i < 3; i++) {
        along[i] = helix_u[i] * vector_dot(helix_u, helix_v) / (k * k);
        across[i] = helix_v[i] - along[i];
        aside[i] /= k;
    }
    return k;
}

/* The pose at `s`, a text, as YAML; and its rates at t = 0. */
static void print_helix(char *text, size_t size, const char *s, bool rates)
{
    double along[3], across[3], aside[3], k = helix_parts(along, across, aside);
    size_t at = 0;
    for (int i = 0; i < 3; i++) {
        at += (size_t)snprintf(
            text + at, size - at, "%s%.17g*(%s)+%.17g*sin(%.17g*(%s))+%.17g*(1-cos(%.17g*(%s)))%s",
            i ? ", " : "position: [", along[i], s, across[i] / k, k, s, aside[i] / k, k, s,
            rates    ? ""
            : i == 0 ? "+0.4*t"
            : i == 1 ? "-0.8*t"
                     : "+1.2*t");
    }
    at += (size_t)snprintf(text + at, size - at, "], rotation: [cos(%.17g*(%s))", k / 2, s);
    for (int i = 0; i < 3; i++) {
        at += (size_t)snprintf(text + at, size - at, ", %.17g*sin(%.17g*(%s))", helix_u[i] / k,
                               k / 2, s);
    }
    for (int i = 0; rates && i < 3; i++) {
        at +=
            (size_t)snprintf(text + at, size - at, "%s%.17g+%.17g*cos(%.17g*s)+%.17g*sin(%.17g*s)",
                             i ? ", " : "], velocity: [", helix_d * helix_u[i] + helix_c * along[i],
                             helix_c * across[i], k, helix_c * aside[i], k);
    }
    snprintf(text + at, size - at, rates ? "], angular_velocity: [1.5, -3, 4.5]" : "]");
}

static void test_travelling_helix(void **state)
{
    (void)state;
    static char text[8192], start[2048], end[2048], initial[2048];
    print_helix(start, sizeof start, "1.5*t", false);
    print_helix(end, sizeof end, "1+1.5*t", false);
    print_helix(initial, sizeof initial, "s", true);
    snprintf(text, sizeof text,
             "rod:\n"
             "  length: 1\n"
             "  stiffness: {shear: [40, 50], axial: 90, bending: [1.2, 0.8], torsion: 0.5}\n"
             "  inertia: {mass_per_length: 1.3, rotary: [0.03, 0.02, 0.05]}\n"
             "  rest: {curvature: [1.0160696223870533, -2.1114776951672862, 1.4442075796726965]}\n"
             "boundary:\n"
             "  start: {type: driven, %s}\n"
             "  end: {type: driven, %s}\n"
             "initial: {%s}\n"
             "time: {duration: 1}\n",
             start, end, initial);
    solved x;
    make_rod(&x, "helix.yaml", text);
    solve(&x, 15, 1e-9, 1, (double[]){x.rod->duration});
    double along[3], across[3], aside[3], k = helix_parts(along, across, aside), worst = 0;
    for (int i = 0; i <= 10; i++) {
        double way = i / 10.0 + helix_c, exact[3];
        for (int j = 0; j < 3; j++) {
            exact[j] = along[j] * way + across[j] * sin(k * way) / k +
                       aside[j] * (1 - cos(k * way)) / k + helix_d * helix_u[j];
        }
        solve_state at = state_at(&x, 0, i / 10.0);
        worst = fmax(worst, distance(at.position, exact));
        worst = fmax(worst, distance(at.strain, helix_v));
        worst = fmax(worst, distance(at.curvature, helix_u));
    }
    print_message("D6: %.1e, %ld steps\n", worst, x.report.time_steps);
    assert_true(worst < 1e-7);
    free_solved(&x);
}

/* A locked rod is the limit of stiff ones, which differ from it by 1/stiffness. */
static void test_locked_strain(void **state)
{
    (void)state;
    static const char *const stiffness[3] = {"1e5", "1e6", ".inf"};
    char text[1024];
    double tip[3][3];
    for (int i = 0; i < 3; i++) {
        snprintf(text, sizeof text,
                 "rod:\n"
                 "  length: 1\n"
                 "  stiffness: {shear: [%s, %s], axial: %s, bending: [1, 1], torsion: 0.8}\n"
                 "  inertia: {mass_per_length: 1, rotary: [0.0006, 0.0006, 0.0012]}\n"
                 "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}\n"
                 "loads: {tip: {force: [0, 0, -8*sin(pi*t)^2]}}\n"
                 "time: {duration: 0.5}\n",
                 stiffness[i], stiffness[i], stiffness[i]);
        solved x;
        make_rod(&x, "locked.yaml", text);
        solve(&x, 17, 1e-6, 1, (double[]){0.5});
        memcpy(tip[i], state_at(&x, 0, 1).position, sizeof tip[i]);
        free_solved(&x);
    }
    for (int k = 0; k < 3; k++) {
        assert_near(tip[2][k], tip[1][k] + (tip[1][k] - tip[0][k]) / 9, 1e-5); /* the steps' */
    }
    print_message("1e5 and 1e6 differ by %.1e\n", distance(tip[0], tip[1]));
}

/* A rod that hangs and does not stretch stays where it is, however heavy: what springs in place of
 * the lock give way by is in the estimate. */
static void test_locked_strain_is_estimated(void **state)
{
    (void)state;
    static const double weights[2] = {3, 300}, tolerance = 1e-4;
    for (int i = 0; i < 2; i++) {
        char text[512];
        double off = 0, size = 0;
        snprintf(text, sizeof text,
                 "rod:\n"
                 "  model: kirchhoff\n"
                 "  length: 1\n"
                 "  stiffness: {bending: [1, 1], torsion: 0.8}\n"
                 "  inertia: {mass_per_length: 1, rotary: [0.0006, 0.0006, 0.0012]}\n"
                 "boundary: {start: {type: clamped}}\n"
                 "loads: {gravity: [0, 0, %g*sin(pi*t)]}\n"
                 "time: {duration: 0.5}\n",
                 weights[i]);
        solved x;
        make_rod(&x, "hanging.yaml", text);
        solve(&x, 0, tolerance, 2, (double[]){0.25, 0.5});
        for (int k = 0; k <= 20; k++) {
            for (size_t which = 0; which < 2; which++) {
                const double s = k / 20.0, by = state_at(&x, which, s).position[2] - s;
                off += by * by;
                size += s * s;
            }
        }
        print_message("hanging by %g EI/L^2: off by %.1e, estimated %.1e\n", weights[i],
                      sqrt(off / size), x.report.estimate_l2);
        assert_true(sqrt(off / size) < 2 * x.report.estimate_l2); /* of other times; not a tenth */
        assert_true((x.report.estimate_l2 < tolerance) == (weights[i] < 100));
        free_solved(&x);
    }
}

/* ---- conservation -------------------------------------------------------------------------- */

/* A free rod without loads or damping, bent and moving at random. */
static motion *random_motion(const solve_rod *rod, double *state, double *rate)
{
    ad_error error = {.message = ""};
    motion *m = NULL;
    if (motion_create(rod, 1e8, 2, NULL, 5, &m, &error) != AD_OK ||
        motion_at(m, 0, &error) != AD_OK || motion_initial(m, state, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (size_t i = 0; i < motion_nodes(m) * MOTION_ROWS; i++) {
        state[i] += 0.3 * sin(1.7 * (double)(i * i));
    }
    motion_prescribe(m, state);
    motion_rate(m, state, rate);
    return m;
}

/* d/dt of the energy, by a difference quotient along the motion. */
static double energy_rate(motion *m, const double *state, const double *rate)
{
    const double step = 1e-6;
    double moved[20 * MOTION_ROWS], energy[2];
    for (int way = 0; way < 2; way++) {
        for (size_t i = 0; i < motion_nodes(m) * MOTION_ROWS; i++) {
            moved[i] = state[i] + (way ? step : -step) * rate[i];
        }
        motion_energy now = motion_energy_of(m, moved);
        energy[way] = now.kinetic + now.strain;
    }
    return (energy[1] - energy[0]) / (2 * step);
}

/* Not to the order of a method but exactly, whatever the mesh. */
static void test_conservation(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [40, 50], axial: 90, bending: [1.2, 1], torsion: 0.5}\n"
        "  inertia: {mass_per_length: 1, rotary: [0.03, 0.02, 0.05]}\n"
        "boundary: {start: {type: free}, end: {type: free}}\n"
        "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0]}\n"
        "time: {duration: 1}\n";
    double now[20 * MOTION_ROWS], rate[20 * MOTION_ROWS], force[3] = {0}, moment[3] = {0};
    solved x;
    make_rod(&x, "free.yaml", text);
    motion *m = random_motion(x.rod, now, rate);
    static const double inertia[3] = {0.03, 0.02, 0.05}; /* over rhoA L^2 */
    double largest = 0;
    for (size_t i = 0; i < motion_nodes(m); i++) {
        const double *r = now + i * MOTION_ROWS, *q = r + MOTION_Q, *w = r + MOTION_W;
        const double *V_t = rate + i * MOTION_ROWS + MOTION_V, *w_t = V_t + 3;
        const double weight = motion_weights(m)[i];
        const double spin[3] = {inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2]};
        double R[3][3], gyroscopic[3], body[3], world[3], of_force[3];
        vector_cross(w, spin, gyroscopic);
        vector_cross(r, V_t, of_force);
        for (int k = 0; k < 3; k++) {
            body[k] = inertia[k] * w_t[k] + gyroscopic[k];
        }
        rotation_matrix(q, R);
        to_world(R, body, world);
        for (int k = 0; k < 3; k++) {
            force[k] += weight * V_t[k];
            moment[k] += weight * (of_force[k] + world[k]);
            largest = fmax(largest, fabs(weight * V_t[k]));
        }
    }
    double power = energy_rate(m, now, rate);
    print_message("forces up to %.1e, sums %.1e %.1e, power %.1e\n", largest, force[0], moment[0],
                  power);
    for (int k = 0; k < 3; k++) { /* rounding of some hundred operations */
        assert_near(force[k], 0, 1e-13 * largest);
        assert_near(moment[k], 0, 1e-13 * largest);
    }
    assert_near(power, 0, 1e-7 * largest); /* of the difference quotient */
    motion_free(m);
    free_solved(&x);
}

/* ---- settings ------------------------------------------------------------------------------ */

/* A short push from rest, which long steps would pass: m x_tt = 100 from 0.5 to 0.51, all along the
 * rod, so that it does not bend. */
static void test_blow(void **state)
{
    (void)state;
    static const char free_rod[] =
        "rod: {model: cosserat, length: 1,\n"
        "      stiffness: {shear: [100, 100], axial: 100, bending: [1, 1], torsion: 1},\n"
        "      inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.01]}}\n"
        "boundary: {start: {type: free}, end: {type: free}}\n"
        "loads: {force: [100*(step(t-0.5)-step(t-0.51)), 0, 0]}\n"
        "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0]}\n"
        "time: {duration: 1}\n";
    solved x;
    make_rod(&x, "blow.yaml", free_rod);
    solve(&x, 0, 1e-6, 1, (double[]){x.rod->duration});
    assert_true(x.report.estimate <= 1e-6);
    assert_near(state_at(&x, 0, 1).position[0], 0.005 + 0.49, 1e-6);
    free_solved(&x);
}

static void test_estimate(void **state)
{
    (void)state;
    static const double exact[3] = {0.28976971024616704, 0, -0.8563839622444808};
    solved x;
    make_rod(&x, "configs/cantilever_dynamic.yaml", NULL);
    solve(&x, 0, 1e-5, 2, (double[]){0.5, 1});
    solve_state tip = state_at(&x, 1, 1);
    double error = distance(tip.position, exact);
    print_message("error %.1e, estimate %.1e\n", error, x.report.estimate);
    assert_true(error <= x.report.estimate && x.report.estimate <= 1e-5);
    assert_near(x.report.time, 1, 0);
    free_solved(&x);
}

static void test_refusals(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    solve_settings settings = {.tolerance = 1e-6};
    solve_report report;
    solved x;
    make_rod(&x, "configs/cantilever_dynamic.yaml", NULL);
    const double late[2] = {0.5, 1.5};
    assert_int_equal(dynamic_solve(x.rod, &settings, 2, late, &x.motion, &report, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "time 1 is 1.5; allowed: ascending, from 0 to 1"));
    free_solved(&x);
    make_rod(&x, "pointlike.yaml",
             "rod:\n"
             "  stiffness: {shear: [40, 50], axial: 90, bending: [1.2, 1], torsion: 0.5}\n"
             "  length: 1\n"
             "  inertia: {mass_per_length: 1, rotary: [0.03, 0.02, 0]}\n"
             "time: {duration: 1}\n");
    assert_int_equal(dynamic_solve(x.rod, &settings, 1, late, &x.motion, &report, &error),
                     AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "rotary inertia about d3 is 0"));
    assert_null(x.motion);
    free_solved(&x);
}

/* Whichever allocation fails, it is told (or, of a formula's value, survived) and nothing is left.
 */
static void test_no_memory(void **state)
{
    (void)state;
    solve_settings settings = {.tolerance = 1e-2};
    long needed = 0;
    int told = 0;
    for (long n = 0; n <= needed; n += n < 20 ? 1 : FARTHER(1)) {
        solved x;
        make_rod(&x, "configs/cantilever_dynamic.yaml", NULL);
        allocations = 0;
        failing_allocation = n;
        ad_status status =
            dynamic_solve(x.rod, &settings, 1, (double[]){0.1}, &x.motion, &x.report, NULL);
        failing_allocation = 0;
        needed = n == 0 ? allocations : needed;
        assert_true(status == AD_OK || (status == AD_NO_MEMORY && x.motion == NULL));
        told += status == AD_NO_MEMORY;
        free_solved(&x);
    }
    assert_true(needed > 50 && told > FEWER(50));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_order_of_steps),
        cmocka_unit_test(test_torsion_wave),
        cmocka_unit_test(test_spinning_rod),
        cmocka_unit_test(test_conservation),
        cmocka_unit_test(test_estimate),
        cmocka_unit_test(test_blow),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_no_memory),
        cmocka_unit_test(test_locked_strain_is_estimated),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_order_in_space),      cmocka_unit_test(test_travelling_helix),
        cmocka_unit_test(test_order_in_time),       cmocka_unit_test(test_loaded_cantilever),
        cmocka_unit_test(test_released_cantilever), cmocka_unit_test(test_locked_strain),
    };
    return run_with_alike(tests, alike, NULL, NULL);
}
