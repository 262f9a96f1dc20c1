#include "physics/learn/model.h"

#include "physics/beam/beam.h"
#include "physics/learn/window_state.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- rods ---------------------------------------------------------------------------------- */

/* One row per observable of a rod: name and unit of the column, member of rod_observables, its row,
 * whether only motion has it. */
#define ROD_REST_COLUMN_LIST(X)                                                                    \
    X("x", "m", position, 0, false)                                                                \
    X("y", "m", position, 1, false)                                                                \
    X("z", "m", position, 2, false)                                                                \
    X("qw", "", rotation, 0, false)                                                                \
    X("qx", "", rotation, 1, false)                                                                \
    X("qy", "", rotation, 2, false)                                                                \
    X("qz", "", rotation, 3, false)                                                                \
    X("v1", "", strain, 0, false)                                                                  \
    X("v2", "", strain, 1, false)                                                                  \
    X("v3", "", strain, 2, false)                                                                  \
    X("u1", "1/m", curvature, 0, false)                                                            \
    X("u2", "1/m", curvature, 1, false)                                                            \
    X("u3", "1/m", curvature, 2, false)                                                            \
    X("n1", "N", force, 0, false)                                                                  \
    X("n2", "N", force, 1, false)                                                                  \
    X("n3", "N", force, 2, false)                                                                  \
    X("m1", "N m", moment, 0, false)                                                               \
    X("m2", "N m", moment, 1, false)                                                               \
    X("m3", "N m", moment, 2, false)
#define ROD_MOTION_COLUMN_LIST(X)                                                                  \
    X("vx", "m/s", velocity, 0, true)                                                              \
    X("vy", "m/s", velocity, 1, true)                                                              \
    X("vz", "m/s", velocity, 2, true)                                                              \
    X("w1", "1/s", angular_velocity, 0, true)                                                      \
    X("w2", "1/s", angular_velocity, 1, true)                                                      \
    X("w3", "1/s", angular_velocity, 2, true)

#define COLUMN(name, unit, member, row, of_motion) {name, unit, of_motion},
static const model_column rod_columns[] = {ROD_REST_COLUMN_LIST(COLUMN)
                                               ROD_MOTION_COLUMN_LIST(COLUMN)};
static const model_column tube_columns[] = {ROD_REST_COLUMN_LIST(COLUMN){"theta1", "rad", false},
                                            {"mt1", "N m", false},
                                            {"theta2", "rad", false},
                                            {"mt2", "N m", false},
                                            {"theta3", "rad", false},
                                            {"mt3", "N m", false},
                                            {"theta4", "rad", false},
                                            {"mt4", "N m", false}};
#undef COLUMN

static rod_state rod_state_of(const physics_model *m, const ad_value *fields)
{
    rod_state state = {
        .position = fields[0], .rotation = fields[1], .force = fields[2], .moment = fields[3]};
    fields += SCENE_FIELDS;
    if (rod_residual_rows(&m->scene, ROD_TENDON) > 0) {
        state.tendons = *fields++;
    }
    if (m->scene.tube_count > 0) {
        state.tubes = *fields++;
    }
    if (m->scene.formulation == SCENE_POSE_STRAIN) {
        state.strains = *fields;
    }
    return state;
}

static void rod_fields(const physics_model *m, rod_state state, ad_value *fields)
{
    fields[0] = state.position;
    fields[1] = state.rotation;
    fields[2] = state.force;
    fields[3] = state.moment;
    fields += SCENE_FIELDS;
    if (rod_residual_rows(&m->scene, ROD_TENDON) > 0) {
        *fields++ = state.tendons;
    }
    if (m->scene.tube_count > 0) {
        *fields++ = state.tubes;
    }
    if (m->scene.formulation == SCENE_POSE_STRAIN) {
        *fields = state.strains;
    }
}

static void ansatz_rod(const physics_model *m, const domain_place *at, ad_value outputs,
                       ad_value *fields)
{
    rod_fields(m, rod_ansatz(&m->scene, at, outputs), fields);
}

static void observe_rod(const physics_model *m, const domain_place *at, const ad_value *fields,
                        ad_value *values)
{
    const rod_scales scale = rod_scales_of(&m->scene);
    rod_observables o = rod_observe(&m->scene, rod_state_of(m, fields), at);
#define VALUE(name, unit, member, row, of_motion) *values++ = ad_row(o.member, row);
    ROD_REST_COLUMN_LIST(VALUE)
    for (int i = 0; i < 2 * m->scene.tube_count; i++) { /* theta, m_i */
        *values++ = ad_scale(ad_row(o.tubes, i), i % 2 ? scale.moment : 1);
    }
    if (m->scene.tube_count == 0) {
        ROD_MOTION_COLUMN_LIST(VALUE)
    }
#undef VALUE
}

static void state_rod(const physics_model *m, const domain_place *at, const ad_value *fields,
                      ad_value *rows)
{
    rod_moving_state(&m->scene, at, rod_state_of(m, fields), rows);
}

static ad_value residual_rod(const void *context, const domain_place *at, const ad_value *fields)
{
    const struct model_scene_term *term = context;
    return rod_residual(&term->owner->scene, term->kind, rod_state_of(term->owner, fields), at);
}

static int going_rod(const physics_model *m, const double *state)
{
    return rod_going_degree(&m->scene, state);
}

/* ---- beams --------------------------------------------------------------------------------- */

static const model_column beam_columns[BEAM_COLUMNS] = {
    {"w", "m", false},   {"slope", "rad", false}, {"V", "N", false},
    {"M", "N m", false}, {"w_t", "m/s", true},    {"slope_t", "rad/s", true}};

static beam_state beam_state_of(const ad_value *fields)
{
    return (beam_state){fields[0], fields[1], fields[2], fields[3]};
}

static void ansatz_beam(const physics_model *m, const domain_place *at, ad_value outputs,
                        ad_value *fields)
{
    beam_state state = beam_ansatz(&m->scene, at, outputs);
    fields[0] = state.deflection;
    fields[1] = state.slope;
    fields[2] = state.shear;
    fields[3] = state.moment;
}

static void observe_beam(const physics_model *m, const domain_place *at, const ad_value *fields,
                         ad_value *values)
{
    beam_observe(&m->scene, beam_state_of(fields), at, values);
}

static void state_beam(const physics_model *m, const domain_place *at, const ad_value *fields,
                       ad_value *rows)
{
    beam_moving_state(&m->scene, at, beam_state_of(fields), rows);
}

static ad_value residual_beam(const void *context, const domain_place *at, const ad_value *fields)
{
    const struct model_scene_term *term = context;
    return beam_residual(&term->owner->scene, term->kind, beam_state_of(fields), at);
}

static int going_beam(const physics_model *m, const double *state)
{
    (void)m;
    (void)state;
    return BEAM_GOING_DEGREE;
}

/* ---- models of scenes ---------------------------------------------------------------------- */

#define ROD_PHYSICS(list, count)                                                                   \
    {                                                                                              \
        .fields = {"r", "q", "N", "m"}, .columns = (list), .column_count = (count),                \
        .position_columns = 3, .rotation_columns = 4, .network_outputs = rod_network_outputs,      \
        .state_rows = rod_state_rows, .residual_rows = rod_residual_rows,                          \
        .residual = residual_rod, .call = {ansatz_rod, observe_rod, state_rod, going_rod, NULL},   \
        .check = rod_check, .terms = rod_terms                                                     \
    }
static const scene_physics rod_physics =
    ROD_PHYSICS(rod_columns, sizeof rod_columns / sizeof *rod_columns);
/* By the number of tubes, after the columns that a rod has at rest. */
static const scene_physics tube_physics[SCENE_TUBES_MAX + 1] = {
    ROD_PHYSICS(tube_columns, 19), ROD_PHYSICS(tube_columns, 21), ROD_PHYSICS(tube_columns, 23),
    ROD_PHYSICS(tube_columns, 25), ROD_PHYSICS(tube_columns, 27)};
_Static_assert(sizeof tube_columns / sizeof *tube_columns == 19 + 2 * SCENE_TUBES_MAX,
               "columns of each");

static const scene_physics beam_physics = {
    .fields = {"w", "psi", "V", "M"},
    .columns = beam_columns,
    .column_count = BEAM_COLUMNS,
    .position_columns = 1,
    .rotation_columns = 1,
    .network_outputs = beam_network_outputs,
    .state_rows = beam_state_rows,
    .residual_rows = beam_residual_rows,
    .residual = residual_beam,
    .call = {ansatz_beam, observe_beam, state_beam, going_beam, NULL},
    .check = beam_check,
    .terms = beam_terms};

const scene_physics *scene_physics_of(const scene *scene)
{
    return scene_is_beam(scene)    ? &beam_physics
           : scene->tube_count > 0 ? &tube_physics[scene->tube_count]
                                   : &rod_physics;
}

static model_set scene_set(const physics_model *m, const char *name, model_points points, int end)
{
    model_set set = {.points = points};
    snprintf(set.name, sizeof set.name, "%s", name);
    if (points == MODEL_BOUNDARY) {
        set.holds[0] = true;
        set.value[0] = end;
    } else if (points == MODEL_INITIAL) {
        set.holds[m->domain.time] = true;
    }
    return set;
}

/* The residuals that the scene has, with their weights; a set of points where one is needed. */
static void add_scene_terms(physics_model *m, const rod_weights *weights)
{
    static const struct {
        const char *name;
        model_points points;
        int end;
        rod_residual_kind first, last;
    } sets[] = {{"interior", MODEL_INTERIOR, 0, ROD_STRAIN, ROD_TORSION},
                {"start", MODEL_BOUNDARY, 0, ROD_START, ROD_START},
                {"end", MODEL_BOUNDARY, 1, ROD_END, ROD_END},
                {"initial", MODEL_INITIAL, 0, ROD_INITIAL, ROD_INITIAL}};
    const scene_physics *physics = scene_physics_of(&m->scene);
    for (size_t i = 0; i < sizeof sets / sizeof *sets; i++) {
        bool has_set = false;
        for (int kind = (int)sets[i].first; kind <= (int)sets[i].last; kind++) {
            if (physics->residual_rows(&m->scene, (rod_residual_kind)kind) == 0) {
                continue;
            }
            if (!has_set) {
                m->sets[m->set_count++] = scene_set(m, sets[i].name, sets[i].points, sets[i].end);
                has_set = true;
            }
            m->scene_terms[kind] = (struct model_scene_term){m, (rod_residual_kind)kind};
            model_add_term(m, rod_residual_name((rod_residual_kind)kind), m->set_count - 1,
                           rod_weight_of(weights, (rod_residual_kind)kind), physics->residual,
                           &m->scene_terms[kind]);
        }
    }
}

ad_status model_of_scene(const scene *scene, const rod_weights *weights, physics_model **result,
                         ad_error *error)
{
    const rod_weights usual = rod_weights_default();
    const scene_physics *physics = scene_physics_of(scene);
    bool mixed = scene->formulation == SCENE_MIXED;
    *result = NULL;
    if (scene->rod.inserted.is_given) {
        return ad_fail(error, AD_BAD_ARGUMENT, "rod.inserted: allowed: what scene_map makes of it");
    }
    physics_model *m = *result = model_create();
    if (!m) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a model");
    }
    m->scene = *scene;
    m->has_scene = true;
    ad_status status = model_domain_of(scene, &m->domain, error);
    if (status != AD_OK) {
        model_free(m);
        *result = NULL;
        return status;
    }
    m->field_count = SCENE_FIELDS;
    for (int i = 0; i < m->field_count; i++) {
        snprintf(m->symbols[i], sizeof m->symbols[i], "%s", physics->fields[i]);
    }
    if (physics->residual_rows(scene, ROD_TENDON) > 0) {
        snprintf(m->symbols[m->field_count++], sizeof *m->symbols, "tau");
    }
    if (physics->residual_rows(scene, ROD_TWIST) > 0) {
        snprintf(m->symbols[m->field_count++], sizeof *m->symbols, "tubes");
    }
    if (scene->formulation == SCENE_POSE_STRAIN) {
        snprintf(m->symbols[m->field_count++], sizeof *m->symbols, "vu");
    }
    m->unknowns = mixed ? m->field_count : 2;
    m->outputs = physics->network_outputs(scene);
    m->columns = physics->columns;
    m->column_count = physics->column_count;
    m->position_columns = physics->position_columns;
    m->rotation_columns = physics->rotation_columns;
    m->takes_load_factor = !scene_is_dynamic(scene) && !scene_is_beam(scene);
    m->state_rows = physics->state_rows(scene);
    m->call = physics->call;
    add_scene_terms(m, weights ? weights : &usual);
    return AD_OK;
}

/* ---- models of one's own ------------------------------------------------------------------- */

static void outputs_as_fields(const physics_model *m, const domain_place *at, ad_value outputs,
                              ad_value *fields)
{
    (void)at;
    for (int i = 0, row = 0; i < m->field_count; row += m->field_rows[i++]) {
        fields[i] = ad_slice(outputs, row, m->field_rows[i]);
    }
}

static void fields_as_columns(const physics_model *m, const domain_place *at,
                              const ad_value *fields, ad_value *values)
{
    (void)at;
    for (int i = 0; i < m->field_count; i++) {
        for (int row = 0; row < m->field_rows[i]; row++) {
            *values++ = ad_row(fields[i], row);
        }
    }
}

bool model_has_ansatz(const physics_model *m)
{
    return m->call.ansatz != outputs_as_fields;
}

physics_model *model_create(void)
{
    physics_model *m = calloc(1, sizeof *m);
    if (m) {
        m->domain.time = -1;
        m->domain.windows = 1;
        m->call = (model_functions){.ansatz = outputs_as_fields, .observe = fields_as_columns};
        m->columns = m->own_columns;
        m->error = (ad_error){AD_OK, ""};
        scene_defaults(&m->scene);
    }
    return m;
}

void model_free(physics_model *m)
{
    free(m);
}

/* The first error stays. */
static int refuse(physics_model *m, const char *what, const char *name, const char *allowed)
{
    if (m->error.status == AD_OK) {
        ad_fail(&m->error, AD_BAD_ARGUMENT, "model: %s '%.40s'; allowed: %s", what,
                name ? name : "", allowed);
    }
    return 0;
}

static bool is_name(const char *name, size_t size)
{
    return name && name[0] && strlen(name) < size;
}

int model_add_coordinate(physics_model *m, const char *name, const char *unit, double low,
                         double high, double scale)
{
    domain *d = &m->domain;
    if (d->count == DOMAIN_COORDINATES_MAX || !is_name(name, DOMAIN_NAME) ||
        domain_find(d, name) >= 0 || !(high - low > 0 && high - low < 1e300) || !(scale >= 0)) {
        return refuse(m, "coordinate", name,
                      "26 of different names up to 47 letters, low < high, scale 0 or more");
    }
    double unit_of = scale > 0 ? scale : high - low;
    domain_coordinate *c = &d->coordinates[d->count];
    *c = (domain_coordinate){
        .unit = unit, .low = low / unit_of, .high = high / unit_of, .scale = unit_of};
    snprintf(c->name, sizeof c->name, "%s", name);
    return d->count++;
}

void model_set_time(physics_model *m, int coordinate)
{
    if (coordinate < 0 || coordinate >= m->domain.count) {
        refuse(m, "time", "", "a coordinate that has been added");
    } else {
        m->domain.time = coordinate;
    }
}

int model_add_field(physics_model *m, const char *symbol, int rows)
{
    int next = m->field_count;
    if (next == MODEL_FIELDS_MAX || !is_name(symbol, sizeof m->symbols[0]) || rows < 1 ||
        rows > MODEL_COLUMNS_MAX - m->column_count || m->has_scene) {
        return refuse(
            m, "field", symbol,
            "8, of 1 to 32 rows in all, with symbols of 1 to 7 letters, of a model without "
            "scene");
    }
    snprintf(m->symbols[next], sizeof m->symbols[next], "%s", symbol);
    m->field_rows[next] = rows;
    for (int row = 0; row < rows; row++) {
        char number[12] = "", *name = m->own_names[m->column_count];
        if (rows > 1) {
            snprintf(number, sizeof number, "%d", row + 1);
        }
        snprintf(name, sizeof m->own_names[0], "%s%s", symbol, number);
        m->own_columns[m->column_count++] = (model_column){.name = name, .unit = ""};
    }
    m->outputs += rows;
    m->unknowns++;
    return m->field_count++;
}

static int add_set(physics_model *m, const char *name, model_points points)
{
    if (m->set_count == MODEL_SETS_MAX || !is_name(name, MODEL_NAME)) {
        return refuse(m, "points", name, "16 sets with names of 1 to 31 letters");
    }
    model_set *set = &m->sets[m->set_count];
    *set = (model_set){.points = points};
    snprintf(set->name, sizeof set->name, "%s", name);
    return m->set_count++;
}

int model_add_interior(physics_model *m, const char *name)
{
    return add_set(m, name, MODEL_INTERIOR);
}

int model_add_face(physics_model *m, const char *name, int coordinate, int end)
{
    if (coordinate < 0 || coordinate >= m->domain.count || (end != 0 && end != 1)) {
        return refuse(m, "face", name, "a coordinate that has been added, end 0 or 1");
    }
    bool begins = coordinate == m->domain.time && end == 0;
    int set = add_set(m, name, begins ? MODEL_INITIAL : MODEL_BOUNDARY);
    const domain_coordinate *c = &m->domain.coordinates[coordinate];
    m->sets[set].holds[coordinate] = true;
    m->sets[set].value[coordinate] = end ? c->high : c->low;
    return set;
}

int model_add_given(physics_model *m, const char *name, const model_source *source)
{
    if (source->rows < 0 || !source->fill || source->points < 1 || source->draw_every < 0) {
        return refuse(m, "source of points", name,
                      "a function that fills them, 1 point at least, rows and steps of 0 or more");
    }
    int set = add_set(m, name, MODEL_GIVEN);
    m->sets[set].source = *source;
    return set;
}

int model_add_term(physics_model *m, const char *name, int set, double weight,
                   model_residual *residual, const void *context)
{
    if (m->term_count == MODEL_TERMS_MAX || !is_name(name, MODEL_NAME) || set < 0 ||
        set >= m->set_count || !(weight >= 0 && weight < 1e300) || !residual) {
        return refuse(m, "term", name,
                      "24 with names of 1 to 31 letters, at points that have been added, with a "
                      "finite weight of 0 or more and a residual");
    }
    model_term *term = &m->terms[m->term_count];
    *term = (model_term){.set = set, .weight = weight, .residual = residual, .context = context};
    snprintf(term->name, sizeof term->name, "%s", name);
    return m->term_count++;
}

void model_set_periodic(physics_model *m, int coordinate)
{
    if (coordinate < 0 || coordinate >= m->domain.count || coordinate == m->domain.time) {
        refuse(m, "periodic", "", "a coordinate that has been added, but not time");
    } else {
        m->domain.coordinates[coordinate].periodic = true;
    }
}

static ad_value condition_residual(const void *context, const domain_place *at,
                                   const ad_value *fields)
{
    const model_condition *c = context;
    const ad_value given = ad_row(fields[c->field], c->row);
    return ad_sub(c->order > 0 ? ad_derivative(given, at->x[c->coordinate], c->order) : given,
                  c->value(c->context, at));
}

int model_add_condition(physics_model *m, const char *name, model_condition condition, int end)
{
    const model_condition *c = &condition;
    if (m->condition_count == MODEL_SETS_MAX || c->field < 0 || c->field >= m->field_count ||
        c->row < 0 || c->row >= m->field_rows[c->field] || c->order < 0 || !c->value) {
        return refuse(m, "condition", name,
                      "16, each of a row of a field that has been added, with a function that "
                      "records its value");
    }
    const int next = m->condition_count++;
    m->conditions[next] = condition;
    m->condition_terms[next] = model_add_term(m, name, model_add_face(m, name, c->coordinate, end),
                                              100, condition_residual, &m->conditions[next]);
    return m->condition_terms[next];
}

int model_add_unknown(physics_model *m, const char *name, const char *unit, double guess)
{
    if (m->own_unknown_count == MODEL_UNKNOWNS_MAX || !is_name(name, MODEL_NAME) ||
        !(guess > -1e300 && guess < 1e300)) {
        return refuse(m, "unknown", name, "8 with names of 1 to 31 letters and a finite guess");
    }
    model_unknown *unknown = &m->own_unknowns[m->own_unknown_count];
    *unknown = (model_unknown){.unit = unit, .guess = guess};
    snprintf(unknown->name, sizeof unknown->name, "%s", name);
    return m->own_unknown_count++;
}

ad_status model_check(const physics_model *m, ad_error *error)
{
    double weights = 0;
    if (m->error.status != AD_OK) {
        return ad_fail(error, m->error.status, "%s", m->error.message);
    }
    for (int i = 0; i < m->term_count; i++) {
        weights += m->terms[i].weight;
    }
    if (m->domain.count == 0 || m->field_count == 0) {
        return ad_fail(error, AD_BAD_ARGUMENT, "model: has no %s; it needs one at least",
                       m->domain.count == 0 ? "coordinate" : "field");
    }
    return weights > 0
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT, "every loss term has weight 0: nothing to learn");
}

/* ---- recording ----------------------------------------------------------------------------- */

domain_uniforms model_uniforms(const physics_model *m, int window)
{
    return (domain_uniforms){.window = m->domain.windows > 1,
                             .state = window > 0 ? (int)window_state_numbers(m) : 0,
                             .load_factor = m->takes_load_factor};
}

/* Within their ranges whatever the scalars are, and where they are 0 at the guess. */
void model_record_unknowns(const physics_model *m, const nn_mlp *mlp, bool combined,
                           domain_place *at)
{
    const scene *open = &m->scene;
    const int count = open->unknown_count, first = scene_known_count(open);
    ad_value rows[SCENE_PARAMETERS_MAX];
    if (count == 0) {
        return;
    }
    ad_value scalars = nn_mlp_record_scalars(mlp, at->tape, combined, 0);
    for (int i = 0; i < count; i++) {
        const scene_parameter *p = &open->parameters[first + i];
        const double from = scene_unknown_scalar(p, open->guess[first + i]);
        ad_value half = ad_scale(ad_add(ad_row(scalars, i), ad_scalar(at->tape, from)), 0.5);
        ad_value part = ad_scale(ad_add(ad_tanh(half), ad_scalar(at->tape, 1)), 0.5);
        rows[i] = p->scale == SCENE_LOG
                      ? ad_scale(ad_exp(ad_scale(part, log(p->high / p->low))), p->low)
                      : ad_add(ad_scale(part, p->high - p->low), ad_scalar(at->tape, p->low));
    }
    at->unknowns = ad_stack(count, rows);
}

domain_place model_record(const physics_model *m, int window, const nn_mlp *mlp, ad_tape *tape,
                          ad_value *fields)
{
    domain_uniforms uniforms = model_uniforms(m, window);
    domain_place at = domain_record(&m->domain, &uniforms, tape);
    if (mlp) {
        model_record_unknowns(m, mlp, false, &at);
        ad_value input =
            m->call.input ? m->call.input(m, &at) : domain_network_input(&m->domain, &at);
        m->call.ansatz(m, &at, nn_mlp_record(mlp, input, 0), fields);
    } else {
        bool moves = scene_is_dynamic(&m->scene);
        rod_fields(m, rod_manufactured(&m->scene, at.x[0], moves ? at.x[1] : ad_scalar(tape, 0)),
                   fields);
    }
    return at;
}

int model_columns(const physics_model *m)
{
    int count = 0;
    while (count < m->column_count && (m->domain.time >= 0 || !m->columns[count].of_motion)) {
        count++;
    }
    return count;
}
