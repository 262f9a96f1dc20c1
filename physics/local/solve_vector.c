#include "physics/local/solve_vector.h"

#include "physics/numerics/processor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- operations ---------------------------------------------------------------------------- */

/* Each takes what the function of the same name in sundials_nvector.h takes; results may be
 * arguments. */

static void fill(realtype value, N_Vector z)
{
    sunindextype n = NV_LENGTH_S(z);
    double *to = NV_DATA_S(z);
    for (sunindextype i = 0; i < n; i++) {
        to[i] = value;
    }
}

FOR_EACH_PROCESSOR static void scale(realtype a, N_Vector x, N_Vector z)
{
    sunindextype n = NV_LENGTH_S(z);
    const double *from = NV_DATA_S(x);
    double *to = NV_DATA_S(z);
    for (sunindextype i = 0; i < n; i++) {
        to[i] = a * from[i];
    }
}

FOR_EACH_PROCESSOR static void linear_sum(realtype a, N_Vector x, realtype b, N_Vector y,
                                          N_Vector z)
{
    sunindextype n = NV_LENGTH_S(z);
    const double *p = NV_DATA_S(x), *q = NV_DATA_S(y);
    double *to = NV_DATA_S(z);
    for (sunindextype i = 0; i < n; i++) {
        to[i] = a * p[i] + b * q[i];
    }
}

/* A block of the sum, before any of it is stored: the result may be among the vectors. */
FOR_EACH_PROCESSOR static int linear_combination(int count, realtype *c, N_Vector *Vector,
                                                 N_Vector z)
{
    sunindextype n = NV_LENGTH_S(z), i = 0;
    double *to = NV_DATA_S(z);
    for (; i + LANES + LANES <= n; i += LANES + LANES) {
        lanes sum = {0}, next_sum = {0};
        for (int k = 0; k < count; k++) {
            const lanes *from = (const lanes *)(NV_DATA_S(Vector[k]) + i);
            sum += c[k] * from[0];
            next_sum += c[k] * from[1];
        }
        memcpy(to + i, &sum, sizeof sum);
        memcpy(to + i + LANES, &next_sum, sizeof sum);
    }
    for (; i < n; i++) {
        double sum = 0;
        for (int k = 0; k < count; k++) {
            sum += c[k] * NV_DATA_S(Vector[k])[i];
        }
        to[i] = sum;
    }
    return 0;
}

static realtype wrms_norm(N_Vector x, N_Vector weight)
{
    sunindextype n = NV_LENGTH_S(x);
    const double *p = NV_DATA_S(x), *w = NV_DATA_S(weight);
    double sum[4] = {0}; /* additions that need not wait for one another */
    sunindextype i = 0;
    for (; i + 4 <= n; i += 4) {
        for (int k = 0; k < 4; k++) {
            double term = p[i + k] * w[i + k];
            sum[k] += term * term;
        }
    }
    for (; i < n; i++) {
        sum[0] += p[i] * w[i] * p[i] * w[i];
    }
    return sqrt((sum[0] + sum[1] + sum[2] + sum[3]) / (double)n);
}

/* ---- vectors ------------------------------------------------------------------------------- */

N_Vector solve_vector_create(size_t rows, SUNContext context)
{
    N_Vector vector = N_VNew_Serial((sunindextype)rows, context);
    if (vector) {
        vector->ops->nvconst = fill;
        vector->ops->nvscale = scale;
        vector->ops->nvlinearsum = linear_sum;
        vector->ops->nvlinearcombination = linear_combination;
        vector->ops->nvwrmsnorm = wrms_norm;
    }
    return vector;
}

bool solve_vectors_fit(size_t rows)
{
    const size_t clones = 32, besides = (size_t)1 << 20;
    void *volatile tried = malloc(clones * rows * sizeof(double) + besides);
    const bool fit = tried != NULL;
    free(tried);
    return fit;
}

/* ---- for states of a rod ------------------------------------------------------------------- */

FOR_EACH_PROCESSOR static void weigh(sunindextype n, double tolerance, const double *from,
                                     double *to)
{
    for (sunindextype i = 0; i < n; i++) {
        to[i] = 1 / (tolerance * (1 + fabs(from[i])));
    }
}

void solve_vector_weigh(double tolerance, N_Vector x, N_Vector weight)
{
    weigh(NV_LENGTH_S(x), tolerance, NV_DATA_S(x), NV_DATA_S(weight));
}

bool solve_vector_is_finite(N_Vector x)
{
    sunindextype n = NV_LENGTH_S(x), i = 0;
    const double *from = NV_DATA_S(x);
    double zero[4] = {0}; /* not a number as soon as one is not finite */
    for (; i + 4 <= n; i += 4) {
        for (int k = 0; k < 4; k++) {
            zero[k] += 0 * from[i + k];
        }
    }
    for (; i < n; i++) {
        zero[0] += 0 * from[i];
    }
    return zero[0] + zero[1] + zero[2] + zero[3] == 0;
}
