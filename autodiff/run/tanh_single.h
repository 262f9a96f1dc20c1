/* tanh.h for numbers of single precision, at most 4 units in the last place off. Private. */
#ifndef AD_TANH_SINGLE_H
#define AD_TANH_SINGLE_H

#include <math.h>
#include <stdint.h>
#include <string.h>

static inline float ad_tanh_single(float a)
{
    const float size = fabsf(a), left = 10 - size, most = 10;
    uint32_t bits, large, limit;
    float x2, power;
    memcpy(&bits, &size, sizeof bits);
    memcpy(&large, &left, sizeof large);
    memcpy(&limit, &most, sizeof limit);
    large = 0 - (large >> 31);
    bits = (bits & ~large) | (limit & large);
    memcpy(&x2, &bits, sizeof x2);
    x2 *= 2;
    const float shifted = x2 * 1.44269504f + 12582912.0f, k = shifted - 12582912.0f;
    const float r = (x2 - k * 0.69287109375f) - k * 0.000276086809945f, r2 = r * r;
    const float even = 0.5f + r2 * (0.0416664641974f + r2 * 0.00139337307158f),
                odd = 0.166666666817f + r2 * (0.00833331084465f + r2 * 0.000198910804640f);
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits << 23) + ((uint32_t)127 << 23);
    memcpy(&power, &bits, sizeof power);
    {
        const float e = power * ((odd * r + even) * r2 + r) + (power - 1);
        return copysignf(e / (e + 2), a);
    }
}

#endif
