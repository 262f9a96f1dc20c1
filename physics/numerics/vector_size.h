/* Sizes of vectors. Not in vector.h, which is in exported C that has no use for them. */
#ifndef PHYSICS_NUMERICS_VECTOR_SIZE_H
#define PHYSICS_NUMERICS_VECTOR_SIZE_H

#include "physics/numerics/vector.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

static inline double vector_length(const double a[3])
{
    return sqrt(vector_dot(a, a));
}

/* Of any number of components. */
static inline double vector_square(size_t count, const double *a)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += a[i] * a[i];
    }
    return sum;
}

static inline bool vector_is_finite(size_t count, const double *a)
{
    bool finite = true;
    for (size_t i = 0; i < count; i++) {
        finite = finite && isfinite(a[i]);
    }
    return finite;
}

#endif
