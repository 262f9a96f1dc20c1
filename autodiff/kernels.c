/* One loop per elementwise operation. Compiled several times with different target options;
 * AD_KERNEL_SET names the result. Transcendental functions but tanh come from the C library's
 * vector library (libmvec, at most 4 units in the last place). */
#include "autodiff/kernels.h"

#include <math.h>
#include <string.h>

/* HALVES: the first, and the second halves of two vectors, interleaved. */
#if defined(__AVX512F__)
#define LANES                       8
#define FIRST_HALVES                0, 8, 1, 9, 2, 10, 3, 11
#define SECOND_HALVES               4, 12, 5, 13, 6, 14, 7, 15
#define VECTOR_ABI(arguments, name) _ZGVeN8##arguments##_##name
#elif defined(__AVX2__)
#define LANES                       4
#define FIRST_HALVES                0, 4, 1, 5
#define SECOND_HALVES               2, 6, 3, 7
#define VECTOR_ABI(arguments, name) _ZGVdN4##arguments##_##name
#else
#define LANES                       2
#define FIRST_HALVES                0, 2
#define SECOND_HALVES               1, 3
#define VECTOR_ABI(arguments, name) _ZGVbN2##arguments##_##name
#endif

#define INLINE static inline __attribute__((always_inline))

typedef double vec __attribute__((vector_size(LANES * 8), may_alias));
typedef int64_t bits __attribute__((vector_size(LANES * 8), may_alias));

#if defined(__x86_64__) && defined(__GLIBC__)
#define VECTOR_FUNCTION1(name)                                                                     \
    vec VECTOR_ABI(v, name)(vec);                                                                  \
    INLINE vec v_##name(vec a)                                                                     \
    {                                                                                              \
        return VECTOR_ABI(v, name)(a);                                                             \
    }
#define VECTOR_FUNCTION2(name)                                                                     \
    vec VECTOR_ABI(vv, name)(vec, vec);                                                            \
    INLINE vec v_##name(vec a, vec b)                                                              \
    {                                                                                              \
        return VECTOR_ABI(vv, name)(a, b);                                                         \
    }
#else
#define VECTOR_FUNCTION1(name)                                                                     \
    INLINE vec v_##name(vec a)                                                                     \
    {                                                                                              \
        for (int i = 0; i < LANES; i++) {                                                          \
            a[i] = name(a[i]);                                                                     \
        }                                                                                          \
        return a;                                                                                  \
    }
#define VECTOR_FUNCTION2(name)                                                                     \
    INLINE vec v_##name(vec a, vec b)                                                              \
    {                                                                                              \
        for (int i = 0; i < LANES; i++) {                                                          \
            a[i] = name(a[i], b[i]);                                                               \
        }                                                                                          \
        return a;                                                                                  \
    }
#endif

VECTOR_FUNCTION1(sin)
VECTOR_FUNCTION1(cos)
VECTOR_FUNCTION1(exp)
VECTOR_FUNCTION1(log)
VECTOR_FUNCTION1(erf)
VECTOR_FUNCTION2(pow)
VECTOR_FUNCTION2(atan2)

INLINE vec splat(double number)
{
    vec zero = {0};
    return number - zero; /* not zero + number: keeps -0 */
}

INLINE vec v_sqrt(vec a)
{
    for (int i = 0; i < LANES; i++) {
        a[i] = sqrt(a[i]);
    }
    return a;
}

INLINE vec choose(bits where, vec a, vec b)
{
    return (vec)(((bits)a & where) | ((bits)b & ~where));
}

/* tanh, the function networks use most: at most 3 units in the last place, and faster than the
 * library's. tanh |a| = e / (e + 2), e = exp(2 |a|) - 1 = 2^k (r + r^2 q(r)) + (2^k - 1), where r =
 * 2 |a| - k ln 2 in two parts (Cody and Waite), |r| <= ln(2)/2; q interpolates (exp(r) - 1 - r)/r^2
 * at Chebyshev points to 2^-60, odd and even powers apart for half the latency. */
INLINE vec v_tanh(vec a)
{
    const bits sign = (bits)a & INT64_MIN;
    const vec x = (vec)((bits)a ^ sign);
    const vec x2 = 2 * choose(x > 20, splat(20), x);          /* tanh rounds to 1; NaN stays */
    const vec shifted = x2 * 0x1.71547652b82fep+0 + 0x1.8p52; /* k in the lowest bits */
    const vec k = shifted - 0x1.8p52;
    const vec r = (x2 - k * 0x1.62e42fefa3800p-1) - k * 0x1.ef35793c76730p-45;
    const vec power = (vec)(((bits)shifted << 52) + (bits)splat(1)); /* 2^k */
    const vec r2 = r * r;
    vec even = r2 * 0x1.1f730349868cep-29 + 0x1.27e4db646b17ep-22;
    vec odd = r2 * 0x1.af4de97ca4194p-26 + 0x1.71de0231960ebp-19;
    even = even * r2 + 0x1.a01a01a6d889cp-16;
    odd = odd * r2 + 0x1.a01a01abe7fe1p-13;
    even = even * r2 + 0x1.6c16c16c162d4p-10;
    odd = odd * r2 + 0x1.11111111100dcp-7;
    even = even * r2 + 0x1.5555555555556p-5;
    odd = odd * r2 + 0x1.5555555555557p-3;
    even = even * r2 + 0.5;
    const vec e = power * ((odd * r + even) * r2 + r) + (power - 1);
    return (vec)((bits)(e / (e + 2)) | sign);
}

INLINE vec v_reciprocal_or_zero(vec a)
{
    return choose(a == 0, splat(0), 1 / a);
}

INLINE vec v_sign(vec a)
{
    return choose(a > 0, splat(1), choose(a < 0, splat(-1), splat(0)));
}

INLINE vec v_abs(vec a)
{
    return (vec)((bits)a & INT64_MAX);
}

INLINE vec v_stumpff(vec a, int whole)
{
    for (int i = 0; i < LANES; i++) {
        double x = a[i];
        a[i] = ad_op_evaluate(OP_STUMPFF, whole, 0, &x);
    }
    return a;
}

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
LOOP1(reciprocal, 1 / a)
LOOP1(reciprocal_or_zero, v_reciprocal_or_zero(a))
LOOP1(power, v_pow(a, splat(number)))
LOOP1(abs, v_abs(a))
LOOP1(sign, v_sign(a))
LOOP2(atan2, v_atan2(a, b))
LOOP1(stumpff, v_stumpff(a, whole))
LOOP3(select, choose(a > 0, b, c))
LOOP1(copy, a)
LOOP3(mul_add, a *b + c)
LOOP3(mul_sub, a *b - c)
LOOP3(sub_mul, c - a * b)
LOOP2(scaled_mul, number *(a *b))
LOOP3(scaled_mul_add, number *(a *b) + c)
LOOP3(scaled_mul_sub, number *(a *b) - c)
LOOP4(pair_add, number *(a *b) + c * d)
LOOP4(pair_sub, number *(a *b) - c * d)
LOOP2(tanh_sum, v_tanh(a + b))

static void sum_points(int rows, int points, double *sum, kernel_operand x)
{
    enum { PARTS = 8 }; /* the same for every instruction set: so is the order of the sum */
    for (int row = 0; row < rows; row++) {
        const double *from = x.at + row * x.stride;
        double part[PARTS] = {0};
        int j = 0;
        for (; j + PARTS <= points; j += PARTS) {
            for (int i = 0; i < PARTS; i++) {
                part[i] += from[j + i];
            }
        }
        for (int i = 0; j + i < points; i++) {
            part[i] += from[j + i];
        }
        sum[row] += ((part[0] + part[4]) + (part[2] + part[6])) +
                    ((part[1] + part[5]) + (part[3] + part[7]));
    }
}

static void add_outer(int columns, int points, double *out, ptrdiff_t stride, const double *y,
                      kernel_operand x)
{
    for (int k = 0; k < columns; k++) {
        double *restrict to = out + k * stride;
        const double *restrict from = x.at + k * x.stride;
        for (int j = 0; j < points; j++) {
            to[j] += y[j] * from[j];
        }
    }
}

/* LANES x LANES numbers: vectors i and i + LANES/2 interleaved into 2 i and 2 i + 1 shift the bits
 * of (vector, lane) round by one; after log2(LANES) times the two have changed places. */
INLINE void transpose_block(const double *from, ptrdiff_t from_stride, double *to,
                            ptrdiff_t to_stride)
{
    vec a[LANES], b[LANES];
    for (int i = 0; i < LANES; i++) {
        a[i] = *(const vec *)(from + i * from_stride);
    }
    for (int step = 1; step < LANES; step *= 2) {
        for (int i = 0; i < LANES / 2; i++) {
            b[2 * i] = __builtin_shufflevector(a[i], a[i + LANES / 2], FIRST_HALVES);
            b[2 * i + 1] = __builtin_shufflevector(a[i], a[i + LANES / 2], SECOND_HALVES);
        }
        memcpy(a, b, sizeof a);
    }
    for (int i = 0; i < LANES; i++) {
        *(vec *)(to + i * to_stride) = a[i];
    }
}

static void transpose(int rows, int points, double *out, ptrdiff_t stride, kernel_operand x)
{
    int row = 0;
    for (; row + LANES <= rows; row += LANES) {
        for (int j = 0; j < points; j += LANES) {
            transpose_block(x.at + row * x.stride + j, x.stride, out + j * stride + row, stride);
        }
    }
    for (; row < rows; row++) {
        for (int j = 0; j < points; j++) {
            out[j * stride + row] = x.at[row * x.stride + j];
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

const kernel_set AD_KERNEL_SET = {
    .name = AD_KERNEL_NAME,
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
    .transpose = transpose,
    .add_outer = add_outer,
};
