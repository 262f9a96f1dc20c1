/* Tendons whose tension the scene does not give everywhere: by friction it falls along them, by a
 * displacement it is unknown (physics/rod.h). What of them is sought are fields along the rod. */
#include "physics/breaks.h"
#include "physics/rod_internal.h"

#include <math.h>

/* Of a length: a tendon closer to the axis than this still has a scale. */
static const double LEVER_LEAST = 1e-3;

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

static int first_row(const scene *rod_scene, int index)
{
    int rows = 0;
    for (int i = 0; i < index; i++) {
        rows += tendon_rows(rod_scene, i);
    }
    return rows;
}

/* Of what it turns the rod by, and so of changes of its length; 1 over it of tensions. */
static double lever_of(const rod_context *rod, int i)
{
    return fmax(rod_tendon_lever(rod->scene, i) / rod->scales.length, LEVER_LEAST);
}

/* `inside` where the tendon is, else `outside`. */
static ad_value where_is(const rod_context *rod, const rod_actuator *tendon, ad_value inside,
                         ad_value outside)
{
    if (tendon->start > 0) {
        inside = ad_select(ad_sub(ad_scalar(rod->tape, tendon->start), rod->s), outside, inside);
    }
    if (tendon->end < 1) {
        inside = ad_select(ad_sub(rod->s, ad_scalar(rod->tape, tendon->end)), outside, inside);
    }
    return inside;
}

/* From 0 at its beginning to 1 at its end. */
static ad_value share_of(const rod_context *rod, const rod_actuator *tendon)
{
    return ad_scale(ad_sub(rod->s, ad_scalar(rod->tape, tendon->start)),
                    1 / (tendon->end - tendon->start));
}

/* ---- from the network ------------------------------------------------------------------------ */

/* By how much it is longer at its end than in the unstressed rod: of a number x above 0 the tension
 * by its scale, below 0 by how much it is slack, by the lever. So it pulls or is slack, never both.
 */
static ad_value end_length(const rod_context *rod, int i, ad_value tension)
{
    const scene_tendon *given = &rod->scene->tendons[i];
    const double none = 0, lever = lever_of(rod, i);
    ad_value zero = ad_scalar(rod->tape, 0);
    ad_value pulled =
        rod_quantities(rod, 1, &given->displacement, &none, 1 / rod->scales.length, rod->s, rod->t);
    ad_value slack = ad_scale(ad_max(ad_neg(tension), zero), lever * lever);
    ad_value length = ad_neg(ad_add(ad_mul(rod->at.load_factor, pulled), slack));
    if (given->stiffness.is_given) {
        double unit = rod->scales.force / rod->scales.length;
        double compliance = unit / quantity_value(given->stiffness, 0, 0);
        length = ad_add(length, ad_scale(ad_max(tension, zero), compliance));
    }
    return length;
}

/* The path has a kink where strains jump: the angle would, too. */
static void refuse_kinks(const rod_context *rod, int i, const rod_actuator *tendon)
{
    scene_breaks breaks;
    ad_error error;
    if (scene_breaks_of(rod->scene, "s", &breaks, &error) != AD_OK) {
        ad_tape_fail(rod->tape, error.status, "%s", error.message);
        return;
    }
    for (int k = 0; k < breaks.count; k++) {
        double s = breaks.place[k] / rod->scales.length;
        if (s > tendon->start + 1e-12 && s < tendon->end - 1e-12) {
            ad_tape_fail(rod->tape, AD_BAD_ARGUMENT,
                         "tendons[%d].friction: at s = %.6g m something jumps, where the tendon "
                         "may have a kink; a network needs a friction of 0, the classical solver "
                         "has it",
                         i, breaks.place[k]);
            return;
        }
    }
}

/* tau_0 as x of end_length by 1 over the lever; l as if it went in proportion to its end, and what
 * the network says; phi. Beyond the ends of a tendon the last two are what the network says. */
ad_value rod_tendon_ansatz(const rod_context *rod, ad_value raw)
{
    ad_value rows[3 * SCENE_TENDONS_MAX], one = ad_scalar(rod->tape, 1);
    int count = 0;
    for (int i = 0; i < rod->scene->tendon_count; i++) {
        rod_actuator tendon = rod_actuator_of(rod, i);
        double lever = lever_of(rod, i), range = tendon.end - tendon.start;
        ad_value share = share_of(rod, &tendon);
        if (has_length(rod->scene, i)) {
            ad_value tension = ad_scale(ad_add(ad_row(raw, count), one), 1 / lever);
            ad_value said = ad_scale(ad_row(raw, count + 1), lever);
            ad_value bow = ad_mul(ad_mul(share, ad_sub(one, share)), said);
            ad_value along = ad_add(ad_mul(share, end_length(rod, i, tension)), bow);
            rows[count++] = tension;
            rows[count++] = where_is(rod, &tendon, along, said);
        }
        if (has_friction(rod->scene, i)) {
            ad_value said = ad_row(raw, count);
            ad_value rise = ad_scale(share, range);
            refuse_kinks(rod, i, &tendon);
            rows[count++] = where_is(rod, &tendon, ad_mul(rise, said), said);
        }
    }
    return ad_stack(count, rows);
}

/* ---- what follows ---------------------------------------------------------------------------- */

ad_value rod_tendon_pull(const rod_context *rod, ad_value tendons, int index, ad_value given)
{
    int row = first_row(rod->scene, index);
    const scene_tendon *tendon = &rod->scene->tendons[index];
    if (tendon_rows(rod->scene, index) == 0) {
        return given;
    }
    if (!ad_is_valid(tendons)) {
        ad_tape_fail(rod->tape, AD_BAD_ARGUMENT,
                     "tendons[%d].%s: the tension of this tendon is sought along the rod; "
                     "allowed: formulation: mixed",
                     index, has_length(rod->scene, index) ? "displacement" : "friction");
        return given;
    }
    if (has_length(rod->scene, index)) {
        given = ad_max(ad_row(tendons, row), ad_scalar(rod->tape, 0));
        row += 2;
    }
    if (has_friction(rod->scene, index)) {
        double friction = quantity_value(tendon->friction, 0, 0);
        given = ad_mul(given, ad_exp(ad_scale(ad_row(tendons, row), -friction)));
    }
    return given;
}

/* Beyond the ends of a tendon its fields are to be 0. */
ad_value rod_tendon_residual(const rod_context *rod, rod_state state)
{
    ad_value rows[3 * SCENE_TENDONS_MAX];
    rod_coefficients c = rod_coefficients_of(rod);
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    int count = 0;
    for (int i = 0; i < rod->scene->tendon_count; i++) {
        rod_actuator tendon = rod_actuator_of(rod, i);
        double lever = lever_of(rod, i);
        ad_value path = rod_tendon_path(&tendon, k.strain, k.curvature);
        if (has_length(rod->scene, i)) {
            ad_value rest = rod_tendon_path(&tendon, c.rest_strain, c.rest_curvature);
            ad_value longer = ad_sub(ad_norm(path), ad_norm(rest));
            ad_value length = ad_row(state.tendons, count + 1);
            ad_value off = ad_sub(rod_space_derivative(rod, length), longer);
            rows[count] = ad_scale(rod_space_derivative(rod, ad_row(state.tendons, count)), lever);
            rows[count + 1] = ad_scale(where_is(rod, &tendon, off, length), 1 / lever);
            count += 2;
        }
        if (has_friction(rod->scene, i)) {
            ad_value angle = ad_row(state.tendons, count);
            ad_value tangent = ad_rotate(state.rotation, ad_normalize(path));
            ad_value turning = ad_norm(rod_space_derivative(rod, tangent));
            ad_value off = ad_sub(rod_space_derivative(rod, angle), turning);
            rows[count++] = where_is(rod, &tendon, off, angle);
        }
    }
    return ad_stack(count, rows);
}
