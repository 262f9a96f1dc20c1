/* The classical solver beside networks: every number of nodes is a row. */
#include "tools/judge/compare/compare.h"

#include "tools/config/config_experiment.h"
#include "tools/judge/signals.h"
#include "tools/judge/sweep.h"

#include <math.h>

typedef struct sweep {
    const compare_task *task;
    compare_measure measure;
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
    sweep *x = context;
    compare_run *run = x->run;
    double before = run->count > 0 ? run->rows[run->count - 1].seconds : 0;
    reference_errors errors;
    x->status = reference_compare_solution(x->known, solved, &errors, x->error);
    if (x->status != AD_OK) {
        return NAN;
    }
    compare_row row = {.seconds = fmax(before, seconds),
                       .step = nodes,
                       .loss = NAN,
                       .held_out = NAN,
                       .errors = {errors.position, errors.tip, errors.rotation}};
    x->status = compare_run_add(run, &row, x->error);
    x->spent += seconds;
    run->seconds = row.seconds;
    run->end = signals_caught()               ? COMPARE_STOPPED
               : x->spent >= x->task->seconds ? COMPARE_OUT_OF_TIME
                                              : COMPARE_ENDED;
    return x->status == AD_OK && run->end == COMPARE_ENDED ? row.errors[x->measure] : NAN;
}

static ad_status open_scene(sweep *x, ad_error *error)
{
    const compare_task *task = x->task;
    config *settings;
    ad_status status =
        config_read(task->path, NULL, task->override_count, task->overrides, &settings, error);
    if (status == AD_OK) {
        status = config_experiment_create(settings, task->threads, &x->e, error);
    }
    return status == AD_OK ? reference_create(x->e, &x->known, error) : status;
}

ad_status compare_solve(const compare_task *task, compare_measure measure, compare_run *run,
                        ad_error *error)
{
    sweep x = {.task = task, .measure = measure, .run = run, .error = error};
    ad_status status = open_scene(&x, error);
    run->end = COMPARE_ENDED;
    if (status == AD_OK) {
        status = solve_sweep(x.e->scene, 0, reference_points(x.known), reference_t(x.known),
                             add_row, &x, error);
        status = status == AD_OK ? x.status : status;
    }
    if (status == AD_BAD_ARGUMENT || (status == AD_OK && run->count == 0)) {
        snprintf(run->why, sizeof run->why, "%s",
                 status == AD_OK ? "no number of nodes reaches the whole load" : error->message);
        run->end = COMPARE_FAILED; /* a scene that the solver does not take */
        status = AD_OK;
    }
    reference_free(x.known);
    experiment_free(x.e);
    return status;
}
