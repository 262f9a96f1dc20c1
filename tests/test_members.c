/* Values of members of a family: against a naive interpreter, against the same recorded per point,
 * derivatives in any order, any cut of the points, and what is saved. */
#include "random_graphs.h"

#include "autodiff/program.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

/* Products of up to 64 terms and a few hundred operations that do not amplify. */
#define ROUNDING 2e-12

typedef struct shape {
    size_t members, each;
    int tile;
} shape;

/* One member, one point of each, odd numbers, tiles smaller and larger than members. */
static const shape shapes[] = {{1, 40, 32}, {40, 1, 16}, {7, 5, 0},   {3, 33, 8},
                               {13, 7, 32}, {2, 100, 24}, {0, 17, 0}, {50, 8, 64}};

enum { SHAPES = sizeof shapes / sizeof *shapes };

static size_t points_of(shape s)
{
    return (s.members ? s.members : 1) * s.each;
}

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
    print_message("%d passes over members, %d values spread, %d loaded again, %d products, %d sums, "
                  "%d of products, %d in shares\n",
                  o.passes, o.spread, o.loaded, o.matrix, o.sum, o.outer, o.shares);
    assert_true(o.passes > 100 && o.spread > 100 && o.loaded > 100 && o.matrix > 10 &&
                o.sum > 100 && o.outer > 10 && o.shares > 10);
}

/* ---- the same per point ------------------------------------------------------------------------
 */

/* A member's block at each of its points. */
static void repeat_inputs(run_data *data, const run_data *members, const ad_tape *tape)
{
    size_t each = data->points / blocks_of(members, AD_MEMBER);
    for (int i = 0; i < data->inputs; i++) {
        bool of_member = tape->input_extent[i] == AD_MEMBER;
        size_t width = blocks_of(members, (ad_extent)tape->input_extent[i]);
        for (int row = 0; row < tape->input_rows[i]; row++)
            for (size_t j = 0; j < data->points; j++)
                data->input[i][(size_t)row * data->points + j] =
                    members->input[i][(size_t)row * width + (of_member ? j / each : j)];
    }
    for (int i = 0; i < data->uniforms; i++)
        memcpy(data->uniform[i], members->uniform[i],
               (size_t)tape->uniform_rows[i] * sizeof(double));
    memcpy(data->parameters, members->parameters, sizeof data->parameters);
}

/* Row by row; per point where either is: a sum over the points of a member where only one is to be
 * summed. */
static double difference(const compiled *a, const compiled *b, int i, ad_extent extent,
                         ad_extent other, bool sum, const run_data *data)
{
    size_t width = blocks_of(data, extent), wide = blocks_of(data, other);
    size_t each = wide / width, rows = a->sizes[i] / width;
    double worst = 0, scale = 1;
    for (size_t row = 0; row < rows; row++) {
        for (size_t k = 0; k < width; k++) {
            double expected = 0, value = a->results[i][row * width + k];
            for (size_t j = 0; j < each; j++) {
                double now = b->results[i][row * wide + k * each + j];
                expected = sum ? expected + now : now;
                worst = sum ? worst : fmax(worst, fabs(value - now));
            }
            worst = fmax(worst, fabs(value - expected));
            scale = fmax(scale, fabs(expected));
        }
    }
    return worst / scale;
}

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
        double off = difference(&a, &b, i, extent, other,
                                i >= count - 2 && extent == AD_MEMBER, &data);
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

/* ---- a family of rods ---------------------------------------------------------------------------
 */

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
    family f = make_family(ad_input_member), p = make_family(ad_input);
    run_data data, wide;
    uint64_t random = 3;
    data_fill_members(&data, f.tape, FAMILY * EACH, FAMILY, -0.3, 0.3, &random);
    data_fill(&wide, p.tape, FAMILY * EACH, -1, 1, &random);
    repeat_inputs(&wide, &data, f.tape);
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
    print_message("%zu flops per point and %zu per member, without members %zu per point: %.0f times "
                  "as fast, %.0f ns per point\n",
                  a.flops_per_point, a.flops_per_member, b.flops_per_point, slow / quick,
                  1e9 * quick / (FAMILY * EACH));
    assert_true(slow > 4 * quick); /* it is some 50 times; others may use the processor */
    compiled_free(&once);
    compiled_free(&often);
    data_free(&data);
    data_free(&wide);
    ad_tape_free(f.tape);
    ad_tape_free(p.tape);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_graphs),
        cmocka_unit_test(test_same_as_per_point),
        cmocka_unit_test(test_saved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
