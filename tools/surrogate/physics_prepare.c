/* Centers, scales, the linear flow, and parameters to begin with. */
#include "tools/surrogate/physics_loss.h"

#include "nn/rng.h"
#include "physics/solve/reduced.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LINEARISED = 256 }; /* states whose derivatives are averaged */

typedef struct parts {
    double *state_center, *state_scale, *input_center, *input_scale, *state_range, *flow, *network;
} parts;

static parts parts_of(const decoupled *m, double *numbers)
{
    const size_t n = (size_t)m->states, inputs = (size_t)m->inputs;
    parts x;
#define PHYSICS_TAKE(name, count)                                                                  \
    x.name = numbers;                                                                              \
    numbers += (count);
    DECOUPLED_NUMBERS(PHYSICS_TAKE)
#undef PHYSICS_TAKE
    x.network = numbers;
    return x;
}

static void find_scales(const scene *open, const excite_rollouts *motions, const decoupled *m,
                        parts *x)
{
    const int n = m->states;
    for (int pass = 0; pass < 3; pass++) { /* mean, deviation, range */
        double count = 0;
        for (int i = 0; i < motions->count; i++) {
            for (int k = 0; k <= motions->done[i]; k++) {
                const double *state =
                    motions->state + ((size_t)i * (size_t)(motions->steps + 1) + (size_t)k) * n;
                for (int j = 0; j < n; j++) {
                    const double off = state[j] - x->state_center[j];
                    x->state_center[j] += pass == 0 ? (off) / (count + 1) : 0;
                    x->state_scale[j] += pass == 1 ? off * off : 0;
                    x->state_range[j] =
                        pass == 2 ? fmax(x->state_range[j], fabs(off) / x->state_scale[j]) : 0;
                }
                count++;
            }
        }
        double largest = 0;
        for (int j = 0; j < n && pass == 1; j++) {
            x->state_scale[j] = sqrt(x->state_scale[j] / count);
            largest = fmax(largest, x->state_scale[j]);
        }
        for (int j = 0; j < n && pass == 1; j++) {
            x->state_scale[j] = x->state_scale[j] > EXCITE_STAYS * largest ? x->state_scale[j] : 1;
        }
        for (int j = 0; j < n && pass == 2; j++) { /* of what moves it is 1 or more anyhow */
            x->state_range[j] = fmax(x->state_range[j], 1);
        }
    }
    for (int k = 0; k < m->inputs; k++) {
        const scene_parameter *of = &open->parameters[k];
        x->input_center[k] = 0.5 * (of->low + of->high);
        x->input_scale[k] = 0.5 * (of->high - of->low);
    }
}

/* z' = A z + B v + c: the mean of the derivatives over states of the motions, and of what f has
 * beside these. */
static ad_status find_flow(reduced_rod *rod, const excite_rollouts *motions, const decoupled *m,
                           parts *x, ad_error *error)
{
    const int n = m->states, inputs = m->inputs, columns = n + inputs + 1;
    double *memory = malloc((size_t)(n * columns) * sizeof *memory);
    double *by_state = memory, *by_inputs = by_state + n * n, *rate = by_inputs + n * inputs;
    ad_status status =
        memory ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a linear flow");
    for (int s = 0; s < 2 * LINEARISED && status == AD_OK; s++) {
        const int which = s % LINEARISED, i = which % motions->count;
        const bool derives = s < LINEARISED;
        const int k = motions->done[i] > 0 ? (int)(((long)which * 7919) % motions->done[i]) : 0;
        const size_t at = (size_t)i * (size_t)(motions->steps + 1) + (size_t)k;
        const double *state = motions->state + at * (size_t)n;
        const double *u = motions->input + at * (size_t)inputs;
        status = reduced_rate(rod, 0, state, u, rate, derives ? by_state : NULL,
                              derives ? by_inputs : NULL, error);
        for (int r = 0; r < n && status == AD_OK; r++) {
            const double h = m->step / x->state_scale[r];
            double *row = x->flow + r * columns, rest = h * rate[r];
            for (int c = 0; c < n; c++) {
                rest -= row[c] * (state[c] - x->state_center[c]) / x->state_scale[c];
                row[c] += derives ? h * by_state[r * n + c] * x->state_scale[c] / LINEARISED : 0;
            }
            for (int c = 0; c < inputs; c++) {
                rest -= row[n + c] * (u[c] - x->input_center[c]) / x->input_scale[c];
                row[n + c] +=
                    derives ? h * by_inputs[r * inputs + c] * x->input_scale[c] / LINEARISED : 0;
            }
            row[n + inputs] += derives ? 0 : rest / LINEARISED;
        }
    }
    free(memory);
    return status;
}

/* LeCun's weights; of the outputs a thousandth of them. Damped sines begin with frequencies up to
 * half a turn a step, phases all around, and decays from 0.3 to 30 a step. */
static void draw_parameters(const decoupled *m, uint64_t seed, double *at)
{
    nn_rng random = nn_rng_split(seed, "one-step model");
    const double pi = 3.14159265358979323846;
    int in = m->states + decoupled_given(m);
    for (int l = 0; l <= m->layers; l++) {
        const bool last = l == m->layers;
        const int out = last ? decoupled_outputs(m) : m->width[l];
        const double size = (last ? 1e-3 : 1) / sqrt(in);
        for (int k = 0; k < out * in; k++) {
            *at++ = size * nn_rng_normal(&random);
        }
        for (int k = 0; k < out; k++) {
            const double uniform = nn_rng_uniform(&random);
            const int term = m->terms > 0 ? k / 4 % m->terms : 0;
            const double decay = 0.3 * pow(100, m->terms > 1 ? (double)term / (m->terms - 1) : 0.5);
            const double begin[4] = {2e-3 * (uniform - 0.5), pi * uniform, 2 * pi * (uniform - 0.5),
                                     decay};
            *at++ = last && m->terms > 0 ? begin[k % 4] : 0;
        }
        in = out;
    }
}

ad_status physics_prepare(const scene *open, const int modes[4], const excite_rollouts *motions,
                          uint64_t seed, const decoupled *m, double *numbers, ad_error *error)
{
    parts x = parts_of(m, numbers);
    reduced_settings settings = {.count = 0};
    reduced_rod *rod = NULL;
    memset(numbers, 0, decoupled_numbers(m) * sizeof *numbers);
    memcpy(settings.modes, modes, sizeof settings.modes);
    ad_status status = reduced_create(open, &settings, &rod, error);
    if (status == AD_OK) {
        find_scales(open, motions, m, &x);
        draw_parameters(m, seed, x.network);
    }
    if (status == AD_OK) {
        status = find_flow(rod, motions, m, &x, error);
    }
    reduced_free(rod);
    return status;
}
