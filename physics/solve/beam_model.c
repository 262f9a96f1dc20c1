#include "physics/solve/beam_model.h"

#include "physics/beam/beam_internal.h"
#include "physics/local/formula.h"
#include "physics/local/mesh.h"

#include <stdlib.h>
#include <string.h>

enum { FORMULAS = 4 };

typedef struct beam_functions {
    ad_pool *pool;
    union {
        struct {
            formula *sections, *load, *ends, *initial;
        };
        formula *all[FORMULAS];
    };
    formula *jumps; /* NULL: none */
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

static void place_jumps(const beam_context *beam, solve_beam *to)
{
    const scene *given = beam->scene;
    double s[BEAM_JUMPS_MAX];
    int count = 0;
    for (int i = 0; i < given->beam.point_count; i++) {
        s[count++] = beam_point_of(beam, i, beam->t).s;
    }
    for (int i = 0; i < given->body_count; i++) {
        s[count++] = beam_body_of(beam, i).s;
    }
    for (int i = 0; i < given->spring_count; i++) {
        s[count++] = beam_spring_of(beam, i).s;
    }
    to->jump_count = solve_mesh_places(count, s);
    for (int i = 0; i < to->jump_count; i++) {
        to->jumps[i].s = s[i];
    }
}

static int jump_at(const solve_beam *beam, double s)
{
    int found = 0;
    while (found + 1 < beam->jump_count && beam->jumps[found].s < s - SOLVE_SAME_PLACE) {
        found++;
    }
    return found;
}

/* Rows of beam_load, one after the other. */
static ad_value record_jumps(const beam_context *beam, solve_beam *to)
{
    ad_value loads[2 * BEAM_JUMPS_MAX];
    place_jumps(beam, to);
    for (int i = 0; i < 2 * to->jump_count; i++) {
        loads[i] = ad_scalar(beam->tape, 0);
    }
    for (int i = 0; i < beam->scene->beam.point_count; i++) {
        beam_point_data point = beam_point_of(beam, i, beam->t);
        ad_value *load = loads + 2 * jump_at(to, point.s);
        load[0] = ad_add(load[0], point.force);
        load[1] = ad_add(load[1], point.moment);
    }
    for (int i = 0; i < beam->scene->body_count; i++) {
        beam_body_data body = beam_body_of(beam, i);
        beam_jump *jump = &to->jumps[jump_at(to, body.s)];
        jump->mass += body.mass;
        jump->inertia += body.inertia;
    }
    for (int i = 0; i < beam->scene->spring_count; i++) {
        beam_spring_data spring = beam_spring_of(beam, i);
        int place = jump_at(to, spring.s);
        ad_value pull = ad_scalar(beam->tape, spring.stiffness * spring.anchor);
        to->jumps[place].stiffness += spring.stiffness;
        to->jumps[place].turning += spring.turning;
        loads[2 * place] = ad_add(loads[2 * place], pull);
    }
    return to->jump_count > 0 ? ad_stack(2 * to->jump_count, loads) : ad_scalar(beam->tape, 0);
}

static ad_status record(solve_beam *beam, const scene *beam_scene, ad_error *error)
{
    beam_functions *f = beam->formula;
    ad_tape *tape = ad_tape_create();
    ad_value s = ad_input(tape, "s", 1), t = ad_input(tape, "t", 1);
    const domain_place at = rod_place(beam_scene, s, t);
    const beam_context context = beam_context_of(beam_scene, &at);
    beam->deflection = context.unit.deflection;
    beam->turns = context.rotary_inertia > 0;
    const ad_value values[FORMULAS] = {record_sections(&context), record_load(&context),
                                       record_ends(&context, beam), record_initial(&context)};
    const ad_value jumps = record_jumps(&context, beam);
    ad_status status = ad_tape_status(tape, error);
    for (int i = 0; status == AD_OK && i < FORMULAS; i++) {
        status = solve_formula_create(values[i], 0, f->pool, &f->all[i], error);
    }
    if (status == AD_OK && beam->jump_count > 0) {
        status = solve_formula_create(jumps, 0, f->pool, &f->jumps, error);
    }
    ad_tape_free(tape);
    return status;
}

/* ---- what is given along it ------------------------------------------------------------------ */

enum {
    SECTION_ROWS = sizeof(beam_section) / sizeof(double),
    LOAD_ROWS = sizeof(beam_load) / sizeof(double)
};

static ad_status given_at(const void *context, size_t n, const double *s, double *out,
                          ad_error *error)
{
    const solve_beam *beam = context;
    beam_section sections[QUADRATURE_BATCH];
    beam_load loads[QUADRATURE_BATCH];
    ad_status status = solve_beam_sections(beam, n, s, sections, error);
    status = status == AD_OK ? solve_beam_load(beam, n, s, 0, loads, error) : status;
    for (size_t i = 0; i < n && status == AD_OK; i++, out += SECTION_ROWS + LOAD_ROWS) {
        memcpy(out, &sections[i], sizeof sections[i]);
        memcpy(out + SECTION_ROWS, &loads[i], sizeof loads[i]);
    }
    return status;
}

solve_given solve_beam_given(const solve_beam *beam)
{
    return (solve_given){
        .rows = beam->dynamic ? 0 : SECTION_ROWS + LOAD_ROWS, .at = given_at, .context = beam};
}

static ad_status add_quadrature(solve_beam *beam, const scene *beam_scene, ad_error *error)
{
    const solve_given given = solve_beam_given(beam);
    double places[BEAM_JUMPS_MAX];
    for (int i = 0; i < beam->jump_count; i++) {
        places[i] = beam->jumps[i].s;
    }
    return solve_quadrature_create(beam_scene, &given, beam->jump_count, places, &beam->quadrature,
                                   error);
}

static ad_status add_instants(solve_beam *beam, const scene *beam_scene, ad_error *error)
{
    ad_status status = scene_divisions_of(beam_scene, "t", BREAKS_MAX, &beam->instants, error);
    for (int i = 0; i < beam->instants.count && status == AD_OK; i++) {
        beam->instants.place[i] /= beam->scales.time;
    }
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
    status = status == AD_OK ? add_quadrature(beam, beam_scene, error) : status;
    status = status == AD_OK ? add_instants(beam, beam_scene, error) : status;
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
        solve_formula_free(f->jumps);
        ad_pool_free(f->pool);
        solve_quadrature_free(beam->quadrature);
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

ad_status solve_beam_jump_loads(const solve_beam *beam, double t, beam_load *out, ad_error *error)
{
    double s = 0; /* of t alone */
    return beam->jump_count > 0
               ? solve_formula_evaluate(beam->formula->jumps, 1, &s, t, (double *)out, error)
               : AD_OK;
}

ad_status solve_beam_ends(const solve_beam *beam, double t, double values[4], ad_error *error)
{
    double s = 0; /* of t alone */
    return solve_formula_evaluate(beam->formula->ends, 1, &s, t, values, error);
}

void solve_beam_units(const solve_beam *beam, double *units)
{
    const rod_scales *scale = &beam->scales;
    double slope = beam->deflection / scale->length;
    const double of[] = {beam->deflection,
                         slope,
                         slope * scale->force,
                         slope * scale->moment,
                         beam->deflection / scale->time,
                         slope / scale->time};
    memcpy(units, of, sizeof of);
}
