/* Lengths, places and insertion that differ from member to member: members of a family against the
 * scene with its numbers written in, and derivatives by them against differences. */
#include "fewer.h"
#include "good.h"
#include "random_numbers.h"

#include "physics/chain/solve_members.h"
#include "physics/solve/solve.h"
#include "tools/prepare/prepare.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 9, MEMBERS = 6, MOST = 8, WIDTH = POINTS * SOLVE_MEMBERS_COLUMNS, NODES_MOST = 96 };

/* Two segments with an elbow, of which the second tapers; places of everything move, and formulas
 * of s go on along the rod as it is. */
static const char robot[] =
    "parameters: {first: {range: [0.08, 0.12]}, second: {range: [0.12, 0.17]},\n"
    "             fixed: {range: [0.03, 0.07]}, acts: {range: [0.13, 0.17]},\n"
    "             back: {range: [0.01, 0.02]}, pull: {range: [0.5, 1.5]}}\n"
    "rod: {model: cosserat, section: {shape: circle, radius: 0.002},\n"
    "      material: {youngs_modulus: 1e9, poissons_ratio: 0.3, density: 2000},\n"
    "      rest: {strain: [0, 0.01, 1.02], curvature: [0, \"3*cos(20*s)\", 1]}}\n"
    "segments:\n"
    "  - {length: first}\n"
    "  - {length: second, turn: [0, 0.3, 0], section: {radius: \"0.002-0.003*(s-first)\"}}\n"
    "boundary: {start: {rotation: [0.8, 0.6, 0, 0]}, end: {type: loaded}}\n"
    "loads:\n"
    "  gravity: [0, 4, -8]\n"
    "  buoyancy: 0.004\n"
    "  force: [\"where(s-0.075, 0.3*s, 0)\", 0.1, 0]\n"
    "  moment: [0, 0, 0.01]\n"
    "  magnetic: {moment: [0, 0.02, 0.1], field: [0.02, 0.01, 0]}\n"
    "  tip: {force: [0.02, 0.03, 0]}\n"
    "  points: [{at: acts, force: [0.05, 0, 0], frame: follower}]\n"
    "bodies: [{at: \"first+second-back\", mass: 0.001}]\n"
    "tendons:\n"
    "  - {offset: [0.006, 0], end: fixed, tension: pull}\n"
    "  - {offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], tension: pull/2}\n"
    "chambers: [{offset: [0, 0.005], start: \"first/5\", end: first, pressure: 4e4, area: 1e-5}]\n";

/* One piece that does not shear and only grows. */
static const char grown[] =
    "parameters: {first: {range: [0.1, 0.3]}, pull: {range: [0, 2]}}\n"
    "rod: {model: kirchhoff, length: first, section: {shape: circle, radius: 0.001},\n"
    "      material: {youngs_modulus: 5e9, poissons_ratio: 0.3, density: 2000}}\n"
    "boundary: {end: {type: free}}\n"
    "loads: {gravity: [4, 0, 0]}\n"
    "tendons: [{offset: [0.006, 0], tension: pull}]\n";

/* By the length of tendons, and with friction. */
#define PULLED(tendons)                                                                            \
    "parameters: {first: {range: [0.15, 0.3]}, pull: {range: [0.2, 1]}, turn: {range: [-1, 1]}}\n" \
    "rod: {model: cosserat, length: first, section: {shape: circle, radius: 0.002},\n"             \
    "      material: {youngs_modulus: 1e9, poissons_ratio: 0.3, density: 2000},\n"                 \
    "      rest: {curvature: [0, 3, 1]}}\n"                                                        \
    "boundary: {start: {rotation: [cos(turn), sin(turn), 0, 0], position: [turn, 0, first]},\n"    \
    "           end: {type: loaded}}\n"                                                            \
    "loads: {gravity: [0, 4, -8], tip: {force: [0.02, 0, 0]}}\n"                                   \
    "tendons:\n" tendons
static const char displaced[] =
    PULLED("  - {offset: [0.006, 0], displacement: 0.001*pull}\n"
           "  - {offset: [0, 0.006], displacement: 0.001*pull, stiffness: 3000, end: first/2}\n");
static const char rubbed[] =
    PULLED("  - {offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], tension: pull, friction: "
           "0.3}\n");

/* The last part of a robot out of a port, which stays within its first segment; one tendon ends
 * behind it. */
#define INSERTED(inserted)                                                                         \
    "parameters: {out: {range: [0.13, 0.18]}, pull: {range: [0.5, 1.5]}}\n"                        \
    "rod: {model: cosserat, section: {shape: circle, radius: 0.001}, " inserted                    \
    "      material: {youngs_modulus: 5e9, poissons_ratio: 0.3, density: 2000}}\n"
static const char inserted[] = INSERTED(
    "inserted: out,\n") "segments:\n"
                        "  - {length: 0.1}\n"
                        "  - {length: 0.1, section: {radius: 0.0008}, rest: {curvature: "
                        "[\"20*(s-0.1)\", 0, 0]}}\n"
                        "boundary: {end: {type: loaded}}\n"
                        "loads: {gravity: [4, 0, 0], tip: {force: [0, 0.01, 0]}, points: [{at: "
                        "0.01, force: [9, 0, 0]}],"
                        " force: [0, \"0.1*s\", 0]}\n"
                        "tendons:\n"
                        "  - {offset: [0.004, 0], end: 0.015, tension: 9}\n"
                        "  - {offset: [\"0.004*cos(20*s)\", \"0.004*sin(20*s)\"], tension: pull}\n"
                        "  - {offset: [0, 0.004], start: 0.005, end: 0.16, tension: pull}\n";
static const char cut[] =
    INSERTED("") "segments:\n"
                 "  - {length: \"out-0.1\"}\n"
                 "  - {length: 0.1, section: {radius: 0.0008}, rest: {curvature: "
                 "[\"20*(s+0.1-out)\", 0, 0]}}\n"
                 "boundary: {end: {type: loaded}}\n"
                 "loads: {gravity: [4, 0, 0], tip: {force: [0, 0.01, 0]}, force: [0, "
                 "\"0.1*(s+0.2-out)\", 0]}\n"
                 "tendons:\n"
                 "  - {offset: [\"0.004*cos(20*(s+0.2-out))\", \"0.004*sin(20*(s+0.2-out))\"], "
                 "tension: pull}\n"
                 "  - {offset: [0, 0.004], end: \"out-0.04\", tension: pull}\n";

/* What is to be found moves places as what is known does. */
static const char found[] =
    "parameters: {pull: {range: [0.1, 1]}, first: {identify: 0.21, range: [0.2, 0.25]},\n"
    "             back: {identify: 0.03, range: [0.02, 0.04]}}\n"
    "rod: {model: cosserat, length: first, section: {shape: circle, radius: 0.001},\n"
    "      material: {youngs_modulus: 5e9, poissons_ratio: 0.3, density: 2000}}\n"
    "boundary: {end: {type: loaded}}\n"
    "loads: {gravity: [4, 0, 0], tip: {force: [0, 0.01, 0]},\n"
    "        points: [{at: first-back, force: [0.1, 0, 0]}]}\n"
    "tendons: [{offset: [0.004, 0], tension: pull}]\n";

static config *read_text(const char *text, int count, const char *const *overrides)
{
    ad_error error = {.message = ""};
    config *result = NULL;
    assert_good(prepare_read("family.yaml", text, count, overrides, &result, &error), &error);
    return result;
}

/* ---- members of a family ------------------------------------------------------------------- */

typedef struct family {
    config *given;
    const scene *open;
    solve_members *x;
    size_t count, unknowns;
    double s[POINTS], members[MEMBERS][MOST];
    double values[MEMBERS][WIDTH], curvature[MEMBERS * NODES_MOST * 3];
} family;

static family *solve_family(const char *text, double tolerance)
{
    family *f = calloc(1, sizeof *f);
    ad_error error = {.message = ""};
    uint64_t random = 7;
    solve_member results[MEMBERS];
    double packed[MEMBERS * MOST];
    assert_non_null(f);
    f->given = read_text(text, 0, NULL);
    f->open = &f->given->scene;
    f->count = (size_t)f->open->parameter_count;
    for (int i = 0; i < POINTS; i++) {
        f->s[i] = scene_length(f->open) * i / (POINTS - 1);
    }
    for (size_t i = 0; i < MEMBERS * f->count; i++) {
        const scene_parameter *p = &f->open->parameters[i % f->count];
        packed[i] = f->members[i / f->count][i % f->count] = random_in(&random, p->low, p->high);
    }
    const solve_members_settings settings = {
        .tolerance = tolerance, .threads = 1, .points = POINTS, .s = f->s};
    assert_good(solve_members_create(f->open, &settings, &f->x, &error), &error);
    f->unknowns = 3 * solve_members_nodes(f->x);
    assert_true(f->unknowns <= 3 * NODES_MOST);
    assert_good(
        solve_members_curvature(f->x, MEMBERS, packed, f->values[0], f->curvature, results, &error),
        &error);
    for (int i = 0; i < MEMBERS; i++) {
        assert_true(results[i].solved);
    }
    return f;
}

static void free_family(family *f)
{
    solve_members_free(f->x);
    config_free(f->given);
    free(f);
}

/* A scene with the numbers of a member written in, by the other solver, at the places of the rod
 * that the family was asked for; `shift`: where its s = 0 is. */
static void compare_with(const family *f, const char *text, int member, double shift,
                         double tolerance)
{
    char lines[MOST][80];
    const char *overrides[MOST];
    double all[WIDTH], s[POINTS];
    ad_error error = {.message = ""};
    solution *found = NULL;
    solve_report report;
    for (size_t i = 0; i < f->count; i++) {
        snprintf(lines[i], sizeof lines[i], "parameters.%s=%.17g", f->open->parameters[i].name,
                 f->members[member][i]);
        overrides[i] = lines[i];
    }
    config *fixed = read_text(text, (int)f->count, overrides);
    const double length = scene_length(&fixed->scene);
    for (int i = 0; i < POINTS; i++) {
        s[i] = fmin(scene_place_at(f->open, f->members[member], f->s[i], 0) - shift, length);
    }
    assert_near(s[POINTS - 1], length, 1e-15);
    const solve_settings asked = {.tolerance = 1e-10};
    assert_good(solution_create(&fixed->scene, &asked, 0, NULL, &found, &report, &error), &error);
    assert_good(solution_evaluate(found, SOLVE_MEMBERS_COLUMNS, POINTS, s, NULL, all, &error),
                &error);
    for (int c = 0; c < SOLVE_MEMBERS_COLUMNS; c++) {
        /* u in 1/m is known to its size times as much as the shape, and at an end that is beyond
         * the last point less */
        const double allowed = tolerance * (c < 3 ? 0.25 : c < 10 ? 3 : 1000);
        for (int i = 0; i < POINTS; i++) {
            assert_near(f->values[member][i * SOLVE_MEMBERS_COLUMNS + c], all[c * POINTS + i],
                        allowed);
        }
    }
    solution_free(found);
    config_free(fixed);
}

static void test_against_fixed(void **state)
{
    static const double tolerance = 1e-8;
    family *f = solve_family(*state, tolerance);
    for (int i = 0; i < MEMBERS; i++) {
        compare_with(f, *state, i, 0, tolerance);
    }
    free_family(f);
}

/* What has come out of a port is the rod without what is behind. */
static void test_against_cut(void **state)
{
    (void)state;
    static const double tolerance = 1e-8;
    family *f = solve_family(inserted, tolerance);
    for (int i = 0; i < MEMBERS; i++) {
        compare_with(f, cut, i, 0.2 - f->members[i][0], tolerance);
    }
    free_family(f);
}

/* By differences of order 4 of members that six steps have settled: rounding over the step and the
 * step to the fourth are 1e-10 of values whose derivatives are of their size over that of the
 * parameter. */
static void test_derivatives(void **state)
{
    enum { STEPS = 6 };
    static double jacobian[WIDTH][MOST], values[4][WIDTH], curvature[2][3 * NODES_MOST];
    static const double side[4] = {-2, -1, 1, 2}, weight[4] = {1, -8, 8, -1};
    family *f = solve_family(*state, 1e-8);
    ad_error error = {.message = ""};
    double *packed = &jacobian[0][0];
    assert_good(solve_members_refine(f->x, 1, f->members[0], f->curvature, STEPS, values[0],
                                     curvature[0], NULL, &error),
                &error);
    assert_good(solve_members_jacobian(f->x, 1, f->members[0], curvature[0], 0, packed, &error),
                &error);
    for (size_t i = 0; i < f->count; i++) {
        const scene_parameter *p = &f->open->parameters[i];
        const double h = 2e-3 * (p->high - p->low);
        for (int k = 0; k < 4; k++) {
            double there[MOST];
            memcpy(there, f->members[0], sizeof there);
            there[i] += side[k] * h;
            assert_good(solve_members_refine(f->x, 1, there, curvature[0], STEPS, values[k],
                                             curvature[1], NULL, &error),
                        &error);
        }
        double largest[3] = {0};
        for (int pass = 0; pass < 2; pass++) {
            for (int j = 0; j < WIDTH; j++) {
                const int column = j % SOLVE_MEMBERS_COLUMNS, kind = column < 3    ? 0
                                                                     : column < 10 ? 1
                                                                                   : 2;
                double by = 0;
                for (int k = 0; k < 4; k++) {
                    by += weight[k] * values[k][j] / (12 * h);
                }
                if (pass == 0) {
                    largest[kind] = fmax(largest[kind], fabs(by));
                } else {
                    assert_near(packed[(size_t)j * f->count + i], by, 1e-7 * largest[kind]);
                }
            }
        }
    }
    free_family(f);
}

/* ---- motions ------------------------------------------------------------------------------- */

/* Lengths and places of a rod in motion that is straight at rest. */
static const char swings[] =
    "parameters: {first: {range: [0.2, 0.3]}, at: {range: [0.05, 0.15]}}\n"
    "rod: {model: cosserat, length: first, section: {shape: circle, radius: \"0.005*(1-s)\"},\n"
    "      material: {youngs_modulus: 1e7, poissons_ratio: 0.45, density: 1070,\n"
    "                 relaxation_time: 0.01}}\n"
    "boundary: {start: {rotation: [0, 1, 0, 1]}}\n"
    "bodies: [{at: at, mass: 0.005, inertia: [1e-6, 1e-6, 1e-6]}]\n"
    "springs: [{at: \"at/2\", stiffness: [1, 1, 1]}]\n"
    "loads: {gravity: [0, 0, -9.81], drag: 0.01, fluid: {added_mass: 0.01},\n"
    "        foundation: [0.1, 0.1, 0.1]}\n"
    "tendons: [{offset: [0.003, 0.001], end: first/1.2, tension: \"2*sin(t)^2\"}]\n"
    "initial: {velocity: [0, s, 0]}\n"
    "time: {duration: 0.1}\n";

/* The tip of a member of what scene_map has made, along another s, against that of the scene with
 * its numbers; of errors of `tolerance` each. */
static void compare_tips(const char *text, const double *member, int count,
                         const char *const *numbers, solve_method method, double tolerance)
{
    ad_error error = {.message = ""};
    config *family = read_text(text, 0, NULL), *fixed = read_text(text, count, numbers);
    scene mapped;
    scene_member(&family->scene, member, &mapped);
    const scene *of[2] = {&mapped, &fixed->scene};
    double tip[2][13];
    for (int k = 0; k < 2; k++) {
        const solve_settings asked = {.tolerance = tolerance, .method = method};
        const double end = scene_length(of[k]), t = 0.1;
        const size_t times = scene_is_dynamic(of[k]);
        solution *found = NULL;
        solve_report report;
        assert_good(solution_create(of[k], &asked, times, &t, &found, &report, &error), &error);
        assert_good(solution_evaluate(found, 13, 1, &end, times ? &t : NULL, tip[k], &error),
                    &error);
        solution_free(found);
    }
    for (int c = 0; c < 7; c++) {
        assert_near(tip[0][c], tip[1][c], 4 * tolerance);
    }
    config_free(family);
    config_free(fixed);
}

static void test_motion(void **state)
{
    (void)state;
    static const double member[2] = {0.23, 0.08};
    static const char *const numbers[2] = {"parameters.first=0.23", "parameters.at=0.08"};
    compare_tips(swings, member, 2, numbers, SOLVE_COLLOCATION, 1e-6);
    compare_tips(swings, member, 2, numbers, SOLVE_MODES, 1e-6);
}

/* ---- concentric tubes ---------------------------------------------------------------------- */

/* Pushed out and turned from behind; what is not outside is straight. */
static const char pushed[] =
    "parameters: {reach: {range: [0.2, 0.25]}, stop: {range: [0.1, 0.18]},\n"
    "             angle: {range: [0, 1.5]}}\n"
    "rod: {model: kirchhoff, length: reach, section: {shape: tube, radius: 6e-4,\n"
    "      inner_radius: 4.5e-4}, rest: {curvature: [\"40*s\", 0, 0]},\n"
    "      material: {youngs_modulus: 6e10, poissons_ratio: 0.3, density: 6450}}\n"
    "loads: {gravity: [0, 0, -9.81], tip: {force: [0, 0.1, 0]}}\n"
    "tubes:\n"
    "  - {section: {radius: \"8e-4+5e-4*s\", inner_radius: 7e-4}, rest: {curvature: [5, \"9*s\", "
    "1]},\n"
    "     material: {youngs_modulus: 6e10, poissons_ratio: 0.3, density: 6450},\n"
    "     end: stop, turned: angle, transmission: 0.28-stop}\n";

static void test_tubes(void **state)
{
    (void)state;
    static const double member[3] = {0.24, 0.11, 1.2};
    static const char *const numbers[3] = {"parameters.reach=0.24", "parameters.stop=0.11",
                                           "parameters.angle=1.2"};
    compare_tips(pushed, member, 3, numbers, SOLVE_COLLOCATION, 1e-8);
}

/* ---- what is refused ----------------------------------------------------------------------- */

static void refuse(const char *text, const char *why)
{
    ad_error error = {.message = ""};
    config *result = NULL;
    assert_int_not_equal(prepare_read("family.yaml", text, 0, NULL, &result, &error), AD_OK);
    if (!strstr(error.message, why)) {
        fail_msg("%s", error.message);
    }
}

#define ROD(more)                                                                                  \
    "parameters: {a: {range: [0.05, 0.15]}}\n"                                                     \
    "rod: {model: cosserat, section: {shape: circle, radius: 0.001}, length: 0.2, " more           \
    "material: {youngs_modulus: 5e9, poissons_ratio: 0.3, density: 2000}}\n"

static void test_refusals(void **state)
{
    (void)state;
    refuse(ROD("") "tendons: [{offset: [0.004, 0], end: a, tension: 1},\n"
                   "          {offset: [0, 0.004], end: 0.11, tension: 1}]\n",
           "places change their order");
    refuse(ROD("inserted: a, ") "tendons: [{offset: [0.004, 0], end: 0.1, tension: 1}]\n",
           "places change their order");
    refuse(ROD("inserted: 0.3, ") "loads: {tip: {force: [a, 0, 0]}}\nboundary: {end: {type: "
                                  "loaded}}\n",
           "rod.inserted");
    refuse("parameters: {e: {identify: 5e9, range: [1e9, 9e9]}}\n"
           "rod: {model: cosserat, section: {shape: circle, radius: 0.001}, length: 0.2,\n"
           "      inserted: \"0.1+0.01*t\", material: {youngs_modulus: e, poissons_ratio: 0.3,\n"
           "                                            density: 1e3}}\n"
           "loads: {force: [0.1, 0, 0]}\ntime: {duration: 1}\n",
           "rod.inserted: moves beside a parameter to be identified");
}

#define OF(robot, test)                                                                            \
    {                                                                                              \
#robot "_" #test, test_##test, NULL, NULL, (void *)(robot)                                 \
    }

int main(void)
{
    const struct CMUnitTest tests[] = {
        OF(robot, against_fixed),       OF(grown, against_fixed), OF(displaced, against_fixed),
        OF(rubbed, against_fixed),      OF(robot, derivatives),   OF(grown, derivatives),
        OF(displaced, derivatives),     OF(rubbed, derivatives),  OF(inserted, derivatives),
        OF(found, against_fixed),       OF(found, derivatives),   cmocka_unit_test(test_tubes),
        cmocka_unit_test(test_refusals)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_motion),
                                       cmocka_unit_test(test_against_cut)};
    return run_with_alike(tests, alike, NULL, NULL);
}
