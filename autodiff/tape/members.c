/* Values of members among those of points: what has one block per member is recorded as such, and
 * spread over the points where it meets a value that varies over them. */
#include "autodiff/tape/tape.h"

#include <stdlib.h>

enum { PARTS_MAX = 16 };

/* x, or the value of members that it spreads: operations on such values alone are a member's. */
static ad_value gathered(ad_value x)
{
    const node *n = node_of(x);
    return n->op == OP_SPREAD                  ? argument_of(x, 0)
           : n->op == OP_STACK && n->whole > 0 ? value_of(x.tape, n->whole - 1)
                                               : x;
}

static ad_value spread(ad_value x)
{
    node n = {.op = OP_SPREAD, .extent = AD_BATCH, .rows = ad_rows(x), .count = 1};
    return node_of(x)->extent == AD_MEMBER ? ad_tape_append(x.tape, n, &x) : x;
}

/* A few parts above one another are spread one by one, so that zeros among them fold. */
static ad_value spread_parts(ad_value x)
{
    node n = *node_of(x);
    ad_value parts[PARTS_MAX];
    if (n.op != OP_STACK || n.extent != AD_MEMBER || n.count > PARTS_MAX) {
        return spread(x);
    }
    for (int i = 0; i < n.count; i++) {
        parts[i] = spread(argument_of(x, i));
        if (!ad_is_valid(parts[i])) {
            return parts[i];
        }
    }
    n.extent = AD_BATCH;
    n.whole = x.id + 1;
    return ad_tape_append(x.tape, n, parts);
}

ad_extent ad_members_gather(int count, ad_value *arguments)
{
    ad_extent widest = AD_UNIFORM;
    for (int i = 0; i < count; i++) {
        arguments[i] = gathered(arguments[i]);
        ad_extent extent = (ad_extent)node_of(arguments[i])->extent;
        widest = extent > widest ? extent : widest;
    }
    return widest;
}

bool ad_members_spread(int op, int count, ad_value *arguments)
{
    for (int i = 0; i < count; i++) {
        arguments[i] = op_is_elementwise(op) ? spread_parts(arguments[i]) : spread(arguments[i]);
        if (!ad_is_valid(arguments[i])) {
            return false;
        }
    }
    return true;
}
