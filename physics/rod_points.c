/* What acts at single places of a rod: concentrated loads, joints, rigid bodies. */
#include "physics/rod_internal.h"

#include <math.h>

static const double POINT_ZEROS[3] = {0, 0, 0};

/* ---- loads ----------------------------------------------------------------------------------- */

rod_point_data rod_point_of(const rod_context *rod, int i, ad_value t)
{
    const scene_point *given = &rod->scene->points[i];
    rod_point_data point = {.s = given->at.number / rod->scales.length,
                            .follows = given->load.frame == SCENE_FOLLOWER};
    ad_value s = ad_scalar(rod->tape, point.s), factor = rod->at.load_factor;
    point.force = ad_mul(factor, rod_quantities(rod, 3, given->load.force, POINT_ZEROS,
                                                1 / rod->scales.force, s, t));
    point.moment = ad_mul(factor, rod_quantities(rod, 3, given->load.moment, POINT_ZEROS,
                                                 1 / rod->scales.moment, s, t));
    point.force = point.follows ? rod_keep_in_plane(rod, point.force, false)
                                : rod_from_world(rod, point.force);
    point.moment = point.follows ? rod_keep_in_plane(rod, point.moment, true)
                                 : rod_axial_from_world(rod, point.moment);
    return point;
}

ad_value rod_point_force(const rod_point_data *point, ad_value rotation)
{
    bool turn = point->follows && !ad_is_constant(point->force, 0);
    return turn ? ad_rotate(rotation, point->force) : point->force;
}

ad_value rod_point_moment(const rod_point_data *point, ad_value rotation)
{
    bool turn = !point->follows && !ad_is_constant(point->moment, 0);
    return turn ? ad_rotate_inverse(rotation, point->moment) : point->moment;
}

/* ---- joints ---------------------------------------------------------------------------------- */

int rod_joint_count(const scene *rod_scene)
{
    return rod_scene->segment_count > 1 ? rod_scene->segment_count - 1 : 0;
}

rod_joint rod_joint_of(const scene *rod_scene, int i)
{
    const scene_segment *after = &rod_scene->segments[i + 1];
    rod_joint joint = {.s = scene_joint(rod_scene, i) / scene_length(rod_scene), .turn = {1}};
    double turn[3], square = 0;
    for (int k = 0; k < 3; k++) {
        turn[k] = quantity_number_or(after->turn[k], 0);
        square += turn[k] * turn[k];
    }
    joint.turns = square > 0;
    if (joint.turns) {
        double angle = sqrt(square);
        joint.turn[0] = cos(angle / 2);
        for (int k = 0; k < 3; k++) {
            joint.turn[1 + k] = sin(angle / 2) * turn[k] / angle;
        }
    }
    return joint;
}

/* ---- bodies ---------------------------------------------------------------------------------- */

rod_body_data rod_body_of(const rod_context *rod, int i, ad_value t)
{
    const scene_body *given = &rod->scene->bodies[i];
    const rod_scales *scale = &rod->scales;
    double mass = given->mass.number, rate = rod->dynamic ? 1 / scale->time : 0;
    rod_body_data body = {.s = given->at.number / scale->length,
                          .mass = mass * rate * rate * scale->length / scale->force};
    for (int k = 0; k < 3; k++) {
        double inertia = quantity_number_or(given->inertia[k], 0);
        body.inertia[k] = inertia * rate * rate / scale->moment;
    }
    ad_value s = ad_scalar(rod->tape, body.s);
    const bool same = quantity_is_number(given->mass, &mass); /* of all members of a family */
    ad_value weight = rod_quantities(rod, 3, rod->scene->loads.gravity, POINT_ZEROS,
                                     (same ? mass : 1) / scale->force, s, t);
    weight = same ? weight : ad_mul(rod_quantity(rod, given->mass, s, t), weight);
    body.weight = ad_mul(rod->at.load_factor, rod_from_world(rod, weight));
    return body;
}
