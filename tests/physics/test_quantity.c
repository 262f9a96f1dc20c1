/* Quantities: their numbers, derivatives, texts, what they say about mistakes, and names. */
#include "evaluate.h"

#include "allocations.h"
#include "quantity_testing.h"

#include <locale.h>
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
        quantity q = Q(formulas[i].text);
        if (quantity_check(q, &error) != AD_OK)
            fail_msg("%s", error.message);
        ad_tape *tape = ad_tape_create();
        ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
        double *numbers = evaluate_at(quantity_record_at(q, s, t), POINTS, point_s, point_t, NULL);
        for (int k = 0; k < POINTS; k++) {
            double expected = formulas[i].number(point_s[k], point_t[k]);
            /* a few roundings, the formula's order of operations may differ */
            double tolerance = 2e-14 * fmax(1, fabs(expected));
            assert_near(numbers[k], expected, tolerance);
            assert_near(quantity_value(q, point_s[k], point_t[k]), expected, tolerance);
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
        ad_value f = quantity_record_at(Q(formulas[i].text), s, t);
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
    ad_value cube = quantity_record_at(Q("s^3"), x, y);
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
        quantity wrong = Q(mistakes[i].text);
        assert_int_equal(quantity_check(wrong, &error), AD_BAD_INPUT);
        assert_int_equal(quantity_check(quantity_add(Q("s"), wrong), NULL), AD_BAD_INPUT);
        assert_true(isnan(quantity_value(wrong, 1, 1)));
        if (strncmp(error.message, column, strlen(column)) != 0 ||
            !strstr(error.message, mistakes[i].says) || strchr(error.message, '\n'))
            fail_msg("'%s': %s", mistakes[i].text, error.message);
        ad_tape *tape = ad_tape_create();
        ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
        ad_value value = quantity_record_at(wrong, s, t);
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
        assert_int_equal(quantity_check(Q(text), NULL), depth == 20 ? AD_OK : AD_BAD_INPUT);
    }
    memset(text, '-', 4000);
    strcpy(text + 4000, "s");
    assert_int_equal(quantity_check(Q(text), NULL), AD_BAD_INPUT);
    for (int terms = 1000; terms <= 3000;
         terms += 2000) { /* operations are counted, not characters */
        char sum[8192] = "s";
        for (int i = 0; i < terms; i++)
            strcpy(sum + 1 + 2 * i, "+s");
        assert_int_equal(quantity_check(Q(sum), NULL), terms == 1000 ? AD_OK : AD_BAD_INPUT);
    }
}

static void test_not_finite(void **state)
{
    (void)state;
    assert_true(isinf(quantity_value(Q("1/(s-1)"), 1, 0)));
    assert_true(isnan(quantity_value(Q("log(-t)"), 1, 1)));
    assert_true(isnan(quantity_value(Q("2 +"), 1, 0)));
    assert_true(isnan(quantity_value(Q(NULL), 1, 0)));
}

static void test_use(void **state)
{
    (void)state;
    double value = 0;
    assert_true(quantity_depends_on(Q("sin(t)*2"), "t"));
    assert_false(quantity_depends_on(Q("sin(t)*2"), "s"));
    assert_true(quantity_depends_on(Q("s + pi"), "s"));
    assert_false(quantity_depends_on(Q("s + pi"), "t"));
    assert_true(quantity_is_number(Q("step(1)"), &value) && value == 1);
    assert_false(quantity_is_number(Q("0*s"), &value)); /* formulas are not looked into */
    assert_false(quantity_is_number(Q(NULL), &value));
    assert_true(quantity_is(Q("2-2"), 0) && !quantity_is_something(Q("2-2")));
}

/* ---- nodes ----------------------------------------------------------------------------------- */

/* What is computed from quantities is what is computed from their numbers, in the same order: to
 * the last bit. */
static void test_algebra(void **state)
{
    (void)state;
    const quantity a = Q("1 + 0.3*s"), b = Q("cos(t) + 2"), c = quantity_number(0.7);
    quantity made =
        quantity_divide(quantity_multiply(quantity_subtract(a, c), quantity_power(b, 3)),
                        quantity_add(quantity_scale(a, 2.5), b));
    quantity arguments[2] = {made, c};
    quantity lesser = quantity_call("min", arguments);
    for (int k = 0; k < POINTS; k++) {
        double s = point_s[k], t = point_t[k], x = 1 + 0.3 * s, y = cos(t) + 2;
        double expected = (x - 0.7) * pow(y, 3) / (x * 2.5 + y);
        assert_true(quantity_value(made, s, t) == expected);
        assert_true(quantity_value(lesser, s, t) == (expected < 0.7 ? expected : 0.7));
    }
    assert_true(made.node ==
                quantity_divide(quantity_multiply(quantity_subtract(a, c), quantity_power(b, 3)),
                                quantity_add(quantity_scale(a, 2.5), b))
                    .node); /* made twice, kept once */
    quantity folded = quantity_multiply(c, quantity_call("exp", &c));
    assert_null(folded.node);
    assert_true(folded.number == 0.7 * exp(0.7));
    assert_false(quantity_multiply(a, Q(NULL)).is_given);
    assert_false(quantity_call("nothing", &c).is_given);
}

/* Derivatives of what is made of nodes, by the tape and by differences. */
static void test_algebra_derivative(void **state)
{
    (void)state;
    quantity made = quantity_divide(quantity_power(Q("1 - 0.2*s"), 4), Q("2 + sin(s*t)"));
    ad_tape *tape = ad_tape_create();
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
    ad_value f = quantity_record_at(made, s, t);
    double *slopes = evaluate_at(ad_derivative(f, s, 1), POINTS, point_s, point_t, NULL);
    for (int k = 0; k < POINTS; k++) {
        double h = 1e-5, x = point_s[k], y = point_t[k];
        double expected =
            (quantity_value(made, x + h, y) - quantity_value(made, x - h, y)) / (2 * h);
        assert_near(slopes[k], expected, 1e-9); /* h^2 times a third derivative, and rounding/h */
    }
    free(slopes);
    ad_tape_free(tape);
}

/* As its author wrote it, and from its nodes: both are read back as what they are. */
static void test_text(void **state)
{
    (void)state;
    for (int i = 0; i < FORMULAS; i++) {
        quantity q = Q(formulas[i].text);
        char *written = quantity_text(q, true), *made = quantity_text(q, false);
        assert_string_equal(written, formulas[i].text);
        quantity again = Q(made);
        for (int k = 0; k < POINTS; k++) {
            double number = quantity_value(q, point_s[k], point_t[k]);
            assert_true(quantity_value(again, point_s[k], point_t[k]) == number);
        }
        char *twice = quantity_text(again, false);
        assert_string_equal(made, twice);
        free(written);
        free(made);
        free(twice);
    }
    char *same[2] = {quantity_text(Q("2*s + 1/3"), false), quantity_text(Q(" 2 * s+(1/3)"), false)};
    assert_string_equal(same[0], same[1]);
    free(same[0]);
    free(same[1]);
}

/* ---- names ----------------------------------------------------------------------------------- */

static void test_names(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    ad_error error = {.message = ""};
    assert_int_equal(quantities_define(names, "load", quantity_number(0.3), &error), AD_OK);
    assert_int_equal(quantities_define(names, "ramp", quantity_formula(names, "load*t"), &error),
                     AD_OK);
    assert_int_equal(quantities_define(names, "x2_", quantity_formula(names, "load^2"), NULL),
                     AD_OK);
    assert_true(quantity_value(quantity_formula(names, "-ramp*s"), 2, 5) == -(0.3 * 5) * 2);
    assert_true(quantity_is(quantity_formula(names, "x2_ + load"), 0.3 * 0.3 + 0.3));
    char *text = quantity_text(quantity_formula(names, "-ramp*s"), true);
    assert_string_equal(text, "-ramp*s");
    free(text);
    text = quantity_text(quantity_formula(names, "-ramp*s"), false);
    assert_string_equal(text, "(-1)*(0.3*t)*s");
    free(text);
    static const struct {
        const char *name, *says;
    } wrong[] = {{"s", "already"},     {"t", "already"},      {"pi", "already"},
                 {"sin", "already"},   {"load", "already"},   {"2x", "is no name"},
                 {"", "is no name"},   {"a b", "is no name"}, {"l\xc3\xa4nge", "is no name"},
                 {"a-b", "is no name"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(quantities_define(names, wrong[i].name, quantity_number(1), &error),
                         AD_BAD_INPUT);
        if (!strstr(error.message, wrong[i].says))
            fail_msg("%s: %s", wrong[i].name, error.message);
    }
    assert_int_equal(quantities_define(names, "bad", quantity_formula(names, "1 +"), &error),
                     AD_BAD_INPUT);
    assert_int_equal(quantity_check(quantity_formula(names, "laod*s"), &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message,
                           "unknown name 'laod'; did you mean load? allowed are s, t, load, ramp"));
    quantities_free(names);
}

/* A table goes through its rows, neither rises above nor falls below its neighbours between them,
 * has a continuous slope, and is not a number beyond. On the tape it has the same values, and the
 * slope of differences. */
static void test_tables(void **state)
{
    (void)state;
    static const double x[] = {-1, 0, 0.5, 2, 2.25, 4}, y[] = {3, 3, -1, 0.5, 0.75, 9};
    enum { ROWS = 6 };
    ad_error error;
    quantities *names = quantities_create();
    assert_int_equal(quantities_define_table(names, "wind", ROWS, x, y, &error), AD_OK);
    quantity wind = quantity_formula(names, "wind(s)");
    assert_int_equal(quantity_check(wind, &error), AD_OK);
    for (int i = 0; i < ROWS; i++) {
        assert_near(quantity_value(wind, x[i], 0), y[i], 1e-15);
    }
    for (int i = 0; i + 1 < ROWS; i++) {
        for (int k = 1; k < 20; k++) {
            double value = quantity_value(wind, x[i] + (x[i + 1] - x[i]) * k / 20, 0);
            assert_true(value >= fmin(y[i], y[i + 1]) - 1e-14);
            assert_true(value <= fmax(y[i], y[i + 1]) + 1e-14);
        }
    }
    for (int i = 1; i + 1 < ROWS;
         i++) { /* an error of slope would show as 1, the rest is h y''/2 */
        const double h = 1e-6;
        double before = (y[i] - quantity_value(wind, x[i] - h, 0)) / h;
        double after = (quantity_value(wind, x[i] + h, 0) - y[i]) / h;
        assert_near(before, after, 1e-3);
    }
    assert_true(isnan(quantity_value(wind, -1.001, 0)) && isnan(quantity_value(wind, 4.001, 0)));
    quantity shifted = quantity_formula(names, "2*wind(4*t - s) + 1");
    assert_near(quantity_value(shifted, 1.25, 0.4375), 2 * -1 + 1, 1e-15);
    quantities_free(names);
}

static void test_table_refusals(void **state)
{
    (void)state;
    static const double rising[] = {0, 1, 2}, falling[] = {0, 2, 1}, y[] = {1, 2, 3};
    static const double bad[] = {0, NAN, 1};
    ad_error error;
    quantities *names = quantities_create();
    assert_int_equal(quantities_define_table(names, "sin", 3, rising, y, &error), AD_BAD_INPUT);
    assert_int_equal(quantities_define_table(names, "f", 1, rising, y, &error), AD_BAD_INPUT);
    assert_int_equal(quantities_define_table(names, "f", 3, falling, y, &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "row 3"));
    assert_int_equal(quantities_define_table(names, "f", 3, rising, bad, &error), AD_BAD_INPUT);
    assert_int_equal(quantities_define_table(names, "f", 3, rising, y, &error), AD_OK);
    assert_int_equal(quantities_define(names, "f", quantity_number(1), &error), AD_BAD_INPUT);
    assert_int_equal(quantity_check(quantity_formula(names, "f + 1"), &error), AD_BAD_INPUT);
    assert_non_null(strstr(error.message, "a table takes 1 argument"));
    assert_int_equal(quantity_check(quantity_formula(names, "f(1, 2)"), &error), AD_BAD_INPUT);
    assert_true(quantity_is(quantity_formula(names, "f(1)"), 2));
    quantities_free(names);
}

/* A formula is parsed when its names are known. */
static void test_unparsed(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    quantity later = quantity_unparsed(names, "2*load"), number = quantity_number(3);
    assert_int_equal(quantity_check(later, NULL), AD_BAD_ARGUMENT);
    assert_int_equal(quantities_define(names, "load", quantity_number(0.3), NULL), AD_OK);
    assert_true(quantity_is(quantity_parsed(later), 0.6));
    assert_true(quantity_is(quantity_parsed(number), 3));
    quantities_free(names);
}

/* Another coordinate than s and t, bound to an input, a uniform, a parameter or a number. */
static void test_bindings(void **state)
{
    (void)state;
    quantities *names = quantities_create();
    assert_int_equal(quantities_coordinate(names, "tension", NULL), AD_OK);
    assert_int_equal(quantities_coordinate(names, "s", NULL), AD_BAD_INPUT);
    quantity q = quantity_formula(names, "tension^2*s");
    assert_true(quantity_depends_on(q, "tension") && !quantity_depends_on(q, "t"));
    assert_true(isnan(quantity_value(q, 2, 0))); /* it has no value here */
    ad_tape *tape = ad_tape_create();
    ad_value s = ad_input(tape, "s", 1), pull = ad_parameter(tape, "tension", 1, 0);
    ad_value bound = quantity_record(q, tape, 2, (quantity_binding[]){{"s", s}, {"tension", pull}});
    ad_value fixed = quantity_record(
        q, tape, 2,
        (quantity_binding[]){{"s", ad_scalar(tape, 2)}, {"tension", ad_scalar(tape, 3)}});
    assert_true(ad_is_constant(fixed, 18));
    double parameter = 3,
           *by_s = evaluate_at(ad_derivative(bound, s, 1), 1, point_s, point_t, &parameter);
    assert_near(*by_s, 9, 1e-15);
    free(by_s);
    quantity_record(q, tape, 1, (quantity_binding[]){{"s", s}});
    ad_error error = {.message = ""};
    assert_int_equal(ad_tape_status(tape, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "tension"));
    ad_tape_free(tape);
    quantities_free(names);
}

/* Memory that runs out anywhere is an error of the quantity, and of what is made of it. */
static void test_memory(void **state)
{
    (void)state;
    bool failed = true;
    for (long n = 1; failed; n++) {
        ad_status status = AD_NO_MEMORY;
        allocations = 0;
        failing_allocation = n;
        quantities *names = quantities_create();
        if (names) {
            quantity later = quantity_unparsed(names, "2*load*s + sin(t)");
            status = quantities_define(names, "load", quantity_formula(names, "exp(s)"), NULL);
            quantity made = quantity_multiply(quantity_parsed(later), quantity_formula(names, "t"));
            status = status == AD_OK ? quantity_check(made, NULL) : status;
            if (status == AD_OK) {
                assert_near(quantity_value(made, 0, 2), 2 * sin(2), 1e-15);
            }
        }
        failed = failing_allocation <= allocations;
        failing_allocation = 0;
        assert_true(status == (failed ? AD_NO_MEMORY : AD_OK));
        quantities_free(names);
    }
}

/* ---- locale ---------------------------------------------------------------------------------- */

/* Numbers have a point whatever the locale of the program, of which some have a comma. */
static void test_locale(void **state)
{
    (void)state;
    static const char *const commas[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"};
    char text[32];
    locale_t comma = (locale_t)0;
    for (size_t i = 0; i < sizeof commas / sizeof *commas && !comma; i++) {
        comma = newlocale(LC_ALL_MASK, commas[i], (locale_t)0);
    }
    if (!comma) {
        print_message("no locale with a comma is installed\n");
        skip();
    }
    locale_t before = uselocale(comma);
    snprintf(text, sizeof text, "%.1f", 0.5);
    bool has_comma = strcmp(text, "0,5") == 0;
    quantity q = Q("0.25*s + 1.5e-3");
    double value = quantity_value(q, 1, 0);
    char *made = quantity_text(q, false);
    quantity_number_text(1.5, text);
    bool is_comma_after = localeconv()->decimal_point[0] == ',';
    uselocale(before);
    freelocale(comma);
    assert_true(has_comma && is_comma_after);
    assert_true(value == 0.25 + 1.5e-3);
    assert_string_equal(made, "0.25*s+0.0015");
    assert_string_equal(text, "1.5");
    free(made);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),         cmocka_unit_test(test_derivatives),
        cmocka_unit_test(test_mistakes),       cmocka_unit_test(test_tables),
        cmocka_unit_test(test_table_refusals), cmocka_unit_test(test_power_of_negative),
        cmocka_unit_test(test_depth),          cmocka_unit_test(test_use),
        cmocka_unit_test(test_not_finite),     cmocka_unit_test(test_algebra),
        cmocka_unit_test(test_text),           cmocka_unit_test(test_algebra_derivative),
        cmocka_unit_test(test_names),          cmocka_unit_test(test_unparsed),
        cmocka_unit_test(test_bindings),       cmocka_unit_test(test_memory),
        cmocka_unit_test(test_locale),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
