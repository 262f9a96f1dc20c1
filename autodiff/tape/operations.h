/* The operations, one row each: all that is said of an operation is made of its row. Private.
 *
 * A smooth operation has its partial derivative as its rule, a linear or bilinear one its adjoint
 * (ops.c). An elementwise one has its meaning three times, which the tests compare: for numbers
 * x[0], x[1], ... with the attributes `whole` and `number`; for vectors a, b, c, d by the functions
 * of lanes.h; and as C text of operands A to D and N, NULL where a function computes it. */
#ifndef AD_OPERATIONS_H
#define AD_OPERATIONS_H

/* clang-format off */

/* X(CODE, name) */
#define AD_LEAVES(X) \
    X(CONSTANT, constant) \
    X(INPUT, input) \
    X(UNIFORM, uniform) \
    X(PARAMETER, parameter) \
    X(POINTS, points)

/* X(CODE, name, arity, kind, rule, of numbers, of vectors, text) */
#define AD_ELEMENTWISE(X) \
    X(ADD, add, 2, LINEAR, adjoint_add, x[0] + x[1], a + b, "A + B") \
    X(SUB, sub, 2, LINEAR, adjoint_sub, x[0] - x[1], a - b, "A - B") \
    X(MUL, mul, 2, BILINEAR, adjoint_mul, x[0] * x[1], a * b, "A * B") \
    X(TANH, tanh, 1, SMOOTH, partial_tanh, tanh(x[0]), v_tanh(a), NULL) \
    X(SIN, sin, 1, SMOOTH, partial_sin, sin(x[0]), v_sin(a), NULL) \
    X(COS, cos, 1, SMOOTH, partial_cos, cos(x[0]), v_cos(a), NULL) \
    X(EXP, exp, 1, SMOOTH, partial_exp, exp(x[0]), v_exp(a), NULL) \
    X(LOG, log, 1, SMOOTH, partial_log, log(x[0]), v_log(a), NULL) \
    X(ERF, erf, 1, SMOOTH, partial_erf, erf(x[0]), v_erf(a), NULL) \
    X(SQRT, sqrt, 1, SMOOTH, partial_sqrt, sqrt(x[0]), v_sqrt(a), NULL) \
    X(RECIPROCAL, reciprocal, 1, SMOOTH, partial_reciprocal, \
      1 / x[0], v_reciprocal(a), "1 / A") \
    X(RECIPROCAL_OR_ZERO, reciprocal_or_zero, 1, SMOOTH, partial_reciprocal, \
      x[0] == 0 ? 0 : 1 / x[0], v_reciprocal_or_zero(a), "A == 0 ? 0 : 1 / A") \
    X(POWER, power, 1, SMOOTH, partial_power, pow(x[0], number), v_power(a, number), NULL) \
    X(ABS, abs, 1, SMOOTH, partial_abs, fabs(x[0]), v_abs(a), NULL) \
    X(SIGN, sign, 1, FLAT, NULL, (x[0] > 0) - (x[0] < 0), v_sign(a), "(A > 0) - (A < 0)") \
    X(ATAN2, atan2, 2, SMOOTH, partial_atan2, atan2(x[0], x[1]), v_atan2(a, b), NULL) \
    X(STUMPFF, stumpff, 1, SMOOTH, partial_stumpff, \
      ad_stumpff_number(whole, x[0]), v_stumpff(a, whole), NULL) \
    X(SELECT, select, 3, SELECT, NULL, x[0] > 0 ? x[1] : x[2], v_select(a, b, c), "A > 0 ? B : C") \
    X(REPEAT, repeat, 1, LINEAR, adjoint_repeat, x[0], a, "A") \
    /* appear only in programs: contractions found by the compiler, copies of parts of a stack */ \
    X(MUL_ADD, mul_add, 3, LEAF, NULL, \
      fma(x[0], x[1], x[2]), v_mul_add(a, b, c), "A * B + C") \
    X(MUL_SUB, mul_sub, 3, LEAF, NULL, \
      fma(x[0], x[1], -x[2]), v_mul_sub(a, b, c), "A * B - C") \
    X(SUB_MUL, sub_mul, 3, LEAF, NULL, \
      fma(-x[0], x[1], x[2]), v_sub_mul(a, b, c), "C - A * B") \
    X(SCALED_MUL, scaled_mul, 2, LEAF, NULL, \
      number * (x[0] * x[1]), v_scaled_mul(a, b, number), "N * (A * B)") \
    /* whole 1: recorded as c - (-number) (a b), as pair_add below */ \
    X(SCALED_MUL_ADD, scaled_mul_add, 3, LEAF, NULL, \
      fma(number, x[0] * x[1], x[2]), v_scaled_mul_add(a, b, c, number), "N * (A * B) + C") \
    X(SCALED_MUL_SUB, scaled_mul_sub, 3, LEAF, NULL, \
      fma(number, x[0] * x[1], -x[2]), v_scaled_mul_sub(a, b, c, number), "N * (A * B) - C") \
    X(PAIR_ADD, pair_add, 4, LEAF, NULL, \
      fma(number, x[0] * x[1], x[2] * x[3]), v_pair_add(a, b, c, d, number), \
      "N * (A * B) + C * D") \
    X(PAIR_SUB, pair_sub, 4, LEAF, NULL, \
      fma(number, x[0] * x[1], -(x[2] * x[3])), v_pair_sub(a, b, c, d, number), \
      "N * (A * B) - C * D") \
    X(TANH_SUM, tanh_sum, 2, LEAF, NULL, tanh(x[0] + x[1]), v_tanh_sum(a, b), NULL) \
    X(COPY, copy, 1, LEAF, NULL, x[0], a, "A")

/* Rows, points, matrices: X(CODE, name, arity, kind, rule, form) */
#define AD_STRUCTURAL(X) \
    X(SLICE, slice, 1, LINEAR, adjoint_slice, FORM_SLICE) \
    X(STACK, stack, AD_ARITY_ANY, LINEAR, adjoint_stack, FORM_JOIN) \
    X(PAD, pad, 1, LINEAR, adjoint_pad, FORM_JOIN) \
    X(SUM_ROWS, sum_rows, 1, LINEAR, adjoint_sum_rows, FORM_SUM_ROWS) \
    X(SUM_POINTS, sum_points, 1, LINEAR, adjoint_add, FORM_SUM_POINTS) \
    X(MATVEC, matvec, 2, BILINEAR, adjoint_matvec, FORM_PRODUCT) \
    X(MATVEC_TRANSPOSED, matvec_transposed, 2, BILINEAR, adjoint_matvec_transposed, FORM_PRODUCT) \
    X(OUTER, outer, 2, BILINEAR, adjoint_outer, FORM_OUTER) \
    X(OUTER_SUM, outer_sum, 2, BILINEAR, adjoint_outer, FORM_OUTER_SUM) /* over points */ \
    /* a value of members at every point: made where it meets a batch value */ \
    X(SPREAD, spread, 1, LINEAR, adjoint_add, FORM_SPREAD)

/* clang-format on */

#endif
