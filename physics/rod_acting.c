/* What acts on a rod from outside by a law of its place, its rotation or its velocity: which laws a
 * scene has, and what numbers they are given. */
#include "physics/rod_internal.h"

static const double ACTING_ZEROS[4] = {0, 0, 0, 0};

/* ---- along the rod ------------------------------------------------------------------------- */

static bool has_foundation(const scene *given)
{
    return quantity_any_something(3, given->loads.foundation);
}

static ad_value foundation_numbers(const rod_context *rod)
{
    const double unit = rod->scales.force / (rod->scales.length * rod->scales.length);
    const ad_value place = rod_undeformed(rod, rod->s).position;
    return ad_stack(3, (ad_value[]){ad_zeros(rod->tape, 3),
                                    rod_quantities(rod, 3, rod->scene->loads.foundation,
                                                   ACTING_ZEROS, 1 / unit, rod->s, rod->t),
                                    rod_position_to_world(rod, place)});
}

static bool has_drag(const scene *given)
{
    return scene_is_dynamic(given) && (quantity_is_something(given->loads.drag) ||
                                       quantity_is_something(given->loads.quadratic_drag));
}

static ad_value drag_numbers(const rod_context *rod)
{
    const scene_loads *given = &rod->scene->loads;
    const double speed = rod->scales.length / rod->scales.time;
    const double factor = speed * rod->scales.length / rod->scales.force;
    return ad_stack(
        2, (ad_value[]){rod_quantities(rod, 1, &given->drag, ACTING_ZEROS, factor, rod->s, rod->t),
                        rod_quantities(rod, 1, &given->quadratic_drag, ACTING_ZEROS, speed * factor,
                                       rod->s, rod->t)});
}

static const struct {
    law_name law;
    bool (*is_on)(const scene *given);
    ad_value (*numbers)(const rod_context *rod);
} ALONG[] = {{LAW_SPRING, has_foundation, foundation_numbers},
             {LAW_RESISTANCE, has_drag, drag_numbers}};

_Static_assert(sizeof ALONG / sizeof *ALONG <= ROD_ALONG_MAX, "too many laws along a rod");

int rod_acting_along(const rod_context *rod, rod_acting *acting)
{
    int count = 0;
    for (size_t i = 0; i < sizeof ALONG / sizeof *ALONG; i++) {
        if (ALONG[i].is_on(rod->scene)) {
            acting[count++] = (rod_acting){.law = ALONG[i].law, .numbers = ALONG[i].numbers(rod)};
        }
    }
    return count;
}

/* ---- at places ----------------------------------------------------------------------------- */

/* Of [3] numbers with that unit. */
static ad_value stiffness_of(const rod_context *rod, const quantity *given, double unit)
{
    return ad_vector_constant(rod->tape, quantity_number_or(given[0], 0) / unit,
                              quantity_number_or(given[1], 0) / unit,
                              quantity_number_or(given[2], 0) / unit);
}

/* An anchor that is given sets out from where the unstressed rod is. */
static ad_value spring_numbers(const rod_context *rod, const scene_spring *given, ad_value position)
{
    const double length = rod->scales.length;
    const ad_value place = rod_position_to_world(rod, position), zero = ad_scalar(rod->tape, 0);
    ad_value shift = ad_zeros(rod->tape, 3);
    if (quantity_any_given(3, given->anchor)) {
        shift = rod_quantities(rod, 3, given->anchor, ACTING_ZEROS, 1 / length, zero, zero);
        shift = ad_mul(rod->at.load_factor, ad_sub(shift, place));
    }
    return ad_stack(3, (ad_value[]){shift,
                                    stiffness_of(rod, given->stiffness, rod->scales.force / length),
                                    place});
}

/* A load at s, under the load factor, in its own frame: of the world, or of the rod. */
static ad_value load_at(const rod_context *rod, const quantity *given, bool axial, bool follows,
                        double s)
{
    const double unit = axial ? rod->scales.moment : rod->scales.force;
    const ad_value load =
        rod_quantities(rod, 3, given, ACTING_ZEROS, 1 / unit, ad_scalar(rod->tape, s), rod->t);
    const ad_value now = ad_mul(rod->at.load_factor, load);
    return follows ? rod_keep_in_plane(rod, now, axial)
                   : (axial ? rod_axial_from_world : rod_from_world)(rod, now);
}

static int add_points(const rod_context *rod, rod_acting *acting)
{
    int count = 0;
    for (int i = 0; i < rod->scene->point_count; i++) {
        const scene_load *load = &rod->scene->points[i].load;
        const double s = rod->scene->points[i].at.number / rod->scales.length;
        const bool follows = load->frame == SCENE_FOLLOWER;
        if (quantity_any_something(3, load->force)) {
            acting[count++] = (rod_acting){follows ? LAW_FOLLOWER_FORCE : LAW_FORCE, s,
                                           load_at(rod, load->force, false, follows, s)};
        }
        if (quantity_any_something(3, load->moment)) {
            acting[count++] = (rod_acting){follows ? LAW_FOLLOWER_MOMENT : LAW_MOMENT, s,
                                           load_at(rod, load->moment, true, follows, s)};
        }
    }
    return count;
}

/* Weights of bodies. */
static int add_weights(const rod_context *rod, rod_acting *acting)
{
    const quantity *gravity = rod->scene->loads.gravity;
    int count = 0;
    for (int i = 0; i < rod->scene->body_count && quantity_any_something(3, gravity); i++) {
        const rod_body_data body = rod_body_of(rod, i, rod->t);
        acting[count++] = (rod_acting){LAW_FORCE, body.s, body.weight};
    }
    return count;
}

int rod_acting_at_places(const rod_context *rod, rod_acting *acting)
{
    int count = add_points(rod, acting);
    count += add_weights(rod, acting + count);
    for (int i = 0; i < rod->scene->spring_count; i++) {
        const scene_spring *given = &rod->scene->springs[i];
        const double s = given->at.number / rod->scales.length;
        const rod_pose pose = rod_undeformed(rod, ad_scalar(rod->tape, s));
        if (quantity_any_something(3, given->stiffness)) {
            acting[count++] =
                (rod_acting){LAW_SPRING, s, spring_numbers(rod, given, pose.position)};
        }
        if (quantity_any_something(3, given->turning)) {
            const ad_value k = stiffness_of(rod, given->turning, rod->scales.moment);
            acting[count++] =
                (rod_acting){LAW_TURNING_SPRING, s, ad_stack(2, (ad_value[]){k, pose.rotation})};
        }
    }
    return count;
}

/* ---- on the tape --------------------------------------------------------------------------- */

static void put_rows(ad_value vector, int count, ad_value *rows)
{
    for (int i = 0; i < count; i++) {
        rows[i] = ad_row(vector, i);
    }
}

rod_wrench rod_acting_wrench(const rod_context *rod, const rod_acting *at, rod_pose pose,
                             ad_value velocity)
{
    const law *of = &law_table[at->law];
    ad_value given[LAW_GIVEN_MAX], wrench[LAW_WRENCH];
    rod_wrench x = {ad_zeros(rod->tape, 3), ad_zeros(rod->tape, 3)};
    if (of->along_axes) {
        pose.position = rod_position_to_world(rod, pose.position);
        pose.rotation = rod_rotation_to_world(rod, pose.rotation);
        velocity = rod_to_world(rod, velocity);
    }
    put_rows(pose.position, 3, given);
    put_rows(pose.rotation, 4, given + 3);
    put_rows(velocity, 3, given + 7);
    put_rows(at->numbers, of->numbers, given + LAW_STATE);
    law_record(at->law, rod->tape, given, NULL, wrench, NULL);
    if (of->has_force) {
        x.force = ad_stack(3, wrench);
        x.force =
            of->along_axes ? rod_from_world(rod, x.force) : rod_keep_in_plane(rod, x.force, false);
    }
    if (of->has_moment) {
        x.moment = ad_rotate_inverse(pose.rotation, ad_stack(3, wrench + 3));
        x.moment = rod_keep_in_plane(rod, x.moment, true);
    }
    return x;
}

bool rod_is_held_by_laws(const scene *given, bool along)
{
    bool any = !along && given->spring_count > 0;
    for (size_t i = 0; i < sizeof ALONG / sizeof *ALONG && along; i++) {
        any = any || (law_table[ALONG[i].law].kind == LAW_STORES && ALONG[i].is_on(given));
    }
    return any;
}
