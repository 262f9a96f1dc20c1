/* The table of a one-step model against the solver: the reduced rod in place of a model is off by
 * what its own row says, one that is wrong by a known amount by that, one that grows diverges. */
#include "near.h"
#include "rollouts_testing.h"

#include "physics/chain/reduced.h"
#include "tools/control/reduced_model.h"
#include "tools/prepare/prepare.h"
#include "tools/surrogate/rollouts.h"

#include <math.h>
#include <string.h>

static const char arm[] = ARM("{range: [0.5, 2], scale: log}");

/* The rod, but for numbers that grow and one that is off. */
typedef struct wrong {
    one_step rod;
    double growth, off;
} wrong;

static int advance_wrong(void *context, int count, double h, const double *states,
                         const double *inputs, const double *after, double *next, double *by_state,
                         double *by_inputs)
{
    const wrong *x = context;
    const int status =
        x->rod.advance(x->rod.context, count, h, states, inputs, after, next, by_state, by_inputs);
    for (int i = 0; i < count * x->rod.states; i++) {
        next[i] = x->growth * next[i] + x->off;
    }
    return status;
}

static double outside_half(void *context, const double *state, const double *inputs)
{
    (void)context;
    (void)state;
    return inputs[0] > 0.5 ? 2 : 1;
}

static rollouts_report judge(const config *given, const one_step *model, int threads)
{
    ad_error error = {.message = ""};
    rollouts_report report;
    ad_pool *pool = ad_pool_create(threads);
    const rollouts_subject subject = {&given->scene, {1, 1, 1, 1}, model, "model", true, 2};
    assert_non_null(pool);
    if (rollouts_judge(&subject, 5, 7, pool, &report, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    ad_pool_free(pool);
    return report;
}

static void test_table(void **state)
{
    (void)state;
    ad_error error = {.message = ""};
    const reduced_settings modes = {.modes = {1, 1, 1, 1}};
    config *given = NULL;
    reduced_rod *rod = NULL;
    if (prepare_read("arm.yaml", arm, 0, NULL, &given, &error) != AD_OK ||
        reduced_create(&given->scene, &modes, &rod, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    wrong x = {reduced_one_step(rod, 0.05), 1, 0};
    one_step model = x.rod;
    model.outside = outside_half;
    rollouts_report same = judge(given, &model, 2), again = judge(given, &model, 1);
    const rollouts_row *row = same.rows;
    for (int span = ROLLOUTS_ONE; span <= ROLLOUTS_SHORT; span++) {
        const double *of_rod = row[ROLLOUTS_ROD].error[span], *twice = row[2].error[span];
        assert_true(row[0].error[span][1] >= row[0].error[span][0]);
        assert_true(of_rod[1] < 1e-2 && twice[1] < 0.7 * of_rod[1]);
        assert_true(row[0].error[span][1] >= of_rod[1]); /* one step: of 1000, not of 100 */
        assert_memory_equal(row[0].error[span], again.rows[0].error[span], 2 * sizeof(double));
    }
    assert_memory_equal(row[0].error[ROLLOUTS_SHORT], row[1].error[ROLLOUTS_SHORT],
                        2 * sizeof(double));
    assert_int_equal(same.steps[ROLLOUTS_SHORT], 100);
    assert_int_equal(same.steps[ROLLOUTS_LONG], 1000);
    assert_int_equal(row[0].diverged, 0);
    assert_true(row[ROLLOUTS_FINER].error[ROLLOUTS_SHORT][1] > 1e-4); /* one mode is few */
    assert_true(row[ROLLOUTS_FINER].states > row[0].states);
    assert_true(same.outside > 0.2 && same.outside < 0.8);
    assert_true(row[0].alone > 0 && row[0].jacobian > row[0].alone);
    assert_true(row[0].together > 20 * row[0].alone);
    assert_false(rollouts_fail(&same, NAN));
    const double own = row[0].error[ROLLOUTS_SHORT][1], few = row[3].error[ROLLOUTS_SHORT][1];
    assert_false(rollouts_fail(&same, own + few));
    assert_true(rollouts_fail(&same, own + 0.9 * few)); /* what modes leave out counts */
    assert_near(same.over_time[99][1], again.over_time[99][1], 0);
    assert_true(isfinite(same.path[99][0][0]) && isfinite(same.path[99][1][2]));
    rollouts_free(&same);
    rollouts_free(&again);

    model.context = &x;
    model.advance = advance_wrong;
    x.growth = 1.2;
    x.off = 0.01;
    same = judge(given, &model, 2);
    assert_int_equal(same.rows[0].diverged, 5);
    assert_true(rollouts_fail(&same, NAN));
    assert_true(same.rows[0].error[ROLLOUTS_ONE][1] > 1e-3);
    assert_true(isnan(same.rows[0].error[ROLLOUTS_LONG][1]));
    rollouts_free(&same);
    x.off = NAN;
    same = judge(given, &model, 2);
    assert_int_equal(same.rows[0].diverged, 5);
    rollouts_free(&same);
    reduced_free(rod);
    config_free(given);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_table)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
