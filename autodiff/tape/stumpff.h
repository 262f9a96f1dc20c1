/* The Stumpff functions of a number. Private. */
#ifndef AD_STUMPFF_H
#define AD_STUMPFF_H

#include <math.h>

/* The series where its terms fall from the start, |a| < max(1, k (k-1)); elsewhere the closed forms
 * of c_0 and c_1 and a c_(k+2) = 1/k! - c_k, which loses no digits there. */
static inline double ad_stumpff_number(int k, double a)
{
    double root = sqrt(fabs(a)), term = 1;
    if (k == 0) {
        return a > 0 ? cos(root) : cosh(root);
    }
    if (fabs(a) < 1 || fabs(a) < (double)k * (k - 1)) {
        for (int i = 2; i <= k; i++) {
            term /= i;
        }
        double sum = term;
        for (int i = 1; fabs(term) > 1e-18 * fabs(sum); i++) {
            term *= -a / ((double)(k + 2 * i - 1) * (k + 2 * i));
            sum += term;
        }
        return sum;
    }
    if (k == 1) {
        return a > 0 ? sin(root) / root : sinh(root) / root;
    }
    for (int i = 2; i <= k - 2; i++) {
        term /= i;
    }
    return (term - ad_stumpff_number(k - 2, a)) / a;
}

#endif
