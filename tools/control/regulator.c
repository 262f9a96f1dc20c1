#include "tools/control/regulator.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

struct regulator {
    estimator *filter;
    controller *plan[REGULATOR_TURNS_MAX];
    one_step model;    /* of the filter */
    double period;     /* s, of a sample */
    const int *inputs; /* [controlled] */
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

static size_t numbers_of(const regulator_settings *settings)
{
    const one_step *model = &settings->estimator.model;
    return (size_t)(settings->delay + 1) * settings->controller.controlled +
           2 * (size_t)model->inputs + (size_t)(3 + settings->estimator.parameters) * model->states;
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
    regulator *x = memory;
    if (regulator_refusal(settings)) {
        return NULL;
    }
    memset(x, 0, sizeof *x);
    x->model = settings->estimator.model;
    x->period = settings->estimator.period > 0 ? settings->estimator.period : x->model.step;
    x->inputs = c->inputs;
    x->controlled = c->controlled;
    x->turns = settings->turns;
    x->delay = settings->delay;
    at += padded(sizeof *x);
    x->acting = (double *)(void *)at;
    x->given = x->acting + (x->delay + 1) * x->controlled;
    x->ahead = x->given + x->model.inputs;
    x->first = x->ahead + 2 * x->model.states;
    x->by_parameters = x->first + x->model.states + x->model.inputs;
    x->parameters = settings->estimator.parameters;
    x->cycle = cycle_of(&settings->estimator);
    at += padded(numbers_of(settings) * sizeof(double));
    x->filter = estimator_init(at, &settings->estimator);
    at += padded(estimator_size(&settings->estimator));
    for (int i = 0; i < x->turns; i++) {
        x->plan[i] = controller_init(at, c);
        at += padded(controller_size(c));
    }
    x->rate = settings->rate;
    x->lower = c->lower;
    x->upper = c->upper;
    x->deviation = settings->estimator.deviation;
    return x;
}

/* Whether a robot may have been given it: a model answers it, but what follows is nothing to learn
 * from. */
static bool may_act(const regulator *x, int k, double input)
{
    return fabs(input - x->lower[k]) <= REGULATOR_FAR * (x->upper[k] - x->lower[k]);
}

int regulator_start(regulator *x, const double *state, const double *inputs,
                    const double *by_parameters)
{
    bool good = true;
    for (int k = 0; k < x->controlled; k++) {
        good &= may_act(x, k, inputs[x->inputs[k]]);
    }
    if (!good || estimator_start(x->filter, state, inputs, by_parameters) != 0) {
        return ESTIMATOR_BAD_START;
    }
    for (int i = 0; i < (x->delay + 1) * x->controlled; i++) {
        x->acting[i] = inputs[x->inputs[i % x->controlled]];
    }
    const size_t n = (size_t)x->model.states, count = n * (size_t)x->parameters;
    if (!x->has_first) {
        memcpy(x->first, state, n * sizeof *x->first);
        memcpy(x->first + n, inputs, (size_t)x->model.inputs * sizeof *x->first);
        memset(x->by_parameters, 0, count * sizeof *x->by_parameters);
        if (by_parameters) {
            memcpy(x->by_parameters, by_parameters, count * sizeof *x->by_parameters);
        }
        x->has_first = true;
    }
    for (int i = 0; i < x->turns; i++) {
        controller_start(x->plan[i], x->acting);
    }
    x->lost = 0;
    x->has_plan = x->has_inputs = x->late = false;
    x->turn = x->flags = 0;
    return 0;
}

int regulator_measure(regulator *x, int sensor, int age, const double *values)
{
    regulator_prepare(x);
    return estimator_measure(x->filter, sensor, age, values);
}

/* Whether the filter is where no robot can be: its model, which answers all the same, would need
 * long to come back from there. */
static bool is_far(const regulator *x)
{
    const double *state = estimator_state(x->filter);
    bool far = false;
    for (int i = 0; i < x->model.states && x->has_first; i++) {
        far |= fabs(state[i] - x->first[i]) > REGULATOR_FAR * x->deviation[i];
    }
    return far;
}

/* A network says nothing of where it was not trained. A filter that is there, and whose
 * measurements contradict it, does not come back by itself. */
static int find_again(regulator *x, int flags)
{
    enum { LOST = ESTIMATOR_OUTLIER | ESTIMATOR_INFLATED | ESTIMATOR_NO_ANSWER };
    const bool lost = (flags & ESTIMATOR_OUTSIDE) && (flags & LOST);
    x->lost = lost || is_far(x) ? x->lost + 1 : 0;
    if (x->lost < REGULATOR_LOST || estimator_sample(x->filter) % x->cycle != 0) {
        return flags;
    }
    x->lost = 0;
    estimator_start(x->filter, x->first, x->first + x->model.states, x->by_parameters);
    for (int i = 0; i < x->turns; i++) {
        controller_forget(x->plan[i]);
    }
    return flags | REGULATOR_AGAIN;
}

int regulator_filter(regulator *x)
{
    regulator_prepare(x);
    const int flags = x->flags;
    x->flags = 0;
    return find_again(x, flags | estimator_update(x->filter));
}

/* All inputs of the model with those that act `later` samples on. */
static const double *inputs_at(regulator *x, int later)
{
    memcpy(x->given, estimator_inputs(x->filter), (size_t)x->model.inputs * sizeof *x->given);
    for (int k = 0; k < x->controlled; k++) {
        x->given[x->inputs[k]] = x->acting[later * x->controlled + k];
    }
    return x->given;
}

/* The state when the answer acts, by the filter's model; NULL: it has no answer. */
static const double *state_ahead(regulator *x)
{
    double *now = x->ahead, *next = now + x->model.states;
    memcpy(now, estimator_state(x->filter), (size_t)x->model.states * sizeof *now);
    for (int i = 0; i < x->delay && x->turns > 1; i++) {
        const double *inputs = inputs_at(x, i);
        if (x->model.advance(x->model.context, 1, x->period, now, inputs, NULL, next, NULL, NULL)) {
            return NULL;
        }
        memcpy(now, next, (size_t)x->model.states * sizeof *now);
    }
    return now;
}

/* Where the answer goes, and what was answered before. */
static double *answer_of(const regulator *x, const double **before)
{
    double *to = x->acting + x->delay * x->controlled;
    *before = x->delay > 0 ? to - x->controlled : to;
    return to;
}

static void answer(regulator *x, double *inputs)
{
    const size_t m = (size_t)x->controlled;
    const double *before;
    double *to = answer_of(x, &before);
    for (size_t k = 0; k < m; k++) { /* one plan is followed by another, or by what was applied */
        const double rate = x->rate ? x->rate[k] : INFINITY;
        inputs[k] = fmin(fmax(inputs[k], before[k] - rate), before[k] + rate);
        inputs[k] = fmin(fmax(inputs[k], x->lower[k]), x->upper[k]);
    }
    memcpy(to, inputs, m * sizeof *to);
    x->has_plan = x->has_inputs = true;
}

int regulator_plan(regulator *x, const double *reference, double *inputs)
{
    const controller_sample now = {
        .state = state_ahead(x), .others = estimator_inputs(x->filter), .reference = reference};
    const int flags = controller_feedback(x->plan[x->turn], &now, inputs);
    answer(x, inputs);
    return flags << REGULATOR_CONTROLLER;
}

int regulator_control(regulator *x, const double *reference, double *inputs)
{
    const int flags = regulator_filter(x);
    return flags | regulator_plan(x, reference, inputs);
}

int regulator_late(regulator *x, bool held, double *inputs)
{
    controller *plan = x->plan[x->turn];
    const double *before;
    (void)answer_of(x, &before);
    memcpy(inputs, held ? before : controller_plan(plan), (size_t)x->controlled * sizeof *inputs);
    controller_skip(plan, 1);
    answer(x, inputs);
    controller_applied(plan, 0, inputs);
    x->late = true;
    return REGULATOR_LATE;
}

void regulator_predict(regulator *x)
{
    const size_t kept = (size_t)x->delay * x->controlled;
    if (x->has_inputs) {
        x->flags = estimator_predict(x->filter, inputs_at(x, 0), NULL);
        memmove(x->acting, x->acting + x->controlled, kept * sizeof *x->acting);
        x->has_inputs = false;
    }
}

void regulator_prepare(regulator *x)
{
    if (x->has_plan) {
        if (!x->late) {
            controller_prepare(x->plan[x->turn]);
        }
        x->turn = (x->turn + 1) % x->turns;
        x->has_plan = x->late = false;
    }
    regulator_predict(x);
}

void regulator_applied(regulator *x, const double *inputs)
{
    for (int k = 0; k < x->controlled; k++) {
        if (!may_act(x, k, inputs[k])) {
            return;
        }
    }
    memcpy(x->acting, inputs, (size_t)x->controlled * sizeof *inputs);
    if (x->turns == 1) {
        controller_applied(x->plan[0], x->delay, inputs);
    }
}

estimator *regulator_estimator(const regulator *x)
{
    return x->filter;
}

controller *regulator_controller(const regulator *x)
{
    return x->plan[x->turn];
}
