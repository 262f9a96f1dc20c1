/* What the transforms share. */
#include "autodiff/tape/transform.h"

/* ---- dependence ---------------------------------------------------------------------------- */

bool ad_dependence_extend(dependence *d)
{
    int known = d->count;
    if (!ad_tape_grow((void **)&d->on, &d->capacity, d->tape->count, sizeof *d->on)) {
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

void ad_dependence_mark(dependence *d, int id)
{
    d->on[id] = true;
    for (int later = id + 1; later < d->count; later++) {
        const node *n = &d->tape->nodes[later];
        for (int i = 0; i < n->count && !d->on[later]; i++) {
            d->on[later] = d->on[d->tape->arguments[n->first + i]];
        }
    }
}

/* ---- values ------------------------------------------------------------------------------------
 */

ad_value ad_transform_zeros(ad_value y)
{
    return ad_zeros(y.tape, ad_rows(y));
}

ad_value ad_transform_apply(ad_value y, const ad_value *arguments)
{
    node n = *node_of(y);
    return ad_tape_record(y.tape, n.op, n.count, arguments, n.whole, n.number, n.rows);
}

bool ad_transform_usable(ad_value x, const char *what, ad_tape *tape)
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

bool ad_transform_variable(ad_value x, const char *what, ad_tape *tape)
{
    if (!ad_transform_usable(x, what, tape)) {
        return false;
    }
    int op = node_of(x)->op;
    if (op != OP_INPUT && op != OP_UNIFORM && op != OP_PARAMETER) {
        ad_tape_fail(tape, AD_BAD_ARGUMENT,
                     "%s is the result of %s; an input, uniform or parameter is needed", what,
                     ad_op_table[op].name);
        return false;
    }
    return true;
}

void ad_transform_fail(ad_tape *tape, int count, ad_value *values)
{
    for (int i = 0; i < count; i++) {
        values[i] = ad_tape_failed(tape);
    }
}
