#include "tools/surrogate/rollouts_internal.h"

#include "physics/chain/reduced.h"
#include "physics/numerics/clock.h"
#include "physics/numerics/quaternion.h"
#include "physics/numerics/sort.h"
#include "tools/surrogate/excitation.h"
#include "tools/surrogate/growth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double SHORT_SECONDS = 5, DIVERGED = 0.25;
enum { LONG_STEPS = 1000, FRESH = 1000000 }; /* rollouts of that number on are for no training */

static double *truth_state(const excitation_rollouts *rollouts, int i, int k)
{
    return rollouts->state +
           ((size_t)i * (size_t)(rollouts->steps + 1) + (size_t)k) * (size_t)rollouts->states;
}

static double *truth_input(const excitation_rollouts *rollouts, int i, int k)
{
    return rollouts->input +
           ((size_t)i * (size_t)(rollouts->steps + 1) + (size_t)k) * (size_t)rollouts->inputs;
}

/* ---- numbers ------------------------------------------------------------------------------- */

void rollouts_median_and_worst(size_t count, double *errors, double result[2])
{
    sort_ascending(count, errors);
    result[ROLLOUTS_MEDIAN] = count ? errors[count / 2] : NAN;
    result[ROLLOUTS_WORST] = count ? errors[count - 1] : NAN;
}

static bool tip_of(const rollouts_runner *runner, const double *state, const double *inputs,
                   double tip[3])
{
    reduced_place at;
    ad_error error;
    for (int k = 0; k < runner->truth->states; k++) {
        if (!isfinite(state[k])) {
            return false;
        }
    }
    if (reduced_output(runner->rod, 0, state, inputs, &at, NULL, &error) != AD_OK) {
        return false;
    }
    memcpy(tip, at.position, sizeof at.position);
    return isfinite(tip[0] + tip[1] + tip[2]);
}

/* ---- errors -------------------------------------------------------------------------------- */

/* Error after step k of rollout i from `state`, which becomes the one after it; NaN: diverged. */
static double advance(const rollouts_runner *runner, const one_step *model, int i, int k,
                      const double *state, double *next, double tip[3])
{
    const double *inputs = truth_input(runner->truth, i, k),
                 *after = truth_input(runner->truth, i, k + 1);
    const double *expected =
        runner->tips[(size_t)i * (size_t)(runner->truth->steps + 1) + (size_t)k + 1];
    if (model->advance(model->context, 1, model->step, state, inputs,
                       runner->subject->linear ? after : NULL, next, NULL, NULL) != 0 ||
        !tip_of(runner, next, inputs, tip)) {
        return NAN;
    }
    const double error = vector_distance(tip, expected) / runner->length;
    return error <= DIVERGED ? error : NAN;
}

int rollouts_one_steps(const rollouts_runner *runner, const one_step *model, int i, int steps,
                       double *errors)
{
    double tip[3];
    int k = 0;
    for (; k < steps && k < runner->truth->done[i]; k++) {
        const double error =
            advance(runner, model, i, k, truth_state(runner->truth, i, k), runner->state, tip);
        errors[k] = isnan(error) ? INFINITY : error;
    }
    return k;
}

static void one_steps(rollouts_runner *runner, const one_step *model, int steps, rollouts_row *row)
{
    size_t count = 0;
    for (int i = 0; i < runner->truth->count; i++) {
        count += (size_t)rollouts_one_steps(runner, model, i, steps, runner->errors + count);
    }
    rollouts_median_and_worst(count, runner->errors, row->error[ROLLOUTS_ONE]);
}

/* What a report keeps of rollout i after `done` of its steps: the tips and the states. */
static void keep(const rollouts_runner *runner, int i, int done, const double *state,
                 const double tip[3], rollouts_report *report)
{
    const size_t n = (size_t)runner->truth->states, m = (size_t)runner->truth->inputs;
    double *to = report->states + (size_t)done * 2 * n;
    memcpy(to, truth_state(runner->truth, i, done), n * sizeof *to);
    memcpy(to + n, state, n * sizeof *to);
    memcpy(report->inputs + (size_t)done * m, truth_input(runner->truth, i, done), m * sizeof *to);
    if (done > 0) {
        const size_t at = (size_t)i * (size_t)(runner->truth->steps + 1) + (size_t)done;
        memcpy(report->path[done - 1][0], runner->tips[at], 3 * sizeof *tip);
        memcpy(report->path[done - 1][1], tip, 3 * sizeof *tip);
    }
}

bool rollouts_roll(const rollouts_runner *runner, const one_step *model, int i, int steps,
                   double *errors, int *count, rollouts_report *report)
{
    const size_t n = (size_t)runner->truth->states;
    double *now = runner->state, *next = runner->state + n, tip[3];
    memcpy(now, truth_state(runner->truth, i, 0), n * sizeof *now);
    if (report) {
        keep(runner, i, 0, now, NULL, report);
    }
    for (*count = 0; *count < steps && *count < runner->truth->done[i]; ++*count) {
        const double error = advance(runner, model, i, *count, now, next, tip);
        double *const other = now;
        now = next;
        next = other;
        if (isnan(error)) {
            return true;
        }
        errors[*count] = error;
        if (report) {
            keep(runner, i, *count + 1, now, tip, report);
        }
    }
    return false;
}

static void rollouts(rollouts_runner *runner, const one_step *model,
                     const int steps[ROLLOUTS_SPANS], rollouts_row *row)
{
    for (int span = ROLLOUTS_SHORT; span <= ROLLOUTS_LONG; span++) {
        size_t all = 0;
        row->diverged = 0;
        for (int i = 0; i < runner->truth->count; i++) {
            int count;
            const bool diverges =
                rollouts_roll(runner, model, i, steps[span], runner->errors + all, &count, NULL);
            row->diverged += diverges;
            all += diverges ? 0 : (size_t)count;
        }
        rollouts_median_and_worst(all, runner->errors, row->error[span]);
    }
}

/* The errors of the model after each step, and the rollout that is in the middle of all by its
 * largest error. */
static ad_status over_time(rollouts_runner *runner, const one_step *model, rollouts_report *report,
                           ad_error *error)
{
    const int steps = report->steps[ROLLOUTS_SHORT], count = runner->truth->count;
    double *each = malloc(2 * (size_t)count * sizeof *each), *sorted = each + count;
    int typical = 0, done, largest_first = 0;
    if (!each) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d rollouts", count);
    }
    for (int i = 0; i < count; i++) {
        double *errors = runner->errors + (size_t)i * (size_t)steps;
        const bool diverges = rollouts_roll(runner, model, i, steps, errors, &done, NULL);
        each[i] = diverges ? INFINITY : 0;
        for (int k = 0; k < steps; k++) {
            errors[k] = k < done ? errors[k] : NAN;
            each[i] = k < done ? fmax(each[i], errors[k]) : each[i];
        }
    }
    for (int k = 0; k < steps; k++) {
        size_t number = 0;
        for (int i = 0; i < count; i++) {
            const double e = runner->errors[(size_t)i * (size_t)steps + (size_t)k];
            sorted[number] = e;
            number += !isnan(e);
        }
        rollouts_median_and_worst(number, sorted, report->over_time[k]);
    }
    memcpy(sorted, each, (size_t)count * sizeof *each);
    sort_ascending((size_t)count, sorted);
    for (int i = 0; i < count && !largest_first; i++) {
        typical = i;
        largest_first = each[i] == sorted[count / 2];
    }
    for (size_t k = 0; k < 2 * (size_t)(steps + 1) * (size_t)runner->truth->states; k++) {
        report->states[k] = NAN;
    }
    rollouts_roll(runner, model, typical, steps, runner->errors, &done, report);
    for (int k = done; k < steps; k++) {
        for (int c = 0; c < 6; c++) {
            report->path[k][c / 3][c % 3] = NAN;
        }
    }
    free(each);
    return AD_OK;
}

/* ---- times --------------------------------------------------------------------------------- */

/* The least of many rounds over the same states, s a call for `together` of them; NaN: no answer.
 */
static double time_steps(const one_step *model, int together, const double *states,
                         const double *inputs, const double *after, double *next, double *by_state,
                         double *by_inputs)
{
    const double measured = 0.05;
    const size_t n = (size_t)model->states, m = (size_t)model->inputs;
    const double began = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
    double least = INFINITY, now = began;
    while (now - began < measured) {
        for (int i = 0; i < ROLLOUTS_TOGETHER; i += together) {
            if (model->advance(model->context, together, model->step, states + (size_t)i * n,
                               inputs + (size_t)i * m, after ? after + (size_t)i * m : NULL, next,
                               by_state, by_inputs) != 0) {
                return NAN;
            }
        }
        const double then = now;
        now = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
        least = fmin(least, (now - then) / (ROLLOUTS_TOGETHER / together));
    }
    return least;
}

ad_status rollouts_time_model(const rollouts_runner *runner, const one_step *model,
                              rollouts_row *row, ad_error *error)
{
    const excitation_rollouts *truth = runner->truth;
    const size_t n = (size_t)truth->states, m = (size_t)truth->inputs, many = ROLLOUTS_TOGETHER;
    double *memory = malloc((many * (2 * n + 2 * m) + n * (n + m)) * sizeof *memory);
    if (!memory) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d states", ROLLOUTS_TOGETHER);
    }
    double *states = memory, *inputs = states + many * n, *after = inputs + many * m;
    double *next = after + many * m, *by = next + many * n;
    for (int i = 0; i < ROLLOUTS_TOGETHER; i++) {
        const int which = i % truth->count, most = truth->done[which];
        const int k = most > 1 ? (int)(((long)i * 7919) % most) : 0;
        memcpy(states + (size_t)i * n, truth_state(truth, which, k), n * sizeof *states);
        memcpy(inputs + (size_t)i * m, truth_input(truth, which, k), m * sizeof *inputs);
        memcpy(after + (size_t)i * m, truth_input(truth, which, k + 1), m * sizeof *after);
    }
    const double *end = runner->subject->linear ? after : NULL;
    row->alone = time_steps(model, 1, states, inputs, end, next, NULL, NULL);
    row->together = time_steps(model, ROLLOUTS_TOGETHER, states, inputs, end, next, NULL, NULL);
    row->jacobian = time_steps(model, 1, states, inputs, end, next, by, by + n * n);
    free(memory);
    return AD_OK;
}

/* ---- the whole ----------------------------------------------------------------------------- */

static ad_status find_tips(reduced_rod *rod, const excitation_rollouts *truth, double (*tips)[3],
                           ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < truth->count; i++) {
        for (int k = 0; k <= truth->done[i] && status == AD_OK; k++) {
            reduced_place at;
            status = reduced_output(rod, 0, truth_state(truth, i, k),
                                    truth_input(truth, i, k > 0 ? k - 1 : 0), &at, NULL, error);
            memcpy(tips[(size_t)i * (size_t)(truth->steps + 1) + (size_t)k], at.position,
                   sizeof at.position);
        }
    }
    return status;
}

/* The same inputs with more modes, for as long as the short span. */
static ad_status judge_finer(rollouts_runner *runner, const excitation_settings *settings,
                             ad_pool *pool, rollouts_report *report, ad_error *error)
{
    const int steps = report->steps[ROLLOUTS_SHORT];
    rollouts_row *row = &report->rows[ROLLOUTS_FINER];
    excitation_settings finer = *settings;
    excitation_rollouts motion = {0};
    reduced_rod *rod = NULL;
    double(*tips)[3] = NULL;
    size_t count = 0;
    finer.steps = steps;
    for (int k = 0; k < 4; k++) {
        finer.modes[k]++;
    }
    ad_status status = excitation_run(runner->subject->scene, &finer, pool, &motion, error);
    status = status == AD_OK ? rollouts_make_rod(runner->subject->scene, finer.modes, &rod, error)
                             : status;
    if (status == AD_OK) {
        tips = calloc((size_t)motion.count * (size_t)(steps + 1), sizeof *tips);
        status = tips ? find_tips(rod, &motion, tips, error)
                      : ad_fail(error, AD_NO_MEMORY, "out of memory for paths");
    }
    for (int i = 0; i < motion.count && status == AD_OK; i++) {
        for (int k = 1; k <= motion.done[i] && k <= runner->truth->done[i]; k++) {
            const double *of = tips[(size_t)i * (size_t)(steps + 1) + (size_t)k];
            const size_t at = (size_t)i * (size_t)(runner->truth->steps + 1) + (size_t)k;
            runner->errors[count++] = vector_distance(of, runner->tips[at]) / runner->length;
        }
    }
    if (status == AD_OK) {
        row->name = "solver with finer modes";
        row->states = motion.states;
        rollouts_median_and_worst(count, runner->errors, row->error[ROLLOUTS_SHORT]);
        row->alone = motion.seconds / ((double)motion.count * steps);
    }
    reduced_free(rod);
    excitation_free(&motion);
    free(tips);
    return status;
}

static ad_status prepare(const rollouts_subject *subject, const excitation_rollouts *truth,
                         rollouts_runner *runner, rollouts_report *report, ad_error *error)
{
    const size_t rows = (size_t)truth->count * (size_t)(truth->steps + 1);
    const size_t steps = (size_t)report->steps[ROLLOUTS_SHORT];
    *runner = (rollouts_runner){.subject = subject, .truth = truth, .length = report->length};
    AD_TAKE(runner, tips, rows);
    AD_TAKE(runner, errors, rows);
    AD_TAKE(runner, state, 2 * truth->states);
    AD_TAKE(report, over_time, steps);
    AD_TAKE(report, path, steps);
    AD_TAKE(report, states, 2 * (steps + 1) * (size_t)truth->states);
    AD_TAKE(report, inputs, (steps + 1) * (size_t)truth->inputs + 1);
    if (runner->memory.is_short || report->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %d rollouts", truth->count);
    }
    if (subject->model->states != truth->states || subject->model->inputs != truth->inputs) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the model has %d states and %d inputs, the reduced rod %d and %d",
                       subject->model->states, subject->model->inputs, truth->states,
                       truth->inputs);
    }
    ad_status status = rollouts_make_rod(subject->scene, subject->modes, &runner->rod, error);
    return status == AD_OK ? find_tips(runner->rod, truth, runner->tips, error) : status;
}

static double part_outside(const one_step *model, const excitation_rollouts *truth)
{
    double outside = 0, all = 0;
    for (int i = 0; i < truth->count && model->outside; i++) {
        for (int k = 0; k < truth->done[i]; k++) {
            outside += !(model->outside(model->context, truth_state(truth, i, k),
                                        truth_input(truth, i, k)) <= 1);
            all++;
        }
    }
    return model->outside && all > 0 ? outside / all : NAN;
}

static void judge_model(rollouts_runner *runner, rollouts_report *report)
{
    const one_step *model = runner->subject->model;
    rollouts_row *row = &report->rows[ROLLOUTS_MODEL];
    row->name = runner->subject->name;
    row->states = model->states;
    report->outside = part_outside(model, runner->truth);
    one_steps(runner, model, runner->truth->steps, row);
    rollouts(runner, model, report->steps, row);
}

static void begin(const rollouts_subject *subject, int count, rollouts_report *report)
{
    const double h = subject->model->step;
    const int steps = (int)ceil(fmin(SHORT_SECONDS / h, 1e6) - 1e-9);
    *report = (rollouts_report){.count = count,
                                .steps = {1, steps, steps > LONG_STEPS ? steps : LONG_STEPS},
                                .step = h,
                                .length = scene_length(subject->scene)};
    for (int r = 0; r < ROLLOUTS_ROWS; r++) {
        rollouts_row *row = &report->rows[r];
        row->alone = row->together = row->jacobian = NAN;
        for (int k = 0; k < 2 * ROLLOUTS_SPANS; k++) {
            row->error[k / 2][k % 2] = NAN;
        }
    }
}

ad_status rollouts_judge(const rollouts_subject *subject, int count, uint64_t seed, ad_pool *pool,
                         rollouts_report *report, ad_error *error)
{
    excitation_settings settings = excitation_settings_default();
    excitation_rollouts truth = {0};
    rollouts_runner x = {0};
    begin(subject, count, report);
    memcpy(settings.modes, subject->modes, sizeof settings.modes);
    settings.step = report->step;
    settings.steps = report->steps[ROLLOUTS_LONG];
    settings.count = count;
    settings.first = FRESH;
    settings.seed = seed;
    settings.linear = subject->linear;
    settings.constant = subject->constant;
    ad_status status = excitation_run(subject->scene, &settings, pool, &truth, error);
    status = status == AD_OK ? prepare(subject, &truth, &x, report, error) : status;
    if (status == AD_OK) {
        report->lost = truth.lost;
        report->solver = truth.seconds / ((double)count * settings.steps);
        judge_model(&x, report);
        status = rollouts_time_model(&x, subject->model, &report->rows[ROLLOUTS_MODEL], error);
    }
    status = status == AD_OK
                 ? surrogate_rest_growth(pool, x.rod, report->step, &report->growth, error)
                 : status;
    status = status == AD_OK ? over_time(&x, subject->model, report, error) : status;
    status = status == AD_OK ? rollouts_judge_rod(&x, pool, report, error) : status;
    status = status == AD_OK ? judge_finer(&x, &settings, pool, report, error) : status;
    reduced_free(x.rod);
    ad_memory_free(&x.memory);
    excitation_free(&truth);
    if (status != AD_OK) {
        rollouts_free(report);
    }
    return status;
}

void rollouts_free(rollouts_report *report)
{
    ad_memory_free(&report->memory);
    report->over_time = NULL;
    report->path = NULL;
    report->states = report->inputs = NULL;
}

bool rollouts_fail(const rollouts_report *report, double tolerance)
{
    const rollouts_row *row = &report->rows[ROLLOUTS_MODEL];
    const double *modes = report->rows[ROLLOUTS_FINER].error[ROLLOUTS_SHORT];
    return row->diverged > 0 ||
           (!isnan(tolerance) &&
            !(row->error[ROLLOUTS_SHORT][ROLLOUTS_WORST] + modes[ROLLOUTS_WORST] <= tolerance));
}
