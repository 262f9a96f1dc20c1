#include "physics/numerics/clock.h"
#include "tools/surrogate/surrogate.h"
#include "tools/surrogate/training_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Half of the steps are of long rollouts, in which motions build up, half of short ones, for more
 * values of slow parameters and more beginnings; and one is held out for so many to learn from. */
enum { LENGTHS = 2, HELD = 10 };
static const int lengths[LENGTHS] = {250, 50};

static const fit_kind one_step_model;

/* ---- preparation --------------------------------------------------------------------------- */

/* How rollouts of so many steps are drawn. */
static excitation_settings excitation_of(const surrogate_training *t, int steps, int first,
                                         int count)
{
    excitation_settings settings = excitation_settings_default();
    memcpy(settings.modes, t->settings->modes, sizeof settings.modes);
    settings.step = t->settings->step;
    settings.steps = steps;
    settings.first = first;
    settings.count = count;
    settings.seed = t->training->seed;
    settings.linear = t->settings->hold == SURROGATE_RAMP;
    for (int i = 0; i < t->open->parameter_count; i++) {
        if (surrogate_names_parameter(t->settings, t->open->parameters[i].name)) {
            settings.constant |= UINT32_C(1) << i;
        }
    }
    return settings;
}

/* The rollouts `part` (0: to learn from, 1: held out) of one length. */
static ad_status draw_one(surrogate_training *t, int length, int part, surrogate_steps *steps,
                          ad_error *error)
{
    const int learnt = (t->settings->solved / LENGTHS + length - 1) / length;
    const int first = (length == lengths[0] ? 0 : INT32_MAX / 2) + part * learnt;
    const excitation_settings settings =
        excitation_of(t, length, first, part == 0 ? learnt : (learnt + HELD - 1) / HELD);
    excitation_rollouts motions;
    ad_status status = excitation_run(t->open, &settings, t->pool, &motions, error);
    if (status == AD_OK) {
        const size_t before = steps->count;
        status = surrogate_steps_add(&motions, settings.linear, steps, error);
        if (status == AD_OK && t->settings->kind == SURROGATE_POLYNOMIAL) {
            status = surrogate_add_nodes(t, &motions, before, steps, error);
        }
        excitation_free(&motions);
    }
    return status;
}

static ad_status draw(surrogate_training *t, int part, surrogate_steps *steps, ad_error *error)
{
    ad_status status = AD_OK;
    const int wanted = part == 0 ? t->settings->solved : t->settings->solved / HELD;
    for (int i = 0; i < LENGTHS && status == AD_OK; i++) {
        status = draw_one(t, lengths[i], part, steps, error);
    }
    if (status == AD_OK && steps->count < (size_t)wanted / 2) {
        status = ad_fail(error, AD_NOT_FINITE,
                         "of %d steps of the reduced rod only %zu could be solved; allowed: ranges "
                         "of parameters within which the robot moves, or a shorter surrogate.step",
                         wanted, steps->count);
    }
    return status;
}

/* Mean of e^T Q e over steps, of the model as it is. */
static double weighted_error(surrogate_training *t, const surrogate_step *m,
                             const surrogate_steps *steps)
{
    const size_t n = (size_t)m->states, u = (size_t)m->inputs, all = m->ramps ? 2 * u : u;
    const surrogate_numbers at = surrogate_numbers_of(m, t->numbers);
    double next[SURROGATE_STATES_MAX], sum = 0;
    for (size_t i = 0; i < steps->count; i++) {
        const double *inputs = steps->input + i * all;
        surrogate_step_advance(m, t->work, 1, m->step, steps->state + i * n, inputs,
                               m->ramps ? inputs + u : NULL, next, NULL, NULL);
        for (size_t k = 0; k < n; k++) {
            next[k] = (next[k] - steps->next[i * n + k]) / at.state_scale[k];
        }
        for (size_t a = 0; a < n; a++) {
            for (size_t b = 0; b < n; b++) {
                sum += next[a] * t->gramian[a * n + b] * next[b];
            }
        }
    }
    return sum / (double)steps->count;
}

static void add_network(surrogate_training *t)
{
    const nn_mlp_settings *network = &t->training->network;
    surrogate_step *m = &t->step;
    m->layers = t->settings->kind == SURROGATE_LINEAR ? 0 : network->hidden_count;
    for (int i = 0; i < m->layers; i++) {
        m->width[i] = network->hidden[i];
        m->width[i] += m->mirrors && m->width[i] % 2; /* units come in pairs */
    }
}

static ad_status find_model(surrogate_training *t, reduced_rod *rod, ad_error *error)
{
    double *numbers = NULL;
    ad_status status = surrogate_find_symmetry(rod, t->settings, t->open, &t->steps, &t->step,
                                               &t->numbers, t->info.frame, error);
    if (status == AD_OK) {
        status = surrogate_fit_linear(t->pool, &t->step, t->numbers, &t->steps, error);
    }
    const size_t n = (size_t)t->step.states;
    t->gramian = calloc(n * n, sizeof *t->gramian);
    if (status == AD_OK) {
        status = t->gramian
                     ? surrogate_gramian(t->pool, &t->step, rod, &t->steps, t->gramian, error)
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    if (status != AD_OK) {
        return status;
    }
    add_network(t);
    const size_t nodes = t->settings->kind == SURROGATE_POLYNOMIAL ? SURROGATE_NODES : 1;
    numbers = realloc(t->numbers, nodes * surrogate_step_numbers(&t->step) * sizeof *numbers);
    t->numbers = numbers ? numbers : t->numbers;
    t->step.numbers = t->numbers;
    t->work = calloc(surrogate_step_work(&t->step), sizeof *t->work);
    if (!numbers || !t->work) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    surrogate_step linear = t->step;
    linear.layers = 0;
    t->held_linear = weighted_error(t, &linear, &t->held);
    return nodes > 1 ? surrogate_find_inner(t, error) : AD_OK;
}

static ad_status start(void *of, ad_error *error)
{
    surrogate_training *t = of;
    const train_stage *stage = &t->training->stages[t->fit.at.stage];
    const char *why;
    const optim_settings settings = optim_settings_own(&stage->optim);
    optim_free(t->optimizer);
    t->optimizer = t->fit.by = optim_create(t->info.parameters, t->start, &settings, &why);
    return t->optimizer ? AD_OK : ad_fail(error, AD_NO_MEMORY, "training.stages: %s", why);
}

static ad_status prepare(surrogate_training *t, ad_error *error)
{
    const double length = scene_length(t->open);
    const reduced_settings reduced = {.modes = {t->settings->modes[0], t->settings->modes[1],
                                                t->settings->modes[2], t->settings->modes[3]},
                                      .count = 1,
                                      .s = &length};
    reduced_rod *rod = NULL;
    ad_status status = reduced_create(t->open, &reduced, &rod, error);
    if (status == AD_OK && reduced_states(rod) > SURROGATE_STATES_MAX) {
        status = ad_fail(error, AD_BAD_INPUT, "%d states of the reduced rod; allowed: up to %d",
                         reduced_states(rod), SURROGATE_STATES_MAX);
    }
    status = status == AD_OK ? draw(t, 0, &t->steps, error) : status;
    status = status == AD_OK ? draw(t, 1, &t->held, error) : status;
    status = status == AD_OK ? find_model(t, rod, error) : status;
    reduced_free(rod);
    t->info.solved = t->steps.count;
    if (status != AD_OK || t->step.layers == 0) {
        t->fit.state = FIT_OVER;
        t->fit.loss = t->fit.held_out = 1;
        return status;
    }
    surrogate_node nodes[SURROGATE_NODES] = {{&t->step, t->steps.next}};
    for (int i = 0; i < SURROGATE_INNER; i++) {
        nodes[i + 1] = (surrogate_node){&t->inner[i], t->steps.inner[i]};
    }
    status = surrogate_flow_create(t->settings->kind == SURROGATE_POLYNOMIAL ? SURROGATE_NODES : 1,
                                   nodes, &t->steps, t->gramian, t->pool, &t->flow, error);
    if (status != AD_OK) {
        return status;
    }
    t->info.parameters = surrogate_flow_parameters(t->flow);
    t->start = malloc((t->info.parameters + 1) * sizeof *t->start);
    if (!t->start) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    surrogate_flow_start(t->flow, t->training->seed, t->start);
    return fit_start(&t->fit, error);
}

ad_status surrogate_training_create(const scene *open, surrogate_settings *settings,
                                    const train_settings *training, ad_pool *pool,
                                    surrogate_training **result, ad_error *error)
{
    static const char *const names[] = {"step",     "stage",         "seconds",    "loss",
                                        "held_out", "gradient_norm", "evaluations"};
    *result = NULL;
    if (open->memory_count > 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "a trained one-step model does not take plays and lags of inputs; allowed: "
                       "control.model: reduced, which takes them");
    }
    if (scene_has_branch(open)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "a trained one-step model does not take material.maxwell; allowed: "
                       "control.model: reduced, which takes it");
    }
    surrogate_training *t = calloc(1, sizeof *t);
    if (!t) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    const double before = clock_seconds(CLOCK_MONOTONIC);
    t->open = open;
    t->settings = settings;
    t->training = training;
    t->pool = pool;
    t->fit = fit_of(training, ad_pool_ranks(pool), &one_step_model, t);
    t->fit.text_item = "scene/yaml";
    t->fit.rows.columns = (int)(sizeof names / sizeof *names);
    memcpy(t->fit.rows.names, names, sizeof names);
    ad_status status =
        surrogate_choose_modes(open, settings, pool, training->seed, t->info.modes, error);
    status = status == AD_OK ? prepare(t, error) : status;
    t->info.prepared = clock_seconds(CLOCK_MONOTONIC) - before;
    t->fit.started = clock_seconds(CLOCK_MONOTONIC);
    if (status != AD_OK) {
        surrogate_training_free(t);
        return status;
    }
    *result = t;
    return AD_OK;
}

void surrogate_training_free(surrogate_training *t)
{
    if (t) {
        surrogate_flow_free(t->flow);
        surrogate_steps_free(&t->steps);
        surrogate_steps_free(&t->held);
        optim_free(t->optimizer);
        fit_free(&t->fit);
        free(t->numbers);
        free(t->gramian);
        free(t->work);
        free(t->start);
        free(t);
    }
}

/* ---- steps --------------------------------------------------------------------------------- */

const surrogate_step *surrogate_training_step_of(surrogate_training *t)
{
    if (!t->flow) {
        return &t->step;
    }
    const double *best = t->optimizer ? optim_best_x(t->optimizer) : t->start;
    double *networks[SURROGATE_NODES];
    const size_t nodes = t->settings->kind == SURROGATE_POLYNOMIAL ? SURROGATE_NODES : 1;
    for (size_t i = 0; i < nodes; i++) {
        networks[i] = t->numbers + (i + 1) * surrogate_step_numbers(&t->step) -
                      surrogate_step_parameters(&t->step);
    }
    return surrogate_flow_finish(t->flow, best, networks) ? &t->step : NULL;
}

static ad_status row(void *of, ad_error *error)
{
    surrogate_training *t = of;
    fit *f = &t->fit;
    const surrogate_step *m = surrogate_training_step_of(t);
    f->held_out = m ? weighted_error(t, m, &t->held) / t->held_linear : NAN;
    const double row[] = {(double)f->at.step,
                          f->at.stage + 1,
                          fit_seconds(f),
                          f->loss,
                          f->held_out,
                          f->gradient_norm,
                          (double)optim_inspect(t->optimizer).evaluations};
    return history_add(&f->rows, row, error);
}

static double trained_loss(const void *of, size_t row)
{
    return history_value(&((const surrogate_training *)of)->fit.rows, row, "loss");
}

static ad_status step(void *of, optim_status *outcome, bool *taken, ad_error *error)
{
    surrogate_training *t = of;
    const fit_place *at = &t->fit.at;
    const optim_target target = {.objective = surrogate_flow_evaluate, .context = t->flow};
    (void)taken;
    *outcome = optim_step(t->optimizer, &target);
    return *outcome == OPTIM_NOT_FINITE || *outcome == OPTIM_NO_FINITE_STEP ||
                   *outcome == OPTIM_UNBOUNDED || *outcome == OPTIM_STOPPED_BY_OBJECTIVE
               ? ad_fail(error, AD_NOT_FINITE, "step %lld of stage %d: %s %s",
                         (long long)at->step + 1, at->stage + 1, optim_status_text(*outcome),
                         optim_advice(t->training->stages[at->stage].optim.method))
               : AD_OK;
}

static ad_status end(void *of, optim_status status, bool *again, ad_error *error)
{
    surrogate_training *t = of;
    (void)status, (void)again, (void)error;
    memcpy(t->start, optim_best_x(t->optimizer), t->info.parameters * sizeof *t->start);
    return AD_OK;
}

static const fit_kind one_step_model = {.start = start,
                                        .step = step,
                                        .row = row,
                                        .trained = trained_loss,
                                        .end = end,
                                        .put = surrogate_training_put,
                                        .get = surrogate_training_get};

const surrogate_training_info *surrogate_training_inspect(const surrogate_training *t)
{
    return &t->info;
}

fit *surrogate_training_fit(surrogate_training *t)
{
    return &t->fit;
}
