/* Ends that slide, elastic foundations and segments that lock strains: against closed forms and
 * shooting outside of the project, by solver and by network. */
#include "fewer.h"
#include "near.h"
#include "trainer_testing.h"

#include "physics/solve/solve.h"

#define PI 3.14159265358979323846

/* ---- solving and training -------------------------------------------------------------------- */

typedef struct solved {
    config *settings;
    solution *solution;
    solve_report report;
    verdict verdict;
} solved;

static solved solve(const char *text, double tolerance, size_t count, const double *times)
{
    ad_error error = {.message = ""};
    const solve_settings asked = {.tolerance = tolerance};
    solved x = {0};
    if (prepare_read("scene.yaml", text, 0, NULL, &x.settings, &error) != AD_OK ||
        solution_create(&x.settings->scene, &asked, count, times, &x.solution, &x.report, &error) !=
            AD_OK) {
        fail_msg("%s", error.message);
    }
    solution_verdict(x.solution, &x.settings->scene, &asked, &x.report, &x.verdict);
    return x;
}

static void release(solved *x)
{
    solution_free(x->solution);
    config_free(x->settings);
}

static void place(const solved *x, double s, double t, double *values, int count)
{
    assert_int_equal(solution_evaluate(x->solution, count, 1, &s, &t, values, NULL), AD_OK);
}

/* Error of positions by a network against the solver. */
static double trained(const char *text)
{
    ad_error error = {AD_OK, ""};
    run r = {.made = {experiment_of("scene.yaml", text, NULL), NULL}};
    if (experiment_problem(r.made.e, &r.made.p, &error) != AD_OK ||
        reference_create(r.made.e, &r.known, &error) != AD_OK ||
        trainer_create(r.made.e, r.made.p, r.known, 0, &r.trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    finish(&r);
    double result = trainer_inspect(r.trainer)->errors.position;
    stop(&r);
    return result;
}

/* The first load, as a part of the whole, at which another path crosses. */
static double crossing(const char *text)
{
    ad_error error = {.message = ""};
    const solve_settings asked = {.tolerance = 1e-10};
    config *settings = NULL;
    solution_path *path = NULL;
    if (prepare_read("scene.yaml", text, 0, NULL, &settings, &error) != AD_OK ||
        solution_path_create(&settings->scene, &asked, &path, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    double load = NAN;
    for (size_t i = 1; i < path->count && isnan(load); i++) {
        if (path->points[i].mark == SOLUTION_BIFURCATION) {
            load = path->points[i].load;
            assert_int_equal(path->points[i - 1].unstable_modes, 0);
            assert_true(path->points[i + 1].unstable_modes != 0);
        }
    }
    solution_path_free(path);
    config_free(settings);
    return load;
}

/* ---- columns --------------------------------------------------------------------------------- */

#define COLUMN "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}}\n"
#define HELD   "position: [0, 0, 1], rotation: [1, 0, 0, 0]"

/* By Euler's loads, and Timoshenko and Gere 1961, Theory of Elastic Stability, 2.4 (tan x = x) and
 * 2.10: pinned on a foundation k, P = pi^2 m^2 + k/(m pi)^2 with the best m. Upright, pushed down
 * by 1.05 of the critical load. */
static void test_columns(void **state)
{
    (void)state;
    static const struct {
        const char *ends, *foundation;
        double critical;
    } rows[] = {
        {"start: {type: clamped}, end: {type: guided, " HELD "}", "0", 9.8696044010894},
        {"start: {type: clamped}, end: {type: guided, along: [0, 0, 2], " HELD "}", "0",
         39.478417604357},
        {"start: {type: clamped}, end: {type: roller, along: [0, 0, 1], position: [0, 0, 1]}", "0",
         20.190728556427},
        {"start: {type: pinned}, end: {type: roller, along: [0, 0, 1], position: [0, 0, 1]}", "0",
         9.8696044010894},
        {"start: {type: pinned}, end: {type: roller, along: [0, 0, 1], position: [0, 0, 1]}",
         "3000", 39.478417604357 + 3000 / 39.478417604357},
        {"start: {type: guided, across: [0, 0, 1]}, "
         "end: {type: roller, along: [0, 0, 1], position: [0, 0, 1]}",
         "0", 2.4674011002723},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i += FARTHER(1)) {
        char text[1024];
        snprintf(text, sizeof text,
                 COLUMN "boundary: {%s}\nmotion: planar\n"
                        "loads: {tip: {force: [0, 0, %.17g]}, foundation: [%s, 0, 0]}\n",
                 rows[i].ends, -1.05 * rows[i].critical, rows[i].foundation);
        double load = crossing(text);
        print_message("%s: %.12g\n", rows[i].ends, 1.05 * rows[i].critical * load);
        assert_true(fabs(1.05 * load - 1) < 1e-9); /* measured: 1e-11 */
    }
}

/* P = 2 (k EI)^(1/2) of a long one, here of six half waves exactly (Timoshenko and Gere
 * 1961, 2.10).
 */
static void test_long_column(void **state)
{
    (void)state;
    const double wave = 6 * PI, critical = 2 * wave * wave;
    char text[1024];
    snprintf(text, sizeof text,
             COLUMN "boundary: {start: {type: pinned}, end: {type: roller, along: [0, 0, 1], "
                    "position: [0, 0, 1]}}\nmotion: planar\n"
                    "loads: {tip: {force: [0, 0, %.17g]}, foundation: [%.17g, 0, 0]}\n",
             -1.03 * critical, wave * wave * wave * wave);
    assert_near(1.03 * crossing(text), 1, 1e-9);
}

/* Stable in the plane of the scene, and not out of it: columns with a weak axis, which lose by
 * Euler's loads and tan x = x; a tall strip under a force at its tip by Michell and Prandtl 1899, P
 * = 4.0126 (EI GJ)^(1/2)/L^2 (Timoshenko and Gere 1961, 6.4; GJ = 0.5; bent downwards by 1e-5,
 * which changes it by less). A round column between pins may turn about itself, which a force of
 * 1e-3 across it hardly resists. Elements of 1/512 have all this within 0.1%. */
static void test_out_of_the_plane(void **state)
{
    (void)state;
    enum { BELOW, ABOVE, KEPT }; /* the last above, in the plane by `motion` */
    static const char roller[] = "end: {type: roller, along: [0, 0, 1], position: [0, 0, 1]}";
    static const struct {
        double bending[2], direction[3];
        const char *start;
        double critical;
        int sides;
    } rows[] = {
        {{1, 3}, {0, 0, -1}, NULL, PI * PI / 4, 3},
        {{3, 1}, {0, 0, -1}, NULL, PI * PI / 4, 2},
        {{1, 3}, {0, 0, -1}, "clamped", 20.190728556427, 3},
        {{1, 1e5}, {1, 0, 0}, NULL, 2.837337, 3},
        {{1, 1}, {0, 0, -1}, "pinned", PI * PI, 1},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        for (int side = 0; side < rows[i].sides; side++) {
            const double P = (side == BELOW ? 0.995 : 1.005) * rows[i].critical;
            const double *d = rows[i].direction;
            char text[1024], ends[256] = "";
            if (rows[i].start) {
                snprintf(ends, sizeof ends, "boundary: {start: {type: %s}, %s}\n", rows[i].start,
                         roller);
            }
            snprintf(text, sizeof text,
                     "rod: {model: kirchhoff, length: 1, stiffness: {bending: [%g, %g], torsion: "
                     "0.5}}\n%s%sloads: {force: [%g, 0, 0], tip: {force: [%.17g, 0, %.17g]}}\n",
                     rows[i].bending[0], rows[i].bending[1], ends,
                     side == KEPT ? "motion: planar\n" : "", rows[i].start ? 1e-3 : 0, P * d[0],
                     P * d[2]);
            solved x = solve(text, 1e-9, 0, NULL);
            if (verdict_has(&x.verdict, VERDICT_UNSTABLE) != (side == ABOVE)) {
                fail_msg("row %zu, %d: %s", i, side, verdict_text(&x.verdict));
            }
            release(&x);
        }
    }
}

/* ---- shapes ---------------------------------------------------------------------------------- */

/* What slides sideways without turning is two cantilevers of half the length, turned about the
 * middle: by solver and by network. */
static void test_guided_elastica(void **state)
{
    (void)state;
    static const char text[] = COLUMN "boundary: {start: {type: clamped}, end: {type: guided, " HELD
                                      "}}\nloads: {tip: {force: [5, 0, 0]}}\nreference: solve\n";
    solved whole = solve(text, 1e-11, 0, NULL);
    solved half = solve("rod: {model: kirchhoff, length: 0.5, stiffness: {bending: [1, 1], "
                        "torsion: 1}}\nloads: {tip: {force: [5, 0, 0]}}\n",
                        1e-11, 0, NULL);
    double tip[3], middle[3];
    place(&whole, 1, 0, tip, 3);
    place(&half, 0.5, 0, middle, 3);
    assert_near(tip[0], 2 * middle[0], 1e-12);
    assert_near(tip[2], 2 * middle[2], 1e-12);
    release(&whole);
    release(&half);
    assert_true(trained(text) < 1e-12); /* measured: 1e-14 */
}

/* A cantilever on a foundation, pulled at its tip: w = sum of exponentials (Hetenyi 1946, Beams on
 * Elastic Foundation), the numbers by numpy from w'''' + 600 w = 0. */
static void test_founded_cantilever(void **state)
{
    (void)state;
    solved x = solve(COLUMN "loads: {tip: {force: [1e-4, 0, 0]}, foundation: [600, 5, 0]}\n", 1e-12,
                     0, NULL);
    double tip[3];
    place(&x, 1, 0, tip, 3);
    assert_near(tip[0], 1.1593177490082448e-06, 1e-15); /* to the square of the slope */
    solve_energy energy; /* half the work, with that of the foundation */
    assert_int_equal(solution_energy(x.solution, 0, &energy, NULL), AD_OK);
    assert_near(energy.strain, 0.5e-4 * tip[0], 1e-16);
    release(&x);
}

/* In space, oblique, with all of it, by scipy outside of the project: DOP853 to 1e-12 over rods in
 * pieces and Newton's method on what the ends give. */
static void test_oblique(void **state)
{
    (void)state;
    static const char text[] =
        "rod: {model: cosserat, stiffness: {bending: [1, 1.5], torsion: 0.8, shear: [30, 40], "
        "axial: 50}}\n"
        "segments:\n"
        "  - {length: 0.4}\n"
        "  - {length: 0.3, stiffness: {bending: [.inf, .inf], torsion: .inf, shear: [.inf, .inf], "
        "axial: .inf}}\n"
        "  - {length: 0.3, stiffness: {shear: [.inf, .inf], axial: .inf}}\n"
        "boundary: {start: {type: clamped}, end: {type: roller, position: [0.05, 0.03, 0.97], "
        "across: [1, 2, -0.5]}}\n"
        "loads: {force: [1, 2, -0.5], tip: {force: [0.5, -0.3, -1], moment: [0.2, 0.1, -0.1]}, "
        "foundation: [\"40*(1+s)\", \"20*(1+s)\", \"10*(1+s)\"]}\n"
        "reference: solve\n";
    static const double expected[3] = {0.0526877492919523, 0.0329856605784027, 0.987318140897515};
    solved x = solve(text, 1e-11, 0, NULL);
    double tip[3];
    place(&x, 1, 0, tip, 3);
    for (int i = 0; i < 3; i++) {
        assert_near(tip[i], expected[i], 1e-13);
    }
    release(&x);
    assert_true(trained(text) < 1e-12); /* measured: 1e-15 */
}

/* A clamped column, flexible up to a half and rigid beyond, pushed down: x tan(x/2) = 2 with
 * P = x^2 EI/L^2, from the deflection P (w_end - w) = EI w'' of the lower half. */
static void test_rigid_half(void **state)
{
    (void)state;
    double load = crossing("rod: {model: kirchhoff}\n"
                           "segments:\n"
                           "  - {length: 0.5, stiffness: {bending: [1, 1], torsion: 1}}\n"
                           "  - {length: 0.5, stiffness: {bending: [.inf, .inf], torsion: .inf}}\n"
                           "loads: {tip: {force: [0, 0, -4]}}\n");
    double low = 0.1, high = 3.1;
    for (int i = 0; i < 60; i++) {
        double x = (low + high) / 2;
        bool below = x * tan(x / 2) < 2;
        low = below ? x : low;
        high = below ? high : x;
    }
    assert_near(4 * load, low * low, 1e-9);
}

/* ---- motions --------------------------------------------------------------------------------- */

#define MOVING                                                                                     \
    "rod: {model: cosserat, length: %s, stiffness: {shear: [400, 400], axial: 1000, "              \
    "bending: [1, 1], torsion: 0.8}, inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.02]}}\n"

/* By symmetry what is guided across its axis is half of a rod that is clamped at both ends and
 * loaded alike, shear and large deflections included. */
static void test_guided_motion(void **state)
{
    (void)state;
    static const char half[] =
        MOVING "boundary: {start: {type: clamped}, end: {type: guided, along: [1, 0, 0], " HELD
               "}}\nloads: {force: [\"60*s*t^2\", 0, 0]}\ntime: {duration: 0.5}\n"
               "reference: solve\n";
    static const char whole[] =
        MOVING "boundary: {start: {type: clamped}, end: {type: clamped, position: [0, 0, 2], "
               "rotation: [1, 0, 0, 0]}}\nloads: {force: [\"60*min(s, 2-s)*t^2\", 0, 0]}\n"
               "time: {duration: 0.5}\n";
    const double t = 0.5;
    char text[2][1024];
    snprintf(text[0], sizeof text[0], half, "1");
    snprintf(text[1], sizeof text[1], whole, "2");
    solved one = solve(text[0], 1e-8, 1, &t), two = solve(text[1], 1e-8, 1, &t);
    double tip[3], middle[3];
    place(&one, 1, t, tip, 3);
    place(&two, 1, t, middle, 3);
    assert_true(fabs(tip[0]) > 0.05);
    assert_near(tip[0], middle[0], 1e-7);
    assert_near(tip[2], 1, 1e-12);
    release(&one);
    release(&two);
    double error = trained(text[0]);
    print_message("guided motion by network: %.1e\n", error);
    assert_true(error < 1e-4);
}

/* A rod whose end is rigid, as a solver takes a very stiff one; the number by network, which has
 * compliances of 0 there. */
static void test_rigid_motion(void **state)
{
    (void)state;
    static const char text[] =
        "rod: {model: cosserat, stiffness: {shear: [400, 400], axial: 1000, bending: [1, 1], "
        "torsion: 0.8}, inertia: {mass_per_length: 1, rotary: [0.01, 0.01, 0.02]}}\n"
        "segments:\n"
        "  - {length: 0.6}\n"
        "  - {length: 0.4, stiffness: {bending: [.inf, .inf], torsion: .inf, shear: [.inf, .inf], "
        "axial: .inf}}\n"
        "loads: {force: [\"20*t^2\", 0, 0]}\n"
        "time: {duration: 0.6}\n";
    const double t = 0.6;
    solved x = solve(text, 1e-6, 1, &t);
    double tip[3];
    place(&x, 1, t, tip, 3);
    assert_near(tip[0], 0.263172393, 1e-6);
    assert_near(tip[2], 0.962837847, 1e-6);
    release(&x);
}

/* A free rod on a foundation that is alike all along swings as a whole, without a strain, by
 * r = r0 + a cos(t (k/rhoA)^(1/2)): a strain of its own is as small as the initial state allows. */
static void test_founded_swing(void **state)
{
    (void)state;
    char text[1024];
    snprintf(text, sizeof text,
             MOVING "boundary: {start: {type: free}, end: {type: free}}\n"
                    "initial: {position: [0.1, 0, s], rotation: [1, 0, 0, 0]}\n"
                    "loads: {foundation: [9, 25, 4]}\ntime: {duration: 1}\nreference: solve\n",
             "1");
    const double t = 1;
    solved x = solve(text, 1e-9, 1, &t);
    double r[3];
    place(&x, 0.3, t, r, 3);
    assert_near(r[0], 0.1 * cos(3), 1e-8);
    assert_near(r[2], 0.3, 1e-10);
    release(&x);
    assert_true(trained(text) < 1e-7);
}

/* ---- beams ----------------------------------------------------------------------------------- */

/* Clamped and guided: the first root of tan b + tanh b = 0, and its mode swings by cos(b^2 t)
 * (Blevins 1979, Formulas for Natural Frequency and Mode Shape, table 8-1). */
static void test_guided_beam(void **state)
{
    (void)state;
    const double b = 2.3650203724313520;
    const double turn = (sinh(b) + sin(b)) / (cosh(b) - cos(b)), t = 0.4;
    assert_near(tan(b) + tanh(b), 0, 1e-12);
    char text[1024];
    snprintf(text, sizeof text,
             "rod: {model: euler_bernoulli, length: 1, stiffness: {bending: [1, 1]}, "
             "inertia: {mass_per_length: 1}}\n"
             "boundary: {start: {type: clamped}, end: {type: guided}}\n"
             "parameters: {b: %.17g, c: %.17g}\n"
             "beam: {initial: {deflection: \"cosh(b*s)-cos(b*s)-c*(sinh(b*s)-sin(b*s))\"}}\n"
             "time: {duration: %g}\n"
             "reference: {deflection: "
             "\"(cosh(b*s)-cos(b*s)-c*(sinh(b*s)-sin(b*s)))*cos(b^2*t)\"}\n",
             b, turn, t);
    solved x = solve(text, 1e-10, 1, &t);
    double w;
    place(&x, 1, t, &w, 1);
    double mode = cosh(b) - cos(b) - turn * (sinh(b) - sin(b));
    assert_near(w, mode * cos(b * b * t), 1e-9);
    release(&x);
    assert_true(trained(text) < 1e-6);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_columns),         cmocka_unit_test(test_rigid_half),
        cmocka_unit_test(test_guided_elastica), cmocka_unit_test(test_founded_cantilever),
        cmocka_unit_test(test_oblique),         cmocka_unit_test(test_rigid_motion),
        cmocka_unit_test(test_guided_beam),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_long_column), cmocka_unit_test(test_out_of_the_plane),
        cmocka_unit_test(test_founded_swing), cmocka_unit_test(test_guided_motion)};
    return run_with_alike(tests, alike, make_folder, remove_folder);
}
