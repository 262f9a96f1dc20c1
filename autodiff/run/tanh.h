/* tanh of a number, as v_tanh of lanes.h has it but for the rounding of products: at most 4 units
 * in the last place, and nothing that keeps a compiler from taking several at once, not even a
 * comparison: where 20 - |a| is negative, 20 is taken for |a|. Private. */
#ifndef AD_TANH_H
#define AD_TANH_H

#include <math.h>
#include <stdint.h>
#include <string.h>

static inline double ad_tanh_number(double a)
{
    const double size = fabs(a), left = 20 - size, most = 20;
    uint64_t bits, large, limit;
    double x2, power;
    memcpy(&bits, &size, sizeof bits);
    memcpy(&large, &left, sizeof large);
    memcpy(&limit, &most, sizeof limit);
    large = 0 - (large >> 63);
    bits = (bits & ~large) | (limit & large);
    memcpy(&x2, &bits, sizeof x2);
    x2 *= 2;
    const double shifted = x2 * 1.4426950408889634 + 6755399441055744.0,
                 k = shifted - 6755399441055744.0;
    const double r = (x2 - k * 0.6931471805598903) - k * 5.497923018708371e-14, r2 = r * r;
    double even = r2 * 2.0914686968086876e-09 + 2.75572736431103e-07;
    double odd = r2 * 2.5105217004720745e-08 + 2.7557255400206422e-06;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits << 52) + ((uint64_t)1023 << 52);
    memcpy(&power, &bits, sizeof power);
    even = even * r2 + 2.4801587325547743e-05;
    odd = odd * r2 + 0.00019841269874820627;
    even = even * r2 + 0.0013888888888883748;
    odd = odd * r2 + 0.008333333333326136;
    even = even * r2 + 0.04166666666666667;
    odd = odd * r2 + 0.1666666666666667;
    even = even * r2 + 0.5;
    {
        const double e = power * ((odd * r + even) * r2 + r) + (power - 1);
        return copysign(e / (e + 2), a);
    }
}

#endif
