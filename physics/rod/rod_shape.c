/* The unloaded rod: v = v*, u = u* from a held end on, and the turns of joints. Exact exponentials
 * where v*, u* are constant; elsewhere a numerical solution as Chebyshev polynomials, which the
 * tape can differentiate. Each piece of the rod by itself, so that jumps cost nothing. */
#include "physics/rod/rod_shape.h"

#include "physics/numerics/constants.h"
#include "physics/numerics/quaternion.h"
#include "physics/numerics/vector_size.h"
#include "physics/scene/breaks.h"

#include <string.h>

shape_twist rod_shape_rest(const shape_piece *piece, double s)
{
    const scene_rest *rest = &piece->rest;
    double length = piece->length;
    shape_twist twist;
    for (int i = 0; i < 3; i++) {
        twist.v.x[i] = quantity_value(rest->strain[i], s * length, 0);
        twist.u.x[i] = 0;
        twist.u.x[i] += length * quantity_value(rest->curvature[i], s * length, 0);
        twist.u.x[i] += length * quantity_value(rest->imperfection[i], s * length, 0);
    }
    return twist;
}

double rod_shape_gauss(int i, double s, double h)
{
    return s + (0.5 + (i - 1) * sqrt(0.15)) * h;
}

double rod_shape_point(const shape_piece *piece, int degree, int j)
{
    return piece->from + (piece->to - piece->from) * (0.5 - 0.5 * cos(PI * j / degree));
}

double rod_shape_share(int degree, int k, int j)
{
    return (j == 0 || j == degree ? 0.5 : 1) * cos(PI * (degree - j) * k / degree);
}

shape_pose rod_shape_solve(const shape_piece *piece, int degree, int steps,
                           double (*values)[SHAPE_ROWS])
{
    shape_pose pose = piece->start;
    double s = piece->from;
    for (int j = 0; j <= degree; j++) {
        double next = rod_shape_point(piece, degree, j);
        double h = (next - s) / steps;
        for (int i = 0; i < steps && j > 0; i++) {
            shape_twist at[3];
            for (int k = 0; k < 3; k++) {
                at[k] = rod_shape_rest(piece, rod_shape_gauss(k, s + i * h, h));
            }
            pose = shape_advance(pose, shape_step(at, h), 1);
        }
        s = next;
        if (values) {
            memcpy(values[j], pose.r.x, sizeof pose.r);
            memcpy(values[j] + 3, pose.q.x, sizeof pose.q);
        }
    }
    return pose;
}

/* The end of a piece of constant strains. */
static shape_pose shape_arc(const shape_piece *piece)
{
    shape_twist twist = rod_shape_rest(piece, piece->from);
    for (int i = 0; i < 3; i++) {
        twist.u.x[i] *= piece->to - piece->from;
        twist.v.x[i] *= piece->to - piece->from;
    }
    return shape_advance(piece->start, twist, 1);
}

/* Of values [SHAPE_DEGREE + 1]; returns the degree that matters. */
static int shape_coefficients(double (*values)[SHAPE_ROWS], double (*c)[SHAPE_ROWS])
{
    int degree = 1;
    for (int k = 0; k <= SHAPE_DEGREE; k++) {
        for (int row = 0; row < SHAPE_ROWS; row++) {
            double sum = 0;
            for (int j = SHAPE_DEGREE; j >= 0; j--) {
                sum += rod_shape_share(SHAPE_DEGREE, k, j) * values[j][row];
            }
            c[k][row] = sum * shape_factor(SHAPE_DEGREE, k) / SHAPE_DEGREE;
            if (fabs(c[k][row]) > 1e-15 && k > degree) {
                degree = k;
            }
        }
    }
    return degree;
}

bool rod_shape_is_uniform(const scene_rest *rest)
{
    return !quantity_any_depends_on(3, rest->strain, "s") &&
           !quantity_any_depends_on(3, rest->curvature, "s") &&
           !quantity_any_depends_on(3, rest->imperfection, "s");
}

/* Where the rest shape of a piece jumps or has a kink at t = 0, or what is narrow begins or ends;
 * in m. */
static void shape_breaks(double length, const scene_rest *rest, scene_breaks *breaks)
{
    ad_error error;
    scene alone = {.rod.length = quantity_number(length)};
    memcpy(alone.rod.rest_strain, rest->strain, sizeof rest->strain);
    memcpy(alone.rod.rest_curvature, rest->curvature, sizeof rest->curvature);
    memcpy(alone.rod.imperfection, rest->imperfection, sizeof rest->imperfection);
    if (scene_divisions_of(&alone, "s", SHAPE_PIECES_MAX / 2, breaks, &error) != AD_OK) {
        breaks->count = 0; /* out of memory, as the tape will say, too */
    }
}

/* One more piece from where the last one ends. */
static void add_piece(shape *made, int segment, const scene_rest *rest, const shape_twist *turn,
                      double length, double from, double to)
{
    double values[SHAPE_DEGREE + 1][SHAPE_ROWS];
    shape_piece *piece = &made->pieces[made->count++];
    *piece = (shape_piece){.segment = segment,
                           .from = from,
                           .to = to,
                           .length = length,
                           .rest = *rest,
                           .is_uniform = rod_shape_is_uniform(rest),
                           .turn = *turn,
                           .start = shape_advance(made->end, *turn, 1)};
    if (piece->is_uniform) {
        made->end = shape_arc(piece);
    } else {
        made->end = rod_shape_solve(piece, SHAPE_DEGREE, SHAPE_STEPS, values);
        piece->degree = shape_coefficients(values, piece->c);
    }
    piece->end = made->end;
}

void rod_shape_make(const scene *rod_scene, shape *made)
{
    double length = scene_length(rod_scene);
    scene_breaks breaks = {.count = 0};
    made->count = 0;
    made->end = (shape_pose){.q = {{1, 0, 0, 0}}};
    for (int i = 0; i < scene_pieces(rod_scene); i++) {
        scene_piece given = scene_piece_of(rod_scene, i);
        shape_twist turn = {.u = {{given.turn[0], given.turn[1], given.turn[2]}}};
        scene_rest rest = scene_rod_rest(&given.rod);
        double from = given.from, left = scene_pieces(rod_scene) - i;
        if (!rod_shape_is_uniform(&rest)) {
            shape_breaks(length, &rest, &breaks);
        }
        for (int k = 0; k < breaks.count && made->count + left < SHAPE_PIECES_MAX; k++) {
            double place = breaks.place[k];
            if (place > from && place < given.to) {
                add_piece(made, i, &rest, &turn, length, from / length, place / length);
                turn = (shape_twist){.u = {{0}}};
                from = place;
            }
        }
        breaks.count = 0;
        add_piece(made, i, &rest, &turn, length, from / length, given.to / length);
    }
}

bool rod_shape_is_resolved(const scene *rod_scene)
{
    shape made;
    bool resolved = true;
    rod_shape_make(rod_scene, &made);
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

bool rod_shape_is_between(const scene *rod_scene)
{
    bool is_between = true;
    for (int i = 0; i < 2; i++) {
        const scene_end *held = i ? &rod_scene->end : &rod_scene->start;
        is_between = is_between && scene_end_is_placed(held->type) &&
                     !scene_end_holds_rotation(held->type) && held->position[0].is_given;
    }
    return is_between;
}

void rod_shape_upright(const scene *rod_scene, double q[4])
{
    double chord[3], side[3];
    shape made;
    const scene_end *start = &rod_scene->start, *end = &rod_scene->end;
    q[0] = 1;
    q[1] = q[2] = q[3] = 0;
    if (!rod_shape_is_between(rod_scene)) {
        return;
    }
    rod_shape_make(rod_scene, &made);
    const double *rest = made.end.r.x;
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
    rod_shape_make(rod_scene, &made);
    quaternion_product(held[0], made.end.q.x, rest);
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
