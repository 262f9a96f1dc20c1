/* Programs, normal equations, factors and items of work over several ranks: the bits of one
 * process. The ranks are threads that exchange numbers through common memory. */
#include "autodiff/dense.h"
#include "autodiff/ranks.h"
#include "tools/programs/program_ranks.h"

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- ranks that are threads ------------------------------------------------------------------ */

enum { RANKS_MAX = 70 };

typedef struct meeting {
    pthread_barrier_t barrier;
    const void *numbers[RANKS_MAX];
    const size_t *bounds[RANKS_MAX];
} meeting;

typedef struct thread_rank {
    meeting *at;
    int rank, count;
} thread_rank;

static void gather(void *context, const size_t *bounds, double *data)
{
    thread_rank *me = context;
    me->at->numbers[me->rank] = data;
    pthread_barrier_wait(&me->at->barrier);
    for (int i = 0; i < me->count; i++) {
        const double *from = me->at->numbers[i];
        for (size_t k = bounds[i]; i != me->rank && k < bounds[i + 1]; k++) {
            data[k] = from[k];
        }
    }
    pthread_barrier_wait(&me->at->barrier);
}

static void exchange(void *context, const size_t *to, const double *send, const size_t *from,
                     double *receive)
{
    thread_rank *me = context;
    me->at->numbers[me->rank] = send;
    me->at->bounds[me->rank] = to;
    pthread_barrier_wait(&me->at->barrier);
    for (int i = 0; i < me->count; i++) {
        const size_t *there = me->at->bounds[i], first = there[me->rank];
        assert_int_equal(there[me->rank + 1] - first, from[i + 1] - from[i]);
        memcpy(receive + from[i], (const double *)me->at->numbers[i] + first,
               (from[i + 1] - from[i]) * sizeof *receive);
    }
    pthread_barrier_wait(&me->at->barrier);
}

typedef struct worker {
    thread_rank self;
    void (*work)(ad_pool *pool, double *results);
    int threads;
    double *results;
} worker;

static void *be_rank(void *argument)
{
    worker *w = argument;
    const ad_ranks ranks = {w->self.rank, w->self.count, &w->self, gather, exchange};
    ad_pool *pool = ad_pool_create(w->threads);
    ad_error error;
    assert_non_null(pool);
    assert_int_equal(ad_pool_share(pool, &ranks, &error), AD_OK);
    assert_true((ad_pool_ranks(pool) != NULL) == (ranks.count > 1));
    w->work(pool, w->results);
    ad_pool_free(pool);
    return NULL;
}

/* The results [count] of every one of so many ranks are those of the first call, by one of two
 * threads. */
static void compare(void (*work)(ad_pool *pool, double *results), size_t count)
{
    static const int ranks[] = {1, 1, 2, 3, 7, 8, RANKS_MAX};
    double *expected = calloc(count, sizeof *expected);
    for (size_t i = 0; i < sizeof ranks / sizeof *ranks; i++) {
        meeting at = {.numbers = {NULL}};
        worker workers[RANKS_MAX];
        pthread_t threads[RANKS_MAX];
        pthread_barrier_init(&at.barrier, NULL, (unsigned)ranks[i]);
        for (int k = 0; k < ranks[i]; k++) {
            double *results = i == 0 ? expected : calloc(count, sizeof *results);
            workers[k] = (worker){{&at, k, ranks[i]}, work, i == 0 ? 2 : 1, results};
            pthread_create(&threads[k], NULL, be_rank, &workers[k]);
        }
        for (int k = 0; k < ranks[i]; k++) {
            pthread_join(threads[k], NULL);
        }
        for (int k = 0; k < ranks[i]; k++) {
            assert_memory_equal(workers[k].results, expected, count * sizeof *expected);
            if (i > 0) {
                free(workers[k].results);
            }
        }
        pthread_barrier_destroy(&at.barrier);
    }
    assert_true(fabs(expected[0]) > 0);
    free(expected);
}

/* ---- what they compute ----------------------------------------------------------------------- */

enum { WIDTH = 40, PARAMETERS = 4 * WIDTH + 1, MANY = 6001, LOTS = 20011, SMALL_TILE = 8 };

static void fill(double *x, size_t count, double seed)
{
    for (size_t i = 0; i < count; i++) {
        x[i] = sin(seed + 1.7 * (double)i);
    }
}

/* A network of two inputs, and its parameters. */
static ad_value network(ad_tape *tape, ad_value views[4])
{
    ad_value x = ad_stack(2, (ad_value[]){ad_input(tape, "s", 1), ad_input(tape, "t", 1)});
    const int rows[4] = {2 * WIDTH, WIDTH, WIDTH, 1};
    size_t offset = 0;
    for (int i = 0; i < 4; i++) {
        views[i] = ad_parameter(tape, "p", rows[i], offset);
        offset += (size_t)rows[i];
    }
    ad_value hidden = ad_tanh(ad_add(ad_matvec(views[0], x), views[1]));
    return ad_add(ad_matvec(views[2], hidden), views[3]);
}

/* Sums, a second pass that needs those of the first, and values of points, of so many points. */
static void execute(ad_pool *pool, size_t points, int tile, double *results)
{
    ad_settings settings = ad_settings_default();
    settings.tile = tile;
    ad_error error;
    ad_tape *tape = ad_tape_create();
    ad_value views[4], y = network(tape, views);
    ad_value off = ad_sub(y, ad_div(ad_sum_points(y), ad_points(tape)));
    ad_value outputs[7] = {ad_sum_points(ad_square(off)), y, ad_stack(2, (ad_value[]){off, y})};
    assert_int_equal(ad_reverse(outputs[0], 4, views, AD_SUMMED, outputs + 3), AD_OK);
    ad_program *program = NULL;
    assert_int_equal(ad_compile(7, outputs, &settings, pool, &program, &error), AD_OK);
    double x[PARAMETERS], *numbers = calloc(2 * points + 1, sizeof *numbers);
    fill(x, PARAMETERS, 2);
    fill(numbers, 2 * points, 0.3);
    const double *const inputs[2] = {numbers, numbers + points};
    double *to[7] = {results,
                     results + 1,
                     results + 1 + points,
                     results + 1 + 3 * points,
                     results + 1 + 3 * points + 2 * WIDTH,
                     results + 1 + 3 * points + 3 * WIDTH,
                     results + 1 + 3 * points + 4 * WIDTH};
    const ad_run run = {.points = points, .inputs = inputs, .parameters = x, .outputs = to};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(ad_execute(program, &run, &error), AD_OK);
    }
    free(numbers);
    ad_program_free(program);
    ad_tape_free(tape);
}

static void execute_all(ad_pool *pool, double *results)
{
    static const size_t points[] = {MANY, 1, 33, 300, 2048, LOTS}; /* the last: a tree of 256 */
    for (size_t i = 0; i < sizeof points / sizeof *points; i++) {
        execute(pool, points[i], points[i] == LOTS ? SMALL_TILE : 0, results);
        results += 1 + 3 * points[i] + PARAMETERS;
    }
}

static void test_programs(void **state)
{
    (void)state;
    compare(execute_all, 6 * (1 + PARAMETERS) + 3 * (MANY + 1 + 33 + 300 + 2048 + LOTS));
}

enum { TRIANGLE = PARAMETERS * PARAMETERS, NORMAL = TRIANGLE + PARAMETERS + 1 };

static void add_normal(ad_pool *pool, size_t points, double *results)
{
    ad_error error;
    ad_tape *tape = ad_tape_create();
    ad_value views[4], y = network(tape, views);
    ad_value rows = ad_stack(2, (ad_value[]){y, ad_mul(y, ad_sin(y))});
    ad_normal *normal = NULL;
    assert_int_equal(ad_normal_compile(1, &rows, 4, views, PARAMETERS, pool, &normal, &error),
                     AD_OK);
    double x[PARAMETERS], *numbers = calloc(2 * points + 1, sizeof *numbers);
    fill(x, PARAMETERS, 2);
    fill(numbers, 2 * points, 0.3);
    const double *const inputs[2] = {numbers, numbers + points};
    const ad_run run = {.points = points, .inputs = inputs, .parameters = x};
    for (int i = 0; i < 2; i++) { /* to what is there already */
        assert_int_equal(ad_normal_add(normal, &run, results, results + TRIANGLE,
                                       results + TRIANGLE + PARAMETERS, &error),
                         AD_OK);
    }
    free(numbers);
    ad_normal_free(normal);
    ad_tape_free(tape);
}

static void add_normals(ad_pool *pool, double *results)
{
    static const size_t points[] = {MANY, 1, 1500, 2048};
    for (size_t i = 0; i < sizeof points / sizeof *points; i++) {
        add_normal(pool, points[i], results + i * NORMAL);
    }
}

static void test_normal_equations(void **state)
{
    (void)state;
    compare(add_normals, 4 * NORMAL);
}

/* Solutions of one positive definite system of each order, and whether others have a factor. */
static const size_t orders[] = {1, 24, 25, 100, 290};
enum { ORDERS = sizeof orders / sizeof *orders, ORDER_MAX = 290 };

static void factor_matrices(ad_pool *pool, double *results)
{
    double *matrix = calloc(ORDER_MAX, ORDER_MAX * sizeof *matrix);
    for (int k = 0; k < ORDERS; k++) {
        const size_t n = orders[k];
        ad_dense_factor *factor = ad_dense_factor_create(n);
        double *x = results + (size_t)k * (ORDER_MAX + 1), shift[ORDER_MAX];
        assert_non_null(factor);
        fill(matrix, n * n, 0.1);
        fill(x, n, 0.7);
        for (size_t i = 0; i < n; i++) {
            shift[i] = (double)n;
        }
        assert_int_equal(ad_dense_cholesky(pool, matrix, shift, factor), 0);
        ad_dense_cholesky_solve(factor, x);
        shift[n / 2] = -1;
        x[ORDER_MAX] = ad_dense_cholesky(pool, matrix, shift, factor);
        assert_true(x[ORDER_MAX] != 0);
        ad_dense_factor_free(factor);
    }
    free(matrix);
}

static void test_factors(void **state)
{
    ad_error error;
    (void)state;
    assert_int_equal(ad_dense_load(&error), AD_OK);
    compare(factor_matrices, ORDERS * (ORDER_MAX + 1));
}

/* What does not follow from numbers that all have. */
static void agree(ad_pool *pool, double *results)
{
    const ad_ranks *ranks = ad_pool_ranks(pool);
    const int rank = ranks ? ranks->rank : 0, last = ranks ? ranks->count - 1 : 0;
    double first[2] = {rank == 0 ? 5 : 0, rank == 0 ? -7 : 1};
    ad_ranks_first(ranks, 2, first);
    results[0] = first[0];
    results[1] = first[1];
    results[2] = ad_ranks_largest(ranks, rank == last ? 3 : -1);
    results[3] = ad_ranks_agree(ranks, 0xfedcba9876543210u);
    results[4] = last == 0 || !ad_ranks_agree(ranks, 0xfedcba9876543210u + (rank == last));
}

static void test_agreement(void **state)
{
    (void)state;
    compare(agree, 5);
}

/* ---- items of work --------------------------------------------------------------------------- */

enum { ITEMS = 301, EACH = 7, BYTES = 3 };

/* Item i makes EACH numbers, the last one two of them, and BYTES characters; those from `fails` on
 * fail. */
typedef struct items {
    double numbers[ITEMS * EACH - 5];
    char letters[ITEMS * BYTES];
    int fails;
    atomic_int done;
    atomic_bool asked;
} items;

/* Some take a hundred times as long as others. */
static double take_long(int item)
{
    volatile double x = item + 1;
    for (int k = 0; k < (item % 13 == 0 ? 20000 : 200); k++) {
        x = sin(x) + item;
    }
    return x;
}

static ad_status make_item(void *context, int item, int thread, ad_error *error)
{
    items *x = context;
    const double number = take_long(item);
    (void)thread;
    for (int k = 0; k < (item < ITEMS - 1 ? EACH : 2); k++) {
        x->numbers[item * EACH + k] = number + k;
    }
    for (int k = 0; k < BYTES; k++) {
        x->letters[item * BYTES + k] = (char)(item + k);
    }
    x->done++;
    return item >= x->fails ? ad_fail(error, AD_NOT_FINITE, "item %d", item) : AD_OK;
}

static bool is_asked(void *context)
{
    items *x = context;
    return x->asked;
}

static void test_one_item(ad_pool *pool, items *x)
{
    ad_error error;
    const ad_dealt all[2] = {{x->numbers, EACH * sizeof *x->numbers, sizeof x->numbers},
                             {x->letters, BYTES, sizeof x->letters}};
    memset(x, 0, sizeof *x);
    x->fails = ITEMS;
    assert_int_equal(ad_pool_deal(pool, 0, make_item, x, 2, all, &error), AD_OK);
    assert_int_equal(ad_pool_deal(pool, 1, make_item, x, 2, all, &error), AD_OK);
    assert_int_equal(x->done, 1);
}

/* Everyone has all that is made, the same first error, and stops when one is asked to. */
static void deal(ad_pool *pool, double *results)
{
    const ad_ranks *ranks = ad_pool_ranks(pool);
    const int rank = ranks ? ranks->rank : 0, count = ranks ? ranks->count : 1;
    ad_error error;
    items *x = calloc(1, sizeof *x);
    const ad_dealt all[2] = {{x->numbers, EACH * sizeof *x->numbers, sizeof x->numbers},
                             {x->letters, BYTES, sizeof x->letters}};
    test_one_item(pool, x);
    for (int i = 0; i < 3; i++) {
        memset(x, 0, sizeof *x);
        x->fails = ITEMS;
        assert_int_equal(ad_pool_deal(pool, ITEMS, make_item, x, 2, all, &error), AD_OK);
    }
    memcpy(results, x->numbers, sizeof x->numbers);
    memcpy(results + ITEMS * EACH - 5, x->letters, sizeof x->letters);
    double done = x->done;
    if (ranks) {
        double each[RANKS_MAX];
        size_t bounds[RANKS_MAX + 1] = {0};
        for (int i = 0; i < count; i++) {
            bounds[i + 1] = (size_t)i + 1;
        }
        each[rank] = x->done;
        ranks->gather(ranks->context, bounds, each);
        done = 0;
        for (int i = 0; i < count; i++) {
            done += each[i];
        }
    }
    assert_int_equal(done, ITEMS); /* each once */
    x->fails = 77;
    assert_int_equal(ad_pool_deal(pool, ITEMS, make_item, x, 2, all, &error), AD_NOT_FINITE);
    assert_string_equal(error.message, "item 77");
    x->fails = ITEMS;
    x->asked = rank == count - 1;
    ad_pool_watch(pool, is_asked, x);
    assert_int_equal(ad_pool_deal(pool, ITEMS, make_item, x, 2, all, &error), AD_OK);
    assert_true(ad_pool_stopped(pool));
    ad_pool_watch(pool, NULL, NULL);
    free(x);
}

static void test_items(void **state)
{
    (void)state;
    compare(deal, ITEMS * EACH + ITEMS);
}

/* Every point is somebody's. */
static void test_shares(void **state)
{
    (void)state;
    ad_error error;
    ad_tape *tape = ad_tape_create();
    ad_pool *pool = ad_pool_create(1);
    ad_program *program = NULL, *fine = NULL;
    ad_normal *normal = NULL;
    ad_value views[4], y = network(tape, views), outputs[4];
    assert_int_equal(ad_reverse(ad_sum_points(ad_square(y)), 4, views, AD_SUMMED, outputs), AD_OK);
    ad_settings settings = ad_settings_default();
    settings.tile = SMALL_TILE;
    assert_int_equal(ad_compile(4, outputs, NULL, pool, &program, &error), AD_OK);
    assert_int_equal(ad_compile(4, outputs, &settings, pool, &fine, &error), AD_OK);
    assert_int_equal(ad_normal_compile(1, &y, 4, views, PARAMETERS, pool, &normal, &error), AD_OK);
    for (int ranks = 1; ranks < PARAMETERS; ranks += 1 + ranks / 9) {
        size_t points = 0, rows = 0, busiest = 0;
        for (int i = 0; i < ranks; i++) {
            const ad_share share = ad_program_share(program, MANY, ranks, i),
                           leaves = ad_normal_share(normal, MANY, ranks, i),
                           many = ad_program_share(fine, LOTS, ranks, i);
            busiest = many.points > busiest ? many.points : busiest;
            assert_true(share.points == 0 || share.first == points); /* one after the other */
            assert_true(leaves.points == 0 || leaves.first == rows);
            points += share.points;
            rows += leaves.points;
        }
        assert_int_equal(points, MANY);
        assert_int_equal(rows, MANY);
        /* a chunk and a tile too many, at most, as long as there are leaves */
        assert_true(busiest <= (size_t)(LOTS / (ranks < 256 ? ranks : 256)) + LOTS / 256 + 64);
    }
    ad_normal_free(normal);
    ad_program_free(program);
    ad_program_free(fine);
    ad_pool_free(pool);
    ad_tape_free(tape);
}

/* ---- what ranks are about to do ---------------------------------------------------------------
 */

/* The line that differs is said, on every rank, with the rank that has it, and the error of one
 * that cannot begin; the first of them, if there are several. */
static void compare_texts(ad_pool *pool, double *results)
{
    static const struct {
        const char *usual, *odd, *says;
        ad_status own, status; /* of the odd rank before; of all, but for its own */
    } rows[] = {
        {"a: 1\nb: 2\n", "a: 1\nb: 2\n", NULL, AD_OK, AD_OK},
        {"a: 1\n  b: 2\nc\n", "a: 1\n  b: 3\nc\n", "'b: 3' there, 'b: 2' on", AD_OK, AD_BAD_INPUT},
        {"a: 1\n", "a: 1\nb: 2\n", "'b: 2' there, 'nothing' on", AD_OK, AD_BAD_INPUT},
        {"a: 1\nb: 2\n", "a: 1\n", "'nothing' there, 'b: 2' on", AD_OK, AD_BAD_INPUT},
        {"", "a\n", "'a' there, 'nothing' on", AD_OK, AD_BAD_INPUT},
        {"a\n", NULL, ": no scene", AD_IO, AD_IO},
    };
    const ad_ranks *ranks = ad_pool_ranks(pool);
    const int count = ranks ? ranks->count : 1;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        for (int odd = 1; odd < count; odd += 1 + count / 3) {
            const bool is_odd = ranks->rank == odd || (ranks->rank > odd && i % 2);
            ad_error error = {AD_OK, ""};
            char name[32];
            if (is_odd && rows[i].own != AD_OK) {
                ad_fail(&error, rows[i].own, "no scene");
            }
            const ad_status status = ranks_compare(ranks, is_odd ? rows[i].own : AD_OK,
                                                   is_odd ? rows[i].odd : rows[i].usual, &error);
            snprintf(name, sizeof name, "rank %d", odd);
            assert_int_equal(status, rows[i].status);
            if (rows[i].own == AD_OK && rows[i].says) {
                assert_non_null(strstr(error.message, rows[i].says));
            }
            if (rows[i].says && !(is_odd && rows[i].own != AD_OK)) {
                assert_memory_equal(error.message, name, strlen(name));
            }
        }
    }
    assert_int_equal(ranks_compare(NULL, AD_IO, NULL, NULL), AD_IO);
    results[0] = 1;
}

static void test_texts(void **state)
{
    (void)state;
    compare(compare_texts, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_programs), cmocka_unit_test(test_normal_equations),
        cmocka_unit_test(test_factors),  cmocka_unit_test(test_agreement),
        cmocka_unit_test(test_items),    cmocka_unit_test(test_shares),
        cmocka_unit_test(test_texts)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
