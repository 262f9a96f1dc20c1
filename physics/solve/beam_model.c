#include "physics/solve/beam_model.h"

#include "physics/beam_internal.h"
#include "physics/solve/formula.h"

#include <stdlib.h>

enum { FORMULAS = 4 };

typedef struct beam_functions {
    ad_pool *pool;
    union {
        struct {
            formula *sections, *load, *ends, *initial;
        };
        formula *all[FORMULAS];
    };
} beam_functions;

/* ---- recording ------------------------------------------------------------------------------- */

static ad_value record_sections(const beam_context *beam)
{
    ad_value moves = ad_scalar(beam->tape, beam->dynamic);
    return ad_stack(6, (ad_value[]){beam->softness, beam->shear_compliance,
                                    ad_mul(moves, beam->mass), beam->inertia,
                                    ad_mul(moves, beam_drag(beam)), beam_foundation(beam)});
}

static ad_value record_load(const beam_context *beam)
{
    double line_force = beam->unit.force / beam->unit.length;
    ad_value force = beam_formula(beam, beam->scene->beam.force, line_force, beam->s, beam->t);
    return ad_stack(2, (ad_value[]){force, beam_line_moment(beam)});
}

/* Ends that hold are held at 0. */
static ad_value record_ends(const beam_context *beam, solve_beam *to)
{
    ad_value parts[4];
    for (int i = 0; i < 2; i++) {
        beam_end end = beam_end_of(beam, i);
        to->ends[i].holds_deflection = end.holds_deflection;
        to->ends[i].holds_slope = end.holds_slope;
        parts[2 * i] = end.holds_deflection ? end.deflection : end.shear;
        parts[2 * i + 1] = end.holds_slope ? end.slope : end.moment;
    }
    return ad_stack(4, parts);
}

static ad_value record_initial(const beam_context *beam)
{
    beam_initial initial = beam_initial_of(beam);
    return ad_stack(
        4, (ad_value[]){initial.deflection, initial.slope, initial.velocity, initial.slope_rate});
}

static ad_status record(solve_beam *beam, const scene *beam_scene, ad_error *error)
{
    beam_functions *f = beam->formula;
    ad_tape *tape = ad_tape_create();
    if (!tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
    const domain_place at = rod_place(beam_scene, s, t);
    const beam_context context = beam_context_of(beam_scene, &at);
    beam->deflection = context.unit.deflection;
    beam->turns = context.rotary_inertia > 0;
    const ad_value values[FORMULAS] = {record_sections(&context), record_load(&context),
                                       record_ends(&context, beam), record_initial(&context)};
    ad_status status = ad_tape_status(tape, error);
    for (int i = 0; status == AD_OK && i < FORMULAS; i++) {
        status = solve_formula_create(values[i], 0, f->pool, &f->all[i], error);
    }
    ad_tape_free(tape);
    return status;
}

/* ---- making and freeing ---------------------------------------------------------------------- */

ad_status solve_beam_create(const scene *beam_scene, solve_beam **result, ad_error *error)
{
    *result = NULL;
    solve_beam *beam = calloc(1, sizeof *beam);
    beam_functions *f = calloc(1, sizeof *f);
    ad_pool *pool = ad_pool_create(1);
    if (!beam || !f || !pool) {
        free(beam);
        free(f);
        ad_pool_free(pool);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a beam");
    }
    f->pool = pool;
    *beam = (solve_beam){
        .scales = rod_scales_of(beam_scene), .dynamic = scene_is_dynamic(beam_scene), .formula = f};
    beam->duration = beam->dynamic ? scene_duration(beam_scene) / beam->scales.time : 0;
    ad_status status = record(beam, beam_scene, error);
    if (status != AD_OK) {
        solve_beam_free(beam);
        return status;
    }
    *result = beam;
    return AD_OK;
}

void solve_beam_free(solve_beam *beam)
{
    if (beam) {
        beam_functions *f = beam->formula;
        for (int i = 0; i < FORMULAS; i++) {
            solve_formula_free(f->all[i]);
        }
        ad_pool_free(f->pool);
        free(f);
        free(beam);
    }
}

/* ---- evaluating ------------------------------------------------------------------------------ */

ad_status solve_beam_load(const solve_beam *beam, size_t n, const double *s, double t,
                          beam_load *out, ad_error *error)
{
    return solve_formula_evaluate(beam->formula->load, n, s, t, (double *)out, error);
}

ad_status solve_beam_sections(const solve_beam *beam, size_t n, const double *s, beam_section *out,
                              ad_error *error)
{
    return solve_formula_evaluate(beam->formula->sections, n, s, 0, (double *)out, error);
}

ad_status solve_beam_initial(const solve_beam *beam, size_t n, const double *s,
                             beam_initial_state *out, ad_error *error)
{
    return solve_formula_evaluate(beam->formula->initial, n, s, 0, (double *)out, error);
}

ad_status solve_beam_ends(const solve_beam *beam, double t, double values[4], ad_error *error)
{
    double s = 0; /* of t alone */
    return solve_formula_evaluate(beam->formula->ends, 1, &s, t, values, error);
}
