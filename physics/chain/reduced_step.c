/* Steps of reduced rods, along what is asked for. */
#include "physics/chain/reduced_internal.h"

#include "physics/scene/scene_memory.h"

#include <string.h>

/* ---- steps --------------------------------------------------------------------------------- */

/* The place of number r of the state among rows of a step, which has those of reactions, too. */
static int row_of(const reduced_rod *rod, int r)
{
    const int moving = reduced_modes(rod), held = rod->m->size - moving;
    return r < moving ? r : r < 2 * moving ? r + held : r + 2 * held;
}

/* Where states of memory are among inputs; none of them: these count as any input. */
typedef struct remembered {
    int first, count;
} remembered;

/* Inputs at both ends of a step with the states of memory, and rod->change, how they change along
 * each direction. Of held inputs a play has moved at the beginning. */
static void remember(reduced_rod *rod, double h, remembered memory, bool held, int count,
                     const double *change, double *now, double *then)
{
    const int inputs = rod->m->inputs, states = reduced_states(rod);
    double *before = rod->change[0], *after = rod->change[1];
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < inputs; k++) {
            const int at = k - memory.first;
            const bool is_state = at >= 0 && at < memory.count;
            before[i * inputs + k] =
                change[(states + (is_state ? at : memory.count + k)) * count + i];
        }
    }
    memcpy(after, before, (size_t)count * (size_t)inputs * sizeof *after);
    if (memory.count > 0) {
        scene_memory_step(&rod->open, &rod->values, h, now, then, count, before, after);
    }
    for (int k = memory.first; k < memory.first + memory.count && held; k++) {
        if (!rod->open.memory[k - memory.first].lags) {
            now[k] = then[k];
            for (int i = 0; i < count; i++) {
                before[i * inputs + k] = after[i * inputs + k];
            }
        }
    }
}

/* Of a step that was made from rod->start, with rod->change. */
static ad_status change_step(reduced_rod *rod, double t, double h, remembered memory,
                             const double *now, const double *then, int count, double *change,
                             ad_error *error)
{
    const int n = rod->m->size, inputs = rod->m->inputs, states = reduced_states(rod);
    const double time = rod->rod->scales.time, *before = rod->change[0], *after = rod->change[1];
    double *by = rod->by, *to = by + (2 * n + rod->m->branch.count) * count,
           *ends = to + inputs * count;
    memset(by, 0, (size_t)(to - by) * sizeof *by);
    for (int i = 0; i < count; i++) {
        for (int r = 0; r < states; r++) {
            by[row_of(rod, r) * count + i] = change[r * count + i] / rod->unit[r];
        }
        for (int k = 0; k < inputs; k++) {
            to[k * count + i] = before[i * inputs + k];
        }
        for (int k = 0; k < memory.count; k++) {
            const int at = i * inputs + memory.first + k;
            ends[k * count + i] = after[at] - before[at];
        }
    }
    const collocation_ends which = {memory.first, memory.count};
    const ad_status status =
        collocation_along(rod->step, t / time, h / time, now, then, which, rod->start,
                          rod->start + n, rod->start + 2 * n, count, rod->room, by, error);
    for (int i = 0; i < count; i++) {
        for (int r = 0; r < states; r++) {
            change[r * count + i] = by[row_of(rod, r) * count + i] * rod->unit[r];
        }
        for (int k = 0; k < memory.count; k++) {
            change[(states + k) * count + i] = after[i * inputs + memory.first + k];
        }
    }
    return status;
}

/* change [states + memory.count + inputs][count]. */
static ad_status step_along(reduced_rod *rod, double t, double h, remembered memory,
                            const double *state, const double *inputs, const double *after,
                            double *next, int count, double *change, ad_error *error)
{
    const int n = rod->m->size, states = reduced_states(rod);
    const double time = rod->rod->scales.time;
    const size_t width = (size_t)rod->m->inputs, kept = (size_t)memory.count;
    double now[SCENE_PARAMETERS_MAX], then[SCENE_PARAMETERS_MAX];
    memcpy(now, inputs, width * sizeof *now);
    memcpy(then, after ? after : inputs, width * sizeof *then);
    memcpy(now + memory.first, state + states, kept * sizeof *now);
    remember(rod, h, memory, !after, count, change, now, then);
    const double *end = after || kept > 0 ? then : NULL;
    reduced_take_state(rod, state);
    memcpy(rod->start, rod->q, (size_t)n * sizeof *rod->q);
    memcpy(rod->start + n, rod->v, (size_t)n * sizeof *rod->v);
    memcpy(rod->start + 2 * n, rod->d, (size_t)n * sizeof *rod->d);
    ad_status status = collocation_once(rod->step, t / time, h / time, now, end, rod->newton,
                                        rod->q, rod->v, rod->d, error);
    if (status == AD_OK && count > 0) {
        status = change_step(rod, t, h, memory, now, end, count, change, error);
    }
    if (status == AD_OK) {
        reduced_give_state(rod, next);
        memcpy(next + states, then + memory.first, kept * sizeof *next);
    }
    return status;
}

/* Along the state, and inputs where these are wanted. */
static ad_status step_square(reduced_rod *rod, double t, double h, remembered memory,
                             const double *state, const double *inputs, const double *after,
                             double *next, double *by_state, double *by_inputs, ad_error *error)
{
    const size_t states = (size_t)reduced_states(rod) + (size_t)memory.count,
                 width = (size_t)rod->m->inputs,
                 count = by_inputs  ? states + width
                         : by_state ? states
                                    : 0;
    double *along = rod->along;
    memset(along, 0, (states + width) * count * sizeof *along);
    for (size_t i = 0; i < count; i++) {
        along[i * count + i] = 1;
    }
    const ad_status status =
        step_along(rod, t, h, memory, state, inputs, after, next, (int)count, along, error);
    for (size_t r = 0; r < states && status == AD_OK; r++) {
        if (by_state) {
            memcpy(by_state + r * states, along + r * count, states * sizeof *along);
        }
        if (by_inputs) {
            memcpy(by_inputs + r * width, along + r * count + states, width * sizeof *along);
        }
    }
    return status;
}

ad_status reduced_step(reduced_rod *rod, double t, double h, const double *state,
                       const double *inputs, double *next, double *by_state, double *by_inputs,
                       ad_error *error)
{
    return reduced_step_linear(rod, t, h, state, inputs, NULL, next, by_state, by_inputs, error);
}

ad_status reduced_step_linear(reduced_rod *rod, double t, double h, const double *state,
                              const double *inputs, const double *after, double *next,
                              double *by_state, double *by_inputs, ad_error *error)
{
    return step_square(rod, t, h, (remembered){0, 0}, state, inputs, after, next, by_state,
                       by_inputs, error);
}

/* ---- inputs with a memory ------------------------------------------------------------------ */

int reduced_all_states(const reduced_rod *rod)
{
    return reduced_states(rod) + rod->open.memory_count;
}

void reduced_remember(const reduced_rod *rod, const double *state, double *inputs)
{
    memcpy(inputs + scene_given_count(&rod->open), state + reduced_states(rod),
           (size_t)rod->open.memory_count * sizeof *inputs);
}

void reduced_begin(const reduced_rod *rod, double *inputs, double *state)
{
    scene_memory_start(&rod->open, &rod->values, inputs, 0, NULL);
    memcpy(state + reduced_states(rod), inputs + scene_given_count(&rod->open),
           (size_t)rod->open.memory_count * sizeof *state);
}

static remembered memory_of(const reduced_rod *rod)
{
    return (remembered){scene_given_count(&rod->open), rod->open.memory_count};
}

ad_status reduced_step_whole(reduced_rod *rod, double t, double h, const double *state,
                             const double *inputs, const double *after, double *next,
                             double *by_state, double *by_inputs, ad_error *error)
{
    return step_square(rod, t, h, memory_of(rod), state, inputs, after, next, by_state, by_inputs,
                       error);
}

ad_status reduced_step_along(reduced_rod *rod, double t, double h, const double *state,
                             const double *inputs, const double *after, double *next, int count,
                             double *change, ad_error *error)
{
    return step_along(rod, t, h, memory_of(rod), state, inputs, after, next, count, change, error);
}
