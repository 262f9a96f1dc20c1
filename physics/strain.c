#include "physics/strain.h"

#include "physics/breaks.h"
#include "physics/strain_internal.h"
#include "physics/support.h"

#include <math.h>
#include <stdlib.h>

/* ---- meshes -------------------------------------------------------------------------------- */

ad_status strain_mesh_of(const scene *one, int stages, strain_mesh *mesh, ad_error *error)
{
    scene_breaks breaks;
    ad_status status = scene_breaks_of(one, "s", &breaks, error);
    if (status == AD_OK && (breaks.unresolved || breaks.count >= STRAIN_ELEMENTS_MAX)) {
        status =
            ad_fail(error, AD_BAD_ARGUMENT,
                    "strain form: %s jumps in more places than are found or allowed, %d",
                    breaks.unresolved ? breaks.unresolved : "the scene", STRAIN_ELEMENTS_MAX - 1);
    }
    if (status != AD_OK) {
        return status;
    }
    *mesh = (strain_mesh){.stages = stages, .elements = 1 + breaks.count};
    for (int i = 0; i < breaks.count; i++) {
        mesh->edges[1 + i] = breaks.place[i] / scene_length(one);
    }
    mesh->edges[mesh->elements] = 1;
    return AD_OK;
}

static bool has_places(const strain_mesh *mesh, const double *s)
{
    double at[STRAIN_NODES_MAX];
    bool same = true;
    strain_mesh_places(mesh, at);
    for (int i = 0; i < strain_mesh_nodes(mesh); i++) {
        same = same && fabs(at[i] - s[i]) < 1e-12;
    }
    return same;
}

ad_status strain_mesh_at(const scene *one, int nodes, const double *s, strain_mesh *mesh,
                         ad_error *error)
{
    strain_mesh whole;
    ad_status status = strain_mesh_of(one, STRAIN_STAGES_MIN, &whole, error);
    for (int parts = 1; status == AD_OK && parts * whole.elements <= STRAIN_ELEMENTS_MAX; parts++) {
        *mesh = (strain_mesh){.elements = parts * whole.elements};
        mesh->stages = nodes / mesh->elements;
        for (int e = 0; e <= mesh->elements; e++) {
            const double *edge = whole.edges + e / parts;
            mesh->edges[e] =
                e % parts ? edge[0] + (edge[1] - edge[0]) * (e % parts) / parts : *edge;
        }
        if (mesh->stages >= STRAIN_STAGES_MIN && mesh->stages <= STRAIN_STAGES_MAX &&
            strain_mesh_nodes(mesh) == nodes && has_places(mesh, s)) {
            return AD_OK;
        }
    }
    return status != AD_OK
               ? status
               : ad_fail(error, AD_BAD_ARGUMENT,
                         "strain form: %d places are not those of Gauss between jumps", nodes);
}

int strain_mesh_nodes(const strain_mesh *mesh)
{
    return mesh->stages * mesh->elements;
}

void strain_mesh_places(const strain_mesh *mesh, double *s)
{
    const gauss_rule rule = solve_gauss_rule_of(mesh->stages);
    for (int i = 0; i < strain_mesh_nodes(mesh); i++) {
        const double *edge = mesh->edges + i / mesh->stages;
        s[i] = edge[0] + (edge[1] - edge[0]) * rule.nodes[i % mesh->stages];
    }
}

void strain_mesh_integral(const strain_mesh *mesh, bool to_edge, int i, double *weights)
{
    const gauss_rule rule = solve_gauss_rule_of(mesh->stages);
    const int n = mesh->stages, whole = to_edge ? i : i / n; /* elements before it */
    for (int from = 0; from < strain_mesh_nodes(mesh); from++) {
        const int e = from / n, j = from % n;
        const double part = e < whole              ? rule.weights[j]
                            : e > whole || to_edge ? 0
                                                   : rule.matrix[i % n][j];
        weights[from] = part * (mesh->edges[e + 1] - mesh->edges[e]);
    }
}

void strain_mesh_modes(const strain_mesh *mesh, double weights[STRAIN_MODES][STRAIN_STAGES_MAX])
{
    const gauss_rule rule = solve_gauss_rule_of(mesh->stages);
    for (int j = 0; j < mesh->stages; j++) {
        const double z = 2 * rule.nodes[j] - 1;
        double before = 0, now = 1; /* Legendre's polynomials by their recurrence */
        for (int k = 0; k < mesh->stages; k++) {
            if (k >= mesh->stages - STRAIN_MODES) {
                weights[k - mesh->stages + STRAIN_MODES][j] = (2 * k + 1) * rule.weights[j] * now;
            }
            const double next = ((2 * k + 1) * z * now - k * before) / (k + 1);
            before = now;
            now = next;
        }
    }
}

double strain_mesh_unresolved(const strain_mesh *mesh, double scale, const double *curvature)
{
    double weights[STRAIN_MODES][STRAIN_STAGES_MAX], turn = STRAIN_RESOLVED;
    strain_mesh_modes(mesh, weights);
    for (int i = 0; i < mesh->elements * STRAIN_MODES * 3; i++) {
        const int e = i / (3 * STRAIN_MODES), k = i / 3 % STRAIN_MODES;
        double sum = 0;
        for (int j = 0; j < mesh->stages; j++) {
            sum += weights[k][j] * curvature[3 * (e * mesh->stages + j) + i % 3];
        }
        turn += fabs(sum) * scale * (mesh->edges[e + 1] - mesh->edges[e]);
    }
    return turn;
}

/* ---- what is known of a scene -------------------------------------------------------------- */

ad_status strain_check(const scene *one, bool on_tape, ad_error *error)
{
    return support_check(one, on_tape ? SUPPORT_EXPORT : SUPPORT_FAMILY, NULL, error);
}

ad_status strain_takes(const scene *one, ad_error *error)
{
    strain_mesh mesh;
    ad_status status = strain_check(one, false, error);
    return status == AD_OK ? strain_mesh_of(one, STRAIN_STAGES_MIN, &mesh, error) : status;
}

static ad_status check_mesh(const strain_mesh *mesh, ad_error *error)
{
    bool ok = mesh->stages >= STRAIN_STAGES_MIN && mesh->stages <= STRAIN_STAGES_MAX &&
              mesh->elements >= 1 && mesh->elements <= STRAIN_ELEMENTS_MAX;
    return ok ? AD_OK
              : ad_fail(error, AD_BAD_ARGUMENT,
                        "strain form: %d elements of %d points; allowed: 1 to %d of %d to %d",
                        mesh->elements, mesh->stages, STRAIN_ELEMENTS_MAX, STRAIN_STAGES_MIN,
                        STRAIN_STAGES_MAX);
}

static bool is_placed(const law *of)
{
    return of->by_position;
}

int strain_held(const scene *open)
{
    return (scene_hold_of(&open->end).directions > 0 ? 3 : 0) +
           (scene_end_holds_rotation(open->end.type) ? 3 : 0) + strain_tensions(open);
}

int strain_tensions(const scene *open)
{
    int count = 0;
    for (int i = 0; i < open->tendon_count; i++) {
        count += open->tendons[i].displacement.is_given;
    }
    return count;
}

int strain_angles(const scene *open)
{
    int count = 0;
    for (int i = 0; i < open->tendon_count; i++) {
        count += quantity_is_something(open->tendons[i].friction);
    }
    return count;
}

bool strain_is_placed(const scene *open)
{
    return strain_held(open) + strain_angles(open) > 0 || rod_has_law_along(open, is_placed) ||
           rod_has_law_at_places(open, is_placed);
}

int strain_forces(const scene *open, int nodes)
{
    int count = rod_has_law_along(open, law_force_by_position) ? 3 * nodes : 0;
    for (int i = 0; i < open->spring_count; i++) {
        count += quantity_any_something(3, open->springs[i].stiffness) ? 3 : 0;
    }
    return count + strain_angles(open) * nodes;
}

/* ---- what is given ------------------------------------------------------------------------- */

/* Rows of a value recorded at s, each of one row for each point, or one for all. */
static void spread(const strain_rod *x, ad_value value, ad_value *rows)
{
    ad_value at[STRAIN_NODES_MAX], of_row[STRAIN_NODES_MAX];
    const bool varies = ad_uses(1, &value, x->rod.s);
    for (int i = 0; i < x->nodes && varies; i++) {
        at[i] = ad_substitute(value, x->rod.s, ad_scalar(x->tape, x->s[i]));
    }
    for (int r = 0; r < ad_rows(value); r++) {
        rows[r] = ad_row(value, r);
        if (ad_uses(1, &rows[r], x->rod.s)) {
            for (int i = 0; i < x->nodes; i++) {
                of_row[i] = ad_row(at[i], r);
            }
            rows[r] = ad_stack(x->nodes, of_row);
        }
    }
}

/* What is known of a tendon whose length is given. */
static void give_length(strain_rod *x, int i, const rod_actuator *one)
{
    const scene_tendon *given = &x->open.tendons[i];
    const double unit = x->rod.scales.force / x->rod.scales.length;
    strain_pull *to = &x->pulls[i];
    to->is_sought = true;
    to->displacement = one->displacement;
    if (given->stiffness.is_given) {
        to->compliance = unit / quantity_value(given->stiffness, 0, 0);
    }
}

static void give_actuators(strain_rod *x)
{
    x->actuators = scene_actuator_count(&x->open);
    for (int i = 0; i < x->actuators; i++) {
        rod_actuator one = rod_actuator_of(&x->rod, i);
        strain_pull *to = &x->pulls[i];
        to->law = one.law;
        spread(x, one.offset, to->offset);
        spread(x, one.slope, to->slope);
        spread(x, one.pull, &to->pull);
        for (int k = 0; k < x->nodes; k++) {
            to->first += x->s[k] < one.start;
            to->count += one.start <= x->s[k] && x->s[k] <= one.end;
        }
        to->pull = strain_pull_within(x, to, to->pull);
        if (i < x->open.tendon_count && x->open.tendons[i].displacement.is_given) {
            give_length(x, i, &one);
        }
        to->friction = one.friction;
        to->rubs = i < x->open.tendon_count && quantity_is_something(x->open.tendons[i].friction);
    }
}

/* Laws along the rod and at places; forces that depend on the position are sought. */
static void give_laws(strain_rod *x)
{
    rod_acting along[ROD_ALONG_MAX], places[ROD_AT_PLACES_MAX + ROD_AT_ENDS_MAX];
    x->along_count = rod_acting_along(&x->rod, along);
    x->place_count = rod_acting_at_places(&x->rod, places);
    x->place_count += rod_acting_at_ends(&x->rod, places + x->place_count);
    for (int i = 0; i < x->along_count; i++) {
        x->along[i].law = along[i].law;
        x->turns |= law_table[along[i].law].by_rotation;
        x->is_pushed |= law_force_by_position(&law_table[along[i].law]);
        spread(x, along[i].numbers, x->along[i].numbers);
    }
    for (int i = 0; i < x->place_count; i++) {
        x->places[i].law = places[i].law;
        x->places[i].s = places[i].s;
        for (int k = 0; k < law_table[places[i].law].numbers; k++) {
            x->places[i].numbers[k] = ad_row(places[i].numbers, k);
        }
    }
    x->forces = strain_forces(&x->open, x->nodes);
    x->is_placed = strain_is_placed(&x->open);
}

static void give(strain_rod *x)
{
    const rod_coefficients c = rod_coefficients_of(&x->rod);
    spread(x, c.rest_strain, x->rest_strain.x);
    spread(x, c.rest_curvature, x->rest_curvature.x);
    spread(x, c.strain_compliance, x->strain_compliance.x);
    spread(x, c.curvature_compliance, x->curvature_compliance.x);
    give_actuators(x);
    give_laws(x);
    x->start = rod_end_of(&x->rod, 0, x->rod.t);
    x->end = rod_end_of(&x->rod, 1, x->rod.t);
    x->holds_position = x->end.hold.directions > 0;
    x->holds_rotation = x->end.holds_rotation;
    x->held = strain_held(&x->open);
}

/* ---- making -------------------------------------------------------------------------------- */

/* What is measured by scales is measured by those of the scene with numbers. */
static void begin(strain_rod *x, const strain_settings *settings, ad_value s,
                  const ad_value *parameters)
{
    x->open = *settings->open;
    x->open.motion = SCENE_SPATIAL; /* everything in the frame of the world */
    scene_with(&x->open, settings->count, settings->names, settings->values, &x->one);
    x->tape = s.tape;
    x->mesh = settings->mesh;
    x->rule = solve_gauss_rule_of(x->mesh.stages);
    x->nodes = strain_mesh_nodes(&x->mesh);
    strain_mesh_places(&x->mesh, x->s);
    x->at = rod_place(&x->one, s, ad_scalar(s.tape, 0));
    x->rod = rod_context_of(&x->one, &x->at);
    x->rod.scene = &x->open;
    x->rod.properties = scene_properties_of(&x->open);
    x->rod.parameter_count = settings->count;
    for (int i = 0; i < settings->count; i++) {
        x->rod.parameters[i] = (quantity_binding){settings->names[i], parameters[i]};
    }
    const scene_properties made = scene_properties_of(&x->one);
    for (int i = 0; i < 3; i++) {
        x->shears = x->shears || !scene_locks(made.strain_stiffness[i]);
    }
}

ad_status strain_rod_create(const strain_settings *settings, ad_value s, const ad_value *parameters,
                            strain_rod **result, ad_error *error)
{
    *result = NULL;
    if (settings->count < 0 || settings->count > SCENE_PARAMETERS_MAX) {
        return ad_fail(error, AD_BAD_ARGUMENT, "strain form: %d parameters; allowed: up to %d",
                       settings->count, SCENE_PARAMETERS_MAX);
    }
    ad_status status = check_mesh(&settings->mesh, error);
    strain_rod *x = status == AD_OK ? calloc(1, sizeof *x) : NULL;
    if (status == AD_OK && !x) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a rod in the strain form");
    }
    if (status == AD_OK) {
        begin(x, settings, s, parameters);
        status = strain_check(&x->one, true, error);
    }
    if (status == AD_OK) {
        give(x);
        status = ad_tape_status(x->tape, error);
    }
    if (status != AD_OK) {
        strain_rod_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void strain_rod_free(strain_rod *rod)
{
    free(rod);
}
