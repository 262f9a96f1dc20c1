#include "tools/surrogate/surrogate_curve.h"

#include "tools/surrogate/training_parts.h"

#include <string.h>

const double surrogate_nodes[SURROGATE_NODES] = {0.15505102572168219, 0.64494897427831781, 1};

/* Numbers of the hidden layers, which come before the output layer. */
static size_t hidden_parameters(const surrogate_step *end)
{
    surrogate_step hidden = *end; /* the same without an output */
    hidden.out_pairs = hidden.out_evens = hidden.out_odds = 0;
    return surrogate_step_parameters(&hidden);
}

/* to += by from, of what nodes do not have in common. */
static void add(const surrogate_step *end, double by, const double *from, double *to)
{
    const surrogate_numbers at = surrogate_numbers_of(end, to);
    const size_t spans[3][2] = {
        {(size_t)(at.next_center - to), (size_t)end->states},
        {(size_t)(at.linear - to), (size_t)(at.state_scale - at.linear)},
        {(size_t)(at.network - to) + hidden_parameters(end),
         surrogate_step_parameters(end) - hidden_parameters(end)},
    };
    for (size_t s = 0; s < 3; s++) {
        for (size_t k = spans[s][0]; k < spans[s][0] + spans[s][1]; k++) {
            to[k] += by * from[k];
        }
    }
}

void surrogate_curve_at(const surrogate_step *end, const double *inner, double t, double *numbers)
{
    const size_t size = surrogate_step_numbers(end), n = (size_t)end->states;
    const surrogate_numbers to = surrogate_numbers_of(end, numbers);
    double begin = 1; /* 1 at 0, and 0 at the nodes */
    memcpy(numbers, end->numbers, size * sizeof *numbers);
    add(end, -1, end->numbers, numbers); /* 0 */
    for (size_t i = 0; i <= SURROGATE_INNER; i++) {
        const double own = surrogate_nodes[i];
        double by = t / own;
        for (size_t j = 0; j <= SURROGATE_INNER; j++) {
            by *= j == i ? 1 : (t - surrogate_nodes[j]) / (own - surrogate_nodes[j]);
        }
        add(end, by, i < SURROGATE_INNER ? inner + i * size : end->numbers, numbers);
        begin *= (own - t) / own;
    }
    for (size_t j = 0; j < n; j++) {
        to.next_center[j] += begin * to.state_center[j];
        to.linear[j * n + j] += begin;
    }
}
