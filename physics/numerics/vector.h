/* Vectors in plain C. */
#ifndef PHYSICS_NUMERICS_VECTOR_H
#define PHYSICS_NUMERICS_VECTOR_H

#define ALGEBRA_NUMBER double
#define ALGEBRA(name)  name
#define ALGEBRA_INLINE static inline
#include "physics/numerics/vector_algebra.h"
#undef ALGEBRA_NUMBER
#undef ALGEBRA
#undef ALGEBRA_INLINE

static inline double vector_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

#endif
