/* Scales, numbers, formulas and ends of a beam. */
#include "physics/beam/beam_internal.h"

#include <math.h>

enum { BEAM_SPACE_SAMPLES = 8, BEAM_TIME_SAMPLES = 16 }; /* a scale does not need the peak */

/* ---- scales ---------------------------------------------------------------------------------- */

/* Largest absolute value over samples of what varies; 0 of what is not given. */
static double beam_largest(const scene *beam_scene, quantity q, bool along_s, bool in_time)
{
    int space = along_s ? BEAM_SPACE_SAMPLES : 0;
    int time = in_time && scene_is_dynamic(beam_scene) ? BEAM_TIME_SAMPLES : 0;
    double largest = 0;
    for (int i = 0; q.is_given && i <= space; i++) {
        for (int j = 0; j <= time; j++) {
            double s = scene_length(beam_scene) * i / BEAM_SPACE_SAMPLES;
            double t = scene_duration(beam_scene) * j / BEAM_TIME_SAMPLES;
            largest = fmax(largest, quantity_largest(q, s, t));
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
        quantity value;
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
        double value = beam_largest(beam_scene, rows[i].value, rows[i].along_s, rows[i].in_time);
        largest = fmax(largest, rows[i].factor * value);
    }
    for (int i = 0; i < beam->point_count; i++) {
        const scene_beam_load *load = &beam->points[i].load;
        largest = fmax(largest, by_force / 3 * beam_largest(beam_scene, load->force, false, true));
        largest =
            fmax(largest, by_moment / 2 * beam_largest(beam_scene, load->moment, false, true));
    }
    for (int i = 0; i < beam_scene->spring_count; i++) {
        largest =
            fmax(largest, beam_largest(beam_scene, beam_scene->springs[i].anchor[1], false, false));
    }
    return largest > 0 && isfinite(largest) ? largest : length;
}

beam_numbers beam_numbers_of(const scene *beam_scene)
{
    scene_properties properties = scene_properties_of(beam_scene);
    rod_scales scales = rod_scales_of(beam_scene);
    double length = scales.length, mass = scene_mean(beam_scene, properties.mass_per_length);
    double inertia = scene_mean(beam_scene, properties.rotary_inertia[0]);
    double foundation = beam_largest(beam_scene, beam_scene->beam.foundation, true, false);
    return (beam_numbers){.deflection = beam_deflection_scale(beam_scene) / length,
                          .shear_ratio =
                              scene_mean_stiffness(beam_scene, properties.strain_stiffness[1]) /
                              scales.force,
                          .rotary_inertia = mass > 0 ? inertia / (mass * length * length) : 0,
                          .foundation = foundation * length * length / scales.force};
}

/* A quantity of s in `unit`; the number `otherwise` where it is the same all along. */
static ad_value beam_along(const beam_context *beam, quantity q, double unit, double otherwise)
{
    return quantity_is_number(q, NULL) ? ad_scalar(beam->tape, otherwise)
                                       : beam_formula(beam, q, unit, beam->s, beam->t);
}

static void beam_coefficients(beam_context *beam, const beam_numbers *numbers)
{
    const scene *given = beam->scene;
    scene_properties properties = scene_properties_of(given);
    rod_scales scales = rod_scales_of(given);
    double mass = scene_mean(given, properties.mass_per_length);
    quantity shear = quantity_divide(quantity_number(scales.force), properties.strain_stiffness[1]);
    beam->bending =
        beam_along(beam, properties.curvature_stiffness[0], scales.moment * scales.length, 1);
    beam->softness = quantity_is_number(properties.curvature_stiffness[0], NULL)
                         ? beam->bending
                         : ad_reciprocal(beam->bending);
    beam->shear_compliance = beam_along(beam, shear, 1, 1 / numbers->shear_ratio);
    beam->mass = beam_along(beam, properties.mass_per_length, mass, 1);
    beam->inertia = beam_along(beam, properties.rotary_inertia[0],
                               mass * scales.length * scales.length, beam->rotary_inertia);
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
                         .dynamic = dynamic,
                         .mixed = beam_scene->formulation == SCENE_MIXED,
                         .domain = rod_domain_of(beam_scene),
                         .at = *at,
                         .s = at->x[0],
                         .t = dynamic ? at->x[1] : ad_scalar(at->tape, 0)};
    beam.rotary_inertia = beam.dynamic ? numbers.rotary_inertia : 0;
    beam_coefficients(&beam, &numbers);
    return beam;
}

bool beam_turns(const scene *beam_scene)
{
    return quantity_is_something(scene_properties_of(beam_scene).rotary_inertia[0]);
}

/* ---- formulas -------------------------------------------------------------------------------- */

ad_value beam_formula(const beam_context *beam, quantity q, double unit, ad_value s, ad_value t)
{
    if (!q.is_given) {
        return ad_scalar(beam->tape, 0);
    }
    quantity_binding bindings[2 + SCENE_PARAMETERS_MAX] = {{"s", ad_scale(s, beam->unit.length)},
                                                           {"t", ad_scale(t, beam->unit.time)}};
    int count = 2 + rod_bind(beam->scene, &beam->domain, &beam->at, bindings + 2);
    return ad_scale(quantity_record(q, beam->tape, count, bindings), 1 / unit);
}

ad_value beam_line_moment(const beam_context *beam)
{
    return beam_formula(beam, beam->scene->beam.moment, beam->unit.force, beam->s, beam->t);
}

ad_value beam_foundation(const beam_context *beam)
{
    const beam_units *unit = &beam->unit;
    double line_force = unit->force / unit->length;
    return beam_formula(beam, beam->scene->beam.foundation, line_force / unit->deflection, beam->s,
                        beam->t);
}

ad_value beam_drag(const beam_context *beam)
{
    const beam_units *unit = &beam->unit;
    double line_force = unit->force / unit->length;
    quantity drag = quantity_scale(beam->scene->loads.drag, unit->deflection);
    return beam_formula(beam, drag, line_force * unit->time, beam->s, beam->t);
}

ad_value beam_space_derivative(const beam_context *beam, ad_value y, int order)
{
    return order > 0 ? ad_derivative(y, beam->s, order) : y;
}

/* Leibniz's rule; where EI does not vary one term is left of it. */
ad_value beam_bent(const beam_context *beam, ad_value w, int order)
{
    static const int binomial[3][3] = {{1}, {1, 1}, {1, 2, 1}};
    ad_value sum = ad_scalar(beam->tape, 0);
    for (int i = order; i >= 0; i--) {
        ad_value stiffness = beam_space_derivative(beam, beam->bending, i);
        if (!ad_is_constant(stiffness, 0)) {
            ad_value bent = beam_space_derivative(beam, w, 2 + order - i);
            sum = ad_add(sum, ad_scale(ad_mul(stiffness, bent), binomial[order][i]));
        }
    }
    return sum;
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
    quantity slope = given->slope;
    if (beam->dynamic && beam->scene->initial.state == SCENE_EQUILIBRIUM) {
        const quantity *settled = beam->scene->initial.settled;
        initial.deflection = beam_formula(beam, settled[0], unit->deflection, s, zero);
        slope = settled[1];
    }
    initial.slope = slope.is_given ? beam_formula(beam, slope, unit->slope, s, zero)
                                   : beam_space_derivative(beam, initial.deflection, 1);
    initial.slope_rate =
        given->slope_rate.is_given
            ? beam_formula(beam, given->slope_rate, unit->slope / unit->time, s, zero)
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
        .holds_deflection = type == SCENE_CLAMPED || type == SCENE_PINNED,
        .holds_slope = scene_end_holds_rotation(type),
        .deflection = zero,
        .slope = zero,
        .shear = beam_formula(beam, load->force, sign * beam->unit.force, at, beam->t),
        .moment = beam_formula(beam, load->moment, sign * beam->unit.moment, at, beam->t)};
}

/* ---- terms, for people ----------------------------------------------------------------------- */

static const char *beam_given(quantity q)
{
    return quantity_is_something(q) ? NULL : "not given";
}

static const char *beam_load_reason(scene_end_type type, const scene_beam_load *load)
{
    bool zero = beam_given(load->force) && beam_given(load->moment);
    return !scene_end_takes_force(type) ? "the end is not loaded" : zero ? "zero" : NULL;
}

int beam_terms(const scene *beam_scene, rod_term *terms)
{
    const scene_beam *beam = &beam_scene->beam;
    scene_properties properties = scene_properties_of(beam_scene);
    const char *still = scene_is_dynamic(beam_scene) ? NULL : "static scene";
    const char *rigid = scene_locks(properties.strain_stiffness[1]) ? "infinite stiffness" : NULL;
    const char *pointlike = quantity_is(properties.rotary_inertia[0], 0) ? "rho I = 0" : NULL;
    const rod_term rows[] = {
        {.name = "bending"},
        {.name = "shear", .reason = rigid},
        {.name = "translational inertia", .reason = still},
        {.name = "rotary inertia", .reason = still ? still : pointlike},
        rod_drag_term(beam_scene),
        {.name = "elastic foundation", .reason = beam_given(beam->foundation)},
        {.name = "distributed force", .reason = beam_given(beam->force)},
        {.name = "distributed moment", .reason = beam_given(beam->moment)},
        {.name = "point loads", .reason = beam->point_count ? NULL : "not given"},
        {.name = "base load", .reason = beam_load_reason(beam_scene->start.type, &beam->base)},
        {.name = "tip load", .reason = beam_load_reason(beam_scene->end.type, &beam->tip)}};
    enum { COUNT = sizeof rows / sizeof *rows };
    for (int i = 0; i < COUNT; i++) {
        terms[i] = rows[i];
        terms[i].present = rows[i].reason == NULL;
    }
    return COUNT;
}
