/* A family of rods whose coefficients a network gives once per member: gradient, products with J^T
 * J, normal equations, rows of the Jacobian, and what is saved. */
#include "fewer.h"
#include "members_testing.h"

#include <time.h>

/* Curvature of a rod as modes along s, whose coefficients a network gives for the actuations of a
 * robot; residuals of a balance of moments at points s, their squares and the gradient. */
enum { ACTUATIONS = 5, MODES = 8, HIDDEN = 64, COEFFICIENTS = 3 * MODES };
enum {
    W2 = (ACTUATIONS + 1) * HIDDEN,
    W3 = W2 + (HIDDEN + 1) * HIDDEN,
    FAMILY_PARAMETERS = W3 + HIDDEN * COEFFICIENTS
};

typedef struct family {
    ad_tape *tape;
    ad_value actuations, s, w[3], b[2];
    ad_value coefficients, curvature, residual;
    ad_value outputs[6]; /* loss, gradient */
} family;

static ad_value modes_of(ad_value s)
{
    ad_value p[MODES] = {ad_scalar(s.tape, 1), s};
    for (int k = 2; k < MODES; k++) /* Legendre's recurrence */
        p[k] = ad_sub(ad_scale(ad_mul(s, p[k - 1]), (2.0 * k - 1) / k),
                      ad_scale(p[k - 2], (k - 1.0) / k));
    return ad_stack(MODES, p);
}

static family make_family(ad_value (*input)(ad_tape *, const char *, int))
{
    family f = {.tape = ad_tape_create()};
    f.actuations = input(f.tape, "actuations", ACTUATIONS);
    f.s = ad_input(f.tape, "s", 1);
    f.w[0] = ad_parameter(f.tape, "w1", ACTUATIONS * HIDDEN, 0);
    f.b[0] = ad_parameter(f.tape, "b1", HIDDEN, ACTUATIONS * HIDDEN);
    f.w[1] = ad_parameter(f.tape, "w2", HIDDEN * HIDDEN, W2);
    f.b[1] = ad_parameter(f.tape, "b2", HIDDEN, W2 + HIDDEN * HIDDEN);
    f.w[2] = ad_parameter(f.tape, "w3", HIDDEN * COEFFICIENTS, W3);
    ad_value h = ad_tanh(ad_add(ad_matvec(f.w[0], f.actuations), f.b[0]));
    h = ad_tanh(ad_add(ad_matvec(f.w[1], h), f.b[1]));
    f.coefficients = ad_matvec(f.w[2], h);
    f.curvature = ad_matvec(f.coefficients, modes_of(f.s));
    ad_value force = ad_vector(ad_sin(f.s), ad_row(f.actuations, 0), ad_scalar(f.tape, 0.3));
    f.residual = ad_add(ad_derivative(f.curvature, f.s, 1), ad_cross(f.curvature, force));
    f.outputs[0] = ad_sum_points(ad_dot(f.residual, f.residual));
    ad_value wrt[5] = {f.w[0], f.b[0], f.w[1], f.b[1], f.w[2]};
    ad_reverse(f.outputs[0], 5, wrt, AD_SUMMED, f.outputs + 1);
    assert_tape_ok(f.tape);
    return f;
}

static void free_pair(family *f, family *p, run_data *data, run_data *wide)
{
    data_free(data);
    data_free(wide);
    ad_tape_free(f->tape);
    ad_tape_free(p->tape);
}

/* The family and the same per point, at the same numbers. */
static void make_pair(family *f, family *p, run_data *data, run_data *wide, shape s)
{
    uint64_t random = 3;
    *f = make_family(ad_input_member);
    *p = make_family(ad_input);
    data_fill_members(data, f->tape, points_of(s), s.members, -0.3, 0.3, &random);
    data_fill(wide, p->tape, points_of(s), -1, 1, &random);
    repeat_inputs(wide, data, f->tape);
}

/* ---- derivatives -------------------------------------------------------------------------------
 */

typedef struct loss_of {
    compiled *c;
    const ad_value *outputs;
    run_data *data;
} loss_of;

static int evaluate_loss(void *context, const double *x, double *value, double *gradient)
{
    static const size_t at[6] = {0, 0, ACTUATIONS * HIDDEN, W2, W2 + HIDDEN * HIDDEN, W3};
    const loss_of *l = context;
    memcpy(l->data->parameters, x, FAMILY_PARAMETERS * sizeof *x);
    compiled_execute(l->c, l->outputs, l->data);
    *value = l->c->results[0][0];
    for (int i = 1; gradient && i < 6; i++)
        memcpy(gradient + at[i], l->c->results[i], l->c->sizes[i] * sizeof *x);
    return 0;
}

static void test_gradient(void **state)
{
    (void)state;
    for (int i = 0; i < (int)SHAPES; i++) {
        family f = make_family(ad_input_member);
        run_data data;
        uint64_t random = 5;
        ad_check check;
        ad_error error = {AD_OK, ""};
        data_fill_members(&data, f.tape, points_of(shapes[i]), shapes[i].members, -0.3, 0.3,
                          &random);
        ad_settings settings = {.tile = shapes[i].tile, .piece = 64, .fuse = true};
        compiled c = compile_values(6, f.outputs, &settings, 1);
        loss_of loss = {&c, f.outputs, &data};
        double *x = new_numbers(FAMILY_PARAMETERS);
        memcpy(x, data.parameters, FAMILY_PARAMETERS * sizeof *x);
        assert_int_equal(
            ad_check_gradient(evaluate_loss, &loss, x, FAMILY_PARAMETERS, 12, 1e-2, &check, &error),
            AD_OK);
        /* differences of sixth order at this step are good to 1e-9 */
        assert_true(check.worst_error < 1e-7 && check.dot_error < 1e-7);
        free(x);
        compiled_free(&c);
        data_free(&data);
        ad_tape_free(f.tape);
    }
}

/* J^T J v, forwards and backwards through the values of members, against the same per point. */
static void test_normal_product(void **state)
{
    (void)state;
    static const shape s = {6, 21, 0};
    family pair[2];
    run_data data[2];
    compiled c[2];
    ad_value products[2][5], v[5];
    make_pair(&pair[0], &pair[1], &data[0], &data[1], s);
    for (int k = 0; k < 2; k++) {
        family *f = &pair[k];
        ad_value wrt[5] = {f->w[0], f->b[0], f->w[1], f->b[1], f->w[2]};
        for (int i = 0; i < 5; i++)
            v[i] = ad_parameter(f->tape, "v", ad_rows(wrt[i]), (size_t)i);
        assert_int_equal(ad_normal_product(1, &f->residual, 5, wrt, v, products[k]), AD_OK);
        c[k] = compile_values(5, products[k], NULL, 1);
        data[k].inputs = 2; /* the weights are in no program */
        compiled_execute(&c[k], products[k], &data[k]);
    }
    for (int i = 0; i < 5; i++)
        assert_true(difference(&c[0], &c[1], i, AD_UNIFORM, AD_UNIFORM, false, data) < ROUNDING);
    ad_program_info once = ad_program_inspect(c[0].program),
                    often = ad_program_inspect(c[1].program);
    assert_true(once.flops_per_point * 20 < often.flops_per_point);
    compiled_free(&c[0]);
    compiled_free(&c[1]);

    ad_pool *pool = ad_pool_create(1);
    ad_normal *normal;
    ad_error error = {AD_OK, ""};
    assert_int_equal(ad_normal_compile(1, &pair[0].residual, 1, &pair[0].w[2], FAMILY_PARAMETERS,
                                       pool, &normal, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "values of members"));
    ad_pool_free(pool);
    free_pair(&pair[0], &pair[1], &data[0], &data[1]);
}

/* Rows of the Jacobian by a member's coefficients, each of the member's points; r = c0 s + c1^2 and
 * its Taylor coefficient along c. */
static void test_rows_of_members(void **state)
{
    (void)state;
    enum { MEMBERS_HERE = 3, EACH = 11 };
    ad_tape *tape = ad_tape_create();
    ad_value c = ad_input_member(tape, "c", 2), s = ad_input(tape, "s", 1), rows, taylor[3];
    ad_value r = ad_add(ad_mul(ad_row(c, 0), s), ad_square(ad_row(c, 1)));
    ad_value direction = ad_constant(tape, 2, (double[]){1, 3});
    assert_int_equal(ad_reverse(r, 1, &c, AD_PER_POINT, &rows), AD_OK);
    assert_int_equal(ad_taylor(1, &r, c, direction, 2, taylor), AD_OK);
    assert_int_equal(ad_extent_of(taylor[2]), AD_UNIFORM);
    run_data data;
    uint64_t random = 1;
    data_fill_members(&data, tape, MEMBERS_HERE * EACH, MEMBERS_HERE, -1, 1, &random);
    ad_value outputs[2] = {rows, taylor[1]};
    compiled result = run_compiled(2, outputs, NULL, 1, &data);
    for (size_t j = 0; j < data.points; j++) {
        double c1 = data.input[0][MEMBERS_HERE + j / EACH];
        assert_near(result.results[0][j], data.input[1][j], 1e-15);
        assert_near(result.results[0][data.points + j], 2 * c1, 1e-15);
        assert_near(result.results[1][j], data.input[1][j] + 3 * 2 * c1, 1e-14);
    }
    assert_true(ad_is_constant(taylor[2], 9));
    compiled_free(&result);
    data_free(&data);
    ad_tape_free(tape);
}

/* Where all members have the same points s, the modes at these are a matrix for all: a product per
 * member, of as many rows as there are points. */
static void test_common_points(void **state)
{
    (void)state;
    enum { EACH = 16 };
    static const shape s = {9, EACH, 0};
    double at[EACH * MODES];
    family f = make_family(ad_input_member);
    run_data data;
    uint64_t random = 8;
    data_fill_members(&data, f.tape, points_of(s), s.members, -0.3, 0.3, &random);
    for (size_t j = 0; j < data.points; j++)
        data.input[1][j] = -1 + 2.0 * (double)(j % EACH) / (EACH - 1);
    ad_value modes = modes_of(f.s), outputs[4], sum = ad_zeros(f.tape, 1);
    run_data one = data;
    one.points = EACH;
    one.members = 1;
    compiled c = run_compiled(1, &modes, NULL, 1, &one);
    for (int i = 0; i < EACH * MODES; i++)
        at[i] = c.results[0][i % MODES * EACH + i / MODES];
    compiled_free(&c);
    ad_value matrix = ad_constant(f.tape, EACH * MODES, at);
    for (int i = 0; i < 3; i++) {
        ad_value u = ad_matvec(matrix, ad_slice(f.coefficients, i * MODES, MODES));
        assert_int_equal(ad_extent_of(u), AD_MEMBER);
        sum = ad_add(sum, ad_dot(u, u));
    }
    outputs[0] = ad_sum_members(sum);
    outputs[1] = ad_sum_points(ad_dot(f.curvature, f.curvature));
    ad_reverse(sum, 1, &f.w[2], AD_SUMMED, &outputs[2]); /* a root per member: of their sum */
    ad_reverse(outputs[1], 1, &f.w[2], AD_SUMMED, &outputs[3]);
    c = run_compiled(4, outputs, NULL, 1, &data);
    assert_near(c.results[0][0], c.results[1][0], ROUNDING * c.results[1][0]);
    for (size_t i = 0; i < c.sizes[2]; i++)
        assert_near(c.results[2][i], c.results[3][i], 100 * ROUNDING);
    compiled_free(&c);
    data_free(&data);
    ad_tape_free(f.tape);
}

/* ---- what is saved ------------------------------------------------------------------------------
 */

static double seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double time_of(compiled *c, const ad_value *outputs, const run_data *data)
{
    double start = seconds();
    compiled_execute(c, outputs, data);
    return seconds() - start;
}

/* The network's operations are counted once per member, and the program takes a small part of the
 * time of one that has everything per point. */
static void test_saved(void **state)
{
    (void)state;
    enum { EACH = 64, FAMILY = 128, ROUNDS = 7 };
    family f, p;
    run_data data, wide;
    make_pair(&f, &p, &data, &wide, (shape){FAMILY, EACH, 0});
    compiled once = run_compiled(6, f.outputs, NULL, 1, &data);
    compiled often = run_compiled(6, p.outputs, NULL, 1, &wide);
    for (int i = 0; i < 6; i++) {
        double off = difference(&once, &often, i, AD_UNIFORM, AD_UNIFORM, false, &data);
        if (!(off <= ROUNDING))
            fail_msg("output %d: off by %g", i, off);
    }
    ad_program_info a = ad_program_inspect(once.program), b = ad_program_inspect(often.program);
    double network = 2.0 * (ACTUATIONS * HIDDEN + HIDDEN * HIDDEN + HIDDEN * COEFFICIENTS);
    double back = 2 * network - 2.0 * ACTUATIONS * HIDDEN; /* nothing goes back to the actuations */
    assert_true((double)a.flops_per_member == network + back);
    assert_true(a.flops_per_point * 20 < a.flops_per_member);
    assert_true(b.flops_per_point > a.flops_per_member && b.flops_per_member == 0);
    double slow = INFINITY, quick = INFINITY;
    for (int round = 0; round < ROUNDS; round++) {
        slow = fmin(slow, time_of(&often, p.outputs, &wide));
        quick = fmin(quick, time_of(&once, f.outputs, &data));
    }
    print_message(
        "%zu flops per point and %zu per member, without members %zu per point: %.0f times "
        "as fast, %.0f ns per point\n",
        a.flops_per_point, a.flops_per_member, b.flops_per_point, slow / quick,
        1e9 * quick / (FAMILY * EACH));
    assert_true(slow > 4 * quick); /* it is some 50 times; others may use the processor */
    compiled_free(&once);
    compiled_free(&often);
    free_pair(&f, &p, &data, &wide);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_gradient),
        cmocka_unit_test(test_normal_product),
        cmocka_unit_test(test_rows_of_members),
        cmocka_unit_test(test_common_points),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_saved)};
    return run_with_alike(tests, alike, NULL, NULL);
}
