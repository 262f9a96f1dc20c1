/* Enclosures of formulas: nothing that a formula gives lies outside, and what is narrow is seen. */
#include "fewer.h"
#include "quantity_testing.h"

#include "near.h"
#include "random_numbers.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FORMULAS = 3000, BOXES = 12, SAMPLES = 12, TEXT = 4096 };

/* ---- random formulas ------------------------------------------------------------------------- */

static void write_formula(uint64_t *state, int depth, FILE *to);

static void write_call(uint64_t *state, int depth, const char *name, int arity, FILE *to)
{
    fprintf(to, "%s(", name);
    for (int i = 0; i < arity; i++) {
        fputs(i ? ", " : "", to);
        write_formula(state, depth - 1, to);
    }
    fputs(")", to);
}

static void write_formula(uint64_t *state, int depth, FILE *to)
{
    static const char *const one[] = {"sin",  "cos",  "tan", "asin", "acos", "atan", "sinh",
                                      "cosh", "tanh", "exp", "log",  "sqrt", "abs",  "step"};
    static const char *const two[] = {"atan2", "min", "max"};
    static const char *const powers[] = {"2", "3", "-1", "-2", "0.5", "1.5", "-0.5", "0", "1"};
    static const char operators[] = "+-*/";
    int kind = depth == 0 ? random_below(state, 3) : 3 + random_below(state, 10);
    if (kind < 2) {
        fputs(kind == 0 ? "s" : "t", to);
    } else if (kind == 2) {
        fprintf(to, "%.3g", random_in(state, 0, 3));
    } else if (kind < 8) {
        fputs("(", to);
        write_formula(state, depth - 1, to);
        fprintf(to, "%c", operators[random_below(state, 4)]);
        write_formula(state, depth - 1, to);
        fputs(")", to);
    } else if (kind < 10) {
        write_call(state, depth, one[random_below(state, sizeof one / sizeof *one)], 1, to);
    } else if (kind == 10) {
        write_call(state, depth, two[random_below(state, 3)], 2, to);
    } else if (kind == 11) {
        write_call(state, depth, "where", 3, to);
    } else {
        fputs("(", to);
        write_formula(state, depth - 1, to);
        fprintf(to, ")^%s", powers[random_below(state, sizeof powers / sizeof *powers)]);
    }
}

static quantity random_formula(uint64_t *state, char *text)
{
    FILE *to = fmemopen(text, TEXT, "w");
    assert_non_null(to);
    write_formula(state, 1 + random_below(state, 4), to);
    fclose(to);
    return Q(text);
}

/* From wide to a point, some with an end at 0 or at 1. */
static quantity_interval random_interval(uint64_t *state)
{
    static const double sizes[] = {4, 1, 0.1, 1e-3, 1e-7, 0};
    double size = sizes[random_below(state, 6)], low = random_in(state, -2, 2);
    int kind = random_below(state, 4);
    low = kind == 0 ? 0 : kind == 1 ? 1 - size : low;
    return (quantity_interval){low, low + size};
}

/* An end as often as not: there an enclosure is met exactly. */
static double random_place(uint64_t *state, quantity_interval x)
{
    int kind = random_below(state, 4);
    double inside = random_in(state, x.low, x.high);
    return kind == 0 ? x.low : kind == 1 ? x.high : fmin(fmax(inside, x.low), x.high);
}

/* ---- tests ----------------------------------------------------------------------------------- */

static bool is_line(quantity_interval x)
{
    return x.low == -INFINITY && x.high == INFINITY;
}

static bool holds(quantity_interval x, double value)
{
    return is_line(x) || (x.low <= value && value <= x.high);
}

/* The quotient of differences of two values, each off by rounding at most. */
static bool holds_slope(const quantity_enclosure *of, double p, double q, double at_p, double at_q)
{
    double step = q - p, rise = at_q - at_p, allowed = 2 * of->rounding + DBL_EPSILON * fabs(rise);
    double a = of->slope.low * step, b = of->slope.high * step;
    return is_line(of->slope) || !isfinite(rise) || step == 0 || !isfinite(a) || !isfinite(b) ||
           (rise >= fmin(a, b) - allowed && rise <= fmax(a, b) + allowed);
}

static void look_into(uint64_t *state, quantity q, const char *text)
{
    quantity_interval s = random_interval(state), t = random_interval(state);
    quantity_interval range = quantity_range(q, s, t);
    quantity_enclosure by_s = quantity_enclose(q, "s", s, t), by_t = quantity_enclose(q, "t", s, t);
    for (int i = 0; i < SAMPLES; i++) {
        double at_s = random_place(state, s), at_t = random_place(state, t);
        double other_s = random_place(state, s), other_t = random_place(state, t);
        double value = quantity_value(q, at_s, at_t);
        bool within = holds(range, value) && holds(by_s.value, value) && holds(by_t.value, value);
        bool sloped = holds_slope(&by_s, at_s, other_s, value, quantity_value(q, other_s, at_t)) &&
                      holds_slope(&by_t, at_t, other_t, value, quantity_value(q, at_s, other_t));
        if (!within || !sloped) {
            fail_msg("%s: %.17g at s = %.17g, t = %.17g leaves [%.17g, %.17g], or its slope by s "
                     "[%g, %g], by t [%g, %g]",
                     text, value, at_s, at_t, range.low, range.high, by_s.slope.low,
                     by_s.slope.high, by_t.slope.low, by_t.slope.high);
        }
    }
}

static void test_enclosed(void **unused)
{
    uint64_t state = 7;
    int told = 0;
    char text[TEXT];
    (void)unused;
    for (int i = 0; i < FORMULAS; i++) {
        quantity q = random_formula(&state, text);
        if (quantity_check(q, NULL) != AD_OK) {
            continue; /* a constant that is not finite */
        }
        for (int k = 0; k < BOXES; k++) {
            look_into(&state, q, text);
            told += !is_line(
                quantity_range(q, (quantity_interval){0.4, 0.5}, (quantity_interval){0.4, 0.5}));
        }
    }
    /* enclosures that say nothing would pass; most formulas are defined on most of the plane */
    assert_true(told > FORMULAS * BOXES / 2);
}

static void assert_range(const char *text, double low, double high, double tolerance)
{
    const quantity_interval s = {0, 2}, t = {0, 0};
    quantity_interval range = quantity_range(Q(text), s, t);
    assert_true(range.low <= low && range.high >= high);
    assert_near(range.low, low, tolerance);
    assert_near(range.high, high, tolerance);
}

/* Where nothing appears twice an enclosure is exact but for rounding. */
static void test_exact(void **unused)
{
    (void)unused;
    assert_range("sin(s)", 0, 1, 1e-13);
    assert_range("3 - 2*s^2", -5, 3, 1e-13);
    assert_range("abs(s - 1)", 0, 1, 1e-13);
    assert_range("exp(-((s-0.3)/1e-6)^2)", 0, 1, 1e-13);
    assert_range("where((s-0.3)*(0.3000001-s), 5, 0)", 0, 5, 1e-13);
    assert_range("tanh(1e6*(s-0.7))", -1, 1, 1e-13);
    assert_range("step(s+1) + max(s, 1)", 2, 3, 1e-13);
    assert_range("cosh(s-1)", 1, cosh(1), 1e-13);
}

/* The mean value form: the excess falls with the square of the width. */
static void test_order(void **unused)
{
    double excess[2];
    quantity q = Q("s*(1-s)*exp(s) - s*exp(s)");
    (void)unused;
    for (int i = 0; i < 2; i++) {
        double width = i == 0 ? 1e-2 : 1e-3;
        quantity_interval s = {0.6, 0.6 + width}, t = {0, 0}, range = quantity_range(q, s, t);
        double ends = fabs(quantity_value(q, s.low, 0) - quantity_value(q, s.high, 0));
        excess[i] = range.high - range.low - ends; /* it falls all along */
    }
    assert_true(excess[0] > 0 && excess[1] < excess[0] / 50);
}

static void test_undefined(void **unused)
{
    static const char *const texts[] = {"sqrt(s-1)", "1/(s-1)", "log(s-1)", "asin(s)", "tan(s)"};
    const quantity_interval s = {0, 2}, t = {0, 0};
    (void)unused;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        assert_true(is_line(quantity_range(Q(texts[i]), s, t)));
    }
    assert_true(is_line(quantity_range(Q("s +"), s, t)));
    assert_true(is_line(quantity_range((quantity){.is_given = false}, s, t)));
    /* a branch that is not taken may be undefined */
    assert_range("where(s+1, s, sqrt(s-3))", 0, 2, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact),
        cmocka_unit_test(test_order),
        cmocka_unit_test(test_undefined),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_enclosed)};
    return run_with_alike(tests, alike, NULL, NULL);
}
