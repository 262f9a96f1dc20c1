/* Laws of the outside in motion, by forms that share nothing but the law: a network in the mixed
 * form, one of strain modes, modes and nodes. A magnetised rod in a field that turns, with a
 * gradient; and a rod in a fluid that resists it along and across, moves with it and carries it. */
#include "fewer.h"
#include "near.h"
#include "temporary_folder.h"

#include "cpinn.h"
#include "physics/solve/solve.h"
#include "tools/prepare/prepare.h"

#include <stdio.h>
#include <string.h>

enum { FORMS = 4, PLACES = 4 };

/* Of the length. Forms are as far apart as their own errors are, of which the largest is estimated
 * at 1e-7; without the law they would be apart by `moved`. */
static const double AGREE = 1e-6;

#define ROD                                                                                        \
    "rod: {model: cosserat, length: 1, stiffness: {shear: [545, 545], axial: 1600, bending: [1, "  \
    "1], torsion: 0.77}, inertia: {mass_per_length: 1, rotary: [6.25e-4, 6.25e-4, 1.25e-3]}}\n"    \
    "time: {duration: 1}\n"

static const struct {
    const char *text, *without;
    double moved;
} scenes[] = {
    {ROD "loads: {magnetic: {moment: [0, 0.2, 1], field: ['2*sin(2*t)^2', '0.5*t^2', '-t^2'],\n"
         "                   gradient: [0, 0, 0, '0.3*t^2', 0]}}\n",
     "loads=null", 0.3},
    {ROD "loads: {force: [0, '4*sin(2*t)^2', 0], gravity: [0, 0, '-t^2'], buoyancy: 0.3,\n"
         "        fluid: {along: [0.1, 0.2, 0.1], across: [0.2, 2, 1], added_mass: 0.6}}\n",
     "loads.fluid=null", 0.1}};

static const double s[PLACES] = {1, 0.6, 1, 0.6}, t[PLACES] = {1, 1, 0.5, 0.5};

static void by_network(const char *path, const char *form, double values[3 * PLACES])
{
    const char *const overrides[] = {form};
    const cpinn_options options = {.threads = 1};
    ad_error error = {.message = ""};
    cpinn_model *model = NULL;
    evaluator *at = NULL;
    if (cpinn_train_file(path, 1, overrides, &options, &model, &error) != AD_OK ||
        cpinn_evaluator(model, "r", &at, &error) != AD_OK ||
        evaluator_evaluate(at, PLACES, s, t, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    assert_int_equal(verdict_outcome_of(cpinn_verdict(model)), VERDICT_SOLVED);
    evaluator_free(at);
    cpinn_free(model);
}

static void by_solver(const char *text, int count, const char *const *overrides,
                      solve_method method, double values[3 * PLACES])
{
    static const double times[2] = {0.5, 1};
    const solve_settings asked = {.tolerance = 1e-7, .method = method};
    ad_error error = {.message = ""};
    config *read = NULL;
    solution *solved = NULL;
    solve_report report;
    if (prepare_read("scene.yaml", text, count, overrides, &read, &error) != AD_OK ||
        solution_create(&read->scene, &asked, 2, times, &solved, &report, &error) != AD_OK ||
        solution_evaluate(solved, 3, PLACES, s, t, values, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    solution_free(solved);
    config_free(read);
}

static void test_agree(void **state)
{
    (void)state;
    for (size_t k = 0; k < FEWER(sizeof scenes / sizeof *scenes); k++) {
        double values[FORMS][3 * PLACES], without[3 * PLACES], moved = 0;
        const char *const changes[] = {scenes[k].without};
        char path[512];
        snprintf(path, sizeof path, "%s", at("scene.yaml"));
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fputs(scenes[k].text, file);
        assert_int_equal(fclose(file), 0);
        by_network(path, "formulation=mixed", values[0]);
        by_network(path, "formulation=strain", values[1]);
        by_solver(scenes[k].text, 0, NULL, SOLVE_MODES, values[2]);
        by_solver(scenes[k].text, 0, NULL, SOLVE_COLLOCATION, values[3]);
        by_solver(scenes[k].text, 1, changes, SOLVE_COLLOCATION, without);
        for (int i = 0; i < 3 * PLACES; i++) {
            for (int form = 1; form < FORMS; form++) {
                assert_near(values[form][i], values[0][i], AGREE);
            }
            moved = fmax(moved, fabs(values[0][i] - without[i]));
        }
        assert_true(moved > scenes[k].moved);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_agree, make_directory, remove_directory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
