/* Joints and rigid bodies at single places of a rod. */
#include "physics/rod/rod_internal.h"

#include <math.h>

static const double POINT_ZEROS[3] = {0, 0, 0};

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

/* Steiner's rule. */
static void set_beside(rod_body_data *body)
{
    const ad_value first = ad_mul(body->mass, body->offset);
    ad_value c[3], on[3], products[3];
    for (int i = 0; i < 3; i++) {
        c[i] = ad_row(body->offset, i);
    }
    for (int i = 0; i < 3; i++) {
        const ad_value y = c[(i + 1) % 3], z = c[(i + 2) % 3];
        on[i] = ad_add(ad_square(y), ad_square(z));
        products[i] = ad_neg(ad_mul(body->mass, ad_mul(y, z)));
    }
    body->inertia = ad_add(body->inertia, ad_mul(body->mass, ad_stack(3, on)));
    body->beside = ad_stack(2, (const ad_value[]){first, ad_stack(3, products)});
}

rod_body_data rod_body_of(const rod_context *rod, int i, ad_value t)
{
    const scene_body *given = &rod->scene->bodies[i];
    const rod_scales *scale = &rod->scales;
    const double rate = rod->dynamic ? 1 / scale->time : 0, by = rate * rate;
    rod_body_data body = {.s = given->at.number / scale->length};
    const ad_value s = ad_scalar(rod->tape, body.s);
    body.mass =
        rod_quantities(rod, 1, &given->mass, POINT_ZEROS, by * scale->length / scale->force, s, t);
    body.inertia = rod_quantities(rod, 3, given->inertia, POINT_ZEROS, by / scale->moment, s, t);
    body.is_beside = quantity_any_something(3, given->offset);
    body.offset = rod_quantities(rod, 3, given->offset, POINT_ZEROS, 1 / scale->length, s, t);
    body.beside = ad_zeros(rod->tape, 6);
    if (body.is_beside) {
        set_beside(&body);
    }
    double mass = 1;
    const bool same = quantity_is_number(given->mass, &mass); /* of all members of a family */
    ad_value weight = rod_quantities(rod, 3, rod->scene->loads.gravity, POINT_ZEROS,
                                     (same ? mass : 1) / scale->force, s, t);
    weight = same ? weight : ad_mul(rod_quantity(rod, given->mass, s, t), weight);
    body.world_weight = ad_mul(rod->at.load_factor, weight);
    body.weight = rod_from_world(rod, body.world_weight);
    return body;
}
