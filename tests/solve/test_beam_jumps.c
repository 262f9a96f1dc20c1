/* Beams of small deflection with what acts at single places: loads, springs, rigid bodies. By the
 * classical solver, against textbook deflections and exact modes. */
#include "near.h"

#include "physics/beam/beam.h"
#include "physics/solve/solve.h"
#include "quantity_testing.h"

#include <stdio.h>

static const double L = 2, EI = 3;

static scene beam_of(scene_model model, scene_end_type start, scene_end_type end)
{
    scene made;
    scene_defaults(&made);
    made.rod.model = model;
    made.rod.length = Q(L);
    made.rod.bending_stiffness[0] = Q(EI);
    made.rod.mass_per_length = Q(0.7);
    made.start.type = start;
    made.end.type = end;
    return made;
}

static void add_point(scene *to, double at, double force, double moment)
{
    scene_beam_point *point = &to->beam.points[to->beam.point_count++];
    *point = (scene_beam_point){.at = Q(at)};
    point->load = (scene_beam_load){.force = Q(force), .moment = Q(moment)};
}

static void add_spring(scene *to, double at, double stiffness, double turning)
{
    scene_spring *spring = &to->springs[to->spring_count++];
    *spring = (scene_spring){.at = Q(at)};
    spring->stiffness[1] = Q(stiffness);
    spring->turning[0] = Q(turning);
}

static void add_body(scene *to, double at, double mass, double inertia)
{
    scene_body *body = &to->bodies[to->body_count++];
    *body = (scene_body){.at = Q(at), .mass = Q(mass)};
    body->inertia[0] = Q(inertia);
}

typedef struct beam_values {
    double w, psi, V, M, w_t, psi_t;
} beam_values;

static solution *solve(const scene *given, size_t count, const double *times)
{
    ad_error error = {.message = ""};
    const solve_settings settings = solve_settings_default(given);
    solution *x;
    solve_report report;
    if (solution_create(given, &settings, count, times, &x, &report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_true(report.estimate <= settings.tolerance);
    return x;
}

static beam_values values_at(const solution *x, double s, double t)
{
    beam_values values;
    assert_int_equal(solution_evaluate(x, BEAM_COLUMNS, 1, &s, &t, (double *)&values, NULL), AD_OK);
    return values;
}

/* ---- at rest ------------------------------------------------------------------------------- */

/* Polynomials of degree 3 between the places: rounding only. */
static const double rounding = 1e-12;

/* Force and moment at a: F s^2 (3a - s)/6EI + T s^2/2EI, and on along the tangent at a. */
static void test_cantilever(void **state)
{
    (void)state;
    const double a = 0.7, F = 4, T = -1.5;
    scene given = beam_of(SCENE_EULER_BERNOULLI, SCENE_CLAMPED, SCENE_FREE);
    add_point(&given, a, F, T);
    solution *x = solve(&given, 0, NULL);
    for (double s = 0.15; s <= L; s += 0.3) {
        double z = fmin(s, a), slope = F * z * (2 * a - z) / (2 * EI) + T * z / EI;
        double w = F * z * z * (3 * a - z) / (6 * EI) + T * z * z / (2 * EI) + (s - z) * slope;
        beam_values at = values_at(x, s, 0);
        assert_near(at.w, w, rounding);
        assert_near(at.psi, slope, rounding);
        assert_near(at.V, s < a ? F : 0, 10 * rounding);
        assert_near(at.M, s < a ? F * (a - s) + T : 0, 10 * rounding);
    }
    assert_near(values_at(x, a, 0).V, F, 10 * rounding); /* before it */
    solution_free(x);
}

/* Simply supported, off centre: F b s (L^2 - b^2 - s^2)/6 L EI up to the load, b = L - a. */
static void test_supported(void **state)
{
    (void)state;
    const double a = 0.6, b = L - a, F = -2.5;
    scene given = beam_of(SCENE_EULER_BERNOULLI, SCENE_PINNED, SCENE_PINNED);
    add_point(&given, a, F, 0);
    solution *x = solve(&given, 0, NULL);
    for (double s = 0; s <= a; s += 0.15) {
        assert_near(values_at(x, s, 0).w, F * b * s * (L * L - b * b - s * s) / (6 * L * EI),
                    rounding);
    }
    for (double s = L; s > a; s -= 0.2) {
        double r = L - s;
        assert_near(values_at(x, s, 0).w, F * a * r * (L * L - a * a - r * r) / (6 * L * EI),
                    rounding);
    }
    solution_free(x);
}

/* Shear adds F s/kGA up to the load. */
static void test_timoshenko(void **state)
{
    (void)state;
    const double a = 1.1, F = 4, kGA = 20;
    scene given = beam_of(SCENE_TIMOSHENKO, SCENE_CLAMPED, SCENE_FREE);
    given.rod.shear_stiffness[1] = Q(kGA);
    add_point(&given, a, F, 0);
    solution *x = solve(&given, 0, NULL);
    assert_near(values_at(x, L, 0).w, F * a * a * (3 * L - a) / (6 * EI) + F * a / kGA, rounding);
    solution_free(x);
}

/* On springs alone, a load off the middle: rigid supports' deflection and that of the springs; and
 * one that is also held by a spring that turns. */
static void test_springs(void **state)
{
    (void)state;
    const double a = 0.6, b = L - a, F = 3, k0 = 5, k1 = 9, k = 11;
    scene given = beam_of(SCENE_EULER_BERNOULLI, SCENE_FREE, SCENE_FREE);
    add_point(&given, a, F, 0);
    add_spring(&given, 0, k0, 0);
    add_spring(&given, L, k1, 0);
    solution *x = solve(&given, 0, NULL);
    double w0 = F * b / L / k0, w1 = F * a / L / k1;
    double bent = F * b * a * (L * L - b * b - a * a) / (6 * L * EI);
    assert_near(values_at(x, 0, 0).w, w0, rounding);
    assert_near(values_at(x, L, 0).w, w1, rounding);
    assert_near(values_at(x, a, 0).w, w0 + (w1 - w0) * a / L + bent, rounding);
    assert_near(values_at(x, 0, 0).V, w0 * k0, 10 * rounding); /* beyond the spring */
    solution_free(x);

    given = beam_of(SCENE_EULER_BERNOULLI, SCENE_PINNED, SCENE_LOADED);
    given.beam.tip.force = Q(F);
    add_spring(&given, 0, 0, k);
    add_spring(&given, L, k1, 0);
    given.springs[1].anchor[1] = Q(0.4);
    x = solve(&given, 0, NULL);
    double soft = L * L / k + L * L * L / (3 * EI); /* of the tip */
    assert_near(values_at(x, L, 0).w, (F + k1 * 0.4) / (1 / soft + k1), rounding);
    solution_free(x);
}

/* ---- in motion ----------------------------------------------------------------------------- */

/* A cantilever with mass m, inertia J and a spring k at its tip, by its exact mode
 *   phi = cosh b s - cos b s - c (sinh b s - sin b s),   w^2 = EI b^4/rhoA:
 *   EI phi'' = w^2 J phi',   EI phi''' = (k - w^2 m) phi at s = L
 * (Blevins 1979, Formulas for Natural Frequency and Mode Shape, ch. 8). */
typedef struct tip {
    double m, J, k;
} tip;

static double mode(double b, const tip *at, double rhoA, double *c)
{
    double x = b * L, square = EI * b * b * b * b / rhoA;
    double phi[4][2] = {{cosh(x) - cos(x), sinh(x) - sin(x)},
                        {b * (sinh(x) + sin(x)), b * (cosh(x) - cos(x))},
                        {b * b * (cosh(x) + cos(x)), b * b * (sinh(x) + sin(x))},
                        {b * b * b * (sinh(x) - sin(x)), b * b * b * (cosh(x) + cos(x))}};
    double bend[2], shear[2];
    for (int i = 0; i < 2; i++) {
        bend[i] = EI * phi[2][i] - square * at->J * phi[1][i];
        shear[i] = EI * phi[3][i] - (at->k - square * at->m) * phi[0][i];
    }
    *c = bend[0] / bend[1];
    return shear[0] * bend[1] - shear[1] * bend[0];
}

static void check_mode(const tip *at, double low, double high)
{
    const double rhoA = 0.7;
    double c, sign = mode(low, at, rhoA, &c);
    for (int i = 0; i < 80; i++) {
        double middle = (low + high) / 2;
        bool same = mode(middle, at, rhoA, &c) * sign > 0;
        low = same ? middle : low;
        high = same ? high : middle;
    }
    double w = low * low * sqrt(EI / rhoA), times[3];
    char text[256];
    snprintf(text, sizeof text,
             "0.01*(cosh(%.17g*s)-cos(%.17g*s)-%.17g*(sinh(%.17g*s)-sin(%.17g*s)))", low, low, c,
             low, low);
    scene given = beam_of(SCENE_EULER_BERNOULLI, SCENE_CLAMPED, SCENE_FREE);
    given.duration = Q(9 / w);
    given.beam.deflection = Q((const char *)text);
    add_body(&given, L, at->m, at->J);
    add_spring(&given, L, at->k, 0);
    for (int i = 0; i < 3; i++) {
        times[i] = (2.5 + 3 * i) / w;
    }
    solution *x = solve(&given, 3, times);
    double size = fabs(quantity_value(given.beam.deflection, L, 0));
    for (int i = 0; i < 3; i++) {
        for (double s = 0.5; s <= L; s += 0.5) {
            double now = quantity_value(given.beam.deflection, s, 0) * cos(w * times[i]);
            assert_near(values_at(x, s, times[i]).w, now, 1e-11 * size); /* 1e-13 here */
        }
    }
    solution_free(x);
}

static void test_tip_mass(void **state)
{
    (void)state;
    /* mass of the beam: 1 + cos x cosh x = x (sin x cosh x - cos x sinh x), x = 1.2479174 */
    double c, x = 1.247917407, rhoA = 0.7;
    tip equal = {.m = rhoA * L};
    double near = mode((x - 1e-6) / L, &equal, rhoA, &c),
           far = mode((x + 1e-6) / L, &equal, rhoA, &c);
    assert_true(near * far < 0); /* as Blevins' table 8-8 has it */
    check_mode(&equal, 1 / L, 1.5 / L);
    check_mode(&(tip){.m = 0.5, .J = 0.3}, 0.7 / L, 1.5 / L);
    check_mode(&(tip){.m = 0.5, .k = 6}, 2 / L, 2.8 / L);
    check_mode(&(tip){.m = 3, .J = 0.02, .k = 2}, 3 / L, 4.5 / L); /* second mode */
}

/* A force that grows slowly carries a mass within the beam as at rest; what is left is the
 * acceleration, w_tt = d^2/dt^2 of that: of a heavy body and next to no beam, m w_tt + k w = F. */
static void test_body_within(void **state)
{
    (void)state;
    const double a = 1.2, m = 2, F = 0.3, k = 3 * EI / (a * a * a);
    scene given = beam_of(SCENE_EULER_BERNOULLI, SCENE_CLAMPED, SCENE_FREE);
    given.rod.mass_per_length = Q(1e-6); /* of the answer some 1e-6, too */
    given.duration = Q(2.0);
    add_body(&given, a, m, 0);
    scene_beam_point *point = &given.beam.points[given.beam.point_count++];
    *point = (scene_beam_point){.at = Q(a)};
    point->load.force = Q("0.3*t^2");
    const double t = 2;
    solve_settings settings = {.tolerance = 1, .nodes = 8};
    solution *x;
    solve_report report;
    ad_error error = {.message = ""};
    if (solution_create(&given, &settings, 1, &t, &x, &report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    /* w = F/k (t^2 - 2 (1 - cos wt)/w^2) */
    double w = sqrt(k / m), exact = F / k * (t * t - 2 * (1 - cos(w * t)) / (w * w));
    assert_near(values_at(x, a, t).w, exact, 3e-6 * exact);
    solution_free(x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cantilever), cmocka_unit_test(test_supported),
        cmocka_unit_test(test_timoshenko), cmocka_unit_test(test_springs),
        cmocka_unit_test(test_tip_mass),   cmocka_unit_test(test_body_within),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
