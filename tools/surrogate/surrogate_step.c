#include "tools/surrogate/step_map.h"

size_t surrogate_step_parameters(const surrogate_step *m)
{
    size_t all = 0;
    for (int at = 0; at <= m->layers && m->layers > 0; at++) {
        all += (size_t)((step_layer_inputs(m, at, false) + 1) * step_layer_outputs(m, at, false) +
                        step_layer_inputs(m, at, true) * step_layer_outputs(m, at, true));
    }
    return all;
}

size_t surrogate_step_numbers(const surrogate_step *m)
{
    step_parts parts;
    return step_find_parts(m, &parts) + surrogate_step_parameters(m);
}

size_t surrogate_step_work(const surrogate_step *m)
{
    step_work x;
    return step_divide(m, NULL, &x);
}

FOR_EACH_PROCESSOR static void step_one(const surrogate_step *m, const step_parts *parts,
                                        step_work *work, const double *state, const double *inputs,
                                        const double *after, double *next)
{
    step_tile(m, 1, 1, parts, work, state, inputs, after, next);
}

FOR_EACH_PROCESSOR static void step_many(const surrogate_step *m, int count,
                                         const step_parts *parts, step_work *work,
                                         const double *states, const double *inputs,
                                         const double *after, double *next)
{
    step_tile(m, STEP_LANES, count, parts, work, states, inputs, after, next);
}

int surrogate_step_advance(const surrogate_step *m, double *work, int count, double h,
                           const double *states, const double *inputs, const double *after,
                           double *next, double *by_state, double *by_inputs)
{
    const int n = m->states, inputs_count = m->inputs;
    const bool derive = by_state || by_inputs;
    step_parts parts;
    step_work x;
    if (fabs(h - m->step) > 1e-9 * m->step || (after && !m->ramps)) {
        return 2;
    }
    after = m->ramps && !after ? inputs : after;
    step_find_parts(m, &parts);
    step_divide(m, work, &x);
    for (int i = 0; i < count;) {
        const double *state = states + i * n, *u = inputs + i * inputs_count;
        const double *end = after ? after + i * inputs_count : NULL;
        const int lanes = derive || count - i < STEP_LANES / 2 ? 1 : STEP_LANES;
        if (derive) {
            surrogate_step_differentiate(m, &parts, &x, state, u, end, next + i * n,
                                         by_state ? by_state + i * n * n : NULL,
                                         by_inputs ? by_inputs + i * n * inputs_count : NULL);
        } else if (lanes == 1) {
            step_one(m, &parts, &x, state, u, end, next + i * n);
        } else {
            step_many(m, count - i, &parts, &x, state, u, end, next + i * n);
        }
        i += lanes;
    }
    double sum = 0; /* not finite if any number is */
    for (int i = 0; i < count * n; i++) {
        sum += 0 * next[i];
    }
    return sum == 0 ? 0 : 1;
}

double surrogate_step_outside(const surrogate_step *m, const double *state, const double *inputs)
{
    step_parts parts;
    double most = 0;
    step_find_parts(m, &parts);
    for (int k = 0; k < m->states + m->inputs; k++) {
        const int i = k - m->states;
        const double here = k < m->states
                                ? fabs(state[k] - parts.state_center[k]) / parts.state_range[k]
                                : fabs(2 * inputs[i] - parts.input_low[i] - parts.input_high[i]) /
                                      (parts.input_high[i] - parts.input_low[i]);
        if (!(here <= most)) {
            most = isnan(here) ? INFINITY : here;
        }
    }
    return most;
}
