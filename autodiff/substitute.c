/* A value with another in place of a variable; and whether one value needs another. */
#include "autodiff/transform.h"

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
