/* What a scene is compared with, and the numbers of the comparison. */
#include "evaluate.h"
#include "temporary_folder.h"
#include "training_testing.h"

#include "physics/learn/analytic.h"
#include "tools/files/table_file.h"
#include "tools/train/reference.h"

#define PI 3.14159265358979323846

/* Rounding of sums over some thousand numbers of order 1. */
static const double rounding = 1e-12;

static reference *reference_of(const experiment *e)
{
    ad_error error = {.message = ""};
    reference *r = NULL;
    if (reference_create(e, &r, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return r;
}

static reference_errors compare(reference *r, const experiment *e)
{
    reference_errors errors;
    assert_int_equal(reference_compare(r, e->parameters, &errors, NULL), AD_OK);
    return errors;
}

/* ---- angles -------------------------------------------------------------------------------- */

static void test_angles(void **state)
{
    (void)state;
    static const double angles[] = {0, 1e-12, 1e-5, 0.3, 1, 3, PI - 1e-7, PI};
    const double axis[3] = {2.0 / 7, -3.0 / 7, 6.0 / 7};
    const double p[4] = {0.5, -0.5, 0.5, 0.5};
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        double c = cos(angles[i] / 2), s = sin(angles[i] / 2);
        double x = s * axis[0], y = s * axis[1], z = s * axis[2];
        /* p (c, x, y, z) */
        const double q[4] = {
            p[0] * c - p[1] * x - p[2] * y - p[3] * z, p[0] * x + c * p[1] + p[2] * z - p[3] * y,
            p[0] * y + c * p[2] + p[3] * x - p[1] * z, p[0] * z + c * p[3] + p[1] * y - p[2] * x};
        const double minus[4] = {-q[0], -q[1], -q[2], -q[3]};
        assert_near(reference_angle(p, q), angles[i], 1e-15 + 4e-16 * angles[i]);
        assert_near(reference_angle(q, p), angles[i], 1e-15 + 4e-16 * angles[i]);
        assert_near(reference_angle(p, minus), angles[i], 1e-15 + 4e-16 * angles[i]);
    }
}

/* ---- closed forms -------------------------------------------------------------------------- */

typedef void (*closed_form)(const scene *scene, double s, analytic_state *state);

/* The numbers of configs/elastica.yaml, rollup.yaml and helix.yaml, worked out here anew. */
static const analytic_clamp along_x = {{0, 0, 0}, {0, 0.70710678118654752, 0, 0.70710678118654752}};

static void elastica_form(const scene *scene, double s, analytic_state *state)
{
    const double length = 0.3, stiffness = 1e6 * PI / 4 * pow(0.005, 4);
    const double force[3] = {0, 0, -stiffness / (length * length)};
    analytic_elastica elastica;
    (void)scene;
    analytic_elastica_create(&along_x, length, stiffness, force, &elastica, NULL);
    analytic_elastica_at(&elastica, s, state);
}

static void rollup_form(const scene *scene, double s, analytic_state *state)
{
    const double length = 0.25, stiffness = 6e10 * PI / 4 * (pow(0.5e-3, 4) - pow(0.4e-3, 4));
    const double couple[3] = {0, -2 * PI * stiffness / length, 0};
    (void)scene;
    analytic_rollup_at(&along_x, stiffness, couple, s, state, NULL);
}

static void helix_form(const scene *scene, double s, analytic_state *state)
{
    const analytic_clamp upright = {{0, 0, 0}, {1, 0, 0, 0}};
    const double length = 0.2, stiffness = 2e11 * PI / 4 * pow(0.5e-3, 4);
    const double couple[3] = {0, 3 * stiffness / length, 4 * stiffness / length};
    (void)scene;
    analytic_helix_at(&upright, stiffness, stiffness / 1.3, couple, s, state, NULL);
}

enum { POSE = 7 };
static const char *const pose_names[POSE] = {"x", "y", "z", "qw", "qx", "qy", "qz"};

/* The errors of the untrained network against the form, by plain sums. */
static reference_errors expected_errors(const experiment *e, closed_form form)
{
    double s[101], values[POSE * 101], off = 0, size = 0, angles = 0;
    reference_errors expected = {0};
    field *f = NULL;
    double length = scene_length(e->scene);
    for (int i = 0; i < 101; i++) {
        s[i] = length * i / 100;
    }
    assert_int_equal(field_create(e->model, e->mlp, true, e->pool, &f, NULL), AD_OK);
    assert_int_equal(
        field_evaluate(f, e->parameters, 101, (const double *const[]){s}, values, NULL), AD_OK);
    for (int i = 0; i < 101; i++) {
        analytic_state exact;
        double square = 0, q[4];
        form(e->scene, s[i], &exact);
        for (int k = 0; k < 3; k++) {
            square += pow(values[k * 101 + i] - exact.position[k], 2);
            size += exact.position[k] * exact.position[k];
        }
        for (int k = 0; k < 4; k++) {
            q[k] = values[(3 + k) * 101 + i];
        }
        double angle = reference_angle(q, exact.quaternion);
        off += square;
        angles += angle * angle;
        expected.rotation_max = fmax(expected.rotation_max, angle);
        expected.position_max = fmax(expected.position_max, sqrt(square) / length);
        expected.tip = sqrt(square) / length; /* the last one stays */
    }
    expected.position = sqrt(off / size);
    expected.rotation = sqrt(angles / 101);
    field_free(f);
    return expected;
}

static void test_closed_forms(void **state)
{
    static const struct {
        const char *path, *name;
        closed_form form;
    } rows[] = {{"configs/elastica.yaml", "elastica", elastica_form},
                {"configs/rollup.yaml", "rollup", rollup_form},
                {"configs/helix.yaml", "helix", helix_form}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        experiment *e = experiment_of(rows[i].path, NULL, NULL);
        reference *r = reference_of(e);
        reference_errors errors = compare(r, e);
        reference_errors expected = expected_errors(e, rows[i].form);
        assert_string_equal(reference_name(r), rows[i].name);
        assert_int_equal(reference_points(r), 101);
        assert_int_equal(reference_left_out(r), 0);
        assert_near(errors.position, expected.position, rounding);
        assert_near(errors.position_max, expected.position_max, rounding);
        assert_near(errors.tip, expected.tip, rounding);
        assert_near(errors.rotation, expected.rotation, rounding);
        assert_near(errors.rotation_max, expected.rotation_max, 1e-7); /* near pi: sqrt(epsilon) */
        reference_free(r);
        experiment_free(e);
    }
}

/* ---- manufactured -------------------------------------------------------------------------- */

static void test_manufactured(void **state)
{
    (void)state;
    experiment *e = experiment_of("configs/manufactured_dynamic.yaml", NULL, "time.windows=1");
    reference *r = reference_of(e);
    reference_errors errors = compare(r, e);
    field *f = NULL;
    double off = 0, size = 0, tip = 0;
    assert_int_equal(reference_points(r), 41 * 41);
    assert_int_equal(field_create(e->model, e->mlp, true, e->pool, &f, NULL), AD_OK);
    for (int i = 0; i < 41 * 41; i++) {
        double s = i % 41 / 40.0, t = i / 41 / 40.0, values[POSE], square = 0;
        const double exact[3] = {0.3 * s * s * cos(2 * t) + 0.1 * s * s * s,
                                 0.2 * s * s * sin(3 * t), s + 0.05 * s * s * sin(t)};
        assert_int_equal(
            field_evaluate(f, e->parameters, 1, (const double *const[]){&s, &t}, values, NULL),
            AD_OK);
        for (int k = 0; k < 3; k++) {
            square += pow(values[k] - exact[k], 2);
            size += exact[k] * exact[k];
        }
        off += square;
        tip = s == 1 ? fmax(tip, sqrt(square)) : tip;
    }
    assert_near(errors.position, sqrt(off / size), rounding);
    assert_near(errors.tip, tip, rounding);
    assert_true(errors.rotation > 0 && errors.rotation <= errors.rotation_max);
    field_free(f);
    reference_free(r);
    experiment_free(e);
}

/* ---- files --------------------------------------------------------------------------------- */

static const char static_rod[] = "rod: {length: 2, stiffness: {bending: [1, 1], torsion: 1, "
                                 "shear: [100, 100], axial: 100}}\n"
                                 "network: {hidden: [6]}\n";
static const char moving_rod[] = "rod: {length: 2, stiffness: {bending: [1, 1], torsion: 1, "
                                 "shear: [100, 100], axial: 100}, inertia: {mass_per_length: 1, "
                                 "rotary: [0.01, 0.01, 0.02]}}\n"
                                 "time: {duration: 3}\n"
                                 "network: {hidden: [6]}\n";

static void write_text(const char *text)
{
    FILE *file = fopen(at("field.csv"), "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static experiment *with_file(const char *text)
{
    char override[600];
    snprintf(override, sizeof override, "reference.file=%s", at("field.csv"));
    return experiment_of("rod.yaml", text, override);
}

/* Numbers without units. */
static ad_status write_table(const char *path, const char *const *names,
                             const double *const *columns, size_t ncols, size_t nrows,
                             ad_error *error)
{
    const table_source table = {.names = names, .columns = columns, .ncols = ncols, .nrows = nrows};
    return table_write(path, &table, error);
}

/* The field itself as a file, moved by `shift` along y and turned by `angle` about body axis 3. */
static void write_field(const experiment *e, double shift, double angle)
{
    const double s[4] = {0, 0.5, 1.7, 2}, t[4] = {0.2, 3, 1, 2.5};
    double values[POSE * 4], turned[4 * 4];
    const char *names[2 + POSE] = {"s", "t"};
    const double *columns[2 + POSE] = {s, t};
    field *f = NULL;
    assert_int_equal(field_create(e->model, e->mlp, true, e->pool, &f, NULL), AD_OK);
    assert_int_equal(
        field_evaluate(f, e->parameters, 4, (const double *const[]){s, t}, values, NULL), AD_OK);
    field_free(f);
    for (int i = 0; i < 4; i++) {
        const double *q = values + 12 + i;
        double c = cos(angle / 2), z = sin(angle / 2);
        turned[i] = q[0] * c - q[12] * z;
        turned[4 + i] = q[4] * c + q[8] * z;
        turned[8 + i] = q[8] * c - q[4] * z;
        turned[12 + i] = q[12] * c + q[0] * z;
        values[4 + i] += shift;
    }
    for (int k = 0; k < POSE; k++) {
        names[2 + k] = pose_names[k];
        columns[2 + k] = k < 3 ? values + 4 * k : turned + 4 * (k - 3);
    }
    assert_int_equal(write_table(at("field.csv"), names, columns, 2 + POSE, 4, NULL), AD_OK);
}

static void test_file(void **state)
{
    (void)state;
    experiment *e = experiment_of("rod.yaml", moving_rod, NULL);
    write_field(e, 0.05, 0.4);
    experiment_free(e);
    e = with_file(moving_rod);
    reference *r = reference_of(e);
    reference_errors errors = compare(r, e);
    assert_string_equal(reference_name(r), "field.csv");
    assert_int_equal(reference_points(r), 4);
    assert_near(errors.position_max, 0.05 / 2, rounding);
    assert_near(errors.tip, 0.05 / 2, rounding);
    assert_near(errors.rotation, 0.4, rounding);
    assert_near(errors.rotation_max, 0.4, rounding);
    reference_free(r);
    write_field(e, 0, 0);
    r = reference_of(e);
    errors = compare(r, e);
    assert_near(errors.position, 0, rounding);
    assert_near(errors.rotation_max, 0, rounding);
    reference_free(r);
    experiment_free(e);
}

/* Points beyond the scene, and without a number, are counted; rows may have no rotation, and none
 * may lie at the tip. */
static void test_left_out(void **state)
{
    (void)state;
    write_text("s,t,x,y,z\n0,0,0,0,0\n1,1,0,0,1\n2.1,1,0,0,1\n1,3.1,0,0,1\n-0.1,0,0,0,0\n"
               "1,2,,,nan\n");
    experiment *e = with_file(moving_rod);
    reference *r = reference_of(e);
    reference_errors errors = compare(r, e);
    assert_int_equal(reference_points(r), 2);
    assert_int_equal(reference_left_out(r), 4);
    assert_true(isfinite(errors.position));
    assert_true(isnan(errors.tip) && isnan(errors.rotation) && isnan(errors.rotation_max));
    reference_free(r);
    experiment_free(e);
    write_text("s,t,x,y,z\n0,7,0,0,0\n2.000000001,7,0,0,2\n"); /* rounded; one time is fine */
    e = with_file(static_rod);
    r = reference_of(e);
    errors = compare(r, e);
    assert_int_equal(reference_points(r), 2);
    assert_true(isfinite(errors.tip));
    reference_free(r);
    experiment_free(e);
}

static void test_refused_files(void **state)
{
    static const struct {
        const char *scene, *text, *expected;
    } rows[] = {
        {static_rod, "s,x,z\n0,0,0\n", "column 'y' is missing; a reference has columns s, x, y, z"},
        {static_rod, "x,y,z\n0,0,0\n", "column 's' is missing"},
        {moving_rod, "s,x,y,z\n0,0,0,0\n", "column 't' is missing; a reference has columns s, t"},
        {static_rod, "s,x,y,z,qw\n0,0,0,0,1\n", "column 'qx' is missing"},
        {static_rod, "s,t,x,y,z\n0,0,0,0,0\n0,1,0,0,0\n", "several times"},
        {static_rod, "s,x,y,z\n", "no rows"},
        {static_rod, "s,x,y,z\n3,0,0,0\n", "none of its 1 points lies in the scene"},
        {static_rod, "s,x,y,z,qw,qx,qy,qz\n0,0,0,0,0,0,0,0\n", "row 1: the quaternion"},
        {static_rod, "s,x,y,z\n0,0,inf,0\n", "field.csv:2:5"},
        {static_rod, "s,x,y,z\n0,0,nan,0\n1,1,0,\n", "none of its 2 points lies in the scene"},
        {static_rod, "s,x,y,z\n1,900,0,0\n2,1800,0,0\n", "they are in m, not in mm"}};
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ad_error error = {.message = ""};
        reference *r = NULL;
        write_text(rows[i].text);
        experiment *e = with_file(rows[i].scene);
        assert_int_equal(reference_create(e, &r, &error), AD_BAD_INPUT);
        assert_null(r);
        if (!strstr(error.message, rows[i].expected) || !strstr(error.message, "field.csv")) {
            fail_msg("'%s' is not in: %s", rows[i].expected, error.message);
        }
        experiment_free(e);
    }
}

static void test_none_and_not_a_number(void **state)
{
    (void)state;
    experiment *e = experiment_of("rod.yaml", static_rod, NULL);
    reference *r = NULL;
    assert_int_equal(reference_create(e, &r, NULL), AD_OK);
    assert_null(r);
    reference_free(r);
    experiment_free(e);
    e = experiment_of("configs/elastica_deep.yaml", NULL, NULL);
    r = reference_of(e);
    e->parameters[0] = NAN;
    reference_errors errors = compare(r, e);
    assert_true(isnan(errors.position) && isnan(errors.position_max) && isnan(errors.tip));
    assert_true(isnan(errors.rotation) && isnan(errors.rotation_max));
    reference_free(r);
    experiment_free(e);
}

/* A beam has a deflection and a slope: a formula, or a file with one or both. The untrained network
 * is 0, so that errors are those of the reference itself. */
static void test_beam(void **state)
{
    (void)state;
    static const char text[] = "rod: {model: euler_bernoulli, length: 2, stiffness: {bending: [1, "
                               "1]}}\nbeam: {foundation: 1}\n";
    const double s[3] = {0, 1, 2}, w[3] = {0, 3, -4}, slope[3] = {0.1, 0.1, 0.1};
    const char *const names[3] = {"s", "w", "slope"};
    const double *const columns[3] = {s, w, slope};
    for (int count = 1; count <= 3; count++) { /* formula; file with w; with w and slope */
        char override[256];
        ad_error error = {.message = ""};
        reference_errors errors;
        reference *known = NULL;
        snprintf(override, sizeof override, "reference.file=%s", at("field.csv"));
        assert_int_equal(write_table(at("field.csv"), names, columns, (size_t)count, 3, NULL),
                         AD_OK);
        experiment *e =
            experiment_of("beam.yaml", text, count == 1 ? "reference.deflection=s^2" : override);
        assert_int_equal(reference_create(e, &known, &error), AD_OK);
        assert_int_equal(reference_compare(known, e->parameters, &errors, NULL), AD_OK);
        assert_near(errors.position, 1, 1e-15);
        assert_near(errors.tip, 2, 1e-15); /* of the length */
        assert_true(count == 3 ? fabs(errors.rotation - 0.1) < 1e-15 : isnan(errors.rotation));
        reference_free(known);
        experiment_free(e);
        remove(at("field.csv"));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_angles),        cmocka_unit_test(test_closed_forms),
        cmocka_unit_test(test_manufactured),  cmocka_unit_test(test_file),
        cmocka_unit_test(test_beam),          cmocka_unit_test(test_left_out),
        cmocka_unit_test(test_refused_files), cmocka_unit_test(test_none_and_not_a_number)};
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
