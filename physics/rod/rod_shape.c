/* The unloaded rod: v = v*, u = u* from a held end on, and the turns of joints. Exact exponentials
 * where v*, u* are constant; elsewhere a numerical solution as Chebyshev polynomials, which the
 * tape can differentiate. Each piece of the rod by itself, so that jumps cost nothing. */
#include "physics/numerics/constants.h"
#include "physics/numerics/quaternion.h"
#include "physics/numerics/vector_size.h"
#include "physics/rod/rod_internal.h"
#include "physics/scene/breaks.h"

#include <math.h>
#include <string.h>

enum {
    SHAPE_DEGREE = 40, /* of the polynomials; coefficients at rounding level are cut off */
    SHAPE_STEPS = 16,  /* of the integrator between two Chebyshev points */
    SHAPE_ROWS = 7,    /* r, q */
    SHAPE_PIECES_MAX = 64
};

/* ---- numbers --------------------------------------------------------------------------------- */

typedef struct shape_twist {
    double u[3], v[3];
} shape_twist;

typedef struct shape_pose {
    double r[3], q[4];
} shape_pose;

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
    vector_cross(u, v, uv);
    vector_cross(u, uv, uuv);
    for (int i = 0; i < 3; i++) {
        step[i] = v[i] + shape_stumpff(2, square) * uv[i] + shape_stumpff(3, square) * uuv[i];
    }
    double *q = pose->q, half = 0.5 * shape_stumpff(1, square / 4), turned[3], twice[3];
    vector_cross(q + 1, step, turned);
    for (int i = 0; i < 3; i++) {
        turned[i] *= 2;
    }
    vector_cross(q + 1, turned, twice);
    for (int i = 0; i < 3; i++) {
        pose->r[i] += step[i] + q[0] * turned[i] + twice[i];
    }
    double p[4] = {shape_stumpff(0, square / 4), half * u[0], half * u[1], half * u[2]}, side[3];
    double scalar = q[0] * p[0] - q[1] * p[1] - q[2] * p[2] - q[3] * p[3];
    vector_cross(q + 1, p + 1, side);
    for (int i = 0; i < 3; i++) {
        q[i + 1] = q[0] * p[i + 1] + p[0] * q[i + 1] + side[i];
    }
    q[0] = scalar;
}

/* pose exp(twist) of any size, in steps that shape_stumpff is good for. */
static void shape_turn(shape_pose *pose, const shape_twist *twist)
{
    const double *u = twist->u;
    int steps = 1 + (int)fmin(vector_length(u), 1e6);
    shape_twist part;
    for (int i = 0; i < 3; i++) {
        part.u[i] = u[i] / steps;
        part.v[i] = twist->v[i] / steps;
    }
    for (int i = 0; i < steps; i++) {
        shape_advance(pose, &part);
    }
}

/* From `from` to `to`, of arc length over the length of the rod. */
typedef struct shape_piece {
    double from, to;
    double length; /* of the rod; m */
    scene_rest rest;
    bool is_uniform; /* constant strains at t = 0 */
    shape_pose start;
    double c[SHAPE_DEGREE + 1][SHAPE_ROWS]; /* if it is not */
    int degree;
} shape_piece;

static shape_twist shape_rest(const shape_piece *piece, double s)
{
    const scene_rest *rest = &piece->rest;
    double length = piece->length;
    shape_twist twist;
    for (int i = 0; i < 3; i++) {
        twist.v[i] = quantity_value(rest->strain[i], s * length, 0);
        twist.u[i] = 0;
        twist.u[i] += length * quantity_value(rest->curvature[i], s * length, 0);
        twist.u[i] += length * quantity_value(rest->imperfection[i], s * length, 0);
    }
    return twist;
}

/* [a, b] of twists. */
static shape_twist shape_bracket(const shape_twist *a, const shape_twist *b)
{
    shape_twist result;
    double moved[3];
    vector_cross(a->u, b->u, result.u);
    vector_cross(a->u, b->v, result.v);
    vector_cross(a->v, b->u, moved);
    for (int i = 0; i < 3; i++) {
        result.v[i] += moved[i];
    }
    return result;
}

/* x a + y b */
static shape_twist shape_sum(double x, const shape_twist *a, double y, const shape_twist *b)
{
    shape_twist result;
    for (int i = 0; i < 3; i++) {
        result.u[i] = x * a->u[i] + y * b->u[i];
        result.v[i] = x * a->v[i] + y * b->v[i];
    }
    return result;
}

/* One step of the Magnus method of order 6 with Gauss points (Blanes, Casas, Oteo, Ros, Physics
 * Reports 470, 2009, section 5.2, brackets of the other sign), for g' = g twist. */
static void shape_step(const shape_piece *piece, shape_pose *pose, double s, double h)
{
    double offset = sqrt(0.15), root = sqrt(15.0) / 3 * h;
    shape_twist a = shape_rest(piece, s + (0.5 - offset) * h), b = shape_rest(piece, s + 0.5 * h);
    shape_twist c = shape_rest(piece, s + (0.5 + offset) * h), ends = shape_sum(1, &a, 1, &c);
    shape_twist first = shape_sum(h, &b, 0, &b), second = shape_sum(root, &c, -root, &a);
    shape_twist third = shape_sum(10 * h / 3, &ends, -20 * h / 3, &b);
    shape_twist turn = shape_bracket(&first, &second), left = shape_sum(-20, &first, -1, &third);
    shape_twist inner = shape_sum(2, &third, -1, &turn), right = shape_bracket(&first, &inner);
    left = shape_sum(1, &left, -1, &turn);
    right = shape_sum(1, &second, 1.0 / 60, &right);
    turn = shape_bracket(&left, &right);
    shape_twist sum = shape_sum(1, &first, 1.0 / 12, &third);
    sum = shape_sum(1, &sum, -1.0 / 240, &turn);
    shape_advance(pose, &sum);
}

/* values [SHAPE_DEGREE + 1][SHAPE_ROWS] of the pose at the Chebyshev points of the piece,
 * ascending; returns the last. */
static shape_pose shape_solve(const shape_piece *piece, double (*values)[SHAPE_ROWS])
{
    shape_pose pose = piece->start;
    double s = piece->from, span = piece->to - piece->from;
    for (int j = 0; j <= SHAPE_DEGREE; j++) {
        double next = piece->from + span * (0.5 - 0.5 * cos(PI * j / SHAPE_DEGREE));
        double h = (next - s) / SHAPE_STEPS;
        for (int i = 0; i < SHAPE_STEPS && j > 0; i++) {
            shape_step(piece, &pose, s + i * h, h);
        }
        s = next;
        memcpy(values[j], pose.r, sizeof pose.r);
        memcpy(values[j] + 3, pose.q, sizeof pose.q);
    }
    return pose;
}

/* The end of a piece of constant strains. */
static shape_pose shape_arc(const shape_piece *piece)
{
    shape_twist twist = shape_rest(piece, piece->from);
    shape_pose pose = piece->start;
    for (int i = 0; i < 3; i++) {
        twist.u[i] *= piece->to - piece->from;
        twist.v[i] *= piece->to - piece->from;
    }
    shape_turn(&pose, &twist);
    return pose;
}

/* Coefficients of sum_k c_k T_k(x), x from -1 to 1 along the piece; returns the degree that
 * matters. */
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

/* Constant strains at t = 0. */
static bool shape_is_uniform(const scene_rest *rest)
{
    return !quantity_any_depends_on(3, rest->strain, "s") &&
           !quantity_any_depends_on(3, rest->curvature, "s") &&
           !quantity_any_depends_on(3, rest->imperfection, "s");
}

typedef struct shape {
    int count;
    shape_piece pieces[SHAPE_PIECES_MAX];
    shape_pose end;
} shape;

/* Where the rest shape of a piece jumps or has a kink at t = 0, or what is narrow begins or ends;
 * in m. */
static void shape_breaks(const scene *rod_scene, const scene_piece *given, scene_breaks *breaks)
{
    ad_error error;
    scene alone = {.rod.length = quantity_number(scene_length(rod_scene))};
    memcpy(alone.rod.rest_strain, given->rod.rest_strain, sizeof alone.rod.rest_strain);
    memcpy(alone.rod.rest_curvature, given->rod.rest_curvature, sizeof alone.rod.rest_curvature);
    memcpy(alone.rod.imperfection, given->rod.imperfection, sizeof alone.rod.imperfection);
    if (scene_divisions_of(&alone, "s", SHAPE_PIECES_MAX / 2, breaks, &error) != AD_OK) {
        breaks->count = 0; /* out of memory, as the tape will say, too */
    }
}

/* One more piece from where the last one ends. */
static void shape_add(shape *made, const scene_rest *rest, double length, double from, double to)
{
    double values[SHAPE_DEGREE + 1][SHAPE_ROWS];
    shape_piece *piece = &made->pieces[made->count++];
    *piece = (shape_piece){.from = from,
                           .to = to,
                           .length = length,
                           .rest = *rest,
                           .is_uniform = shape_is_uniform(rest),
                           .start = made->end};
    if (piece->is_uniform) {
        made->end = shape_arc(piece);
    } else {
        made->end = shape_solve(piece, values);
        piece->degree = shape_coefficients(values, piece->c);
    }
}

/* From the identity at s = 0. Where there are more breaks than pieces, the last ones stay within
 * one, which then is not resolved. */
static void shape_make(const scene *rod_scene, shape *made)
{
    double length = scene_length(rod_scene);
    scene_breaks breaks = {.count = 0};
    made->count = 0;
    made->end = (shape_pose){.q = {1, 0, 0, 0}};
    for (int i = 0; i < scene_pieces(rod_scene); i++) {
        scene_piece given = scene_piece_of(rod_scene, i);
        shape_twist turn = {{given.turn[0], given.turn[1], given.turn[2]}, {0, 0, 0}};
        scene_rest rest = scene_rod_rest(&given.rod);
        double from = given.from, left = scene_pieces(rod_scene) - i;
        shape_turn(&made->end, &turn);
        if (!shape_is_uniform(&rest)) {
            shape_breaks(rod_scene, &given, &breaks);
        }
        for (int k = 0; k < breaks.count && made->count + left < SHAPE_PIECES_MAX; k++) {
            double place = breaks.place[k];
            if (place > from && place < given.to) {
                shape_add(made, &rest, length, from / length, place / length);
                from = place;
            }
        }
        breaks.count = 0;
        shape_add(made, &rest, length, from / length, given.to / length);
    }
}

/* ---- on the tape ----------------------------------------------------------------------------- */

/* Clenshaw's recurrence on all seven rows at once. Beyond the piece, where another one holds, its
 * polynomial is taken no farther than a length of the piece away, so that it stays finite. */
static ad_value shape_clenshaw(ad_value s, const shape_piece *piece)
{
    double span = piece->to - piece->from;
    ad_value along = ad_scale(ad_sub(s, ad_scalar(s.tape, piece->from)), 2 / span);
    ad_value x = ad_sub(along, ad_scalar(s.tape, 1)), twice;
    if (span < 1) {
        x = ad_max(ad_min(x, ad_scalar(s.tape, 3)), ad_scalar(s.tape, -3));
    }
    twice = ad_scale(x, 2);
    ad_value b1 = ad_zeros(s.tape, SHAPE_ROWS), b2 = b1;
    for (int k = piece->degree; k >= 1; k--) {
        ad_value coefficient = ad_constant(s.tape, SHAPE_ROWS, piece->c[k]);
        ad_value b0 = ad_add(coefficient, ad_sub(ad_mul(twice, b1), b2));
        b2 = b1;
        b1 = b0;
    }
    return ad_add(ad_constant(s.tape, SHAPE_ROWS, piece->c[0]), ad_sub(ad_mul(x, b1), b2));
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

static rod_pose shape_pose_of(const shape_piece *piece, ad_value s)
{
    if (!piece->is_uniform) {
        ad_value rows = shape_clenshaw(s, piece);
        return (rod_pose){.position = ad_slice(rows, 0, 3),
                          .rotation = ad_normalize(ad_slice(rows, 3, 4))};
    }
    shape_twist twist = shape_rest(piece, piece->from);
    rod_pose pose = shape_helix(&twist, ad_sub(s, ad_scalar(s.tape, piece->from)));
    if (piece->from == 0) {
        return pose; /* from the identity */
    }
    ad_value position = ad_constant(s.tape, 3, piece->start.r);
    ad_value rotation = ad_constant(s.tape, 4, piece->start.q);
    return (rod_pose){.position = ad_add(position, ad_rotate(rotation, pose.position)),
                      .rotation = ad_quaternion_multiply(rotation, pose.rotation)};
}

/* A place where pieces meet belongs to what is before. */
static rod_pose shape_at(const shape *given, ad_value s)
{
    rod_pose pose = shape_pose_of(&given->pieces[0], s);
    for (int i = 1; i < given->count; i++) {
        rod_pose behind = shape_pose_of(&given->pieces[i], s);
        ad_value beyond = ad_sub(s, ad_scalar(s.tape, given->pieces[i].from));
        pose.position = ad_select(beyond, behind.position, pose.position);
        pose.rotation = ad_select(beyond, behind.rotation, pose.rotation);
    }
    return pose;
}

bool rod_shape_is_resolved(const scene *rod_scene)
{
    shape made;
    bool resolved = true;
    shape_make(rod_scene, &made);
    for (int i = 0; i < made.count && resolved; i++) {
        const shape_piece *piece = &made.pieces[i];
        double rest = 0;
        for (int row = 0; row < SHAPE_ROWS && !piece->is_uniform; row++) {
            for (int k = SHAPE_DEGREE - 3; k <= SHAPE_DEGREE; k++) {
                rest += fabs(piece->c[k][row]);
            }
        }
        resolved = rest <= ROD_MISMATCH;
    }
    return resolved;
}

/* The end whose pose places the rod: the first that holds the rotation, else the first that holds
 * the position, else the start. */
int rod_shape_anchor(const scene *rod_scene)
{
    scene_end_type start = rod_scene->start.type, end = rod_scene->end.type;
    bool end_places = scene_end_is_placed(end) && !scene_end_is_placed(start);
    return !scene_end_holds_rotation(start) && (scene_end_holds_rotation(end) || end_places);
}

/* Two ends that are held and turn freely: the smallest rotation that turns the line between the
 * ends of the unloaded rod to the line between the two points; else, or without such lines, none.
 */
void rod_shape_upright(const scene *rod_scene, double q[4])
{
    double chord[3], side[3];
    shape made;
    const scene_end *start = &rod_scene->start, *end = &rod_scene->end;
    q[0] = 1;
    q[1] = q[2] = q[3] = 0;
    for (int i = 0; i < 2; i++) {
        const scene_end *held = i ? end : start;
        if (!scene_end_is_placed(held->type) || scene_end_holds_rotation(held->type) ||
            !held->position[0].is_given) {
            return;
        }
    }
    shape_make(rod_scene, &made);
    const double *rest = made.end.r;
    double dot = 0, size = 0, square = 0;
    for (int i = 0; i < 3; i++) {
        chord[i] = quantity_value(end->position[i], scene_length(rod_scene), 0) -
                   quantity_value(start->position[i], 0, 0);
        dot += rest[i] * chord[i];
        size += rest[i] * rest[i];
        square += chord[i] * chord[i];
    }
    size = sqrt(size * square);
    vector_cross(rest, chord, side);
    if (size + dot > 1e-6 * size) {
        double scale = 1 / sqrt(2 * size * (size + dot));
        q[0] = (size + dot) * scale;
        for (int i = 0; i < 3; i++) {
            q[i + 1] = side[i] * scale;
        }
    } else if (size > 0) { /* half a turn about anything across */
        double across[3] = {fabs(rest[0]) < fabs(rest[1]), fabs(rest[0]) >= fabs(rest[1]), 0};
        vector_cross(rest, across, side);
        double norm = vector_length(side);
        q[0] = 0;
        for (int i = 0; i < 3; i++) {
            q[i + 1] = side[i] / norm;
        }
    }
}

/* A turn by more than this, by the shorter way, may as well be meant the other way round. */
static const double SHAPE_DOUBT = 2.967; /* rad, 170 degrees */

bool rod_turn_is_doubtful(const scene *rod_scene, double turn[3])
{
    double held[2][4], rest[4], back[4], q[4];
    const scene_end *ends[2] = {&rod_scene->start, &rod_scene->end};
    shape made;
    if (scene_is_beam(rod_scene) || scene_is_dynamic(rod_scene) ||
        scene_is_manufactured(rod_scene)) {
        return false;
    }
    for (int i = 0; i < 2; i++) {
        double square = 0;
        for (int k = 0; k < 4; k++) {
            quantity given = quantity_or(ends[i]->rotation[k], quantity_number(k == 0));
            held[i][k] = quantity_value(given, 0, 0);
            square += held[i][k] * held[i][k];
        }
        for (int k = 0; k < 4; k++) {
            held[i][k] /= sqrt(square);
        }
        if (!scene_end_holds_rotation(ends[i]->type)) {
            return false;
        }
    }
    shape_make(rod_scene, &made);
    quaternion_product(held[0], made.end.q, rest);
    for (int k = 1; k < 4; k++) {
        rest[k] = -rest[k];
    }
    memcpy(back, rest, sizeof back);
    quaternion_product(held[1], back, q);
    double size = sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    double angle = 2 * atan2(size, fabs(q[0])), sign = q[0] < 0 ? -1 : 1;
    for (int i = 0; i < 3; i++) {
        turn[i] = size > 0 ? sign * angle * q[i + 1] / size + 0.0 : 0;
    }
    bool round = size < 1e-9; /* -1: a whole turn, or none */
    return ends[1]->rotation[0].is_given && !round && (q[0] < 0 || angle > SHAPE_DOUBT);
}

/* A straight rod whose lengths differ from member to member: where s is on the rod as written. */
static rod_pose shape_straight(const rod_context *rod, ad_value s)
{
    const ad_value zero = ad_scalar(rod->tape, 0);
    const ad_value far = ad_sub(rod_quantity(rod, rod->scene->place, s, zero),
                                rod_quantity(rod, rod->scene->place, zero, zero));
    const ad_value along = ad_scale(far, 1 / rod->scales.length);
    return (rod_pose){.position = ad_stack(3, (ad_value[]){zero, zero, along}),
                      .rotation = ad_constant(rod->tape, 4, (const double[]){1, 0, 0, 0})};
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
    shape made;
    const bool straight = rod->scene->place.is_given && scene_rests_straight(rod->scene);
    if (!straight) {
        shape_make(rod->scene, &made);
    }
    const rod_pose poses[2] = {straight ? shape_straight(rod, s) : shape_at(&made, s),
                               straight ? shape_straight(rod, at) : shape_at(&made, at)};
    ad_value turn = ad_quaternion_multiply(rotation, ad_quaternion_conjugate(poses[1].rotation));
    ad_value from_anchor = ad_sub(poses[0].position, poses[1].position);
    rod_pose pose = {.position = ad_add(position, ad_rotate(turn, from_anchor)),
                     .rotation = ad_quaternion_multiply(turn, poses[0].rotation)};
    return rod_pose_in_plane(rod, pose);
}
