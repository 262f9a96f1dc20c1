/* A value with another in place of a variable; and whether one value needs another. */
#include "autodiff/tape/transform.h"

#include <stdlib.h>

/* y with `to` in place of the leaf x. */
static ad_value rewrite(ad_value y, ad_value x, ad_value to, dependence *d, bool *needed,
                        int *renamed, ad_value *arguments)
{
    ad_tape *tape = y.tape;
    for (int id = y.id; id >= 0; id--) { /* what y does not need stays out of it */
        d->on[id] = d->on[id] && (id == y.id || needed[id]);
        for (int i = 0; d->on[id] && id != x.id && i < tape->nodes[id].count; i++) {
            needed[tape->arguments[tape->nodes[id].first + i]] = true;
        }
    }
    for (int id = 0; id <= y.id; id++) {
        renamed[id] = id == x.id ? to.id : id;
        if (!d->on[id] || id == x.id) {
            continue;
        }
        for (int i = 0; i < tape->nodes[id].count; i++) {
            arguments[i] = value_of(tape, renamed[tape->arguments[tape->nodes[id].first + i]]);
        }
        renamed[id] = ad_transform_apply(value_of(tape, id), arguments).id;
    }
    return value_of(tape, renamed[y.id]);
}

static ad_value replace(ad_value y, ad_value x, ad_value to)
{
    ad_tape *tape = y.tape;
    dependence d = {.tape = tape};
    int widest = 0;
    for (int id = 0; id <= y.id; id++) {
        widest = tape->nodes[id].count > widest ? tape->nodes[id].count : widest;
    }
    int *renamed = malloc((size_t)tape->count * sizeof *renamed);
    ad_value *arguments = malloc(((size_t)widest + 1) * sizeof *arguments);
    bool *needed = calloc((size_t)tape->count, sizeof *needed);
    ad_value result = ad_tape_failed(tape);
    if (!renamed || !arguments || !needed || !ad_dependence_extend(&d)) {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory in a substitution");
    } else {
        ad_dependence_mark(&d, x.id);
        result = rewrite(y, x, to, &d, needed, renamed, arguments);
    }
    free(renamed);
    free(arguments);
    free(needed);
    free(d.on);
    return result;
}

ad_value ad_substitute(ad_value y, ad_value x, ad_value replacement)
{
    ad_tape *tape = y.tape;
    if (!tape || !ad_transform_usable(y, "substitution", tape) ||
        !ad_transform_variable(x, "variable of a substitution", tape) ||
        !ad_transform_usable(replacement, "substitution", tape)) {
        return (ad_value){tape, -1};
    }
    if (ad_rows(replacement) == 1 && ad_rows(x) > 1) {
        replacement = ad_repeat(replacement, ad_rows(x));
    }
    if (ad_rows(replacement) != ad_rows(x)) {
        ad_tape_fail(tape, AD_BAD_SHAPE, "substitution of %d rows for a variable of %d",
                     ad_rows(replacement), ad_rows(x));
        return ad_tape_failed(tape);
    }
    return replace(y, x, replacement);
}

/* ---- calls --------------------------------------------------------------------------------- */

/* A node of a tape, recorded anew on that of its arguments. */
static ad_value copy_node(const ad_tape *from, int id, ad_tape *to, const int *copied,
                          ad_value *arguments)
{
    const node *n = &from->nodes[id];
    if (n->op == OP_CONSTANT) {
        return n->splat ? ad_repeat(ad_scalar(to, n->number), n->rows)
                        : ad_constant(to, n->rows, from->numbers + n->offset);
    }
    if (n->count == 0) {
        ad_tape_fail(to, AD_BAD_ARGUMENT, "'%s' of a called formula has no value",
                     ad_tape_name(from, id));
        return ad_tape_failed(to);
    }
    for (int i = 0; i < n->count; i++) {
        arguments[i] = value_of(to, copied[from->arguments[n->first + i]]);
        if (arguments[i].id < 0) {
            return ad_tape_failed(to);
        }
    }
    return ad_tape_record(to, n->op, n->count, arguments, n->whole, n->number, n->rows);
}

ad_status ad_call(int count, const ad_value *formula, int inputs, const ad_value *input,
                  ad_tape *tape, const ad_value *values, ad_value *results)
{
    const ad_tape *from = formula[0].tape;
    int last = 0, widest = 0;
    bool usable = ad_tape_status(from, &tape->error) == AD_OK && tape->error.status == AD_OK;
    for (int i = 0; i < inputs && usable; i++) {
        usable = ad_transform_usable(values[i], "argument of a call", tape);
    }
    for (int i = 0; i < count && usable; i++) {
        last = formula[i].id > last ? formula[i].id : last;
    }
    for (int id = 0; id <= last && usable; id++) {
        widest = from->nodes[id].count > widest ? from->nodes[id].count : widest;
    }
    int *copied = usable ? malloc(((size_t)last + 1) * sizeof *copied) : NULL;
    bool *needed = usable ? calloc((size_t)last + 1, sizeof *needed) : NULL;
    ad_value *arguments = usable ? malloc(((size_t)widest + 1) * sizeof *arguments) : NULL;
    if (copied && needed && arguments) {
        for (int i = 0; i < count; i++) {
            needed[formula[i].id] = true;
        }
        for (int id = last; id >= 0; id--) {
            for (int i = 0; needed[id] && i < from->nodes[id].count; i++) {
                needed[from->arguments[from->nodes[id].first + i]] = true;
            }
        }
        for (int id = 0; id <= last; id++) {
            copied[id] = -1;
            for (int i = 0; i < inputs; i++) {
                copied[id] = input[i].id == id ? values[i].id : copied[id];
            }
            if (needed[id] && copied[id] < 0) {
                copied[id] = copy_node(from, id, tape, copied, arguments).id;
            }
        }
    } else if (usable) {
        ad_tape_fail(tape, AD_NO_MEMORY, "out of memory in a call");
    }
    for (int i = 0; i < count; i++) {
        results[i] = value_of(tape, copied && needed && arguments ? copied[formula[i].id] : -1);
    }
    free(copied);
    free(needed);
    free(arguments);
    return ad_tape_status(tape, NULL);
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
            if (!needed) {
                ad_tape_fail(x.tape, AD_NO_MEMORY, "out of memory while looking for a use");
                return false;
            }
            needed[y[i].id] = true;
            used = reaches(x.tape, y[i].id, x.id, needed);
            free(needed);
        }
    }
    return used;
}
