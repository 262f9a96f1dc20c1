/* Own equations from YAML: what is read, and what is refused with its place. */
#include "tools/config/config_equations.h"

#include "allocations.h"
#include "near.h"
#include "temporary_folder.h"

#include <glob.h>
#include <stdio.h>
#include <string.h>

#ifndef CONFIGS_FOLDER
#define CONFIGS_FOLDER "configs"
#endif

static const char burgers[] = "equations:\n"
                              "  coordinates:\n"
                              "    x: {range: [-L, L], unit: m}\n"
                              "    t: {range: [0, 1], time: true}\n"
                              "  parameters: {nu: 0.01/pi, L: 1, flux: nu*u_x}\n"
                              "  fields: [u]\n"
                              "  inside: [u_t + u*u_x - nu*u_xx]\n"
                              "  conditions:\n"
                              "    - {at: {t: 0}, u: -sin(pi*x)}\n"
                              "    - {at: {x: -L}, u: 0}\n"
                              "    - at: {x: L}\n"
                              "      zero: flux + u^4\n"
                              "fit: {tolerance: 1e-8}\n";

static config_equations *take(const char *text, int count, const char *const *overrides)
{
    config_equations *c = NULL;
    ad_error error = {.message = ""};
    if (config_equations_read("some/burgers.yaml", text, count, overrides, &c, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return c;
}

static void reads(void **state)
{
    (void)state;
    config_equations *c = take(burgers, 0, NULL);
    const physics_model *m = c->model;
    assert_string_equal(c->name, "burgers");
    assert_near(c->tolerance, 1e-8, 0);
    assert_near(c->seconds, CONFIG_FIT_SECONDS, 0);
    assert_int_equal(m->domain.count, 2);
    assert_string_equal(m->domain.coordinates[0].name, "x");
    assert_string_equal(m->domain.coordinates[0].unit, "m");
    assert_near(m->domain.coordinates[0].low, -1, 0);
    assert_int_equal(m->domain.time, 1);
    assert_int_equal(m->condition_count, 2);
    assert_int_equal(m->term_count, 4);
    config_equations_free(c);
}

/* Overrides change keys, add some to a section, and take some away. */
static void overrides(void **state)
{
    (void)state;
    const char *const changes[] = {"equations.parameters.L=2",
                                   "equations.parameters.k={range: [1, 2]}",
                                   "equations.conditions[0].u=k*x",
                                   "equations.coordinates.y.range=[0, 2*pi]",
                                   "equations.coordinates.y={range: [0, 1], periodic: true}",
                                   "equations.conditions[2].zero=null",
                                   "equations.conditions[2].u=0",
                                   "fit.seconds=5",
                                   "name=other"};
    config_equations *c = take(burgers, sizeof changes / sizeof *changes, changes);
    const physics_model *m = c->model;
    assert_string_equal(c->name, "other");
    assert_near(c->seconds, 5, 0);
    assert_int_equal(m->domain.count, 4);
    assert_near(m->domain.coordinates[0].high, 2, 0);
    assert_string_equal(m->domain.coordinates[2].name, "y");
    assert_near(m->domain.coordinates[2].high, 2 * 3.14159265358979323846, 1e-15);
    assert_true(m->domain.coordinates[2].periodic);
    assert_true(equations_is_range(c->equations, 3));
    assert_int_equal(m->condition_count, 3);
    config_equations_free(c);
}

static void write_data(const char *table)
{
    FILE *file = fopen(at("measured.csv"), "w");
    assert_non_null(file);
    fputs(table, file);
    assert_int_equal(fclose(file), 0);
}

/* Data lie beside the file. */
static void reads_data(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    config_equations *c = NULL;
    write_data("t,x,u\n0,0.5,1\n1,-0.5,nan\n");
    const char *const changes[] = {"equations.parameters.nu={guess: 0.1}",
                                   "equations.data={file: measured.csv, noise: 0.5}"};
    if (config_equations_read(at("some.yaml"), burgers, 2, changes, &c, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(c->model->own_unknown_count, 1);
    assert_near(c->model->own_unknowns[0].guess, 0.1, 0);
    assert_int_equal(c->model->sets[c->model->terms[4].set].source.points, 1);
    config_equations_free(c);

    write_data("t,x,w\n0,0.5,1\n");
    assert_int_equal(config_equations_read(at("some.yaml"), burgers, 2, changes, &c, &error),
                     AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "equations.data: measured.csv: the column 'w' is nothing "
                                          "of the model; allowed: x, t, u"));
    assert_null(c);
}

static void refuses(void **state)
{
    (void)state;
    static const char *const rows[][2] = {
        {"equations.inside=[u_t + w]", "equations.inside[0]: column 7 of 'u_t + w': unknown name"},
        {"equations.inside=[u_t + u_z]", "allowed behind u_ are coordinates"},
        {"equations.inside=null", "equations: there is no equation inside"},
        {"equations.fields=null", "unknown name 'u_x'"},
        {"equations.fields=[u, v]", "no equation has the field v"},
        {"equations.coordinates.x=[0, 1]", "equations.coordinates.x: is no section"},
        {"equations.coordinates.x.range=[0]", "has 1 numbers; allowed: 2"},
        {"equations.coordinates.x.range=[1, 0]", "from 1 to 0"},
        {"equations.coordinates.x.range=[0, t]", "unknown name 't'"},
        {"equations.coordinates.x.time=true", "t is a second coordinate of time"},
        {"equations.coordinates.x.time=1", "is '1'; allowed: true, false"},
        {"equations.coordinates.x.rang=1", "did you mean range?"},
        {"equations.coordinates.z={unit: m}", "equations.coordinates.z: has no range"},
        {"equations.parameters.nu={}", "equations.parameters.nu: allowed: a number, a formula"},
        {"equations.parameters.nu={gess: 1}", "did you mean guess?"},
        {"equations.parameters.nu={guess: 1}", "nothing is measured that would say what nu is"},
        {"equations.parameters.nu=[1]", "is no number or formula"},
        {"equations.conditions[0].at.t=0.5", "t = 0.5 is no face; allowed: 0, where time begins"},
        {"equations.conditions[0].at.x=0", "has a face of several coordinates"},
        {"equations.conditions[0].at=null", "equations.conditions[0]: has no face"},
        {"equations.conditions[0].u=null", "says nothing of what is there"},
        {"equations.conditions[0].u_x=0", "u_x is a derivative along a face of t"},
        {"equations.conditions[0].u_t=0", "2 conditions at the ends of t"},
        {"equations.data={file: none.csv}", "equations.data: some/none.csv: "},
        {"equations.data={noise: 1}", "equations.data: has no file"},
        {"equations.data={file: a, noise: 0}", "equations.data.noise: is 0; allowed: above 0"},
        {"equations.condition=1", "did you mean conditions?"},
        {"equations.conditions[9].u=1", "there is nothing at equations.conditions[9].u"},
        {"equations=null", "has no equations; needed: a section equations. Scenes of rods"},
        {"fit.tolerance=-1", "fit.tolerance: is -1; allowed: above 0"},
        {"fit=3", "fit: is no section"},
        {"rod.length=3", "rod.length=3: there is nothing at rod.length"},
        {"rod=3", "unknown key; allowed: name, equations, fit"},
        {"nothing", "override nothing: allowed: key=value"}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        config_equations *c = NULL;
        ad_error error = {.message = ""};
        assert_int_equal(
            config_equations_read("some/burgers.yaml", burgers, 1, &rows[i][0], &c, &error),
            AD_BAD_INPUT);
        assert_null(c);
        if (!strstr(error.message, rows[i][1])) {
            fail_msg("%s: '%s' says nothing of '%s'", rows[i][0], error.message, rows[i][1]);
        }
    }
}

/* Whichever allocation fails: no memory, or a whole model. */
static void runs_out_of_memory(void **state)
{
    (void)state;
    ad_status status = AD_NO_MEMORY;
    for (long n = 1; status != AD_OK && n < 10000; n++) {
        config_equations *c = NULL;
        ad_error error = {.message = ""};
        allocations = 0;
        failing_allocation = n;
        allocations_count = true;
        status = config_equations_read("some/burgers.yaml", burgers, 0, NULL, &c, &error);
        allocations_count = false;
        failing_allocation = 0;
        assert_true(status == AD_OK ? c != NULL : status == AD_NO_MEMORY && c == NULL);
        config_equations_free(c);
    }
    assert_int_equal(status, AD_OK);
}

/* Line and column. */
static void names_places(void **state)
{
    (void)state;
    config_equations *c = NULL;
    ad_error error = {.message = ""};
    assert_int_equal(
        config_equations_read("a.yaml", "equations:\n  inside: [1\n", 0, NULL, &c, &error),
        AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "a.yaml:3:"));
    const char *const text = "equations:\n  coordinates: {x: {range: [0, 1]}}\n  fields: [u]\n"
                             "  inside:\n    - u_x\n    - u_xx + v\n";
    assert_int_equal(config_equations_read("a.yaml", text, 0, NULL, &c, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "a.yaml:6:7: equations.inside[1]: column 8"));
}

/* Those of the folder configs/equations, with their data. */
static void reads_shipped(void **state)
{
    (void)state;
    glob_t found;
    assert_int_equal(glob(CONFIGS_FOLDER "/equations/*.yaml", 0, NULL, &found), 0);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        config_equations *c = NULL;
        ad_error error = {.message = ""};
        if (config_equations_read(found.gl_pathv[i], NULL, 0, NULL, &c, &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        config_equations_free(c);
    }
    globfree(&found);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads),
        cmocka_unit_test(overrides),
        cmocka_unit_test(reads_shipped),
        cmocka_unit_test_setup_teardown(reads_data, make_directory, remove_directory),
        cmocka_unit_test(refuses),
        cmocka_unit_test(runs_out_of_memory),
        cmocka_unit_test(names_places)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
