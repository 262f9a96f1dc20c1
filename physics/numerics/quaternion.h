/* Quaternions (w, x, y, z) in plain C; rotations take the body to the world. */
#ifndef PHYSICS_NUMERICS_QUATERNION_H
#define PHYSICS_NUMERICS_QUATERNION_H

#include <math.h>

#define NUMBER         double
#define ALGEBRA(name)  name
#define ALGEBRA_INLINE static inline
#include "physics/numerics/quaternion_algebra.h"
#undef NUMBER
#undef ALGEBRA
#undef ALGEBRA_INLINE

static inline double vector_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double vector_distance(const double a[3], const double b[3])
{
    const double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    return sqrt(vector_dot(d, d));
}

static inline void quaternion_normalize(double q[4])
{
    double by = 1 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) {
        q[i] *= by;
    }
}

#endif
