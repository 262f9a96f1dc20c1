/* The unloaded rod on the tape: numbers of rod_shape.c as constants; where rest strains depend on
 * parameters, the same steps as functions of these. */
#include "physics/rod/rod_shape.h"

#include <math.h>
#include <string.h>

static ad_value taped_add3(ad_value a, ad_value b, ad_value c)
{
    return ad_add(a, ad_add(b, c));
}

#define SHAPE_NUMBER   ad_value
#define SHAPE_VECTOR   ad_value
#define SHAPE_ROTATION ad_value
#define SHAPE(name)    taped_##name
#define taped_add      ad_add
#define taped_times    ad_mul
#define taped_scale    ad_scale
#define taped_dot      ad_dot
#define taped_cross    ad_cross
#define taped_stumpff  ad_stumpff
#define taped_rotate   ad_rotate
#define taped_multiply ad_quaternion_multiply
#define taped_exp      ad_quaternion_exp
#include "physics/rod/shape_algebra.h"

/* One of the pieces; `twist` where it is uniform, else coefficients. */
typedef struct taped_piece {
    double from, to;
    bool is_uniform;
    taped_pose start;
    taped_twist twist;
    int degree;
    ad_value c[SHAPE_DEGREE + 1];
} taped_piece;

typedef struct taped_shape {
    int count;
    taped_piece pieces[SHAPE_PIECES_MAX];
} taped_shape;

/* ---- where nothing depends on a parameter ---------------------------------------------------- */

static taped_pose pose_constant(ad_tape *tape, const shape_pose *pose)
{
    return (taped_pose){ad_constant(tape, 3, pose->r.x), ad_constant(tape, 4, pose->q.x)};
}

static taped_twist twist_constant(ad_tape *tape, const shape_twist *twist)
{
    return (taped_twist){ad_constant(tape, 3, twist->u.x), ad_constant(tape, 3, twist->v.x)};
}

static void put_numbers(ad_tape *tape, const shape_piece *given, taped_piece *to)
{
    to->start = pose_constant(tape, &given->start);
    if (given->is_uniform) {
        const shape_twist twist = rod_shape_rest(given, given->from);
        to->twist = twist_constant(tape, &twist);
    }
    to->degree = given->degree;
    for (int k = 0; k <= given->degree && !given->is_uniform; k++) {
        to->c[k] = ad_constant(tape, SHAPE_ROWS, given->c[k]);
    }
}

/* ---- where something does -------------------------------------------------------------------- */

static bool depends(const rod_context *rod, int count, const quantity *given)
{
    bool any = false;
    for (int i = 0; i < rod->parameter_count; i++) {
        any = any || quantity_any_depends_on(count, given, rod->parameters[i].name);
    }
    return any;
}

/* Of a rod at rest that nothing is measured from it is where a search begins, which is one for all.
 */
static bool counts(const rod_context *rod)
{
    const scene *given = rod->scene;
    return rod->dynamic || scene_measures_from_rest(given) ||
           given->start.rotation_vector[0].is_given || given->end.rotation_vector[0].is_given;
}

static bool rest_depends(const rod_context *rod)
{
    const scene_rest rest = scene_rest_of(rod->scene);
    return depends(rod, 3, rest.strain) || depends(rod, 3, rest.curvature) ||
           depends(rod, 3, rest.imperfection);
}

/* Between two pinned ends. */
static bool chord_depends(const rod_context *rod)
{
    return depends(rod, 3, rod->scene->start.position) || depends(rod, 3, rod->scene->end.position);
}

/* What serves all members, by one within the ranges and those in their corners. */
typedef struct taped_fit {
    shape within;
    bool is_uniform[SHAPE_PIECES_MAX];
    int degree[SHAPE_PIECES_MAX], steps[SHAPE_PIECES_MAX];
    double upright[4];
    const char *problem; /* NULL: none */
} taped_fit;

static double distance(const shape_pose *a, const shape_pose *b)
{
    double most = 0;
    for (int i = 0; i < 4; i++) {
        most = fmax(most, fabs(a->q.x[i] - b->q.x[i]));
        most = i < 3 ? fmax(most, fabs(a->r.x[i] - b->r.x[i])) : most;
    }
    return most;
}

/* Of shapes on the tape, which grow with degrees and steps: below what solvers are asked for. */
static const double SMALL = 1e-12;

static int degree_of(const shape_piece *piece)
{
    enum { LEAST = 8, MORE = 4 }; /* for members that are not looked at */
    int degree = piece->degree;
    for (double size = 0; degree > LEAST; degree--) {
        for (int row = 0; row < SHAPE_ROWS; row++) {
            size = fmax(size, fabs(piece->c[degree][row]));
        }
        if (size > SMALL) {
            break;
        }
    }
    return degree > SHAPE_DEGREE - MORE ? SHAPE_DEGREE : degree + MORE;
}

/* How many steps from Chebyshev point to point reach the end of a piece as SHAPE_STEPS do. */
static int steps_of(const shape_piece *piece, int degree)
{
    for (int steps = 1; steps < SHAPE_STEPS; steps++) {
        const shape_pose end = rod_shape_solve(piece, degree, steps, NULL);
        if (distance(&end, &piece->end) <= 10 * SMALL) {
            return steps;
        }
    }
    return SHAPE_STEPS;
}

/* Whether pieces end where some of the others do. */
static bool ends_are_among(const shape *pieces, const shape *others)
{
    static const double SAME = 1e-9;
    int found = 0;
    for (int i = 0; i < others->count && found < pieces->count; i++) {
        found += fabs(pieces->pieces[found].to - others->pieces[i].to) <= SAME;
    }
    return found == pieces->count;
}

static void fit_member(const scene *member, taped_fit *fit)
{
    shape made;
    double upright[4];
    rod_shape_make(member, &made);
    rod_shape_upright(member, upright);
    for (int i = 0; i < made.count && made.count == fit->within.count; i++) {
        if (!fit->is_uniform[i]) {
            const int degree = degree_of(&made.pieces[i]);
            fit->degree[i] = degree > fit->degree[i] ? degree : fit->degree[i];
            const int steps = steps_of(&made.pieces[i], fit->degree[i]);
            fit->steps[i] = steps > fit->steps[i] ? steps : fit->steps[i];
        }
    }
    if (!ends_are_among(&made, &fit->within)) {
        fit->problem = "a parameter moves a place at which it jumps, has a kink or is narrow; "
                       "allowed where the unstressed shape counts: places that stay";
    } else if ((upright[0] == 0) != (fit->upright[0] == 0)) {
        fit->problem = "within the ranges the unstressed rod between its two ends turns over; "
                       "allowed: ranges within which it does not";
    }
}

/* The member at these fractions of the ranges; the first has the places of all. */
static void fit_fractions(const scene *open, bool is_first, const double *fractions, taped_fit *fit)
{
    double values[SCENE_PARAMETERS_MAX];
    scene member;
    for (int i = 0; i < open->parameter_count; i++) {
        values[i] = scene_parameter_at(&open->parameters[i], fractions[i]);
    }
    scene_member(open, values, &member);
    if (is_first) {
        rod_shape_make(&member, &fit->within);
        rod_shape_upright(&member, fit->upright);
        for (int i = 0; i < fit->within.count; i++) {
            const scene_piece piece = scene_piece_of(open, fit->within.pieces[i].segment);
            const scene_rest rest = scene_rod_rest(&piece.rod);
            fit->is_uniform[i] = rod_shape_is_uniform(&rest);
        }
    }
    fit_member(&member, fit);
}

static void fit_members(const scene *open, taped_fit *fit)
{
    enum { CORNERS_OF = 3, SPREAD = 4 }; /* parameters, others go with one of these; members */
    const int count = open->parameter_count, bits = count < CORNERS_OF ? count : CORNERS_OF;
    *fit = (taped_fit){.problem = NULL};
    for (int member = 0; member < SPREAD + (1 << bits) && !fit->problem; member++) {
        double fractions[SCENE_PARAMETERS_MAX];
        for (int i = 0; i < count; i++) {
            fractions[i] = member < SPREAD ? scene_spread_fraction(member, i)
                                           : (member - SPREAD) >> i % CORNERS_OF & 1;
        }
        fit_fractions(open, member == 0, fractions, fit);
    }
}

static taped_twist twist_at(const rod_context *rod, const scene_rest *rest, double s)
{
    static const double zeros[3] = {0};
    const ad_value at = ad_scalar(rod->tape, s), zero = ad_scalar(rod->tape, 0);
    const double length = rod->scales.length;
    return (taped_twist){
        ad_add(rod_quantities(rod, 3, rest->curvature, zeros, length, at, zero),
               rod_quantities(rod, 3, rest->imperfection, zeros, length, at, zero)),
        rod_quantities(rod, 3, rest->strain, zeros, 1, at, zero)};
}

/* rod_shape_solve, and coefficients; returns the end. */
static taped_pose put_solution(const rod_context *rod, const shape_piece *given,
                               const scene_rest *rest, int steps, taped_piece *to)
{
    const ad_value one = ad_scalar(rod->tape, 1);
    ad_value values[SHAPE_DEGREE + 1];
    taped_pose pose = to->start;
    double s = given->from;
    for (int j = 0; j <= to->degree; j++) {
        const double next = rod_shape_point(given, to->degree, j), h = (next - s) / steps;
        for (int i = 0; i < steps && j > 0; i++) {
            taped_twist at[3];
            for (int k = 0; k < 3; k++) {
                at[k] = twist_at(rod, rest, rod_shape_gauss(k, s + i * h, h));
            }
            pose = taped_advance(pose, taped_step(at, h), one);
        }
        s = next;
        values[j] = ad_stack(2, (const ad_value[]){pose.r, pose.q});
    }
    for (int k = 0; k <= to->degree; k++) {
        const double factor = shape_factor(to->degree, k) / to->degree;
        to->c[k] = ad_zeros(rod->tape, SHAPE_ROWS);
        for (int j = 0; j <= to->degree; j++) {
            to->c[k] =
                ad_add(to->c[k], ad_scale(values[j], factor * rod_shape_share(to->degree, k, j)));
        }
    }
    return pose;
}

static void put_formulas(const rod_context *rod, const taped_fit *fit, taped_shape *to)
{
    const shape_pose upright = {.q = {{1, 0, 0, 0}}};
    const ad_value one = ad_scalar(rod->tape, 1);
    taped_pose pose = pose_constant(rod->tape, &upright);
    for (int i = 0; i < to->count; i++) {
        const shape_piece *given = &fit->within.pieces[i];
        const scene_piece piece = scene_piece_of(rod->scene, given->segment);
        const scene_rest rest = scene_rod_rest(&piece.rod);
        taped_piece *one_of = &to->pieces[i];
        pose = taped_advance(pose, twist_constant(rod->tape, &given->turn), one);
        one_of->start = pose;
        one_of->degree = fit->degree[i];
        if (one_of->is_uniform) {
            one_of->twist = twist_at(rod, &rest, given->from);
            pose =
                taped_advance(pose, one_of->twist, ad_scalar(rod->tape, given->to - given->from));
        } else {
            pose = put_solution(rod, given, &rest, fit->steps[i], one_of);
        }
    }
}

/* ---- the shape ------------------------------------------------------------------------------- */

/* Clenshaw's recurrence on all seven rows at once. Beyond the piece, where another one holds, its
 * polynomial is taken no farther than a length of the piece away, so that it stays finite. */
static ad_value shape_clenshaw(ad_value s, const taped_piece *piece)
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
        ad_value b0 = ad_add(piece->c[k], ad_sub(ad_mul(twice, b1), b2));
        b2 = b1;
        b1 = b0;
    }
    return ad_add(piece->c[0], ad_sub(ad_mul(x, b1), b2));
}

static rod_pose shape_pose_of(const taped_piece *piece, ad_value s)
{
    if (!piece->is_uniform) {
        ad_value rows = shape_clenshaw(s, piece);
        return (rod_pose){.position = ad_slice(rows, 0, 3),
                          .rotation = ad_normalize(ad_slice(rows, 3, 4))};
    }
    const taped_pose pose =
        taped_advance(piece->start, piece->twist, ad_sub(s, ad_scalar(s.tape, piece->from)));
    return (rod_pose){.position = pose.r, .rotation = pose.q};
}

/* A place where pieces meet belongs to what is before. */
static rod_pose shape_at(const taped_shape *given, ad_value s)
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

/* The smallest rotation of the rod to the line between two pinned ends. */
static ad_value to_chord(const rod_context *rod, ad_value rest)
{
    static const double zeros[3] = {0};
    const ad_value zero = ad_scalar(rod->tape, 0), one = ad_scalar(rod->tape, 1);
    const double unit = 1 / rod->scales.length;
    const ad_value chord =
        ad_sub(rod_quantities(rod, 3, rod->scene->end.position, zeros, unit, one, zero),
               rod_quantities(rod, 3, rod->scene->start.position, zeros, unit, zero, zero));
    const ad_value size = ad_mul(ad_norm(rest), ad_norm(chord));
    return ad_normalize(ad_quaternion(ad_add(size, ad_dot(rest, chord)), ad_cross(rest, chord)));
}

/* From the identity at s = 0 to two places, and how the rod is turned between two pinned ends. */
static ad_value shape_put(const rod_context *rod, const ad_value s[2], rod_pose poses[2])
{
    const bool straight = rod->scene->place.is_given && scene_rests_straight(rod->scene);
    const bool by_rest = !straight && counts(rod) && rest_depends(rod);
    const bool turns = rod_shape_is_between(rod->scene) && counts(rod) &&
                       (straight || by_rest || chord_depends(rod));
    const ad_value one = ad_scalar(rod->tape, 1);
    taped_fit fit = {.problem = NULL};
    taped_shape made = {.count = 0};
    if (by_rest || turns) {
        fit_members(rod->scene, &fit);
    } else {
        rod_shape_upright(rod->scene, fit.upright);
        if (!straight) {
            rod_shape_make(rod->scene, &fit.within);
        }
    }
    if (fit.problem) {
        ad_tape_fail(rod->tape, AD_BAD_INPUT, "rod.rest: %s", fit.problem);
    }
    made.count = straight ? 0 : fit.within.count;
    for (int i = 0; i < made.count; i++) {
        const shape_piece *given = &fit.within.pieces[i];
        made.pieces[i] =
            (taped_piece){.is_uniform = by_rest ? fit.is_uniform[i] : given->is_uniform,
                          .from = given->from,
                          .to = given->to};
        if (!by_rest) {
            put_numbers(rod->tape, given, &made.pieces[i]);
        }
    }
    if (by_rest) {
        put_formulas(rod, &fit, &made);
    }
    for (int i = 0; i < 2; i++) {
        poses[i] = straight ? shape_straight(rod, s[i]) : shape_at(&made, s[i]);
    }
    return turns && fit.upright[0] != 0 /* half a turn is one for all */
               ? to_chord(rod,
                          (straight ? shape_straight(rod, one) : shape_at(&made, one)).position)
               : ad_constant(rod->tape, 4, fit.upright);
}

/* Relative to the anchor's pose (r_e, q_e) at t = 0, with p = q_e q(e)^-1:
 * q(s) = p q(s), r(s) = r_e + R(p) (r(s) - r(e)). */
rod_pose rod_undeformed(const rod_context *rod, ad_value s)
{
    int anchor = rod_shape_anchor(rod->scene);
    const scene_end *end = anchor ? &rod->scene->end : &rod->scene->start;
    const double zeros[4] = {0};
    ad_value zero = ad_scalar(rod->tape, 0), at = ad_scalar(rod->tape, anchor), upright;
    rod_pose poses[2];
    upright = shape_put(rod, (const ad_value[]){s, at}, poses);
    ad_value position =
        rod_quantities(rod, 3, end->position, zeros, 1 / rod->scales.length, at, zero);
    ad_value rotation = end->rotation[0].is_given
                            ? rod_quantities(rod, 4, end->rotation, zeros, 1, at, zero)
                            : upright;
    position = rod_from_world(rod, position);
    rotation = rod_rotation_from_world(rod, ad_normalize(rotation));
    ad_value turn = ad_quaternion_multiply(rotation, ad_quaternion_conjugate(poses[1].rotation));
    ad_value from_anchor = ad_sub(poses[0].position, poses[1].position);
    rod_pose pose = {.position = ad_add(position, ad_rotate(turn, from_anchor)),
                     .rotation = ad_quaternion_multiply(turn, poses[0].rotation)};
    return rod_pose_in_plane(rod, pose);
}
