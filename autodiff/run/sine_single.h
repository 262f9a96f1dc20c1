/* sine.h for numbers of single precision: pi/2 has three parts of 11 bits and the rest. Private. */
#ifndef AD_SINE_SINGLE_H
#define AD_SINE_SINGLE_H

#include <stdint.h>
#include <string.h>

#define AD_SINE_MOST_SINGLE 1e4f

static inline float ad_sine_single(float a, int turns)
{
    const float shifted = a * 0.636619772f + 12582912.0f, k = shifted - 12582912.0f;
    const float b = (a - k * 1.5703125f) - k * 0.00048375129699707031f, w = k * 7.5495336206e-08f,
                r = b - w;
    const float low = ((b - r) - w) - k * 2.5633441516e-12f, z = r * r;
    const float sine = -0.166666646563f + z * (0.00833274710437f - z * 0.000195876390358f),
                cosine = 0.0416666646535f + z * (-0.0013888301867f + z * 2.45476897094e-05f);
    const float half = 0.5f * z, one = 1 - half;
    const float s = r + (low + r * z * sine - half * low),
                c = one + (((1 - one) - half) + (z * z * cosine - r * low));
    uint32_t quadrant, odd, bits, other;
    memcpy(&quadrant, &shifted, sizeof quadrant);
    quadrant += (uint32_t)turns;
    odd = 0 - (quadrant & 1);
    memcpy(&bits, &s, sizeof bits);
    memcpy(&other, &c, sizeof other);
    bits = ((bits & ~odd) | (other & odd)) ^ ((quadrant & 2) << 30);
    {
        float result;
        memcpy(&result, &bits, sizeof result);
        return result;
    }
}

#endif
