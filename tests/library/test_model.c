/* Models of one's own: equations over one's own coordinates, and further terms on those of a scene;
 * and what is refused. */
#include "temporary_folder.h"
#include "training_testing.h"

#include "tools/library/cpinn.h"

static const double pi = 3.14159265358979323846;

/* ---- a beam that bends far: EI y'' = M (1 + y'^2)^(3/2) ----------------------------------------
 */

static ad_value bending(const void *context, const domain_place *at, const ad_value *y)
{
    double moment = *(const double *)context;
    ad_value slope = ad_derivative(*y, at->x[0], 1), one = ad_scalar(at->tape, 1);
    ad_value size = ad_power(ad_add(one, ad_square(slope)), 1.5);
    return ad_sub(ad_derivative(*y, at->x[0], 2), ad_scale(size, moment));
}

static ad_value clamp(const void *context, const domain_place *at, const ad_value *y)
{
    (void)context;
    return ad_stack(2, (ad_value[]){*y, ad_derivative(*y, at->x[0], 1)});
}

static physics_model *circle(const double *moment, double weight)
{
    physics_model *m = model_create();
    int x = model_add_coordinate(m, "x", "m", 0, 1, 0), inside = model_add_interior(m, "inside");
    assert_int_equal(model_add_field(m, "y", 1), 0);
    model_add_term(m, "bending", inside, 1, bending, moment);
    model_add_term(m, "clamp", model_add_face(m, "clamp", x, 0), weight, clamp, NULL);
    return m;
}

/* The circle of radius EI/M through the clamp, a nonlinear problem of one coordinate; 1e-9, its
 * slope 1e-7: ten times what 33 functions miss of it. */
static void test_circle(void **state)
{
    (void)state;
    const double moment = 0.5;
    physics_model *m = circle(&moment, 10);
    cpinn_model *trained = NULL;
    ad_error error = {AD_OK, ""};
    if (cpinn_train_physics(m, NULL, NULL, &trained, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(verdict_worst(cpinn_verdict(trained)), VERDICT_ERROR_UNKNOWN);
    assert_int_equal(verdict_outcome_of(cpinn_verdict(trained)), VERDICT_WARNING);
    assert_non_null(
        strstr(verdict_text(cpinn_verdict(trained)), "cpinn_fit_equations or patches_fit"));
    evaluator *e = NULL;
    assert_int_equal(cpinn_evaluator(trained, "y y_x", &e, NULL), AD_OK);
    assert_string_equal(evaluator_column_name(e, 1), "y_x");
    for (int i = 0; i <= 10; i++) {
        double at = i / 10.0, values[2], root = sqrt(1 - moment * moment * at * at);
        assert_int_equal(evaluator_evaluate_at(e, 1, (const double *const[]){&at}, values, NULL),
                         AD_OK);
        assert_true(fabs(values[0] - (1 - root) / moment) < 1e-9);
        assert_true(fabs(values[1] - moment * at / root) < 1e-7);
    }
    evaluator_free(e);
    cpinn_free(trained);
    model_free(m);
}

/* ---- a further term on a scene -----------------------------------------------------------------
 */

/* The height of an elastica at its fields, as a term: z - wanted. */
static ad_value height(const void *context, const domain_place *at, const ad_value *fields)
{
    (void)at;
    return ad_sub(ad_row(fields[0], 2), ad_scalar(at->tape, *(const double *)context));
}

static void test_scene_with_a_term(void **state)
{
    (void)state;
    config *file;
    ad_error error = {AD_OK, ""};
    assert_int_equal(prepare_read("configs/elastica.yaml", NULL, 0, NULL, &file, &error), AD_OK);
    assert_int_equal(prepare_training(file, &error), AD_OK);
    const double wanted = 0;
    double errors[2];
    for (int with = 0; with < 2; with++) {
        physics_model *m = NULL;
        train_settings settings = file->settings;
        settings.reference = TRAIN_REFERENCE_NONE;
        assert_int_equal(model_of_scene(&file->scene, &settings.weights, &m, &error), AD_OK);
        int terms = m->term_count;
        if (with) {
            model_add_term(m, "height", 0, 1000, height, &wanted);
            assert_int_equal(m->term_count, terms + 1);
        }
        cpinn_model *trained = NULL;
        if (cpinn_train_physics(m, &settings, NULL, &trained, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        evaluator *e = NULL;
        double s = scene_length(&file->scene), tip[3];
        assert_int_equal(cpinn_evaluator(trained, "x y z", &e, NULL), AD_OK);
        assert_int_equal(evaluator_evaluate(e, 1, &s, NULL, tip, NULL), AD_OK);
        errors[with] = fabs(tip[2]);
        bool has_column = false;
        for (int c = 0; c < cpinn_history_columns(trained); c++) {
            has_column = has_column || strcmp(cpinn_history_name(trained, c), "height") == 0;
        }
        assert_int_equal(has_column, with);
        evaluator_free(e);
        cpinn_free(trained);
        model_free(m);
    }
    assert_true(errors[1] < 0.9 * errors[0]); /* the tip is drawn towards the wanted height */
    config_free(file);
}

/* ---- runs in folders ----------------------------------------------------------------------------
 */

static bool stop_at_two(void *context, const cpinn_progress *now)
{
    (void)context;
    return now->step < 2;
}

static double tip_of(const cpinn_model *trained)
{
    evaluator *e = NULL;
    double y;
    assert_int_equal(cpinn_evaluator(trained, "y", &e, NULL), AD_OK);
    assert_int_equal(evaluator_evaluate_at(e, 1, (const double *const[]){&(double){1}}, &y, NULL),
                     AD_OK);
    evaluator_free(e);
    return y;
}

/* Stopped, resumed to the same bits as in one go, opened; not as anything else. */
static void test_folder(void **state)
{
    (void)state;
    const double moment = 0.5;
    char run[512];
    snprintf(run, sizeof run, "%s", at("run"));
    cpinn_options options = {.threads = 1, .folder = run, .progress = stop_at_two};
    physics_model *m = circle(&moment, 10), *other = circle(&moment, 20);
    cpinn_model *whole, *trained;
    ad_error error = {AD_OK, ""};
    assert_int_equal(cpinn_train_physics(m, NULL, NULL, &whole, &error), AD_OK);
    assert_int_equal(cpinn_train_physics(m, NULL, &options, &trained, &error), AD_OK);
    assert_int_equal(verdict_worst(cpinn_verdict(trained)), VERDICT_UNFINISHED);
    cpinn_free(trained);
    options = (cpinn_options){.threads = 1, .folder = run, .resume = true};
    assert_int_equal(cpinn_train_physics(other, NULL, &options, &trained, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "weight: 20}' now; a run keeps"));
    if (cpinn_train_physics(m, NULL, &options, &trained, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(cpinn_history_rows(trained), cpinn_history_rows(whole));
    assert_true(tip_of(trained) == tip_of(whole));
    assert_int_equal(cpinn_save(trained, at("saved.h5"), &error), AD_OK);
    cpinn_free(trained);

    const char *const files[] = {run, at("saved.h5")};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(cpinn_open_physics(files[i], m, NULL, &trained, &error), AD_OK);
        assert_int_equal(verdict_worst(cpinn_verdict(trained)), VERDICT_ERROR_UNKNOWN);
        assert_true(tip_of(trained) == tip_of(whole));
        cpinn_free(trained);
        assert_int_equal(cpinn_open_physics(files[i], other, NULL, &trained, &error), AD_BAD_INPUT);
        assert_null(trained);
        assert_int_equal(cpinn_open(files[i], &trained, &error), AD_BAD_INPUT);
        assert_non_null(strstr(error.message, "cpinn_open_physics opens it"));
    }
    cpinn_free(whole);
    model_free(m);
    model_free(other);
    char command[600];
    snprintf(command, sizeof command, "rm -r '%s'", run);
    assert_int_equal(system(command), 0);
}

/* ---- refusals -----------------------------------------------------------------------------------
 */

static void refused(physics_model *m, const char *text)
{
    cpinn_model *trained = NULL;
    ad_error error = {AD_OK, ""};
    ad_status status = cpinn_train_physics(m, NULL, NULL, &trained, &error);
    assert_true(status == AD_BAD_ARGUMENT || status == AD_BAD_INPUT);
    assert_null(trained);
    if (!strstr(error.message, text)) {
        fail_msg("\"%s\" instead of \"%s\"", error.message, text);
    }
    model_free(m);
}

static physics_model *line(void)
{
    physics_model *m = model_create();
    model_add_coordinate(m, "x", "m", 0, 1, 0);
    model_add_field(m, "y", 1);
    return m;
}

static void test_refusals(void **state)
{
    (void)state;
    refused(model_create(), "no coordinate");
    physics_model *m = model_create();
    model_add_coordinate(m, "x", "m", 1, 1, 0);
    refused(m, "low < high");
    m = line();
    model_add_coordinate(m, "x", "m", 0, 1, 0);
    refused(m, "different names");
    refused(line(), "weight 0: nothing to learn");
    m = line();
    model_add_term(m, "bending", 0, 1, bending, &pi);
    refused(m, "at points that have been added");
    m = line();
    model_add_term(m, "bending", model_add_interior(m, "inside"), -1, bending, &pi);
    refused(m, "weight of 0 or more");
    m = line();
    model_add_face(m, "top", 3, 1);
    refused(m, "a coordinate that has been added");
    m = line();
    model_add_field(m, "a field too long", 1);
    refused(m, "symbols of 1 to 7 letters");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_circle), cmocka_unit_test(test_scene_with_a_term),
        cmocka_unit_test(test_folder), cmocka_unit_test(test_refusals)};
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
