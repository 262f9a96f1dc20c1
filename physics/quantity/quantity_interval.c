/* Interval extensions of the operations of formulas: values, and derivatives by the arguments.
 *
 * Ends move outward by a few roundings, for those of the functions of the C library. A result of
 * which an end is not a number is the whole line. */
#include "physics/numerics/constants.h"
#include "physics/quantity/quantity_internal.h"

#include <float.h>
#include <math.h>

typedef quantity_interval interval;

/* The functions of the C library are right to two units in the last place (glibc manual). */
static const double WIDENING = 4 * DBL_EPSILON;

static const interval LINE = {-INFINITY, INFINITY};

/* Exact ends. */
static interval between(double low, double high)
{
    return low <= high ? (interval){low, high} : LINE;
}

/* What has overflowed is beyond all numbers. */
static interval outward(double low, double high)
{
    low = low == INFINITY ? DBL_MAX : low;
    high = high == -INFINITY ? -DBL_MAX : high;
    return between(low - WIDENING * fabs(low), high + WIDENING * fabs(high));
}

static bool holds(interval x, double value)
{
    return x.low <= value && value <= x.high;
}

static interval number(double value)
{
    return (interval){value, value};
}

static interval hull(interval a, interval b)
{
    return between(fmin(a.low, b.low), fmax(a.high, b.high));
}

/* ---- arithmetic ------------------------------------------------------------------------------ */

interval quantity_interval_add(interval a, interval b)
{
    return outward(a.low + b.low, a.high + b.high);
}

static interval subtract(interval a, interval b)
{
    return outward(a.low - b.high, a.high - b.low);
}

static interval negative(interval x)
{
    return (interval){-x.high, -x.low};
}

/* Of four corners; not a number if one is none. */
static interval corners(double a, double b, double c, double d)
{
    if (isnan(a) || isnan(b) || isnan(c) || isnan(d)) {
        return LINE;
    }
    return outward(fmin(fmin(a, b), fmin(c, d)), fmax(fmax(a, b), fmax(c, d)));
}

interval quantity_interval_multiply(interval a, interval b)
{
    return corners(a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high);
}

static interval divide(interval a, interval b)
{
    return holds(b, 0) ? LINE
                       : corners(a.low / b.low, a.low / b.high, a.high / b.low, a.high / b.high);
}

static interval reciprocal(interval x)
{
    return divide(number(1), x);
}

static interval square(interval x)
{
    double low = x.low * x.low, high = x.high * x.high;
    return holds(x, 0) ? outward(0, fmax(low, high)) : outward(fmin(low, high), fmax(low, high));
}

void quantity_range_add(const interval *x, interval *value, interval *by)
{
    *value = quantity_interval_add(x[0], x[1]);
    by[0] = by[1] = number(1);
}

void quantity_range_subtract(const interval *x, interval *value, interval *by)
{
    *value = subtract(x[0], x[1]);
    by[0] = number(1);
    by[1] = number(-1);
}

void quantity_range_multiply(const interval *x, interval *value, interval *by)
{
    *value = quantity_interval_multiply(x[0], x[1]);
    by[0] = x[1];
    by[1] = x[0];
}

void quantity_range_divide(const interval *x, interval *value, interval *by)
{
    *value = divide(x[0], x[1]);
    by[0] = reciprocal(x[1]);
    by[1] = negative(divide(x[0], square(x[1])));
}

/* ---- functions ------------------------------------------------------------------------------- */

typedef double function(double);

static interval rising(function *f, interval x)
{
    return outward(f(x.low), f(x.high));
}

static interval falling(function *f, interval x)
{
    return outward(f(x.high), f(x.low));
}

/* x^n for n one number; roots of what is negative are undefined, and powers below 0 at 0. */
static interval power(interval x, double n)
{
    bool whole = n == floor(n), even = whole && fmod(n, 2) == 0;
    double low = pow(x.low, n), high = pow(x.high, n);
    if ((x.low < 0 && !whole) || (n < 0 && holds(x, 0)) || isnan(low) || isnan(high)) {
        return LINE;
    }
    if (even && n > 0 && holds(x, 0)) {
        return outward(0, fmax(low, high));
    }
    return outward(fmin(low, high), fmax(low, high));
}

void quantity_range_power(const interval *x, interval *value, interval *by)
{
    double n = x[1].low;
    *value = power(x[0], n);
    by[0] = n == 0 ? number(0) : quantity_interval_multiply(number(n), power(x[0], n - 1));
    by[1] = number(0);
}

/* cos(pi (x - shift)): extremes where that is a whole number, even ones high. */
static interval wave(function *f, interval x, double shift)
{
    static const double FAR = 1e8; /* where whole numbers are not told apart any more */
    double slack = 1e-12 * fmax(1, fmax(fabs(x.low), fabs(x.high)));
    double first = ceil(x.low / PI - shift - slack), last = floor(x.high / PI - shift + slack);
    if (isinf(x.low) || isinf(x.high)) {
        return LINE;
    }
    if (!(fabs(x.low) < FAR && fabs(x.high) < FAR) || last > first) {
        return (interval){-1, 1};
    }
    double low = fmin(f(x.low), f(x.high)), high = fmax(f(x.low), f(x.high));
    if (first == last) {
        high = fmod(first, 2) == 0 ? 1 : high;
        low = fmod(first, 2) == 0 ? low : -1;
    }
    interval ends = outward(low, high);
    return between(fmax(-1, ends.low), fmin(1, ends.high));
}

void quantity_range_sin(const interval *x, interval *value, interval *by)
{
    *value = wave(sin, x[0], 0.5);
    by[0] = wave(cos, x[0], 0);
}

void quantity_range_cos(const interval *x, interval *value, interval *by)
{
    *value = wave(cos, x[0], 0);
    by[0] = negative(wave(sin, x[0], 0.5));
}

void quantity_range_tan(const interval *x, interval *value, interval *by)
{
    bool has_pole = holds(wave(cos, x[0], 0), 0);
    *value = has_pole ? LINE : rising(tan, x[0]);
    by[0] = quantity_interval_add(number(1), square(*value));
}

/* (1 - x^2)^(-1/2) */
static interval arc_slope(interval x)
{
    interval rest = subtract(number(1), square(x));
    return power(between(fmax(0, rest.low), rest.high), -0.5);
}

static bool leaves_unit(interval x)
{
    return x.low < -1 || x.high > 1;
}

void quantity_range_asin(const interval *x, interval *value, interval *by)
{
    *value = leaves_unit(x[0]) ? LINE : rising(asin, x[0]);
    by[0] = leaves_unit(x[0]) ? LINE : arc_slope(x[0]);
}

void quantity_range_acos(const interval *x, interval *value, interval *by)
{
    *value = leaves_unit(x[0]) ? LINE : falling(acos, x[0]);
    by[0] = leaves_unit(x[0]) ? LINE : negative(arc_slope(x[0]));
}

void quantity_range_atan(const interval *x, interval *value, interval *by)
{
    *value = rising(atan, x[0]);
    by[0] = reciprocal(quantity_interval_add(number(1), square(x[0])));
}

/* Of y and x: the directions of a box without the origin are between those of its corners; it jumps
 * across the negative half of the x axis. */
void quantity_range_atan2(const interval *x, interval *value, interval *by)
{
    interval distance = quantity_interval_add(square(x[0]), square(x[1]));
    if (x[1].low <= 0 && holds(x[0], 0)) {
        *value = outward(-PI, PI);
        by[0] = by[1] = LINE;
        return;
    }
    *value = corners(atan2(x[0].low, x[1].low), atan2(x[0].low, x[1].high),
                     atan2(x[0].high, x[1].low), atan2(x[0].high, x[1].high));
    by[0] = divide(x[1], distance);
    by[1] = negative(divide(x[0], distance));
}

static interval cosh_of(interval x)
{
    double low = cosh(x.low), high = cosh(x.high);
    return outward(holds(x, 0) ? 1 : fmin(low, high), fmax(low, high));
}

void quantity_range_sinh(const interval *x, interval *value, interval *by)
{
    *value = rising(sinh, x[0]);
    by[0] = cosh_of(x[0]);
}

void quantity_range_cosh(const interval *x, interval *value, interval *by)
{
    *value = cosh_of(x[0]);
    by[0] = rising(sinh, x[0]);
}

/* Its derivative is 1/cosh^2, which loses no digits far from 0 and may be 1/infinity there. */
void quantity_range_tanh(const interval *x, interval *value, interval *by)
{
    double low = cosh(x[0].low), high = cosh(x[0].high);
    double least = holds(x[0], 0) ? 1 : fmin(low, high), most = fmax(low, high);
    *value = rising(tanh, x[0]);
    by[0] = outward(1 / most / most, 1 / least / least);
}

void quantity_range_exp(const interval *x, interval *value, interval *by)
{
    *value = by[0] = rising(exp, x[0]);
}

void quantity_range_log(const interval *x, interval *value, interval *by)
{
    *value = x[0].low < 0 ? LINE : rising(log, x[0]);
    by[0] = x[0].low < 0 ? LINE : power(x[0], -1);
}

void quantity_range_sqrt(const interval *x, interval *value, interval *by)
{
    *value = x[0].low < 0 ? LINE : rising(sqrt, x[0]);
    by[0] = quantity_interval_multiply(number(0.5), power(x[0], -0.5));
}

/* ---- with kinks and jumps -------------------------------------------------------------------- */

void quantity_range_abs(const interval *x, interval *value, interval *by)
{
    double low = fabs(x[0].low), high = fabs(x[0].high);
    *value = between(holds(x[0], 0) ? 0 : fmin(low, high), fmax(low, high));
    by[0] = x[0].low > 0 ? number(1) : x[0].high < 0 ? number(-1) : between(-1, 1);
}

void quantity_range_min(const interval *x, interval *value, interval *by)
{
    *value = between(fmin(x[0].low, x[1].low), fmin(x[0].high, x[1].high));
    by[0] = x[0].high < x[1].low ? number(1) : x[0].low > x[1].high ? number(0) : between(0, 1);
    by[1] = subtract(number(1), by[0]);
}

void quantity_range_max(const interval *x, interval *value, interval *by)
{
    *value = between(fmax(x[0].low, x[1].low), fmax(x[0].high, x[1].high));
    by[0] = x[0].low > x[1].high ? number(1) : x[0].high < x[1].low ? number(0) : between(0, 1);
    by[1] = subtract(number(1), by[0]);
}

void quantity_range_step(const interval *x, interval *value, interval *by)
{
    bool never = x[0].high <= 0, always = x[0].low > 0;
    *value = between(always ? 1 : 0, never ? 0 : 1);
    by[0] = never || always ? number(0) : LINE;
}

/* Beyond the bounds there is no value. */
void quantity_range_within(const interval *x, interval *value, interval *by)
{
    bool inside = x[0].low >= x[1].high && x[0].high <= x[2].low;
    *value = inside ? x[0] : LINE;
    by[0] = inside ? number(1) : LINE;
    by[1] = by[2] = number(0);
}

void quantity_range_where(const interval *x, interval *value, interval *by)
{
    bool never = x[0].high <= 0, always = x[0].low > 0;
    *value = never ? x[2] : always ? x[1] : hull(x[1], x[2]);
    by[0] = never || always ? number(0) : LINE;
    by[1] = always ? number(1) : never ? number(0) : between(0, 1);
    by[2] = subtract(number(1), by[1]);
}
