/* Quaternions (w, x, y, z) in plain C; rotations take the body to the world. */
#ifndef PHYSICS_SOLVE_QUATERNION_H
#define PHYSICS_SOLVE_QUATERNION_H

#include <math.h>

static inline void vector_cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline double vector_dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* p q */
static inline void quaternion_product(const double p[4], const double q[4], double out[4])
{
    out[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
    out[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2];
    out[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1];
    out[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0];
}

/* p* q */
static inline void quaternion_quotient(const double p[4], const double q[4], double out[4])
{
    const double conjugate[4] = {p[0], -p[1], -p[2], -p[3]};
    quaternion_product(conjugate, q, out);
}

/* q (0, a) */
static inline void quaternion_times_vector(const double q[4], const double a[3], double out[4])
{
    out[0] = -q[1] * a[0] - q[2] * a[1] - q[3] * a[2];
    out[1] = q[0] * a[0] + q[2] * a[2] - q[3] * a[1];
    out[2] = q[0] * a[1] + q[3] * a[0] - q[1] * a[2];
    out[3] = q[0] * a[2] + q[1] * a[1] - q[2] * a[0];
}

static inline void quaternion_normalize(double q[4])
{
    double by = 1 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) {
        q[i] *= by;
    }
}

/* R(q), rows in turn, of a unit quaternion. */
static inline void rotation_matrix(const double q[4], double R[3][3])
{
    double ww = q[0] * q[0], xx = q[1] * q[1], yy = q[2] * q[2], zz = q[3] * q[3];
    double wx = q[0] * q[1], wy = q[0] * q[2], wz = q[0] * q[3];
    double xy = q[1] * q[2], xz = q[1] * q[3], yz = q[2] * q[3];
    R[0][0] = ww + xx - yy - zz;
    R[1][1] = ww - xx + yy - zz;
    R[2][2] = ww - xx - yy + zz;
    R[0][1] = 2 * (xy - wz);
    R[1][0] = 2 * (xy + wz);
    R[0][2] = 2 * (xz + wy);
    R[2][0] = 2 * (xz - wy);
    R[1][2] = 2 * (yz - wx);
    R[2][1] = 2 * (yz + wx);
}

/* R a and R^T a */
static inline void to_world(double R[3][3], const double a[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = R[i][0] * a[0] + R[i][1] * a[1] + R[i][2] * a[2];
    }
}

static inline void to_body(double R[3][3], const double a[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = R[0][i] * a[0] + R[1][i] * a[1] + R[2][i] * a[2];
    }
}

#endif
