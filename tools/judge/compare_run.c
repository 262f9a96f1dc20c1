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

bool compare_failed(const compare_run *run)
{
    verdict_reason reason = verdict_worst(&run->verdict);
    return verdict_reason_outcome(reason) >= VERDICT_STOPPED && reason != VERDICT_SIGNAL &&
           reason != VERDICT_TIME_LIMIT;
}

/* ---- rehearsal ----------------------------------------------------------------------------- */

static ad_status read_task(const compare_task *task, config **settings, ad_error *error)
{
    return prepare_read_member(task->path, NULL, task->override_count, task->overrides, NULL,
                               settings, error);
}

static ad_status open_session(const compare_task *task, session *s, ad_error *error)
{
    config *settings;
    ad_status status = read_task(task, &settings, error);
    return status == AD_OK ? config_session_create(settings, task->threads, s, error) : status;
}

static ad_status check_reference(const session *s, const compare_task *task, judge_measure measure,
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

ad_status compare_rehearse(const compare_task *task, judge_measure measure, compare_cell *cell,
                           uint64_t *seed, ad_error *error)
{
    session s = {.e = NULL};
    ad_status status = open_session(task, &s, error);
    if (status == AD_OK) {
        judge_name(cell->scene_name, s.e->settings->name);
        compare_network_name(cell->network, &s.e->settings->network);
        judge_form(s.e, cell->form);
        cell->parameters = s.e->count;
        if (task->is_solver) {
            strcpy(cell->form, judge_solver_form(s.e->scene, SOLVE_COLLOCATION));
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

/* The row that the trainer has evaluated last, at the clock of now. Its errors count where they are
 * those of the whole scene, not of its first windows alone. */
static compare_row row_of(const session *s)
{
    const fit *f = trainer_fit(s->trainer);
    const trainer_info *info = trainer_inspect(s->trainer);
    const history *h = &f->rows;
    int windows = s->e->scene->windows;
    compare_row row = {.seconds = fit_seconds(f),
                       .step = (double)f->at.step,
                       .loss = f->loss,
                       .held_out = f->held_out,
                       .errors = {NAN, NAN, NAN}};
    if (windows == 1 || history_value(h, h->count - 1, "window") == windows) {
        judge_measures(&info->errors, row.errors);
    }
    return row;
}

/* A row for a step that has none: at the end, and when time has grown enough since the last. */
static bool row_is_due(const session *s, const compare_run *run, bool is_last)
{
    const fit *f = trainer_fit(s->trainer);
    const double last = run->count > 0 ? run->rows[run->count - 1].seconds : 0;
    const size_t count = f->rows.count;
    const bool is_there =
        count > 0 && history_value(&f->rows, count - 1, "step") == (double)f->at.step;
    return is_last ? !is_there && f->at.step > 0 : run->seconds >= row_growth * last;
}

/* The trainer's own rows, of which there were `known`, and ours. */
static ad_status record(const compare_task *task, session *s, bool is_last, size_t *known,
                        compare_run *run, ad_error *error)
{
    const fit *f = trainer_fit(s->trainer);
    ad_status status = AD_OK;
    run->seconds = fit_seconds(f);
    run->steps = f->at.step;
    if (f->rows.count == *known && row_is_due(s, run, is_last)) {
        status = fit_add_row(trainer_fit(s->trainer), error);
    }
    if (status == AD_OK && f->rows.count > *known) {
        compare_row row = row_of(s);
        *known = f->rows.count;
        status = compare_run_add(run, &row, error);
    }
    return status == AD_OK && task->step ? task->step(task->context, s, is_last, error) : status;
}

static ad_status take_steps(const compare_task *task, session *s, compare_run *run, ad_error *error)
{
    const fit *f = trainer_fit(s->trainer);
    size_t known = 0;
    ad_status status = AD_OK;
    while (status == AD_OK && f->state == FIT_RUNNING) {
        if (signals_caught()) {
            run->verdict.signal = signals_caught();
            verdict_add(&run->verdict, VERDICT_SIGNAL, "stopped");
            break;
        }
        if (fit_seconds(f) >= task->seconds) {
            verdict_add(&run->verdict, VERDICT_TIME_LIMIT, "%g s in window %d of %d", task->seconds,
                        s->e->window + 1, s->e->scene->windows);
            break;
        }
        status = trainer_step(s->trainer, error);
        status = status == AD_OK ? record(task, s, false, &known, run, error) : status;
    }
    status = status == AD_OK ? record(task, s, true, &known, run, error) : status;
    if (status == AD_OK && f->state == FIT_OVER) {
        trainer_verdict(s->trainer, &run->verdict);
    }
    return status;
}

static ad_status train(const compare_task *task, compare_run *run, ad_error *error)
{
    session s = {.e = NULL};
    ad_status status = open_session(task, &s, error);
    status = status == AD_OK ? take_steps(task, &s, run, error) : status;
    if (status != AD_OK) {
        verdict_add(&run->verdict, status == AD_NOT_FINITE ? VERDICT_NOT_FINITE : VERDICT_FAILED,
                    "%s", error->message);
    }
    session_free(&s);
    return status == AD_NOT_FINITE ? AD_OK : status;
}

/* ---- by the solver ------------------------------------------------------------------------- */

typedef struct sweep {
    const compare_task *task;
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

static ad_status solve(const compare_task *task, judge_measure measure, compare_run *run,
                       ad_error *error)
{
    sweep x = {.task = task, .measure = measure, .run = run, .error = error};
    config *settings;
    ad_status status = read_task(task, &settings, error);
    status = status == AD_OK ? config_experiment_create(settings, 1, &x.e, error) : status;
    status = status == AD_OK ? reference_create(x.e, &x.known, error) : status;
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

ad_status compare_do(const compare_task *task, judge_measure measure, compare_run *run,
                     ad_error *error)
{
    return task->is_solver ? solve(task, measure, run, error) : train(task, run, error);
}
