/* What acts at single places of a rod: concentrated loads, joints, rigid bodies, springs. */
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

/* ---- springs --------------------------------------------------------------------------------- */

rod_spring_data rod_spring_of(const rod_context *rod, int i)
{
    const scene_spring *given = &rod->scene->springs[i];
    const rod_scales *scale = &rod->scales;
    rod_spring_data spring = {.s = given->at.number / scale->length};
    for (int k = 0; k < 3; k++) {
        double stiffness = quantity_number_or(given->stiffness[k], 0);
        double turning = quantity_number_or(given->turning[k], 0);
        spring.stiffness[k] = stiffness * scale->length / scale->force;
        spring.turning[k] = turning / scale->moment;
    }
    rod_pose pose = rod_undeformed(rod, ad_scalar(rod->tape, spring.s));
    spring.anchor = rod_position_to_world(rod, pose.position);
    spring.upright = pose.rotation;
    if (quantity_any_given(3, given->anchor)) { /* reached as held ends reach their places */
        ad_value zero = ad_scalar(rod->tape, 0);
        ad_value anchor =
            rod_quantities(rod, 3, given->anchor, POINT_ZEROS, 1 / scale->length, zero, zero);
        ad_value way = ad_mul(rod->at.load_factor, ad_sub(anchor, spring.anchor));
        spring.anchor = ad_add(spring.anchor, way);
    }
    return spring;
}

ad_value rod_spring_force(const rod_context *rod, const rod_spring_data *spring, ad_value position)
{
    const double *k = spring->stiffness;
    ad_value off = ad_sub(spring->anchor, rod_position_to_world(rod, position));
    return rod_from_world(rod, ad_mul(ad_vector_constant(rod->tape, k[0], k[1], k[2]), off));
}

/* Polynomials in a, coefficients from the constant on. */
static ad_value spring_series(ad_value a, int count, const double *coefficient)
{
    ad_value sum = ad_scalar(a.tape, coefficient[count - 1]);
    for (int i = count - 2; i >= 0; i--) {
        sum = ad_add(ad_scalar(a.tape, coefficient[i]), ad_mul(a, sum));
    }
    return sum;
}

/* The rotation vector phi of a unit quaternion p and c = (1 - b cot b)/(4 b^2), b = |phi|/2. The
 * angle is halved four times, and there both are short series; nothing is divided by the angle, so
 * that both are smooth up to a whole turn. With b of a level, y = sin b, w = cos b and R = b/y,
 *   C(2b) = (C(b) + 1/(w R))/4,   R(2b) = R(b)/w
 * for C(b) = (1 - b cot b)/b^2 = 1/3 + b^2/45 + ..., by cot 2b = (cot b - tan b)/2. */
static ad_value spring_rotation_vector(ad_value p, ad_value *c)
{
    enum { HALVINGS = 4, TERMS = 13 };
    static const double cotangent[7] = {1.0 / 3,     1.0 / 45,           2.0 / 945,     1.0 / 4725,
                                        2.0 / 93555, 1382.0 / 638512875, 4.0 / 18243225};
    double arcsine[TERMS] = {1}; /* of asin(y)/y in y^2 */
    ad_value one = ad_scalar(p.tape, 1), w[HALVINGS + 1], x = ad_slice(p, 1, 3);
    for (int n = 1; n < TERMS; n++) {
        double odd = 2 * n - 1;
        arcsine[n] = arcsine[n - 1] * odd * odd / (2 * n * (2 * n + 1));
    }
    w[0] = ad_row(p, 0);
    for (int i = 1; i <= HALVINGS; i++) {
        w[i] = ad_sqrt(ad_scale(ad_add(one, w[i - 1]), 0.5));
        x = ad_div(x, ad_scale(w[i], 2));
    }
    ad_value square = ad_dot(x, x), ratio = spring_series(square, TERMS, arcsine);
    ad_value phi = ad_scale(ad_mul(ratio, x), 2 << HALVINGS);
    *c = spring_series(ad_mul(square, ad_square(ratio)), 7, cotangent);
    for (int i = HALVINGS; i >= 1; i--) {
        *c = ad_scale(ad_add(*c, ad_reciprocal(ad_mul(w[i], ratio))), 0.25);
        ratio = ad_div(ratio, w[i]);
    }
    *c = ad_scale(*c, 0.25);
    return phi;
}

ad_value rod_spring_moment(const rod_context *rod, const rod_spring_data *spring, ad_value rotation)
{
    const double *k = spring->turning;
    if (k[0] == 0 && k[1] == 0 && k[2] == 0) {
        return ad_zeros(rod->tape, 3);
    }
    ad_value c, turned = ad_quaternion_multiply(ad_quaternion_conjugate(spring->upright), rotation);
    ad_value phi = spring_rotation_vector(turned, &c);
    ad_value moment = ad_mul(ad_vector_constant(rod->tape, k[0], k[1], k[2]), phi);
    if (k[0] != k[1] || k[0] != k[2]) { /* else both lie along phi */
        ad_value once = ad_cross(phi, moment), again = ad_cross(phi, once);
        moment = ad_add(ad_sub(moment, ad_scale(once, 0.5)), ad_mul(c, again));
    }
    return rod_keep_in_plane(rod, ad_neg(moment), true);
}
