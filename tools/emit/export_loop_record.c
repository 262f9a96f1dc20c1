/* What the self-test of an exported loop compares with: the loop on its own model. */
#include "tools/emit/export_loop.h"

#include "physics/numerics/vector_size.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 60, MISSING = 20, NOT_A_NUMBER = 26, WILD = 33, LATE = 40, HELD = 41 };

typedef struct recorder {
    export_loop *to;
    regulator *both;
    void *memory;
    double *states; /* [SAMPLES + 1][states] of the model that stands for the robot */
    double *acting; /* [SAMPLES + REGULATOR_DELAY_MAX + 1][controlled] */
    double *inputs, *reference, *place, *place_then;
    double *held; /* [2][states], then [inputs] */
    unsigned seed;
} recorder;

static double noise(recorder *r)
{
    r->seed = r->seed * 1664525u + 1013904223u;
    return 3.4 * ((double)r->seed / 4294967296.0 - 0.5); /* of variance 1 */
}

int export_loop_values(const export_loop *loop)
{
    int count = 0;
    for (int i = 0; i < loop->settings->estimator.sensors; i++) {
        count += loop->settings->estimator.sensor[i].observation.values;
    }
    return count;
}

static ad_status allocate(recorder *r, ad_error *error)
{
    export_loop *loop = r->to;
    const regulator_settings *s = loop->settings;
    const controller_settings *c = &s->controller;
    const size_t n = (size_t)s->estimator.model.states, v = (size_t)c->observation.values;
    const size_t m = (size_t)c->controlled, horizon = (size_t)c->horizon;
    loop->samples = SAMPLES;
    const struct {
        double **list;
        size_t count;
    } lists[] = {
        {&loop->measured, SAMPLES * (size_t)export_loop_values(loop)}, /* has all of them */
        {&loop->paths, SAMPLES * horizon * 3},
        {&loop->expected, SAMPLES * (m + (size_t)s->estimator.parameters)},
        {&loop->reached, (size_t)SAMPLES * 3},
        {&r->states, (SAMPLES + 1) * n},
        {&r->acting, (SAMPLES + REGULATOR_DELAY_MAX + 1) * m},
        {&r->inputs, (size_t)c->model.inputs},
        {&r->reference, horizon * v},
        {&r->place, v},
        {&r->place_then, v},
        {&r->held, 2 * n + (size_t)c->model.inputs}};
    size_t count = 0;
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
        count += lists[i].count;
    }
    double *at = calloc(count, sizeof *at);
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
        *lists[i].list = at;
        at = at ? at + lists[i].count : NULL;
    }
    loop->flags = calloc(SAMPLES, sizeof *loop->flags);
    r->memory = malloc(regulator_size(s));
    return loop->measured && loop->flags && r->memory
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for a self-test");
}

/* What arrives in sample k, with noise, and faults. */
static int measure(recorder *r, int k, double *to)
{
    const estimator_settings *e = &r->to->settings->estimator;
    int flags = 0;
    for (int i = 0; i < e->sensors; to += e->sensor[i++].observation.values) {
        const estimator_sensor *s = &e->sensor[i];
        const int every = s->every > 0 ? s->every : 1, taken = k - s->delay;
        const int width = s->observation.values;
        const bool due = taken >= 0 && taken % every == s->phase && k != MISSING;
        if (!due || s->observation.see(s->observation.context, 1,
                                       r->states + taken * e->model.states, r->inputs, to, NULL)) {
            to[0] = NAN;
            continue;
        }
        for (int c = 0; c < width && !s->rotations; c++) {
            to[c] += s->noise[c] * noise(r) + (k == WILD ? 1e3 * s->noise[c] : 0);
        }
        to[width - 1] = k == NOT_A_NUMBER ? NAN : to[width - 1];
        flags |= regulator_measure(r->both, i, -1, to);
    }
    return flags;
}

/* A small circle through where the place rests. */
static const double *wish(recorder *r, int k, double *path)
{
    const controller_settings *c = &r->to->settings->controller;
    const int v = c->observation.values;
    const double *place = r->place;
    const double size = 0.03 * vector_length(place);
    for (int i = 0; i < c->horizon; i++) {
        const double turn = 0.1 * (k + i);
        const double off[3] = {size * sin(turn), size * (1 - cos(turn)), 0};
        for (int j = 0; j < v; j++) {
            r->reference[i * v + j] = j < 3 ? place[j] + off[j] : NAN;
        }
        memcpy(path + 3 * i, r->reference + i * v, 3 * sizeof *path);
    }
    return r->reference;
}

/* Where an answer that is held leads the place, by the estimate and the model of the filter. */
static bool reach(recorder *r, const double *answer, double position[3])
{
    const controller_settings *c = &r->to->settings->controller;
    const one_step *model = &r->to->settings->estimator.model;
    const one_observation *place = &c->observation;
    const size_t n = (size_t)model->states;
    double *state = r->held, *next = state + n, *inputs = next + n;
    const estimator *filtered = regulator_estimator(r->both);
    memcpy(state, estimator_state(filtered), n * sizeof *state);
    memcpy(inputs, estimator_inputs(filtered), (size_t)model->inputs * sizeof *inputs);
    for (int i = 0; i < c->controlled; i++) {
        inputs[c->inputs[i]] = answer[i];
    }
    for (int i = 0; i < EXPORT_LOOP_HELD; i++) {
        if (model->advance(model->context, 1, model->step, state, inputs, NULL, next, NULL, NULL)) {
            return false;
        }
        memcpy(state, next, n * sizeof *state);
    }
    if (place->see(place->context, 1, state, inputs, r->place_then, NULL)) {
        return false;
    }
    memcpy(position, r->place_then, 3 * sizeof *position);
    return true;
}

static ad_status sample(recorder *r, int k, ad_error *error)
{
    export_loop *loop = r->to;
    const regulator_settings *s = loop->settings;
    const estimator_settings *e = &s->estimator;
    const controller_settings *c = &s->controller;
    const int n = e->model.states, m = c->controlled, known = m + e->parameters;
    double *answer = loop->expected + k * known, *acting = r->acting + k * m;
    const double period = e->period > 0 ? e->period : e->model.step;
    measure(r, k, loop->measured + k * export_loop_values(loop));
    const double *rows = wish(r, k, loop->paths + k * c->horizon * 3);
    if (k == LATE || k == HELD) { /* two in turn, which the C sees by the flag */
        loop->flags[k] = regulator_filter(r->both);
        loop->flags[k] |= regulator_late(r->both, k == HELD, answer);
    } else {
        loop->flags[k] = regulator_control(r->both, rows, answer);
    }
    memcpy(acting + s->delay * m, answer, (size_t)m * sizeof *answer);
    regulator_prepare(r->both);
    for (int i = 0; i < e->parameters; i++) {
        answer[m + i] = estimator_inputs(regulator_estimator(r->both))[e->parameter[i].input];
    }
    const bool reached = reach(r, answer, loop->reached + 3 * k);
    for (int i = 0; i < m; i++) {
        r->inputs[c->inputs[i]] = acting[i];
    }
    if (!reached || e->model.advance(e->model.context, 1, period, r->states + k * n, r->inputs,
                                     NULL, r->states + (k + 1) * n, NULL, NULL)) {
        return ad_fail(error, AD_NOT_FINITE, "the model has no answer near rest");
    }
    return AD_OK;
}

/* As the C counts it; its struct is no larger than what it has and some pointers. */
static size_t memory_of(const export_loop *loop)
{
    const regulator_settings *s = loop->settings;
    const int observations = s->estimator.sensors + loop->seen->parts;
    size_t numbers = task_observation_room(loop->seen) +
                     (size_t)(s->controller.horizon * s->controller.observation.values);
    for (int i = 0; i < observations; i++) {
        const kinematic_observation *observation =
            i < s->estimator.sensors ? loop->sensors[i] : loop->parts[i - s->estimator.sensors];
        numbers += kinematic_observation_room(&observation->rod);
    }
    for (int i = 0; i < 2; i++) {
        const export_step *m = i ? &loop->controller : &loop->filter;
        numbers += m->surrogate ? surrogate_step_work(m->surrogate) : 0;
    }
    if (loop->clearance) {
        numbers += clearance_observation_room(&loop->clearance->places);
    }
    return regulator_size(s) + numbers * sizeof(double) + sizeof *s + sizeof(task_observation) +
           (size_t)observations * sizeof(kinematic_observation) +
           (size_t)s->estimator.sensors * sizeof(estimator_sensor) + sizeof(clearance_observation) +
           512;
}

ad_status export_loop_record(export_loop *loop, ad_error *error)
{
    const regulator_settings *s = loop->settings;
    const int n = s->estimator.model.states, m = s->controller.controlled;
    recorder r = {.to = loop, .seed = 1};
    ad_status status = allocate(&r, error);
    if (status == AD_OK) {
        r.both = regulator_init(r.memory, s);
        regulator_start(r.both, loop->state, loop->inputs, loop->by_parameters);
        memcpy(r.states, loop->state, (size_t)n * sizeof *r.states);
        memcpy(r.inputs, loop->inputs, (size_t)s->estimator.model.inputs * sizeof *r.inputs);
        for (int i = 0; i < s->delay * m; i++) {
            r.acting[i] = loop->inputs[s->controller.inputs[i % m]];
        }
        const one_observation *observation = &s->controller.observation;
        observation->see(observation->context, 1, loop->state, loop->inputs, r.place, NULL);
        loop->memory = memory_of(loop);
    }
    for (int k = 0; k < SAMPLES && status == AD_OK; k++) {
        status = sample(&r, k, error);
    }
    free(r.memory);
    return status;
}

void export_loop_free(export_loop *loop)
{
    free(loop->measured);
    free(loop->flags);
}
