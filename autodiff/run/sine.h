/* sin of a number, turns = 0, or cos, turns = 1, at most 1 unit in the last place off for |a| <=
 * AD_SINE_MOST, and nothing that keeps a compiler from taking several at once. Private.
 *
 * r = a - k pi/2, |r| <= pi/4, with pi/2 in four parts, of which three have 26 bits, so that k
 * times them is exact up to k = 2^27 (Cody and Waite); r in two parts. The polynomials interpolate
 * (sin r - r)/r^3 and (cos r - 1 + r^2/2)/r^4 at Chebyshev points of r^2 to 2^-55. */
#ifndef AD_SINE_H
#define AD_SINE_H

#include <stdint.h>
#include <string.h>

#define AD_SINE_MOST 1e8

static inline double ad_sine_number(double a, int turns)
{
    const double shifted = a * 0.6366197723675814 + 6755399441055744.0,
                 k = shifted - 6755399441055744.0;
    const double b = (a - k * 1.5707963109016418) - k * 1.5893254712295857e-08,
                 w = k * 6.123233932053594e-17, r = b - w;
    const double low = ((b - r) - w) - k * 6.36831716351095e-25, z = r * r;
    const double sine_low = z * (-2.505112989596281e-08 + z * 1.5917988944318715e-10),
                 sine = -0.16666666666666666 +
                        z * (0.008333333333330937 + z * (-0.00019841269836740528 +
                                                         z * (2.7557316093196066e-06 + sine_low)));
    const double cosine_low = z * (2.087614504910828e-09 - z * 1.138254462340429e-11),
                 cosine =
                     0.04166666666666667 + z * (-0.0013888888888887388 +
                                                z * (2.4801587298754398e-05 +
                                                     z * (-2.7557317265876613e-07 + cosine_low)));
    const double half = 0.5 * z, one = 1 - half;
    const double s = r + (low + r * z * sine - half * low),
                 c = one + (((1 - one) - half) + (z * z * cosine - r * low));
    uint64_t quadrant, odd, bits, other;
    memcpy(&quadrant, &shifted, sizeof quadrant);
    quadrant += (uint64_t)turns;
    odd = 0 - (quadrant & 1);
    memcpy(&bits, &s, sizeof bits);
    memcpy(&other, &c, sizeof other);
    bits = ((bits & ~odd) | (other & odd)) ^ ((quadrant & 2) << 62);
    {
        double result;
        memcpy(&result, &bits, sizeof result);
        return result;
    }
}

#endif
