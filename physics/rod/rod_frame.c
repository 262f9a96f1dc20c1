/* Between the world and the frame of a planar motion, in which what leaves the plane is the
 * constant 0, so that the tape folds it away. */
#include "physics/numerics/quaternion.h"
#include "physics/rod/rod_internal.h"

#include <math.h>

static ad_value plane_combine(ad_value v, const double *coefficient)
{
    ad_value sum = ad_scalar(v.tape, 0);
    for (int i = 0; i < 3; i++) {
        sum = ad_add(sum, ad_scale(ad_row(v, i), coefficient[i]));
    }
    return sum;
}

/* Rows that may differ from 0, the others made the constant 0. */
static ad_value plane_keep(const rod_plane *plane, ad_value v, bool axial)
{
    ad_value zero = ad_scalar(v.tape, 0), rows[3];
    for (int i = 0; i < 3; i++) {
        rows[i] = (i == plane->director) == axial ? ad_row(v, i) : zero;
    }
    return ad_stack(3, rows);
}

static ad_value plane_keep_rotation(const rod_plane *plane, ad_value q)
{
    ad_value zero = ad_scalar(q.tape, 0), rows[4] = {ad_row(q, 0), zero, zero, zero};
    rows[plane->director + 1] = ad_row(q, plane->director + 1);
    return ad_stack(4, rows);
}

static ad_value plane_from_world(const rod_context *rod, ad_value v, bool axial)
{
    const rod_plane *plane = &rod->plane;
    ad_value rows[3];
    if (!plane->is_planar) {
        return v;
    }
    for (int i = 0; i < 3; i++) {
        const double column[3] = {plane->axes[0][i], plane->axes[1][i], plane->axes[2][i]};
        rows[i] = plane_combine(v, column);
    }
    return plane_keep(plane, ad_stack(3, rows), axial);
}

ad_value rod_from_world(const rod_context *rod, ad_value v)
{
    return plane_from_world(rod, v, false);
}

ad_value rod_axial_from_world(const rod_context *rod, ad_value v)
{
    return plane_from_world(rod, v, true);
}

ad_value rod_rotation_from_world(const rod_context *rod, ad_value q)
{
    double frame[4];
    if (!rod->plane.is_planar) {
        return q;
    }
    quaternion_of_matrix(rod->plane.axes, frame);
    ad_value back = ad_quaternion_conjugate(ad_constant(rod->tape, 4, frame));
    return plane_keep_rotation(&rod->plane, ad_quaternion_multiply(back, q));
}

rod_pose rod_pose_in_plane(const rod_context *rod, rod_pose pose)
{
    if (rod->plane.is_planar) {
        pose.position = plane_keep(&rod->plane, pose.position, false);
        pose.rotation = plane_keep_rotation(&rod->plane, pose.rotation);
    }
    return pose;
}

ad_value rod_keep_in_plane(const rod_context *rod, ad_value vector, bool axial)
{
    return rod->plane.is_planar ? plane_keep(&rod->plane, vector, axial) : vector;
}

ad_value rod_angle_of(const rod_context *rod, ad_value q)
{
    return ad_scale(ad_atan2(ad_row(q, rod->plane.director + 1), ad_row(q, 0)), 2);
}

ad_value rod_rotation_by(const rod_context *rod, ad_value turn)
{
    if (!rod->plane.is_planar) {
        return ad_quaternion_exp(turn);
    }
    ad_value half = ad_scale(turn, 0.5), zero = ad_scalar(rod->tape, 0);
    ad_value rows[4] = {ad_cos(half), zero, zero, zero};
    rows[rod->plane.director + 1] = ad_sin(half);
    return ad_stack(4, rows);
}

/* 4 q q^T has only sums of entries of the matrix as its own; its column of the largest diagonal
 * entry is q times a number far from 0 (Shepperd's method without roots). */
static ad_value quaternion_of_columns(const ad_value columns[3])
{
    ad_tape *tape = columns[0].tape;
    ad_value m[3][3], one = ad_scalar(tape, 1), best = one, column = one;
    for (int i = 0; i < 9; i++) {
        m[i / 3][i % 3] = ad_row(columns[i % 3], i / 3);
    }
    for (int k = 0; k < 4; k++) {
        ad_value row[4];
        for (int i = 0; i < 4; i++) {
            int a = (i > k ? i : k) - 1, b = (i > k ? k : i) - 1; /* b < a; -1: the scalar */
            row[i] = one;
            if (i == k) {
                for (int j = 0; j < 3; j++) {
                    row[i] =
                        k == 0 || k == j + 1 ? ad_add(row[i], m[j][j]) : ad_sub(row[i], m[j][j]);
                }
            } else if (b < 0) {
                row[i] = ad_sub(m[(a + 2) % 3][(a + 1) % 3], m[(a + 1) % 3][(a + 2) % 3]);
            } else {
                row[i] = ad_add(m[a][b], m[b][a]);
            }
        }
        ad_value now = ad_stack(4, row), larger = ad_sub(row[k], best);
        column = k == 0 ? now : ad_select(larger, now, column);
        best = k == 0 ? row[0] : ad_select(larger, row[k], best);
    }
    ad_value sign = ad_select(ad_neg(ad_row(column, 0)), ad_neg(one), one);
    return ad_mul(sign, ad_normalize(column));
}

ad_value rod_rotation_by_six(ad_value columns)
{
    ad_tape *tape = columns.tape;
    ad_value first = ad_add(ad_vector_constant(tape, 1, 0, 0), ad_slice(columns, 0, 3));
    ad_value second = ad_add(ad_vector_constant(tape, 0, 1, 0), ad_slice(columns, 3, 3));
    ad_value frame[3] = {ad_normalize(first)};
    frame[1] = ad_normalize(ad_sub(second, ad_mul(ad_dot(frame[0], second), frame[0])));
    frame[2] = ad_cross(frame[0], frame[1]);
    return quaternion_of_columns(frame);
}

ad_value rod_to_world(const rod_context *rod, ad_value v)
{
    const rod_plane *plane = &rod->plane;
    if (!plane->is_planar) {
        return v;
    }
    return ad_vector(plane_combine(v, plane->axes[0]), plane_combine(v, plane->axes[1]),
                     plane_combine(v, plane->axes[2]));
}

ad_value rod_position_to_world(const rod_context *rod, ad_value position)
{
    const rod_plane *plane = &rod->plane;
    const double *n = plane->normal, h = plane->height / rod->scales.length;
    if (!plane->is_planar) {
        return position;
    }
    ad_value foot = ad_vector_constant(rod->tape, h * n[0], h * n[1], h * n[2]);
    return ad_add(foot, rod_to_world(rod, position));
}

ad_value rod_rotation_to_world(const rod_context *rod, ad_value q)
{
    double frame[4];
    if (!rod->plane.is_planar) {
        return q;
    }
    quaternion_of_matrix(rod->plane.axes, frame);
    return ad_quaternion_multiply(ad_constant(rod->tape, 4, frame), q);
}

static ad_value plane_embed(const rod_context *rod, ad_value rows, bool axial)
{
    const rod_plane *plane = &rod->plane;
    ad_value zero = ad_scalar(rod->tape, 0), all[3];
    int count = 0;
    if (!plane->is_planar) {
        return rows;
    }
    for (int i = 0; i < 3; i++) {
        all[i] = (i == plane->director) == axial ? ad_row(rows, count++) : zero;
    }
    return ad_stack(3, all);
}

ad_value rod_vector_of(const rod_context *rod, ad_value rows)
{
    return plane_embed(rod, rows, false);
}

ad_value rod_axial_of(const rod_context *rod, ad_value rows)
{
    return plane_embed(rod, rows, true);
}

int rod_vector_rows(const rod_plane *plane)
{
    return plane->is_planar ? 2 : 3;
}

int rod_axial_rows(const rod_plane *plane)
{
    return plane->is_planar ? 1 : 3;
}

static ad_value plane_rows(const rod_context *rod, ad_value v, bool axial)
{
    const rod_plane *plane = &rod->plane;
    ad_value kept[3];
    int count = 0;
    if (!plane->is_planar || !ad_is_valid(v)) {
        return v;
    }
    for (int i = 0; i < 3; i++) {
        ad_value row = ad_row(v, i);
        if ((i == plane->director) == axial) {
            kept[count++] = row;
        } else if (!ad_is_constant(row, 0)) {
            ad_tape_fail(rod->tape, AD_BAD_ARGUMENT, "the planar equations leave their plane");
        }
    }
    return ad_stack(count, kept);
}

ad_value rod_vector_in_plane(const rod_context *rod, ad_value residual)
{
    return plane_rows(rod, residual, false);
}

ad_value rod_axial_in_plane(const rod_context *rod, ad_value residual)
{
    return plane_rows(rod, residual, true);
}
