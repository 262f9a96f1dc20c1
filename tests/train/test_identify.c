/* Unknowns from measurements by solving: whether the truth lies within the stated deviations as
 * often as it should, what the measurements do not tell, and what is refused. */
#include "fewer.h"
#include "good.h"
#include "resume_testing.h"

#include "nn/rng.h"
#include "tools/train/identify.h"

#include <stdlib.h>
#include <string.h>

/* A precurved rod, pulled at its tip by a known force that turns from experiment to experiment, and
 * loaded by an unknown weight; two stiffnesses are unknown, too. */
enum { TURNED, PULL, BENDING, TORSION, WEIGHT, PARAMETERS, UNKNOWNS = PARAMETERS - BENDING };

static const double LENGTH = 0.2;
static const double truth[PARAMETERS] = {0, 0, 3.1e-3, 1.9e-3, 0.03};

typedef struct made {
    quantities *names;
    scene open;
} made;

static made make_scene(void)
{
    static const scene_parameter parameters[PARAMETERS] = {{"turned", 0, 6.3, SCENE_LINEAR},
                                                           {"pull", 0, 0.2, SCENE_LINEAR},
                                                           {"bending", 1e-3, 1e-2, SCENE_LOG},
                                                           {"torsion", 1e-3, 1e-2, SCENE_LOG},
                                                           {"weight", -0.1, 0.1, SCENE_LINEAR}};
    static const double starts[PARAMETERS] = {0, 0, 2e-3, 4e-3, 0};
    made m = {.names = quantities_create()};
    ad_error error;
    scene *x = &m.open;
    scene_defaults(x);
    for (int i = 0; i < PARAMETERS; i++) {
        assert_good(quantities_coordinate(m.names, parameters[i].name, &error), &error);
        x->parameters[i] = parameters[i];
        x->guess[i] = starts[i];
    }
    x->parameter_count = PARAMETERS;
    x->unknown_count = UNKNOWNS;
    x->names = m.names;
    x->rod.model = SCENE_KIRCHHOFF;
    x->rod.length = quantity_number(LENGTH);
    for (int i = 0; i < 2; i++) {
        x->rod.bending_stiffness[i] = quantity_formula(m.names, "bending");
    }
    x->rod.torsional_stiffness = quantity_formula(m.names, "torsion");
    for (int i = 0; i < 3; i++) {
        x->rod.rest_curvature[i] = quantity_number(i == 1 ? 8 : 0);
    }
    x->loads.tip.force[0] = quantity_formula(m.names, "pull*cos(turned)");
    x->loads.tip.force[1] = quantity_formula(m.names, "pull*sin(turned)");
    x->loads.tip.force[2] = quantity_formula(m.names, "-weight");
    x->end.type = SCENE_LOADED;
    return m;
}

static void free_scene(made *m)
{
    quantities_free(m->names);
}

/* ---- measurements -------------------------------------------------------------------------- */

enum { EXPERIMENTS = 20, COORDINATES = 3 };

typedef struct tips {
    double s[EXPERIMENTS], t[EXPERIMENTS], known[EXPERIMENTS][PARAMETERS];
    double exact[COORDINATES][EXPERIMENTS], values[COORDINATES][EXPERIMENTS];
    solve_measured set;
} tips;

static bool pulled = true;

/* Where the tip is, by the solver of single scenes. */
static void measure_tips(const made *m, double noise, tips *x)
{
    ad_error error;
    x->set = (solve_measured){.rows = EXPERIMENTS,
                              .s = x->s,
                              .t = x->t,
                              .known = x->known[0],
                              .columns = COORDINATES,
                              .column = {0, 1, 2},
                              .noise = {noise, noise, noise},
                              .values = x->values[0]};
    for (int i = 0; i < EXPERIMENTS; i++) {
        double values[PARAMETERS], tip[COORDINATES];
        scene member;
        solution *solved;
        solve_report report;
        memcpy(values, truth, sizeof values);
        values[TURNED] = 6.28 * i / EXPERIMENTS;
        values[PULL] = pulled ? 0.05 + 0.1 * (i % 3) / 2 : 0;
        memcpy(x->known[i], values, sizeof values);
        x->s[i] = LENGTH;
        x->t[i] = 0;
        scene_member(&m->open, values, &member);
        solve_settings settings = solve_settings_default(&member);
        assert_good(solution_create(&member, &settings, 0, NULL, &solved, &report, &error), &error);
        assert_good(solution_evaluate(solved, COORDINATES, 1, &LENGTH, NULL, tip, &error), &error);
        solution_free(solved);
        for (int c = 0; c < COORDINATES; c++) {
            x->exact[c][i] = tip[c];
        }
    }
}

static void add_noise(tips *x, nn_rng *random)
{
    for (int c = 0; c < COORDINATES; c++) {
        for (int i = 0; i < EXPERIMENTS; i++) {
            x->values[c][i] = x->exact[c][i] + x->set.noise[c] * nn_rng_normal(random);
        }
    }
}

static int draws = FEWER(20); /* an argument makes it another number */

/* 68.3 % of all errors lie within one deviation, 95.4 % within two; counts may be off by four
 * deviations of their own, as may the mean of chi squared. */
static void test_calibrated(void **state)
{
    (void)state;
    const int DRAWS = draws;
    made m = make_scene();
    tips x;
    ad_error error;
    nn_rng random = nn_rng_seed(1);
    int within_one = 0, within_two = 0;
    double chi_squared = 0;
    measure_tips(&m, 5e-4, &x);
    for (int draw = 0; draw < DRAWS; draw++) {
        const identify_settings settings = {.threads = 1};
        identified found;
        verdict judged = {.count = 0};
        add_noise(&x, &random);
        assert_good(identify(&m.open, 1, &x.set, &settings, &found, &error), &error);
        identified_verdict(&found, &m.open, &judged);
        assert_true(found.by_members && found.count == UNKNOWNS && found.experiments == 20);
        assert_int_equal(verdict_outcome_of(&judged), VERDICT_SOLVED);
        for (int i = 0; i < UNKNOWNS; i++) {
            const double off = fabs(found.value[i] - truth[BENDING + i]) / found.deviation[i];
            within_one += off < 1;
            within_two += off < 2;
        }
        chi_squared += found.chi_squared;
    }
    print_message("within one deviation %.1f %%, within two %.1f %%, chi squared %.2f of %d\n",
                  100.0 * within_one / (UNKNOWNS * DRAWS), 100.0 * within_two / (UNKNOWNS * DRAWS),
                  chi_squared / DRAWS, COORDINATES * EXPERIMENTS - UNKNOWNS);
    const double numbers = UNKNOWNS * DRAWS;
    assert_near(within_one / numbers, 0.683, 4 * sqrt(0.683 * 0.317 / numbers));
    assert_near(within_two / numbers, 0.954, 4 * sqrt(0.954 * 0.046 / numbers));
    assert_near(chi_squared / DRAWS, 57, 4 * sqrt(2.0 * 57 / DRAWS));
    free_scene(&m);
}

/* Without the known force nothing but ratios of stiffness and weight can be seen. */
static void test_not_told(void **state)
{
    (void)state;
    made m = make_scene();
    tips x;
    ad_error error;
    nn_rng random = nn_rng_seed(2);
    const identify_settings settings = {.threads = 1};
    identified found;
    verdict judged = {.count = 0};
    pulled = false;
    measure_tips(&m, 5e-4, &x);
    pulled = true;
    add_noise(&x, &random);
    assert_good(identify(&m.open, 1, &x.set, &settings, &found, &error), &error);
    identified_verdict(&found, &m.open, &judged);
    assert_true(found.information.untold >= 1);
    assert_true(verdict_has(&judged, VERDICT_NOT_TOLD));
    free_scene(&m);
}

/* Left before the first step, within the first descent and in one from elsewhere. */
static void test_resumed(void **state)
{
    (void)state;
    made m = make_scene();
    tips x;
    ad_error error;
    nn_rng random = nn_rng_seed(3);
    stops to = {.after = -1};
    const least_squares_runner runner = {run_and_stop, &to};
    const identify_settings settings = {.threads = 1, .runner = &runner};
    identified found, same;
    measure_tips(&m, 5e-4, &x);
    add_noise(&x, &random);
    assert_good(identify(&m.open, 1, &x.set, &settings, &found, &error), &error);
    assert_true(to.end.window > 0);
    const int64_t after[] = {0, 2, to.end.step - 1, to.end.step};
    for (size_t i = 0; i < sizeof after / sizeof *after; i++) {
        to.after = after[i];
        to.resumes = false;
        assert_good(identify(&m.open, 1, &x.set, &settings, &same, &error), &error);
        assert_true(same.count == (after[i] == to.end.step ? UNKNOWNS : 0));
        to.resumes = true;
        assert_good(identify(&m.open, 1, &x.set, &settings, &same, &error), &error);
        assert_memory_equal(found.value, same.value, sizeof found.value);
        assert_memory_equal(found.deviation, same.deviation, sizeof found.deviation);
        assert_memory_equal(&found.chi_squared, &same.chi_squared, sizeof found.chi_squared);
        assert_true(found.steps == same.steps && found.solutions == same.solutions);
        assert_true(found.others == same.others && found.converged == same.converged);
    }
    history_free(&to.whole);
    free_scene(&m);
}

static void test_too_few(void **state)
{
    (void)state;
    made m = make_scene();
    tips x;
    ad_error error;
    const identify_settings settings = {.threads = 1};
    identified found;
    measure_tips(&m, 5e-4, &x);
    x.set.rows = 2;
    x.set.columns = 1;
    assert_int_equal(identify(&m.open, 1, &x.set, &settings, &found, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "2 measured numbers for 3 unknowns"));
    free_scene(&m);
}

int main(int count, char **arguments)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_not_told),
        cmocka_unit_test(test_too_few),
        cmocka_unit_test(test_resumed),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_calibrated)};
    draws = count > 1 ? atoi(arguments[1]) : draws;
    return run_with_alike(tests, alike, make_directory, remove_directory);
}
