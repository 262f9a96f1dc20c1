/* The reduced rod itself in the place of a one-step model. */
#include "tools/surrogate/rollouts_internal.h"

#include "autodiff/memory.h"
#include "autodiff/ranks.h"

#include <stdlib.h>
#include <string.h>

ad_status rollouts_make_rod(const scene *open, const int modes[4], reduced_rod **rod,
                            ad_error *error)
{
    const double tip = scene_length(open);
    reduced_settings settings = {.count = 1, .s = &tip};
    memcpy(settings.modes, modes, sizeof settings.modes);
    return reduced_create(open, &settings, rod, error);
}

typedef struct rod_steps {
    reduced_rod *rod;
    int parts; /* 1 or 2; the first is a quarter, as inputs jump at the begin */
} rod_steps;

static int advance_rod(void *context, int count, double h, const double *states,
                       const double *inputs, const double *after, double *next, double *by_state,
                       double *by_inputs)
{
    const rod_steps *steps = context;
    const int n = reduced_states(steps->rod), m = reduced_inputs(steps->rod);
    double between[SCENE_PARAMETERS_MAX];
    ad_error error;
    bool good = steps->parts == 1 || !by_state;
    for (int i = 0; i < count && good; i++) {
        const double *from = states + (size_t)i * (size_t)n, *u = inputs + (size_t)i * (size_t)m;
        const double *end = after ? after + (size_t)i * (size_t)m : NULL;
        double *to = next + (size_t)i * (size_t)n, part = 0;
        if (steps->parts == 2) {
            part = 0.25;
            for (int k = 0; k < m; k++) {
                between[k] = u[k] + (end ? part * (end[k] - u[k]) : 0);
            }
            good = reduced_step_linear(steps->rod, 0, part * h, from, u, end ? between : NULL, to,
                                       NULL, NULL, &error) == AD_OK;
            from = to;
            u = between;
        }
        good = good && reduced_step_linear(steps->rod, 0, (1 - part) * h, from, u, end, to,
                                           by_state, by_inputs, &error) == AD_OK;
    }
    return good ? 0 : 1;
}

static one_step rod_model(const rollouts_runner *runner, rod_steps *steps)
{
    return (one_step){.context = steps,
                      .states = runner->truth->states,
                      .inputs = runner->truth->inputs,
                      .step = runner->subject->model->step,
                      .shorter = 1,
                      .advance = advance_rod};
}

/* What the errors of a rollout are of: one step from each state, all steps in a row. */
enum { OF_ONE, OF_ALL, OF_BOTH };

/* The rod in rollouts, each by whatever thread is free. */
typedef struct rod_rollouts {
    const rollouts_runner *x;
    int parts, steps;
    reduced_rod **rods;    /* [threads] */
    double *state;         /* [threads][2][states] */
    double *errors;        /* [count][OF_BOTH][steps] */
    int (*found)[OF_BOTH]; /* [count]: how many; of all steps 0 where they diverge, and */
    int *diverges;         /* [count] */
    ad_memory memory;
} rod_rollouts;

static ad_status roll_rod(void *context, int item, int thread, ad_error *error)
{
    const rod_rollouts *of = context;
    rollouts_runner own = *of->x;
    double *errors = of->errors + (size_t)item * OF_BOTH * (size_t)of->steps;
    int *found = of->found[item];
    (void)error;
    own.rod = of->rods[thread];
    own.state = of->state + (size_t)thread * 2 * (size_t)own.truth->states;
    rod_steps steps = {own.rod, of->parts};
    const one_step model = rod_model(&own, &steps);
    found[OF_ONE] = rollouts_one_steps(&own, &model, item, of->steps, errors);
    of->diverges[item] =
        rollouts_roll(&own, &model, item, of->steps, errors + of->steps, &found[OF_ALL], NULL);
    found[OF_ALL] = of->diverges[item] ? 0 : found[OF_ALL];
    return AD_OK;
}

static ad_status roll_rods(const rod_rollouts *of, ad_pool *pool, rollouts_row *row,
                           ad_error *error)
{
    static const int spans[OF_BOTH] = {ROLLOUTS_ONE, ROLLOUTS_SHORT};
    const rollouts_runner *runner = of->x;
    const size_t count = (size_t)runner->truth->count, steps = (size_t)of->steps;
    const size_t bytes = OF_BOTH * steps * sizeof *of->errors;
    const ad_dealt made[] = {{of->errors, bytes, count * bytes},
                             {of->found, sizeof *of->found, count * sizeof *of->found},
                             {of->diverges, sizeof *of->diverges, count * sizeof *of->diverges}};
    ad_status status = ad_pool_deal(pool, runner->truth->count, roll_rod, (void *)of,
                                    sizeof made / sizeof *made, made, error);
    row->diverged = 0;
    for (int k = 0; k < OF_BOTH && status == AD_OK; k++) {
        size_t all = 0;
        for (size_t i = 0; i < count; i++) {
            const size_t own = (size_t)of->found[i][k];
            memcpy(runner->errors + all, of->errors + (i * OF_BOTH + (size_t)k) * steps,
                   own * sizeof *runner->errors);
            all += own;
            row->diverged += k == OF_ALL && of->diverges[i];
        }
        rollouts_median_and_worst(all, runner->errors, row->error[spans[k]]);
    }
    return status;
}

static ad_status open_rods(rod_rollouts *of, int threads, ad_error *error)
{
    const rollouts_runner *runner = of->x;
    const size_t count = (size_t)runner->truth->count;
    ad_status status = AD_OK;
    AD_TAKE(of, rods, (size_t)threads);
    AD_TAKE(of, state, (size_t)threads * 2 * (size_t)runner->truth->states);
    AD_TAKE(of, errors, count * OF_BOTH * (size_t)of->steps);
    AD_TAKE(of, found, count);
    AD_TAKE(of, diverges, count);
    if (of->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rollouts", count);
    }
    for (int i = 0; i < threads && status == AD_OK; i++) {
        status =
            rollouts_make_rod(runner->subject->scene, runner->subject->modes, &of->rods[i], error);
    }
    return status;
}

static void close_rods(rod_rollouts *of, int threads)
{
    for (int i = 0; of->rods && i < threads; i++) {
        reduced_free(of->rods[i]);
    }
    ad_memory_free(&of->memory);
}

ad_status rollouts_judge_rod(rollouts_runner *runner, ad_pool *pool, rollouts_report *report,
                             ad_error *error)
{
    const int threads = ad_pool_threads(pool);
    rod_rollouts all = {.x = runner, .steps = report->steps[ROLLOUTS_SHORT]};
    ad_status status = open_rods(&all, threads, error);
    for (int parts = 1; parts <= 2 && status == AD_OK; parts++) {
        rod_steps steps = {runner->rod, parts};
        const one_step model = rod_model(runner, &steps);
        rollouts_row *row = &report->rows[parts == 1 ? ROLLOUTS_ROD : ROLLOUTS_ROD_TWICE];
        row->name = parts == 1 ? "reduced rod in one step" : "reduced rod in two steps";
        row->states = runner->truth->states;
        all.parts = parts;
        status = roll_rods(&all, pool, row, error);
        status = status == AD_OK ? rollouts_time_model(runner, &model, row, error) : status;
    }
    close_rods(&all, threads);
    return status;
}
