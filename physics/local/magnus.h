/* Rotations from point to point by Magnus' expansion of order 6, in lanes. For functions that are
 * compiled FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_LOCAL_MAGNUS_H
#define PHYSICS_LOCAL_MAGNUS_H

#include "physics/local/strain_algebra.h"

/* The turn w of a step with terms a1, a2, a3, and what it is made of: it is a1 + a3/12 + [with,
 * sum]/240, with first = 2 a3 + [a2, a1]. */
PROCESSOR_INLINE void magnus_turn(lanes a[3][3], lanes first[3], lanes sum[3], lanes with[3],
                                  lanes w[3])
{
    lanes c1[3], c2[3], last[3];
    lanes_vector_cross(a[1], a[0], c1);
    for (int i = 0; i < 3; i++) {
        first[i] = 2 * a[2][i] + c1[i];
    }
    lanes_vector_cross(a[0], first, c2); /* - [a1, 2 a3 + c1]/60, turned about */
    for (int i = 0; i < 3; i++) {
        sum[i] = -20 * a[0][i] - a[2][i] + c1[i];
        with[i] = a[1][i] + c2[i] * (1.0 / 60);
    }
    lanes_vector_cross(with, sum, last);
    for (int i = 0; i < 3; i++) {
        w[i] = a[0][i] + a[2][i] * (1.0 / 12) + last[i] * (1.0 / 240);
    }
}

/* q at the end of such a step. */
PROCESSOR_INLINE void step_on(lanes a[3][3], lanes q[4])
{
    lanes first[3], sum[3], with[3], w[3], turn[4], next[4];
    magnus_turn(a, first, sum, with, w);
    exponential(w, turn);
    lanes_quaternion_product(q, turn, next);
    memcpy(q, next, sizeof next);
}

/* The turn of the end of such a step, world, by its terms: by[k] times the change of a_k, beside
 * the turn of its beginning, where the rotation is R. With exp(w + dw) = exp(J dw) exp(w) it is R J
 * dw, J = 1 + (1 - cos w)/w^2 w^ + (w - sin w)/w^3 w^^2. */
PROCESSOR_INLINE void step_change(lanes a[3][3], lanes R[3][3], lanes by[3][3][3])
{
    enum { TERMS = 12 }; /* beyond 1e-15 of 3^2 */
    lanes c1[3], c2[3], first[3], sum[3], with[3], last[3], w[3], square = NO_LANES;
    magnus_turn(a, first, sum, with, w);
    for (int i = 0; i < 3; i++) {
        square += w[i] * w[i];
    }
    lanes once = NO_LANES + 1, twice = NO_LANES + 1;
    for (int k = TERMS; k > 0; k--) {
        once = 1 - once * square * (1.0 / ((2 * k + 1) * (2 * k + 2)));
        twice = 1 - twice * square * (1.0 / ((2 * k + 2) * (2 * k + 3)));
    }
    for (int n = 0; n < 9; n++) {
        lanes da[3][3], more[3], dsum[3], dw[3];
        memset(da, 0, sizeof da);
        da[n / 3][n % 3] += 1;
        lanes_vector_cross(da[1], a[0], dsum);
        lanes_vector_cross(a[1], da[0], more);
        for (int i = 0; i < 3; i++) {
            c1[i] = dsum[i] + more[i];
            c2[i] = 2 * da[2][i] + c1[i];
            dsum[i] = -20 * da[0][i] - da[2][i] + c1[i];
        }
        lanes_vector_cross(a[0], c2, more);
        lanes_vector_cross(da[0], first, c2);
        for (int i = 0; i < 3; i++) {
            c2[i] = da[1][i] + (c2[i] + more[i]) * (1.0 / 60);
        }
        lanes_vector_cross(c2, sum, more);
        lanes_vector_cross(with, dsum, last);
        for (int i = 0; i < 3; i++) {
            dw[i] = da[0][i] + da[2][i] * (1.0 / 12) + (last[i] + more[i]) * (1.0 / 240);
        }
        lanes_vector_cross(w, dw, c1);
        lanes_vector_cross(w, c1, c2);
        for (int i = 0; i < 3; i++) {
            dw[i] += once * (1.0 / 2) * c1[i] + twice * (1.0 / 6) * c2[i];
        }
        for (int i = 0; i < 3; i++) {
            by[n / 3][i][n % 3] = R[i][0] * dw[0] + R[i][1] * dw[1] + R[i][2] * dw[2];
        }
    }
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
