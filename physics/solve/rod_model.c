#include "physics/solve/rod_model.h"

#include "physics/expression.h"
#include "physics/solve/formula.h"

#include <math.h>
#include <stdlib.h>

typedef struct solve_functions {
    ad_pool *pool;
    formula *rest, *load, *ends[2], *initial;
} solve_functions;

/* Rows of a formula are the doubles of the struct it fills, in their order. */

typedef struct recording {
    const scene *scene;
    rod_scales scales;
    ad_value s, t; /* inputs */
} recording;

/* ---- recording ----------------------------------------------------------------------------- */

/* `count` texts times factor; `fallback` [count], dimensionless, for those not given (NULL: 0). */
static ad_value record_texts(const recording *rec, int count, const char *const *texts,
                             const double *fallback, double factor)
{
    ad_value s = ad_scale(rec->s, rec->scales.length), t = ad_scale(rec->t, rec->scales.time);
    ad_value parts[4];
    for (int i = 0; i < count; i++) {
        parts[i] = texts[i] ? ad_scale(expression_record(texts[i], s, t), factor)
                            : ad_scalar(s.tape, fallback ? fallback[i] : 0);
    }
    return ad_stack(count, parts);
}

static ad_value record_rest(const recording *rec)
{
    static const double straight[3] = {0, 0, 1};
    const scene_rod *rod = &rec->scene->rod;
    const ad_value parts[3] = {record_texts(rec, 3, rod->rest_strain, straight, 1),
                               record_texts(rec, 3, rod->rest_curvature, NULL, rec->scales.length),
                               record_texts(rec, 3, rod->imperfection, NULL, rec->scales.length)};
    return ad_stack(3, parts);
}

static ad_value record_load(const recording *rec)
{
    const scene_loads *loads = &rec->scene->loads;
    const rod_scales *scale = &rec->scales;
    double mass = scene_properties_of(rec->scene).mass_per_length;
    double per_force = scale->length / scale->force, per_moment = scale->length / scale->moment;
    double weight[3];
    for (int i = 0; i < 3; i++) {
        weight[i] = loads->gravity[i] == 0 ? 0 : mass * loads->gravity[i] * per_force;
    }
    bool body = loads->frame == SCENE_FOLLOWER;
    ad_value force = record_texts(rec, 3, loads->force, NULL, per_force);
    ad_value moment = record_texts(rec, 3, loads->moment, NULL, per_moment);
    ad_value zeros = ad_zeros(rec->s.tape, 3);
    ad_value parts[4] = {body ? zeros : force, body ? zeros : moment, body ? force : zeros,
                         body ? moment : zeros};
    parts[0] = ad_add(parts[0], ad_constant(rec->s.tape, 3, weight));
    if (scene_is_manufactured(rec->scene)) {
        rod_load exact = rod_manufactured_load(rec->scene, rec->s, rec->t);
        parts[0] = ad_add(parts[0], exact.force);
        parts[1] = ad_add(parts[1], exact.moment);
    }
    return ad_stack(4, parts);
}

/* 2 vec(q* dq) */
static ad_value record_rate(ad_value rotation, ad_value derivative)
{
    ad_value product = ad_quaternion_multiply(ad_quaternion_conjugate(rotation), derivative);
    return ad_scale(ad_slice(product, 1, 3), 2);
}

static ad_value record_end(const recording *rec, int end)
{
    static const double upright[4] = {1, 0, 0, 0};
    const scene_end *given = end ? &rec->scene->end : &rec->scene->start;
    const scene_load *load = end ? &rec->scene->loads.tip : &rec->scene->loads.base;
    const rod_scales *scale = &rec->scales;
    double sign = end ? 1 : -1; /* at s = 0 the outside exerts -N and -M */
    rod_state exact;
    if (scene_is_manufactured(rec->scene)) {
        exact = rod_manufactured(rec->scene, rec->s, rec->t);
    } else {
        ad_value q = record_texts(rec, 4, given->rotation, upright, 1);
        exact = (rod_state){record_texts(rec, 3, given->position, NULL, 1 / scale->length),
                            ad_normalize(q),
                            record_texts(rec, 3, load->force, NULL, sign / scale->force),
                            record_texts(rec, 3, load->moment, NULL, sign / scale->moment)};
    }
    ad_value r = exact.position, q = exact.rotation;
    const ad_value parts[8] = {r,
                               q,
                               ad_derivative(r, rec->t, 1),
                               record_rate(q, ad_derivative(q, rec->t, 1)),
                               ad_derivative(r, rec->t, 2),
                               record_rate(q, ad_derivative(q, rec->t, 2)),
                               exact.force,
                               exact.moment};
    return ad_stack(8, parts);
}

/* The lift of the ansatz whose ends and initial state are soft is the unstressed shape. */
static rod_state record_unstressed(const recording *rec)
{
    scene bare = *rec->scene;
    bare.duration = 0;
    bare.windows = 1;
    bare.formulation = SCENE_MIXED;
    bare.boundary_enforcement = bare.initial_enforcement = SCENE_SOFT;
    ad_value zeros = ad_zeros(rec->s.tape, rod_network_outputs(&bare));
    return rod_ansatz(&bare, NULL, zeros, rec->s, ad_scalar(rec->s.tape, 0));
}

static ad_value record_initial(const recording *rec)
{
    const scene_initial *given = &rec->scene->initial;
    const rod_scales *scale = &rec->scales;
    if (scene_is_manufactured(rec->scene)) {
        rod_state exact = rod_manufactured(rec->scene, rec->s, rec->t);
        ad_value turning = ad_derivative(exact.rotation, rec->t, 1);
        const ad_value parts[4] = {exact.position, exact.rotation,
                                   ad_derivative(exact.position, rec->t, 1),
                                   record_rate(exact.rotation, turning)};
        return ad_stack(4, parts);
    }
    rod_state shape = {0};
    if (!given->position[0] || !given->rotation[0]) {
        shape = record_unstressed(rec);
    }
    if (given->position[0]) {
        shape.position = record_texts(rec, 3, given->position, NULL, 1 / scale->length);
    }
    if (given->rotation[0]) {
        shape.rotation = ad_normalize(record_texts(rec, 4, given->rotation, NULL, 1));
    }
    const ad_value parts[4] = {
        shape.position, shape.rotation,
        record_texts(rec, 3, given->velocity, NULL, scale->time / scale->length),
        record_texts(rec, 3, given->angular_velocity, NULL, scale->time)};
    return ad_stack(4, parts);
}

/* ---- compiling ----------------------------------------------------------------------------- */

static ad_status record(solve_rod *rod, ad_error *error)
{
    solve_functions *f = rod->formula;
    ad_tape *tape = ad_tape_create();
    if (!tape) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a tape");
    }
    recording rec = {.scene = &rod->scene, .scales = rod->scales};
    rec.s = ad_input(tape, "s", 1);
    rec.t = ad_input(tape, "t", 1);
    ad_value load = record_load(&rec);
    rod->has_body_load = !ad_is_constant(ad_slice(load, 6, 6), 0);
    const ad_value values[5] = {record_rest(&rec), load, record_end(&rec, 0), record_end(&rec, 1),
                                record_initial(&rec)};
    formula **to[5] = {&f->rest, &f->load, &f->ends[0], &f->ends[1], &f->initial};
    ad_status status = ad_tape_status(tape, error);
    for (int i = 0; status == AD_OK && i < 5; i++) {
        status = formula_create(values[i], f->pool, to[i], error);
    }
    ad_tape_free(tape);
    return status;
}

static double compliance(double stiffness)
{
    return isfinite(stiffness) ? 1 / stiffness : 0;
}

static void set_coefficients(solve_rod *rod)
{
    const scene *given = &rod->scene;
    const rod_scales *scale = &rod->scales;
    scene_properties properties = scene_properties_of(given);
    double rate = rod->dynamic ? 1 / scale->time : 0, bending = scale->moment * scale->length;
    double inertia_scale = scale->force / (rate * rate);
    for (int i = 0; i < 3; i++) {
        rod->strain_stiffness[i] = properties.strain_stiffness[i] / scale->force;
        rod->curvature_stiffness[i] = properties.curvature_stiffness[i] / bending;
        rod->strain_compliance[i] = compliance(rod->strain_stiffness[i]);
        rod->curvature_compliance[i] = compliance(rod->curvature_stiffness[i]);
        rod->strain_damping[i] = given->rod.strain_damping[i] * rate / scale->force;
        rod->curvature_damping[i] = given->rod.curvature_damping[i] * rate / bending;
        rod->rotary_inertia[i] = rod->dynamic ? properties.rotary_inertia[i] / inertia_scale : 0;
    }
    rod->mass = rod->dynamic;
    rod->drag = given->loads.drag * scale->length * scale->length * rate / scale->force;
}

static solve_end end_of(const scene *given, int end)
{
    scene_end_type type = end ? given->end.type : given->start.type;
    const scene_load *load = end ? &given->loads.tip : &given->loads.base;
    bool follows = type == SCENE_LOADED && load->frame == SCENE_FOLLOWER;
    return (solve_end){.holds_position = scene_end_holds_position(type),
                       .holds_rotation = scene_end_holds_rotation(type),
                       .force_is_body = follows,
                       .moment_is_body = follows || scene_is_manufactured(given)};
}

ad_status solve_rod_create(const scene *rod_scene, solve_rod **result, ad_error *error)
{
    *result = NULL;
    solve_rod *rod = calloc(1, sizeof *rod);
    solve_functions *f = calloc(1, sizeof *f);
    ad_pool *pool = ad_pool_create(1);
    if (!rod || !f || !pool) {
        free(rod);
        free(f);
        ad_pool_free(pool);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a rod");
    }
    f->pool = pool;
    *rod = (solve_rod){.scene = *rod_scene,
                       .scales = rod_scales_of(rod_scene),
                       .dynamic = scene_is_dynamic(rod_scene),
                       .ends = {end_of(rod_scene, 0), end_of(rod_scene, 1)},
                       .formula = f};
    rod->scene.motion = SCENE_SPATIAL; /* everything in the frame of the world */
    rod->duration = rod->dynamic ? rod_scene->duration / rod->scales.time : 0;
    set_coefficients(rod);
    ad_status status = record(rod, error);
    if (status != AD_OK) {
        solve_rod_free(rod);
        return status;
    }
    *result = rod;
    return AD_OK;
}

void solve_rod_free(solve_rod *rod)
{
    if (rod) {
        solve_functions *f = rod->formula;
        formula *all[5] = {f->rest, f->load, f->ends[0], f->ends[1], f->initial};
        for (int i = 0; i < 5; i++) {
            formula_free(all[i]);
        }
        ad_pool_free(f->pool);
        free(f);
        free(rod);
    }
}

/* ---- evaluating ---------------------------------------------------------------------------- */

ad_status solve_rod_rest(const solve_rod *rod, size_t n, const double *s, solve_rest *out,
                         ad_error *error)
{
    return formula_evaluate(rod->formula->rest, n, s, 0, (double *)out, error);
}

ad_status solve_rod_load(const solve_rod *rod, size_t n, const double *s, double t, solve_load *out,
                         ad_error *error)
{
    return formula_evaluate(rod->formula->load, n, s, t, (double *)out, error);
}

ad_status solve_rod_loads(const solve_rod *rod, size_t n, const double *s, const double *t,
                          solve_load *out, ad_error *error)
{
    return formula_evaluate_at(rod->formula->load, n, s, t, (double *)out, error);
}

ad_status solve_rod_end(const solve_rod *rod, int end, double t, solve_end_state *out,
                        ad_error *error)
{
    double s = end;
    return formula_evaluate(rod->formula->ends[end], 1, &s, t, (double *)out, error);
}

ad_status solve_rod_ends(const solve_rod *rod, int end, size_t n, const double *s, const double *t,
                         solve_end_state *out, ad_error *error)
{
    return formula_evaluate_at(rod->formula->ends[end], n, s, t, (double *)out, error);
}

/* In such a scene the formula of either end is the solution. */
ad_status solve_rod_manufactured(const solve_rod *rod, size_t n, const double *s, double t,
                                 solve_end_state *out, ad_error *error)
{
    return formula_evaluate(rod->formula->ends[0], n, s, t, (double *)out, error);
}

ad_status solve_rod_initial(const solve_rod *rod, size_t n, const double *s, solve_initial *out,
                            ad_error *error)
{
    return formula_evaluate(rod->formula->initial, n, s, 0, (double *)out, error);
}
