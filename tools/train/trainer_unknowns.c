#include "tools/train/trainer_unknowns.h"

#include "autodiff/dense.h"
#include "tools/train/measured_terms.h"
#include "tools/train/trainer_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX = SCENE_PARAMETERS_MAX };

/* Of the last parameters of x, [unknowns][unknowns]: A, their block of the inverse of the normal
 * equations, and A K A, with K what the measurements say of them where the others follow by the
 * equations; and [unknowns] the step that the normal equations would still take. */
static ad_status covariance_of(const trainer *t, size_t unknowns, double *inverse,
                               double *covariance, double *step, problem_noise *noise,
                               ad_error *error)
{
    const size_t count = t->e->count;
    double *matrix = malloc(2 * count * count * sizeof *matrix),
           *jtr = malloc(2 * count * sizeof *jtr);
    double *by_noise = matrix ? matrix + count * count : NULL;
    double *columns = malloc(unknowns * count * sizeof *columns);
    ad_dense_factor *factor = ad_dense_factor_create(count);
    ad_status status =
        matrix && jtr && columns && factor
            ? ad_dense_load(error)
            : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu parameters", count);
    const double *x = experiment_parameters(t->e);
    double loss, largest = 0, *damping = jtr ? jtr + count : NULL;
    status = status == AD_OK ? problem_normal_equations(t->problem, x, &loss, matrix, jtr, error)
                             : status;
    status = status == AD_OK ? problem_noise_of(t->problem, x, by_noise, noise, error) : status;
    for (size_t i = 0; status == AD_OK && i < count; i++) {
        largest = fmax(largest, matrix[i * count + i]);
    }
    bool factored = false;
    for (double part = 1e-14; status == AD_OK && !factored && part < 1e-3; part *= 10) {
        for (size_t i = 0; i < count; i++) {
            damping[i] = part * largest; /* what the equations do not determine stays as it is */
        }
        factored = ad_dense_cholesky(t->e->pool, matrix, damping, factor) == 0;
    }
    if (status == AD_OK && !factored) {
        status = ad_fail(error, AD_NOT_FINITE, "the normal equations cannot be factored");
    }
    for (size_t k = 0; status == AD_OK && k < unknowns; k++) {
        memset(columns + k * count, 0, count * sizeof *columns);
        columns[k * count + count - unknowns + k] = 1;
        ad_dense_cholesky_solve(factor, columns + k * count);
        step[k] = 0;
        for (size_t i = 0; i < count; i++) {
            step[k] -= columns[k * count + i] * jtr[i];
        }
    }
    for (size_t k = 0; status == AD_OK && k < unknowns * unknowns; k++) {
        const double *a = columns + k / unknowns * count, *b = columns + k % unknowns * count;
        inverse[k] = b[count - unknowns + k / unknowns];
        covariance[k] = 0;
        for (size_t i = 0; i < count; i++) { /* the upper triangle is kept */
            double row = by_noise[i * count + i] * b[i], column = 0;
            for (size_t j = i + 1; j < count; j++) {
                row += by_noise[i * count + j] * b[j];
                column += by_noise[i * count + j] * a[j];
            }
            covariance[k] += a[i] * row + b[i] * column;
        }
    }
    ad_dense_factor_free(factor);
    free(columns);
    free(jtr);
    free(matrix);
    return status;
}

/* What the measurements say by themselves of scalars of which the parts of the ranges go as slope:
 * K, from A, what they and the residuals of the equations say together, and A K A. Where the
 * equations are met at all values of the unknowns A is the inverse of K, but for the variance of
 * the measurements' rows. */
static void conclude(const trainer *t, const double *slope, const double *inverse,
                     const double *covariance, double variance, identified *result)
{
    const size_t count = (size_t)result->count;
    double a[MAX * MAX], x[MAX * MAX], information[MAX * MAX];
    int pivots[MAX];
    for (size_t i = 0; i < count * count; i++) {
        const double unit = slope[i / count] * slope[i % count];
        a[i] = inverse[i] * unit;
        x[i] = covariance[i] * unit;
    }
    result->held_by_equations = 0;
    for (size_t i = 0; i < count; i++) {
        const double share = 1 - variance * x[i * count + i] / a[i * count + i];
        result->held_by_equations =
            result->bounded[i] ? result->held_by_equations : fmax(result->held_by_equations, share);
    }
    if (ad_dense_lu(count, a, pivots) == 0) { /* symmetric, but for rounding */
        ad_dense_lu_solve(count, count, a, pivots, x);
        for (size_t i = 0; i < count * count; i++) {
            information[i] = x[i % count * count + i / count];
        }
        ad_dense_lu_solve(count, count, a, pivots, information);
    }
    identified_inform(result, t->e->scene, information);
}

/* Whether an unknown that never reaches an end of its range goes there: it is close, and what the
 * normal equations would still change of it leads beyond. */
static bool is_at_bound(double z, double step)
{
    static const double CLOSE = 1e-2, ALMOST = 1e-3;
    const double left = fmin(z, 1 - z);
    return left < ALMOST || (left < CLOSE && (z < 0.5 ? -step : step) >= left);
}

/* Of its deviation: a search has ended where the normal equations would change an unknown by less.
 */
static const double ENDED = 0.3;

ad_status trainer_unknowns(trainer *t, identified *result, ad_error *error)
{
    const scene *open = t->e->scene;
    const size_t count = (size_t)open->unknown_count;
    double inverse[MAX * MAX], covariance[MAX * MAX], values[MAX], slope[MAX], step[MAX], z[MAX];
    problem_noise noise;
    *result = (identified){.count = (int)count, .converged = true, .experiments = 1};
    if (count == 0) {
        return AD_OK;
    }
    experiment_member_values(t->e, values);
    for (size_t i = 0; i < count; i++) {
        const size_t k = (size_t)scene_known_count(open) + i;
        z[i] = scene_parameter_fraction(&open->parameters[k], values[k]);
        result->value[i] = values[k];
        result->growth[i][0] = result->growth[i][1] = NAN;
        slope[i] = z[i] * (1 - z[i]);
    }
    ad_status status = covariance_of(t, count, inverse, covariance, step, &noise, error);
    if (status != AD_OK) {
        return status;
    }
    noise.numbers -= measured_missing(t->e->measured);
    for (size_t i = 0; i < count; i++) {
        result->bounded[i] = result->held[i] = is_at_bound(z[i], step[i] * slope[i]);
    }
    result->steps = (int)t->fit.at.step;
    result->chi_squared = noise.chi_squared;
    result->residuals = noise.numbers;
    result->missing = measured_fields_missing(t->e->measured);
    result->scaled = !measured_tells_noise(t->e->measured);
    result->noise_factor = 1;
    if (result->scaled && noise.numbers > count) {
        result->noise_factor = sqrt(noise.chi_squared / (double)(noise.numbers - count));
    }
    conclude(t, slope, inverse, covariance, noise.variance, result);
    const double unit = measured_unit(t->e->measured); /* from that of the terms to the SI */
    result->noise_factor *= unit;
    result->chi_squared *= unit * unit;
    for (size_t i = 0; i < count; i++) { /* parts of the ranges, as both are */
        const double left = fabs(step[i] * slope[i]);
        result->converged = result->converged && (result->bounded[i] ||
                                                  left <= ENDED * result->information.deviation[i]);
    }
    return AD_OK;
}
