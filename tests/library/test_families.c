/* Families: one network for all values of parameters, against the classical solvers. */
#include "config_testing.h"
#include "fewer.h"
#include "good.h"
#include "random_numbers.h"

#include "tools/library/cpinn.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { POINTS = 11, MEMBERS = 20 };

static const char REST[] = "configs/families/cantilever.yaml";
static const char MOTION[] = "configs/families/ramp.yaml";

static cpinn_model *train(const char *path, int count, const char *const *overrides,
                          const cpinn_options *options)
{
    cpinn_model *model = NULL;
    ad_error error = {.message = ""};
    assert_good(cpinn_train_file(path, count, overrides, options, &model, &error), &error);
    return model;
}

static evaluator *evaluator_of(const cpinn_model *model, const char *names)
{
    evaluator *result = NULL;
    ad_error error = {.message = ""};
    assert_good(cpinn_evaluator(model, names, &result, &error), &error);
    return result;
}

static void evaluate(evaluator *from, double s, const double *member, double *values)
{
    const double *at[] = {&s, &member[0], &member[1]};
    ad_error error = {.message = ""};
    assert_good(evaluator_evaluate_at(from, 1, at, values, &error), &error);
}

/* Fewer features than by default. */
static const char *const small[] = {"network.fourier.features=100", "reference.solve=null",
                                    "output.every=2"};

/* Largest distance from members that are solved to 1e-9, over the length. */
static double largest_error(evaluator *from)
{
    ad_error error = {.message = ""};
    uint64_t random = 7;
    double s[POINTS], members[MEMBERS][2], worst = 0;
    double values[MEMBERS][POINTS][SOLVE_MEMBERS_COLUMNS];
    cpinn_answer answers[MEMBERS];
    cpinn_family *solver = NULL;
    for (int i = 0; i < POINTS; i++) {
        s[i] = 0.3 * i / (POINTS - 1);
    }
    const cpinn_family_settings settings = {.threads = 1, .points = POINTS, .s = s};
    assert_good(cpinn_family_file(REST, 0, NULL, 1e-9, &settings, &solver, &error), &error);
    for (int i = 0; i < MEMBERS; i++) {
        members[i][0] = random_in(&random, 0, 2);
        members[i][1] = exp(random_in(&random, log(0.5), log(2)));
    }
    assert_good(
        cpinn_family_evaluate(solver, NULL, MEMBERS, members[0], values[0][0], answers, &error),
        &error);
    for (int i = 0; i < MEMBERS; i++) {
        assert_true(answers[i].trusted && answers[i].source == CPINN_FROM_MEMBERS);
        for (int k = 0; k < POINTS; k++) {
            double found[3];
            evaluate(from, s[k], members[i], found);
            for (int c = 0; c < 3; c++) {
                worst = fmax(worst, fabs(found[c] - values[i][k][c]) / 0.3);
            }
        }
    }
    cpinn_family_free(solver);
    return worst;
}

/* 201 functions of three coordinates: 1e-3 at the softest corner, 1e-4 elsewhere; twice that. */
static void test_at_rest(void **state)
{
    (void)state;
    cpinn_model *model = train(REST, 3, small, &(cpinn_options){.threads = 2});
    evaluator *r = evaluator_of(model, "r");
    const double worst = largest_error(r);
    print_message("worst of %d members: %.2g of the length\n", MEMBERS, worst);
    assert_true(worst < 2e-3);
    evaluator_free(r);
    cpinn_free(model);
}

/* By parameters as by differences of fourth order, whose error at this step is 1e-9. */
static void test_derivatives(void **state)
{
    (void)state;
    static const char *const names[] = {"x_load", "x_s_stiffness", "x_load_load"};
    const char *const few[] = {"network.fourier.features=20", "reference.solve=null",
                               "training.stages[0].steps=3"};
    const double member[2] = {1.1, 0.9};
    cpinn_model *model = train(REST, 3, few, &(cpinn_options){.threads = 1});
    evaluator *exact = evaluator_of(model, "x_load x_s_stiffness x_load_load");
    evaluator *field = evaluator_of(model, "x x_s x_load");
    double values[3];
    evaluate(exact, 0.2, member, values);
    for (int i = 0; i < 3; i++) {
        const int along = i == 1;
        const double h = 1e-2;
        double sum = 0;
        for (int k = -2; k <= 2; k++) {
            static const double weights[5] = {1. / 12, -2. / 3, 0, 2. / 3, -1. / 12};
            double moved[2] = {member[0], member[1]}, at[3];
            moved[along] += k * h;
            evaluate(field, 0.2, moved, at);
            sum += weights[k + 2] * at[i == 2 ? 2 : i] / h;
        }
        assert_string_equal(evaluator_column_name(exact, i), names[i]);
        assert_near(values[i], sum, 1e-6 * (1 + fabs(sum)));
    }
    ad_error error = {.message = ""};
    evaluator *none = NULL;
    assert_int_equal(evaluator_evaluate(field, 1, member, NULL, values, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "load is given, too"));
    assert_int_equal(cpinn_evaluator(model, "x_lode", &none, &error), AD_BAD_ARGUMENT);
    evaluator_free(exact);
    evaluator_free(field);
    cpinn_free(model);
}

static bool until_third(void *context, const cpinn_progress *now)
{
    (void)context;
    return now->step < 3;
}

/* Stopped and gone on with, to the same bits. */
static void test_resume(void **state)
{
    (void)state;
    char folder[] = "/tmp/cpinn_family_XXXXXX", command[64];
    const char *const few[] = {"network.fourier.features=20", "reference.solve=null",
                               "training.stages[0].steps=6"};
    const double member[2] = {1.7, 0.6};
    double whole[3], resumed[3];
    assert_non_null(mkdtemp(folder));
    cpinn_model *model = train(REST, 3, few, &(cpinn_options){.threads = 1});
    evaluator *r = evaluator_of(model, "r");
    evaluate(r, 0.3, member, whole);
    evaluator_free(r);
    cpinn_free(model);
    cpinn_options options = {.threads = 2, .folder = folder, .progress = until_third};
    cpinn_free(train(REST, 3, few, &options));
    options.progress = NULL;
    options.resume = true;
    model = train(REST, 3, few, &options);
    r = evaluator_of(model, "r");
    evaluate(r, 0.3, member, resumed);
    assert_memory_equal(whole, resumed, sizeof whole);
    evaluator_free(r);
    cpinn_free(model);
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

/* Two windows: the second begins where the first ends, for every force. The error falls from 3e-3
 * with 120 features by 2e-4 with these to 2e-5 with 250. */
static void test_in_motion(void **state)
{
    (void)state;
    static const char *const few[] = {
        "time.duration=0.3", "time.windows=2", "reference.solve=1e-4",
        WATCHED ? "network.fourier.features=60" : "network.fourier.features=180",
        WATCHED ? "training.stages[0].steps=2" : "training.stages[0].steps=6"};
    cpinn_model *model = train(MOTION, 5, few, &(cpinn_options){.threads = 2});
    const size_t last = cpinn_history_rows(model) - 1;
    const double error = cpinn_history_value(model, last, "tip_error");
    print_message("members in motion: %.2g of the length\n", error);
    assert_true(isfinite(error) && (WATCHED || error < 5e-4)); /* watched, hardly trained */
    cpinn_free(model);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_resume),
        cmocka_unit_test(test_in_motion),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_at_rest)};
    return run_with_alike(tests, alike, NULL, NULL);
}
