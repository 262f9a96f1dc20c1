/* Groups of families: how many there are, that members with the same groups have the same shape,
 * and that a member that is turned about its base or mirrored is the same to a network. */
#include "near.h"
#include "random_numbers.h"

#include "physics/groups.h"
#include "physics/solve/members.h"
#include "tools/config/config.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { INPUTS = 32, POINTS = 5, MEMBERS = 24 };

#define PI    3.14159265358979323846
#define THIRD 2.0943951023931953 /* of a turn */

static void assert_good(ad_status status, const ad_error *error)
{
    if (status != AD_OK) {
        fail_msg("%s", error->message);
    }
}

/* ---- a family at work ---------------------------------------------------------------------- */

typedef struct family {
    config *given;
    groups *x;
    int count;
} family;

static family read_family(const char *text, groups_settings settings)
{
    ad_error error = {.message = ""};
    family f = {NULL, NULL, 0};
    assert_good(config_read("family.yaml", text, 0, NULL, &f.given, &error), &error);
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

/* ---- the robot with three tendons ---------------------------------------------------------- */

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

static const groups_settings usual = {GROUPS_OF_EQUATIONS, GROUPS_SYMMETRY};

static void test_counts(void **state)
{
    (void)state;
    family b = read_family(robot(1, 1, 0.2), usual), mild = read_family(robot(1, 1, 0.05), usual);
    family plain = read_family(robot(1, 1, 0.2), (groups_settings){.inputs = GROUPS_PARAMETERS});
    assert_int_equal(b.count, 9);
    assert_int_equal(mild.count, 9);
    assert_int_equal(plain.count, 9);
    assert_line(&b, "symmetry: a turn by 120 degrees and a mirror");
    assert_line(&b, "moment of actuators about d2");
    assert_line(&b, "weight along d3");
    assert_line(&plain, "tension_1: 0");
    free_family(&b);
    free_family(&mild);
    free_family(&plain);
}

/* A turn by a third hands the tensions on; a mirror through the first tendon exchanges the others.
 * Inputs differ by rounding, and by that of the offsets in the text. */
static void twin_of(const double *p, bool mirrors, double *twin)
{
    const double c = cos(THIRD), s = sin(THIRD);
    memcpy(twin, p, 9 * sizeof *p);
    twin[0] = mirrors ? p[0] : p[2];
    twin[1] = mirrors ? p[2] : p[0];
    twin[2] = p[1];
    twin[3] = mirrors ? -p[3] : p[3] + THIRD;
    twin[5] = mirrors ? p[5] : c * p[5] - s * p[6];
    twin[6] = mirrors ? -p[6] : s * p[5] + c * p[6];
}

static void test_twins(void **state)
{
    (void)state;
    family f = read_family(robot(1, 1, 0.05), usual);
    static double p[MEMBERS][9], u[MEMBERS][POINTS][3];
    uint64_t random = 3;
    for (int i = 0; i < MEMBERS; i += 2) {
        draw(&f, &random, p[i]);
        twin_of(p[i], i % 4 == 0, p[i + 1]);
    }
    solve(&f, MEMBERS, p[0], u);
    double bent = 0;
    for (int i = 0; i < MEMBERS; i += 2) {
        const member_inputs a = inputs_of(&f, p[i]), b = inputs_of(&f, p[i + 1]);
        assert_same_inputs(&f, &a, &b, 1e-11);
        for (int j = 0; j < POINTS; j++) {
            for (int k = 0; k < 3; k++) { /* in the sector, of both */
                double first = 0, second = 0;
                for (int l = 0; l < 3; l++) {
                    first += a.back[k][l] * u[i][j][l];
                    second += b.back[k][l] * u[i + 1][j][l];
                }
                assert_near(first, second, 1e-7);
                bent = fmax(bent, fabs(first));
            }
        }
    }
    assert_true(bent > 1);
    free_family(&f);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_twins),
        cmocka_unit_test(test_scaling),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
