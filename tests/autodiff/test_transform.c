/* Transforms of transforms, per-point rows, substitution, and what is refused. */
#include "ad_testing.h"

#include <limits.h>

enum { WIDTH = 5, LAYERS = 3, POINTS = 9 };

/* A small network s -> tanh -> tanh -> 2 rows; every parameter of one flat value. */
typedef struct net {
    ad_tape *tape;
    ad_value s, t, all, y;
    run_data data;
} net;

enum { FIRST = 0, SECOND = 15, THIRD = 45, NUMBERS = 57 };

static ad_value layer(ad_value all, int offset, int rows, int columns, ad_value x)
{
    ad_value w = ad_slice(all, offset, rows * columns);
    return ad_add(ad_matvec(w, x), ad_slice(all, offset + rows * columns, rows));
}

static void net_begin(net *n)
{
    *n = (net){.tape = ad_tape_create()};
    n->s = ad_input(n->tape, "s", 1);
    n->t = ad_input(n->tape, "t", 1);
    n->all = ad_parameter(n->tape, "all", NUMBERS, 0);
    ad_value x = ad_stack(2, (ad_value[]){n->s, n->t});
    x = ad_tanh(layer(n->all, FIRST, WIDTH, 2, x));
    x = ad_tanh(layer(n->all, SECOND, WIDTH, WIDTH, x));
    n->y = layer(n->all, THIRD, 2, WIDTH, x);
}

static void net_fill(net *n)
{
    uint64_t random = 8;
    assert_tape_ok(n->tape);
    data_fill(&n->data, n->tape, POINTS, -1, 1, &random);
}

static void net_end(net *n)
{
    data_free(&n->data);
    ad_tape_free(n->tape);
}

static void numbers_of(ad_value value, const run_data *data, double *numbers)
{
    compiled c = run_compiled(1, &value, NULL, 1, data);
    memcpy(numbers, c.results[0], c.sizes[0] * sizeof *numbers);
    compiled_free(&c);
}

/* ---- order four against the recurrence by hand --------------------------------------------------
 */

typedef long double series[5];

static void series_tanh(const series x, series y)
{
    series u; /* 1 - y^2; k y_k = sum_j j x_j u_(k-j) (Griewank and Walther 2008, table 13.2) */
    y[0] = tanhl(x[0]);
    for (int k = 0; k < 5; k++) {
        for (int j = 1; k > 0 && j <= k; j++)
            y[k] = (j == 1 ? 0 : y[k]) + j * x[j] * u[k - j] / k;
        u[k] = k == 0 ? 1 : 0;
        for (int j = 0; j <= k; j++)
            u[k] -= y[j] * y[k - j];
    }
}

static void series_layer(const double *p, int rows, int columns, const series *x, series *y)
{
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < 5; k++) {
            y[i][k] = k == 0 ? p[rows * columns + i] : 0;
            for (int j = 0; j < columns; j++)
                y[i][k] += p[i * columns + j] * x[j][k];
        }
}

static void net_by_hand(const net *n, size_t point, series *y)
{
    series a[WIDTH], b[WIDTH], x[2] = {{n->data.input[0][point], 1}, {n->data.input[1][point]}};
    series_layer(n->data.parameters + FIRST, WIDTH, 2, (const series *)x, a);
    for (int i = 0; i < WIDTH; i++)
        series_tanh(a[i], b[i]);
    series_layer(n->data.parameters + SECOND, WIDTH, WIDTH, (const series *)b, a);
    for (int i = 0; i < WIDTH; i++)
        series_tanh(a[i], b[i]);
    series_layer(n->data.parameters + THIRD, 2, WIDTH, (const series *)b, y);
}

static void test_network_to_order_four(void **state)
{
    (void)state;
    net n;
    net_begin(&n);
    ad_value c[5];
    assert_int_equal(ad_taylor(1, &n.y, n.s, ad_scalar(n.tape, 1), 4, c), AD_OK);
    net_fill(&n);
    compiled r = run_compiled(5, c, NULL, 1, &n.data);
    for (size_t j = 0; j < POINTS; j++) {
        series y[2];
        net_by_hand(&n, j, y);
        for (int k = 0; k < 5; k++)
            for (size_t row = 0; row < 2; row++) /* 10-term sums, 4 ulp tanh, two layers */
                assert_near(r.results[k][row * POINTS + j], (double)y[row][k], 2e-14);
    }
    compiled_free(&r);
    net_end(&n);
}

/* ---- transforms of transforms -------------------------------------------------------------------
 */

static const double six[3] = {45, -9, 1};

/* Derivative of `value` (uniform, `rows` rows) along a direction of the parameters. */
static void difference_of(const net *n, ad_value value, const double *direction, double step,
                          double *result)
{
    compiled c = compile_values(1, &value, NULL, 1);
    run_data moved = n->data;
    for (int i = 0; i < ad_rows(value); i++)
        result[i] = 0;
    for (int k = -3; k <= 3; k++) {
        for (int i = 0; i < NUMBERS; i++)
            moved.parameters[i] = n->data.parameters[i] + k * step * direction[i];
        compiled_execute(&c, &value, &moved);
        for (int i = 0; k && i < ad_rows(value); i++)
            result[i] += (k > 0 ? 1 : -1) * six[abs(k) - 1] * c.results[0][i] / (60 * step);
    }
    compiled_free(&c);
}

/* Loss of second and mixed derivatives, as of a residual. */
static ad_value loss_of(net *n)
{
    ad_value ss = ad_derivative(n->y, n->s, 2);
    ad_value st = ad_derivative(ad_derivative(n->y, n->s, 1), n->t, 1);
    ad_value residual = ad_add(ad_add(n->y, ad_scale(ss, 0.5)), ad_sub(st, ad_sin(n->t)));
    return ad_div(ad_sum_points(ad_dot(residual, residual)), ad_points(n->tape));
}

static void test_gradient_of_coefficients(void **state)
{
    (void)state;
    net n;
    net_begin(&n);
    ad_value loss = loss_of(&n), gradient;
    assert_int_equal(ad_reverse(loss, 1, &n.all, AD_SUMMED, &gradient), AD_OK);
    net_fill(&n);
    double numbers[NUMBERS], direction[NUMBERS] = {0}, slope;
    numbers_of(gradient, &n.data, numbers);
    for (int i = 0; i < NUMBERS; i++) {
        direction[i] = 1;
        difference_of(&n, loss, direction, 2e-3, &slope);
        direction[i] = 0; /* rounding 1e-16 * 1e2 / h; truncation h^6 f^(7) / 140 */
        assert_near(numbers[i], slope, 1e-9);
    }
    net_end(&n);
}

/* H v three ways: Taylor of the gradient, reverse of reverse, differences of the gradient; and the
 * gradient of the Taylor coefficient, which is the same by symmetry. */
static void test_hessian_vector_products(void **state)
{
    (void)state;
    net n;
    net_begin(&n);
    ad_value loss = loss_of(&n), v = ad_uniform(n.tape, "v", NUMBERS);
    ad_value gradient, forward[2], pushed[2], values[3];
    ad_reverse(loss, 1, &n.all, AD_SUMMED, &gradient);
    ad_taylor(1, &gradient, n.all, v, 1, forward);
    ad_reverse(ad_dot(gradient, v), 1, &n.all, AD_SUMMED, &values[1]);
    ad_taylor(1, &loss, n.all, v, 1, pushed);
    ad_reverse(pushed[1], 1, &n.all, AD_SUMMED, &values[2]);
    values[0] = forward[1];
    net_fill(&n);
    double expected[NUMBERS];
    difference_of(&n, gradient, n.data.uniform[0], 1e-3, expected);
    compiled r = run_compiled(3, values, NULL, 1, &n.data);
    for (int way = 0; way < 3; way++)
        for (int i = 0; i < NUMBERS; i++) /* gradients near 100, rounding 1e-13 / h */
            assert_near(r.results[way][i], expected[i], 1e-7 * (1 + fabs(expected[i])));
    for (int i = 0; i < NUMBERS; i++) { /* exact but for rounding */
        assert_near(r.results[1][i], r.results[0][i], 1e-11 * (1 + fabs(expected[i])));
        assert_near(r.results[2][i], r.results[0][i], 1e-11 * (1 + fabs(expected[i])));
    }
    compiled_free(&r);
    net_end(&n);
}

/* A derivative of a derivative has the partial derivatives of a second coefficient: the way
 * back needs no more of the values on the way forward, hence the same memory. */
static void test_nested_derivatives(void **state)
{
    (void)state;
    double numbers[2][NUMBERS];
    size_t bytes[2];
    for (int nested = 0; nested < 2; nested++) {
        net n;
        net_begin(&n);
        ad_value first = ad_derivative(n.y, n.s, 1), gradient;
        ad_value second = nested ? ad_derivative(first, n.s, 1) : ad_derivative(n.y, n.s, 2);
        ad_value loss = ad_sum_points(ad_add(ad_dot(first, first), ad_dot(second, second)));
        assert_int_equal(ad_reverse(loss, 1, &n.all, AD_SUMMED, &gradient), AD_OK);
        net_fill(&n);
        compiled c = run_compiled(1, &gradient, NULL, 1, &n.data);
        memcpy(numbers[nested], c.results[0], sizeof numbers[nested]);
        bytes[nested] = ad_program_inspect(c.program).workspace_bytes;
        compiled_free(&c);
        net_end(&n);
    }
    assert_int_equal(bytes[1], bytes[0]);
    for (int i = 0; i < NUMBERS; i++) /* the same numbers but for rounding */
        assert_near(numbers[1][i], numbers[0][i], 1e-11 * (1 + fabs(numbers[0][i])));
}

/* exp(a s) sin(b t) + s^2 t^3: every mixed derivative known. */
static void test_mixed_derivatives(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
    ad_value wave = ad_mul(ad_exp(ad_scale(s, 0.7)), ad_sin(ad_scale(t, 1.3)));
    ad_value y = ad_add(wave, ad_mul(ad_square(s), ad_power(t, 3)));
    ad_value values[3] = {ad_derivative(ad_derivative(y, s, 2), t, 2),
                          ad_derivative(ad_derivative(y, t, 2), s, 2),
                          ad_derivative(ad_derivative(ad_derivative(y, s, 1), t, 1), s, 2)};
    uint64_t random = 4;
    run_data data;
    assert_tape_ok(tape);
    data_fill(&data, tape, 5, 0.5, 1.5, &random);
    compiled r = run_compiled(3, values, NULL, 1, &data);
    for (int j = 0; j < 5; j++) {
        double at_s = data.input[0][j], at_t = data.input[1][j], e = exp(0.7 * at_s);
        double both = -0.49 * 1.69 * e * sin(1.3 * at_t) + 12 * at_t;
        assert_near(r.results[0][j], both, 1e-13); /* values up to 20, few operations */
        assert_near(r.results[1][j], both, 1e-13);
        assert_near(r.results[2][j], 0.343 * 1.3 * e * cos(1.3 * at_t), 1e-14);
    }
    compiled_free(&r);
    data_free(&data);
    ad_tape_free(tape);
}

/* ---- one row per point --------------------------------------------------------------------------
 */

static void test_rows_per_point(void **state)
{
    (void)state;
    net n;
    net_begin(&n);
    ad_value residual = ad_row(ad_add(n.y, ad_derivative(n.y, n.s, 2)), 1);
    ad_value row, total, jtj, jtr;
    assert_int_equal(ad_reverse(residual, 1, &n.all, AD_PER_POINT, &row), AD_OK);
    assert_int_equal(ad_reverse(residual, 1, &n.all, AD_SUMMED, &total), AD_OK);
    assert_int_equal(ad_extent_of(row), AD_BATCH);
    jtj = ad_sum_points(ad_outer(row, row));
    jtr = ad_sum_points(ad_mul(row, residual));
    net_fill(&n);
    ad_value values[5] = {row, total, jtj, jtr, residual};
    compiled all = run_compiled(5, values, NULL, 1, &n.data);
    double *sum = new_numbers(NUMBERS * NUMBERS), product[NUMBERS] = {0}, rows[NUMBERS] = {0};
    run_data one = n.data; /* the gradient of each point alone */
    compiled single = compile_values(1, &total, NULL, 1);
    one.points = 1;
    for (int j = 0; j < POINTS; j++) {
        one.input[0] = n.data.input[0] + j;
        one.input[1] = n.data.input[1] + j;
        compiled_execute(&single, &total, &one);
        for (int i = 0; i < NUMBERS; i++) {
            double entry = all.results[0][i * POINTS + j];
            assert_near(entry, single.results[0][i], 1e-13); /* the same sums in another order */
            rows[i] += entry;
            product[i] += entry * all.results[4][j];
            for (int k = 0; k < NUMBERS; k++)
                sum[i * NUMBERS + k] += entry * all.results[0][k * POINTS + j];
        }
    }
    for (int i = 0; i < NUMBERS; i++) {
        assert_near(all.results[1][i], rows[i], 1e-12);
        assert_near(all.results[3][i], product[i], 1e-12);
        for (int k = 0; k < NUMBERS; k++)
            assert_near(all.results[2][i * NUMBERS + k], sum[i * NUMBERS + k], 1e-12);
    }
    free(sum);
    compiled_free(&single);
    compiled_free(&all);
    net_end(&n);
}

/* ---- substitution -------------------------------------------------------------------------------
 */

static void test_substitution(void **state)
{
    (void)state;
    net n;
    net_begin(&n);
    ad_value slope = ad_derivative(n.y, n.s, 1), zero = ad_scalar(n.tape, 0);
    ad_value values[3] = {ad_substitute(slope, n.s, n.t), ad_substitute(n.y, n.s, zero), slope};
    ad_value gone = ad_substitute(values[1], n.t, zero); /* uniform: the network at one place */
    assert_int_equal(ad_extent_of(gone), AD_UNIFORM);
    assert_int_equal(ad_substitute(n.all, n.s, zero).id, n.all.id);
    net_fill(&n);
    memcpy(n.data.input[0], n.data.input[1], POINTS * sizeof(double)); /* s = t: all agree */
    compiled r = run_compiled(3, values, NULL, 1, &n.data);
    for (int i = 0; i < 2 * POINTS; i++)
        assert_near(r.results[0][i], r.results[2][i], 1e-14);
    compiled_free(&r);
    memset(n.data.input[0], 0, POINTS * sizeof(double));
    double at_zero[2 * POINTS], without[2 * POINTS];
    numbers_of(values[1], &n.data, at_zero);
    numbers_of(n.y, &n.data, without);
    for (int i = 0; i < 2 * POINTS; i++)
        assert_near(at_zero[i], without[i], 1e-14);
    net_end(&n);
}

static void test_substitution_is_simplified(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 3), a = ad_uniform(tape, "a", 1);
    ad_value y = ad_add(ad_mul(a, ad_sin(x)), x);
    assert_int_equal(ad_substitute(y, a, ad_scalar(tape, 0)).id, x.id);
    ad_value wide = ad_substitute(ad_slice(ad_tanh(x), 0, 2), x, a); /* one row is repeated */
    assert_int_equal(ad_rows(wide), 2);
    assert_tape_ok(tape);
    assert_false(ad_is_valid(ad_substitute(y, x, ad_uniform(tape, "b", 2))));
    ad_error error;
    assert_int_equal(ad_tape_status(tape, &error), AD_BAD_SHAPE);
    assert_non_null(strstr(error.message, "substitution of 2 rows for a variable of 3"));
    ad_tape_free(tape);
}

/* ---- refusals -----------------------------------------------------------------------------------
 */

typedef struct refusal {
    const char *what;
    ad_status status;
    const char *message;
} refusal;

static ad_value refused(int number, ad_tape *tape, ad_tape *other)
{
    ad_value x = ad_input(tape, "x", 3), p = ad_parameter(tape, "p", 6, 0), out[4];
    ad_value one = ad_row(x, 0), sum = ad_sum_points(one), s = ad_input(tape, "s", 1);
    switch (number) {
    case 0:
        return ad_derivative(ad_stumpff(8, s), s, 3); /* 8 + 2 * 3 > 12 */
    case 1:
        return ad_stumpff(13, x);
    case 2:
        ad_reverse(ad_mul(sum, one), 1, &x, AD_PER_POINT, out);
        return out[0];
    case 3:
        ad_reverse(sum, 1, &one, AD_SUMMED, out);
        return out[0];
    case 4:
        return ad_derivative(sum, ad_tanh(one), 1);
    case 5:
        return ad_add(x, ad_input(other, "y", 3));
    case 6:
        return ad_add(x, p);
    case 7:
        return ad_matvec(p, ad_input(tape, "y", 5));
    case 8:
        return ad_slice(x, 2, 2);
    case 9:
        return ad_slice(x, 1, 2147483647);
    case 10:
        ad_reverse(x, 1, &p, AD_SUMMED, out);
        return out[0];
    case 11:
        ad_taylor(1, &x, x, ad_input(tape, "v", 2), 1, out);
        return out[1];
    case 12:
        return ad_cross(x, p);
    case 13:
        return ad_rotate(x, x);
    case 14:
        return ad_derivative(x, s, -1);
    case 15:
        return ad_derivative(x, s, 17);
    case 16:
        return ad_input(tape, "empty", 0);
    case 17:
        return ad_repeat(x, 4);
    case 18:
        return ad_pad(x, 2, 4);
    case 19:
        ad_taylor(1, (ad_value[]){ad_input(other, "y", 3)}, x, x, 1, out);
        return out[1];
    case 20: /* recorded, but with other rows than these */
        p = ad_parameter(tape, "p of two rows", 2, 0);
        ad_reverse(ad_mul(sum, ad_row(ad_parameter(tape, "p", 6, 0), 1)), 1, &p, AD_SUMMED, out);
        return out[0];
    case 21:
        return ad_outer(ad_zeros(tape, 1 << 16), ad_zeros(tape, 1 << 15)); /* 2^31 */
    case 22:
        return ad_stack(2, (ad_value[]){ad_zeros(tape, INT_MAX), s});
    case 23:
        return ad_parameter(tape, "far", 2, INT_MAX - 1);
    default:
        return ad_substitute(x, ad_tanh(x), x);
    }
}

/* A parameter that algebra made disappear is known to the tape all the same: its adjoint is 0. */
static void test_unneeded_parameter(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value p = ad_parameter(tape, "p", 3, 0), x = ad_input(tape, "x", 3), adjoint;
    ad_value root = ad_sum_points(ad_dot(x, ad_add(x, ad_mul(p, ad_zeros(tape, 3)))));
    assert_int_equal(ad_reverse(root, 1, &p, AD_SUMMED, &adjoint), AD_OK);
    assert_true(ad_is_constant(adjoint, 0));
    ad_tape_free(tape);
}

static void test_refusals(void **state)
{
    (void)state;
    static const refusal expected[] = {
        {"derivative of stumpff", AD_NO_RULE, "stumpff: order 1"},
        {"stumpff", AD_NO_RULE, "stumpff: order 13; 0 to 12"},
        {"row through a sum", AD_NO_RULE, "sum_points: a row of a Jacobian"},
        {"reverse to a result", AD_BAD_ARGUMENT, "is the result of slice"},
        {"Taylor in a result", AD_BAD_ARGUMENT, "is the result of tanh"},
        {"other tape", AD_BAD_ARGUMENT, "add: argument 2 is not a value of this tape"},
        {"add", AD_BAD_SHAPE, "add: arguments of 3 and 6 rows"},
        {"matvec", AD_BAD_SHAPE, "matvec: arguments of 6 and 5 rows"},
        {"slice", AD_BAD_SHAPE, "slice"},
        {"large slice", AD_BAD_SHAPE, "slice"},
        {"root of rows", AD_BAD_SHAPE, "reverse transform of 3 rows; a scalar"},
        {"direction", AD_BAD_SHAPE, "direction of 2 rows for a variable of 3"},
        {"cross", AD_BAD_SHAPE, "cross product: 6 rows; 3"},
        {"rotation", AD_BAD_SHAPE, "rotation: 3 rows; 4"},
        {"order -1", AD_BAD_ARGUMENT, "derivative of order -1"},
        {"order 17", AD_BAD_ARGUMENT, "order 0 to 16"},
        {"no rows", AD_BAD_SHAPE, "empty: 0 rows"},
        {"repeat", AD_BAD_SHAPE, "repeat"},
        {"pad", AD_BAD_SHAPE, "pad"},
        {"Taylor of another tape", AD_BAD_ARGUMENT, "Taylor function is not a value of this tape"},
        {"unused parameter", AD_BAD_ARGUMENT,
         "the parameter p of two rows, 2 rows from 0 on: nothing"},
        {"outer overflows", AD_BAD_SHAPE, "outer: more than 2147483647 rows"},
        {"stack overflows", AD_BAD_SHAPE, "stack: more than 2147483647 rows"},
        {"far parameter", AD_BAD_ARGUMENT, "far: 2 rows from 2147483646 on"},
        {"substitution of a result", AD_BAD_ARGUMENT, "is the result of tanh"},
    };
    for (int i = 0; i < (int)(sizeof expected / sizeof *expected); i++) {
        ad_tape *tape = ad_tape_create(), *other = ad_tape_create();
        ad_error error = {.status = AD_OK};
        ad_value failed = refused(i, tape, other);
        if (ad_is_valid(failed) || ad_tape_status(tape, &error) != expected[i].status ||
            !strstr(error.message, expected[i].message))
            fail_msg("%s: status %d, \"%s\"", expected[i].what, error.status, error.message);
        ad_tape_free(tape);
        ad_tape_free(other);
    }
}

/* The first error stays; what comes after computes nothing and does no harm. */
static void test_errors_are_sticky(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 3), c[3], g;
    ad_value bad = ad_add(x, ad_input(tape, "y", 2));
    ad_value later = ad_normalize(ad_cross(ad_rotate(ad_quaternion_exp(bad), bad), ad_tanh(bad)));
    ad_taylor(1, &later, x, x, 2, c);
    ad_reverse(ad_norm(later), 1, &x, AD_SUMMED, &g);
    later = ad_stack(3, (ad_value[]){ad_derivative(later, x, 1), c[2], g});
    later = ad_gelu(ad_silu(ad_max(later, ad_power(later, 3))));
    later = ad_substitute(later, x, ad_scale(ad_neg(ad_sum_points(later)), 2));
    assert_false(ad_is_valid(later));
    assert_int_equal(ad_rows(later), 0);
    ad_pool *pool = ad_pool_create(1);
    ad_program *program = NULL;
    ad_error error;
    assert_int_equal(ad_compile(1, &x, NULL, pool, &program, &error), AD_BAD_SHAPE);
    assert_null(program);
    assert_string_equal(error.message, "add: arguments of 3 and 2 rows do not fit");
    ad_pool_free(pool);
    ad_tape_free(tape);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_network_to_order_four),
        cmocka_unit_test(test_gradient_of_coefficients),
        cmocka_unit_test(test_hessian_vector_products),
        cmocka_unit_test(test_nested_derivatives),
        cmocka_unit_test(test_mixed_derivatives),
        cmocka_unit_test(test_rows_per_point),
        cmocka_unit_test(test_substitution),
        cmocka_unit_test(test_substitution_is_simplified),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_unneeded_parameter),
        cmocka_unit_test(test_errors_are_sticky),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
