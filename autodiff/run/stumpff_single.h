/* tape/stumpff.h for numbers of single precision. Private. */
#ifndef AD_STUMPFF_SINGLE_H
#define AD_STUMPFF_SINGLE_H

#include <math.h>

#define AD_STUMPFF_SINGLE_TERMS 8
/* clang-format off */
static const float ad_stumpff_single_terms[12 + 2 * AD_STUMPFF_SINGLE_TERMS - 1] = {
    1.0f, 1.0f, 0.5f, 0.166666667f, 0.0416666667f, 0.00833333333f, 0.00138888889f, 0.000198412698f,
    2.48015873e-05f, 2.75573192e-06f, 2.75573192e-07f, 2.50521084e-08f, 2.0876757e-09f,
    1.60590438e-10f, 1.14707456e-11f, 7.64716373e-13f, 4.77947733e-14f, 2.81145725e-15f,
    1.5619207e-16f, 8.22063525e-18f, 4.11031762e-19f, 1.95729411e-20f, 8.89679139e-22f,
    3.86817017e-23f, 1.61173757e-24f, 6.44695028e-26f, 2.47959626e-27f};
/* clang-format on */

#define AD_STUMPFF_NEAR 4

static inline float ad_stumpff_near_single(int k, float a)
{
    const float *t = ad_stumpff_single_terms + k;
    float sum = t[2 * AD_STUMPFF_SINGLE_TERMS - 2];
    for (int i = AD_STUMPFF_SINGLE_TERMS - 2; i >= 0; i--) {
        sum = t[2 * i] - a * sum;
    }
    return sum;
}

static inline float ad_stumpff_far_single(int k, float a)
{
    const float root = sqrtf(fabsf(a)), start = ad_stumpff_single_terms[k < 2 ? 0 : k - 2];
    if (k == 0) {
        return a > 0 ? cosf(root) : coshf(root);
    }
    if (k == 1) {
        return a > 0 ? sinf(root) / root : sinhf(root) / root;
    }
    if (fabsf(a) < (float)(k * (k - 1))) {
        float term = ad_stumpff_single_terms[k], sum = term;
        for (int i = 1; fabsf(term) > 1e-9f * fabsf(sum); i++) {
            term *= -a / (float)((k + 2 * i - 1) * (k + 2 * i));
            sum += term;
        }
        return sum;
    }
    return (start - ad_stumpff_far_single(k - 2, a)) / a;
}

static inline float ad_stumpff_single(int k, float a)
{
    return fabsf(a) <= AD_STUMPFF_NEAR ? ad_stumpff_near_single(k, a) : ad_stumpff_far_single(k, a);
}

#endif
