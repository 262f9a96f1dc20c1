#include "physics/local/rod_model.h"

#include "physics/local/formula.h"
#include "physics/numerics/quaternion.h"
#include "physics/rod/rod_internal.h"
#include "physics/scene/scene_field.h"

#include <stdlib.h>
#include <string.h>

enum { FORMULAS = 5, ENDS = 2 };

/* What ends are given of each parameter: itself and its two rates by t. */
enum { PATH = 3 };

typedef struct solve_functions {
    ad_pool *pool;
    union {
        struct {
            formula *sections, *rest, *ends[2], *initial;
        };
        formula *all[FORMULAS];
    };
    size_t path;        /* rates of parameters that ends are given in motion; else 0 */
    formula *actuators; /* NULL: none */
    formula *along;     /* NULL: none */
    formula *jumps;     /* NULL: none */
    formula *growth;    /* NULL: none */
    formula *feed;      /* NULL: none */
    const scene *open;  /* with open names; NULL: none */
    const solve_parameters *parameters;
    bool changes; /* parts are derivatives of what they are, by each parameter */
    solve_part_kind kinds[SOLVE_PARTS];
} solve_functions;

/* ---- recording ----------------------------------------------------------------------------- */

/* Rows of a formula are the doubles of the struct it fills, in their order. */
#define STACK(...)                                                                                 \
    ad_stack(sizeof((ad_value[]){__VA_ARGS__}) / sizeof(ad_value), (ad_value[]){__VA_ARGS__})

static const double zeros[3] = {0, 0, 0};

static ad_value record_sections(const rod_coefficients *c)
{
    return STACK(c->strain_stiffness, c->curvature_stiffness, c->strain_compliance,
                 c->curvature_compliance, c->strain_damping, c->curvature_damping, c->maxwell,
                 c->mass, c->rotary_inertia, c->added_mass);
}

static ad_value record_rest(const rod_context *rod, const rod_coefficients *c)
{
    const scene_rest rest = scene_rest_of(rod->scene);
    ad_value imperfection =
        rod_quantities(rod, 3, rest.imperfection, zeros, rod->scales.length, rod->s, rod->t);
    return STACK(c->rest_strain, c->rest_curvature, imperfection,
                 rod_time_derivative(rod, c->rest_strain, 1),
                 rod_time_derivative(rod, c->rest_curvature, 1));
}

/* Numbers of all laws along the rod. */
static ad_value record_along(const rod_context *rod, acting *along)
{
    rod_acting laws[ROD_ALONG_MAX];
    ad_value numbers[ROD_ALONG_MAX];
    int count = rod_acting_along(rod, laws);
    if (scene_is_manufactured(rod->scene)) {
        const rod_load exact = rod_manufactured_load(rod->scene, rod->s, rod->t);
        laws[count++] = (rod_acting){.law = LAW_FORCE, .numbers = exact.force};
        laws[count++] = (rod_acting){.law = LAW_MOMENT, .numbers = exact.moment};
    }
    for (int i = 0; i < count; i++) {
        acting_add(along, laws[i].law);
        numbers[i] = laws[i].numbers;
    }
    return count > 0 ? ad_stack(count, numbers) : ad_zeros(rod->tape, 1);
}

/* A tape with a rod at s and t. */
typedef struct recording {
    ad_tape *tape;
    ad_value s, t, parameters; /* the last not valid where there are none */
    int count, more;           /* of parameters, and rows of that input */
    domain_place at;
    rod_context context;
} recording;

/* What is measured by scales is measured by those of the scene without open names. rows: 1, or PATH
 * where parameters are given with their rates, those of all behind one another. */
static void begin(const solve_rod *rod, int rows, recording *on)
{
    const solve_functions *f = rod->formula;
    *on = (recording){.tape = ad_tape_create()};
    on->s = ad_input(on->tape, "s", 1);
    on->t = ad_input(on->tape, "t", 1);
    on->at = rod_place(&rod->scene, on->s, on->t);
    on->context = rod_context_of(&rod->scene, &on->at);
    const int count = f->open ? f->parameters->count : 0;
    on->count = count;
    on->more = rows * count;
    if (count > 0) {
        on->parameters = ad_input(on->tape, "parameters", on->more);
        for (int i = 0; i < count; i++) {
            on->context.parameters[i] =
                (quantity_binding){f->parameters->names[i], ad_row(on->parameters, i)};
        }
        on->context.scene = f->open;
        on->context.properties = scene_properties_of(f->open);
        on->context.parameter_count = count;
    }
}

/* By t, along which parameters that are given with their rates move, too. */
static ad_value end_rate(const recording *on, ad_value y)
{
    if (!on->context.dynamic || on->more <= on->count) {
        return rod_time_derivative(&on->context, y, 1);
    }
    const int moving = on->more - on->count;
    const ad_value wrt[2] = {on->t, on->parameters};
    const ad_value along[2] = {
        ad_scalar(on->tape, 1),
        STACK(ad_slice(on->parameters, on->count, moving), ad_zeros(on->tape, on->count))};
    ad_value rate = ad_zeros(on->tape, ad_rows(y));
    ad_directional(1, &y, 2, wrt, along, &rate);
    return rate;
}

/* Of a manufactured scene its solution, anywhere. */
static ad_value record_end(const recording *on, int end, solve_end *kind)
{
    const rod_context *rod = &on->context;
    rod_end_data data = rod_end_of(rod, end, rod->t);
    const scene_end *given = end ? &rod->scene->end : &rod->scene->start;
    *kind = (solve_end){.hold = scene_hold_of(given), .holds_rotation = data.holds_rotation};
    if (scene_is_manufactured(rod->scene)) {
        rod_state exact = rod_manufactured(rod->scene, rod->s, rod->t);
        data.position = exact.position;
        data.rotation = exact.rotation;
        data.force = exact.force;
        data.moment = exact.moment;
    }
    ad_value r = data.position, q = data.rotation;
    const ad_value velocity = end_rate(on, r), turning = end_rate(on, q);
    ad_value pose = STACK(r, q, velocity, rod_rate(q, turning), end_rate(on, velocity),
                          rod_rate(q, end_rate(on, turning)));
    kind->moves = ad_uses(1, &pose, rod->t);
    return STACK(pose, data.force, data.moment);
}

static ad_value record_initial(const rod_context *rod)
{
    ad_value none = ad_zeros(rod->tape, 3);
    if (!rod->dynamic && scene_is_manufactured(rod->scene)) {
        rod_state exact = rod_manufactured(rod->scene, rod->s, rod->t);
        return STACK(exact.position, exact.rotation, none, none);
    }
    rod_initial_data initial = rod_initial_of(rod, rod->s);
    return STACK(initial.position, initial.rotation, initial.velocity, initial.spin);
}

/* Derivatives of a part by each parameter, one after the other. */
static ad_value by_each(const recording *on, int count, ad_value value)
{
    ad_value each[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < count; i++) {
        double unit[SCENE_PARAMETERS_MAX] = {0};
        unit[i] = 1;
        const ad_value along = ad_constant(on->tape, count, unit);
        ad_directional(1, &value, 1, &on->parameters, &along, &each[i]);
        each[i] = ad_rows(each[i]) < ad_rows(value) ? ad_repeat(each[i], ad_rows(value)) : each[i];
    }
    return ad_stack(count, each);
}

/* One formula of the rod: the part that it is. */
static ad_status add_formula(solve_rod *rod, const recording *on, solve_part part, ad_value value,
                             formula **to, ad_error *error)
{
    solve_functions *f = rod->formula;
    const bool is_open = on->count > 0 && ad_uses(1, &value, on->parameters);
    value = f->changes ? by_each(on, on->count, value) : value;
    f->kinds[part] = (solve_part_kind){.width = (size_t)ad_rows(value),
                                       .by_s = ad_uses(1, &value, on->s),
                                       .by_t = ad_uses(1, &value, on->t),
                                       .by_parameters = is_open};
    return solve_formula_create(value, on->more, f->pool, to, error);
}

/* Parts without the ends. */
static ad_status record_along_rod(solve_rod *rod, ad_error *error)
{
    solve_functions *f = rod->formula;
    recording on;
    begin(rod, 1, &on);
    const rod_context context = on.context;
    ad_tape *tape = on.tape;
    const ad_value t = on.t;
    const rod_coefficients c = rod_coefficients_of(&context);
    const ad_value rest = record_rest(&context, &c), along = record_along(&context, &rod->along);
    const ad_value sections = record_sections(&c), initial = record_initial(&context);
    const ad_value jumps = solve_jumps_record(&context, &rod->jumps);
    rod->along_moves = ad_uses(1, &along, t);
    rod->rest_moves = ad_uses(1, &rest, t); /* a jump has no rate */
    ad_status status = ad_tape_status(tape, error);
    if (status == AD_OK) {
        status = add_formula(rod, &on, SOLVE_SECTIONS, sections, &f->sections, error);
    }
    if (status == AD_OK) {
        status = add_formula(rod, &on, SOLVE_REST, rest, &f->rest, error);
    }
    if (status == AD_OK) {
        status = add_formula(rod, &on, SOLVE_INITIAL, initial, &f->initial, error);
    }
    if (status == AD_OK && rod->jumps.numbers > 0) {
        status = add_formula(rod, &on, SOLVE_JUMPS, jumps, &f->jumps, error);
    }
    if (status == AD_OK && rod->along.count > 0) {
        status = add_formula(rod, &on, SOLVE_ALONG, along, &f->along, error);
    }
    if (status == AD_OK && context.scene->rod.growth.is_given) {
        status = add_formula(rod, &on, SOLVE_GROWTH, rod_growth(&context), &f->growth, error);
    }
    if (status == AD_OK && context.scene->feed.by == SCENE_FED_IN_TIME) {
        const ad_value growth = rod_growth(&context), one = ad_scalar(tape, 1);
        const ad_value feed = STACK(ad_sub(growth, one), rod_time_derivative(&context, growth, 1),
                                    rod_time_derivative(&context, growth, 2));
        status = add_formula(rod, &on, SOLVE_FEED, feed, &f->feed, error);
    }
    ad_tape_free(tape);
    return status;
}

/* In motion parameters move them. */
static ad_status record_ends(solve_rod *rod, ad_error *error)
{
    solve_functions *f = rod->formula;
    recording on;
    begin(rod, rod->dynamic ? PATH : 1, &on);
    const ad_value values[ENDS] = {record_end(&on, 0, &rod->ends[0]),
                                   record_end(&on, 1, &rod->ends[1])};
    ad_status status = ad_tape_status(on.tape, error);
    for (int end = 0; end < ENDS && status == AD_OK; end++) {
        const solve_part part = end ? SOLVE_END : SOLVE_START;
        status = add_formula(rod, &on, part, values[end], &f->ends[end], error);
    }
    ad_tape_free(on.tape);
    f->path = status == AD_OK ? (size_t)(on.more - on.count) : 0;
    return status;
}

/* Of the length over its time: robots whose tendons lie 0.02 of the length off the axis and that
 * bend by 1 rad in ten such times slide a hundred times as fast. */
static const double CREEP = 1e-5;

/* What tendons have besides what all actuators have. */
static void set_tendon(solve_rod *rod, const scene_tendon *given, solve_extent *extent)
{
    extent->rubs = quantity_is_something(given->friction);
    extent->creep = given->creep_speed.is_given ? quantity_value(given->creep_speed, 0, 0) *
                                                      rod->scales.time / rod->scales.length
                                                : CREEP;
    rod->frictions += extent->rubs;
    if (given->displacement.is_given) {
        extent->has_length = true;
        rod->lengths++;
        if (given->stiffness.is_given) {
            double unit = rod->scales.force / rod->scales.length;
            extent->compliance = unit / quantity_value(given->stiffness, 0, 0);
        }
    }
}

double solve_rod_displacement(const solve_rod *rod, int i, double t)
{
    return rod->extents[i].has_length
               ? quantity_value(rod->scene.tendons[i].displacement, 0, t * rod->scales.time) /
                     rod->scales.length
               : 0;
}

/* Rows of solve_actuator for one actuator after the other. */
static ad_status record_actuators(solve_rod *rod, ad_error *error)
{
    int pulling = scene_actuator_count(&rod->scene);
    rod->tubes = rod->scene.tube_count;
    rod->actuators = pulling + rod->tubes;
    if (rod->actuators == 0) {
        return AD_OK;
    }
    recording on;
    ad_value all[SOLVE_ACTUATORS_MAX];
    begin(rod, 1, &on);
    const rod_context context = on.context;
    ad_tape *tape = on.tape;
    for (int i = 0; i < pulling; i++) {
        rod_actuator one = rod_actuator_of(&context, i);
        all[i] =
            STACK(one.offset, one.slope, one.pull, one.displacement, one.friction, one.compliance);
        rod->extents[i] = (solve_extent){.start = one.start, .end = one.end, .law = one.law};
        if (i < rod->scene.tendon_count) {
            set_tendon(rod, &rod->scene.tendons[i], &rod->extents[i]);
        }
    }
    for (int i = 0; i < rod->tubes; i++) {
        rod_tube tube = rod_tube_of(&context, i);
        const ad_value base = ad_substitute(tube.softness, context.s, ad_scalar(tape, 0));
        all[pulling + i] = STACK(tube.bending, tube.softness, tube.rest, tube.turned,
                                 ad_mul(base, tube.transmission));
        rod->extents[pulling + i] = (solve_extent){.end = tube.end, .law = LAW_TUBE};
    }
    ad_status status = ad_tape_status(tape, error);
    if (status == AD_OK) {
        status = add_formula(rod, &on, SOLVE_ACTUATORS, ad_stack(rod->actuators, all),
                             &rod->formula->actuators, error);
    }
    ad_tape_free(tape);
    return status;
}

/* ---- making and freeing -------------------------------------------------------------------- */

static ad_status add_quadrature(solve_rod *rod, ad_error *error)
{
    const solve_given given = solve_rod_given(rod);
    double places[SOLVE_JUMPS_MAX];
    solve_jump_places(&rod->jumps, places);
    return rod->dynamic ? AD_OK
                        : solve_quadrature_create(&rod->scene, &given, rod->jumps.count, places,
                                                  &rod->quadrature, error);
}

static ad_status create(const scene *rod_scene, const scene *open,
                        const solve_parameters *parameters, bool changes, solve_rod **result,
                        ad_error *error)
{
    *result = NULL;
    if (rod_scene->rod.inserted.is_given) {
        return ad_fail(error, AD_BAD_ARGUMENT, "rod.inserted: allowed: what scene_map makes of it");
    }
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
    f->open = open;
    f->parameters = parameters;
    f->changes = changes;
    *rod = (solve_rod){.scene = *rod_scene,
                       .motion = rod_scene->motion,
                       .scales = rod_scales_of(rod_scene),
                       .dynamic = scene_is_dynamic(rod_scene),
                       .formula = f};
    rod->scene.motion = SCENE_SPATIAL; /* everything in the frame of the world */
    rod->duration = rod->dynamic ? scene_duration(rod_scene) / rod->scales.time : 0;
    ad_status status = record_along_rod(rod, error);
    status = status == AD_OK ? record_ends(rod, error) : status;
    if (status == AD_OK && !open) {
        status = solve_rod_jump_numbers(rod, 0, rod->jumps.number, error);
    }
    status = status == AD_OK ? record_actuators(rod, error) : status;
    status = status == AD_OK && !open ? add_quadrature(rod, error) : status;
    f->open = NULL; /* recorded */
    f->parameters = NULL;
    if (status != AD_OK) {
        solve_rod_free(rod);
        return status;
    }
    *result = rod;
    return AD_OK;
}

ad_status solve_rod_create(const scene *rod_scene, solve_rod **result, ad_error *error)
{
    return create(rod_scene, NULL, NULL, false, result, error);
}

/* What a scene has as one number for all its members: lengths, places, turns. */
static ad_status check_open(const scene *open, const solve_parameters *parameters, ad_error *error)
{
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        const quantity *q = scene_field_of(open, field);
        bool fixed = field->rule == SCENE_ONE_NUMBER || field->rule == SCENE_LENGTH ||
                     field->rule == SCENE_PLACE;
        for (int k = 0; k < parameters->count && fixed; k++) {
            if (quantity_any_depends_on(field->count, q, parameters->names[k])) {
                return ad_fail(error, AD_BAD_INPUT,
                               "%s depends on %s; allowed: one number for all members", field->key,
                               parameters->names[k]);
            }
        }
    }
    return AD_OK;
}

static ad_status create_open(const scene *open, const solve_parameters *parameters, bool changes,
                             solve_rod **result, ad_error *error)
{
    scene one;
    *result = NULL;
    scene_with(open, parameters->count, parameters->names, parameters->values, &one);
    ad_status status = check_open(open, parameters, error);
    return status == AD_OK ? create(&one, open, parameters, changes, result, error) : status;
}

ad_status solve_rod_create_open(const scene *open, const solve_parameters *parameters,
                                solve_rod **result, ad_error *error)
{
    return create_open(open, parameters, false, result, error);
}

ad_status solve_rod_create_changes(const scene *open, const solve_parameters *parameters,
                                   solve_rod **result, ad_error *error)
{
    return create_open(open, parameters, true, result, error);
}

void solve_rod_free(solve_rod *rod)
{
    if (rod) {
        solve_functions *f = rod->formula;
        for (int i = 0; i < FORMULAS; i++) {
            solve_formula_free(f->all[i]);
        }
        solve_formula_free(f->actuators);
        solve_formula_free(f->along);
        solve_formula_free(f->jumps);
        solve_formula_free(f->growth);
        solve_formula_free(f->feed);
        ad_pool_free(f->pool);
        solve_quadrature_free(rod->quadrature);
        free(f);
        free(rod);
    }
}

void solve_rod_units(const solve_rod *rod, double *units)
{
    const rod_scales *scale = &rod->scales;
    const double of[8] = {scale->length,
                          1,
                          1,
                          1 / scale->length,
                          scale->force,
                          scale->moment,
                          scale->length / scale->time,
                          1 / scale->time};
    const int rows[8] = {3, 4, 3, 3, 3, 3, 3, 3};
    for (int i = 0; i < (rod->tubes > 0 ? 6 : 8); i++) {
        for (int k = 0; k < rows[i]; k++) {
            *units++ = of[i];
        }
    }
    for (int i = 0; i < rod->tubes; i++) {
        *units++ = 1;
        *units++ = scale->moment;
    }
}

/* ---- evaluating ---------------------------------------------------------------------------- */

static formula *formula_of(const solve_functions *f, solve_part part)
{
    return part == SOLVE_JUMPS       ? f->jumps
           : part == SOLVE_ACTUATORS ? f->actuators
           : part == SOLVE_ALONG     ? f->along
           : part == SOLVE_FEED      ? f->feed
           : part == SOLVE_GROWTH    ? f->growth
                                     : f->all[part];
}

solve_part_kind solve_rod_part_kind(const solve_rod *rod, solve_part part)
{
    return rod->formula->kinds[part];
}

ad_status solve_rod_end_moving(const solve_rod *rod, int end, double t, const double *parameters,
                               const double *rates, solve_end_state *out, ad_error *error)
{
    const size_t count = rod->formula->path / (PATH - 1);
    const double s = end;
    double path[PATH * SCENE_PARAMETERS_MAX] = {0};
    memcpy(path, parameters, count * sizeof *path);
    if (rates) {
        memcpy(path + count, rates, (PATH - 1) * count * sizeof *path);
    }
    return solve_formula_evaluate_of(rod->formula->ends[end], 1, &s, t, path, (double *)out, error);
}

ad_status solve_rod_part(const solve_rod *rod, solve_part part, size_t n, const double *s, double t,
                         const double *parameters, double *out, ad_error *error)
{
    const bool is_end = part == SOLVE_START || part == SOLVE_END;
    if (is_end && rod->formula->path > 0) { /* of which there is one point */
        return solve_rod_end_moving(rod, part == SOLVE_END, t, parameters, NULL,
                                    (solve_end_state *)(void *)out, error);
    }
    return solve_formula_evaluate_of(formula_of(rod->formula, part), n, s, t, parameters, out,
                                     error);
}

ad_status solve_rod_sections(const solve_rod *rod, size_t n, const double *s, solve_section *out,
                             ad_error *error)
{
    return solve_formula_evaluate(rod->formula->sections, n, s, 0, (double *)out, error);
}

ad_status solve_rod_rest(const solve_rod *rod, size_t n, const double *s, double t, solve_rest *out,
                         ad_error *error)
{
    return solve_formula_evaluate(rod->formula->rest, n, s, t, (double *)out, error);
}

ad_status solve_rod_jump_numbers(const solve_rod *rod, double t, double *out, ad_error *error)
{
    const double s = 0;
    return rod->jumps.numbers > 0
               ? solve_formula_evaluate(rod->formula->jumps, 1, &s, t, out, error)
               : AD_OK;
}

ad_status solve_rod_along(const solve_rod *rod, size_t n, const double *s, double t, double *out,
                          ad_error *error)
{
    return rod->along.count > 0 ? solve_formula_evaluate(rod->formula->along, n, s, t, out, error)
                                : AD_OK;
}

ad_status solve_rod_actuators(const solve_rod *rod, size_t n, const double *s, double t,
                              solve_actuator *out, ad_error *error)
{
    return rod->actuators == 0
               ? AD_OK
               : solve_formula_evaluate(rod->formula->actuators, n, s, t, (double *)out, error);
}

ad_status solve_rod_end(const solve_rod *rod, int end, double t, solve_end_state *out,
                        ad_error *error)
{
    double s = end;
    return solve_formula_evaluate(rod->formula->ends[end], 1, &s, t, (double *)out, error);
}

/* In such a scene the formula of either end is the solution. */
ad_status solve_rod_manufactured(const solve_rod *rod, size_t n, const double *s, double t,
                                 solve_end_state *out, ad_error *error)
{
    return solve_formula_evaluate(rod->formula->ends[0], n, s, t, (double *)out, error);
}

ad_status solve_rod_initial(const solve_rod *rod, size_t n, const double *s, solve_initial *out,
                            ad_error *error)
{
    return solve_formula_evaluate(rod->formula->initial, n, s, 0, (double *)out, error);
}
