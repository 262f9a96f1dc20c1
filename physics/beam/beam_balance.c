/* The equations of a beam, its open conditions, and what is observed. */
#include "physics/beam/beam_internal.h"

static ad_value beam_strain_residual(const beam_context *beam, beam_state x)
{
    ad_value slope = beam_space_derivative(beam, x.deflection, 1);
    return ad_sub(ad_sub(slope, x.slope), ad_mul(beam->shear_compliance, x.shear));
}

static ad_value beam_curvature_residual(const beam_context *beam, beam_state x)
{
    ad_value bent = ad_mul(beam->softness, x.moment);
    return ad_sub(beam_space_derivative(beam, x.slope, 1), bent);
}

/* V_s; in the strong form of Euler and Bernoulli by one derivative of fourth order. */
static ad_value beam_shear_slope(const beam_context *beam, beam_state x)
{
    if (beam->mixed || beam->scene->rod.model == SCENE_TIMOSHENKO) {
        return beam_space_derivative(beam, x.shear, 1);
    }
    ad_value turning = beam_space_derivative(beam, beam_line_moment(beam), 1);
    return ad_neg(ad_add(beam_bent(beam, x.deflection, 2), turning));
}

/* V_s + q - k w - c w_t - rhoA w_tt */
static ad_value beam_force_balance(const beam_context *beam, beam_state x)
{
    const scene *given = beam->scene;
    const beam_units *unit = &beam->unit;
    double line_force = unit->force / unit->length;
    ad_value q = beam_formula(beam, given->beam.force, line_force, beam->s, beam->t);
    ad_value drag = ad_mul(beam_drag(beam), beam_time_derivative(beam, x.deflection, 1));
    ad_value resisting = ad_add(ad_mul(beam_foundation(beam), x.deflection), drag);
    ad_value loaded = ad_add(beam_shear_slope(beam, x), ad_sub(q, resisting));
    return ad_sub(loaded, ad_mul(beam->mass, beam_time_derivative(beam, x.deflection, 2)));
}

/* M_s + V + mu - rhoI psi_tt */
static ad_value beam_moment_balance(const beam_context *beam, beam_state x)
{
    ad_value turning = ad_add(x.shear, beam_line_moment(beam));
    ad_value inertia = ad_mul(beam->inertia, beam_time_derivative(beam, x.slope, 2));
    return ad_sub(ad_add(beam_space_derivative(beam, x.moment, 1), turning), inertia);
}

static ad_value beam_end_residual(const beam_context *beam, beam_state x, int at)
{
    beam_end end = beam_end_of(beam, at);
    beam_force_at acting[BEAM_PLACES_MAX];
    int count = beam_forces_at(beam, x.deflection, x.slope, acting);
    for (int i = 0; i < count; i++) { /* the beam begins behind it, and ends before */
        if (at ? acting[i].s >= 1 : acting[i].s <= 0) {
            end.shear = ad_add(end.shear, ad_scale(acting[i].force, at ? 1 : -1));
            end.moment = ad_add(end.moment, ad_scale(acting[i].moment, at ? 1 : -1));
        }
    }
    ad_value along =
        end.holds_deflection ? ad_sub(x.deflection, end.deflection) : ad_sub(x.shear, end.shear);
    ad_value around = end.holds_slope ? ad_sub(x.slope, end.slope) : ad_sub(x.moment, end.moment);
    return ad_stack(2, (ad_value[]){along, around});
}

static ad_value beam_initial_residual(const beam_context *beam, beam_state x)
{
    beam_initial initial = beam_initial_of(beam);
    ad_value rows[4] = {ad_sub(x.deflection, initial.deflection),
                        ad_sub(beam_time_derivative(beam, x.deflection, 1), initial.velocity),
                        ad_sub(x.slope, initial.slope),
                        ad_sub(beam_time_derivative(beam, x.slope, 1), initial.slope_rate)};
    return ad_stack(beam->rotary_inertia > 0 ? 4 : 2, rows);
}

int beam_residual_rows(const scene *beam_scene, rod_residual_kind kind)
{
    bool mixed = beam_scene->formulation == SCENE_MIXED;
    bool soft_ends = beam_scene->boundary_enforcement == SCENE_SOFT;
    bool turns = beam_turns(beam_scene);
    switch (kind) {
    case ROD_STRAIN:
    case ROD_CURVATURE:
        return mixed;
    case ROD_FORCE:
        return 1;
    case ROD_MOMENT:
        return mixed || beam_scene->rod.model == SCENE_TIMOSHENKO;
    case ROD_START:
    case ROD_END:
        return soft_ends ? 2 : 0;
    case ROD_INITIAL:
        return !scene_is_dynamic(beam_scene) || beam_scene->initial_enforcement == SCENE_HARD ? 0
               : turns                                                                        ? 4
                                                                                              : 2;
    case ROD_TENDON:
    case ROD_TWIST:
    case ROD_TORSION:
    case ROD_RESIDUAL_COUNT:
        break;
    }
    return 0;
}

ad_value beam_residual(const scene *beam_scene, rod_residual_kind kind, beam_state state,
                       const domain_place *at)
{
    beam_context beam = beam_context_of(beam_scene, at);
    if (beam_residual_rows(beam_scene, kind) == 0) {
        ad_tape_fail(at->tape, AD_BAD_ARGUMENT, "this scene has no residual '%s'",
                     rod_residual_name(kind));
        return ad_scalar(at->tape, 0);
    }
    switch (kind) {
    case ROD_STRAIN:
        return beam_strain_residual(&beam, state);
    case ROD_CURVATURE:
        return beam_curvature_residual(&beam, state);
    case ROD_FORCE:
        return beam_force_balance(&beam, state);
    case ROD_MOMENT:
        return beam_moment_balance(&beam, state);
    case ROD_START:
    case ROD_END:
        return beam_end_residual(&beam, state, kind == ROD_END);
    default:
        return beam_initial_residual(&beam, state);
    }
}

void beam_observe(const scene *beam_scene, beam_state state, const domain_place *at,
                  ad_value values[BEAM_COLUMNS])
{
    beam_context beam = beam_context_of(beam_scene, at);
    const beam_units *unit = &beam.unit;
    ad_value velocity = beam_time_derivative(&beam, state.deflection, 1);
    ad_value turning = beam_time_derivative(&beam, state.slope, 1);
    values[0] = ad_scale(state.deflection, unit->deflection);
    values[1] = ad_scale(state.slope, unit->slope);
    values[2] = ad_scale(state.shear, unit->force);
    values[3] = ad_scale(state.moment, unit->moment);
    values[4] = ad_scale(velocity, unit->deflection / unit->time);
    values[5] = ad_scale(turning, unit->slope / unit->time);
}
