/* Compiled programs against a naive interpreter: random graphs, several passes, any number of
 * points, tiles and threads. */
#include "random_graphs.h"

#include <stdio.h>

/* Products of up to 64 terms and a few hundred operations that do not amplify: rounding stays
 * below some hundred units of 2e-16. */
#define ROUNDING 2e-12

/* ---- random graphs -----------------------------------------------------------------------------
 */

static void check_garden(uint64_t seed, int operations, bool sums)
{
    static const size_t points[] = {1, 7, 8, 9, 31, 33, 40, 100};
    static const int tiles[] = {0, 8, 32, 40, 64}, pieces[] = {512, 1, 64, 100000};
    garden g;
    garden_plant(&g, seed, operations, sums);
    ad_value outputs[OUTPUTS];
    int count = garden_outputs(&g, outputs);
    run_data data;
    data_fill(&data, g.tape, points[seed % 8], -1, 1, &g.random);
    naive n = naive_run(g.tape, &data);
    double pulled = naive_at(&n, outputs[count - 2].id, 0, 0);
    double pushed = naive_at(&n, outputs[count - 1].id, 0, 0);
    if (!(fabs(pulled - pushed) <= 1e-10 * (1 + fabs(pushed))))
        fail_msg("graph %llu: %.17g backwards, %.17g forwards", (unsigned long long)seed, pulled,
                 pushed);
    for (int fuse = 0; fuse < 2; fuse++) {
        ad_settings settings = {.tile = tiles[seed / 8 % 5], .piece = pieces[seed / 3 % 4]};
        settings.fuse = fuse;
        compiled c = run_compiled(count, outputs, &settings, 1, &data);
        double error = compiled_error(&c, outputs, &n);
        if (!(error <= ROUNDING))
            fail_msg("graph %llu of %d operations, fuse %d: off by %g", (unsigned long long)seed,
                     operations, fuse, error);
        compiled_free(&c);
    }
    naive_free(&n);
    data_free(&data);
    ad_tape_free(g.tape);
}

static void test_random_graphs(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 400; seed++)
        check_garden(seed, 6 + (int)(seed % 60), seed % 3 == 0);
}

/* ---- points, tiles, threads --------------------------------------------------------------------
 */

static void test_number_of_points(void **state)
{
    (void)state;
    static const size_t points[] = {0, 1, 7, 8, 9, 31, 32, 33, 127, 128, 129, 1000};
    garden g;
    garden_plant(&g, 77, 50, true);
    ad_value outputs[OUTPUTS];
    int count = garden_outputs(&g, outputs);
    ad_settings settings = ad_settings_default();
    compiled c = compile_values(count, outputs, &settings, 1);
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < 12; i++) { /* one program for all, up and down */
            run_data data;
            data_fill(&data, g.tape, points[round ? 11 - i : i], -1, 1, &g.random);
            naive n = naive_run(g.tape, &data);
            compiled_execute(&c, outputs, &data);
            assert_near(compiled_error(&c, outputs, &n), 0, ROUNDING);
            naive_free(&n);
            data_free(&data);
        }
    }
    compiled_free(&c);
    ad_tape_free(g.tape);
}

static void assert_same_bits(const compiled *a, const compiled *b)
{
    for (int i = 0; i < a->count; i++)
        assert_memory_equal(a->results[i], b->results[i], a->sizes[i] * sizeof(double));
}

static void test_threads_give_the_same_bits(void **state)
{
    (void)state;
    static const size_t points[] = {33, 1000, 3000};
    for (int i = 0; i < 3; i++) {
        garden g;
        garden_plant(&g, 1000 + (uint64_t)i, 40, true);
        ad_value outputs[OUTPUTS];
        int count = garden_outputs(&g, outputs);
        run_data data;
        data_fill(&data, g.tape, points[i], -1, 1, &g.random);
        ad_settings settings = {.tile = 32, .piece = 512, .fuse = true};
        compiled one = run_compiled(count, outputs, &settings, 1, &data);
        for (int threads = 1; threads <= 3; threads++) {
            compiled c = run_compiled(count, outputs, &settings, threads, &data);
            assert_same_bits(&one, &c);
            compiled_execute(&c, outputs, &data); /* run twice */
            assert_same_bits(&one, &c);
            compiled_free(&c);
        }
        compiled_free(&one);
        data_free(&data);
        ad_tape_free(g.tape);
    }
}

static void test_tiles_agree_to_rounding(void **state)
{
    (void)state;
    garden g;
    garden_plant(&g, 4242, 60, true);
    ad_value outputs[OUTPUTS];
    int count = garden_outputs(&g, outputs);
    run_data data;
    data_fill(&data, g.tape, 700, -1, 1, &g.random);
    naive n = naive_run(g.tape, &data);
    for (int tile = 8; tile <= 1000; tile = 2 * tile + 1) {
        ad_settings settings = {.tile = tile, .piece = 256, .fuse = true};
        compiled c = run_compiled(count, outputs, &settings, 2, &data);
        assert_near(compiled_error(&c, outputs, &n), 0, ROUNDING);
        compiled_free(&c);
    }
    naive_free(&n);
    data_free(&data);
    ad_tape_free(g.tape);
}

/* ---- special programs --------------------------------------------------------------------------
 */

static void check_values(ad_tape *tape, int count, const ad_value *values, size_t points)
{
    uint64_t random = 9;
    run_data data;
    assert_tape_ok(tape);
    data_fill(&data, tape, points, 0.5, 1.5, &random);
    naive n = naive_run(tape, &data);
    for (int fuse = 0; fuse < 2; fuse++) {
        ad_settings settings = {.tile = 16, .piece = 64, .fuse = fuse};
        compiled c = run_compiled(count, values, &settings, 2, &data);
        assert_near(compiled_error(&c, values, &n), 0, ROUNDING);
        compiled_free(&c);
    }
    naive_free(&n);
    data_free(&data);
}

/* x normalised by mean and variance of all points, then the gradient of the log of a sum. */
static void test_several_passes(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 3), p = ad_parameter(tape, "p", 3, 0);
    ad_value count = ad_points(tape), y = ad_mul(x, p);
    ad_value mean = ad_div(ad_sum_points(y), count);
    ad_value off = ad_sub(y, mean);
    ad_value variance = ad_div(ad_sum_points(ad_square(off)), count);
    ad_value normal = ad_mul(off, ad_power(ad_add(variance, ad_scalar(tape, 0.1)), -0.5));
    ad_value third = ad_sum_points(ad_exp(ad_scale(ad_dot(normal, normal), 0.1)));
    ad_value loss = ad_log(third), gradient[2];
    assert_int_equal(ad_reverse(loss, 1, &p, AD_SUMMED, gradient), AD_OK);
    ad_value weighted = ad_mul(ad_row(normal, 1), gradient[0]); /* batch again, after the sums */
    ad_value values[] = {normal, loss, gradient[0], weighted, x, off};
    check_values(tape, 6, values, 75);
    ad_settings settings = ad_settings_default();
    compiled c = compile_values(1, &normal, &settings, 1);
    assert_int_equal(ad_program_inspect(c.program).passes, 3); /* mean; variance; result */
    compiled_free(&c);
    ad_tape_free(tape);
}

/* Sums that meet in one addition are one sum, but only within a pass and without other users. */
static void test_sums_of_sums(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 2), y = ad_input(tape, "y", 3);
    ad_value early = ad_sum_points(ad_sin(x)), middle = ad_sum_points(ad_cos(x));
    ad_value late = ad_sum_points(ad_mul(ad_tanh(x), ad_add(early, middle)));
    ad_value plain = ad_sum_points(ad_exp(x)), user = ad_sum_points(ad_square(x));
    ad_value outer = ad_add(ad_sum_points(ad_outer(x, y)), ad_sum_points(ad_outer(ad_sin(x), y)));
    ad_value values[] = {ad_add(plain, late),
                         ad_add(ad_add(early, user), ad_sum_points(ad_log(x))),
                         user,
                         outer,
                         ad_add(outer, ad_sum_points(ad_stack(2, (ad_value[]){y, y}))),
                         ad_add(ad_sum_points(ad_row(x, 0)), ad_sum_points(y))};
    check_values(tape, 6, values, 75);
    check_values(tape, 1, values, 75);
    ad_tape_free(tape);
}

static void test_inputs_and_views_as_outputs(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 4), unused = ad_input(tape, "unused", 2);
    ad_value middle = ad_slice(x, 1, 2), values[3] = {x, middle, x};
    check_values(tape, 1, &x, 20);
    check_values(tape, 1, &middle, 20);
    check_values(tape, 3, values, 20);
    ad_value two[2] = {ad_stack(2, (ad_value[]){unused, x}), ad_stack(2, (ad_value[]){x, x})};
    check_values(tape, 2, two, 20);
    ad_tape_free(tape);
}

static void test_uniform_programs(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value w = ad_parameter(tape, "w", 12, 5), u = ad_uniform(tape, "u", 3);
    ad_value y = ad_matvec(w, ad_tanh(u)), z = ad_matvec_transposed(w, ad_sin(y));
    ad_value gradient, loss = ad_dot(z, z);
    assert_int_equal(ad_reverse(loss, 1, &w, AD_SUMMED, &gradient), AD_OK);
    ad_value values[] = {y,
                         z,
                         loss,
                         gradient,
                         w,
                         u,
                         ad_slice(w, 3, 4),
                         ad_points(tape),
                         ad_pad(u, 1, 6),
                         ad_scalar(tape, 3),
                         ad_outer(u, y),
                         ad_stack(2, (ad_value[]){ad_slice(w, 1, 2), u})};
    check_values(tape, 12, values, 20);
    check_values(tape, 12, values, 0);
    ad_settings settings = ad_settings_default();
    compiled c = compile_values(3, values, &settings, 1);
    assert_int_equal(ad_program_inspect(c.program).passes, 0);
    compiled_free(&c);
    ad_tape_free(tape);
}

static void test_outputs_not_wanted(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 1), y = ad_sin(x), sum = ad_sum_points(y);
    ad_value values[2] = {y, sum};
    compiled c = compile_values(2, values, NULL, 1);
    double points[3] = {1, 2, 3}, result = 0;
    const double *inputs[] = {points};
    double *outputs[] = {NULL, &result};
    ad_run run = {.points = 3, .inputs = inputs, .outputs = outputs};
    assert_int_equal(ad_execute(c.program, &run, NULL), AD_OK);
    assert_near(result, sin(1) + sin(2) + sin(3), 1e-15); /* 4 units in the last place of 1 */
    compiled_free(&c);
    ad_tape_free(tape);
}

/* A constant as the sum over points: no batch value at all, but the number of points. */
static void test_sum_of_constants(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 1);
    ad_value slope = ad_derivative(ad_scale(x, 3), x, 1);
    ad_value values[2] = {ad_sum_points(slope), ad_sum_points(ad_add(x, slope))};
    check_values(tape, 2, values, 20);
    run_data data;
    uint64_t random = 1;
    data_fill(&data, tape, 20, 0, 1, &random);
    assert_near(compiled_number(values[0], &data), 60, 0);
    data_free(&data);
    ad_tape_free(tape);
}

/* Rows that no int counts are refused with a sentence, not computed modulo 2^32. */
static void test_too_many_rows(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 1), u = ad_uniform(tape, "u", 1), outputs[4];
    for (int i = 0; i < 4; i++) {
        ad_value source = ad_add(i % 2 ? u : x, ad_scalar(tape, i));
        outputs[i] = ad_tanh(ad_repeat(source, i % 2 ? 1 << 29 : 1 << 24));
    }
    static const struct {
        int first, count;
    } sets[] = {{0, 3}, {1, 3}};
    ad_pool *pool = ad_pool_create(1);
    ad_program *program;
    ad_error error;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(
            ad_compile(sets[i].count, outputs + sets[i].first, NULL, pool, &program, &error),
            AD_BAD_SHAPE);
        assert_null(program);
        assert_non_null(strstr(error.message, "rows per point"));
    }
    ad_settings settings = {.tile = 1 << 20, .piece = 256};
    assert_int_equal(ad_compile(1, &x, &settings, pool, &program, &error), AD_BAD_ARGUMENT);
    ad_pool_free(pool);
    ad_tape_free(tape);
}

/* Values are the same whether a program is kept or not; what is uniform is at every point if that
 * is wanted, and once if not. */
static void test_once(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "x", 1);
    const ad_value outputs[3] = {ad_constant(tape, 2, (double[]){4, 5}), ad_square(x),
                                 ad_sum_points(x)};
    const double at[3] = {1, 2, 3}, *inputs[1] = {at};
    double same[6] = {0}, square[3], sum[3] = {0};
    ad_run run = {.points = 3, .inputs = inputs, .outputs = (double *[]){same, square, sum}};
    ad_error error;
    assert_int_equal(ad_evaluate(3, outputs, NULL, &run, &error), AD_OK);
    assert_memory_equal(same, ((double[]){4, 5, 0, 0, 0, 0}), sizeof same);
    assert_memory_equal(square, ((double[]){1, 4, 9}), sizeof square);
    assert_memory_equal(sum, ((double[]){6, 0, 0}), sizeof sum);
    ad_pool *pool = ad_pool_create(2);
    run.everywhere = true;
    assert_int_equal(ad_evaluate(3, outputs, pool, &run, &error), AD_OK);
    assert_memory_equal(same, ((double[]){4, 4, 4, 5, 5, 5}), sizeof same);
    assert_memory_equal(square, ((double[]){1, 4, 9}), sizeof square);
    assert_memory_equal(sum, ((double[]){6, 6, 6}), sizeof sum);
    ad_pool_free(pool);
    const ad_value wrong = ad_add(outputs[0], ad_zeros(tape, 3));
    assert_int_equal(ad_evaluate(1, &wrong, NULL, &run, &error), AD_BAD_SHAPE);
    ad_tape_free(tape);
}

static char *printed(const ad_program *program)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    assert_non_null(file);
    ad_program_print(program, file);
    assert_int_equal(fclose(file), 0);
    return text;
}

/* What a printed tape and program say, whatever their layout. */
static void test_print(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value x = ad_input(tape, "place", 2), load = ad_uniform(tape, "load", 1), outputs[2];
    ad_value w = ad_parameter(tape, "weights", 6, 10);
    outputs[0] = ad_sum_points(ad_mul(load, ad_sum_rows(ad_tanh(ad_matvec(w, x)))));
    ad_reverse(outputs[0], 1, &w, AD_SUMMED, &outputs[1]);
    compiled c = compile_values(2, outputs, NULL, 1);
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    assert_non_null(file);
    ad_tape_print(tape, file);
    ad_program_print(c.program, file);
    assert_int_equal(fclose(file), 0);
    static const char *const expected[] = {
        "input \"place\"",
        "uniform \"load\"",
        "parameter \"weights\" from 10 on",
        "matvec \"weights\" \"place\"\n",
        "matvec \"weights\" \"place\"@0; 3 x 2 times 1 column, 12 flops",
        "outer_sum",
        "3 rows, ",
        "2 matrix products per tile, 24 flops per point; 7 sums",
        "output 1: %"};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        if (!strstr(text, expected[i])) {
            fail_msg("\"%s\" is missing in:\n%s", expected[i], text);
        }
    }
    free(text);
    compiled_free(&c);
    ad_tape_free(tape);
}

/* More products of one matrix than a panel has columns, 33: 32 of their vectors stand side by side,
 * one by itself. */
static void test_many_alike(void **state)
{
    (void)state;
    enum { ALIKE = 33 };
    ad_tape *tape = ad_tape_create();
    ad_value w = ad_parameter(tape, "weights", 6, 0), sum = ad_scalar(tape, 0), outputs[2];
    for (int i = 0; i < ALIKE; i++) {
        ad_value x = ad_input(tape, "x", 2);
        sum = ad_add(sum, ad_sum_rows(ad_tanh(ad_matvec(w, ad_sin(x)))));
    }
    outputs[0] = ad_sum_points(sum);
    assert_int_equal(ad_reverse(outputs[0], 1, &w, AD_SUMMED, &outputs[1]), AD_OK);
    compiled c = compile_values(2, outputs, NULL, 1);
    char *text = printed(c.program);
    int aside = 0, alone = 0;
    for (char *rest = text, *line; (line = strtok_r(rest, "\n", &rest));) {
        int number, value, at, stride;
        if (strstr(line, " sin \"x\"")) {
            bool strided = sscanf(line, "%d %%%d@%d/%d", &number, &value, &at, &stride) == 4;
            aside += strided;
            alone += !strided;
        }
    }
    assert_int_equal(aside, 32);
    assert_int_equal(alone, 1);
    free(text);
    compiled_free(&c);
    ad_tape_free(tape);
}

/* Of values that stand side by side a row is as far from the next as there are columns. */
static void test_print_strides(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value w = ad_parameter(tape, "w", 6, 0), x[2], y[2];
    for (int i = 0; i < 2; i++) {
        x[i] = ad_sin(ad_input(tape, i == 0 ? "x" : "y", 2));
        y[i] = ad_matvec(w, x[i]);
    }
    for (int i = 0; i < 2; i++) {
        y[i] = ad_slice(y[i], 2, 1);
    }
    ad_value both = ad_mul(x[0], ad_add(y[0], y[1]));
    compiled c = compile_values(1, &both, NULL, 1);
    char *text = printed(c.program);
    static const char *const expected[] = {
        "%2@4/2                  sin \"x\"@0\n", "%5@5/2                  sin \"y\"@2\n",
        " 24 flops per point\n", "add %3@12 %3@13\n", "mul %2@4 %9@0"};
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        if (!strstr(text, expected[i])) {
            fail_msg("\"%s\" is missing in:\n%s", expected[i], text);
        }
    }
    free(text);
    compiled_free(&c);
    ad_tape_free(tape);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_graphs),
        cmocka_unit_test(test_number_of_points),
        cmocka_unit_test(test_threads_give_the_same_bits),
        cmocka_unit_test(test_tiles_agree_to_rounding),
        cmocka_unit_test(test_several_passes),
        cmocka_unit_test(test_sums_of_sums),
        cmocka_unit_test(test_inputs_and_views_as_outputs),
        cmocka_unit_test(test_uniform_programs),
        cmocka_unit_test(test_outputs_not_wanted),
        cmocka_unit_test(test_sum_of_constants),
        cmocka_unit_test(test_too_many_rows),
        cmocka_unit_test(test_once),
        cmocka_unit_test(test_print),
        cmocka_unit_test(test_print_strides),
        cmocka_unit_test(test_many_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
