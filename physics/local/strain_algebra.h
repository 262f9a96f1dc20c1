/* 3 x 3 matrices and the functions of angles that the strain form needs, in lanes. For functions
 * that are compiled FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_LOCAL_STRAIN_ALGEBRA_H
#define PHYSICS_LOCAL_STRAIN_ALGEBRA_H

#include "physics/numerics/quaternion_lanes.h"

#include <math.h>
#include <string.h>

static const lanes NO_LANES = {0};

/* out = A x */
PROCESSOR_INLINE void apply(lanes A[3][3], const lanes x[3], lanes out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = A[i][0] * x[0] + A[i][1] * x[1] + A[i][2] * x[2];
    }
}

/* out += A x */
PROCESSOR_INLINE void add_applied(lanes A[3][3], const lanes x[3], lanes out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] += A[i][0] * x[0] + A[i][1] * x[1] + A[i][2] * x[2];
    }
}

/* out = A B, A B^T */
PROCESSOR_INLINE void multiply(lanes A[3][3], lanes B[3][3], lanes out[3][3])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            out[i][j] = A[i][0] * B[0][j] + A[i][1] * B[1][j] + A[i][2] * B[2][j];
        }
    }
}

PROCESSOR_INLINE void multiply_turned(lanes A[3][3], lanes B[3][3], lanes out[3][3])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            out[i][j] = A[i][0] * B[j][0] + A[i][1] * B[j][1] + A[i][2] * B[j][2];
        }
    }
}

/* out = factor a^, which makes a cross product from the left. */
PROCESSOR_INLINE void cross_matrix(const lanes a[3], double factor, lanes out[3][3])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        out[i][i] = NO_LANES;
        out[k][j] = factor * a[i];
        out[j][k] = -factor * a[i];
    }
}

/* out = factor a^ B */
PROCESSOR_INLINE void cross_times(const lanes a[3], double factor, lanes B[3][3], lanes out[3][3])
{
    for (int c = 0; c < 3; c++) {
        const lanes column[3] = {B[0][c], B[1][c], B[2][c]};
        lanes turned[3];
        lanes_vector_cross(a, column, turned);
        for (int i = 0; i < 3; i++) {
            out[i][c] = factor * turned[i];
        }
    }
}

/* out = A b^ */
PROCESSOR_INLINE void times_cross(lanes A[3][3], const lanes b[3], lanes out[3][3])
{
    for (int i = 0; i < 3; i++) {
        lanes_vector_cross(A[i], b, out[i]);
    }
}

/* out = A^-1 by cofactors: A is near 1. */
PROCESSOR_INLINE void invert(lanes A[3][3], lanes out[3][3])
{
    lanes determinant = NO_LANES;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        for (int c = 0; c < 3; c++) {
            int d = (c + 1) % 3, e = (c + 2) % 3;
            out[c][i] = A[j][d] * A[k][e] - A[j][e] * A[k][d];
        }
        if (i == 0) {
            determinant = A[0][0] * out[0][0] + A[0][1] * out[1][0] + A[0][2] * out[2][0];
        }
    }
    const lanes by = 1 / determinant;
    for (int i = 0; i < 3; i++) {
        for (int c = 0; c < 3; c++) {
            out[i][c] *= by;
        }
    }
}

/* The quaternion of a rotation vector of at most 3 rad; what is longer is no number. */
PROCESSOR_INLINE void exponential(const lanes vector[3], lanes q[4])
{
    enum { TERMS = 10 }; /* beyond 1e-15 of 1.5^2 */
    const lanes x = 0.25 * (vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    lanes cosine = NO_LANES + 1, sine = NO_LANES + 1;
    for (int k = TERMS; k > 0; k--) {
        cosine = 1 - cosine * x * (1.0 / ((2 * k - 1) * (2 * k)));
        sine = 1 - sine * x * (1.0 / ((2 * k) * (2 * k + 1)));
    }
    const integer_lanes far = x > 2.25; /* all bits: not a number */
    q[0] = (lanes)((integer_lanes)cosine | far);
    for (int i = 0; i < 3; i++) {
        q[1 + i] = 0.5 * sine * vector[i];
    }
}

PROCESSOR_INLINE void in_all_lanes(int count, const double *from, lanes *to)
{
    for (int i = 0; i < count; i++) {
        to[i] = NO_LANES + from[i];
    }
}

/* vec (p* q) of numbers p. */
PROCESSOR_INLINE void turned_from(const double p[4], const lanes q[4], lanes vector[3])
{
    lanes from[4], turn[4];
    in_all_lanes(4, p, from);
    lanes_quaternion_quotient(from, q, turn);
    memcpy(vector, turn + 1, 3 * sizeof *vector);
}

#endif
