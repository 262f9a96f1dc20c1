/* The Stumpff functions of a number, c_k(a) = sum_i (-a)^i / (k + 2i)!. */
#ifndef AD_STUMPFF_H
#define AD_STUMPFF_H

#include <math.h>

/* 1/n!, of which the series takes every second from n = k on; k is at most 12 (AD_STUMPFF_MAX).
 * Each is the one before over n, as rounded, so that derivatives, (k c_(k+2) - c_(k+1)) / 2, lose
 * less. */
#define AD_STUMPFF_TERMS 13
/* clang-format off */
static const double ad_stumpff_terms[12 + 2 * AD_STUMPFF_TERMS - 1] = {
    1, 1, 0.5, 0.16666666666666666, 0.041666666666666664, 0.008333333333333333,
    0.001388888888888889, 0.0001984126984126984, 2.48015873015873e-05, 2.7557319223985893e-06,
    2.7557319223985894e-07, 2.505210838544172e-08, 2.08767569878681e-09, 1.6059043836821616e-10,
    1.1470745597729726e-11, 7.647163731819817e-13, 4.779477332387386e-14, 2.811457254345521e-15,
    1.5619206968586228e-16, 8.220635246624331e-18, 4.1103176233121653e-19, 1.9572941063391263e-20,
    8.896791392450574e-22, 3.868170170630684e-23, 1.6117375710961184e-24, 6.446950284384474e-26,
    2.4795962632247976e-27, 9.183689863795547e-29, 3.2798892370698385e-30, 1.1309962886447718e-31,
    3.769987628815906e-33, 1.2161250415535181e-34, 3.800390754854744e-36, 1.151633562077195e-37,
    3.387157535521162e-39, 9.67759295863189e-41, 2.6882202662866363e-42};
/* clang-format on */

#define AD_STUMPFF_NEAR 4

/* For |a| <= AD_STUMPFF_NEAR the series to 2^-60, with nothing that keeps a compiler from taking
 * several at once. */
static inline double ad_stumpff_near(int k, double a)
{
    const double *t = ad_stumpff_terms + k;
    double sum = t[2 * AD_STUMPFF_TERMS - 2];
    for (int i = AD_STUMPFF_TERMS - 2; i >= 0; i--) {
        sum = t[2 * i] - a * sum;
    }
    return sum;
}

/* Beyond: the series where its terms fall from the start, |a| < k (k-1); elsewhere the closed forms
 * of c_0 and c_1 and a c_(k+2) = 1/k! - c_k, which loses no digits there. */
static inline double ad_stumpff_far(int k, double a)
{
    const double root = sqrt(fabs(a)), start = ad_stumpff_terms[k < 2 ? 0 : k - 2];
    if (k == 0) {
        return a > 0 ? cos(root) : cosh(root);
    }
    if (k == 1) {
        return a > 0 ? sin(root) / root : sinh(root) / root;
    }
    if (fabs(a) < (double)k * (k - 1)) {
        double term = ad_stumpff_terms[k], sum = term;
        for (int i = 1; fabs(term) > 1e-18 * fabs(sum); i++) {
            term *= -a / ((double)(k + 2 * i - 1) * (k + 2 * i));
            sum += term;
        }
        return sum;
    }
    return (start - ad_stumpff_far(k - 2, a)) / a;
}

static inline double ad_stumpff_number(int k, double a)
{
    return fabs(a) <= AD_STUMPFF_NEAR ? ad_stumpff_near(k, a) : ad_stumpff_far(k, a);
}

#endif
