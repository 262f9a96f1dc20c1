/* The residuals of a motion (model_motion), which are computed and not recorded. */
#include "physics/problem_internal.h"

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

/* Residuals at a point, weighted as those on tapes (problem_set.c), but for 1/points. */
static ad_status evaluate(problem *p, const problem_cloud *cloud, const double *x, size_t k,
                          bool derive, instant *at, ad_error *error)
{
    const model_motion *motion = p->model->motion;
    const double t = problem_time_of(p, cloud, k);
    at->y = p->motion_room;
    at->residual = at->y + 3 * motion->size;
    at->by = problem_weight_in_window(p, t);
    motion_network_state(p->motion, k, p->window > 0 ? p->setting.state : NULL, x, at->y);
    return motion->residual(motion->context, t, at->y, at->residual, derive ? at->slopes : NULL,
                            error);
}

/* Entry of J, but for its weight: of residual i by parameter j of output a. */
static double slope(const problem *p, const instant *at, size_t k, int i, int a, int j)
{
    const size_t entry = (size_t)i * (size_t)p->model->motion->stride + (size_t)a;
    double sum = 0;
    for (int d = 0; d < 3; d++) {
        sum += at->slopes[d][entry] * motion_network_values(p->motion, k, d)[j];
    }
    return sum;
}

/* Where parameter j of output a stands in the network's parameters. */
static size_t place_of(const problem *p, int a, int j)
{
    const int features = motion_network_functions(p->motion) - 1, size = p->model->motion->size;
    return j < features ? (size_t)(a * features + j) : (size_t)(size * features + a);
}

/* gradient += 2 by r dr/dx */
static void add_gradient(const problem *p, const instant *at, size_t k, double *gradient)
{
    const int size = p->model->motion->size, functions = motion_network_functions(p->motion);
    for (int a = 0; a < size; a++) {
        double sums[3] = {0};
        for (int i = 0; i < size; i++) {
            const double by = 2 * at->by * at->by * at->residual[i];
            for (int d = 0; d < 3; d++) {
                sums[d] +=
                    by * at->slopes[d][(size_t)i * (size_t)p->model->motion->stride + (size_t)a];
            }
        }
        for (int j = 0; j < functions; j++) {
            for (int d = 0; d < 3; d++) {
                gradient[place_of(p, a, j)] += sums[d] * motion_network_values(p->motion, k, d)[j];
            }
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
            add_gradient(p, &at, k, gradient);
        }
    }
    for (size_t i = 0; i < p->parameters && gradient; i++) {
        gradient[i] *= part;
    }
    return status;
}

/* J [rows][parameters], r [rows]: each residual times the root of its weight over the points. */
static ad_status list_rows(problem *p, const double *x, double *jacobian, double *r,
                           ad_error *error)
{
    const int size = p->model->motion->size, functions = motion_network_functions(p->motion);
    const problem_cloud *cloud = &p->sets[0].trained;
    const double root = sqrt(p->terms[0]->weight / (double)cloud->count);
    ad_status status = enter(p, cloud, error);
    for (size_t k = 0; k < cloud->count && status == AD_OK; k++) {
        instant at;
        status = evaluate(p, cloud, x, k, true, &at, error);
        const double by = root * at.by;
        for (int i = 0; i < size && status == AD_OK; i++) {
            const size_t row = k * (size_t)size + (size_t)i;
            r[row] = by * at.residual[i];
            for (int a = 0; a < size; a++) {
                for (int j = 0; j < functions; j++) {
                    jacobian[row * p->parameters + place_of(p, a, j)] =
                        by * slope(p, &at, k, i, a, j);
                }
            }
        }
    }
    return status;
}

static size_t rows_of(const problem *p)
{
    return p->sets[0].trained.count * (size_t)p->model->motion->size;
}

ad_status problem_motion_least_squares(problem *p, problem_least_squares *info, ad_error *error)
{
    const size_t rows = rows_of(p), numbers = rows * (p->parameters + 1);
    ad_status status = problem_motion_prepare(p, error);
    if (status == AD_OK && !p->motion_rows) {
        p->motion_rows = malloc(numbers * sizeof *p->motion_rows);
        status =
            p->motion_rows ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a motion");
    }
    *info = (problem_least_squares){rows, numbers * sizeof(double), numbers * sizeof(double)};
    return status;
}

ad_status problem_motion_normal(problem *p, const double *x, double *loss, double *jtj, double *jtr,
                                ad_error *error)
{
    const size_t rows = rows_of(p), count = p->parameters;
    double *jacobian = p->motion_rows, *r = jacobian + rows * count;
    ad_status status = list_rows(p, x, jacobian, r, error);
    if (status != AD_OK) {
        return status;
    }
    ad_dense_gram(p->pool, rows, count, jacobian, jtj);
    for (size_t row = 0; row < rows; row++) {
        *loss += r[row] * r[row];
        for (size_t i = 0; i < count; i++) {
            jtr[i] += r[row] * jacobian[row * count + i];
        }
    }
    return AD_OK;
}

ad_status problem_motion_jacobian(problem *p, const double *x, double *jt, double *r,
                                  ad_error *error)
{
    const size_t rows = rows_of(p), count = p->parameters;
    ad_status status = list_rows(p, x, p->motion_rows, r, error);
    for (size_t row = 0; row < rows && status == AD_OK; row++) {
        for (size_t i = 0; i < count; i++) {
            jt[i * rows + row] = p->motion_rows[row * count + i];
        }
    }
    return status;
}
