#include "tools/control/regulator.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

struct regulator {
    estimator *filter;
    controller *plan[REGULATOR_TURNS_MAX];
    one_step model;              /* of the filter */
    one_observation observation; /* of the controller */
    double period;               /* s, of a sample */
    const int *inputs;           /* [controlled] */
    int controlled, turns, turn, delay;
    int flags;                 /* of the prediction, for the next answer */
    bool has_plan, has_inputs; /* to be prepared, to be predicted with */
    bool has_first;
    bool late;                   /* there is no time to prepare, either */
    const double *rate;          /* [controlled], NULL: any */
    const double *lower, *upper; /* [controlled] */
    const double *deviation;     /* [model.states] */
    double *acting;              /* [delay + 1][controlled] from the present sample on */
    double *given;               /* [model.inputs] */
    double *ahead;               /* [2][model.states] */
    double *first;               /* of the first regulator_start: [states], [model.inputs], and */
    double *by_parameters;       /* [states][parameters] */
    double *margin, *by;         /* [values], [values][1 + states]; where the model doubts */
    int parameters, lost;        /* lost: samples since when the filter is */
    int cycle;                   /* samples after which all sensors are due again */
};

/* All parts of the memory begin as aligned as it does. */
enum { PART = 64 };

static size_t padded(size_t bytes)
{
    return (bytes + PART - 1) / PART * PART;
}

const char *regulator_refusal(const regulator_settings *settings)
{
    const char *why = estimator_refusal(&settings->estimator);
    why = why ? why : controller_refusal(&settings->controller);
    if (why) {
        return why;
    }
    return settings->turns < 1 || settings->turns > REGULATOR_TURNS_MAX
               ? "samples in a step of the controller's model: allowed: 1 to 100"
           : settings->delay < 0 || settings->delay > REGULATOR_DELAY_MAX
               ? "the delay from a measurement to the inputs by it: allowed: 0 to 100 samples"
           : settings->controller.delay != (settings->turns > 1 ? 0 : settings->delay)
               ? "the controller has another delay"
               : NULL;
}

/* Values that may be kept off their limits by what is not known of them. */
static size_t margins_of(const regulator_settings *settings)
{
    const controller_settings *c = &settings->controller;
    const bool limits = c->soft_lower || c->soft_upper;
    return limits && settings->estimator.model.doubts > 0 ? (size_t)c->observation.values : 0;
}

static size_t numbers_of(const regulator_settings *settings)
{
    const one_step *model = &settings->estimator.model;
    return (size_t)(settings->delay + 1) * settings->controller.controlled +
           2 * (size_t)model->inputs +
           (size_t)(3 + settings->estimator.parameters) * model->states +
           margins_of(settings) * (size_t)(2 + model->states);
}

size_t regulator_size(const regulator_settings *settings)
{
    return padded(sizeof(regulator)) + padded(numbers_of(settings) * sizeof(double)) +
           padded(estimator_size(&settings->estimator)) +
           (size_t)settings->turns * padded(controller_size(&settings->controller));
}

/* The least common multiple of the sensors' samples. */
static int cycle_of(const estimator_settings *of)
{
    int cycle = 1;
    for (int i = 0; i < of->sensors; i++) {
        const int every = of->sensor[i].every > 0 ? of->sensor[i].every : 1;
        int all = cycle;
        while (all % every != 0 && all < REGULATOR_CYCLE_MAX) {
            all += cycle;
        }
        cycle = all;
    }
    return cycle;
}

regulator *regulator_init(void *memory, const regulator_settings *settings)
{
    const controller_settings *c = &settings->controller;
    char *at = memory;
    regulator *regulator = memory;
    if (regulator_refusal(settings)) {
        return NULL;
    }
    memset(regulator, 0, sizeof *regulator);
    regulator->model = settings->estimator.model;
    regulator->period =
        settings->estimator.period > 0 ? settings->estimator.period : regulator->model.step;
    regulator->inputs = c->inputs;
    regulator->controlled = c->controlled;
    regulator->turns = settings->turns;
    regulator->delay = settings->delay;
    at += padded(sizeof *regulator);
    regulator->acting = (double *)(void *)at;
    regulator->given = regulator->acting + (regulator->delay + 1) * regulator->controlled;
    regulator->ahead = regulator->given + regulator->model.inputs;
    regulator->first = regulator->ahead + 2 * regulator->model.states;
    regulator->by_parameters = regulator->first + regulator->model.states + regulator->model.inputs;
    regulator->parameters = settings->estimator.parameters;
    if (margins_of(settings) > 0) {
        regulator->observation = c->observation;
        regulator->margin =
            regulator->by_parameters + (size_t)regulator->parameters * regulator->model.states;
        regulator->by = regulator->margin + c->observation.values;
    }
    regulator->cycle = cycle_of(&settings->estimator);
    at += padded(numbers_of(settings) * sizeof(double));
    regulator->filter = estimator_init(at, &settings->estimator);
    at += padded(estimator_size(&settings->estimator));
    for (int i = 0; i < regulator->turns; i++) {
        regulator->plan[i] = controller_init(at, c);
        at += padded(controller_size(c));
    }
    regulator->rate = settings->rate;
    regulator->lower = c->lower;
    regulator->upper = c->upper;
    regulator->deviation = settings->estimator.deviation;
    return regulator;
}

/* Whether a robot may have been given it: a model answers it, but what follows is nothing to learn
 * from. */
static bool may_act(const regulator *regulator, int k, double input)
{
    return fabs(input - regulator->lower[k]) <=
           REGULATOR_FAR * (regulator->upper[k] - regulator->lower[k]);
}

int regulator_start(regulator *regulator, const double *state, const double *inputs,
                    const double *by_parameters)
{
    bool good = true;
    for (int k = 0; k < regulator->controlled; k++) {
        good &= may_act(regulator, k, inputs[regulator->inputs[k]]);
    }
    if (!good || estimator_start(regulator->filter, state, inputs, by_parameters) != 0) {
        return ESTIMATOR_BAD_START;
    }
    for (int i = 0; i < (regulator->delay + 1) * regulator->controlled; i++) {
        regulator->acting[i] = inputs[regulator->inputs[i % regulator->controlled]];
    }
    const size_t n = (size_t)regulator->model.states, count = n * (size_t)regulator->parameters;
    if (!regulator->has_first) {
        memcpy(regulator->first, state, n * sizeof *regulator->first);
        memcpy(regulator->first + n, inputs,
               (size_t)regulator->model.inputs * sizeof *regulator->first);
        memset(regulator->by_parameters, 0, count * sizeof *regulator->by_parameters);
        if (by_parameters) {
            memcpy(regulator->by_parameters, by_parameters,
                   count * sizeof *regulator->by_parameters);
        }
        regulator->has_first = true;
    }
    for (int i = 0; i < regulator->turns; i++) {
        controller_start(regulator->plan[i], regulator->acting);
    }
    regulator->lost = 0;
    regulator->has_plan = regulator->has_inputs = regulator->late = false;
    regulator->turn = regulator->flags = 0;
    return 0;
}

int regulator_measure(regulator *regulator, int sensor, int age, const double *values)
{
    regulator_prepare(regulator);
    return estimator_measure(regulator->filter, sensor, age, values);
}

/* Whether the filter is where no robot can be: its model, which answers all the same, would need
 * long to come back from there. */
static bool is_far(const regulator *regulator)
{
    const double *state = estimator_state(regulator->filter);
    bool far = false;
    for (int i = 0; i < regulator->model.states && regulator->has_first; i++) {
        far |= fabs(state[i] - regulator->first[i]) > REGULATOR_FAR * regulator->deviation[i];
    }
    return far;
}

/* A network says nothing of where it was not trained. A filter that is there, and whose
 * measurements contradict it, does not come back by itself. */
static int find_again(regulator *regulator, int flags)
{
    enum { LOST = ESTIMATOR_OUTLIER | ESTIMATOR_INFLATED | ESTIMATOR_NO_ANSWER };
    const bool lost = (flags & ESTIMATOR_OUTSIDE) && (flags & LOST);
    regulator->lost = lost || is_far(regulator) ? regulator->lost + 1 : 0;
    if (regulator->lost < REGULATOR_LOST ||
        estimator_sample(regulator->filter) % regulator->cycle != 0) {
        return flags;
    }
    regulator->lost = 0;
    estimator_start(regulator->filter, regulator->first, regulator->first + regulator->model.states,
                    regulator->by_parameters);
    for (int i = 0; i < regulator->turns; i++) {
        controller_forget(regulator->plan[i]);
    }
    return flags | REGULATOR_AGAIN;
}

int regulator_filter(regulator *regulator)
{
    regulator_prepare(regulator);
    const int flags = regulator->flags;
    regulator->flags = 0;
    return find_again(regulator, flags | estimator_update(regulator->filter));
}

/* All inputs of the model with those that act `later` samples on. */
static const double *inputs_at(regulator *regulator, int later)
{
    memcpy(regulator->given, estimator_inputs(regulator->filter),
           (size_t)regulator->model.inputs * sizeof *regulator->given);
    for (int k = 0; k < regulator->controlled; k++) {
        regulator->given[regulator->inputs[k]] =
            regulator->acting[later * regulator->controlled + k];
    }
    return regulator->given;
}

/* The state when the answer acts, by the filter's model; NULL: it has no answer. */
static const double *state_ahead(regulator *regulator)
{
    double *now = regulator->ahead, *next = now + regulator->model.states;
    memcpy(now, estimator_state(regulator->filter), (size_t)regulator->model.states * sizeof *now);
    for (int i = 0; i < regulator->delay && regulator->turns > 1; i++) {
        const double *inputs = inputs_at(regulator, i);
        if (regulator->model.advance(regulator->model.context, 1, regulator->period, now, inputs,
                                     NULL, next, NULL, NULL)) {
            return NULL;
        }
        memcpy(now, next, (size_t)regulator->model.states * sizeof *now);
    }
    return now;
}

/* Where the answer goes, and what was answered before. */
static double *answer_of(const regulator *regulator, const double **before)
{
    double *to = regulator->acting + regulator->delay * regulator->controlled;
    *before = regulator->delay > 0 ? to - regulator->controlled : to;
    return to;
}

static void answer(regulator *regulator, double *inputs)
{
    const size_t m = (size_t)regulator->controlled;
    const double *before;
    double *to = answer_of(regulator, &before);
    for (size_t k = 0; k < m; k++) { /* one plan is followed by another, or by what was applied */
        const double rate = regulator->rate ? regulator->rate[k] : INFINITY;
        inputs[k] = fmin(fmax(inputs[k], before[k] - rate), before[k] + rate);
        inputs[k] = fmin(fmax(inputs[k], regulator->lower[k]), regulator->upper[k]);
    }
    memcpy(to, inputs, m * sizeof *to);
    regulator->has_plan = regulator->has_inputs = true;
}

/* Limits are kept off by two deviations of what is seen, 95 %, as the filter knows them. NULL: they
 * are not known, or the model does not doubt itself. */
static const double *margin_of(regulator *regulator)
{
    enum { DEVIATIONS = 2 };
    const one_observation *seen = &regulator->observation;
    double *by = regulator->by + seen->values;
    if (!regulator->margin ||
        seen->see(seen->context, 1, estimator_state(regulator->filter),
                  estimator_inputs(regulator->filter), regulator->by, by) != 0) {
        return NULL;
    }
    for (int k = 0; k < seen->values; k++) {
        regulator->margin[k] =
            DEVIATIONS * estimator_deviation_along(regulator->filter, by + k * seen->states);
    }
    return regulator->margin;
}

int regulator_plan(regulator *regulator, const double *reference, double *inputs)
{
    const controller_sample now = {.state = state_ahead(regulator),
                                   .others = estimator_inputs(regulator->filter),
                                   .reference = reference,
                                   .margin = margin_of(regulator)};
    const int flags = controller_feedback(regulator->plan[regulator->turn], &now, inputs);
    answer(regulator, inputs);
    return flags << REGULATOR_CONTROLLER;
}

int regulator_control(regulator *regulator, const double *reference, double *inputs)
{
    const int flags = regulator_filter(regulator);
    return flags | regulator_plan(regulator, reference, inputs);
}

int regulator_late(regulator *regulator, bool held, double *inputs)
{
    controller *plan = regulator->plan[regulator->turn];
    const double *before;
    (void)answer_of(regulator, &before);
    memcpy(inputs, held ? before : controller_plan(plan),
           (size_t)regulator->controlled * sizeof *inputs);
    controller_skip(plan, 1);
    answer(regulator, inputs);
    controller_applied(plan, 0, inputs);
    regulator->late = true;
    return REGULATOR_LATE;
}

void regulator_predict(regulator *regulator)
{
    const size_t kept = (size_t)regulator->delay * regulator->controlled;
    if (regulator->has_inputs) {
        regulator->flags = estimator_predict(regulator->filter, inputs_at(regulator, 0), NULL);
        memmove(regulator->acting, regulator->acting + regulator->controlled,
                kept * sizeof *regulator->acting);
        regulator->has_inputs = false;
    }
}

void regulator_prepare(regulator *regulator)
{
    if (regulator->has_plan) {
        if (!regulator->late) {
            controller_prepare(regulator->plan[regulator->turn]);
        }
        regulator->turn = (regulator->turn + 1) % regulator->turns;
        regulator->has_plan = regulator->late = false;
    }
    regulator_predict(regulator);
}

void regulator_applied(regulator *regulator, const double *inputs)
{
    for (int k = 0; k < regulator->controlled; k++) {
        if (!may_act(regulator, k, inputs[k])) {
            return;
        }
    }
    memcpy(regulator->acting, inputs, (size_t)regulator->controlled * sizeof *inputs);
    if (regulator->turns == 1) {
        controller_applied(regulator->plan[0], regulator->delay, inputs);
    }
}

estimator *regulator_estimator(const regulator *regulator)
{
    return regulator->filter;
}

controller *regulator_controller(const regulator *regulator)
{
    return regulator->plan[regulator->turn];
}
