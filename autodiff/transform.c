/* Transforms: each takes a tape and appends to it, in terms of the table's rules. */
#include "autodiff/tape.h"

#include <stdlib.h>

/* ---- dependence ---------------------------------------------------------------------------- */

/* For ids below `count`, grown on demand: does the node depend on the marked ones? */
typedef struct dependence {
    ad_tape *tape;
    bool *on;
    int count, capacity;
} dependence;

static bool dependence_extend(dependence *d)
{
    int known = d->count;
    if (!tape_grow((void **)&d->on, &d->capacity, d->tape->count, sizeof *d->on)) {
        ad_tape_fail(d->tape, AD_NO_MEMORY, "out of memory in a transform");
        return false;
    }
    for (int id = known; id < d->tape->count; id++) {
        const node *n = &d->tape->nodes[id];
        bool on = false;
        for (int i = 0; i < n->count && !on; i++) {
            on = d->on[d->tape->arguments[n->first + i]];
        }
        d->on[id] = on;
    }
    d->count = d->tape->count;
    return true;
}

/* Mark one node, and what is known to depend on it. */
static void dependence_mark(dependence *d, int id)
{
    d->on[id] = true;
    for (int later = id + 1; later < d->count; later++) {
        const node *n = &d->tape->nodes[later];
        for (int i = 0; i < n->count && !d->on[later]; i++) {
            d->on[later] = d->on[d->tape->arguments[n->first + i]];
        }
    }
}

/* ---- Taylor -------------------------------------------------------------------------------- */

typedef struct taylor {
    ad_tape *tape;
    dependence depends;
    ad_value x, direction;
    int order;
    int *known; /* [nodes][order + 1] ids, -2: not yet computed */
    int known_count, known_capacity;
} taylor;

static ad_value coefficient(taylor *t, ad_value y, int k);

static bool taylor_extend(taylor *t)
{
    int width = t->order + 1, needed = t->tape->count * width;
    if (!dependence_extend(&t->depends) ||
        !tape_grow((void **)&t->known, &t->known_capacity, needed, sizeof *t->known)) {
        ad_tape_fail(t->tape, AD_NO_MEMORY, "out of memory in a Taylor transform");
        return false;
    }
    for (; t->known_count < needed; t->known_count++) {
        t->known[t->known_count] = -2;
    }
    return true;
}

static ad_value zeros_like(ad_value y)
{
    return ad_zeros(y.tape, ad_rows(y));
}

/* Apply the linear operation of y to arguments given in place of its own. */
static ad_value apply(ad_value y, const ad_value *arguments)
{
    node n = *node_of(y);
    return tape_record(y.tape, n.op, n.count, arguments, n.whole, n.number, n.rows);
}

static ad_value coefficient_linear(taylor *t, ad_value y, int k)
{
    int count = node_of(y)->count;
    ad_value fixed[AD_ARITY_MAX] = {{NULL, -1}};
    ad_value *arguments = count <= AD_ARITY_MAX ? fixed : malloc((size_t)count * sizeof *arguments);
    if (!arguments) {
        ad_tape_fail(t->tape, AD_NO_MEMORY, "out of memory in a Taylor transform");
        return tape_failed(t->tape);
    }
    for (int i = 0; i < count; i++) {
        bool frozen = node_of(y)->op == OP_SELECT && i == 0;
        arguments[i] = frozen ? argument_of(y, 0) : coefficient(t, argument_of(y, i), k);
    }
    ad_value result = apply(y, arguments);
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
    ad_value sum = zeros_like(y);
    for (int i = 0; i <= k && (!square || 2 * i <= k); i++) {
        ad_value pair[2] = {coefficient(t, a, i), coefficient(t, b, k - i)};
        ad_value product = apply(y, pair);
        sum = ad_add(sum, square && 2 * i < k ? ad_scale(product, 2) : product);
    }
    return sum;
}

/* y' = sum_i partial_i x_i'  =>  k y_k = sum_i sum_(j=1..k) j x_(i,j) partial_(i,k-j) */
static ad_value coefficient_smooth(taylor *t, ad_value y, int k)
{
    int count = node_of(y)->count;
    ad_value sum = zeros_like(y);
    for (int i = 0; i < count; i++) {
        ad_value partial = op_table[node_of(y)->op].partial(y, i);
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

/* d y_k = sum_j f'(x)_(k-j) d x_j for the coefficients of y = f(x), because d y = f'(x) d x as a
 * product of series. Noted for the reverse transform: it takes fewer operations than going back
 * through the recurrence above, and needs no intermediate value of it. */
static void note_partials(taylor *t, ad_value y, int k, ad_value result)
{
    ad_value x = argument_of(y, 0), slope = op_table[node_of(y)->op].partial(y, 0);
    for (int j = 0; j <= k; j++) { /* not if simplification found an older value for y_k */
        if (ad_is_constant(result, 0) || node_of(result)->partials ||
            coefficient(t, x, j).id >= result.id) {
            return;
        }
    }
    for (int j = 0; j <= k; j++) {
        known_partial known = {coefficient(t, x, j).id, coefficient(t, slope, k - j).id, 0};
        if (known.argument < 0 || known.partial < 0 ||
            !tape_grow((void **)&t->tape->partials, &t->tape->partial_capacity,
                       t->tape->partial_count + 1, sizeof known)) {
            ad_tape_fail(t->tape, AD_NO_MEMORY, "out of memory in a Taylor transform");
            return;
        }
        node *n = &t->tape->nodes[result.id];
        known.next = n->partials;
        t->tape->partials[t->tape->partial_count++] = known;
        n->partials = t->tape->partial_count;
    }
}

static ad_value coefficient_compute(taylor *t, ad_value y, int k)
{
    switch (op_table[node_of(y)->op].kind) {
    case LINEAR:
    case SELECT:
        return coefficient_linear(t, y, k);
    case BILINEAR:
        return coefficient_bilinear(t, y, k);
    case SMOOTH:
        return coefficient_smooth(t, y, k);
    default:
        return zeros_like(y);
    }
}

static ad_value coefficient(taylor *t, ad_value y, int k)
{
    if (k == 0 || !ad_is_valid(y) || !taylor_extend(t)) {
        return y;
    }
    if (y.id == t->x.id) {
        return k == 1 ? t->direction : zeros_like(y);
    }
    if (!t->depends.on[y.id]) {
        return zeros_like(y);
    }
    int *slot = &t->known[y.id * (t->order + 1) + k];
    if (*slot == -2) {
        ad_value result = coefficient_compute(t, y, k);
        if (!ad_is_valid(result) || !taylor_extend(t)) {
            return tape_failed(t->tape);
        }
        t->known[y.id * (t->order + 1) + k] = result.id; /* the array may have moved */
        if (op_is_regular(node_of(y)->op)) {
            note_partials(t, y, k, result);
        }
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

static bool usable(ad_value x, const char *what, ad_tape *tape)
{
    if (tape->error.status != AD_OK) {
        return false;
    }
    if (!ad_is_valid(x) || x.tape != tape) {
        ad_tape_fail(tape, AD_BAD_ARGUMENT, "%s is not a value of this tape", what);
        return false;
    }
    return true;
}

/* Simplification may look through any operation, so only leaves are certain to be seen. */
static bool is_variable(ad_value x, const char *what, ad_tape *tape)
{
    if (!usable(x, what, tape)) {
        return false;
    }
    int op = node_of(x)->op;
    if (op != OP_INPUT && op != OP_UNIFORM && op != OP_PARAMETER) {
        ad_tape_fail(tape, AD_BAD_ARGUMENT,
                     "%s is the result of %s; an input, uniform or parameter is needed", what,
                     op_table[op].name);
        return false;
    }
    return true;
}

/* What a transform returns when it fails: values that may be passed on but compute nothing. */
static void fail_all(ad_tape *tape, int count, ad_value *values)
{
    for (int i = 0; i < count; i++) {
        values[i] = tape_failed(tape);
    }
}

static ad_status taylor_record(ad_tape *tape, int count, const ad_value *y, ad_value x,
                               ad_value direction, int order, ad_value *coefficients)
{
    if (!is_variable(x, "Taylor variable", tape) || !usable(direction, "Taylor direction", tape)) {
        return tape->error.status;
    }
    if (ad_rows(direction) == 1 && ad_rows(x) > 1) {
        direction = ad_repeat(direction, ad_rows(x));
    }
    if (ad_rows(direction) != ad_rows(x)) {
        ad_tape_fail(tape, AD_BAD_SHAPE, "Taylor direction of %d rows for a variable of %d",
                     ad_rows(direction), ad_rows(x));
        return tape->error.status;
    }
    taylor t = {.tape = tape, .depends = {.tape = tape}, .x = x, .direction = direction};
    t.order = order;
    if (taylor_extend(&t)) {
        dependence_mark(&t.depends, x.id);
        for (int i = 0; i < count && usable(y[i], "Taylor function", tape); i++) {
            coefficients_in_order(&t, y[i]);
            for (int k = 0; k <= order; k++) {
                coefficients[i * (order + 1) + k] = coefficient(&t, y[i], k);
            }
        }
    }
    free(t.known);
    free(t.depends.on);
    return tape->error.status;
}

ad_status ad_taylor(int count, const ad_value *y, ad_value x, ad_value direction, int order,
                    ad_value *coefficients)
{
    if (!x.tape || order < 0) {
        return AD_BAD_ARGUMENT;
    }
    ad_status status = taylor_record(x.tape, count, y, x, direction, order, coefficients);
    if (status != AD_OK) {
        fail_all(x.tape, count * (order + 1), coefficients);
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
        return tape_failed(x.tape);
    }
    if (order < 0 || order > ORDER_MAX || ad_rows(x) != 1) {
        ad_tape_fail(x.tape, AD_BAD_ARGUMENT,
                     "derivative of order %d in %d variables; order 0 to %d in one is available",
                     order, ad_rows(x), ORDER_MAX);
        return tape_failed(x.tape);
    }
    if (ad_taylor(1, &y, x, ad_scalar(x.tape, 1), order, coefficients) != AD_OK) {
        return tape_failed(x.tape);
    }
    double factorial = 1;
    for (int i = 2; i <= order; i++) {
        factorial *= i;
    }
    return ad_scale(coefficients[order], factorial);
}

/* ---- reverse ------------------------------------------------------------------------------- */

/* Adjoint of a node while it grows: of the whole block, and of single rows that slices took. */
typedef struct growing {
    int whole; /* id or -1 */
    int *rows; /* [rows of the node] ids or -1; NULL until a slice contributes */
} growing;

typedef struct reverse {
    ad_tape *tape;
    dependence depends;
    ad_reduction reduction;
    growing *adjoints; /* [root + 1] */
} reverse;

static ad_value add_to(ad_tape *tape, int id, ad_value x)
{
    return id < 0 ? x : ad_add(value_of(tape, id), x);
}

/* Give a contribution from node y the shape of its argument x: what was broadcast is summed. */
static ad_value fit(reverse *r, ad_value contribution, ad_value y, ad_value x)
{
    if (ad_rows(contribution) > ad_rows(x)) {
        contribution = ad_sum_rows(contribution);
    }
    if (ad_rows(contribution) < ad_rows(x)) {
        contribution = ad_repeat(contribution, ad_rows(x));
    }
    if (ad_extent_of(x) == AD_UNIFORM && ad_extent_of(y) == AD_BATCH && r->reduction == AD_SUMMED) {
        contribution = ad_sum_points(contribution);
    }
    return contribution;
}

/* A slice contributes to some rows: kept apart, so that they meet as parts of one stack. */
static bool contribute_rows(reverse *r, ad_value x, int first, ad_value contribution)
{
    growing *g = &r->adjoints[x.id];
    int height = ad_rows(x);
    if (!g->rows) {
        g->rows = malloc((size_t)height * sizeof *g->rows);
        if (!g->rows) {
            ad_tape_fail(r->tape, AD_NO_MEMORY, "out of memory in a reverse transform");
            return false;
        }
        for (int i = 0; i < height; i++) {
            g->rows[i] = -1;
        }
    }
    for (int i = 0; i < ad_rows(contribution); i++) {
        g->rows[first + i] = add_to(r->tape, g->rows[first + i], ad_row(contribution, i)).id;
    }
    return true;
}

static ad_value settle(reverse *r, int id)
{
    growing *g = &r->adjoints[id];
    int height = r->tape->nodes[id].rows;
    if (!g->rows) {
        return value_of(r->tape, g->whole);
    }
    ad_value *parts = malloc((size_t)height * sizeof *parts);
    if (!parts) {
        ad_tape_fail(r->tape, AD_NO_MEMORY, "out of memory in a reverse transform");
        return tape_failed(r->tape);
    }
    for (int i = 0; i < height; i++) {
        parts[i] = g->rows[i] >= 0 ? value_of(r->tape, g->rows[i]) : ad_zeros(r->tape, 1);
    }
    ad_value stacked = ad_stack(height, parts);
    free(parts);
    free(g->rows);
    g->rows = NULL;
    g->whole = add_to(r->tape, g->whole, stacked).id;
    return value_of(r->tape, g->whole);
}

static ad_value contribution_to(ad_value y, ad_value adjoint, int i)
{
    const op_row *row = &op_table[node_of(y)->op];
    ad_value zero = ad_zeros(y.tape, 1);
    switch (row->kind) {
    case SMOOTH:
        return ad_mul(adjoint, row->partial(y, i));
    case SELECT:
        return i == 1 ? ad_select(argument_of(y, 0), adjoint, zero)
                      : ad_select(argument_of(y, 0), zero, adjoint);
    case FLAT:
        return zero;
    default:
        return row->adjoint(y, adjoint, i);
    }
}

static void contribute(reverse *r, ad_value y, ad_value x, ad_value contribution)
{
    if (ad_is_valid(contribution) && !ad_is_constant(contribution, 0)) {
        growing *g = &r->adjoints[x.id];
        g->whole = add_to(r->tape, g->whole, fit(r, contribution, y, x)).id;
    }
}

static void reverse_known(reverse *r, ad_value y, ad_value adjoint)
{
    for (int i = node_of(y)->partials; i > 0; i = r->tape->partials[i - 1].next) {
        known_partial known = r->tape->partials[i - 1];
        if (r->depends.on[known.argument]) {
            contribute(r, y, value_of(r->tape, known.argument),
                       ad_mul(adjoint, value_of(r->tape, known.partial)));
        }
    }
}

static void reverse_node(reverse *r, ad_value y, ad_value adjoint)
{
    int op = node_of(y)->op, count = node_of(y)->count;
    if (op_is_reduction(op) && r->reduction == AD_PER_POINT) {
        ad_tape_fail(r->tape, AD_NO_RULE, "%s: a row of a Jacobian cannot pass a sum over points",
                     op_table[op].name);
        return;
    }
    if (node_of(y)->partials) {
        reverse_known(r, y, adjoint);
        return;
    }
    for (int i = 0; i < count; i++) {
        ad_value x = argument_of(y, i);
        if (!r->depends.on[x.id] || (op == OP_SELECT && i == 0)) {
            continue;
        }
        if (op == OP_SLICE) {
            contribute_rows(r, x, node_of(y)->whole, adjoint);
            continue;
        }
        contribute(r, y, x, contribution_to(y, adjoint, i));
    }
}

static bool reverse_begin(reverse *r, ad_value root, int count, const ad_value *wrt)
{
    r->adjoints = malloc(((size_t)root.id + 1) * sizeof *r->adjoints);
    for (int id = 0; r->adjoints && id <= root.id; id++) {
        r->adjoints[id] = (growing){-1, NULL};
    }
    if (!r->adjoints || !dependence_extend(&r->depends)) {
        ad_tape_fail(r->tape, AD_NO_MEMORY, "out of memory in a reverse transform");
        return false;
    }
    for (int i = 0; i < count; i++) {
        if (!is_variable(wrt[i], "variable of a reverse transform", r->tape)) {
            return false;
        }
        r->depends.on[wrt[i].id] = true;
    }
    for (int id = 0; id < r->depends.count; id++) {
        const node *n = &r->tape->nodes[id];
        for (int k = 0; k < n->count && !r->depends.on[id]; k++) {
            r->depends.on[id] = r->depends.on[r->tape->arguments[n->first + k]];
        }
    }
    return true;
}

static ad_status reverse_record(ad_tape *tape, ad_value root, int count, const ad_value *wrt,
                                ad_reduction reduction, ad_value *adjoints)
{
    if (!usable(root, "root of a reverse transform", tape)) {
        return tape->error.status;
    }
    if (ad_rows(root) != 1) {
        ad_tape_fail(tape, AD_BAD_SHAPE, "reverse transform of %d rows; a scalar is needed",
                     ad_rows(root));
        return tape->error.status;
    }
    reverse r = {.tape = tape, .depends = {.tape = tape}, .reduction = reduction};
    if (reverse_begin(&r, root, count, wrt)) {
        r.adjoints[root.id].whole = ad_scalar(tape, 1).id;
        for (int id = root.id; id >= 0 && tape->error.status == AD_OK; id--) {
            growing *g = &r.adjoints[id];
            if ((g->whole >= 0 || g->rows) && r.depends.on[id]) {
                reverse_node(&r, value_of(tape, id), settle(&r, id));
            }
        }
        for (int i = 0; i < count && tape->error.status == AD_OK; i++) {
            int id = wrt[i].id <= root.id ? r.adjoints[wrt[i].id].whole : -1;
            adjoints[i] = id >= 0 ? value_of(tape, id) : zeros_like(wrt[i]);
        }
    }
    for (int id = 0; r.adjoints && id <= root.id; id++) {
        free(r.adjoints[id].rows);
    }
    free(r.adjoints);
    free(r.depends.on);
    return tape->error.status;
}

ad_status ad_reverse(ad_value root, int count, const ad_value *wrt, ad_reduction reduction,
                     ad_value *adjoints)
{
    if (!root.tape) {
        return AD_BAD_ARGUMENT;
    }
    ad_status status = reverse_record(root.tape, root, count, wrt, reduction, adjoints);
    if (status != AD_OK) {
        fail_all(root.tape, count, adjoints);
    }
    return status;
}

/* ---- substitution -------------------------------------------------------------------------- */

ad_value ad_substitute(ad_value y, ad_value x, ad_value replacement)
{
    ad_tape *tape = y.tape;
    if (!tape || !usable(y, "substitution", tape) ||
        !is_variable(x, "variable of a substitution", tape) ||
        !usable(replacement, "substitution", tape)) {
        return (ad_value){tape, -1};
    }
    if (ad_rows(replacement) == 1 && ad_rows(x) > 1) {
        replacement = ad_repeat(replacement, ad_rows(x));
    }
    if (ad_rows(replacement) != ad_rows(x)) {
        ad_tape_fail(tape, AD_BAD_SHAPE, "substitution of %d rows for a variable of %d",
                     ad_rows(replacement), ad_rows(x));
        return tape_failed(tape);
    }
    dependence d = {.tape = tape};
    int *renamed = malloc(((size_t)y.id + 1) * sizeof *renamed);
    ad_value result = tape_failed(tape);
    int widest = 0;
    for (int id = 0; id <= y.id; id++) {
        widest = tape->nodes[id].count > widest ? tape->nodes[id].count : widest;
    }
    ad_value *arguments = malloc(((size_t)widest + 1) * sizeof *arguments);
    if (!renamed || !arguments || !dependence_extend(&d)) {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory in a substitution");
    } else {
        dependence_mark(&d, x.id);
        for (int id = 0; id <= y.id; id++) {
            renamed[id] = id == x.id ? replacement.id : id;
            if (!d.on[id] || id == x.id) {
                continue;
            }
            for (int i = 0; i < tape->nodes[id].count; i++) {
                arguments[i] = value_of(tape, renamed[tape->arguments[tape->nodes[id].first + i]]);
            }
            renamed[id] = apply(value_of(tape, id), arguments).id;
        }
        result = value_of(tape, renamed[y.id]);
    }
    free(renamed);
    free(arguments);
    free(d.on);
    return result;
}

/* ---- use --------------------------------------------------------------------------------------
 */

static bool reaches(const ad_tape *tape, int from, int to, bool *needed)
{
    for (int id = from; id > to; id--) {
        const node *n = &tape->nodes[id];
        for (int i = 0; needed[id] && i < n->count; i++) {
            needed[tape->arguments[n->first + i]] = true;
        }
    }
    return needed[to];
}

/* Of a stack, any part will do; a constant factor is looked through, since simplification moves it
 * about. */
bool ad_uses(int count, const ad_value *y, ad_value x)
{
    if (!ad_is_valid(x) || is_constant(x)) {
        return false;
    }
    const node *n = node_of(x);
    if (n->op == OP_STACK) {
        for (int i = 0; i < n->count; i++) {
            if (ad_uses(count, y, argument_of(x, i))) {
                return true;
            }
        }
        return false;
    }
    if (n->op == OP_MUL && is_constant(argument_of(x, 0))) {
        return ad_uses(count, y, argument_of(x, 1));
    }
    bool used = false;
    for (int i = 0; i < count && !used; i++) {
        if (ad_is_valid(y[i]) && y[i].id >= x.id) {
            bool *needed = calloc((size_t)y[i].id + 1, sizeof *needed);
            if (needed) {
                needed[y[i].id] = true;
                used = reaches(x.tape, y[i].id, x.id, needed);
            }
            free(needed);
        }
    }
    return used;
}
