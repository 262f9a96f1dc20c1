/* Taylor coefficients along a direction, appended to the tape. */
#include "autodiff/tape/transform.h"

#include <stdlib.h>

typedef struct taylor {
    ad_tape *tape;
    dependence depends;
    int moving; /* variables, each along its direction */
    const ad_value *x, *direction;
    int order;
    int *known; /* [nodes][order + 1] ids, -2: not yet computed */
    int known_count, known_capacity;
} taylor;

static ad_value coefficient(taylor *t, ad_value y, int k);

static bool taylor_extend(taylor *t)
{
    int width = t->order + 1, needed = t->tape->count * width;
    if (!ad_dependence_extend(&t->depends) ||
        !ad_tape_grow((void **)&t->known, &t->known_capacity, needed, sizeof *t->known)) {
        ad_tape_fail(t->tape, AD_NO_MEMORY, "out of memory in a Taylor transform");
        return false;
    }
    for (; t->known_count < needed; t->known_count++) {
        t->known[t->known_count] = -2;
    }
    return true;
}

static ad_value coefficient_linear(taylor *t, ad_value y, int k)
{
    int count = node_of(y)->count;
    ad_value fixed[AD_ARITY_MAX] = {{NULL, -1}};
    ad_value *arguments = count <= AD_ARITY_MAX ? fixed : malloc((size_t)count * sizeof *arguments);
    if (!arguments) {
        ad_tape_fail(t->tape, AD_NO_MEMORY, "out of memory in a Taylor transform");
        return ad_tape_failed(t->tape);
    }
    for (int i = 0; i < count; i++) {
        bool frozen = node_of(y)->op == OP_SELECT && i == 0;
        arguments[i] = frozen ? argument_of(y, 0) : coefficient(t, argument_of(y, i), k);
    }
    ad_value result = ad_transform_apply(y, arguments);
    if (arguments != fixed) {
        free(arguments);
    }
    return result;
}

/* sum_i op(a_i, b_(k-i)); of a square, each pair once. */
static ad_value coefficient_bilinear(taylor *t, ad_value y, int k)
{
    ad_value a = argument_of(y, 0), b = argument_of(y, 1);
    bool square = a.id == b.id && node_of(y)->op == OP_MUL;
    ad_value sum = ad_transform_zeros(y);
    for (int i = 0; i <= k && (!square || 2 * i <= k); i++) {
        ad_value pair[2] = {coefficient(t, a, i), coefficient(t, b, k - i)};
        ad_value product = ad_transform_apply(y, pair);
        sum = ad_add(sum, square && 2 * i < k ? ad_scale(product, 2) : product);
    }
    return sum;
}

/* y' = sum_i partial_i x_i'  =>  k y_k = sum_i sum_(j=1..k) j x_(i,j) partial_(i,k-j) */
static ad_value coefficient_smooth(taylor *t, ad_value y, int k)
{
    int count = node_of(y)->count;
    ad_value sum = ad_transform_zeros(y);
    for (int i = 0; i < count; i++) {
        ad_value partial = ad_op_table[node_of(y)->op].partial(y, i);
        for (int j = 1; j <= k; j++) {
            ad_value x = coefficient(t, argument_of(y, i), j);
            if (!ad_is_constant(x, 0)) {
                ad_value product = ad_mul(x, coefficient(t, partial, k - j));
                sum = ad_add(sum, ad_scale(product, (double)j / k));
            }
        }
    }
    return sum;
}

static ad_value coefficient_compute(taylor *t, ad_value y, int k)
{
    switch (ad_op_table[node_of(y)->op].kind) {
    case LINEAR:
    case SELECT:
        return coefficient_linear(t, y, k);
    case BILINEAR:
        return coefficient_bilinear(t, y, k);
    case SMOOTH:
        return coefficient_smooth(t, y, k);
    default:
        return ad_transform_zeros(y);
    }
}

static ad_value coefficient(taylor *t, ad_value y, int k)
{
    if (k == 0 || !ad_is_valid(y) || !taylor_extend(t)) {
        return y;
    }
    for (int i = 0; i < t->moving; i++) {
        if (y.id == t->x[i].id) {
            return k == 1 ? t->direction[i] : ad_transform_zeros(y);
        }
    }
    if (!t->depends.on[y.id]) {
        return ad_transform_zeros(y);
    }
    int *slot = &t->known[y.id * (t->order + 1) + k];
    if (*slot == -2) {
        ad_value result = coefficient_compute(t, y, k);
        if (!ad_is_valid(result) || !taylor_extend(t)) {
            return ad_tape_failed(t->tape);
        }
        t->known[y.id * (t->order + 1) + k] = result.id; /* the array may have moved */
        return result;
    }
    return value_of(t->tape, *slot);
}

/* In the order of the tape, for what y needs: keeps the recursion of `coefficient` shallow. */
static void coefficients_in_order(taylor *t, ad_value y)
{
    int end = y.id + 1;
    bool *needed = calloc((size_t)end, sizeof *needed);
    if (!needed) {
        ad_tape_fail(t->tape, AD_NO_MEMORY, "out of memory in a Taylor transform");
        return;
    }
    needed[y.id] = true;
    for (int id = y.id; id >= 0; id--) {
        const node *n = &t->tape->nodes[id];
        for (int i = 0; needed[id] && i < n->count; i++) {
            needed[t->tape->arguments[n->first + i]] = true;
        }
    }
    for (int id = 0; id < end; id++) {
        for (int k = 1; k <= t->order && needed[id] && t->depends.on[id]; k++) {
            coefficient(t, value_of(t->tape, id), k);
        }
    }
    free(needed);
}

/* The direction, with the rows of its variable; failed where it has others. */
static ad_value direction_of(ad_tape *tape, ad_value x, ad_value direction)
{
    if (!ad_transform_variable(x, "Taylor variable", tape) ||
        !ad_transform_usable(direction, "Taylor direction", tape)) {
        return ad_tape_failed(tape);
    }
    if (ad_rows(direction) == 1 && ad_rows(x) > 1) {
        direction = ad_repeat(direction, ad_rows(x));
    }
    if (ad_rows(direction) != ad_rows(x)) {
        ad_tape_fail(tape, AD_BAD_SHAPE, "Taylor direction of %d rows for a variable of %d",
                     ad_rows(direction), ad_rows(x));
        return ad_tape_failed(tape);
    }
    return direction;
}

/* coefficients: `first` .. order of each y. */
static ad_status taylor_record(taylor *t, int count, const ad_value *y, int first,
                               ad_value *coefficients)
{
    ad_tape *tape = t->tape;
    if (taylor_extend(t)) {
        for (int i = 0; i < t->moving; i++) {
            ad_dependence_mark(&t->depends, t->x[i].id);
        }
        for (int i = 0; i < count && ad_transform_usable(y[i], "Taylor function", tape); i++) {
            coefficients_in_order(t, y[i]);
            for (int k = first; k <= t->order; k++) {
                *coefficients++ = coefficient(t, y[i], k);
            }
        }
    }
    free(t->known);
    free(t->depends.on);
    return tape->error.status;
}

ad_status ad_taylor(int count, const ad_value *y, ad_value x, ad_value direction, int order,
                    ad_value *coefficients)
{
    ad_tape *tape = x.tape;
    if (!tape || order < 0) {
        return AD_BAD_ARGUMENT;
    }
    direction = direction_of(tape, x, direction);
    taylor t = {.tape = tape, .depends = {.tape = tape}, .order = order};
    t.moving = 1;
    t.x = &x;
    t.direction = &direction;
    ad_status status = tape->error.status;
    if (status == AD_OK) {
        status = taylor_record(&t, count, y, 0, coefficients);
    }
    if (status != AD_OK) {
        ad_transform_fail(tape, count * (order + 1), coefficients);
    }
    return status;
}

ad_status ad_directional(int count, const ad_value *y, int wrt_count, const ad_value *wrt,
                         const ad_value *directions, ad_value *derivatives)
{
    ad_tape *tape = wrt_count > 0 ? wrt[0].tape : NULL;
    if (!tape) {
        return AD_BAD_ARGUMENT;
    }
    ad_value *along = malloc((size_t)wrt_count * sizeof *along);
    if (!along) {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory in a Taylor transform");
    }
    for (int i = 0; along && i < wrt_count; i++) {
        along[i] = direction_of(tape, wrt[i], directions[i]);
    }
    taylor t = {.tape = tape, .depends = {.tape = tape}, .order = 1};
    t.moving = wrt_count;
    t.x = wrt;
    t.direction = along;
    ad_status status = tape->error.status;
    if (status == AD_OK) {
        status = taylor_record(&t, count, y, 1, derivatives);
    }
    free(along);
    if (status != AD_OK) {
        ad_transform_fail(tape, count, derivatives);
    }
    return status;
}

ad_value ad_derivative(ad_value y, ad_value x, int order)
{
    enum { ORDER_MAX = 16 };
    ad_value coefficients[ORDER_MAX + 1];
    if (!x.tape) {
        return x;
    }
    if (x.tape->error.status != AD_OK) {
        return ad_tape_failed(x.tape);
    }
    if (order < 0 || order > ORDER_MAX || ad_rows(x) != 1) {
        ad_tape_fail(x.tape, AD_BAD_ARGUMENT,
                     "derivative of order %d in %d variables; order 0 to %d in one is available",
                     order, ad_rows(x), ORDER_MAX);
        return ad_tape_failed(x.tape);
    }
    if (ad_taylor(1, &y, x, ad_scalar(x.tape, 1), order, coefficients) != AD_OK) {
        return ad_tape_failed(x.tape);
    }
    double factorial = 1;
    for (int i = 2; i <= order; i++) {
        factorial *= i;
    }
    return ad_scale(coefficients[order], factorial);
}
