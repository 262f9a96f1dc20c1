/* cpinn.h: scenes by hand and from files, in memory and in a folder; what is refused is named. */
#include "near.h"
#include "temporary_folder.h"

#include "cpinn.h"
#include "tools/library/trained_family.h"

#include <malloc.h>
#include <stdio.h>
#include <string.h>

#define ELASTICA "configs/elastica.yaml"

/* The rod of ELASTICA, except for its name. */
static scene elastica(void)
{
    scene rod;
    scene_defaults(&rod);
    rod.rod.model = SCENE_KIRCHHOFF;
    rod.rod.length = quantity_number(1);
    for (int i = 0; i < 3; i++) {
        rod.rod.bending_stiffness[i % 2] = quantity_number(1);
        rod.loads.tip.force[i] = quantity_number(i == 0 ? 4 : 0);
    }
    rod.rod.torsional_stiffness = quantity_number(1);
    rod.end.type = SCENE_LOADED;
    return rod;
}

static ad_status train(const scene *rod, const train_settings *settings, cpinn_model **model,
                       ad_error *error)
{
    const cpinn_options options = {.threads = 1};
    return cpinn_train_scene(rod, settings, &options, model, error);
}

/* By hand and by file the same recipe: the same numbers to the last bit. */
static void test_by_hand(void **state)
{
    (void)state;
    static const char *const overrides[] = {
        "rod={model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}}",
        "loads.tip.force=[4, 0, 0]", "reference=null", "boundary=null", "loads.units=SI"};
    const scene rod = elastica();
    cpinn_model *by_hand = NULL, *from_file = NULL;
    ad_error error = {AD_OK, ""};
    if (train(&rod, NULL, &by_hand, &error) != AD_OK ||
        cpinn_train_file(ELASTICA, 5, overrides, NULL, &from_file, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(verdict_outcome_of(cpinn_verdict(by_hand)), VERDICT_SOLVED);
    assert_int_equal(cpinn_settings(by_hand)->network.hidden_count, 0);
    assert_int_equal(cpinn_settings(by_hand)->network.fourier_features,
                     cpinn_settings(from_file)->network.fourier_features);
    evaluator *a, *b;
    double s = 0.77, x[2], y[2];
    assert_int_equal(cpinn_evaluator(by_hand, "x z", &a, &error), AD_OK);
    assert_int_equal(cpinn_evaluator(from_file, "x z", &b, &error), AD_OK);
    evaluator_evaluate(a, 1, &s, NULL, x, NULL);
    evaluator_evaluate(b, 1, &s, NULL, y, NULL);
    assert_true(x[0] == y[0] && x[1] == y[1]);
    cpinn_free(by_hand); /* evaluators do not need their models */
    cpinn_free(from_file);
    evaluator_evaluate(a, 1, &s, NULL, y, NULL);
    assert_true(x[0] == y[0] && x[1] == y[1]);
    evaluator_free(a);
    evaluator_free(b);

    cpinn_solution *solved;
    assert_int_equal(cpinn_solve_scene(&rod, 0, 0, NULL, &solved, &error), AD_OK);
    double values[MODEL_COLUMNS_MAX];
    assert_int_equal(cpinn_solution_evaluate(solved, 1, &s, NULL, values, &error), AD_OK);
    assert_near(values[0], x[0], 1e-8);
    assert_string_equal(cpinn_solution_column_name(solved, 2), "z");
    cpinn_solution_free(solved);
}

static bool stop_at_two(void *context, const cpinn_progress *now)
{
    *(cpinn_progress *)context = *now;
    return now->step < 2;
}

/* Stopped, kept, resumed to the same bits as in one go. */
static void test_resume(void **state)
{
    (void)state;
    static const char *const overrides[] = {"time.duration=0.3"};
    const char *path = "configs/cantilever_dynamic.yaml";
    char run[600];
    cpinn_progress last;
    snprintf(run, sizeof run, "%s", at("run"));
    cpinn_options options = {
        .threads = 1, .folder = run, .progress = stop_at_two, .context = &last};
    cpinn_model *model, *whole;
    ad_error error = {AD_OK, ""};
    assert_int_equal(cpinn_train_file(path, 1, overrides, &options, &model, &error), AD_OK);
    assert_int_equal(last.step, 2);
    assert_int_equal(last.windows, 4);
    assert_int_equal(verdict_worst(cpinn_verdict(model)), VERDICT_UNFINISHED);
    cpinn_free(model);
    options.progress = NULL;
    assert_int_equal(cpinn_train_file(path, 1, overrides, &options, &model, &error), AD_BAD_INPUT);
    assert_null(model);
    options.resume = true;
    assert_int_equal(cpinn_train_file(path, 1, overrides, &options, &model, &error), AD_OK);
    assert_int_equal(cpinn_train_file(path, 1, overrides, NULL, &whole, &error), AD_OK);
    size_t rows = cpinn_history_rows(whole);
    assert_int_equal(cpinn_history_rows(model), rows);
    assert_true(cpinn_history_value(model, rows - 1, "loss") ==
                cpinn_history_value(whole, rows - 1, "loss"));
    assert_true(isnan(cpinn_history_value(model, rows, "loss")));
    assert_true(isnan(cpinn_history_value(model, 0, "weather")));
    cpinn_free(model);
    cpinn_free(whole);
    assert_int_equal(cpinn_open(run, &model, &error), AD_OK);
    assert_int_equal(cpinn_history_rows(model), rows);
    assert_string_equal(cpinn_history_name(model, 0), "step");
    assert_int_equal(cpinn_save(model, at("copy.h5"), &error), AD_BAD_ARGUMENT);
    cpinn_free(model);
    static const char *const files[] = {"run/checkpoint.h5", "run/history.csv", "run/config.yaml"};
    for (int i = 0; i < 3; i++) {
        remove(at(files[i]));
    }
    for (int i = 1; i < 4; i++) {
        char older[64];
        snprintf(older, sizeof older, "run/checkpoint.h5.%d", i);
        remove(at(older));
    }
    remove(run);
}

/* Within four deviations of what the data were made with, configs/identify/measure.py. */
static void test_unknowns(void **state)
{
    (void)state;
    static const char *const names[] = {"bending", "torsion", "weight"};
    static const double values[] = {3.1e-3, 1.9e-3, 0.03};
    cpinn_unknowns *found;
    ad_error error = {AD_OK, ""};
    if (cpinn_identify_file("configs/identify/stiffness.yaml", 0, NULL, 1, &found, &error)) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(cpinn_unknowns_count(found), 3);
    for (int i = 0; i < 3; i++) {
        assert_string_equal(cpinn_unknowns_name(found, i), names[i]);
        assert_near(cpinn_unknowns_value(found, i), values[i],
                    4 * cpinn_unknowns_deviation(found, i));
        assert_true(cpinn_unknowns_correlation(found, i, i) == 1);
    }
    assert_true(isnan(cpinn_unknowns_value(found, 3)) &&
                isnan(cpinn_unknowns_deviation(found, -1)));
    assert_string_equal(cpinn_unknowns_name(found, 3), "");
    assert_true(cpinn_unknowns_freedom(found) == 57);
    assert_true(cpinn_unknowns_chi_squared(found) < 2 * 57);
    assert_int_equal(verdict_outcome_of(cpinn_unknowns_verdict(found)), VERDICT_SOLVED);
    cpinn_unknowns_free(found);
    assert_int_equal(cpinn_identify_file(ELASTICA, 0, NULL, 1, &found, &error), AD_BAD_INPUT);
    assert_null(found);
    assert_non_null(strstr(error.message, "have no unknown"));
}

/* The field that is to blame is named, whether it is the scene's or the settings'. */
static void test_refusals(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    ad_error error;
    for (int row = 0; row < 6; row++) {
        static const char *const texts[] = {"scene: rod.length: ",
                                            "scene: loads.tip.force",
                                            "scene: training.stages: ",
                                            "scene: losses.causal.slices: ",
                                            "scene: network.fourier.frequency: ",
                                            "my rod: reference.analytic: "};
        scene rod = elastica();
        train_settings settings = train_settings_default();
        cpinn_model *model = NULL;
        switch (row) {
        case 0:
            rod.rod.length = quantity_number(-1);
            break;
        case 1:
            rod.loads.tip.force[1] = quantity_formula(names, "2*(s");
            break;
        case 2:
            settings.stage_count = 0;
            break;
        case 3:
            settings.losses.causal_slices = 4;
            break;
        case 4:
            settings.fourier_frequency = 3;
            break;
        default:
            settings.name = "my rod";
            settings.reference = TRAIN_REFERENCE_ROLLUP;
        }
        assert_int_equal(train(&rod, &settings, &model, &error), AD_BAD_INPUT);
        assert_null(model);
        if (strncmp(error.message, texts[row], strlen(texts[row])) != 0) {
            fail_msg("\"%s\" instead of \"%s\"", error.message, texts[row]);
        }
    }
    quantities_free(names);
}

/* A family whose members are all alike, straight under an axial force: what its network gives once
 * holds for each of them, whatever memory held before. */
static void test_alike(void **state)
{
    (void)state;
    enum { MEMBERS = 5 };
    static const char *const ranges[] = {"parameters={force: {range: [0, 4]}}",
                                         "loads.tip.force=[force, 0, 0]",
                                         "reference=null",
                                         "formulation=strain",
                                         "network.hidden=[4]",
                                         "members.solved=20",
                                         "training.stages=[{optimizer: adam, steps: 3}]"};
    const cpinn_options options = {.threads = 1};
    const double s[2] = {0.1, 0.3}, given[MEMBERS] = {0, 1, 2, 3, 4};
    const cpinn_family_settings points = {.threads = 1, .points = 2, .s = s};
    double values[MEMBERS * 2 * SOLVE_MEMBERS_COLUMNS];
    cpinn_answer answers[MEMBERS];
    cpinn_family *family = NULL;
    cpinn_model *model = NULL;
    ad_error error = {AD_OK, ""};
    mallopt(M_PERTURB, 0xa5); /* memory that nobody has set is no small number */
    if (cpinn_train_file(ELASTICA, 7, ranges, &options, &model, &error) != AD_OK ||
        cpinn_save(model, at("alike.h5"), &error) != AD_OK ||
        cpinn_family_open(at("alike.h5"), &points, &family, &error) != AD_OK ||
        cpinn_family_evaluate(family, NULL, MEMBERS, given, values, answers, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (int k = 0; k < MEMBERS; k++) {
        assert_near(answers[k].error, 0, 1e-12); /* straight is what all of them are */
        assert_near(values[(2 * k + 1) * SOLVE_MEMBERS_COLUMNS], 0.3, 1e-12);
    }
    mallopt(M_PERTURB, 0);
    cpinn_family_free(family);
    cpinn_free(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_by_hand), cmocka_unit_test(test_resume),
        cmocka_unit_test(test_unknowns), cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_alike)};
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
