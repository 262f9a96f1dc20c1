#include "tools/surrogate/surrogate_curve.h"

#include "tools/surrogate/training_parts.h"

#include <string.h>

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

/* The same of the base at t; work [order n + decoupled_work]. */
static void add_base(const decoupled *base, double by, double t, double *work,
                     const surrogate_numbers *to)
{
    const size_t n = (size_t)base->states, inputs = (size_t)base->inputs;
    const size_t given = (size_t)decoupled_given(base), order = n + given + 1;
    const double *center = base->numbers, *scale = center + n, *u_center = scale + n;
    const double *u_scale = u_center + inputs;
    double *flow = work;
    decoupled_flow(base, t, work + n * order, flow);
    for (size_t r = 0; r < n; r++) {
        const double *row = flow + r * order;
        double sum = row[order - 1];
        for (size_t k = 0; k < n; k++) {
            sum += row[k] * (to->state_center[k] - center[k]) / scale[k];
            to->linear[k * n + r] += by * scale[r] * row[k] / scale[k];
        }
        for (size_t k = 0; k < given; k++) {
            const size_t i = k % inputs;
            sum += row[n + k] * (to->input_center[k] - u_center[i]) / u_scale[i];
            to->linear[(n + k) * n + r] += by * scale[r] * row[n + k] / u_scale[i];
        }
        to->next_center[r] += by * (center[r] + scale[r] * sum);
    }
}

size_t surrogate_curve_work(const decoupled *base)
{
    return (size_t)(base->states * (base->states + decoupled_given(base) + 1)) +
           decoupled_work(base);
}

void surrogate_curve_at(const surrogate_step *end, const double *inner, const decoupled *base,
                        double t, double *work, double *numbers)
{
    const size_t size = surrogate_step_numbers(end);
    const surrogate_numbers to = surrogate_numbers_of(end, numbers);
    memcpy(numbers, end->numbers, size * sizeof *numbers);
    add(end, -1, end->numbers, numbers); /* 0 */
    for (size_t i = 0; i <= SURROGATE_INNER; i++) {
        const double own = decoupled_nodes[i];
        double by = t / own;
        for (size_t j = 0; j <= SURROGATE_INNER; j++) {
            by *= j == i ? 1 : (t - decoupled_nodes[j]) / (own - decoupled_nodes[j]);
        }
        add(end, by, i < SURROGATE_INNER ? inner + i * size : end->numbers, numbers);
        add_base(base, -by, own, work, &to);
    }
    add_base(base, 1, t, work, &to);
}
