/* Tendons whose tension the scene does not give everywhere: by friction it falls along them, by a
 * displacement it is unknown (physics/rod/rod.h). What of them is sought are fields along the rod.
 */
#include "physics/rod/rod_internal.h"
#include "physics/scene/breaks.h"

#include <math.h>

static bool has_length(const scene *rod_scene, int i)
{
    return rod_scene->tendons[i].displacement.is_given;
}

static bool has_friction(const scene *rod_scene, int i)
{
    return quantity_is_something(rod_scene->tendons[i].friction);
}

static int tendon_rows(const scene *rod_scene, int i)
{
    return 2 * has_length(rod_scene, i) + has_friction(rod_scene, i);
}

int rod_tendon_rows(const scene *rod_scene)
{
    int rows = 0;
    for (int i = 0; i < rod_scene->tendon_count; i++) {
        rows += tendon_rows(rod_scene, i);
    }
    return rod_scene->formulation == SCENE_MIXED ? rows : 0;
}

/* Of what it turns the rod by, and so of changes of its length; 1 over it of tensions. */
static double lever_of(const rod_context *rod, int i)
{
    return rod_tendon_arm(rod->scene, i);
}

/* What of them is sought, rows of rod_state.tendons. Fields of a tendon have kinks at its ends and
 * what the network says has none: these are made of it in the tendon, and beyond it goes on as it
 * is. */
typedef struct tendon_rows_at {
    int tension, length, angle;
} tendon_rows_at;

static tendon_rows_at rows_of(const scene *rod_scene, int index)
{
    int row = 0;
    for (int i = 0; i < index; i++) {
        row += tendon_rows(rod_scene, i);
    }
    return (tendon_rows_at){row, row + 1, row + 2 * has_length(rod_scene, index)};
}

/* From 0 at its beginning to 1 at its end. */
static ad_value share_of(const rod_context *rod, const rod_actuator *tendon)
{
    return ad_scale(ad_sub(rod->s, ad_scalar(rod->tape, tendon->start)),
                    1 / (tendon->end - tendon->start));
}

/* ---- from the network ------------------------------------------------------------------------ */

/* tau_0, by 1 over the lever: below 0 by how much it is slack. The network starts with taut ones,
 * as nothing says how hard a slack one is pulled. */
static ad_value tension_of(const rod_context *rod, ad_value tendons, int i)
{
    ad_value said = ad_row(tendons, rows_of(rod->scene, i).tension);
    return ad_scale(ad_add(said, ad_scalar(rod->tape, 1)), 1 / lever_of(rod, i));
}

/* l at its end. A tension below 0 stands for the length, by the lever, by which it is slack. So it
 * pulls or is slack, never both. */
static ad_value end_length(const rod_context *rod, int i, ad_value tension)
{
    const scene_tendon *given = &rod->scene->tendons[i];
    const double lever = lever_of(rod, i);
    ad_value zero = ad_scalar(rod->tape, 0);
    const rod_actuator tendon = rod_actuator_of(rod, i);
    ad_value slack = ad_scale(ad_max(ad_neg(tension), zero), lever * lever);
    ad_value length = ad_neg(ad_add(ad_mul(rod->at.load_factor, tendon.displacement), slack));
    return given->stiffness.is_given
               ? ad_add(length, ad_mul(ad_max(tension, zero), tendon.compliance))
               : length;
}

/* l, in proportion to that at its end, and what the network says; phi. */
static ad_value length_of(const rod_context *rod, const rod_actuator *tendon, ad_value tendons,
                          int i)
{
    ad_value share = share_of(rod, tendon), one = ad_scalar(rod->tape, 1);
    ad_value said = ad_scale(ad_row(tendons, rows_of(rod->scene, i).length), lever_of(rod, i));
    ad_value end = end_length(rod, i, tension_of(rod, tendons, i));
    return ad_mul(share, ad_add(end, ad_mul(ad_sub(one, share), said)));
}

static ad_value angle_of(const rod_context *rod, const rod_actuator *tendon, ad_value tendons,
                         int i)
{
    ad_value rise = ad_sub(rod->s, ad_scalar(rod->tape, tendon->start));
    return ad_mul(rise, ad_row(tendons, rows_of(rod->scene, i).angle));
}

/* ---- what follows ---------------------------------------------------------------------------- */

ad_value rod_tendon_rubbed(ad_value pull, ad_value friction, ad_value angle)
{
    return ad_mul(pull, ad_exp(ad_neg(ad_mul(angle, friction))));
}

ad_value rod_tendon_pull(const rod_context *rod, ad_value tendons, int index, ad_value given)
{
    if (tendon_rows(rod->scene, index) == 0) {
        return given;
    }
    if (has_length(rod->scene, index)) {
        given = ad_max(tension_of(rod, tendons, index), ad_scalar(rod->tape, 0));
    }
    if (has_friction(rod->scene, index)) {
        rod_actuator tendon = rod_actuator_of(rod, index);
        ad_value angle = angle_of(rod, &tendon, tendons, index);
        given = rod_tendon_rubbed(given, tendon.friction, angle);
    }
    return given;
}

/* tau_0s, and l_s - |p'| + |p'| unstressed. */
static void length_residual(const rod_context *rod, int i, const rod_actuator *tendon,
                            ad_value stretched, ad_value tendons, ad_value *rows)
{
    const rod_coefficients c = rod_coefficients_of(rod);
    const ad_value one = ad_scalar(rod->tape, 1);
    ad_value rest;
    rod_actuator_wrench(rod, tendon, one, c.rest_strain, c.rest_curvature, &rest);
    tendon_rows_at at = rows_of(rod->scene, i);
    double lever = lever_of(rod, i);
    ad_value longer = ad_sub(stretched, rest);
    ad_value length = length_of(rod, tendon, tendons, i);
    ad_value off = ad_scale(ad_sub(rod_space_derivative(rod, length), longer), 1 / lever);
    ad_value going_on = rod_space_derivative(rod, ad_row(tendons, at.length));
    rows[at.tension] = rod_space_derivative(rod, ad_row(tendons, at.tension));
    rows[at.length] = rod_within(rod, tendon->start, tendon->end, off, going_on);
}

/* phi_s - |t_s|, t in the world. */
static void angle_residual(const rod_context *rod, int i, const rod_actuator *tendon,
                           ad_value direction, rod_state state, ad_value *rows)
{
    int row = rows_of(rod->scene, i).angle;
    ad_value tangent = ad_rotate(state.rotation, direction);
    ad_value turning = ad_norm(rod_space_derivative(rod, tangent));
    ad_value angle = angle_of(rod, tendon, state.tendons, i);
    ad_value going_on = rod_space_derivative(rod, ad_row(state.tendons, row));
    ad_value off = ad_sub(rod_space_derivative(rod, angle), turning);
    rows[row] = rod_within(rod, tendon->start, tendon->end, off, going_on);
}

ad_value rod_tendon_residual(const rod_context *rod, rod_state state)
{
    ad_value rows[3 * SCENE_TENDONS_MAX];
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    for (int i = 0; i < rod->scene->tendon_count; i++) {
        rod_actuator tendon = rod_actuator_of(rod, i);
        const ad_value one = ad_scalar(rod->tape, 1);
        ad_value length;
        const ad_value direction =
            rod_actuator_wrench(rod, &tendon, one, k.strain, k.curvature, &length).force;
        if (has_length(rod->scene, i)) {
            length_residual(rod, i, &tendon, length, state.tendons, rows);
        }
        if (has_friction(rod->scene, i)) {
            angle_residual(rod, i, &tendon, direction, state, rows);
        }
    }
    return ad_stack(rod_tendon_rows(rod->scene), rows);
}
