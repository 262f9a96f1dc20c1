/* What is prescribed at the ends and at the start of time, as the scene or the manufactured
 * solution gives it. */
#include "physics/rod/rod_internal.h"

static const double ROD_ZEROS[3] = {0, 0, 0}, ROD_UPRIGHT[4] = {1, 0, 0, 0};

static rod_hold rod_hold_of(const rod_context *rod, const scene_end *given)
{
    const scene_hold hold = scene_hold_of(given);
    const double *a = hold.axis;
    return (rod_hold){hold.directions,
                      rod_from_world(rod, ad_vector_constant(rod->tape, a[0], a[1], a[2]))};
}

ad_value rod_hold_part(const rod_context *rod, const rod_hold *hold, ad_value x)
{
    if (hold->directions == 0 || hold->directions == 3) {
        return hold->directions == 0 ? ad_zeros(rod->tape, ad_rows(x)) : x;
    }
    ad_value along = ad_mul(ad_dot(hold->axis, x), hold->axis);
    return rod_keep_in_plane(rod, hold->directions == 1 ? along : ad_sub(x, along), false);
}

rod_hold rod_hold_other(const rod_hold *hold)
{
    return (rod_hold){3 - hold->directions, hold->axis};
}

/* N in the world frame, for the rod's own rotation at or near the end. */
ad_value rod_end_force(const rod_end_data *end, ad_value rotation)
{
    bool turn = end->force_is_body && !ad_is_constant(end->force, 0);
    return turn ? ad_rotate(rotation, end->force) : end->force;
}

ad_value rod_end_moment(const rod_end_data *end, ad_value rotation)
{
    bool turn = end->moment_is_world && !ad_is_constant(end->moment, 0);
    return turn ? ad_rotate_inverse(rotation, end->moment) : end->moment;
}

/* The exact solution at s = end, time t. */
static void rod_manufactured_end(const rod_context *rod, int end, ad_value t, rod_end_data *data)
{
    rod_state exact = rod_manufactured(rod->scene, rod->s, rod->t);
    ad_value *fields[4] = {&data->position, &data->rotation, &data->force, &data->moment};
    ad_value values[4] = {exact.position, exact.rotation, exact.force, exact.moment};
    for (int i = 0; i < 4; i++) {
        ad_value at_end = ad_substitute(values[i], rod->s, ad_scalar(rod->tape, end));
        bool other_time = rod->dynamic && t.id != rod->t.id;
        *fields[i] = other_time ? ad_substitute(at_end, rod->t, t) : at_end;
    }
    data->force_is_body = false; /* N world, m body, as rod_state has them */
    data->moment_is_world = false;
}

/* At s = 0 the outside exerts F = -N(0), T = -M(0). */
static void rod_loaded_end(const rod_context *rod, int end, ad_value t, rod_end_data *data)
{
    const scene_load *load = end ? &rod->scene->loads.tip : &rod->scene->loads.base;
    double sign = end ? 1 : -1;
    ad_value s = ad_scalar(rod->tape, end), factor = rod->at.load_factor;
    ad_value force = rod_quantities(rod, 3, load->force, ROD_ZEROS, sign / rod->scales.force, s, t);
    ad_value moment =
        rod_quantities(rod, 3, load->moment, ROD_ZEROS, sign / rod->scales.moment, s, t);
    data->force = ad_mul(factor, force);
    data->moment = ad_mul(factor, moment);
    data->force_is_body = load->frame == SCENE_FOLLOWER;
    data->moment_is_world = load->frame == SCENE_DEAD;
    if (load->frame == SCENE_DEAD) {
        data->force = rod_from_world(rod, data->force);
        data->moment = rod_axial_from_world(rod, data->moment);
    }
}

ad_value rod_twisted(const rod_context *rod, ad_value rotation, ad_value share, ad_value t)
{
    const scene_end *end = &rod->scene->end;
    if (!end->twist.is_given || !scene_end_holds_rotation(end->type)) {
        return rotation;
    }
    ad_value zero = ad_zeros(rod->tape, 1), one = ad_scalar(rod->tape, 1);
    ad_value angle = ad_mul(share, rod_quantities(rod, 1, &end->twist, ROD_ZEROS, 1, one, t));
    return ad_quaternion_multiply(rotation, ad_quaternion_exp(ad_vector(zero, zero, angle)));
}

rod_end_data rod_end_of(const rod_context *rod, int end, ad_value t)
{
    const scene_end *given = end ? &rod->scene->end : &rod->scene->start;
    ad_value zeros = ad_zeros(rod->tape, 3);
    rod_end_data data = {.force = zeros, .moment = zeros};
    data.hold = rod_hold_of(rod, given);
    data.holds_rotation = scene_end_holds_rotation(given->type);
    if (scene_is_manufactured(rod->scene)) {
        rod_manufactured_end(rod, end, t, &data);
        return data;
    }
    ad_value s = ad_scalar(rod->tape, end);
    data.position =
        rod_quantities(rod, 3, given->position, ROD_ZEROS, 1 / rod->scales.length, s, t);
    data.position = rod_from_world(rod, data.position);
    data.turns = data.holds_rotation && given->rotation_vector[0].is_given;
    if (data.turns) {
        data.turn = rod_axial_from_world(
            rod, rod_quantities(rod, 3, given->rotation_vector, ROD_ZEROS, 1, s, t));
        data.rotation =
            ad_quaternion_multiply(ad_quaternion_exp(data.turn), rod_undeformed(rod, s).rotation);
    } else {
        data.rotation = ad_normalize(rod_quantities(rod, 4, given->rotation, ROD_UPRIGHT, 1, s, t));
        data.rotation = rod_rotation_from_world(rod, data.rotation);
    }
    data.rotation = end ? rod_twisted(rod, data.rotation, s, t) : data.rotation;
    if (scene_end_takes_force(given->type)) {
        rod_loaded_end(rod, end, t, &data);
    }
    return data;
}

static rod_initial_data rod_manufactured_initial(const rod_context *rod, ad_value s)
{
    rod_state exact = rod_manufactured(rod->scene, rod->s, rod->t);
    ad_value rotation_rate = rod_time_derivative(rod, exact.rotation, 1);
    ad_value values[4] = {exact.position, exact.rotation,
                          rod_time_derivative(rod, exact.position, 1),
                          rod_rate(exact.rotation, rotation_rate)};
    for (int i = 0; i < 4; i++) {
        values[i] = ad_substitute(values[i], rod->t, ad_scalar(rod->tape, 0));
        if (s.id != rod->s.id) {
            values[i] = ad_substitute(values[i], rod->s, s);
        }
    }
    return (rod_initial_data){values[0], values[1], values[2], values[3]};
}

/* Needs a dynamic scene. What the scene does not give: at rest, undeformed. */
rod_initial_data rod_initial_of(const rod_context *rod, ad_value s)
{
    if (scene_is_manufactured(rod->scene)) {
        return rod_manufactured_initial(rod, s);
    }
    const scene_initial *given = &rod->scene->initial;
    const rod_scales *scale = &rod->scales;
    ad_value zero = ad_scalar(rod->tape, 0);
    rod_pose pose = rod_undeformed(rod, s);
    if (given->position[0].is_given) {
        pose.position = rod_from_world(
            rod, rod_quantities(rod, 3, given->position, ROD_ZEROS, 1 / scale->length, s, zero));
    }
    if (given->rotation[0].is_given) {
        pose.rotation = rod_rotation_from_world(
            rod, ad_normalize(rod_quantities(rod, 4, given->rotation, ROD_UPRIGHT, 1, s, zero)));
    }
    if (rod->dynamic && given->state == SCENE_EQUILIBRIUM) {
        pose.position = rod_from_world(
            rod, rod_quantities(rod, 3, given->settled, ROD_ZEROS, 1 / scale->length, s, zero));
        pose.rotation = rod_rotation_from_world(
            rod, ad_normalize(rod_quantities(rod, 4, given->settled + 3, ROD_UPRIGHT, 1, s, zero)));
        pose = rod_pose_in_plane(rod, pose); /* which it leaves by rounding */
    }
    ad_value velocity =
        rod_quantities(rod, 3, given->velocity, ROD_ZEROS, scale->time / scale->length, s, zero);
    return (rod_initial_data){
        .position = pose.position,
        .rotation = pose.rotation,
        .velocity = rod_from_world(rod, velocity),
        .spin = rod_quantities(rod, 3, given->angular_velocity, ROD_ZEROS, scale->time, s, zero)};
}
