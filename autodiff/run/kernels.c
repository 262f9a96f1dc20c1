/* One loop per elementwise operation of lanes.h. Compiled several times with different target
 * options; AD_KERNEL_SET names the result. */
#include "autodiff/compile/kernels.h"
#include "autodiff/run/lanes.h"

#include <string.h>

/* A loop over rows and points; `mask` and `arity` are known at compile time. Rows are short: what
 * counts is how little surrounds the inner loop. */
#define LOOP(name, expression)                                                                     \
    INLINE void name##_loop(int mask, int rows, int points, double *out, ptrdiff_t stride,         \
                            const kernel_operand *x, int arity, int whole, double number)          \
    {                                                                                              \
        (void)whole, (void)number;                                                                 \
        const double *at[4] = {NULL, NULL, NULL, NULL};                                            \
        ptrdiff_t next[4] = {0, 0, 0, 0};                                                          \
        for (int i = 0; i < arity; i++) {                                                          \
            at[i] = x[i].at;                                                                       \
            next[i] = x[i].stride;                                                                 \
        }                                                                                          \
        const ptrdiff_t end = points;                                                              \
        for (; rows > 0; rows--) {                                                                 \
            vec a = mask & 1 ? splat(*at[0]) : splat(0);                                           \
            vec b = mask & 2 ? splat(*at[1]) : splat(0);                                           \
            vec c = mask & 4 ? splat(*at[2]) : splat(0);                                           \
            vec d = mask & 8 ? splat(*at[3]) : splat(0);                                           \
            for (ptrdiff_t j = 0; j < end; j += LANES) {                                           \
                if (!(mask & 1)) {                                                                 \
                    a = *(const vec *)(at[0] + j);                                                 \
                }                                                                                  \
                if (arity > 1 && !(mask & 2)) {                                                    \
                    b = *(const vec *)(at[1] + j);                                                 \
                }                                                                                  \
                if (arity > 2 && !(mask & 4)) {                                                    \
                    c = *(const vec *)(at[2] + j);                                                 \
                }                                                                                  \
                if (arity > 3 && !(mask & 8)) {                                                    \
                    d = *(const vec *)(at[3] + j);                                                 \
                }                                                                                  \
                (void)b, (void)c, (void)d;                                                         \
                *(vec *)(out + j) = (expression);                                                  \
            }                                                                                      \
            for (int i = 0; i < arity; i++) {                                                      \
                at[i] += next[i];                                                                  \
            }                                                                                      \
            out += stride;                                                                         \
        }                                                                                          \
    }

#define VARIANT(name, arity, mask)                                                                 \
    static void name##_##mask(int rows, int points, double *out, ptrdiff_t stride,                 \
                              const kernel_operand *x, int whole, double number)                   \
    {                                                                                              \
        name##_loop(mask, rows, points, out, stride, x, arity, whole, number);                     \
    }

#define LOOP1(name, expression)                                                                    \
    LOOP(name, expression)                                                                         \
    VARIANT(name, 1, 0)                                                                            \
    VARIANT(name, 1, 1)
#define LOOP2(name, expression)                                                                    \
    LOOP(name, expression)                                                                         \
    VARIANT(name, 2, 0)                                                                            \
    VARIANT(name, 2, 1)                                                                            \
    VARIANT(name, 2, 2)
#define LOOP3(name, expression)                                                                    \
    LOOP(name, expression)                                                                         \
    VARIANT(name, 3, 0)                                                                            \
    VARIANT(name, 3, 1)                                                                            \
    VARIANT(name, 3, 2)                                                                            \
    VARIANT(name, 3, 3)                                                                            \
    VARIANT(name, 3, 4)                                                                            \
    VARIANT(name, 3, 5)                                                                            \
    VARIANT(name, 3, 6)

#define LOOP4(name, expression)                                                                    \
    LOOP(name, expression)                                                                         \
    VARIANT(name, 4, 0)                                                                            \
    VARIANT(name, 4, 1)                                                                            \
    VARIANT(name, 4, 2)                                                                            \
    VARIANT(name, 4, 3)                                                                            \
    VARIANT(name, 4, 4)                                                                            \
    VARIANT(name, 4, 5)                                                                            \
    VARIANT(name, 4, 6)                                                                            \
    VARIANT(name, 4, 7)                                                                            \
    VARIANT(name, 4, 8)                                                                            \
    VARIANT(name, 4, 9)                                                                            \
    VARIANT(name, 4, 10)                                                                           \
    VARIANT(name, 4, 11)                                                                           \
    VARIANT(name, 4, 12)                                                                           \
    VARIANT(name, 4, 13)                                                                           \
    VARIANT(name, 4, 14)

LOOP2(add, a + b)
LOOP2(sub, a - b)
LOOP2(mul, a *b)
LOOP1(tanh, v_tanh(a))
LOOP1(sin, v_sin(a))
LOOP1(cos, v_cos(a))
LOOP1(exp, v_exp(a))
LOOP1(log, v_log(a))
LOOP1(erf, v_erf(a))
LOOP1(sqrt, v_sqrt(a))
LOOP1(reciprocal, v_reciprocal(a))
LOOP1(reciprocal_or_zero, v_reciprocal_or_zero(a))
LOOP1(power, v_power(a, number))
LOOP1(abs, v_abs(a))
LOOP1(sign, v_sign(a))
LOOP2(atan2, v_atan2(a, b))
LOOP1(stumpff, v_stumpff(a, whole))
LOOP3(select, v_select(a, b, c))
LOOP1(copy, a)
LOOP3(mul_add, v_mul_add(a, b, c))
LOOP3(mul_sub, v_mul_sub(a, b, c))
LOOP3(sub_mul, v_sub_mul(a, b, c))
LOOP2(scaled_mul, v_scaled_mul(a, b, number))
LOOP3(scaled_mul_add, v_scaled_mul_add(a, b, c, number))
LOOP3(scaled_mul_sub, v_scaled_mul_sub(a, b, c, number))
LOOP4(pair_add, v_pair_add(a, b, c, d, number))
LOOP4(pair_sub, v_pair_sub(a, b, c, d, number))
LOOP2(tanh_sum, v_tanh_sum(a, b))

static void sum_points(int rows, int points, double *sum, kernel_operand x)
{
    enum { PARTS = 8 }; /* the same for every instruction set: so is the order of the sum */
    for (int row = 0; row < rows; row++) {
        const double *from = x.at + row * x.stride;
        vec parts[PARTS / LANES];
        double part[PARTS];
        int j = 0;
        for (int i = 0; i < PARTS / LANES; i++) {
            parts[i] = splat(0);
        }
        for (; j + PARTS <= points; j += PARTS) {
            for (int i = 0; i < PARTS / LANES; i++) {
                parts[i] += *(const vec *)(from + j + i * LANES);
            }
        }
        memcpy(part, parts, sizeof part);
        for (int i = 0; j + i < points; i++) {
            part[i] += from[j + i];
        }
        for (int half = PARTS / 2; half > 0; half /= 2) {
            for (int i = 0; i < half; i++) {
                part[i] += part[i + half];
            }
        }
        sum[row] += part[0];
    }
}

static void add_outer(int columns, int points, double *out, ptrdiff_t stride, const double *y,
                      kernel_operand x)
{
    for (int k = 0; k < columns; k++) {
        double *restrict to = out + k * stride;
        const double *restrict from = x.at + k * x.stride;
        for (int j = 0; j < points; j++) {
            to[j] = mul_add(y[j], from[j], to[j]);
        }
    }
}

#define ROW1(name)                                                                                 \
    {                                                                                              \
        name##_0, name##_1                                                                         \
    }
#define ROW2(name)                                                                                 \
    {                                                                                              \
        name##_0, name##_1, name##_2                                                               \
    }
#define ROW3(name)                                                                                 \
    {                                                                                              \
        name##_0, name##_1, name##_2, name##_3, name##_4, name##_5, name##_6                       \
    }

#define ROW4(name)                                                                                 \
    {                                                                                              \
        name##_0, name##_1, name##_2, name##_3, name##_4, name##_5, name##_6, name##_7, name##_8,  \
            name##_9, name##_10, name##_11, name##_12, name##_13, name##_14                        \
    }

extern const product_set AD_PRODUCT_SET;

const kernel_set AD_KERNEL_SET = {
    .name = AD_KERNEL_NAME,
    .flags = AD_KERNEL_FLAGS,
    .loops =
        {
            [OP_ADD] = ROW2(add),
            [OP_SUB] = ROW2(sub),
            [OP_MUL] = ROW2(mul),
            [OP_TANH] = ROW1(tanh),
            [OP_SIN] = ROW1(sin),
            [OP_COS] = ROW1(cos),
            [OP_EXP] = ROW1(exp),
            [OP_LOG] = ROW1(log),
            [OP_ERF] = ROW1(erf),
            [OP_SQRT] = ROW1(sqrt),
            [OP_RECIPROCAL] = ROW1(reciprocal),
            [OP_RECIPROCAL_OR_ZERO] = ROW1(reciprocal_or_zero),
            [OP_POWER] = ROW1(power),
            [OP_ABS] = ROW1(abs),
            [OP_SIGN] = ROW1(sign),
            [OP_ATAN2] = ROW2(atan2),
            [OP_STUMPFF] = ROW1(stumpff),
            [OP_SELECT] = ROW3(select),
            [OP_REPEAT] = ROW1(copy),
            [OP_MUL_ADD] = ROW3(mul_add),
            [OP_MUL_SUB] = ROW3(mul_sub),
            [OP_SUB_MUL] = ROW3(sub_mul),
            [OP_SCALED_MUL] = ROW2(scaled_mul),
            [OP_SCALED_MUL_ADD] = ROW3(scaled_mul_add),
            [OP_SCALED_MUL_SUB] = ROW3(scaled_mul_sub),
            [OP_PAIR_ADD] = ROW4(pair_add),
            [OP_PAIR_SUB] = ROW4(pair_sub),
            [OP_TANH_SUM] = ROW2(tanh_sum),
            [OP_COPY] = ROW1(copy),
        },
    .sum_points = sum_points,
    .add_outer = add_outer,
    .products = &AD_PRODUCT_SET,
};
