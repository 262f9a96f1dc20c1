/* Operators and functions of formulas: one row each. */
#include "physics/quantity/quantity_internal.h"

#include <math.h>
#include <string.h>

#define OPERATION(name, formula, recorded)                                                         \
    static double name##_number(const double *x)                                                   \
    {                                                                                              \
        return formula;                                                                            \
    }                                                                                              \
    static ad_value name##_record(const ad_value *x)                                               \
    {                                                                                              \
        return recorded;                                                                           \
    }

static ad_value record_cosh(ad_value x)
{
    return ad_scale(ad_add(ad_exp(x), ad_exp(ad_neg(x))), 0.5);
}

static ad_value record_one(ad_value x)
{
    return ad_scalar(x.tape, 1);
}

OPERATION(add, x[0] + x[1], ad_add(x[0], x[1]))
OPERATION(subtract, x[0] - x[1], ad_sub(x[0], x[1]))
OPERATION(multiply, x[0] * x[1], ad_mul(x[0], x[1]))
OPERATION(divide, x[0] / x[1], ad_div(x[0], x[1]))
OPERATION(sin, sin(x[0]), ad_sin(x[0]))
OPERATION(cos, cos(x[0]), ad_cos(x[0]))
OPERATION(tan, tan(x[0]), ad_div(ad_sin(x[0]), ad_cos(x[0])))
OPERATION(asin, asin(x[0]), ad_asin(x[0]))
OPERATION(acos, acos(x[0]), ad_acos(x[0]))
OPERATION(atan, atan(x[0]), ad_atan2(x[0], record_one(x[0])))
OPERATION(atan2, atan2(x[0], x[1]), ad_atan2(x[0], x[1]))
/* tanh cosh rather than a difference of exponentials, which loses digits near 0 */
OPERATION(sinh, sinh(x[0]), ad_mul(ad_tanh(x[0]), record_cosh(x[0])))
OPERATION(cosh, cosh(x[0]), record_cosh(x[0]))
OPERATION(tanh, tanh(x[0]), ad_tanh(x[0]))
OPERATION(exp, exp(x[0]), ad_exp(x[0]))
OPERATION(log, log(x[0]), ad_log(x[0]))
OPERATION(sqrt, sqrt(x[0]), ad_sqrt(x[0]))
OPERATION(abs, fabs(x[0]), ad_abs(x[0]))
OPERATION(min, x[0] < x[1] ? x[0] : x[1], ad_min(x[0], x[1]))
OPERATION(max, x[0] > x[1] ? x[0] : x[1], ad_max(x[0], x[1]))
OPERATION(step, x[0] > 0 ? 1 : 0, ad_select(x[0], record_one(x[0]), ad_scalar(x[0].tape, 0)))
OPERATION(where, x[0] > 0 ? x[1] : x[2], ad_select(x[0], x[1], x[2]))

/* Rounding may put a last instant beyond a table that ends there. */
static double within_number(const double *x)
{
    double rounding = 1e-12 * (x[2] - x[1]);
    return x[0] >= x[1] - rounding && x[0] <= x[2] + rounding ? x[0] : NAN;
}

static ad_value within_record(const ad_value *x)
{
    return x[0];
}

static double power_number(const double *x)
{
    return pow(x[0], x[1]);
}

#define ROW(text, arity, precedence, name, switches)                                               \
    {                                                                                              \
        text, arity, precedence, name##_number, name##_record, quantity_range_##name,              \
            QUANTITY_##switches                                                                    \
    }
/* clang-format off */
const quantity_operation quantity_operations[] = {
    [QUANTITY_ADD] = ROW("+", 2, 1, add, SMOOTH),
    [QUANTITY_SUBTRACT] = ROW("-", 2, 1, subtract, SMOOTH),
    [QUANTITY_MULTIPLY] = ROW("*", 2, 2, multiply, SMOOTH),
    [QUANTITY_DIVIDE] = ROW("/", 2, 2, divide, SMOOTH),
    [QUANTITY_POWER] = {"^", 2, 3, power_number, NULL /* by its exponent, a number */,
                        quantity_range_power, QUANTITY_BY_EXPONENT},
    ROW("sin", 1, 0, sin, SMOOTH),
    ROW("cos", 1, 0, cos, SMOOTH),
    ROW("tan", 1, 0, tan, SMOOTH),
    ROW("asin", 1, 0, asin, BY_UNIT),
    ROW("acos", 1, 0, acos, BY_UNIT),
    ROW("atan", 1, 0, atan, SMOOTH),
    ROW("atan2", 2, 0, atan2, BY_SIGN),
    ROW("sinh", 1, 0, sinh, SMOOTH),
    ROW("cosh", 1, 0, cosh, SMOOTH),
    ROW("tanh", 1, 0, tanh, SMOOTH),
    ROW("exp", 1, 0, exp, SMOOTH),
    ROW("log", 1, 0, log, SMOOTH),
    ROW("sqrt", 1, 0, sqrt, BY_SIGN),
    ROW("abs", 1, 0, abs, BY_SIGN),
    ROW("min", 2, 0, min, BY_DIFFERENCE),
    ROW("max", 2, 0, max, BY_DIFFERENCE),
    ROW("step", 1, 0, step, BY_SIGN),
    [QUANTITY_WHERE] = ROW("where", 3, 0, where, BY_SIGN),
    [QUANTITY_WITHIN] = ROW("within", 3, 0, within, SMOOTH),
};
/* clang-format on */
const int quantity_operation_count = sizeof quantity_operations / sizeof quantity_operations[0];

const quantity_operation *quantity_operation_find(const char *name, size_t length)
{
    for (int i = 0; i < quantity_operation_count; i++) {
        const quantity_operation *row = &quantity_operations[i];
        if (strncmp(row->name, name, length) == 0 && row->name[length] == '\0') {
            return row;
        }
    }
    return NULL;
}

/* ---- on the tape ----------------------------------------------------------------------------- */

typedef struct quantity_recording {
    ad_tape *tape;
    int count;
    const quantity_binding *bindings;
} quantity_recording;

static ad_value record_open(const quantity_recording *on, const char *name)
{
    for (int i = 0; i < on->count; i++) {
        if (strcmp(on->bindings[i].name, name) == 0) {
            return on->bindings[i].value;
        }
    }
    ad_tape_fail(on->tape, AD_BAD_ARGUMENT, "a formula of %s, which has no value here", name);
    return ad_scalar(on->tape, 0);
}

/* Small integer powers by multiplication: exact derivatives at 0 and for negative bases. */
static ad_value record_power(ad_value x, double exponent)
{
    enum { MULTIPLIED_MAX = 8 };
    if (exponent != floor(exponent) || fabs(exponent) > MULTIPLIED_MAX) {
        return ad_power(x, exponent);
    }
    ad_value product = ad_scalar(x.tape, 1);
    for (int i = 0; i < (int)fabs(exponent); i++) {
        product = ad_mul(product, x);
    }
    return exponent < 0 ? ad_reciprocal(product) : product;
}

/* Where `put` is not NULL it stands for the first name. */
static quantity replace(quantity q, int count, const char *const *names, const double *values,
                        const quantity *put)
{
    const quantity_node *node = q.node;
    quantity x[QUANTITY_ARGUMENTS_MAX];
    if (!node || node->uses == 0) {
        return q;
    }
    for (int i = 0; i < count && node->kind == QUANTITY_OPEN; i++) {
        if (strcmp(node->text, names[i]) == 0) {
            return put ? *put : quantity_number(values[i]);
        }
    }
    if (node->kind == QUANTITY_WRITTEN) {
        return replace(node->x[0], count, names, values, put);
    }
    for (int i = 0; node->kind == QUANTITY_OPERATION && i < node->operation->arity; i++) {
        x[i] = replace(node->x[i], count, names, values, put);
    }
    return node->kind == QUANTITY_OPERATION ? quantity_operate(node->operation, x) : q;
}

quantity quantity_with(quantity q, int count, const char *const *names, const double *values)
{
    return replace(q, count, names, values, NULL);
}

quantity quantity_put(quantity q, const char *name, quantity value)
{
    return replace(q, 1, &name, NULL, &value);
}

quantity quantity_put_unseen(quantity q, const char *name, quantity value)
{
    return quantity_written(q, quantity_put(q, name, value));
}

static ad_value record(const quantity_recording *on, const quantity *q);

static ad_value record_operation(const quantity_recording *on, const quantity_node *node)
{
    ad_value x[QUANTITY_ARGUMENTS_MAX];
    for (int numbers = 0; numbers <= 1; numbers++) {
        for (int i = 0; i < node->operation->arity; i++) {
            if ((node->x[i].node == NULL) == numbers) {
                x[i] = record(on, &node->x[i]);
            }
        }
    }
    bool by_number = !node->x[1].node;
    if (!node->operation->record) {
        return record_power(x[0], node->x[1].number);
    }
    if (node->operation == &quantity_operations[QUANTITY_DIVIDE] && by_number) {
        return ad_scale(x[0], 1 / node->x[1].number);
    }
    return node->operation->record(x);
}

static ad_value record(const quantity_recording *on, const quantity *q)
{
    if (!q->node || q->node->uses == 0) {
        return ad_scalar(on->tape, q->number);
    }
    switch (q->node->kind) {
    case QUANTITY_OPEN:
        return record_open(on, q->node->text);
    case QUANTITY_WRITTEN:
        return record(on, &q->node->x[0]);
    default:
        return record_operation(on, q->node);
    }
}

ad_value quantity_record(quantity q, ad_tape *tape, int count, const quantity_binding *bindings)
{
    const quantity_recording on = {tape, count, bindings};
    ad_error error;
    ad_status status = quantity_check(q, &error);
    if (status != AD_OK || !q.is_given) {
        ad_tape_fail(tape, status == AD_OK ? AD_BAD_ARGUMENT : status, "%s",
                     status == AD_OK ? "a quantity is not given" : error.message);
        return ad_scalar(tape, 0);
    }
    return record(&on, &q);
}

ad_value quantity_record_at(quantity q, ad_value s, ad_value t)
{
    return quantity_record(q, s.tape, 2, (quantity_binding[]){{"s", s}, {"t", t}});
}
