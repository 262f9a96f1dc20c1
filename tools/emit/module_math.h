/* What C that is written has of <math.h> and <string.h>, where there is no library of C: functions
 * that are declared are those of JavaScript's Math. */
#ifndef MODULE_MATH_H
#define MODULE_MATH_H

#define HUGE_VAL       __builtin_huge_val()
#define INFINITY       __builtin_inff()
#define NAN            __builtin_nanf("")
#define isnan(x)       __builtin_isnan(x)
#define isfinite(x)    __builtin_isfinite(x)
#define isgreater      __builtin_isgreater
#define isgreaterequal __builtin_isgreaterequal
#define isless         __builtin_isless
#define islessequal    __builtin_islessequal
#define copysign       __builtin_copysign
#define fabs           __builtin_fabs
#define sqrt           __builtin_sqrt
#define memcpy         __builtin_memcpy

static double fmin(double a, double b)
{
    return b < a ? b : a;
}

static double fmax(double a, double b)
{
    return b > a ? b : a;
}

double sin(double), cos(double), tan(double), asin(double), acos(double), atan(double);
double sinh(double), cosh(double), tanh(double), exp(double), expm1(double);
double log(double), log1p(double), pow(double, double), atan2(double, double);

#endif
