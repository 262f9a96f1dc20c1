/* Manufactured solutions: an exact pose chosen by the author, and by the equations themselves the
 * loads that make it a solution. */
#include "physics/rod/rod_internal.h"

/* exp of a rotation by `angle` about body axis 0, 1, 2. */
static ad_value rod_axis_rotation(ad_value angle, int axis)
{
    return ad_quaternion_exp(ad_pad(angle, axis, 3));
}

static ad_value rod_manufactured_rotation(const rod_context *rod)
{
    const scene_manufactured *exact = &rod->scene->manufactured;
    const double none[4] = {1, 0, 0, 0};
    if (exact->rotation[0].is_given) {
        return ad_normalize(rod_quantities(rod, 4, exact->rotation, none, 1, rod->s, rod->t));
    }
    ad_value angles = rod_quantities(rod, 3, exact->angles, none + 1, 1, rod->s, rod->t);
    ad_value first = rod_axis_rotation(ad_row(angles, 0), 0);
    ad_value second = rod_axis_rotation(ad_row(angles, 1), 1);
    ad_value third = rod_axis_rotation(ad_row(angles, 2), 2);
    return ad_quaternion_multiply(ad_quaternion_multiply(first, second), third);
}

rod_state rod_manufactured(const scene *rod_scene, ad_value s, ad_value t)
{
    const domain_place at = rod_place(rod_scene, s, t);
    rod_context rod = rod_context_of(rod_scene, &at);
    if (scene_is_locked(&rod.properties)) {
        ad_tape_fail(s.tape, AD_BAD_ARGUMENT,
                     "manufactured: internal force and moment follow from the strains, so every "
                     "stiffness must be finite (model cosserat)");
    }
    const double none[3] = {0, 0, 0};
    rod_state exact = {0};
    exact.position = rod_quantities(&rod, 3, rod_scene->manufactured.position, none,
                                    1 / rod.scales.length, s, t);
    exact.rotation = rod_manufactured_rotation(&rod);
    rod_kinematics k = rod_kinematics_of(&rod, exact.position, exact.rotation);
    rod_wrench wrench = rod_constitutive(&rod, &k);
    exact.force = ad_rotate(exact.rotation, wrench.force);
    exact.moment = wrench.moment;
    return exact;
}

/* The balance laws at the exact state, with the sign turned; the moment turned to the world. */
rod_load rod_manufactured_load(const scene *rod_scene, ad_value s, ad_value t)
{
    const domain_place at = rod_place(rod_scene, s, t);
    rod_context rod = rod_context_of(rod_scene, &at);
    rod_state exact = rod_manufactured(rod_scene, s, t);
    ad_value moment = ad_neg(rod_moment_balance(&rod, exact));
    return (rod_load){.force = ad_neg(rod_force_balance(&rod, exact)),
                      .moment = ad_rotate(exact.rotation, moment)};
}
