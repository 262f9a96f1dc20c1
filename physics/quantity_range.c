/* Enclosures of formulas over intervals, and the expressions that make them jump or kink. */
#include "physics/quantity_internal.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Of one operation and its function of the C library, as in quantity_interval.c. */
static const double ROUNDING = 4 * DBL_EPSILON;

typedef struct enclosing {
    quantity_interval x[2]; /* s and t */
    int along;              /* which of them the slope is by; -1: neither */
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

/* By the chain rule. What counts for nothing, as the other branch of where, may be anything. */
static quantity_enclosure enclose_operation(const enclosing *in, const quantity_node *node)
{
    quantity_enclosure x[QUANTITY_ARGUMENTS_MAX], result = {.rounding = 0};
    quantity_interval values[QUANTITY_ARGUMENTS_MAX], by[QUANTITY_ARGUMENTS_MAX];
    bool chooses = node->operation == &quantity_operations[QUANTITY_WHERE];
    for (int i = 0; i < node->operation->arity; i++) {
        bool never = chooses && ((i == 1 && values[0].high <= 0) || (i == 2 && values[0].low > 0));
        x[i] = never ? whole_line() : enclose(in, &node->x[i]);
        values[i] = x[i].value;
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

static quantity_enclosure enclose(const enclosing *in, const quantity *q)
{
    const quantity_node *node = q->node;
    if (!node || node->uses == 0) {
        return of_number(q->number);
    }
    switch (node->kind) {
    case QUANTITY_OPEN:
        return node->index < 2 ? (quantity_enclosure){.value = in->x[node->index],
                                                      .slope = {node->index == in->along,
                                                                node->index == in->along}}
                               : whole_line();
    case QUANTITY_WRITTEN:
        return enclose(in, &node->x[0]);
    case QUANTITY_OPERATION:
        return enclose_operation(in, node);
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
    double middle = whole.low + (whole.high - whole.low) / 2;
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

quantity_enclosure quantity_enclose(quantity q, const char *coordinate, quantity_interval s,
                                    quantity_interval t)
{
    if (!q.is_given) {
        return whole_line();
    }
    enclosing in = {.x = {s, t}, .along = strcmp(coordinate, "s") == 0 ? 0 : 1};
    quantity_enclosure result = enclose(&in, &q);
    if (in.x[in.along].low < in.x[in.along].high && !is_line(result.slope)) {
        tighten(&in, &q, &result);
    }
    return result;
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
