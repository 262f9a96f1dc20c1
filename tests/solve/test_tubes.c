/* Concentric tubes at rest: against closed forms, an independent program, and the equations on the
 * tape against those in C. */
#include "fewer.h"
#include "tendon_testing.h"

#include "physics/chain/solve_members.h"
#include "physics/local/static_rod.h"
#include "physics/rod/rod_internal.h"
#include "physics/rod/rod_section.h"
#include "physics/solve/stability.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static scene rod_of(double first, double second, double torsion)
{
    scene made;
    scene_defaults(&made);
    made.rod.model = SCENE_KIRCHHOFF;
    made.rod.length = Q(1.0);
    made.rod.bending_stiffness[0] = Q(first);
    made.rod.bending_stiffness[1] = Q(second);
    made.rod.torsional_stiffness = Q(torsion);
    return made;
}

static scene_tube *add_tube(scene *given, double first, double second, double torsion,
                            const char *const curvature[3])
{
    scene_tube *tube = &given->tubes[given->tube_count++];
    tube->rod.bending_stiffness[0] = Q(first);
    tube->rod.bending_stiffness[1] = Q(second);
    tube->rod.torsional_stiffness = Q(torsion);
    set_quantities(tube->rod.rest_curvature, 3, curvature);
    return tube;
}

/* On one mesh: a path on finer ones takes its time. */
static solved solve_on(const scene *given, int nodes)
{
    ad_error error;
    const solve_settings settings = {.tolerance = 1e-10, .nodes = nodes};
    solved x;
    assert_int_equal(solution_create(given, &settings, 0, NULL, &x.solution, &x.report, &error),
                     AD_OK);
    return x;
}

/* theta, m_i of each tube at s. */
static void tubes_at(const solved *x, int count, double s, double *values)
{
    enum { FIRST = 19 };
    double all[MODEL_COLUMNS_MAX];
    ad_error error;
    assert_int_equal(solution_evaluate(x->solution, FIRST + 2 * count, 1, &s, NULL, all, &error),
                     AD_OK);
    memcpy(values, all + FIRST, 2 * (size_t)count * sizeof *values);
}

/* ---- two equal tubes: a pendulum ------------------------------------------------------------- */

static const double NU = 0.3;

/* Two equal tubes with L sqrt(c) = x, theta'' = c sin(theta), c = (1 + nu) k^2 (Dupont et al. 2010,
 * eq. 36; GJ = EI/(1 + nu)); `opposed`: curved to different sides. */
static scene pair_of(double x, double turned, bool opposed)
{
    scene given = rod_of(1, 1, 1 / (1 + NU));
    char text[2][32];
    snprintf(text[0], sizeof text[0], "%.17g", x / sqrt(1 + NU));
    snprintf(text[1], sizeof text[1], "%s%.17g", opposed ? "-" : "", x / sqrt(1 + NU));
    const char *const curved[3] = {text[0], "0", "0"}, *const other[3] = {text[1], "0", "0"};
    set_quantities(given.rod.rest_curvature, 3, curved);
    add_tube(&given, 1, 1, 1 / (1 + NU), other)->turned = Q(turned);
    return given;
}

/* cos(turned/2) = k cd(x, k), k = cos(theta(L)/2): the amplitude of the pendulum. Evaluated by
 * Jacobi's functions of scipy 1.11. The last is past half a turn, where slow turning has not
 * snapped yet. */
static void test_pendulum(void **state)
{
    (void)state;
    static const struct {
        double x, turned, tip;
    } rows[] = {{1, 0.7572202079256661, 0.5},
                {1, 2.779023887305531, 2.5},
                {2, -2.8027502334245034, -1},
                {2, 3.427204138661337, 1.8}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        scene given = pair_of(rows[i].x, rows[i].turned, false);
        solved x = solve(&given, 0, NULL, 1e-10);
        double tube[2];
        tubes_at(&x, 1, 1, tube);
        assert_near(tube[0], rows[i].tip, 1e-9); /* measured: 1e-11, for the last near the fold */
        assert_near(tube[1], 0, 1e-11);
        assert_true(x.report.estimate < 1e-9);
        solution_free(x.solution);
    }
}

/* Slowly turned by more than the S-curve has, tubes snap; its limit point is that of the closed
 * form, the largest angle of the base over all of the tip, 3.452010181781879 for x = 2 (minimised
 * numerically, flat to 1e-14). The load factor stands for the square root of the angle. */
static void test_snap(void **state)
{
    (void)state;
    const double turned = 4;
    scene given = pair_of(2, turned, false);
    solved x = solve_on(&given, 30);
    double share = x.report.limit_load * x.report.limit_load, tube[2];
    assert_true(x.report.snapped);
    /* on the way the tubes are not all of their shape: 1 - (1 - 0.929)^4 = 1 - 2.5e-5 of it */
    assert_near(turned * share, 3.452010181781879, 1e-4);
    tubes_at(&x, 1, 1, tube);
    assert_true(tube[0] > PI && tube[0] < 2 * PI); /* near the other way round */
    solution_free(x.solution);
}

/* Equal tubes bent to different sides are straight, and unstable where L sqrt(c) > pi/2; behind a
 * straight part of length b, which twists as cos(x) = b/2 x sin(x), at x = 1.2199520138379425 for
 * b = 0.6. */
static void test_bifurcation(void **state)
{
    (void)state;
    static const struct {
        double x, transmission;
        int unstable;
    } rows[] = {{0.999 * PI / 2, 0, 0},
                {1.001 * PI / 2, 0, 1},
                {3.1 * PI / 2, 0, 2},
                {0.999 * 1.2199520138379425, 0.6, 0},
                {1.001 * 1.2199520138379425, 0.6, 1}};
    for (size_t i = 0; i < FEWER(sizeof rows / sizeof *rows); i++) {
        double at[STABILITY_POINTS], values[MODEL_COLUMNS_MAX * STABILITY_POINTS];
        scene given = pair_of(rows[i].x, 0, true);
        given.tubes[0].transmission = Q(rows[i].transmission);
        solved x = solve_on(&given, 20);
        ad_error error;
        int unstable;
        assert_int_equal(stability_points(&given, at, NULL), AD_OK);
        assert_int_equal(solution_evaluate(x.solution, solution_columns(&given), STABILITY_POINTS,
                                           at, NULL, values, &error),
                         AD_OK);
        assert_near(values[STABILITY_POINTS - 1], 0, 1e-9); /* x: straight */
        assert_int_equal(stability_count(&given, values, &unstable, &error), AD_OK);
        assert_int_equal(unstable, rows[i].unstable);
        solution_free(x.solution);
    }
}

/* ---- the same as members ----------------------------------------------------------------------
 */

/* The curvature at s = 1 by the strain form. */
static solve_member solve_member_of(const scene *given, double curvature[3])
{
    const double s = 1;
    const solve_members_settings settings = {
        .tolerance = 1e-9, .threads = 1, .points = 1, .s = &s, .own_curvature = true};
    double values[SOLVE_MEMBERS_COLUMNS];
    solve_members *x;
    solve_member said;
    ad_error error;
    assert_int_equal(solve_members_create(given, &settings, &x, &error), AD_OK);
    assert_int_equal(solve_members_solve(x, 1, NULL, values, &said, &error), AD_OK);
    memcpy(curvature, values + 10, 3 * sizeof *curvature);
    solve_members_free(x);
    return said;
}

/* The rows of test_pendulum: two equal tubes have the mean of their curvatures, k cos(theta/2). The
 * last two are before and beyond the limit point of test_snap, next to which Newton's method from a
 * load that is 1e-3 less does not settle. */
static void test_member_pendulum(void **state)
{
    (void)state;
    static const struct {
        double x, turned, tip;
    } rows[] = {{1, 0.7572202079256661, 0.5},       {1, 2.779023887305531, 2.5},
                {2, -2.8027502334245034, -1},       {2, 3.427204138661337, 1.8},
                {2, 3.452010181781879 - 2e-3, NAN}, {2, 3.452010181781879 + 2e-3, NAN}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const scene given = pair_of(rows[i].x, rows[i].turned, false);
        const double k = rows[i].x / sqrt(1 + NU);
        double u[3];
        const solve_member said = solve_member_of(&given, u);
        assert_int_equal(said.end == SOLVE_MEMBER_SOLVED, i < 5);
        if (i < 4) { /* of a polynomial beyond its last point; measured: 1e-8 */
            assert_near(hypot(u[0], u[1]), k * cos(rows[i].tip / 2), 1e-7);
            assert_near(u[2], 0, 1e-7);
        }
    }
}

/* The rows of test_bifurcation: what is unstable ends on the way, where the share of the shape that
 * is reached has an x sqrt(2 a - 1) of the limit, as in test_bifurcation_load. Load steps of 1e-3
 * and pivots of iterates that are off by 1e-3 find it to some 1e-3. */
static void test_member_bifurcation(void **state)
{
    (void)state;
    static const struct {
        double x, transmission, limit; /* limit: of x */
    } rows[] = {{0.999 * PI / 2, 0, PI / 2},
                {1.001 * PI / 2, 0, PI / 2},
                {2, 0, PI / 2},
                {0.999 * 1.2199520138379425, 0.6, 1.2199520138379425},
                {1.001 * 1.2199520138379425, 0.6, 1.2199520138379425},
                {1.6, 0.6, 1.2199520138379425}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        scene given = pair_of(rows[i].x, 0, true);
        given.tubes[0].transmission = Q(rows[i].transmission);
        double u[3];
        const solve_member said = solve_member_of(&given, u);
        if (rows[i].x < rows[i].limit) {
            assert_int_equal(said.end, SOLVE_MEMBER_SOLVED);
            assert_near(hypot(u[0], u[1]), 0, 1e-9);
        } else {
            assert_int_equal(said.end, SOLVE_MEMBER_UNSTABLE);
            const double way = 2 * rod_tube_shape_share(said.load) - 1;
            assert_near(sqrt(way) * rows[i].x / rows[i].limit, 1, 2e-3);
        }
    }
}

/* Where it becomes so on the way: the shape is a share a of the way from one side to the other,
 * c = -(2 a - 1) x^2, a = 1 - (1 - load)^4. */
static void test_bifurcation_load(void **state)
{
    (void)state;
    const double x = 2, ratio = PI / (2 * x), share = (1 + ratio * ratio) / 2;
    scene given = pair_of(x, 0, true);
    solved y = solve_on(&given, WATCHED ? 20 : 30);
    assert_near(y.report.bifurcation_load, 1 - pow(1 - share, 0.25), 1e-7);
    solution_free(y.solution);
}

/* ---- an independent program ------------------------------------------------------------------ */

/* Shooting from s = 0 in a frame that does not twist, with the moment in the world and the balance
 * of moments of each tube about the tangent, by an eighth-order Runge-Kutta method to 1e-12
 * (scipy); unknown moments to 1e-14. */
static scene helical_scene(void)
{
    scene given = rod_of(1, 1.3, 0.7);
    const char *const rod[3] = {"0.8*cos(4*s)", "0.8*sin(4*s)", "0.3"},
                      *const first[3] = {"where(s-0.3,-1.5,0)", "0.5", "0"},
                      *const second[3] = {"1.2*s*(1+s)", "-0.6", "0.2"},
                      *const gravity[3] = {"0.3", "-0.2", "-0.4"},
                      *const force[3] = {"0.4", "-0.3", "0.5"},
                      *const moment[3] = {"0.1", "0.2", "-0.15"};
    set_quantities(given.rod.rest_curvature, 3, rod);
    set_quantities(given.loads.gravity, 3, gravity);
    set_quantities(given.loads.tip.force, 3, force);
    set_quantities(given.loads.tip.moment, 3, moment);
    given.end.type = SCENE_LOADED;
    given.rod.mass_per_length = Q(0.5);
    scene_tube *tube = add_tube(&given, 2.5, 2, 1.8, first);
    tube->end = Q(0.7);
    tube->turned = Q(2.0);
    tube->transmission = Q(0.4);
    tube->rod.mass_per_length = Q(0.8);
    tube = add_tube(&given, 5, 5, 4, second);
    tube->end = Q(0.45);
    tube->turned = Q(-1.3);
    tube->rod.mass_per_length = Q(1.1);
    return given;
}

static void test_helical(void **state)
{
    (void)state;
    scene given = helical_scene();
    solved x = solve(&given, 0, NULL, 1e-11);
    double pose[7], tubes[4];
    pose_at(&x, 1, 0, pose);
    assert_near(pose[0], -0.1688114553025431, 1e-11);
    assert_near(pose[1], 0.1267177828128434, 1e-11);
    assert_near(pose[2], 0.9654364243231169, 1e-11);
    tubes_at(&x, 2, 0.7, tubes);
    assert_near(tubes[0], 1.6728911255833427, 1e-11);
    tubes_at(&x, 2, 0.45, tubes);
    assert_near(tubes[2], -1.3715587342471471, 1e-11);
    tubes_at(&x, 2, 0, tubes);
    assert_near(tubes[1], -0.2262558789779209, 1e-11);
    assert_near(tubes[3], -0.0016844104535971, 1e-11);
    solution_free(x.solution);
}

static void test_follower(void **state)
{
    (void)state;
    scene given = rod_of(1, 1, 0.8);
    const char *const rod[3] = {"0.9", "0", "0"}, *const outer[3] = {"0", "1.4", "0"},
                      *const force[3] = {"0.5", "-0.4", "-0.6"};
    set_quantities(given.rod.rest_curvature, 3, rod);
    set_quantities(given.loads.tip.force, 3, force);
    given.loads.tip.frame = SCENE_FOLLOWER;
    given.end.type = SCENE_LOADED;
    scene_tube *tube = add_tube(&given, 3, 3, 2.2, outer);
    tube->end = Q(0.6);
    tube->turned = Q(-2.5);
    tube->transmission = Q(0.2);
    solved x = solve(&given, 0, NULL, 1e-11);
    double pose[7], tubes[2];
    pose_at(&x, 1, 0, pose);
    assert_near(pose[0], -0.26086225028116744, 1e-11);
    assert_near(pose[1], -0.4376978526921206, 1e-11);
    assert_near(pose[2], 0.803114538750439, 1e-11);
    tubes_at(&x, 1, 0.6, tubes);
    assert_near(tubes[0], -2.271659944139531, 1e-11);
    solution_free(x.solution);
}

/* ---- the tape -------------------------------------------------------------------------------- */

/* A state and its rates by the equations in C: on the tape what goes through it at these rates has
 * no residual there. */
static void check_tape(const scene *given, double s, double load_factor)
{
    enum { ROWS = STATIC_TUBES + 4 };
    solve_rod *rod;
    ad_error error;
    solve_section section;
    solve_rest rest;
    double along[ACTING_ALONG_MAX];
    solve_actuator actuators[SOLVE_ACTUATORS_MAX];
    double y[ROWS] = {0.1, 0.2, 0.3,  0.7, -0.1, 0.5,  0.5, -1.1, 0.9,
                      0.6, 0.3, -0.8, 0.5, 1.3,  -0.4, 2.2, 0.6},
           rate[ROWS];
    assert_int_equal(solve_rod_create(given, &rod, &error), AD_OK);
    assert_int_equal(static_rows(rod), ROWS);
    assert_int_equal(solve_rod_sections(rod, 1, &s, &section, &error), AD_OK);
    assert_int_equal(solve_rod_rest(rod, 1, &s, 0, &rest, &error), AD_OK);
    assert_int_equal(solve_rod_along(rod, 1, &s, 0, along, &error), AD_OK);
    assert_int_equal(solve_rod_actuators(rod, 1, &s, 0, actuators, &error), AD_OK);
    static_point at = {.rest = rest,
                       .acting = &rod->along,
                       .compliance = section.compliance,
                       .actuation = solve_actuation_at(rod, actuators, 0, s, load_factor),
                       .tubes = rod->tubes};
    acting_on_way(at.acting, along, load_factor, load_factor, at.numbers);
    static_rate(&at, y, rate, NULL);
    recorded r = begin(given);
    domain_place place = r.at;
    place.load_factor = ad_scalar(r.tape, load_factor);
    ad_value rows[ROWS];
    for (int i = 0; i < ROWS; i++) {
        ad_value away = ad_sub(r.s, ad_scalar(r.tape, s));
        rows[i] = ad_add(ad_scalar(r.tape, y[i]), ad_scale(away, rate[i]));
    }
    rod_state taped = {.position = ad_stack(3, rows + STATIC_R),
                       .rotation = ad_stack(4, rows + STATIC_Q),
                       .force = ad_stack(3, rows + STATIC_N),
                       .moment = ad_stack(3, rows + STATIC_M),
                       .tubes = ad_stack(4, rows + STATIC_TUBES)};
    for (int kind = ROD_STRAIN; kind <= ROD_TORSION; kind++) {
        if (rod_residual_rows(given, (rod_residual_kind)kind) == 0) {
            continue;
        }
        ad_value residual = rod_residual(given, (rod_residual_kind)kind, taped, &place);
        double t = 0, *values = evaluate_at(residual, 1, &s, &t, NULL);
        for (int i = 0; i < rod_residual_rows(given, (rod_residual_kind)kind); i++) {
            assert_near(values[i], 0, 1e-13);
        }
        free(values);
    }
    ad_tape_free(r.tape);
    solve_rod_free(rod);
}

/* With both tubes, with one, and beyond; with a tendon, too; and on the way to the load. */
static void test_tape(void **state)
{
    (void)state;
    static const double s[] = {0.2, 0.6, 0.8};
    scene given = helical_scene();
    add_tendon(&given, 0.05, 40, 3);
    for (int i = 0; i < 3; i++) {
        check_tape(&given, s[i], 1);
        check_tape(&given, s[i], 0.6);
    }
}

/* Angles, torsions and their residuals where a network says some functions of s, at the values of
 * the parameters, [OPEN_ROWS][OPEN_POINTS]; of `by` in place of them their derivatives by one. */
enum { OPEN_ROWS = 8, OPEN_POINTS = 3, OPEN_PARAMETERS = 2 };

static void open_values(const scene *open, const double *parameters, int by, double *values)
{
    static const double s[OPEN_POINTS] = {0.05, 0.4, 0.6};
    double inputs[OPEN_PARAMETERS][OPEN_POINTS];
    recorded r = begin(open);
    const ad_value p[OPEN_PARAMETERS] = {ad_input(r.tape, "a", 1), ad_input(r.tape, "b", 1)};
    ad_value says[40], rows[4];
    for (int i = 0; i < rod_network_outputs(open); i++) {
        says[i] = ad_sin(ad_add(ad_scale(r.s, 1 + 0.1 * i), ad_scalar(r.tape, 0.7 * i)));
    }
    r.at.unknowns = ad_stack(OPEN_PARAMETERS, p);
    const rod_state state = rod_ansatz(open, &r.at, ad_stack(rod_network_outputs(open), says));
    rows[0] = state.tubes;
    rows[1] = rod_residual(open, ROD_TWIST, state, &r.at);
    rows[2] = rod_residual(open, ROD_TORSION, state, &r.at);
    ad_value all = ad_stack(3, rows);
    if (by >= 0) {
        const ad_value one = ad_scalar(r.tape, 1);
        assert_int_equal(ad_directional(1, &all, 1, &p[by], &one, &all), AD_OK);
    }
    for (int i = 0; i < OPEN_PARAMETERS * OPEN_POINTS; i++) {
        inputs[i / OPEN_POINTS][i % OPEN_POINTS] = parameters[i / OPEN_POINTS];
    }
    assert_int_equal(ad_rows(all), OPEN_ROWS);
    evaluate(1, &all, OPEN_POINTS, (const double *const[]){s, inputs[0], inputs[1]}, NULL, &values);
    ad_tape_free(r.tape);
}

/* Angles and straight parts that are parameters: as their numbers, to rounding, and derivatives as
 * differences, whose step of 1e-4 leaves 1e-8 of them. */
static void test_open(void **state)
{
    (void)state;
    static const double at[OPEN_PARAMETERS] = {0.9, 0.3}, h = 1e-4;
    enum { NUMBERS = OPEN_ROWS * OPEN_POINTS };
    double values[2][NUMBERS], beside[2][NUMBERS];
    const char *const names[OPEN_PARAMETERS] = {"a", "b"};
    quantities *given = quantities_create();
    ad_error error;
    scene open = helical_scene(), member;
    for (int i = 0; i < OPEN_PARAMETERS; i++) {
        assert_int_equal(quantities_coordinate(given, names[i], &error), AD_OK);
        open.parameters[i] = (scene_parameter){.name = names[i], .high = 2};
    }
    open.parameter_count = open.unknown_count = OPEN_PARAMETERS;
    open.tubes[0].turned = quantity_formula(given, "2*a");
    open.tubes[0].transmission = quantity_formula(given, "b");
    open.tubes[1].turned = quantity_formula(given, "-1.3*a^2");
    open.tubes[1].transmission = quantity_formula(given, "b*a");
    scene_member(&open, at, &member);
    open_values(&open, at, -1, values[0]);
    open_values(&member, at, -1, values[1]);
    for (int i = 0; i < NUMBERS; i++) {
        assert_near(values[0][i], values[1][i], 1e-14);
    }
    for (int by = 0; by < OPEN_PARAMETERS; by++) {
        double largest = 0;
        open_values(&open, at, by, values[0]);
        for (int side = 0; side < 2; side++) {
            double there[OPEN_PARAMETERS] = {at[0], at[1]};
            there[by] += side ? h : -h;
            open_values(&open, there, -1, beside[side]);
        }
        for (int i = 0; i < NUMBERS; i++) {
            assert_near(values[0][i], (beside[1][i] - beside[0][i]) / (2 * h), 1e-7);
            largest = fmax(largest, fabs(values[0][i]));
        }
        assert_true(largest > 0.1);
    }
    quantities_free(given);
}

/* What a section carries and stores does not follow from the strains of the rod alone. */
static void test_section(void **state)
{
    (void)state;
    static const rod_section refused[] = {ROD_SECTION_N3, ROD_SECTION_M1, ROD_SECTION_ENERGY,
                                          ROD_SECTION_STRAIN};
    const scene given = helical_scene();
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        ad_tape *tape = ad_tape_create();
        ad_error error = {.message = ""};
        const ad_value s = ad_input(tape, "s", 1), strains = ad_input(tape, "strains", 6);
        rod_section_record(&given, refused[i], s, NULL, strains);
        assert_int_equal(ad_tape_status(tape, &error), AD_BAD_INPUT);
        assert_non_null(strstr(error.message, "tubes add"));
        ad_tape_free(tape);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_helical),
                                       cmocka_unit_test(test_follower), cmocka_unit_test(test_tape),
                                       cmocka_unit_test(test_open), cmocka_unit_test(test_section)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_bifurcation),
                                       cmocka_unit_test(test_bifurcation_load),
                                       cmocka_unit_test(test_snap),
                                       cmocka_unit_test(test_pendulum),
                                       cmocka_unit_test(test_member_pendulum),
                                       cmocka_unit_test(test_member_bifurcation)};
    return run_with_alike(tests, alike, NULL, NULL);
}
