/* Networks of scenes that jump along s, by the default recipe: against closed forms, against the
 * classical solver, and where they are joined. */
#include "fewer.h"
#include "near.h"

#include "cpinn.h"

#include <stdio.h>
#include <string.h>

static quantities *names;

static quantity formula(const char *text)
{
    return quantity_formula(names, text);
}

/* Along +x, d1 up along +z; length, EI and GJ 1. */
static scene along_x(void)
{
    scene rod;
    scene_defaults(&rod);
    rod.rod.model = SCENE_KIRCHHOFF;
    rod.rod.length = rod.rod.torsional_stiffness = quantity_number(1);
    for (int i = 0; i < 2; i++) {
        rod.rod.bending_stiffness[i] = quantity_number(1);
        rod.start.rotation[2 * i] = quantity_number(0);
        rod.start.rotation[2 * i + 1] = quantity_number(sqrt(0.5));
    }
    return rod;
}

static void set(quantity *vector, double x, double y, double z)
{
    const double values[3] = {x, y, z};
    for (int i = 0; i < 3; i++) {
        vector[i] = quantity_number(values[i]);
    }
}

static void load_tip(scene *rod, double x, double y, double z)
{
    rod->end.type = SCENE_LOADED;
    set(rod->loads.tip.force, x, y, z);
}

/* Of loads that follow the rod it is said whether the equilibrium is stable or flutters. */
static bool is_about_followers(const scene *rod, verdict_reason reason)
{
    bool follows = rod->loads.tip.frame == SCENE_FOLLOWER;
    for (int i = 0; i < rod->point_count; i++) {
        follows |= rod->points[i].load.frame == SCENE_FOLLOWER;
    }
    return follows && (reason == VERDICT_UNSTABLE || reason == VERDICT_STABILITY_OPEN);
}

/* Columns of the trained network at `count` places and times (NULL: at rest), values
 * [columns][count]. */
static void trained(const scene *rod, const char *columns, size_t count, const double *s,
                    const double *t, double *values)
{
    ad_error error = {AD_OK, ""};
    const cpinn_options options = {.threads = 1};
    cpinn_model *model = NULL;
    evaluator *seen = NULL;
    if (cpinn_train_scene(rod, NULL, &options, &model, &error) != AD_OK ||
        cpinn_evaluator(model, columns, &seen, &error) != AD_OK ||
        evaluator_evaluate(seen, count, s, t, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    const verdict *found = cpinn_verdict(model);
    for (int i = 0; i < found->count; i++) {
        if (!is_about_followers(rod, found->findings[i].reason)) {
            fail_msg("%s", found->findings[i].text);
        }
    }
    evaluator_free(seen);
    cpinn_free(model);
}

/* A beam's deflection, slope, shear and moment, at t where it moves. */
static void beam_agrees_with_solver(const scene *beam, double t, double tolerance)
{
    enum { PLACES = 12, COLUMNS = 4 };
    double s[PLACES], at[PLACES], network[COLUMNS * PLACES], solved[MODEL_COLUMNS_MAX * PLACES];
    ad_error error = {AD_OK, ""};
    cpinn_solution *solution = NULL;
    for (int i = 0; i < PLACES; i++) {
        s[i] = (i + 0.877) / (PLACES - 0.123);
        at[i] = t;
    }
    trained(beam, "w slope V M", PLACES, s, t > 0 ? at : NULL, network);
    if (cpinn_solve_scene(beam, 0, t > 0, &t, &solution, &error) != AD_OK ||
        cpinn_solution_evaluate(solution, PLACES, s, at, solved, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (int i = 0; i < COLUMNS * PLACES; i++) {
        assert_near(network[i], solved[i], tolerance);
    }
    cpinn_solution_free(solution);
}

/* Position and rotation at places all along the rod, between breaks. Of q and -q either will do. */
static void agrees_with_solver(const scene *rod, double tolerance)
{
    enum { PLACES = 12, POSE = 7 };
    double s[PLACES], network[POSE * PLACES], solved[MODEL_COLUMNS_MAX * PLACES];
    ad_error error = {AD_OK, ""};
    cpinn_solution *solution = NULL;
    for (int i = 0; i < PLACES; i++) {
        s[i] = (i + 0.877) / (PLACES - 0.123);
    }
    trained(rod, "x y z qw qx qy qz", PLACES, s, NULL, network);
    if (cpinn_solve_scene(rod, 1e-11, 0, NULL, &solution, &error) != AD_OK ||
        cpinn_solution_evaluate(solution, PLACES, s, NULL, solved, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (int i = 0; i < PLACES; i++) {
        double dot = 0;
        for (int k = 3; k < POSE; k++) {
            dot += network[k * PLACES + i] * solved[k * PLACES + i];
        }
        for (int k = 0; k < POSE; k++) {
            double sign = k >= 3 && dot < 0 ? -1 : 1;
            assert_near(sign * network[k * PLACES + i], solved[k * PLACES + i], tolerance);
        }
    }
    cpinn_solution_free(solution);
}

/* ---- closed forms ------------------------------------------------------------------------------
 */

/* Two circular arcs under a moment at the tip. */
static void test_two_stiffnesses(void **state)
{
    (void)state;
    static const double places[] = {1e-3, 0.4, 0.93};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        char text[64];
        double tip[2], s = 1, at = places[i], moment = 1.5, angle = moment * at / 3;
        scene rod = along_x();
        snprintf(text, sizeof text, "where(s-%.17g, 1, 3)", at);
        rod.rod.bending_stiffness[0] = rod.rod.bending_stiffness[1] = formula(text);
        rod.end.type = SCENE_LOADED;
        set(rod.loads.tip.moment, 0, -moment, 0);
        trained(&rod, "x z", 1, &s, NULL, tip);
        double end = angle + moment * (1 - at), first = 3 / moment, second = 1 / moment;
        double x = first * sin(angle) + second * (sin(end) - sin(angle));
        double z = first * (1 - cos(angle)) + second * (cos(angle) - cos(end));
        assert_near(tip[0], x, 1e-10); /* the least loss of a network is that of rounding */
        assert_near(tip[1], z, 1e-10);
    }
}

/* A cantilever of small deflection under a load q on a band [a, a + b]: the deflection at its tip
 * by the theorem of Mohr, the moment at its start. */
static void test_beam_band(void **state)
{
    (void)state;
    static const double widths[] = {0.3, 1e-3, 1e-5};
    for (size_t i = 0; i < sizeof widths / sizeof *widths; i++) {
        double a = 0.3, b = widths[i], q = 2 / b;
        double s[2] = {0, 1}, values[4];
        char text[96];
        scene beam;
        scene_defaults(&beam);
        beam.rod.model = SCENE_EULER_BERNOULLI;
        beam.rod.length = quantity_number(1);
        beam.rod.bending_stiffness[0] = beam.rod.bending_stiffness[1] = quantity_number(1);
        snprintf(text, sizeof text, "where((s-%.17g)*(%.17g-s), %.17g, 0)", a, a + b, q);
        beam.beam.force = formula(text);
        trained(&beam, "w M", 2, s, NULL, values);
        /* one element q dx at x moves the tip by x^2 (3 - x)/6 q dx */
        double c = a + b, tip = q / 6 * ((c * c * c - a * a * a) - (pow(c, 4) - pow(a, 4)) / 4);
        assert_near(values[0], 0, 0);
        assert_near(values[1], tip, 1e-10 * tip);
        assert_near(values[2], 2 * (a + b / 2), 1e-9);
        assert_near(values[3], 0, 1e-12);
    }
}

/* An elbow is where it is, without a load: exact to rounding. */
static void test_elbow(void **state)
{
    (void)state;
    double s[2] = {0.4, 1}, values[6];
    scene rod = along_x();
    rod.segment_count = 2;
    rod.segments[0].length = quantity_number(0.4);
    rod.segments[1].length = quantity_number(0.6);
    set(rod.segments[1].turn, 0, acos(0), 0); /* about d2, from d3 = +x to d1 = +z */
    trained(&rod, "x y z", 2, s, NULL, values);
    const double expected[6] = {0.4, 0.4, 0, 0, 0, 0.6};
    for (int i = 0; i < 6; i++) {
        assert_near(values[i], expected[i], 1e-12);
    }
}

/* ---- the classical solver ----------------------------------------------------------------------
 */

static void test_elbow_loaded(void **state)
{
    (void)state;
    scene rod = along_x();
    rod.segment_count = 3;
    for (int i = 0; i < 3; i++) {
        rod.segments[i].length = quantity_number(i == 1 ? 0.4 : 0.3);
    }
    set(rod.segments[1].turn, 0, 1.2, 0);
    load_tip(&rod, -1, 0, -2); /* in the plane */
    agrees_with_solver(&rod, 1e-8);
    load_tip(&rod, -1, 0.7, -2);
    set(rod.segments[2].turn, -0.5, 0.4, 0.8);
    agrees_with_solver(&rod, 1e-8);
    rod.rotation = SCENE_VECTOR;
    rod.loads.tip.frame = SCENE_FOLLOWER;
    set(rod.loads.tip.moment, 0.2, 0.1, -0.3);
    agrees_with_solver(&rod, 1e-8);
}

static void test_points(void **state)
{
    (void)state;
    scene rod = along_x();
    rod.point_count = 3;
    rod.points[0].at = quantity_number(0.25);
    set(rod.points[0].load.force, 0, 0, -3);
    rod.points[1].at = quantity_number(0.6);
    rod.points[1].load.frame = SCENE_FOLLOWER;
    set(rod.points[1].load.force, 2, 0, 0);
    rod.points[2].at = quantity_number(0.61);
    set(rod.points[2].load.moment, 0, 1, 0);
    agrees_with_solver(&rod, 1e-8); /* in a plane */
    set(rod.points[1].load.moment, 0.3, 0.2, 0.5);
    set(rod.points[2].load.moment, 0.4, 1, -0.2);
    agrees_with_solver(&rod, 1e-8);
    rod.segment_count = 2; /* a joint where something acts */
    rod.segments[0].length = quantity_number(0.6);
    rod.segments[1].length = quantity_number(0.4);
    set(rod.segments[1].turn, 0.3, 1, 0);
    agrees_with_solver(&rod, 1e-8);
}

static void test_springs_and_bodies(void **state)
{
    (void)state;
    scene rod = along_x();
    set(rod.loads.gravity, 0, 0, -1);
    rod.rod.mass_per_length = quantity_number(1);
    rod.body_count = 2;
    rod.bodies[0] = (scene_body){.at = quantity_number(0.5), .mass = quantity_number(2)};
    rod.bodies[1] = (scene_body){.at = quantity_number(1), .mass = quantity_number(1)};
    rod.spring_count = 2;
    rod.springs[0].at = quantity_number(0.8);
    set(rod.springs[0].stiffness, 0, 0, 20);
    rod.springs[1].at = quantity_number(1);
    set(rod.springs[1].turning, 3, 2, 1);
    agrees_with_solver(&rod, 1e-8);
    set(rod.springs[0].anchor, 0.8, 0.3, 0);
    set(rod.springs[0].stiffness, 5, 10, 20); /* out of the plane */
    agrees_with_solver(&rod, 1e-8);
}

/* A load of 1 on 1e-1 to 1e-4 of the length, smooth: no formula switches, nothing is overlooked. */
static void test_narrow_peak(void **state)
{
    (void)state;
    for (double width = 0.1; width > 5e-5; width /= 10) {
        char text[96];
        scene rod = along_x();
        set(rod.loads.force, 0, 0, 0);
        snprintf(text, sizeof text, "-exp(-((s-0.377)/%.3g)^2)/%.3g", width, width);
        rod.loads.force[2] = formula(text);
        agrees_with_solver(&rod, 5e-8); /* what a network that is solved stays below */
    }
}

/* Bands of loads, jumps of stiffness and of the unstressed curvature at random, dead or follower.
 */
static void test_random(void **state)
{
    (void)state;
    nn_rng rng = nn_rng_split(7, "pieces");
    for (int i = 0; i < FEWER(12); i++) {
        char text[200];
        double at[6], width = pow(10, nn_rng_between(&rng, -3, -0.5));
        for (int k = 0; k < 6; k++) {
            at[k] = nn_rng_between(&rng, 0.02, 0.98 - width);
        }
        scene rod = along_x();
        snprintf(text, sizeof text, "where((s-%.17g)*(%.17g-s), %.3g, 0)", at[0], at[0] + width,
                 nn_rng_between(&rng, -2, 2) / sqrt(width));
        set(rod.loads.force, 0, nn_rng_between(&rng, -1, 1), 0);
        rod.loads.force[0] = formula(text);
        rod.loads.force[2] = quantity_number(nn_rng_between(&rng, -1, 1));
        rod.loads.frame = i % 2 ? SCENE_FOLLOWER : SCENE_DEAD;
        snprintf(text, sizeof text, "where(s-%.17g, 1, where(s-%.17g, 2, 0.6))", fmax(at[1], at[2]),
                 fmin(at[1], at[2]));
        rod.rod.bending_stiffness[0] = rod.rod.bending_stiffness[1] = formula(text);
        snprintf(text, sizeof text, "where(s-%.17g, 0.7, -0.4)", at[3]);
        set(rod.rod.rest_curvature, 0.2, 0, 0);
        rod.rod.rest_curvature[1] = formula(text);
        rod.point_count = 1;
        rod.points[0].at = quantity_number(at[4]);
        set(rod.points[0].load.force, nn_rng_between(&rng, -1, 1), 0, nn_rng_between(&rng, -1, 1));
        agrees_with_solver(&rod, 1e-8);
    }
}

/* Ends between which some acts on the beam itself, and springs and bodies at the ends too. */
static void test_beam_places(void **state)
{
    (void)state;
    for (int model = SCENE_EULER_BERNOULLI; model <= SCENE_TIMOSHENKO; model++) {
        scene beam;
        scene_defaults(&beam);
        beam.rod.model = (scene_model)model;
        beam.rod.length = quantity_number(2);
        for (int i = 0; i < 2; i++) {
            beam.rod.bending_stiffness[i] = quantity_number(3);
            if (model == SCENE_TIMOSHENKO) {
                beam.rod.shear_stiffness[i] = quantity_number(40);
            }
        }
        beam.start.type = SCENE_PINNED;
        beam.end.type = SCENE_FREE;
        beam.beam.force = formula("s");
        beam.beam.point_count = 2;
        beam.beam.points[0].at = quantity_number(0.3);
        beam.beam.points[0].load.moment = quantity_number(0.7);
        beam.beam.points[1].at = quantity_number(1.1);
        beam.beam.points[1].load.force = quantity_number(-1.5);
        beam.spring_count = 3;
        const double places[3] = {0, 1.4, 2};
        for (int i = 0; i < 3; i++) {
            beam.springs[i].at = quantity_number(places[i]);
            set(beam.springs[i].stiffness, 0, 5 + i, 0);
            set(beam.springs[i].turning, 2 - i, 0, 0);
            set(beam.springs[i].anchor, 0, 0.1 * i, 0);
        }
        beam_agrees_with_solver(&beam, 0, 1e-9);
    }
}

/* A body at the tip and one within. */
static void test_beam_bodies(void **state)
{
    (void)state;
    scene beam;
    scene_defaults(&beam);
    beam.rod.model = SCENE_EULER_BERNOULLI;
    beam.rod.length = beam.rod.mass_per_length = quantity_number(1);
    beam.rod.bending_stiffness[0] = beam.rod.bending_stiffness[1] = quantity_number(1);
    beam.duration = quantity_number(0.5);
    beam.end.type = SCENE_FREE;
    beam.beam.force = formula("t^2*s");
    beam.body_count = 2;
    beam.bodies[0] = (scene_body){.at = quantity_number(0.6), .mass = quantity_number(0.5)};
    beam.bodies[1] = (scene_body){.at = quantity_number(1), .mass = quantity_number(1)};
    set(beam.bodies[1].inertia, 0.1, 0, 0);
    beam_agrees_with_solver(&beam, 0.5, 1e-4);
}

/* A load that comes at once at 0.2 s does from then on what it does from 0 s on. */
static void test_jump_in_time(void **state)
{
    (void)state;
    const double s[2] = {0.5, 1}, late[2] = {0.45, 0.45}, early[2] = {0.25, 0.25};
    const double before[2] = {0.2, 0.1};
    double w[2], expected[2];
    scene beam;
    scene_defaults(&beam);
    beam.rod.model = SCENE_EULER_BERNOULLI;
    beam.rod.length = beam.rod.mass_per_length = quantity_number(1);
    beam.rod.bending_stiffness[0] = beam.rod.bending_stiffness[1] = quantity_number(1);
    beam.end.type = SCENE_FREE;
    beam.duration = quantity_number(0.45);
    beam.beam.force = formula("step(t-0.2)*s");
    trained(&beam, "w", 2, s, before, w);
    assert_near(w[0], 0, 1e-13); /* at rest until then, to rounding */
    assert_near(w[1], 0, 1e-13);
    trained(&beam, "w", 2, s, late, w);
    beam.duration = quantity_number(0.25);
    beam.beam.force = formula("s");
    trained(&beam, "w", 2, s, early, expected);
    for (int i = 0; i < 2; i++) { /* what the same waves leave, 1e-5 of the deflection */
        assert_near(w[i], expected[i], 1e-5 * fabs(expected[1]));
    }
}

static int begin(void **state)
{
    (void)state;
    names = quantities_create();
    return !names;
}

static int end(void **state)
{
    (void)state;
    quantities_free(names);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_two_stiffnesses),
        cmocka_unit_test(test_beam_band),
        cmocka_unit_test(test_elbow),
        cmocka_unit_test(test_elbow_loaded),
        cmocka_unit_test(test_springs_and_bodies),
        cmocka_unit_test(test_beam_places),
        cmocka_unit_test(test_beam_bodies),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_random), cmocka_unit_test(test_narrow_peak),
        cmocka_unit_test(test_points), cmocka_unit_test(test_jump_in_time)};
    return run_with_alike(tests, alike, begin, end);
}
