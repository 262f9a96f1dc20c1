/* Vectors of some type of number, as quaternion_algebra.h has it. */
ALGEBRA_INLINE void ALGEBRA(vector_cross)(const ALGEBRA_NUMBER a[3], const ALGEBRA_NUMBER b[3],
                                          ALGEBRA_NUMBER out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}
