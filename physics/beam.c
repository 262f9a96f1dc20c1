/* Scales, numbers, formulas and ends of a beam. */
#include "physics/beam_internal.h"
#include "physics/expression.h"

#include <math.h>

enum { BEAM_SPACE_SAMPLES = 8, BEAM_TIME_SAMPLES = 16 }; /* a scale does not need the peak */

/* ---- scales ---------------------------------------------------------------------------------- */

/* Largest |formula|, 0 for NULL, over samples of what varies. */
static double beam_largest(const scene *beam_scene, const char *text, bool along_s, bool in_time)
{
    int space = along_s ? BEAM_SPACE_SAMPLES : 0;
    int time = in_time && scene_is_dynamic(beam_scene) ? BEAM_TIME_SAMPLES : 0;
    double largest = 0;
    for (int i = 0; text && i <= space; i++) {
        for (int j = 0; j <= time; j++) {
            double s = beam_scene->rod.length * i / BEAM_SPACE_SAMPLES;
            double t = beam_scene->duration * j / BEAM_TIME_SAMPLES;
            largest = fmax(largest, fabs(expression_evaluate(text, s, t)));
        }
    }
    return largest;
}

double beam_deflection_scale(const scene *beam_scene)
{
    const scene_beam *beam = &beam_scene->beam;
    rod_scales scales = rod_scales_of(beam_scene);
    double length = scales.length, time = scales.time;
    double by_force = length / scales.force,
           by_moment = length / scales.moment; /* L^3/EI, L^2/EI */
    const struct {
        const char *text;
        double factor; /* to m */
        bool along_s, in_time;
    } rows[] = {{beam->force, by_force * length / 8, true, true},
                {beam->moment, by_force / 3, true, true},
                {beam->base.force, by_force / 3, false, true},
                {beam->tip.force, by_force / 3, false, true},
                {beam->base.moment, by_moment / 2, false, true},
                {beam->tip.moment, by_moment / 2, false, true},
                {beam->deflection, 1, true, false},
                {beam->velocity, time, true, false},
                {beam->slope, length, true, false},
                {beam->slope_rate, length * time, true, false}};
    double largest = 0;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        double value = beam_largest(beam_scene, rows[i].text, rows[i].along_s, rows[i].in_time);
        largest = fmax(largest, rows[i].factor * value);
    }
    return largest > 0 && isfinite(largest) ? largest : length;
}

beam_numbers beam_numbers_of(const scene *beam_scene)
{
    scene_properties properties = scene_properties_of(beam_scene);
    rod_scales scales = rod_scales_of(beam_scene);
    double length = scales.length, mass = properties.mass_per_length;
    double foundation = beam_largest(beam_scene, beam_scene->beam.foundation, true, false);
    return (beam_numbers){
        .deflection = beam_deflection_scale(beam_scene) / length,
        .shear_ratio = properties.strain_stiffness[1] / scales.force,
        .rotary_inertia = mass > 0 ? properties.rotary_inertia[0] / (mass * length * length) : 0,
        .foundation = foundation * length * length / scales.force};
}

beam_context beam_context_of(const scene *beam_scene, const domain_place *at)
{
    bool dynamic = scene_is_dynamic(beam_scene);
    rod_scales scales = rod_scales_of(beam_scene);
    beam_numbers numbers = beam_numbers_of(beam_scene);
    double ratio = numbers.deflection;
    beam_context beam = {.scene = beam_scene,
                         .tape = at->tape,
                         .unit = {.length = scales.length,
                                  .time = scales.time,
                                  .deflection = ratio * scales.length,
                                  .slope = ratio,
                                  .force = ratio * scales.force,
                                  .moment = ratio * scales.moment},
                         .shear_compliance = 1 / numbers.shear_ratio, /* 0 of infinity */
                         .dynamic = dynamic,
                         .mixed = beam_scene->formulation == SCENE_MIXED,
                         .domain = rod_domain_of(beam_scene),
                         .at = *at,
                         .s = at->x[0],
                         .t = dynamic ? at->x[1] : ad_scalar(at->tape, 0)};
    beam.rotary_inertia = beam.dynamic ? numbers.rotary_inertia : 0;
    return beam;
}

/* ---- formulas -------------------------------------------------------------------------------- */

ad_value beam_formula(const beam_context *beam, const char *text, double unit, ad_value s,
                      ad_value t)
{
    if (!text) {
        return ad_scalar(beam->tape, 0);
    }
    ad_value length = ad_scale(s, beam->unit.length), time = ad_scale(t, beam->unit.time);
    return ad_scale(expression_record(text, length, time), 1 / unit);
}

ad_value beam_line_moment(const beam_context *beam)
{
    return beam_formula(beam, beam->scene->beam.moment, beam->unit.force, beam->s, beam->t);
}

ad_value beam_space_derivative(const beam_context *beam, ad_value y, int order)
{
    return order > 0 ? ad_derivative(y, beam->s, order) : y;
}

ad_value beam_time_derivative(const beam_context *beam, ad_value y, int order)
{
    return beam->dynamic ? ad_derivative(y, beam->t, order) : ad_scalar(beam->tape, 0);
}

beam_initial beam_initial_of(const beam_context *beam)
{
    const scene_beam *given = &beam->scene->beam;
    const beam_units *unit = &beam->unit;
    ad_value zero = ad_scalar(beam->tape, 0), s = beam->s;
    beam_initial initial = {
        .deflection = beam_formula(beam, given->deflection, unit->deflection, s, zero),
        .velocity = beam_formula(beam, given->velocity, unit->deflection / unit->time, s, zero)};
    initial.slope = given->slope ? beam_formula(beam, given->slope, unit->slope, s, zero)
                                 : beam_space_derivative(beam, initial.deflection, 1);
    initial.slope_rate =
        given->slope_rate ? beam_formula(beam, given->slope_rate, unit->slope / unit->time, s, zero)
                          : beam_space_derivative(beam, initial.velocity, 1);
    return initial;
}

/* At s = 0 the outside pulls the other way. */
beam_end beam_end_of(const beam_context *beam, int end)
{
    const scene_end_type type = end ? beam->scene->end.type : beam->scene->start.type;
    const scene_beam_load *load = end ? &beam->scene->beam.tip : &beam->scene->beam.base;
    double sign = end ? 1 : -1;
    ad_value zero = ad_scalar(beam->tape, 0), at = ad_scalar(beam->tape, end);
    return (beam_end){
        .holds_deflection = scene_end_holds_position(type),
        .holds_slope = scene_end_holds_rotation(type),
        .deflection = zero,
        .slope = zero,
        .shear = beam_formula(beam, load->force, sign * beam->unit.force, at, beam->t),
        .moment = beam_formula(beam, load->moment, sign * beam->unit.moment, at, beam->t)};
}

/* ---- terms, for people ----------------------------------------------------------------------- */

static const char *beam_given(const char *text)
{
    double number = 0;
    bool zero = !text || (expression_is_number(text, &number) && number == 0);
    return zero ? "not given" : NULL;
}

static const char *beam_load_reason(scene_end_type type, const scene_beam_load *load)
{
    bool zero = beam_given(load->force) && beam_given(load->moment);
    return type != SCENE_LOADED ? "the end is not loaded" : zero ? "zero" : NULL;
}

int beam_terms(const scene *beam_scene, rod_term *terms)
{
    const scene_beam *beam = &beam_scene->beam;
    scene_properties properties = scene_properties_of(beam_scene);
    const char *still = scene_is_dynamic(beam_scene) ? NULL : "static scene";
    const char *rigid = isinf(properties.strain_stiffness[1]) ? "infinite stiffness" : NULL;
    const char *pointlike = properties.rotary_inertia[0] == 0 ? "rho I = 0" : NULL;
    const char *undamped = beam_scene->loads.drag == 0 ? "not given" : NULL;
    const rod_term rows[] = {
        {"bending", true, NULL},
        {"shear", !rigid, rigid},
        {"translational inertia", !still, still},
        {"rotary inertia", !still && !pointlike, still ? still : pointlike},
        {"drag", !still && !undamped, still ? still : undamped},
        {"elastic foundation", true, beam_given(beam->foundation)},
        {"distributed force", true, beam_given(beam->force)},
        {"distributed moment", true, beam_given(beam->moment)},
        {"base load", true, beam_load_reason(beam_scene->start.type, &beam->base)},
        {"tip load", true, beam_load_reason(beam_scene->end.type, &beam->tip)}};
    enum { COUNT = sizeof rows / sizeof *rows };
    for (int i = 0; i < COUNT; i++) {
        terms[i] = rows[i];
        terms[i].present = rows[i].reason == NULL;
    }
    return COUNT;
}
