/* Enclosures of formulas over intervals, and the expressions that make them jump or kink. */
#include "physics/quantity/quantity_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Of one operation and its function of the C library, as in quantity_interval.c. */
static const double ROUNDING = 4 * DBL_EPSILON;

typedef struct enclosing {
    quantity_interval x[2]; /* s and t */
    int along;              /* which of them the slope is by */
    bool is_between;        /* nothing of it alone switches within */
} enclosing;

static bool is_number(quantity_interval x, double number)
{
    return x.low == number && x.high == number;
}

static bool is_line(quantity_interval x)
{
    return x.low == -INFINITY && x.high == INFINITY;
}

static double magnitude(quantity_interval x)
{
    return fmax(fabs(x.low), fabs(x.high));
}

static quantity_enclosure whole_line(void)
{
    static const quantity_interval line = {-INFINITY, INFINITY};
    return (quantity_enclosure){line, line, INFINITY};
}

static quantity_enclosure of_number(double number)
{
    return isnan(number) ? whole_line() : (quantity_enclosure){.value = {number, number}};
}

static quantity_enclosure enclose(const enclosing *in, const quantity *q);

/* Whether it is between switches and its argument depends on nothing but the coordinate: what it
 * does in the middle it does everywhere. */
static bool is_settled(const enclosing *in, quantity argument)
{
    uint64_t other = ~(UINT64_C(1) << in->along);
    return in->is_between && (!argument.node || !(argument.node->uses & other));
}

static double in_the_middle(const enclosing *in, quantity x)
{
    return quantity_value(x, quantity_middle(in->x[0]), quantity_middle(in->x[1]));
}

/* Takes from the interval of what decides by its sign the side on which it is not. */
static void settle_sign(const enclosing *in, quantity x, quantity_interval *value)
{
    if (in_the_middle(in, x) > 0) {
        value->low = fmax(value->low, DBL_MIN);
        value->high = fmax(value->high, DBL_MIN);
    } else {
        value->low = fmin(value->low, 0);
        value->high = fmin(value->high, 0);
    }
}

/* The argument that min or max is. */
static int settled_choice(const enclosing *in, const quantity_node *node)
{
    const double x[2] = {in_the_middle(in, node->x[0]), in_the_middle(in, node->x[1])};
    return node->operation->number(x) == x[0] ? 0 : 1;
}

/* By the chain rule. What counts for nothing, as the other branch of where, may be anything. */
static quantity_enclosure enclose_operation(const enclosing *in, const quantity_node *node)
{
    quantity_enclosure x[QUANTITY_ARGUMENTS_MAX], result = {.rounding = 0};
    quantity_interval values[QUANTITY_ARGUMENTS_MAX], by[QUANTITY_ARGUMENTS_MAX];
    bool chooses = node->operation == &quantity_operations[QUANTITY_WHERE];
    quantity_switch switches = node->operation->switches;
    if (switches == QUANTITY_BY_DIFFERENCE && is_settled(in, node->x[0]) &&
        is_settled(in, node->x[1])) {
        return enclose(in, &node->x[settled_choice(in, node)]);
    }
    for (int i = 0; i < node->operation->arity; i++) {
        bool never = chooses && ((i == 1 && values[0].high <= 0) || (i == 2 && values[0].low > 0));
        x[i] = never ? whole_line() : enclose(in, &node->x[i]);
        values[i] = x[i].value;
        if (i == 0 && switches == QUANTITY_BY_SIGN && is_settled(in, node->x[0])) {
            settle_sign(in, node->x[0], &values[0]);
        }
    }
    node->operation->range(values, &result.value, by);
    for (int i = 0; i < node->operation->arity; i++) {
        if (is_number(by[i], 0)) {
            continue;
        }
        if (is_line(values[i])) {
            return whole_line();
        }
        if (!is_number(x[i].slope, 0)) {
            quantity_interval part = quantity_interval_multiply(by[i], x[i].slope);
            result.slope = quantity_interval_add(result.slope, part);
        }
        result.rounding += x[i].rounding > 0 ? x[i].rounding * magnitude(by[i]) : 0;
    }
    result.rounding += ROUNDING * magnitude(result.value);
    result.rounding = isnan(result.rounding) ? INFINITY : result.rounding;
    return result;
}

/* Panels ask for an enclosure some 100,000 times, of which a network of parameters is the same. */
static bool is_still(const quantity_node *node)
{
    return node->kind == QUANTITY_OPERATION && node->uses && !(node->uses & QUANTITY_COORDINATES);
}

quantity_enclosure quantity_enclose_still(const quantity_node *node)
{
    const enclosing nowhere = {.along = 0};
    return is_still(node) ? enclose_operation(&nowhere, node) : (quantity_enclosure){.rounding = 0};
}

static quantity_enclosure enclose(const enclosing *in, const quantity *q)
{
    const quantity_node *node = q->node;
    if (!node || node->uses == 0) {
        return of_number(q->number);
    }
    switch (node->kind) {
    case QUANTITY_OPEN:
        return node->index < 2
                   ? (quantity_enclosure){.value = in->x[node->index],
                                          .slope = {node->index == in->along,
                                                    node->index == in->along}}
                   : (quantity_enclosure){.value = {node->x[1].number, node->x[2].number}};
    case QUANTITY_WRITTEN:
        return enclose(in, &node->x[0]);
    case QUANTITY_OPERATION:
        return is_still(node) ? node->still : enclose_operation(in, node);
    case QUANTITY_UNPARSED:
    case QUANTITY_ERROR:
        break;
    }
    return whole_line();
}

/* The mean value form, f(middle) + slope (x - middle), and where it is narrower, this. */
static void tighten(const enclosing *in, const quantity *q, quantity_enclosure *result)
{
    quantity_interval whole = in->x[in->along];
    double middle = quantity_middle(whole);
    enclosing at = *in;
    at.x[in->along] = (quantity_interval){middle, middle};
    quantity_enclosure there = enclose(&at, q);
    quantity_interval step = {whole.low - middle, whole.high - middle};
    quantity_interval off = quantity_interval_multiply(result->slope, step);
    quantity_interval form = quantity_interval_add(there.value, off);
    double low = form.low - result->rounding, high = form.high + result->rounding;
    result->value.low = low > result->value.low ? low : result->value.low;
    result->value.high = high < result->value.high ? high : result->value.high;
}

static quantity_enclosure enclose_all(const enclosing *in, quantity q)
{
    if (!q.is_given) {
        return whole_line();
    }
    quantity_enclosure result = enclose(in, &q);
    if (in->x[in->along].low < in->x[in->along].high && !is_line(result.slope)) {
        tighten(in, &q, &result);
    }
    return result;
}

static int index_of(const char *coordinate)
{
    return strcmp(coordinate, "s") == 0 ? 0 : 1;
}

quantity_enclosure quantity_enclose(quantity q, const char *coordinate, quantity_interval s,
                                    quantity_interval t)
{
    const enclosing in = {.x = {s, t}, .along = index_of(coordinate)};
    return enclose_all(&in, q);
}

quantity_enclosure quantity_enclose_between(quantity q, const char *coordinate, quantity_interval s,
                                            quantity_interval t)
{
    const enclosing in = {.x = {s, t}, .along = index_of(coordinate), .is_between = true};
    return enclose_all(&in, q);
}

quantity_interval quantity_range(quantity q, quantity_interval s, quantity_interval t)
{
    quantity_interval by_s = quantity_enclose(q, "s", s, t).value;
    quantity_interval by_t = t.low < t.high ? quantity_enclose(q, "t", s, t).value : by_s;
    return (quantity_interval){fmax(by_s.low, by_t.low), fmin(by_s.high, by_t.high)};
}

/* ---- where formulas switch ------------------------------------------------------------------- */

static void visit_switch(const quantity_node *node, quantity_visitor *visit, void *context)
{
    const quantity *x = node->x, one = quantity_number(1);
    double exponent = node->x[1].number;
    switch (node->operation->switches) {
    case QUANTITY_SMOOTH:
        break;
    case QUANTITY_BY_SIGN:
        visit(x[0], context);
        break;
    case QUANTITY_BY_DIFFERENCE:
        visit(quantity_subtract(x[0], x[1]), context);
        break;
    case QUANTITY_BY_UNIT:
        visit(quantity_subtract(x[0], one), context);
        visit(quantity_add(x[0], one), context);
        break;
    case QUANTITY_BY_EXPONENT:
        if (exponent < 0 || exponent != floor(exponent)) {
            visit(x[0], context);
        }
        break;
    }
}

void quantity_switches(quantity q, quantity_visitor *visit, void *context)
{
    const quantity_node *node = q.node;
    if (!node || node->uses == 0) {
        return;
    }
    if (node->kind == QUANTITY_WRITTEN) {
        quantity_switches(node->x[0], visit, context);
    } else if (node->kind == QUANTITY_OPERATION) {
        for (int i = 0; i < node->operation->arity; i++) {
            quantity_switches(node->x[i], visit, context);
        }
        visit_switch(node, visit, context);
    }
}
