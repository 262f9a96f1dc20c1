#include "physics/learn/evaluator_table.h"

#include "physics/learn/motion_network.h"
#include "physics/learn/window_state.h"
#include "physics/numerics/constants.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Points of a piece of s, of a window of time: what is a polynomial of degree 15 in time turns and
 * bends the rod, so that positions are met to some 1e-11 by more. */
enum { ALONG = 20, TIMES = 24, EACH = ALONG * TIMES };

/* Chebyshev's polynomials T_k(x), k < count. */
static ad_value polynomials(ad_value x, int count)
{
    ad_value rows[TIMES];
    rows[0] = ad_scalar(x.tape, 1);
    rows[1] = x;
    for (int k = 2; k < count; k++) {
        rows[k] = ad_sub(ad_scale(ad_mul(x, rows[k - 1]), 2), rows[k - 2]);
    }
    return ad_stack(count, rows);
}

/* The domain with the motion's own pieces along s. */
static domain in_pieces(const physics_model *m)
{
    domain d = m->domain;
    d.pieces = m->motion->pieces;
    memcpy(d.edge, m->motion->edges, ((size_t)d.pieces + 1) * sizeof *d.edge);
    return d;
}

size_t evaluator_table_numbers(const physics_model *m, int columns)
{
    return (size_t)m->motion->pieces * EACH * (size_t)columns;
}

ad_value evaluator_table_record(const physics_model *m, int columns, const domain_place *at,
                                ad_value numbers)
{
    const domain d = in_pieces(m);
    const domain_local local = domain_local_of(&d, at->x[0]);
    ad_value along = polynomials(local.x, ALONG), products[TIMES],
             sum = ad_zeros(at->tape, columns);
    ad_value times = polynomials(domain_unit(&m->domain, at, m->domain.time), TIMES);
    for (int k = 0; k < TIMES; k++) {
        products[k] = ad_mul(ad_row(times, k), along);
    }
    ad_value all = ad_stack(TIMES, products);
    for (int k = 0; k < d.pieces; k++) {
        ad_value here = ad_slice(numbers, k * EACH * columns, EACH * columns);
        sum = ad_add(sum, ad_mul(local.mask[k], ad_matvec_transposed(here, all)));
    }
    return sum;
}

/* ---- from values to coefficients ----------------------------------------------------------- */

/* Chebyshev's points of [-1, 1], which leave out its ends. */
static double point(int j, int count)
{
    return cos(PI * (j + 0.5) / count);
}

/* Coefficients of T_k, k < count, from values at those points. */
static void transform(const double *values, int count, double *coefficients)
{
    for (int k = 0; k < count; k++) {
        double sum = 0;
        for (int j = 0; j < count; j++) {
            sum += values[j] * cos(PI * k * (j + 0.5) / count);
        }
        coefficients[k] = sum * (k > 0 ? 2 : 1) / count;
    }
}

/* numbers [TIMES][ALONG] of one column from its values [TIMES][ALONG], both `stride` apart. */
static void transform_both(const double *values, size_t stride, double *numbers)
{
    double rows[TIMES][ALONG], line[TIMES], found[TIMES];
    for (int i = 0; i < TIMES; i++) {
        transform(values + (size_t)i * ALONG, ALONG, rows[i]);
    }
    for (int k = 0; k < ALONG; k++) {
        for (int i = 0; i < TIMES; i++) {
            line[i] = rows[i][k];
        }
        transform(line, TIMES, found);
        for (int i = 0; i < TIMES; i++) {
            numbers[(size_t)(i * ALONG + k) * stride] = found[i];
        }
    }
}

static void place_points(const domain *d, int window, int piece, double *s, double *t)
{
    const double begin = domain_window_time(d, window), end = domain_window_time(d, window + 1);
    double low, high;
    domain_piece(d, piece, &low, &high);
    for (int i = 0; i < EACH; i++) {
        s[i] = low + (high - low) * (1 + point(i % ALONG, ALONG)) / 2;
        t[i] = begin + (end - begin) * (1 + point(i / ALONG, TIMES)) / 2;
    }
}

ad_status evaluator_table_fill(const evaluator_model *model, int columns, const int *which,
                               ad_pool *pool, double *table, ad_error *error)
{
    const physics_model *m = model->physics;
    const domain d = in_pieces(m);
    const size_t parameters = nn_mlp_parameters(model->mlp), state = window_state_numbers(m);
    double s[EACH], t[EACH];
    double *values = malloc((size_t)m->column_count * EACH * sizeof *values);
    motion_network *network = NULL;
    ad_status status = values ? motion_network_create(m, model->mlp, pool, &network, error)
                              : ad_fail(error, AD_NO_MEMORY, "out of memory for a table");
    for (int i = 0; i < model->windows * d.pieces && status == AD_OK; i++) {
        const int window = i / d.pieces;
        const double *start = window > 0 ? model->starts + (size_t)window * state : NULL;
        place_points(&d, window, i % d.pieces, s, t);
        status = motion_network_observe(network, window, start,
                                        model->parameters + (size_t)window * parameters, EACH, s, t,
                                        m->column_count, values, error);
        for (int c = 0; c < columns && status == AD_OK; c++) {
            transform_both(values + (size_t)which[c] * EACH, (size_t)columns, table + c);
        }
        table += EACH * columns;
    }
    motion_network_free(network);
    free(values);
    return status;
}
