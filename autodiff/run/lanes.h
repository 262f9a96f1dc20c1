/* What each elementwise operation does to a vector of LANES numbers. kernels.c and the C that
 * programs are written out as (c_groups.c) compile this same text, without contraction, so that
 * both give the same bits. Transcendental functions but tanh come from the C library's vector
 * library (libmvec, at most 4 units in the last place). Private. */
#ifndef AD_LANES_H
#define AD_LANES_H

#include "autodiff/tape/stumpff.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__AVX512F__)
#define LANES                       8
#define VECTOR_ABI(arguments, name) _ZGVeN8##arguments##_##name
#elif defined(__AVX2__)
#define LANES                       4
#define VECTOR_ABI(arguments, name) _ZGVdN4##arguments##_##name
#else
#define LANES                       2
#define VECTOR_ABI(arguments, name) _ZGVbN2##arguments##_##name
#endif

#define INLINE static inline __attribute__((always_inline))

typedef double vec __attribute__((vector_size(LANES * 8), may_alias));
typedef int64_t bits __attribute__((vector_size(LANES * 8), may_alias));

#define SCALAR_FUNCTION1(name)                                                                     \
    INLINE vec v_##name(vec a)                                                                     \
    {                                                                                              \
        for (int i = 0; i < LANES; i++) {                                                          \
            a[i] = name(a[i]);                                                                     \
        }                                                                                          \
        return a;                                                                                  \
    }
#define SCALAR_FUNCTION2(name)                                                                     \
    INLINE vec v_##name(vec a, vec b)                                                              \
    {                                                                                              \
        for (int i = 0; i < LANES; i++) {                                                          \
            a[i] = name(a[i], b[i]);                                                               \
        }                                                                                          \
        return a;                                                                                  \
    }
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
#if !defined(AD_MVEC_OLD) && !__GLIBC_PREREQ(2, 35) /* without vectors for erf and atan2 */
#define AD_MVEC_OLD
#endif
#else
#define VECTOR_FUNCTION1(name) SCALAR_FUNCTION1(name)
#define VECTOR_FUNCTION2(name) SCALAR_FUNCTION2(name)
#endif

VECTOR_FUNCTION1(sin)
VECTOR_FUNCTION1(cos)
VECTOR_FUNCTION1(exp)
VECTOR_FUNCTION1(log)
VECTOR_FUNCTION2(pow)
#ifdef AD_MVEC_OLD
SCALAR_FUNCTION1(erf)
SCALAR_FUNCTION2(atan2)
#else
VECTOR_FUNCTION1(erf)
VECTOR_FUNCTION2(atan2)
#endif

INLINE vec splat(double number)
{
    vec zero = {0};
    return number - zero; /* not zero + number: keeps -0 */
}

/* a b + c, rounded once where the processor has an instruction for it. Compilers say so in words of
 * their own (clang 14 does not define __FP_FAST_FMA), and must agree: one compiles the kernels,
 * another, perhaps, what is written out. */
INLINE double mul_add(double a, double b, double c)
{
#if defined(__FP_FAST_FMA) || defined(__FMA__) || defined(__ARM_FEATURE_FMA)
    return __builtin_fma(a, b, c);
#else
    return a * b + c;
#endif
}

INLINE vec v_mul_add(vec a, vec b, vec c)
{
    for (int i = 0; i < LANES; i++) {
        a[i] = mul_add(a[i], b[i], c[i]);
    }
    return a;
}

INLINE vec v_mul_sub(vec a, vec b, vec c)
{
    return v_mul_add(a, b, -c);
}

INLINE vec v_sub_mul(vec a, vec b, vec c)
{
    return v_mul_add(-a, b, c);
}

INLINE vec v_scaled_mul(vec a, vec b, double number)
{
    return number * (a * b);
}

INLINE vec v_scaled_mul_add(vec a, vec b, vec c, double number)
{
    return v_mul_add(splat(number), a * b, c);
}

INLINE vec v_scaled_mul_sub(vec a, vec b, vec c, double number)
{
    return v_mul_sub(splat(number), a * b, c);
}

INLINE vec v_pair_add(vec a, vec b, vec c, vec d, double number)
{
    return v_mul_add(splat(number), a * b, c * d);
}

INLINE vec v_pair_sub(vec a, vec b, vec c, vec d, double number)
{
    return v_mul_sub(splat(number), a * b, c * d);
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

INLINE vec v_select(vec a, vec b, vec c)
{
    return choose(a > 0, b, c);
}

/* tanh, the function networks use most: at most 3 units in the last place, and faster than the
 * library's. tanh |a| = e / (e + 2), e = exp(2 |a|) - 1 = 2^k (r + r^2 q(r)) + (2^k - 1), where r =
 * 2 |a| - k ln 2 in two parts (Cody and Waite), |r| <= ln(2)/2; q interpolates (exp(r) - 1 - r)/r^2
 * at Chebyshev points to 2^-60, odd and even powers apart for half the latency. */
INLINE vec v_tanh(vec a)
{
    const bits sign = (bits)a & INT64_MIN;
    const vec x = (vec)((bits)a ^ sign);
    const vec x2 = 2 * choose(x > 20, splat(20), x); /* tanh rounds to 1; NaN stays */
    const vec shifted =
        v_mul_add(x2, splat(0x1.71547652b82fep+0), splat(0x1.8p52)); /* k in the lowest bits */
    const vec k = shifted - 0x1.8p52;
    const vec r =
        v_sub_mul(k, splat(0x1.ef35793c76730p-45), v_sub_mul(k, splat(0x1.62e42fefa3800p-1), x2));
    const vec power = (vec)(((bits)shifted << 52) + (bits)splat(1)); /* 2^k */
    const vec r2 = r * r;
    vec even = v_mul_add(r2, splat(0x1.1f730349868cep-29), splat(0x1.27e4db646b17ep-22));
    vec odd = v_mul_add(r2, splat(0x1.af4de97ca4194p-26), splat(0x1.71de0231960ebp-19));
    even = v_mul_add(even, r2, splat(0x1.a01a01a6d889cp-16));
    odd = v_mul_add(odd, r2, splat(0x1.a01a01abe7fe1p-13));
    even = v_mul_add(even, r2, splat(0x1.6c16c16c162d4p-10));
    odd = v_mul_add(odd, r2, splat(0x1.11111111100dcp-7));
    even = v_mul_add(even, r2, splat(0x1.5555555555556p-5));
    odd = v_mul_add(odd, r2, splat(0x1.5555555555557p-3));
    even = v_mul_add(even, r2, splat(0.5));
    const vec e = v_mul_add(power, v_mul_add(v_mul_add(odd, r, even), r2, r), power - 1);
    return (vec)((bits)(e / (e + 2)) | sign);
}

INLINE vec v_tanh_sum(vec a, vec b)
{
    return v_tanh(a + b);
}

INLINE vec v_reciprocal(vec a)
{
    return 1 / a;
}

INLINE vec v_reciprocal_or_zero(vec a)
{
    return choose(a == 0, splat(0), 1 / a);
}

INLINE vec v_power(vec a, double number)
{
    return v_pow(a, splat(number));
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
    const double *t = ad_stumpff_terms + whole;
    const bits near = v_abs(a) <= splat(AD_STUMPFF_NEAR);
    vec sum = splat(t[2 * AD_STUMPFF_TERMS - 2]);
    for (int i = AD_STUMPFF_TERMS - 2; i >= 0; i--) {
        sum = splat(t[2 * i]) - a * sum;
    }
    for (int i = 0; i < LANES; i++) {
        sum[i] = near[i] ? sum[i] : ad_stumpff_far(whole, a[i]);
    }
    return sum;
}

#endif
