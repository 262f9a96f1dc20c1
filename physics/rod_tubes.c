/* Tubes around the rod, which bend with it and twist by themselves. */
#include "physics/rod_internal.h"

#include <math.h>

double rod_tube_shape_share(double load_factor)
{
    double missing = (1 - load_factor) * (1 - load_factor);
    return 1 - missing * missing;
}

double rod_tube_turn_share(double load_factor)
{
    return load_factor * load_factor;
}

/* G_i of the middle, by EI: what its torsion is counted in; 1 where it does not twist. */
static double tube_torsion_unit(const rod_context *rod, int index)
{
    const scene *given = rod->scene;
    quantity torsion = scene_tube_properties(&given->tubes[index]).curvature_stiffness[2];
    double middle = quantity_value(torsion, scene_tube_end(given, index) / 2, 0);
    return isfinite(middle) ? middle / (rod->scales.moment * rod->scales.length) : 1;
}

rod_tube rod_tube_of(const rod_context *rod, int index)
{
    const scene_tube *given = &rod->scene->tubes[index];
    const scene_properties made = scene_tube_properties(given);
    const double length = rod->scales.length, none[3] = {0, 0, 0};
    double unit = rod->scales.moment * length;
    quantity torsion = made.curvature_stiffness[2];
    bool locked = scene_locks(torsion);
    return (rod_tube){
        .bending = rod_quantities(rod, 2, made.curvature_stiffness, none, 1 / unit, rod->s, rod->t),
        .softness = locked
                        ? ad_scalar(rod->tape, 0)
                        : ad_scale(ad_reciprocal(rod_quantity(rod, torsion, rod->s, rod->t)), unit),
        .rest = rod_quantities(rod, 3, given->rod.rest_curvature, none, length, rod->s, rod->t),
        .end = scene_tube_end(rod->scene, index) / length,
        .turned = given->turned.number,
        .transmission = given->transmission.number / length};
}

/* y where the tube is, `otherwise` behind its end. */
static ad_value tube_within(const rod_context *rod, const rod_tube *tube, ad_value y,
                            ad_value otherwise)
{
    return tube->end < 1 ? ad_select(ad_sub(rod->s, ad_scalar(rod->tape, tube->end)), otherwise, y)
                         : y;
}

/* ---- the equations --------------------------------------------------------------------------- */

/* A tube at work: w, k on its way and w - k in its own frame, and K (w - k). */
typedef struct tube_state {
    rod_tube tube;
    ad_value theta, torsion; /* m_i */
    ad_value bent, strained, bending;
    ad_value rest_twist;
} tube_state;

/* [2] turned by the angle, by its cosine and sine. */
static ad_value tube_turn(ad_value cosine, ad_value sine, ad_value vector)
{
    ad_value x = ad_row(vector, 0), y = ad_row(vector, 1);
    const ad_value rows[2] = {ad_sub(ad_mul(cosine, x), ad_mul(sine, y)),
                              ad_add(ad_mul(sine, x), ad_mul(cosine, y))};
    return ad_stack(2, rows);
}

static tube_state tube_state_of(const rod_context *rod, int index, ad_value tubes,
                                ad_value curvature)
{
    tube_state x = {.tube = rod_tube_of(rod, index),
                    .theta = ad_row(tubes, 2 * index),
                    .torsion = ad_row(tubes, 2 * index + 1)};
    ad_value one = ad_scalar(rod->tape, 1);
    ad_value missing = ad_square(ad_square(ad_sub(one, rod->at.load_factor)));
    const scene_rest rest = scene_rest_of(rod->scene);
    ad_value shape =
        rod_quantities(rod, 3, rest.curvature, NULL, rod->scales.length, rod->s, rod->t);
    ad_value away = ad_sub(shape, x.tube.rest);
    ad_value k = ad_add(x.tube.rest, ad_mul(missing, away));
    x.bent = tube_turn(ad_cos(x.theta), ad_neg(ad_sin(x.theta)), ad_slice(curvature, 0, 2));
    x.strained = ad_sub(x.bent, ad_slice(k, 0, 2));
    x.bending = ad_mul(x.tube.bending, x.strained);
    x.rest_twist = ad_row(k, 2);
    return x;
}

ad_value rod_tube_moment(const rod_context *rod, ad_value tubes, ad_value curvature)
{
    ad_value sum = ad_zeros(rod->tape, 3), none = sum;
    for (int i = 0; i < rod->scene->tube_count; i++) {
        tube_state x = tube_state_of(rod, i, tubes, curvature);
        const ad_value parts[2] = {tube_turn(ad_cos(x.theta), ad_sin(x.theta), x.bending),
                                   x.torsion};
        sum = ad_add(sum, tube_within(rod, &x.tube, ad_stack(2, parts), none));
    }
    return sum;
}

ad_value rod_tube_weight(const rod_context *rod)
{
    const double none[3] = {0, 0, 0}, length = rod->scales.length;
    ad_value sum = ad_zeros(rod->tape, 3), nothing = sum;
    for (int i = 0; i < rod->scene->tube_count; i++) {
        const scene_properties made = scene_tube_properties(&rod->scene->tubes[i]);
        const rod_tube tube = {.end = scene_tube_end(rod->scene, i) / length};
        quantity pull[3];
        for (int k = 0; k < 3; k++) {
            pull[k] = quantity_multiply(made.mass_per_length, rod->scene->loads.gravity[k]);
        }
        ad_value weight =
            rod_quantities(rod, 3, pull, none, length / rod->scales.force, rod->s, rod->t);
        sum = ad_add(sum, tube_within(rod, &tube, weight, nothing));
    }
    return sum;
}

ad_value rod_tube_stiffening(const rod_context *rod, ad_value compliance)
{
    ad_value one = ad_scalar(rod->tape, 1), sum = ad_zeros(rod->tape, 1), none = sum;
    for (int i = 0; i < rod->scene->tube_count; i++) {
        rod_tube tube = rod_tube_of(rod, i);
        ad_value mean = ad_scale(ad_add(ad_row(tube.bending, 0), ad_row(tube.bending, 1)), 0.5);
        sum = ad_add(sum, tube_within(rod, &tube, mean, none));
    }
    const ad_value rows[3] = {ad_reciprocal(ad_add(one, ad_mul(ad_row(compliance, 0), sum))),
                              ad_reciprocal(ad_add(one, ad_mul(ad_row(compliance, 1), sum))), one};
    return ad_stack(3, rows);
}

/* m_i' - K_1 (w_1 - k_1) w_2 + K_2 (w_2 - k_2) w_1, by what the tube's torsion is counted in. */
static ad_value tube_balance(const rod_context *rod, const tube_state *x, int index)
{
    ad_value change = rod_space_derivative(rod, x->torsion);
    ad_value driven = ad_sub(ad_mul(ad_row(x->bending, 0), ad_row(x->bent, 1)),
                             ad_mul(ad_row(x->bending, 1), ad_row(x->bent, 0)));
    ad_value none = ad_zeros(rod->tape, 1);
    ad_value missing = ad_sub(change, tube_within(rod, &x->tube, driven, none));
    return ad_scale(missing, 1 / tube_torsion_unit(rod, index));
}

static ad_value tube_twist(const rod_context *rod, const tube_state *x, ad_value curvature)
{
    ad_value turning = rod_space_derivative(rod, x->theta);
    ad_value twisted = ad_mul(x->tube.softness, x->torsion);
    ad_value twist = ad_sub(ad_add(twisted, x->rest_twist), ad_row(curvature, 2));
    return ad_sub(turning, tube_within(rod, &x->tube, twist, ad_zeros(rod->tape, 1)));
}

ad_value rod_tube_residual(const rod_context *rod, rod_state state, bool torsion)
{
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    ad_value rows[SCENE_TUBES_MAX];
    for (int i = 0; i < rod->scene->tube_count; i++) {
        tube_state x = tube_state_of(rod, i, state.tubes, k.curvature);
        rows[i] = torsion ? tube_balance(rod, &x, i) : tube_twist(rod, &x, k.curvature);
    }
    return ad_stack(rod->scene->tube_count, rows);
}

/* ---- the ansatz ------------------------------------------------------------------------------ */

/* m_i = fall network, theta = turned + transmission m_i(0)/G(0) + rise network. */
ad_value rod_tube_ansatz(const rod_context *rod, ad_value outputs)
{
    ad_value rows[2 * SCENE_TUBES_MAX], zero = ad_scalar(rod->tape, 0);
    if (rod->scene->tube_count == 0) {
        return outputs;
    }
    ad_value rise = domain_vanish(&rod->at, 0), fall = domain_vanish(&rod->at, 1);
    for (int i = 0; i < rod->scene->tube_count; i++) {
        rod_tube tube = rod_tube_of(rod, i);
        ad_value share = ad_square(rod->at.load_factor);
        ad_value torsion =
            ad_mul(fall, ad_scale(ad_row(outputs, 2 * i + 1), tube_torsion_unit(rod, i)));
        ad_value theta = ad_add(ad_scale(share, tube.turned), ad_mul(rise, ad_row(outputs, 2 * i)));
        if (tube.transmission > 0) {
            ad_value twisted = ad_substitute(ad_mul(tube.softness, torsion), rod->s, zero);
            theta = ad_add(theta, ad_scale(twisted, tube.transmission));
        }
        rows[2 * i] = theta;
        rows[2 * i + 1] = torsion;
    }
    return ad_stack(2 * rod->scene->tube_count, rows);
}
