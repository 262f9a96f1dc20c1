/* Lists of a scene: read from a file, written and read again; segments against the same rod written
 * with formulas that switch, and the unstressed shape of rods in pieces against closed forms. */
#include "config_testing.h"
#include "rod_testing.h"
#include "temporary_folder.h"

#include "physics/rod/rod_internal.h"
#include "physics/scene/breaks.h"
#include "physics/solve/solve.h"
#include "tools/config/config_parts.h"

#include <string.h>
#include <unistd.h>

/* ---- reading --------------------------------------------------------------------------------- */

#define EVERYTHING                                                                                 \
    "parameters: {load: 0.3}\n"                                                                    \
    "rod:\n"                                                                                       \
    "  section: {shape: circle, radius: 0.01}\n"                                                   \
    "  material: {youngs_modulus: 1e7, poissons_ratio: 0.5, density: 1000}\n"                      \
    "segments:\n"                                                                                  \
    "  - length: 0.4\n"                                                                            \
    "  - length: 0.6\n"                                                                            \
    "    section: {shape: rectangle, width: 0.01, height: 0.02}\n"                                 \
    "    rest: {curvature: [\"2*s\", 0, 0]}\n"                                                     \
    "    turn: [0.5, 0, 0]\n"                                                                      \
    "loads:\n"                                                                                     \
    "  points:\n"                                                                                  \
    "    - {at: 0.3, force: [0, \"load*t\", 0]}\n"                                                 \
    "    - {at: 0.5, moment: [0.01, 0, 0], frame: follower}\n"                                     \
    "bodies: [{at: 1, mass: 0.2}, {at: 0.5, mass: 0.1, inertia: [1e-4, 1e-4, 2e-4]}]\n"            \
    "springs: [{at: 0.7, stiffness: [0, 1, 0], anchor: [0, 0.1, 0.7]}]\n"                          \
    "tendons:\n"                                                                                   \
    "  - {offset: [0, \"0.02 - 0.01*s\"], end: 0.8, tension: \"3*t\"}\n"                           \
    "  - {offset: [0, -0.02], tension: 1, start: 0.1}\n"                                           \
    "chambers: [{offset: [0, 0.005], area: 1e-5, pressure: \"1e4*t\"}]\n"                          \
    "time: {duration: 1}\n"

static void test_reading(void **state)
{
    (void)state;
    config *given = read_text(EVERYTHING, 0, NULL);
    const scene *s = &given->scene;
    assert_int_equal(s->segment_count, 2);
    assert_int_equal(s->point_count, 2);
    assert_int_equal(s->body_count, 2);
    assert_int_equal(s->spring_count, 1);
    assert_int_equal(s->tendon_count, 2);
    assert_int_equal(s->chamber_count, 1);
    assert_near(scene_length(s), 1, 0);
    assert_false(s->segments[0].rod.radius.is_given);
    assert_int_equal(s->segments[1].rod.section, SCENE_RECTANGLE);
    assert_text(s->segments[1].rod.rest_curvature[0], "2*s");
    assert_near(s->segments[1].turn[0].number, 0.5, 0);
    assert_text(s->points[0].load.force[1], "load*t");
    assert_near(quantity_value(s->points[0].load.force[1], 0, 0.5), 0.15, 1e-16);
    assert_false(s->points[0].load.moment[0].is_given);
    assert_int_equal(s->points[1].load.frame, SCENE_FOLLOWER);
    assert_near(s->bodies[0].inertia[2].number, 0, 0); /* the default of an entry */
    assert_near(s->bodies[1].inertia[2].number, 2e-4, 0);
    assert_near(s->springs[0].turning[1].number, 0, 0);
    assert_near(s->springs[0].anchor[1].number, 0.1, 0);
    assert_near(s->tendons[0].end.number, 0.8, 0);
    assert_false(s->tendons[1].end.is_given);
    assert_near(s->tendons[1].start.number, 0.1, 0);
    assert_false(s->tendons[1].displacement.is_given);
    assert_near(s->tendons[1].friction.number, 0, 0);
    assert_near(s->chambers[0].area.number, 1e-5, 0);
    config_free(given);
}

static void test_round_trip(void **state)
{
    (void)state;
    config *given = read_text(EVERYTHING, 0, NULL);
    for (int help = 0; help < 2; help++) {
        char *first = written(given, help);
        config *again = read_text(first, 0, NULL);
        char *second = written(again, help);
        assert_string_equal(first, second);
        assert_int_equal(again->scene.tendon_count, 2);
        config_free(again);
        free(first);
        free(second);
    }
    config_free(given);
}

/* The same scene, filled in by a program, is written as the one of the file. */
static void test_by_hand(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    config *given = read_text(EVERYTHING, 0, NULL), *made = NULL;
    if (prepare_create(&given->scene, &given->settings, &made, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (double s = 0.05; s < 1; s += 0.1) {
        scene_properties a = scene_properties_of(&given->scene);
        scene_properties b = scene_properties_of(&made->scene);
        assert_near(quantity_value(a.curvature_stiffness[0], s, 0),
                    quantity_value(b.curvature_stiffness[0], s, 0), 0);
    }
    assert_near(quantity_value(made->scene.tendons[0].offset[1], 0.5, 0), 0.015, 1e-17);
    assert_true(made->scene.names == made->names);
    given->scene.point_count = SCENE_POINTS_MAX + 1;
    config *refused = NULL;
    assert_int_equal(prepare_create(&given->scene, &given->settings, &refused, &error),
                     AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "loads.points: has 17 entries"));
    given->scene.point_count = 2;
    config_free(made);
    config_free(given);
}

static void test_overrides(void **state)
{
    (void)state;
    static const char *const overrides[] = {
        "loads.points[0].force=[0, 0, -1]",
        "loads.points[0].force[1]=5",
        "tendons[1].start=null",
        "tendons[0].end=null",
        "segments[1].rest=null",
        "segments[0].section.radius=0.02",
        "bodies=null",
        "springs[0]={stiffness: [0, 2, 0]}",
        "chambers=[]",
        "segments[1].turn[0]=1.5",
        "loads.base=null",
    };
    config *given = read_text(EVERYTHING, sizeof overrides / sizeof *overrides, overrides);
    const scene *s = &given->scene;
    assert_near(s->points[0].load.force[2].number, -1, 0);
    assert_near(s->points[0].load.force[1].number, 5, 0);
    assert_false(s->tendons[1].start.is_given);
    assert_false(s->tendons[0].end.is_given);
    assert_false(s->segments[1].rod.rest_curvature[0].is_given);
    assert_near(s->segments[0].rod.radius.number, 0.02, 0);
    assert_near(s->segments[1].turn[0].number, 1.5, 0);
    assert_int_equal(s->body_count, 0);
    assert_int_equal(s->chamber_count, 0);
    assert_near(s->springs[0].stiffness[1].number, 2, 0);
    assert_near(s->springs[0].anchor[1].number, 0.1, 0); /* what is not named stays */
    assert_int_equal(s->point_count, 2);
    config_free(given);
    given = read_text(EVERYTHING, 1, (const char *const[]){"loads=null"});
    assert_int_equal(given->scene.point_count, 0);
    config_free(given);
}

/* Multiples of EI/L^2 and EI/L, here 2/0.25 and 2/0.5. */
static void test_units(void **state)
{
    (void)state;
    config *given =
        read_text("rod:\n"
                  "  length: 0.5\n"
                  "  stiffness: {shear: [5, 5], axial: 9, bending: [2, 2], torsion: 1}\n"
                  "loads:\n"
                  "  units: EI\n"
                  "  points: [{at: 0.2, force: [3, 0, 0], moment: [0, 5, 0]}]\n",
                  0, NULL);
    assert_near(given->scene.points[0].load.force[0].number, 24, 1e-14);
    assert_near(given->scene.points[0].load.moment[1].number, 20, 1e-14);
    config_free(given);
}

/* ---- tables ---------------------------------------------------------------------------------- */

#define TABLED                                                                                     \
    "rod:\n"                                                                                       \
    "  length: 0.5\n"                                                                              \
    "  stiffness: {shear: [5, 5], axial: 9, bending: [2, 2], torsion: 1}\n"                        \
    "loads: {force: [0, \"2*wind(s)\", 0]}\n"

static void put_file(const char *name, const char *content)
{
    FILE *file = fopen(at(name), "w");
    assert_non_null(file);
    fputs(content, file);
    fclose(file);
}

/* Numbers of a file, and what is written is complete without it. */
static void test_table(void **state)
{
    (void)state;
    put_file("wind.csv", "s,f\n0,1\n0.2,3\n0.5,0\n");
    put_file("rod.yaml", TABLED "tables: [{name: wind, file: wind.csv}]\n");
    config *given = read_config(at("rod.yaml"), NULL, 0, NULL);
    char *text = written(given, false);
    quantity force = given->scene.loads.force[1];
    assert_near(quantity_value(force, 0, 0), 2, 1e-15);
    assert_near(quantity_value(force, 0.2, 0), 6, 1e-15);
    assert_near(quantity_value(force, 0.5, 0), 0, 1e-15);
    double middle = quantity_value(force, 0.1, 0);
    assert_true(middle > 2 && middle < 6);
    config_free(given);
    remove(at("wind.csv"));
    given = read_text(text, 0, NULL);
    char *again = written(given, false);
    assert_string_equal(text, again);
    assert_near(quantity_value(given->scene.loads.force[1], 0.1, 0), middle, 0);
    config_free(given);
    free(text);
    free(again);
}

static void test_table_refusals(void **state)
{
    (void)state;
    static const struct {
        const char *tables, *line;
    } rows[] = {
        {"[{name: wind, x: [0, 0.4], y: [1, 2]}]",
         "scene.yaml:4:16: loads.force: goes beyond the rows of its table somewhere along the rod "
         "or in time; give a table that covers them"},
        {"[{name: wind}]",
         "override tables=[{name: wind}]: tables[0]: has no numbers; give file, or x and y"},
        {"[{x: [0, 1], y: [1, 2]}]", "override tables=[{x: [0, 1], y: [1, 2]}]: tables[0]: has no "
                                     "name; give it the one that formulas call it by"},
        {"[{name: wind, x: [0, 1], y: [1, 2, 3]}]", "override tables=[{name: wind, x: [0, 1], y: "
                                                    "[1, 2, 3]}]: tables[0]: has 2 numbers x and 3 "
                                                    "numbers y; allowed: as many"},
        {"[{name: wind, x: [0, 0], y: [1, 2]}]", NULL},
        {"[{name: sin, x: [0, 1], y: [1, 2]}]", NULL},
        {"[{name: wind, x: [0, 1], y: [1, 2], file: a.csv}]",
         "override tables=[{name: wind, x: [0, 1], y: [1, 2], file: a.csv}]: tables[0]: has a file "
         "and numbers; allowed: one of the two"},
        {"[{name: wind, file: no_such.csv}]", NULL},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char override[100];
        const char *overrides[] = {override};
        ad_error error = {.message = ""};
        config *given = NULL;
        snprintf(override, sizeof override, "tables=%s", rows[i].tables);
        assert_int_equal(prepare_read("scene.yaml", TABLED, 1, overrides, &given, &error),
                         AD_BAD_INPUT);
        if (rows[i].line) {
            assert_string_equal(error.message, rows[i].line);
        } else {
            assert_non_null(strstr(error.message, "tables[0]"));
        }
    }
}

/* ---- properties ------------------------------------------------------------------------------ */

#define MATERIAL "  material: {youngs_modulus: 1e6, poissons_ratio: 0.4, density: 1200}\n"

static void assert_same(const quantity *a, const quantity *b, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        for (double s = 0; s <= 1; s += 1.0 / 64) {
            assert_near(quantity_value(a[i], s, 0), quantity_value(b[i], s, 0), 0);
        }
    }
}

/* Sizes, material and rest shape that jump: the same numbers by the same operations. */
static void test_formulas(void **state)
{
    (void)state;
    config *pieces =
        read_text("rod:\n"
                  "  section: {shape: tube, radius: 0.01, inner_radius: 0.004}\n" MATERIAL
                  "  damping: {strain: [1, 2, 3]}\n"
                  "segments:\n"
                  "  - {length: 0.25}\n"
                  "  - length: 0.5\n"
                  "    section: {radius: \"0.02 - 0.01*s\"}\n"
                  "    material: {density: 900}\n"
                  "    rest: {curvature: [3, 0, 0], strain: [0, 0, 1.1]}\n"
                  "  - length: 0.25\n"
                  "    material: {youngs_modulus: 2e6}\n"
                  "    damping: {strain: [0, 0, 0]}\n",
                  0, NULL);
    config *formulas =
        read_text("rod:\n"
                  "  length: 1\n"
                  "  section:\n"
                  "    shape: tube\n"
                  "    radius: \"where(s - 0.25, where(s - 0.75, 0.01, 0.02 - 0.01*s), 0.01)\"\n"
                  "    inner_radius: 0.004\n"
                  "  material:\n"
                  "    youngs_modulus: \"where(s - 0.75, 2e6, 1e6)\"\n"
                  "    poissons_ratio: 0.4\n"
                  "    density: \"where(s - 0.25, where(s - 0.75, 1200, 900), 1200)\"\n"
                  "  damping: {strain: [\"where(s - 0.75, 0, 1)\", \"where(s - 0.75, 0, 2)\",\n"
                  "                     \"where(s - 0.75, 0, 3)\"]}\n"
                  "  rest:\n"
                  "    curvature: [\"where(s - 0.25, where(s - 0.75, 0, 3), 0)\", 0, 0]\n"
                  "    strain: [0, 0, \"where(s - 0.25, where(s - 0.75, 1, 1.1), 1)\"]\n",
                  0, NULL);
    scene_properties a = scene_properties_of(&pieces->scene);
    scene_properties b = scene_properties_of(&formulas->scene);
    assert_same(&a.strain_stiffness[0], &b.strain_stiffness[0], sizeof a / sizeof(quantity));
    scene_rest rest = scene_rest_of(&pieces->scene), other = scene_rest_of(&formulas->scene);
    assert_same(&rest.strain[0], &other.strain[0], sizeof rest / sizeof(quantity));
    assert_near(scene_mean(&pieces->scene, a.mass_per_length),
                scene_mean(&formulas->scene, b.mass_per_length), 2e-3); /* of samples */
    config_free(pieces);
    config_free(formulas);
}

/* A circle, then a rectangle: each piece by its own shape, the range over both. */
static void test_shapes(void **state)
{
    (void)state;
    config *given = read_text("rod:\n"
                              "  section: {shape: circle, radius: 0.01}\n" MATERIAL "segments:\n"
                              "  - {length: 0.4}\n"
                              "  - {length: 0.6, section: {shape: rectangle, width: 0.01, "
                              "height: 0.03}}\n",
                              0, NULL);
    scene_properties p = scene_properties_of(&given->scene);
    assert_near(quantity_value(p.mass_per_length, 0.39, 0), 1200 * PI * 1e-4, 1e-15);
    assert_near(quantity_value(p.mass_per_length, 0.41, 0), 1200 * 3e-4, 1e-15);
    assert_near(quantity_value(p.curvature_stiffness[0], 0.1, 0), 1e6 * PI / 4 * 1e-8, 1e-16);
    assert_near(quantity_value(p.curvature_stiffness[0], 0.9, 0), 1e6 * 0.01 * 27e-6 / 12, 1e-14);
    scene_range range = scene_range_of(&given->scene, p.mass_per_length);
    assert_near(range.low, 0.36, 1e-15);
    assert_near(range.high, 0.12 * PI, 1e-15);
    assert_near(scene_mean(&given->scene, p.mass_per_length), 0.4 * 0.12 * PI + 0.6 * 0.36, 1e-14);
    config_free(given);
}

/* Pieces that are alike are one: no formula is made. */
static void test_alike(void **state)
{
    (void)state;
    config *given = read_text("rod:\n"
                              "  section: {shape: circle, radius: 0.01}\n" MATERIAL
                              "segments: [{length: 0.4}, {length: 0.3, turn: [1, 0, 0]}, "
                              "{length: 0.3}]\n",
                              0, NULL);
    scene_properties joined = scene_properties_of(&given->scene);
    scene_properties alone = scene_rod_properties(&given->scene.rod);
    for (int i = 0; i < 3; i++) {
        assert_true(quantity_is(joined.strain_stiffness[i], alone.strain_stiffness[i].number));
        assert_true(quantity_is(joined.rotary_inertia[i], alone.rotary_inertia[i].number));
    }
    assert_true(quantity_is(scene_rest_of(&given->scene).curvature[0], 0));
    config_free(given);
}

/* ---- solutions ------------------------------------------------------------------------------- */

static void solve_positions(const config *given, size_t count, const double *s, double *values)
{
    ad_error error = {.message = ""};
    solution *x = NULL;
    solve_report report;
    solve_settings settings = solve_settings_default(&given->scene);
    double t[16] = {0};
    if (solution_create(&given->scene, &settings, 0, NULL, &x, &report, &error) != AD_OK ||
        solution_evaluate(x, 3, count, s, t, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_near(report.load_fraction, 1, 0);
    solution_free(x);
}

/* Two rods that say the same deform alike, to what the solver is asked for. */
static void test_solved_alike(void **state)
{
    (void)state;
    static const double s[4] = {0.2, 0.37, 0.6, 1};
#define LOADED "loads: {tip: {force: [0, 0.004, 0.002]}}\n"
    config *pieces = read_text("rod:\n"
                               "  section: {shape: circle, radius: 0.01}\n" MATERIAL "segments:\n"
                               "  - {length: 0.37}\n"
                               "  - {length: 0.63, material: {youngs_modulus: 1e5}, "
                               "rest: {curvature: [2, 0, 0]}}\n" LOADED,
                               0, NULL);
    config *formulas = read_text("rod:\n"
                                 "  length: 1\n"
                                 "  section: {shape: circle, radius: 0.01}\n"
                                 "  material: {youngs_modulus: \"where(0.37 - s, 1e6, 1e5)\", "
                                 "poissons_ratio: 0.4, density: 1200}\n"
                                 "  rest: {curvature: [\"where(0.37 - s, 0, 2)\", 0, 0]}\n" LOADED,
                                 0, NULL);
    double a[12], b[12], bent = 0;
    solve_positions(pieces, 4, s, a);
    solve_positions(formulas, 4, s, b);
    for (int i = 0; i < 12; i++) {
        assert_near(a[i], b[i], 2e-10);
        bent = fmax(bent, fabs(a[i] - (i >= 8 ? s[i - 8] : 0)));
    }
    assert_true(bent > 0.1);
    config_free(pieces);
    config_free(formulas);
}

/* ---- on both sides of a jump ----------------------------------------------------------------- */

/* A rod of E I = 2, and 6 beyond a joint at s = 0.3, bent in its plane by moments: 0.75 before the
 * joint, 0.5 behind it, 0.25 beyond s = 0.7. */
#define SIDES_OF(more)                                                                             \
    "rod:\n  stiffness: {shear: [1e6, 1e6], axial: 1e6, torsion: 2, bending: [2, 2]}\n"            \
    "  inertia: {mass_per_length: 1, rotary: [1e-3, 1e-3, 2e-3]}\n"                                \
    "segments:\n  - {length: 0.3}\n"                                                               \
    "  - {length: 0.7, stiffness: {bending: [6, 6]}, turn: [0.4, 0, 0],\n"                         \
    "     rest: {curvature: [0.2, 0, 0]}}\n"                                                       \
    "loads: {tip: {moment: [0.25, 0, 0]}, points: [{at: 0.3, moment: [0.25, 0, 0]}, "              \
    "{at: 0.7, moment: [0.25, 0, 0]}]}\n" more

enum { SIDES = 9, CURVATURE = 10, MOMENT = 16 }; /* of the columns */

/* At places as grids hit them, with rounding: u = u* + m/(E I), all of the side before them. */
static void test_sides(void **state)
{
    (void)state;
    const double s[SIDES] = {
        0, nextafter(0.3, 0), 0.3, nextafter(0.3, 1), 0.5, 0.7, nextafter(0.7, 1), 0.71, 1};
    for (int run = 0; run < 2; run++) { /* at rest, and in motion */
        config *given =
            read_text(run < 1 ? SIDES_OF("") : SIDES_OF("time: {duration: 0.2}\n"), 0, NULL);
        ad_error error = {.message = ""};
        solution *x = NULL;
        solve_report report;
        solve_settings settings = solve_settings_default(&given->scene);
        double t[SIDES], values[19 * SIDES];
        for (int i = 0; i < SIDES; i++) {
            t[i] = 0.2;
        }
        settings.tolerance = run == 1 ? 1e-3 : 1e-12;
        if (solution_create(&given->scene, &settings, 1, t, &x, &report, &error) != AD_OK ||
            solution_evaluate(x, 19, SIDES, s, t, values, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        for (int i = 0; i < SIDES; i++) {
            const bool stiff = s[i] > 0.3;
            const double m = values[MOMENT * SIDES + i], u = values[CURVATURE * SIDES + i];
            assert_near(u, stiff ? 0.2 + m / 6 : m / 2, 1e-11);
            if (run < 1) {
                assert_near(m, s[i] > 0.7 ? 0.25 : stiff ? 0.5 : 0.75, 1e-11);
            }
        }
        solution_free(x);
        config_free(given);
    }
}

/* ---- the unstressed shape -------------------------------------------------------------------- */

enum { PLACES = 7 };
static const double places[PLACES] = {0.1, 0.29, 0.31, 0.5, 0.59, 0.61, 1};

/* r [3][PLACES], q [4][PLACES] of the unstressed rod on the tape, over the length. */
static void undeformed(const scene *given, double *r, double *q)
{
    recorded on = begin(given);
    rod_context rod = rod_context_of(given, &on.at);
    rod_pose pose = rod_undeformed(&rod, on.s);
    double *values = evaluate_at(pose.position, PLACES, places, places, NULL);
    memcpy(r, values, 3 * PLACES * sizeof *r);
    free(values);
    values = evaluate_at(pose.rotation, PLACES, places, places, NULL);
    memcpy(q, values, 4 * PLACES * sizeof *q);
    free(values);
    ad_tape_free(on.tape);
}

typedef struct arc {
    double from, curvature, turn;
} arc;

/* Arcs in the plane y, z: d3 = (0, -sin a, cos a) at the angle a about x. A place where arcs meet
 * belongs to the one before. */
static void arcs_at(int count, const arc *arcs, double s, double point[3], double *angle)
{
    *angle = 0;
    point[0] = point[1] = point[2] = 0;
    for (int i = 0; i < count && (i == 0 || s > arcs[i].from); i++) {
        double to = i + 1 < count ? fmin(s, arcs[i + 1].from) : s, k = arcs[i].curvature;
        double before = *angle + arcs[i].turn, after = before + k * (to - arcs[i].from);
        point[1] += (cos(after) - cos(before)) / k;
        point[2] += (sin(after) - sin(before)) / k;
        *angle = after;
    }
}

static void check_arcs(const config *given, int count, const arc *arcs)
{
    double r[3 * PLACES], q[4 * PLACES];
    undeformed(&given->scene, r, q);
    for (int i = 0; i < PLACES; i++) {
        double point[3], angle;
        arcs_at(count, arcs, places[i], point, &angle);
        for (int k = 0; k < 3; k++) { /* rounding of some hundred steps along the rod */
            assert_near(r[k * PLACES + i], point[k], 1e-13);
        }
        double half[2] = {cos(angle / 2), sin(angle / 2)};
        double sign = q[i] * half[0] + q[PLACES + i] * half[1] < 0 ? -1 : 1;
        assert_near(q[i], sign * half[0], 1e-13);
        assert_near(q[PLACES + i], sign * half[1], 1e-13);
    }
    solve_place ends[2];
    double tip[3], angle;
    arcs_at(count, arcs, 1, tip, &angle);
    assert_int_equal(solve_start(&given->scene, ends, NULL), AD_OK);
    for (int k = 0; k < 3; k++) {
        assert_near(ends[1].position[k], tip[k], 1e-13);
    }
}

#define BARE                                                                                       \
    "  stiffness: {shear: [5, 5], axial: 9, bending: [1, 1], torsion: 0.8}\nmotion: spatial\n"

static void test_arcs(void **state)
{
    (void)state;
    static const arc arcs[3] = {{0, 2, 0}, {0.3, -3, 0.7}, {0.6, 5, -4}};
    config *given =
        read_text("rod:\n" BARE "segments:\n"
                  "  - {length: 0.3, rest: {curvature: [2, 0, 0]}}\n"
                  "  - {length: 0.3, rest: {curvature: [-3, 0, 0]}, turn: [0.7, 0, 0]}\n"
                  "  - {length: 0.4, rest: {curvature: [5, 0, 0]}, turn: [-4, 0, 0]}\n",
                  0, NULL);
    check_arcs(given, 3, arcs);
    config_free(given);
}

/* The same arcs by a formula that switches, without joints: polynomials between the places. */
static void test_switching(void **state)
{
    (void)state;
    static const arc arcs[3] = {{0, 2, 0}, {0.3, -3, 0}, {0.6, 5, 0}};
    config *given = read_text(
        "rod:\n"
        "  length: 1\n"
        "  rest: {curvature: [\"where(0.3 - s, 2, where(s - 0.6, 5, -3))\", 0, 0]}\n" BARE,
        0, NULL);
    check_arcs(given, 3, arcs);
    config_free(given);
}

/* A curve in space by polynomials: one piece, and cut in two where nothing changes. */
static void test_cut(void **state)
{
    (void)state;
    static const char whole[] = "rod:\n"
                                "  length: 1\n"
                                "  rest: {curvature: [\"3*sin(4*s)\", 2, \"5*s\"]}\n" BARE;
    config *one = read_text(whole, 0, NULL);
    config *two =
        read_text(whole, 1, (const char *const[]){"segments=[{length: 0.45}, {length: 0.55}]"});
    double r[2][3 * PLACES], q[2][4 * PLACES];
    undeformed(&one->scene, r[0], q[0]);
    undeformed(&two->scene, r[1], q[1]);
    for (int i = 0; i < 3 * PLACES; i++) { /* of order 4, the longest of 640 steps 1/400 */
        assert_near(r[0][i], r[1][i], 1e-10);
    }
    for (int i = 0; i < 4 * PLACES; i++) {
        assert_near(q[0][i], q[1][i], 1e-10);
    }
    assert_true(fabs(r[0][PLACES - 1]) > 0.1);
    config_free(one);
    config_free(two);
}

/* ---- the plane ------------------------------------------------------------------------------- */

/* Everything at once lies in a plane; one entry of any list leaves it. */
static void test_plane(void **state)
{
    (void)state;
    static const struct {
        const char *override, *leaves; /* NULL: it stays */
    } rows[] = {
        {"name=all", NULL},
        {"segments[1].turn=[0.5, 0, 0.1]", "segments[1].turn"},
        {"segments[0].rest.curvature=[0, 0, 1]", "segments[0].rest.curvature"},
        {"segments[0].rest.strain=[0.1, 0, 1]", "segments[0].rest.strain"},
        {"loads.points[0].force=[0.1, 0, 0]", "loads.points[0].force"},
        {"loads.points[1].moment=[0, 1, 0]", "loads.points[1].moment"},
        {"loads.points[1].force=[1, 0, 0]", "loads.points[1].force"},
        {"springs[0].anchor=[0.1, 0, 0]", "springs[0].anchor"},
        {"springs[0].stiffness=[3, 1, 2]", NULL}, /* an axis is normal to the plane */
        {"springs[0].turning=[3, 1, 2]", NULL},
        {"tendons[1].offset=[1e-9, 0.01]", "tendons[1].offset"},
        {"tendons[1].offset=[0*s, 0.01]", "tendons[1].offset"}, /* a formula across it leaves */
        {"tendons[1].offset=[1e-9*s, 0.01]", "tendons[1].offset"},
        {"chambers[0].offset=[0.01, 0]", "chambers[0].offset"},
        {"boundary.start.rotation=[0.9, 0.1, 0, 0.2]", "loads.points[0].force"},
        {"loads.gravity=[0, 9.81, 0]", NULL}, /* the weight of bodies, too */
        {"loads.gravity=[9.81, 0, 0]", "loads.gravity"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        config *given = read_text(EVERYTHING, 1, &rows[i].override);
        rod_plane plane = rod_plane_of(&given->scene);
        if (plane.is_planar != (rows[i].leaves == NULL)) {
            fail_msg("%s: %s", rows[i].override, plane.is_planar ? "planar" : plane.leaves);
        }
        if (rows[i].leaves) {
            assert_string_equal(plane.leaves, rows[i].leaves);
        } else {
            assert_int_equal(plane.director, 0);
        }
        config_free(given);
    }
}

/* Stiffness that differs along the world's axes turns a spring out of a skew plane. */
static void test_skew_spring(void **state)
{
    (void)state;
    static const char text[] =
        "rod:\n"
        "  length: 1\n"
        "  stiffness: {shear: [5, 5], axial: 9, bending: [1, 1], torsion: 1}\n"
        "boundary: {start: {rotation: [0.8, 0, 0, 0.6]}}\n" /* about z */
        "springs: [{at: 1, stiffness: [2, 2, 3]}]\n";
    config *given = read_text(text, 0, NULL);
    assert_true(rod_plane_of(&given->scene).is_planar);
    config_free(given);
    given = read_text(text, 1, (const char *const[]){"springs[0].stiffness[0]=1"});
    assert_string_equal(rod_plane_of(&given->scene).leaves, "springs[0].stiffness");
    config_free(given);
}

/* ---- in words -------------------------------------------------------------------------------- */

static void test_words(void **state)
{
    (void)state;
    static const char *const lines[] = {
        "segments[0]: length 0.4; 0 to 0.4 m, circle",
        ("segments[1]: length 0.6; section.width 0.01; section.height 0.02; rest.curvature 2*s, 0, "
         "0; turn 0.5, 0, 0; 0.4 to 1 m, rectangle"),
        "loads.points[0]: at 0.3; force 0, load*t, 0; dead",
        "loads.points[1]: at 0.5; moment 0.01, 0, 0; follower",
        "bodies[0]: at 1; mass 0.2",
    };
    config *given = read_text(EVERYTHING, 0, NULL);
    char text[200], few[20];
    for (int i = 0; i < 5; i++) {
        assert_true(scene_entry_text(&given->scene, i, text, sizeof text));
        assert_string_equal(text, lines[i]);
    }
    assert_true(scene_entry_text(&given->scene, 9, text, sizeof text));
    assert_true(scene_entry_text(&given->scene, 1, few, sizeof few));
    assert_string_equal(few, "segments[1]: length");
    assert_false(scene_entry_text(&given->scene, 10, text, sizeof text));
    config_free(given);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reading),
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_by_hand),
        cmocka_unit_test(test_overrides),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_table),
        cmocka_unit_test(test_table_refusals),
        cmocka_unit_test(test_formulas),
        cmocka_unit_test(test_shapes),
        cmocka_unit_test(test_alike),
        cmocka_unit_test(test_solved_alike),
        cmocka_unit_test(test_sides),
        cmocka_unit_test(test_arcs),
        cmocka_unit_test(test_switching),
        cmocka_unit_test(test_cut),
        cmocka_unit_test(test_plane),
        cmocka_unit_test(test_skew_spring),
        cmocka_unit_test(test_words),
    };
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
