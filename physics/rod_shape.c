/* The unloaded rod: v = v*, u = u* from a held end on. Exact exponentials for constant v*, u*; for
 * others a numerical solution as Chebyshev polynomials, which the tape can differentiate. Joints
 * move what lies beyond them rigidly. */
#include "physics/constants.h"
#include "physics/rod_internal.h"

#include <math.h>
#include <string.h>

enum {
    SHAPE_DEGREE = 40, /* of the polynomials; coefficients at rounding level are cut off */
    SHAPE_STEPS = 16,  /* of the integrator between two Chebyshev points */
    SHAPE_ROWS = 7     /* r, q */
};

/* ---- numbers --------------------------------------------------------------------------------- */

typedef struct shape_twist {
    double u[3], v[3];
} shape_twist;

typedef struct shape_pose {
    double r[3], q[4];
} shape_pose;

static void cross(double *result, const double *a, const double *b)
{
    for (int i = 0; i < 3; i++) {
        result[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    }
}

/* c_k(a) = sum_i (-a)^i / (2i+k)!; a is small here, 10 terms reach rounding for a <= 1. */
static double shape_stumpff(int k, double a)
{
    double term = 1, sum = 0;
    for (int i = 2; i <= k; i++) {
        term /= i;
    }
    for (int i = 0; i < 10; i++) {
        sum += term;
        term *= -a / ((2 * i + k + 1) * (2 * i + k + 2));
    }
    return sum;
}

/* pose exp(twist): translation (1 + c_2 u^ + c_3 u^ u^) v, rotation exp(u/2). */
static void shape_advance(shape_pose *pose, const shape_twist *twist)
{
    const double *u = twist->u, *v = twist->v;
    double square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2], uv[3], uuv[3], step[3];
    cross(uv, u, v);
    cross(uuv, u, uv);
    for (int i = 0; i < 3; i++) {
        step[i] = v[i] + shape_stumpff(2, square) * uv[i] + shape_stumpff(3, square) * uuv[i];
    }
    double *q = pose->q, half = 0.5 * shape_stumpff(1, square / 4), turned[3], twice[3];
    cross(turned, q + 1, step);
    for (int i = 0; i < 3; i++) {
        turned[i] *= 2;
    }
    cross(twice, q + 1, turned);
    for (int i = 0; i < 3; i++) {
        pose->r[i] += step[i] + q[0] * turned[i] + twice[i];
    }
    double p[4] = {shape_stumpff(0, square / 4), half * u[0], half * u[1], half * u[2]}, side[3];
    double scalar = q[0] * p[0] - q[1] * p[1] - q[2] * p[2] - q[3] * p[3];
    cross(side, q + 1, p + 1);
    for (int i = 0; i < 3; i++) {
        q[i + 1] = q[0] * p[i + 1] + p[0] * q[i + 1] + side[i];
    }
    q[0] = scalar;
}

static shape_twist shape_rest(const scene *rod_scene, double s)
{
    const scene_rod *given = &rod_scene->rod;
    double length = scene_length(rod_scene);
    shape_twist twist;
    for (int i = 0; i < 3; i++) {
        quantity strain = quantity_or(given->rest_strain[i], quantity_number(i == 2));
        const quantity curvatures[2] = {given->rest_curvature[i], given->imperfection[i]};
        twist.v[i] = quantity_value(strain, s * length, 0);
        twist.u[i] = 0;
        for (int k = 0; k < 2; k++) {
            twist.u[i] +=
                curvatures[k].is_given ? length * quantity_value(curvatures[k], s * length, 0) : 0;
        }
    }
    return twist;
}

/* One step of the Magnus method of order 4 with Gauss points (Iserles et al., Acta Numerica 2000,
 * section 4.2), for g' = g twist. */
static void shape_step(const scene *rod_scene, shape_pose *pose, double s, double h)
{
    double offset = sqrt(3.0) / 6;
    shape_twist a = shape_rest(rod_scene, s + (0.5 - offset) * h);
    shape_twist b = shape_rest(rod_scene, s + (0.5 + offset) * h), sum;
    double uu[3], uv[3], vu[3], bracket = sqrt(3.0) / 12 * h * h;
    cross(uu, a.u, b.u);
    cross(uv, a.u, b.v);
    cross(vu, a.v, b.u);
    for (int i = 0; i < 3; i++) {
        sum.u[i] = 0.5 * h * (a.u[i] + b.u[i]) + bracket * uu[i];
        sum.v[i] = 0.5 * h * (a.v[i] + b.v[i]) + bracket * (uv[i] + vu[i]);
    }
    shape_advance(pose, &sum);
}

/* From s to `to`; the steps of a whole rod are as many as of all intervals between Chebyshev
 * points.
 */
static void shape_march(const scene *rod_scene, shape_pose *pose, double s, double to)
{
    int steps = 1 + (int)(SHAPE_DEGREE * SHAPE_STEPS * (to - s));
    double h = (to - s) / steps;
    for (int i = 0; i < steps; i++) {
        shape_step(rod_scene, pose, s + i * h, h);
    }
}

/* p = g p, of rigid motions */
static void shape_move(const shape_pose *g, shape_pose *p)
{
    shape_pose moved = *g;
    double once[3], twice[3], side[3];
    cross(once, g->q + 1, p->r);
    cross(side, g->q + 1, p->q + 1);
    for (int i = 0; i < 3; i++) {
        once[i] *= 2;
    }
    cross(twice, g->q + 1, once);
    moved.q[0] = g->q[0] * p->q[0];
    for (int i = 0; i < 3; i++) {
        moved.r[i] += p->r[i] + g->q[0] * once[i] + twice[i];
        moved.q[0] -= g->q[i + 1] * p->q[i + 1];
        moved.q[i + 1] = g->q[0] * p->q[i + 1] + p->q[0] * g->q[i + 1] + side[i];
    }
    *p = moved;
}

static shape_pose shape_inverse(const shape_pose *g)
{
    shape_pose inverse = {.q = {g->q[0], -g->q[1], -g->q[2], -g->q[3]}}, turned = inverse;
    shape_pose back = {.r = {-g->r[0], -g->r[1], -g->r[2]}, .q = {1}};
    shape_move(&turned, &back);
    memcpy(inverse.r, back.r, sizeof back.r);
    return inverse;
}

/* By which rigid motion the rod after joint i is where it is, rather than where it were without any
 * joint: g_i = g_(i-1) p(s_i) turn p(s_i)^-1, with the pose p of the rod without joints.
 * motions [rod_joint_count] */
static void shape_joints(const scene *rod_scene, shape_pose *motions)
{
    shape_pose at = {.q = {1, 0, 0, 0}}, before = at;
    double s = 0;
    for (int i = 0; i < rod_joint_count(rod_scene); i++) {
        rod_joint joint = rod_joint_of(rod_scene, i);
        shape_march(rod_scene, &at, s, joint.s);
        s = joint.s;
        shape_pose turn = {.q = {joint.turn[0], joint.turn[1], joint.turn[2], joint.turn[3]}};
        motions[i] = shape_inverse(&at);
        shape_move(&turn, &motions[i]);
        shape_move(&at, &motions[i]);
        shape_move(&before, &motions[i]);
        before = motions[i];
    }
}

/* values [SHAPE_DEGREE + 1][SHAPE_ROWS] of the pose at the Chebyshev points of [0, 1], ascending,
 * from the identity at 0. */
static void shape_solve(const scene *rod_scene, double (*values)[SHAPE_ROWS])
{
    shape_pose pose = {.q = {1, 0, 0, 0}};
    double s = 0;
    for (int j = 0; j <= SHAPE_DEGREE; j++) {
        double next = 0.5 - 0.5 * cos(PI * j / SHAPE_DEGREE), h = (next - s) / SHAPE_STEPS;
        for (int i = 0; i < SHAPE_STEPS && j > 0; i++) {
            shape_step(rod_scene, &pose, s + i * h, h);
        }
        s = next;
        memcpy(values[j], pose.r, sizeof pose.r);
        memcpy(values[j] + 3, pose.q, sizeof pose.q);
    }
}

/* Coefficients of sum_k c_k T_k(2s - 1); returns the degree that matters. */
static int shape_coefficients(double (*values)[SHAPE_ROWS], double (*c)[SHAPE_ROWS])
{
    int degree = 1;
    for (int k = 0; k <= SHAPE_DEGREE; k++) {
        for (int row = 0; row < SHAPE_ROWS; row++) {
            double sum = 0;
            for (int j = 0; j <= SHAPE_DEGREE; j++) {
                double end = j == 0 || j == SHAPE_DEGREE ? 0.5 : 1;
                sum += end * values[SHAPE_DEGREE - j][row] * cos(PI * j * k / SHAPE_DEGREE);
            }
            c[k][row] = sum * (k == 0 || k == SHAPE_DEGREE ? 1.0 : 2.0) / SHAPE_DEGREE;
            if (fabs(c[k][row]) > 1e-15 && k > degree) {
                degree = k;
            }
        }
    }
    return degree;
}

/* ---- on the tape ----------------------------------------------------------------------------- */

/* Clenshaw's recurrence on all seven rows at once. */
static ad_value shape_clenshaw(ad_value s, double (*c)[SHAPE_ROWS], int degree)
{
    ad_value x = ad_sub(ad_scale(s, 2), ad_scalar(s.tape, 1)), twice = ad_scale(x, 2);
    ad_value b1 = ad_zeros(s.tape, SHAPE_ROWS), b2 = b1;
    for (int k = degree; k >= 1; k--) {
        ad_value coefficient = ad_constant(s.tape, SHAPE_ROWS, c[k]);
        ad_value b0 = ad_add(coefficient, ad_sub(ad_mul(twice, b1), b2));
        b2 = b1;
        b1 = b0;
    }
    return ad_add(ad_constant(s.tape, SHAPE_ROWS, c[0]), ad_sub(ad_mul(x, b1), b2));
}

/* From the identity at s = 0, constant twist: r = (s + s^2 c_2 u^ + s^3 c_3 u^ u^) v with c_k at
 * |s u|^2, q = exp(s u/2). */
static rod_pose shape_helix(const shape_twist *twist, ad_value s)
{
    ad_value u = ad_vector_constant(s.tape, twist->u[0], twist->u[1], twist->u[2]);
    ad_value v = ad_vector_constant(s.tape, twist->v[0], twist->v[1], twist->v[2]);
    ad_value turn = ad_mul(s, u), square = ad_dot(turn, turn);
    ad_value once = ad_cross(turn, v), again = ad_cross(turn, once);
    ad_value mean = ad_add(
        v, ad_add(ad_mul(ad_stumpff(2, square), once), ad_mul(ad_stumpff(3, square), again)));
    return (rod_pose){.position = ad_mul(s, mean), .rotation = ad_quaternion_exp(turn)};
}

/* Constant strains at t = 0. */
static bool shape_is_uniform(const scene_rod *rod)
{
    return !quantity_any_depends_on(3, rod->rest_strain, "s") &&
           !quantity_any_depends_on(3, rod->rest_curvature, "s") &&
           !quantity_any_depends_on(3, rod->imperfection, "s");
}

bool rod_shape_is_resolved(const scene *rod_scene)
{
    double values[SHAPE_DEGREE + 1][SHAPE_ROWS], c[SHAPE_DEGREE + 1][SHAPE_ROWS], rest = 0;
    if (shape_is_uniform(&rod_scene->rod)) {
        return true;
    }
    shape_solve(rod_scene, values);
    shape_coefficients(values, c);
    for (int row = 0; row < SHAPE_ROWS; row++) {
        for (int k = SHAPE_DEGREE - 3; k <= SHAPE_DEGREE; k++) {
            rest += fabs(c[k][row]);
        }
    }
    return rest <= ROD_MISMATCH;
}

/* What lies beyond joints is moved by them; a joint itself belongs to what is before. */
static void shape_turn(const rod_context *rod, int count, const ad_value *s, rod_pose *poses)
{
    shape_pose motions[SCENE_SEGMENTS_MAX], here = {.q = {1, 0, 0, 0}};
    shape_joints(rod->scene, motions);
    for (int k = 0; k < count; k++) {
        ad_value r = ad_constant(rod->tape, 3, here.r), q = ad_constant(rod->tape, 4, here.q);
        for (int i = 0; i < rod_joint_count(rod->scene); i++) {
            ad_value beyond = ad_sub(s[k], ad_scalar(rod->tape, rod_joint_of(rod->scene, i).s));
            r = ad_select(beyond, ad_constant(rod->tape, 3, motions[i].r), r);
            q = ad_select(beyond, ad_constant(rod->tape, 4, motions[i].q), q);
        }
        poses[k].position = ad_add(r, ad_rotate(q, poses[k].position));
        poses[k].rotation = ad_quaternion_multiply(q, poses[k].rotation);
    }
}

/* Poses of a rod without joints at several arc lengths, from one numerical solution. */
static void shape_smooth_poses(const rod_context *rod, int count, const ad_value *s,
                               rod_pose *poses)
{
    if (shape_is_uniform(&rod->scene->rod)) {
        shape_twist twist = shape_rest(rod->scene, 0);
        for (int i = 0; i < count; i++) {
            poses[i] = shape_helix(&twist, s[i]);
        }
        return;
    }
    double values[SHAPE_DEGREE + 1][SHAPE_ROWS], c[SHAPE_DEGREE + 1][SHAPE_ROWS];
    shape_solve(rod->scene, values);
    int degree = shape_coefficients(values, c);
    for (int i = 0; i < count; i++) {
        ad_value rows = shape_clenshaw(s[i], c, degree);
        poses[i].position = ad_slice(rows, 0, 3);
        poses[i].rotation = ad_normalize(ad_slice(rows, 3, 4));
    }
}

static void shape_poses(const rod_context *rod, int count, const ad_value *s, rod_pose *poses)
{
    shape_smooth_poses(rod, count, s, poses);
    if (rod_joint_count(rod->scene) > 0) {
        shape_turn(rod, count, s, poses);
    }
}

/* The end whose pose places the rod: the first that holds the rotation, else the first that holds
 * the position, else the start. */
int rod_shape_anchor(const scene *rod_scene)
{
    scene_end_type start = rod_scene->start.type, end = rod_scene->end.type;
    bool end_places = scene_end_holds_position(end) && !scene_end_holds_position(start);
    return !scene_end_holds_rotation(start) && (scene_end_holds_rotation(end) || end_places);
}

/* Two pinned ends: the smallest rotation that turns the line between the ends of the unloaded rod
 * to the line between the two points; else, or without such lines, none. */
void rod_shape_upright(const scene *rod_scene, double q[4])
{
    double values[SHAPE_DEGREE + 1][SHAPE_ROWS], chord[3], side[3];
    const scene_end *start = &rod_scene->start, *end = &rod_scene->end;
    q[0] = 1;
    q[1] = q[2] = q[3] = 0;
    if (start->type != SCENE_PINNED || end->type != SCENE_PINNED || !start->position[0].is_given ||
        !end->position[0].is_given) {
        return;
    }
    shape_solve(rod_scene, values);
    shape_pose rest_end = {.q = {1, 0, 0, 0}}, motions[SCENE_SEGMENTS_MAX];
    memcpy(rest_end.r, values[SHAPE_DEGREE], sizeof rest_end.r);
    int joints = rod_joint_count(rod_scene);
    if (joints > 0) {
        shape_joints(rod_scene, motions);
        shape_move(&motions[joints - 1], &rest_end);
    }
    const double *rest = rest_end.r;
    double dot = 0, size = 0, square = 0;
    for (int i = 0; i < 3; i++) {
        chord[i] = quantity_value(end->position[i], scene_length(rod_scene), 0) -
                   quantity_value(start->position[i], 0, 0);
        dot += rest[i] * chord[i];
        size += rest[i] * rest[i];
        square += chord[i] * chord[i];
    }
    size = sqrt(size * square);
    cross(side, rest, chord);
    if (size + dot > 1e-6 * size) {
        double scale = 1 / sqrt(2 * size * (size + dot));
        q[0] = (size + dot) * scale;
        for (int i = 0; i < 3; i++) {
            q[i + 1] = side[i] * scale;
        }
    } else if (size > 0) { /* half a turn about anything across */
        double across[3] = {fabs(rest[0]) < fabs(rest[1]), fabs(rest[0]) >= fabs(rest[1]), 0};
        cross(side, rest, across);
        double norm = sqrt(side[0] * side[0] + side[1] * side[1] + side[2] * side[2]);
        q[0] = 0;
        for (int i = 0; i < 3; i++) {
            q[i + 1] = side[i] / norm;
        }
    }
}

/* Relative to the anchor's pose (r_e, q_e) at t = 0, with p = q_e q(e)^-1:
 * q(s) = p q(s), r(s) = r_e + R(p) (r(s) - r(e)). */
rod_pose rod_undeformed(const rod_context *rod, ad_value s)
{
    int anchor = rod_shape_anchor(rod->scene);
    const scene_end *end = anchor ? &rod->scene->end : &rod->scene->start;
    const double origin[3] = {0, 0, 0};
    double upright[4];
    rod_shape_upright(rod->scene, upright);
    ad_value zero = ad_scalar(rod->tape, 0), at = ad_scalar(rod->tape, anchor);
    ad_value position =
        rod_quantities(rod, 3, end->position, origin, 1 / rod->scales.length, at, zero);
    ad_value rotation = ad_normalize(rod_quantities(rod, 4, end->rotation, upright, 1, at, zero));
    position = rod_from_world(rod, position);
    rotation = rod_rotation_from_world(rod, rotation);
    rod_pose poses[2];
    shape_poses(rod, 2, (ad_value[]){s, at}, poses);
    ad_value turn = ad_quaternion_multiply(rotation, ad_quaternion_conjugate(poses[1].rotation));
    ad_value from_anchor = ad_sub(poses[0].position, poses[1].position);
    rod_pose pose = {.position = ad_add(position, ad_rotate(turn, from_anchor)),
                     .rotation = ad_quaternion_multiply(turn, poses[0].rotation)};
    return rod_pose_in_plane(rod, pose);
}
