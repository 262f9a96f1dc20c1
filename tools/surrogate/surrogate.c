#include "tools/surrogate/surrogate.h"

#include <math.h>
#include <stdlib.h>

void surrogate_free(surrogate *s)
{
    if (s) {
        free(s->numbers);
        if (s->free_owner) {
            s->free_owner(s->owner);
        }
        free(s);
    }
}

bool surrogate_is_parameter(const surrogate *s, int i)
{
    return surrogate_names_parameter(&s->settings, s->scene->parameters[i].name);
}

/* ---- steps --------------------------------------------------------------------------------- */

typedef struct runner {
    const surrogate_step *step;
    const double *inner; /* of polynomials; NULL: none */
    surrogate_step part; /* that polynomials are after a part of the step, not 0 once it is known */
    double *work;        /* of the step; then [inputs], [numbers] */
    double *numbers, *end;
} runner;

/* Parts of a step by polynomials. What is known of the end is that of this part. */
static int advance_part(runner *runner, int count, double h, const double *states,
                        const double *inputs, const double *after, double *next, double *by_state,
                        double *by_inputs)
{
    const surrogate_step *m = runner->step;
    const size_t n = (size_t)m->states, given = (size_t)m->inputs;
    const double t = h / m->step;
    int bad = 0;
    if (!(t > 0 && t < 1) || (after && !m->ramps)) {
        return 2;
    }
    if (runner->part.step != h) {
        surrogate_curve_at(m, runner->inner, t, runner->numbers);
        runner->part = *m;
        runner->part.step = h;
        runner->part.numbers = runner->numbers;
    }
    if (!after) {
        return surrogate_step_advance(&runner->part, runner->work, count, h, states, inputs, NULL,
                                      next, by_state, by_inputs);
    }
    for (size_t i = 0; i < (size_t)count; i++) {
        const double *u = inputs + i * given;
        for (size_t k = 0; k < given; k++) {
            runner->end[k] = u[k] + (after[i * given + k] - u[k]) / t;
        }
        bad |= surrogate_step_advance(
            &runner->part, runner->work, 1, h, states + i * n, u, runner->end, next + i * n,
            by_state ? by_state + i * n * n : NULL, by_inputs ? by_inputs + i * n * given : NULL);
    }
    return bad;
}

static int advance(void *context, int count, double h, const double *states, const double *inputs,
                   const double *after, double *next, double *by_state, double *by_inputs)
{
    runner *runner = context;
    if (runner->inner && fabs(h - runner->step->step) > 1e-9 * runner->step->step) {
        return advance_part(runner, count, h, states, inputs, after, next, by_state, by_inputs);
    }
    return surrogate_step_advance(runner->step, runner->work, count, h, states, inputs, after, next,
                                  by_state, by_inputs);
}

static double outside(void *context, const double *state, const double *inputs)
{
    const runner *runner = context;
    return surrogate_step_outside(runner->step, state, inputs);
}

ad_status surrogate_one_step(const surrogate *s, one_step *result, ad_error *error)
{
    const surrogate_step *m = &s->step;
    const bool parts = s->settings.kind == SURROGATE_POLYNOMIAL;
    const size_t own = surrogate_step_work(m);
    const size_t numbers = parts ? surrogate_step_numbers(m) : 0;
    runner *x = malloc(sizeof *x);
    double *work = calloc(own + SURROGATE_INPUTS_MAX + numbers, sizeof *work);
    *result = (one_step){0};
    if (!x || !work) {
        free(x);
        free(work);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    *x = (runner){.step = m,
                  .inner = parts ? s->numbers + numbers : NULL,
                  .work = work,
                  .end = work + own,
                  .numbers = work + own + SURROGATE_INPUTS_MAX};
    *result = (one_step){.context = x,
                         .states = m->states,
                         .inputs = m->inputs,
                         .step = m->step,
                         .shorter = parts,
                         .advance = advance,
                         .outside = outside};
    return AD_OK;
}

void surrogate_one_step_free(one_step *step)
{
    runner *own = step->context;
    if (own) {
        free(own->work);
        free(own);
    }
    *step = (one_step){0};
}

ad_status surrogate_rod(const surrogate *s, int count, const double *places, reduced_rod **result,
                        ad_error *error)
{
    const int *modes = s->settings.modes;
    const reduced_settings settings = {
        .modes = {modes[0], modes[1], modes[2], modes[3]}, .count = count, .s = places};
    return reduced_create(s->scene, &settings, result, error);
}

/* ---- in a checkpoint ----------------------------------------------------------------------- */

enum { SINGLE = 15 };
_Static_assert(SINGLE + SURROGATE_SLOW_MAX + SURROGATE_LAYERS_MAX + SURROGATE_STATES_MAX +
                       SURROGATE_INPUTS_MAX ==
                   SURROGATE_SHAPE,
               "whole numbers of a step");

/* Where the whole numbers of a step are. */
static void list_shape(surrogate_step *m, int *at[SURROGATE_SHAPE])
{
    int *const single[SINGLE] = {&m->kind,       &m->states,    &m->inputs,    &m->ramps,
                                 &m->turns,      &m->mirrors,   &m->pairs,     &m->evens,
                                 &m->odds,       &m->out_pairs, &m->out_evens, &m->out_odds,
                                 &m->slow_count, &m->layers,    &m->drives};
    int *const lists[] = {m->slow, m->width, m->state_slot, m->input_slot};
    const int counts[] = {SURROGATE_SLOW_MAX, SURROGATE_LAYERS_MAX, SURROGATE_STATES_MAX,
                          SURROGATE_INPUTS_MAX};
    int count = 0;
    for (; count < SINGLE; count++) {
        at[count] = single[count];
    }
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
        for (int k = 0; k < counts[i]; k++) {
            at[count++] = lists[i] + k;
        }
    }
}

void surrogate_put(surrogate_step *m, int64_t shape[SURROGATE_SHAPE], checkpoint *file)
{
    const size_t size = SURROGATE_SHAPE, numbers = surrogate_step_numbers(m);
    int *at[SURROGATE_SHAPE];
    list_shape(m, at);
    for (size_t i = 0; i < size; i++) {
        shape[i] = *at[i];
    }
    checkpoint_put_int64(file, "surrogate/shape", shape, 1, &size);
    checkpoint_put_double(file, "surrogate/step", m->step);
    checkpoint_put_double(file, "surrogate/soft", m->soft);
    checkpoint_put_doubles(file, "surrogate/numbers", m->numbers, 1, &numbers);
}

static bool is_between(int low, int x, int high)
{
    return x >= low && x <= high;
}

/* Whether every size is one that a step can have, and every place within it. */
static bool is_sound(const surrogate_step *m)
{
    const int all = m->ramps ? 2 * m->inputs : m->inputs;
    bool fine = is_between(1, m->states, SURROGATE_STATES_MAX) && is_between(0, m->ramps, 1) &&
                is_between(0, m->inputs, SURROGATE_INPUTS_MAX) &&
                is_between(0, all, SURROGATE_INPUTS_MAX) &&
                is_between(all, m->drives, SURROGATE_INPUTS_MAX) &&
                is_between(0, m->slow_count, SURROGATE_SLOW_MAX) &&
                is_between(0, m->layers, SURROGATE_LAYERS_MAX) && m->pairs >= 0 && m->evens >= 0 &&
                m->odds >= 0 && is_between(0, m->out_pairs, m->pairs) &&
                is_between(0, m->out_evens, m->evens) && is_between(0, m->out_odds, m->odds) &&
                2 * m->pairs + m->evens + m->odds == m->states + m->drives &&
                2 * m->out_pairs + m->out_evens + m->out_odds == m->states;
    for (int i = 0; fine && i < m->states + m->drives; i++) {
        fine = is_between(0, i < m->states ? m->state_slot[i] : m->input_slot[i - m->states],
                          m->states + m->drives - 1);
    }
    for (int i = 0; fine && i < m->slow_count; i++) {
        fine = is_between(0, m->slow[i], m->inputs - 1);
    }
    for (int i = 0; fine && i < m->layers; i++) {
        fine = is_between(1, m->width[i], 4096) && !(m->mirrors && m->width[i] % 2);
    }
    return fine;
}

ad_status surrogate_get(const checkpoint *file, surrogate_step *m, double **numbers,
                        ad_error *error)
{
    int64_t shape[SURROGATE_SHAPE];
    int *at[SURROGATE_SHAPE];
    *numbers = NULL;
    ad_status status = checkpoint_get_int64(file, "surrogate/shape", shape, SURROGATE_SHAPE, error);
    *m = (surrogate_step){0};
    list_shape(m, at);
    for (int i = 0; i < SURROGATE_SHAPE && status == AD_OK; i++) {
        *at[i] = shape[i] >= 0 && shape[i] <= 4096 ? (int)shape[i] : -1;
    }
    if (status == AD_OK && !is_sound(m)) {
        status = ad_fail(error, AD_BAD_INPUT, "checkpoint: surrogate/shape is not that of a model");
    }
    if (status == AD_OK) {
        status = checkpoint_get_doubles(file, "surrogate/step", &m->step, 1, error);
    }
    if (status == AD_OK) {
        status = checkpoint_get_doubles(file, "surrogate/soft", &m->soft, 1, error);
    }
    if (status == AD_OK) {
        const size_t count = surrogate_step_numbers(m);
        *numbers = malloc(count * sizeof **numbers);
        status = *numbers
                     ? checkpoint_get_doubles(file, "surrogate/numbers", *numbers, count, error)
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    m->numbers = *numbers;
    return status;
}

void surrogate_put_nodes(const surrogate_step *m, const double *inner, checkpoint *file)
{
    const size_t sizes[] = {SURROGATE_INNER, surrogate_step_numbers(m)};
    checkpoint_put_doubles(file, "surrogate/inner", inner, 2, sizes);
}

ad_status surrogate_get_nodes(const checkpoint *file, surrogate_step *m, double **numbers,
                              ad_error *error)
{
    ad_status status = surrogate_get(file, m, numbers, error);
    if (status != AD_OK) {
        return status;
    }
    const size_t each = surrogate_step_numbers(m), inner = SURROGATE_INNER * each;
    double *all = realloc(*numbers, (each + inner) * sizeof *all);
    if (!all) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a one-step model");
    }
    m->numbers = *numbers = all;
    return checkpoint_get_doubles(file, "surrogate/inner", all + each, inner, error);
}
