/* Values of members of a family: against a naive interpreter, against the same recorded per point,
 * for any cut of the points; algebra, hoisting, machine code, C. */
#include "fewer.h"
#include "members_testing.h"

#include "random_graphs.h"

#include "autodiff/compile/program.h"

#include <dlfcn.h>
#include <stdio.h>
#include <unistd.h>

/* ---- random graphs -----------------------------------------------------------------------------
 */

static void assert_same_bits(const compiled *a, const compiled *b, uint64_t seed)
{
    for (int i = 0; i < a->count; i++)
        if (memcmp(a->results[i], b->results[i], a->sizes[i] * sizeof(double)) != 0)
            fail_msg("graph %llu, output %d: other bits", (unsigned long long)seed, i);
}

/* What occurs in programs: else it would not be tested. */
typedef struct occurrence {
    int passes, spread, loaded, matrix, sum, outer, shares;
} occurrence;

static void note(const ad_program *program, shape s, occurrence *o)
{
    for (int k = 0; k < program->pass_count; k++) {
        const pass *p = &program->passes[k];
        o->passes += p->members;
        o->shares += p->summed > 0 && s.each > (size_t)program->tile;
        for (int n = 0; n < p->count; n++) {
            const instruction *i = &p->instructions[n];
            o->spread += i->op == OP_SPREAD && !p->members;
            o->loaded += i->op == OP_SPREAD && p->members;
            o->matrix += i->op != OP_SPREAD && i->in[0].kind == PLACE_MEMBER;
            o->sum += i->op == OP_SUM_POINTS && i->out.kind == PLACE_MEMBER;
            o->outer += i->op == OP_OUTER_SUM && i->out.kind == PLACE_MEMBER;
        }
    }
}

static void check_naive(uint64_t seed, int operations, garden_kind kind, occurrence *o)
{
    shape s = shapes[seed % SHAPES];
    garden g;
    garden_plant_members(&g, seed, operations, seed % 3 == 0, kind);
    ad_value outputs[OUTPUTS];
    int count = garden_outputs(&g, outputs);
    run_data data;
    data_fill_members(&data, g.tape, points_of(s), s.members, -1, 1, &g.random);
    naive n = naive_run(g.tape, &data);
    double pulled = naive_at(&n, outputs[count - 4].id, 0, 0);
    double pushed = naive_at(&n, outputs[count - 3].id, 0, 0);
    if (!(fabs(pulled - pushed) <= 1e-10 * (1 + fabs(pushed))))
        fail_msg("graph %llu: %.17g backwards, %.17g forwards", (unsigned long long)seed, pulled,
                 pushed);
    for (int fuse = 0; fuse < 2; fuse++) {
        ad_settings settings = {.tile = s.tile, .piece = 64, .fuse = fuse};
        compiled one = run_compiled(count, outputs, &settings, 1, &data);
        compiled two = run_compiled(count, outputs, &settings, 2, &data);
        double error = compiled_error(&one, outputs, &n);
        if (!(error <= ROUNDING))
            fail_msg("graph %llu of %d operations, fuse %d: off by %g", (unsigned long long)seed,
                     operations, fuse, error);
        assert_same_bits(&one, &two, seed);
        note(one.program, s, o);
        compiled_free(&one);
        compiled_free(&two);
    }
    naive_free(&n);
    data_free(&data);
    ad_tape_free(g.tape);
}

static void test_random_graphs(void **state)
{
    (void)state;
    occurrence o = {0};
    for (uint64_t seed = 1; seed <= 200; seed++)
        check_naive(seed, 6 + (int)(seed % 40), seed % 2 ? MEMBERS : MEMBERS_AND_SUMS, &o);
    print_message(
        "%d passes over members, %d values spread, %d loaded again, %d products, %d sums, "
        "%d of products, %d in shares\n",
        o.passes, o.spread, o.loaded, o.matrix, o.sum, o.outer, o.shares);
    assert_true(o.passes > 100 && o.spread > 100 && o.loaded > 100 && o.matrix > 10 &&
                o.sum > 100 && o.outer > 10 && o.shares > 10);
}

/* ---- the same per point ------------------------------------------------------------------------
 */

static void check_per_point(uint64_t seed, int operations)
{
    shape s = shapes[seed % SHAPES];
    garden g, twin;
    ad_value outputs[OUTPUTS], same[OUTPUTS];
    run_data data, wide;
    garden_plant_members(&g, seed, operations, seed % 4 == 0, MEMBERS);
    garden_plant_members(&twin, seed, operations, seed % 4 == 0, MEMBERS_PER_POINT);
    int count = garden_outputs(&g, outputs);
    assert_int_equal(garden_outputs(&twin, same), count);
    data_fill_members(&data, g.tape, points_of(s), s.members, -1, 1, &g.random);
    data_fill(&wide, twin.tape, points_of(s), -1, 1, &g.random);
    repeat_inputs(&wide, &data, g.tape);
    ad_settings settings = {.tile = s.tile, .piece = 128, .fuse = true};
    compiled a = run_compiled(count, outputs, &settings, 1, &data);
    compiled b = run_compiled(count, same, &settings, 1, &wide);
    for (int i = 0; i < count; i++) {
        ad_extent extent = ad_extent_of(outputs[i]), other = ad_extent_of(same[i]);
        double off = difference(&a, &b, i, extent, other, i >= count - 2, &data);
        if (!(off <= 20 * ROUNDING))
            fail_msg("graph %llu, output %d: off by %g", (unsigned long long)seed, i, off);
    }
    compiled_free(&a);
    compiled_free(&b);
    data_free(&data);
    data_free(&wide);
    ad_tape_free(g.tape);
    ad_tape_free(twin.tape);
}

static void test_same_as_per_point(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 200; seed++)
        check_per_point(seed, 6 + (int)(seed % 40));
}

/* ---- algebra and errors ------------------------------------------------------------------------
 */

static void test_extents(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value m = ad_input_member(tape, "m", 1), x = ad_input(tape, "x", 3);
    ad_value p = ad_parameter(tape, "p", 9, 0), u = ad_uniform(tape, "u", 1);
    ad_value load = ad_vector(ad_scalar(tape, 0), ad_scalar(tape, 0), m);
    assert_int_equal(ad_extent_of(ad_matvec(p, load)), AD_MEMBER);
    assert_int_equal(ad_extent_of(ad_mul(m, u)), AD_MEMBER);
    assert_int_equal(ad_extent_of(ad_add(load, x)), AD_BATCH);
    assert_int_equal(ad_extent_of(ad_tanh(ad_row(ad_stack(2, (ad_value[]){x, m}), 3))), AD_MEMBER);
    assert_true(
        ad_is_constant(ad_row(ad_mul(load, x), 1), 0)); /* zeros within a value of members */
    assert_int_equal(ad_extent_of(ad_sum_points_of_member(x)), AD_MEMBER);
    assert_int_equal(ad_extent_of(ad_sum_members(m)), AD_UNIFORM);
    assert_int_equal(ad_extent_of(ad_sum_points(m)), AD_UNIFORM);
    ad_value same = ad_mul(m, ad_sum_points_of_member(ad_row(x, 0)));
    assert_int_equal(ad_sum_points_of_member(ad_mul(m, ad_row(x, 0))).id, same.id);
    assert_int_equal(ad_sum_points_of_member(u).id, ad_mul(u, ad_points_of_member(tape)).id);
    assert_int_equal(ad_sum_members(u).id, ad_mul(u, ad_members(tape)).id);
    assert_tape_ok(tape);
    assert_false(ad_is_valid(ad_sum_members(x)));
    assert_int_equal(ad_tape_status(tape, NULL), AD_BAD_SHAPE);
    ad_tape_free(tape);
}

/* No points at all: members are computed, sums are 0. Uneven members are refused. */
static void test_numbers_of_points(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_value m = ad_input_member(tape, "m", 1), x = ad_input(tape, "x", 1), outputs[3];
    outputs[0] = ad_scale(m, 2);
    outputs[1] = ad_add(m, ad_sum_points_of_member(ad_mul(m, ad_sin(x))));
    outputs[2] = ad_add(ad_sum_members(m), ad_sum_points(ad_add(ad_sin(x), m)));
    compiled c = compile_values(3, outputs, NULL, 2);
    run_data data;
    uint64_t random = 9;
    static const size_t sizes[][2] = {{0, 5}, {0, 0}, {1, 0}, {1, 1}, {400, 4}, {5, 5}, {0, 5}};
    for (int k = 0; k < (int)(sizeof sizes / sizeof *sizes); k++) {
        data_fill_members(&data, tape, sizes[k][0], sizes[k][1], -1, 1, &random);
        compiled_execute(&c, outputs, &data);
        naive n = naive_run(tape, &data);
        assert_true(compiled_error(&c, outputs, &n) < ROUNDING);
        naive_free(&n);
        data_free(&data);
    }
    ad_error error = {AD_OK, ""};
    ad_run run = {.points = 7, .members = 2};
    assert_int_equal(ad_execute(c.program, &run, &error), AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "7 points of 2 members"));
    compiled_free(&c);
    ad_tape_free(tape);
}

/* What a printed tape and program say of members. */
static void test_print(void **state)
{
    (void)state;
    static const char *const expected[] = {"3 of member  input \"m\"", "of each member",
                                           "over members\n",           "kept of members, row 3",
                                           " of members sum_points",   "flops per member, "};
    ad_tape *tape = ad_tape_create();
    ad_value m = ad_input_member(tape, "m", 3), x = ad_input(tape, "x", 3);
    ad_value w = ad_parameter(tape, "w", 9, 0), c = ad_matvec(w, m), outputs[2];
    outputs[0] = ad_sum_points(ad_square(ad_dot(ad_tanh(x), c)));
    ad_reverse(outputs[0], 1, &w, AD_SUMMED, &outputs[1]);
    compiled compiled_outputs = compile_values(2, outputs, NULL, 1);
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    assert_non_null(file);
    ad_tape_print(tape, file);
    ad_program_print(compiled_outputs.program, file);
    assert_int_equal(fclose(file), 0);
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++)
        if (!strstr(text, expected[i]))
            fail_msg("\"%s\" is missing in:\n%s", expected[i], text);
    free(text);
    compiled_free(&compiled_outputs);
    ad_tape_free(tape);
}

/* What depends on inputs of members alone is taken out once, as values of members. */
static void test_hoist(void **state)
{
    (void)state;
    enum { FIXED_MAX = 4 };
    ad_tape *tape = ad_tape_create();
    ad_value m = ad_input_member(tape, "m", 1), x = ad_input(tape, "x", 1);
    ad_value p = ad_parameter(tape, "p", 1, 0), fixed[FIXED_MAX];
    ad_value heavy = ad_exp(ad_sin(m)), y = ad_mul(ad_tanh(ad_mul(p, x)), heavy);
    ad_value outputs[2] = {ad_sum_points(ad_square(y)), heavy};
    run_data data;
    uint64_t random = 2;
    data_fill_members(&data, tape, 60, 5, -1, 1, &random);
    compiled before = run_compiled(1, outputs, NULL, 1, &data);
    int count;
    assert_int_equal(ad_precompute(1, outputs, 0, NULL, 4, FIXED_MAX, fixed, &count), AD_OK);
    assert_int_equal(count, 1);
    assert_int_equal(ad_extent_of(fixed[0]), AD_MEMBER);
    compiled once = run_compiled(1, fixed, NULL, 1, &data);
    data.input[data.inputs++] = once.results[0];
    compiled after = run_compiled(1, outputs, NULL, 1, &data);
    assert_near(after.results[0][0], before.results[0][0], 1e-13);
    data.inputs--;
    compiled_free(&before);
    compiled_free(&once);
    compiled_free(&after);
    data_free(&data);
    ad_tape_free(tape);
}

/* ---- machine code ------------------------------------------------------------------------------
 */

/* Groups of machine code in passes over members, or over points. */
static int count_fused(const ad_program *program, bool members)
{
    int count = 0;
    for (int k = 0; k < program->pass_count; k++)
        for (int n = 0; n < program->passes[k].group_count; n++)
            count += program->passes[k].members == members &&
                     program->passes[k].groups[n].fused_count > 0;
    return count;
}

static void test_groups_give_the_same_bits(void **state)
{
    (void)state;
    char folder[] = "/tmp/cpinn_test_XXXXXX", command[64];
    int of_members = 0, of_points = 0;
    if (system("cc --version > /dev/null 2>&1") != 0)
        skip();
    assert_non_null(mkdtemp(folder));
    for (uint64_t seed = 30; seed < 32; seed++) {
        shape s = shapes[seed % SHAPES];
        garden g;
        ad_value outputs[OUTPUTS];
        run_data data;
        ad_fuse_state is = AD_INTERPRETED;
        ad_error error = {AD_OK, ""};
        garden_plant_members(&g, seed, 40, true, MEMBERS_AND_SUMS);
        int count = garden_outputs(&g, outputs);
        data_fill_members(&data, g.tape, points_of(s), s.members, -1, 1, &g.random);
        compiled before = run_compiled(count, outputs, NULL, 1, &data);
        compiled after = compile_values(count, outputs, NULL, 1);
        assert_int_equal(
            ad_fuse_begin(after.program, data.points, data.members, folder, true, &error), AD_OK);
        assert_int_equal(ad_fuse_finish(after.program, true, &is, &error), AD_OK);
        assert_int_equal(is, AD_FUSED);
        compiled_execute(&after, outputs, &data);
        assert_same_bits(&before, &after, seed);
        of_members += count_fused(after.program, true);
        of_points += count_fused(after.program, false);
        compiled_free(&before);
        compiled_free(&after);
        data_free(&data);
        ad_tape_free(g.tape);
    }
    assert_true(of_members > 0 && of_points > 0);
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

typedef void written(const double *x, const double *const *uniforms, const double *parameters,
                     double *y, double *w);

static void call_written(written *function, size_t memory, const ad_tape *tape, run_data *data,
                         compiled *c)
{
    enum { NUMBERS = 1 << 16 };
    double *x = new_numbers(NUMBERS), *y = new_numbers(NUMBERS), *w = new_numbers(memory);
    size_t at = 0;
    for (int i = 0; i < tape->inputs; i++) {
        size_t each = tape->input_extent[i] == AD_BATCH ? data->points : 1;
        size_t count = (size_t)tape->input_rows[i] * each;
        assert_true(at + count <= NUMBERS);
        memcpy(x + at, data->input[i], count * sizeof *x);
        at += count;
    }
    function(x, (const double *const *)data->uniform, data->parameters, y, w);
    at = 0;
    for (int i = 0; i < c->count; i++) {
        assert_true(at + c->sizes[i] <= NUMBERS);
        memcpy(c->results[i], y + at, c->sizes[i] * sizeof *y);
        at += c->sizes[i];
    }
    free(x);
    free(y);
    free(w);
}

/* Whole programs for the points of one member. */
static void test_written_for_one_member(void **state)
{
    (void)state;
    enum { SEEDS = 4 };
    static const size_t points[] = {1, 13, 64};
    static const char *const names[SEEDS] = {"run_0", "run_1", "run_2", "run_3"};
    char folder[] = "/tmp/cpinn_test_XXXXXX", path[64], command[256];
    ad_c_options options[SEEDS];
    ad_program *programs[SEEDS];
    size_t memory;
    compiled c[SEEDS];
    run_data data[SEEDS];
    ad_value outputs[SEEDS][OUTPUTS];
    garden g[SEEDS];
    if (system("cc --version > /dev/null 2>&1") != 0)
        skip();
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/x.c", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int k = 0; k < SEEDS; k++) {
        garden_plant_members(&g[k], 50 + (uint64_t)k, 40, true, k % 2 ? MEMBERS : MEMBERS_AND_SUMS);
        int count = garden_outputs(&g[k], outputs[k]);
        data_fill_members(&data[k], g[k].tape, points[k % 3], 1, -1, 1, &g[k].random);
        c[k] = run_compiled(count, outputs[k], NULL, 1, &data[k]);
        options[k] = (ad_c_options){.name = names[k], .points = data[k].points};
        programs[k] = c[k].program;
    }
    assert_int_equal(ad_write_c(SEEDS, programs, options, false, file, &memory, NULL), AD_OK);
    assert_int_equal(fclose(file), 0);
    snprintf(command, sizeof command,
             "cc -O0 -std=c99 -Wall -Wextra -Wpedantic -Werror -fPIC -shared "
             "-o %s/x.so %s -lm",
             folder, path);
    assert_int_equal(system(command), 0);
    snprintf(path, sizeof path, "%s/x.so", folder);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    assert_non_null(library);
    for (int k = 0; k < SEEDS; k++) {
        naive n = naive_run(g[k].tape, &data[k]);
        void *found = dlsym(library, names[k]);
        written *function;
        assert_non_null(found);
        memcpy(&function, &found, sizeof found);
        call_written(function, memory, g[k].tape, &data[k], &c[k]);
        assert_true(compiled_error(&c[k], outputs[k], &n) <= ROUNDING);
        naive_free(&n);
        compiled_free(&c[k]);
        data_free(&data[k]);
        ad_tape_free(g[k].tape);
    }
    dlclose(library);
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_graphs),
        cmocka_unit_test(test_extents),
        cmocka_unit_test(test_numbers_of_points),
        cmocka_unit_test(test_print),
        cmocka_unit_test(test_hoist),
        cmocka_unit_test(test_written_for_one_member),
    };
    const struct CMUnitTest alike[] = {cmocka_unit_test(test_groups_give_the_same_bits),
                                       cmocka_unit_test(test_same_as_per_point)};
    return run_with_alike(tests, alike, NULL, NULL);
}
