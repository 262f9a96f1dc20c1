/* Operations at and around their singular points: values and derivatives are what ad.h defines. */
#include "ad_testing.h"

enum { ORDER = 4 };

typedef ad_value (*unary)(ad_value);

/* Value, first derivative by reverse mode, Taylor coefficients 0 .. ORDER at x. */
typedef struct expansion {
    double slope;
    double c[ORDER + 1];
} expansion;

/* x is a parameter (`batch` false) or an input: ad_op_evaluate or kernels. */
static expansion expand(unary f, double at, bool batch)
{
    ad_tape *tape = ad_tape_create();
    ad_value x = batch ? ad_input(tape, "x", 1) : ad_parameter(tape, "x", 1, 0);
    ad_value y = f(x), values[ORDER + 2];
    ad_reverse(y, 1, &x, AD_SUMMED, values);
    ad_taylor(1, &y, x, ad_scalar(tape, 1), ORDER, values + 1);
    assert_tape_ok(tape);
    uint64_t random = 1;
    run_data data;
    data_fill(&data, tape, 1, at, at, &random);
    expansion e;
    compiled c = run_compiled(ORDER + 2, values, NULL, 1, &data);
    e.slope = c.results[0][0];
    for (int k = 0; k <= ORDER; k++)
        e.c[k] = c.results[k + 1][0];
    compiled_free(&c);
    data_free(&data);
    ad_tape_free(tape);
    return e;
}

static void check_point(unary f, double at, double value, double slope, double tolerance)
{
    for (int batch = 0; batch < 2; batch++) {
        expansion e = expand(f, at, batch);
        assert_near(e.c[0], value, tolerance);
        assert_near(e.slope, slope, tolerance);
        assert_near(e.c[1], slope, tolerance);
    }
}

static void check_finite(unary f, double at)
{
    for (int batch = 0; batch < 2; batch++) {
        expansion e = expand(f, at, batch);
        for (int k = 0; k <= ORDER; k++)
            assert_true(isfinite(e.c[k]));
    }
}

/* ---- one variable -------------------------------------------------------------------------------
 */

static void test_sqrt_at_zero(void **state)
{
    (void)state;
    check_point(ad_sqrt, 0, 0, 0, 0);
    check_finite(ad_sqrt, 0);
    check_point(ad_sqrt, 1e-300, 1e-150, 5e149, 1e135); /* no epsilon beside the point */
    assert_true(isnan(expand(ad_sqrt, -1, true).c[0]));
    assert_true(isnan(expand(ad_sqrt, -1, true).slope));
}

static void test_inverse_functions_at_the_ends(void **state)
{
    (void)state;
    double half = acos(0.0); /* pi / 2 */
    check_point(ad_acos, 1, 0, 0, 0);
    check_point(ad_acos, -1, 2 * half, 0, 1e-15);
    check_point(ad_asin, 1, half, 0, 1e-15);
    check_point(ad_asin, -1, -half, 0, 1e-15);
    check_finite(ad_acos, 1);
    check_finite(ad_asin, -1);
    for (double off = 1e-12; off < 1; off *= 10) { /* few units in the last place up to the end */
        double x = 1 - off, value = expand(ad_acos, x, true).c[0];
        assert_near(value / acos(x), 1, 8 * DBL_EPSILON);
        assert_near(expand(ad_asin, -x, true).c[0], -asin(x), 8 * DBL_EPSILON);
        assert_near(expand(ad_acos, x, true).slope * sqrt((1 - x) * (1 + x)), -1, 16 * DBL_EPSILON);
    }
    assert_true(isnan(expand(ad_acos, 1.5, true).c[0]));
}

static void test_jumps(void **state)
{
    (void)state;
    check_point(ad_abs, 0, 0, 0, 0);
    check_point(ad_abs, -3, 3, -1, 0);
    check_point(ad_abs, 3, 3, 1, 0);
    check_point(ad_sign, 0, 0, 0, 0);
    check_point(ad_sign, -1e-300, -1, 0, 0);
    check_point(ad_sign, 5, 1, 0, 0);
    check_point(ad_reciprocal_or_zero, 0, 0, 0, 0);
    check_point(ad_reciprocal_or_zero, -0.5, -2, -4, 0);
    assert_true(isinf(expand(ad_reciprocal, 0, true).c[0]));
    for (int k = 0; k <= ORDER; k++)
        assert_near(expand(ad_reciprocal_or_zero, 0, true).c[k], 0, 0);
}

static ad_value third_power(ad_value x)
{
    return ad_power(x, 3);
}

static ad_value half_power(ad_value x)
{
    return ad_power(x, 0.5);
}

static void test_power(void **state)
{
    (void)state;
    check_point(third_power, 0, 0, 0, 0);
    check_point(third_power, -2, -8, 12, 1e-14); /* pow: few units in the last place */
    expansion e = expand(third_power, 0, true);  /* x^3 = tau^3 */
    for (int k = 0; k <= ORDER; k++)
        assert_near(e.c[k], k == 3 ? 1 : 0, 1e-15);
    assert_true(isinf(expand(half_power, 0, true).slope));
}

static ad_value sigmoid_like(ad_value x)
{
    return ad_add(ad_sigmoid(x), ad_add(ad_silu(ad_scale(x, 1e-300)), ad_gelu(ad_scale(x, 0))));
}

static void test_no_overflow(void **state)
{
    (void)state;
    check_point(ad_sigmoid, 800, 1, 0, 1e-15);
    check_point(ad_sigmoid, -800, 0, 0, 1e-15);
    check_point(ad_silu, -800, 0, 0, 1e-12); /* 800 units in the last place of 1/2 */
    check_point(ad_gelu, -40, 0, 0, 1e-14);
    check_point(ad_gelu, 40, 40, 1, 1e-14);
    check_point(sigmoid_like, 0, 0.5, 0.25, 1e-15);
    check_point(ad_tanh, 400, 1, 0, 0);
    check_finite(ad_tanh, -1e300);
    check_finite(ad_erf, 1e100);
}

/* ---- several variables --------------------------------------------------------------------------
 */

/* Value and gradient of f at `at`; all batch. */
static void gradient_at(ad_value (*f)(ad_value), int rows, const double *at, double *value,
                        double *gradient)
{
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", rows), y = f(x), values[2] = {y};
    ad_reverse(y, 1, &x, AD_SUMMED, values + 1);
    assert_tape_ok(tape);
    uint64_t random = 1;
    run_data data;
    data_fill(&data, tape, 1, 0, 1, &random);
    memcpy(data.input[0], at, (size_t)rows * sizeof *at);
    compiled c = run_compiled(2, values, NULL, 1, &data);
    *value = c.results[0][0];
    memcpy(gradient, c.results[1], (size_t)rows * sizeof *gradient);
    compiled_free(&c);
    data_free(&data);
    ad_tape_free(tape);
}

static ad_value angle_of(ad_value x)
{
    return ad_atan2(ad_row(x, 0), ad_row(x, 1));
}

static ad_value first_of_normalized(ad_value x)
{
    return ad_row(ad_normalize(x), 0);
}

static void test_atan2(void **state)
{
    (void)state;
    double value, gradient[2];
    gradient_at(angle_of, 2, (double[]){0, 0}, &value, gradient);
    assert_near(value, 0, 0);
    assert_near(fabs(gradient[0]) + fabs(gradient[1]), 0, 0);
    gradient_at(angle_of, 2, (double[]){0, -2}, &value, gradient);
    assert_near(value, acos(-1.0), 1e-15);
    assert_near(gradient[0], -0.5, 1e-16);
    gradient_at(angle_of, 2, (double[]){3, 4}, &value, gradient);
    assert_near(gradient[0], 4.0 / 25, 1e-16);
    assert_near(gradient[1], -3.0 / 25, 1e-16);
}

static void test_norm(void **state)
{
    (void)state;
    double value, gradient[3], zero[3] = {0, 0, 0}, x[3] = {2, -3, 6};
    gradient_at(ad_norm, 3, zero, &value, gradient);
    assert_near(fabs(value) + fabs(gradient[0]) + fabs(gradient[2]), 0, 0);
    gradient_at(ad_norm, 3, x, &value, gradient);
    assert_near(value, 7, 1e-15);
    assert_near(gradient[1], -3.0 / 7, 1e-16);
    gradient_at(first_of_normalized, 3, zero, &value, gradient);
    assert_near(fabs(value) + fabs(gradient[0]) + fabs(gradient[1]), 0, 0);
    gradient_at(first_of_normalized, 3, x, &value, gradient);
    assert_near(value, 2.0 / 7, 1e-16);
    assert_near(gradient[1], 2.0 * 3 / 343, 1e-16); /* -x_0 x_1 / |x|^3 */
}

/* A unit vector stays one; the derivative of the rotation at angle 0 is the cross product. */
static void test_rotation_at_zero_angle(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value w = ad_input(tape, "w", 3), axis = ad_input(tape, "axis", 3);
    ad_value x = ad_vector_constant(tape, 1, 2, 3), c[2];
    ad_value q = ad_quaternion_exp(w), turned = ad_rotate(q, x);
    ad_taylor(1, &turned, w, axis, 1, c);
    ad_value back = ad_rotate_inverse(q, turned), length = ad_norm(q);
    ad_value values[4] = {turned, c[1], back, length};
    assert_tape_ok(tape);
    for (int sizes = 0; sizes < 4; sizes++) {
        double size = (double[]){0, 1e-9, 0.3, 40}[sizes];
        double angle[3] = {2 * size / 7, -3 * size / 7, 6 * size / 7}, along[3] = {0.5, 0.25, -1};
        run_data data = {.points = 1, .inputs = 0, .input = {angle, along}};
        compiled r = run_compiled(4, values, NULL, 1, &data);
        for (int k = 0; k < 3; k++)
            assert_near(r.results[2][k], k + 1, 4e-15);
        assert_near(r.results[3][0], 1, 1e-15);
        if (size == 0) { /* axis x (1, 2, 3) */
            assert_near(r.results[1][0], 0.25 * 3 + 2, 1e-15);
            assert_near(r.results[1][1], -1 - 0.5 * 3, 1e-15);
            assert_near(r.results[1][2], 0.5 * 2 - 0.25, 1e-15);
        }
        compiled_free(&r);
    }
    ad_tape_free(tape);
}

/* ---- Stumpff functions --------------------------------------------------------------------------
 */

/* The series itself in extended precision; loses exp(sqrt(a)) * 1e-19 for a > 0. */
static double stumpff_series(int k, double a)
{
    long double term = 1, sum;
    for (int i = 2; i <= k; i++)
        term /= i;
    sum = term;
    for (int i = 1; i < 400; i++) {
        term *= -(long double)a / ((long double)(k + 2 * i - 1) * (k + 2 * i));
        sum += term;
    }
    return (double)sum;
}

/* |c_k(a)| <= 1/k! for a >= 0: errors relative to that; for a < 0 relative to c_k. Trigonometric
 * functions of sqrt(a) lose half a unit of sqrt(a). */
static double stumpff_tolerance(int k, double a, double value)
{
    double size = 1;
    for (int i = 2; i <= k; i++)
        size /= i;
    return 8 * DBL_EPSILON * fmax(fabs(value), size) * (1 + 0.5 * sqrt(fabs(a)));
}

static void check_stumpff(int k, double a)
{
    double value = ad_op_evaluate(OP_STUMPFF, k, 0, &a), expected = stumpff_series(k, a);
    if (!(fabs(value - expected) <= stumpff_tolerance(k, a, expected)))
        fail_msg("stumpff %d at %.17g: %.17g, not %.17g", k, a, value, expected);
}

static void test_stumpff(void **state)
{
    (void)state;
    uint64_t random = 2;
    for (int k = 0; k <= AD_STUMPFF_MAX; k++) {
        check_stumpff(k, 0);
        for (double size = 1e-12; size < 60; size *= 1.3) {
            check_stumpff(k, size);
            check_stumpff(k, -size);
        }
        for (int i = 0; i < 200; i++)
            check_stumpff(k, random_in(&random, -400, 60));
        for (int other = 0; other <= AD_STUMPFF_MAX && other * other <= 60; other++) {
            double point = other < 2 ? 1 : other * (other - 1); /* where the formula changes */
            for (int side = -1; side <= 1; side++) {
                check_stumpff(k, point * (1 + side * DBL_EPSILON));
                check_stumpff(k, -point * (1 + side * DBL_EPSILON));
            }
        }
    }
}

static ad_value stumpff_three(ad_value a)
{
    return ad_stumpff(3, a);
}

/* At 0 the Taylor coefficients are those of the series. */
static void test_stumpff_coefficients(void **state)
{
    (void)state;
    for (int batch = 0; batch < 2; batch++) {
        expansion e = expand(stumpff_three, 0, batch);
        double expected = 1.0 / 6;
        for (int k = 0; k <= ORDER; k++) {
            assert_near(e.c[k] / expected, 1, 8 * DBL_EPSILON);
            expected /= -(2.0 * k + 4) * (2 * k + 5);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sqrt_at_zero), cmocka_unit_test(test_inverse_functions_at_the_ends),
        cmocka_unit_test(test_jumps),        cmocka_unit_test(test_power),
        cmocka_unit_test(test_no_overflow),  cmocka_unit_test(test_atan2),
        cmocka_unit_test(test_norm),         cmocka_unit_test(test_rotation_at_zero_angle),
        cmocka_unit_test(test_stumpff),      cmocka_unit_test(test_stumpff_coefficients),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
