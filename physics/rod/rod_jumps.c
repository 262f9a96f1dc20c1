/* What jumps along a rod: rotation and moments in body components at joints, N and m where
 * something acts at a single place. The ansatz is made in the frame of the rod as if it had no
 * joints, in which all else is continuous: with the turns E of all joints before s, q = p E,   m =
 * R(E)^T m',   w = R(E)^T w'. */
#include "physics/rod/rod_internal.h"

#include <math.h>

/* ---- joints ---------------------------------------------------------------------------------- */

/* Of any joint. */
static bool has_turns(const scene *rod_scene)
{
    for (int i = 0; i < rod_joint_count(rod_scene); i++) {
        if (rod_joint_of(rod_scene, i).turns) {
            return true;
        }
    }
    return false;
}

/* E, at a joint that before it. */
static ad_value jumps_turn(const rod_context *rod, ad_value s)
{
    const double none[4] = {1, 0, 0, 0};
    ad_value turned = ad_constant(rod->tape, 4, none), all = turned;
    for (int i = 0; i < rod_joint_count(rod->scene); i++) {
        rod_joint joint = rod_joint_of(rod->scene, i);
        if (joint.turns) {
            all = ad_quaternion_multiply(all, ad_constant(rod->tape, 4, joint.turn));
            turned = ad_select(ad_sub(s, ad_scalar(rod->tape, joint.s)), all, turned);
        }
    }
    return turned;
}

ad_value rod_straightened(const rod_context *rod, ad_value rotation, ad_value s)
{
    return has_turns(rod->scene)
               ? ad_quaternion_multiply(rotation, ad_quaternion_conjugate(jumps_turn(rod, s)))
               : rotation;
}

ad_value rod_turned_at_joints(const rod_context *rod, ad_value rotation, ad_value s)
{
    return has_turns(rod->scene) ? ad_quaternion_multiply(rotation, jumps_turn(rod, s)) : rotation;
}

/* In a plane the turns are about the normal, along which axial vectors lie. */
ad_value rod_vector_straightened(const rod_context *rod, ad_value vector, bool axial, ad_value s)
{
    bool turns = has_turns(rod->scene) && !(axial && rod->plane.is_planar);
    return turns && !ad_is_constant(vector, 0) ? ad_rotate(jumps_turn(rod, s), vector) : vector;
}

ad_value rod_moment_at_joints(const rod_context *rod, ad_value moment, ad_value s)
{
    bool turns = has_turns(rod->scene) && !rod->plane.is_planar;
    return turns ? ad_rotate_inverse(jumps_turn(rod, s), moment) : moment;
}

/* ---- forces and moments ---------------------------------------------------------------------- */

bool rod_has_places(const scene *rod_scene)
{
    return rod_scene->point_count + rod_scene->body_count + rod_scene->spring_count > 0;
}

/* What is on the tape at a place along the rod. */
static ad_value jumps_at(const rod_context *rod, ad_value y, double s)
{
    return ad_substitute(y, rod->s, ad_scalar(rod->tape, s));
}

static rod_pose jumps_pose_at(const rod_context *rod, const rod_pose *pose, double s)
{
    return (rod_pose){jumps_at(rod, pose->position, s), jumps_at(rod, pose->rotation, s)};
}

/* What resists the motion of a body. */
static rod_force_at jumps_of_body(const rod_context *rod, int i, const rod_pose *field)
{
    const rod_body_data body = rod_body_of(rod, i, rod->t);
    const ad_value turning = rod_time_derivative(rod, field->rotation, 1);
    const ad_value bending = rod_time_derivative(rod, field->rotation, 2);
    const ad_value rotation = jumps_at(rod, field->rotation, body.s);
    const rod_kinematics k = {
        .velocity = jumps_at(rod, rod_time_derivative(rod, field->position, 1), body.s),
        .acceleration = jumps_at(rod, rod_time_derivative(rod, field->position, 2), body.s),
        .spin = jumps_at(rod, rod_rate(field->rotation, turning), body.s),
        .spin_rate = jumps_at(rod, rod_rate(field->rotation, bending), body.s)};
    rod_wrench sum = {ad_neg(ad_mul(body.mass, k.acceleration)), ad_zeros(rod->tape, 3)};
    if (!ad_is_constant(body.inertia, 0)) {
        sum = rod_wrench_add(sum,
                             rod_resistance(rod, LAW_ROTARY_INERTIA, rotation, &k, body.inertia));
    }
    if (body.is_beside) {
        sum = rod_wrench_add(sum, rod_resistance(rod, LAW_ECCENTRICITY, rotation, &k, body.beside));
    }
    return (rod_force_at){body.s, sum.force, sum.moment};
}

static rod_force_at jumps_of_law(const rod_context *rod, const rod_acting *at,
                                 const rod_pose *field)
{
    const rod_pose pose = jumps_pose_at(rod, field, at->s);
    const ad_value velocity = rod_time_derivative(rod, field->position, 1);
    const rod_wrench wrench = rod_acting_wrench(rod, at, pose, jumps_at(rod, velocity, at->s));
    return (rod_force_at){at->s, wrench.force, wrench.moment};
}

int rod_forces_at(const rod_context *rod, const rod_pose *field, rod_force_at *acting)
{
    const scene *given = rod->scene;
    rod_acting laws[ROD_AT_PLACES_MAX];
    const int law_count = rod_acting_at_places(rod, laws);
    int count = 0;
    for (int i = 0; i < given->body_count && rod->dynamic; i++) {
        acting[count++] = jumps_of_body(rod, i, field);
    }
    for (int i = 0; i < law_count; i++) {
        acting[count++] = jumps_of_law(rod, &laws[i], field);
    }
    return count;
}

rod_jumps rod_jumps_of(const rod_context *rod, const rod_pose *field)
{
    rod_force_at acting[ROD_AT_PLACES_MAX + SCENE_BODIES_MAX];
    ad_value none = ad_zeros(rod->tape, 3);
    rod_jumps jumps = {none, none, none, none};
    int count = rod_has_places(rod->scene) ? rod_forces_at(rod, field, acting) : 0;
    for (int i = 0; i < count; i++) {
        const rod_force_at *at = &acting[i];
        ad_value place = ad_scalar(rod->tape, at->s), one = ad_scalar(rod->tape, 1);
        ad_value moment = rod_vector_straightened(rod, at->moment, true, place);
        ad_value past =
            at->s > 0 ? ad_select(ad_sub(rod->s, place), one, ad_scalar(rod->tape, 0)) : one;
        jumps.force = ad_sub(jumps.force, ad_mul(past, at->force));
        jumps.moment = ad_sub(jumps.moment, ad_mul(past, moment));
        jumps.all_force = ad_sub(jumps.all_force, at->force);
        jumps.all_moment = ad_sub(jumps.all_moment, moment);
    }
    return jumps;
}
