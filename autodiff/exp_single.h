/* exp.h for numbers of single precision. Private. */
#ifndef AD_EXP_SINGLE_H
#define AD_EXP_SINGLE_H

#include <stdint.h>
#include <string.h>

static inline float ad_exp_single(float a)
{
    const float most = a > 89 ? 89 : a, x = most < -105 ? -105 : most; /* inf, 0; NaN stays */
    const float shifted = x * 1.44269504f + 12582912.0f, k = shifted - 12582912.0f;
    const float high = x - k * 0.69287109375f, low = k * 0.000276086809945f, r = high - low,
                left = (high - r) - low;
    const float even = 0.5f + r * r * (0.0416664641974f + r * r * 0.00139337307158f),
                odd = 0.166666666817f + r * r * (0.00833331084465f + r * r * 0.000198910804640f);
    uint32_t bits, whole;
    float power, half;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits + 256) & 1023; /* k + 256, positive */
    whole = bits >> 1;
    bits = (bits - whole + 127 - 128) << 23;
    memcpy(&power, &bits, sizeof power);
    bits = (whole + 127 - 128) << 23;
    memcpy(&half, &bits, sizeof half);
    return (1 + (r + (left + (odd * r + even) * r * r))) * power * half;
}

#endif
