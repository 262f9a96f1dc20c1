/* Stability margins: closed forms of columns, and the matrix of members against that of the second
 * variation of one equilibrium, which other equations find and in which displacements, forces and
 * turns stand where the members have curvatures. */
#include "fewer.h"
#include "near.h"

#include "physics/solve/solve.h"
#include "physics/solve/stability.h"
#include "tools/prepare/prepare.h"

#include <stdlib.h>
#include <string.h>

enum { NODES_MOST = 96, PARAMETERS_MOST = 3 };

static config *read_text(const char *text)
{
    ad_error error = {.message = ""};
    config *result = NULL;
    if (prepare_read("family.yaml", text, 0, NULL, &result, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return result;
}

/* Solvers choose their meshes by members of the family: one for all of a scene. */
static solve_members *solver_of(const scene *open)
{
    const double s = scene_length(open);
    const solve_members_settings settings = {.tolerance = 1e-9, .threads = 1, .points = 1, .s = &s};
    solve_members *x = NULL;
    ad_error error = {.message = ""};
    if (solve_members_create(open, &settings, &x, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_true(solve_members_nodes(x) <= NODES_MOST);
    return x;
}

/* Of a member: its margin and the next, and the derivatives. */
static void margins_of(solve_members *x, const double *parameters, double margin[SOLVE_MARGINS],
                       double *by)
{
    solve_member result;
    double curvature[(3 + SCENE_TUBES_MAX) * NODES_MOST];
    ad_error error = {.message = ""};
    assert_int_equal(solve_members_curvature(x, 1, parameters, NULL, curvature, &result, &error),
                     AD_OK);
    if (!result.solved) {
        fail_msg("%s at %g of the load, estimate %g", solve_member_text(result.end), result.load,
                 result.estimate);
    }
    assert_int_equal(solve_members_margin(x, 1, parameters, curvature, margin, by, &error), AD_OK);
}

/* The least alone; by: [SOLVE_MARGINS][parameters]. */
static double margin_of(solve_members *x, const double *parameters, double *by)
{
    double margin[SOLVE_MARGINS];
    margins_of(x, parameters, margin, by);
    return *margin;
}

/* The share of the sections' stiffness against bending and twist that the rod could lose, to 1e-10,
 * by the signs of the second variation; it is between `low` and `high`, if the latter is finite. */
static double margin_by_counts(const scene *one, const double *values)
{
    enum { STEPS = 60 };
    static const double ALL = 1e-6, FINE = 1e-10;
    double low = -INFINITY, high = 1 - ALL, at = high;
    ad_error error = {.message = ""};
    for (int k = 0; k < STEPS && high - low > FINE * fmax(1, fabs(high)); k++) {
        int count;
        assert_int_equal(stability_count_with(one, 1, 1 - at, values, &count, &error), AD_OK);
        assert_true(count >= 0);
        *(count > 0 ? &high : &low) = at;
        if (k == 0 && count == 0) {
            low = high = 1;
        }
        at = low > -INFINITY ? (low + high) / 2 : high > 0 ? 0 : 2 * high - 1;
    }
    return (low + high) / 2;
}

/* By the second variation, of what the other solver finds. */
static double by_variation(const scene *open, const double *parameters)
{
    double s[STABILITY_POINTS], *values;
    scene one;
    solve_report report;
    solution *found = NULL;
    ad_error error = {.message = ""};
    scene_member(open, parameters, &one);
    one.motion = SCENE_SPATIAL; /* margins count what leaves a plane */
    const solve_settings settings = solve_settings_default(&one);
    const int columns = solution_columns(&one);
    if (solution_create(&one, &settings, 0, NULL, &found, &report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_true(report.load_fraction == 1);
    values = malloc((size_t)columns * STABILITY_POINTS * sizeof *values);
    assert_int_equal(stability_points(&one, s, &error), AD_OK);
    assert_int_equal(solution_evaluate(found, columns, STABILITY_POINTS, s, NULL, values, &error),
                     AD_OK);
    const double margin = margin_by_counts(&one, values);
    free(values);
    solution_free(found);
    return margin;
}

#define COLUMN                                                                                     \
    "parameters: {push: {range: [-2, 10]}}\n"                                                      \
    "rod: {model: kirchhoff, length: 2, stiffness: {bending: [4, 3], torsion: 2}}\n"

/* Of straight columns all is linear in the load: 1 - P/P_cr, and its derivative. Polynomials on
 * Gauss' points have critical loads to 1e-10, differences of derivatives leave 1e-9. On the 512
 * straight elements of the other form P_cr is off by (pi h/2 L)^2/12 = 0.8e-6 of it, of twice that
 * for what is in the middle of an element. */
static void columns_lose_a_share_by_their_load(void **state)
{
    (void)state;
    static const double pi = 3.141592653589793;
    const struct {
        const char *more;
        double critical;
    } rows[] = {
        {"loads: {tip: {force: [0, 0, -push]}}\n", 3 * pi * pi / 16},
        {"loads: {tip: {force: [0, 0, -push]}}\nmotion: spatial\n", 3 * pi * pi / 16},
        /* its own weight: by the first zero of Bessel's function of order -1/3 (Greenhill 1881) */
        {"loads: {force: [0, 0, -push]}\n", 3 * 7.837347438943469 / 8},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char text[400];
        snprintf(text, sizeof text, COLUMN "%s", rows[i].more);
        config *given = read_text(text);
        solve_members *solver = solver_of(&given->scene);
        for (double share = -0.24; share < 1; share += 0.24) {
            const double push = share * rows[i].critical, expected = share < 0 ? 1 : 1 - share;
            double by[SOLVE_MARGINS];
            assert_near(margin_of(solver, &push, by), expected, 1e-9);
            if (share != 0) { /* there nothing softens it on one side */
                assert_near(*by * rows[i].critical, share < 0 ? 0 : -1, 1e-8);
            }
            assert_near(by_variation(&given->scene, &push), expected, 2e-6);
        }
        solve_members_free(solver);
        config_free(given);
    }
}

/* Two equal tubes of curvature k, turned by half a turn against one another, are straight. With E I
 * = 1, G J = 1/(1 + nu) and x^2 = k^2 E I/(G J) the second variation for a change of the angle phi
 * is, at its best curvatures, that of phi'' = -x^2/(1 - margin) phi, phi(0) = phi'(1) = 0. */
static void tubes_lose_a_share_by_their_curvature(void **state)
{
    (void)state;
    static const double pi = 3.141592653589793;
    config *given = read_text(
        "parameters: {x: {range: [0.1, 1.5]}}\n"
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1/1.3},\n"
        "      rest: {curvature: [x/sqrt(1.3), 0, 0]}}\n"
        "tubes: [{stiffness: {bending: [1, 1], torsion: 1/1.3}, turned: pi,\n"
        "         rest: {curvature: [x/sqrt(1.3), 0, 0]}}]\n");
    solve_members *solver = solver_of(&given->scene);
    for (double x = 0.3; x < 1.5; x += 0.3) {
        double by[SOLVE_MARGINS];
        const double lost = 4 * x * x / (pi * pi);
        assert_near(margin_of(solver, &x, by), 1 - lost, 1e-9);
        assert_near(*by, -2 * lost / x, 1e-7);
        assert_near(by_variation(&given->scene, &x), 1 - lost, 2e-5);
    }
    solve_members_free(solver);
    config_free(given);
}

#define ROBOT(start, more)                                                                         \
    "parameters: {pull: {range: [0, 2]}, side: {range: [-0.2, 0.2]}, stiff: {range: [0.5, 2], "    \
    "scale: log}}\n"                                                                               \
    "rod: {model: cosserat, section: {shape: circle, radius: 0.002},\n"                            \
    "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000}}\n"           \
    "segments:\n"                                                                                  \
    "  - {length: 0.1}\n"                                                                          \
    "  - {length: 0.15, turn: [0, 0.3, 0], section: {radius: \"0.002-0.004*(s-0.1)\"}}\n"          \
    "boundary: {start: {type: clamped, rotation: " start "}}\n" more

/* Rods that are bent out of a plane, with joints, tendons, springs, a foundation, a held end: the
 * other form is off by up to 1.5e-5, as its elements are straight. Derivatives against differences
 * of fourth order of margins, of members that are solved to 1e-9, which over the step is 1e-6 at
 * most and was 3e-8. */
static void bent_rods_have_the_margin_of_the_second_variation(void **state)
{
    (void)state;
    static const char *const robots[] = {
        ROBOT("[1, 0, 0, 0]", "loads: {gravity: [0, 4, -8], tip: {force: [0, side, -0.3*pull]}}\n"),
        ROBOT("[0.8, 0.6, 0, 0]",
              "loads: {gravity: [3, side, -4], tip: {force: [0, side, -0.3*pull]}}\n"
              "tendons: [{offset: [0.006, 0], end: 0.18, tension: pull}, {offset: "
              "[\"0.005*cos(10*s)\", "
              "\"0.005*sin(10*s)\"], tension: pull/2}]\n"),
        ROBOT("[1, 0, 0, 0]", "loads: {tip: {force: [0, side, -2*pull]}, foundation: [2, 1, 0]}\n"
                              "springs: [{at: 0.25, stiffness: [3, 2, 0.5]}, {at: 0.05, turning: "
                              "[0.01, 0.02, 0.01]}]\n"),
        ROBOT("[1, 0, 0, 0]",
              "loads: {tip: {force: [0, 0, -pull]}, points: [{at: 0.05, force: [0, 0, side]}]}\n"),
        "parameters: {pull: {range: [0, 2]}, side: {range: [-0.2, 0.2]}, stiff: {range: [0.5, "
        "2]}}\n"
        "rod: {length: 1, model: cosserat, stiffness: {shear: [200, 200], axial: 400, bending: "
        "[stiff, 2*stiff], torsion: 1}}\n"
        "boundary: {end: {type: clamped, position: [side, 0, 0.9], rotation: [1, 0, 0.1, 0]}}\n"
        "loads: {force: [0, 3*pull, 0]}\n",
        "parameters: {pull: {range: [0, 2]}, side: {range: [-0.2, 0.2]}, stiff: {range: [0.5, "
        "2]}}\n"
        "rod: {length: 1, model: kirchhoff, stiffness: {bending: [stiff, 1], torsion: 0.7},\n"
        "      rest: {curvature: ['1 + s', side, 0.1]}}\n"
        "tubes: [{stiffness: {bending: [1, 2], torsion: 0.8}, turned: 1.5*pull, transmission: "
        "0.1,\n"
        "         end: 0.7, rest: {curvature: [1.2, side, 0]}},\n"
        "        {stiffness: {bending: [2, 2], torsion: 1}, turned: 1, end: 0.4,\n"
        "         rest: {curvature: [0.5, 0, 0]}}]\n"
        "loads: {tip: {force: [side, 0, -0.2*pull]}, force: [0, 0.1, 0]}\n",
    };
    static const double parameters[][3] = {{0.4, 0.05, 1}, {1.1, -0.1, 1.6}, {1.5, 0.17, 0.8}};
    static const double weight[4] = {1, -8, 8, -1}, way[4] = {-2, -1, 1, 2};
    for (size_t r = 0; r < sizeof robots / sizeof *robots; r++) {
        config *given = read_text(robots[r]);
        solve_members *solver = solver_of(&given->scene);
        for (size_t i = 0; i < FEWER(3); i++) {
            double by[SOLVE_MARGINS * 3], p[3];
            const double margin = margin_of(solver, parameters[i], by);
            assert_near(by_variation(&given->scene, parameters[i]), margin, 2e-5);
            for (int k = 0; k < 3; k++) {
                double sum = 0;
                for (int j = 0; j < 4; j++) {
                    memcpy(p, parameters[i], sizeof p);
                    p[k] += 1e-3 * way[j];
                    sum += weight[j] * margin_of(solver, p, NULL) / 12e-3;
                }
                assert_near(by[k], sum, 1e-7);
            }
        }
        solve_members_free(solver);
        config_free(given);
    }
}

/* Of a column that bends in two planes each has a margin of its own, 1 - P/P_cr with a stiffness of
 * its own, also where scene and shape are planar. They cross where these are the same: the least
 * has a kink there, whose sides are the derivatives of the two, wherever the member is beside it.
 * Differences of derivatives leave 1e-9 of them, over the gap 1e-5 in the vectors. */
static void margins_of_two_planes_cross(void **state)
{
    (void)state;
    static const double pi = 3.141592653589793;
    static const double beside[] = {-0.1, -1e-3, -1e-5, -1e-7, -1e-10, 0, 1e-9, 1e-6, 1e-4, 0.2};
    for (int turned = 0; turned < 2; turned++) {
        char text[300];
        snprintf(text, sizeof text,
                 "parameters: {wide: {range: [1, 2]}, high: {range: [1, 2]}, push: {range: [0, "
                 "2]}}\nrod: {model: kirchhoff, length: 1, stiffness: {bending: [%s], torsion: "
                 "1}}\nloads: {tip: {force: [0, 0, -push]}}\n",
                 turned ? "high, wide" : "wide, high");
        config *given = read_text(text);
        solve_members *solver = solver_of(&given->scene);
        for (size_t i = 0; i < sizeof beside / sizeof *beside; i++) {
            const double p[3] = {1.5, 1.5 + beside[i], 1.8};
            double margin[SOLVE_MARGINS], by[SOLVE_MARGINS][3];
            margins_of(solver, p, margin, by[0]);
            const int weak = fabs(beside[i]) > 1e-8 ? p[1] < p[0] : by[0][1] > by[0][0];
            for (int k = 0; k < SOLVE_MARGINS; k++) {
                const int own = k == 0 ? weak : !weak; /* the plane that gives way by it */
                const double lost = 4 * p[2] / (pi * pi * p[own]);
                assert_near(margin[k], 1 - lost, 1e-9);
                assert_near(by[k][own], lost / p[own], 1e-6);
                assert_near(by[k][!own], 0, 1e-6);
                assert_near(by[k][2], -lost / p[2], 1e-7);
            }
        }
        solve_members_free(solver);
        config_free(given);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(tubes_lose_a_share_by_their_curvature),
                                       cmocka_unit_test(margins_of_two_planes_cross)};
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(columns_lose_a_share_by_their_load),
        cmocka_unit_test(bent_rods_have_the_margin_of_the_second_variation)};
    return run_with_alike(tests, alike, NULL, NULL);
}
