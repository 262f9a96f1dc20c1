/* Closed-form rods against tabulated values, against high-precision evaluations and against direct
 * Runge-Kutta integration of the equations they solve. */
#include "near.h"

#include "physics/learn/analytic.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const double pi = 3.14159265358979323846;
static const double root_half = 0.70710678118654752440;

/* Angle between two orientations; the same for q and -q. */
static double rotation_distance(const double p[4], const double q[4])
{
    const double scalar = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
    double squares = 0;
    const double vector[3] = {p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2],
                              p[0] * q[2] + p[1] * q[3] - p[2] * q[0] - p[3] * q[1],
                              p[0] * q[3] - p[1] * q[2] + p[2] * q[1] - p[3] * q[0]};
    for (int i = 0; i < 3; i++) {
        squares += vector[i] * vector[i];
    }
    return 2.0 * atan2(sqrt(squares), fabs(scalar));
}

/* ---- elastica ---- */

static const analytic_clamp along_x = {{0, 0, 0},
                                       {0, 0.70710678118654752440, 0, 0.70710678118654752440}};

/* Unit rod clamped along +x with tip load alpha along -z. */
static analytic_elastica unit_elastica(double alpha)
{
    analytic_elastica elastica;
    ad_error error;
    const double force[3] = {0, 0, -alpha};
    assert_int_equal(analytic_elastica_create(&along_x, 1.0, 1.0, force, &elastica, &error), AD_OK);
    return elastica;
}

/* Tip values from elliptic integrals (Bisshopp and Drucker 1945), accurate to 1e-14: reference
 * case S2. alpha, theta, x/L, y/L, curvature at the clamp times L. */
static const double tip_table[6][5] = {
    {0.5, 0.2445336471332183, 0.9840810375291625, 0.1621435756583696, 0.4920405187645813},
    {1, 0.461351949711879, 0.9435667637166231, 0.3017207737998135, 0.9435667637166231},
    {2, 0.781749831556543, 0.8393582791748329, 0.4934574803967118, 1.678716558349666},
    {5, 1.215368117611681, 0.6123716392755701, 0.7137915236119127, 3.061858196377851},
    {10, 1.430285538803858, 0.4450044022462487, 0.8106090248802965, 4.450044022462487},
    {50, 1.567981901571437, 0.1999996039504024, 0.9171554473035874, 9.999980197520118},
};

static void elastica_tip_meets_reference_table(void **unused)
{
    (void)unused;
    for (size_t row = 0; row < sizeof tip_table / sizeof tip_table[0]; row++) {
        const double *expected = tip_table[row];
        const analytic_elastica elastica = unit_elastica(expected[0]);
        const analytic_planar tip = analytic_elastica_shape(&elastica, 1.0);
        const analytic_planar clamp = analytic_elastica_shape(&elastica, 0.0);
        /* The table itself is good to about 1e-14. */
        assert_near(tip.angle, expected[1], 5e-14 * expected[1]);
        assert_near(tip.along, expected[2], 5e-14 * expected[2]);
        assert_near(tip.across, expected[3], 5e-14 * expected[3]);
        assert_near(clamp.curvature, expected[4], 5e-14 * expected[4]);
        assert_near(tip.curvature, 0.0, 0.0);
        assert_near(clamp.angle, 0.0, 0.0);
    }
}

/* alpha, s/L, theta, x/L, y/L, curvature L: the formulas of analytic.h evaluated with mpmath's
 * Jacobi functions and adaptive quadrature in 40 digits (220 for alpha = 1e4). */
static const double fine_table[][6] = {
    {1e-6, 0.01, 9.9499999999993333e-9, 0.0099999999999999998, 4.983333333333e-11,
     9.8999999999993333e-7},
    {1e-6, 0.3, 2.5499999999998028e-7, 0.29999999999999645, 4.0499999999996787e-8,
     6.9999999999993688e-7},
    {1e-6, 1, 4.9999999999995417e-7, 0.99999999999993333, 3.3333333333329524e-7, 0},
    {0.01, 0.01, 9.9499333346445597e-5, 0.0099999999834583047, 4.9832999965264045e-7,
     0.0098999333347685601},
    {0.01, 0.3, 0.0025499802801643002, 0.29999964518040637, 0.00040499678686820128,
     0.0069999368827990794},
    {0.01, 1, 0.0049999541675597495, 0.99999333346031431, 0.0033332952389090696, 0},
    {1, 0.01, 0.0093856680057763372, 0.0099998527912287128, 4.7011326659000507e-5,
     0.9335669109253944},
    {1, 0.3, 0.2383158675412189, 0.29689421828896106, 0.03778679394324475, 0.64667254542766206},
    {1, 1, 0.46135194971187896, 0.94356676371662312, 0.30172077379981353, 0},
    {5, 0.01, 0.030368601303543193, 0.0099984566484643207, 0.00015224788800791525,
     3.011865913135529},
    {5, 0.3, 0.70499567346154951, 0.27209702835977257, 0.1108902906955376, 1.7013730545789878},
    {5, 1, 1.2153681176116811, 0.61237163927557013, 0.71379152361191273, 0},
    {10, 0.01, 0.044000521623141746, 0.0099967552023112359, 0.00022079996249934422,
     4.3500764704393749},
    {10, 0.3, 0.92745795959083006, 0.25004442905506471, 0.14571010103438417, 1.9495997319118402},
    {10, 1, 1.4302855388038575, 0.44500440224624873, 0.81060902488029645, 0},
    {100, 0.01, 0.1364293346330195, 0.0099684371696478606, 0.00068937532517878549,
     13.145291826747005},
    {100, 0.3, 1.4883180332212313, 0.13317587740753096, 0.24159139716174163, 0.82454780295869573},
    {100, 1, 1.5706458846600332, 0.14142135543711792, 0.94142135086201098, 0},
    {1000, 0.01, 0.39793603254270843, 0.0097218302470826826, 0.002042778052630777,
     34.999529302913088},
    {1000, 0.3, 1.5706706644696303, 0.044717385758359241, 0.28147580647146717,
     0.0039737916365292708},
    {1000, 1, 1.5707963267948354, 0.04472135954999577, 0.9814758063466282, 0},
    {10000, 0.01, 0.96592673322906034, 0.0081852280513869499, 0.0050498530945373626,
     59.569075723440005},
    {10000, 0.3, 1.5707963267947416, 0.0141421356237294, 0.29414213562373095,
     1.5504217381070346e-11},
    {10000, 1, 1.5707963267948966, 0.01414213562373095, 0.99414213562373095, 0},
};

static void elastica_keeps_relative_accuracy(void **unused)
{
    (void)unused;
    double worst_small = 0, worst_large = 0;
    for (size_t row = 0; row < sizeof fine_table / sizeof fine_table[0]; row++) {
        const double *expected = fine_table[row];
        const analytic_elastica elastica = unit_elastica(expected[0]);
        const analytic_planar shape = analytic_elastica_shape(&elastica, expected[1]);
        const double actual[4] = {shape.angle, shape.along, shape.across, shape.curvature};
        for (int i = 0; i < 4; i++) {
            const double error = fabs(actual[i] - expected[2 + i]);
            const double relative = error > 0 ? error / fabs(expected[2 + i]) : 0;
            double *worst = expected[0] <= 10 ? &worst_small : &worst_large;
            *worst = fmax(*worst, relative);
        }
    }
    print_message("relative error: alpha <= 10 %.2g, above %.2g\n", worst_small, worst_large);
    /* What the header promises; sinh(sqrt(alpha)) alone costs sqrt(alpha) roundings of 1e-16. */
    assert_true(worst_small < 1e-14);
    assert_true(worst_large < 3e-14);
}

typedef struct planar_state {
    double angle, curvature, along, across;
} planar_state;

static planar_state planar_rate(planar_state y, double alpha)
{
    return (planar_state){y.curvature, -alpha * cos(y.angle), cos(y.angle), sin(y.angle)};
}

static planar_state planar_add(planar_state y, double h, planar_state rate)
{
    return (planar_state){y.angle + h * rate.angle, y.curvature + h * rate.curvature,
                          y.along + h * rate.along, y.across + h * rate.across};
}

/* Classical fourth-order Runge-Kutta step of the elastica's equation. */
static planar_state planar_step(planar_state y, double h, double alpha)
{
    const planar_state a = planar_rate(y, alpha);
    const planar_state b = planar_rate(planar_add(y, 0.5 * h, a), alpha);
    const planar_state c = planar_rate(planar_add(y, 0.5 * h, b), alpha);
    const planar_state d = planar_rate(planar_add(y, h, c), alpha);
    y = planar_add(y, h / 6.0, a);
    y = planar_add(y, h / 3.0, b);
    y = planar_add(y, h / 3.0, c);
    return planar_add(y, h / 6.0, d);
}

static void elastica_solves_its_equation(void **unused)
{
    (void)unused;
    const double alphas[] = {1e-3, 0.3, 1.0, 3.7, 10.0, 40.0};
    const int steps = 4000;
    for (size_t row = 0; row < sizeof alphas / sizeof alphas[0]; row++) {
        const analytic_elastica elastica = unit_elastica(alphas[row]);
        planar_state y = {.curvature = analytic_elastica_shape(&elastica, 0.0).curvature};
        /* The step error is about alpha^2.5 h^4/100; starting errors of 1e-15 and it grow by at
         * most exp(sqrt(alpha)) on the way to the tip. */
        const double tolerance =
            (2e-14 + pow(alphas[row], 2.5) * pow(steps, -4.0)) * exp(sqrt(alphas[row]));
        for (int step = 1; step <= steps; step++) {
            y = planar_step(y, 1.0 / steps, alphas[row]);
            if (step % 500 == 0) {
                const analytic_planar shape =
                    analytic_elastica_shape(&elastica, (double)step / steps);
                assert_near(y.angle, shape.angle, tolerance);
                assert_near(y.curvature, shape.curvature, tolerance * (1 + sqrt(alphas[row])));
                assert_near(y.along, shape.along, tolerance);
                assert_near(y.across, shape.across, tolerance);
            }
        }
    }
}

static void elastica_balances_moments_at_any_load(void **unused)
{
    (void)unused;
    for (double alpha = 1e-8; alpha <= 1e4; alpha *= 1.37) {
        const analytic_elastica elastica = unit_elastica(alpha);
        const analytic_planar tip = analytic_elastica_shape(&elastica, 1.0);
        for (int i = 0; i <= 20; i++) {
            const analytic_planar shape = analytic_elastica_shape(&elastica, i / 20.0);
            /* Moment about the section: kappa = alpha (x(L) - x(s)); rounding of the difference. */
            assert_near(shape.curvature, alpha * (tip.along - shape.along),
                        1e-14 * alpha * tip.along);
            /* First integral kappa^2/2 = alpha (sin theta(L) - sin theta), the same way. */
            assert_near(0.5 * shape.curvature * shape.curvature,
                        alpha * (sin(tip.angle) - sin(shape.angle)),
                        1e-14 * alpha * sin(tip.angle));
        }
    }
}

static void elastica_in_space(void **unused)
{
    (void)unused;
    /* The same rod in SI units, somewhere else, bent sideways: L = 0.4 m, EI = 0.02 N m^2. */
    const double length = 0.4, stiffness = 0.02, alpha = 5.0;
    const double size = alpha * stiffness / (length * length);
    const analytic_clamp clamp = {{1, 2, 3}, {root_half, 0, root_half, 0}}; /* d3 = +x, d2 = +y */
    const double force[3] = {0, size, 0};
    analytic_elastica elastica;
    analytic_state state;
    assert_int_equal(analytic_elastica_create(&clamp, length, stiffness, force, &elastica, NULL),
                     AD_OK);
    analytic_elastica_at(&elastica, length, &state);
    /* Reference case S2, alpha = 5; rounding of 0.4 x 0.6 beside 3. */
    assert_near(state.position[0], 1 + length * 0.6123716392755701, 1e-15);
    assert_near(state.position[1], 2 + length * 0.7137915236119127, 1e-15);
    assert_near(state.position[2], 3, 1e-15);
    /* Turn by theta about +z after the clamp's turn about +y. */
    const double half = 0.5 * 1.215368117611681;
    const double expected[4] = {root_half * cos(half), -root_half * sin(half),
                                root_half * cos(half), root_half * sin(half)};
    for (int i = 0; i < 4; i++) {
        assert_near(state.quaternion[i], expected[i], 1e-15);
    }
    /* At the clamp M = r(L) x F = F x(L) about world +z, which is -d1. */
    analytic_elastica_at(&elastica, 0.0, &state);
    assert_near(state.moment[0], -size * length * 0.6123716392755701, 1e-15);
    assert_near(state.moment[1], 0, 1e-15);
    assert_near(state.moment[2], 0, 1e-15);
    assert_near(state.force[1], size, 0.0);
    for (int i = 0; i < 4; i++) {
        assert_near(state.quaternion[i], clamp.quaternion[i], 1e-15);
    }
}

static void elastica_without_load_is_straight(void **unused)
{
    (void)unused;
    const analytic_elastica elastica = unit_elastica(0.0);
    analytic_state state;
    analytic_elastica_at(&elastica, 0.25, &state);
    assert_near(state.position[0], 0.25, 1e-16);
    assert_near(state.position[2], 0.0, 1e-16);
    assert_near(rotation_distance(state.quaternion, along_x.quaternion), 0.0, 1e-15);
}

static void elastica_refuses_bad_arguments(void **unused)
{
    (void)unused;
    analytic_elastica elastica;
    ad_error error;
    const double force[3] = {0, 0, -1}, tilted[3] = {0.1, 0, -1}, bad[3] = {NAN, 0, 0};
    const double huge[3] = {0, 0, -1.1e4};
    const analytic_clamp skewed = {{0, 0, 0}, {1, 0, 0, 0.1}};
    assert_int_equal(analytic_elastica_create(&along_x, 1, 1, tilted, &elastica, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "tip force"));
    assert_int_equal(analytic_elastica_create(&along_x, 1, 1, bad, &elastica, &error),
                     AD_BAD_ARGUMENT);
    assert_int_equal(analytic_elastica_create(&along_x, 1, 1, huge, &elastica, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "10000"));
    assert_int_equal(analytic_elastica_create(&along_x, 0, 1, force, &elastica, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "length"));
    assert_int_equal(analytic_elastica_create(&along_x, 1, -1, force, &elastica, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "bending stiffness"));
    assert_int_equal(analytic_elastica_create(&skewed, 1, 1, force, &elastica, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "quaternion"));
}

/* ---- helix and circle ---- */

static const analytic_clamp along_z = {{0, 0, 0}, {1, 0, 0, 0}};

/* Reference case S5a: L = B = 1, clamped at the origin with the identity; the closed form agrees
 * with integration to 1e-13. Couple, C, tip, quaternion at the tip. */
static const struct {
    double couple[3], torsion, tip[3], quaternion[4];
} helix_table[] = {
    {{6.283185307179586, 0, 0}, 0.7, {0, 0, 0}, {-1, 0, 0, 0}},
    {{12.566370614359172, 0, 0}, 0.7, {0, 0, 0}, {1, 0, 0, 0}},
    {{0, 3, 4},
     0.7692307692307693,
     {0.08596053774441283, 0.5720567303676612, 0.5709574522242542},
     {-0.9315505919323018, 0.20275367502293265, 0.29636422503621157, -0.05720741257877954}},
    {{0, 25, 20},
     0.7692307692307692,
     {0.004255902700122457, 0.4792055632270869, 0.40099304596614144},
     {0.9718599193412969, -0.03254913445371952, 0.22834039852344223, 0.04784886024135593}},
};

static void helix_meets_reference_table(void **unused)
{
    (void)unused;
    for (size_t row = 0; row < sizeof helix_table / sizeof helix_table[0]; row++) {
        analytic_state state;
        assert_int_equal(analytic_helix_at(&along_z, 1.0, helix_table[row].torsion,
                                           helix_table[row].couple, 1.0, &state, NULL),
                         AD_OK);
        /* Angles up to 32 rad, each good to half an ulp. */
        for (int i = 0; i < 3; i++) {
            assert_near(state.position[i], helix_table[row].tip[i], 1e-14);
        }
        for (int i = 0; i < 4; i++) {
            assert_near(state.quaternion[i], helix_table[row].quaternion[i], 1e-14);
        }
    }
}

/* d/ds of (r, q) for M constant in the world: q_s = q (x) (0, u)/2 with u = diag(1/B,1/B,1/C) R^T
 * M, r_s = d3; the rotation matrix is written out, independent of the code under test. */
static void helix_rate(const double y[7], const double M[3], double B, double C, double rate[7])
{
    const double w = y[3], a = y[4], b = y[5], c = y[6];
    const double d1[3] = {1 - 2 * (b * b + c * c), 2 * (a * b + w * c), 2 * (a * c - w * b)};
    const double d2[3] = {2 * (a * b - w * c), 1 - 2 * (a * a + c * c), 2 * (b * c + w * a)};
    const double d3[3] = {2 * (a * c + w * b), 2 * (b * c - w * a), 1 - 2 * (a * a + b * b)};
    const double u1 = (d1[0] * M[0] + d1[1] * M[1] + d1[2] * M[2]) / B;
    const double u2 = (d2[0] * M[0] + d2[1] * M[1] + d2[2] * M[2]) / B;
    const double u3 = (d3[0] * M[0] + d3[1] * M[1] + d3[2] * M[2]) / C;
    for (int i = 0; i < 3; i++) {
        rate[i] = d3[i];
    }
    rate[3] = 0.5 * (-a * u1 - b * u2 - c * u3);
    rate[4] = 0.5 * (w * u1 + b * u3 - c * u2);
    rate[5] = 0.5 * (w * u2 + c * u1 - a * u3);
    rate[6] = 0.5 * (w * u3 + a * u2 - b * u1);
}

static void helix_step(double y[7], double h, const double M[3], double B, double C)
{
    static const double node[4] = {0, 0.5, 0.5, 1}, weight[4] = {1, 2, 2, 1};
    double rate[7] = {0}, sum[7] = {0}, trial[7];
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < 7; i++) {
            trial[i] = y[i] + h * node[stage] * rate[i];
        }
        helix_rate(trial, M, B, C, rate);
        for (int i = 0; i < 7; i++) {
            sum[i] += weight[stage] * rate[i];
        }
    }
    for (int i = 0; i < 7; i++) {
        y[i] += h / 6.0 * sum[i];
    }
}

static void helix_solves_its_equation(void **unused)
{
    (void)unused;
    const double B = 0.31, C = 0.22, M[3] = {0.7, -1.1, 0.9};
    const analytic_clamp clamp = {{0.3, -0.2, 0.1}, {0.5, -0.5, 0.1, 0.7}}; /* already unit */
    double y[7];
    memcpy(y, clamp.position, sizeof clamp.position);
    memcpy(y + 3, clamp.quaternion, sizeof clamp.quaternion);
    const int steps = 4000;
    for (int step = 1; step <= steps; step++) {
        helix_step(y, 1.0 / steps, M, B, C);
        if (step % 1000 == 0) {
            analytic_state state;
            assert_int_equal(analytic_helix_at(&clamp, B, C, M, (double)step / steps, &state, NULL),
                             AD_OK);
            /* Rates of 5 per length: 5^5/100 h^4 = 1e-13, plus rounding of the integration. */
            for (int i = 0; i < 3; i++) {
                assert_near(state.position[i], y[i], 3e-13);
                assert_near(state.force[i], 0.0, 0.0);
            }
            for (int i = 0; i < 4; i++) {
                assert_near(state.quaternion[i], y[3 + i], 3e-13);
            }
            double rate[7];
            helix_rate(y, M, 1.0, 1.0, rate); /* with B = C = 1 the body rate is the moment */
            const double *m = state.moment;
            assert_near(0.5 * (-y[4] * m[0] - y[5] * m[1] - y[6] * m[2]), rate[3], 1e-12);
            assert_near(0.5 * (y[3] * m[0] + y[5] * m[2] - y[6] * m[1]), rate[4], 1e-12);
            assert_near(0.5 * (y[3] * m[1] + y[6] * m[0] - y[4] * m[2]), rate[5], 1e-12);
            assert_near(0.5 * (y[3] * m[2] + y[4] * m[1] - y[5] * m[0]), rate[6], 1e-12);
        }
    }
}

static void rollup_is_a_circle(void **unused)
{
    (void)unused;
    const double length = 2.5, stiffness = 3.0;
    const double bends[] = {0.0, 1e-9, 1e-3, 1.0, 2 * pi, 4 * pi, 100.0, -7.0};
    for (size_t row = 0; row < sizeof bends / sizeof bends[0]; row++) {
        for (int i = 0; i <= 8; i++) {
            const double s = length * i / 8, angle = bends[row] * i / 8;
            const double couple[3] = {0, bends[row] * stiffness / length, 0};
            analytic_state state;
            assert_int_equal(analytic_rollup_at(&along_z, stiffness, couple, s, &state, NULL),
                             AD_OK);
            /* About +y the tangent goes from +z to +x; (1 - cos)/angle from half angles. */
            const double half = 0.5 * angle;
            const double sideways = angle != 0 ? s * sin(half) * sin(half) / half : 0;
            const double forward = angle != 0 ? s * sin(angle) / angle : s;
            /* 100 rad carry a rounding of 1e-14 each. */
            assert_near(state.position[0], sideways, 2e-14 * fmin(length, fabs(sideways) + 1e-3));
            assert_near(state.position[1], 0.0, 0.0);
            assert_near(state.position[2], forward, 5e-14);
            assert_near(state.quaternion[0], cos(half), 2e-14);
            assert_near(state.quaternion[2], sin(half), 2e-14);
            assert_near(state.moment[1], couple[1], 1e-14 * fabs(couple[1]));
        }
    }
}

static void rollup_turns_meet_reference(void **unused)
{
    (void)unused;
    /* Reference case S3: M = 2 pi n EI/L closes the rod n times; q(L) = -1 for n = 1, +1 for 2. */
    for (int turns = 1; turns <= 2; turns++) {
        const double couple[3] = {2 * pi * turns, 0, 0};
        analytic_state state;
        assert_int_equal(analytic_rollup_at(&along_z, 1.0, couple, 1.0, &state, NULL), AD_OK);
        for (int i = 0; i < 3; i++) {
            assert_near(state.position[i], 0.0, 1e-15);
        }
        assert_near(state.quaternion[0], turns == 1 ? -1.0 : 1.0, 1e-15);
    }
}

static void couples_refuse_bad_arguments(void **unused)
{
    (void)unused;
    analytic_state state;
    ad_error error;
    const double couple[3] = {1, 0, 1}, bad[3] = {INFINITY, 0, 0};
    assert_int_equal(analytic_rollup_at(&along_z, 1, couple, 1, &state, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "tip couple"));
    assert_int_equal(analytic_helix_at(&along_z, 1, 0, couple, 1, &state, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "torsional stiffness"));
    assert_int_equal(analytic_helix_at(&along_z, 1, 1, bad, 1, &state, &error), AD_BAD_ARGUMENT);
    assert_int_equal(analytic_helix_at(&along_z, 1, 1, couple, NAN, &state, &error),
                     AD_BAD_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elastica_tip_meets_reference_table),
        cmocka_unit_test(elastica_keeps_relative_accuracy),
        cmocka_unit_test(elastica_solves_its_equation),
        cmocka_unit_test(elastica_balances_moments_at_any_load),
        cmocka_unit_test(elastica_in_space),
        cmocka_unit_test(elastica_without_load_is_straight),
        cmocka_unit_test(elastica_refuses_bad_arguments),
        cmocka_unit_test(helix_meets_reference_table),
        cmocka_unit_test(helix_solves_its_equation),
        cmocka_unit_test(rollup_is_a_circle),
        cmocka_unit_test(rollup_turns_meet_reference),
        cmocka_unit_test(couples_refuse_bad_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
