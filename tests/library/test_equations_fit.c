/* Equations of one's own through the face of the library: solved, kept, read and evaluated. */
#include "tools/library/cpinn.h"

#include "done.h"
#include "temporary_folder.h"

#include <string.h>

static const double pi = 3.14159265358979323846;

/* Heat in a bar with cold ends: u = exp(-pi^2 k t) sin(pi x). */
static equations *heat(void)
{
    equations *e = equations_create();
    assert_non_null(e);
    DONE(
        equations_add_coordinate(e, &(equations_coordinate){"x", "m", 0, 1, false, false}, &error));
    DONE(equations_add_coordinate(e, &(equations_coordinate){"t", "s", 0, 0.5, false, true},
                                  &error));
    DONE(equations_add_field(e, "u", &error));
    return e;
}

static void add_conditions(equations *e)
{
    DONE(equations_add_inside(e, "u_t - k*u_xx", &error));
    DONE(equations_add_condition(e, "t", 0, "u", "sin(pi*x)", &error));
    DONE(equations_add_condition(e, "x", 0, "u", "0", &error));
    DONE(equations_add_condition(e, "x", 1, "u", "0", &error));
}

/* What is said of the error is not below a tenth of it. */
static void solves(void **state)
{
    (void)state;
    const double k = 0.4, x[3] = {0.1, 0.5, 0.8}, t[3] = {0, 0.2, 0.5};
    const double *const at_these[] = {x, t};
    double values[3], errors[3], again[3];
    cpinn_fit *fit, *read;
    equations *e = heat();
    DONE(equations_add_parameter(e, "k", "0.4", &error));
    add_conditions(e);
    DONE(cpinn_fit_equations(e, &(cpinn_fit_options){.tolerance = 1e-8, .threads = 1}, &fit,
                             &error));
    assert_int_equal(verdict_outcome_of(cpinn_fit_verdict(fit)), VERDICT_SOLVED);
    const patches_summary s = cpinn_fit_summary(fit);
    assert_true(s.estimate > 0 && s.estimate <= 1e-8);
    DONE(cpinn_fit_evaluate(fit, "u", 3, at_these, values, errors, &error));
    for (int i = 0; i < 3; i++) {
        const double exact = exp(-pi * pi * k * t[i]) * sin(pi * x[i]);
        assert_near(values[i], exact, 30 * s.estimate);
        assert_true(isfinite(errors[i]));
    }
    DONE(cpinn_fit_evaluate(fit, "u_xt", 3, at_these, again, errors, &error));
    for (int i = 0; i < 3; i++) { /* two derivatives of an error of 1e-8: some hundred times it */
        const double exact = -pi * pi * pi * k * exp(-pi * pi * k * t[i]) * cos(pi * x[i]);
        assert_near(again[i], exact, 1e-4);
        assert_true(errors[i] >= 0 && errors[i] < 1e-4);
    }

    DONE(cpinn_fit_save(fit, at("heat.h5"), &error));
    DONE(cpinn_fit_open(at("heat.h5"), &read, &error));
    assert_string_equal(cpinn_fit_coordinate(read, 1), "t");
    assert_string_equal(cpinn_fit_model(read)->domain.coordinates[0].unit, "m");
    assert_null(cpinn_fit_coordinate(read, 2));
    assert_string_equal(cpinn_fit_field(read, 0), "u");
    assert_null(cpinn_fit_unknown(read, 0));
    assert_near(cpinn_fit_tolerance(read), 1e-8, 0);
    DONE(cpinn_fit_evaluate(read, "u", 3, at_these, again, NULL, &error));
    assert_memory_equal(again, values, sizeof values);
    assert_int_equal(verdict_outcome_of(cpinn_fit_verdict(read)), VERDICT_SOLVED);

    assert_int_equal(cpinn_fit_evaluate(fit, "v", 3, at_these, values, NULL, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "'v' is no field"));
    assert_int_equal(cpinn_fit_evaluate(fit, "u", 1, (const double *const[]){&k, &(double){0.6}},
                                        values, NULL, &error),
                     AD_BAD_INPUT);
    assert_string_equal(error.message, "t is 0.6; allowed: 0 to 0.5");
    cpinn_fit_free(read);
    cpinn_fit_free(fit);
    equations_free(e);
}

/* An unknown, from numbers without noise: to what the solution is exact to. */
static void finds_unknown(void **state)
{
    (void)state;
    enum { COUNT = 20 };
    double x[COUNT], t[COUNT], u[COUNT];
    cpinn_fit *fit, *read;
    equations *e = heat();
    for (int i = 0; i < COUNT; i++) {
        x[i] = (i % 5 + 1) / 6.0;
        t[i] = 0.1 * (i / 5 + 1);
        u[i] = exp(-pi * pi * 0.4 * t[i]) * sin(pi * x[i]);
    }
    DONE(equations_add_unknown(e, "k", 0.2, &error));
    add_conditions(e);
    DONE(equations_add_data(e, COUNT, 3, (const char *const[]){"u", "x", "t"},
                            (const double *const[]){u, x, t}, 0, &error));
    DONE(cpinn_fit_equations(e, &(cpinn_fit_options){.tolerance = 1e-7, .threads = 1}, &fit,
                             &error));
    assert_near(cpinn_fit_summary(fit).unknown[0], 0.4, 1e-6);
    DONE(cpinn_fit_save(fit, at("unknown.h5"), &error));
    DONE(cpinn_fit_open(at("unknown.h5"), &read, &error));
    assert_string_equal(cpinn_fit_unknown(read, 0), "k");
    assert_near(cpinn_fit_summary(read).unknown[0], cpinn_fit_summary(fit).unknown[0], 0);
    cpinn_fit_free(read);
    cpinn_fit_free(fit);
    equations_free(e);
}

static bool stop(void *context, const patches_progress *now)
{
    (void)now;
    ++*(int *)context;
    return false;
}

static void stops(void **state)
{
    (void)state;
    int calls = 0;
    cpinn_fit *fit;
    equations *e = heat();
    DONE(equations_add_parameter(e, "k", "0.4", &error));
    add_conditions(e);
    DONE(cpinn_fit_equations(e, &(cpinn_fit_options){.progress = stop, .context = &calls}, &fit,
                             &error));
    assert_int_equal(calls, 1);
    assert_int_equal(verdict_worst(cpinn_fit_verdict(fit)), VERDICT_UNFINISHED);
    cpinn_fit_free(fit);
    equations_free(e);
}

static void refuses_files(void **state)
{
    (void)state;
    cpinn_fit *fit;
    assert_int_equal(cpinn_fit_open(at("none.h5"), &fit, &error), AD_IO);
    assert_null(fit);
    FILE *file = fopen(at("text.h5"), "w");
    assert_non_null(file);
    fputs("nothing", file);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(cpinn_fit_open(at("text.h5"), &fit, &error), AD_BAD_INPUT);
    assert_int_equal(cpinn_fit_file(at("none.yaml"), 0, NULL, NULL, &fit, &error), AD_IO);
    assert_null(fit);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(solves), cmocka_unit_test(finds_unknown),
                                       cmocka_unit_test(stops), cmocka_unit_test(refuses_files)};
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
