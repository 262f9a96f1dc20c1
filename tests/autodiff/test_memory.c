/* Nothing is allocated in a step; running out of memory anywhere is an error and leaves nothing
 * behind. Also the gradient check. */
#include "ad_testing.h"
#include "allocations.h"
#include "autodiff/memory.h"

static void watch(long fail_at)
{
    allocations = 0;
    failing_allocation = fail_at;
    allocations_count = true;
}

/* ---- a whole life -------------------------------------------------------------------------------
 */

enum { WIDTH = 20, POINTS = 200, NUMBERS = 2 * WIDTH + WIDTH + WIDTH * WIDTH + WIDTH };

static ad_value record(ad_tape *tape, ad_value *gradient)
{
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
    ad_value scale = ad_uniform(tape, "scale", 1);
    ad_value all = ad_parameter(tape, "all", NUMBERS, 0);
    ad_value x = ad_stack(2, (ad_value[]){s, t});
    x = ad_tanh(ad_add(ad_matvec(ad_slice(all, 0, 2 * WIDTH), x), ad_slice(all, 2 * WIDTH, WIDTH)));
    ad_value w = ad_slice(all, 3 * WIDTH, WIDTH * WIDTH);
    x = ad_sin(ad_add(ad_matvec(w, x), ad_slice(all, 3 * WIDTH + WIDTH * WIDTH, WIDTH)));
    ad_value many[WIDTH]; /* a stack of many parts, a constant of many rows */
    double numbers[WIDTH];
    for (int i = 0; i < WIDTH; i++) {
        many[i] = ad_mul(ad_row(x, WIDTH - 1 - i), s);
        numbers[i] = i;
    }
    x = ad_add(ad_mul(ad_constant(tape, WIDTH, numbers), ad_stack(WIDTH, many)), x);
    x = ad_sub(x, ad_div(ad_sum_points(x), ad_points(tape))); /* a second pass */
    ad_value coefficient = ad_derivative(x, s, 2);
    coefficient = ad_substitute(coefficient, scale, ad_scalar(tape, 2));
    ad_value loss = ad_sum_points(ad_mul(scale, ad_dot(coefficient, x)));
    ad_reverse(loss, 1, &all, AD_SUMMED, gradient);
    return loss;
}

static double s_points[POINTS], t_points[POINTS], scale_number[1] = {1.5};
static double parameters[NUMBERS], gradient_numbers[NUMBERS];

static ad_status execute(ad_program *program, size_t points, double *loss, ad_error *error)
{
    ad_run run = {.points = points,
                  .inputs = (const double *const[]){s_points, t_points},
                  .uniforms = (const double *const[]){scale_number},
                  .parameters = parameters,
                  .outputs = (double *const[]){loss, gradient_numbers}};
    return ad_execute(program, &run, error);
}

/* Record, transform, compile and run; every object freed whatever happened. */
static ad_status live(double *loss)
{
    ad_error error = {.status = AD_OK};
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(2);
    ad_program *program = NULL;
    ad_status status = AD_NO_MEMORY;
    if (tape && pool) {
        ad_value outputs[2];
        outputs[0] = record(tape, &outputs[1]);
        ad_settings settings = ad_settings_default();
        status = ad_compile(2, outputs, &settings, pool, &program, &error);
        assert_true((status == AD_OK) == (program != NULL));
        assert_int_equal(status, error.status);
        if (status == AD_OK)
            status = execute(program, POINTS, loss, &error);
    }
    ad_program_free(program);
    ad_pool_free(pool);
    ad_tape_free(tape);
    return status;
}

static int fill(void **state)
{
    (void)state;
    uint64_t random = 6;
    for (int i = 0; i < POINTS; i++) {
        s_points[i] = random_in(&random, -1, 1);
        t_points[i] = random_in(&random, -1, 1);
    }
    for (int i = 0; i < NUMBERS; i++)
        parameters[i] = random_in(&random, -0.3, 0.3);
    return 0;
}

/* ---- values of members -------------------------------------------------------------------------
 */

enum { MEMBERS = 5 };

typedef struct member_life {
    ad_tape *tape;
    ad_pool *pool;
    ad_program *program;
} member_life;

static ad_status run_members(member_life *l, size_t points, double *loss, ad_error *error)
{
    ad_run run = {.points = points,
                  .members = MEMBERS,
                  .inputs = (const double *const[]){t_points, s_points},
                  .parameters = parameters,
                  .outputs = (double *const[]){loss, gradient_numbers}};
    return ad_execute(l->program, &run, error);
}

/* Coefficients of members from parameters, their sums in shares of several tiles. */
static ad_status compile_members(member_life *l, ad_error *error)
{
    ad_value m = ad_input_member(l->tape, "m", 3), s = ad_input(l->tape, "s", 1);
    ad_value w = ad_parameter(l->tape, "w", 9, 0), c = ad_tanh(ad_matvec(w, m)), outputs[2];
    ad_value modes = ad_stack(3, (ad_value[]){s, ad_sin(s), ad_square(s)});
    ad_value load = ad_vector(ad_scalar(l->tape, 0), ad_row(m, 1), s);
    ad_value r = ad_dot(ad_add(c, load), modes);
    outputs[0] = ad_sum_points(ad_square(r));
    ad_reverse(outputs[0], 1, &w, AD_SUMMED, &outputs[1]);
    ad_settings settings = {.tile = 16, .piece = 64, .fuse = true};
    return ad_compile(2, outputs, &settings, l->pool, &l->program, error);
}

static ad_status live_members(double *loss)
{
    ad_error error = {.status = AD_OK};
    member_life l = {.tape = ad_tape_create(), .pool = ad_pool_create(2)};
    ad_status status = AD_NO_MEMORY;
    if (l.tape && l.pool) {
        status = compile_members(&l, &error);
        assert_int_equal(status, error.status);
        if (status == AD_OK)
            status = run_members(&l, POINTS, loss, &error);
    }
    ad_program_free(l.program);
    ad_pool_free(l.pool);
    ad_tape_free(l.tape);
    return status;
}

static void check_out_of_memory(ad_status (*live)(double *))
{
    double loss, expected;
    assert_int_equal(live(&expected), AD_OK); /* also loads what is loaded once */
    watch(0);
    assert_int_equal(live(&loss), AD_OK);
    allocations_count = false;
    long all = allocations;
    assert_true(all > 50);
    for (long n = 1; n <= all; n++) {
        watch(n);
        ad_status status = live(&loss);
        allocations_count = false;
        if (status != AD_NO_MEMORY)
            fail_msg("allocation %ld of %ld fails: status %d", n, all, status);
    }
    assert_int_equal(live(&loss), AD_OK);
    assert_near(loss, expected, 0);
}

static void test_out_of_memory_anywhere(void **state)
{
    (void)state;
    check_out_of_memory(live);
    check_out_of_memory(live_members);
}

static void test_steps_of_members_allocate_nothing(void **state)
{
    (void)state;
    double loss;
    member_life l = {.tape = ad_tape_create(), .pool = ad_pool_create(2)};
    assert_int_equal(compile_members(&l, NULL), AD_OK);
    ad_tape_free(l.tape);
    assert_int_equal(run_members(&l, POINTS, &loss, NULL), AD_OK);
    watch(0);
    for (int i = 0; i < 20; i++)
        assert_int_equal(run_members(&l, (size_t)(POINTS - MEMBERS * i), &loss, NULL), AD_OK);
    allocations_count = false;
    assert_int_equal(allocations, 0);
    ad_program_free(l.program);
    ad_pool_free(l.pool);
}

static void test_steps_allocate_nothing(void **state)
{
    (void)state;
    double loss;
    for (int threads = 1; threads <= 2; threads++) {
        ad_tape *tape = ad_tape_create();
        ad_pool *pool = ad_pool_create(threads);
        ad_program *program = NULL;
        ad_value outputs[2];
        outputs[0] = record(tape, &outputs[1]);
        assert_int_equal(ad_compile(2, outputs, NULL, pool, &program, NULL), AD_OK);
        ad_tape_free(tape); /* not needed any more */
        assert_int_equal(execute(program, POINTS, &loss, NULL), AD_OK);
        watch(0);
        for (int i = 0; i < 20; i++)
            assert_int_equal(execute(program, (size_t)(POINTS - 7 * i), &loss, NULL), AD_OK);
        allocations_count = false;
        assert_int_equal(allocations, 0);
        ad_program_free(program);
        ad_pool_free(pool);
    }
}

/* The workspace is that of one tile (some of it of one piece, which does not grow). */
static void test_workspace_is_a_tile(void **state)
{
    (void)state;
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(1);
    ad_program *program = NULL;
    ad_value outputs[2];
    outputs[0] = record(tape, &outputs[1]);
    size_t before = 0;
    for (int tile = 32; tile <= 128; tile *= 2) {
        ad_settings settings = {.tile = tile, .piece = 512, .fuse = true};
        assert_int_equal(ad_compile(2, outputs, &settings, pool, &program, NULL), AD_OK);
        ad_program_info info = ad_program_inspect(program);
        assert_int_equal(info.tile, tile);
        assert_true(info.workspace_bytes > before);
        assert_true(before == 0 || info.workspace_bytes <= 2 * before);
        before = info.workspace_bytes;
        ad_program_free(program);
    }
    ad_pool_free(pool);
    ad_tape_free(tape);
}

static void test_pools(void **state)
{
    (void)state;
    assert_null(ad_pool_create(0));
    assert_null(ad_pool_create(-3));
    for (int threads = 1; threads <= 3; threads++) {
        ad_pool *pool = ad_pool_create(threads);
        assert_int_equal(ad_pool_threads(pool), threads);
        ad_pool_free(pool);
    }
    ad_pool_free(NULL);
    ad_program_free(NULL);
    ad_tape_free(NULL);
}

/* ---- gradient check -----------------------------------------------------------------------------
 */

enum { ENTRIES = 40 };

typedef struct trial {
    int wrong;     /* entry whose gradient is off, -1: none */
    double by;     /* relative */
    bool infinite; /* the function itself */
    int calls;
} trial;

static int trial_function(void *context, const double *x, double *value, double *gradient)
{
    trial *t = context;
    t->calls++;
    *value = t->infinite ? INFINITY : 0;
    for (int i = 0; i < ENTRIES; i++) {
        *value += sin(x[i] + i) + x[i] * x[(i + 1) % ENTRIES];
        if (gradient)
            gradient[i] = cos(x[i] + i) + x[(i + 1) % ENTRIES] + x[(i + ENTRIES - 1) % ENTRIES];
    }
    if (gradient && t->wrong >= 0)
        gradient[t->wrong] *= 1 + t->by;
    return 0;
}

static void test_gradient_check(void **state)
{
    (void)state;
    double x[ENTRIES], start[ENTRIES];
    for (int i = 0; i < ENTRIES; i++)
        start[i] = x[i] = 0.1 * i - 1;
    trial good = {.wrong = -1}, bad = {.wrong = 17, .by = 1e-5}, infinite = {.infinite = true};
    ad_check check;
    ad_error error = {.status = AD_OK};
    assert_int_equal(ad_check_gradient(trial_function, &good, x, ENTRIES, 0, 1e-2, &check, &error),
                     AD_OK);
    assert_true(check.worst_error < 1e-11); /* rounding 1e-14 / h */
    assert_true(check.dot_error < 1e-10);
    assert_memory_equal(x, start, sizeof x); /* restored */
    assert_int_equal(ad_check_gradient(trial_function, &bad, x, ENTRIES, 0, 1e-2, &check, &error),
                     AD_OK);
    assert_int_equal(check.worst_entry, 17);
    assert_true(check.worst_error > 1e-7 && check.dot_error > 1e-7);
    assert_near(check.worst_gradient / check.worst_difference, 1 + 1e-5, 1e-9);
    bad.wrong = 1; /* not among 4 entries 0, 10, 20, 30: the direction finds it */
    assert_int_equal(ad_check_gradient(trial_function, &bad, x, ENTRIES, 4, 1e-2, &check, &error),
                     AD_OK);
    assert_true(check.worst_error < 1e-11 && check.dot_error > 1e-8);
    assert_int_equal(
        ad_check_gradient(trial_function, &infinite, x, ENTRIES, 0, 1e-2, &check, &error),
        AD_NOT_FINITE);
    assert_memory_equal(x, start, sizeof x);
}

/* Pieces are zeros where vectors want them; one that cannot be had says so, and ends all others. */
static void test_pieces(void **state)
{
    (void)state;
    struct {
        double *numbers;
        char *nothing;
        ad_memory memory;
    } x = {.memory = {0}};
    ad_error error = {.status = AD_OK};
    assert_non_null(AD_TAKE(&x, numbers, 1000));
    assert_non_null(AD_TAKE(&x, nothing, 0));
    assert_int_equal((uintptr_t)x.numbers % 64, 0);
    for (int i = 0; i < 1000; i++)
        assert_true(x.numbers[i] == 0);
    assert_int_equal(ad_memory_status(&x.memory, &error, "no memory for %d", 3), AD_OK);
    assert_null(ad_memory_take(&x.memory, SIZE_MAX / 4, sizeof(double)));
    assert_null(ad_memory_take(&x.memory, 1, 1));
    assert_int_equal(ad_memory_status(&x.memory, &error, "no memory for %d", 3), AD_NO_MEMORY);
    assert_string_equal(error.message, "no memory for 3");
    ad_memory_free(&x.memory);
    watch(2);
    AD_TAKE(&x, numbers, 10);
    assert_false(x.memory.is_short);
    AD_TAKE(&x, nothing, 10);
    allocations_count = false;
    assert_true(x.memory.is_short);
    ad_memory_free(&x.memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pieces),
        cmocka_unit_test(test_out_of_memory_anywhere),
        cmocka_unit_test(test_steps_allocate_nothing),
        cmocka_unit_test(test_steps_of_members_allocate_nothing),
        cmocka_unit_test(test_workspace_is_a_tile),
        cmocka_unit_test(test_pools),
        cmocka_unit_test(test_gradient_check),
    };
    return cmocka_run_group_tests(tests, fill, NULL);
}
