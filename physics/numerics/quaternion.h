/* Quaternions (w, x, y, z) in plain C; rotations take the body to the world. */
#ifndef PHYSICS_NUMERICS_QUATERNION_H
#define PHYSICS_NUMERICS_QUATERNION_H

#include "physics/numerics/vector.h"

#include <math.h>

#define ALGEBRA_NUMBER double
#define ALGEBRA(name)  name
#define ALGEBRA_INLINE static inline
#include "physics/numerics/quaternion_algebra.h"
#undef ALGEBRA_NUMBER
#undef ALGEBRA
#undef ALGEBRA_INLINE

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

/* The unit quaternion of a rotation matrix, whose columns are the axes of the body (Shepperd, J.
 * Guidance and Control 1, 1978). */
static inline void quaternion_of_matrix(const double m[3][3], double q[4])
{
    const double trace = m[0][0] + m[1][1] + m[2][2];
    double square = trace;
    int i = -1;
    for (int k = 0; k < 3; k++) {
        i = m[k][k] > square ? k : i;
        square = m[k][k] > square ? m[k][k] : square;
    }
    if (i < 0) {
        q[0] = 0.5 * sqrt(1 + trace);
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            q[k + 1] = (m[b][a] - m[a][b]) / (4 * q[0]);
        }
        return;
    }
    const int a = (i + 1) % 3, b = (i + 2) % 3;
    q[i + 1] = 0.5 * sqrt(1 + 2 * m[i][i] - trace);
    q[0] = (m[b][a] - m[a][b]) / (4 * q[i + 1]);
    q[a + 1] = (m[a][i] + m[i][a]) / (4 * q[i + 1]);
    q[b + 1] = (m[b][i] + m[i][b]) / (4 * q[i + 1]);
}

#endif
