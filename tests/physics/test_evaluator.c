/* Values and derivatives of a trained network at given points: against the field that training
 * uses, against differences, over windows of time, and without allocations. */
#include "allocations.h"
#include "near.h"
#include "training_testing.h"

#include "physics/learn/evaluator.h"
#include "physics/learn/field.h"

#include <string.h>

#define MOVING "configs/cantilever_dynamic.yaml"

enum { LOW = 12 }; /* functions of the basis that the networks here use; those behind cancel more */

/* Numbers of the order of 0.1 for the smooth functions of each output, 0 for the others. */
static void fill(const experiment *e, double *parameters)
{
    const nn_view *views;
    nn_mlp_views(e->mlp, &views);
    bool linear = e->settings->network.hidden_count == 0;
    for (size_t i = 0; i < e->count; i++) {
        bool used = !linear || i >= views[1].offset || i % (size_t)views[0].columns < LOW;
        parameters[i] = used ? 0.1 * sin(1 + 7.3 * (double)i) : 0;
    }
}

/* With the default network, but for one change; NULL: none. */
static experiment *make_default(const char *path, const char *change)
{
    const char *changes[] = {"network.hidden=null", "network.fourier.features=null",
                             "formulation=mixed", change, NULL};
    return make_experiment(path, changes, 1);
}

static evaluator_model model_of_windows(experiment *e, int windows)
{
    assert_true(windows <= e->scene->windows);
    for (int i = 0; i < windows; i++) {
        fill(e, e->parameters + (size_t)i * e->count);
    }
    while (e->window + 1 < windows) {
        assert_int_equal(experiment_next_window(e, NULL), AD_OK);
    }
    return (evaluator_model){e->model, e->mlp, windows, e->parameters, e->starts};
}

static evaluator *make(const evaluator_model *model, const char *names)
{
    evaluator *made = NULL;
    ad_error error = {AD_OK, ""};
    if (evaluator_create(model, names, &made, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return made;
}

/* All columns, at rest and in motion, in a plane and in space, of linear networks and others. */
static void test_against_field(void **state)
{
    (void)state;
    static const struct {
        const char *path, *change;
        int windows;
    } rows[] = {{"configs/elastica.yaml", NULL, 1},
                {"configs/elastica.yaml", "network.hidden=[8, 8]", 1},
                {"configs/helix.yaml", NULL, 1},
                {"configs/timoshenko_vibration.yaml", "time.windows=1", 1},
                {MOVING, NULL, 3},
                {MOVING, "motion=spatial", 2}};
    enum { POINTS = 300 };
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
        experiment *e = make_default(rows[row].path, rows[row].change);
        const evaluator_model model = model_of_windows(e, rows[row].windows);
        evaluator *all = make(&model, NULL);
        field *f;
        assert_int_equal(field_create(e->model, e->mlp, false, e->pool, &f, NULL), AD_OK);
        field_enter(f, e->window, e->parameters, e->starts);
        int columns = evaluator_columns(all);
        assert_int_equal(columns, field_columns(f));
        static double s[POINTS], t[POINTS], expected[MODEL_COLUMNS_MAX * POINTS],
            values[MODEL_COLUMNS_MAX * POINTS], alone[MODEL_COLUMNS_MAX];
        for (int i = 0; i < POINTS; i++) {
            s[i] = scene_length(e->scene) * (i * 37 % 101) / 100;
            t[i] = scene_duration(e->scene) * (i * 53 % 97) / 96;
        }
        assert_int_equal(field_evaluate(f, experiment_parameters(e), POINTS,
                                        (const double *const[]){s, t}, expected, NULL),
                         AD_OK);
        assert_int_equal(evaluator_evaluate(all, POINTS, s, t, values, NULL), AD_OK);
        for (int c = 0; c < columns; c++) {
            double size = 1;
            assert_string_equal(evaluator_column_name(all, c), field_column_name(f, c));
            for (int i = 0; i < POINTS; i++) {
                size = fmax(size, fabs(expected[c * POINTS + i]));
            }
            for (int i = 0; i < POINTS; i++) { /* sums of 200 products in another order */
                assert_near(values[c * POINTS + i], expected[c * POINTS + i], 1e-11 * size);
            }
            assert_int_equal(evaluator_evaluate(all, 1, &s[7], &t[7], alone, NULL), AD_OK);
            assert_near(alone[c], values[c * POINTS + 7], 1e-12 * size);
        }
        field_free(f);
        evaluator_free(all);
        experiment_free(e);
    }
}

/* Each derivative against a difference of sixth order of the one below: 2e-3 of the range with
 * waves of up to 20 radians in it leave 20^7 (2e-3)^6 / 140 = 6e-10, rounding 1e-13 / 2e-3. */
static void test_derivatives(void **state)
{
    (void)state;
    static const struct {
        const char *name, *below;
        bool by_s;
        int columns;
    } rows[] = {{"r_s", "r", true, 3},     {"q_t", "q", false, 4},      {"x_ss", "x_s", true, 1},
                {"r_tt", "r_t", false, 3}, {"m2_st", "m2_s", false, 1}, {"z_sss", "z_ss", true, 1}};
    static const double weights[3] = {3.0 / 4, -3.0 / 20, 1.0 / 60};
    experiment *e = make_default(MOVING, "rod.length=2");
    const evaluator_model model = model_of_windows(e, 2);
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
        evaluator *derivative = make(&model, rows[row].name),
                  *below = make(&model, rows[row].below);
        assert_int_equal(evaluator_columns(derivative), rows[row].columns);
        double h = 1e-3 * (rows[row].by_s ? scene_length(e->scene)
                                          : scene_duration(e->scene) / e->scene->windows);
        for (int i = 0; i < 20; i++) {
            double s = 0.1 + 0.09 * i,
                   t = scene_duration(e->scene) / e->scene->windows * (0.1 + 0.04 * i);
            double values[4], low[4], high[4], difference[4] = {0};
            assert_int_equal(evaluator_evaluate(derivative, 1, &s, &t, values, NULL), AD_OK);
            for (int k = 1; k <= 3; k++) {
                double ds = rows[row].by_s ? k * h : 0, dt = rows[row].by_s ? 0 : k * h;
                evaluator_evaluate(below, 1, (double[]){s - ds}, (double[]){t - dt}, low, NULL);
                evaluator_evaluate(below, 1, (double[]){s + ds}, (double[]){t + dt}, high, NULL);
                for (int c = 0; c < rows[row].columns; c++) {
                    difference[c] += weights[k - 1] * (high[c] - low[c]) / h;
                }
            }
            for (int c = 0; c < rows[row].columns; c++) {
                assert_near(values[c], difference[c], 1e-6 * (1 + fabs(values[c])));
            }
        }
        evaluator_free(derivative);
        evaluator_free(below);
    }
    evaluator *units = make(&model, "x_s m2_stt qw_t v3");
    assert_string_equal(evaluator_column_name(units, 1), "m2_stt");
    assert_string_equal(evaluator_column_unit(units, 0), "m m^-1");
    assert_string_equal(evaluator_column_unit(units, 1), "N m m^-1 s^-2");
    assert_string_equal(evaluator_column_unit(units, 2), "s^-1");
    assert_string_equal(evaluator_column_unit(units, 3), "");
    evaluator_free(units);
    experiment_free(e);
}

/* An instant between windows belongs to the one that it ends, what comes after all is the last's.
 */
static void test_windows(void **state)
{
    (void)state;
    experiment *e = make_default(MOVING, NULL);
    const evaluator_model model = model_of_windows(e, 3);
    evaluator *x = make(&model, "r v1 u2");
    field *f;
    assert_int_equal(field_create(e->model, e->mlp, false, e->pool, &f, NULL), AD_OK);
    field_enter(f, 2, e->parameters, e->starts);
    double window = scene_duration(e->scene) / e->scene->windows;
    const double at[] = {
        0, window, 2 * window, 2 * window + 1e-9, 3 * window, scene_duration(e->scene)};
    for (size_t i = 0; i < sizeof at / sizeof *at; i++) {
        double s = 0.8, values[5], expected[MODEL_COLUMNS_MAX];
        assert_int_equal(evaluator_evaluate(x, 1, &s, &at[i], values, NULL), AD_OK);
        assert_int_equal(field_evaluate(f, experiment_parameters(e), 1,
                                        (const double *const[]){&s, &at[i]}, expected, NULL),
                         AD_OK);
        assert_near(values[0], expected[0], 1e-11);
        assert_near(values[3], expected[7], 1e-10);
    }
    field_free(f);
    evaluator_free(x);
    experiment_free(e);
}

/* Behind the columns their derivatives by s and t, as those that are asked for by name; what
 * rounding does to them is small, and nothing is left of the trial. */
static void test_jacobian(void **state)
{
    (void)state;
    enum { POINTS = 5, COLUMNS = 6 };
    experiment *e = make_default(MOVING, "network.fourier.features=16");
    const evaluator_model model = model_of_windows(e, 2);
    evaluator *both = NULL, *named = make(&model, "x vz x_s x_t vz_s vz_t");
    double s[POINTS], t[POINTS], values[COLUMNS * POINTS], expected[COLUMNS * POINTS];
    double change[COLUMNS], again[COLUMNS * POINTS];
    assert_int_equal(evaluator_create_jacobian(&model, "x vz", &both, NULL), AD_OK);
    assert_int_equal(evaluator_columns(both), COLUMNS);
    assert_string_equal(evaluator_column_name(both, 3), "x_t");
    assert_string_equal(evaluator_column_unit(both, 5), "m/s s^-1");
    for (int i = 0; i < POINTS; i++) {
        s[i] = 0.2 * i * scene_length(e->scene);
        t[i] = 0.1 * i * scene_duration(e->scene);
    }
    assert_int_equal(evaluator_evaluate(both, POINTS, s, t, values, NULL), AD_OK);
    assert_int_equal(evaluator_evaluate(named, POINTS, s, t, expected, NULL), AD_OK);
    assert_int_equal(evaluator_rounding(both, POINTS, (const double *const[]){s, t}, change, NULL),
                     AD_OK);
    assert_int_equal(evaluator_evaluate(both, POINTS, s, t, again, NULL), AD_OK);
    assert_memory_equal(again, values, sizeof values);
    for (int c = 0; c < COLUMNS; c++) {
        assert_true(change[c] >= 0 && change[c] < 1e-11);
        for (int i = c * POINTS; i < (c + 1) * POINTS; i++) {
            assert_near(values[i], expected[i], 64 * change[c] + 1e-13);
        }
    }
    assert_true(change[1] > 0);
    evaluator_free(both);
    evaluator_free(named);
    experiment_free(e);
}

static void test_refusals(void **state)
{
    (void)state;
    static const struct {
        const char *path, *names, *text;
    } rows[] = {{MOVING, "x bend", "bend is no column"},
                {MOVING, "x_", "x_ is no column"},
                {MOVING, "x_sx", "x_sx is no column"},
                {MOVING, "x_sssss", "x_sssss is no column"},
                {MOVING, " , ", "no column is asked for"},
                {"configs/elastica.yaml", "vx", "vx is of a scene in motion"},
                {"configs/elastica.yaml", "r_t", "r_t is a derivative by time"},
                {"configs/beam_cantilever.yaml", "r", "r is no column"}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        experiment *e = make_default(rows[i].path, NULL);
        const evaluator_model model = model_of_windows(e, 1);
        evaluator *x = NULL;
        ad_error error = {AD_OK, ""};
        assert_int_equal(evaluator_create(&model, rows[i].names, &x, &error), AD_BAD_ARGUMENT);
        assert_null(x);
        if (strncmp(error.message, rows[i].text, strlen(rows[i].text)) != 0) {
            fail_msg("\"%s\" instead of \"%s\"", error.message, rows[i].text);
        }
        experiment_free(e);
    }
}

/* Beyond the rod and the motion a network means nothing; what grids round is no place beyond. */
static void test_beyond(void **state)
{
    (void)state;
    static const struct {
        double s, t;
        const char *text;
    } rows[] = {{120, 0.5, "s is 120 m; allowed: 0 to 1 m"},
                {-0.01, 0.5, "s is -0.01 m; allowed: 0 to 1 m"},
                {0.5, 1.5, "t is 1.5 s; allowed: 0 to 1 s"},
                {1 + 1e-12, 1 + 1e-12, NULL},
                {1 + 6e-8, 1, NULL}, /* as a number of type float */
                {NAN, 0.5, NULL}};
    experiment *e = make_default(MOVING, NULL);
    const evaluator_model model = model_of_windows(e, 1);
    evaluator *x = make(&model, "x");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const double s[2] = {0.5, rows[i].s}, t[2] = {0.5, rows[i].t};
        double values[2];
        ad_error error = {AD_OK, ""};
        const ad_status status = evaluator_evaluate(x, 2, s, t, values, &error);
        assert_int_equal(status, rows[i].text ? AD_BAD_ARGUMENT : AD_OK);
        assert_string_equal(error.message, rows[i].text ? rows[i].text : "");
        assert_true(rows[i].text || isnan(values[1]) == isnan(rows[i].s));
    }
    evaluator_free(x);
    experiment_free(e);
}

/* Nothing is allocated while points are evaluated, from the first on; and what is allocated before
 * may fail at any place. */
static void test_allocations(void **state)
{
    (void)state;
    experiment *e = make_default(MOVING, NULL);
    const evaluator_model model = model_of_windows(e, 2);
    evaluator *x = make(&model, "r q r_tt");
    static double s[1000], t[1000], values[10 * 1000];
    long before = allocations;
    for (int i = 0; i < 1000; i++) {
        s[i] = 1e-3 * i;
        t[i] = 0.3 * (i % 10) / 9;
        assert_int_equal(evaluator_evaluate(x, 1, &s[i], &t[i], values, NULL), AD_OK);
    }
    assert_int_equal(evaluator_evaluate(x, 1000, s, t, values, NULL), AD_OK);
    assert_int_equal(allocations, before);
    evaluator_free(x);
    ad_status status = AD_NO_MEMORY;
    for (long nth = 1; status == AD_NO_MEMORY; nth += nth < 40 ? 1 : 97) {
        failing_allocation = allocations + nth;
        status = evaluator_create(&model, "r", &x, NULL);
        failing_allocation = 0;
    }
    assert_int_equal(status, AD_OK);
    evaluator_free(x);
    experiment_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_against_field), cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_windows),       cmocka_unit_test(test_jacobian),
        cmocka_unit_test(test_refusals),      cmocka_unit_test(test_beyond),
        cmocka_unit_test(test_allocations)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
