/* What a scene does not need disappears while it is recorded. Every rule is checked twice: the tape
 * holds the simpler value, and numbers are those of the formula. */
#include "ad_testing.h"

static ad_tape *tape;
static ad_value x, y, u; /* batch, 3 rows; batch, 1 row; uniform, 3 rows */

static int begin(void **state)
{
    (void)state;
    tape = ad_tape_create();
    x = ad_input(tape, "x", 3);
    y = ad_input(tape, "y", 1);
    u = ad_uniform(tape, "u", 3);
    return tape ? 0 : -1;
}

static int end(void **state)
{
    (void)state;
    ad_tape_free(tape);
    return 0;
}

#define assert_same(a, b) assert_int_equal((a).id, (b).id)

static int op_of(ad_value a)
{
    return node_of(a)->op;
}

static void assert_all(ad_value a, int rows, double number)
{
    assert_tape_ok(tape);
    assert_int_equal(ad_rows(a), rows);
    assert_true(ad_is_constant(a, number));
}

/* How many operations on the tape `outputs` need. */
static size_t operations(ad_value output)
{
    compiled c = compile_values(1, &output, &(ad_settings){.piece = 512}, 1);
    size_t count = ad_program_inspect(c.program).instructions;
    compiled_free(&c);
    return count;
}

static void test_zero_and_one(void **state)
{
    (void)state;
    ad_value zero = ad_scalar(tape, 0), one = ad_scalar(tape, 1);
    assert_all(ad_mul(x, zero), 3, 0);
    assert_all(ad_mul(ad_zeros(tape, 3), y), 3, 0);
    assert_same(ad_mul(one, x), x);
    assert_same(ad_mul(x, one), x);
    assert_same(ad_add(x, zero), x);
    assert_same(ad_add(ad_zeros(tape, 3), x), x);
    assert_same(ad_sub(x, zero), x);
    assert_same(ad_sub(zero, x), ad_neg(x));
    assert_same(ad_neg(ad_neg(x)), x);
    assert_all(ad_sub(x, x), 3, 0);
    assert_all(ad_div(ad_zeros(tape, 3), y), 3, 0);
    assert_same(ad_power(x, 1), x);
    assert_all(ad_power(x, 0), 3, 1);
    assert_same(ad_power(x, 2), ad_mul(x, x));
    assert_int_equal(ad_rows(ad_add(y, ad_zeros(tape, 3))), 3); /* keeps the rows of the result */
    assert_int_equal(ad_rows(ad_mul(y, ad_repeat(one, 3))), 3);
    assert_all(ad_sum_points(ad_mul(x, zero)), 3, 0);
    assert_all(ad_matvec(ad_parameter(tape, "w", 6, 0), ad_zeros(tape, 3)), 2, 0);
    assert_all(ad_matvec(ad_zeros(tape, 6), x), 2, 0);
    assert_all(ad_matvec_transposed(ad_zeros(tape, 6), x), 2, 0);
    assert_all(ad_outer(x, zero), 3, 0);
}

static void test_constants_fold(void **state)
{
    (void)state;
    ad_value a = ad_constant(tape, 3, (double[]){1, 2, 3}), b = ad_scalar(tape, 0.5);
    ad_value folded = ad_exp(ad_mul(ad_add(a, b), a));
    assert_int_equal(op_of(folded), OP_CONSTANT);
    for (int i = 0; i < 3; i++)
        assert_near(ad_constant_row(folded, i), exp((i + 1.5) * (i + 1)), 0);
    assert_all(ad_sum_rows(a), 1, 6);
    assert_all(ad_row(a, 1), 1, 2);
    assert_all(ad_norm(ad_constant(tape, 2, (double[]){3, 4})), 1, 5);
    assert_same(
        ad_stack(3, (ad_value[]){ad_scalar(tape, 1), ad_scalar(tape, 2), ad_scalar(tape, 3)}), a);
    assert_same(ad_scale(ad_scale(x, 4), 0.25), x); /* factors meet */
    assert_same(ad_mul(ad_scale(x, 2), ad_scale(y, 3)), ad_scale(ad_mul(x, y), 6));
    assert_same(ad_select(ad_scalar(tape, 1), x, u), x);
    assert_same(ad_select(ad_scalar(tape, 0), x, u), u);
    assert_same(ad_select(y, x, x), x);
}

static void test_equal_operations_are_shared(void **state)
{
    (void)state;
    ad_value first = ad_tanh(ad_mul(x, u));
    ad_tape_counts before = ad_tape_count(tape);
    assert_same(ad_tanh(ad_mul(u, x)), first); /* either order */
    assert_same(ad_add(first, x), ad_add(x, first));
    ad_tape_counts after = ad_tape_count(tape);
    assert_int_equal(after.stored, before.stored + 1);
    assert_int_equal(after.recorded - before.recorded, (after.stored - before.stored) +
                                                           (after.shared - before.shared) +
                                                           (after.folded - before.folded));
    assert_true(ad_input(tape, "x", 3).id != x.id); /* inputs never are */
    assert_same(ad_parameter(tape, "p", 2, 7), ad_parameter(tape, "q", 2, 7));
    assert_true(ad_parameter(tape, "p", 2, 7).id != ad_parameter(tape, "p", 2, 8).id);
    assert_true(ad_scalar(tape, 0.0).id != ad_scalar(tape, -0.0).id);
    assert_true(ad_power(x, 3).id != ad_power(x, 4).id);
    assert_true(ad_stumpff(1, y).id != ad_stumpff(2, y).id);
    assert_true(ad_slice(x, 0, 2).id != ad_slice(x, 1, 2).id);
}

static void test_rows(void **state)
{
    (void)state;
    ad_value rows[3] = {ad_row(x, 0), ad_row(x, 1), ad_row(x, 2)};
    assert_same(ad_stack(3, rows), x);
    assert_same(ad_stack(2, rows + 1), ad_slice(x, 1, 2));
    ad_value both = ad_stack(2, (ad_value[]){u, x});
    assert_same(ad_slice(both, 3, 3), x);
    assert_same(ad_row(both, 4), rows[1]);
    assert_same(ad_slice(ad_slice(x, 1, 2), 1, 1), rows[2]);
    ad_value padded = ad_pad(x, 2, 9);
    assert_same(ad_slice(padded, 3, 2), ad_slice(x, 1, 2));
    assert_all(ad_slice(padded, 5, 4), 4, 0);
    assert_same(ad_slice(ad_repeat(y, 5), 2, 1), y);
    assert_same(ad_sum_rows(ad_repeat(y, 5)), ad_scale(y, 5));
    assert_same(ad_sum_rows(y), y);
}

/* Only the two products that a cross product with an axis needs. */
static void test_vectors_with_zeros(void **state)
{
    (void)state;
    ad_value e3 = ad_vector_constant(tape, 0, 0, 1);
    ad_value turned = ad_cross(x, e3); /* (x_1, -x_0, 0) */
    assert_same(ad_row(turned, 0), ad_row(x, 1));
    assert_same(ad_row(turned, 1), ad_neg(ad_row(x, 0)));
    assert_all(ad_row(turned, 2), 1, 0);
    assert_same(ad_dot(x, e3), ad_row(x, 2));
    assert_all(ad_cross(e3, e3), 3, 0);
    assert_all(ad_cross(x, x), 3, 0);
    ad_value plane = ad_vector(y, ad_scalar(tape, 0), ad_sin(y));
    ad_value moved = ad_add(ad_mul(plane, x), ad_tanh(plane));
    assert_all(ad_row(moved, 1), 1, 0);
    assert_same(ad_row(ad_cross(plane, ad_vector_constant(tape, 0, 1, 0)), 0), ad_neg(ad_sin(y)));
}

static void test_quaternions(void **state)
{
    (void)state;
    ad_value zero = ad_scalar(tape, 0), pure = ad_quaternion(zero, x);
    ad_value axis = ad_quaternion(zero, ad_vector_constant(tape, 0, 0, 1));
    ad_value product = ad_quaternion_multiply(pure, axis); /* (-x_2, x x e3) */
    assert_same(ad_row(product, 0), ad_neg(ad_row(x, 2)));
    assert_same(ad_row(product, 1), ad_row(x, 1));
    assert_all(ad_row(product, 3), 1, 0);
    ad_value one = ad_quaternion(ad_scalar(tape, 1), ad_zeros(tape, 3));
    ad_value q = ad_stack(2, (ad_value[]){y, x});
    assert_same(ad_quaternion_multiply(one, q), q);
    assert_same(ad_quaternion_multiply(q, one), q);
    assert_same(ad_rotate(one, x), x);
    assert_same(ad_quaternion_conjugate(ad_quaternion_conjugate(q)), q);
}

/* A static network: no derivative in time, at no cost. */
static void test_static_network(void **state)
{
    (void)state;
    ad_value time = ad_input(tape, "time", 1), w = ad_parameter(tape, "w", 15, 0);
    ad_value net = ad_tanh(ad_add(ad_matvec(w, x), ad_parameter(tape, "b", 5, 15)));
    ad_value velocity = ad_derivative(net, time, 1), c[5];
    assert_all(velocity, 5, 0);
    assert_all(ad_derivative(ad_sin(velocity), time, 2), 5, 0);
    ad_value dynamic = ad_add(net, ad_mul(y, ad_derivative(velocity, time, 1)));
    assert_same(dynamic, net);
    ad_taylor(1, &net, x, ad_vector_constant(tape, 1, 0, 0), 4, c);
    ad_value linear = ad_matvec(w, x);
    ad_taylor(1, &linear, x, ad_vector_constant(tape, 1, 0, 0), 4, c);
    assert_all(c[2], 5, 0); /* of a linear map */
    assert_int_equal(ad_extent_of(c[1]), AD_UNIFORM);
    ad_value gradient, wrt = ad_uniform(tape, "absent", 2);
    assert_int_equal(ad_reverse(ad_sum_points(ad_sum_rows(net)), 1, &wrt, AD_SUMMED, &gradient),
                     AD_OK);
    assert_all(gradient, 2, 0);
}

static void test_dead_code(void **state)
{
    (void)state;
    ad_value used = ad_sin(y), unused = ad_exp(ad_mul(x, used));
    (void)unused;
    assert_int_equal(operations(used), 1);
    compiled c = compile_values(1, &used, NULL, 1);
    assert_int_equal(ad_program_inspect(c.program).dead, ad_tape_count(tape).stored - 2);
    compiled_free(&c);
}

static void test_sums_over_points(void **state)
{
    (void)state;
    assert_same(ad_sum_points(u), ad_mul(ad_points(tape), u));
    ad_value mean = ad_sum_points(ad_mul(u, y)); /* uniform factors move out */
    assert_same(mean, ad_mul(u, ad_sum_points(y)));
    assert_int_equal(op_of(ad_sum_points(ad_outer(x, ad_stack(2, (ad_value[]){y, ad_sin(y)})))),
                     OP_OUTER_SUM);
}

static void test_uses(void **state)
{
    (void)state;
    ad_value slope = ad_cos(y), values[2] = {ad_sin(x), ad_mul(u, ad_scale(slope, 3))};
    assert_true(ad_uses(2, values, x));
    assert_true(ad_uses(2, values, slope));
    assert_true(ad_uses(2, values, ad_scale(slope, 5))); /* but for a factor */
    assert_true(ad_uses(2, values, ad_stack(2, (ad_value[]){ad_exp(y), slope})));
    assert_false(ad_uses(1, values, y));
    assert_false(ad_uses(1, values, slope));
    assert_false(ad_uses(2, values, ad_exp(y)));
    assert_false(ad_uses(2, values, ad_scalar(tape, 3)));
    assert_false(ad_uses(0, values, x));
}

/* The numbers of the formulas above, at points. */
static void test_numbers(void **state)
{
    (void)state;
    ad_value e3 = ad_vector_constant(tape, 0, 0, 1);
    ad_value values[3] = {ad_cross(x, e3), ad_neg(ad_sub(x, ad_scale(u, 2))),
                          ad_mul(ad_scale(x, 2), ad_scale(y, 3))};
    uint64_t random = 3;
    run_data data;
    data_fill(&data, tape, 4, -1, 1, &random);
    compiled c = run_compiled(3, values, NULL, 1, &data);
    for (size_t j = 0; j < 4; j++) {
        const double *at = data.input[0] + j;
        assert_near(c.results[0][j], at[4], 0);
        assert_near(c.results[0][4 + j], -at[0], 0);
        for (size_t k = 0; k < 3; k++) {
            assert_near(c.results[1][4 * k + j], 2 * data.uniform[0][k] - at[4 * k], 1e-15);
            assert_near(c.results[2][4 * k + j], 6 * at[4 * k] * data.input[1][j], 2e-15);
        }
    }
    compiled_free(&c);
    data_free(&data);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(test_zero_and_one),
        TEST(test_constants_fold),
        TEST(test_equal_operations_are_shared),
        TEST(test_rows),
        TEST(test_vectors_with_zeros),
        TEST(test_quaternions),
        TEST(test_static_network),
        TEST(test_dead_code),
        TEST(test_sums_over_points),
        TEST(test_uses),
        TEST(test_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
