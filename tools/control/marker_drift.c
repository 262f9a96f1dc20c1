#include "tools/control/marker_drift.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

static int advance(void *context, int count, double h, const double *states, const double *inputs,
                   const double *after, double *next, double *by_state, double *by_inputs)
{
    const marker_drift *x = context;
    const size_t n = (size_t)x->model.states, all = n + 3 * (size_t)x->markers,
                 m = (size_t)x->model.inputs;
    const double kept = x->fade > 0 ? exp(-h / x->fade) : 1;
    int failed = by_state || by_inputs;
    for (size_t i = 0; i < (size_t)count && !failed; i++) {
        failed = x->model.advance(x->model.context, 1, h, states + i * all, inputs + i * m,
                                  after ? after + i * m : NULL, next + i * all, NULL, NULL);
        for (size_t k = n; k < all; k++) {
            next[i * all + k] = kept * states[i * all + k];
        }
    }
    return failed;
}

static double outside(void *context, const double *state, const double *inputs)
{
    const marker_drift *x = context;
    return x->model.outside ? x->model.outside(x->model.context, state, inputs) : 0;
}

/* Of the model; offsets have none. */
static int doubt(void *context, double h, const double *state, const double *inputs,
                 const double *by_state, double *memory, double *covariance)
{
    const marker_drift *x = context;
    const size_t n = (size_t)x->model.states, all = n + 3 * (size_t)x->markers;
    for (size_t i = 0; i < n * n && by_state; i++) {
        x->room[i] = by_state[i / n * all + i % n];
    }
    const int failed = x->model.doubt(x->model.context, h, state, inputs, by_state ? x->room : NULL,
                                      memory, covariance);
    for (size_t i = by_state ? all * all : 0; i-- > 0;) {
        const bool is_model = i / all < n && i % all < n;
        covariance[i] = is_model ? covariance[i / all * n + i % all] : 0;
    }
    return failed;
}

one_step marker_drift_model(marker_drift *drift)
{
    one_step model = drift->model;
    model.context = drift;
    model.states += 3 * drift->markers;
    model.advance = advance;
    model.outside = outside;
    model.doubt = doubt;
    return model;
}

static int see(void *context, int count, const double *states, const double *inputs, double *values,
               double *by_state)
{
    const struct marker_drift_eye *eye = context;
    const one_step *model = &eye->of->model;
    const size_t n = (size_t)model->states, all = n + 3 * (size_t)eye->of->markers;
    int failed = by_state != NULL;
    for (size_t i = 0; i < (size_t)count && !failed; i++) {
        const double *offset = states + i * all + n + 3 * (size_t)eye->marker;
        failed = eye->observation.see(eye->observation.context, 1, states + i * all,
                                      inputs + i * (size_t)model->inputs, values + 3 * i, NULL);
        for (size_t k = 0; k < 3; k++) {
            values[3 * i + k] += offset[k];
        }
    }
    return failed;
}

one_observation marker_drift_see(marker_drift *drift, int marker)
{
    struct marker_drift_eye *eye = &drift->eye[marker];
    one_observation seen = eye->observation;
    eye->of = drift;
    eye->marker = marker;
    seen.context = eye;
    seen.states = drift->model.states + 3 * drift->markers;
    seen.see = see;
    return seen;
}
