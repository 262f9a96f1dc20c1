/* Equations as text: what is recorded of them against numbers by hand, and refusals. */
#include "physics/learn/equations.h"

#include "done.h"
#include "evaluate.h"

#include <stdio.h>

/* x in [-1, 1], t in [0, 2] as time, a field u. */
static equations *burgers(void)
{
    equations *e = equations_create();
    assert_non_null(e);
    DONE(equations_add_coordinate(e, &(equations_coordinate){"x", "m", -1, 1, false, false},
                                  &error));
    DONE(equations_add_coordinate(e, &(equations_coordinate){"t", "s", 0, 2, false, true}, &error));
    DONE(equations_add_parameter(e, "nu", "0.01/pi", &error));
    DONE(equations_add_field(e, "u", &error));
    return e;
}

/* The numbers of a term at points x, t of u = sin(2 x) exp(-3 t) + x t. */
static void residual_at(const physics_model *m, int term, size_t points, const double *x,
                        const double *t, const double *data, double *values)
{
    ad_tape *tape = ad_tape_create();
    assert_non_null(tape);
    domain_place at = {.tape = tape, .over = &m->domain};
    at.x[0] = ad_input(tape, "p", 1);
    at.x[1] = ad_input(tape, "p", 1);
    at.data = ad_input(tape, "p", 1);
    at.unknowns = ad_constant(tape, 2, (const double[]){5, 7});
    const ad_value u = ad_add(ad_mul(ad_sin(ad_scale(at.x[0], 2)), ad_exp(ad_scale(at.x[1], -3))),
                              ad_mul(at.x[0], at.x[1]));
    const ad_value value = m->terms[term].residual(m->terms[term].context, &at, &u);
    evaluate(1, &value, points, (const double *const[]){x, t, data}, NULL, &values);
    ad_tape_free(tape);
}

static void records_residuals(void **state)
{
    (void)state;
    const double x[3] = {-0.7, 0.1, 0.9}, t[3] = {0, 0.4, 1.3}, data[3] = {0.5, -1, 2};
    const physics_model *m;
    double values[3];
    equations *e = burgers();
    DONE(equations_add_unknown(e, "a", 1, &error));
    DONE(equations_add_unknown(e, "b", 1, &error));
    DONE(equations_add_parameter(e, "flux", "nu*u_x + b", &error));
    DONE(equations_add_inside(e, "u_t + u*u_x - nu*u_xx", &error));
    DONE(equations_add_inside(e, "a*u_xxt + flux - x*t^2", &error));
    DONE(equations_add_parameter(e, "F", "u^2/2 - flux", &error));
    DONE(equations_add_inside(e, "u_t + F_x + x*flux_xt", &error)); /* of formulas */
    DONE(equations_add_condition(e, "t", 0, "u", "-sin(pi*x)", &error));
    DONE(equations_add_condition(e, "x", 1, "zero", "u_x + u^4 - exp(t)", &error));
    DONE(equations_add_data(e, 3, 3, (const char *const[]){"t", "u_t", "x"},
                            (const double *const[]){t, data, x}, 0.25, &error));
    DONE(equations_model(e, &m, &error));
    assert_int_equal(m->term_count, 6);
    assert_int_equal(m->domain.time, 1);
    for (int term = 0; term < 6; term++) {
        residual_at(m, term, 3, x, t, data, values);
        for (int i = 0; i < 3; i++) {
            const double s = sin(2 * x[i]), c = cos(2 * x[i]), decay = exp(-3 * t[i]);
            const double u = s * decay + x[i] * t[i], u_x = 2 * c * decay + t[i],
                         u_t = -3 * s * decay + x[i], nu = 0.01 / 3.14159265358979323846;
            const double expected[6] = {u_t + u * u_x + nu * 4 * s * decay,
                                        5 * 12 * s * decay + nu * u_x + 7 - x[i] * t[i] * t[i],
                                        u_t + u * u_x + nu * 4 * s * decay +
                                            x[i] * nu * 12 * s * decay,
                                        u + sin(3.14159265358979323846 * x[i]),
                                        u_x + u * u * u * u - exp(t[i]),
                                        (u_t - data[i]) / 0.25};
            assert_near(values[i], expected[term], 1e-13); /* some roundings of numbers below 100 */
        }
    }
    equations_free(e);
}

/* Measured numbers come with their places, without those that are missing. */
static void gives_data(void **state)
{
    (void)state;
    const double x[3] = {-0.5, 0.5, 1}, t[3] = {0, 1, 2}, u[3] = {3, NAN, 4};
    double places[8], values[4];
    const physics_model *m;
    equations *e = burgers();
    DONE(equations_add_inside(e, "u_t - u_xx", &error));
    DONE(equations_add_data(e, 3, 4, (const char *const[]){"x", "t", "u", "error_u"},
                            (const double *const[]){x, t, u, x}, 0, &error));
    DONE(equations_model(e, &m, &error));
    const model_source *source = &m->sets[m->terms[1].set].source;
    assert_int_equal(source->points, 2);
    const model_draw draw = {.count = 3, .x = places, .data = values};
    DONE(source->fill(source->context, &draw, &error));
    const double expected[6] = {-0.5, 1, -0.5, 0, 2, 0}, measured[3] = {3, 4, 3};
    for (int i = 0; i < 6; i++) {
        assert_near(places[i], expected[i], 0);
        assert_near(values[i % 3], measured[i % 3], 0);
    }
    /* in units of the root of the mean square, sqrt(12.5) */
    residual_at(m, 1, 1, x, t, (const double[]){3}, values);
    assert_near(values[0], (sin(-1) - 3) / sqrt(12.5), 1e-15);
    equations_free(e);
}

static void refuses_names(void **state)
{
    (void)state;
    equations *e = burgers();
    REFUSED(equations_add_inside(e, "u_t + w", &error), "unknown name 'w'");
    REFUSED(equations_add_inside(e, "u_t + s", &error), "unknown name 's'");
    REFUSED(equations_add_inside(e, "u_t + u_y", &error), "allowed behind u_ are coordinates");
    REFUSED(equations_add_inside(e, "u_xxxxxxx", &error), "6 times at most: x, t");
    REFUSED(equations_add_inside(e, "x - t", &error), "has no field");
    REFUSED(equations_add_inside(e, "u_t + (u", &error), "column 9");
    REFUSED(equations_add_field(e, "x", &error), "formulas know 'x' already");
    REFUSED(equations_add_field(e, "velocities", &error), "1 to 7 letters");
    REFUSED(equations_add_range(e, "sin", 0, 1, &error), "formulas know 'sin' already");
    REFUSED(equations_add_range(e, "k", 1, 1, &error), "from 1 to 1; allowed");
    REFUSED(equations_add_unknown(e, "k", NAN, &error), "guess of k");
    REFUSED(equations_add_parameter(e, "k", "2*", &error), "the formula ends");
    REFUSED(
        equations_add_coordinate(e, &(equations_coordinate){"z", "", 0, 1, false, true}, &error),
        "second coordinate of time, beside t");
    REFUSED(equations_add_coordinate(e, &(equations_coordinate){"z", "", 0, 1, true, true}, &error),
            "second coordinate of time");
    double number = 0;
    REFUSED(equations_number(e, "2*x", &number, &error), "x stands where only numbers");
    DONE(equations_number(e, "100*nu*pi", &number, &error));
    assert_near(number, 1, 1e-15);
    equations_free(e);
}

static void refuses_conditions(void **state)
{
    (void)state;
    equations *e = burgers();
    DONE(equations_add_range(e, "k", 1, 2, &error));
    DONE(equations_add_coordinate(e, &(equations_coordinate){"y", "", 0, 1, true, false}, &error));
    REFUSED(equations_add_condition(e, "z", 0, "u", "0", &error), "'z' is no coordinate");
    REFUSED(equations_add_condition(e, "k", 1, "u", "0", &error), "but a parameter");
    REFUSED(equations_add_condition(e, "y", 0, "u", "0", &error), "is periodic");
    REFUSED(equations_add_condition(e, "x", 0.5, "u", "0", &error), "no face; allowed: -1 or 1");
    REFUSED(equations_add_condition(e, "t", 2, "u", "0", &error),
            "t = 2 is no face; allowed: 0, where time begins");
    REFUSED(equations_add_condition(e, "x", 1, "w", "0", &error), "'w' is no field");
    REFUSED(equations_add_condition(e, "x", 1, "u_t", "0", &error), "zero: u_t - ");
    REFUSED(equations_add_condition(e, "x", 1, "u", "u_x", &error), "u_x stands where only");
    REFUSED(equations_add_condition(e, "x", 1, "zero", "t", &error), "has no field");
    DONE(equations_add_condition(e, "x", 1, "u_xx", "k*t", &error));
    REFUSED(equations_add_condition(e, "x", 1, "u_xx", "0", &error), "given twice");
    equations_free(e);
}

static void refuses_data(void **state)
{
    (void)state;
    const double zeros[2] = {0, 0}, far[2] = {0, 3}, none[2] = {NAN, NAN};
    equations *e = burgers();
    const char *const names[] = {"x", "t", "u"};
    const double *columns[] = {zeros, zeros, zeros};
    REFUSED(equations_add_data(e, 2, 2, names, columns, 0, &error), "no column of a field");
    REFUSED(equations_add_data(e, 2, 2, names + 1, columns, 0, &error), "no column x");
    REFUSED(equations_add_data(e, 2, 3, (const char *const[]){"x", "t", "w"}, columns, 0, &error),
            "'w' is nothing of the model; allowed: x, t, u");
    REFUSED(equations_add_data(e, 2, 3, names, columns, -1, &error), "noise -1");
    columns[1] = far;
    REFUSED(equations_add_data(e, 2, 3, names, columns, 0, &error), "row 2 has t = 3");
    columns[1] = zeros;
    columns[2] = none;
    REFUSED(equations_add_data(e, 2, 3, names, columns, 0, &error), "has no number");
    equations_free(e);
}

/* What is missing, or more than fits, once all is told. */
static void refuses_wholes(void **state)
{
    (void)state;
    const physics_model *m;
    equations *e = burgers();
    REFUSED(equations_model(e, &m, &error), "no equation inside");
    DONE(equations_add_inside(e, "u_t - u_xx", &error));
    REFUSED(equations_model(e, &m, &error), "how it begins");
    DONE(equations_add_condition(e, "t", 0, "u", "0", &error));
    DONE(equations_add_unknown(e, "k", 1, &error));
    REFUSED(equations_model(e, &m, &error), "say what k is");
    DONE(equations_add_condition(e, "t", 0, "u_t", "0", &error));
    REFUSED(equations_model(e, &m, &error), "2 conditions at the ends of t");
    DONE(equations_add_field(e, "v", &error));
    REFUSED(equations_model(e, &m, &error), "no equation has the field v");
    equations_free(e);

    e = burgers();
    DONE(equations_add_field(e, "v", &error));
    DONE(equations_add_inside(e, "u_t - v_xx", &error));
    REFUSED(equations_model(e, &m, &error), "2 fields and only 1 equations");
    DONE(equations_add_inside(e, "v_t + u_xx", &error));
    DONE(equations_add_condition(e, "t", 0, "u", "0", &error));
    DONE(equations_model(e, &m, &error));
    REFUSED(equations_add_inside(e, "u", &error), "made already");
    equations_free(e);
}

/* "u_xt" as evaluations ask for it. */
static void finds_derivatives(void **state)
{
    (void)state;
    int field, orders[DOMAIN_COORDINATES_MAX];
    equations *e = burgers();
    DONE(equations_add_field(e, "u_a", &error));
    DONE(equations_find(e, "u_a", &field, orders, &error));
    assert_int_equal(field, 1);
    assert_int_equal(orders[0] + orders[1], 0);
    DONE(equations_find(e, "u_a_xtx", &field, orders, &error));
    assert_int_equal(field, 1);
    assert_int_equal(orders[0], 2);
    assert_int_equal(orders[1], 1);
    REFUSED(equations_find(e, "nu", &field, orders, &error), "no field");
    equations_free(e);
}

/* The derivative of a formula that jumps would leave out the jump, without a word. */
static void refuses_jumps(void **state)
{
    (void)state;
    equations *e = burgers();
    DONE(equations_add_parameter(e, "F", "where(0.5-x, 1, 10)*u_x", &error));
    REFUSED(equations_add_inside(e, "u_t - F_x", &error), "F jumps");
    DONE(equations_add_parameter(e, "G", "u*u_x", &error));
    DONE(equations_add_inside(e, "u_t - G_x - F", &error));
    equations_free(e);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(records_residuals),  cmocka_unit_test(gives_data),
        cmocka_unit_test(refuses_names),      cmocka_unit_test(refuses_jumps),
        cmocka_unit_test(refuses_conditions), cmocka_unit_test(refuses_data),
        cmocka_unit_test(refuses_wholes),     cmocka_unit_test(finds_derivatives)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
