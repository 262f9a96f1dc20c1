/* Formulas made of operations: composite functions, vectors, quaternions. */
#include "autodiff/tape/tape.h"

#include <math.h>

ad_value ad_div(ad_value a, ad_value b)
{
    return ad_mul(a, ad_reciprocal(b));
}

ad_value ad_scale(ad_value a, double factor)
{
    return a.tape ? ad_mul(ad_scalar(a.tape, factor), a) : a;
}

ad_value ad_neg(ad_value a)
{
    return ad_scale(a, -1);
}

ad_value ad_square(ad_value a)
{
    return ad_mul(a, a);
}

/* (1 - a)(1 + a): 1 - a is exact where a is near 1, so no digits are lost there. */
static ad_value one_minus_square(ad_value a)
{
    ad_value one = ad_scalar(a.tape, 1);
    return ad_mul(ad_sub(one, a), ad_add(one, a));
}

ad_value ad_acos(ad_value a)
{
    return ad_atan2(ad_sqrt(one_minus_square(a)), a);
}

ad_value ad_asin(ad_value a)
{
    return ad_atan2(a, ad_sqrt(one_minus_square(a)));
}

ad_value ad_max(ad_value a, ad_value b)
{
    return ad_select(ad_sub(a, b), a, b);
}

ad_value ad_min(ad_value a, ad_value b)
{
    return ad_select(ad_sub(a, b), b, a);
}

ad_value ad_sigmoid(ad_value a)
{
    ad_value half = ad_scalar(a.tape, 0.5);
    return ad_add(half, ad_mul(half, ad_tanh(ad_scale(a, 0.5)))); /* no overflow */
}

ad_value ad_silu(ad_value a)
{
    return ad_mul(a, ad_sigmoid(a));
}

ad_value ad_gelu(ad_value a)
{
    ad_value half = ad_scalar(a.tape, 0.5);
    return ad_mul(a, ad_add(half, ad_mul(half, ad_erf(ad_scale(a, sqrt(0.5))))));
}

/* ---- vectors ------------------------------------------------------------------------------- */

ad_value ad_vector(ad_value x, ad_value y, ad_value z)
{
    return ad_stack(3, (ad_value[]){x, y, z});
}

ad_value ad_vector_constant(ad_tape *tape, double x, double y, double z)
{
    return ad_constant(tape, 3, (double[]){x, y, z});
}

ad_value ad_dot(ad_value a, ad_value b)
{
    return ad_sum_rows(ad_mul(a, b));
}

ad_value ad_norm(ad_value a)
{
    return ad_sqrt(ad_dot(a, a));
}

ad_value ad_normalize(ad_value a)
{
    return ad_mul(a, ad_reciprocal_or_zero(ad_norm(a)));
}

/* a_i b_j - a_j b_i */
static ad_value minor(ad_value a, ad_value b, int i, int j)
{
    return ad_sub(ad_mul(ad_row(a, i), ad_row(b, j)), ad_mul(ad_row(a, j), ad_row(b, i)));
}

static bool has_rows(ad_value a, int rows, const char *what)
{
    if (a.tape && ad_is_valid(a) && ad_rows(a) != rows) {
        ad_tape_fail(a.tape, AD_BAD_SHAPE, "%s: %d rows; %d are needed", what, ad_rows(a), rows);
    }
    return ad_is_valid(a) && ad_rows(a) == rows;
}

ad_value ad_cross(ad_value a, ad_value b)
{
    if (!has_rows(a, 3, "cross product") || !has_rows(b, 3, "cross product")) {
        return ad_tape_failed(a.tape);
    }
    return ad_vector(minor(a, b, 1, 2), minor(a, b, 2, 0), minor(a, b, 0, 1));
}

/* ---- quaternions --------------------------------------------------------------------------- */

static ad_value vector_part(ad_value q)
{
    return ad_slice(q, 1, 3);
}

ad_value ad_quaternion(ad_value scalar, ad_value vector)
{
    return ad_stack(2, (ad_value[]){scalar, vector});
}

ad_value ad_quaternion_multiply(ad_value p, ad_value q)
{
    if (!has_rows(p, 4, "quaternion product") || !has_rows(q, 4, "quaternion product")) {
        return ad_tape_failed(p.tape);
    }
    ad_value pw = ad_row(p, 0), qw = ad_row(q, 0);
    ad_value pv = vector_part(p), qv = vector_part(q);
    ad_value scalar = ad_sub(ad_mul(pw, qw), ad_dot(pv, qv));
    ad_value vector = ad_add(ad_add(ad_mul(pw, qv), ad_mul(qw, pv)), ad_cross(pv, qv));
    return ad_quaternion(scalar, vector);
}

ad_value ad_quaternion_conjugate(ad_value q)
{
    return has_rows(q, 4, "quaternion conjugate")
               ? ad_quaternion(ad_row(q, 0), ad_neg(vector_part(q)))
               : ad_tape_failed(q.tape);
}

ad_value ad_quaternion_exp(ad_value rotation_vector)
{
    /* angle^2/4: cos(angle/2) = c_0, sin(angle/2)/angle = c_1 / 2 */
    ad_value quarter = ad_scale(ad_dot(rotation_vector, rotation_vector), 0.25);
    return ad_quaternion(ad_stumpff(0, quarter),
                         ad_mul(ad_scale(ad_stumpff(1, quarter), 0.5), rotation_vector));
}

/* x + 2 w (v x x) + 2 v x (v x x), for a unit quaternion (w, v) */
static ad_value rotate(ad_value w, ad_value v, ad_value x)
{
    ad_value twice = ad_scale(ad_cross(v, x), 2);
    return ad_add(x, ad_add(ad_mul(w, twice), ad_cross(v, twice)));
}

ad_value ad_rotate(ad_value q, ad_value x)
{
    return has_rows(q, 4, "rotation") ? rotate(ad_row(q, 0), vector_part(q), x)
                                      : ad_tape_failed(q.tape);
}

ad_value ad_rotate_inverse(ad_value q, ad_value x)
{
    return has_rows(q, 4, "rotation") ? rotate(ad_row(q, 0), ad_neg(vector_part(q)), x)
                                      : ad_tape_failed(q.tape);
}
