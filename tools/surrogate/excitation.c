#include "tools/surrogate/excitation.h"

#include "autodiff/ranks.h"
#include "nn/rng.h"
#include "physics/chain/reduced.h"
#include "physics/numerics/clock.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

excitation_settings excitation_settings_default(void)
{
    return (excitation_settings){.count = 1, .only = -1, .seed = 1};
}

/* ---- inputs -------------------------------------------------------------------------------- */

/* How one input moves: fractions of its range, stretch by stretch. */
typedef struct course {
    nn_rng random;
    excitation_kind kind;
    double shortest, longest; /* s */
    double begin, end;        /* s, of this stretch */
    double from, to;          /* levels */
    double first, last;       /* 1/s, frequencies of a chirp */
} course;

/* Ends of the range are where actuators stay: one level in five is one of them. */
static double draw_level(nn_rng *random, bool ends)
{
    const double u = nn_rng_uniform(random), which = nn_rng_uniform(random);
    return ends || u < 0.2 ? (which < 0.5 ? 0 : 1) : which;
}

static double draw_log(nn_rng *random, double low, double high)
{
    return low * pow(high / low, nn_rng_uniform(random));
}

static void next_stretch(course *c)
{
    c->begin = c->end;
    c->from = c->to;
    c->to = draw_level(&c->random, c->kind == EXCITATION_BANG);
    c->end += draw_log(&c->random, c->shortest, c->longest);
    if (c->kind == EXCITATION_CHIRPS) { /* sweeps last longer than one period */
        c->end = c->begin + c->longest * (1 + nn_rng_uniform(&c->random));
        c->from = draw_level(&c->random, false);
        c->first = 0.5 / draw_log(&c->random, c->shortest, c->longest);
        c->last = 0.5 / draw_log(&c->random, c->shortest, c->longest);
    }
}

/* The fraction at t, which does not go back. */
static double fraction_at(course *c, double t)
{
    const double pi = 3.14159265358979323846;
    while (t >= c->end) {
        next_stretch(c);
    }
    const double part = (t - c->begin) / (c->end - c->begin);
    if (c->kind == EXCITATION_RAMPS) {
        return c->from + part * (c->to - c->from);
    }
    if (c->kind == EXCITATION_CHIRPS) {
        const double turns = (t - c->begin) * (c->first + 0.5 * part * (c->last - c->first));
        return 0.5 * (c->from + c->to) + 0.5 * (c->to - c->from) * cos(2 * pi * turns);
    }
    return c->to;
}

void excitation_draw(int count, const scene_parameter *parameters,
                     const excitation_settings *settings, int index, double *inputs)
{
    const double h = settings->step;
    for (int i = 0; i < count; i++) {
        char stream[64];
        snprintf(stream, sizeof stream, "excitation %d input %d", index, i);
        nn_rng random = nn_rng_split(settings->seed, stream);
        course c = {.kind = (excitation_kind)(settings->only >= 0 ? settings->only
                                                                  : index % EXCITATION_KIND_COUNT),
                    .shortest = settings->shortest > 0 ? settings->shortest : h,
                    .longest = settings->longest > 0 ? settings->longest : 50 * h};
        if (c.kind == EXCITATION_MIXED) {
            c.kind = (excitation_kind)nn_rng_below(&random, EXCITATION_MIXED);
        }
        const bool constant = settings->constant >> i & 1;
        const double level = nn_rng_uniform(&random);
        c.random = random;
        c.to = draw_level(&c.random, c.kind == EXCITATION_BANG);
        for (int k = 0; k <= settings->steps; k++) {
            const double fraction = constant ? level : fraction_at(&c, k * h);
            const double value = scene_parameter_at(&parameters[i], fraction);
            inputs[k * count + i] = fmin(fmax(value, parameters[i].low), parameters[i].high);
        }
    }
}

/* ---- motions ------------------------------------------------------------------------------- */

typedef struct runner {
    const excitation_settings *settings;
    const scene *open;
    excitation_rollouts *to;
    reduced_rod **rods; /* [threads] */
    long *tally;        /* [count][2] */
    double *seconds;    /* [count] */
    ad_memory memory;
} runner;

/* One step as `parts`, with inputs [2][inputs] of its ends. The first are short: where inputs jump
 * the rod is fastest. A soft arm whose inputs jump for 5 s is off by 0.14 % of its length with one
 * part, by 6e-4 % with four, or 6e-3 % if they are equal. */
static ad_status step_in_parts(const runner *runner, reduced_rod *rod, int parts, double t,
                               const double *state, const double *inputs, double *next,
                               ad_error *error)
{
    const int count = runner->to->inputs;
    const double h = runner->settings->step;
    double ends[2][SCENE_PARAMETERS_MAX];
    ad_status status = AD_OK;
    for (int p = 0; p < parts && status == AD_OK; p++) {
        const double begin = (double)(p * p) / (parts * parts);
        const double end = (double)((p + 1) * (p + 1)) / (parts * parts);
        for (int i = 0; i < count; i++) {
            const double change = runner->settings->linear ? inputs[count + i] - inputs[i] : 0;
            ends[0][i] = inputs[i] + change * begin;
            ends[1][i] = inputs[i] + change * end;
        }
        status = reduced_step_linear(rod, t + begin * h, (end - begin) * h, p == 0 ? state : next,
                                     ends[0], ends[1], next, NULL, NULL, error);
    }
    return status;
}

static ad_status run_rollout(void *context, int item, int thread, ad_error *error)
{
    enum { USUAL = 4, MOST = 256 };
    runner *runner = context;
    excitation_rollouts *to = runner->to;
    reduced_rod *rod = runner->rods[thread];
    const excitation_settings *settings = runner->settings;
    const size_t rows = (size_t)settings->steps + 1;
    double *state = to->state + (size_t)item * rows * (size_t)to->states;
    double *input = to->input + (size_t)item * rows * (size_t)to->inputs;
    const double began = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
    const int index = settings->first + item;
    ad_error unsettled;
    excitation_draw(to->inputs, runner->open->parameters, settings, index, input);
    ad_status status = reduced_initial(rod, input, state, error);
    if (status != AD_OK) {
        return status;
    }
    if (index % 4 != 3) { /* leaves the state where it finds none */
        (void)reduced_settle(rod, 0, input, state, &unsettled);
    }
    for (int k = 0; k < settings->steps && status == AD_OK; k++) {
        const double *from = state + k * to->states;
        status = AD_NOT_FINITE;
        for (int parts = USUAL; parts <= MOST && status == AD_NOT_FINITE; parts *= 2) {
            status = step_in_parts(runner, rod, parts, k * settings->step, from,
                                   input + k * to->inputs, state + (k + 1) * to->states, error);
            runner->tally[2 * item] += status == AD_OK && parts > USUAL;
        }
        to->done[item] += status == AD_OK;
        runner->tally[2 * item + 1] += status == AD_NOT_FINITE;
    }
    runner->seconds[item] = clock_seconds(CLOCK_THREAD_CPUTIME_ID) - began;
    return status == AD_NOT_FINITE ? AD_OK : status; /* this rollout is over */
}

static ad_status check(const scene *open, const excitation_settings *settings, ad_error *error)
{
    const bool spans = settings->shortest <= 0 || settings->longest <= 0 ||
                       settings->shortest <= settings->longest;
    if (!(settings->step > 0) || settings->steps < 1 || settings->count < 1 ||
        settings->first < 0 || settings->only >= EXCITATION_KIND_COUNT || !spans) {
        return ad_fail(
            error, AD_BAD_ARGUMENT,
            "rollouts: %d of %d steps of %g s, levels of %g to %g s; allowed: from 1 on, "
            "> 0, the shorter first",
            settings->count, settings->steps, settings->step, settings->shortest,
            settings->longest);
    }
    if (open->parameter_count == 0) {
        return ad_fail(error, AD_BAD_INPUT, "the scene has no parameters with a range: no inputs");
    }
    return AD_OK;
}

static ad_status allocate(runner *runner, ad_error *error)
{
    excitation_rollouts *to = runner->to;
    const size_t count = (size_t)to->count, rows = count * (size_t)(to->steps + 1);
    AD_TAKE(to, state, rows * (size_t)to->states);
    AD_TAKE(to, input, rows * (size_t)to->inputs);
    AD_TAKE(to, done, count);
    AD_TAKE(runner, tally, 2 * count);
    AD_TAKE(runner, seconds, count);
    return !to->memory.is_short && !runner->memory.is_short
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for %d rollouts", to->count);
}

static ad_status run_rollouts(runner *runner, ad_pool *pool, ad_error *error)
{
    excitation_rollouts *to = runner->to;
    const size_t count = (size_t)to->count, rows = (size_t)to->steps + 1;
    const size_t states = rows * (size_t)to->states * sizeof *to->state;
    const size_t inputs = rows * (size_t)to->inputs * sizeof *to->input;
    const ad_dealt made[] = {
        {to->state, states, count * states},
        {to->input, inputs, count * inputs},
        {to->done, sizeof *to->done, count * sizeof *to->done},
        {runner->tally, 2 * sizeof *runner->tally, 2 * count * sizeof *runner->tally},
        {runner->seconds, sizeof *runner->seconds, count * sizeof *runner->seconds}};
    ad_status status =
        ad_pool_deal(pool, to->count, run_rollout, runner, sizeof made / sizeof *made, made, error);
    for (int i = 0; i < to->count; i++) {
        to->substepped += runner->tally[2 * i];
        to->lost += runner->tally[2 * i + 1];
        to->seconds += runner->seconds[i];
    }
    return status;
}

ad_status excitation_run(const scene *open, const excitation_settings *settings, ad_pool *pool,
                         excitation_rollouts *result, ad_error *error)
{
    const int threads = ad_pool_threads(pool);
    runner x = {.settings = settings, .open = open, .to = result};
    reduced_settings rod = {.newton = 1e-7};
    memcpy(rod.modes, settings->modes, sizeof rod.modes);
    *result = (excitation_rollouts){.steps = settings->steps, .count = settings->count};
    ad_status status = check(open, settings, error);
    if (!AD_TAKE(&x, rods, threads) && status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %d threads", threads);
    }
    for (int i = 0; i < threads && status == AD_OK; i++) {
        status = reduced_create(open, &rod, &x.rods[i], error);
    }
    if (status == AD_OK) {
        result->states = reduced_states(x.rods[0]);
        result->inputs = reduced_inputs(x.rods[0]);
        status = allocate(&x, error);
    }
    status = status == AD_OK ? run_rollouts(&x, pool, error) : status;
    for (int i = 0; x.rods && i < threads; i++) {
        reduced_free(x.rods[i]);
    }
    ad_memory_free(&x.memory);
    if (status != AD_OK) {
        excitation_free(result);
    }
    return status;
}

void excitation_free(excitation_rollouts *rollouts)
{
    ad_memory_free(&rollouts->memory);
    *rollouts = (excitation_rollouts){0};
}
