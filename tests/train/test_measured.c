/* Measured data as terms of the loss. */
#include "fewer.h"
#include "trainer_testing.h"

#include "physics/solve/solve.h"
#include "tools/files/table_file.h"
#include "tools/train/measured_terms.h"

#define ROD                                                                                        \
    "rod: {model: kirchhoff, length: 0.3, section: {shape: circle, radius: 0.005}, "               \
    "material: {youngs_modulus: 1.0e7, poissons_ratio: 0.45, density: 1070}}\n"                    \
    "boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}}\n"
#define BEAM                                                                                       \
    "rod: {model: euler_bernoulli, length: 1, section: {shape: rectangle, width: 0.02, "           \
    "height: 0.01}, material: {youngs_modulus: 1.0e9, poissons_ratio: 0.3, density: 1000}}\n"      \
    "boundary: {start: {type: clamped}, end: {type: pinned}}\n"

static char path[2][80]; /* of data, of what they are compared with */

static config *read_text(const char *text, ad_error *error)
{
    config *read = NULL;
    return prepare_read("scene.yaml", text, 0, NULL, &read, error) == AD_OK ? read : NULL;
}

/* A classical solution at equal distances, with the columns that it has. */
static void solve_to(const char *file, const char *text, size_t ns, size_t nt)
{
    enum { ROWS = 1000, COLUMNS = 25 };
    static double s[ROWS], t[ROWS], times[ROWS], values[COLUMNS * ROWS];
    const char *names[COLUMNS + 2] = {"s", "t"};
    const double *columns[COLUMNS + 2] = {s, t};
    ad_error error = {AD_OK, ""};
    solve_settings settings = {.tolerance = nt > 1 ? 1e-5 : 1e-9};
    solve_report report;
    solution *solved = NULL;
    config *read = read_text(text, &error);
    assert_non_null(read);
    const scene_physics *physics = scene_physics_of(&read->scene);
    size_t count = scene_is_beam(&read->scene) ? 4 : 19;
    for (size_t i = 0; i < nt; i++) {
        times[i] = nt > 1 ? scene_duration(&read->scene) * (double)i / (double)(nt - 1) : 0;
    }
    for (size_t i = 0; i < ns * nt; i++) {
        s[i] = scene_length(&read->scene) * (double)(i % ns) / (double)(ns - 1);
        t[i] = times[i / ns];
    }
    if (solution_create(&read->scene, &settings, nt > 1 ? nt : 0, nt > 1 ? times : NULL, &solved,
                        &report, &error) != AD_OK ||
        solution_evaluate(solved, (int)count, ns * nt, s, t, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (size_t k = 0; k < count; k++) {
        names[2 + k] = physics->columns[k].name;
        columns[2 + k] = values + k * ns * nt;
    }
    const table_source table = {
        .names = names, .columns = columns, .ncols = count + 2, .nrows = ns * nt};
    assert_int_equal(table_write(file, &table, NULL), AD_OK);
    solution_free(solved);
    config_free(read);
}

static run start_text(const char *text, int threads)
{
    run r = {.made = {NULL, NULL}};
    ad_error error = {AD_OK, ""};
    config *settings = read_text(text, &error);
    if (!settings || config_experiment_create(settings, threads, &r.made.e, &error) != AD_OK ||
        experiment_problem(r.made.e, &r.made.p, &error) != AD_OK ||
        reference_create(r.made.e, &r.known, &error) != AD_OK ||
        trainer_create(r.made.e, r.made.p, r.known, 0, &r.trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return r;
}

/* `physics` with data of the quantity from path[0], against path[1]. */
static void describe(char text[2000], const char *physics, const char *quantity, bool measured)
{
    char data[200] = "";
    if (measured) {
        snprintf(data, sizeof data, "data: [{quantity: %s, file: %s}]\n", quantity, path[0]);
    }
    snprintf(text, 2000, "%slosses: {interior: {weights: {force: 0}}}\n%sreference: {file: %s}\n",
             physics, data, path[1]);
}

/* A load that the scene does not have, and whose equation has no weight, is made up for by data:
 * errors of the position over the length. Without data the rod stays where it is. */
static void check_unknown_load(const char *physics, const char *load, const char *quantity,
                               size_t instants, double allowed)
{
    char text[2000];
    snprintf(text, sizeof text, "%s%s", physics, load);
    solve_to(path[0], text, 21, instants);
    solve_to(path[1], text, 33, instants > 1 ? instants - 2 : 1);
    for (int measured = 0; measured < 2; measured++) {
        describe(text, physics, quantity, measured);
        run r = start_text(text, 1);
        finish(&r);
        fit_add_row(trainer_fit(r.trainer), NULL);
        const trainer_info *info = trainer_inspect(r.trainer);
        assert_true(measured ? info->errors.position < allowed : info->errors.position > 2e-3);
        assert_true(isfinite(history_value(&trainer_fit(r.trainer)->rows, 0, "data0_position")) ==
                    (measured && strcmp(quantity, "position") == 0));
        stop(&r);
    }
}

static void test_unknown_load(void **state)
{
    (void)state;
    static const char load[] = "loads: {force: [0, 0, \"-0.4*sin(pi*s/0.3)\"]}\n";
    check_unknown_load(ROD, load, "position", 1, 1e-4); /* measured 3e-6 */
    check_unknown_load(ROD, load, "rotation", 1, 1e-4);
    check_unknown_load(BEAM, "beam: {force: \"-sin(pi*s)\"}\n", "position", 1, 1e-4);
}

static void test_unknown_motion(void **state)
{
    (void)state;
    static const char load[] = "loads: {force: [0, 0, \"-0.4*sin(pi*s/0.3)*sin(60*t)^2\"]}\n";
    check_unknown_load(ROD "time: {duration: 0.05, windows: 2}\n", load, "position", 11, 1e-3);
}

/* From every step of a run in two windows the same bits. */
static void test_resume(void **state)
{
    (void)state;
    char text[2000];
    ad_error error = {AD_OK, ""};
    FILE *file = fopen(path[0], "w");
    assert_non_null(file);
    fputs("s,t,x,y,z,m1,m2,m3\n0.1,0.02,0.1,0,0,0,0.01,0\n0.2,0.1,0.2,0,-0.01,0,0,0\n"
          "0.3,0.07,0.3,0,-0.01,0,0,0\n",
          file);
    fclose(file);
    snprintf(text, sizeof text,
             ROD "time: {duration: 0.1, windows: 2}\nloads: {gravity: [0, 0, -9]}\n"
                 "network: {hidden: [5], fourier: {features: 0}}\n"
                 "losses: {interior: {points: 20}, held_out_points: 10}\noutput: {every: 2}\n"
                 "training: {stages: [{optimizer: adam, steps: 4}, "
                 "{optimizer: gauss_newton, steps: 3}]}\n"
                 "data: [{quantity: position, file: %s, noise: 0.001}, "
                 "{quantity: moment, weight: 2, file: %s}]\n",
             path[0], path[0]);
    run whole = start_text(text, 1);
    for (int i = 0; i < 9; i++) {
        step(&whole);
    }
    save(&whole, "half.h5");
    finish(&whole);
    run again = start_text(text, 2);
    if (restore(&again, in_folder("half.h5"), &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    finish(&again);
    assert_memory_equal(whole.made.e->parameters, again.made.e->parameters,
                        2 * whole.made.e->count * sizeof(double));
    unlink(in_folder("half.h5"));
    stop(&whole);
    stop(&again);
}

/* Terms of a network that is 0 everywhere, of measurements with what cameras leave out. */
static double loss_of(const char *rows, size_t *missing)
{
    char text[1000];
    double loss;
    FILE *file = fopen(path[0], "w");
    assert_non_null(file);
    fputs(rows, file);
    fclose(file);
    snprintf(text, sizeof text, ROD "data: [{quantity: position, file: %s, noise: 0.5}]\n",
             path[0]);
    run r = start_text(text, 1);
    double *nothing = calloc(r.made.e->count, sizeof *nothing);
    assert_int_equal(problem_evaluate(r.made.p, nothing, &loss, NULL, NULL), AD_OK);
    loss = problem_losses(r.made.p)[problem_terms(r.made.p) - 1];
    *missing = measured_fields_missing(r.made.e->measured);
    assert_int_equal(measured_missing(r.made.e->measured), *missing > 0);
    free(nothing);
    stop(&r);
    return loss;
}

/* The straight rod is at (s, 0, 0): misses of 1 along z in two rows, one of 2 along y in one of
 * them, over a noise of a half. What is missing, and columns that nobody asks for, change nothing
 * but the number of rows that the mean is of. */
static void test_lost_markers(void **state)
{
    (void)state;
    size_t missing;
    assert_true(fabs(loss_of("s,x,y,z\n0.1,0.1,0,1\n0.2,0.2,2,1\n", &missing) - 12) < 1e-12);
    assert_int_equal(missing, 0);
    assert_true(fabs(loss_of("frame,s,x,y,z,remark\n"
                             "a.png,0.1,0.1,,1,\n"
                             "b.png,0.15,nan,,NaN,\"lost, it seems\"\n"
                             "c.png,0.2,0.2,2,1,7\n",
                             &missing) -
                     12) < 1e-12);
    assert_int_equal(missing, 4);
}

/* The mean square of the angles between the rotations of a file and those of the rod without a
 * network, over the noise, from nothing to half a turn and of both signs. */
static void test_angles(void **state)
{
    (void)state;
    static const double angles[] = {0, 1e-9, 1e-3, 0.0199, 0.02, 0.0201, 1, 3.1, 3.141592653589793};
    enum { COUNT = sizeof angles / sizeof *angles };
    const double root = sqrt(0.5);
    char text[2000];
    double sum = 0, loss;
    FILE *file = fopen(path[0], "w");
    assert_non_null(file);
    fprintf(file, "s,qw,qx,qy,qz\n");
    for (int i = 0; i < COUNT; i++) { /* (0, 1, 0, 1) turned about a body axis */
        double c = cos(angles[i] / 2) * (i % 2 ? -1 : 1), d = sin(angles[i] / 2) * (i % 2 ? -1 : 1);
        const double p[4] = {0, root, 0, root}, n[3] = {0.6 * d, 0, -0.8 * d};
        fprintf(file, "%g,%.17g,%.17g,%.17g,%.17g\n", 0.03 * i,
                p[0] * c - p[1] * n[0] - p[2] * n[1] - p[3] * n[2],
                p[0] * n[0] + c * p[1] + p[2] * n[2] - p[3] * n[1],
                p[0] * n[1] + c * p[2] + p[3] * n[0] - p[1] * n[2],
                p[0] * n[2] + c * p[3] + p[1] * n[1] - p[2] * n[0]);
        sum += angles[i] * angles[i] / COUNT;
    }
    fclose(file);
    snprintf(text, sizeof text,
             ROD "motion: spatial\ndata: [{quantity: rotation, file: %s, noise: 0.5}]\n", path[0]);
    run r = start_text(text, 1);
    double *nothing = calloc(r.made.e->count, sizeof *nothing);
    assert_int_equal(problem_evaluate(r.made.p, nothing, &loss, NULL, NULL), AD_OK);
    int last = problem_terms(r.made.p) - 1;
    assert_string_equal(problem_term_name(r.made.p, last), "data0_rotation");
    assert_true(fabs(problem_losses(r.made.p)[last] - sum / 0.25) < 1e-12 * sum); /* rounding */
    free(nothing);
    stop(&r);
}

/* ---- refusals ----------------------------------------------------------------------------------
 */

static void test_refusals(void **state)
{
    (void)state;
    static const struct {
        const char *rows, *quantity, *message; /* "FILE" stands for the path */
    } bad[] = {
        {"s,x,y,z\n", "position", "data[0].file: FILE: there are no rows; at least one is needed"},
        {"x,y,z\n1,2,3\n", "position",
         "data[0].file: FILE: column 's' is missing; the place along the rod in m"},
        {"s,x,z\n0.1,2,3\n", "position",
         "data[0].file: FILE: column 'y' is missing; of a quantity all columns are needed"},
        {"s,x,y,z\n0.1,2,3,4\n0.4,1,2,3\n", "position",
         "data[0].file: FILE:3: s is 0.4; allowed: 0 to 0.3"},
        {"s,x,y,z\n\n0.1,inf,3,4\n", "position",
         "data[0].file: FILE:3:5: 'inf': the field is not finite; allowed: a decimal number such "
         "as -1.5e-3, or nan or nothing where it is missing"},
        {"s,x,y,z\n0.1,0.1,0,0\n0.2,lost,3,4\n", "position",
         "data[0].file: FILE:3:5: 'lost': the field is not a number; allowed: a decimal number "
         "such as -1.5e-3, or nan or nothing where it is missing"},
        {"s,x,y,z\n0.1,0.1,0,0\n,1,2,3\n", "position",
         "data[0].file: FILE:3: column 's' has no number; allowed there: a number in each row"},
        {"s,x,y,z\n0.1,,nan,\n", "position",
         "data[0].file: FILE: in every row a number is missing; at least one row is needed"},
        {"s,qw,qx,qy,qz\n0.1,1,0,0,0\n0.2,,,,\n0.3,0,1,0,1\n", "rotation",
         "data[0].file: FILE:4: the length of qw to qz is 1.41421; allowed: 0.999 to 1.001"},
        {"s,x,y,z\n0.1,99,3,4\n0.2,190,9,-21\n0.3,260,14,-80\n", "position",
         "data[0].file: FILE: positions lie some 908 times the length, 0.3 m, from where the rod "
         "is held; they are in m, not in mm; columns: {x: x/1000, y: y/1000, z: z/1000} reads mm"},
        {"s,qw,qx,qy,qz\n0.1,0,1,0,1\n", "rotation",
         "data[0].file: FILE:2: the length of qw to qz is 1.41421; allowed: 0.999 to 1.001"},
        {"s,vx,vy,vz\n0.1,0,1,0\n", "velocity", "data[0].quantity: this scene has no velocity"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char text[1000], wanted[400];
        ad_error error = {AD_OK, ""};
        experiment *e = NULL;
        problem *p = NULL;
        FILE *file = fopen(path[0], "w");
        fputs(bad[i].rows, file);
        fclose(file);
        snprintf(text, sizeof text, ROD "data: [{quantity: %s, file: %s}]\n", bad[i].quantity,
                 path[0]);
        config *settings = read_text(text, &error);
        assert_non_null(settings);
        assert_int_equal(config_experiment_create(settings, 1, &e, &error), AD_OK);
        assert_int_equal(experiment_problem(e, &p, &error), AD_BAD_INPUT);
        const char *name = strstr(bad[i].message, "FILE");
        snprintf(wanted, sizeof wanted, "%.*s%s%s",
                 (int)(name ? name - bad[i].message : (long)strlen(bad[i].message)), bad[i].message,
                 name ? path[0] : "", name ? name + 4 : "");
        const char *found = strstr(error.message, "data[0]");
        assert_non_null(found);
        assert_string_equal(found, wanted);
        assert_memory_equal(error.message, "scene.yaml:3:", 13);
        experiment_free(e);
    }
}

static int make_files(void **state)
{
    int result = make_folder(state);
    snprintf(path[0], sizeof path[0], "%s/data.csv", folder);
    snprintf(path[1], sizeof path[1], "%s/truth.csv", folder);
    return result;
}

static int remove_files(void **state)
{
    unlink(path[0]);
    unlink(path[1]);
    return remove_folder(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_unknown_load),
                                       cmocka_unit_test(test_resume), cmocka_unit_test(test_angles),
                                       cmocka_unit_test(test_lost_markers),
                                       cmocka_unit_test(test_refusals)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_unknown_motion)};
    return run_with_alike(tests, alike, make_files, remove_files);
}
