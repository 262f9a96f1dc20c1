/* Centers, scales, and parameters to begin with. */
#include "tools/surrogate/physics_loss.h"

#include "nn/rng.h"

#include <math.h>
#include <string.h>

typedef struct parts {
    double *state_center, *state_scale, *input_center, *input_scale, *state_range, *network;
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

void physics_prepare(const scene *open, const excite_rollouts *motions, uint64_t seed,
                     const decoupled *m, double *numbers)
{
    parts x = parts_of(m, numbers);
    memset(numbers, 0, decoupled_numbers(m) * sizeof *numbers);
    find_scales(open, motions, m, &x);
    draw_parameters(m, seed, x.network);
}
