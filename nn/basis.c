/* Gram and Schmidt, each time with the function of which most is left, and twice, which is enough
 * to be orthogonal to rounding (Bjorck 1967; Daniel, Gragg, Kaufman & Stewart 1976). Coefficients
 * undergo the same steps as the values. */
#include "nn/basis.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS_PER_FUNCTION = 4 };

static const double PI = 3.14159265358979323846;

/* Root mean square of what is left of a function, below which it depends on the others. Those kept
 * have coefficients up to the inverse, and are smooth to rounding times that. */
static const double LEAST = 1e-12;

/* A column for each function: its values at the points above its coefficients. */
typedef struct nn_columns {
    size_t points, rows, count; /* rows = points + count */
    double *a;                  /* [rows][count] */
    double *products;           /* [count], work */
} nn_columns;

int nn_basis_functions(const nn_mlp_settings *settings)
{
    return 1 + settings->inputs + 2 * settings->fourier_features;
}

/* In the order in which a network stacks them. */
static void evaluate(const nn_mlp_settings *settings, const double *fourier, const double *x,
                     double *values)
{
    int inputs = settings->inputs, features = settings->fourier_features;
    *values++ = 1;
    memcpy(values, x, (size_t)inputs * sizeof *x);
    for (int k = 0; k < features; k++) {
        double phase = 0;
        for (int i = 0; i < inputs; i++)
            phase += fourier[k * inputs + i] * x[i];
        values[inputs + k] = sin(phase);
        values[inputs + features + k] = cos(phase);
    }
}

static void fill(const nn_columns *c, const nn_mlp_settings *settings, const double *fourier,
                 nn_rng *rng)
{
    double x[NN_INPUTS_MAX];
    for (size_t p = 0; p < c->points; p++) {
        for (int i = 0; i < settings->inputs; i++)
            x[i] = cos(nn_rng_between(rng, 0, PI));
        evaluate(settings, fourier, x, c->a + p * c->count);
    }
    for (size_t j = 0; j < c->count; j++)
        c->a[(c->points + j) * c->count + j] = 1;
}

/* Column k with every column, in the mean over the points; returns its mean square. */
static double multiply(const nn_columns *c, size_t k)
{
    memset(c->products, 0, c->count * sizeof *c->products);
    for (size_t p = 0; p < c->points; p++) {
        const double *row = c->a + p * c->count;
        for (size_t j = 0; j < c->count; j++)
            c->products[j] += row[k] * row[j] / (double)c->points;
    }
    return c->products[k];
}

/* The one from `first` on with the largest mean square. */
static size_t largest(const nn_columns *c, size_t first)
{
    size_t best = first;
    memset(c->products, 0, c->count * sizeof *c->products);
    for (size_t p = 0; p < c->points; p++) {
        const double *row = c->a + p * c->count;
        for (size_t j = first; j < c->count; j++)
            c->products[j] += row[j] * row[j];
    }
    for (size_t j = first; j < c->count; j++)
        best = c->products[j] > c->products[best] ? j : best;
    return best;
}

static void swap(const nn_columns *c, size_t j, size_t k)
{
    for (double *row = c->a; row < c->a + c->rows * c->count; row += c->count) {
        double kept = row[j];
        row[j] = row[k];
        row[k] = kept;
    }
}

/* Column k without those before it, of mean square 1; false when nothing is left of it. */
static bool normalize(const nn_columns *c, size_t k)
{
    multiply(c, k);
    for (double *row = c->a; row < c->a + c->rows * c->count; row += c->count) {
        for (size_t j = 0; j < k; j++)
            row[k] -= c->products[j] * row[j];
    }
    double size = sqrt(multiply(c, k));
    for (double *row = c->a; row < c->a + c->rows * c->count; row += c->count)
        row[k] /= size;
    return size > LEAST;
}

/* Columns behind k without column k. */
static void remove_from_rest(const nn_columns *c, size_t k)
{
    multiply(c, k);
    for (double *row = c->a; row < c->a + c->rows * c->count; row += c->count) {
        for (size_t j = k + 1; j < c->count; j++)
            row[j] -= c->products[j] * row[k];
    }
}

/* How many columns are left, 1 the first of them. */
static size_t orthonormalize(const nn_columns *c)
{
    for (size_t k = 0; k < c->count; k++) {
        swap(c, k, k > 0 ? largest(c, k) : 0);
        if (!normalize(c, k))
            return k;
        remove_from_rest(c, k);
    }
    return c->count;
}

ad_status nn_basis_create(const nn_mlp_settings *settings, const double *fourier, nn_rng *rng,
                          double **basis, int *rows, ad_error *error)
{
    size_t count = (size_t)nn_basis_functions(settings), points = POINTS_PER_FUNCTION * count;
    nn_columns c = {.points = points, .rows = points + count, .count = count};
    c.a = calloc(c.rows, count * sizeof *c.a);
    c.products = malloc(count * sizeof *c.products);
    *basis = malloc(count * count * sizeof **basis);
    ad_status status = AD_OK;
    if (c.a && c.products && *basis) {
        fill(&c, settings, fourier, rng);
        *rows = (int)orthonormalize(&c) - 1;
        for (size_t i = 0; i < (size_t)*rows * count; i++)
            (*basis)[i] = c.a[(points + i % count) * count + 1 + i / count];
    } else {
        free(*basis);
        *basis = NULL;
        status = ad_fail(error, AD_NO_MEMORY, "network: out of memory");
    }
    free(c.a);
    free(c.products);
    return status;
}
