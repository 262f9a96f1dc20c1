/* Runs an FMU over the points of a table that cpinn-eval has written, and compares.
 *   fmu_drive LIBRARY MODEL_DESCRIPTION POINTS.csv
 * Outputs have to be the columns, derivatives those by central differences. Exit status 1: they are
 * not, or a function fails. */
#include "fmi_importer.h"

#include "tools/files/table_file.h"

#include <stdio.h>

/* References of an FMU of one place: 0 the time, 1 s, then the outputs. Central differences over
 * 1e-4 of a range: off by a sixth of 1e-8 times a third derivative, in units of the range, and by
 * 1e-16 / 1e-4 of rounding. */
enum { FIRST = 2, COLUMNS_MAX = 64 };
static const double step_part = 1e-4, difference_tolerance = 1e-5;

/* The C of a network sums in another order than cpinn-eval and has its own tanh; forces and moments
 * multiply that by what cancels in them, some hundred roundings in all. */
static const double tolerance = 1e-13;

static const table_file *points;
static int columns;
static double scale[COLUMNS_MAX];
static const double *values[COLUMNS_MAX], *s, *t;

static void read_columns(const char *description)
{
    size_t rows = table_rows(points);
    s = table_column(points, "s");
    t = table_column(points, "t");
    for (size_t k = 2; k < table_columns(points); k++) {
        char variable[128], *reference;
        const char *name = table_name(points, k);
        snprintf(variable, sizeof variable, "<Float64 name=\"%s\" valueReference=\"", name);
        reference = between(description, variable, "\"");
        if (atoi(reference) != FIRST + columns || columns == COLUMNS_MAX) {
            fail_msg("%s has the reference %s", name, reference);
        }
        free(reference);
        values[columns] = table_column(points, name);
        for (size_t i = 0; i < rows; i++) {
            scale[columns] = fmax(scale[columns], fabs(values[columns][i]));
        }
        columns++;
    }
}

static void outputs(fmi3Instance instance, double at_s, double at_t, double *result)
{
    double reached;
    assert_int_equal(set(instance, 1, at_s), fmi3OK);
    assert_int_equal(step(instance, at_t, 0, &reached), fmi3OK);
    for (int k = 0; k < columns; k++) {
        assert_int_equal(get(instance, (fmi3ValueReference)(FIRST + k), &result[k]), fmi3OK);
    }
}

static double compare_derivatives(fmi3Instance instance, double at_s, double at_t,
                                  const double range[2])
{
    double worst = 0, more[COLUMNS_MAX], less[COLUMNS_MAX], slope[COLUMNS_MAX];
    fmi3ValueReference unknowns[COLUMNS_MAX];
    for (int k = 0; k < columns; k++) {
        unknowns[k] = (fmi3ValueReference)(FIRST + k);
    }
    for (fmi3ValueReference known = 0; known < 2; known++) {
        double h = step_part * range[known], seed = range[known];
        outputs(instance, at_s + (known ? h : 0), at_t + (known ? 0 : h), more);
        outputs(instance, at_s - (known ? h : 0), at_t - (known ? 0 : h), less);
        outputs(instance, at_s, at_t, slope);
        assert_int_equal(
            FIND(product_function, "fmi3GetDirectionalDerivative")(
                instance, unknowns, (size_t)columns, &known, 1, &seed, 1, slope, (size_t)columns),
            fmi3OK);
        for (int k = 0; k < columns && h > 0; k++) {
            double change = (more[k] - less[k]) / (2 * step_part);
            worst = fmax(worst, fabs(slope[k] - change) / (scale[k] + fabs(change) + 1e-9));
        }
    }
    return worst;
}

static void test_drive(void **state)
{
    char *const *arguments = *state;
    size_t rows = table_rows(points);
    double worst = 0, worst_slope = 0, result[COLUMNS_MAX];
    char *token = between(arguments[2], "instantiationToken=\"", "\"");
    fmi3Instance instance = importer_open(arguments[1], token, true, false);
    free(token);
    assert_non_null(instance);
    read_columns(arguments[2]);
    assert_int_equal(initialize(instance, t[0]), fmi3OK);
    const double range[2] = {t[rows - 1] - t[0], s[rows - 1] - s[0]};
    for (size_t i = 0; i < rows; i++) {
        outputs(instance, s[i], t[i], result);
        for (int k = 0; k < columns; k++) {
            worst = fmax(worst, fabs(result[k] - values[k][i]) / (scale[k] > 0 ? scale[k] : 1));
        }
        bool inside = s[i] > s[0] && s[i] < s[rows - 1] &&
                      (range[0] == 0 || (t[i] > t[0] && t[i] < t[rows - 1]));
        if (inside) {
            worst_slope = fmax(worst_slope, compare_derivatives(instance, s[i], t[i], range));
        }
    }
    printf("%zu points, %d outputs: off by %.1e, derivatives by %.1e\n", rows, columns, worst,
           worst_slope);
    assert_true(worst <= tolerance);
    assert_true(worst_slope <= difference_tolerance);
    assert_int_equal(warnings + errors, 0);
    end(instance);
}

int main(int count, char **arguments)
{
    ad_error error = {.message = ""};
    table_file *table = NULL;
    if (count != 4 || table_read(arguments[3], TABLE_FINITE, &table, &error) != AD_OK) {
        fprintf(stderr, "fmu_drive LIBRARY MODEL_DESCRIPTION POINTS.csv: %s\n", error.message);
        return 2;
    }
    points = table;
    const struct CMUnitTest tests[] = {cmocka_unit_test_prestate(test_drive, arguments)};
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    table_free(table);
    return failed ? 1 : 0;
}
