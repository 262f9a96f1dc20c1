#include "physics/solve/beam_model.h"

#include "physics/beam.h"
#include "physics/expression.h"
#include "physics/solve/formula.h"

#include <stdlib.h>

typedef struct beam_functions {
    ad_pool *pool;
    formula *load, *foundation, *ends, *initial;
} beam_functions;

typedef struct recording {
    const scene_beam *given;
    const solve_beam *beam;
    ad_value s, t; /* inputs */
} recording;

/* ---- recording ------------------------------------------------------------------------------- */

/* A text of SI units, times factor; 0 where not given. */
static ad_value record_text(const recording *rec, const char *text, double factor)
{
    const rod_scales *scale = &rec->beam->scales;
    ad_value s = ad_scale(rec->s, scale->length), t = ad_scale(rec->t, scale->time);
    return text ? ad_scale(expression_record(text, s, t), factor) : ad_scalar(s.tape, 0);
}

static double force_unit(const solve_beam *beam)
{
    return beam->scales.force * beam->deflection / beam->scales.length;
}

static ad_value record_load(const recording *rec)
{
    double force = force_unit(rec->beam), length = rec->beam->scales.length;
    return ad_stack(2, (ad_value[]){record_text(rec, rec->given->force, length / force),
                                    record_text(rec, rec->given->moment, 1 / force)});
}

static ad_value record_foundation(const recording *rec)
{
    const rod_scales *scale = &rec->beam->scales;
    return record_text(rec, rec->given->foundation, scale->length * scale->length / scale->force);
}

/* Ends that hold are held at 0; at s = 0 the outside exerts -V and -M. */
static ad_value record_ends(const recording *rec)
{
    double force = force_unit(rec->beam), moment = force * rec->beam->scales.length;
    const scene_beam_load *base = &rec->given->base, *tip = &rec->given->tip;
    return ad_stack(4, (ad_value[]){record_text(rec, base->force, -1 / force),
                                    record_text(rec, base->moment, -1 / moment),
                                    record_text(rec, tip->force, 1 / force),
                                    record_text(rec, tip->moment, 1 / moment)});
}

/* Slopes that are not given are those of the axis. */
static ad_value record_initial(const recording *rec)
{
    const scene_beam *given = rec->given;
    double length = rec->beam->scales.length, time = rec->beam->scales.time;
    double by = 1 / rec->beam->deflection;
    ad_value deflection = record_text(rec, given->deflection, by);
    ad_value velocity = record_text(rec, given->velocity, by * time);
    ad_value slope = given->slope ? record_text(rec, given->slope, by * length)
                                  : ad_derivative(deflection, rec->s, 1);
    ad_value slope_rate = given->slope_rate
                              ? record_text(rec, given->slope_rate, by * length * time)
                              : ad_derivative(velocity, rec->s, 1);
    return ad_stack(4, (ad_value[]){deflection, slope, velocity, slope_rate});
}

static ad_status record(solve_beam *beam, const scene *beam_scene, ad_error *error)
{
    beam_functions *f = beam->formula;
    ad_tape *tape = ad_tape_create();
    if (!tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    recording rec = {.given = &beam_scene->beam, .beam = beam};
    rec.s = ad_input(tape, "s", 1);
    rec.t = ad_input(tape, "t", 1);
    const ad_value values[4] = {record_load(&rec), record_foundation(&rec), record_ends(&rec),
                                record_initial(&rec)};
    formula **to[4] = {&f->load, &f->foundation, &f->ends, &f->initial};
    ad_status status = ad_tape_status(tape, error);
    for (int i = 0; status == AD_OK && i < 4; i++) {
        status = formula_create(values[i], f->pool, to[i], error);
    }
    ad_tape_free(tape);
    return status;
}

/* ---- making and freeing ---------------------------------------------------------------------- */

static void set_coefficients(solve_beam *beam, const scene *given)
{
    const rod_scales *scale = &beam->scales;
    scene_properties properties = scene_properties_of(given);
    double square = scale->length * scale->length;
    beam->dynamic = scene_is_dynamic(given);
    beam->shear_compliance = scale->force / properties.strain_stiffness[1]; /* 0 of infinity */
    for (int end = 0; end < 2; end++) {
        scene_end_type type = end ? given->end.type : given->start.type;
        beam->ends[end].holds_deflection = scene_end_holds_position(type);
        beam->ends[end].holds_slope = scene_end_holds_rotation(type);
    }
    if (beam->dynamic) {
        beam->duration = given->duration / scale->time;
        beam->rotary_inertia = properties.rotary_inertia[0] / (properties.mass_per_length * square);
        beam->drag = given->loads.drag * square / (scale->force * scale->time);
    }
}

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
    *beam = (solve_beam){.scales = rod_scales_of(beam_scene),
                         .deflection = beam_deflection_scale(beam_scene),
                         .formula = f};
    set_coefficients(beam, beam_scene);
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
        formula_free(f->load);
        formula_free(f->foundation);
        formula_free(f->ends);
        formula_free(f->initial);
        ad_pool_free(f->pool);
        free(f);
        free(beam);
    }
}

/* ---- evaluating ------------------------------------------------------------------------------ */

ad_status solve_beam_load(const solve_beam *beam, size_t n, const double *s, double t,
                          beam_load *out, ad_error *error)
{
    return formula_evaluate(beam->formula->load, n, s, t, (double *)out, error);
}

ad_status solve_beam_foundation(const solve_beam *beam, size_t n, const double *s, double *out,
                                ad_error *error)
{
    return formula_evaluate(beam->formula->foundation, n, s, 0, out, error);
}

ad_status solve_beam_initial(const solve_beam *beam, size_t n, const double *s,
                             beam_initial_state *out, ad_error *error)
{
    return formula_evaluate(beam->formula->initial, n, s, 0, (double *)out, error);
}

ad_status solve_beam_ends(const solve_beam *beam, double t, double values[4], ad_error *error)
{
    double s = 0; /* of t alone */
    return formula_evaluate(beam->formula->ends, 1, &s, t, values, error);
}
