/* Functions of numbers that the C of programs is made of, against libm: those of double against
 * long double, those of float against double, in units in the last place of what is right. */
#include "near.h"

#include "autodiff/run/exp.h"
#include "autodiff/run/exp_single.h"
#include "autodiff/run/sine.h"
#include "autodiff/run/sine_single.h"
#include "autodiff/run/stumpff_single.h"
#include "autodiff/run/tanh.h"
#include "autodiff/run/tanh_single.h"
#include "autodiff/tape/stumpff.h"

#include <float.h>
#include <stdbool.h>

enum { POINTS = 200000 };

static uint64_t random_state = 5;

static double random_part(void)
{
    random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(random_state >> 11) * 0x1p-53;
}

/* Of either sign, as many per decade from `low` to `high`. */
static double random_size(double low, double high)
{
    double size = low * pow(high / low, random_part());
    return random_part() < 0.5 ? -size : size;
}

/* |is - wanted| over the distance of numbers with `digits` bits at `wanted`. */
static double units(long double is, long double wanted, int digits, double least)
{
    int exponent;
    frexpl(wanted, &exponent);
    return (double)(fabsl(is - wanted) / fmaxl(ldexpl(1, exponent - digits), least));
}

static void check(const char *what, double a, long double is, long double wanted, bool single,
                  double most)
{
    double off = single ? units(is, wanted, FLT_MANT_DIG, (double)FLT_MIN * FLT_EPSILON)
                        : units(is, wanted, DBL_MANT_DIG, DBL_MIN * DBL_EPSILON);
    if (!(off <= most)) {
        fail_msg("%s of %.17g is %.17Lg, not %.17Lg: %.2f units", what, a, is, wanted, off);
    }
}

/* Where sin or cos is 0 to rounding, and the numbers beside it. */
static double near_zero(double most)
{
    double a = floor(2 * (random_part() - 0.5) * most / 1.5707963267948966) * 1.5707963267948966;
    for (int k = (int)(4 * random_part()); k > 0; k--) {
        a = nextafter(a, 1e300);
    }
    return fabs(a) <= most ? a : 1;
}

static void test_sine(void **state)
{
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        double a = i % 4 ? random_size(1e-9, AD_SINE_MOST) : near_zero(AD_SINE_MOST);
        check("sin", a, ad_sine_number(a, 0), sinl(a), false, 1);
        check("cos", a, ad_sine_number(a, 1), cosl(a), false, 1);
        double b = (double)AD_SINE_MOST_SINGLE;
        float x = (float)(i % 4 ? random_size(1e-5, b) : near_zero(0.99 * b));
        check("sin, single", x, ad_sine_single(x, 0), sinl(x), true, 1);
        check("cos, single", x, ad_sine_single(x, 1), cosl(x), true, 1);
    }
    assert_true(isnan(ad_sine_number(NAN, 0)) && isnan((double)ad_sine_single((float)NAN, 1)));
}

/* Results that are subnormal are rounded once more. */
static void test_exp(void **state)
{
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        double a = i % 2 ? random_size(1e-9, 1) : -746 + 1455.7 * random_part();
        check("exp", a, ad_exp_number(a), expl(a), false, 1.1);
        float x = (float)(i % 2 ? random_size(1e-5, 1) : -104 + 192.7 * random_part());
        check("exp, single", x, ad_exp_single(x), expl(x), true, 1.1);
    }
    assert_true(isnan(ad_exp_number(NAN)) && ad_exp_number(-1e9) == 0 && isinf(ad_exp_number(710)));
    assert_true(ad_exp_number(0) == 1 && ad_exp_number(-INFINITY) == 0);
    assert_true(isnan((double)ad_exp_single((float)NAN)) && isinf((double)ad_exp_single(89)));
}

/* Against that of double, itself tested with its derivatives (test_ops), below where c_0 is 0. */
static void test_stumpff(void **state)
{
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        const int k = i % 6;
        const float x = (float)random_size(1e-5, 2);
        check("stumpff, single", x, ad_stumpff_single(k, x), ad_stumpff_number(k, (double)x), true,
              8);
    }
    assert_true(isnan((double)ad_stumpff_single(2, (float)NAN)));
}

static void test_tanh(void **state)
{
    (void)state;
    for (int i = 0; i < POINTS; i++) {
        double a = random_size(1e-9, 40);
        check("tanh", a, ad_tanh_number(a), tanhl(a), false, 4);
        float x = (float)a;
        check("tanh, single", x, ad_tanh_single(x), tanhl(x), true, 4);
    }
    assert_true(isnan(ad_tanh_number(NAN)) && isnan((double)ad_tanh_single((float)NAN)));
    assert_true(ad_tanh_number(-INFINITY) == -1 && (double)ad_tanh_single(1e30F) == 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sine), cmocka_unit_test(test_exp),
                                       cmocka_unit_test(test_tanh), cmocka_unit_test(test_stumpff)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
