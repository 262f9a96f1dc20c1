/* What acts at single places of a beam: concentrated loads, rigid bodies, springs. */
#include "physics/beam_internal.h"

/* Of what may be left out. */
static double beam_number(quantity q)
{
    return q.is_given ? q.number : 0;
}

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
    return (beam_body_data){
        .s = given->at.number / unit->length,
        .mass = given->mass.number * rate * rate * unit->deflection / unit->force,
        .inertia = beam_number(given->inertia[0]) * rate * rate * unit->slope / unit->moment};
}

beam_spring_data beam_spring_of(const beam_context *beam, int i)
{
    const scene_spring *given = &beam->scene->springs[i];
    const beam_units *unit = &beam->unit;
    return (beam_spring_data){
        .s = given->at.number / unit->length,
        .stiffness = beam_number(given->stiffness[1]) * unit->deflection / unit->force,
        .turning = beam_number(given->turning[0]) * unit->slope / unit->moment,
        .anchor = beam_number(given->anchor[1]) / unit->deflection};
}
