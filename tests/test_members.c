/* Values of members of a family: against a naive interpreter, against the same recorded per point,
 * derivatives in any order, any cut of the points, and what is saved. */
#include "random_graphs.h"

#include "autodiff/program.h"

#include <dlfcn.h>
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
static const shape shapes[] = {{1, 40, 32}, {40, 1, 16},  {7, 5, 0},  {3, 33, 8},
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
    print_message(
        "%d passes over members, %d values spread, %d loaded again, %d products, %d sums, "
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
        double off =
            difference(&a, &b, i, extent, other, i >= count - 2 && extent == AD_MEMBER, &data);
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

/* J^T J, J^T r, r^T r through a member's coefficients against those of rows taken per point. */
static void check_normal(shape s, bool also_members)
{
    enum { WIDTH = 4, INPUTS = 3, COUNT = INPUTS * WIDTH + WIDTH + 5 * WIDTH };
    double jtj[2][COUNT * COUNT] = {{0}}, jtr[2][COUNT] = {{0}}, rtr[2] = {0}, scale = 0;
    for (int k = 0; k < 2; k++) {
        ad_tape *tape = ad_tape_create();
        ad_value p = (k ? ad_input : ad_input_member)(tape, "p", INPUTS);
        ad_value x = ad_input(tape, "s", 1);
        ad_value w[3] = {ad_parameter(tape, "w", WIDTH * INPUTS, 0),
                         ad_parameter(tape, "b", WIDTH, INPUTS * WIDTH),
                         ad_parameter(tape, "v", 5 * WIDTH, INPUTS * WIDTH + WIDTH)};
        ad_value c = ad_matvec(w[2], ad_tanh(ad_add(ad_matvec(w[0], p), w[1])));
        ad_value modes = ad_stack(2, (ad_value[]){x, ad_sin(x)});
        ad_value u = ad_matvec(ad_slice(c, 0, 4), modes), r[3];
        r[0] = ad_add(ad_mul(ad_row(p, 0), ad_derivative(u, x, 1)), ad_square(u));
        r[1] = ad_sub(ad_mul(ad_row(c, 4), ad_row(u, 1)), x);
        r[2] = ad_sub(ad_row(c, 4), ad_square(ad_row(p, 1)));
        run_data data, wide;
        uint64_t random = 4;
        data_fill_members(&data, tape, points_of(s), s.members, -1, 1, &random);
        if (k == 1) { /* the same numbers, repeated */
            ad_tape *members = ad_tape_create();
            ad_input_member(members, "p", INPUTS);
            ad_input(members, "s", 1);
            wide = data;
            random = 4;
            data_fill_members(&data, members, points_of(s), s.members, -1, 1, &random);
            repeat_inputs(&wide, &data, members);
            data_free(&data);
            data = wide;
            ad_tape_free(members);
        }
        ad_error error = {AD_OK, ""};
        ad_run run = {.points = data.points,
                      .members = s.members,
                      .inputs = (const double *const *)data.input,
                      .parameters = data.parameters};
        for (int threads = 1; threads <= 2 - k; threads++) {
            double first = jtj[k][1] + jtr[k][0];
            ad_pool *pool = ad_pool_create(threads);
            ad_normal *normal = NULL;
            ad_member_normal *through = NULL;
            int count = also_members ? 3 : 2;
            memset(jtj[k], 0, sizeof jtj[k]);
            memset(jtr[k], 0, sizeof jtr[k]);
            rtr[k] = 0;
            ad_status status =
                k ? ad_normal_compile(count, r, 3, w, COUNT, pool, &normal, &error)
                  : ad_member_normal_compile(count, r, 3, w, COUNT, pool, &through, &error);
            if (status != AD_OK)
                fail_msg("%s", error.message);
            status = k ? ad_normal_add(normal, &run, jtj[k], jtr[k], &rtr[k], &error)
                       : ad_member_normal_add(through, &run, jtj[k], jtr[k], &rtr[k], &error);
            assert_int_equal(status, AD_OK);
            assert_true(threads == 1 || first == jtj[k][1] + jtr[k][0]);
            ad_normal_free(normal);
            ad_member_normal_free(through);
            ad_pool_free(pool);
        }
        data_free(&data);
        ad_tape_free(tape);
    }
    for (int i = 0; i < COUNT; i++)
        scale = fmax(scale, jtj[1][i * COUNT + i]);
    for (int i = 0; i < COUNT; i++) {
        for (int k = i; k < COUNT; k++)
            assert_near(jtj[0][i * COUNT + k], jtj[1][i * COUNT + k], 1e-11 * scale);
        assert_near(jtr[0][i], jtr[1][i], 1e-11 * sqrt(scale * rtr[1]));
    }
    assert_near(rtr[0], rtr[1], 1e-11 * rtr[1]);
    assert_true(scale > 0.1);
}

static void test_normal_equations(void **state)
{
    (void)state;
    for (int i = 0; i < (int)SHAPES; i++) /* also with fewer residuals than coefficients */
        check_normal(shapes[i], i % 2);
    ad_tape *tape = ad_tape_create();
    ad_value m = ad_input_member(tape, "m", 1), x = ad_input(tape, "x", 1);
    ad_value p = ad_parameter(tape, "p", 1, 0), r = ad_mul(ad_mul(p, x), ad_tanh(ad_mul(p, m)));
    ad_pool *pool = ad_pool_create(1);
    ad_member_normal *normal;
    ad_error error = {AD_OK, ""};
    assert_int_equal(ad_member_normal_compile(1, &r, 1, &p, 1, pool, &normal, &error),
                     AD_BAD_ARGUMENT);
    assert_non_null(strstr(error.message, "through values of members alone"));
    ad_pool_free(pool);
    ad_tape_free(tape);
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
    assert_int_equal(ad_hoist(1, outputs, 0, NULL, 4, FIXED_MAX, fixed, &count), AD_OK);
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

static void test_groups_give_the_same_bits(void **state)
{
    (void)state;
    char folder[] = "/tmp/cpinn_test_XXXXXX", command[64];
    if (system("cc --version > /dev/null 2>&1") != 0)
        skip();
    assert_non_null(mkdtemp(folder));
    for (uint64_t seed = 30; seed < 32; seed++) {
        shape s = shapes[seed % SHAPES];
        garden g;
        ad_value outputs[OUTPUTS];
        run_data data;
        bool fused = false;
        ad_error error = {AD_OK, ""};
        garden_plant_members(&g, seed, 40, true, MEMBERS_AND_SUMS);
        int count = garden_outputs(&g, outputs);
        data_fill_members(&data, g.tape, points_of(s), s.members, -1, 1, &g.random);
        compiled before = run_compiled(count, outputs, NULL, 1, &data);
        compiled after = compile_values(count, outputs, NULL, 1);
        assert_int_equal(ad_fuse_begin(after.program, data.points, data.members, folder, &error),
                         AD_OK);
        assert_int_equal(ad_fuse_finish(after.program, true, &fused, &error), AD_OK);
        assert_true(fused);
        compiled_execute(&after, outputs, &data);
        assert_same_bits(&before, &after, seed);
        compiled_free(&before);
        compiled_free(&after);
        data_free(&data);
        ad_tape_free(g.tape);
    }
    snprintf(command, sizeof command, "rm -r %s", folder);
    assert_int_equal(system(command), 0);
}

typedef void written(const double *const *inputs, const double *const *uniforms,
                     const double *parameters, double *const *outputs);

/* Whole programs for the points of one member. */
static void test_written_for_one_member(void **state)
{
    (void)state;
    enum { SEEDS = 4 };
    static const size_t points[] = {1, 13, 64};
    char folder[] = "/tmp/cpinn_test_XXXXXX", path[64], name[16], command[256];
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
        snprintf(name, sizeof name, "run_%d", k);
        ad_c_options options = {.name = name, .points = data[k].points};
        assert_int_equal(ad_write_c(c[k].program, &options, file, NULL), AD_OK);
    }
    assert_int_equal(fclose(file), 0);
    snprintf(command, sizeof command,
             "cc -O0 -std=c99 -Wall -Wextra -Wpedantic -Werror -Wno-unused-variable -fPIC -shared "
             "-o %s/x.so %s -lm", /* a row of a block may be read by nobody */
             folder, path);
    assert_int_equal(system(command), 0);
    snprintf(path, sizeof path, "%s/x.so", folder);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    assert_non_null(library);
    for (int k = 0; k < SEEDS; k++) {
        naive n = naive_run(g[k].tape, &data[k]);
        snprintf(name, sizeof name, "run_%d", k);
        void *found = dlsym(library, name);
        written *function;
        assert_non_null(found);
        memcpy(&function, &found, sizeof found);
        function((const double *const *)data[k].input, (const double *const *)data[k].uniform,
                 data[k].parameters, c[k].results);
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
        cmocka_unit_test(test_random_graphs),
        cmocka_unit_test(test_same_as_per_point),
        cmocka_unit_test(test_gradient),
        cmocka_unit_test(test_normal_product),
        cmocka_unit_test(test_normal_equations),
        cmocka_unit_test(test_rows_of_members),
        cmocka_unit_test(test_extents),
        cmocka_unit_test(test_numbers_of_points),
        cmocka_unit_test(test_hoist),
        cmocka_unit_test(test_groups_give_the_same_bits),
        cmocka_unit_test(test_written_for_one_member),
        cmocka_unit_test(test_saved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
