#include "tools/surrogate/surrogate_curve.h"

#include <string.h>

typedef struct curve_parts {
#define CURVE_FIELD(name, count) double *name;
    SURROGATE_STEP_NUMBERS(CURVE_FIELD)
#undef CURVE_FIELD
    double *output; /* layer of the network */
} curve_parts;

/* Returns how many numbers the output layer has. */
static size_t find_parts(const surrogate_step *end, double *numbers, curve_parts *x)
{
    const size_t n = (size_t)end->states, m = (size_t)end->inputs * (end->ramps ? 2 : 1);
    const size_t blocks = (size_t)surrogate_step_blocks(end), c = (size_t)end->drives;
    surrogate_step hidden = *end; /* the same without an output */
    double *at = numbers;
#define CURVE_PLACE(name, count)                                                                   \
    x->name = at;                                                                                  \
    at += (count);
    SURROGATE_STEP_NUMBERS(CURVE_PLACE)
#undef CURVE_PLACE
    hidden.out_pairs = hidden.out_evens = hidden.out_odds = 0;
    const size_t before = surrogate_step_parameters(&hidden);
    x->output = at + before;
    return surrogate_step_parameters(end) - before;
}

/* to += by from, of what nodes do not have in common. */
static void add(const surrogate_step *end, double by, const curve_parts *from, size_t outputs,
                const curve_parts *to)
{
    const size_t n = (size_t)end->states, m = (size_t)end->inputs * (end->ramps ? 2 : 1);
    const size_t size = (size_t)surrogate_step_blocks(end) * (n + m) * n;
    for (size_t k = 0; k < n; k++) {
        to->next_center[k] += by * from->next_center[k];
    }
    for (size_t k = 0; k < size; k++) {
        to->linear[k] += by * from->linear[k];
    }
    for (size_t k = 0; k < outputs; k++) {
        to->output[k] += by * from->output[k];
    }
}

/* The same of the base at t; work [order n + decoupled_work]. */
static void add_base(const decoupled *base, double by, double t, double *work,
                     const curve_parts *to)
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
    curve_parts to, from;
    memcpy(numbers, end->numbers, size * sizeof *numbers);
    const size_t outputs = find_parts(end, numbers, &to);
    const curve_parts none = to;
    add(end, -1, &none, outputs, &to);
    for (size_t i = 0; i <= SURROGATE_INNER; i++) {
        const double own = decoupled_nodes[i];
        double by = t / own;
        for (size_t j = 0; j <= SURROGATE_INNER; j++) {
            by *= j == i ? 1 : (t - decoupled_nodes[j]) / (own - decoupled_nodes[j]);
        }
        find_parts(end, (double *)(i < SURROGATE_INNER ? inner + i * size : end->numbers), &from);
        add(end, by, &from, outputs, &to);
        add_base(base, -by, own, work, &to);
    }
    add_base(base, 1, t, work, &to);
}
