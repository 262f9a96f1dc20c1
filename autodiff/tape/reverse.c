/* Adjoints of a scalar, appended to the tape. */
#include "autodiff/tape/transform.h"

#include <stdlib.h>

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
    ad_extent from = ad_extent_of(y), to = ad_extent_of(x);
    if (to < from && r->reduction == AD_SUMMED) {
        contribution = ad_tape_sum(contribution, to == AD_MEMBER     ? OF_MEMBER
                                                 : from == AD_MEMBER ? OVER_MEMBERS
                                                                     : OVER_POINTS);
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
        return ad_tape_failed(r->tape);
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
    const op_row *row = &ad_op_table[node_of(y)->op];
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

static void reverse_node(reverse *r, ad_value y, ad_value adjoint)
{
    int op = node_of(y)->op, count = node_of(y)->count;
    if (op_is_reduction(op) && r->reduction == AD_PER_POINT) {
        ad_tape_fail(r->tape, AD_NO_RULE, "%s: a row of a Jacobian cannot pass a sum over points",
                     ad_op_table[op].name);
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

/* A parameter that no operation has seen is most likely another one than the caller means: the same
 * numbers recorded with another offset or other rows. */
static bool is_known(reverse *r, ad_value root, ad_value x)
{
    const node *n = node_of(x);
    if (n->op != OP_PARAMETER || n->used || x.id == root.id) {
        return true;
    }
    ad_tape_fail(r->tape, AD_BAD_ARGUMENT,
                 "reverse transform by the parameter %s, %d rows from %zu on: nothing on the tape "
                 "uses it; give the offset and rows that the operations were recorded with",
                 ad_tape_name(r->tape, x.id), n->rows, n->offset);
    return false;
}

static bool reverse_begin(reverse *r, ad_value root, int count, const ad_value *wrt)
{
    r->adjoints = malloc(((size_t)root.id + 1) * sizeof *r->adjoints);
    for (int id = 0; r->adjoints && id <= root.id; id++) {
        r->adjoints[id] = (growing){-1, NULL};
    }
    if (!r->adjoints || !ad_dependence_extend(&r->depends)) {
        ad_tape_fail(r->tape, AD_NO_MEMORY, "out of memory in a reverse transform");
        return false;
    }
    for (int i = 0; i < count; i++) {
        if (!ad_transform_variable(wrt[i], "variable of a reverse transform", r->tape) ||
            !is_known(r, root, wrt[i])) {
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
    if (!ad_transform_usable(root, "root of a reverse transform", tape)) {
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
            adjoints[i] = id >= 0 ? value_of(tape, id) : ad_transform_zeros(wrt[i]);
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
        ad_transform_fail(root.tape, count, adjoints);
    }
    return status;
}
