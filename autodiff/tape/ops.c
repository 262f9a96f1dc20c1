/* The rules of derivatives, the table of operations, and the functions that record them. */
#include "autodiff/tape/stumpff.h"
#include "autodiff/tape/tape.h"

#include <math.h>

static ad_value constant_like(ad_value y, double number)
{
    return ad_scalar(y.tape, number);
}

/* ---- partial derivatives of smooth operations ---------------------------------------------- */

#define PARTIAL(name) static ad_value name(ad_value y, int i)

PARTIAL(partial_tanh)
{
    (void)i;
    return ad_sub(constant_like(y, 1), ad_mul(y, y));
}

PARTIAL(partial_sin)
{
    (void)i;
    return ad_cos(argument_of(y, 0));
}

PARTIAL(partial_cos)
{
    (void)i;
    return ad_neg(ad_sin(argument_of(y, 0)));
}

PARTIAL(partial_exp)
{
    (void)i;
    return y;
}

PARTIAL(partial_log)
{
    (void)i;
    return ad_reciprocal(argument_of(y, 0));
}

PARTIAL(partial_erf)
{
    (void)i; /* 2/sqrt(pi) exp(-x^2) */
    return ad_scale(ad_exp(ad_neg(ad_mul(argument_of(y, 0), argument_of(y, 0)))),
                    1.1283791670955126);
}

PARTIAL(partial_sqrt)
{
    (void)i;
    return ad_scale(ad_reciprocal_or_zero(y), 0.5);
}

PARTIAL(partial_reciprocal) /* of both reciprocals */
{
    (void)i;
    return ad_neg(ad_mul(y, y));
}

PARTIAL(partial_power)
{
    (void)i;
    double exponent = node_of(y)->number;
    return ad_scale(ad_power(argument_of(y, 0), exponent - 1), exponent);
}

PARTIAL(partial_abs)
{
    (void)i;
    return ad_sign(argument_of(y, 0));
}

PARTIAL(partial_atan2)
{
    ad_value scale = ad_reciprocal_or_zero(ad_add(ad_mul(argument_of(y, 0), argument_of(y, 0)),
                                                  ad_mul(argument_of(y, 1), argument_of(y, 1))));
    return i == 0 ? ad_mul(argument_of(y, 1), scale) : ad_neg(ad_mul(argument_of(y, 0), scale));
}

PARTIAL(partial_stumpff)
{
    (void)i; /* c_k' = (k c_(k+2) - c_(k+1)) / 2, from the series */
    int k = node_of(y)->whole;
    if (k == 0) {
        return ad_scale(ad_stumpff(1, argument_of(y, 0)), -0.5);
    }
    return ad_scale(ad_sub(ad_scale(ad_stumpff(k + 2, argument_of(y, 0)), k),
                           ad_stumpff(k + 1, argument_of(y, 0))),
                    0.5);
}

/* ---- adjoints of linear and bilinear operations -------------------------------------------- */

#define ADJOINT(name) static ad_value name(ad_value y, ad_value adjoint, int i)

ADJOINT(adjoint_add)
{
    (void)y, (void)i;
    return adjoint;
}

ADJOINT(adjoint_sub)
{
    (void)y;
    return i == 0 ? adjoint : ad_neg(adjoint);
}

ADJOINT(adjoint_mul)
{
    return ad_mul(adjoint, argument_of(y, 1 - i));
}

ADJOINT(adjoint_repeat)
{
    (void)y, (void)i;
    return ad_sum_rows(adjoint);
}

ADJOINT(adjoint_slice)
{
    (void)i;
    return ad_pad(adjoint, node_of(y)->whole, ad_rows(argument_of(y, 0)));
}

ADJOINT(adjoint_stack)
{
    int before = 0;
    for (int k = 0; k < i; k++) {
        before += ad_rows(argument_of(y, k));
    }
    return ad_slice(adjoint, before, ad_rows(argument_of(y, i)));
}

ADJOINT(adjoint_pad)
{
    (void)i;
    return ad_slice(adjoint, node_of(y)->whole, ad_rows(argument_of(y, 0)));
}

ADJOINT(adjoint_sum_rows)
{
    (void)i;
    return ad_repeat(adjoint, ad_rows(argument_of(y, 0)));
}

ADJOINT(adjoint_matvec)
{
    return i == 0 ? ad_outer(adjoint, argument_of(y, 1))
                  : ad_matvec_transposed(argument_of(y, 0), adjoint);
}

ADJOINT(adjoint_matvec_transposed)
{
    return i == 0 ? ad_outer(argument_of(y, 1), adjoint) : ad_matvec(argument_of(y, 0), adjoint);
}

ADJOINT(adjoint_outer) /* of outer and its sum */
{
    return i == 0 ? ad_matvec(adjoint, argument_of(y, 1))
                  : ad_matvec_transposed(adjoint, argument_of(y, 0));
}

/* ---- the table ----------------------------------------------------------------------------- */

#define RULE_LEAF(rule)      NULL, NULL
#define RULE_FLAT(rule)      NULL, NULL
#define RULE_SELECT(rule)    NULL, NULL
#define RULE_SMOOTH(rule)    rule, NULL
#define RULE_LINEAR(rule)    NULL, rule
#define RULE_BILINEAR(rule)  NULL, rule
#define LEAF_ROW(code, name) [OP_##code] = {#name, 0, FORM_LEAF, LEAF, NULL, NULL},
#define ELEMENTWISE_ROW(code, name, arity, kind, rule, numbers, vectors, text)                     \
    [OP_##code] = {#name, arity, FORM_ELEMENTWISE, kind, RULE_##kind(rule)},
#define STRUCTURAL_ROW(code, name, arity, kind, rule, form)                                        \
    [OP_##code] = {#name, arity, form, kind, RULE_##kind(rule)},

const op_row ad_op_table[OP_COUNT] = {AD_LEAVES(LEAF_ROW) AD_ELEMENTWISE(ELEMENTWISE_ROW)
                                          AD_STRUCTURAL(STRUCTURAL_ROW)};

double ad_op_evaluate(int op, int whole, double number, const double *x)
{
#define EVALUATE(code, name, arity, kind, rule, numbers, vectors, text)                            \
    case OP_##code:                                                                                \
        return numbers;
    switch (op) {
        AD_ELEMENTWISE(EVALUATE)
    default:
        return NAN;
    }
}

/* ---- recording ----------------------------------------------------------------------------- */

#define RECORD1(name, code)                                                                        \
    ad_value name(ad_value a)                                                                      \
    {                                                                                              \
        return tape_record1(code, a);                                                              \
    }
#define RECORD2(name, code)                                                                        \
    ad_value name(ad_value a, ad_value b)                                                          \
    {                                                                                              \
        return tape_record2(code, a, b);                                                           \
    }

RECORD2(ad_add, OP_ADD)
RECORD2(ad_sub, OP_SUB)
RECORD2(ad_mul, OP_MUL)
RECORD1(ad_tanh, OP_TANH)
RECORD1(ad_sin, OP_SIN)
RECORD1(ad_cos, OP_COS)
RECORD1(ad_exp, OP_EXP)
RECORD1(ad_log, OP_LOG)
RECORD1(ad_erf, OP_ERF)
RECORD1(ad_sqrt, OP_SQRT)
RECORD1(ad_reciprocal, OP_RECIPROCAL)
RECORD1(ad_reciprocal_or_zero, OP_RECIPROCAL_OR_ZERO)
RECORD1(ad_abs, OP_ABS)
RECORD1(ad_sign, OP_SIGN)
RECORD2(ad_atan2, OP_ATAN2)
RECORD1(ad_sum_rows, OP_SUM_ROWS)
RECORD2(ad_matvec, OP_MATVEC)
RECORD2(ad_matvec_transposed, OP_MATVEC_TRANSPOSED)
RECORD2(ad_outer, OP_OUTER)

ad_value ad_power(ad_value a, double exponent)
{
    return ad_tape_record(a.tape, OP_POWER, 1, &a, 0, exponent, 0);
}

ad_value ad_stumpff(int k, ad_value a)
{
    if (a.tape && (k < 0 || k > AD_STUMPFF_MAX)) {
        ad_tape_fail(a.tape, AD_NO_RULE, "stumpff: order %d; 0 to %d are available", k,
                     AD_STUMPFF_MAX);
    }
    return ad_tape_record(a.tape, OP_STUMPFF, 1, &a, k, 0, 0);
}

ad_value ad_select(ad_value condition, ad_value a, ad_value b)
{
    return ad_tape_record(a.tape, OP_SELECT, 3, (ad_value[]){condition, a, b}, 0, 0, 0);
}

ad_value ad_repeat(ad_value a, int rows)
{
    return ad_tape_record(a.tape, OP_REPEAT, 1, &a, 0, 0, rows);
}

ad_value ad_slice(ad_value a, int first, int rows)
{
    return ad_tape_record(a.tape, OP_SLICE, 1, &a, first, 0, rows);
}

ad_value ad_row(ad_value a, int row)
{
    return ad_slice(a, row, 1);
}

ad_value ad_stack(int count, const ad_value *parts)
{
    return ad_tape_record(parts[0].tape, OP_STACK, count, parts, 0, 0, 0);
}

ad_value ad_pad(ad_value a, int before, int rows)
{
    return ad_tape_record(a.tape, OP_PAD, 1, &a, before, 0, rows);
}

ad_value ad_tape_sum(ad_value a, sum_over over)
{
    return ad_tape_record(a.tape, OP_SUM_POINTS, 1, &a, (int)over, 0, 0);
}

ad_value ad_tape_outer_sum(ad_value y, ad_value x, sum_over over)
{
    return ad_tape_record(y.tape, OP_OUTER_SUM, 2, (ad_value[]){y, x}, (int)over, 0, 0);
}

ad_value ad_sum_points(ad_value a)
{
    return ad_tape_sum(a, OVER_POINTS);
}

ad_value ad_sum_points_of_member(ad_value a)
{
    return ad_tape_sum(a, OF_MEMBER);
}

ad_value ad_sum_members(ad_value a)
{
    return ad_tape_sum(a, OVER_MEMBERS);
}
