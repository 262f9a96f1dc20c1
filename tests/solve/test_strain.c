/* The strain form: kinematics against closed forms, derivatives against differences, equilibria
 * against the other solver. */
#include "chain_testing.h"
#include "fewer.h"
#include "near.h"
#include "random_numbers.h"

#include "physics/chain/strain_form.h"
#include "physics/numerics/quaternion.h"
#include "physics/rod/strain.h"
#include "physics/solve/solve.h"
#include "tools/prepare/prepare.h"

#include <stdlib.h>
#include <string.h>

/* ---- kinematics ---------------------------------------------------------------------------- */

enum { ELEMENTS_MAX = 16 };

typedef void strains_at(double s, double u[3], double v[3]);

static void spread(size_t count, const double *from, lanes *to)
{
    for (size_t i = 0; i < count; i++) {
        for (int lane = 0; lane < LANES; lane++) {
            to[i][lane] = from[i];
        }
    }
}

/* The end of a rod of given strains. */
static void place(strains_at *strains, int stages, int elements, double q[4], double r[3])
{
    double edges[ELEMENTS_MAX + 1];
    strain_kind kind = {
        .stages = stages, .elements = elements, .edges = edges, .substeps = 1, .is_rigid = true};
    strain_form *x = NULL;
    ad_error error;
    for (int e = 0; e <= elements; e++) {
        edges[e] = (double)e / elements;
    }
    assert_int_equal(strain_form_create(&kind, &x, &error), AD_OK);
    for (int i = 0; i < x->nodes; i++) {
        double u[3], v[3];
        strains((i / stages + x->rule.nodes[i % stages]) / elements, u, v);
        spread(3, u, x->at[i].u);
        spread(3, v, x->at[i].v);
    }
    strain_form_place(x);
    for (int i = 0; i < 4; i++) {
        q[i] = x->edges[elements].q[i][LANES - 1];
    }
    for (int i = 0; i < 3; i++) {
        r[i] = x->edges[elements].r[i][0];
    }
    strain_form_free(x);
}

static void constant(double s, double u[3], double v[3])
{
    (void)s;
    memcpy(u, (double[]){0.6, -0.3, 0.9}, 3 * sizeof *u);
    memcpy(v, (double[]){0.1, -0.2, 1.1}, 3 * sizeof *v);
}

/* R = exp(u^), r = (1 + (1 - cos a)/a^2 u^ + (a - sin a)/a^3 u^ u^) v (Murray, Li, Sastry 1994,
 * eq. 2.36): a helix. Rotations are exact; r by four points, of a curve that turns by 1.1 rad, to
 * 1e-9. */
static void test_helix(void **state)
{
    (void)state;
    double u[3], v[3], q[4], r[3], once[3], again[3];
    constant(0, u, v);
    place(constant, 4, 1, q, r);
    const double a = sqrt(vector_dot(u, u));
    vector_cross(u, v, once);
    vector_cross(u, once, again);
    assert_near(q[0], cos(a / 2), 1e-15);
    for (int i = 0; i < 3; i++) {
        assert_near(q[1 + i], sin(a / 2) * u[i] / a, 1e-15);
        assert_near(r[i],
                    v[i] + (1 - cos(a)) / (a * a) * once[i] + (a - sin(a)) / (a * a * a) * again[i],
                    1e-8);
    }
}

static void varying(double s, double u[3], double v[3])
{
    memcpy(u, (double[]){1 + 4 * s - 3 * s * s, 5 * s * s - 2, 3 - 6 * s}, 3 * sizeof *u);
    memcpy(v, (double[]){0, 0, 1}, 3 * sizeof *v);
}

/* q' = q (0, u)/2 by 2000 steps of Runge and Kutta's method, exact to 1e-13. */
static void integrate(strains_at *strains, double q[4])
{
    enum { STEPS = 2000 };
    const double h = 1.0 / STEPS, at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1, 2, 2, 1};
    memcpy(q, (double[]){1, 0, 0, 0}, 4 * sizeof *q);
    for (int k = 0; k < STEPS; k++) {
        double sum[4] = {0}, rate[4] = {0}, u[3], v[3];
        for (int stage = 0; stage < 4; stage++) {
            double p[4];
            for (int i = 0; i < 4; i++) {
                p[i] = q[i] + h * at[stage] * rate[i];
            }
            strains((k + at[stage]) * h, u, v);
            quaternion_times_vector(p, u, rate);
            for (int i = 0; i < 4; i++) {
                rate[i] /= 2;
                sum[i] += weight[stage] * rate[i];
            }
        }
        for (int i = 0; i < 4; i++) {
            q[i] += h / 6 * sum[i];
        }
    }
}

/* A commutator of the wrong sign converges, too, at second order. */
static void test_order(void **state)
{
    (void)state;
    double exact[4], error[4], q[4], r[3], turn[4];
    integrate(varying, exact);
    for (int k = 0; k < 4; k++) { /* three points have all of u */
        place(varying, 3, 1 << k, q, r);
        quaternion_quotient(exact, q, turn);
        error[k] = 2 * sqrt(vector_dot(turn + 1, turn + 1));
    }
    for (int k = 0; k < 3; k++) {
        const double order = log2(error[k] / error[k + 1]);
        if (!(order > 5.6 && order < 7)) {
            fail_msg("order %g: errors %g, %g", order, error[k], error[k + 1]);
        }
    }
    assert_true(error[3] < 1e-7);
}

/* ---- derivatives --------------------------------------------------------------------------- */

static uint64_t random_state = 3;

static void fill(size_t count, double size, lanes *x)
{
    for (size_t i = 0; i < count; i++) {
        for (int lane = 0; lane < LANES; lane++) {
            x[i][lane] = random_in(&random_state, -size, size);
        }
    }
}

static double place_of(const strain_form *x, int node)
{
    const int e = node / x->kind.stages;
    return x->kind.edges[e] + x->width[e] * x->rule.nodes[node % x->kind.stages];
}

static void fill_points(strain_form *x)
{
    const int pulling = x->kind.actuators;
    for (int i = 0; i < x->nodes; i++) {
        strain_point *point = &x->points[i];
        fill(6, 0.2, point->rest);
        fill(6, 0.1, point->compliance);
        for (int c = 0; c < 3; c++) {
            const double u = 0.8 - 0.5 * c + (c - 0.5) * place_of(x, i);
            spread(1, &u, &x->at[i].u[c]);
        }
        fill(3, 0.5, x->at[i].push);
        point->rest[2] += 1;
        for (int c = 0; c < 6; c++) {
            point->compliance[c] += 0.5;
            if (!x->kind.shears && c < 3) {
                memset(&point->compliance[c], 0, sizeof(lanes));
            }
        }
        memcpy(x->at[i].v, point->rest, sizeof x->at[i].v);
        for (int k = 0; k < pulling; k++) {
            strain_actuator *a = &x->actuators[i * pulling + k];
            fill(4, 0.1, a->given + ACTUATOR_OFFSET); /* and slope */
            fill(1, 0.2, a->given + ACTUATOR_PULL);   /* so that none is squeezed to a point */
        }
    }
}

/* Loads at all edges, springs at so many from the second on, a joint at the second. */
static void list_jumps(const double *edges, bool follow, bool magnets, int springs,
                       solve_jumps *jumps)
{
    *jumps = (solve_jumps){.count = 3};
    for (int e = 0; e < jumps->count; e++) {
        solve_jump *at = &jumps->at[e];
        *at = (solve_jump){.s = edges[e], .turn = {1}, .first = jumps->numbers};
        acting_add(&at->acting, LAW_FORCE);
        acting_add(&at->acting, LAW_MOMENT);
        if (follow) {
            acting_add(&at->acting, LAW_FOLLOWER_FORCE);
            acting_add(&at->acting, LAW_FOLLOWER_MOMENT);
        }
        if (magnets) {
            acting_add(&at->acting, LAW_MAGNET_GRADIENT);
        }
        if (e > 0 && e <= springs) {
            acting_add(&at->acting, LAW_SPRING);
            acting_add(&at->acting, LAW_TURNING_SPRING);
        }
        if (e == 1) {
            at->turns = true;
            memcpy(at->turn, (double[]){0.8, 0, 0.6, 0}, sizeof at->turn);
        }
        jumps->numbers += at->acting.numbers;
    }
}

static void fill_end(static_end *x, const solve_end *kind)
{
    *x = (static_end){.kind = *kind,
                      .position = {0.1, 0.2, 0.9},
                      .rotation = {0.8, 0.6, 0, 0},
                      .spring = {0.5, 0.7, 0.2},
                      .upright = {1, 0, 0, 0}};
}

/* Direction k: a power of s in one component of u, or one of what else is sought. The matrix is
 * that of quadrature, which is exact for what is smooth. */
enum { SMOOTH = 12 };

static void set_direction(const strain_form *x, int k, lanes *step)
{
    const double one = 1;
    memset(step, 0, (size_t)x->unknowns * sizeof *step);
    for (int i = 0; i < x->nodes && k < SMOOTH; i++) {
        const double to = pow(place_of(x, i), k / 3);
        spread(1, &to, &step[3 * i + k % 3]);
    }
    if (k >= SMOOTH) {
        spread(1, &one, &step[x->elastic + k - SMOOTH]);
    }
}

/* Against differences of residuals, in every lane: both have errors below 1e-9. */
static void compare_directions(strain_form *x)
{
    const double length = 1e-5, way[3] = {-length, 2 * length, -length}; /* move subtracts */
    const size_t count = (size_t)x->unknowns;
    lanes *step = calloc(3 * count, sizeof *step), *before = step + count, *by = before + count;
    assert_non_null(step);
    for (int i = 0; i < 4; i++) { /* v settles */
        strain_form_shape(x);
    }
    strain_form_linearise(x);
    for (int k = 0; k < SMOOTH + x->unknowns - x->elastic; k++) {
        set_direction(x, k, step);
        strain_form_apply(x, step, by);
        for (int side = 0; side < 3; side++) { /* there, on the other side, and back */
            lanes share;
            spread(1, &way[side], &share);
            strain_form_move(x, step, &share);
            strain_form_shape(x);
            for (size_t i = 0; side == 0 && i < count; i++) {
                before[i] = x->right[i];
            }
            for (size_t i = 0; side == 1 && i < count; i++) {
                for (int lane = 0; lane < LANES; lane++) {
                    const double change = (before[i][lane] - x->right[i][lane]) / (2 * length);
                    if (!(fabs(change - by[i][lane]) < 1e-8)) {
                        fail_msg("row %zu, direction %d, lane %d: %.9g, by differences %.9g", i, k,
                                 lane, by[i][lane], change);
                    }
                }
            }
        }
    }
    free(step);
}

/* What elimination finds, once and for another right side, gives that back. */
static void check_elimination(strain_form *x)
{
    const size_t count = (size_t)x->unknowns;
    lanes *right = calloc(2 * count, sizeof *right), *back = right + count;
    assert_non_null(right);
    strain_form_linearise(x);
    for (int k = 0; k < x->tension_count; k++) { /* none becomes slack */
        x->tensions[k].pull += 1000;
    }
    for (int again = 0; again < 2; again++) {
        fill(count, 1 + again, x->right);
        memcpy(right, x->right, count * sizeof *right);
        (again ? strain_form_solve_again : strain_form_solve)(x);
        strain_form_apply(x, x->right, back);
        for (size_t i = 0; i < count * LANES; i++) {
            assert_near(back[i / LANES][i % LANES], right[i / LANES][i % LANES], 1e-11);
        }
    }
    free(right);
}

/* Laws along the rod, a foundation first. */
enum { FOUNDED = 1, TURNED = 2, MAGNETISED = 4, GRADIENT = 8 };

static acting laws_along(int which)
{
    acting along = {.count = 0};
    if (which & FOUNDED) {
        acting_add(&along, LAW_SPRING);
    }
    acting_add(&along, LAW_FORCE);
    acting_add(&along, LAW_MOMENT);
    if (which & TURNED) {
        acting_add(&along, LAW_FOLLOWER_FORCE);
        acting_add(&along, LAW_FOLLOWER_MOMENT);
    }
    if (which & MAGNETISED) {
        acting_add(&along, LAW_MAGNET);
    }
    if (which & GRADIENT) {
        acting_add(&along, LAW_MAGNET_GRADIENT);
    }
    return along;
}

static void check_derivatives(strain_kind kind, int which, int springs, bool follow)
{
    static const double edges[3] = {0, 0.4, 1};
    const bool by_length = kind.seeks_tensions;
    const solve_extent extents[3] = {{.end = 1},
                                     {.end = 1, .law = LAW_CHAMBER},
                                     {.end = 1, .has_length = by_length, .compliance = 0.1}};
    static const double spring[16] = {0.1, 0.2, 0.3, 1, 2, 3, 0, 0.1, 0, /* shift, k, place */
                                      0.4, 0.4, 0.4, 1};                 /* k, upright */
    solve_jumps jumps;
    const acting along = laws_along(which);
    list_jumps(edges, follow, which & GRADIENT, springs, &jumps);
    strain_form *x = NULL;
    ad_error error;
    kind.stages = 12;
    kind.elements = 2;
    kind.edges = edges;
    kind.extents = extents;
    kind.substeps = STRAIN_SUBSTEPS_MAX;
    kind.along = &along;
    kind.jumps = &jumps;
    assert_int_equal(strain_form_create(&kind, &x, &error), AD_OK);
    fill_points(x);
    fill_end(&x->last, &kind.end);
    spread(3, x->last.position, x->held_r);
    spread(4, x->last.rotation, x->held_q);
    fill(x->force_at >= 0 ? 3 : 0, 1, x->end_force);
    fill(x->moment_at >= 0 ? 3 : 0, 1, x->end_moment);
    for (int k = 0; k < x->tension_count; k++) {
        fill(1, 0.2, &x->tensions[k].pull);
    }
    fill(3, 1, x->start_r);
    strain_form_set_jumps(x);
    fill((size_t)jumps.numbers, 1, x->numbers);
    for (int k = 0; k < springs; k++) {
        const solve_jump *at = &jumps.at[1 + k];
        spread(16, spring, x->numbers + at->first + at->acting.numbers - 16);
        fill(3, 1, x->places[1 + k].force);
    }
    fill((size_t)(x->nodes * along.numbers), 1, x->along);
    for (int i = 0; i < x->nodes && which & FOUNDED; i++) {
        spread((size_t)law_table[LAW_SPRING].numbers, spring, x->along + i * along.numbers);
    }
    strain_form_load(x);

    compare_directions(x);
    check_elimination(x);
    strain_form_free(x);
}

static void test_derivatives(void **state)
{
    (void)state;
    const solve_end clamped = {.hold = {.directions = 3}, .holds_rotation = true};
    const solve_end rail = {.hold = {.directions = 1, .axis = {0, 0.6, 0.8}}};
    const solve_end wall = {.hold = {.directions = 2, .axis = {1, 0, 0}}};
    check_derivatives((strain_kind){.shears = false}, 0, 0, false);
    check_derivatives((strain_kind){.shears = true, .actuators = 3}, 0, 0, false);
    check_derivatives((strain_kind){.shears = false, .actuators = 3}, TURNED, 0, true);
    check_derivatives((strain_kind){.shears = true}, TURNED, 0, true);
    check_derivatives((strain_kind){.shears = true, .actuators = 3, .seeks_tensions = true}, 0, 0,
                      false);
    check_derivatives((strain_kind){.actuators = 3, .seeks_tensions = true}, TURNED, 0, true);
    check_derivatives(
        (strain_kind){.shears = true, .actuators = 3, .seeks_tensions = true, .end = clamped},
        FOUNDED | GRADIENT, 2, true);
    check_derivatives((strain_kind){.shears = true, .end = clamped}, 0, 0, false);
    check_derivatives((strain_kind){.shears = false}, MAGNETISED, 0, false);
    check_derivatives((strain_kind){.shears = true, .actuators = 3}, MAGNETISED | GRADIENT, 0,
                      false);
    check_derivatives((strain_kind){.shears = true, .actuators = 2, .end = rail},
                      FOUNDED | TURNED | GRADIENT, 2, true);
    check_derivatives((strain_kind){.end = wall}, FOUNDED | TURNED, 1, true);
}

/* ---- equilibria ---------------------------------------------------------------------------- */

enum { POINTS = 21, COLUMNS = 19 };

/* Positions and rotations of both to within ten times the tolerance of the members, as loads that
 * are hundreds of EI/L^2 amplify what is left. */
static void check_against_collocation(const char *path, const char *override)
{
    ad_error error = {.message = ""};
    config *settings = NULL;
    solution *found = NULL;
    solve_report report;
    const solve_settings asked = {.tolerance = 1e-10};
    double s[POINTS], values[COLUMNS * POINTS], members[POINTS * SOLVE_MEMBERS_COLUMNS];
    if (prepare_read(path, NULL, override != NULL, &override, &settings, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    const double length = scene_length(&settings->scene);
    for (int i = 0; i < POINTS; i++) {
        s[i] = length * i / (POINTS - 1);
    }
    if (solution_create(&settings->scene, &asked, 0, NULL, &found, &report, &error) != AD_OK ||
        solution_evaluate(found, COLUMNS, POINTS, s, NULL, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_near(report.load_fraction, 1, 0);
    solve_by_chain(&settings->scene, 1e-7, POINTS, s, members);
    for (int k = 0; k < 7 * POINTS; k++) {
        const double other = members[k % POINTS * SOLVE_MEMBERS_COLUMNS + k / POINTS];
        if (!(fabs(values[k] - other) <= 1e-6 * (k < 3 * POINTS ? length : 1))) {
            fail_msg("%s, column %d: %.15g, %.15g", path, k / POINTS, values[k], other);
        }
    }
    solution_free(found);
    config_free(settings);
}

/* Those of the library that are at rest and that members of families are solved like. */
static void test_against_collocation(void **state)
{
    (void)state;
    static const char *const scenes[] = {"elastica",
                                         "heavy_cantilever",
                                         "helix",
                                         "rollup",
                                         "cases/bend_45",
                                         "cases/buckled_1",
                                         "cases/buckled_2",
                                         "cases/elastica_10",
                                         "cases/elastica_50",
                                         "cases/follower_25",
                                         "cases/follower_5",
                                         "cases/heavy_25",
                                         "cases/rollup_2",
                                         "cases/shear_stretch",
                                         "cases/tapered",
                                         "robots/catheter_routed_tendon",
                                         "robots/soft_arm_three_chambers",
                                         "robots/tendon_one_segment",
                                         "robots/tendon_pulled",
                                         "robots/tendon_two_segments"};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i += FARTHER(1)) {
        char path[100];
        snprintf(path, sizeof path, "configs/%s.yaml", scenes[i]);
        check_against_collocation(path, NULL);
    }
    check_against_collocation("configs/robots/tendon_one_segment.yaml", "tendons[0].friction=0.3");
    check_against_collocation("configs/heavy_cantilever.yaml", /* between points of usual meshes */
                              "loads.force=['1000*exp(-((s-0.3137)/1.2e-3)^2)', 0, "
                              "'500*exp(-((s-0.7412)/1.2e-3)^2)']");
}

/* At these values of the parameter, 3 of them. */
static void check_narrow(const char *const overrides[4], const double *at)
{
    static const double tip = 1;
    ad_error error = {.message = ""};
    config *settings = NULL;
    solve_members *members = NULL;
    const solve_members_settings asked = {.tolerance = 1e-7, .threads = 1, .points = 1, .s = &tip};
    const char *const path = "configs/heavy_cantilever.yaml";
    if (prepare_read(path, NULL, 4, overrides, &settings, &error) != AD_OK ||
        solve_members_create(&settings->scene, &asked, &members, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (size_t i = 0; i < 3; i++) {
        double values[SOLVE_MEMBERS_COLUMNS], expected[3];
        scene one;
        solve_member result;
        solution *found = NULL;
        solve_report report;
        assert_int_equal(solve_members_solve(members, 1, &at[i], values, &result, NULL), AD_OK);
        scene_member(&settings->scene, &at[i], &one);
        const solve_settings alone = {.tolerance = 1e-10};
        assert_int_equal(solution_create(&one, &alone, 0, NULL, &found, &report, NULL), AD_OK);
        assert_int_equal(solution_evaluate(found, 3, 1, &tip, NULL, expected, NULL), AD_OK);
        for (int k = 0; k < 3 && result.solved; k++) {
            assert_near(values[k], expected[k], 1e-6);
        }
        solution_free(found);
    }
    solve_members_free(members);
    config_free(settings);
}

/* A narrow load, whose place is a parameter or the length of whose rod is: the mesh of all members
 * sees it wherever it is, or there is none. Without, no point of the coarse meshes had it, and the
 * estimate of what was 0.16 m off was rounding. */
static void test_moving(void **state)
{
    (void)state;
    const char *overrides[] = {"parameters={a: {range: [0.2, 0.8]}}",
                               "loads.force=['25*exp(-((s-a)/0.02)^2)', 0, 0]", "reference=null",
                               "rod.length=1"};
    const char *grown[] = {"parameters={a: {range: [0.9, 1.1]}}",
                           "loads.force=['125*exp(-((s-0.5)/0.004)^2)', 0, 0]", "reference=null",
                           "rod.length=a"};
    check_narrow(overrides, (double[]){0.31, 0.5, 0.6537});
    check_narrow(grown, (double[]){0.91, 1, 1.0537});
    overrides[1] = "loads.force=['500*exp(-((s-a)/0.001)^2)', 0, 0]";
    config *settings;
    assert_int_equal(
        prepare_read("configs/heavy_cantilever.yaml", NULL, 4, overrides, &settings, NULL), AD_OK);
    assert_int_equal(strain_takes(&settings->scene, NULL), AD_BAD_ARGUMENT);
    config_free(settings);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_helix),       cmocka_unit_test(test_order),
        cmocka_unit_test(test_derivatives), cmocka_unit_test(test_against_collocation),
        cmocka_unit_test(test_moving),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
