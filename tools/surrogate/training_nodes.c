/* Polynomials in time: what the equations of the rod say of the nodes of a step. */
#include "tools/surrogate/training_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Row `from`, of n numbers of the state and `all` of inputs, becomes row `to` <= from. */
static void move(size_t n, size_t all, surrogate_steps *steps, size_t from, size_t to)
{
    memmove(steps->state + to * n, steps->state + from * n, n * sizeof *steps->state);
    memmove(steps->next + to * n, steps->next + from * n, n * sizeof *steps->next);
    memmove(steps->input + to * all, steps->input + from * all, all * sizeof *steps->input);
}

ad_status surrogate_add_nodes(surrogate_training *t, const excitation_rollouts *motions,
                              size_t from, surrogate_steps *steps, ad_error *error)
{
    const size_t n = (size_t)motions->states, each = SURROGATE_NODES * n;
    const size_t given = (size_t)motions->inputs * (t->settings->hold == SURROGATE_RAMP ? 2 : 1);
    const size_t rows = (size_t)motions->count * (size_t)motions->steps;
    size_t to = from;
    double *nodes = malloc((rows + 1) * each * sizeof *nodes);
    bool fine = nodes != NULL;
    for (int i = 0; i < SURROGATE_INNER; i++) {
        double *grown = realloc(steps->inner[i], (steps->count + 1) * n * sizeof *grown);
        steps->inner[i] = grown ? grown : steps->inner[i];
        fine = fine && grown;
    }
    ad_status status = fine ? surrogate_collocate(t, motions, nodes, error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for nodes of steps");
    for (int i = 0; i < motions->count && status == AD_OK; i++) {
        for (int k = 0; k < motions->done[i]; k++, from++) {
            const double *of = nodes + ((size_t)i * (size_t)motions->steps + (size_t)k) * each;
            if (isnan(of[0])) {
                continue;
            }
            move(n, given, steps, from, to);
            memcpy(steps->next + to * n, of + SURROGATE_INNER * n, n * sizeof *of);
            for (int s = 0; s < SURROGATE_INNER; s++) {
                memcpy(steps->inner[s] + to * n, of + (size_t)s * n, n * sizeof *of);
            }
            to++;
        }
    }
    steps->count = status == AD_OK ? to : steps->count;
    free(nodes);
    return status;
}

ad_status surrogate_find_inner(surrogate_training *t, ad_error *error)
{
    const size_t each = surrogate_step_numbers(&t->step);
    const surrogate_numbers end = surrogate_numbers_of(&t->step, t->numbers);
    ad_status status = AD_OK;
    for (int i = 0; i < SURROGATE_INNER && status == AD_OK; i++) {
        double *own = t->numbers + (size_t)(i + 1) * each;
        surrogate_steps steps = t->steps;
        steps.next = t->steps.inner[i];
        memcpy(own, t->numbers, each * sizeof *own);
        t->inner[i] = t->step;
        t->inner[i].numbers = own;
        status = surrogate_fit_linear(t->pool, &t->inner[i], own, &steps, error);
        /* the frame is that of the end */
        memcpy(own + (end.lead - t->numbers), end.lead,
               (size_t)(end.state_range - end.lead) * sizeof *own);
    }
    return status;
}
