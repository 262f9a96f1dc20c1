/* exp of a number, at most 1 unit in the last place off, and nothing that keeps a compiler from
 * taking several at once: 2^k exp(r), r = a - k ln 2 in two parts (Cody and Waite), and the
 * polynomial of tanh.h. 2^k in two factors, so that subnormal results are rounded once. Private. */
#ifndef AD_EXP_H
#define AD_EXP_H

#include <math.h>
#include <stdint.h>
#include <string.h>

static inline double ad_exp_number(double a)
{
    const double size = fabs(a), beyond = 750 - size, most = 750; /* inf, 0; NaN stays */
    uint64_t bits, large, limit, whole;
    double x, power, half;
    memcpy(&bits, &size, sizeof bits);
    memcpy(&large, &beyond, sizeof large);
    memcpy(&limit, &most, sizeof limit);
    large = 0 - (large >> 63);
    bits = (bits & ~large) | (limit & large);
    memcpy(&x, &bits, sizeof x);
    x = copysign(x, a);
    const double shifted = x * 1.4426950408889634 + 6755399441055744.0,
                 k = shifted - 6755399441055744.0;
    const double high = x - k * 0.6931471805598903, low = k * 5.497923018708371e-14, r = high - low,
                 r2 = r * r, left = (high - r) - low;
    double even = r2 * 2.0914686968086876e-09 + 2.75572736431103e-07;
    double odd = r2 * 2.5105217004720745e-08 + 2.7557255400206422e-06;
    even = even * r2 + 2.4801587325547743e-05;
    odd = odd * r2 + 0.00019841269874820627;
    even = even * r2 + 0.0013888888888883748;
    odd = odd * r2 + 0.008333333333326136;
    even = even * r2 + 0.04166666666666667;
    odd = odd * r2 + 0.1666666666666667;
    even = even * r2 + 0.5;
    memcpy(&bits, &shifted, sizeof bits);
    bits += 2048; /* k + 2048 in the lowest bits, positive */
    bits &= 8191;
    whole = bits >> 1;
    bits = (bits - whole - 1) << 52;
    memcpy(&power, &bits, sizeof power);
    bits = (whole - 1) << 52;
    memcpy(&half, &bits, sizeof half);
    return (1 + (r + (left + (odd * r + even) * r2))) * power * half;
}

#endif
