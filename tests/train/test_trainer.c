/* Training step by step: resuming to the same bits from everywhere, what history says, how stages
 * end, numbers that are not finite, allocations in a step. */
#include "allocations.h"
#include "fewer.h"
#include "trainer_testing.h"

#include "physics/numerics/clock.h"

/* ---- resuming ----------------------------------------------------------------------------------
 */

/* All that a step shows. */
typedef struct shown {
    int64_t step, stage, stage_step;
    double loss, gradient_norm, learning_rate, held_out, error, epsilon;
    uint64_t parameters;
} shown;

static shown show(const run *r)
{
    const fit *f = trainer_fit(r->trainer);
    const trainer_info *info = trainer_inspect(r->trainer);
    return (shown){f->at.step,
                   f->at.stage,
                   f->at.stage_step,
                   f->loss,
                   f->gradient_norm,
                   f->rate,
                   f->held_out,
                   info->errors.position,
                   problem_causal_epsilon(r->made.p),
                   fingerprint(trainer_parameters(r->trainer), r->made.e->count)};
}

/* Rows of two histories, but for the seconds. */
static void assert_same_history(const history *a, const history *b)
{
    assert_int_equal(a->columns, b->columns);
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count * (size_t)a->columns; i++) {
        if (strcmp(a->names[i % (size_t)a->columns], "seconds") != 0) {
            assert_memory_equal(&a->rows[i], &b->rows[i], sizeof *a->rows);
        }
    }
}

/* From every `stride`-th step. */
static void check_resume(const char *path, const char *const *changes, int stride)
{
    static shown whole[STEPS_MAX];
    run r = start(path, changes, 1), saved = start(path, changes, 1);
    int steps = 0;
    for (; trainer_fit(r.trainer)->state == FIT_RUNNING; steps++) {
        char name[32];
        snprintf(name, sizeof name, "%d.h5", steps);
        if (steps % stride == 0) {
            save(&saved, name);
        }
        step(&r);
        step(&saved);
        whole[steps] = show(&r);
        shown other = show(&saved);
        assert_memory_equal(&other, &whole[steps], sizeof other);
    }
    assert_true(steps > 45); /* L-BFGS has worked with its memory full */
    for (int from = 0; from < steps; from += stride) {
        char name[32];
        snprintf(name, sizeof name, "%d.h5", from);
        run again = start(path, changes, 1 + from % 2);
        ad_error error = {AD_OK, ""};
        if (restore(&again, in_folder(name), &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        assert_int_equal(trainer_fit(again.trainer)->at.step, from);
        for (int i = from; i < steps; i++) {
            step(&again);
            shown now = show(&again);
            if (memcmp(&now, &whole[i], sizeof now) != 0) {
                fail_msg("%s: resumed at %d, step %d differs: loss %.17g, %.17g", path, from, i + 1,
                         now.loss, whole[i].loss);
            }
        }
        assert_int_equal(trainer_fit(again.trainer)->state, FIT_OVER);
        assert_same_history(&trainer_fit(again.trainer)->rows, &trainer_fit(r.trainer)->rows);
        stop(&again);
        unlink(in_folder(name));
    }
    stop(&r);
    stop(&saved);
}

static void test_resume_static(void **state)
{
    (void)state;
    check_resume(ELASTICA, static_changes, FARTHER(1));
}

static void test_resume_moving(void **state)
{
    (void)state;
    check_resume(DYNAMIC, moving_changes, FARTHER(1));
}

static void test_resume_balanced(void **state)
{
    (void)state;
    check_resume(DYNAMIC, balanced_changes, FARTHER(5));
}

/* Weights begin anew in every window of time. */
static void test_resume_windows(void **state)
{
    (void)state;
    const char *const changes[] = {"training.stages=[{optimizer: adam, steps: 17}, "
                                   "{optimizer: lbfgs, steps: 14, memory: 6}]",
                                   "time.windows=2",
                                   "output.every=3",
                                   "enforcement.boundary=soft",
                                   "losses.balance_every=4",
                                   "losses.balance=gradient_norm",
                                   NULL};
    check_resume(DYNAMIC, changes, FARTHER(5));
    run r = start(DYNAMIC, changes, 1);
    while (trainer_fit(r.trainer)->at.window == 0) {
        step(&r);
    }
    assert_true(problem_balance_weight(r.made.p, 0) == 1);
    step(&r);
    assert_true(problem_balance_weight(r.made.p, 0) > 1);
    stop(&r);
}

/* A finished run stays finished, with its parameters. */
static void test_resume_finished(void **state)
{
    (void)state;
    run r = start(ELASTICA, static_changes, 1), again = start(ELASTICA, static_changes, 1);
    finish(&r);
    save(&r, "done.h5");
    assert_int_equal(restore(&again, in_folder("done.h5"), NULL), AD_OK);
    assert_int_equal(trainer_fit(again.trainer)->state, FIT_OVER);
    assert_int_equal(trainer_fit(again.trainer)->at.step, trainer_fit(r.trainer)->at.step);
    assert_memory_equal(trainer_parameters(again.trainer), trainer_parameters(r.trainer),
                        r.made.e->count * sizeof(double));
    assert_same_history(&trainer_fit(again.trainer)->rows, &trainer_fit(r.trainer)->rows);
    unlink(in_folder("done.h5"));
    stop(&r);
    stop(&again);
}

/* ---- history -----------------------------------------------------------------------------------
 */

static void check_rows(const run *r, bool causal)
{
    const history *h = &trainer_fit(r->trainer)->rows;
    int64_t every = r->made.e->settings->output_every;
    assert_true(h->count > 10);
    for (size_t i = 0; i < h->count; i++) {
        double at = history_value(h, i, "step"), stage = history_value(h, i, "stage");
        double loss = history_value(h, i, "loss"), sum = 0;
        for (int k = 0; k < problem_terms(r->made.p); k++) {
            sum += problem_term_weight(r->made.p, k) *
                   history_value(h, i, problem_term_name(r->made.p, k));
        }
        /* The terms are those of the point whose loss this is; summed in another order. */
        assert_true(causal ? loss <= sum : fabs(sum - loss) <= 1e-11 * loss);
        bool last_of_stage =
            i + 1 == h->count || history_value(h, i + 1, "stage") != history_value(h, i, "stage");
        assert_true(i == 0 ? at == 1 : (int64_t)at % every == 0 || last_of_stage);
        assert_true(i == 0 || at > history_value(h, i - 1, "step"));
        assert_true(i == 0 || stage >= history_value(h, i - 1, "stage"));
        assert_true(i == 0 || history_value(h, i, "seconds") >= history_value(h, i - 1, "seconds"));
        assert_true(history_value(h, i, "held_out") > 0 && history_value(h, i, "error") > 0);
        assert_true(history_value(h, i, "gradient_norm") > 0);
        assert_true(history_value(h, i, "learning_rate") > 0);
    }
    assert_true(isnan(history_value(h, 0, "no such column")));
}

static void test_history(void **state)
{
    (void)state;
    run r = start(ELASTICA, static_changes, 1);
    finish(&r);
    check_rows(&r, false);
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    history_print(&trainer_fit(r.trainer)->rows, -1, file);
    fclose(file);
    assert_string_equal(text, "step,stage,seconds,loss,strain,curvature,force,moment,held_out,"
                              "error,tip_error,rotation_error,learning_rate,gradient_norm\n");
    free(text);
    const history *h = &trainer_fit(r.trainer)->rows;
    double held_out;
    assert_int_equal(
        problem_held_out(r.made.p, trainer_parameters(r.trainer), &held_out, NULL, NULL), AD_OK);
    assert_true(history_value(h, h->count - 1, "held_out") == held_out);
    stop(&r);
    r = start(DYNAMIC, moving_changes, 1);
    finish(&r);
    check_rows(&r, true);
    h = &trainer_fit(r.trainer)->rows;
    assert_string_equal(h->names[h->columns - 2], "causal_epsilon");
    assert_true(history_value(h, h->count - 1, "causal_epsilon") ==
                problem_causal_epsilon(r.made.p));
    assert_true(isnan(history_value(h, 0, "rotation_error"))); /* the file has positions only */
    stop(&r);
}

/* Weights move in the stage of Adam, and stay as they are in that of L-BFGS. Rows: the first, at
 * the end of Adam, the last. */
static void check_moved(const run *r, const char *column, double least)
{
    const history *h = &trainer_fit(r->trainer)->rows;
    size_t last = h->count - 1, adam = 0;
    while (adam < last && history_value(h, adam + 1, "stage") == 1) {
        adam++;
    }
    assert_true(adam > 3 && last > adam + 3);
    assert_true(history_value(h, adam, column) != history_value(h, 1, column));
    for (size_t row = adam; row <= last; row++) {
        assert_true(history_value(h, row, column) == history_value(h, adam, column));
        assert_true(history_value(h, row, column) > least);
    }
}

static void test_weights_in_history(void **state)
{
    (void)state;
    run r = start(DYNAMIC, balanced_changes, 1);
    finish(&r);
    for (int k = 0; k < problem_terms(r.made.p); k++) {
        char column[64];
        snprintf(column, sizeof column, "balance_%s", problem_term_name(r.made.p, k));
        check_moved(&r, column, 1);
        const history *h = &trainer_fit(r.trainer)->rows;
        assert_true(history_value(h, h->count - 1, column) == problem_balance_weight(r.made.p, k));
    }
    stop(&r);
}

static void check_last_row(const run *r)
{
    const history *h = &trainer_fit(r->trainer)->rows;
    size_t count = r->made.e->count;
    double *gradient = malloc(count * sizeof *gradient), loss, sum = 0, square = 0;
    assert_non_null(gradient);
    for (int k = 0; k < problem_terms(r->made.p); k++) {
        sum += problem_term_weight(r->made.p, k) *
               history_value(h, h->count - 1, problem_term_name(r->made.p, k));
    }
    assert_int_equal(
        problem_evaluate(r->made.p, trainer_parameters(r->trainer), &loss, gradient, NULL), AD_OK);
    for (size_t i = 0; i < count; i++) {
        square += gradient[i] * gradient[i];
    }
    assert_true(history_value(h, h->count - 1, "loss") == loss);
    /* Both of these are summed in another order. */
    double norm = sqrt(square);
    assert_true(fabs(history_value(h, h->count - 1, "gradient_norm") - norm) <= 1e-12 * norm);
    assert_true(fabs(sum - loss) <= 1e-11 * loss);
    free(gradient);
}

/* A line search that gives up may keep an earlier trial than its last: the last row, terms and
 * gradient included, speaks of what is kept. */
static void test_history_of_failed_search(void **state)
{
    (void)state;
    int failed = 0;
    for (int most = 2; most < 12; most++) {
        char stages[200];
        snprintf(stages, sizeof stages,
                 "training.stages=[{optimizer: lbfgs, steps: 300, sufficient_decrease: 1e-7, "
                 "curvature: 1e-6, maximum_line_evaluations: %d}]",
                 most);
        const char *changes[] = {stages, NULL};
        run r = start(ELASTICA, changes, 1);
        finish(&r);
        failed += strstr(trainer_fit(r.trainer)->ended, "line search") != NULL;
        check_last_row(&r);
        stop(&r);
    }
    assert_true(failed > 3);
}

/* ---- how stages end ----------------------------------------------------------------------------
 */

static void test_endings(void **state)
{
    (void)state;
    static const struct {
        const char *stages, *ended;
        int64_t least, most; /* steps */
    } rows[] = {
        {"training.stages=[{optimizer: adam, steps: 7}]", "steps done", 7, 7},
        {"training.stages=[{optimizer: lbfgs, steps: 7}]", "steps done", 7, 7},
        {"training.stages=[{optimizer: adam, steps: 5000, stop: {loss: 3}}]", "stop.loss reached",
         1, 4999},
        {"training.stages=[{optimizer: lbfgs, steps: 5000, stop: {error: 0.1}}]",
         "stop.error reached", 2, 4999},
        {"training.stages=[{optimizer: adam, steps: 5000, stop: {error: 1e9}}]",
         "stop.error reached", 1, 1},
        {"training.stages=[{optimizer: lbfgs, steps: 5000, gradient_tolerance: 1e-1}]",
         "gradient tolerance reached", 2, 4999},
        {"training.stages=[{optimizer: adam, steps: 1000000, stop: {seconds: 1e-9}}]",
         "stop.seconds reached", 1, 1},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const char *changes[] = {rows[i].stages, NULL};
        run r = start(ELASTICA, changes, 1);
        finish(&r);
        const fit *f = trainer_fit(r.trainer);
        if (i != 5) { /* its words are those of optim/ */
            assert_string_equal(f->ended, rows[i].ended);
        }
        assert_non_null(strstr(f->ended, i == 5 ? "gradient" : ""));
        assert_in_range(f->at.step, rows[i].least, rows[i].most);
        const history *h = &trainer_fit(r.trainer)->rows;
        assert_true(history_value(h, h->count - 1, "step") == (double)f->at.step);
        assert_true(i != 2 || history_value(h, h->count - 1, "loss") < 3);
        assert_true(i != 3 || history_value(h, h->count - 1, "error") < 0.1);
        stop(&r);
    }
}

/* L-BFGS starts from the best point of Adam, and never rises above it. */
static void test_best_goes_on(void **state)
{
    (void)state;
    static const char *const changes[] = {"training.stages=[{optimizer: adam, steps: 39, schedule: "
                                          "constant, learning_rate: 0.1, beta1: 0, beta2: 0}, "
                                          "{optimizer: lbfgs, steps: 5}]",
                                          "output.every=1", NULL};
    run r = start(ELASTICA, changes, 1);
    double best = INFINITY, loss = INFINITY;
    int rises = 0;
    for (int i = 0; i < 39; i++) {
        step(&r);
        loss = trainer_fit(r.trainer)->loss;
        rises += loss > best;
        best = fmin(best, loss);
    }
    assert_true(rises > 5 && loss > best); /* so that best and last differ */
    assert_int_equal(trainer_fit(r.trainer)->at.stage, 1);
    assert_int_equal(problem_evaluate(r.made.p, trainer_parameters(r.trainer), &loss, NULL, NULL),
                     AD_OK);
    assert_true(loss == best);
    while (trainer_fit(r.trainer)->state == FIT_RUNNING) {
        step(&r);
        assert_true(trainer_fit(r.trainer)->loss <= loss);
        loss = trainer_fit(r.trainer)->loss;
    }
    stop(&r);
}

/* ---- not finite --------------------------------------------------------------------------------
 */

static void check_not_finite(const char *path, const char *const *changes, int good_steps,
                             const char *const *words)
{
    run r = start(path, changes, 1);
    ad_error error = {AD_OK, ""};
    for (int i = 0; i < good_steps; i++) {
        step(&r);
    }
    save(&r, "good.h5");
    shown before = show(&r);
    assert_int_equal(trainer_step(r.trainer, &error), AD_NOT_FINITE);
    assert_int_equal(trainer_fit(r.trainer)->state, FIT_NOT_FINITE);
    assert_int_equal(trainer_fit(r.trainer)->at.step, good_steps);
    assert_null(strchr(error.message, '\n'));
    for (; *words; words++) {
        if (!strstr(error.message, *words)) {
            fail_msg("no '%s' in: %s", *words, error.message);
        }
    }
    run again = start(path, changes, 1);
    assert_int_equal(restore(&again, in_folder("good.h5"), &error), AD_OK);
    shown after = show(&again);
    assert_int_equal(after.step, before.step);
    assert_true(after.parameters == before.parameters);
    unlink(in_folder("good.h5"));
    stop(&again);
    stop(&r);
}

static void test_not_finite(void **state)
{
    (void)state;
    static const char *const huge[] = {
        "training.stages=[{optimizer: adam, steps: 60, learning_rate: 1e200}]", NULL};
    check_not_finite(
        ELASTICA, huge, 1,
        (const char *[]){"step 2", "loss term '", "s = ", " m; try", "learning_rate", NULL});
    static const char *const bad_load[] = {"loads.force=[0, \"sqrt(0.96-t)\", 0]",
                                           "training.stages=[{optimizer: lbfgs, steps: 60}]", NULL};
    check_not_finite(
        DYNAMIC, bad_load, 0,
        (const char *[]){"step 1", "loss term 'force'", "s = ", "t = 0.", "formula", NULL});
}

/* ---- allocations in a step ---------------------------------------------------------------------
 */

/* Rows of history grow their array by half when it is full, at 64 rows first; fewer are written
 * here, so that only steps are counted: evaluations, updates, new points, rows, comparisons. */
static void test_steps_allocate_nothing(void **state)
{
    (void)state;
    const char *const paths[] = {ELASTICA, DYNAMIC, DYNAMIC};
    const char *const *const changes[] = {static_changes, moving_changes, balanced_changes};
    for (int k = 0; k < 6; k++) {
        run r = start(paths[k / 2], changes[k / 2], 1 + k % 2);
        assert_true(allocations > 100); /* the hook is linked in */
        step(&r);
        for (int64_t i = 2; trainer_fit(r.trainer)->state == FIT_RUNNING; i++) {
            allocations = 0;
            int stage = trainer_fit(r.trainer)->at.stage;
            step(&r);
            /* The next stage makes its optimiser. */
            bool next = trainer_fit(r.trainer)->at.stage != stage;
            if (allocations > 0 && !next) {
                fail_msg("step %d: %ld allocations", (int)i, allocations);
            }
        }
        assert_true(trainer_fit(r.trainer)->rows.count < 64);
        stop(&r);
    }
}

/* Rows on demand show the state of the step, and training goes on to the same bits. */
static void test_rows_between(void **state)
{
    (void)state;
    run plain = start(DYNAMIC, moving_changes, 1), watched = start(DYNAMIC, moving_changes, 1);
    ad_error error = {AD_OK, ""};
    for (int i = 0; i < 40; i++) {
        step(&plain);
        step(&watched);
        size_t rows = trainer_fit(watched.trainer)->rows.count;
        const double wall = clock_seconds(CLOCK_MONOTONIC),
                     spent = fit_seconds(trainer_fit(watched.trainer));
        if (fit_add_row(trainer_fit(watched.trainer), &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        const double counted = fit_seconds(trainer_fit(watched.trainer)) - spent;
        assert_true(counted <
                    clock_seconds(CLOCK_MONOTONIC) - wall); /* its clock stands still meanwhile */
        assert_int_equal(trainer_fit(watched.trainer)->rows.count, rows + 1);
        assert_true(history_value(&trainer_fit(watched.trainer)->rows, rows, "step") == i + 1);
    }
    shown a = show(&plain), b = show(&watched);
    assert_true(a.parameters == b.parameters && a.loss == b.loss && a.epsilon == b.epsilon);
    stop(&plain);
    stop(&watched);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_resume_finished),        cmocka_unit_test(test_history),
        cmocka_unit_test(test_rows_between),           cmocka_unit_test(test_endings),
        cmocka_unit_test(test_best_goes_on),           cmocka_unit_test(test_not_finite),
        cmocka_unit_test(test_steps_allocate_nothing),
    };
    const struct CMUnitTest alike[] = {
        cmocka_unit_test(test_resume_windows),     cmocka_unit_test(test_resume_static),
        cmocka_unit_test(test_resume_moving),      cmocka_unit_test(test_resume_balanced),
        cmocka_unit_test(test_weights_in_history), cmocka_unit_test(test_history_of_failed_search),
    };
    return run_with_alike(tests, alike, make_folder, remove_folder);
}
