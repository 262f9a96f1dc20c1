/* The residuals of a motion (model_motion), which are computed and not recorded. */
#include "physics/learn/problem_internal.h"

#include "autodiff/dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of one point: what its residuals count, y, residuals and where they stand in J. */
typedef struct instant {
    double by;
    double *y, *residual;    /* [3][size], [size] */
    const double *slopes[3]; /* [size rows of stride] */
} instant;

ad_status problem_motion_prepare(problem *p, ad_error *error)
{
    const size_t size = (size_t)p->model->motion->size;
    ad_status status = p->motion ? AD_OK : ad_dense_load(error);
    if (status == AD_OK && !p->motion) {
        status = motion_network_create(p->model, p->mlp, p->pool, &p->motion, error);
    }
    if (status == AD_OK && !p->motion_room) {
        p->motion_room = malloc(4 * size * sizeof *p->motion_room);
        status =
            p->motion_room ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    return status;
}

static ad_status enter(problem *p, const problem_cloud *cloud, ad_error *error)
{
    return motion_network_at(p->motion, p->window, cloud->count,
                             cloud->x + (size_t)p->model->domain.time * cloud->count, error);
}

/* As weight_in_window of problem_set.c. */
static double weight_at(const problem *p, double t)
{
    const double x = (t - p->setting.window[0]) / p->setting.window[1];
    return p->model->domain.windows == 1 ? 1 : (1 + x) / sqrt(7.0 / 3);
}

/* Residuals at a point, with what they count, but for 1/points. */
static ad_status evaluate(problem *p, const problem_cloud *cloud, const double *x, size_t k,
                          bool derive, instant *at, ad_error *error)
{
    const model_motion *motion = p->model->motion;
    const double t = problem_time_of(p, cloud, k);
    at->y = p->motion_room;
    at->residual = at->y + 3 * motion->size;
    at->by = weight_at(p, t);
    motion_network_state(p->motion, k, p->window > 0 ? p->setting.state : NULL, x, at->y);
    return motion->residual(motion->context, t, at->y, at->residual, derive ? at->slopes : NULL,
                            error);
}

/* to += factor r dr/dx: with f_d the functions of the point, those of output a by sum_d (S_d^T r)_a
 * f_d, S_d being the derivatives of r. */
static void add_gradient(const problem *p, const instant *at, size_t k, double factor, double *to)
{
    const int size = p->model->motion->size, functions = motion_network_functions(p->motion);
    const size_t stride = (size_t)p->model->motion->stride, features = (size_t)functions - 1;
    for (size_t a = 0; a < (size_t)size; a++) {
        double *weights = to + a * features, *bias = to + (size_t)size * features + a;
        for (int d = 0; d < 3; d++) {
            const double *value = motion_network_values(p->motion, k, d);
            double sum = 0;
            for (size_t i = 0; i < (size_t)size; i++) {
                sum += at->slopes[d][i * stride + a] * at->residual[i];
            }
            sum *= factor * at->by * at->by;
            for (size_t j = 0; j < features; j++) {
                weights[j] += sum * value[j];
            }
            *bias += sum * value[features];
        }
    }
}

ad_status problem_motion_run(problem *p, const problem_cloud *cloud, const double *x,
                             double *squares, double *mean, double *gradient, ad_error *error)
{
    const int size = p->model->motion->size;
    const double part = 1 / (double)cloud->count;
    ad_status status = problem_motion_prepare(p, error);
    status = status == AD_OK ? enter(p, cloud, error) : status;
    *mean = 0;
    if (gradient) {
        memset(gradient, 0, p->parameters * sizeof *gradient);
    }
    for (size_t k = 0; k < cloud->count && status == AD_OK; k++) {
        instant at;
        double square = 0;
        status = evaluate(p, cloud, x, k, gradient != NULL, &at, error);
        for (int i = 0; i < size && status == AD_OK; i++) {
            square += at.by * at.by * at.residual[i] * at.residual[i];
        }
        if (squares) {
            squares[k] = square;
        }
        *mean += square * part;
        if (gradient && status == AD_OK) {
            add_gradient(p, &at, k, 2 * part, gradient);
        }
    }
    return status;
}

ad_status problem_motion_loss(problem *p, const problem_cloud *cloud, const double *x,
                              double *terms, double *total, double *gradient, ad_error *error)
{
    const double weight = p->terms[0]->weight;
    const ad_status status = problem_motion_run(p, cloud, x, NULL, terms, gradient, error);
    *total = weight * *terms;
    for (size_t i = 0; gradient && i < p->parameters; i++) {
        gradient[i] *= weight;
    }
    return status;
}

/* ---- normal equations ---------------------------------------------------------------------- */

/* J^T J without J: its block of outputs a and b is
 *
 *   sum over points and d, e of  (S_d^T S_e)_ab f_d f_e^T
 *
 * which is a product with an inner dimension of three a point in place of one for each residual. */
typedef struct blocks {
    size_t size, functions, inner; /* inner: 3 points */
    double *stacked;               /* [size][3 size] S of a point */
    double *grams;                 /* [points][3 size][3 size] */
    double *values;                /* [inner][functions] */
    double *left, *product;        /* [inner][rows], [rows][functions] of the outputs from one on */
} blocks;

/* How many numbers there are, which begin at `memory`; NULL: there are none yet. */
static size_t list_blocks(const problem *p, double *memory, blocks *blocks)
{
    const size_t points = p->sets[0].trained.count;
    blocks->size = (size_t)p->model->motion->size;
    blocks->functions = (size_t)motion_network_functions(p->motion);
    blocks->inner = 3 * points;
    const size_t counts[] = {
        3 * blocks->size * blocks->size, points * 9 * blocks->size * blocks->size,
        blocks->inner * blocks->functions, blocks->size * blocks->functions * blocks->inner,
        blocks->size * blocks->functions * blocks->functions};
    double **const to[] = {&blocks->stacked, &blocks->grams, &blocks->values, &blocks->left,
                           &blocks->product};
    size_t numbers = 0;
    for (int i = 0; i < 5; i++) {
        *to[i] = memory ? memory + numbers : NULL;
        numbers += counts[i];
    }
    return numbers;
}

ad_status problem_motion_least_squares(problem *p, problem_least_squares *info, ad_error *error)
{
    blocks x;
    ad_status status = problem_motion_prepare(p, error);
    if (status != AD_OK) {
        return status;
    }
    const size_t numbers = list_blocks(p, NULL, &x);
    if (!p->motion_blocks) {
        p->motion_blocks = malloc(numbers * sizeof *p->motion_blocks);
    }
    *info = (problem_least_squares){
        .rows = x.size * x.inner / 3, .inner = x.inner, .bytes = numbers * sizeof(double)};
    return p->motion_blocks ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
}

/* What a point adds: its residuals are weighted by the root of their weight over the points. */
static void take_point(problem *p, const blocks *blocks, const instant *at, size_t k, double by)
{
    const size_t stride = (size_t)p->model->motion->stride;
    for (size_t i = 0; i < blocks->size; i++) {
        for (size_t d = 0; d < 3; d++) {
            for (size_t a = 0; a < blocks->size; a++) {
                blocks->stacked[(3 * i + d) * blocks->size + a] =
                    by * at->slopes[d][i * stride + a];
            }
        }
    }
    const size_t n = 3 * blocks->size;
    double *gram = blocks->grams + k * n * n;
    ad_dense_gram(p->pool, blocks->size, n, blocks->stacked, gram);
    for (size_t i = 0; i < n; i++) { /* its upper triangle */
        for (size_t j = 0; j < i; j++) {
            gram[i * n + j] = gram[j * n + i];
        }
    }
    for (size_t d = 0; d < 3; d++) {
        memcpy(blocks->values + (3 * k + d) * blocks->functions,
               motion_network_values(p->motion, k, (int)d),
               blocks->functions * sizeof *blocks->values);
    }
}

/* Rows of J^T J of output a, in which outputs before it are left out. */
static void list_left(const blocks *blocks, size_t a)
{
    const size_t rows = (blocks->size - a) * blocks->functions;
    for (size_t b = a; b < blocks->size; b++) {
        for (size_t k = 0; k < blocks->inner / 3; k++) {
            const size_t n = 3 * blocks->size;
            const double *gram = blocks->grams + k * n * n + a * n + b;
            double by[3][3];
            for (size_t d = 0; d < 3; d++) {
                for (size_t e = 0; e < 3; e++) {
                    by[d][e] = gram[e * blocks->size * n + d * blocks->size];
                }
            }
            const double *f = blocks->values + 3 * k * blocks->functions;
            for (size_t e = 0; e < 3; e++) {
                double *to = blocks->left + (3 * k + e) * rows + (b - a) * blocks->functions;
                for (size_t j = 0; j < blocks->functions; j++) {
                    to[j] = by[0][e] * f[j] + by[1][e] * f[blocks->functions + j] +
                            by[2][e] * f[2 * blocks->functions + j];
                }
            }
        }
    }
}

/* Where function j of output a stands in the network's parameters. */
static size_t place_of(const blocks *blocks, size_t a, size_t j)
{
    const size_t features = blocks->functions - 1;
    return j < features ? a * features + j : blocks->size * features + a;
}

static void put_product(const problem *p, const blocks *blocks, size_t a, double *jtj)
{
    for (size_t b = a; b < blocks->size; b++) {
        for (size_t i = 0; i < blocks->functions; i++) {
            const size_t row = place_of(blocks, b, i);
            const double *from =
                blocks->product + ((b - a) * blocks->functions + i) * blocks->functions;
            for (size_t j = 0; j < blocks->functions; j++) {
                const size_t column = place_of(blocks, a, j);
                const size_t low = row < column ? row : column;
                jtj[low * p->parameters + row + column - low] = from[j];
            }
        }
    }
}

ad_status problem_motion_normal(problem *p, const double *x, double *loss, double *jtj, double *jtr,
                                ad_error *error)
{
    blocks all;
    const problem_cloud *cloud = &p->sets[0].trained;
    const double part = p->terms[0]->weight / (double)cloud->count;
    ad_status status = enter(p, cloud, error);
    list_blocks(p, p->motion_blocks, &all);
    for (size_t k = 0; k < cloud->count && status == AD_OK; k++) {
        instant at;
        status = evaluate(p, cloud, x, k, true, &at, error);
        if (status == AD_OK) {
            take_point(p, &all, &at, k, sqrt(part) * at.by);
            add_gradient(p, &at, k, part, jtr);
        }
        for (size_t i = 0; i < all.size; i++) {
            *loss += part * at.by * at.by * at.residual[i] * at.residual[i];
        }
    }
    for (size_t a = 0; a < all.size && status == AD_OK; a++) {
        list_left(&all, a);
        ad_dense_multiply(p->pool, true, false, (all.size - a) * all.functions, all.functions,
                          all.inner, all.left, all.values, 0, all.product);
        put_product(p, &all, a, jtj);
    }
    return status;
}
