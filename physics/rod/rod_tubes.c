/* Tubes around the rod, which bend with it and twist by themselves. */
#include "physics/law/law.h"
#include "physics/rod/rod_internal.h"

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
    scene_tube tube = rod->scene->tubes[index];
    tube.rod.growth = (quantity){.is_given = false}; /* 1 in the middle */
    quantity torsion = scene_tube_properties(&tube).curvature_stiffness[2];
    double middle = quantity_value(torsion, scene_tube_end(rod->scene, index) / 2, 0);
    return isfinite(middle) ? middle / (rod->scales.moment * rod->scales.length) : 1;
}

rod_tube rod_tube_of(const rod_context *rod, int index)
{
    const scene_tube *given = &rod->scene->tubes[index];
    const scene_properties made = scene_tube_properties(given);
    const scene_rest rest = scene_rod_rest(&given->rod);
    const double length = rod->scales.length, none[3] = {0, 0, 0};
    double unit = rod->scales.moment * length;
    quantity torsion = made.curvature_stiffness[2];
    bool locked = scene_locks(torsion);
    return (rod_tube){
        .bending = rod_quantities(rod, 2, made.curvature_stiffness, none, 1 / unit, rod->s, rod->t),
        .softness = locked
                        ? ad_scalar(rod->tape, 0)
                        : ad_scale(ad_reciprocal(rod_quantity(rod, torsion, rod->s, rod->t)), unit),
        .rest = rod_quantities(rod, 3, rest.curvature, none, length, rod->s, rod->t),
        .end = scene_tube_end(rod->scene, index) / length,
        .turned = rod_quantity(rod, given->turned, rod->s, rod->t),
        .transmission =
            ad_scale(rod_quantity(rod, given->transmission, rod->s, rod->t), 1 / length)};
}

/* ---- the equations --------------------------------------------------------------------------- */

void rod_tube_numbers(const rod_context *rod, int index, ad_value *numbers)
{
    const rod_tube tube = rod_tube_of(rod, index);
    const scene_rest rest = scene_rest_of(rod->scene);
    const ad_value one = ad_scalar(rod->tape, 1);
    const ad_value missing = ad_square(ad_square(ad_sub(one, rod->at.load_factor)));
    const ad_value shape =
        rod_quantities(rod, 3, rest.curvature, NULL, rod->scales.length, rod->s, rod->t);
    const ad_value k = ad_add(tube.rest, ad_mul(missing, ad_sub(shape, tube.rest)));
    numbers[0] = ad_row(tube.bending, 0);
    numbers[1] = ad_row(tube.bending, 1);
    for (int i = 0; i < 3; i++) {
        numbers[2 + i] = ad_row(k, i);
    }
    numbers[5] = tube.softness;
}

/* The gradient of the law of a tube: what the moment of the rod gains [3], m_i', -theta'. */
static void tube_law(const rod_context *rod, int index, ad_value tubes, ad_value curvature,
                     ad_value gradient[LAW_WRENCH])
{
    const ad_value theta = ad_row(tubes, 2 * index);
    ad_value given[LAW_WRENCH + LAW_TUBE_GIVEN] = {
        [3] = ad_cos(theta), [4] = ad_sin(theta), [5] = ad_row(tubes, 2 * index + 1)};
    for (int i = 0; i < 3; i++) {
        given[i] = ad_row(curvature, i);
    }
    rod_tube_numbers(rod, index, given + LAW_WRENCH);
    law_record(LAW_TUBE, rod->tape, given, NULL, gradient, NULL);
}

ad_value rod_tube_moment(const rod_context *rod, ad_value tubes, ad_value curvature)
{
    ad_value sum = ad_zeros(rod->tape, 3), none = sum, gradient[LAW_WRENCH];
    for (int i = 0; i < rod->scene->tube_count; i++) {
        const rod_tube tube = rod_tube_of(rod, i);
        tube_law(rod, i, tubes, curvature, gradient);
        sum = ad_add(sum, rod_within(rod, 0, tube.end, ad_stack(3, gradient), none));
    }
    return sum;
}

ad_value rod_tube_stiffening(const rod_context *rod, ad_value compliance)
{
    ad_value one = ad_scalar(rod->tape, 1), sum = ad_zeros(rod->tape, 1), none = sum;
    for (int i = 0; i < rod->scene->tube_count; i++) {
        rod_tube tube = rod_tube_of(rod, i);
        ad_value mean = ad_scale(ad_add(ad_row(tube.bending, 0), ad_row(tube.bending, 1)), 0.5);
        sum = ad_add(sum, rod_within(rod, 0, tube.end, mean, none));
    }
    const ad_value rows[3] = {ad_reciprocal(ad_add(one, ad_mul(ad_row(compliance, 0), sum))),
                              ad_reciprocal(ad_add(one, ad_mul(ad_row(compliance, 1), sum))), one};
    return ad_stack(3, rows);
}

ad_value rod_tube_residual(const rod_context *rod, rod_state state, bool torsion)
{
    rod_kinematics k = rod_kinematics_of(rod, state.position, state.rotation);
    ad_value rows[SCENE_TUBES_MAX], gradient[LAW_WRENCH], none = ad_zeros(rod->tape, 1);
    for (int i = 0; i < rod->scene->tube_count; i++) {
        const rod_tube tube = rod_tube_of(rod, i);
        tube_law(rod, i, state.tubes, k.curvature, gradient);
        const ad_value change = rod_space_derivative(rod, ad_row(state.tubes, 2 * i + torsion));
        const ad_value by = torsion ? ad_neg(gradient[3]) : gradient[4];
        rows[i] = ad_add(change, rod_within(rod, 0, tube.end, by, none));
        rows[i] = ad_scale(rows[i], torsion ? 1 / tube_torsion_unit(rod, i) : 1);
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
        ad_value theta = ad_add(ad_mul(share, tube.turned), ad_mul(rise, ad_row(outputs, 2 * i)));
        if (quantity_is_something(rod->scene->tubes[i].transmission)) {
            ad_value twisted = ad_substitute(ad_mul(tube.softness, torsion), rod->s, zero);
            theta = ad_add(theta, ad_mul(twisted, tube.transmission));
        }
        rows[2 * i] = theta;
        rows[2 * i + 1] = torsion;
    }
    return ad_stack(2 * rod->scene->tube_count, rows);
}
