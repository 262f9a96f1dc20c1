/* Training step by step: resuming to the same bits from everywhere, what history says, how stages
 * end, numbers that are not finite, checkpoints that cannot be, allocations in a step. Linked with
 * --wrap for malloc, calloc, realloc and posix_memalign. */
#include "training_testing.h"

#include "tools/trainer.h"

#include <unistd.h>

/* ---- allocations -------------------------------------------------------------------------------
 */

static long allocations;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
int __real_posix_memalign(void **memory, size_t alignment, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t size);
int __wrap_posix_memalign(void **memory, size_t alignment, size_t size);

void *__wrap_malloc(size_t size)
{
    allocations++;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    allocations++;
    return __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
    allocations++;
    return __real_realloc(memory, size);
}

int __wrap_posix_memalign(void **memory, size_t alignment, size_t size)
{
    allocations++;
    return __real_posix_memalign(memory, alignment, size);
}

/* ---- runs --------------------------------------------------------------------------------------
 */

#define DYNAMIC  "configs/cantilever_dynamic.yaml"
#define ELASTICA "configs/elastica.yaml"

/* 25 steps of Adam, 35 of L-BFGS, whose memory is full after 6. */
#define STAGES                                                                                     \
    "training.stages=[{optimizer: adam, steps: 25, schedule: cosine, warmup_steps: 3}, "           \
    "{optimizer: lbfgs, steps: 35, memory: 6}]"

static const char *const static_changes[] = {STAGES, "output.every=4", NULL};
static const char *const moving_changes[] = {STAGES,
                                             "output.every=3",
                                             "enforcement.initial=soft",
                                             "enforcement.boundary=soft",
                                             "losses.interior.sampler=latin_hypercube",
                                             "losses.interior.resample_every=11",
                                             "losses.initial.sampler=uniform",
                                             "losses.initial.resample_every=13",
                                             "losses.causal.slices=3",
                                             "losses.causal.update_every=7",
                                             "losses.causal.epsilon=[1e-6, 1e-4, 1e-2]",
                                             "losses.causal.threshold=0.5",
                                             NULL};

enum { STEPS_MAX = 80 };

typedef struct run {
    made made;
    reference *known;
    trainer *trainer;
} run;

static run start(const char *path, const char *const *changes, int threads)
{
    run r = {.made = make_problem(path, changes, threads)};
    ad_error error = {AD_OK, ""};
    if (reference_create(r.made.e, &r.known, &error) != AD_OK ||
        trainer_create(r.made.e, r.made.p, r.known, 0, &r.trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
    return r;
}

static void stop(run *r)
{
    trainer_free(r->trainer);
    reference_free(r->known);
    made_free(&r->made);
}

static void step(run *r)
{
    ad_error error = {AD_OK, ""};
    if (trainer_step(r->trainer, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

static void finish(run *r)
{
    while (trainer_inspect(r->trainer).state == TRAINER_RUNNING) {
        step(r);
    }
}

static ad_status restore(run *r, const char *path, ad_error *error)
{
    checkpoint *file;
    ad_status status = checkpoint_open(path, &file, error);
    if (status == AD_OK) {
        status = trainer_restore(r->trainer, file, error);
        checkpoint_free(file);
    }
    return status;
}

static char folder[64];

static const char *in_folder(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int make_folder(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/cpinn_test_trainer_XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    return rmdir(folder); /* every test has cleaned up behind itself */
}

static void save(run *r, const char *name)
{
    ad_error error = {AD_OK, ""};
    if (trainer_save(r->trainer, in_folder(name), 1, &error) != AD_OK) {
        fail_msg("%s", error.message);
    }
}

/* ---- resuming ----------------------------------------------------------------------------------
 */

/* All that a step shows. */
typedef struct shown {
    int64_t step, stage, stage_step;
    double loss, gradient_norm, learning_rate, held_out, error, epsilon;
    uint64_t parameters;
} shown;

static uint64_t fingerprint(const double *x, size_t count)
{
    uint64_t hash = UINT64_C(14695981039346656037); /* FNV-1a */
    for (size_t i = 0; i < count * sizeof *x; i++) {
        hash = (hash ^ ((const unsigned char *)x)[i]) * UINT64_C(1099511628211);
    }
    return hash;
}

static shown show(const run *r)
{
    trainer_info info = trainer_inspect(r->trainer);
    return (shown){info.step,
                   info.stage,
                   info.stage_step,
                   info.loss,
                   info.gradient_norm,
                   info.learning_rate,
                   info.held_out,
                   info.errors.position,
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

static void check_resume(const char *path, const char *const *changes)
{
    static shown whole[STEPS_MAX];
    run r = start(path, changes, 1), saved = start(path, changes, 1);
    int steps = 0;
    for (; trainer_inspect(r.trainer).state == TRAINER_RUNNING; steps++) {
        char name[32];
        snprintf(name, sizeof name, "%d.h5", steps);
        save(&saved, name);
        step(&r);
        step(&saved);
        whole[steps] = show(&r);
        shown other = show(&saved);
        assert_memory_equal(&other, &whole[steps], sizeof other);
    }
    assert_true(steps > 45); /* L-BFGS has worked with its memory full */
    for (int from = 0; from < steps; from++) {
        char name[32];
        snprintf(name, sizeof name, "%d.h5", from);
        run again = start(path, changes, 1 + from % 2);
        ad_error error = {AD_OK, ""};
        if (restore(&again, in_folder(name), &error) != AD_OK) {
            fail_msg("%s", error.message);
        }
        assert_int_equal(trainer_inspect(again.trainer).step, from);
        for (int i = from; i < steps; i++) {
            step(&again);
            shown now = show(&again);
            if (memcmp(&now, &whole[i], sizeof now) != 0) {
                fail_msg("%s: resumed at %d, step %d differs: loss %.17g, %.17g", path, from, i + 1,
                         now.loss, whole[i].loss);
            }
        }
        assert_int_equal(trainer_inspect(again.trainer).state, TRAINER_DONE);
        assert_same_history(trainer_history(again.trainer), trainer_history(r.trainer));
        stop(&again);
        unlink(in_folder(name));
    }
    stop(&r);
    stop(&saved);
}

static void test_resume_static(void **state)
{
    (void)state;
    check_resume(ELASTICA, static_changes);
}

static void test_resume_moving(void **state)
{
    (void)state;
    check_resume(DYNAMIC, moving_changes);
}

/* A finished run stays finished, with its parameters. */
static void test_resume_finished(void **state)
{
    (void)state;
    run r = start(ELASTICA, static_changes, 1), again = start(ELASTICA, static_changes, 1);
    finish(&r);
    save(&r, "done.h5");
    assert_int_equal(restore(&again, in_folder("done.h5"), NULL), AD_OK);
    assert_int_equal(trainer_inspect(again.trainer).state, TRAINER_DONE);
    assert_int_equal(trainer_inspect(again.trainer).step, trainer_inspect(r.trainer).step);
    assert_memory_equal(trainer_parameters(again.trainer), trainer_parameters(r.trainer),
                        r.made.e->count * sizeof(double));
    assert_same_history(trainer_history(again.trainer), trainer_history(r.trainer));
    unlink(in_folder("done.h5"));
    stop(&r);
    stop(&again);
}

/* ---- history -----------------------------------------------------------------------------------
 */

static void check_rows(const run *r, bool causal)
{
    const history *h = trainer_history(r->trainer);
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
    history_print(trainer_history(r.trainer), -1, file);
    fclose(file);
    assert_string_equal(text, "step,stage,seconds,loss,strain,curvature,force,moment,held_out,"
                              "error,tip_error,rotation_error,learning_rate,gradient_norm\n");
    free(text);
    const history *h = trainer_history(r.trainer);
    double held_out;
    assert_int_equal(
        problem_held_out(r.made.p, trainer_parameters(r.trainer), &held_out, NULL, NULL), AD_OK);
    assert_true(history_value(h, h->count - 1, "held_out") == held_out);
    stop(&r);
    r = start(DYNAMIC, moving_changes, 1);
    finish(&r);
    check_rows(&r, true);
    h = trainer_history(r.trainer);
    assert_string_equal(h->names[h->columns - 2], "causal_epsilon");
    assert_true(history_value(h, h->count - 1, "causal_epsilon") ==
                problem_causal_epsilon(r.made.p));
    assert_true(isnan(history_value(h, 0, "rotation_error"))); /* the file has positions only */
    stop(&r);
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
        trainer_info info = trainer_inspect(r.trainer);
        if (i != 5) { /* its words are those of optim/ */
            assert_string_equal(info.ended, rows[i].ended);
        }
        assert_non_null(strstr(info.ended, i == 5 ? "gradient" : ""));
        assert_in_range(info.step, rows[i].least, rows[i].most);
        const history *h = trainer_history(r.trainer);
        assert_true(history_value(h, h->count - 1, "step") == (double)info.step);
        assert_true(i != 2 || history_value(h, h->count - 1, "loss") < 3);
        assert_true(i != 3 || history_value(h, h->count - 1, "error") < 0.1);
        stop(&r);
    }
}

/* L-BFGS starts from the best point of Adam, and never rises above it. */
static void test_best_goes_on(void **state)
{
    (void)state;
    static const char *const changes[] = {
        "training.stages=[{optimizer: adam, steps: 60, learning_rate: 0.3}, "
        "{optimizer: lbfgs, steps: 5}]",
        "output.every=1", NULL};
    run r = start(ELASTICA, changes, 1);
    finish(&r);
    const history *h = trainer_history(r.trainer);
    double best = INFINITY, before = INFINITY;
    int rises = 0;
    for (size_t i = 0; i < 60; i++) {
        rises += history_value(h, i, "loss") > best;
        best = fmin(best, history_value(h, i, "loss"));
    }
    assert_true(rises > 5); /* so that best and last differ */
    for (size_t i = 60; i < h->count; before = history_value(h, i, "loss"), i++) {
        assert_true(history_value(h, i, "loss") <= fmin(best, before));
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
    assert_int_equal(trainer_inspect(r.trainer).state, TRAINER_NOT_FINITE);
    assert_int_equal(trainer_inspect(r.trainer).step, good_steps);
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
        (const char *[]){"step 2", "loss term '", "s = ", " m, t = 0 s", "learning_rate", NULL});
    static const char *const bad_load[] = {"loads.force=[0, \"sqrt(0.25-t)\", 0]",
                                           "training.stages=[{optimizer: lbfgs, steps: 60}]", NULL};
    check_not_finite(
        DYNAMIC, bad_load, 0,
        (const char *[]){"step 1", "loss term 'force'", "s = ", "t = 0.", "adam", NULL});
}

/* ---- checkpoints that cannot be ----------------------------------------------------------------
 */

enum { NUMBERS_MAX = 20000, NAMES_MAX = 32 };

/* What to do with one item: leave it out, give it one number too many, or change its first. */
typedef struct tamper {
    const char *name;
    enum { LEAVE_OUT, LENGTHEN, CHANGE, RENAME_COLUMN } how;
    double value;
} tamper;

/* Copy item `i`, tampered with if it is the one; `numbers` [NUMBERS_MAX + 1] lives until the write.
 */
static void copy_item(const checkpoint *from, size_t i, checkpoint *to, const tamper *change,
                      double *numbers)
{
    const char *name = checkpoint_name(from, i), *text;
    bool chosen = strcmp(name, change->name) == 0;
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK];
    assert_true(checkpoint_shape(from, name, &rank, shape));
    size_t count = shape[0] * shape[1] * shape[2];
    assert_true(count < NUMBERS_MAX);
    if (chosen && change->how == LEAVE_OUT) {
        return;
    }
    size_t longer = count + (chosen && change->how == LENGTHEN);
    if (checkpoint_get_doubles(from, name, numbers, count, NULL) == AD_OK) {
        numbers[0] = chosen && change->how == CHANGE ? change->value : numbers[0];
        numbers[count] = 0.5;
        static const char *columns[NAMES_MAX]; /* there is one table */
        for (size_t k = 0; k < NAMES_MAX && checkpoint_column(from, name, k); k++) {
            columns[k] = checkpoint_column(from, name, k);
        }
        if (checkpoint_column(from, name, 0)) {
            columns[4] = chosen && change->how == RENAME_COLUMN ? "other" : columns[4];
            size_t more = longer > count;
            checkpoint_put_table(to, name, numbers, more ? 1 : shape[0],
                                 more ? shape[1] - 1 : shape[1], columns);
        } else if (longer > count) {
            checkpoint_put_doubles(to, name, numbers, 1, &longer);
        } else {
            checkpoint_put_doubles(to, name, numbers, rank, shape);
        }
    } else if (checkpoint_get_int64(from, name, (int64_t *)numbers, count, NULL) == AD_OK) {
        int64_t *integers = (int64_t *)numbers;
        integers[0] = chosen && change->how == CHANGE ? (int64_t)change->value : integers[0];
        checkpoint_put_int64(to, name, integers, longer > count ? 1 : rank, &longer);
    } else if (checkpoint_get_uint64(from, name, (uint64_t *)numbers, count, NULL) == AD_OK) {
        ((uint64_t *)numbers)[count] = 1;
        checkpoint_put_uint64(to, name, (uint64_t *)numbers, 1, &longer);
    } else {
        assert_int_equal(checkpoint_get_text(from, name, &text, NULL), AD_OK);
        checkpoint_put_text(to, name, text);
    }
}

static ad_status restore_tampered(const checkpoint *good, const tamper *change, ad_error *error)
{
    checkpoint *bad = checkpoint_create("test");
    size_t count = checkpoint_count(good);
    double *numbers = calloc(count * (NUMBERS_MAX + 1), sizeof *numbers);
    assert_true(bad && numbers);
    for (size_t i = 0; i < count; i++) {
        copy_item(good, i, bad, change, numbers + i * (NUMBERS_MAX + 1));
    }
    if (checkpoint_write(bad, in_folder("bad.h5"), 1, error) != AD_OK) {
        fail_msg("%s", error->message);
    }
    checkpoint_free(bad);
    free(numbers);
    run r = start(DYNAMIC, moving_changes, 1);
    ad_status status = restore(&r, in_folder("bad.h5"), error);
    unlink(in_folder("bad.h5"));
    stop(&r);
    return status;
}

static void check_tampered(const checkpoint *good, tamper change)
{
    ad_error error = {AD_OK, ""};
    ad_status status = restore_tampered(good, &change, &error);
    if (status != AD_BAD_INPUT || strchr(error.message, '\n') || strlen(error.message) < 15) {
        fail_msg("%s (%d, %g): status %d, '%s'", change.name, (int)change.how, change.value,
                 (int)status, error.message);
    }
}

static checkpoint *saved_after(int steps)
{
    run r = start(DYNAMIC, moving_changes, 1);
    for (int i = 0; i < steps; i++) {
        step(&r);
    }
    save(&r, "good.h5");
    stop(&r);
    checkpoint *good = NULL;
    assert_int_equal(checkpoint_open(in_folder("good.h5"), &good, NULL), AD_OK);
    unlink(in_folder("good.h5"));
    return good;
}

static void test_items(void **state)
{
    (void)state;
    for (int steps = 10; steps <= 40; steps += 30) { /* of Adam, of L-BFGS */
        checkpoint *good = saved_after(steps);
        ad_error error = {AD_OK, ""};
        assert_int_equal(restore_tampered(good, &(tamper){"no such item", LEAVE_OUT, 0}, &error),
                         AD_OK);
        for (size_t i = 0; i < checkpoint_count(good); i++) {
            const char *name = checkpoint_name(good, i);
            if (strcmp(name, "scene/yaml") != 0) { /* whoever opens the file has read it */
                check_tampered(good, (tamper){name, LEAVE_OUT, 0});
                check_tampered(good, (tamper){name, LENGTHEN, 0});
            }
        }
        checkpoint_free(good);
    }
}

static void test_values(void **state)
{
    (void)state;
    static const tamper changes[] = {
        {"training/stage", CHANGE, -1},
        {"training/stage", CHANGE, 3},
        {"training/stage", CHANGE, 2}, /* done, but with an optimiser at work */
        {"training/stage", CHANGE, 0}, /* the state of L-BFGS for Adam */
        {"training/stage_step", CHANGE, -1},
        {"training/stage_step", CHANGE, 41},
        {"training/step", CHANGE, -1},
        {"training/optimizer", CHANGE, 0},
        {"training/optimizer", CHANGE, 2},
        {"training/seconds", CHANGE, -1},
        {"training/seconds", CHANGE, NAN},
        {"training/stage_seconds", CHANGE, INFINITY},
        {"parameters/network/layer0/weight", CHANGE, NAN},
        {"parameters/network/layer0/bias", CHANGE, INFINITY},
        {"optimizer/x", CHANGE, NAN},
        {"optimizer/gradient", CHANGE, INFINITY},
        {"points/interior", CHANGE, 1.5},
        {"points/initial", CHANGE, NAN},
        {"causal/weights", CHANGE, 2},
        {"causal/epsilon_index", CHANGE, 3},
        {"history/table", RENAME_COLUMN, 0},
    };
    checkpoint *good = saved_after(40);
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        assert_true(checkpoint_has(good, changes[i].name));
        check_tampered(good, changes[i]);
    }
    checkpoint_free(good);
}

/* Where nothing can be written the run itself goes on. */
static void test_save_fails(void **state)
{
    (void)state;
    run r = start(ELASTICA, static_changes, 1);
    ad_error error = {AD_OK, ""};
    step(&r);
    assert_int_equal(trainer_save(r.trainer, in_folder("nowhere/a.h5"), 1, &error), AD_IO);
    assert_non_null(strstr(error.message, "nowhere"));
    step(&r);
    stop(&r);
}

/* ---- allocations in a step ---------------------------------------------------------------------
 */

/* Rows of history grow their array by half when it is full, at 64 rows first; fewer are written
 * here, so that only steps are counted: evaluations, updates, new points, rows, comparisons. */
static void test_steps_allocate_nothing(void **state)
{
    (void)state;
    const char *const paths[] = {ELASTICA, DYNAMIC};
    const char *const *const changes[] = {static_changes, moving_changes};
    for (int k = 0; k < 4; k++) {
        run r = start(paths[k / 2], changes[k / 2], 1 + k % 2);
        assert_true(allocations > 100); /* the hook is linked in */
        step(&r);
        for (int64_t i = 2; trainer_inspect(r.trainer).state == TRAINER_RUNNING; i++) {
            allocations = 0;
            int stage = trainer_inspect(r.trainer).stage;
            step(&r);
            /* The next stage makes its optimiser. */
            bool next = trainer_inspect(r.trainer).stage != stage;
            if (allocations > 0 && !next) {
                fail_msg("step %d: %ld allocations", (int)i, allocations);
            }
        }
        assert_true(trainer_history(r.trainer)->count < 64);
        stop(&r);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_resume_static),
        cmocka_unit_test(test_resume_moving),
        cmocka_unit_test(test_resume_finished),
        cmocka_unit_test(test_history),
        cmocka_unit_test(test_endings),
        cmocka_unit_test(test_best_goes_on),
        cmocka_unit_test(test_not_finite),
        cmocka_unit_test(test_items),
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_save_fails),
        cmocka_unit_test(test_steps_allocate_nothing),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
