/* From raw network outputs to a state that meets the conditions of the scene by construction. */
#include "nn/nn.h"
#include "physics/learn/window_state.h"
#include "physics/rod/rod_internal.h"

/* Of a quaternion's four numbers only the direction counts: their free length leaves J^T J without
 * full rank and Gauss-Newton with linear convergence. A rotation vector and an angle have none; but
 * at a full turn a vector turns the rod about one axis only. Six numbers have no such place (Zhou
 * et al., CVPR 2019), and three that are free. */
static const rod_head angle_head = {"theta[1] angle", 1, true};
static const rod_head heads[] = {[SCENE_QUATERNION] = {"q[4] quaternion", 4, false},
                                 [SCENE_VECTOR] = {"theta[3] rotation vector", 3, true},
                                 [SCENE_SIX] = {"a[6] columns of a rotation matrix", 6, true}};

const rod_head *rod_head_of(const scene *rod_scene)
{
    return rod_plane_of(rod_scene).is_planar ? &angle_head : &heads[rod_scene->rotation];
}

int rod_network_outputs(const scene *rod_scene)
{
    rod_plane plane = rod_plane_of(rod_scene);
    int vector = rod_vector_rows(&plane), pose = vector + rod_head_of(rod_scene)->outputs;
    int wrench = rod_has_strains(rod_scene)
                     ? vector + rod_axial_rows(&plane) + rod_tendon_rows(rod_scene)
                     : 0;
    return pose + wrench + 2 * rod_scene->tube_count;
}

/* The raw outputs of the network by field, those of the rotation as they are; the displacement form
 * has none of force and moment. */
static rod_state rod_raw_outputs(const rod_context *rod, ad_value outputs)
{
    int vector = rod_vector_rows(&rod->plane), axial = rod_axial_rows(&rod->plane);
    int turn = rod_head_of(rod->scene)->outputs, pose = vector + turn;
    rod_state raw = {.position = rod_vector_of(rod, ad_slice(outputs, 0, vector)),
                     .rotation = ad_slice(outputs, vector, turn)};
    if (rod_has_strains(rod->scene)) {
        raw.force = rod_vector_of(rod, ad_slice(outputs, pose, vector));
        raw.moment = rod_axial_of(rod, ad_slice(outputs, pose + vector, axial));
    }
    int row = pose + vector + axial, tendons = rod_tendon_rows(rod->scene);
    if (tendons > 0) {
        raw.tendons = ad_slice(outputs, row, tendons);
    }
    if (rod->scene->tube_count > 0) {
        raw.tubes = ad_slice(outputs, row + tendons, 2 * rod->scene->tube_count);
    }
    return raw;
}

/* In which directions the two ends give a field; of what is no vector all or none. With P the part
 * in them, c what is missing at an end to its data, and f the network, the field gets
 *   (1 - s P1) P0 c0 + (1 - (1 - s) P0) P1 c1 + (1 - (1 - s) P0) (1 - s P1) f,
 * of which P0 at s = 0 is P0 c0, and P1 at s = 1 is P1 c1. */
typedef struct rod_blend {
    rod_hold start, end;
} rod_blend;

static rod_blend rod_blend_of(bool start, bool end)
{
    return (rod_blend){{.directions = start ? 3 : 0}, {.directions = end ? 3 : 0}};
}

/* x with its part in the directions times the factor. */
static ad_value rod_faded(const rod_context *rod, const rod_hold *hold, ad_value x, ad_value factor)
{
    if (hold->directions == 0 || hold->directions == 3) {
        return hold->directions == 0 ? x : ad_mul(factor, x);
    }
    ad_value part = rod_hold_part(rod, hold, x);
    return ad_add(ad_sub(x, part), ad_mul(factor, part));
}

/* What the ends leave to the network. */
static ad_value rod_between(const rod_context *rod, const rod_blend *blend, ad_value network)
{
    network = rod_faded(rod, &blend->end, network, domain_vanish(&rod->at, 1));
    return rod_faded(rod, &blend->start, network, domain_vanish(&rod->at, 0));
}

static bool rod_is_hard(const scene *rod_scene)
{
    return rod_scene->boundary_enforcement == SCENE_HARD;
}

static bool rod_starts_hard(const rod_context *rod)
{
    return rod->dynamic && rod->scene->initial_enforcement == SCENE_HARD;
}

/* ---- where a window begins ------------------------------------------------------------------- */

/* The motion of a pose: itself and its rates. */
static rod_initial_data rod_motion_of(const rod_context *rod, rod_pose pose)
{
    ad_value turning = rod_time_derivative(rod, pose.rotation, 1);
    return (rod_initial_data){.position = pose.position,
                              .rotation = pose.rotation,
                              .velocity = rod_time_derivative(rod, pose.position, 1),
                              .spin = rod_rate(pose.rotation, turning)};
}

static rod_initial_data rod_unstack(ad_value rows)
{
    return (rod_initial_data){.position = ad_slice(rows, 0, 3),
                              .rotation = ad_slice(rows, 3, 4),
                              .velocity = ad_slice(rows, 7, 3),
                              .spin = ad_slice(rows, 10, 3)};
}

static ad_value rod_stack(rod_initial_data motion)
{
    const ad_value parts[4] = {motion.position, motion.rotation, motion.velocity, motion.spin};
    return ad_stack(4, parts);
}

/* As if there were no joints. */
static rod_initial_data rod_start_straightened(const rod_context *rod, rod_initial_data state,
                                               ad_value s)
{
    state.rotation = rod_straightened(rod, state.rotation, s);
    state.spin = rod_vector_straightened(rod, state.spin, true, s);
    return state;
}

/* The state in which the window starts, or the part of it that goes on. What leaves the plane of a
 * planar motion is 0 and made the constant 0. */
static rod_initial_data rod_window_start(const rod_context *rod, bool going)
{
    rod_initial_data state = rod_unstack(window_state_state(&rod->at, ROD_STATE_ROWS, going));
    state = rod_start_straightened(rod, state, rod->s);
    rod_pose pose = rod_pose_in_plane(rod, (rod_pose){state.position, state.rotation});
    return (rod_initial_data){.position = pose.position,
                              .rotation = pose.rotation,
                              .velocity = rod_keep_in_plane(rod, state.velocity, false),
                              .spin = rod_keep_in_plane(rod, state.spin, true)};
}

/* A held end is where it is said to be, also when the window begins: t is replaced by that time
 * after the derivatives by it have been taken. */
static rod_initial_data rod_held_at_start(const rod_context *rod, rod_pose held)
{
    ad_value state = rod_stack(rod_motion_of(rod, held));
    return rod_unstack(ad_substitute(state, rod->t, rod->at.start));
}

/* Half waves that every network follows in time. But where the rod winds along s so much that such
 * a quaternion would come near 0, an angle or a rotation vector has nothing to count from: then all
 * of the state goes on. */
int rod_going_degree(const scene *rod_scene, const double *state)
{
    enum { LOW = 6 };
    static const double near = 0.01; /* far above what networks miss */
    double misfit = rod_head_of(rod_scene)->counts_on
                        ? window_state_misfit(state, ROD_STATE_ROWS, 3, 4, LOW)
                        : 0;
    return misfit > near ? WINDOW_STATE_DEGREE : LOW;
}

/* One of several windows. Its state at the start goes on, r_k + t v_k and q_k exp(t w_k), but only
 * a polynomial p of s in it; what is left fades away:
 *   r_p + t v_p + h(x) (r_k - r_p) + T g(x) (v_k - v_p),
 * and so for q with the velocity q_k w_k / 2; x = t/T, h = (1 - x)^2 (1 + 2x), g = x (1 - x)^2,
 * Hermite's polynomials: 1 and x at the start to first order, 0 at the end. If all of it went on,
 * what networks cannot represent would be handed on from window to window, and grow with its
 * velocity. */
static rod_pose rod_going_lift(const rod_context *rod, const rod_initial_data *initial,
                               const rod_initial_data *going)
{
    ad_value zero = ad_scalar(rod->tape, 0), one = ad_scalar(rod->tape, 1);
    ad_value t = domain_elapsed(&rod->domain, &rod->at);
    ad_value x = ad_mul(t, ad_reciprocal(rod->at.span));
    ad_value left = ad_square(ad_sub(one, x));
    ad_value keep = ad_mul(left, ad_add(one, ad_scale(x, 2)));
    ad_value push = ad_mul(ad_mul(x, left), rod->at.span);
    ad_value turns[2];
    const rod_initial_data *states[2] = {initial, going};
    for (int i = 0; i < 2; i++) {
        ad_value spin = ad_quaternion(zero, ad_scale(states[i]->spin, 0.5));
        turns[i] = ad_quaternion_multiply(states[i]->rotation, spin);
    }
    ad_value drift = ad_add(going->position, ad_mul(t, going->velocity));
    ad_value spin = ad_quaternion_exp(ad_mul(t, going->spin));
    ad_value turn = ad_quaternion_multiply(going->rotation, spin);
    ad_value moved = ad_mul(keep, ad_sub(initial->position, going->position));
    ad_value turned = ad_mul(keep, ad_sub(initial->rotation, going->rotation));
    ad_value pushed = ad_mul(push, ad_sub(initial->velocity, going->velocity));
    ad_value spun = ad_mul(push, ad_sub(turns[0], turns[1]));
    return rod_pose_in_plane(
        rod, (rod_pose){ad_add(drift, ad_add(moved, pushed)), ad_add(turn, ad_add(turned, spun))});
}

/* The undeformed shape as if there were no joints, turned in proportion to s where an end is held
 * turned by a vector, or twisted: what is left between the two is then no whole turn. */
static rod_pose rod_turned_shape(const rod_context *rod, ad_value s)
{
    rod_pose pose = rod_undeformed(rod, s);
    rod_end_data end = rod_end_of(rod, 1, rod->t);
    if (end.turns) {
        ad_value turn = ad_quaternion_exp(ad_mul(s, end.turn));
        pose.rotation = ad_quaternion_multiply(turn, pose.rotation);
    }
    pose.rotation = rod_twisted(rod, rod_straightened(rod, pose.rotation, s), s, rod->t);
    return pose;
}

/* Pose to start from: r_i + t v_i and q_i exp(t w_i), or the undeformed shape. */
static rod_pose rod_lift(const rod_context *rod, const rod_initial_data *initial,
                         const rod_initial_data *going, ad_value s)
{
    if (!rod_starts_hard(rod)) {
        if (!scene_is_manufactured(rod->scene)) {
            return rod_turned_shape(rod, s);
        }
        ad_value straight = ad_vector(ad_zeros(s.tape, 1), ad_zeros(s.tape, 1), s);
        return (rod_pose){straight, ad_constant(s.tape, 4, (double[]){1, 0, 0, 0})};
    }
    if (rod->at.goes_on) {
        return rod_going_lift(rod, initial, going);
    }
    ad_value spun = ad_quaternion_exp(ad_mul(rod->t, initial->spin));
    return (rod_pose){.position = ad_add(initial->position, ad_mul(rod->t, initial->velocity)),
                      .rotation = ad_quaternion_multiply(initial->rotation, spun)};
}

/* q or -q, whichever is on the side of `near` at t = 0: the scene's author may write either. */
static ad_value rod_align(ad_value q, ad_value q_at_zero, ad_value near)
{
    ad_value one = ad_scalar(q.tape, 1);
    ad_value sign = ad_select(ad_neg(ad_dot(q_at_zero, near)), ad_neg(one), one);
    return ad_mul(sign, q);
}

/* What leads from one rotation to another, to be weighed and added up: a difference of quaternions;
 * in a plane an angle, which is exact for any share of it. */
static ad_value rod_turn_between(const rod_context *rod, ad_value from, ad_value to)
{
    if (!rod->plane.is_planar) {
        return ad_sub(to, from);
    }
    return rod_angle_of(rod, ad_quaternion_multiply(ad_quaternion_conjugate(from), to));
}

static ad_value rod_turned(const rod_context *rod, ad_value from, ad_value turn)
{
    if (!rod->plane.is_planar) {
        return ad_normalize(ad_add(from, turn));
    }
    return ad_quaternion_multiply(ad_normalize(from), rod_rotation_by(rod, turn));
}

/* The same, and then by what the network says. */
static ad_value rod_turned_on(const rod_context *rod, ad_value from, ad_value turn,
                              ad_value network)
{
    if (!rod_head_of(rod->scene)->counts_on) {
        return rod_turned(rod, from, ad_add(turn, network));
    }
    bool six = !rod->plane.is_planar && rod->scene->rotation == SCENE_SIX;
    ad_value by = six ? rod_rotation_by_six(network) : rod_rotation_by(rod, network);
    return ad_quaternion_multiply(rod_turned(rod, from, turn), by);
}

/* What is prescribed at an end, as if there were no joints. */
static rod_end_data rod_end_straightened(const rod_context *rod, int end, ad_value t)
{
    rod_end_data data = rod_end_of(rod, end, t);
    ad_value s = ad_scalar(rod->tape, end);
    data.rotation = rod_straightened(rod, data.rotation, s);
    if (data.force_is_body) {
        data.force = rod_vector_straightened(rod, data.force, false, s);
    }
    if (!data.moment_is_world) {
        data.moment = rod_vector_straightened(rod, data.moment, true, s);
    }
    return data;
}

static rod_initial_data rod_initial_straightened(const rod_context *rod, ad_value s)
{
    return rod_start_straightened(rod, rod_initial_of(rod, s), s);
}

/* From the lift at the end to the data, for position and rotation. What is not held has no weight.
 */
static rod_pose rod_correction(const rod_context *rod, int end)
{
    rod_end_data data = rod_end_straightened(rod, end, rod->t);
    ad_value s = ad_scalar(rod->tape, end), rotation = data.rotation;
    rod_initial_data initial = {0};
    if (rod_starts_hard(rod)) {
        initial = rod_initial_straightened(rod, s);
    }
    if (data.holds_rotation && !scene_is_manufactured(rod->scene)) {
        rod_end_data first = rod_end_straightened(rod, end, ad_scalar(rod->tape, 0));
        ad_value near = rod_starts_hard(rod) ? initial.rotation : rod_turned_shape(rod, s).rotation;
        rotation = rod_align(rotation, first.rotation, near);
    }
    if (rod->at.goes_on) {
        initial = rod_held_at_start(rod, (rod_pose){data.position, rotation});
    }
    rod_pose lift = rod_lift(rod, &initial, &initial, s); /* p meets the state at the ends */
    return (rod_pose){ad_sub(data.position, lift.position),
                      rod_turn_between(rod, lift.rotation, rotation)};
}

/* What the data of the ends add. */
static ad_value rod_weigh(const rod_context *rod, const rod_blend *blend, ad_value at_start,
                          ad_value at_end)
{
    ad_value rest = ad_sub(ad_scalar(rod->tape, 1), rod->s);
    at_start = rod_hold_part(rod, &blend->start, at_start);
    at_end = rod_hold_part(rod, &blend->end, at_end);
    return ad_add(rod_faded(rod, &blend->end, at_start, rest),
                  rod_faded(rod, &blend->start, at_end, rod->s));
}

static ad_value rod_assemble(const rod_context *rod, const rod_blend *blend, ad_value at_start,
                             ad_value at_end, ad_value network)
{
    return ad_add(rod_weigh(rod, blend, at_start, at_end), rod_between(rod, blend, network));
}

/* r and, as if there were no joints, q from what the window's network answers. */
static rod_pose rod_ansatz_pose(const rod_context *rod, const rod_state *raw)
{
    rod_initial_data initial = {0};
    bool hard = rod_is_hard(rod->scene);
    rod_end_data start = rod_end_of(rod, 0, rod->t), end = rod_end_of(rod, 1, rod->t);
    rod_blend along = hard ? (rod_blend){start.hold, end.hold} : rod_blend_of(false, false);
    rod_blend around = rod_blend_of(hard && start.holds_rotation, hard && end.holds_rotation);
    ad_value position = raw->position, rotation = raw->rotation;
    if (rod_starts_hard(rod)) {
        initial =
            rod->at.goes_on ? rod_window_start(rod, false) : rod_initial_straightened(rod, rod->s);
    }
    rod_initial_data going = rod->at.goes_on ? rod_window_start(rod, true) : initial;
    rod_pose lift = rod_lift(rod, &initial, &going, rod->s);
    rod_pose at_start = rod_correction(rod, 0), at_end = rod_correction(rod, 1);
    if (rod_starts_hard(rod)) {
        ad_value elapsed = domain_elapsed(&rod->domain, &rod->at);
        ad_value since = ad_square(ad_mul(elapsed, ad_reciprocal(rod->at.span)));
        position = ad_mul(since, position);
        rotation = ad_mul(since, rotation);
    }
    ad_value moved = rod_assemble(rod, &along, at_start.position, at_end.position, position);
    ad_value turn = rod_weigh(rod, &around, at_start.rotation, at_end.rotation);
    ad_value network = rod_between(rod, &around, rotation);
    return (rod_pose){.position = ad_add(lift.position, moved),
                      .rotation = rod_turned_on(rod, lift.rotation, turn, network)};
}

/* N and m of the mixed form, both and the pose as if there were no joints; `pose` is the field
 * r(s, t), q(s, t), so that loads fixed in one frame appear in the other. */
static rod_wrench rod_ansatz_wrench(const rod_context *rod, const rod_pose *pose,
                                    const rod_jumps *jumps, ad_value force, ad_value moment)
{
    bool hard = rod_is_hard(rod->scene);
    ad_value rotation = pose->rotation;
    rod_end_data start = rod_end_straightened(rod, 0, rod->t);
    rod_end_data end = rod_end_straightened(rod, 1, rod->t);
    rod_blend pull = hard ? (rod_blend){rod_hold_other(&start.hold), rod_hold_other(&end.hold)}
                          : rod_blend_of(false, false);
    rod_blend turn = rod_blend_of(hard && !start.holds_rotation, hard && !end.holds_rotation);
    ad_value end_force = ad_sub(rod_end_force(&end, rotation), jumps->all_force);
    ad_value end_moment = ad_sub(rod_end_moment(&end, rotation), jumps->all_moment);
    force = rod_assemble(rod, &pull, rod_end_force(&start, rotation), end_force, force);
    moment = rod_assemble(rod, &turn, rod_end_moment(&start, rotation), end_moment, moment);
    return (rod_wrench){ad_add(force, jumps->force), ad_add(moment, jumps->moment)};
}

/* Force and moment of these strains. */
static rod_state rod_state_by_law(const rod_context *rod, rod_pose pose, const rod_kinematics *k)
{
    rod_wrench wrench = rod_constitutive(rod, k);
    return (rod_state){.position = pose.position,
                       .rotation = pose.rotation,
                       .force = ad_rotate(pose.rotation, wrench.force),
                       .moment = wrench.moment};
}

static rod_state rod_displacement_state(const rod_context *rod, rod_pose pose)
{
    rod_kinematics k = rod_kinematics_of(rod, pose.position, pose.rotation);
    return rod_state_by_law(rod, pose, &k);
}

/* The network says the elastic force and moment, which have the size of the loads. */
static rod_state rod_strain_state(const rod_context *rod, rod_pose pose, ad_value force,
                                  ad_value moment)
{
    rod_coefficients c = rod_coefficients_of(rod);
    rod_kinematics k = {.strain = ad_add(c.rest_strain, ad_mul(c.strain_compliance, force)),
                        .curvature =
                            ad_add(c.rest_curvature, ad_mul(c.curvature_compliance, moment))};
    k.strain_rate = rod_time_derivative(rod, k.strain, 1);
    k.curvature_rate = rod_time_derivative(rod, k.curvature, 1);
    rod_state state = rod_state_by_law(rod, pose, &k);
    state.strains = ad_stack(2, (const ad_value[]){k.strain, k.curvature});
    return state;
}

rod_state rod_ansatz(const scene *rod_scene, const domain_place *at, ad_value outputs)
{
    rod_context rod = rod_context_of(rod_scene, at);
    int rows = rod_network_outputs(rod_scene);
    if (ad_is_valid(outputs) && ad_rows(outputs) != rows) {
        ad_tape_fail(at->tape, AD_BAD_SHAPE, "the network has %d outputs, %d are needed",
                     ad_rows(outputs), rows);
    }
    rod_state raw = rod_raw_outputs(&rod, outputs);
    rod_pose straight = rod_ansatz_pose(&rod, &raw), pose = straight;
    pose.rotation = rod_turned_at_joints(&rod, straight.rotation, rod.s);
    if (rod_scene->formulation == SCENE_DISPLACEMENT) {
        return rod_displacement_state(&rod, pose);
    }
    ad_value force = ad_scale(raw.force, rod_force_scale(rod_scene));
    ad_value moment = ad_scale(raw.moment, rod_moment_scale(rod_scene));
    if (rod_scene->formulation == SCENE_POSE_STRAIN) {
        return rod_strain_state(&rod, pose, force, moment);
    }
    rod_jumps jumps = rod_jumps_of(&rod, &pose);
    rod_wrench wrench = rod_ansatz_wrench(&rod, &straight, &jumps, force, moment);
    return (rod_state){.position = pose.position,
                       .rotation = pose.rotation,
                       .force = wrench.force,
                       .moment = rod_moment_at_joints(&rod, wrench.moment, rod.s),
                       .tendons = raw.tendons,
                       .tubes = rod_tube_ansatz(&rod, raw.tubes)};
}

int rod_state_rows(const scene *rod_scene)
{
    return scene_is_dynamic(rod_scene) ? ROD_STATE_ROWS : 0;
}

void rod_moving_state(const scene *rod_scene, const domain_place *at, rod_state state,
                      ad_value *rows)
{
    rod_context rod = rod_context_of(rod_scene, at);
    rod_pose pose = {state.position, state.rotation};
    ad_value all = rod_stack(rod_motion_of(&rod, pose));
    for (int i = 0; i < ROD_STATE_ROWS; i++) {
        rows[i] = ad_row(all, i);
    }
}
