/* The state of training in a checkpoint; the items are listed in tools/train/trainer.h. */
#include "autodiff/dense.h"
#include "physics/numerics/clock.h"
#include "tools/train/report.h"
#include "tools/train/trainer_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- saving -------------------------------------------------------------------------------- */

enum { NAME_MAX_ = 96 };

static void item_name(char name[NAME_MAX_], const char *group, const char *rest)
{
    snprintf(name, NAME_MAX_, "%s/%s", group, rest);
}

static void put_loads(const optim_continuation *loads, checkpoint *file)
{
    size_t shape[2] = {2, loads->count};
    if (loads->solved) {
        checkpoint_put_double(file, "training/loads/part", loads->part);
        checkpoint_put_double(file, "training/loads/reached", loads->reached);
        checkpoint_put_double(file, "training/loads/before", loads->before);
        checkpoint_put_double(file, "training/loads/increment", loads->increment);
        checkpoint_put_doubles(file, "training/loads/solved", loads->solved, 2, shape);
    }
}

enum { WORDS = TRAINER_DRAWN - 1 }; /* of a generator */

static void put_array(checkpoint *file, const problem_array *array, uint64_t drawn[TRAINER_DRAWN])
{
    const size_t shape[2] = {array->rows, array->columns}, count = TRAINER_DRAWN;
    if (array->drawn && array->drawn->still) {
        memcpy(drawn, array->drawn->before.state, WORDS * sizeof *drawn);
        drawn[WORDS] = array->columns;
        checkpoint_put_uint64(file, array->name, drawn, 1, &count);
    } else {
        checkpoint_put_doubles(file, array->name, array->data, 2, shape);
    }
}

ad_status trainer_put(void *of, checkpoint *file, ad_error *error)
{
    trainer *t = of;
    (void)error;
    experiment_put(t->e, trainer_parameters(t), file);
    checkpoint_put_integer(file, "training/optimizer", t->optimizer != NULL);
    checkpoint_put_text(file, "training/kernels", ad_dense_kernels());
    put_loads(&t->loads, file);
    problem_array points[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int generator_count,
        point_count = problem_state(t->problem, points, generators, &generator_count);
    for (int i = 0; i < point_count; i++) {
        put_array(file, &points[i], t->drawn[i]);
    }
    const size_t words = WORDS;
    for (int i = 0; i < generator_count; i++) {
        char name[NAME_MAX_];
        item_name(name, "generators", generators[i].name);
        checkpoint_put_uint64(file, name, generators[i].rng->state, 1, &words);
    }
    verdict at_present;
    trainer_verdict(t, &at_present);
    report_put_verdict(file, &at_present);
    checkpoint_put_double(file, "estimate", trainer_estimate(t));
    return AD_OK;
}

/* ---- restoring ----------------------------------------------------------------------------- */

/* What a file of measurements says is not restored: it has to say the same as before. */
static ad_status check_given(const checkpoint *file, const problem_array *now, ad_error *error)
{
    const size_t count = now->rows * now->columns;
    double *before = malloc((count + 1) * sizeof *before);
    if (!before) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for measurements");
    }
    ad_status status = checkpoint_get_doubles(file, now->name, before, count, error);
    if (status != AD_OK || memcmp(before, now->data, count * sizeof *before) != 0) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "checkpoint: %s: the file of these measurements has other rows now; a run "
                         "keeps its scene, network and points, or choose another folder",
                         now->name);
    }
    free(before);
    return status;
}

/* The state of a generator first: one of zeros would give zeros for ever. */
static ad_status get_words(const checkpoint *file, const char *name, uint64_t *words, size_t count,
                           ad_error *error)
{
    ad_status status = checkpoint_get_uint64(file, name, words, count, error);
    if (status == AD_OK && (words[0] | words[1] | words[2] | words[3]) == 0) {
        return ad_fail(error, AD_BAD_INPUT, "checkpoint: %s is no state of a generator", name);
    }
    return status;
}

static ad_status get_array(const checkpoint *file, const problem_array *array, ad_error *error)
{
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK];
    uint64_t drawn[TRAINER_DRAWN];
    const bool still =
        array->drawn && checkpoint_shape(file, array->name, &rank, shape) && rank == 1;
    if (array->drawn) {
        array->drawn->still = still;
    }
    if (!still) {
        return checkpoint_get_doubles(file, array->name, array->data, array->rows * array->columns,
                                      error);
    }
    ad_status status = get_words(file, array->name, drawn, TRAINER_DRAWN, error);
    if (status == AD_OK && drawn[WORDS] != array->columns) {
        status = ad_fail(error, AD_BAD_INPUT, "checkpoint: %s are %llu, not %zu", array->name,
                         (unsigned long long)drawn[WORDS], array->columns);
    }
    if (status == AD_OK) {
        memcpy(array->drawn->before.state, drawn, WORDS * sizeof *drawn);
    }
    return status;
}

static ad_status restore_problem(trainer *t, const checkpoint *file, ad_error *error)
{
    problem_array points[PROBLEM_STATE_MAX];
    problem_generator generators[PROBLEM_STATE_MAX];
    int generator_count, count = problem_state(t->problem, points, generators, &generator_count);
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < count; i++) {
        status = points[i].given ? check_given(file, &points[i], error)
                                 : get_array(file, &points[i], error);
    }
    for (int i = 0; status == AD_OK && i < generator_count; i++) {
        char name[NAME_MAX_];
        item_name(name, "generators", generators[i].name);
        status = get_words(file, name, generators[i].rng->state, WORDS, error);
    }
    return status == AD_OK ? problem_restored(t->problem, error) : status;
}

static ad_status get_parameters(experiment *e, const checkpoint *file, ad_error *error)
{
    ad_status status = experiment_get(e, file, error);
    size_t numbers = e->count * ((size_t)e->window + 1);
    for (size_t i = 0; status == AD_OK && i < numbers; i++) {
        if (!isfinite(e->parameters[i])) {
            return ad_fail(error, AD_BAD_INPUT, "checkpoint: a parameter is not finite");
        }
    }
    return status;
}

/* The window at work, with the networks of those before. */
static ad_status restore_window(trainer *t, const checkpoint *file, ad_error *error)
{
    int before = t->e->window;
    ad_status status = get_parameters(t->e, file, error);
    t->fit.at.window = t->e->window;
    return status == AD_OK && (before > 0 || t->e->window > 0) ? trainer_enter_window(t, 0, error)
                                                               : status;
}

static ad_status restore_loads(trainer *t, const checkpoint *file, ad_error *error)
{
    optim_continuation *loads = &t->loads;
    const struct {
        const char *name;
        double *to;
        size_t count;
    } items[] = {{"training/loads/part", &loads->part, 1},
                 {"training/loads/reached", &loads->reached, 1},
                 {"training/loads/before", &loads->before, 1},
                 {"training/loads/increment", &loads->increment, 1},
                 {"training/loads/solved", loads->solved, 2 * loads->count}};
    ad_status status = AD_OK;
    for (size_t i = 0; loads->solved && status == AD_OK && i < sizeof items / sizeof *items; i++) {
        status = checkpoint_get_doubles(file, items[i].name, items[i].to, items[i].count, error);
    }
    if (status == AD_OK && loads->solved && !optim_continuation_is_sound(loads)) {
        return ad_fail(error, AD_BAD_INPUT, "checkpoint: training/loads holds impossible numbers");
    }
    if (status == AD_OK) {
        trainer_apply_loads(t);
    }
    return status;
}

/* Any other kernels are told of, not refused: the run goes on, but not to the same bits. */
static ad_status compare_kernels(trainer *t, const checkpoint *file, ad_error *error)
{
    const char *before;
    ad_status status = checkpoint_get_text(file, "training/kernels", &before, error);
    if (status == AD_OK && strcmp(before, ad_dense_kernels()) != 0) {
        snprintf(t->info.kernels, sizeof t->info.kernels, "%s", before);
    }
    return status;
}

ad_status trainer_get(void *of, const checkpoint *file, bool *at_work, ad_error *error)
{
    trainer *t = of;
    int64_t kept;
    const int stages = t->e->settings->stage_count;
    const fit_place *at = &t->fit.at;
    ad_status status =
        checkpoint_get_integer(file, "training/optimizer", at->stage < stages && at->stage_step > 0,
                               at->stage < stages, &kept, error);
    status = status == AD_OK ? restore_window(t, file, error) : status;
    status = status == AD_OK ? restore_loads(t, file, error) : status;
    if (status == AD_OK) {
        trainer_forget_optimizer(t);
        *at_work = kept; /* not if the run was over and has got more stages */
    }
    return status;
}

ad_status trainer_got(void *of, const checkpoint *file, ad_error *error)
{
    trainer *t = of;
    ad_status status;
    if ((status = compare_kernels(t, file, error)) != AD_OK ||
        (status = restore_problem(t, file, error)) != AD_OK) {
        return status;
    }
    const history *rows = &t->fit.rows;
    if (rows->count > 0) { /* what stopping criteria look at */
        t->info.errors.position = t->fit.error;
        t->info.errors.tip = history_value(rows, rows->count - 1, "tip_error");
        t->info.errors.rotation = history_value(rows, rows->count - 1, "rotation_error");
        for (int i = 0; t->e->targets && i < TRAINER_MEMBERS; i++) {
            *trainer_members_error(&t->info, i) =
                history_value(rows, rows->count - 1, trainer_members_name(i));
        }
    }
    if (t->fit.state == FIT_OVER) {
        return trainer_measure_end(t, error);
    }
    trainer_limit_steps(t);
    return AD_OK;
}
