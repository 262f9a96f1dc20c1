/* For tests of the engine: random numbers, a naive interpreter of tapes (one node at a time over
 * ad_op_evaluate, nothing shared with the compiler), and compiled runs with chosen settings. */
#ifndef TESTS_AD_TESTING_H
#define TESTS_AD_TESTING_H

#include "autodiff/tape/tape.h"
#include "near.h"
#include "random_numbers.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- data of a run -----------------------------------------------------------------------------
 */

enum { LEAVES_MAX = 24, PARAMETERS_MAX = 8192 };

typedef struct run_data {
    size_t points, members; /* members: 0 is 1 */
    int inputs, uniforms;
    double *input[LEAVES_MAX], *uniform[LEAVES_MAX];
    double parameters[PARAMETERS_MAX];
} run_data;

static inline double *new_numbers(size_t count)
{
    double *numbers = calloc(count + 1, sizeof *numbers);
    assert_non_null(numbers);
    return numbers;
}

/* How many blocks a value has. */
static inline size_t blocks_of(const run_data *data, ad_extent extent)
{
    size_t members = data->members > 0 ? data->members : 1;
    return extent == AD_BATCH ? data->points : extent == AD_MEMBER ? members : 1;
}

/* Numbers in [low, high) for every leaf of the tape. */
static inline void data_fill_members(run_data *data, const ad_tape *tape, size_t points,
                                     size_t members, double low, double high, uint64_t *state)
{
    *data = (run_data){
        .points = points, .members = members, .inputs = tape->inputs, .uniforms = tape->uniforms};
    assert_true(tape->inputs <= LEAVES_MAX && tape->uniforms <= LEAVES_MAX);
    for (int i = 0; i < tape->inputs; i++) {
        size_t count =
            (size_t)tape->input_rows[i] * blocks_of(data, (ad_extent)tape->input_extent[i]);
        data->input[i] = new_numbers(count);
        for (size_t k = 0; k < count; k++)
            data->input[i][k] = random_in(state, low, high);
    }
    for (int i = 0; i < tape->uniforms; i++) {
        data->uniform[i] = new_numbers((size_t)tape->uniform_rows[i]);
        for (int k = 0; k < tape->uniform_rows[i]; k++)
            data->uniform[i][k] = random_in(state, low, high);
    }
    for (int k = 0; k < PARAMETERS_MAX; k++)
        data->parameters[k] = random_in(state, low, high);
}

static inline void data_fill(run_data *data, const ad_tape *tape, size_t points, double low,
                             double high, uint64_t *state)
{
    data_fill_members(data, tape, points, 0, low, high, state);
}

static inline void data_free(run_data *data)
{
    for (int i = 0; i < data->inputs; i++)
        free(data->input[i]);
    for (int i = 0; i < data->uniforms; i++)
        free(data->uniform[i]);
}

/* ---- naive interpreter -------------------------------------------------------------------------
 */

typedef struct naive {
    const ad_tape *tape;
    size_t points, members;
    int count;
    double **values; /* per node [rows][points], [rows][members] or [rows] */
} naive;

static inline double naive_at(const naive *n, int id, int row, size_t point)
{
    int extent = n->tape->nodes[id].extent;
    return n->values[id][extent == AD_BATCH    ? (size_t)row * n->points + point
                         : extent == AD_MEMBER ? (size_t)row * n->members + point
                                               : (size_t)row];
}

static inline double naive_sum(const naive *n, const int *x, int m, size_t point, int row, int op)
{
    int second = n->tape->nodes[x[1]].rows;
    double sum = 0;
    if (op == OP_MATVEC) {
        for (int k = 0; k < second; k++)
            sum += naive_at(n, x[0], row * second + k, point) * naive_at(n, x[1], k, point);
    } else {
        for (int k = 0; k < second; k++)
            sum += naive_at(n, x[0], k * m + row, point) * naive_at(n, x[1], k, point);
    }
    return sum;
}

static inline double naive_joined(const naive *n, const node *now, const int *x, int row,
                                  size_t point)
{
    int before = now->op == OP_PAD ? now->whole : 0;
    for (int i = 0; i < now->count; i++) {
        int rows = n->tape->nodes[x[i]].rows;
        if (row >= before && row < before + rows)
            return naive_at(n, x[i], row - before, point);
        before += rows;
    }
    return 0;
}

/* Of all points, of all members, or of the points of one member. */
static inline double naive_reduced(const naive *n, const node *now, const int *x, int row,
                                   size_t member)
{
    double sum = 0;
    int width = now->op == OP_OUTER_SUM ? n->tape->nodes[x[1]].rows : 1;
    size_t each = n->points / n->members, first = now->whole == OF_MEMBER ? member * each : 0;
    size_t end = now->whole == OF_MEMBER      ? first + each
                 : now->whole == OVER_MEMBERS ? n->members
                                              : n->points;
    for (size_t j = first; j < end; j++)
        sum += now->op == OP_SUM_POINTS
                   ? naive_at(n, x[0], row, j)
                   : naive_at(n, x[0], row / width, j) * naive_at(n, x[1], row % width, j);
    return sum;
}

static inline double naive_number(const naive *n, const node *now, int row, size_t point,
                                  const run_data *data)
{
    const int *x = n->tape->arguments + now->first;
    double arguments[AD_ARITY_MAX], sum = 0;
    switch (now->op) {
    case OP_CONSTANT:
        return now->splat ? now->number : n->tape->numbers[now->offset + (size_t)row];
    case OP_INPUT:
        return data
            ->input[now->whole][(size_t)row * blocks_of(data, (ad_extent)now->extent) + point];
    case OP_UNIFORM:
        return data->uniform[now->whole][row];
    case OP_PARAMETER:
        return data->parameters[now->offset + (size_t)row];
    case OP_POINTS:
        return now->whole == OVER_POINTS    ? (double)n->points
               : now->whole == OVER_MEMBERS ? (double)n->members
                                            : (double)n->points / (double)n->members;
    case OP_SPREAD:
        return naive_at(n, x[0], row, point / (n->points / n->members));
    case OP_SLICE:
        return naive_at(n, x[0], now->whole + row, point);
    case OP_STACK:
    case OP_PAD:
        return naive_joined(n, now, x, row, point);
    case OP_SUM_ROWS:
        for (int k = 0; k < n->tape->nodes[x[0]].rows; k++)
            sum += naive_at(n, x[0], k, point);
        return sum;
    case OP_SUM_POINTS:
    case OP_OUTER_SUM:
        return naive_reduced(n, now, x, row, point);
    case OP_MATVEC:
    case OP_MATVEC_TRANSPOSED:
        return naive_sum(n, x, now->rows, point, row, now->op);
    case OP_OUTER: {
        int width = n->tape->nodes[x[1]].rows;
        return naive_at(n, x[0], row / width, point) * naive_at(n, x[1], row % width, point);
    }
    default:
        assert_true(op_is_elementwise(now->op));
        for (int i = 0; i < now->count; i++)
            arguments[i] = naive_at(n, x[i], n->tape->nodes[x[i]].rows == 1 ? 0 : row, point);
        return ad_op_evaluate(now->op, now->whole, now->number, arguments);
    }
}

/* Every node of the tape, in order. */
static inline naive naive_run(const ad_tape *tape, const run_data *data)
{
    naive n = {.tape = tape,
               .points = data->points,
               .members = blocks_of(data, AD_MEMBER),
               .count = tape->count};
    n.values = calloc((size_t)tape->count, sizeof *n.values);
    assert_non_null(n.values);
    for (int id = 0; id < tape->count; id++) {
        const node *now = &tape->nodes[id];
        size_t width = blocks_of(data, (ad_extent)now->extent);
        n.values[id] = new_numbers((size_t)now->rows * width);
        for (int row = 0; row < now->rows; row++)
            for (size_t j = 0; j < width; j++)
                n.values[id][(size_t)row * width + j] = naive_number(&n, now, row, j, data);
    }
    return n;
}

static inline void naive_free(naive *n)
{
    for (int id = 0; id < n->count; id++)
        free(n->values[id]);
    free(n->values);
}

/* ---- compiled runs -----------------------------------------------------------------------------
 */

typedef struct compiled {
    ad_pool *pool;
    ad_program *program;
    int count;
    size_t sizes[32]; /* numbers per output at `points` points */
    double *results[32];
} compiled;

static inline compiled compile_values(int count, const ad_value *values,
                                      const ad_settings *settings, int threads)
{
    compiled c = {.pool = ad_pool_create(threads), .count = count};
    ad_error error = {.message = ""};
    assert_non_null(c.pool);
    assert_true(count <= 32);
    if (ad_compile(count, values, settings, c.pool, &c.program, &error) != AD_OK)
        fail_msg("compile: %s", error.message);
    return c;
}

static inline void compiled_execute(compiled *c, const ad_value *values, const run_data *data)
{
    ad_error error = {.message = ""};
    for (int i = 0; i < c->count; i++) {
        free(c->results[i]);
        c->sizes[i] = (size_t)ad_rows(values[i]) * blocks_of(data, ad_extent_of(values[i]));
        c->results[i] = new_numbers(c->sizes[i]);
        for (size_t k = 0; k < c->sizes[i]; k++)
            c->results[i][k] = 12345; /* what is not written is noticed */
    }
    ad_run run = {.points = data->points,
                  .inputs = (const double *const *)data->input,
                  .uniforms = (const double *const *)data->uniform,
                  .parameters = data->parameters,
                  .outputs = c->results,
                  .members = data->members};
    if (ad_execute(c->program, &run, &error) != AD_OK)
        fail_msg("execute: %s", error.message);
}

static inline compiled run_compiled(int count, const ad_value *values, const ad_settings *settings,
                                    int threads, const run_data *data)
{
    compiled c = compile_values(count, values, settings, threads);
    compiled_execute(&c, values, data);
    return c;
}

static inline void compiled_free(compiled *c)
{
    for (int i = 0; i < c->count; i++)
        free(c->results[i]);
    ad_program_free(c->program);
    ad_pool_free(c->pool);
}

/* Largest |result - naive| / max(1, largest |naive| of the output) over all outputs; infinite when
 * one is not a number and the other is. */
static inline double compiled_error(const compiled *c, const ad_value *values, const naive *n)
{
    double worst = 0;
    for (int i = 0; i < c->count; i++) {
        const double *expected = n->values[values[i].id];
        double scale = 1;
        for (size_t k = 0; k < c->sizes[i]; k++)
            scale = isfinite(expected[k]) ? fmax(scale, fabs(expected[k])) : scale;
        for (size_t k = 0; k < c->sizes[i]; k++) {
            double a = c->results[i][k], b = expected[k];
            if (a == b || (isnan(a) && isnan(b)))
                continue;
            double off = fabs(a - b) / scale;
            worst = isfinite(off) ? fmax(worst, off) : INFINITY;
        }
    }
    return worst;
}

/* Numbers of values on a tape at given leaves, by the compiled program with default settings. */
static inline double compiled_number(ad_value value, const run_data *data)
{
    compiled c = run_compiled(1, &value, NULL, 1, data);
    double result = c.results[0][0];
    compiled_free(&c);
    return result;
}

static inline void assert_tape_ok(const ad_tape *tape)
{
    ad_error error = {.message = ""};
    if (ad_tape_status(tape, &error) != AD_OK)
        fail_msg("tape: %s", error.message);
}

#endif
