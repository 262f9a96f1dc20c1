/* Centers, scales, parameters to begin with; the equations of the reduced rod in these. */
#include "tools/surrogate/physics_internal.h"

#include "nn/rng.h"

#include <math.h>
#include <stdlib.h>
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

static void find_scales(const scene *open, const excitation_rollouts *motions, const decoupled *m,
                        parts *parts)
{
    const int n = m->states;
    for (int pass = 0; pass < 3; pass++) { /* mean, deviation, range */
        double count = 0;
        for (int i = 0; i < motions->count; i++) {
            for (int k = 0; k <= motions->done[i]; k++) {
                const double *state =
                    motions->state + ((size_t)i * (size_t)(motions->steps + 1) + (size_t)k) * n;
                for (int j = 0; j < n; j++) {
                    const double off = state[j] - parts->state_center[j];
                    parts->state_center[j] += pass == 0 ? (off) / (count + 1) : 0;
                    parts->state_scale[j] += pass == 1 ? off * off : 0;
                    parts->state_range[j] =
                        pass == 2 ? fmax(parts->state_range[j], fabs(off) / parts->state_scale[j])
                                  : 0;
                }
                count++;
            }
        }
        double largest = 0;
        for (int j = 0; j < n && pass == 1; j++) {
            parts->state_scale[j] = sqrt(parts->state_scale[j] / count);
            largest = fmax(largest, parts->state_scale[j]);
        }
        for (int j = 0; j < n && pass == 1; j++) {
            parts->state_scale[j] =
                parts->state_scale[j] > EXCITATION_STAYS * largest ? parts->state_scale[j] : 1;
        }
        for (int j = 0; j < n && pass == 2; j++) { /* of what moves it is 1 or more anyhow */
            parts->state_range[j] = fmax(parts->state_range[j], 1);
        }
    }
    for (int k = 0; k < m->inputs; k++) {
        const scene_parameter *of = &open->parameters[k];
        parts->input_center[k] = 0.5 * (of->low + of->high);
        parts->input_scale[k] = 0.5 * (of->high - of->low);
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

void physics_prepare(const scene *open, const excitation_rollouts *motions, uint64_t seed,
                     const decoupled *m, double *numbers)
{
    parts x = parts_of(m, numbers);
    memset(numbers, 0, decoupled_numbers(m) * sizeof *numbers);
    find_scales(open, motions, m, &x);
    draw_parameters(m, seed, x.network);
}

/* ---- equations ----------------------------------------------------------------------------- */

physics physics_of(const decoupled *m, const excitation_rollouts *motions)
{
    const size_t n = (size_t)m->states, inputs = (size_t)m->inputs;
    const double *center = m->numbers;
    return (physics){.m = m,
                     .motions = motions,
                     .center = center,
                     .scale = center + n,
                     .input_center = center + 2 * n,
                     .input_scale = center + 2 * n + inputs};
}

size_t physics_given(const decoupled *m)
{
    return (size_t)m->states + (size_t)decoupled_given(m);
}

ad_status physics_workers_create(const scene *open, const int modes[4], const decoupled *m,
                                 int threads, size_t more, physics_worker **result, ad_error *error)
{
    const size_t n = (size_t)m->states, given = physics_given(m);
    reduced_settings settings = {.count = 0};
    physics_worker *workers = calloc((size_t)threads, sizeof *workers);
    ad_status status =
        workers ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a rod's equations");
    memcpy(settings.modes, modes, sizeof settings.modes);
    for (int i = 0; i < threads && status == AD_OK; i++) {
        physics_worker *w = &workers[i];
        w->given = calloc(given + n + SCENE_PARAMETERS_MAX + n * n + more, sizeof *w->given);
        if (!w->given) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for a rod's equations");
            break;
        }
        w->state = w->given + given;
        w->input = w->state + n;
        w->jacobian = w->input + SCENE_PARAMETERS_MAX;
        w->own = w->jacobian + n * n;
        status = reduced_create(open, &settings, &w->rod, error);
    }
    *result = workers;
    return status;
}

void physics_workers_free(int threads, physics_worker *workers)
{
    for (int i = 0; i < threads && workers; i++) {
        reduced_free(workers[i].rod);
        free(workers[i].given);
    }
    free(workers);
}

void physics_take(const physics *physics, int i, int k, physics_worker *w)
{
    const int n = physics->m->states, inputs = physics->m->inputs;
    const size_t row = (size_t)i * (size_t)(physics->motions->steps + 1) + (size_t)k;
    const double *state = physics->motions->state + row * (size_t)n;
    const double *input = physics->motions->input + row * (size_t)inputs; /* the next row: end */
    for (int j = 0; j < n; j++) {
        w->given[j] = (state[j] - physics->center[j]) / physics->scale[j];
    }
    for (int j = 0; j < decoupled_given(physics->m); j++) {
        w->given[n + j] =
            (input[j] - physics->input_center[j % inputs]) / physics->input_scale[j % inputs];
    }
}

bool physics_rate(const physics *physics, physics_worker *w, double t, const double *z,
                  double *rate, double *by_z)
{
    const decoupled *m = physics->m;
    const int n = m->states, inputs = m->inputs;
    const double *v = w->given + n;
    ad_error error;
    for (int j = 0; j < n; j++) {
        w->state[j] = physics->center[j] + physics->scale[j] * z[j];
        if (!(fabs(z[j]) < 1e6)) {
            return false;
        }
    }
    for (int k = 0; k < inputs; k++) {
        const double now = v[k] + (m->ramps ? t * (v[inputs + k] - v[k]) : 0);
        w->input[k] = physics->input_center[k] + physics->input_scale[k] * now;
    }
    if (reduced_rate(w->rod, 0, w->state, w->input, rate, by_z ? w->jacobian : NULL, NULL,
                     &error) != AD_OK) {
        return false;
    }
    for (int r = 0; r < n; r++) {
        const double h = m->step / physics->scale[r];
        rate[r] *= h;
        for (int c = 0; c < n && by_z; c++) {
            by_z[r * n + c] = h * w->jacobian[r * n + c] * physics->scale[c];
        }
    }
    return true;
}
