#include "tools/solve/vector.h"

#include <math.h>

/* Each takes what the function of the same name in sundials_nvector.h takes; results may be
 * arguments. */

static void fill(realtype value, N_Vector z)
{
    sunindextype n = N_VGetLength_Serial(z);
    double *to = N_VGetArrayPointer_Serial(z);
    for (sunindextype i = 0; i < n; i++) {
        to[i] = value;
    }
}

static void scale(realtype a, N_Vector x, N_Vector z)
{
    sunindextype n = N_VGetLength_Serial(z);
    const double *from = N_VGetArrayPointer_Serial(x);
    double *to = N_VGetArrayPointer_Serial(z);
    for (sunindextype i = 0; i < n; i++) {
        to[i] = a * from[i];
    }
}

static void linear_sum(realtype a, N_Vector x, realtype b, N_Vector y, N_Vector z)
{
    sunindextype n = N_VGetLength_Serial(z);
    const double *p = N_VGetArrayPointer_Serial(x), *q = N_VGetArrayPointer_Serial(y);
    double *to = N_VGetArrayPointer_Serial(z);
    for (sunindextype i = 0; i < n; i++) {
        to[i] = a * p[i] + b * q[i];
    }
}

/* z may be the first of the vectors, no other. */
static int linear_combination(int count, realtype *c, N_Vector *x, N_Vector z)
{
    scale(c[0], x[0], z);
    for (int k = 1; k < count; k++) {
        linear_sum(c[k], x[k], 1, z, z);
    }
    return 0;
}

static realtype wrms_norm(N_Vector x, N_Vector weight)
{
    sunindextype n = N_VGetLength_Serial(x);
    const double *p = N_VGetArrayPointer_Serial(x), *w = N_VGetArrayPointer_Serial(weight);
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

N_Vector vector_create(size_t rows, SUNContext context)
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
