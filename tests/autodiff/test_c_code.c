/* Programs written out as C: elementwise groups give the interpreter's bits, whole programs agree
 * with it to rounding, for every operation in every shape, for transforms, sums and random graphs.
 * Skipped (77) where there is no compiler. */
#include "random_graphs.h"

#include "autodiff/emit/c_code.h"
#include "kernel_sets.h"

#include <dlfcn.h>
#include <stdio.h>
#include <unistd.h>

/* Sums of up to some hundred terms in another order, functions of libm and of libmvec, a few
 * hundred operations that do not amplify; float: the same with 1e-7 for 2e-16. */
#define ROUNDING        2e-12
#define SINGLE_ROUNDING 1e-3

enum { SUBJECTS_MAX = 24, POINTS = 37, OPERANDS = 4 };

static const char strict[] = "cc -O0 -fPIC -shared -fno-math-errno -ffp-contract=off -Wall -Wextra "
                             "-Wpedantic -Wshadow -Wstrict-prototypes -Wmissing-prototypes -Werror";

typedef struct subject {
    ad_tape *tape;
    ad_value outputs[OUTPUTS];
    int count;
    bool sums; /* over points: cannot be taken point by point */
    run_data data;
    compiled c;
} subject;

static subject subjects[SUBJECTS_MAX];
static int subject_count;
static char folder[64];

static void run_command(const char *format, const char *options, const char *name)
{
    char command[1024];
    snprintf(command, sizeof command, format, strict, options, folder, name, folder, name);
    if (system(command) != 0)
        fail_msg("fails: %s", command);
}

/* ---- subjects -----------------------------------------------------------------------------------
 */

static void finish(subject *s, size_t points, double low, double high, const ad_settings *settings)
{
    uint64_t random = 11;
    assert_tape_ok(s->tape);
    data_fill(&s->data, s->tape, points, low, high, &random);
    s->c = run_compiled(s->count, s->outputs, settings, 1, &s->data);
}

static ad_value operand(ad_tape *tape, bool uniform, int rows)
{
    return uniform ? ad_uniform(tape, "x", rows) : ad_input(tape, "x", rows);
}

enum { FORMS = 9, VALUES_MAX = 512 };

/* Sums and products that the compiler contracts. */
static ad_value contraction(int form, ad_value a, ad_value b, ad_value c, ad_value d)
{
    ad_value ab = ad_mul(a, b), scaled = ad_scale(ab, -2.5);
    switch (form) {
    case 0:
        return ad_add(ab, c);
    case 1:
        return ad_sub(ab, c);
    case 2:
        return ad_sub(c, ab);
    case 3:
        return scaled;
    case 4:
        return ad_add(scaled, c);
    case 5:
        return ad_sub(scaled, c);
    case 6:
        return ad_add(scaled, ad_mul(c, d));
    case 7:
        return ad_sub(ab, ad_mul(c, d));
    default:
        return ad_tanh(ad_add(a, b));
    }
}

/* Each operand the same at all points or not. */
static int record_contractions(ad_value (*x)[2], ad_value *y)
{
    int count = 0;
    for (int form = 0; form < FORMS; form++) {
        for (int mask = 0; mask < 1 << OPERANDS; mask++) {
            ad_value own = ad_scalar(x[0][0].tape, 0.01 * count); /* products are not shared */
            ad_value y_now = contraction(form, ad_add(x[0][mask & 1], own), x[1][mask >> 1 & 1],
                                         x[2][mask >> 2 & 1], x[3][mask >> 3 & 1]);
            y[count++] = y_now;
        }
    }
    return count;
}

static bool takes_negative(int op)
{
    return op != OP_LOG && op != OP_SQRT && op != OP_POWER;
}

/* Every operation of the table by itself, operands also of one row. */
static int record_operations(ad_value (*x)[2], ad_value (*single)[2], ad_value *y)
{
    int count = 0;
    for (int op = OP_ADD; op < OP_REPEAT; op++) {
        int arity = ad_op_table[op].arity;
        for (int k = 0; k < 1 << (2 * arity); k++) {
            ad_value now[AD_ARITY_MAX];
            bool negative = takes_negative(op) && (k & 1);
            for (int i = 0; i < arity; i++) {
                bool uniform = k >> i & 1, one = k >> (arity + i) & 1 && i > 0;
                now[i] = one ? single[i][uniform] : x[i][uniform];
                now[i] = negative ? ad_neg(now[i]) : now[i];
            }
            y[count++] =
                ad_tape_record(now[0].tape, op, arity, now, op == OP_STUMPFF ? k : 0, 2.7, 0);
        }
    }
    return count;
}

/* Values; where `derivatives` are wanted, of some of them the gradient of the sum of their squares
 * and its second derivative along an input. */
static void add_operations(int rows, bool derivatives, size_t points)
{
    subject *s = &subjects[subject_count++];
    static ad_value y[VALUES_MAX], same[VALUES_MAX];
    ad_value x[OPERANDS][2], single[OPERANDS][2], t, path, coefficients[3];
    int count = 0;
    *s = (subject){.tape = ad_tape_create(), .sums = true};
    t = ad_uniform(s->tape, "t", 1);
    for (int i = 0; i < OPERANDS; i++) {
        for (int uniform = 0; uniform < 2; uniform++) {
            x[i][uniform] = operand(s->tape, uniform, rows);
            single[i][uniform] = operand(s->tape, uniform, 1);
        }
    }
    path = x[0][0];
    x[0][0] = ad_add(path, ad_mul(t, x[1][0]));
    count = record_operations(x, single, y);
    count += record_contractions(x, y + count);
    assert_true(count <= VALUES_MAX);
    int batch = 0, uniform = 0;
    for (int i = 0; i < count; i++) {
        if (ad_extent_of(y[i]) == AD_BATCH)
            y[batch++] = y[i];
        else
            same[uniform++] = y[i];
    }
    s->outputs[0] = ad_stack(batch, y);
    s->outputs[1] = ad_stack(uniform, same);
    s->count = 2;
    if (derivatives) {
        enum { EVERY = 13 };
        for (count = 0; count * EVERY < batch; count++)
            y[count] = y[count * EVERY];
        ad_value some = ad_stack(count, y), loss = ad_sum_points(ad_dot(some, some));
        ad_taylor(1, &loss, t, ad_scalar(s->tape, 1), 2, coefficients);
        s->outputs[2] = ad_stack(2, coefficients + 1);
        ad_reverse(loss, 2, (ad_value[]){path, x[2][1]}, AD_SUMMED, s->outputs + 3);
        s->count = 5;
    }
    finish(s, points, 0.4, 1.7, NULL);
}

/* A network with panels of coefficients, rows in loops, sums and two passes. */
static void add_network(size_t points, int tile)
{
    enum { WIDTH = 21 };
    subject *s = &subjects[subject_count++];
    *s = (subject){.tape = ad_tape_create(), .count = 5, .sums = true};
    ad_value x = ad_input(s->tape, "x", 1), y = ad_input(s->tape, "y", 2);
    ad_value load = ad_uniform(s->tape, "load", 2);
    ad_value w1 = ad_parameter(s->tape, "w1", 3 * WIDTH, 0);
    ad_value b1 = ad_parameter(s->tape, "b1", WIDTH, 100);
    ad_value w2 = ad_parameter(s->tape, "w2", WIDTH * WIDTH, 200);
    ad_value w3 = ad_parameter(s->tape, "w3", 2 * WIDTH, 700);
    ad_value h = ad_tanh(ad_add(ad_matvec(w1, ad_stack(2, (ad_value[]){x, y})), b1));
    h = ad_tanh(ad_matvec(w2, ad_sin(h)));
    ad_value u = ad_matvec(w3, h), mean = ad_div(ad_sum_points(u), ad_points(s->tape));
    ad_value residual = ad_add(ad_sub(ad_derivative(u, x, 2), ad_mul(load, u)),
                               ad_mul(ad_sub(u, mean), ad_exp(ad_row(y, 1))));
    s->outputs[0] = ad_sum_points(ad_dot(residual, residual));
    s->outputs[1] = residual;
    ad_reverse(s->outputs[0], 3, (ad_value[]){w1, w2, load}, AD_SUMMED, s->outputs + 2);
    finish(s, points, -1, 1, &(ad_settings){.tile = tile, .piece = 48, .fuse = true});
}

/* What is exported: outputs and their derivatives, point by point. */
static void add_network_of_points(void)
{
    enum { WIDTH = 37 };
    subject *s = &subjects[subject_count++];
    *s = (subject){.tape = ad_tape_create(), .count = 3};
    ad_value x = ad_input(s->tape, "x", 2), u = ad_uniform(s->tape, "u", 2);
    ad_value w1 = ad_parameter(s->tape, "w1", 2 * WIDTH, 0);
    ad_value b1 = ad_parameter(s->tape, "b1", WIDTH, 100);
    ad_value w2 = ad_parameter(s->tape, "w2", WIDTH * WIDTH, 200);
    ad_value w3 = ad_parameter(s->tape, "w3", 7 * WIDTH, 1700);
    ad_value h = ad_tanh(ad_add(ad_matvec(w1, ad_mul(x, u)), ad_scale(b1, 0.1)));
    h = ad_tanh(ad_scale(ad_matvec(w2, h), 0.2));
    s->outputs[0] = ad_matvec(w3, h);
    ad_value direction[2] = {ad_constant(s->tape, 2, (double[]){1, 0}),
                             ad_constant(s->tape, 2, (double[]){0, 1})};
    for (int i = 0; i < 2; i++) {
        ad_value coefficients[2];
        ad_taylor(1, s->outputs, x, direction[i], 1, coefficients);
        s->outputs[1 + i] = coefficients[1];
    }
    finish(s, POINTS, -1, 1, NULL);
}

static void add_graph(uint64_t seed)
{
    static const size_t points[] = {1, 9, 40, 100};
    subject *s = &subjects[subject_count++];
    garden g;
    garden_plant(&g, seed, 40, seed % 2);
    *s = (subject){.tape = g.tape, .sums = true};
    s->count = garden_outputs(&g, s->outputs);
    finish(s, points[seed % 4], -1, 1, &(ad_settings){.tile = 32, .piece = 64, .fuse = seed % 3});
}

static int make_subjects(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/cpinn_test_XXXXXX");
    assert_non_null(mkdtemp(folder));
    add_operations(3, true, POINTS);
    add_operations(11, false, POINTS);
    add_network(150, 16);
    add_network(64, 64);
    add_network_of_points();
    for (uint64_t seed = 1; seed <= 4; seed++)
        add_graph(seed);
    return 0;
}

static void free_subject(subject *s)
{
    compiled_free(&s->c);
    data_free(&s->data);
    ad_tape_free(s->tape);
}

static int free_subjects(void **state)
{
    char command[128];
    (void)state;
    for (int i = 0; i < subject_count; i++)
        free_subject(&subjects[i]);
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

/* ---- groups -------------------------------------------------------------------------------------
 */

static void assert_same_numbers(const char *what, int output, size_t count, const double *a,
                                const double *b)
{
    for (size_t k = 0; k < count; k++)
        if (memcmp(a + k, b + k, sizeof *a) != 0 && !(isnan(a[k]) && isnan(b[k])))
            fail_msg("%s: number %zu of output %d: %.17g, not %.17g", what, k, output, a[k], b[k]);
}

static void check_fused(subject *s, int number)
{
    double *before[OUTPUTS];
    char what[64];
    ad_fuse_state state = AD_INTERPRETED;
    ad_error error = {AD_OK, ""};
    for (int i = 0; i < s->count; i++) {
        before[i] = new_numbers(s->c.sizes[i]);
        memcpy(before[i], s->c.results[i], s->c.sizes[i] * sizeof(double));
    }
    if (ad_fuse_begin(s->c.program, s->data.points, 1, folder, true, &error) != AD_OK ||
        ad_fuse_finish(s->c.program, true, &state, &error) != AD_OK)
        fail_msg("fuse: %s", error.message);
    assert_int_equal(state, AD_FUSED);
    compiled_execute(&s->c, s->outputs, &s->data);
    snprintf(what, sizeof what, "groups of program %d", number);
    for (int i = 0; i < s->count; i++) {
        assert_same_numbers(what, i, s->c.sizes[i], s->c.results[i], before[i]);
        free(before[i]);
    }
}

static void test_groups_give_the_same_bits(void **state)
{
    (void)state;
    for (int i = 0; i < subject_count; i++)
        check_fused(&subjects[i], i);
}

/* Else a rule of what is written would not be tested. */
static void test_every_operation_occurs(void **state)
{
    (void)state;
    bool seen[OP_COUNT] = {false};
    for (int k = 0; k < subject_count; k++)
        for (int s = 0; s < subjects[k].c.program->pass_count; s++)
            for (int i = 0; i < subjects[k].c.program->passes[s].count; i++)
                seen[subjects[k].c.program->passes[s].instructions[i].op] = true;
    for (int op = OP_ADD; op < OP_COUNT; op++) {
        bool is_view = op == OP_SLICE || op == OP_STACK || op == OP_PAD || op == OP_SUM_ROWS ||
                       op == OP_SPREAD; /* test_members */
        if (!seen[op] && !is_view)
            fail_msg("%s: in no program of this test", ad_op_table[op].name);
    }
}

/* As a library, and without a warning. */
static void test_groups_without_warnings(void **state)
{
    (void)state;
    char path[128];
    const ad_program *program = subjects[1].c.program;
    snprintf(path, sizeof path, "%s/groups.c", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(ad_c_write_groups(program, "groups", file));
    assert_int_equal(fclose(file), 0);
    char options[128];
    snprintf(options, sizeof options, "-std=c11 -Wno-unused-function %s", program->kernels->flags);
    run_command("%s %s -o %s/%s.so %s/%s.c", options, "groups");
}

/* By the largest number of the output. */
static void assert_close(const char *kind, int number, int output, const subject *s,
                         const double *values, double tolerance)
{
    const double *expected = s->c.results[output];
    double scale = 1;
    for (size_t k = 0; k < s->c.sizes[output]; k++)
        scale = isfinite(expected[k]) ? fmax(scale, fabs(expected[k])) : scale;
    for (size_t k = 0; k < s->c.sizes[output]; k++)
        if (!(fabs(values[k] - expected[k]) <= tolerance * scale) &&
            !(isnan(values[k]) && isnan(expected[k])))
            fail_msg("%s_%d, output %d, number %zu: %.17g, not %.17g", kind, number, output, k,
                     values[k], expected[k]);
}

static void check_set(const kernel_set *set, const char *compiler)
{
    char path[4096], changed[4200], command[256];
    snprintf(command, sizeof command, "cd %s && rm -f *.so cc && ln -s $(command -v %s) cc", folder,
             compiler);
    if (system(command) != 0)
        return;
    snprintf(path, sizeof path, "%s", getenv("PATH"));
    snprintf(changed, sizeof changed, "%s:%s", folder, path);
    setenv("PATH", changed, 1);
    chosen_kernels = set;
    add_operations(1, false, 24);
    check_fused(&subjects[subject_count - 1], subject_count - 1);
    free_subject(&subjects[--subject_count]);
    chosen_kernels = NULL;
    setenv("PATH", path, 1);
}

/* The same bits by other sets of kernels than the processor's best, and whoever compiles. */
static void test_kernel_sets_and_compilers(void **state)
{
    (void)state;
    const kernel_set *best = ad_kernels_select();
    check_set(best, "gcc");
    check_set(best, "clang");
    if (best != &ad_kernels_baseline)
        check_set(&ad_kernels_baseline, "cc");
    if (best == &ad_kernels_avx512)
        check_set(&ad_kernels_avx2, "cc");
}

/* ---- whole programs -----------------------------------------------------------------------------
 */

enum { NUMBERS = 1 << 19 }; /* at least what the subjects need */

typedef void all_given(const void *x, void *y, void *w);
typedef void none_given(const double *x, const double *const *uniforms, const double *parameters,
                        double *y, double *w);
typedef void sets_given(int set, const double *x, double *y, double *w);

/* Of two sets the results that are known are those of the second. */
static void write_function(const subject *s, int number, const char *kind, size_t points, int sets,
                           bool single, FILE *file)
{
    char name[32];
    ad_error error = {AD_OK, ""};
    double other[PARAMETERS_MAX];
    const double *const parameters[] = {other, s->data.parameters};
    const double *const *const uniforms[] = {(const double *const *)s->data.uniform,
                                             (const double *const *)s->data.uniform};
    const ad_c_options options = {.name = name,
                                  .points = points,
                                  .sets = sets,
                                  .parameters = parameters + (sets == 1),
                                  .uniforms = uniforms + (sets == 1)};
    size_t memory;
    for (int i = 0; i < PARAMETERS_MAX; i++)
        other[i] = 0.3 + 0.001 * i;
    snprintf(name, sizeof name, "%s_%d", kind, number);
    if (ad_write_c(1, (ad_program *const[]){s->c.program}, &options, single, file, &memory,
                   &error) != AD_OK)
        fail_msg("%s: %s", name, error.message);
    assert_true(memory <= NUMBERS);
}

static void write_functions(const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (int i = 0; i < subject_count; i++) {
        const subject *s = &subjects[i];
        write_function(s, i, "asked", s->data.points, 0, false, file);
        if (i > 0) /* large, and nothing new */
            write_function(s, i, "given", s->data.points, 1, false, file);
        if (!s->sums) {
            write_function(s, i, "point", 1, 1, false, file);
            if (i > 0)
                write_function(s, i, "sets", 1, 2, false, file);
            write_function(s, i, "single", 1, 1, true, file);
        }
    }
    assert_int_equal(fclose(file), 0);
}

static void *function_of(void *library, const char *kind, int number)
{
    char name[32];
    snprintf(name, sizeof name, "%s_%d", kind, number);
    void *found = dlsym(library, name);
    assert_non_null(found);
    return found;
}

static size_t numbers_of(const subject *s, size_t points)
{
    size_t count = 0;
    for (int i = 0; i < s->count; i++)
        count += s->c.sizes[i] / s->data.points * points;
    return count;
}

/* Outputs stand one after the other. */
static void check_whole(void *library, const subject *s, int number, bool given)
{
    const char *kind = given ? "given" : "asked";
    void *found = function_of(library, kind, number);
    double *x = new_numbers(NUMBERS), *y = new_numbers(NUMBERS), *w = new_numbers(NUMBERS);
    size_t at = 0;
    all_given *short_form;
    none_given *long_form;
    memcpy(&short_form, &found, sizeof found);
    memcpy(&long_form, &found, sizeof found);
    for (int i = 0; i < s->data.inputs; i++) {
        size_t count = (size_t)s->tape->input_rows[i] * s->data.points;
        memcpy(x + at, s->data.input[i], count * sizeof *x);
        at += count;
        assert_true(at <= NUMBERS);
    }
    if (given)
        short_form(x, y, w);
    else
        long_form(x, (const double *const *)s->data.uniform, s->data.parameters, y, w);
    at = 0;
    for (int i = 0; i < s->count; i++) {
        assert_close(kind, number, i, s, y + at, ROUNDING);
        at += s->c.sizes[i];
        assert_true(at <= NUMBERS);
    }
    free(x);
    free(y);
    free(w);
}

/* Point by point, as double or float; the second of two sets. */
static void check_points(void *library, const subject *s, int number, const char *kind)
{
    void *found = function_of(library, kind, number);
    bool single = strcmp(kind, "single") == 0;
    all_given *function;
    sets_given *of_sets;
    double *values = new_numbers(NUMBERS), *x = new_numbers(NUMBERS), *y = new_numbers(NUMBERS);
    double *w = new_numbers(NUMBERS);
    float x_single[NUMBERS / 100], *y_single = (float *)(void *)w + NUMBERS;
    size_t points = s->data.points, rows = numbers_of(s, 1), at = 0;
    assert_true(rows * points <= NUMBERS && rows <= NUMBERS);
    memcpy(&function, &found, sizeof found);
    memcpy(&of_sets, &found, sizeof found);
    for (size_t j = 0; j < points; j++) {
        size_t count = 0;
        for (int i = 0; i < s->data.inputs; i++) {
            for (int r = 0; r < s->tape->input_rows[i]; r++, count++) {
                x[count] = s->data.input[i][(size_t)r * points + j];
                x_single[count] = (float)x[count];
            }
        }
        if (strcmp(kind, "sets") == 0)
            of_sets(1, x, y, w);
        else if (single)
            function(x_single, y_single, w);
        else
            function(x, y, w);
        for (size_t r = 0; r < rows; r++)
            values[r * points + j] = single ? (double)y_single[r] : y[r];
    }
    for (int i = 0; i < s->count; i++) {
        assert_close(kind, number, i, s, values + at, single ? SINGLE_ROUNDING : ROUNDING);
        at += s->c.sizes[i];
    }
    free(values);
    free(x);
    free(y);
    free(w);
}

static void test_whole_programs(void **state)
{
    (void)state;
    char path[128];
    snprintf(path, sizeof path, "%s/whole.c", folder);
    write_functions(path);
    run_command("%s %s -o %s/%s.so %s/%s.c -lm", "-std=c99", "whole");
    snprintf(path, sizeof path, "%s/whole.so", folder);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        fail_msg("%s", dlerror());
    for (int i = 0; i < subject_count; i++) {
        check_whole(library, &subjects[i], i, false);
        if (i > 0)
            check_whole(library, &subjects[i], i, true);
        if (!subjects[i].sums) {
            check_points(library, &subjects[i], i, "point");
            if (i > 0)
                check_points(library, &subjects[i], i, "sets");
            check_points(library, &subjects[i], i, "single");
        }
    }
    dlclose(library);
}

/* Arguments from 0 to far beyond what our own functions take without a branch, of many rows, which
 * are looked at before their loop, and of few: as libm and the tape have them. */
static void test_far_arguments(void **state)
{
    (void)state;
    enum { MANY = 24, FEW = 3, KINDS = 5, ROWS = KINDS * (MANY + FEW) };
    double x[MANY], y[ROWS], w[4 * ROWS];
    char path[128];
    size_t memory;
    ad_tape *tape = ad_tape_create();
    ad_value many = ad_input(tape, "x", MANY), few = ad_slice(many, MANY - FEW, FEW);
    ad_value outputs[2 * KINDS];
    for (int i = 0; i < 2 * KINDS; i++) {
        const ad_value of = i < KINDS ? many : few;
        const int kind = i % KINDS;
        outputs[i] = kind == 0 ? ad_sin(of) : kind == 1 ? ad_cos(of) : ad_stumpff(kind - 2, of);
    }
    compiled c = compile_values(2 * KINDS, outputs, NULL, 1);
    const ad_c_options options = {.name = "far", .points = 1};
    ad_error error;
    snprintf(path, sizeof path, "%s/far.c", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(ad_write_c(1, &c.program, &options, false, file, &memory, &error), AD_OK);
    assert_int_equal(fclose(file), 0);
    assert_true(memory <= 4 * ROWS);
    run_command("%s %s -o %s/%s.so %s/%s.c -lm", "-std=c99", "far");
    snprintf(path, sizeof path, "%s/far.so", folder);
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL), *found;
    none_given *far;
    assert_non_null(library);
    found = dlsym(library, "far");
    memcpy(&far, &found, sizeof far);
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < MANY; i++)
            x[i] = k * pow(10, i) + 0.1 * i;
        x[4] = k ? -INFINITY : -0.4;
        far(x, NULL, NULL, y, w);
        for (int i = 0; i < ROWS; i++) {
            const int of_few = i - KINDS * MANY, kind = of_few < 0 ? i / MANY : of_few / FEW;
            const double at = x[of_few < 0 ? i % MANY : MANY - FEW + of_few % FEW];
            const double wanted = kind == 0   ? sin(at)
                                  : kind == 1 ? cos(at)
                                              : ad_op_evaluate(OP_STUMPFF, kind - 2, 0, &at);
            assert_true(isnan(wanted) ? isnan(y[i])
                                      : y[i] == wanted || fabs(y[i] - wanted) <= 3e-16);
        }
    }
    dlclose(library);
    compiled_free(&c);
    ad_tape_free(tape);
}

static void test_options_are_checked(void **state)
{
    (void)state;
    ad_program *const program = subjects[0].c.program;
    ad_error error;
    size_t memory;
    ad_c_options options = {.name = "2x", .points = 1};
    assert_int_equal(ad_write_c(1, &program, &options, false, stderr, &memory, &error),
                     AD_BAD_ARGUMENT);
    options = (ad_c_options){.name = "x"};
    assert_int_equal(ad_write_c(1, &program, &options, false, stderr, &memory, &error),
                     AD_BAD_ARGUMENT);
}

int main(void)
{
    if (system("cc --version > /dev/null 2>&1") != 0)
        return 77;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_operation_occurs),
        cmocka_unit_test(test_groups_give_the_same_bits),
        cmocka_unit_test(test_groups_without_warnings),
        cmocka_unit_test(test_kernel_sets_and_compilers),
        cmocka_unit_test(test_whole_programs),
        cmocka_unit_test(test_far_arguments),
        cmocka_unit_test(test_options_are_checked),
    };
    return cmocka_run_group_tests(tests, make_subjects, free_subjects);
}
