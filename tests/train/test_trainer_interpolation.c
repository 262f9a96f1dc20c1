/* A network that fits its points and not the equations between them is noticed; one that converges
 * is not mistaken for it. */
#include "fewer.h"
#include "trainer_testing.h"

#include "tools/train/trainer_internal.h"

#define NETWORK "network={hidden: [12, 12], activation: sin}"

static const char *const too_few[] = {NETWORK, "losses.interior.points=4",
                                      "losses.interior.sampler=uniform",
                                      "training.stages=[{optimizer: lbfgs, steps: 600}]", NULL};

static double ratio_at(const run *r, size_t row)
{
    const history *h = &trainer_fit(r->trainer)->rows;
    double trained = 0;
    for (int k = 0; k < problem_terms(r->made.p); k++) {
        trained += problem_term_weight(r->made.p, k) *
                   history_value(h, row, problem_term_name(r->made.p, k));
    }
    return history_value(h, row, "held_out") / trained;
}

/* Rows at the end whose ratio is above 100 and whose held-out loss is no new minimum, in turn. */
static size_t rows_apart(const run *r)
{
    const history *h = &trainer_fit(r->trainer)->rows;
    size_t apart = 0;
    double best = INFINITY;
    for (size_t i = 0; i < h->count; i++) {
        double held_out = history_value(h, i, "held_out");
        apart = ratio_at(r, i) > 100 && held_out >= best ? apart + 1 : 0;
        best = fmin(best, held_out);
    }
    return apart;
}

/* ---- noticed -----------------------------------------------------------------------------------
 */

/* 4 points and 229 parameters: the stage ends at the fifth such row, far from its end and far from
 * the solution. */
static void test_ends_the_stage(void **state)
{
    (void)state;
    run r = start(ELASTICA, too_few, 1);
    for (size_t rows = 0; trainer_fit(r.trainer)->state == FIT_RUNNING;) {
        step(&r);
        if (trainer_fit(r.trainer)->rows.count > rows) {
            rows = trainer_fit(r.trainer)->rows.count;
            assert_int_equal(trainer_fit(r.trainer)->state == FIT_OVER, rows_apart(&r) == 5);
        }
    }
    const fit *f = trainer_fit(r.trainer);
    const trainer_info *info = trainer_inspect(r.trainer);
    assert_true(f->at.step < 600 && f->interpolates);
    const char *reason = "times the training loss: the network interpolates its points";
    assert_non_null(strstr(f->ended, reason));
    assert_true(strtod(f->ended + strlen("held-out loss "), NULL) > 100);
    assert_true(f->held_out > 0.01 && f->held_out_ratio > 100);
    assert_true(info->errors.position > 0.01);
    stop(&r);
}

/* Gauss-Newton is done with 4 points before there are five rows: it says so all the same. */
static void test_said_at_the_end(void **state)
{
    (void)state;
    const char *const changes[] = {NETWORK,
                                   "losses.interior.points=4",
                                   "losses.interior.sampler=uniform",
                                   "output.every=100",
                                   "training.stages=[{optimizer: gauss_newton, steps: 200}]",
                                   NULL};
    run r = start(ELASTICA, changes, 1);
    finish(&r);
    const fit *f = trainer_fit(r.trainer);
    const trainer_info *info = trainer_inspect(r.trainer);
    assert_true(f->loss < 1e-11 && f->held_out > 0.1 && info->errors.position > 0.01);
    assert_true(trainer_fit(r.trainer)->rows.count < 5);
    assert_true(f->interpolates);
    stop(&r);
}

static void test_never(void **state)
{
    (void)state;
    const char *const changes[] = {
        NETWORK, "losses.interior.points=4", "losses.interior.sampler=uniform",
        "training.stages=[{optimizer: lbfgs, steps: 600, stop: {held_out_ratio: 0}}]", NULL};
    run r = start(ELASTICA, changes, 1);
    finish(&r);
    const fit *f = trainer_fit(r.trainer);
    assert_null(strstr(f->ended, "interpolates"));
    assert_true(f->interpolates && rows_apart(&r) > 5);
    stop(&r);
}

/* The next stage gets its five rows; a run resumed at any step ends at the same one. */
static void test_stages_and_resume(void **state)
{
    (void)state;
    const char *const changes[] = {
        NETWORK, "losses.interior.points=4", "losses.interior.sampler=uniform",
        "training.stages=[{optimizer: lbfgs, steps: 600}, {optimizer: lbfgs, steps: 600}]", NULL};
    run r = start(ELASTICA, changes, 1);
    int64_t first = 0;
    while (trainer_fit(r.trainer)->state == FIT_RUNNING) {
        char name[32];
        snprintf(name, sizeof name, "%d.h5", (int)trainer_fit(r.trainer)->at.step);
        save(&r, name);
        step(&r);
        if (trainer_fit(r.trainer)->at.stage == 1 && first == 0) {
            first = trainer_fit(r.trainer)->at.step;
        }
    }
    int64_t last = trainer_fit(r.trainer)->at.step;
    assert_true(first < 600 && last > first + 40 && last < first + 600);
    for (int64_t from = 0; from < last; from++) {
        char name[32];
        snprintf(name, sizeof name, "%d.h5", (int)from);
        if (from % 10 == 3 || (from >= first && from < first + 11)) {
            ad_error error = {AD_OK, ""};
            run again = start(ELASTICA, changes, 1);
            assert_int_equal(restore(&again, in_folder(name), &error), AD_OK);
            finish(&again);
            assert_true(trainer_fit(again.trainer)->at.step == last);
            assert_string_equal(trainer_fit(again.trainer)->ended, trainer_fit(r.trainer)->ended);
            stop(&again);
        }
        unlink(in_folder(name));
    }
    stop(&r);
}

/* ---- not mistaken ------------------------------------------------------------------------------
 */

/* Enough points of two samplers: every stage runs as far as it would, and says nothing. */
static void test_converges(void **state)
{
    (void)state;
    static const char *const samplers[] = {"sobol", "chebyshev"};
    for (int k = 0; k < 2; k++) {
        char sampler[64];
        snprintf(sampler, sizeof sampler, "losses.interior.sampler=%s", samplers[k]);
        const char *const changes[] = {NETWORK,
                                       "losses.interior.points=48",
                                       sampler,
                                       "training.stages=[{optimizer: adam, steps: 200}, "
                                       "{optimizer: lbfgs, steps: 300}, "
                                       "{optimizer: gauss_newton, steps: 40}]",
                                       "output.every=2",
                                       NULL};
        run r = start(ELASTICA, changes, 1);
        while (trainer_fit(r.trainer)->state == FIT_RUNNING) {
            step(&r);
            assert_false(trainer_fit(r.trainer)->interpolates);
            const char *ended = trainer_fit(r.trainer)->ended;
            assert_true(!ended || !strstr(ended, "interpolates"));
        }
        assert_true(trainer_fit(r.trainer)->held_out < 1e-6); /* it has come far */
        stop(&r);
    }
}

/* A rod that nothing bends: Gauss-Newton comes to what rounding leaves of both losses, and stays
 * there. */
static void test_rounding(void **state)
{
    (void)state;
    const char *const changes[] = {"network={hidden: [12], activation: sin}",
                                   "motion=spatial",
                                   "loads.tip=null",
                                   "reference.analytic=none",
                                   "training.stages=[{optimizer: gauss_newton, steps: 100, "
                                   "scaling: diagonal, gradient_tolerance: 0, "
                                   "damping_decrease: 0.05}]",
                                   "output.every=1",
                                   NULL};
    run r = start(ELASTICA, changes, 1);
    while (trainer_fit(r.trainer)->state == FIT_RUNNING) {
        step(&r);
        assert_false(trainer_fit(r.trainer)->interpolates);
    }
    const fit *f = trainer_fit(r.trainer);
    assert_true(f->loss < 1e-25 && f->held_out < 1e-25);
    assert_null(strstr(f->ended, "interpolates"));
    stop(&r);
}

/* The rule by itself, on rows made up: ten in turn with the same losses. */
static void test_rule(void **state)
{
    (void)state;
    static const struct {
        double trained, held_out, falling; /* factor on the held-out loss from row to row */
        bool interpolates, ends;
    } rows[] = {{1e-6, 0.99e-4, 1, false, false}, {1e-6, 1.01e-4, 1, true, true},
                {1e-6, 1e-2, 0.999, true, false}, {1e-6, 1e-2, 1.001, true, true},
                {1e-28, 1e-25, 1, false, false},  {1e-28, 0.99e-20, 1, false, false},
                {1e-28, 1.01e-20, 1, true, true}, {0, 1e-9, 1, true, true},
                {0, 0, 1, false, false}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        run r = start(ELASTICA, too_few, 1);
        trainer *t = r.trainer;
        double held_out = rows[k].held_out;
        for (int i = 0; i < 10; i++, held_out *= rows[k].falling) {
            double row[HISTORY_COLUMNS_MAX] = {i, 1};
            for (int c = 2; c < t->fit.rows.columns; c++) {
                if (strcmp(t->fit.rows.names[c], "held_out") == 0) {
                    row[c] = held_out;
                } else if (strcmp(t->fit.rows.names[c], problem_term_name(r.made.p, 0)) == 0) {
                    row[c] = rows[k].trained / problem_term_weight(r.made.p, 0);
                }
            }
            assert_int_equal(history_add(&t->fit.rows, row, NULL), AD_OK);
            fit_watch(&t->fit, (size_t)i);
            assert_int_equal(t->fit.interpolates, rows[k].interpolates);
        }
        assert_int_equal(t->fit.rows_apart, rows[k].ends ? 9 : 0); /* the first is a minimum */
        stop(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_ends_the_stage),
                                       cmocka_unit_test(test_said_at_the_end),
                                       cmocka_unit_test(test_never), cmocka_unit_test(test_rule)};
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_converges),
                                       cmocka_unit_test(test_stages_and_resume),
                                       cmocka_unit_test(test_rounding)};
    return run_with_alike(tests, alike, make_folder, remove_folder);
}
