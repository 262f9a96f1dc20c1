/* A magnetised rod in a field: against the elastica in a uniform field, the field at which a rod
 * that is magnetised against it gives way, stretch by a gradient, the same scene elsewhere; and
 * methods among themselves, at rest and in motion. */
#include "chain_testing.h"
#include "fewer.h"
#include "near.h"

#include "physics/solve/solve.h"
#include "physics/solve/stability.h"
#include "tools/prepare/prepare.h"

#include <stdio.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Columns of a rod. */
enum { X = 0, Y = 1, Z = 2, N3 = 15, COLUMNS = 19, TEXT = 1200 };

typedef struct solved {
    config *settings;
    solution *solution;
    solve_report report;
} solved;

static solved solve_by(solve_method method, const char *text, double tolerance, size_t count,
                       const double *times)
{
    ad_error error = {.message = ""};
    const solve_settings asked = {.tolerance = tolerance, .method = method};
    solved x = {.settings = NULL};
    if (prepare_read("scene.yaml", text, 0, NULL, &x.settings, &error) != AD_OK ||
        solution_create(&x.settings->scene, &asked, count, times, &x.solution, &x.report, &error) !=
            AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_near(x.report.load_fraction, 1, 0);
    return x;
}

/* The first of its columns at s, as members of families are solved. */
static void evaluate_by_chain(const solved *x, double s, double *values)
{
    solve_by_chain(&x->settings->scene, 1e-9, 1, &s, values);
}

static void release(solved *x)
{
    solution_free(x->solution);
    config_free(x->settings);
}

static void evaluate(const solved *x, double s, double t, double *values)
{
    ad_error error = {.message = ""};
    double all[40] = {0};
    if (solution_evaluate(x->solution, solution_columns(&x->settings->scene), 1, &s, &t, all,
                          &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    memcpy(values, all, COLUMNS * sizeof *values);
}

/* ---- the elastica in a uniform field ----------------------------------------------------------
 */

/* A rod along z with E I = 2, L = 1.5, m = 3 along it. */
#define ROD    "rod: {model: kirchhoff, length: 1.5, stiffness: {bending: [2, 2], torsion: 1}}\n"
#define MAGNET "loads: {magnetic: {moment: [0, 0, 3], field: "

/* EI theta'' + m B sin(phi - theta) = 0 from theta(0) = 0 to theta'(L) = 0, a pendulum's equation:
 * with psi = pi - phi + theta, sin(psi/2) = k sin(eta), k = cos((phi - theta(L))/2), the arc length
 * goes as ds = (EI/(m B))^(1/2) d eta (1 - k^2 sin^2 eta)^(-1/2), from sin(eta) = cos(phi/2)/k to
 * the end at pi/2 (Wang, Kim, Guo, Zhao, J. Mech. Phys. Solids 142, 2020). Sums at the middles of
 * so many parts, extrapolated: errors are below 1e-14. */
typedef struct elastica {
    double root; /* L (m B/EI)^(1/2) */
    double x, z; /* of the tip, over the length */
} elastica;

static elastica sum_of(double phi, double turned, int parts)
{
    const double k = cos((phi - turned) / 2), from = asin(cos(phi / 2) / k);
    const double h = (pi / 2 - from) / parts;
    elastica sum = {.root = 0};
    for (int i = 0; i < parts; i++) {
        const double sine = k * sin(from + (i + 0.5) * h), ds = h / sqrt(1 - sine * sine);
        const double theta = phi - pi + 2 * asin(sine);
        sum.root += ds;
        sum.x += sin(theta) * ds;
        sum.z += cos(theta) * ds;
    }
    return sum;
}

static elastica elastica_of(double phi, double turned)
{
    enum { PARTS = 4000 };
    const elastica half = sum_of(phi, turned, PARTS), whole = sum_of(phi, turned, 2 * PARTS);
    elastica e = {.root = (4 * whole.root - half.root) / 3};
    e.x = (4 * whole.x - half.x) / 3 / e.root;
    e.z = (4 * whole.z - half.z) / 3 / e.root;
    return e;
}

static void test_elastica(void **state)
{
    (void)state;
    /* across the rod, and against it: the latter bends far beyond where it gives way */
    static const double rows[][2] = {
        {1.5707963267948966, 0.2}, {1.5707963267948966, 1.3}, {2.2, 1.9}, {3, 2.6}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const double phi = rows[k][0];
        const elastica e = elastica_of(phi, rows[k][1]);
        const double field = 2 * e.root * e.root / (3 * 1.5 * 1.5);
        char text[TEXT];
        double tip[2][COLUMNS];
        snprintf(text, sizeof text, ROD MAGNET "[%.17g, 0, %.17g]}}\n", field * sin(phi),
                 field * cos(phi));
        solved x = solve_by(SOLVE_COLLOCATION, text, 1e-11, 0, NULL);
        evaluate(&x, 1.5, 0, tip[0]);
        evaluate_by_chain(&x, 1.5, tip[1]);
        for (int i = 0; i < 2; i++) { /* the tolerance, by how far the rod is bent */
            assert_near(tip[i][X], 1.5 * e.x, i ? 1e-7 : 1e-9);
            assert_near(tip[i][Z], 1.5 * e.z, i ? 1e-7 : 1e-9);
        }
        release(&x);
    }
}

/* ---- where it gives way -----------------------------------------------------------------------
 */

static int ways_of(const char *text)
{
    double at[STABILITY_POINTS], values[COLUMNS * STABILITY_POINTS];
    int ways = -2;
    ad_error error = {.message = ""};
    solved x = solve_by(SOLVE_COLLOCATION, text, 1e-9, 0, NULL);
    assert_int_equal(stability_points(&x.settings->scene, at, NULL), AD_OK);
    if (solution_evaluate(x.solution, COLUMNS, STABILITY_POINTS, at, NULL, values, &error) !=
            AD_OK ||
        stability_count(&x.settings->scene, values, &ways, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    release(&x);
    return ways;
}

/* Against the field it gives way where m B L^2/EI = pi^2/4, in its plane or in both; elements of
 * 1/128 are off by less than 0.1 %. Along the field it stays. */
static void test_critical(void **state)
{
    (void)state;
    static const struct {
        double part;
        int ways[2];
    } rows[] = {{-3, {0, 0}}, {0.995, {0, 0}}, {1.005, {1, 2}}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const double field = rows[k].part * 2 * pi * pi / 4 / (3 * 1.5 * 1.5);
        for (int spatial = 0; spatial < 2; spatial++) {
            char text[TEXT];
            snprintf(text, sizeof text, "%s" ROD MAGNET "[0, 0, %.17g]}}\n",
                     spatial ? "motion: spatial\n" : "", -field);
            assert_int_equal(ways_of(text), rows[k].ways[spatial]);
        }
    }
}

/* The same in a field that grows from 0 at the base, B = c (x/2, y/2, -z). With the force m c
 * (theta/2, -1) per length EI theta'' + m c (L theta + x(L)/2) = 0, which has a solution but 0
 * first where m c L^3/EI = q^2, tan q = 3 q. */
static void test_critical_gradient(void **state)
{
    (void)state;
    double q = 1.3;
    for (int i = 0; i < 20; i++) { /* of sin q - 3 q cos q */
        q -= (sin(q) - 3 * q * cos(q)) / (3 * q * sin(q) - 2 * cos(q));
    }
    for (int beyond = 0; beyond < 2; beyond++) {
        const double c = (beyond ? 1.005 : 0.995) * q * q * 2 / (3 * 1.5 * 1.5 * 1.5);
        for (int spatial = 0; spatial < 2; spatial++) {
            char text[TEXT];
            snprintf(text, sizeof text,
                     "%s" ROD "loads: {magnetic: {moment: [0, 0, 3], gradient: [%.17g, %.17g, 0, "
                     "0, 0]}}\n",
                     spatial ? "motion: spatial\n" : "", c / 2, c / 2);
            assert_int_equal(ways_of(text), beyond ? 1 + spatial : 0);
        }
    }
}

/* A magnet at the tip: EI theta' = m B sin(phi - theta(L)) all along, an arc. Against the field it
 * gives way where m B L/EI = 1. */
#define TIP                                                                                        \
    ROD "bodies: [{at: 1.5, mass: 0, magnetic_moment: [0, 0, 3]}]\nloads: {magnetic: {field: "

static void test_tip(void **state)
{
    (void)state;
    const double turned = 0.9, field = 2 * turned / (1.5 * 3 * cos(turned));
    char text[TEXT];
    snprintf(text, sizeof text, TIP "[%.17g, 0, 0]}}\n", field);
    double tip[2][COLUMNS];
    solved x = solve_by(SOLVE_COLLOCATION, text, 1e-11, 0, NULL);
    evaluate(&x, 1.5, 0, tip[0]);
    evaluate_by_chain(&x, 1.5, tip[1]);
    for (int i = 0; i < 2; i++) {
        assert_near(tip[i][X], 1.5 * (1 - cos(turned)) / turned, i ? 1e-8 : 1e-9);
        assert_near(tip[i][Z], 1.5 * sin(turned) / turned, i ? 1e-8 : 1e-9);
    }
    release(&x);
    for (int beyond = 0; beyond < 2; beyond++) {
        snprintf(text, sizeof text, TIP "[0, 0, %.17g]}}\n",
                 -(beyond ? 1.005 : 0.995) * 2 / (3 * 1.5));
        assert_int_equal(ways_of(text), beyond);
    }
}

/* ---- a gradient -------------------------------------------------------------------------------
 */

/* Along its axis it is pulled by m G per length. */
static void test_stretched(void **state)
{
    (void)state;
    static const char text[] =
        "rod: {model: cosserat, length: 1.5, stiffness: {shear: [9, 9], axial: 50, bending: [2, "
        "2], torsion: 1}}\n"
        "boundary: {start: {type: clamped, position: [0, 0, 0.4]}}\n"
        "loads: {magnetic: {moment: [0, 0, '3*s'], gradient: [-2, -2, 0, 0, 0]}}\n";
    const double stretched = 0.4 + 1.5 + 6 * (1.5 * 1.5 * 1.5 - 1.5 * 1.5 * 1.5 / 3) / 50;
    double tip[COLUMNS], middle[COLUMNS];
    solved x = solve_by(SOLVE_COLLOCATION, text, 1e-11, 0, NULL);
    evaluate(&x, 1.5, 0, tip);
    evaluate(&x, 0.7, 0, middle);
    /* n = 6 (L^2 - s^2), zz = 4 */
    assert_near(middle[N3], 6 * (1.5 * 1.5 - 0.7 * 0.7), 1e-8);
    assert_near(tip[Z], stretched, 1e-9);
    evaluate_by_chain(&x, 1.5, tip);
    assert_near(tip[Z], stretched, 1e-8);
    release(&x);
}

/* A rod in space, with all that there is. Elsewhere, in the field that it had there. */
#define BENT                                                                                       \
    "rod: {model: cosserat, length: 1.5, stiffness: {shear: [90, 90], axial: 150, bending: [2, "   \
    "3], torsion: 1}}\n"                                                                           \
    "boundary: {start: {type: clamped, position: [%g, %g, %g]}}\n"                                 \
    "bodies: [{at: 0.6, mass: 0, magnetic_moment: [0.2, -0.1, 0.3]},\n"                            \
    "         {at: 1.5, mass: 0, magnetic_moment: [0.1, 0.1, 0.4]}]\n"                             \
    "loads:\n"                                                                                     \
    "  force: [0.2, 0.1, 0]\n"                                                                     \
    "  magnetic: {moment: ['0.3*s', 0.2, 1], field: [%.17g, %.17g, %.17g],\n"                      \
    "             gradient: [0.5, -0.3, 0.4, 0.2, 0.6]}\n"

static void write_bent(char *text, const double place[3])
{
    const double B[3] = {0.8, -0.6, 0.3};
    const double G[3][3] = {{0.5, 0.4, 0.2}, {0.4, -0.3, 0.6}, {0.2, 0.6, -0.2}};
    double field[3];
    for (int i = 0; i < 3; i++) {
        field[i] = B[i] - (G[i][0] * place[0] + G[i][1] * place[1] + G[i][2] * place[2]);
    }
    snprintf(text, TEXT, BENT, place[0], place[1], place[2], field[0], field[1], field[2]);
}

/* The methods are solved to 1e-11 and 1e-9, and agree. */
static void test_moved(void **state)
{
    (void)state;
    static const double places[2][3] = {{0, 0, 0}, {1, -2, 0.5}};
    double tip[4][COLUMNS];
    for (int k = 0; k < 2; k++) {
        char text[TEXT];
        write_bent(text, places[k]);
        solved x = solve_by(SOLVE_COLLOCATION, text, 1e-11, 0, NULL);
        evaluate(&x, 1.5, 0, tip[2 * k]);
        evaluate_by_chain(&x, 1.5, tip[2 * k + 1]);
        release(&x);
        for (int i = 0; i < COLUMNS; i++) {
            const double moved = i < 3 ? places[k][i] : 0;
            assert_near(tip[2 * k][i], tip[0][i] + moved, 1e-9);
            if (i < 7) { /* position and rotation */
                assert_near(tip[2 * k + 1][i], tip[0][i] + moved, 1e-8);
            }
        }
    }
    assert_true(fabs(tip[0][X]) > 0.3 && fabs(tip[0][Y]) > 0.1);
}

/* ---- in motion --------------------------------------------------------------------------------
 */

/* Nodes and modes, in a field that turns and a gradient that comes, each to 1e-7 of the length in
 * L2. */
static void test_motion(void **state)
{
    (void)state;
    static const char text[] =
        "rod: {model: cosserat, length: 1, stiffness: {shear: [300, 300], axial: 400, bending: "
        "[1, "
        "1.5], torsion: 0.8}, inertia: {mass_per_length: 1, rotary: [0.01, 0.02, 0.03]}}\n"
        "loads: {magnetic: {moment: [0, 0.2, 1], field: ['2*sin(3*t)', 'sin(t)^2', -0.5],\n"
        "                   gradient: ['0.4*t', '-0.1*t', 0, '0.3*t', 0]}}\n"
        "time: {duration: 1}\n";
    const double t[2] = {WATCHED ? 0.1 : 0.5, WATCHED ? 0.2 : 1};
    double tip[2][2][COLUMNS];
    for (int method = 0; method < 2; method++) {
        solved x = solve_by(method ? SOLVE_MODES : SOLVE_COLLOCATION, text, 1e-7, 2, t);
        for (int i = 0; i < 2; i++) {
            evaluate(&x, 1, t[i], tip[method][i]);
        }
        release(&x);
    }
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 3; k++) {
            assert_near(tip[1][i][k], tip[0][i][k], 1e-6);
        }
    }
    assert_true(WATCHED || fabs(tip[0][1][X]) > 0.1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_elastica),
        cmocka_unit_test(test_tip),
        cmocka_unit_test(test_stretched),
        cmocka_unit_test(test_motion),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_critical_gradient),
                                       cmocka_unit_test(test_moved),
                                       cmocka_unit_test(test_critical)};
    return run_with_alike(tests, alike, NULL, NULL);
}
