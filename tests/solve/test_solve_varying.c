/* What varies along a rod or with time, by the classical solvers in SI units: tapered rods, a rest
 * shape that changes, gravity that turns; against closed forms and integrations of their own. */
#include "fewer.h"
#include "near.h"

#include "physics/solve/solve.h"
#include "physics/solve/stability.h"
#include "tools/prepare/prepare.h"

#include <stdio.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Columns of a rod. */
enum { X = 0, Y = 1, Z = 2, U1 = 10, M1 = 16, COLUMNS = 25 };

typedef struct solved {
    config *settings;
    solution *solution;
    solve_report report;
} solved;

static solved solve_with(const char *path, const char *text, int count_overrides,
                         const char *const *overrides, double tolerance, size_t count,
                         const double *times)
{
    ad_error error = {.message = ""};
    solve_settings settings = {.tolerance = tolerance};
    solved x = {.settings = NULL};
    if (prepare_read(path, text, count_overrides, overrides, &x.settings, &error) != AD_OK ||
        solution_create(&x.settings->scene, &settings, count, times, &x.solution, &x.report,
                        &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_near(x.report.load_fraction, 1, 0);
    assert_true(x.report.estimate_l2 <= tolerance);
    return x;
}

static solved solve(const char *text, double tolerance, size_t count, const double *times)
{
    return solve_with("scene.yaml", text, 0, NULL, tolerance, count, times);
}

static void release(solved *x)
{
    solution_free(x->solution);
    config_free(x->settings);
}

/* values [COLUMNS]; those of motion are 0 at rest. */
static void evaluate(const solved *x, double s, double t, double *values)
{
    ad_error error = {.message = ""};
    memset(values, 0, COLUMNS * sizeof *values);
    if (solution_evaluate(x->solution, solution_columns(&x->settings->scene), 1, &s, &t, values,
                          &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

/* ---- at rest --------------------------------------------------------------------------------- */

/* EI = 2 (1 - s/5)^4 under a tip moment of 1: the tangent turns by the integral of 1/EI. */
static double turned(double s)
{
    return (pow(1 - 0.2 * s, -3) - 1) / 1.2;
}

static double sine(double s)
{
    return sin(turned(s));
}

static double cosine(double s)
{
    return cos(turned(s));
}

/* Adaptive quadrature by Simpson's rule, to an error of `off`. */
static double integral(double (*f)(double), double a, double b, double off)
{
    double half = (b - a) / 2, middle = a + half, fa = f(a), fm = f(middle), fb = f(b);
    double whole = (fa + 4 * fm + fb) * half / 3;
    double left = (fa + 4 * f(a + half / 2) + fm) * half / 6;
    double right = (fm + 4 * f(b - half / 2) + fb) * half / 6;
    double change = left + right - whole;
    return fabs(change) < 15 * off || half < 1e-6
               ? left + right + change / 15
               : integral(f, a, middle, off / 2) + integral(f, middle, b, off / 2);
}

static void test_tip_moment(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  model: kirchhoff\n"
        "  length: 1.5\n"
        "  stiffness: {bending: [2*(1 - s/5)^4, 3*(1 - s/5)^4], torsion: 2*(1 - s/5)^2}\n"
        "loads: {tip: {moment: [1, 0, 0]}}\n";
    solved x = solve(text, 1e-10, 0, NULL);
    for (int i = 0; i <= 6; i++) {
        double s = 1.5 * i / 6, values[COLUMNS];
        evaluate(&x, s, 0, values);
        assert_near(values[M1], 1, 1e-12);
        assert_near(values[U1], 1 / (2 * pow(1 - 0.2 * s, 4)), 1e-12); /* M/EI */
        assert_near(values[Y], -integral(sine, 0, s, 1e-15), 1e-12);
        assert_near(values[Z], integral(cosine, 0, s, 1e-15), 1e-12);
    }
    ad_error error;
    solve_energy energy;
    assert_int_equal(solution_energy(x.solution, 0, &energy, &error), AD_OK);
    assert_near(energy.strain, turned(1.5) / 2, 1e-12); /* the integral of M^2/(2 EI) */
    release(&x);
}

/* A cone of rubber held level, under its own weight: it bends, shears and stretches. In the plane
 * of x and z the internal force is the weight beyond, so that with the tangent at an angle phi
 *
 *   phi_s = m/EI,  m_s = W x_s,  r_s = (1 - W sin(phi)/EA) d3 - W cos(phi)/kGA d1
 *
 * and m(0) is that with which m(L) vanishes. */
typedef struct slope {
    double x, z, phi, m;
} slope;

static const double radius = 0.02, youngs = 4e6, nu = 0.45, density = 1100, gravity = 9.81;

static slope hang(double narrows, double s, const slope *at)
{
    const double narrow = 1 - narrows * s, tip = 1 - narrows * 0.8, r = radius * narrow;
    const double area = pi * r * r, inertia = pi * r * r * r * r / 4;
    const double shear = 6 * (1 + nu) / (7 + 6 * nu) * youngs / (2 * (1 + nu)) * area;
    const double weight =
        density * gravity * pi * radius * radius * (pow(narrow, 3) - pow(tip, 3)) / (3 * narrows);
    const double along = 1 - weight * sin(at->phi) / (youngs * area);
    const double across = -weight * cos(at->phi) / shear;
    slope rate;
    rate.x = along * cos(at->phi) - across * sin(at->phi);
    rate.z = along * sin(at->phi) + across * cos(at->phi);
    rate.phi = at->m / (youngs * inertia);
    rate.m = weight * rate.x;
    return rate;
}

static slope ahead(const slope *y, const slope *rate, double h)
{
    return (slope){y->x + h * rate->x, y->z + h * rate->z, y->phi + h * rate->phi,
                   y->m + h * rate->m};
}

enum { STEPS = 4000 };

/* By Runge and Kutta's method of order 4: the state at the tip for a moment at the clamp. */
static slope shoot(double narrows, double moment, int steps)
{
    slope y = {.m = moment};
    double h = 0.8 / steps;
    for (int i = 0; i < steps; i++) {
        double s = i * h;
        slope a = hang(narrows, s, &y), to_b = ahead(&y, &a, h / 2),
              b = hang(narrows, s + h / 2, &to_b);
        slope to_c = ahead(&y, &b, h / 2), c = hang(narrows, s + h / 2, &to_c);
        slope to_d = ahead(&y, &c, h), d = hang(narrows, s + h, &to_d);
        slope sum = ahead(&a, &b, 2);
        sum = ahead(&sum, &c, 2);
        sum = ahead(&sum, &d, 1);
        y = ahead(&y, &sum, h / 6);
    }
    return y;
}

static void check_cone(double narrows, double off)
{
    char text[512];
    snprintf(text, sizeof text,
             "rod:\n"
             "  length: 0.8\n"
             "  section: {shape: circle, radius: 0.02*(1 - %g*s)}\n"
             "  material: {youngs_modulus: 4.0e6, poissons_ratio: 0.45, density: 1100}\n"
             "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}\n" /* d3 = x, d1 = z */
             "loads: {gravity: [0, 0, -9.81]}\n",
             narrows);
    double moments[2] = {-1, -0.9}, left[2], values[COLUMNS];
    left[0] = shoot(narrows, moments[0], STEPS).m;
    for (int i = 0; i < 40 && moments[0] != moments[1]; i++) { /* secants */
        left[1] = shoot(narrows, moments[1], STEPS).m;
        double next = moments[1] - left[1] * (moments[1] - moments[0]) / (left[1] - left[0]);
        bool done = left[1] == left[0] || fabs(next - moments[1]) < 1e-15;
        moments[0] = moments[1];
        left[0] = left[1];
        moments[1] = done ? moments[0] : next;
    }
    slope tip = shoot(narrows, moments[0], STEPS), coarse = shoot(narrows, moments[0], STEPS / 2);
    assert_near(coarse.x, tip.x, off); /* of order 4: sixteen times the error of the finer */
    assert_near(coarse.z, tip.z, off);
    assert_true(tip.z < -0.1); /* it hangs */
    solved x = solve(text, 1e-11, 0, NULL);
    evaluate(&x, 0.8, 0, values);
    assert_near(values[X], tip.x, off);
    assert_near(values[Y], 0, 1e-13);
    assert_near(values[Z], tip.z, off);
    evaluate(&x, 0, 0, values);
    assert_near(fabs(values[M1 + 1]), fabs(moments[0]), 1e-10 * fabs(moments[0]));
    release(&x);
}

/* Also nearly to a point, where EI is a 400,000th. */
static void test_heavy_cone(void **state)
{
    (void)state;
    check_cone(0.6, 1e-11);
    check_cone(1.2, 1e-9);
}

/* A column whose EI grows as the square of the distance from a point beyond its tip gives way at
 * EI(L) (1/4 + b^2)/a^2 with tan(b log(1 + L/a)) = -2 b (Timoshenko and Gere 1961, Theory of
 * Elastic Stability, 2nd ed., section 2.14); here a = L = 2. */
static void test_tapered_column(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 2\n"
        "  model: kirchhoff\n"
        "  stiffness: {bending: [3*(2 - s/2)^2, 3*(2 - s/2)^2], torsion: 2}\n"
        "loads: {tip: {force: [0, 0, -1]}}\n";
    double low = pi / 2 / log(2) + 1e-9, high = pi / log(2);
    for (int i = 0; i < 60; i++) {
        double middle = (low + high) / 2;
        *(tan(middle * log(2)) + 2 * middle < 0 ? &low : &high) = middle;
    }
    double critical = 3 * (0.25 + low * low) / 4;
    ad_error error = {.message = ""};
    config *settings;
    assert_int_equal(prepare_read("column.yaml", text, 0, NULL, &settings, &error), AD_OK);
    for (int i = 0; i < 2; i++) {
        double values[COLUMNS][STABILITY_POINTS] = {{0}};
        int count;
        for (int k = 0; k < STABILITY_POINTS; k++) {
            values[3][k] = values[9][k] = 1; /* upright and not stretched */
            values[15][k] = -critical * (i ? 1.003 : 0.997);
        }
        assert_int_equal(stability_count(&settings->scene, values[0], &count, &error), AD_OK);
        assert_int_equal(count, i);
    }
    config_free(settings);
}

/* ---- in motion ------------------------------------------------------------------------------- */

/* Where stiffness and inertia are as (1 + s)^2, waves are those of a uniform rod over 1 + s: along
 * the rod u = A sin(k s)/(1 + s) cos(w t), and the same for its twist, with tan(k) = 2 k at the
 * free end. */
static void test_waves(void **state)
{
    (void)state;
    static const double k = 1.1655611852072114, u = 0.05, alpha = 0.4;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [40 + s, 50], axial: 90*(1 + s)^2, bending: [1 + s, 2], torsion: "
        "0.6*(1 + s)^2}\n"
        "  inertia: {mass_per_length: 1.5*(1 + s)^2, rotary: [0.03, 0.02, 0.05*(1 + s)^2]}\n"
        "initial:\n"
        "  position: [0, 0, s + 0.05*sin(1.1655611852072114*s)/(1 + s)]\n"
        "  rotation: [cos(0.2*sin(1.1655611852072114*s)/(1 + s)), 0, 0, "
        "sin(0.2*sin(1.1655611852072114*s)/(1 + s))]\n"
        "time: {duration: 0.8}\n";
    const double times[2] = {0.3, 0.8};
    solved x = solve(text, 1e-6, 2, times);
    for (int i = 0; i < 2; i++) {
        for (int j = 0; j <= 4; j++) {
            double s = j / 4.0, shape = sin(k * s) / (1 + s), values[COLUMNS];
            double angle = alpha * shape * cos(k * sqrt(12) * times[i]);
            evaluate(&x, s, times[i], values);
            assert_near(values[Z], s + u * shape * cos(k * sqrt(60) * times[i]), 1e-6);
            assert_near(values[6], sin(angle / 2), 5e-6); /* a tenth of the angle is asked for */
        }
    }
    assert_true(x.report.energy_mismatch < 1e-4); /* some hundred steps */
    release(&x);
}

/* Between two clamps the rod that should shrink cannot: its strains stay, its tension 9 t is the
 * same everywhere. What makes it shrink does the work that is then in the rod. */
static void test_shrinking(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [40, 50], axial: 90*(1 + s), bending: [1, 2], torsion: 0.6}\n"
        "  inertia: {mass_per_length: 1 + s, rotary: [0.03, 0.02, 0.05]}\n"
        "  rest: {strain: [0, 0, 1 - 0.1*t/(1 + s)]}\n"
        "boundary: {end: {type: clamped, position: [0, 0, 1], rotation: [1, 0, 0, 0]}}\n"
        "time: {duration: 2}\n";
    const double t = 2, stored = 0.45 * log(2) * t * t;
    solved x = solve(text, 1e-6, 1, &t);
    ad_error error;
    solve_energy energy;
    double values[COLUMNS];
    evaluate(&x, 0.4, t, values);
    assert_near(values[Z], 0.4, 1e-9);
    assert_near(values[15], 9 * t, 1e-6);
    assert_int_equal(solution_energy(x.solution, t, &energy, &error), AD_OK);
    assert_near(energy.strain, stored, 1e-8);
    assert_near(energy.work, stored, 1e-8);
    assert_near(energy.mismatch, 0, 1e-8);
    release(&x);
}

/* A rod that curls up slowly and is damped follows its rest shape: acceleration, of some 5.8
 * L k/T^2 at most, bends it by a quarter of that times L^4 rhoA/EI, and less at the end. */
static void test_curling(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [400, 400], axial: 900, bending: [1 + s, 1 + s], torsion: 1}\n"
        "  inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.02]}\n"
        "  damping: {curvature: [0.3, 0.3, 0.3]}\n"
        "  rest: {curvature: [1.5*(t/20)^3*(10 - 15*t/20 + 6*(t/20)^2), 0, 0]}\n"
        "time: {duration: 20}\n";
    const double t = 20, off = 5.8 * 1.5 / (20 * 20) / 4;
    solved x = solve(text, 3e-6, 1, &t);
    ad_error error;
    solve_energy energy;
    double values[COLUMNS];
    for (int i = 1; i <= 4; i++) {
        double s = i / 4.0;
        evaluate(&x, s, t, values);
        assert_near(values[Y], -(1 - cos(1.5 * s)) / 1.5, off);
        assert_near(values[Z], sin(1.5 * s) / 1.5, off);
    }
    assert_int_equal(solution_energy(x.solution, t, &energy, &error), AD_OK);
    assert_true(energy.work > 0 && energy.dissipated > 0);
    assert_near(energy.strain + energy.kinetic, 0, 1e-3 * energy.work);
    assert_near(energy.mismatch, 0, 1e-3 * energy.work);
    release(&x);
}

#define JUMPING                                                                                    \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [40, 50], axial: 90, bending: [2 - s, 3], torsion: 1}\n"                 \
    "  inertia: {mass_per_length: 2 - s, rotary: [0.03, 0.02, 0.05]}\n"

/* A rest shape that jumps sets off the motion of a rod that begins straight, and puts in the energy
 * of the straight rod: that of the curvature 4 (1 - s)^2 in EI = 2 - s. */
static void test_jump(void **state)
{
    (void)state;
    static const char jumping[] = JUMPING "  rest: {curvature: [4*(1 - s)^2*step(t - 0.3), 0, 0]}\n"
                                          "time: {duration: 0.8}\n",
                      straight[] =
                          JUMPING "  rest: {curvature: [4*(1 - s)^2, 0, 0]}\n"
                                  "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0]}\n"
                                  "time: {duration: 0.5}\n";
    const double late = 0.8, early = 0.5, strain = 0.5 * 16 * 11 / 30;
    double after[COLUMNS], from_straight[COLUMNS];
    solved x = solve(jumping, 1e-5, 1, &late), y = solve(straight, 1e-5, 1, &early);
    evaluate(&x, 1, late, after);
    evaluate(&y, 1, early, from_straight);
    assert_true(after[Y] < -0.1);
    for (int i = X; i <= Z; i++) {
        assert_near(after[i], from_straight[i], 2e-5); /* of each its tolerance */
    }
    ad_error error;
    solve_energy energy;
    assert_int_equal(solution_energy(x.solution, late, &energy, &error), AD_OK);
    assert_near(energy.work, strain, 1e-6 * strain);
    assert_near(energy.mismatch, 0, 1e-4 * strain); /* some hundred steps */
    release(&x);
    release(&y);
}

#define SOFT_CONE                                                                                  \
    "rod:\n"                                                                                       \
    "  length: 1\n"                                                                                \
    "  stiffness: {shear: [40, 50], axial: 90, bending: [2 - s, 3 - s], torsion: 1 + s}\n"         \
    "  inertia: {mass_per_length: 2 - s, rotary: [0.03, 0.02, 0.05*(2 - s)]}\n"                    \
    "time: {duration: 1}\n"

/* What displaces as much fluid as it weighs is not bent, nor does it fall; half as much is half the
 * weight, and the whole inertia. */
static void test_buoyancy(void **state)
{
    (void)state;
    static const char half[] = SOFT_CONE "loads: {gravity: [3, 0, -9], buoyancy: 1 - s/2}\n",
                      light[] = SOFT_CONE "loads: {gravity: [1.5, 0, -4.5]}\n",
                      floating[] = SOFT_CONE "loads: {gravity: [3, 0, -9], buoyancy: 2 - s}\n";
    const double t = 1;
    double by_half[COLUMNS], by_light[COLUMNS];
    solved x = solve(half, 1e-6, 1, &t), y = solve(light, 1e-6, 1, &t),
           z = solve(floating, 1e-6, 1, &t);
    evaluate(&x, 1, t, by_half);
    evaluate(&y, 1, t, by_light);
    assert_true(by_half[X] > 0.1);
    for (int i = 0; i < COLUMNS; i++) {
        assert_near(by_half[i], by_light[i], 1e-9); /* the same but for rounding */
    }
    evaluate(&z, 1, t, by_half);
    assert_near(by_half[X], 0, 1e-12);
    assert_near(by_half[Z], 1, 1e-12);
    release(&x);
    release(&y);
    release(&z);
}

/* Gravity that turns is a distributed force of rhoA g(t); free of any hold all of the rod falls
 * alike. */
static void test_turning_gravity(void **state)
{
    (void)state;
    static const char held[] = SOFT_CONE "loads: {gravity: [3*sin(2*t), 0, -3*cos(2*t)]}\n",
                      forced[] = SOFT_CONE
                      "loads: {force: [3*(2 - s)*sin(2*t), 0, -3*(2 - s)*cos(2*t)]}\n",
                      falling[] =
                          SOFT_CONE "loads: {gravity: [0, 5*cos(3*t), -9]}\n"
                                    "boundary: {start: {type: free}}\n"
                                    "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0]}\n";
    const double t = 1;
    double by_gravity[COLUMNS], by_force[COLUMNS];
    solved x = solve(held, 1e-6, 1, &t), y = solve(forced, 1e-6, 1, &t);
    evaluate(&x, 1, t, by_gravity);
    evaluate(&y, 1, t, by_force);
    assert_true(by_gravity[X] > 0.1);
    for (int i = 0; i < COLUMNS; i++) {
        assert_near(by_gravity[i], by_force[i], 1e-9); /* the same but for rounding */
    }
    release(&x);
    release(&y);
    x = solve(falling, 1e-6, 1, &t);
    for (int i = 0; i <= 2; i++) {
        evaluate(&x, i / 2.0, t, by_gravity);
        assert_near(by_gravity[X], 0, 1e-9);
        assert_near(by_gravity[Y], 5.0 / 9 * (1 - cos(3)), 1e-6);
        assert_near(by_gravity[Z], i / 2.0 - 4.5, 1e-6);
    }
    ad_error error;
    solve_energy energy;
    assert_int_equal(solution_energy(x.solution, t, &energy, &error), AD_OK);
    double square = pow(5.0 / 3 * sin(3), 2) + 81;
    double kinetic = 0.5 * 1.5 * square;                  /* a mass of 1.5 */
    assert_near(energy.kinetic, kinetic, 1e-4 * kinetic); /* steps to 1e-6, in velocity too */
    assert_near(energy.work, kinetic, 1e-4 * kinetic);
    release(&x);
}

/* A free rod, thrown through what resists it as the square of its velocity, and in proportion to
 * its mass, stays straight: v_t = -0.8 v^2. */
static void test_thrown(void **state)
{
    (void)state;
    static const char text[] = SOFT_CONE "loads: {quadratic_drag: 0.8*(2 - s)}\n"
                                         "boundary: {start: {type: free}}\n"
                                         "initial: {position: [0, 0, s], rotation: [1, 0, 0, 0],\n"
                                         "  velocity: [0, 3, 4]}\n";
    const double t = WATCHED ? 0.25 : 1, slowed = 1 + 0.8 * 5 * t, way = log(slowed) / 0.8;
    ad_error error;
    solve_energy energy;
    double values[COLUMNS];
    solved x = solve(text, 1e-7, 1, &t);
    for (int i = 0; i <= 2; i++) {
        evaluate(&x, i / 2.0, t, values);
        assert_near(values[X], 0, 1e-9);
        assert_near(values[Y], 0.6 * way, 1e-6);
        assert_near(values[Z], i / 2.0 + 0.8 * way, 1e-6);
    }
    double before = 0.5 * 1.5 * 25, after = before / (slowed * slowed); /* a mass of 1.5 */
    assert_int_equal(solution_energy(x.solution, t, &energy, &error), AD_OK);
    assert_near(energy.kinetic, after, 1e-4 * before); /* some hundred steps to 1e-7 */
    assert_near(energy.dissipated, before - after, 1e-4 * before);
    assert_near(energy.work, 0, 1e-9);
    release(&x);
}

/* The same through a fluid that resists it along and across by laws of their own, thrown askew:
 * along v_t = -0.4 v^(3/2) from 4, across v_t = -0.8 v^2 from 3. */
static void test_slipping(void **state)
{
    (void)state;
    static const char text[] =
        SOFT_CONE "loads: {fluid: {along: [0, 0.4*(2 - s), 0], across: [0, 0, 0.8*(2 - s)]}}\n"
                  "boundary: {start: {type: free}}\n"
                  "initial: {position: [0, 0.6*s, 0.8*s], rotation: [3, -1, 0, 0],\n"
                  "  velocity: [0, 4.8, 1.4]}\n";
    const double t = WATCHED ? 0.25 : 1, along = 4 * t / (1 + 0.4 * t),
                 across = log(1 + 2.4 * t) / 0.8;
    double values[COLUMNS];
    solved x = solve(text, 1e-7, 1, &t);
    for (int i = 0; i <= 2; i++) {
        evaluate(&x, i / 2.0, t, values);
        assert_near(values[X], 0, 1e-9);
        assert_near(values[Y], 0.6 * (i / 2.0 + along) + 0.8 * across, 1e-6);
        assert_near(values[Z], 0.8 * (i / 2.0 + along) - 0.6 * across, 1e-6);
    }
    release(&x);
}

/* Every term of the equations with coefficients that vary, and a rest shape and gravity that
 * change, under the loads that make a chosen motion the solution. */
static void test_everything(void **state)
{
    (void)state;
    static const char *const overrides[] = {
        "rod.stiffness={shear: [40*(1 + s/3), 50 - 9*s], axial: 90*exp(-s/2), bending: [1.2 + "
        "0.4*s, 0.8*(1 + s)^2], torsion: 0.5 + 0.2*sin(3*s)}",
        "rod.inertia={mass_per_length: 1.3*(1.2 - s/2), rotary: [0.03*(1 + s), 0.02 + 0.01*s^2, "
        "0.05*exp(-s)]}",
        "rod.rest={strain: [0.1*s*t, 0.1, 1 + 0.05*sin(t + s)], curvature: [0.3*cos(s + t), -0.2, "
        "0.4*s*t^2]}",
        "rod.damping={strain: [0.6*(1 + s), 0.5, 0.8 - 0.3*s], curvature: [0.03*(1 + s), 0.02, "
        "0.01*exp(s)]}",
        "loads.gravity=[0.5*t, -1 + t^2, -2*cos(t)]",
        "loads.quadratic_drag=0.3 + 0.2*s",
        "loads.fluid.added_mass=0.5*(1 + s)"};
    const double t = 1;
    solved x = solve_with("configs/manufactured_dynamic.yaml", NULL, 7, overrides, 1e-6, 1, &t);
    for (int i = 0; i <= 8; i++) {
        double s = i / 8.0, values[COLUMNS];
        evaluate(&x, s, t, values);
        assert_near(values[X], 0.3 * s * s * cos(2) + 0.1 * s * s * s, 1e-6);
        assert_near(values[Y], 0.2 * s * s * sin(3), 1e-6);
        assert_near(values[Z], s + 0.05 * s * s * sin(1), 1e-6);
    }
    assert_true(x.report.energy_mismatch < 1e-4); /* some hundred steps */
    release(&x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tip_moment),     cmocka_unit_test(test_heavy_cone),
        cmocka_unit_test(test_tapered_column), cmocka_unit_test(test_waves),
        cmocka_unit_test(test_shrinking),      cmocka_unit_test(test_curling),
        cmocka_unit_test(test_jump),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_everything),      cmocka_unit_test(test_slipping),
        cmocka_unit_test(test_turning_gravity), cmocka_unit_test(test_buoyancy),
        cmocka_unit_test(test_thrown),
    };
    return run_with_alike(tests, alike, NULL, NULL);
}
