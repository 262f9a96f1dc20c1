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

static ad_status choose_times(classical *classical, ad_error *error)
{
    size_t points = classical->known ? reference_points(classical->known) : 0;
    classical->count = points + (classical->task->measure ? JUDGE_INSTANTS : 0);
    classical->times = calloc(classical->count + 1, sizeof *classical->times);
    if (!classical->times) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", classical->count);
    }
    if (points > 0) {
        memcpy(classical->times, reference_t(classical->known), points * sizeof *classical->times);
    }
    if (classical->task->measure) {
        judge_instants(classical->e->scene, classical->times + points);
    }
    return AD_OK;
}

/* Where no other reference tells the position, the solver's own estimate is what is known of its
 * error. */
static ad_status measure(const classical *classical, judge_row *row, ad_error *error)
{
    judge_answer judged = {.found = answer_of_solution(classical->solved, classical->e->scene)};
    reference_errors errors = {NAN, NAN, NAN, NAN, NAN};
    ad_status status = AD_OK;
    if (classical->known) {
        status = reference_compare_solution(classical->known, classical->solved, &errors, error);
    }
    if (isnan(errors.position)) {
        errors.position = classical->report.estimate_l2;
    }
    judge_measures(&errors, row->errors);
    memcpy(judged.errors, row->errors, sizeof judged.errors);
    row->error = row->errors[JUDGE_POSITION];
    return status == AD_OK && classical->task->measure
               ? classical->task->measure(&judged, &row->error, error)
               : status;
}

static ad_status solve(classical *classical, double reading, judge_row *row, ad_error *error)
{
    const scene *rod_scene = classical->e->scene;
    bool moves = scene_is_dynamic(rod_scene);
    double began = train_seconds();
    ad_status status =
        solution_create(rod_scene, &classical->settings, classical->count, classical->times,
                        &classical->solved, &classical->report, error);
    if (status != AD_OK) {
        verdict_add(&row->verdict, status == AD_BAD_ARGUMENT ? VERDICT_NO_METHOD : VERDICT_FAILED,
                    "%s", error->message);
        return status;
    }
    row->seconds = reading + train_seconds() - began;
    row->points = classical->report.nodes;
    row->steps = (double)(moves ? classical->report.time_steps : classical->report.newton_steps);
    judge_form(classical->e, JUDGE_SOLVER, row->form);
    judge_left_out(rod_scene, JUDGE_SOLVER, row->left_out);
    solution_verdict(classical->solved, rod_scene, &classical->settings, &classical->report,
                     &row->verdict);
    return verdict_outcome_of(&row->verdict) == VERDICT_STOPPED ? AD_OK
                                                                : measure(classical, row, error);
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
