/* Groups of families: how many there are, that members with the same groups have the same shape,
 * and that a member that is turned about its base or mirrored is the same to a network. */
#include "allocations.h"
#include "fewer.h"
#include "good.h"
#include "random_numbers.h"

#include "physics/chain/solve_members.h"
#include "physics/learn/groups.h"
#include "tools/prepare/prepare.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { INPUTS = 32, POINTS = 5, MEMBERS = 24 };

#define PI    3.14159265358979323846
#define THIRD 2.0943951023931953 /* of a turn */

/* ---- a family at work ------------------------------------------------------------------------ */

typedef struct family {
    config *given;
    groups *x;
    int count;
} family;

static family read_family(const char *text, groups_settings settings)
{
    ad_error error = {.message = ""};
    family f = {NULL, NULL, 0};
    assert_good(prepare_read("family.yaml", text, 0, NULL, &f.given, &error), &error);
    assert_good(groups_find(&f.given->scene, &settings, &f.x, &error), &error);
    f.count = groups_count(f.x);
    return f;
}

static void free_family(family *f)
{
    groups_free(f->x);
    config_free(f->given);
}

static bool has_line(const family *f, const char *part)
{
    char line[300];
    for (int i = 0; groups_text(f->x, i, line, sizeof line); i++) {
        if (strstr(line, part)) {
            return true;
        }
    }
    return false;
}

static void assert_line(const family *f, const char *part)
{
    char line[300];
    for (int i = 0; !has_line(f, part) && groups_text(f->x, i, line, sizeof line); i++) {
        print_message("%s\n", line);
    }
    assert_true(has_line(f, part));
}

/* Inputs, and what vectors (1, 0, 0), (0, 1, 0), (0, 0, 1) of the sector are of the member, axial
 * ones: back [i][k] is row k of vector i. */
typedef struct member_inputs {
    double inputs[INPUTS], back[3][3];
} member_inputs;

static member_inputs inputs_of(const family *f, const double *parameters)
{
    member_inputs result;
    ad_error error = {.message = ""};
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(1);
    ad_program *program = NULL;
    groups_turn turn;
    const int count = f->given->scene.parameter_count;
    ad_value given = ad_input(tape, "parameters", count), all[3];
    ad_value outputs[2] = {groups_record(f->x, given, &turn)};
    assert_true(f->count <= INPUTS);
    assert_int_equal(ad_rows(outputs[0]), f->count);
    for (int k = 0; k < 3; k++) { /* entry k of all three vectors; else the tape would fold them */
        const double unit[3] = {k == 0, k == 1, k == 2};
        ad_value row = ad_scale(ad_row(given, 0), 0);
        all[k] = ad_add(ad_constant(tape, 3, unit), row);
    }
    groups_restore(&turn, all);
    outputs[1] = ad_stack(4, (ad_value[]){all[0], all[1], all[2], ad_row(given, 0)});
    assert_good(ad_tape_status(tape, &error), &error);
    assert_good(ad_compile(2, outputs, NULL, pool, &program, &error), &error);
    double back[10];
    const ad_run run = {
        .points = 1, .inputs = &parameters, .outputs = (double *const[]){result.inputs, back}};
    assert_good(ad_execute(program, &run, &error), &error);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            result.back[i][k] = back[3 * k + i];
        }
    }
    ad_program_free(program);
    ad_pool_free(pool);
    ad_tape_free(tape);
    return result;
}

static void assert_same_inputs(const family *f, const member_inputs *a, const member_inputs *b,
                               double tolerance)
{
    for (int i = 0; i < f->count; i++) {
        assert_near(a->inputs[i], b->inputs[i], tolerance);
    }
}

/* Curvature times length at some points, of members by the solver. */
static void solve(const family *f, size_t members, const double *parameters,
                  double (*curvature)[POINTS][3])
{
    static double values[MEMBERS * POINTS][SOLVE_MEMBERS_COLUMNS];
    solve_member results[MEMBERS];
    double s[POINTS];
    const double length = scene_length(&f->given->scene);
    solve_members *x;
    ad_error error = {.message = ""};
    for (int i = 0; i < POINTS; i++) {
        s[i] = length * (0.5 + i) / POINTS;
    }
    const solve_members_settings settings = {
        .tolerance = 1e-9, .threads = 1, .points = POINTS, .s = s};
    assert_good(solve_members_create(&f->given->scene, &settings, &x, &error), &error);
    assert_good(solve_members_solve(x, members, parameters, values[0], results, &error), &error);
    for (size_t i = 0; i < members; i++) {
        assert_true(results[i].solved);
        for (size_t j = 0; j < POINTS; j++) {
            for (int k = 0; k < 3; k++) {
                curvature[i][j][k] = length * values[i * POINTS + j][10 + k];
            }
        }
    }
    solve_members_free(x);
}

static void draw(const family *f, uint64_t *random, double *parameters)
{
    const scene *s = &f->given->scene;
    for (int i = 0; i < s->parameter_count; i++) {
        parameters[i] = scene_parameter_at(&s->parameters[i], random_in(random, 0, 1));
    }
}

/* ---- the robot with three tendons ------------------------------------------------------------ */

/* All that has a length by `long`, all that has a force by `force`. */
static const char *robot(double length, double force, double tip)
{
    static char text[4000];
    const double r = 8e-3 * length;
    snprintf(text, sizeof text,
             "parameters:\n"
             "  tension_1: {range: [0, %.17g]}\n"
             "  tension_2: {range: [0, %.17g]}\n"
             "  tension_3: {range: [0, %.17g]}\n"
             "  turned: {range: [0, 6.283185307179586]}\n"
             "  vertical: {range: [-1, 1]}\n"
             "  tip_x: {range: [%.17g, %.17g]}\n"
             "  tip_y: {range: [%.17g, %.17g]}\n"
             "  tip_z: {range: [%.17g, %.17g]}\n"
             "  stiffness: {range: [0.5, 2], scale: log}\n"
             "  g: %.17g\n"
             "rod: {model: cosserat, length: %.17g, section: {shape: circle, radius: %.17g},\n"
             "  material: {youngs_modulus: \"%.17g*stiffness\", poissons_ratio: 0.3,\n"
             "             density: 6450}}\n"
             "boundary: {end: {type: loaded}}\n"
             "loads:\n"
             "  gravity: [\"g*sqrt(1-vertical^2)*cos(turned)\",\n"
             "            \"g*sqrt(1-vertical^2)*sin(turned)\", \"g*vertical\"]\n"
             "  tip: {force: [tip_x, tip_y, tip_z]}\n"
             "tendons:\n"
             "  - {offset: [%.17g, 0], tension: tension_1}\n"
             "  - {offset: [%.17g, %.17g], tension: tension_2}\n"
             "  - {offset: [%.17g, %.17g], tension: tension_3}\n",
             3.5 * force, 3.5 * force, 3.5 * force, -tip * force, tip * force, -tip * force,
             tip * force, -tip * force, tip * force, 9.81 * force / pow(length, 3), 0.2 * length,
             0.5e-3 * length, 60e9 * force / pow(length, 2), r, r * cos(THIRD), r * sin(THIRD),
             r * cos(THIRD), -r * sin(THIRD));
    return text;
}

static const groups_settings usual = {GROUPS_OF_EQUATIONS, GROUPS_SYMMETRY},
                             exact = {.symmetry = GROUPS_EXACT},
                             plain = {.symmetry = GROUPS_NO_SYMMETRY};

/* Three numbers of the actuators, of the weight and of the tip force, each over the stiffness; one
 * less where the tip force is turned into a plane. */
static void test_counts(void **state)
{
    (void)state;
    family b = read_family(robot(1, 1, 0.2), usual), mild = read_family(robot(1, 1, 0.05), usual);
    family third = read_family(robot(1, 1, 0.2), exact),
           none = read_family(robot(1, 1, 0.2), plain);
    family own = read_family(robot(1, 1, 0.2), (groups_settings){.inputs = GROUPS_PARAMETERS});
    assert_int_equal(b.count, 8);
    assert_int_equal(mild.count, 8);
    assert_int_equal(third.count, 9);
    assert_int_equal(none.count, 9);
    assert_int_equal(own.count, 9);
    assert_line(&b, "symmetry: any turn about d3 and a mirror, but for some 8e-05 of the length");
    assert_line(&third, "symmetry: a turn by 120 degrees and a mirror");
    assert_line(&third, "moment of actuators about d2");
    assert_line(&third, "weight along d3");
    assert_true(!has_line(&none, "symmetry"));
    assert_line(&own, "stiffness: 0.5 to 2 by its logarithm");
    free_family(&b);
    free_family(&mild);
    free_family(&third);
    free_family(&none);
    free_family(&own);
}

/* By a turn tensions that have the same sum and whose moment is turned, in a mirror those of the
 * second and the third tendon exchanged. */
static void twin_of(const double *p, double angle, bool mirrors, double *twin)
{
    const double c = cos(angle), s = sin(angle);
    double sum = 0, x = 0, y = 0, tension[3];
    memcpy(twin, p, 9 * sizeof *p);
    for (int i = 0; i < 3; i++) {
        sum += p[i];
        x += p[i] * cos(i * THIRD);
        y += p[i] * sin(i * THIRD);
    }
    for (int i = 0; i < 3; i++) {
        tension[i] =
            sum / 3 +
            2.0 / 3 * ((c * x - s * y) * cos(i * THIRD) + (s * x + c * y) * sin(i * THIRD));
    }
    twin[0] = tension[0];
    twin[1] = tension[mirrors ? 2 : 1];
    twin[2] = tension[mirrors ? 1 : 2];
    twin[3] = mirrors ? -p[3] - angle : p[3] + angle;
    twin[5] = c * p[5] - s * p[6];
    twin[6] = (mirrors ? -1 : 1) * (s * p[5] + c * p[6]);
}

/* Both have the same inputs, up to the rounding of offsets in the text, and the same curvature
 * in the sector. */
static void check_twins(groups_settings settings, double angle, double tolerance)
{
    family f = read_family(robot(1, 1, 0.05), settings);
    static double p[MEMBERS][9], u[MEMBERS][POINTS][3];
    uint64_t random = 3;
    double bent = 0;
    for (int i = 0; i < MEMBERS; i += 2) {
        draw(&f, &random, p[i]);
        twin_of(p[i], angle, i % 4 == 0, p[i + 1]);
    }
    solve(&f, MEMBERS, p[0], u);
    for (int i = 0; i < MEMBERS; i += 2) {
        const member_inputs a = inputs_of(&f, p[i]), b = inputs_of(&f, p[i + 1]);
        assert_same_inputs(&f, &a, &b, 1e-11);
        for (int j = 0; j < POINTS; j++) {
            for (int k = 0; k < 3; k++) {
                double first = 0, second = 0;
                for (int l = 0; l < 3; l++) {
                    first += a.back[k][l] * u[i][j][l];
                    second += b.back[k][l] * u[i + 1][j][l];
                }
                assert_near(first, second, tolerance);
                bent = fmax(bent, fabs(first));
            }
        }
    }
    assert_true(bent > 1);
    free_family(&f);
}

/* The solver's own error is 1e-9; by an angle of no third a tendon's resistance to twist is another
 * by a part of 1e-3. */
static void test_twins(void **state)
{
    (void)state;
    check_twins(exact, THIRD, 1e-7);
    check_twins(usual, THIRD, 1e-7);
    check_twins(usual, 0.7, 1e-3);
}

/* Another length, and another unit of force: the same groups and the same shapes. */
static void test_scaling(void **state)
{
    (void)state;
    family f = read_family(robot(1, 1, 0.05), usual), large = read_family(robot(3, 7, 0.05), usual);
    static double p[2][MEMBERS][9], u[2][MEMBERS][POINTS][3];
    uint64_t random = 4;
    assert_int_equal(f.count, large.count);
    for (int i = 0; i < MEMBERS; i++) {
        draw(&f, &random, p[0][i]);
        memcpy(p[1][i], p[0][i], sizeof p[0][i]);
        for (int k = 0; k < 8; k++) {
            p[1][i][k] *= k < 3 || k > 4 ? 7 : 1;
        }
        const member_inputs a = inputs_of(&f, p[0][i]), b = inputs_of(&large, p[1][i]);
        assert_same_inputs(&f, &a, &b, 1e-11);
    }
    solve(&f, MEMBERS, p[0][0], u[0]);
    solve(&large, MEMBERS, p[1][0], u[1]);
    for (int i = 0; i < MEMBERS * POINTS; i++) {
        for (int k = 0; k < 3; k++) {
            assert_near(u[0][i / POINTS][i % POINTS][k], u[1][i / POINTS][i % POINTS][k], 1e-7);
        }
    }
    free_family(&f);
    free_family(&large);
}

/* ---- other families -------------------------------------------------------------------------- */

#define ROD(section, more)                                                                         \
    "rod: {model: cosserat, length: 0.5, section: {" section "},\n"                                \
    "      material: {youngs_modulus: e, poissons_ratio: 0.3, density: rho}}\n"                    \
    "boundary: {end: {type: loaded}}\n" more
#define FORCES                                                                                     \
    "parameters: {x: {range: [-1, 1]}, y: {range: [-1, 1]}, z: {range: [-1, 1]},\n"                \
    "             rho: {range: [1000, 2000]}, e: {range: [1e7, 2e7]}}\n"
#define TIP        "loads: {tip: {force: [x, y, z]}}\n"
#define TIP_WEIGHT "loads: {gravity: [0, 0, -9.81], tip: {force: [x, y, z]}}\n"
#define WOUND                                                                                      \
    "parameters: {a: {range: [0, 2]}, b: {range: [0, 2]}, y: {range: [-0.1, 0.1]}, rho: 1e3,\n"    \
    "             e: 1e9}\n"
#define WINDING(sign) "offset: [\"" sign "0.008*cos(10*s)\", \"" sign "0.008*sin(10*s)\"]"

#define BASE(more)                                                                                 \
    "parameters: {a: {range: [0, 2]}, turn: {range: [-1, 1]}, slide: {range: [0, 1]},\n"           \
    "             rho: 1e3, e: 1e9}\n"                                                             \
    "rod: {model: cosserat, length: 0.5, section: {shape: circle, radius: 0.002},\n"               \
    "      material: {youngs_modulus: e, poissons_ratio: 0.3, density: rho}}\n"                    \
    "boundary: {start: {position: [slide, 0, 0], rotation: [cos(turn), sin(turn), 0, 0]},\n"       \
    "           end: {type: free}}\n" more

static void test_others(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        int count;
        const char *line, *no_line;
    } rows[] = {
        {FORCES ROD("shape: circle, radius: 0.01", TIP), 2, "symmetry: any turn about d3",
         "mirror"}, /* which the only vector leaves to itself */
        {FORCES ROD("shape: circle, radius: 0.01", TIP), 2, "rho does not change the shape", NULL},
        {FORCES ROD("shape: circle, radius: 0.01", TIP_WEIGHT), 3, "weight along d3", "rho does"},
        {FORCES ROD("shape: rectangle, width: 0.01, height: 0.02", TIP), 3,
         "symmetry: a turn by 180 degrees and a mirror", NULL},
        {FORCES ROD("shape: rectangle, width: 0.01, height: 0.01", TIP), 2, "any turn", NULL},
        {"parameters: {a: {range: [0.1, 0.4]}, x: {range: [0, 0.1]}, rho: 1e3, e: 1e9}\n" ROD(
             "shape: circle, radius: \"0.01*where(a-s, 1, 0.7)\"",
             "loads: {tip: {force: [x, 0, 0]}}"),
         3, "a: 0.1 to 0.4", "turn"},
        {WOUND ROD("shape: circle, radius: 0.002",
                   "loads: {tip: {force: [0, y, 0]}}\n"
                   "tendons: [{" WINDING("") ", tension: a}, {" WINDING("-") ", tension: b}]\n"),
         3, "symmetry: a turn by 180 degrees", "mirror"},
        {WOUND ROD("shape: circle, radius: 0.02",
                   "chambers:\n"
                   "  - {offset: [0.01, 0], pressure: 1e5*a, area: 1e-4}\n"
                   "  - {offset: [-0.01, 0], pressure: 1e5*b, area: 1e-4}\n"
                   "loads: {tip: {force: [0, y, 0]}}\n"),
         3, "symmetry: a turn by 180 degrees and a mirror", NULL},
        /* what the base does is no input; the weight in its frame is, of two directions with the
         * turn about d3 left to the symmetry of a round rod */
        {BASE("") "tendons: [{offset: [0.005, 0], tension: a}]\n", 1, "turn moves the base alone",
         NULL},
        {BASE("") "tendons: [{offset: [0.005, 0], tension: a}]\n", 1, "slide moves the base alone",
         NULL},
        {BASE("loads: {gravity: [0, 0, -9.81]}\n") "tendons: [{offset: [0.005, 0], tension: a}]\n",
         3, "slide moves the base alone", "turn moves"},
        /* where nothing else does anything a network still has inputs */
        {BASE("") "tendons: [{offset: [0.005, 0], tension: 1+0*a}]\n", 3, "slide: 0 to 1", NULL},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        family f = read_family(rows[i].text, usual);
        if (f.count != rows[i].count) {
            print_message("row %zu\n", i);
        }
        assert_int_equal(f.count, rows[i].count);
        assert_line(&f, rows[i].line);
        assert_true(!rows[i].no_line || !has_line(&f, rows[i].no_line));
        free_family(&f);
    }
}

/* Of the inputs by a parameter, within a sector, against differences. */
static void test_derivatives(void **state)
{
    (void)state;
    family f = read_family(robot(1, 1, 0.2), usual);
    const double p[9] = {1, 0.5, 2, 0.4, 0.3, 0.1, -0.05, 0.02, 1.3}, step = 1e-5;
    double moved[2][9], slope[INPUTS + 1];
    const double *parameters = p;
    ad_error error = {.message = ""};
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(1);
    ad_value given = ad_input(tape, "parameters", 9);
    ad_value inputs = groups_record(f.x, given, NULL);
    for (int k = 0; k < 9; k++) {
        ad_program *program = NULL;
        double unit[9] = {0};
        unit[k] = 1;
        ad_value along = ad_constant(tape, 9, unit), derivative;
        assert_int_equal(ad_directional(1, &inputs, 1, &given, &along, &derivative), AD_OK);
        derivative = ad_stack(2, (ad_value[]){derivative, ad_row(given, 0)});
        assert_good(ad_compile(1, &derivative, NULL, pool, &program, &error), &error);
        const ad_run run = {
            .points = 1, .inputs = &parameters, .outputs = (double *const[]){slope}};
        assert_good(ad_execute(program, &run, &error), &error);
        ad_program_free(program);
        for (int i = 0; i < 2; i++) {
            memcpy(moved[i], p, sizeof p);
            moved[i][k] += i ? step : -step;
        }
        const member_inputs a = inputs_of(&f, moved[0]), b = inputs_of(&f, moved[1]);
        for (int i = 0; i < f.count; i++) {
            assert_near(slope[i], (b.inputs[i] - a.inputs[i]) / (2 * step),
                        1e-7 * fmax(1, fabs(slope[i])));
        }
    }
    ad_pool_free(pool);
    ad_tape_free(tape);
    free_family(&f);
}

/* The n-th allocation fails: an error, and nothing is left behind. */
static void test_memory(void **state)
{
    (void)state;
    family f = read_family(robot(1, 1, 0.2), usual);
    ad_status status = AD_NO_MEMORY;
    for (long n = 1; status != AD_OK; n += 1 + n / 4) {
        ad_error error = {.message = ""};
        groups *x = NULL;
        allocations = 0;
        failing_allocation = n;
        status = groups_find(&f.given->scene, &usual, &x, &error);
        failing_allocation = 0;
        assert_true(status == AD_OK || (status == AD_NO_MEMORY && !x));
        groups_free(x);
    }
    free_family(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_others),
        cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_memory),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_twins),
                                       cmocka_unit_test(test_scaling)};
    return run_with_alike(tests, alike, NULL, NULL);
}
