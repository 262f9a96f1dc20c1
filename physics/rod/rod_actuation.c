/* Force and moment of a section: elastic, damping, actuators. */
#include "physics/law/law.h"
#include "physics/rod/rod_internal.h"

rod_actuator rod_actuator_of(const rod_context *rod, int index)
{
    const double none[2] = {0, 0}, length = rod->scales.length, force = rod->scales.force;
    const scene_actuator given = scene_actuator_of(rod->scene, index);
    const quantity pull = scene_actuator_pull(&given);
    const quantity displacement = given.tendon ? given.tendon->displacement : quantity_number(0);
    const quantity friction = given.tendon ? given.tendon->friction : quantity_number(0);
    const quantity compliance = given.tendon && given.tendon->stiffness.is_given
                                    ? quantity_divide(quantity_number(1), given.tendon->stiffness)
                                    : quantity_number(0);
    ad_value offset = rod_quantities(rod, 2, given.offset, none, 1 / length, rod->s, rod->t);
    return (rod_actuator){
        .offset = offset,
        .slope = rod_space_derivative(rod, offset),
        .pull = rod_quantities(rod, 1, &pull, none, 1 / force, rod->s, rod->t),
        .displacement = rod_quantities(rod, 1, &displacement, none, 1 / length, rod->s, rod->t),
        .friction = rod_quantities(rod, 1, &friction, none, 1, rod->s, rod->t),
        .compliance = rod_quantities(rod, 1, &compliance, none, force / length, rod->s, rod->t),
        .start = given.from / length,
        .end = given.to / length,
        .law = rod_actuator_law(&given)};
}

ad_value rod_within(const rod_context *rod, double start, double end, ad_value inside,
                    ad_value outside)
{
    if (start > 0) {
        inside = ad_select(ad_sub(ad_scalar(rod->tape, start), rod->s), outside, inside);
    }
    if (end < 1) {
        inside = ad_select(ad_sub(rod->s, ad_scalar(rod->tape, end)), outside, inside);
    }
    return inside;
}

rod_wrench rod_actuator_wrench(const rod_context *rod, const rod_actuator *actuator, ad_value pull,
                               ad_value strain, ad_value curvature, ad_value *energy)
{
    ad_value given[LAW_GIVEN_MAX], wrench[LAW_WRENCH];
    for (int i = 0; i < 3; i++) {
        given[i] = ad_row(strain, i);
        given[3 + i] = ad_row(curvature, i);
    }
    for (int i = 0; i < 2; i++) {
        given[6 + i] = ad_row(actuator->offset, i);
        given[8 + i] = ad_row(actuator->slope, i);
    }
    given[10] = pull;
    law_record(actuator->law, rod->tape, given, energy, wrench, NULL);
    return (rod_wrench){.force = ad_stack(3, wrench), .moment = ad_stack(3, wrench + 3)};
}

/* What the law is beyond Kse (v - v*), Kbt (u - u*). */
static rod_wrench rod_law_wrench(const rod_context *rod, const rod_kinematics *k)
{
    const scene_law *law = rod->scene->rod.law;
    if (!law) {
        return (rod_wrench){ad_zeros(rod->tape, 3), ad_zeros(rod->tape, 3)};
    }
    const rod_coefficients c = rod_coefficients_of(rod);
    ad_value strains = ad_stack(2, (const ad_value[]){ad_sub(k->strain, c.rest_strain),
                                                      ad_sub(k->curvature, c.rest_curvature)});
    ad_value stress = scene_law_record_beyond(law, rod->scales.length, rod->scales.force, strains);
    return (rod_wrench){rod_keep_in_plane(rod, ad_slice(stress, 0, 3), false),
                        rod_keep_in_plane(rod, ad_slice(stress, 3, 3), true)};
}

/* A law of strains or rates, v and u, of which each has a number in `by`. */
static rod_wrench rod_section(const rod_context *rod, law_name law, const ad_value x[2],
                              const ad_value by[2])
{
    ad_value given[LAW_GIVEN_MAX], wrench[LAW_WRENCH];
    for (int i = 0; i < LAW_WRENCH; i++) {
        given[i] = ad_row(x[i / 3], i % 3);
        given[LAW_WRENCH + i] = ad_row(by[i / 3], i % 3);
    }
    law_record(law, rod->tape, given, NULL, wrench, NULL);
    return (rod_wrench){ad_stack(3, wrench), ad_stack(3, wrench + 3)};
}

rod_wrench rod_beyond_elastic(const rod_context *rod, const rod_kinematics *k, ad_value tendons)
{
    const rod_coefficients c = rod_coefficients_of(rod);
    const ad_value rates[2] = {k->strain_rate, k->curvature_rate};
    const ad_value damping[2] = {c.strain_damping, c.curvature_damping};
    rod_wrench sum = rod_section(rod, LAW_DAMPING, rates, damping);
    sum = rod_wrench_add(sum, rod_law_wrench(rod, k));
    int count = scene_actuator_count(rod->scene);
    for (int i = 0; i < count; i++) {
        rod_actuator actuator = rod_actuator_of(rod, i);
        ad_value pull = ad_mul(rod->at.load_factor, actuator.pull);
        if (i < rod->scene->tendon_count) {
            pull = rod_tendon_pull(rod, tendons, i, pull);
        }
        pull = rod_within(rod, actuator.start, actuator.end, pull, ad_scalar(rod->tape, 0));
        sum = rod_wrench_add(
            sum, rod_actuator_wrench(rod, &actuator, pull, k->strain, k->curvature, NULL));
    }
    return sum;
}

rod_wrench rod_constitutive(const rod_context *rod, const rod_kinematics *k)
{
    const rod_coefficients c = rod_coefficients_of(rod);
    const ad_value off[2] = {ad_sub(k->strain, c.rest_strain),
                             ad_sub(k->curvature, c.rest_curvature)};
    const ad_value stiffness[2] = {c.strain_stiffness, c.curvature_stiffness};
    return rod_wrench_add(rod_section(rod, LAW_ELASTIC, off, stiffness),
                          rod_beyond_elastic(rod, k, (ad_value){0}));
}
