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
    const size_t n = (size_t)reduced_all_states(rod), m = (size_t)reduced_inputs(rod);
    ad_error error;
    bool good = true;
    for (size_t i = 0; i < (size_t)count && good; i++) {
        good = reduced_step_whole(rod, 0, h, states + i * n, inputs + i * m,
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
                      .states = reduced_all_states(rod),
                      .inputs = reduced_inputs(rod),
                      .step = step,
                      .shorter = 1,
                      .advance = advance_rod};
}

/* ---- linear -------------------------------------------------------------------------------- */

ad_status linear_step_create(const one_step *of, double h, const double *state,
                             const double *inputs, linear_step **result, ad_error *error)
{
    const size_t n = (size_t)of->states, m = (size_t)of->inputs;
    linear_step *step = calloc(1, sizeof *step);
    double *memory = calloc(n + n * n + n * m, sizeof *memory);
    *result = NULL;
    if (!step || !memory) {
        free(step);
        free(memory);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a linear model");
    }
    *step = (linear_step){of->states, of->inputs, h, memory, memory + n, memory + n + n * n};
    if (of->advance(of->context, 1, h, state, inputs, NULL, memory, memory + n,
                    memory + n + n * n)) {
        linear_step_free(step);
        return ad_fail(error, AD_NOT_FINITE, "the model has no step from rest of %g s", h);
    }
    for (size_t r = 0; r < n; r++) {
        for (size_t c = 0; c < n; c++) {
            memory[r] -= step->by_state[r * n + c] * state[c];
        }
        for (size_t c = 0; c < m; c++) {
            memory[r] -= step->by_inputs[r * m + c] * inputs[c];
        }
    }
    *result = step;
    return AD_OK;
}

void linear_step_free(linear_step *step)
{
    if (step) {
        free((void *)step->next);
        free(step);
    }
}
