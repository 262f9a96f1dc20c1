/* The unloaded rod in numbers, for rod_shape.c and rod_undeformed.c. */
#ifndef PHYSICS_ROD_ROD_SHAPE_H
#define PHYSICS_ROD_ROD_SHAPE_H

#include "autodiff/tape/stumpff.h"
#include "physics/numerics/vector.h"
#include "physics/rod/rod_internal.h"

#include <math.h>

enum {
    SHAPE_DEGREE = 40, /* of the polynomials; coefficients at rounding level are cut off */
    SHAPE_STEPS = 16,  /* of the integrator between two Chebyshev points */
    SHAPE_ROWS = 7,    /* r, q */
    SHAPE_PIECES_MAX = 64
};

typedef struct shape_vector {
    double x[3];
} shape_vector;

typedef struct shape_rotation {
    double x[4];
} shape_rotation;

static inline shape_vector shape_times(double factor, shape_vector a)
{
    return (shape_vector){{factor * a.x[0], factor * a.x[1], factor * a.x[2]}};
}

static inline shape_vector shape_scale(shape_vector a, double factor)
{
    return shape_times(factor, a);
}

static inline shape_vector shape_add(shape_vector a, shape_vector b)
{
    return (shape_vector){{a.x[0] + b.x[0], a.x[1] + b.x[1], a.x[2] + b.x[2]}};
}

static inline shape_vector shape_add3(shape_vector a, shape_vector b, shape_vector c)
{
    return shape_add(shape_add(a, b), c);
}

static inline double shape_dot(shape_vector a, shape_vector b)
{
    return vector_dot(a.x, b.x);
}

static inline shape_vector shape_cross(shape_vector a, shape_vector b)
{
    shape_vector cross;
    vector_cross(a.x, b.x, cross.x);
    return cross;
}

static inline shape_vector shape_rotate(shape_rotation q, shape_vector a)
{
    const shape_vector axis = {{q.x[1], q.x[2], q.x[3]}};
    const shape_vector turned = shape_times(2, shape_cross(axis, a));
    return shape_add(shape_add(a, shape_times(q.x[0], turned)), shape_cross(axis, turned));
}

static inline shape_rotation shape_multiply(shape_rotation q, shape_rotation p)
{
    const shape_vector a = {{q.x[1], q.x[2], q.x[3]}}, b = {{p.x[1], p.x[2], p.x[3]}};
    const shape_vector sides = shape_add(shape_times(q.x[0], b), shape_times(p.x[0], a));
    const shape_vector c = shape_add(sides, shape_cross(a, b));
    const double scalar = q.x[0] * p.x[0] - a.x[0] * b.x[0] - a.x[1] * b.x[1] - a.x[2] * b.x[2];
    return (shape_rotation){{scalar, c.x[0], c.x[1], c.x[2]}};
}

static inline shape_rotation shape_exp(shape_vector turn)
{
    const double quarter = shape_dot(turn, turn) / 4, half = 0.5 * ad_stumpff_number(1, quarter);
    const shape_vector axis = shape_times(half, turn);
    return (shape_rotation){{ad_stumpff_number(0, quarter), axis.x[0], axis.x[1], axis.x[2]}};
}

#define SHAPE_NUMBER   double
#define SHAPE_VECTOR   shape_vector
#define SHAPE_ROTATION shape_rotation
#define SHAPE(name)    shape_##name
#define shape_stumpff  ad_stumpff_number
#include "physics/rod/shape_algebra.h"
#undef SHAPE_NUMBER
#undef SHAPE_VECTOR
#undef SHAPE_ROTATION
#undef SHAPE

/* From `from` to `to`, of arc length over the length of the rod. */
typedef struct shape_piece {
    int segment; /* of scene_piece_of */
    double from, to;
    double length; /* of the rod; m */
    scene_rest rest;
    bool is_uniform;  /* constant strains at t = 0 */
    shape_twist turn; /* of a joint where it begins, which `start` has */
    shape_pose start, end;
    double c[SHAPE_DEGREE + 1][SHAPE_ROWS]; /* if it is not */
    int degree;
} shape_piece;

typedef struct shape {
    int count;
    shape_piece pieces[SHAPE_PIECES_MAX];
    shape_pose end;
} shape;

/* Of a scene of numbers, from the identity at s = 0. Where there are more breaks than pieces, the
 * last ones stay within one, which then is not resolved. */
void rod_shape_make(const scene *rod_scene, shape *made);

/* Constant strains at t = 0. */
bool rod_shape_is_uniform(const scene_rest *rest);

/* v*, u* times the length at s over it, t = 0; and the i-th of the three places where a step h from
 * s on asks for them. */
shape_twist rod_shape_rest(const shape_piece *piece, double s);
double rod_shape_gauss(int i, double s, double h);

/* The j-th of the Chebyshev points, ascending. The shape is sum_k c_k T_k(x), x from -1 to 1 along
 * the piece; c_k is a factor over the degree times the sum of the shares of the poses there. */
double rod_shape_point(const shape_piece *piece, int degree, int j);
double rod_shape_share(int degree, int k, int j);

static inline double shape_factor(int degree, int k)
{
    return k == 0 || k == degree ? 1 : 2;
}

/* The end of a piece that is not uniform, by steps between Chebyshev points of a degree; values
 * [degree + 1], if wanted: the poses at these. */
shape_pose rod_shape_solve(const shape_piece *piece, int degree, int steps,
                           double (*values)[SHAPE_ROWS]);

#endif
