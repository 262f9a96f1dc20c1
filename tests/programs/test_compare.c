/* Methods against one another: names and definitions, medians over seeds of curves known by hand,
 * curves of others from files, and the tables written. Values are powers of two or copied, so that
 * comparisons are exact where no tolerance is given. */
#include "near.h"
#include "temporary_folder.h"

#include "tools/files/table_file.h"
#include "tools/judge/compare.h"
#include "tools/prepare/prepare.h"

/* ---- methods and networks ------------------------------------------------------------------ */

static void assert_methods_refused(const char *text, const char *reason)
{
    compare_method methods[COMPARE_METHODS_MAX];
    int count;
    ad_error error = {AD_OK, ""};
    assert_int_equal(compare_methods_parse(text, methods, &count, &error), AD_BAD_INPUT);
    if (!strstr(error.message, reason) || strncmp(error.message, "--methods", 9) != 0) {
        fail_msg("'%s' is not in: %s", reason, error.message);
    }
}

static void test_methods(void **state)
{
    (void)state;
    static compare_method methods[COMPARE_METHODS_MAX];
    int count;
    assert_int_equal(compare_methods_parse("lbfgs,config,fast=adam:20+gauss_newton:6,adam:7",
                                           methods, &count, NULL),
                     AD_OK);
    assert_int_equal(count, 4);
    assert_string_equal(methods[0].name, "lbfgs");
    assert_string_equal(methods[0].override, "training.stages=[{optimizer: adam, steps: 300}, "
                                             "{optimizer: lbfgs, steps: 1000000000}]");
    assert_string_equal(methods[1].override, "");
    assert_string_equal(methods[2].name, "fast");
    assert_string_equal(methods[2].override, "training.stages=[{optimizer: adam, steps: 20}, "
                                             "{optimizer: gauss_newton, steps: 6}]");
    assert_string_equal(methods[3].name, "adam:7");
    assert_methods_refused("newton", "there is no such method; allowed: config,solver,adam,lbfgs,");
    assert_methods_refused("a=adm:3", "'adm' is not an optimiser; allowed: adam, lbfgs,");
    assert_methods_refused("a=adam:0", "'adam:0' is not a stage");
    assert_methods_refused("a=adam:3x", "'adam:3x' is not a stage");
    assert_methods_refused("a=adam:", "'adam:' is not a stage");
    assert_methods_refused("a=adam:99999999999999999999", "is not a stage");
    assert_methods_refused("a=adam:3+", "'' is not an optimiser");
    assert_methods_refused("adam,", "allowed: names and stages");
    assert_methods_refused("=adam:3", "allowed: names and stages");
    assert_methods_refused("adam,adam=lbfgs:3", "adam is there twice");
}

/* The config reads every method of the table, whose stages replace those of the file with all of
 * their settings. */
static void test_methods_are_configs(void **state)
{
    (void)state;
    static compare_method methods[COMPARE_METHODS_MAX];
    static const char rod[] = "rod: {length: 2, stiffness: {bending: [1, 1], torsion: 1, "
                              "shear: [100, 100], axial: 100}}\n"
                              "training: {stages: [{optimizer: adam, learning_rate: 0.5}]}\n";
    char names[256];
    int count;
    compare_method_names(names, sizeof names);
    assert_int_equal(compare_methods_parse(names, methods, &count, NULL), AD_OK);
    assert_int_equal(count, OPTIM_METHOD_COUNT);
    for (int i = 0; i < count; i++) {
        config *settings;
        ad_error error = {AD_OK, ""};
        const char *override = methods[i].override;
        if (prepare_read("rod.yaml", rod, 1, &override, &settings, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        assert_true(settings->settings.stages[0].optim.learning_rate < 0.5);
        const char *first =
            strchr(override, ':') + 2; /* "training.stages=[{optimizer: adam, ..." */
        const char *name = optim_method_name(settings->settings.stages[0].optim.method);
        assert_memory_equal(first, name, strlen(name));
        config_free(settings);
    }
}

static void test_networks(void **state)
{
    (void)state;
    static compare_network networks[COMPARE_NETWORKS_MAX];
    static const char *const wrong[] = {
        "f",    "f0",  "2x8f3",  "2x8+", "f2000", "f3+2x8", "2x8+f",     "2",     "x16", "2x",
        "0x16", "2x0", "2x16x3", "-1x4", "2,3",   "2x5000", "2x16,2x16", "999x2", "",    "2x16,"};
    char name[COMPARE_NAME];
    int count;
    assert_int_equal(compare_networks_parse("2x16,f64,1x32+f8", networks, &count, NULL), AD_OK);
    assert_int_equal(count, 3);
    assert_string_equal(networks[0].hidden, "network.hidden=[16, 16]");
    assert_string_equal(networks[0].features, "");
    assert_string_equal(networks[1].hidden, "network.hidden=[]");
    assert_string_equal(networks[1].features, "network.fourier.features=64");
    assert_string_equal(networks[2].hidden, "network.hidden=[32]");
    assert_string_equal(networks[2].features, "network.fourier.features=8");
    assert_int_equal(compare_networks_parse(NULL, networks, &count, NULL), AD_OK);
    assert_int_equal(count, 1);
    assert_true(!*networks[0].hidden && !*networks[0].features);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        ad_error error = {AD_OK, ""};
        assert_int_equal(compare_networks_parse(wrong[i], networks, &count, &error), AD_BAD_INPUT);
        assert_int_equal(strncmp(error.message, "--networks", 10), 0);
    }
    nn_mlp_settings network = nn_mlp_settings_default();
    network.hidden_count = 3;
    network.hidden[0] = network.hidden[1] = network.hidden[2] = 20;
    compare_network_name(name, &network);
    assert_string_equal(name, "3x20");
    network.hidden[1] = 8;
    compare_network_name(name, &network);
    assert_string_equal(name, "20-8-20");
    network.fourier_features = 7;
    compare_network_name(name, &network);
    assert_string_equal(name, "20-8-20+f7");
    network.hidden_count = 0;
    compare_network_name(name, &network);
    assert_string_equal(name, "f7");
    network.fourier_features = 0;
    network.degree = 20;
    compare_network_name(name, &network);
    assert_string_equal(name, "p20");
}

static void test_names(void **state)
{
    (void)state;
    char name[COMPARE_NAME];
    static const char *const pairs[][2] = {
        {"a,b'c", "a_b_c"}, {"", "_"}, {".x", "_x"}, {"x ", "x_"}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        judge_name(name, pairs[i][0]);
        assert_string_equal(name, pairs[i][1]);
    }
}

/* ---- statistics ---------------------------------------------------------------------------- */

static void test_spread(void **state)
{
    (void)state;
    double odd[] = {8, 1, 4}, even[] = {8, 1, 4, 2}, missing[] = {INFINITY, 2, 4},
           most[] = {INFINITY, 2, INFINITY, INFINITY}, half[] = {INFINITY, 2};
    compare_spread spread = compare_spread_of(odd, 3);
    assert_true(spread.median == 4 && spread.low == 1 && spread.high == 8);
    assert_true(compare_spread_of(even, 4).median == 3);
    spread = compare_spread_of(missing, 3);
    assert_true(spread.median == 4 && spread.low == 2 && isinf(spread.high));
    assert_true(isinf(compare_spread_of(most, 4).median));
    assert_true(isinf(compare_spread_of(half, 2).median));
    assert_true(isnan(compare_spread_of(odd, 0).median));
}

static void fill(compare_run *run, int cell, const double *seconds, const double *errors,
                 size_t count)
{
    *run = (compare_run){
        .cell = cell, .seconds = count ? seconds[count - 1] : 0, .steps = (int64_t)(10 * count)};
    for (size_t i = 0; i < count; i++) {
        compare_row row = {.seconds = seconds[i],
                           .step = (double)i + 1,
                           .loss = 1,
                           .held_out = 2,
                           .errors = {errors[i], 2 * errors[i], NAN}};
        assert_int_equal(compare_run_add(run, &row, NULL), AD_OK);
    }
}

/* Three seeds of one cell, of which one rises again and one never comes far; a cell in which two of
 * three seeds failed, one of them before its first row. */
typedef struct example {
    compare_cell cells[2];
    compare_run runs[6];
    compare_results results;
} example;

static void example_create(example *x)
{
    static const double times[] = {1, 2, 4, 8};
    static const double a[] = {0.5, 0.0078125, 0.0009765625, 0.0001};
    static const double b[] = {0.25, 0.0625, 0.125, 0.03125};
    static const double c[] = {1, 0.125, 0.0005, 0.001};
    *x = (example){.cells = {{.scene_name = "rod", .method = "good", .network = "2x8"},
                             {.scene_name = "rod", .method = "bad", .network = "2x8"}}};
    fill(&x->runs[0], 0, times, a, 4);
    fill(&x->runs[1], 1, times, c, 4);
    fill(&x->runs[2], 0, times, b, 4);
    fill(&x->runs[3], 0, times, c, 4);
    fill(&x->runs[4], 1, times, a, 2);
    fill(&x->runs[5], 1, times, a, 0);
    verdict_add(&x->runs[4].verdict, VERDICT_NOT_FINITE, "not finite");
    verdict_add(&x->runs[5].verdict, VERDICT_NOT_FINITE, "not finite");
    x->results = (compare_results){JUDGE_POSITION, x->cells, 2, x->runs, 6};
}

static void example_free(example *x)
{
    for (int i = 0; i < 6; i++) {
        compare_run_free(&x->runs[i]);
    }
}

static char *printed(const example *x)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    compare_print(file, &x->results);
    fclose(file);
    return text;
}

/* Errors below that of the reference itself are told to be so. */
static void test_estimates(void **state)
{
    (void)state;
    example x;
    example_create(&x);
    for (int i = 0; i < 3; i++) { /* the smallest error at the end of cell 0 is 1e-4 */
        x.cells[0].estimates[JUDGE_POSITION] = i == 0 ? NAN : i == 1 ? 0.9e-4 : 1.1e-4;
        char *text = printed(&x);
        assert_int_equal(
            strstr(text, "the reference itself is off by an estimated 1.1e-04") != NULL, i == 2);
        free(text);
    }
    example_free(&x);
}

static void test_steps(void **state)
{
    (void)state;
    example x;
    example_create(&x);
    const compare_run *b = &x.runs[2];
    assert_true(isinf(compare_best(b, JUDGE_POSITION, 0.999)));
    assert_true(compare_best(b, JUDGE_POSITION, 1) == 0.25);
    assert_true(compare_best(b, JUDGE_POSITION, 3.9) == 0.0625);
    assert_true(compare_best(b, JUDGE_POSITION, 4) == 0.0625); /* it rose, the best stays */
    assert_true(compare_best(b, JUDGE_TIP, 1e9) == 0.0625);
    assert_true(isinf(compare_best(b, JUDGE_ROTATION, 1e9))); /* never known */
    assert_true(compare_reached(b, JUDGE_POSITION, 0.0625) == 2);
    assert_true(isinf(compare_reached(b, JUDGE_POSITION, 0.01)));
    assert_true(isinf(compare_best(&x.runs[5], JUDGE_POSITION, 1)));
    example_free(&x);
}

static void test_summary(void **state)
{
    (void)state;
    example x;
    example_create(&x);
    compare_summary good = compare_summarize(&x.results, 0);
    compare_summary bad = compare_summarize(&x.results, 1);
    assert_true(good.seeds == 3 && good.failed == 0);
    assert_true(good.error.median == 0.001 && good.error.low == 0.0001);
    assert_true(good.error.high == 0.03125);
    assert_true(good.reached[0] == 4);   /* after 2, 4 and never */
    assert_true(good.reached[1] == 4);   /* after 4, 4 and never */
    assert_true(isinf(good.reached[2])); /* one of three */
    assert_true(good.seconds == 8 && good.steps_per_second == 5);
    assert_true(bad.seeds == 3 && bad.failed == 2);
    assert_true(isinf(bad.error.median) && bad.error.low == 0.001); /* failed runs leave nothing */
    assert_true(bad.reached[0] == 4); /* after 4, after 2 before it failed, never */
    example_free(&x);
}

static void test_band(void **state)
{
    (void)state;
    static compare_band band;
    example x;
    example_create(&x);
    compare_band_of(&x.results, 0, &band);
    assert_int_equal(band.count, COMPARE_GRID);
    assert_true(band.seconds[0] == 1 && band.seconds[band.count - 1] == 8);
    for (size_t i = 0; i < band.count; i++) {
        double t = band.seconds[i];
        double median = t < 2 ? 0.5 : t < 4 ? 0.0625 : 0.0009765625;
        double high = t < 2 ? 1 : t < 4 ? 0.125 : t < 8 ? 0.0625 : 0.03125;
        assert_true(band.errors[i].high == high);
        assert_true(band.errors[i].median == (t < 8 ? median : 0.0005));
        if (i > 0) { /* equal on a logarithmic axis, to rounding */
            assert_near(t / band.seconds[i - 1], pow(8, 1.0 / (COMPARE_GRID - 1)), 1e-12);
        }
    }
    /* Two of three seeds have a first row: a median, but no largest. */
    compare_band_of(&x.results, 1, &band);
    assert_true(band.count > 0 && band.errors[0].median == 1 && isinf(band.errors[0].high));
    x.results.run_count = 0;
    compare_band_of(&x.results, 0, &band);
    assert_int_equal(band.count, 0);
    example_free(&x);
}

/* ---- curves of others ---------------------------------------------------------------------- */

static void spill(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void assert_curve_refused(const char *text, const char *reason)
{
    static compare_curves curves;
    ad_error error = {AD_OK, ""};
    spill(at("c.csv"), text);
    assert_int_equal(compare_curves_read(&curves, at("c.csv"), &error), AD_BAD_INPUT);
    if (!strstr(error.message, reason)) {
        fail_msg("'%s' is not in: %s", reason, error.message);
    }
    compare_curves_free(&curves);
}

static void test_curves(void **state)
{
    (void)state;
    static compare_curves curves;
    char named[600];
    ad_error error = {AD_OK, ""};
    spill(at("c.csv"),
          "# made by hand\nname,seconds,error\nb,1,0.5\n\na x,4,2\n# more\nb,2,0.25\n");
    if (compare_curves_read(&curves, at("c.csv"), &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(curves.count, 2);
    assert_string_equal(curves.curves[0].name, "b");
    assert_int_equal(curves.curves[0].count, 2);
    assert_true(curves.curves[0].seconds[1] == 2 && curves.curves[0].errors[1] == 0.25);
    assert_string_equal(curves.curves[1].name, "a x");
    assert_int_equal(compare_curves_read(&curves, at("c.csv"), &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "two curves are called b"));
    snprintf(named, sizeof named, "n=%s", at("c.csv"));
    assert_int_equal(compare_curves_read(&curves, named, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "names its curves in a column"));
    spill(at("c.csv"), "error,seconds\n1,2\n");
    assert_int_equal(compare_curves_read(&curves, named, &error), AD_OK);
    assert_int_equal(compare_curves_read(&curves, at("c.csv"), &error), AD_OK);
    assert_string_equal(curves.curves[2].name, "n");
    assert_string_equal(curves.curves[3].name, "c");
    assert_true(curves.curves[3].seconds[0] == 2);
    compare_curves_free(&curves);
    assert_int_equal(compare_curves_read(&curves, "n=", &error), AD_BAD_INPUT);
    assert_int_equal(compare_curves_read(&curves, "=c.csv", &error), AD_BAD_INPUT);
    assert_int_equal(compare_curves_read(&curves, at("none.csv"), &error), AD_IO);
}

static void test_bad_curves(void **state)
{
    (void)state;
    assert_curve_refused("seconds,error\n1,1\n\n2,x\n",
                         "c.csv:4:3: 'x': the field is not a number");
    assert_curve_refused("seconds,error\n1,1\n# no\n0,1\n", "c.csv:4: seconds is 0; allowed: > 0");
    assert_curve_refused("seconds,error\n1,-1\n", "c.csv:2: error is -1; allowed: > 0");
    assert_curve_refused("seconds,error\n1,inf\n", "c.csv:2:3: 'inf': the field is not finite");
    assert_curve_refused("seconds,eror\n1,1\n", "column 'error' is missing");
    assert_curve_refused("seconds,error\n", "there are no rows");
}

/* ---- files --------------------------------------------------------------------------------- */

static const char *const words[] = {"scene", "method", "network", NULL};

static table_file *read_back(const char *name, const char *ending)
{
    char path[600];
    ad_error error = {AD_OK, ""};
    table_file *table;
    snprintf(path, sizeof path, "%s/%s.%s", directory, name, ending);
    if (table_read_words(path, TABLE_NONFINITE, words, &table, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return table;
}

static void assert_same_tables(const table_file *a, const table_file *b)
{
    assert_int_equal(table_rows(a), table_rows(b));
    assert_int_equal(table_columns(a), table_columns(b));
    for (size_t k = 0; k < table_columns(a); k++) {
        const char *name = table_name(a, k);
        assert_string_equal(name, table_name(b, k));
        for (size_t row = 0; row < table_rows(a); row++) {
            if (k < 3) {
                assert_string_equal(table_words(a, name)[row], table_words(b, name)[row]);
                continue;
            }
            double x = table_column(a, name)[row], y = table_column(b, name)[row];
            assert_true(x == y || (isnan(x) && isnan(y)));
        }
    }
}

static void test_tables(void **state)
{
    (void)state;
    static const char *const names[] = {"runs", "summary", "curves"};
    example x;
    ad_error error = {AD_OK, ""};
    example_create(&x);
    if (compare_write(&x.results, directory, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    for (int i = 0; i < 3; i++) {
        table_file *csv = read_back(names[i], "csv"), *hdf5 = read_back(names[i], "h5");
        assert_same_tables(csv, hdf5);
        if (i == 0) {
            assert_int_equal(table_rows(csv), 18);
            assert_string_equal(table_words(csv, "method")[4], "bad");
            assert_true(table_column(csv, "tip_error")[0] == 1);
        } else if (i == 1) {
            assert_int_equal(table_rows(csv), 2);
            assert_true(table_column(csv, "seconds_to_1e-2")[0] == 4);
            assert_true(isinf(table_column(csv, "seconds_to_1e-4")[0]));
            assert_true(table_column(csv, "failed")[1] == 2);
        }
        table_free(csv);
        table_free(hdf5);
    }
    example_free(&x);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_methods),
        cmocka_unit_test(test_methods_are_configs),
        cmocka_unit_test(test_networks),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_spread),
        cmocka_unit_test(test_estimates),
        cmocka_unit_test(test_steps),
        cmocka_unit_test(test_summary),
        cmocka_unit_test(test_band),
        cmocka_unit_test_setup_teardown(test_curves, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_bad_curves, make_directory, remove_directory),
        cmocka_unit_test_setup_teardown(test_tables, make_directory, remove_directory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
