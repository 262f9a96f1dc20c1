/* Derivatives of what a family answers, by every parameter, are those of its answers. */
#include "near.h"

#include "tools/library/trained_family.h"
#include "tools/prepare/prepare.h"

#include <math.h>
#include <string.h>

enum {
    POINTS = 4,
    FIRST_FORCE = SOLVE_MEMBERS_COLUMNS,
    FIRST_TUBE = SOLVE_MEMBERS_COLUMNS + SOLVE_MEMBERS_FORCES,
    MOST = POINTS * (FIRST_TUBE + 2 * SCENE_TUBES_MAX),
    PARAMETERS = 3
};

static int columns; /* of the scene at hand */

static const cpinn_polish alone = {.alone = true};

#define ROD                                                                                        \
    "length: 0.3, section: {shape: circle, radius: 2e-3}, "                                        \
    "material: {youngs_modulus: young, poissons_ratio: 0.4, density: 1200}"
#define FAMILY                                                                                     \
    "parameters: {young: {range: [0.8e7, 1.2e7]}, a: {range: [0, 1]}, b: {range: [-1, 1]}"

/* One of each kind that the solver of members takes. */
static const struct {
    const char *name, *text;
} scenes[] = {
    {"loads", FAMILY "}\nrod: {model: kirchhoff, " ROD "}\n"
                     "loads: {gravity: [0, 0, -0.981], force: [0.002*b, 0, 0.002],\n"
                     "        tip: {force: [0.003*a, 0.002*b, 0], moment: [0, 1e-4*b, 2e-4*a]}}\n"},
    {"shear", FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
                     "loads: {tip: {force: [0.003*a, 0.002*b, 0.01], moment: [0, 1e-4*b, 0]}}\n"},
    {"followers", FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
                         "loads: {frame: follower, force: [0.003*a, 0, 0],\n"
                         "        tip: {force: [0, 0.002*b, 0], frame: follower}}\n"},
    {"tendons", FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
                       "loads: {gravity: [0, 0, -0.981]}\n"
                       "tendons: [{offset: [0.004, 0], tension: 0.5*a},\n"
                       "          {offset: [0, 0.004], tension: 0.2 + 0.1*b}]\n"},
    {"points",
     FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
            "loads: {gravity: [0, 0, -0.981], points: [{at: 0.1, force: [0.002*a, 0, 0.002*b]}]}\n"
            "bodies: [{at: 0.2, mass: 1e-3}]\n"},
    {"places",
     FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
            "loads: {foundation: [0.3, 0.2, 0], tip: {force: [0.002*a, 0.005*b, 0]}}\n"
            "springs: [{at: 0.3, stiffness: [0.01, 0.02, 0.01], turning: [1e-4, 0, 1e-4]}]\n"},
    {"chambers", FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
                        "chambers: [{offset: [1e-3, 0], area: 1e-6, pressure: 2e4*a},\n"
                        "           {offset: [0, 1e-3], area: 1e-6, pressure: 1e4 + 5e3*b}]\n"},
    {"jumps", FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
                     "loads: {tip: {force: [0.002*a, 0.002*b, 0]}}\n"
                     "tendons: [{offset: [0.004, 0], tension: 0.5*a, end: 0.17}]\n"},
    {"pulled",
     FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
            "loads: {tip: {force: [0.002*a, 0.001*b, 0]}}\n"
            "tendons: [{offset: [0.004, 0], displacement: 2e-4 + 1e-4*a, stiffness: 2000}]\n"},
    {"friction", FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
                        "loads: {tip: {force: [0.002*a, 0.001*b, 0]}}\n"
                        "tendons: [{offset: [0.004, 0], tension: 0.2 + 0.3*a, friction: 0.2}]\n"},
    {"magnet", FAMILY "}\nrod: {model: kirchhoff, " ROD "}\n"
                      "loads: {magnetic: {moment: [0, 0, 0.1], field: [0.02*a, 0.01*b, 0.005]}}\n"},
    {"held",
     FAMILY "}\nrod: {model: kirchhoff, " ROD "}\n"
            "boundary: {end: {type: roller, along: [0, 0, 1], position: [0.03, 0.02, 0.29]}}\n"
            "loads: {force: [0.003*a, 0.002*b, 0]}\n"},
    /* What is not a load: each with its own way to the equations. */
    {"springs",
     FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
            "loads: {foundation: [0.3 + 0.1*a, 0.2, 0], tip: {force: [0.002, 0.001, 0]}}\n"
            "springs: [{at: 0.3, stiffness: [0.01, 0.02 + 0.01*b, 0.01], turning: [1e-4*a, 0, "
            "1e-4]}]\n"},
    {"routing", FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
                       "tendons: [{offset: ['0.004 + 0.01*a*s', 0.001*b], tension: 0.5}]\n"},
    {"length", FAMILY "}\nrod: {model: cosserat, " ROD ", rest: {curvature: [b, 0, 0.5]}}\n"
                      "loads: {tip: {force: [0.002, 0.001, 0]}}\n"
                      "tendons: [{offset: [0.004 + 0.001*a, 0], displacement: 4e-4, stiffness: "
                      "2000 + 500*b},\n"
                      "          {offset: [-0.004, 0], displacement: -1e-3}]\n"},
    {"rubbing",
     FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
            "loads: {tip: {force: [0.002, 0.001, 0]}}\n"
            "tendons: [{offset: [0.004 + 0.001*b, 0], tension: 0.2, friction: 0.1 + "
            "0.1*a},\n"
            "          {offset: [0, 0.004], displacement: 1e-4*(1 + a), friction: 0.1}]\n"},
    {"gradient", FAMILY "}\nrod: {model: kirchhoff, " ROD "}\n"
                        "loads: {magnetic: {moment: [0, 0.02*a, 0.1], gradient: [0.1, -0.2, "
                        "0.1*b, 0.05, 0.1]}}\n"},
    {"moved", FAMILY "}\nrod: {model: cosserat, " ROD "}\n"
                     "boundary: {start: {position: [0, 0.01*b, 0], rotation: [1, 0.01*a, 0, 0]},\n"
                     "  end: {type: clamped, position: [0.01, 0.02 + 0.005*b, 0.2985], "
                     "rotation: [1, 0.05*a, 0.02, 0]}}\n"
                     "loads: {force: [0.003, 0, 0]}\n"},
    {"grown", FAMILY "}\nrod: {model: cosserat, section: {shape: circle, radius: 2e-3},\n"
                     "  material: {youngs_modulus: young, poissons_ratio: 0.4, density: 1200}}\n"
                     "segments: [{length: 0.08 + 0.04*a}, {length: 0.2, turn: [0, 0.3, 0]}]\n"
                     "loads: {gravity: [0, 0, -0.981], tip: {force: [0.002, 0.003*b, 0]}}\n"
                     "tendons: [{offset: [0.004, 0], tension: 0.5*a}]\n"},
    {"law",
     FAMILY "}\nrod: {model: cosserat, length: 0.3, section: {shape: circle, radius: 2e-3},\n"
            "  material: {density: 2e-4*young}, law: {file: configs/law/neo_hooke.csv}, "
            "rest: {curvature: [b, 0, a]}}\n"
            "loads: {gravity: [0, 0, -0.981]}\n"
            "tendons: [{offset: [0.004, 0], tension: 0.2 + 0.1*a}]\n"},
    {"tubes",
     FAMILY "}\nrod: {model: kirchhoff, " ROD ", rest: {curvature: [3 + b, 1, 0.5]}}\n"
            "tubes: [{section: {radius: 3e-3, inner_radius: 2.6e-3}, end: 0.2, turned: 0.8 + a,\n"
            "  material: {youngs_modulus: young, poissons_ratio: 0.4, density: 1200},\n"
            "  rest: {curvature: [\"4 - 5*s\", b, 0]}, transmission: 0.05},\n"
            "  {section: {radius: 4e-3, inner_radius: 3.6e-3}, end: 0.1, turned: b,\n"
            "  material: {youngs_modulus: 1e7, poissons_ratio: 0.4, density: 1200},\n"
            "  rest: {curvature: [2, 0, 0]}}]\n"
            "loads: {gravity: [0, 0, -0.981], tip: {force: [0.002, 0.001*a, 0]}}\n"},
};

static void assert_good(ad_status status, const char *name, const ad_error *error)
{
    if (status != AD_OK) {
        fail_msg("%s: %s", name, error->message);
    }
}

/* Of fourth order: h^4 of fifth derivatives, and what is left of members over h. */
static void differ(const char *name, cpinn_family *x, const double *at, int parameter,
                   double by[MOST])
{
    static double moved[4][MOST];
    const scene_parameter *p = cpinn_family_parameter(x, parameter);
    const double h = 0.005 * (p->high - p->low);
    ad_error error = {.message = ""};
    cpinn_answer said;
    for (int side = 0; side < 4; side++) {
        double there[PARAMETERS];
        memcpy(there, at, sizeof there);
        there[parameter] += (double[]){-2, -1, 1, 2}[side] * h;
        assert_good(cpinn_family_answer(x, &alone, 1, there, moved[side], NULL, &said, &error),
                    name, &error);
    }
    for (int i = 0; i < POINTS * columns; i++) {
        by[i] = (8 * (moved[2][i] - moved[1][i]) - (moved[3][i] - moved[0][i])) / (12 * h);
    }
}

/* Forces and moments are those of the other solver, whose mesh and unknowns are others: to ten
 * times what it is asked for, of the largest, or of EI/L^2 and EI/L where these are less. */
static void compare_values(const char *name, cpinn_family *x, const scene *open, const double *at,
                           const double *s, const double *values)
{
    static const double TOLERANCE = 1e-9, unit[] = {1.4e-3, 4e-4};
    static double solved[MODEL_COLUMNS_MAX * POINTS];
    cpinn_solution *found = NULL;
    scene one;
    ad_error error = {.message = ""};
    scene_member(open, at, &one);
    assert_good(cpinn_solve_scene(&one, TOLERANCE, 0, NULL, &found, &error), name, &error);
    assert_good(cpinn_solution_evaluate(found, POINTS, s, NULL, solved, &error), name, &error);
    for (int part = 0; part < 2 + columns - FIRST_TUBE; part++) {
        const int first = part < 2 ? FIRST_FORCE + 3 * part : FIRST_TUBE + part - 2;
        double largest = unit[part % 2], off = 0;
        for (int c = first; c < first + (part < 2 ? 3 : 1); c++) {
            assert_string_equal(cpinn_family_column_name(x, c),
                                cpinn_solution_column_name(found, c));
            for (int i = 0; i < POINTS; i++) {
                largest = fmax(largest, fabs(solved[c * POINTS + i]));
                off = fmax(off, fabs(values[i * columns + c] - solved[c * POINTS + i]));
            }
        }
        if (!(off <= 10 * TOLERANCE * largest)) {
            fail_msg("%s: %s off by %g of %g", name, cpinn_family_column_name(x, first), off,
                     largest);
        }
    }
    cpinn_solution_free(found);
}

/* To 1e-7 of the largest, each of positions, rotations, strains, curvatures, forces and moments, of
 * angles and of torsions of tubes:
 * where members are solved to 1e-12 the worst are within 4e-8. Strains of a rod without any stay
 * without, and forces of one on which nothing acts but tendons. */
static void compare(const char *name, const double *jacobian, int parameter, const double *by)
{
    static const int first[] = {0, 3, 7, 10, FIRST_FORCE, FIRST_FORCE + 3, FIRST_TUBE};
    for (int part = 0; part < 6 + columns - FIRST_TUBE; part++) {
        const int begin = part < 6 ? first[part] : FIRST_TUBE + part - 6;
        const int end = part < 6 ? first[part + 1] : begin + 1;
        double largest = 0, off = 0;
        for (int i = 0; i < POINTS * columns; i++) {
            if (i % columns >= begin && i % columns < end) {
                const double slope = jacobian[i * PARAMETERS + parameter];
                largest = fmax(largest, fabs(slope));
                off = fmax(off, isnan(slope) ? INFINITY : fabs(slope - by[i]));
            }
        }
        if (!(off <= 1e-7 * largest)) {
            fail_msg("%s, parameter %d, columns from %d: %g of %g", name, parameter, begin, off,
                     largest);
        }
    }
}

/* Lanes that one member leaves are for its parameters: the bits are those of members together. */
static void compare_alone(const char *name, cpinn_family *x)
{
    enum { MEMBERS = 3 };
    static const double at[MEMBERS][PARAMETERS] = {
        {0.96e7, 0.5, 0.2}, {1.1e7, 0.3, -0.1}, {0.9e7, 0.6, 0.4}};
    static double values[MEMBERS * MOST], together[MEMBERS * MOST * PARAMETERS],
        one[MOST * PARAMETERS];
    const size_t numbers = (size_t)(POINTS * columns * PARAMETERS);
    cpinn_answer said[MEMBERS];
    ad_error error = {.message = ""};
    assert_good(cpinn_family_answer(x, &alone, MEMBERS, at[0], values, together, said, &error),
                name, &error);
    for (int i = 0; i < MEMBERS; i++) {
        assert_good(cpinn_family_answer(x, &alone, 1, at[i], values, one, said, &error), name,
                    &error);
        if (memcmp(one, together + (size_t)i * numbers, numbers * sizeof *one) != 0) {
            fail_msg("%s: member %d alone has other derivatives", name, i);
        }
    }
}

static void test_derivatives(void **state)
{
    (void)state;
    /* Where something jumps, too. */
    static const double s[POINTS] = {0.06, 0.1, 0.2, 0.3}, at[PARAMETERS] = {0.96e7, 0.5, 0.2};
    static double values[MOST], jacobian[MOST * PARAMETERS], by[MOST];
    const cpinn_family_settings settings = {.threads = 1, .points = POINTS, .s = s, .forces = true};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        const char *name = scenes[i].name;
        config *read = NULL;
        cpinn_family *x = NULL;
        cpinn_answer said;
        ad_error error = {.message = ""};
        assert_good(prepare_read(name, scenes[i].text, 0, NULL, &read, &error), name, &error);
        assert_good(cpinn_family_prepare(&read->scene, 1e-12, &settings, &x, &error), name, &error);
        columns = cpinn_family_columns(x);
        assert_int_equal(columns, FIRST_TUBE + 2 * read->scene.tube_count);
        assert_good(cpinn_family_answer(x, &alone, 1, at, values, jacobian, &said, &error), name,
                    &error);
        if (said.source != CPINN_FROM_MEMBERS || !(said.error <= 1e-11)) {
            fail_msg("%s: %s, error %g", name, cpinn_reason_word(said.reason), said.error);
        }
        compare_values(name, x, &read->scene, at, s, values);
        for (int k = 0; k < PARAMETERS; k++) {
            differ(name, x, at, k, by);
            compare(name, jacobian, k, by);
        }
        compare_alone(name, x);
        cpinn_family_free(x);
        config_free(read);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_derivatives),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
