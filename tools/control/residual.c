#include "tools/control/residual_internal.h"

#include "physics/numerics/vector_size.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

ad_status residual_create(const one_step *of, int units, const double *size, const double *middle,
                          const double *half, residual **result, ad_error *error)
{
    const size_t n = (size_t)of->states, m = (size_t)of->inputs;
    *result = NULL;
    if (n + m > LEARNED_WIDTH_MAX) {
        return ad_fail(error, AD_BAD_INPUT,
                       "a residual of %zu states and %zu inputs; allowed: at most %d of both", n, m,
                       LEARNED_WIDTH_MAX);
    }
    residual *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a residual of %d units", units);
    }
    *x = (residual){.of = *of, .states = n, .inputs = m, .seen = n + m, .anew = 0};
    x->net = (learned_net){.inputs = (int)(n + m), .outputs = of->states, .hidden_count = 1};
    x->net.hidden[0] = units;
    memcpy(x->net.size, size, n * sizeof *size);
    memcpy(x->net.half, size, n * sizeof *size);
    memcpy(x->net.middle + n, middle, m * sizeof *middle);
    memcpy(x->net.half + n, half, m * sizeof *half);
    x->count = learned_net_count(&x->net);
    x->pool = ad_pool_create(1);
    AD_TAKE(x, theta, x->count);
    AD_TAKE(x, covariance, x->count * x->count);
    AD_TAKE(x, by_theta, x->count * n);
    AD_TAKE(x, change, x->count * n);
    ad_status status = x->memory.is_short || !x->pool
                           ? ad_fail(error, AD_NO_MEMORY, "out of memory for a residual")
                           : ad_dense_load(error);
    status = status == AD_OK ? learned_tape_create(&x->net, &x->tape, error) : status;
    if (status != AD_OK) {
        residual_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void residual_free(residual *residual)
{
    if (residual) {
        ad_memory_free(&residual->memory);
        learned_tape_free(residual->tape);
        ad_pool_free(residual->pool);
        free(residual->x);
        free(residual);
    }
}

residual_reach residual_reached(const residual *residual)
{
    return residual ? residual->reach : (residual_reach){NAN, NAN};
}

size_t residual_count(const residual *residual)
{
    return residual->count;
}

/* ---- a step -------------------------------------------------------------------------------- */

bool residual_say(residual *residual, size_t points, const double *states, const double *inputs,
                  bool by_x, double *by_theta)
{
    const size_t n = residual->states, m = residual->inputs, seen = residual->seen;
    if (residual->points < points) {
        free(residual->x);
        residual->x = malloc((seen + n + seen * n) * points * sizeof *residual->x);
        residual->points = residual->x ? points : 0;
    }
    if (!residual->x) {
        return false;
    }
    residual->y = residual->x + seen * points;
    residual->by_x = residual->y + n * points;
    for (size_t i = 0; i < points; i++) {
        for (size_t k = 0; k < seen; k++) {
            residual->x[k * points + i] = k < n ? states[i * n + k] : inputs[i * m + k - n];
        }
    }
    return learned_tape_run(residual->tape, &residual->net, points, residual->x, residual->theta,
                            residual->y, by_theta, by_x ? residual->by_x : NULL, NULL) == AD_OK;
}

/* Of the network, to by [points][states][count], those of what it sees from `first` on. */
static void add_derivatives(const residual *residual, size_t points, double h, size_t first,
                            size_t count, double *by)
{
    const size_t n = residual->states;
    for (size_t i = 0; i < points; i++) {
        for (size_t r = 0; r < n; r++) {
            for (size_t c = 0; c < count; c++) {
                by[(i * n + r) * count + c] +=
                    h * residual->by_x[((first + c) * n + r) * points + i];
            }
        }
    }
}

static int advance(void *context, int count, double h, const double *states, const double *inputs,
                   const double *after, double *next, double *by_state, double *by_inputs)
{
    residual *residual = context;
    const size_t n = residual->states, m = residual->inputs, points = (size_t)count;
    if (residual->of.advance(residual->of.context, count, h, states, inputs, after, next, by_state,
                             by_inputs) ||
        !residual_say(residual, points, states, inputs, by_state || by_inputs, NULL)) {
        return 1;
    }
    for (size_t i = 0; i < points * n; i++) {
        next[i] += h * residual->y[i % n * points + i / n];
    }
    if (by_state) {
        add_derivatives(residual, points, h, 0, n, by_state);
    }
    if (by_inputs) {
        add_derivatives(residual, points, h, n, m, by_inputs);
    }
    return 0;
}

bool residual_push(residual *residual, double h, const double *state, const double *inputs,
                   const double *by_state, const double *before, double *after)
{
    const size_t n = residual->states, count = residual->count;
    if (!residual_say(residual, 1, state, inputs, false, residual->by_theta)) {
        return false;
    }
    for (size_t r = 0; r < n; r++) {
        for (size_t i = 0; i < count; i++) {
            after[r * count + i] = h * residual->by_theta[i * n + r];
        }
    }
    ad_dense_multiply(residual->pool, false, false, n, count, n, by_state, before, 1, after);
    return true;
}

ad_status residual_see(residual *residual, size_t values, ad_error *error)
{
    const size_t n = residual->states;
    residual->values = values;
    AD_TAKE(residual, sight, values * n);
    AD_TAKE(residual, turn, n * values);
    AD_TAKE(residual, room, values * (2 * residual->count + n + values));
    AD_TAKE(residual, pivots, values + n);
    AD_TAKE(residual, rest, n * (2 * n + 2 + residual->inputs));
    return ad_memory_status(&residual->memory, error, "out of memory for a residual");
}

bool residual_turn(residual *residual)
{
    const size_t n = residual->states, v = residual->values;
    double *turn = residual->turn, *square = residual->room, trace = 0;
    for (size_t c = 0; c < n; c++) {
        for (size_t i = 0; i < v; i++) {
            turn[c * v + i] = residual->sight[i * n + c] * pow(residual->net.half[c], 2);
        }
    }
    ad_dense_multiply(residual->pool, false, false, v, v, n, residual->sight, turn, 0, square);
    for (size_t i = 0; i < v; i++) {
        trace += square[i * (v + 1)];
    }
    for (size_t i = 0; i < v; i++) { /* also where something does not move at all */
        square[i * (v + 1)] += 1e-9 * trace;
    }
    const bool good = ad_dense_lu(v, square, residual->pivots) == 0;
    if (good) {
        ad_dense_lu_solve(v, n, square, residual->pivots, turn);
    }
    return good;
}

void residual_doubt(residual *residual, double h, const double *change, double *covariance)
{
    const size_t n = residual->states, count = residual->count, v = residual->values;
    double *seen = residual->room, *product = seen + v * count;
    double *square = product + v * count, *both = square + v * v;
    ad_pool *pool = residual->pool;
    ad_dense_multiply(pool, false, false, v, count, n, residual->sight, change, 0, seen);
    ad_dense_multiply(pool, false, false, v, count, count, seen, residual->covariance, 0, product);
    ad_dense_multiply(pool, false, true, v, v, count, seen, product, 0, square);
    for (size_t i = 0; i < v; i++) {
        residual->reach.most = fmax(residual->reach.most, sqrt(square[i * (v + 1)]));
    }
    ad_dense_multiply(pool, false, false, n, v, v, residual->turn, square, 0, both);
    ad_dense_multiply(pool, false, true, n, n, v, both, residual->turn, 0, covariance);
    for (size_t i = 0; i < n * n; i++) {
        covariance[i] *= h * residual->anew;
    }
}

/* (I - A)^-1 [n][n] of a step with derivative A, by columns. Whether there is one. */
static bool find_rest(residual *residual, double h, const double *state, const double *inputs,
                      double *next, double *by_inputs, double *rest)
{
    const size_t n = residual->states;
    double *by_state = rest + n * n;
    if (advance(residual, 1, h, state, inputs, NULL, next, by_state, by_inputs)) {
        return false;
    }
    for (size_t i = 0; i < n * n; i++) {
        rest[i] = i % (n + 1) == 0;
        by_state[i] = rest[i] - by_state[i];
    }
    if (ad_dense_lu(n, by_state, residual->pivots)) { /* of the transpose, read by columns */
        return false;
    }
    ad_dense_lu_solve(n, n, by_state, residual->pivots, rest);
    return true;
}

bool residual_settle(residual *residual, double h, const double *inputs, double *state, double *by)
{
    enum { STEPS = 20 };
    const size_t n = residual->states, m = residual->inputs;
    double *rest = residual->rest, *now = rest + 2 * n * n, *next = now + n, *by_inputs = next + n;
    double off = INFINITY;
    memcpy(now, state, n * sizeof *now);
    for (int step = 0; step < STEPS && off > 1e-10; step++) {
        if (!find_rest(residual, h, now, inputs, next, by_inputs, rest)) {
            return false;
        }
        for (size_t i = 0; i < n; i++) {
            next[i] -= now[i];
        }
        ad_dense_multiply(residual->pool, false, false, n, 1, n, rest, next, 1, now);
        off = 0;
        for (size_t i = 0; i < n; i++) {
            off = fmax(off, fabs(next[i]) / residual->net.half[i]);
        }
    }
    if (!(off <= 1e-10)) {
        return false;
    }
    memcpy(state, now, n * sizeof *state);
    ad_dense_multiply(residual->pool, false, false, n, m, n, rest, by_inputs, 0, by);
    return true;
}

/* The change of a state at rest by each number [states][count]. Whether there is one. */
static bool begin(residual *residual, double h, const double *state, const double *inputs,
                  double *change)
{
    const size_t n = residual->states, count = residual->count;
    double *rest = residual->rest;
    if (!find_rest(residual, h, state, inputs, rest + 2 * n * n, NULL, rest) ||
        !residual_say(residual, 1, state, inputs, false, residual->by_theta)) {
        return false;
    }
    for (size_t i = 0; i < n * n; i++) {
        rest[i] *= h;
    }
    ad_dense_multiply(residual->pool, false, true, n, count, n, rest, residual->by_theta, 0,
                      change);
    return vector_is_finite(n * count, change);
}

static int doubt(void *context, double h, const double *state, const double *inputs,
                 const double *by_state, double *memory, double *covariance)
{
    residual *residual = context;
    const size_t n = residual->states, size = n * residual->count * sizeof *memory;
    bool known = by_state
                     ? residual_push(residual, h, state, inputs, by_state, memory, residual->change)
                     : begin(residual, h, state, inputs, residual->change);
    if (by_state) {
        residual_doubt(residual, h, residual->change, covariance);
    }
    for (size_t i = 0; i < n * n && by_state; i++) {
        known = known && fabs(covariance[i]) < 1e100;
    }
    if (known) {
        memcpy(memory, residual->change, size);
    } else {
        memset(memory, 0, size);
    }
    return !known;
}

static double outside(void *context, const double *state, const double *inputs)
{
    const residual *residual = context;
    return residual->of.outside(residual->of.context, state, inputs);
}

one_step residual_one_step(residual *residual)
{
    one_step result = residual->of;
    result.context = residual;
    result.advance = advance;
    result.outside = residual->of.outside ? outside : NULL;
    result.doubts = residual->values > 0 ? (int)(residual->states * residual->count) : 0;
    result.doubt = doubt;
    return result;
}
