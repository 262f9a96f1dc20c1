/* The linear map of a step, and what counts of its errors. */
#include "autodiff/dense.h"
#include "tools/surrogate/growth.h"
#include "tools/surrogate/training_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the mean of the diagonal, added to normal equations. */
static const double RIDGE = 1e-11;

/* ---- solved steps -------------------------------------------------------------------------- */

void surrogate_steps_free(surrogate_steps *steps)
{
    free(steps->state);
    free(steps->input);
    free(steps->next);
    for (int i = 0; i < SURROGATE_INNER; i++) {
        free(steps->inner[i]);
    }
    *steps = (surrogate_steps){0};
}

/* Room for so many numbers; false: none. */
static bool grow(double **array, size_t count)
{
    double *more = realloc(*array, (count + 1) * sizeof *more);
    *array = more ? more : *array;
    return more != NULL;
}

ad_status surrogate_steps_add(const excitation_rollouts *from, bool ramps, surrogate_steps *steps,
                              ad_error *error)
{
    const size_t n = (size_t)from->states, m = (size_t)from->inputs, all = ramps ? 2 * m : m;
    const size_t rows = (size_t)from->steps + 1;
    size_t at = steps->count, count = steps->count;
    for (int i = 0; i < from->count; i++) {
        count += (size_t)from->done[i];
    }
    if (!grow(&steps->state, count * n) || !grow(&steps->next, count * n) ||
        !grow(&steps->input, count * all)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for solved steps");
    }
    steps->count = count;
    for (int i = 0; i < from->count; i++) {
        for (size_t k = 0; k < (size_t)from->done[i]; k++, at++) {
            const size_t row = (size_t)i * rows + k;
            memcpy(steps->state + at * n, from->state + row * n, n * sizeof *steps->state);
            memcpy(steps->next + at * n, from->state + (row + 1) * n, n * sizeof *steps->next);
            memcpy(steps->input + at * all, from->input + row * m, all * sizeof *steps->input);
        }
    }
    return AD_OK;
}

/* ---- least squares within a class ---------------------------------------------------------- */

/* Numbers of a class: their places in z and, of states, which; of a pair's both components. */
typedef struct group {
    int count, outputs; /* numbers of z; those of states among them come first */
    int from, other;    /* first place in z, of second components; other < 0: none */
    bool constant;      /* even: a constant belongs to it */
} group;

static int groups_of(const surrogate_step *m, group groups[3])
{
    groups[0] = (group){m->pairs, m->out_pairs, 0, m->pairs, false};
    groups[1] = (group){m->evens, m->out_evens, 2 * m->pairs, -1, true};
    groups[2] = (group){m->odds, m->out_odds, 2 * m->pairs + m->evens, -1, false};
    return 3;
}

/* Row [features + outputs] of one sample and one component. */
static void fill_row(const surrogate_step *m, const group *g, bool other, const double *z,
                     const double *next, const double *factor, double *row)
{
    const int from = other ? g->other : g->from, blocks = 1 + 2 * m->slow_count;
    for (int b = 0; b < blocks; b++) {
        for (int k = 0; k < g->count; k++) {
            *row++ = factor[b] * z[from + k];
        }
    }
    if (g->constant) {
        *row++ = 1;
    }
    memcpy(row, next + from, (size_t)g->outputs * sizeof *row);
}

/* Least squares of the rows' outputs by their features, in the upper triangle of gram [size][size];
 * solution [outputs][features]. */
static ad_status solve(ad_pool *pool, int features, int outputs, const double *gram,
                       double *solution, ad_error *error)
{
    const size_t f = (size_t)features, size = f + (size_t)outputs;
    ad_dense_factor *factor = ad_dense_factor_create(f);
    double *matrix = malloc(f * f * sizeof *matrix), *shift = malloc(f * sizeof *shift), trace = 0;
    ad_status status = factor && matrix && shift
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for a linear map");
    for (size_t i = 0; i < f && status == AD_OK; i++) {
        memcpy(matrix + i * f, gram + i * size, f * sizeof *matrix);
        trace += gram[i * size + i];
    }
    for (size_t i = 0; i < f && status == AD_OK; i++) {
        shift[i] = trace > 0 ? RIDGE * trace / (double)f : 1; /* numbers that stay 0 */
    }
    if (status == AD_OK && ad_dense_cholesky(pool, matrix, shift, factor) != 0) {
        status = ad_fail(error, AD_NOT_FINITE, "the linear map of the solved steps is not finite");
    }
    for (size_t o = 0; o < (size_t)outputs && status == AD_OK; o++) {
        for (size_t i = 0; i < f; i++) {
            solution[o * f + i] = gram[i * size + f + o];
        }
        ad_dense_cholesky_solve(factor, solution + o * f);
    }
    ad_dense_factor_free(factor);
    free(matrix);
    free(shift);
    return status;
}

/* Into the numbers: solution [outputs][features] of a group, in coordinates. */
static void store(const surrogate_step *m, const group *g, bool other, const double *solution,
                  surrogate_numbers *to)
{
    const int n = m->states, all = m->ramps ? 2 * m->inputs : m->inputs;
    const int blocks = 1 + 2 * m->slow_count, features = blocks * g->count + g->constant;
    const int from = other ? g->other : g->from;
    for (int r = 0; r < n; r++) {
        const int o = m->state_slot[r] - from;
        if (o < 0 || o >= g->outputs) {
            continue;
        }
        const double *row = solution + o * features;
        const double out = to->state_scale[r];
        for (int b = 0; b < blocks; b++) {
            double *linear = to->linear + b * (n + all) * n;
            for (int k = 0; k < n; k++) {
                const int i = m->state_slot[k] - from;
                linear[k * n + r] +=
                    i >= 0 && i < g->count ? out * row[b * g->count + i] / to->state_scale[k] : 0;
            }
            for (int k = 0; k < m->drives; k++) {
                const int i = m->input_slot[k] - from;
                for (int u = 0; u < all && i >= 0 && i < g->count; u++) {
                    linear[(n + u) * n + r] +=
                        out * row[b * g->count + i] * to->input_map[u * m->drives + k];
                }
            }
        }
        to->next_center[r] = to->state_center[r] + (g->constant ? out * row[features - 1] : 0);
    }
}

/* The upper triangle of the products of rows with each other. */
static ad_status add_products(ad_pool *pool, const surrogate_step *m, const group *g,
                              const surrogate_steps *steps, double *gram, ad_error *error)
{
    enum { MOST = 2 * SURROGATE_STATES_MAX + 2 * SURROGATE_INPUTS_MAX };
    const int n = m->states, all = m->ramps ? 2 * m->inputs : m->inputs;
    const int size = (1 + 2 * m->slow_count) * g->count + g->constant + g->outputs;
    const size_t ends = g->other < 0 ? 1 : 2;
    const surrogate_numbers at = surrogate_numbers_of(m, (double *)m->numbers);
    double z[MOST], next[MOST], factor[1 + 2 * SURROGATE_SLOW_MAX] = {1};
    double *rows = malloc((steps->count * ends * (size_t)size + 1) * sizeof *rows);
    if (!rows) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a linear map");
    }
    for (size_t i = 0; i < steps->count; i++) {
        const double *u = steps->input + i * (size_t)all;
        surrogate_coordinates(m, steps->state + i * (size_t)n, u, z);
        surrogate_coordinates(m, steps->next + i * (size_t)n, u, next);
        for (int j = 0; j < m->slow_count; j++) {
            const int k = m->slow[j];
            const double c = 2 * (u[k] - at.input_center[k]) / (at.input_high[k] - at.input_low[k]);
            factor[1 + 2 * j] = c;
            factor[2 + 2 * j] = c * c;
        }
        for (size_t e = 0; e < ends; e++) {
            fill_row(m, g, e == 1, z, next, factor, rows + (i * ends + e) * (size_t)size);
        }
    }
    ad_dense_gram(pool, steps->count * ends, (size_t)size, rows, gram);
    free(rows);
    return AD_OK;
}

/* The frame turns with the bending one step ahead, by the linear map: a straight robot whose inputs
 * are about to bend it has a direction, too. Usual ones have length 1 in each component. */
static void lead(const surrogate_step *m, const group *g, const surrogate_steps *steps,
                 const double *solution, surrogate_numbers *to)
{
    enum { MOST = 2 * SURROGATE_STATES_MAX + 2 * SURROGATE_INPUTS_MAX };
    const int n = m->states, all = m->ramps ? 2 * m->inputs : m->inputs;
    const int features = (1 + 2 * m->slow_count) * g->count;
    double z[MOST], ahead[MOST] = {0}, square = 0;
    for (int o = 0; o < g->outputs; o++) {
        for (int k = 0; k < g->count; k++) {
            ahead[k] += to->lead[o] * solution[o * features + k];
        }
    }
    for (size_t i = 0; i < steps->count; i++) {
        double w[2] = {0, 0};
        surrogate_coordinates(m, steps->state + i * (size_t)n, steps->input + i * (size_t)all, z);
        for (int k = 0; k < g->count; k++) {
            w[0] += ahead[k] * z[k];
            w[1] += ahead[k] * z[g->count + k];
        }
        square += (w[0] * w[0] + w[1] * w[1]) / (2 * (double)steps->count);
    }
    for (int k = 0; k < g->count && square > 0; k++) {
        to->lead[k] = ahead[k] / sqrt(square);
    }
}

ad_status surrogate_fit_linear(ad_pool *pool, surrogate_step *m, double *numbers,
                               const surrogate_steps *steps, ad_error *error)
{
    group groups[3];
    surrogate_numbers to = surrogate_numbers_of(m, numbers);
    ad_status status = ad_dense_load(error);
    memset(to.linear, 0, (size_t)(to.state_scale - to.linear) * sizeof *numbers); /* groups add */
    for (int g = 0; g < groups_of(m, groups) && status == AD_OK; g++) {
        const group *now = &groups[g];
        const int features = (1 + 2 * m->slow_count) * now->count + now->constant;
        const int size = features + now->outputs;
        double *gram = calloc((size_t)(size * size + now->outputs * features) + 1, sizeof *gram);
        if (now->outputs > 0) {
            status = gram ? add_products(pool, m, now, steps, gram, error)
                          : ad_fail(error, AD_NO_MEMORY, "out of memory for a linear map");
            double *solution = gram + size * size;
            status = status == AD_OK ? solve(pool, features, now->outputs, gram, solution, error)
                                     : status;
            if (m->turns && now->other >= 0 && status == AD_OK) {
                lead(m, now, steps, solution, &to);
            }
            for (int part = 0; part < (now->other < 0 ? 1 : 2) && status == AD_OK; part++) {
                store(m, now, part == 1, solution, &to);
            }
        }
        free(gram);
    }
    return status;
}

/* ---- what counts --------------------------------------------------------------------------- */

/* q [n][n] = mean of C^T C, the derivatives of the tip's position in states that the robot visits.
 */
static ad_status see_tip(const surrogate_step *m, reduced_rod *rod, const surrogate_steps *steps,
                         double *by_state, double *q, ad_error *error)
{
    enum { SEEN = 500, ROWS = 3 };
    const size_t n = (size_t)m->states, all = (size_t)m->inputs * (m->ramps ? 2 : 1);
    const size_t seen = steps->count < SEEN ? steps->count : SEEN;
    ad_status status = AD_OK;
    reduced_place tip;
    for (size_t i = 0; i < seen && status == AD_OK; i++) {
        const size_t at = i * steps->count / seen;
        status = reduced_output(rod, 0, steps->state + at * n, steps->input + at * all, &tip,
                                by_state, error);
        for (size_t a = 0; a < n * n; a++) {
            for (size_t r = 0; r < ROWS; r++) {
                q[a] += by_state[r * n + a / n] * by_state[r * n + a % n] / (double)seen;
            }
        }
    }
    return status;
}

/* A fitted map that is not stable is allowed of a robot that is: its motions are only wide. */
static ad_status check_rest(ad_pool *pool, const surrogate_step *m, reduced_rod *rod, double fitted,
                            ad_error *error)
{
    double own;
    const ad_status status = surrogate_rest_growth(pool, rod, m->step, &own, error);
    return status != AD_OK || own <= SURROGATE_STABLE
               ? status
               : ad_fail(error, AD_BAD_INPUT,
                         "surrogate: the robot has no stable rest with its inputs in the middle "
                         "(deviations grow by a factor of %.4g a step, %.4g in the solved steps); "
                         "allowed: %s, or loops by the reduced rod (surrogate: null)",
                         own, fitted, surrogate_steadier);
}

ad_status surrogate_gramian(ad_pool *pool, const surrogate_step *m, reduced_rod *rod,
                            const surrogate_steps *steps, double *q, ad_error *error)
{
    enum {
        DOUBLINGS = 12
    }; /* of the steps that are summed: the slowest robots die out in so many */
    /* Where motions are so wide that the fitted map is not stable while the robot is, errors are
     * followed for some hundred steps: the map shrunk to this. */
    const double little = 1e-3, shrunk = 0.99;
    const size_t n = (size_t)m->states;
    const surrogate_numbers at = surrogate_numbers_of(m, (double *)m->numbers);
    double *room = calloc(3 * n * n + 12 * n + 1, sizeof *room), trace = 0;
    double *power = room, *next = room + n * n, *product = next + n * n;
    if (!room) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for what counts of errors");
    }
    const double fitted = surrogate_growth(pool, n, at.linear, room);
    ad_status status = fitted <= 1 ? AD_OK : check_rest(pool, m, rod, fitted, error);
    memset(q, 0, n * n * sizeof *q);
    memset(room, 0, (3 * n * n + 12 * n) * sizeof *room);
    for (size_t a = 0; a < n * n; a++) { /* A^T is [n][n] at the begin of the map */
        power[a] = at.linear[a] * (fitted <= 1 ? 1 : shrunk / fitted);
    }
    status = status == AD_OK ? see_tip(m, rod, steps, product + n * n, q, error) : status;
    for (int k = 0; k < DOUBLINGS && status == AD_OK; k++) {
        ad_dense_multiply(pool, false, true, n, n, n, q, power, 0, product); /* Q A^k */
        ad_dense_multiply(pool, false, false, n, n, n, power, product, 1, q);
        ad_dense_multiply(pool, false, false, n, n, n, power, power, 0, next);
        memcpy(power, next, n * n * sizeof *power);
    }
    for (size_t a = 0; a < n * n; a++) { /* by coordinates */
        q[a] *= at.state_scale[a / n] * at.state_scale[a % n];
        trace += a % (n + 1) == 0 ? q[a] : 0;
    }
    for (size_t a = 0; a < n; a++) {
        q[a * n + a] += little * trace / (double)n;
    }
    free(room);
    return status;
}
