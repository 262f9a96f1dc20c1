/* What acts at single places of a beam: concentrated loads, rigid bodies, springs. */
#include "physics/beam/beam_internal.h"

beam_point_data beam_point_of(const beam_context *beam, int i, ad_value t)
{
    const scene_beam_point *given = &beam->scene->beam.points[i];
    double s = given->at.number / beam->unit.length;
    ad_value at = ad_scalar(beam->tape, s);
    return (beam_point_data){
        .s = s,
        .force = beam_formula(beam, given->load.force, beam->unit.force, at, t),
        .moment = beam_formula(beam, given->load.moment, beam->unit.moment, at, t)};
}

beam_body_data beam_body_of(const beam_context *beam, int i)
{
    const scene_body *given = &beam->scene->bodies[i];
    const beam_units *unit = &beam->unit;
    double rate = beam->dynamic ? 1 / unit->time : 0;
    return (beam_body_data){.s = given->at.number / unit->length,
                            .mass =
                                given->mass.number * rate * rate * unit->deflection / unit->force,
                            .inertia = quantity_number_or(given->inertia[0], 0) * rate * rate *
                                       unit->slope / unit->moment};
}

beam_spring_data beam_spring_of(const beam_context *beam, int i)
{
    const scene_spring *given = &beam->scene->springs[i];
    const beam_units *unit = &beam->unit;
    return (beam_spring_data){
        .s = given->at.number / unit->length,
        .stiffness = quantity_number_or(given->stiffness[1], 0) * unit->deflection / unit->force,
        .turning = quantity_number_or(given->turning[0], 0) * unit->slope / unit->moment,
        .anchor = quantity_number_or(given->anchor[1], 0) / unit->deflection};
}

ad_value beam_there(const beam_context *beam, ad_value y, double s)
{
    return ad_substitute(y, beam->s, ad_scalar(beam->tape, s));
}

int beam_forces_at(const beam_context *beam, ad_value w, ad_value psi, beam_force_at *acting)
{
    const scene *given = beam->scene;
    int count = 0;
    for (int i = 0; i < given->beam.point_count; i++) {
        beam_point_data point = beam_point_of(beam, i, beam->t);
        acting[count++] = (beam_force_at){point.s, point.force, point.moment};
    }
    for (int i = 0; i < given->body_count; i++) {
        beam_body_data body = beam_body_of(beam, i);
        ad_value speeding = beam_there(beam, beam_time_derivative(beam, w, 2), body.s);
        ad_value turning = beam_there(beam, beam_time_derivative(beam, psi, 2), body.s);
        acting[count++] = (beam_force_at){body.s, ad_scale(speeding, -body.mass),
                                          ad_scale(turning, -body.inertia)};
    }
    for (int i = 0; i < given->spring_count; i++) {
        beam_spring_data spring = beam_spring_of(beam, i);
        ad_value off = ad_sub(ad_scalar(beam->tape, spring.anchor), beam_there(beam, w, spring.s));
        ad_value turn = ad_scale(beam_there(beam, psi, spring.s), -spring.turning);
        acting[count++] = (beam_force_at){spring.s, ad_scale(off, spring.stiffness), turn};
    }
    return count;
}
