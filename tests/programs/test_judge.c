/* Scenes by methods: the verdicts that only a judge comes to, each by a scene that provokes it. */
#include "near.h"
#include "temporary_folder.h"

#include "tools/judge/judge.h"

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
    FILE *file = fopen(at("scene.yaml"), "w");
    assert_true(file && fputs(task.path ? task.path : ROLLUP, file) >= 0 && fclose(file) == 0);
    task.path = at("scene.yaml"); /* `path` was its text */
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

/* The rolled-up rod is linear in the default network: right to rounding, as in the solver. */
static void test_solved(void **state)
{
    (void)state;
    for (int method = 0; method < JUDGE_METHODS; method++) {
        judge_row row = judge((judge_task){.method = (judge_method)method});
        assert_int_equal(verdict_worst(&row.verdict), VERDICT_NONE);
        assert_true(row.errors[JUDGE_POSITION] < 1e-8 && row.errors[JUDGE_ROTATION] < 1e-8);
        assert_true(row.seconds > 0 && row.steps > 0);
        assert_string_equal(row.form,
                            method == JUDGE_NETWORK ? "mixed form by random waves" : "collocation");
    }
}

static void test_no_answer(void **state)
{
    (void)state;
    static const char missing[] = "rod: {length: 1}\n";
    assert_reason((judge_task){.path = missing}, VERDICT_BAD_INPUT);
    assert_reason((judge_task){.path = missing, .method = JUDGE_SOLVER}, VERDICT_BAD_INPUT);
    assert_reason((judge_task){.seconds = 1e-9}, VERDICT_TIME_LIMIT);
}

/* ---- processes ----------------------------------------------------------------------------- */

static ad_status die(void *context, session *s, bool is_last, ad_error *error)
{
    (void)context, (void)s, (void)is_last, (void)error;
    raise(SIGKILL);
    return AD_OK;
}

static ad_status run_on(void *context, session *s, bool is_last, ad_error *error)
{
    (void)context, (void)s, (void)is_last, (void)error;
    for (;;) {
        pause();
    }
    return AD_OK;
}

/* Training looks at the clock by itself, the solver does not. */
static void test_processes(void **state)
{
    (void)state;
    assert_reason((judge_task){.step = die}, VERDICT_DIED);
    assert_reason((judge_task){.step = run_on, .patience = 0.5}, VERDICT_KILLED);
    assert_reason((judge_task){.patience = 1e-9, .method = JUDGE_SOLVER}, VERDICT_TIME_LIMIT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_solved),
                                       cmocka_unit_test(test_no_answer),
                                       cmocka_unit_test(test_processes)};
    return cmocka_run_group_tests(tests, make_directory, remove_directory);
}
