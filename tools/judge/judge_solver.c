/* A scene by the solver, as cpinn-solve does it. */
#include "tools/judge/judge.h"
#include "tools/train/clock.h"

#include <math.h>

typedef struct classical {
    experiment *e;
    reference *known; /* NULL: the scene names none, or the solver's own */
    solve_settings settings;
    solve_report report;
    solution *solved;
} classical;

/* Where no other reference tells the position, the solver's own estimate is what is known of its
 * error. */
static ad_status measure(const classical *classical, judge_row *row, ad_error *error)
{
    reference_errors errors = {NAN, NAN, NAN, NAN, NAN};
    ad_status status = AD_OK;
    if (classical->known) {
        status = reference_compare_solution(classical->known, classical->solved, &errors, error);
    }
    if (isnan(errors.position)) {
        errors.position = classical->report.estimate_l2;
    }
    judge_measures(&errors, row->errors);
    return status;
}

static ad_status solve(classical *classical, double reading, judge_row *row, ad_error *error)
{
    const scene *rod_scene = classical->e->scene;
    const reference *known = classical->known;
    bool moves = scene_is_dynamic(rod_scene);
    double began = train_seconds();
    ad_status status = solution_create(
        rod_scene, &classical->settings, known ? reference_points(known) : 0,
        known ? reference_t(known) : NULL, &classical->solved, &classical->report, error);
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
    classical x = {.e = NULL};
    double reading = 0;
    ad_status status = judge_open(task, false, &x.e, &x.known, &reading, error);
    if (status == AD_OK) {
        x.settings = solve_settings_default(x.e->scene);
        status = solve(&x, reading, row, error);
    }
    if (status != AD_OK && row->verdict.count == 0) {
        verdict_add(&row->verdict, status == AD_NO_MEMORY ? VERDICT_FAILED : VERDICT_BAD_INPUT,
                    "%s", error->message);
    }
    solution_free(x.solved);
    reference_free(x.known);
    experiment_free(x.e);
    return status;
}
