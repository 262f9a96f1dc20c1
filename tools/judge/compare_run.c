/* A run: a scene by a method with one seed, as rows of error over run time. The clock stands still
 * while errors are evaluated. */
#include "tools/judge/compare.h"
#include "tools/judge/signals.h"
#include "tools/judge/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double row_growth = 1.05; /* of the time from one row to the next, at least */

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

/* The run, and its rows behind it. */
ad_status compare_run_pack(const compare_run *run, void **bytes, size_t *size, ad_error *error)
{
    const size_t rows = run->count * sizeof *run->rows;
    char *to = malloc(sizeof *run + rows);
    if (!to) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a run of %zu rows", run->count);
    }
    memcpy(to, run, sizeof *run);
    if (rows > 0) {
        memcpy(to + sizeof *run, run->rows, rows);
    }
    *bytes = to;
    *size = sizeof *run + rows;
    return AD_OK;
}

ad_status compare_run_unpack(const void *bytes, compare_run *run, ad_error *error)
{
    memcpy(run, bytes, sizeof *run);
    const size_t rows = run->count * sizeof *run->rows;
    run->capacity = run->count;
    run->rows = malloc(rows + 1);
    if (!run->rows) {
        run->count = run->capacity = 0;
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a run of %zu bytes", rows);
    }
    memcpy(run->rows, (const char *)bytes + sizeof *run, rows);
    return AD_OK;
}

bool compare_failed(const compare_run *run)
{
    verdict_reason reason = verdict_worst(&run->verdict);
    return verdict_reason_outcome(reason) >= VERDICT_STOPPED && reason != VERDICT_SIGNAL &&
           reason != VERDICT_TIME_LIMIT;
}

/* ---- rehearsal ----------------------------------------------------------------------------- */

static ad_status open_session(const judge_task *task, session *s, ad_error *error)
{
    config *settings;
    ad_status status = judge_read(task, &settings, NULL, error);
    return status == AD_OK ? config_session_create(settings, task->threads, s, error) : status;
}

static ad_status check_reference(const session *s, const judge_task *task, judge_measure measure,
                                 ad_error *error)
{
    if (!s->known) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: the scene names no reference, so there is no error to show; allowed: "
                       "reference.analytic, solve or file",
                       task->path);
    }
    const reference_errors known = trainer_inspect(s->trainer)->errors;
    double errors[JUDGE_MEASURES];
    judge_measures(&known, errors);
    if (measure != JUDGE_POSITION && isnan(errors[measure])) {
        return ad_fail(error, AD_BAD_INPUT,
                       "--error %s: the reference %s of %s does not know it; allowed: position",
                       judge_measure_name(measure), reference_name(s->known), task->path);
    }
    return AD_OK;
}

static void take_estimates(const session *s, compare_cell *cell)
{
    const reference_errors unknown = {NAN, NAN, NAN, NAN, NAN};
    const reference_errors of = s->known ? reference_estimates(s->known) : unknown;
    judge_measures(&of, cell->estimates);
}

ad_status compare_rehearse(const judge_task *task, judge_measure measure, compare_cell *cell,
                           uint64_t *seed, ad_error *error)
{
    session s = {.e = NULL};
    ad_status status = open_session(task, &s, error);
    if (status == AD_OK) {
        judge_name(cell->scene_name, s.e->settings->name);
        compare_network_name(cell->network, &s.e->settings->network);
        judge_form(s.e, task->method, cell->form);
        cell->parameters = s.e->count;
        if (task->method == JUDGE_SOLVER) {
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

/* ---- by a network -------------------------------------------------------------------------- */

typedef struct recorder {
    const judge_task *task;
    compare_run *run;
    size_t known; /* rows of the trainer's history */
} recorder;

/* The row that the trainer has evaluated last, at the clock of now. Its errors count where they are
 * those of the whole scene, not of its first windows alone. */
static compare_row row_of(const session *s)
{
    const fit *f = trainer_fit(s->trainer);
    const trainer_info *info = trainer_inspect(s->trainer);
    const history *h = &trainer_fit(s->trainer)->rows;
    int windows = s->e->scene->windows;
    compare_row row = {.seconds = fit_seconds(f) - info->row_seconds,
                       .step = (double)f->at.step,
                       .loss = f->loss,
                       .held_out = f->held_out,
                       .errors = {NAN, NAN, NAN}};
    if (windows == 1 || history_value(h, h->count - 1, "window") == windows) {
        judge_measures(&info->errors, row.errors);
    }
    return row;
}

/* The trainer's own rows, and ours when time has grown enough since the last. */
static ad_status record(void *context, session *s, bool is_last, ad_error *error)
{
    recorder *to = context;
    compare_run *run = to->run;
    const fit *f = trainer_fit(s->trainer);
    const trainer_info *info = trainer_inspect(s->trainer);
    const history *h = &trainer_fit(s->trainer)->rows;
    bool has_row = h->count > to->known;
    double last = run->count > 0 ? run->rows[run->count - 1].seconds : 0;
    ad_status status = AD_OK;
    run->seconds = fit_seconds(f) - info->row_seconds;
    run->steps = f->at.step;
    if (!is_last && !has_row && run->seconds >= row_growth * last) {
        status = trainer_add_row(s->trainer, error);
        has_row = true;
    }
    if (status == AD_OK && has_row) {
        compare_row row = row_of(s);
        to->known = h->count;
        status = compare_run_add(run, &row, error);
    }
    return status == AD_OK && to->task->step ? to->task->step(to->task->context, s, is_last, error)
                                             : status;
}

static ad_status train(const judge_task *task, compare_run *run, ad_error *error)
{
    recorder to = {task, run, 0};
    judge_task watched = *task;
    judge_row row = judge_row_empty();
    watched.step = record;
    watched.context = &to;
    ad_status status = judge_by_network(&watched, &row, error);
    run->verdict = row.verdict;
    return status == AD_NOT_FINITE ? AD_OK : status;
}

/* ---- by the solver ------------------------------------------------------------------------- */

typedef struct sweep {
    const judge_task *task;
    judge_measure measure;
    compare_run *run;
    experiment *e;
    reference *known;
    double spent; /* s */
    ad_status status;
    ad_error *error;
} sweep;

/* Rows are in time, as those of training are: more nodes count as no quicker. */
static double add_row(void *context, int nodes, double seconds, const solution *solved)
{
    sweep *sweep = context;
    compare_run *run = sweep->run;
    double before = run->count > 0 ? run->rows[run->count - 1].seconds : 0;
    reference_errors errors;
    compare_row row = {
        .seconds = fmax(before, seconds), .step = nodes, .loss = NAN, .held_out = NAN};
    sweep->status = reference_compare_solution(sweep->known, solved, &errors, sweep->error);
    if (sweep->status == AD_OK) {
        judge_measures(&errors, row.errors);
        sweep->status = compare_run_add(run, &row, sweep->error);
    }
    sweep->spent += seconds;
    run->seconds = row.seconds;
    if (signals_caught()) {
        run->verdict.signal = signals_caught();
        verdict_add(&run->verdict, VERDICT_SIGNAL, "stopped");
    } else if (sweep->spent >= sweep->task->seconds) {
        verdict_add(&run->verdict, VERDICT_TIME_LIMIT, "%g s", sweep->task->seconds);
    }
    return sweep->status == AD_OK && run->verdict.count == 0 ? row.errors[sweep->measure] : NAN;
}

static ad_status solve(const judge_task *task, judge_measure measure, compare_run *run,
                       ad_error *error)
{
    sweep x = {.task = task, .measure = measure, .run = run, .error = error};
    ad_status status = judge_open(task, true, &x.e, &x.known, NULL, error);
    if (status == AD_OK) {
        status = solve_sweep(x.e->scene, reference_points(x.known), reference_t(x.known), add_row,
                             &x, error);
        status = status == AD_OK ? x.status : status;
    }
    if (status == AD_BAD_ARGUMENT) { /* a scene that the solver does not take */
        verdict_add(&run->verdict, VERDICT_NO_METHOD, "%s", error->message);
        status = AD_OK;
    } else if (status == AD_OK && run->count == 0) {
        verdict_add(&run->verdict, VERDICT_LOAD_NOT_REACHED,
                    "no number of nodes reaches the whole load");
    }
    reference_free(x.known);
    experiment_free(x.e);
    return status;
}

ad_status compare_do(const judge_task *task, judge_measure measure, compare_run *run,
                     ad_error *error)
{
    return task->method == JUDGE_SOLVER ? solve(task, measure, run, error)
                                        : train(task, run, error);
}
