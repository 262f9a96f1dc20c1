/* A scene by the solver, as cpinn-solve does it. */
#include "tools/judge/judge.h"
#include "tools/train/clock.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct classical {
    const judge_task *task;
    experiment *e;
    reference *known; /* NULL: the scene names none, or the solver's own */
    double *times;    /* [count] those of the reference; if others are measured, JUDGE_INSTANTS */
    size_t count;
    solve_settings settings;
    solve_report report;
    solution *solved;
} classical;

static ad_status choose_times(classical *x, ad_error *error)
{
    size_t points = x->known ? reference_points(x->known) : 0;
    x->count = points + (x->task->measure ? JUDGE_INSTANTS : 0);
    x->times = calloc(x->count + 1, sizeof *x->times);
    if (!x->times) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", x->count);
    }
    if (points > 0) {
        memcpy(x->times, reference_t(x->known), points * sizeof *x->times);
    }
    if (x->task->measure) {
        judge_instants(x->e->scene, x->times + points);
    }
    return AD_OK;
}

/* Where no other reference tells the position, the solver's own estimate is what is known of its
 * error. */
static ad_status measure(const classical *x, judge_row *row, ad_error *error)
{
    judge_answer answer = {.scene = x->e->scene, .solved = x->solved};
    reference_errors errors = {NAN, NAN, NAN, NAN, NAN};
    ad_status status = AD_OK;
    if (x->known) {
        status = reference_compare_solution(x->known, x->solved, &errors, error);
    }
    if (isnan(errors.position)) {
        errors.position = x->report.estimate_l2;
    }
    judge_measures(&errors, row->errors);
    memcpy(answer.errors, row->errors, sizeof answer.errors);
    row->error = row->errors[JUDGE_POSITION];
    return status == AD_OK && x->task->measure ? x->task->measure(&answer, &row->error, error)
                                               : status;
}

static ad_status solve(classical *x, double reading, judge_row *row, ad_error *error)
{
    const scene *rod_scene = x->e->scene;
    bool moves = scene_is_dynamic(rod_scene);
    double began = train_seconds();
    ad_status status =
        solution_create(rod_scene, &x->settings, x->count, x->times, &x->solved, &x->report, error);
    if (status != AD_OK) {
        verdict_add(&row->verdict, status == AD_BAD_ARGUMENT ? VERDICT_NO_METHOD : VERDICT_FAILED,
                    "%s", error->message);
        return status;
    }
    row->seconds = reading + train_seconds() - began;
    row->points = x->report.nodes;
    row->steps = (double)(moves ? x->report.time_steps : x->report.newton_steps);
    judge_form(x->e, JUDGE_SOLVER, row->form);
    judge_left_out(rod_scene, JUDGE_SOLVER, row->left_out);
    solution_verdict(x->solved, rod_scene, &x->settings, &x->report, &row->verdict);
    return verdict_outcome_of(&row->verdict) == VERDICT_STOPPED ? AD_OK : measure(x, row, error);
}

ad_status judge_by_solver(const judge_task *task, judge_row *row, ad_error *error)
{
    classical x = {.task = task};
    double reading = 0;
    ad_status status = judge_open(task, false, &x.e, &x.known, &reading, error);
    if (status == AD_OK) {
        status = choose_times(&x, error);
    }
    if (status == AD_OK) {
        x.settings = solve_settings_default(x.e->scene);
        x.settings.tolerance = task->tolerance > 0 ? task->tolerance : x.settings.tolerance;
        status = solve(&x, reading, row, error);
    }
    if (status != AD_OK && row->verdict.count == 0) {
        verdict_add(&row->verdict, status == AD_NO_MEMORY ? VERDICT_FAILED : VERDICT_BAD_INPUT,
                    "%s", error->message);
    }
    solution_free(x.solved);
    free(x.times);
    reference_free(x.known);
    experiment_free(x.e);
    return status;
}
