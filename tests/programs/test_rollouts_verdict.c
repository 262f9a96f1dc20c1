/* What is said of a one-step model: its own error, that of its modes, and what is not known. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "tools/programs/eval_rollouts.h"

/* The reasons, a bit each, of a model with an error and its modes with another, over the length. */
static unsigned said(surrogate_kind_id kind, double own, double modes, long lost)
{
    rollouts_report report = {.count = 16, .lost = lost, .growth = 0.5};
    surrogate_settings settings = surrogate_settings_default();
    verdict to = {.count = 0};
    unsigned reasons = 0;
    settings.kind = kind;
    report.rows[ROLLOUTS_MODEL].error[ROLLOUTS_SHORT][ROLLOUTS_MEDIAN] = own;
    report.rows[ROLLOUTS_FINER].error[ROLLOUTS_SHORT][ROLLOUTS_MEDIAN] = modes;
    eval_rollouts_verdict(&report, &settings, 1, 1, &to);
    for (int i = 0; i < to.count; i++) {
        reasons |= 1U << (to.findings[i].reason == VERDICT_NOT_CONVERGED              ? 0
                          : to.findings[i].reason == VERDICT_ESTIMATE_ABOVE_TOLERANCE ? 1
                          : to.findings[i].reason == VERDICT_ERROR_UNKNOWN            ? 2
                                                                                      : 3);
    }
    return reasons;
}

static void every_part_of_the_error_is_judged(void **state)
{
    (void)state;
    assert_int_equal(said(SURROGATE_FLOW, 1e-4, 1e-3, 0), 0);
    assert_int_equal(said(SURROGATE_FLOW, 2e-3, 1e-3, 0), 1);
    assert_int_equal(said(SURROGATE_FLOW, 1e-4, 0.03, 0), 2); /* of a rod that is not the robot */
    assert_int_equal(said(SURROGATE_LINEAR, 6e-3, 0.03, 0), 2);
    assert_int_equal(said(SURROGATE_LINEAR, 6e-3, 1e-3, 0), 0);
    assert_int_equal(said(SURROGATE_FLOW, 1e-4, 1e-3, 3), 4); /* rollouts that the solver lost */
    assert_int_equal(said(SURROGATE_FLOW, NAN, NAN, 16), 7);  /* nothing was compared */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_part_of_the_error_is_judged)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
