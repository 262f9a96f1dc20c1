#include "tools/control/reduced_model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the reduced rod ----------------------------------------------------------------------- */

static int advance_rod(void *context, int count, double h, const double *states,
                       const double *inputs, const double *after, double *next, double *by_state,
                       double *by_inputs)
{
    reduced_rod *rod = context;
    const size_t n = (size_t)reduced_states(rod), m = (size_t)reduced_inputs(rod);
    ad_error error;
    bool good = true;
    for (size_t i = 0; i < (size_t)count && good; i++) {
        good = reduced_step_linear(rod, 0, h, states + i * n, inputs + i * m,
                                   after ? after + i * m : NULL, next + i * n,
                                   by_state ? by_state + i * n * n : NULL,
                                   by_inputs ? by_inputs + i * n * m : NULL, &error) == AD_OK;
        for (size_t k = 0; k < n && good; k++) {
            good = isfinite(next[i * n + k]);
        }
    }
    return good ? 0 : 1;
}

one_step reduced_one_step(reduced_rod *rod, double step)
{
    return (one_step){.context = rod,
                      .states = reduced_states(rod),
                      .inputs = reduced_inputs(rod),
                      .step = step,
                      .shorter = 1,
                      .advance = advance_rod};
}

/* ---- linear -------------------------------------------------------------------------------- */

struct linear_step {
    int states, inputs;
    double h;
    double *next; /* [states] for the state and inputs of rest, less A x_e + B u_e */
    double *by_state, *by_inputs;
};

static int advance_linear(void *context, int count, double h, const double *states,
                          const double *inputs, const double *after, double *next, double *by_state,
                          double *by_inputs)
{
    const linear_step *x = context;
    const size_t n = (size_t)x->states, m = (size_t)x->inputs;
    if (after || fabs(h - x->h) > 1e-9 * x->h) {
        return 1;
    }
    for (size_t i = 0; i < (size_t)count; i++) {
        for (size_t r = 0; r < n; r++) {
            double sum = x->next[r];
            for (size_t c = 0; c < n; c++) {
                sum += x->by_state[r * n + c] * states[i * n + c];
            }
            for (size_t c = 0; c < m; c++) {
                sum += x->by_inputs[r * m + c] * inputs[i * m + c];
            }
            next[i * n + r] = sum;
        }
        if (by_state) {
            memcpy(by_state + i * n * n, x->by_state, n * n * sizeof *by_state);
        }
        if (by_inputs) {
            memcpy(by_inputs + i * n * m, x->by_inputs, n * m * sizeof *by_inputs);
        }
    }
    return 0;
}

ad_status linear_step_create(const one_step *of, double h, const double *state,
                             const double *inputs, linear_step **result, ad_error *error)
{
    const size_t n = (size_t)of->states, m = (size_t)of->inputs;
    linear_step *x = calloc(1, sizeof *x);
    double *memory = calloc(n + n * n + n * m, sizeof *memory);
    *result = NULL;
    if (!x || !memory) {
        free(x);
        free(memory);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a linear model");
    }
    *x = (linear_step){of->states, of->inputs, h, memory, memory + n, memory + n + n * n};
    if (of->advance(of->context, 1, h, state, inputs, NULL, x->next, x->by_state, x->by_inputs)) {
        linear_step_free(x);
        return ad_fail(error, AD_NOT_FINITE, "the model has no step from rest of %g s", h);
    }
    for (size_t r = 0; r < n; r++) {
        for (size_t c = 0; c < n; c++) {
            x->next[r] -= x->by_state[r * n + c] * state[c];
        }
        for (size_t c = 0; c < m; c++) {
            x->next[r] -= x->by_inputs[r * m + c] * inputs[c];
        }
    }
    *result = x;
    return AD_OK;
}

void linear_step_free(linear_step *x)
{
    if (x) {
        free(x->next);
        free(x);
    }
}

one_step linear_one_step(linear_step *x)
{
    return (one_step){.context = x,
                      .states = x->states,
                      .inputs = x->inputs,
                      .step = x->h,
                      .advance = advance_linear};
}
