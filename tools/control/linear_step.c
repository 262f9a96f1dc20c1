#include "tools/control/linear_step.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static int advance_linear(void *context, int count, double h, const double *states,
                          const double *inputs, const double *after, double *next, double *by_state,
                          double *by_inputs)
{
    const linear_step *x = context;
    const size_t n = (size_t)x->states, m = (size_t)x->inputs;
    double zero = 0; /* unless one is not finite */
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
            zero += 0 * sum;
        }
        if (by_state) {
            memcpy(by_state + i * n * n, x->by_state, n * n * sizeof *by_state);
        }
        if (by_inputs) {
            memcpy(by_inputs + i * n * m, x->by_inputs, n * m * sizeof *by_inputs);
        }
    }
    return zero == 0 ? 0 : 1;
}

one_step linear_one_step(const linear_step *x)
{
    return (one_step){.context = (void *)x,
                      .states = x->states,
                      .inputs = x->inputs,
                      .step = x->h,
                      .advance = advance_linear};
}
