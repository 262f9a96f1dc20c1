/* One training, with the clock stopped while errors are evaluated. */
#include "tools/judge/compare/compare.h"

#include "tools/config/config_session.h"
#include "tools/judge/signals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double row_growth = 1.05; /* of the time from one row to the next, at least */

static const struct {
    const char *name, *text;
} measures[COMPARE_MEASURES] = {{"position", "relative L2 error of position"},
                                {"tip", "tip error / length"},
                                {"rotation", "rotation error, rad"}};

const char *compare_measure_name(compare_measure measure)
{
    return measures[measure].name;
}

const char *compare_measure_text(compare_measure measure)
{
    return measures[measure].text;
}

ad_status compare_run_add(compare_run *run, const compare_row *row, ad_error *error)
{
    if (run->count == run->capacity) {
        size_t capacity = run->capacity ? 2 * run->capacity : 64;
        compare_row *larger = realloc(run->rows, capacity * sizeof *larger);
        if (!larger) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for a run of %zu rows", capacity);
        }
        run->rows = larger;
        run->capacity = capacity;
    }
    run->rows[run->count++] = *row;
    return AD_OK;
}

void compare_run_free(compare_run *run)
{
    free(run->rows);
    run->rows = NULL;
    run->count = run->capacity = 0;
}

/* ---- what is trained ----------------------------------------------------------------------- */

static ad_status prepare(session *s, const compare_task *task, ad_error *error)
{
    config *settings;
    ad_status status =
        config_read(task->path, NULL, task->override_count, task->overrides, &settings, error);
    return status == AD_OK ? config_session_create(settings, task->threads, s, error) : status;
}

static double training_seconds(const trainer *t)
{
    trainer_info info = trainer_inspect(t);
    return info.seconds - info.row_seconds;
}

/* Whether the errors of the last row are those of the whole scene, not of its first windows alone.
 */
static bool covers_all(const session *s)
{
    const history *h = trainer_history(s->trainer);
    int windows = s->e->scene->windows;
    return windows == 1 || history_value(h, h->count - 1, "window") == windows;
}

/* The row that the trainer has evaluated last, at the clock of now. */
static compare_row row_of(const session *s)
{
    trainer_info info = trainer_inspect(s->trainer);
    if (!covers_all(s)) {
        info.errors.position = info.errors.tip = info.errors.rotation = NAN;
    }
    return (compare_row){.seconds = info.seconds - info.row_seconds,
                         .step = (double)info.step,
                         .loss = info.loss,
                         .held_out = info.held_out,
                         .errors = {info.errors.position, info.errors.tip, info.errors.rotation}};
}

/* ---- rehearsal ----------------------------------------------------------------------------- */

static ad_status check_reference(const session *s, const compare_task *task,
                                 compare_measure measure, ad_error *error)
{
    if (!s->known) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: the scene names no reference, so there is no error to show; allowed: "
                       "reference.analytic, solve or file",
                       task->path);
    }
    const reference_errors known = trainer_inspect(s->trainer).errors;
    const double errors[COMPARE_MEASURES] = {known.position, known.tip, known.rotation};
    if (measure != COMPARE_POSITION && isnan(errors[measure])) {
        return ad_fail(error, AD_BAD_INPUT,
                       "--error %s: the reference %s of %s does not know it; allowed: position",
                       compare_measure_name(measure), reference_name(s->known), task->path);
    }
    return AD_OK;
}

static void take_estimates(const session *s, compare_cell *cell)
{
    const reference_errors unknown = {NAN, NAN, NAN, NAN, NAN};
    const reference_errors of = s->known ? reference_estimates(s->known) : unknown;
    const double estimates[COMPARE_MEASURES] = {of.position, of.tip, of.rotation};
    memcpy(cell->estimates, estimates, sizeof estimates);
}

ad_status compare_rehearse(const compare_task *task, compare_measure measure, compare_cell *cell,
                           uint64_t *seed, ad_error *error)
{
    session s = {.e = NULL};
    ad_status status = prepare(&s, task, error);
    if (status == AD_OK) {
        compare_name(cell->scene_name, s.e->settings->name);
        compare_network_name(cell->network, &s.e->settings->network);
        cell->parameters = s.e->count;
        if (task->is_solver) {
            strcpy(cell->network, "-");
            cell->parameters = 0;
        }
        *seed = s.e->settings->seed;
        take_estimates(&s, cell);
        if (trainer_step(s.trainer, error) == AD_OK || !s.known) {
            status = check_reference(&s, task, measure, error);
        } else {
            status = error->status == AD_NOT_FINITE ? AD_OK : error->status;
        }
    }
    session_free(&s);
    return status;
}

/* ---- training ------------------------------------------------------------------------------ */

/* After a step: the trainer's own row, or one of ours when time has grown enough since the last. */
static ad_status record(session *s, compare_run *run, size_t known, ad_error *error)
{
    bool has_row = trainer_history(s->trainer)->count > known;
    double last = run->count > 0 ? run->rows[run->count - 1].seconds : 0;
    if (!has_row && training_seconds(s->trainer) < row_growth * last) {
        return AD_OK;
    }
    ad_status status = has_row ? AD_OK : trainer_add_row(s->trainer, error);
    compare_row row = row_of(s);
    return status == AD_OK ? compare_run_add(run, &row, error) : status;
}

static ad_status finish(session *s, compare_run *run, ad_error *error)
{
    trainer_info info = trainer_inspect(s->trainer);
    run->seconds = info.seconds - info.row_seconds;
    run->steps = info.step;
    bool has_row = run->count > 0 && run->rows[run->count - 1].step == (double)info.step;
    if (has_row || info.step == 0 || run->end == COMPARE_FAILED) {
        return AD_OK;
    }
    ad_status status = trainer_add_row(s->trainer, error);
    compare_row row = row_of(s);
    row.seconds = run->seconds;
    return status == AD_OK ? compare_run_add(run, &row, error) : status;
}

static ad_status go(session *s, const compare_task *task, compare_run *run, ad_error *error)
{
    progress live = progress_start(stdout, task->quiet, s->trainer);
    live.limit = task->seconds;
    ad_status status = AD_OK;
    run->end = COMPARE_ENDED;
    while (status == AD_OK && trainer_inspect(s->trainer).state == TRAINER_RUNNING) {
        if (signals_caught() || training_seconds(s->trainer) >= task->seconds) {
            run->end = signals_caught() ? COMPARE_STOPPED : COMPARE_OUT_OF_TIME;
            break;
        }
        size_t rows = trainer_history(s->trainer)->count;
        status = trainer_step(s->trainer, error);
        if (status == AD_OK) {
            status = record(s, run, rows, error);
        }
        if (live.live) {
            progress_step(&live, s->trainer, s->e);
        }
    }
    if (status == AD_NOT_FINITE) {
        run->end = COMPARE_FAILED;
        snprintf(run->why, sizeof run->why, "%s", error->message);
        status = AD_OK;
    }
    progress_clear(&live);
    return status == AD_OK ? finish(s, run, error) : status;
}

ad_status compare_train(const compare_task *task, compare_run *run, ad_error *error)
{
    session s = {.e = NULL};
    ad_status status = prepare(&s, task, error);
    if (status == AD_OK) {
        status = go(&s, task, run, error);
    }
    session_free(&s);
    return status;
}
