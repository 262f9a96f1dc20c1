/* Batches of members: against the other solver, the same bits however they are dealt, and what is
 * refused. */
#include "allocations.h"
#include "fewer.h"
#include "good.h"
#include "random_numbers.h"

#include "physics/numerics/quaternion.h"
#include "physics/solve/solve.h"
#include "tools/library/cpinn.h"
#include "tools/prepare/prepare.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PARAMETERS = 5, POINTS = 11, MEMBERS = 13 };

static const double usual[PARAMETERS] = {1, 0.5, 0, 5, 1};

/* Two segments with an elbow, of which the second tapers; tendons that end mid-rod and that wind, a
 * chamber, a follower within, a body force along part of it, the weight, a force at the tip. */
#define ROBOT_OF(first, second, start, end, tip, supported, springs)                               \
    "parameters: {pull: {range: [0, 2]}, push: {range: [0, 1]}, side: {range: [-1, 1]},\n"         \
    "             weight: {range: [0, 10]}, stiff: {range: [0.7, 2]}, half: stiff/2}\n"            \
    "rod: {model: cosserat, section: {shape: circle, radius: 0.002},\n"                            \
    "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000}}\n"           \
    "segments:\n"                                                                                  \
    "  - {length: 0.1}\n"                                                                          \
    "  - {length: 0.15, turn: [0, 0.3, 0], section: {radius: \"0.002-0.004*(s-0.1)\"},\n"          \
    "     material: {youngs_modulus: 2e9*half}}\n"                                                 \
    "boundary: {start: {type: clamped, " start "}, end: {" end "}}\n"                              \
    "loads:\n" supported "  gravity: [0, weight, -2*weight]\n"                                     \
    "  force: [\"where(s-0.05, where(0.2-s, side, 0), 0)\", 0, 0]\n" tip                           \
    "  points: [{at: 0.17, force: [0.1*push, 0, 0], frame: follower}]\n"                           \
    "tendons:\n"                                                                                   \
    "  - {offset: [0.006, 0], end: 0.18, " first "}\n"                                             \
    "  - {offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], " second "}\n"                       \
    "chambers: [{offset: [0, 0.005], pressure: 5e4*push, area: 1e-5}]\n" springs

#define ROBOT_WITH(...)                     ROBOT_OF(__VA_ARGS__)
#define PULLED                              "tension: pull", "tension: 0.5*pull^2"
#define UPON                                "rotation: [0.8, 0.6, 0, 0]"
#define ROBOT(end, tip, supported, springs) ROBOT_WITH(PULLED, UPON, end, tip, supported, springs)

#define TIP "  tip: {force: [side/20, 0.05*push, 0]}\n"
static const char robot[] = ROBOT("type: loaded", TIP, "", "");

/* The same on a foundation that is softer for some, with springs within and at the tip, where one
 * pulls to somewhere else, and one that only turns. */
static const char supported[] = ROBOT(
    "type: loaded", TIP, "  foundation: [\"where(0.15-s, 3*stiff, 0)\", 2, 0]\n",
    "springs: [{at: 0.2, stiffness: [1+push, 2, 0.5]}, {at: 0.05, turning: [0.01*stiff, 0.02, "
    "0.01]},\n"
    "  {at: 0.25, stiffness: [2, 2*stiff, 1], turning: [0.005, 0, 0.01], anchor: "
    "[\"0.02+0.01*side\", 0, 0.2]}]\n");

/* Held at its end, near where it is by itself, without the loads there. */
static const char pinned[] = ROBOT("type: pinned, position: [0.05, -0.22, 0.08]", "", "", "");
static const char clamped[] =
    ROBOT("type: clamped, position: [0.045, -0.225, 0.075], rotation: [0.8, 0.58, 0.12, 0.1]", "",
          "", "");
static const char clamped_by_minus_q[] =
    ROBOT("type: clamped, position: [0.045, -0.225, 0.075], rotation: [-0.8, -0.58, -0.12, -0.1]",
          "", "", "");
static const char sliding[] =
    ROBOT("type: roller, position: [0.05, -0.22, 0.08], across: [1, 0, 0]", "", "", "");

/* With a base that turns and slides, and an end that is led. */
#define MOVED                                                                                      \
    "position: [0.1*side, 0.05*push, 0.02*weight], rotation: [0.8, 0.6, 0.1*side, 0.15*push]"
static const char moved[] = ROBOT_WITH(PULLED, MOVED, "type: loaded", TIP, "", "");
static const char moved_on_springs[] =
    ROBOT_WITH(PULLED, MOVED, "type: loaded", TIP, "  foundation: [1, 2, 0]\n",
               "springs: [{at: 0.2, stiffness: [1, 2, 0.5]}, {at: 0.05, turning: [0.01, 0.02, "
               "0.01]}]\n");
static const char led[] =
    ROBOT("type: clamped, position: [\"0.045+0.01*side\", \"-0.225-0.01*push\", 0.075], "
          "rotation: [0.8, 0.58, \"0.12+0.1*side\", 0.1]",
          "", "", "");

/* By the length of the tendons, of which one is elastic and slack in nearly half of the members, on
 * a foundation and held at the end, too. */
#define DISPLACED "displacement: 0.001*pull", "displacement: 0.0015*side, stiffness: 3000*stiff"
static const char displaced[] = ROBOT_WITH(DISPLACED, UPON, "type: loaded", TIP, "", "");
static const char slack[] =
    ROBOT_WITH("displacement: 0.001*pull", "displacement: -0.0015*side, stiffness: 3000*stiff",
               UPON, "type: loaded", TIP, "", "");
static const char displaced_on_springs[] =
    ROBOT_WITH(DISPLACED, UPON, "type: loaded", TIP, "  foundation: [1, 2, 0]\n",
               "springs: [{at: 0.2, stiffness: [1, 2, 0.5]}]\n");
static const char displaced_and_pinned[] =
    ROBOT_WITH(DISPLACED, UPON, "type: pinned, position: [0.05, -0.22, 0.08]", "", "", "");

/* With friction of tendons: of a straight one that ends within the rod, of one that winds, of both
 * with coefficients of their own; among springs, on a foundation, and held at the end. */
#define RUBBED(end, tip, supported, tendons, springs)                                              \
    "parameters: {pull: {range: [0, 2]}, push: {range: [0, 1]}, side: {range: [-1, 1]},\n"         \
    "             weight: {range: [0, 10]}, stiff: {range: [0.7, 2]}}\n"                           \
    "rod: {model: cosserat, length: 0.25, section: {shape: circle, radius: \"0.002-0.002*s\"},\n"  \
    "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000},\n"           \
    "      rest: {curvature: [0, 3, 1]}}\n"                                                        \
    "boundary: {end: {" end "}}\n"                                                                 \
    "loads:\n" supported "  gravity: [0, weight, -weight]\n" tip "tendons:\n" tendons springs
#define STRAIGHT "  - {offset: [0.006, 0], end: 0.18, tension: pull, friction: 0.4*stiff}\n"
#define WOUND                                                                                      \
    "  - {offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], tension: 0.5*pull+push, "            \
    "friction: 0.3+0.2*side}\n"
#define BOTH "  - {offset: [0.006, 0], tension: pull, friction: 0.4*stiff}\n" WOUND
static const char rubbed_straight[] = RUBBED("type: loaded", TIP, "", STRAIGHT, "");
static const char rubbed_wound[] = RUBBED("type: loaded", TIP, "", WOUND, "");
static const char rubbed[] = RUBBED("type: loaded", TIP, "", BOTH, "");
static const char rubbed_on_foundation[] =
    RUBBED("type: loaded", TIP, "  foundation: [1, 2, 0]\n", BOTH,
           "springs: [{at: 0.25, stiffness: [1, 2, 0.5]}]\n");
static const char rubbed_and_displaced[] = RUBBED(
    "type: loaded", TIP, "", "  - {offset: [0.006, 0], displacement: 0.001*pull}\n" WOUND, "");
static const char rubbed_by_length[] = RUBBED("type: loaded", TIP, "",
                                              "  - {offset: [0.006, 0], displacement: 0.001*pull, "
                                              "stiffness: 3000*stiff, friction: 0.4*stiff}\n" WOUND,
                                              "");
static const char rubbed_and_pinned[] =
    RUBBED("type: pinned, position: [0.11, 0.024, 0.21]", "", "", BOTH, "");

/* Concentric tubes that end within the rod, the inner one behind a straight part; and with a tendon
 * on a spring, with an outer tube that does not twist, and turned nearly so far that they snap. */
#define TUBED_UNDER(start, rest, turned, torsion, loads, more)                                     \
    "parameters: {pull: {range: [0, 2]}, push: {range: [0, 1]}, side: {range: [-1, 1]},\n"         \
    "             weight: {range: [0, 10]}, stiff: {range: [0.7, 2]}}\n"                           \
    "rod: {model: kirchhoff, length: 0.25, stiffness: {bending: [0.01*stiff, 0.012], "             \
    "torsion: 0.008},\n"                                                                           \
    "      inertia: {mass_per_length: 0.01}, rest: {curvature: " rest "}}\n"                       \
    "boundary: {start: {type: clamped, " start "}, end: " loads "tubes:\n"                         \
    "  - {stiffness: {bending: [\"0.02-0.02*s\", 0.02], torsion: \"0.015*stiff*(1+s)\"},\n"        \
    "     inertia: {mass_per_length: 0.02}, rest: {curvature: [4*push, \"2*s*stiff\", 0.5]},\n"    \
    "     end: 0.18, turned: " turned ", transmission: 0.05*stiff}\n"                              \
    "  - {stiffness: {bending: [0.05, 0.05], torsion: " torsion "}, rest: {curvature: [0, 3, 0]}," \
    "\n     inertia: {mass_per_length: 0.04}, end: 0.1, turned: 0.5*side}\n" more
#define LOADED                                                                                     \
    "{type: loaded}}\n"                                                                            \
    "loads:\n  gravity: [0, weight, -weight]\n"                                                    \
    "  tip: {force: [0.02*side, 0.03*push, 0], moment: [0, 0.001, 0.002*side]}\n"
#define TUBED(start, rest, turned, torsion, more)                                                  \
    TUBED_UNDER(start, rest, turned, torsion, LOADED, more)
#define RESTING "[\"where(s-0.1, 6, 0)\", 0, side]"
static const char tubes[] = TUBED(UPON, RESTING, "pull", "0.04", "");
static const char tubes_driven[] = TUBED(
    "rotation: [0.8, 0.6, 0.1*side, 0.15*push]", "[\"where(s-0.1, 6, 0)\", 0, 0.3]", "pull", "0.04",
    "tendons: [{offset: [0.003, 0], end: 0.2, tension: pull}]\n"
    "springs: [{at: 0.2, stiffness: [1, 2, 0.5]}]\n");
static const char tubes_alone[] =
    TUBED_UNDER(UPON, "[\"where(s-0.1, 6, 0)\", 0.2*weight, side]", "pull", "0.04",
                "{type: free}}\n", "tendons: [{offset: [0.003, 0], tension: pull}]\n");
static const char tubes_locked[] = TUBED(UPON, RESTING, "pull", ".inf", "");
static const char tubes_wound[] =
    TUBED(UPON, "[4, 0, 0]", "\"pi/2*pull\"", "0.04",
          "  - {stiffness: {bending: [0.08, 0.08], torsion: 0.06}, rest: {curvature: [3, 0, 0]},\n"
          "     inertia: {mass_per_length: 0.05}, turned: -pi*push, transmission: 0.1}\n");

/* Two pieces with a joint between them that are curved at rest: without loads, where each point
 * stands for itself, and with springs and a foundation, which are at rest with that shape. */
#define CURVED(more)                                                                               \
    "parameters: {pull: {range: [0, 2]}, push: {range: [0, 1]}, side: {range: [-1, 1]},\n"         \
    "             weight: {range: [0, 10]}, stiff: {range: [0.7, 2]}, half: stiff/2}\n"            \
    "rod: {model: cosserat, section: {shape: circle, radius: 0.002},\n"                            \
    "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3, density: 2000},\n"           \
    "      rest: {curvature: [side, 3, \"weight*sin(20*s)\"]}}\n"                                  \
    "segments:\n"                                                                                  \
    "  - {length: 0.1}\n"                                                                          \
    "  - {length: 0.15, turn: [0, 0.3, 0], section: {radius: \"0.002-0.004*(s-0.1)\"},\n"          \
    "     material: {youngs_modulus: 2e9*half}}\n"                                                 \
    "boundary: {start: {type: clamped, rotation: [0.8, 0.6, 0, 0]}, end: {type: free}}\n"          \
    "tendons:\n"                                                                                   \
    "  - {offset: [0.006, 0], end: 0.18, tension: pull}\n"                                         \
    "  - {offset: [\"0.005*cos(10*s)\", \"0.005*sin(10*s)\"], tension: 3*pull^2}\n"                \
    "chambers: [{offset: [0, 0.005], pressure: 5e4*push, area: 1e-5}]\n" more

static const char unloaded[] = CURVED("");
static const char curved[] = CURVED(
    "loads: {gravity: [0, weight, -2*weight], foundation: [\"where(0.15-s, 3*stiff, 0)\", 2, 0]}\n"
    "springs: [{at: 0.2, stiffness: [1+push, 2, 0.5]}, {at: 0.1, turning: [0.01, 0.02, 0.01]}]\n");

/* Of tendons alone, too, by their lengths: strains are the same all along each piece. But not of
 * members whose push is near 0.56, which are not among those that are looked at. */
static const char uniform[] =
    "parameters: {pull: {range: [0, 2]}, push: {range: [0, 1]}, side: {range: [-1, 1]},\n"
    "             weight: {range: [0, 10]}, stiff: {range: [0.7, 2]}}\n"
    "rod: {model: kirchhoff, section: {shape: circle, radius: 0.002},\n"
    "      material: {youngs_modulus: 1e9*stiff, poissons_ratio: 0.3},\n"
    "      rest: {curvature: [side, \"where(0.1 - s, 3, weight)\",\n"
    "                         \"max(0, 0.01 - abs(push - 0.56))*8000*s\"]}}\n"
    "segments: [{length: 0.1}, {length: 0.15}]\n"
    "boundary: {start: {type: clamped, rotation: [0.8, 0.6, 0, 0]}, end: {type: free}}\n"
    "tendons:\n"
    "  - {offset: [0.006, 0], end: 0.18, displacement: 0.001*pull}\n"
    "  - {offset: [-0.003, 0.005], displacement: -0.0015*side, stiffness: 3000*stiff}\n"
    "  - {offset: [-0.003, -0.005], tension: 3*push}\n";

/* Of the test that runs: its state, or the robot. */
static const char *made;

static void make(void **state)
{
    made = *state ? *state : robot;
}

/* As a file, as only files have members by name. */
static const char *file_of(const char *text)
{
    static char path[] = "/tmp/cpinn_members_XXXXXX";
    memcpy(path + strlen(path) - 6, "XXXXXX", 6);
    int descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    assert_int_equal(write(descriptor, text, strlen(text)), (ssize_t)strlen(text));
    close(descriptor);
    return path;
}

static config *read_text(const char *text, ad_error *error)
{
    config *result = NULL;
    prepare_read("family.yaml", text, 0, NULL, &result, error);
    return result;
}

static config *read_robot(void)
{
    ad_error error = {.message = ""};
    config *result = read_text(made, &error);
    if (!result) {
        fail_msg("%s", error.message);
    }
    return result;
}

static solve_members_settings settings_of(int threads, double tolerance)
{
    static double s[POINTS];
    for (int i = 0; i < POINTS; i++) {
        s[i] = 0.25 * i / (POINTS - 1);
    }
    return (solve_members_settings){.tolerance = tolerance,
                                    .threads = threads,
                                    .points = POINTS,
                                    .s = s,
                                    .own_curvature = made == uniform};
}

static void draw(double (*members)[PARAMETERS])
{
    uint64_t random = 5;
    for (int i = 0; i < MEMBERS; i++) {
        members[i][0] = random_in(&random, 0, 2);
        members[i][1] = random_in(&random, 0, 1);
        members[i][2] = random_in(&random, -1, 1);
        members[i][3] = random_in(&random, 0, 10);
        members[i][4] = random_in(&random, 0.7, 2);
    }
}

enum { NODES_MOST = 64, WIDTH_MOST = 6 };

typedef struct batch {
    double values[MEMBERS][POINTS][SOLVE_MEMBERS_COLUMNS];
    double curvature[MEMBERS * NODES_MOST * WIDTH_MOST]; /* [MEMBERS][nodes][width] */
    solve_member results[MEMBERS];
} batch;

static solve_members *create(const scene *open, int threads, double tolerance)
{
    const solve_members_settings settings = settings_of(threads, tolerance);
    solve_members *x = NULL;
    ad_error error = {.message = ""};
    assert_good(solve_members_create(open, &settings, &x, &error), &error);
    assert_true(solve_members_nodes(x) <= NODES_MOST);
    assert_int_equal(solve_members_is_unloaded(x), made == unloaded || made == tubes_alone);
    return x;
}

/* Member i is the one after `first` others, all in a ring. */
static size_t turned(size_t i, int first)
{
    return (i + (size_t)first) % MEMBERS;
}

static void draw_turned(int first, double (*members)[PARAMETERS])
{
    double drawn[MEMBERS][PARAMETERS];
    draw(drawn);
    for (size_t i = 0; i < MEMBERS; i++) {
        memcpy(members[i], drawn[turned(i, first)], sizeof drawn[0]);
    }
}

/* All of them, `first` to start with. */
static batch *solve_with(solve_members *x, int first)
{
    const size_t unknowns = solve_members_numbers(x);
    double members[MEMBERS][PARAMETERS];
    ad_error error = {.message = ""};
    batch *result = calloc(1, sizeof *result), *there = calloc(1, sizeof *there);
    assert_non_null(result);
    assert_non_null(there);
    draw_turned(first, members);
    const long before = allocations;
    assert_good(solve_members_curvature(x, MEMBERS, members[0], there->values[0][0],
                                        there->curvature, there->results, &error),
                &error);
    assert_int_equal(allocations, before);
    for (size_t i = 0; i < MEMBERS; i++) {
        const size_t to = turned(i, first);
        memcpy(result->values[to], there->values[i], sizeof there->values[i]);
        memcpy(result->curvature + to * unknowns, there->curvature + i * unknowns,
               unknowns * sizeof(double));
        result->results[to] = there->results[i];
    }
    free(there);
    return result;
}

static batch *solve(const scene *open, int threads, int first, double tolerance)
{
    solve_members *x = create(open, threads, tolerance);
    batch *result = solve_with(x, first);
    solve_members_free(x);
    return result;
}

/* The members of a robot by one thread, and their shapes: made once for all tests of it. */
typedef struct known {
    const char *made;
    double tolerance;
    config *given;
    solve_members *x;
    batch *truth;
} known;

static known every[64];

static const known *know(double tolerance)
{
    size_t i = 0;
    while (every[i].made && (every[i].made != made || every[i].tolerance != tolerance)) {
        i++;
        assert_true(i + 1 < sizeof every / sizeof *every);
    }
    if (!every[i].made) {
        config *given = read_robot();
        solve_members *x = create(&given->scene, 1, tolerance);
        every[i] = (known){made, tolerance, given, x, solve_with(x, 0)};
    }
    return &every[i];
}

static int forget(void **state)
{
    (void)state;
    for (size_t i = 0; every[i].made; i++) {
        free(every[i].truth);
        solve_members_free(every[i].x);
        config_free(every[i].given);
        every[i].made = NULL;
    }
    return 0;
}

enum { NUMBERS = SOLVE_MEMBERS_COLUMNS * POINTS };

/* Position, rotation and strains of the other solver, whose own error is 1e-9 of the length. */
static void solve_otherwise(const scene *open, const double *member, double *all)
{
    scene one;
    solution *found = NULL;
    solve_report report;
    ad_error error = {.message = ""};
    const solve_settings asked = {.tolerance = 1e-9};
    scene_member(open, member, &one);
    assert_good(solution_create(&one, &asked, 0, NULL, &found, &report, &error), &error);
    assert_near(report.load_fraction, 1, 0);
    assert_good(solution_evaluate(found, SOLVE_MEMBERS_COLUMNS, POINTS, settings_of(1, 1).s, NULL,
                                  all, &error),
                &error);
    solution_free(found);
}

static void compare(const double *all, const double *values, double tolerance)
{
    for (int c = 0; c < SOLVE_MEMBERS_COLUMNS; c++) {
        /* u in 1/m is known to its size times as much as the shape, v nearly exactly; u at the end
         * is that of a polynomial beyond its last point, and only a free end has little there */
        const double allowed = tolerance * (c < 3 ? 0.25 : c < 10 ? 3 : 300);
        for (int i = 0; i < POINTS; i++) {
            const bool at_end = c >= 10 && i == POINTS - 1 && made != robot;
            assert_near(values[i * SOLVE_MEMBERS_COLUMNS + c], all[c * POINTS + i],
                        (at_end ? 2.5 : 1) * allowed);
        }
    }
}

static void test_against_collocation(void **state)
{
    make(state);
    static const double tolerances[2] = {1e-5, 1e-8};
    double members[MEMBERS][PARAMETERS], all[NUMBERS];
    const known *found[2];
    draw(members);
    for (int k = 0; k < 2; k++) {
        found[k] = know(tolerances[k]);
        for (int i = 0; i < MEMBERS; i++) {
            assert_true(found[k]->truth->results[i].solved);
            assert_true(found[k]->truth->results[i].estimate <= tolerances[k]);
        }
    }
    for (int i = 0; i < MEMBERS; i += FARTHER(made == robot ? 3 : 7)) {
        solve_otherwise(&found[0]->given->scene, members[i], all);
        for (int k = 0; k < 2; k++) {
            compare(all, found[k]->truth->values[i][0], tolerances[k]);
        }
    }
}

/* Where strains are the same along a piece two points have them, and a member whose strains are not
 * gets a finer mesh. */
static void test_uniform(void **state)
{
    enum { PIECES = 3, FEW = 2 };
    static const double members[FEW][PARAMETERS] = {{1.5, 0.3, 0.4, 4, 1.2},
                                                    {1.5, 0.56, 0.4, 4, 1.2}};
    double all[NUMBERS], values[FEW][POINTS][SOLVE_MEMBERS_COLUMNS];
    solve_member said[FEW];
    ad_error error = {.message = ""};
    make(state);
    const known *of = know(1e-8);
    assert_int_equal(solve_members_nodes(of->x), 2 * PIECES);
    assert_good(solve_members_curvature(of->x, FEW, members[0], values[0][0], NULL, said, &error),
                &error);
    for (int i = 0; i < FEW; i++) {
        assert_true(said[i].solved);
        solve_otherwise(&of->given->scene, members[i], all);
        compare(all, values[i][0], 1e-8);
    }
    assert_int_equal(said[0].nodes, 2 * PIECES);
    assert_true(said[1].nodes > 2 * PIECES);
}

/* Derivatives of a member by differences of order 2 of members that six steps have settled. */
static void test_derivatives(void **state)
{
    enum { STEPS = 6, WIDTH = POINTS * SOLVE_MEMBERS_COLUMNS };
    static double jacobian[WIDTH][PARAMETERS], values[3][WIDTH],
        curvature[3][WIDTH_MOST * NODES_MOST];
    make(state);
    double members[MEMBERS][PARAMETERS];
    const known *of = know(1e-8);
    solve_members *x = of->x;
    ad_error error = {.message = ""};
    draw(members);
    assert_good(solve_members_refine(x, 1, members[0], of->truth->curvature, STEPS, values[0],
                                     curvature[1], NULL, &error),
                &error);
    assert_good(solve_members_jacobian(x, 1, members[0], curvature[1], 0, jacobian[0], &error),
                &error);
    for (int i = 0; i < PARAMETERS; i++) {
        const double h = 1e-4;
        for (int side = 0; side < 2; side++) {
            double there[PARAMETERS];
            memcpy(there, members[0], sizeof there);
            there[i] += side ? h : -h;
            assert_good(solve_members_refine(x, 1, there, curvature[1], STEPS, values[side],
                                             curvature[2], NULL, &error),
                        &error);
        }
        for (int k = 0; k < WIDTH; k++) { /* rotations have values of 1, curvatures of 10 */
            const double by = (values[1][k] - values[0][k]) / (2 * h);
            assert_near(jacobian[k][i], by, k % SOLVE_MEMBERS_COLUMNS < 10 ? 1e-6 : 1e-4);
        }
    }
}

/* Force and moment by the balance alone, of a rod with a load at its end and no parameter: R^T F
 * and R^T ((r(L) - r) x F + C), of its own shape. */
static void test_forces(void **state)
{
    (void)state;
    enum { AT = 3 };
    static const double s[AT] = {0, 0.3, 0.8}, F[] = {0.3, -0.2, 0.1}, C[] = {0.02, 0.05, -0.1};
    static const char text[] =
        "rod: {model: kirchhoff, length: 0.8, stiffness: {bending: [0.5, 0.4], torsion: 0.3}}\n"
        "loads: {tip: {force: [0.3, -0.2, 0.1], moment: [0.02, 0.05, -0.1]}}\n";
    const solve_members_settings settings = {1e-9, 1, AT, s, NULL, true};
    double values[AT][SOLVE_MEMBERS_COLUMNS], forces[AT][SOLVE_MEMBERS_FORCES];
    double curvature[3 * NODES_MOST];
    solve_members *x = NULL;
    solve_member said;
    ad_error error = {.message = ""};
    config *given = read_text(text, &error);
    assert_non_null(given);
    assert_good(solve_members_create(&given->scene, &settings, &x, &error), &error);
    assert_good(solve_members_curvature(x, 1, NULL, NULL, curvature, &said, &error), &error);
    assert_true(said.solved);
    assert_good(solve_members_refine(x, 1, NULL, curvature, 0, values[0], NULL, NULL, &error),
                &error);
    assert_good(solve_members_forces(x, 1, NULL, curvature, 0, NULL, forces[0], NULL, &error),
                &error);
    for (int i = 0; i < AT; i++) {
        double arm[3], M[3], n[3], m[3], R[3][3];
        for (int c = 0; c < 3; c++) {
            arm[c] = values[AT - 1][c] - values[i][c];
        }
        vector_cross(arm, F, M);
        for (int c = 0; c < 3; c++) {
            M[c] += C[c];
        }
        rotation_matrix(values[i] + 3, R);
        to_body(R, F, n);
        to_body(R, M, m);
        for (int c = 0; c < 3; c++) { /* M is a polynomial of the mesh: 3e-9 of a few tenths N m */
            assert_near(forces[i][c], n[c], 1e-14);
            assert_near(forces[i][3 + c], m[c], 1e-8);
        }
    }
    solve_members_free(x);
    config_free(given);
}

/* A rod that does not stretch is bent by a tendon beside its axis to an arc. With the angle theta =
 * y L T/EI the tendon is shorter by y theta, and that is its displacement less T/k, or it is slack.
 * One on the other side lets go of `back` times as much: of 1 exactly what it becomes longer by. */
static void test_arc(void **state)
{
    (void)state;
    enum { ENDS = 4 };
    static const double y = 0.02, EI = 0.5, stiff = 400, L = 0.8, back[] = {1, 1.2, 3};
    static const double s[2] = {0.4, 0.8}, moves[ENDS] = {0.01, 0.025, -0.01, 0};
    const solve_members_settings settings = {1e-9, 1, 2, s, NULL, true};
    for (int i = 0; i < 6; i++) {
        char text[600];
        double values[ENDS][2][SOLVE_MEMBERS_COLUMNS];
        solve_member results[ENDS];
        solve_members *x = NULL;
        ad_error error = {.message = ""};
        snprintf(text, sizeof text,
                 "parameters: {d: {range: [-0.03, 0.03]}}\n"
                 "rod: {model: kirchhoff, length: %g, stiffness: {bending: [%g, %g], torsion: 1}}\n"
                 "tendons: [{offset: [%g, 0], displacement: d%s},\n"
                 "          {offset: [-%g, 0], displacement: \"where(d, -%g*d, 0)\"}]\n",
                 L, EI, EI, y, i % 2 ? ", stiffness: 400" : "", y, back[i / 2]);
        config *given = read_text(text, &error);
        assert_non_null(given);
        assert_good(solve_members_create(&given->scene, &settings, &x, &error), &error);
        assert_good(solve_members_solve(x, ENDS, moves, values[0][0], results, &error), &error);
        for (int k = 0; k < ENDS; k++) {
            const double soft = y * y * L / EI, T = moves[k] / (soft + (i % 2 ? 1 / stiff : 0));
            const double theta = T > 0 ? y * L * T / EI : 0;
            assert_true(results[k].solved);
            for (int j = 0; j < 2; j++) {
                const double turn = theta * s[j] / L, r = theta != 0 ? L / theta : 0;
                const double place[3] = {r * (1 - cos(turn)), 0, theta != 0 ? r * sin(turn) : s[j]};
                for (int c = 0; c < 3; c++) {
                    assert_near(values[k][j][c], place[c], 1e-12);
                }
            }
        }
        solve_members_free(x);
        config_free(given);
    }
}

/* Columns above their first load, which is 2.47, bend to where an imperfection has them bend; it is
 * gone then. */
static void test_imperfect(void **state)
{
    (void)state;
    static const double s[2] = {0.5, 1};
    static const char text[] =
        "parameters: {p: {range: [2.8, 4.5]}}\n"
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 2], torsion: 1},\n"
        "      rest: {imperfection: [0.3, 0, 0]}}\n"
        "loads: {tip: {force: [0, 0, -p]}}\nboundary: {end: {type: loaded}}\n";
    const solve_members_settings settings = {1e-7, 1, 2, s, NULL, false};
    const solve_settings by_collocation = {.tolerance = 1e-8};
    ad_error error = {.message = ""};
    config *given = read_text(text, &error);
    solve_members *x = NULL;
    assert_non_null(given);
    assert_good(solve_members_create(&given->scene, &settings, &x, &error), &error);
    for (double p = 2.8; p < 4.6; p += 0.85) {
        double found[2][SOLVE_MEMBERS_COLUMNS], known[6];
        solve_report report = solve_report_blank();
        solve_member result;
        solution *made = NULL;
        scene one;
        assert_good(solve_members_solve(x, 1, &p, found[0], &result, &error), &error);
        assert_true(result.solved);
        scene_member(&given->scene, &p, &one);
        assert_good(solution_create(&one, &by_collocation, 0, NULL, &made, &report, &error),
                    &error);
        assert_good(solution_evaluate(made, 3, 2, s, NULL, known, &error), &error);
        assert_true(fabs(found[1][1]) > 0.3);
        for (int i = 0; i < 6; i++) {
            assert_near(found[i % 2][i / 2], known[i], 1e-6);
        }
        solution_free(made);
    }
    solve_members_free(x);
    config_free(given);
}

static void test_same_bits(void **state)
{
    make(state);
    config *given = read_robot();
    batch *one = solve(&given->scene, 1, 0, 1e-6), *more = solve(&given->scene, 2, 0, 1e-6);
    batch *turned = solve(&given->scene, 1, 5, 1e-6);
    assert_memory_equal(one->values, more->values, sizeof one->values);
    assert_memory_equal(one->values, turned->values, sizeof one->values);
    for (int i = 0; i < MEMBERS; i++) { /* structs have bytes that nobody writes */
        const solve_member *a = &one->results[i], *b = &more->results[i];
        assert_memory_equal(&a->estimate, &b->estimate, sizeof a->estimate);
        assert_memory_equal(&a->load, &b->load, sizeof a->load);
        assert_true(a->nodes == b->nodes && a->steps == b->steps);
        assert_true(a->solved == b->solved && a->end == b->end);
    }
    free(one);
    free(more);
    free(turned);
    config_free(given);
}

/* A column under twice Euler's load along its axis, and a side force that turns it over, is beyond
 * the path of minima that begins unstressed: it is said to be unsolved, not solved elsewhere. */
static void test_unstable(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {along: {range: [-2, 5]}}\n"
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}}\n"
        "boundary: {end: {type: loaded}}\n"
        "loads: {tip: {force: [0, 0, along]}}\n";
    const double s = 1, values[3] = {5, -2, -5};
    double shape[3][SOLVE_MEMBERS_COLUMNS];
    solve_member results[3];
    solve_members *x = NULL;
    ad_error error = {.message = ""};
    config *given = read_text(text, &error);
    assert_non_null(given);
    const solve_members_settings settings = {.tolerance = 1e-6, .threads = 1, .points = 1, .s = &s};
    assert_good(solve_members_create(&given->scene, &settings, &x, &error), &error);
    assert_good(solve_members_solve(x, 3, values, shape[0], results, &error), &error);
    assert_true(results[0].solved && results[1].solved && !results[2].solved);
    assert_near(shape[1][2], 1, 1e-14);
    assert_true(isnan(shape[2][2]) && isinf(results[2].estimate));
    assert_true(results[2].load > 0.4 && results[2].load < 0.5); /* pi^2/4 = 2.467 of 5 */
    assert_true(results[2].end == SOLVE_MEMBER_UNSTABLE && !results[1].end);
    assert_null(solve_member_text(results[1].end));
    assert_non_null(strstr(solve_member_text(results[2].end), "stable equilibria end"));
    double curvature[3][NODES_MOST] = {{0}}; /* straight is an equilibrium, also where it is none */
    solve_answer answers[3];                 /* to be found; and what is none has no equilibrium */
    const size_t unknowns = 3 * solve_members_nodes(x);
    curvature[0][unknowns] = NAN;
    assert_good(solve_members_refine(x, 3, values, curvature[0], 1, NULL, NULL, answers, &error),
                &error);
    assert_true(answers[0].trusted && answers[0].predicted < 1e-14);
    assert_true(!answers[1].trusted && answers[1].reason == SOLVE_NOT_FINITE);
    assert_true(!answers[2].trusted && answers[2].reason == SOLVE_UNSTABLE);
    solve_members_free(x);
    config_free(given);
}

/* A round rod buckles to all sides at once, and a moment in space has no energy: it goes where the
 * other solver does, not straight on, where two pivots are negative and nothing is stable. */
static void test_buckled_by_moment(void **state)
{
    (void)state;
    static const char text[] =
        "parameters: {push: {range: [0, 5]}, bend: {range: [-1, 1]}}\n"
        "rod: {model: kirchhoff, length: 0.25, stiffness: {bending: [0.0625, 0.0625], torsion: "
        "0.05}}\n"
        "boundary: {end: {type: loaded}}\n"
        "loads: {tip: {force: [-0.25, 0.08, -push], moment: [0.02*bend, 0, -0.02]}}\n";
    const double members[3][2] = {{5, -1}, {4.5, 0.3}, {3.4, 1}};
    double values[3][POINTS][SOLVE_MEMBERS_COLUMNS], all[NUMBERS];
    solve_member results[3];
    solve_members *x = NULL;
    ad_error error = {.message = ""};
    const solve_members_settings settings = settings_of(1, 1e-6);
    config *given = read_text(text, &error);
    assert_non_null(given);
    assert_good(solve_members_create(&given->scene, &settings, &x, &error), &error);
    assert_good(solve_members_solve(x, 3, members[0], values[0][0], results, &error), &error);
    for (int i = 0; i < 3; i++) {
        assert_true(results[i].solved);
        solve_otherwise(&given->scene, members[i], all);
        compare(all, values[i][0], 1e-6);
    }
    solve_members_free(x);
    config_free(given);
}

/* ---- curvature ----------------------------------------------------------------------------- */

typedef struct answers {
    double values[MEMBERS][POINTS][SOLVE_MEMBERS_COLUMNS];
    double curvature[MEMBERS][NODES_MOST][WIDTH_MOST];
    solve_answer answers[MEMBERS];
} answers;

/* Without answers the values [MEMBERS][POINTS] are the same, where the mesh resolves the shape; the
 * strain is between its points then, not of the finer mesh. */
static void check_quick(solve_members *x, const double *members, const double *curvature, int steps,
                        const double *values)
{
    enum { COUNT = MEMBERS * NUMBERS };
    double quick[COUNT];
    ad_error error = {.message = ""};
    assert_good(
        solve_members_refine(x, MEMBERS, members, curvature, steps, quick, NULL, NULL, &error),
        &error);
    for (int i = 0; i < COUNT; i++) {
        const int c = i % SOLVE_MEMBERS_COLUMNS;
        const double unit = c < 10 ? 1 : 0.25; /* of curvature */
        assert_near(unit * quick[i], unit * values[i], c >= 7 && c < 10 ? 3e-8 : 1e-9);
    }
}

/* From the curvature of each member, bent by a smooth wave of `size` over the length. */
static answers *ask(solve_members *x, const batch *truth, int first, int steps, double size)
{
    const size_t nodes = solve_members_nodes(x), width = solve_members_width(x);
    double members[MEMBERS][PARAMETERS], s[NODES_MOST], given[MEMBERS * NODES_MOST * WIDTH_MOST];
    ad_error error = {.message = ""};
    answers *result = calloc(1, sizeof *result), *there = calloc(1, sizeof *there);
    assert_non_null(result);
    assert_non_null(there);
    solve_members_places(x, s);
    assert_true(s[0] > 0 && s[nodes - 1] < 0.25);
    draw_turned(first, members);
    for (size_t i = 0; i < MEMBERS * nodes * width; i++) {
        const size_t member = turned(i / width / nodes, first), c = i % width;
        const double wave = cos(12 * s[i / width % nodes] + (double)(member + c));
        given[i] = truth->curvature[member * nodes * width + i % (nodes * width)] +
                   size / 0.25 * wave * (c == 2 ? 0.1 : 1);
    }
    assert_good(solve_members_refine(x, MEMBERS, members[0], given, steps, there->values[0][0],
                                     there->curvature[0][0], there->answers, &error),
                &error);
    if (size == 1e-2) {
        check_quick(x, members[0], given, steps, there->values[0][0]);
    }
    for (size_t i = 0; i < MEMBERS; i++) {
        const size_t to = turned(i, first);
        memcpy(result->values[to], there->values[i], sizeof there->values[i]);
        memcpy(result->curvature[to], (const double *)there->curvature + width * nodes * i,
               width * nodes * sizeof(double));
        result->answers[to] = there->answers[i];
    }
    free(there);
    return result;
}

/* Of the member that was found from its true shape. */
static double distance(const answers *found, const batch *truth, int member)
{
    const double *a = found->values[member][0], *b = truth->values[member][0];
    double result = 0;
    for (int i = 0; i < NUMBERS; i += SOLVE_MEMBERS_COLUMNS) {
        result = fmax(result, hypot(hypot(a[i] - b[i], a[i + 1] - b[i + 1]), a[i + 2] - b[i + 2]));
    }
    return result;
}

/* What is predicted is what is off, for each size of what was added and after each step; a step
 * makes of an error of 1e-3 one of its square, of a rod that slides softly more. */
static void test_predicted(void **state)
{
    make(state);
    const known *of = know(1e-8);
    solve_members *x = of->x;
    const batch *truth = of->truth;
    static const double sizes[] = {0, 1e-4, 1e-2};
    /* of a truth that is found to 1e-8: with friction 2.7e-10 are left, and 1e-11 predicted */
    const double own = made == rubbed || made == rubbed_by_length ? 3e-10 : 0;
    for (int k = 0; k < 3; k++) {
        for (int steps = -1; steps <= 2; steps++) {
            answers *found = ask(x, truth, 0, steps, sizes[k]);
            for (int i = 0; i < MEMBERS; i++) {
                const solve_answer *answer = &found->answers[i];
                const double off = distance(found, truth, i);
                assert_true(answer->trusted && answer->stable && answer->reason == 0);
                /* the mesh has 1e-8 itself */
                assert_near(answer->left, off, 0.05 * off + 2e-8);
                assert_near(answer->predicted, answer->left,
                            steps > 0 ? fmax(answer->predicted, own) : 0);
                assert_true(isnan(answer->ratio) == (steps <= 0));
                assert_true(off <=
                            (made == sliding ? 4 : 2) * 0.25 * pow(sizes[k], steps > 0 ? 2 : 1) +
                                2e-8);
            }
            free(found);
        }
    }
}

/* However far what is given is off, up to a turn of the whole rod: what is trusted is off by what
 * is said. */
static void test_trusted(void **state)
{
    make(state);
    const known *of = know(1e-8);
    solve_members *x = of->x;
    const batch *truth = of->truth;
    int trusted = 0, doubted = 0;
    for (double size = 0.03; size < 7; size *= 3) {
        for (int steps = 0; steps <= 2; steps++) {
            answers *found = ask(x, truth, 0, steps, size);
            for (int i = 0; i < MEMBERS; i++) {
                const double off = distance(found, truth, i);
                trusted += found->answers[i].trusted;
                doubted += !found->answers[i].trusted;
                if (found->answers[i].trusted) {
                    assert_near(found->answers[i].left, off, 0.3 * off + 2e-8);
                }
            }
            free(found);
        }
    }
    assert_true(trusted > MEMBERS && doubted > MEMBERS);
}

static void test_answers_same_bits(void **state)
{
    make(state);
    const known *of = know(1e-8);
    const batch *truth = of->truth;
    solve_members *y = create(&of->given->scene, 2, 1e-8);
    answers *one = ask(of->x, truth, 0, 1, 1e-2), *more = ask(y, truth, 5, 1, 1e-2);
    assert_memory_equal(one->values, more->values, sizeof one->values);
    assert_memory_equal(one->curvature, more->curvature, sizeof one->curvature);
    for (int i = 0; i < MEMBERS; i++) {
        const solve_answer *a = &one->answers[i], *b = &more->answers[i];
        assert_memory_equal(&a->predicted, &b->predicted, sizeof a->predicted);
        assert_memory_equal(&a->left, &b->left, sizeof a->left);
        assert_memory_equal(&a->ratio, &b->ratio, sizeof a->ratio);
        assert_true(a->stable == b->stable && a->trusted == b->trusted && a->reason == b->reason);
    }
    free(one);
    free(more);
    solve_members_free(y);
}

/* ---- faces and refusals -------------------------------------------------------------------- */

static void refuse(const char *text, const char *why)
{
    ad_error error = {.message = ""};
    const double s = 0.5;
    solve_members *x = NULL;
    config *given = read_text(text, &error);
    if (given) {
        solve_members_settings settings = settings_of(1, 1e-6);
        settings.points = 1;
        settings.s = &s;
        assert_int_not_equal(solve_members_create(&given->scene, &settings, &x, &error), AD_OK);
    }
    if (!strstr(error.message, why)) {
        fail_msg("%s", error.message);
    }
    config_free(given);
}

#define FAMILY                                                                                     \
    "parameters: {p: {range: [0, 1]}}\n"                                                           \
    "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}}\n"

static void test_refusals(void **state)
{
    (void)state;
    refuse(FAMILY "boundary: {end: {type: clamped, position: [0, 0, 1], "
                  "rotation_vector: [0, 0, 7]}}\ntendons: [{offset: [0.01, 0], tension: p}]\n",
           "an end turned by an angle");
    refuse(FAMILY "tendons: [{offset: [0.01, 0], tension: p, friction: 0.1},\n"
                  "          {offset: [-0.01, 0], end: 0.5, tension: p}]\n",
           "friction of a tendon where strains jump");
    refuse(FAMILY "segments: [{length: 0.5}, {length: 0.5, turn: [p, 0, 0]}]\n",
           "allowed: one number for all members");
    /* what a foundation is at rest with */
    refuse(
        "parameters: {p: {range: [0, 1]}}\n"
        "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1},\n"
        "      rest: {curvature: [\"where(s-p, 1, 0)\", 0, 0]}}\nloads: {foundation: [1, 1, 1]}\n",
        "rod.rest: a parameter moves a place");
}

/* By the file, whose numbers are one member. */
static void test_file(void **state)
{
    make(state);
    ad_error error = {.message = ""};
    cpinn_family *x = NULL;
    const solve_members_settings at = settings_of(1, 1e-7);
    const cpinn_family_settings settings = {.threads = 1, .points = at.points, .s = at.s};
    double values[POINTS][SOLVE_MEMBERS_COLUMNS], all[NUMBERS];
    cpinn_answer result;
    const char *path = file_of(made);
    assert_good(cpinn_family_file(path, 0, NULL, at.tolerance, &settings, &x, &error), &error);
    assert_good(cpinn_family_evaluate(x, NULL, 1, usual, values[0], &result, &error), &error);
    assert_true(result.trusted && result.source == CPINN_FROM_MEMBERS);
    config *given = read_robot();
    solve_otherwise(&given->scene, usual, all);
    compare(all, values[0], 1e-7);
    unlink(path);
    config_free(given);
    cpinn_family_free(x);
}

/* The n-th allocation fails: an error, and nothing is left behind. */
static void test_memory(void **state)
{
    make(state);
    config *given = read_robot();
    const solve_members_settings settings = settings_of(1, 1e-6);
    ad_status status = AD_NO_MEMORY;
    for (long n = 1; status == AD_NO_MEMORY; n += 1 + n / 4) {
        ad_error error = {.message = ""};
        solve_members *x = NULL;
        allocations = 0;
        failing_allocation = n;
        status = solve_members_create(&given->scene, &settings, &x, &error);
        failing_allocation = 0;
        assert_true(status == AD_OK || (status == AD_NO_MEMORY && !x));
        solve_members_free(x);
    }
    assert_int_equal(status, AD_OK);
    config_free(given);
}

/* A test of a robot. */
#define OF(robot, test)                                                                            \
    {                                                                                              \
#robot "_" #test, test_##test, NULL, NULL, (void *)(robot)                                 \
    }

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_answers_same_bits),
        cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_unstable),
        cmocka_unit_test(test_buckled_by_moment),
        cmocka_unit_test(test_predicted),
        cmocka_unit_test(test_trusted),
        cmocka_unit_test(test_forces),
        cmocka_unit_test(test_arc),
        OF(moved, derivatives),
        OF(moved, predicted),
        OF(moved, same_bits),
        OF(moved_on_springs, derivatives),
        OF(displaced_and_pinned, derivatives),
        OF(tubes, against_collocation),
        OF(tubes, derivatives),
        OF(tubes, predicted),
        OF(tubes, trusted),
        OF(tubes, same_bits),
        OF(tubes, answers_same_bits),
        OF(tubes, memory),
        OF(tubes_alone, against_collocation),
        OF(tubes_alone, derivatives),
        OF(tubes_alone, predicted),
        OF(tubes_alone, trusted),
        OF(tubes_driven, against_collocation),
        OF(tubes_driven, derivatives),
        OF(tubes_locked, against_collocation),
        OF(tubes_locked, derivatives),
        OF(tubes_wound, against_collocation),
        OF(tubes_wound, derivatives),
        OF(uniform, uniform),
        OF(uniform, derivatives),
        OF(uniform, trusted),
        OF(displaced, predicted),
        OF(displaced, trusted),
        OF(unloaded, predicted),
        OF(unloaded, trusted),
        OF(rubbed, against_collocation),
        OF(rubbed_and_displaced, against_collocation),
        OF(rubbed_by_length, derivatives),
        OF(rubbed_by_length, predicted),
        OF(rubbed_by_length, trusted),
        OF(rubbed, predicted),
        OF(rubbed, trusted),
        OF(rubbed, same_bits),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_file),
        cmocka_unit_test(test_memory),
        OF(displaced, memory),
    };
    const struct CMUnitTest alike[] = {
        OF(curved, against_collocation),
        OF(led, against_collocation),
        OF(led, derivatives),
        OF(moved_on_springs, against_collocation),
        OF(sliding, against_collocation),
        OF(moved, against_collocation),
        cmocka_unit_test(test_against_collocation),
        cmocka_unit_test(test_imperfect),
        OF(supported, derivatives),
        OF(pinned, derivatives),
        OF(clamped, derivatives),
        OF(sliding, derivatives),
        OF(supported, against_collocation),
        OF(supported, predicted),
        OF(pinned, predicted),
        OF(sliding, trusted),
        OF(sliding, predicted),
        OF(pinned, against_collocation),
        OF(clamped, against_collocation),
        OF(clamped, predicted),
        OF(displaced, against_collocation),
        OF(displaced_and_pinned, against_collocation),
        OF(displaced, derivatives),
        OF(displaced_on_springs, derivatives),
        OF(displaced, same_bits),
        OF(unloaded, against_collocation),
        OF(unloaded, derivatives),
        OF(unloaded, same_bits),
        OF(rubbed_by_length, against_collocation),
        OF(rubbed_and_pinned, against_collocation),
        OF(rubbed, derivatives),
        OF(rubbed_on_foundation, derivatives),
        OF(rubbed_and_pinned, derivatives),
        OF(clamped_by_minus_q, against_collocation),
        OF(rubbed_straight, against_collocation),
        OF(rubbed_wound, against_collocation),
        OF(rubbed_straight, derivatives),
        OF(displaced_on_springs, against_collocation),
        OF(rubbed_on_foundation, against_collocation),
        OF(slack, derivatives),
    };
    return run_with_alike(tests, alike, NULL, forget);
}
