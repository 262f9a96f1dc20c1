/* tape/stumpff.h for numbers of single precision. Private. */
#ifndef AD_STUMPFF_SINGLE_H
#define AD_STUMPFF_SINGLE_H

#include <math.h>

static inline float ad_stumpff_single(int k, float a)
{
    const float root = sqrtf(fabsf(a));
    float term = 1;
    if (k == 0) {
        return a > 0 ? cosf(root) : coshf(root);
    }
    if (fabsf(a) < 1 || fabsf(a) < (float)(k * (k - 1))) {
        for (int i = 2; i <= k; i++) {
            term /= (float)i;
        }
        float sum = term;
        for (int i = 1; fabsf(term) > 1e-9f * fabsf(sum); i++) {
            term *= -a / (float)((k + 2 * i - 1) * (k + 2 * i));
            sum += term;
        }
        return sum;
    }
    if (k == 1) {
        return a > 0 ? sinf(root) / root : sinhf(root) / root;
    }
    for (int i = 2; i <= k - 2; i++) {
        term /= (float)i;
    }
    return (term - ad_stumpff_single(k - 2, a)) / a;
}

#endif
