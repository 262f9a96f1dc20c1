/* exp.h for numbers of single precision. Private. */
#ifndef AD_EXP_SINGLE_H
#define AD_EXP_SINGLE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

static inline float ad_exp_single(float a)
{
    const float size = fabsf(a), beyond = 105 - size, most = 105; /* inf, 0; NaN stays */
    uint32_t bits, large, limit, whole;
    float x, power, half;
    memcpy(&bits, &size, sizeof bits);
    memcpy(&large, &beyond, sizeof large);
    memcpy(&limit, &most, sizeof limit);
    large = 0 - (large >> 31);
    bits = (bits & ~large) | (limit & large);
    memcpy(&x, &bits, sizeof x);
    x = copysignf(x, a);
    const float shifted = x * 1.44269504f + 12582912.0f, k = shifted - 12582912.0f;
    const float high = x - k * 0.69287109375f, low = k * 0.000276086809945f, r = high - low,
                left = (high - r) - low;
    const float even = 0.5f + r * r * (0.0416664641974f + r * r * 0.00139337307158f),
                odd = 0.166666666817f + r * r * (0.00833331084465f + r * r * 0.000198910804640f);
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 256) & 1023; /* k + 256, positive */
    whole = bits >> 1;
    bits = (bits - whole - 1) << 23;
    memcpy(&power, &bits, sizeof power);
    bits = (whole - 1) << 23;
    memcpy(&half, &bits, sizeof half);
    return (1 + (r + (left + (odd * r + even) * r * r))) * power * half;
}

#endif
