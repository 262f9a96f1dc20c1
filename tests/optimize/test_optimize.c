/* Optimisation: formulas over shapes with their derivatives, and optima that are known in closed
 * form. Shapes are made up: columns of a rod's that depend on parameters by polynomials, so that
 * what is found is told from what is solved. */
#include "near.h"
#include "physics/chain/solve_members.h"
#include "temporary_folder.h"
#include "tools/library/trained_family.h"
#include "tools/optimize/optimize_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = SOLVE_MEMBERS_COLUMNS, COUNT = 3 };

/* Position s (a, b, a b), curvature (a s, b s, c), the rest 0 or 1, for parameters a, b, c. */
static void shape_at(const double *p, double s, double *value, double *by)
{
    memset(value, 0, COLUMNS * sizeof *value);
    memset(by, 0, COLUMNS * COUNT * sizeof *by);
    value[3] = value[9] = 1;
    const double rows[6] = {s * p[0], s * p[1], s * p[0] * p[1], s * p[0], s * p[1], p[2]};
    const double slopes[6][COUNT] = {{s}, {0, s}, {s * p[1], s * p[0]}, {s}, {0, s}, {0, 0, 1}};
    const int column[6] = {0, 1, 2, 10, 11, 12};
    for (int i = 0; i < 6; i++) {
        value[column[i]] = rows[i];
        memcpy(by + column[i] * COUNT, slopes[i], sizeof slopes[i]);
    }
}

typedef struct made_up {
    const double *s;
    size_t points;
    double beyond; /* members with a larger a have no equilibrium */
} made_up;

static ad_status solve(void *of, size_t members, const double *parameters, double *values,
                       double *jacobian, bool *solved, ad_error *error)
{
    const made_up *m = of;
    (void)error;
    for (size_t i = 0; i < members; i++) {
        solved[i] = parameters[i * COUNT] <= m->beyond;
        for (size_t j = 0; j < m->points; j++) {
            const size_t at = (i * m->points + j) * COLUMNS;
            double by[COLUMNS * COUNT];
            shape_at(parameters + i * COUNT, m->s[j], values + at, by);
            if (jacobian) {
                memcpy(jacobian + at * COUNT, by, sizeof by);
            }
        }
    }
    return AD_OK;
}

static scene family_of(void)
{
    scene of;
    scene_defaults(&of);
    of.rod.length = quantity_number(2);
    of.parameter_count = COUNT;
    of.parameters[0] = (scene_parameter){"a", -2, 2, SCENE_LINEAR};
    of.parameters[1] = (scene_parameter){"b", 0.1, 10, SCENE_LOG};
    of.parameters[2] = (scene_parameter){"c", -1, 1, SCENE_LINEAR};
    return of;
}

/* ---- formulas ------------------------------------------------------------------------------ */

enum { POINTS = 6 };
static const double places[POINTS] = {0, 0.5, 1.25, 1.5, 1.75, 2};

static size_t value_of(response *r, const double *p, double *values, double *by)
{
    double shape[POINTS * COLUMNS], jacobian[POINTS * COLUMNS * COUNT];
    const double columns[1] = {0.75};
    const size_t place[2] = {POINTS - 1, 1};
    for (size_t j = 0; j < POINTS; j++) {
        shape_at(p, places[j], shape + j * COLUMNS, jacobian + j * COLUMNS * COUNT);
    }
    const response_shape at = {.points = POINTS,
                               .place = place,
                               .values = shape,
                               .jacobian = jacobian,
                               .parameters = p,
                               .columns = columns};
    ad_error error;
    assert_int_equal(response_evaluate(r, &at, values, by, &error), AD_OK);
    return response_rows(r);
}

static const environment *around; /* of clearances, for a robot of radius 0.25 */

static response *make_of(const scene *family, const char *text, ad_error *error)
{
    static const char *const parameter[] = {"a", "b", "c"}, *const column[] = {"goal"};
    static const char *const place[] = {"tip", "middle"};
    static const double at[] = {2, 0.5};
    const response_scope scope = {family, COUNT,  1,      2,    parameter, column, place,
                                  at,     places, around, 0.25, false,     0};
    response *r = NULL;
    response_create(text, &scope, POINTS, &r, error);
    return r;
}

static response *make(const char *text, ad_error *error)
{
    const scene family = family_of();
    return make_of(&family, text, error);
}

/* Derivatives of the last row against differences of fourth order: off by the step to the fourth
 * times fifth derivatives, and by rounding of values over it. */
static void assert_derivatives(response *r, const double *p, double tolerance)
{
    static const double weight[4] = {1, -8, 8, -1}, way[4] = {-2, -1, 1, 2};
    double values[POINTS], by[POINTS * COUNT], moved[COUNT];
    const size_t last = value_of(r, p, values, by) - 1;
    for (int k = 0; k < COUNT; k++) {
        const double step = 1e-3;
        double slope = 0;
        for (int i = 0; i < 4; i++) {
            memcpy(moved, p, sizeof moved);
            moved[k] += way[i] * step;
            value_of(r, moved, values, NULL);
            slope += weight[i] * values[last] / (12 * step);
        }
        assert_near(by[last * COUNT + (size_t)k], slope, tolerance);
    }
}

/* Values against the same written here. */
static void formulas_have_values_and_derivatives(void **state)
{
    (void)state;
    const double p[COUNT] = {0.7, 1.3, -0.4};
    const struct {
        const char *text;
        size_t rows;
        double value; /* of the last row */
    } cases[] = {{"tip.x^2 + 2*middle.y*c - goal", 1, 1.96 - 0.52 - 0.75},
                 {"max(curvature*sin(s))", POINTS, 2 * sqrt(0.49 + 1.69) * sin(2)},
                 {" min( z + a ) ", POINTS, 2 * 0.91 + 0.7},
                 {"mean(u1)", 1, 0.7},
                 {"max(a, b)*tip.tz", 1, 1.3},
                 {"1e-3*a", 1, 0.7e-3},
                 {"tip.shear + 2", 1, 2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ad_error error = {.message = ""};
        response *r = make(cases[i].text, &error);
        assert_string_equal(error.message, "");
        double values[POINTS], by[POINTS * COUNT];
        assert_int_equal(value_of(r, p, values, by), cases[i].rows);
        const size_t last = cases[i].rows - 1;
        assert_near(values[last], cases[i].value, 1e-14);
        assert_derivatives(r, p, 1e-9);
        response_free(r);
    }
}

/* A rod of a thickness that is chosen, with a tendon that ends at a point of the shapes. */
static scene with_section(quantities *names)
{
    scene of = family_of();
    ad_error error;
    for (int i = 0; i < COUNT; i++) {
        assert_int_equal(quantities_coordinate(names, of.parameters[i].name, &error), AD_OK);
    }
    of.rod.section = SCENE_CIRCLE;
    of.rod.radius = quantity_formula(names, "0.01*(1 + b)");
    of.rod.youngs_modulus = quantity_number(1e5);
    of.rod.poissons_ratio = quantity_number(0.25);
    of.rod.rest_strain[2] = quantity_number(0.99);
    of.rod.rest_curvature[2] = quantity_formula(names, "0.1*c");
    of.tendon_count = 1;
    of.tendons[0].offset[0] = quantity_number(0.005);
    of.tendons[0].offset[1] = quantity_number(0);
    of.tendons[0].tension = quantity_formula(names, "2 + a");
    of.tendons[0].end = quantity_number(1.25);
    return of;
}

/* n = Kse (v - v*) and m = Kbt (u - u*) with T t and r x T t of the tendon, t along v + u x r; the
 * energy, of which the density is a polynomial of second degree in s, in closed form; and strains
 * of fibres. At the end of the tendon the shape is that before. */
static void what_strains_say_is_known(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    const scene family = with_section(names);
    const double p[COUNT] = {0.7, 1.3, -0.4}, L = 2, e = 0.01;
    const double radius = 0.01 * (1 + p[1]), area = acos(-1) * radius * radius;
    const double bend = 1e5 * area * radius * radius / 4, twist = 0.8 * bend, d = 0.005;
    const double tension = 2 + p[0], s[3] = {0.5, 1.25, 2};
    double force[3], moment[3], density[3];
    for (int i = 0; i < 3; i++) {
        const double u[3] = {s[i] * p[0], s[i] * p[1], p[2]}, off = 0.9 * u[2];
        const double t[3] = {0, u[2] * d, 1 - u[1] * d}, size = sqrt(t[1] * t[1] + t[2] * t[2]);
        const double pull = i < 2 ? tension / size : 0;
        force[i] = 1e5 * area * e + pull * t[2];
        moment[i] = bend * u[1] - d * pull * t[2];
        density[i] =
            (1e5 * area * e * e + bend * (u[0] * u[0] + u[1] * u[1]) + twist * off * off) / 2;
    }
    const double bends = p[0] * p[0] + p[1] * p[1], off = 0.9 * p[2];
    const double energy =
        (1e5 * area * e * e * L + bend * bends * L * L * L / 3 + twist * off * off * L) / 2;
    const struct {
        const char *text;
        size_t row;
        double value;
    } cases[] = {{"middle.n3", 0, force[0]},
                 {"max(n3)", 2, force[1]},
                 {"tip.n3", 0, force[2]},
                 {"middle.m2", 0, moment[0]},
                 {"max(m2)", 2, moment[1]},
                 {"tip.m2", 0, moment[2]},
                 {"middle.m1", 0, bend * 0.5 * p[0]},
                 {"tip.m3", 0, twist * off},
                 {"max(energy_density)", POINTS - 1, density[2]},
                 {"energy", 0, energy},
                 {"mean(2*energy_density)", 0, energy},
                 {"sqrt(energy) + tip.x*energy", 0, sqrt(energy) + 2 * p[0] * energy},
                 {"min(strain)", POINTS - 1, e + radius * L * sqrt(bends)}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ad_error error = {.message = ""};
        response *r = make_of(&family, cases[i].text, &error);
        assert_string_equal(error.message, "");
        double values[POINTS], by[POINTS * COUNT];
        value_of(r, p, values, by);
        assert_near(values[cases[i].row], cases[i].value, 1e-13 * (1 + fabs(cases[i].value)));
        assert_derivatives(r, p, 1e-9 * (1 + fabs(cases[i].value)));
        response_free(r);
    }
    quantities_free(names);
}

/* In a cube of half edges 3 the nearest wall is that of the largest coordinate: of the tip y = 2 b,
 * and along the rod likewise. */
static void clearances_are_those_of_a_cube(void **state)
{
    static const char cube[] = "v -3 -3 -3\nv 3 -3 -3\nv 3 3 -3\nv -3 3 -3\nv -3 -3 3\nv 3 -3 3\n"
                               "v 3 3 3\nv -3 3 3\nf 1 4 3\nf 1 3 2\nf 5 6 7\nf 5 7 8\nf 1 2 6\n"
                               "f 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
    (void)state;
    const double p[COUNT] = {0.7, 1.3, -0.4};
    environment_settings settings = ENVIRONMENT_DEFAULT;
    environment *made = NULL;
    ad_error error = {.message = ""};
    double values[POINTS], by[POINTS * COUNT];
    assert_null(make("tip.clearance", &error));
    assert_non_null(strstr(error.message, "no surface is given"));
    if (!environment_is_built()) {
        return;
    }
    FILE *file = fopen(at("cube.obj"), "w");
    assert_non_null(file);
    fputs(cube, file);
    fclose(file);
    settings.file = at("cube.obj");
    assert_int_equal(environment_open(&settings, 2, &made, &error), AD_OK);
    around = made;
    const struct {
        const char *text;
        double value, by_b;
    } cases[] = {{"tip.clearance", 3 - 2 * 1.3 - 0.25, -2},
                 {"min(clearance)", 3 - 2 * 1.3 - 0.25, -2},
                 {"middle.clearance*tip.x + tip.z", (2.75 - 0.65) * 1.4 + 1.82, -0.7 + 1.4}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        response *r = make(cases[i].text, &error);
        const size_t last = value_of(r, p, values, by) - 1;
        assert_near(values[last], cases[i].value, 1e-14);
        assert_near(by[last * COUNT + 1], cases[i].by_b, 1e-13);
        assert_derivatives(r, p, 1e-9);
        response_free(r);
    }
    around = NULL;
    environment_free(made);
}

/* A straight rod has strains and curvatures of 0, of which sizes have slopes of 0. */
static void sizes_of_nothing_have_slopes(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    quantities *names = quantities_create();
    const scene family = with_section(names);
    const double p[COUNT] = {0, 0, 0.3};
    double values[POINTS], by[POINTS * COUNT];
    static const char *const texts[] = {"tip.curvature", "tip.shear", "tip.strain"};
    for (int i = 0; i < 3; i++) {
        response *r = make_of(&family, texts[i], &error);
        value_of(r, p, values, by);
        assert_near(values[0], i < 2 ? 0 : 0.01, 1e-15);
        for (int k = 0; k < COUNT; k++) {
            assert_near(by[k], 0, 1e-50);
        }
        response_free(r);
    }
    quantities_free(names);
}

static void reactions_are_refused(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    scene family = with_section(names);
    ad_error error = {.message = ""};
    family.rod.model = SCENE_KIRCHHOFF;
    assert_null(make_of(&family, "tip.n1", &error));
    assert_non_null(strstr(error.message, "n1, which is a reaction"));
    family.rod.model = SCENE_COSSERAT;
    family.tendons[0].friction = quantity_number(0.1);
    assert_null(make_of(&family, "max(m1)", &error));
    assert_non_null(strstr(error.message, "tensions that strains do not say"));
    family.rod.section = SCENE_SECTION_NONE;
    for (int i = 0; i < 2; i++) {
        family.rod.bending_stiffness[i] = family.rod.shear_stiffness[i] = quantity_number(1);
    }
    family.rod.axial_stiffness = family.rod.torsional_stiffness = quantity_number(1);
    assert_null(make_of(&family, "tip.strain", &error));
    assert_non_null(strstr(error.message, "rod.section must be given"));
    quantities_free(names);
}

static void formulas_are_refused(void **state)
{
    (void)state;
    static const char *const cases[][2] = {{"tip.w", "unknown name 'tip.w'"},
                                           {"x + 1", "unknown name 'x'"},
                                           {"elbow.x", "unknown name 'elbow.x'"},
                                           {"tip.x*t", "has the time t"},
                                           {"tip.x + s", "has s outside of max, min or mean"},
                                           {"max(tip.x", "arguments in parentheses"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ad_error error = {.message = ""};
        assert_null(make(cases[i][0], &error));
        assert_non_null(strstr(error.message, cases[i][1]));
    }
}

/* ---- optima -------------------------------------------------------------------------------- */

static optimize_report run(const optimize_settings *settings, double beyond, optimization **result)
{
    static scene family;
    static made_up made;
    static optimize_report report;
    ad_error error = {.message = ""};
    char key[64] = "";
    family = family_of();
    assert_int_equal(optimize_create(settings, &family, NULL, result, key, &error), AD_OK);
    made.s = optimize_places(*result, &made.points);
    made.beyond = beyond;
    const optimize_solver solver = {solve, NULL, &made};
    optimize_run(*result, &solver, NULL, NULL, &report, &error);
    assert_string_equal(error.message, "");
    return report;
}

/* The place where a line touches a circle: minimize x + y of the tip with x^2 + y^2 <= 2. The tip
 * is 2 (a, b): a = -0.5 is not where b >= 0.1 ends, so b is at the end of its range: a is as the
 * circle says, and the multiplier that of one variable. */
static void a_constraint_and_a_range_are_met(void **state)
{
    (void)state;
    optimize_settings settings = optimize_settings_default();
    settings.minimize = "tip.x + tip.y + c^2";
    settings.constraints[settings.constraint_count++] = "tip.x^2 + tip.y^2 <= 2";
    optimization *o;
    const optimize_report r = run(&settings, INFINITY, &o);
    const double y = 0.2, x = -sqrt(2 - y * y);
    assert_true(r.found);
    assert_near(optimize_parameter(o, 0, 0), x / 2, 1e-6);
    assert_near(optimize_parameter(o, 0, 1), 0.1, 1e-6);
    assert_near(optimize_parameter(o, 0, 2), 0, 1e-4);
    assert_near(r.objective, x + y, 3e-6); /* rows are kept to 1e-8 of what they vary by, 400 */
    assert_near(r.bound[0].multiplier, 1 / (2 * x), 1e-4); /* of the bound: dx = d(bound)/(2 x) */
    assert_int_equal(r.bound[0].active, 1);
    optimize_free(o);
}

/* Goals of three cases, with a of each and b of all: sum of (2 a - goal)^2 + (2 b - 1)^2. */
static void cases_have_variables_of_their_own(void **state)
{
    (void)state;
    optimize_settings settings = optimize_settings_default();
    settings.minimize = "(tip.x - goal)^2 + (tip.y - 1)^2";
    settings.each[settings.each_count++] = "a";
    settings.variables[settings.variable_count++] = "b";
    settings.cases[0] = "goal=1, c=0";
    settings.cases[1] = "goal=-1, c=0.5";
    settings.cases[2] = "goal=5, c=0";
    settings.case_count = 3;
    optimization *o;
    const optimize_report r = run(&settings, INFINITY, &o);
    assert_true(r.found);
    assert_near(optimize_parameter(o, 0, 0), 0.5, 1e-4);
    assert_near(optimize_parameter(o, 1, 0), -0.5, 1e-4);
    assert_near(optimize_parameter(o, 2, 0), 2, 1e-6); /* the end of its range */
    assert_near(optimize_parameter(o, 1, 1), 0.5, 1e-4);
    assert_near(optimize_parameter(o, 1, 2), 0.5, 0);
    assert_near(r.objective, 1. / 3, 1e-6);
    optimize_free(o);
}

/* Distances from goals that are reached have a kink there, where slopes are not small: starts that
 * end alike tell the optimum. */
static void a_kink_is_an_optimum(void **state)
{
    (void)state;
    optimize_settings settings = optimize_settings_default();
    settings.minimize = "sqrt((tip.x - goal)^2 + (tip.y - 1)^2) + sqrt((tip.z - goal/2)^2)";
    settings.each[settings.each_count++] = "a";
    settings.each[settings.each_count++] = "b";
    settings.each[settings.each_count++] = "c";
    settings.cases[0] = "goal=1";
    settings.cases[1] = "goal=-1";
    settings.case_count = 2;
    optimization *o;
    const optimize_report r = run(&settings, INFINITY, &o);
    assert_true(r.found);
    assert_near(optimize_parameter(o, 0, 0), 0.5, 1e-5);
    assert_near(optimize_parameter(o, 1, 0), -0.5, 1e-5);
    assert_near(optimize_parameter(o, 1, 1), 0.5, 1e-5);
    assert_true(r.objective >= 0 && r.objective <= 1e-5);
    optimize_free(o);
}

/* The largest of 2 (a s - c)^2 along the rod, for c anywhere in [-1, 1]: at a = 0 it is 2, and
 * nowhere less. The worst of the box are its corners. */
static void the_worst_of_a_box_counts(void **state)
{
    (void)state;
    optimize_settings settings = optimize_settings_default();
    settings.minimize = "max(2*(x - c)^2)";
    settings.variables[settings.variable_count++] = "a";
    settings.variables[settings.variable_count++] = "b";
    settings.box[settings.box_count++] = "c";
    optimization *o;
    const optimize_report r = run(&settings, INFINITY, &o);
    assert_true(r.found);
    assert_false(r.box_open);
    assert_near(optimize_parameter(o, 0, 0), 0, 1e-5);
    assert_near(r.objective, 2, 1e-5);
    optimize_free(o);
}

/* Within the box the worst may lie anywhere, here at c = 0.3: a is 0.4, up to what members of the
 * box may be worse by: 1e-4 of what the constraint varies by, which is some 5. */
static void the_worst_within_a_box_is_found(void **state)
{
    (void)state;
    optimize_settings settings = optimize_settings_default();
    settings.maximize = "a - (log(b))^2";
    settings.constraints[settings.constraint_count++] = "a*(1 - (c - 0.3)^2) <= 0.4";
    settings.box[settings.box_count++] = "c";
    optimization *o;
    const optimize_report r = run(&settings, INFINITY, &o);
    assert_true(r.found);
    assert_false(r.box_open);
    assert_true(r.cases > 3); /* the middle and both ends are no such members */
    assert_near(optimize_parameter(o, 0, 0), 0.4, 5e-4);
    optimize_free(o);
}

/* Where members have no equilibrium the search goes on elsewhere; where nothing keeps the
 * constraints it says so. */
static void what_is_not_there_is_said(void **state)
{
    (void)state;
    optimize_settings settings = optimize_settings_default();
    settings.maximize = "tip.x - c^2";
    settings.variables[settings.variable_count++] = "a";
    settings.variables[settings.variable_count++] = "b";
    settings.variables[settings.variable_count++] = "c";
    settings.constraints[settings.constraint_count++] = "tip.x <= 1";
    optimization *o;
    optimize_report r = run(&settings, 1, &o);
    assert_true(r.found);
    assert_near(r.objective, 1, 1e-6);
    assert_near(r.bound[0].multiplier, 1, 1e-5);
    optimize_free(o);
    settings.constraints[settings.constraint_count++] = "tip.x >= 2";
    r = run(&settings, 1.5, &o);
    assert_false(r.found);
    assert_true(r.violation > 0.01);
    optimize_free(o);
}

static void settings_are_refused(void **state)
{
    (void)state;
    const struct {
        const char *minimize, *maximize, *constraint, *each, *variable, *case_of, *key, *says;
    } cases[] = {
        {"tip.x", "tip.y", NULL, NULL, NULL, NULL, "optimize.minimize", "beside optimize.maximize"},
        {"min(x)", NULL, NULL, NULL, NULL, NULL, "optimize.minimize", "least value least"},
        {"tip.x", NULL, "tip.y", NULL, NULL, NULL, "optimize.constraints[0]", "compares nothing"},
        {"tip.x", NULL, "tip.y <= tip.x", NULL, NULL, NULL, "optimize.constraints[0]",
         "compare with a number"},
        {"tip.x", NULL, "max(x) >= 1", NULL, NULL, NULL, "optimize.constraints[0]",
         "keeps a max from being small"},
        {"tip.x", NULL, "2 <= tip.x <= 1", NULL, NULL, NULL, "optimize.constraints[0]",
         "one below the other"},
        {"tip.x", NULL, NULL, "d", NULL, NULL, "optimize.each[0]", "no parameter with a range"},
        {"tip.x", NULL, NULL, "a", "a", NULL, "optimize.variables[0]", "comes twice"},
        {"tip.x", NULL, NULL, NULL, "a", NULL, "optimize.variables", "nothing says which value"},
        {"tip.x", NULL, NULL, NULL, NULL, "a=3", "optimize.cases[0]", "its range"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const scene family = family_of();
        optimize_settings settings = optimize_settings_default();
        settings.minimize = cases[i].minimize;
        settings.maximize = cases[i].maximize;
        settings.constraints[0] = cases[i].constraint;
        settings.constraint_count = cases[i].constraint != NULL;
        settings.each[0] = cases[i].each;
        settings.each_count = cases[i].each != NULL;
        settings.variables[0] = cases[i].variable;
        settings.variable_count = cases[i].variable != NULL;
        settings.cases[0] = cases[i].case_of;
        settings.case_count = cases[i].case_of != NULL;
        optimization *o = NULL;
        char key[64] = "";
        ad_error error = {.message = ""};
        assert_int_equal(optimize_create(&settings, &family, NULL, &o, key, &error), AD_BAD_INPUT);
        assert_null(o);
        assert_string_equal(key, cases[i].key);
        assert_non_null(strstr(error.message, cases[i].says));
    }
}

/* ---- of a rod ------------------------------------------------------------------------------ */

static ad_status solve_rod(void *of, size_t members, const double *parameters, double *values,
                           double *jacobian, bool *solved, ad_error *error)
{
    const cpinn_polish alone = {.alone = true};
    cpinn_answer answers[4];
    assert_true(members <= 4);
    const ad_status status =
        cpinn_family_answer(of, &alone, members, parameters, values, jacobian, answers, error);
    for (size_t i = 0; i < members; i++) {
        solved[i] = answers[i].trusted;
    }
    return status;
}

static ad_status margin_of_rod(void *of, size_t members, const double *parameters, double *margin,
                               double *by, ad_error *error)
{
    return cpinn_family_margin(of, members, parameters, margin, by, error);
}

/* Objectives of a rod that is bent far by a tendon, gravity and its rest shape, by differences of
 * fourth order of equilibria: its solver is off by less than 1e-11 of the length, which over the
 * step is 1e-8, and the step to the fourth times fifth derivatives is less. */
static void gradients_are_those_of_equilibria(void **state)
{
    (void)state;
    static const char *const objectives[] = {"energy*100",
                                             "base.m2*100 + base.n3",
                                             "middle.n1 + 0.1*middle.strain",
                                             "mean(1e4*(m1^2 + m2^2))",
                                             "tip.clearance*middle.clearance*10",
                                             "mean(10*strain)",
                                             "stability^2 + tip.x"};
    static const double weight[4] = {1, -8, 8, -1}, way[4] = {-2, -1, 1, 2};
    quantities *names = quantities_create();
    scene family = with_section(names);
    family.rod.length = quantity_number(0.2);
    family.rod.radius = quantity_formula(names, "1e-3*(1 + 0.03*b)");
    family.rod.youngs_modulus = quantity_number(2e9);
    family.rod.density = quantity_number(6000);
    family.rod.rest_strain[2] = quantity_number(1);
    family.rod.rest_curvature[0] = quantity_formula(names, "2*c");
    family.tendons[0].offset[0] = quantity_number(5e-3);
    family.tendons[0].end = quantity_number(0.125);
    family.loads.gravity[0] = quantity_number(-9.81);
    environment *made = NULL;
    ad_error error = {.message = ""};
    environment_settings around_it = ENVIRONMENT_DEFAULT;
    if (environment_is_built()) {
        around_it.file = at("cube.obj"); /* of the test above */
        around_it.unit = ENVIRONMENT_CM;
        around_it.position[2] = 0.19;
        assert_int_equal(environment_open(&around_it, 0.2, &made, &error), AD_OK);
    }
    for (size_t i = 0; i < sizeof objectives / sizeof *objectives; i++) {
        optimize_settings settings = optimize_settings_default();
        char key[64] = "";
        optimization *o = NULL;
        cpinn_family *members = NULL;
        settings.minimize = objectives[i];
        settings.radius = 1e-3;
        settings.points = 21;
        settings.places[0] = (optimize_place){"middle", 0.11};
        settings.places[1] = (optimize_place){"base", 0};
        settings.place_count = 2;
        if (!made && strstr(objectives[i], "clearance")) {
            continue;
        }
        assert_int_equal(optimize_create(&settings, &family, made, &o, key, &error), AD_OK);
        cpinn_family_settings where = {.extrapolate = true, .threads = 1};
        where.s = optimize_places(o, &where.points);
        assert_int_equal(cpinn_family_of_scene(&family, 1e-12, &where, &members, &error), AD_OK);
        const optimize_solver solver = {solve_rod, margin_of_rod, members};
        double x[COUNT] = {0.7, 0.4, 0.3}, gradient[COUNT];
        o->solver = &solver;
        assert_true(optimize_at(o, x));
        memcpy(gradient, o->gradient, sizeof gradient);
        for (int k = 0; k < COUNT; k++) {
            const double step = 2e-3, kept = x[k];
            double slope = 0;
            for (int j = 0; j < 4; j++) {
                x[k] = kept + way[j] * step;
                assert_true(optimize_look(o, x));
                slope += weight[j] * o->value / (12 * step);
            }
            x[k] = kept;
            assert_near(gradient[k], slope, 1e-8 * (1 + fabs(slope)));
        }
        cpinn_family_free(members);
        optimize_free(o);
    }
    environment_free(made);
    quantities_free(names);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(formulas_have_values_and_derivatives),
        cmocka_unit_test(what_strains_say_is_known),
        cmocka_unit_test(clearances_are_those_of_a_cube),
        cmocka_unit_test(gradients_are_those_of_equilibria),
        cmocka_unit_test(sizes_of_nothing_have_slopes),
        cmocka_unit_test(reactions_are_refused),
        cmocka_unit_test(formulas_are_refused),
        cmocka_unit_test(a_constraint_and_a_range_are_met),
        cmocka_unit_test(cases_have_variables_of_their_own),
        cmocka_unit_test(a_kink_is_an_optimum),
        cmocka_unit_test(the_worst_of_a_box_counts),
        cmocka_unit_test(the_worst_within_a_box_is_found),
        cmocka_unit_test(what_is_not_there_is_said),
        cmocka_unit_test(settings_are_refused),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
