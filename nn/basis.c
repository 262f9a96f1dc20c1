/* Gram-Schmidt in the form that is stable: QR factors with column pivoting. The coefficients are
 * those of R^-1. */
#include "nn/basis.h"
#include "autodiff/dense.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_PER_FUNCTION = 4 };

static const double PI = 3.14159265358979323846;

/* Root mean square of what is left of a function, below which it depends on the others. Those kept
 * have coefficients up to the inverse, and are smooth to rounding times that. */
static const double LEAST = 1e-12;

int nn_basis_functions(const nn_mlp_settings *settings)
{
    return 1 + settings->inputs + 2 * settings->fourier_features;
}

/* In the order in which a network stacks them; values [functions] are `stride` apart. */
static void evaluate(const nn_mlp_settings *settings, const double *fourier, const double *x,
                     size_t stride, double *values)
{
    size_t inputs = (size_t)settings->inputs, features = (size_t)settings->fourier_features;
    values[0] = 1;
    for (size_t i = 0; i < inputs; i++) {
        values[(1 + i) * stride] = x[i];
    }
    for (size_t k = 0; k < features; k++) {
        double phase = 0;
        for (size_t i = 0; i < inputs; i++) {
            phase += fourier[k * inputs + i] * x[i];
        }
        values[(1 + inputs + k) * stride] = sin(phase);
        values[(1 + inputs + features + k) * stride] = cos(phase);
    }
}

/* Functions at points, [functions][points], divided by the root of the number of points. */
static void fill(const nn_mlp_settings *settings, const double *fourier, bool at_edges, nn_rng *rng,
                 size_t points, double *values)
{
    double x[NN_INPUTS_MAX] = {0};
    for (size_t p = 0; p < points; p++) {
        for (int i = at_edges; i < settings->inputs; i++) {
            x[i] = cos(nn_rng_between(rng, 0, PI));
        }
        evaluate(settings, fourier, x, points, values + p);
    }
    for (size_t i = 0; i < points * (size_t)nn_basis_functions(settings); i++) {
        values[i] /= sqrt((double)points);
    }
}

ad_status nn_basis_create(const nn_mlp_settings *settings, const double *fourier, bool at_edges,
                          nn_rng *rng, double **basis, int *rows, ad_error *error)
{
    size_t count = (size_t)nn_basis_functions(settings), points = POINTS_PER_FUNCTION * count;
    double *values = malloc(count * points * sizeof *values);
    double *all = malloc(count * count * sizeof *all);
    double *work = malloc(AD_DENSE_BASIS_WORK(count) * sizeof *work);
    int *order = malloc(count * sizeof *order);
    ad_status status = ad_dense_load(error);
    *basis = NULL;
    if (status == AD_OK && values && all && work && order) {
        fill(settings, fourier, at_edges, rng, points, values);
        size_t kept = ad_dense_basis(points, count, values, LEAST, all, order, work);
        *rows = (int)kept - 1; /* all but the constant, which is the bias */
        memmove(all, all + count, (kept - 1) * count * sizeof *all);
        *basis = all;
        all = NULL;
    } else if (status == AD_OK) {
        status = ad_fail(error, AD_NO_MEMORY, "network: out of memory");
    }
    free(values);
    free(all);
    free(work);
    free(order);
    return status;
}
