/* Rotations from point to point by Magnus' expansion of order 6, in lanes. For functions that are
 * compiled FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_LOCAL_MAGNUS_H
#define PHYSICS_LOCAL_MAGNUS_H

#include "physics/local/strain_algebra.h"

/* q at the end of a step with terms a1, a2, a3. */
PROCESSOR_INLINE void step_on(lanes a[3][3], lanes q[4])
{
    lanes c1[3], c2[3], sum[3], with[3], last[3], turn[4], next[4];
    lanes_vector_cross(a[1], a[0], c1);
    for (int i = 0; i < 3; i++) {
        sum[i] = 2 * a[2][i] + c1[i];
    }
    lanes_vector_cross(a[0], sum, c2); /* - [a1, 2 a3 + c1]/60, turned about */
    for (int i = 0; i < 3; i++) {
        sum[i] = -20 * a[0][i] - a[2][i] + c1[i];
        with[i] = a[1][i] + c2[i] * (1.0 / 60);
    }
    lanes_vector_cross(with, sum, last);
    for (int i = 0; i < 3; i++) {
        sum[i] = a[0][i] + a[2][i] * (1.0 / 12) + last[i] * (1.0 / 240);
    }
    exponential(sum, turn);
    lanes_quaternion_product(q, turn, next);
    memcpy(q, next, sizeof next);
}

/* Undoes rounding. */
PROCESSOR_INLINE void normalise(lanes q[4])
{
    const lanes by = 1.5 - 0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) {
        q[i] *= by;
    }
}

#endif
