/* Verdicts: their order, their words and what programs do with them. */
#include "physics/scene/verdict.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

static void test_without_findings(void **state)
{
    (void)state;
    const verdict v = {.count = 0};
    assert_int_equal(verdict_outcome_of(&v), VERDICT_SOLVED);
    assert_int_equal(verdict_worst(&v), VERDICT_NONE);
    assert_int_equal(verdict_exit_status(&v), 0);
    assert_string_equal(verdict_text(&v), "");
    assert_false(verdict_has(&v, VERDICT_UNSTABLE));
}

static void test_worst_first(void **state)
{
    (void)state;
    verdict v = {.count = 0};
    verdict_add(&v, VERDICT_REFERENCE_TOO_COARSE, "a remark");
    assert_int_equal(verdict_outcome_of(&v), VERDICT_SOLVED);
    assert_int_equal(verdict_exit_status(&v), 0);
    verdict_add(&v, VERDICT_UNSTABLE, "in %d directions", 2);
    verdict_add(&v, VERDICT_INTERPOLATES, "between its points");
    verdict_add(&v, VERDICT_NONE, "nothing");
    verdict_add(&v, VERDICT_UNSTABLE, "again");
    assert_int_equal(v.count, 3);
    assert_int_equal(verdict_worst(&v), VERDICT_INTERPOLATES);
    assert_int_equal(v.findings[1].reason, VERDICT_UNSTABLE);
    assert_string_equal(v.findings[1].text, "in 2 directions");
    assert_int_equal(v.findings[2].reason, VERDICT_REFERENCE_TOO_COARSE);
    assert_int_equal(verdict_exit_status(&v), 3);
    assert_true(verdict_has(&v, VERDICT_UNSTABLE));
    assert_false(verdict_has(&v, VERDICT_NOT_CONVERGED));
}

/* The mildest go when there are too many, and a milder one does not come in. */
static void test_too_many(void **state)
{
    (void)state;
    verdict v = {.count = 0};
    for (int reason = 1; reason <= VERDICT_FINDINGS_MAX + 2; reason++) {
        verdict_add(&v, (verdict_reason)reason, "reason %d", reason);
    }
    verdict_add(&v, (verdict_reason)1, "again");
    assert_int_equal(v.count, VERDICT_FINDINGS_MAX);
    for (int i = 0; i < VERDICT_FINDINGS_MAX; i++) {
        assert_int_equal(v.findings[i].reason, VERDICT_FINDINGS_MAX + 2 - i);
    }
}

/* Scripts know the words, so they are here once more. */
static void test_words(void **state)
{
    (void)state;
    static const char *const words[] = {"none",
                                        "implausible",
                                        "misfit_unknown",
                                        "several_equilibria",
                                        "stability_open",
                                        "end_turn",
                                        "reference_too_coarse",
                                        "noise_overstated",
                                        "known_together",
                                        "estimate_off",
                                        "local_optimum",
                                        "error_unknown",
                                        "deviations_rough",
                                        "at_bound",
                                        "not_told",
                                        "several_solutions",
                                        "misfit",
                                        "snapped",
                                        "unstable",
                                        "energy_out_of_balance",
                                        "loads_out_of_balance",
                                        "estimate_above_tolerance",
                                        "estimates_contradict",
                                        "unresolved",
                                        "outside_data",
                                        "strain_large",
                                        "not_converged",
                                        "no_optimum",
                                        "infeasible",
                                        "interpolates",
                                        "not_held",
                                        "chatters",
                                        "innovations",
                                        "diverged",
                                        "not_certified",
                                        "none_found",
                                        "unfinished",
                                        "load_not_reached",
                                        "not_finite",
                                        "signal",
                                        "failed",
                                        "bad_input",
                                        "no_method",
                                        "time_limit",
                                        "killed",
                                        "died"};
    assert_int_equal(sizeof words / sizeof *words, VERDICT_REASON_COUNT);
    verdict_outcome before = VERDICT_SOLVED;
    for (int i = 0; i < VERDICT_REASON_COUNT; i++) {
        verdict_outcome outcome = verdict_reason_outcome((verdict_reason)i);
        assert_string_equal(verdict_reason_name((verdict_reason)i), words[i]);
        assert_int_equal(verdict_reason_find(words[i]), i);
        assert_true(outcome >= before); /* a worse reason has no better outcome */
        before = outcome;
    }
    assert_int_equal(verdict_reason_find("no such reason"), VERDICT_REASON_COUNT);
}

static void test_exit_status(void **state)
{
    (void)state;
    static const struct {
        ad_status status;
        verdict_reason reason;
        int exit;
    } rows[] = {{AD_OK, VERDICT_NONE, 0},
                {AD_NOT_FINITE, VERDICT_NOT_FINITE, 1},
                {AD_NO_MEMORY, VERDICT_FAILED, 1},
                {AD_IO, VERDICT_BAD_INPUT, 2},
                {AD_NOT_WRITTEN, VERDICT_FAILED, 1},
                {AD_BAD_INPUT, VERDICT_BAD_INPUT, 2},
                {AD_BAD_ARGUMENT, VERDICT_NO_METHOD, 2}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const ad_error error = {rows[i].status, "why"};
        verdict v = {.count = 0};
        verdict_add_error(&v, &error);
        assert_int_equal(verdict_worst(&v), rows[i].reason);
        assert_int_equal(verdict_exit_status(&v), rows[i].exit);
        assert_string_equal(verdict_text(&v), i == 0 ? "" : "why");
    }
    verdict v = {.signal = 15};
    verdict_add(&v, VERDICT_SIGNAL, "ended");
    assert_int_equal(verdict_exit_status(&v), 143);
}

static void test_print(void **state)
{
    (void)state;
    char *text = NULL;
    size_t size = 0;
    verdict v = {.count = 0};
    FILE *file = open_memstream(&text, &size);
    assert_non_null(file);
    verdict_print(file, "  ", &v);
    verdict_add(&v, VERDICT_REFERENCE_TOO_COARSE, "the reference is off by 1e-3");
    verdict_add(&v, VERDICT_NOT_CONVERGED, "residuals are large");
    verdict_print(file, "cpinn: ", &v);
    fclose(file);
    assert_string_equal(text, "  solved\n"
                              "cpinn: warning (not_converged): residuals are large\n"
                              "cpinn: note (reference_too_coarse): the reference is off by 1e-3\n");
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_without_findings), cmocka_unit_test(test_worst_first),
        cmocka_unit_test(test_too_many),         cmocka_unit_test(test_words),
        cmocka_unit_test(test_exit_status),      cmocka_unit_test(test_print)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
