/* Formulas: their numbers, derivatives, and what they say about mistakes. */
#include "evaluate.h"

#include "physics/expression.h"

#include <stdio.h>

#define PI 3.14159265358979323846

typedef double formula(double s, double t);

#define FORMULA(name, c)                                                                           \
    static double name(double s, double t)                                                         \
    {                                                                                              \
        (void)s, (void)t;                                                                          \
        return c;                                                                                  \
    }

FORMULA(f_number, 0.02)
FORMULA(f_decimal, 2.5e-3 * 10 + 0.5 + 2e2)
FORMULA(f_load, 0.02 * sin(2 * PI * t))
FORMULA(f_minus, -s *s)
FORMULA(f_right, 512 * s)
FORMULA(f_left, s - t - 1 - s / t / 2)
FORMULA(f_group, (s - (t - 1)) * -(s + 2))
FORMULA(f_negative, pow(t, -3) + 0.25 * s)
FORMULA(f_half, sqrt(s) + pow(t, 1.5))
FORMULA(f_high, pow(t, 9) + pow(s, 8))
FORMULA(f_circular, sin(s) + cos(t) * tan(s / 2))
FORMULA(f_inverse, asin(s / 3) + acos(t / 4) + atan(s * t) + atan2(s, -t))
FORMULA(f_hyperbolic, sinh(s) - cosh(t) + tanh(s * t) + sinh(1e-9 * s) * 1e9)
FORMULA(f_exponential, exp(-s) * log(t + 1) + sqrt(s * t) + fabs(s - 2))
FORMULA(f_choice, fmin(s, 2 * t) + fmax(s, t *t))
FORMULA(f_step, s > 0.7 ? 1 : 0)
FORMULA(f_where, t < 0.5 ? 4 * sin(PI * t) * sin(PI * t) : 4)
FORMULA(f_folded, 8 * exp(1.0) + s * 0)

static const struct {
    const char *text;
    formula *number;
} formulas[] = {
    {"0.02", f_number},
    {"2.5e-3*1E+1 + .5 + 2.e2", f_decimal},
    {"0.02*sin(2*pi*t)", f_load},
    {"-s^2", f_minus},
    {"2^3^2*s", f_right},
    {" s - t - 1 - s / t / 2 ", f_left},
    {"(s-(t-1))*-(s+2)", f_group},
    {"t^-3 + 2^-2*s", f_negative},
    {"s^0.5 + t^(3/2)", f_half},
    {"t^9 + s^8", f_high},
    {"sin(s)+cos(t)*tan(s/2)", f_circular},
    {"asin(s/3)+acos(t/4)+atan(s*t)+atan2(s,-t)", f_inverse},
    {"sinh(s) - cosh(t) + tanh(s*t) + sinh(1e-9*s)*1e9", f_hyperbolic},
    {"exp(-s)*log(t+1)+sqrt(s*t)+abs(s-2)", f_exponential},
    {"min(s, 2*t) + max(s, t^2)", f_choice},
    {"step(s-0.7)", f_step},
    {"where(0.5-t, 4*sin(pi*t)^2, 4)", f_where},
    {"+2^3*exp(1) + s*0", f_folded},
};
enum { FORMULAS = sizeof formulas / sizeof formulas[0], POINTS = 5 };

static const double point_s[POINTS] = {0.1, 0.45, 0.9, 1.3, 2.6};
static const double point_t[POINTS] = {0.25, 0.77, 1.1, 0.4, 2.2};

/* Sixth-order central difference. */
static double slope(formula *f, double s, double t, bool along_s)
{
    static const double weights[3] = {0.75, -0.15, 1.0 / 60};
    double h = 4e-3, sum = 0;
    for (int i = 1; i <= 3; i++) {
        double ds = along_s ? i * h : 0, dt = along_s ? 0 : i * h;
        sum += weights[i - 1] * (f(s + ds, t + dt) - f(s - ds, t - dt));
    }
    return sum / h;
}

static void test_values(void **state)
{
    (void)state;
    for (int i = 0; i < FORMULAS; i++) {
        ad_error error = {.message = ""};
        if (expression_check(formulas[i].text, NULL, &error) != AD_OK)
            fail_msg("%s", error.message);
        ad_tape *tape = ad_tape_create();
        ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
        double *numbers =
            evaluate_at(expression_record(formulas[i].text, s, t), POINTS, point_s, point_t, NULL);
        for (int k = 0; k < POINTS; k++) {
            double expected = formulas[i].number(point_s[k], point_t[k]);
            /* a few roundings, the formula's order of operations may differ */
            double tolerance = 2e-14 * fmax(1, fabs(expected));
            assert_near(numbers[k], expected, tolerance);
            assert_near(expression_evaluate(formulas[i].text, point_s[k], point_t[k]), expected,
                        tolerance);
        }
        free(numbers);
        ad_tape_free(tape);
    }
}

static void test_derivatives(void **state)
{
    (void)state;
    for (int i = 0; i < FORMULAS; i++) {
        ad_tape *tape = ad_tape_create();
        ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
        ad_value f = expression_record(formulas[i].text, s, t);
        double *along_s = evaluate_at(ad_derivative(f, s, 1), POINTS, point_s, point_t, NULL);
        double *along_t = evaluate_at(ad_derivative(f, t, 1), POINTS, point_s, point_t, NULL);
        for (int k = 0; k < POINTS; k++) {
            double by_s = slope(formulas[i].number, point_s[k], point_t[k], true);
            double by_t = slope(formulas[i].number, point_s[k], point_t[k], false);
            /* the difference formula's own error: h^6 times a seventh derivative */
            assert_near(along_s[k], by_s, 1e-6 * fmax(1, fabs(by_s)));
            assert_near(along_t[k], by_t, 1e-6 * fmax(1, fabs(by_t)));
        }
        free(along_s);
        free(along_t);
        ad_tape_free(tape);
    }
}

/* Small integer powers are products: right at 0 and left of it, with their derivatives. */
static void test_power_of_negative(void **state)
{
    (void)state;
    const double s[3] = {-2, 0, 1.5}, t[3] = {0, 0, 0};
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "s", 1), y = ad_input(tape, "t", 1);
    ad_value cube = expression_record("s^3", x, y);
    double *value = evaluate_at(cube, 3, s, t, NULL);
    double *second = evaluate_at(ad_derivative(cube, x, 2), 3, s, t, NULL);
    for (int k = 0; k < 3; k++) {
        assert_near(value[k], s[k] * s[k] * s[k], 1e-15);
        assert_near(second[k], 6 * s[k], 1e-14);
    }
    free(value);
    free(second);
    ad_tape_free(tape);
}

static const struct {
    const char *text;
    int column;
    const char *says;
} mistakes[] = {
    {"", 1, "the formula ends"},
    {"2*", 3, "the formula ends"},
    {"sin(2*t", 8, "sin takes 1 argument in parentheses"},
    {"sin", 1, "sin takes 1 argument in parentheses"},
    {"sin 2", 1, "sin takes 1 argument"},
    {"atan2(s)", 8, "atan2 takes 2 arguments"},
    {"min(s,t,1)", 8, "min takes 2 arguments"},
    {"2*x + 1", 3, "unknown name 'x'; allowed are s, t, pi, sin, cos"},
    {"2 t", 3, "expected an operator"},
    {"(s+1", 5, "expected )"},
    {"s+1)", 4, "expected an operator"},
    {"s^t", 3, "the exponent of ^ must be constant"},
    {"3 + * 2", 5, "expected a number, a name or ("},
    {"0x10", 2, "expected an operator"},
    {"1e", 2, "expected an operator"},
    {".", 1, "not a number"},
    {"nan", 1, "unknown name 'nan'"},
    {"1/0", 1, "not a finite number"},
    {"sqrt(-1)", 1, "not a finite number"},
    {"s & t", 3, "expected an operator"},
};

static void test_mistakes(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; i++) {
        ad_error error = {.message = ""};
        char column[32];
        snprintf(column, sizeof column, "column %d ", mistakes[i].column);
        assert_int_equal(expression_check(mistakes[i].text, NULL, &error), AD_BAD_INPUT);
        if (strncmp(error.message, column, strlen(column)) != 0 ||
            !strstr(error.message, mistakes[i].says) || strchr(error.message, '\n'))
            fail_msg("'%s': %s", mistakes[i].text, error.message);
        ad_tape *tape = ad_tape_create();
        ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
        ad_value value = expression_record(mistakes[i].text, s, t);
        ad_add(value, s); /* may be passed on */
        assert_int_equal(ad_tape_status(tape, NULL), AD_BAD_INPUT);
        ad_tape_free(tape);
    }
}

static void test_depth(void **state)
{
    (void)state;
    char text[4096];
    for (int depth = 20; depth <= 2000; depth += 1980) {
        memset(text, '(', (size_t)depth);
        text[depth] = 's';
        memset(text + depth + 1, ')', (size_t)depth);
        text[2 * depth + 1] = '\0';
        assert_int_equal(expression_check(text, NULL, NULL), depth == 20 ? AD_OK : AD_BAD_INPUT);
    }
    memset(text, '-', 4000);
    strcpy(text + 4000, "s");
    assert_int_equal(expression_check(text, NULL, NULL), AD_BAD_INPUT);
}

static void test_not_finite(void **state)
{
    (void)state;
    assert_true(isnan(expression_evaluate("1/(s-1)", 1, 0)));
    assert_true(isnan(expression_evaluate("log(t)", 1, 0)));
    assert_true(isnan(expression_evaluate("2 +", 1, 0)));
}

static void test_use(void **state)
{
    (void)state;
    expression_use use;
    assert_int_equal(expression_check("sin(t)*2", &use, NULL), AD_OK);
    assert_true(use.t && !use.s);
    assert_int_equal(expression_check("s + pi", &use, NULL), AD_OK);
    assert_true(use.s && !use.t);
    assert_int_equal(expression_check("step(1)", &use, NULL), AD_OK);
    assert_true(!use.s && !use.t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),     cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_mistakes),   cmocka_unit_test(test_power_of_negative),
        cmocka_unit_test(test_depth),      cmocka_unit_test(test_use),
        cmocka_unit_test(test_not_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
