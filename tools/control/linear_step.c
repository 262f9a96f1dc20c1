#include "tools/control/linear_step.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static int advance_linear(void *context, int count, double h, const double *states,
                          const double *inputs, const double *after, double *next, double *by_state,
                          double *by_inputs)
{
    const linear_step *step = context;
    const size_t n = (size_t)step->states, m = (size_t)step->inputs;
    double zero = 0; /* unless one is not finite */
    if (after || fabs(h - step->h) > 1e-9 * step->h) {
        return 1;
    }
    for (size_t i = 0; i < (size_t)count; i++) {
        for (size_t r = 0; r < n; r++) {
            double sum = step->next[r];
            for (size_t c = 0; c < n; c++) {
                sum += step->by_state[r * n + c] * states[i * n + c];
            }
            for (size_t c = 0; c < m; c++) {
                sum += step->by_inputs[r * m + c] * inputs[i * m + c];
            }
            next[i * n + r] = sum;
            zero += 0 * sum;
        }
        if (by_state) {
            memcpy(by_state + i * n * n, step->by_state, n * n * sizeof *by_state);
        }
        if (by_inputs) {
            memcpy(by_inputs + i * n * m, step->by_inputs, n * m * sizeof *by_inputs);
        }
    }
    return zero == 0 ? 0 : 1;
}

one_step linear_one_step(const linear_step *step)
{
    return (one_step){.context = (void *)step,
                      .states = step->states,
                      .inputs = step->inputs,
                      .step = step->h,
                      .advance = advance_linear};
}
