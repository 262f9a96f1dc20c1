/* Scenes by methods: the verdicts that only a judge comes to, each by a scene that provokes it. */
#include "near.h"

#include "tools/judge/stress.h"

#include <signal.h>
#include <unistd.h>

#define ROLLUP                                                                                     \
    "rod: {model: kirchhoff, length: 1, stiffness: {bending: [1, 1], torsion: 1}}\n"               \
    "loads: {tip: {moment: [0, 1, 0]}}\n"                                                          \
    "reference: {analytic: rollup}\n"

static judge_row judge(judge_task task)
{
    judge_row row;
    ad_error error = {AD_OK, ""};
    task.path = "scene.yaml";
    task.text = task.text ? task.text : ROLLUP;
    task.threads = 1;
    task.seconds = task.seconds > 0 ? task.seconds : 60;
    task.patience = task.patience > 0 ? task.patience : 60;
    if (judge_run(&task, &row, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return row;
}

static void assert_reason(judge_task task, verdict_reason wanted)
{
    judge_row row = judge(task);
    if (verdict_worst(&row.verdict) != wanted) {
        fail_msg("%s instead of %s: %s", verdict_reason_name(verdict_worst(&row.verdict)),
                 verdict_reason_name(wanted), verdict_text(&row.verdict));
    }
}

/* ---- answers ------------------------------------------------------------------------------- */

static ad_status quarter(const judge_answer *a, double *value, ad_error *error)
{
    (void)error;
    *value = a->errors[JUDGE_POSITION] < 1e-8 ? 0.25 : NAN;
    return AD_OK;
}

/* The rolled-up rod is linear in the default network: right to rounding, as in the solver. */
static void test_solved(void **state)
{
    (void)state;
    for (int method = 0; method < JUDGE_METHODS; method++) {
        judge_row row = judge((judge_task){.method = (judge_method)method});
        assert_int_equal(verdict_worst(&row.verdict), VERDICT_NONE);
        assert_true(row.error < 1e-8 && row.error == row.errors[JUDGE_POSITION]);
        assert_true(row.errors[JUDGE_ROTATION] < 1e-8 && row.seconds > 0 && row.steps > 0);
        assert_string_equal(row.form,
                            method == JUDGE_NETWORK ? "mixed form by random waves" : "collocation");
        row = judge((judge_task){.method = (judge_method)method, .measure = quarter});
        assert_near(row.error, 0.25, 0);
    }
}

static void test_no_answer(void **state)
{
    (void)state;
    static const char missing[] = "rod: {length: 1}\n";
    assert_reason((judge_task){.text = missing}, VERDICT_BAD_INPUT);
    assert_reason((judge_task){.text = missing, .method = JUDGE_SOLVER}, VERDICT_BAD_INPUT);
    assert_reason((judge_task){.seconds = 1e-9}, VERDICT_TIME_LIMIT);
    assert_reason((judge_task){.seconds = 1e-9, .by_processor = true}, VERDICT_TIME_LIMIT);
}

/* ---- processes ----------------------------------------------------------------------------- */

static ad_status die(const judge_answer *a, double *value, ad_error *error)
{
    (void)a, (void)value, (void)error;
    raise(SIGKILL);
    return AD_OK;
}

static ad_status run_on(const judge_answer *a, double *value, ad_error *error)
{
    (void)a, (void)value, (void)error;
    for (;;) {
        pause();
    }
    return AD_OK;
}

/* Training looks at the clock by itself, the solver does not. */
static void test_processes(void **state)
{
    (void)state;
    assert_reason((judge_task){.measure = die}, VERDICT_DIED);
    assert_reason((judge_task){.measure = run_on, .patience = 0.5}, VERDICT_KILLED);
    assert_reason((judge_task){.measure = run_on, .patience = 0.5, .method = JUDGE_SOLVER},
                  VERDICT_TIME_LIMIT);
}

/* ---- expectations -------------------------------------------------------------------------- */

static void test_wrong(void **state)
{
    (void)state;
    const stress_row row = {.scene = ROLLUP,
                            .expected = {{.outcome = VERDICT_SOLVED, .bound = 1e-8, .why = "exact"},
                                         {.outcome = VERDICT_SOLVED, .bound = 0, .why = "never"}}};
    judge_row result;
    ad_error error = {AD_OK, ""};
    assert_int_equal(stress_run(&row, JUDGE_NETWORK, "/tmp", &result, &error), AD_OK);
    assert_true(stress_as_expected(&row.expected[JUDGE_NETWORK], &result.verdict));
    assert_int_equal(stress_run(&row, JUDGE_SOLVER, "/tmp", &result, &error), AD_OK);
    assert_int_equal(verdict_worst(&result.verdict), VERDICT_ERROR_ABOVE_BOUND);
    assert_int_equal(verdict_outcome_of(&result.verdict), VERDICT_WRONG);
    assert_false(stress_as_expected(&row.expected[JUDGE_SOLVER], &result.verdict));
}

/* Another reason may be worse than the one that is expected; the outcome has to be that one. */
static void test_as_expected(void **state)
{
    (void)state;
    stress_expectation expected = {.outcome = VERDICT_WARNING, .reason = VERDICT_UNSTABLE};
    verdict found = {.count = 0};
    assert_false(stress_as_expected(&expected, &found));
    verdict_add(&found, VERDICT_NOT_CONVERGED, "residuals");
    assert_false(stress_as_expected(&expected, &found));
    verdict_add(&found, VERDICT_UNSTABLE, "in 2 directions");
    assert_true(stress_as_expected(&expected, &found));
    expected.text = "2 directions";
    assert_true(stress_as_expected(&expected, &found));
    expected.text = "3 directions";
    assert_false(stress_as_expected(&expected, &found));
    expected = (stress_expectation){.outcome = VERDICT_WARNING};
    assert_true(stress_as_expected(&expected, &found));
    verdict_add(&found, VERDICT_DIED, "signal 9");
    assert_false(stress_as_expected(&expected, &found));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_solved), cmocka_unit_test(test_no_answer),
        cmocka_unit_test(test_processes), cmocka_unit_test(test_wrong),
        cmocka_unit_test(test_as_expected)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
