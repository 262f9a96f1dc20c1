/* What needs only points and what is set before a run is computed once for both, not in every step:
 * loads, prescribed motion, the forcing of a manufactured solution, where a window starts. */
#include "autodiff/tape/transform.h"

#include <stdlib.h>

enum { HEAVY_OPERATION = 8, HEAVY_MAX = 1 << 20 };

/* Working memory, arrays by node id. */
typedef struct precompute {
    ad_tape *tape;
    int count;    /* nodes below it are looked at */
    bool *needed; /* by an output */
    bool *varies; /* from run to run over the same points */
    bool *taken;  /* becomes an input */
    int *work;    /* operations that it takes, the shared counted each time */
    int *renamed; /* its new id */
} precompute;

static int argument(const precompute *h, int id, int i)
{
    return h->tape->arguments[h->tape->nodes[id].first + i];
}

static void mark_needed(precompute *h, int count, const ad_value *outputs)
{
    for (int i = 0; i < count; i++) {
        h->needed[outputs[i].id] = true;
    }
    for (int id = h->count - 1; id >= 0; id--) {
        for (int i = 0; h->needed[id] && i < h->tape->nodes[id].count; i++) {
            h->needed[argument(h, id, i)] = true;
        }
    }
}

static void mark_varying(precompute *h, int count, const ad_value *varying)
{
    for (int i = 0; i < count; i++) {
        h->varies[varying[i].id] = true;
    }
    for (int id = 0; id < h->count; id++) {
        const node *n = &h->tape->nodes[id];
        h->varies[id] =
            h->varies[id] || n->op == OP_PARAMETER || n->op == OP_POINTS || op_is_reduction(n->op);
        h->work[id] = n->count == 0                       ? 0
                      : ad_op_table[n->op].kind == SMOOTH ? HEAVY_OPERATION
                      : n->op == OP_SLICE || n->op == OP_STACK || n->op == OP_SPREAD ? 0
                                                                                     : 1;
        for (int i = 0; i < n->count; i++) {
            int x = argument(h, id, i);
            h->varies[id] = h->varies[id] || h->varies[x];
            h->work[id] += h->work[x];
        }
        h->work[id] = h->work[id] < HEAVY_MAX ? h->work[id] : HEAVY_MAX;
    }
}

/* Values that do not vary but are used by one that does, and are worth an input. */
static int choose(precompute *h, int least, int rows, ad_value *fixed)
{
    int count = 0, used = 0;
    for (int id = 0; id < h->count; id++) {
        const node *user = &h->tape->nodes[id];
        bool outside = h->needed[id] && (h->varies[id] || op_is_reduction(user->op));
        for (int i = 0; outside && i < user->count; i++) {
            int x = argument(h, id, i);
            x = h->tape->nodes[x].op == OP_SPREAD ? argument(h, x, 0) : x;
            const node *n = &h->tape->nodes[x];
            if (!h->taken[x] && !h->varies[x] && n->extent != AD_UNIFORM && h->work[x] >= least &&
                used + n->rows <= rows) {
                h->taken[x] = true;
                used += n->rows;
                fixed[count++] = value_of(h->tape, x);
            }
        }
    }
    return count;
}

static ad_value rename_arguments(precompute *h, int id, ad_value *arguments)
{
    bool changed = false;
    int count = h->tape->nodes[id].count;
    for (int i = 0; i < count; i++) {
        int x = argument(h, id, i);
        arguments[i] = value_of(h->tape, h->renamed[x]);
        changed = changed || h->renamed[x] != x;
    }
    return changed ? ad_transform_apply(value_of(h->tape, id), arguments) : value_of(h->tape, id);
}

static void rewrite(precompute *h, int fixed_count, const ad_value *fixed, ad_value *arguments)
{
    for (int id = 0; id < h->count; id++) {
        h->renamed[id] = id;
    }
    for (int i = 0; i < fixed_count; i++) {
        bool member = ad_extent_of(fixed[i]) == AD_MEMBER;
        h->renamed[fixed[i].id] =
            (member ? ad_input_member : ad_input)(h->tape, "fixed", ad_rows(fixed[i])).id;
    }
    for (int id = 0; id < h->count; id++) {
        if (h->needed[id] && !h->taken[id]) {
            h->renamed[id] = rename_arguments(h, id, arguments).id;
        }
    }
}

ad_status ad_precompute(int count, ad_value *outputs, int varying_count, const ad_value *varying,
                        int least, int rows, ad_value *fixed, int *fixed_count)
{
    ad_tape *tape = outputs[0].tape;
    *fixed_count = 0;
    precompute h = {.tape = tape, .count = tape->count};
    for (int i = 0; i < count; i++) {
        if (!ad_transform_usable(outputs[i], "output", tape)) {
            return tape->error.status;
        }
    }
    size_t nodes = (size_t)h.count;
    h.needed = calloc(3 * nodes, sizeof *h.needed);
    h.work = malloc(2 * nodes * sizeof *h.work);
    ad_value *arguments = malloc((size_t)tape->argument_count * sizeof *arguments);
    if (h.needed && h.work && arguments) {
        h.varies = h.needed + nodes;
        h.taken = h.needed + 2 * nodes;
        h.renamed = h.work + nodes;
        mark_needed(&h, count, outputs);
        mark_varying(&h, varying_count, varying);
        *fixed_count = choose(&h, least, rows, fixed);
        rewrite(&h, *fixed_count, fixed, arguments);
        for (int i = 0; i < count; i++) {
            outputs[i] = value_of(tape, h.renamed[outputs[i].id]);
        }
    } else {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory while hoisting");
    }
    free(h.needed);
    free(h.work);
    free(arguments);
    return tape->error.status;
}
