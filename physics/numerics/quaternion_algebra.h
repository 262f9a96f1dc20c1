/* Quaternions (w, x, y, z) and rotations of some type of number, for quaternion.h and lanes.h,
 * which say of which: ALGEBRA_NUMBER, and ALGEBRA(name) for what a function is called. There is no
 * guard: each includes it once. */
/* p q */
ALGEBRA_INLINE void ALGEBRA(quaternion_product)(const ALGEBRA_NUMBER p[4],
                                                const ALGEBRA_NUMBER q[4], ALGEBRA_NUMBER out[4])
{
    out[0] = p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3];
    out[1] = p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2];
    out[2] = p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1];
    out[3] = p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0];
}

/* p* q */
ALGEBRA_INLINE void ALGEBRA(quaternion_quotient)(const ALGEBRA_NUMBER p[4],
                                                 const ALGEBRA_NUMBER q[4], ALGEBRA_NUMBER out[4])
{
    const ALGEBRA_NUMBER conjugate[4] = {p[0], -p[1], -p[2], -p[3]};
    ALGEBRA(quaternion_product)(conjugate, q, out);
}

/* q (0, a) */
ALGEBRA_INLINE void ALGEBRA(quaternion_times_vector)(const ALGEBRA_NUMBER q[4],
                                                     const ALGEBRA_NUMBER a[3],
                                                     ALGEBRA_NUMBER out[4])
{
    out[0] = -q[1] * a[0] - q[2] * a[1] - q[3] * a[2];
    out[1] = q[0] * a[0] + q[2] * a[2] - q[3] * a[1];
    out[2] = q[0] * a[1] + q[3] * a[0] - q[1] * a[2];
    out[3] = q[0] * a[2] + q[1] * a[1] - q[2] * a[0];
}

/* R(q), rows in turn, of a unit quaternion. */
ALGEBRA_INLINE void ALGEBRA(rotation_matrix)(const ALGEBRA_NUMBER q[4], ALGEBRA_NUMBER R[3][3])
{
    ALGEBRA_NUMBER ww = q[0] * q[0], xx = q[1] * q[1], yy = q[2] * q[2], zz = q[3] * q[3];
    ALGEBRA_NUMBER wx = q[0] * q[1], wy = q[0] * q[2], wz = q[0] * q[3];
    ALGEBRA_NUMBER xy = q[1] * q[2], xz = q[1] * q[3], yz = q[2] * q[3];
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
ALGEBRA_INLINE void ALGEBRA(to_world)(ALGEBRA_NUMBER R[3][3], const ALGEBRA_NUMBER a[3],
                                      ALGEBRA_NUMBER out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = R[i][0] * a[0] + R[i][1] * a[1] + R[i][2] * a[2];
    }
}

ALGEBRA_INLINE void ALGEBRA(to_body)(ALGEBRA_NUMBER R[3][3], const ALGEBRA_NUMBER a[3],
                                     ALGEBRA_NUMBER out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = R[0][i] * a[0] + R[1][i] * a[1] + R[2][i] * a[2];
    }
}
