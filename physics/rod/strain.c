#include "physics/rod/strain.h"

#include "physics/rod/strain_internal.h"
#include "physics/scene/breaks.h"
#include "physics/scene/support.h"

#include <math.h>
#include <stdlib.h>

/* ---- meshes -------------------------------------------------------------------------------- */

/* Members that are looked at beside the one in the middle: at the ends of all ranges, of each, and
 * some between. */
enum { SPREAD = 8 };

static void member_of(const scene *open, int number, scene *member)
{
    const int count = open->parameter_count, at_ends = 2 + 2 * count;
    double values[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < count; i++) {
        const bool moves = number < 2 || (number - 2) / 2 == i;
        const double fraction = number >= at_ends ? scene_spread_fraction(number - at_ends, i)
                                : moves           ? number % 2
                                                  : 0.5;
        values[i] = scene_parameter_at(&open->parameters[i], fraction);
    }
    scene_member(open, values, member);
}

static bool are_same(const scene_breaks *a, const scene_breaks *b, double same)
{
    bool result = a->count == b->count;
    for (int i = 0; i < a->count && result; i++) {
        result = fabs(a->place[i] - b->place[i]) <= same;
    }
    return result;
}

/* Where pieces of some members are shorter, and elsewhere, because what is narrow is not at the
 * same place in all: how short, of the length; else 1. */
static ad_status find_shortest(const scene *open, const scene_breaks *middle, double *shortest,
                               ad_error *error)
{
    const double length = scene_length(open);
    const int members = scene_is_family(open) ? 2 + 2 * open->parameter_count + SPREAD : 0;
    scene_breaks pieces, breaks;
    ad_status status = AD_OK;
    *shortest = 1;
    for (int m = 0; m < members && status == AD_OK; m++) {
        scene member;
        member_of(open, m, &member);
        status = scene_divisions_of(&member, "s", BREAKS_MAX, &pieces, error);
        status = status == AD_OK ? scene_breaks_of(&member, "s", &breaks, error) : status;
        if (status == AD_OK && pieces.count > breaks.count &&
            !are_same(&pieces, middle, 1e-9 * length)) {
            double before = 0;
            for (int i = 0; i <= pieces.count; i++) {
                const double end = i < pieces.count ? pieces.place[i] : length;
                *shortest = fmin(*shortest, (end - before) / length);
                before = end;
            }
        }
    }
    return status;
}

static ad_status refuse_mesh(const char *what, ad_error *error)
{
    return ad_fail(
        error, AD_BAD_ARGUMENT,
        "strain form: %s jumps or is narrow in more places than are found or allowed, %d", what,
        STRAIN_ELEMENTS_MAX - 1);
}

ad_status strain_mesh_of(const scene *open, int stages, strain_mesh *mesh, ad_error *error)
{
    scene one;
    scene_breaks pieces;
    double shortest = 1, begin = 0;
    scene_middle(open, &one);
    ad_status status = scene_divisions_of(&one, "s", BREAKS_MAX, &pieces, error);
    if (status == AD_OK && (pieces.unresolved || pieces.count >= STRAIN_ELEMENTS_MAX)) {
        return refuse_mesh(pieces.unresolved ? pieces.unresolved : "the scene", error);
    }
    status = status == AD_OK ? find_shortest(open, &pieces, &shortest, error) : status;
    *mesh = (strain_mesh){.stages = stages};
    for (int i = 0; i <= pieces.count && status == AD_OK; i++) {
        const double end = i < pieces.count ? pieces.place[i] / scene_length(&one) : 1;
        const double parts = fmax(1, ceil((end - begin) / shortest - 1e-9));
        if (mesh->elements + parts > STRAIN_ELEMENTS_MAX) {
            return refuse_mesh("the scene, at places that differ from member to member,", error);
        }
        for (int k = 1; k <= (int)parts; k++) {
            mesh->edges[++mesh->elements] =
                k < (int)parts ? begin + (end - begin) * k / parts : end;
        }
        begin = end;
    }
    return status;
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

ad_status strain_mesh_at(const scene *open, int nodes, const double *s, strain_mesh *mesh,
                         ad_error *error)
{
    strain_mesh whole;
    ad_status status = strain_mesh_of(open, STRAIN_STAGES_MIN, &whole, error);
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

double strain_mesh_unresolved(const strain_mesh *mesh, double scale, int width,
                              const double *curvature)
{
    double weights[STRAIN_MODES][STRAIN_STAGES_MAX], turn = STRAIN_RESOLVED;
    strain_mesh_modes(mesh, weights);
    for (int i = 0; i < mesh->elements * STRAIN_MODES * 3; i++) {
        const int e = i / (3 * STRAIN_MODES), k = i / 3 % STRAIN_MODES;
        double sum = 0;
        for (int j = 0; j < mesh->stages; j++) {
            sum += weights[k][j] * curvature[width * (e * mesh->stages + j) + i % 3];
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

void strain_arms(const scene *one, double *arms)
{
    for (int i = 0; i < one->tendon_count; i++) {
        if (one->tendons[i].displacement.is_given) {
            *arms++ = rod_tendon_arm(one, i);
        }
    }
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
    return strain_held(open) + strain_angles(open) + open->tube_count > 0 ||
           rod_has_law_along(open, is_placed) || rod_has_law_at_places(open, is_placed);
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

void strain_spread(const strain_rod *rod, ad_value value, ad_value *rows)
{
    ad_value at[STRAIN_NODES_MAX], of_row[STRAIN_NODES_MAX];
    const bool varies = ad_uses(1, &value, rod->rod.s);
    for (int i = 0; i < rod->nodes && varies; i++) {
        at[i] = ad_substitute(value, rod->rod.s, ad_scalar(rod->tape, rod->s[i]));
    }
    for (int r = 0; r < ad_rows(value); r++) {
        rows[r] = ad_row(value, r);
        if (ad_uses(1, &rows[r], rod->rod.s)) {
            for (int i = 0; i < rod->nodes; i++) {
                of_row[i] = ad_row(at[i], r);
            }
            rows[r] = ad_stack(rod->nodes, of_row);
        }
    }
}

/* What is known of a tendon whose length is given. */
static void give_length(strain_rod *rod, int i, const rod_actuator *one)
{
    strain_pull *to = &rod->pulls[i];
    to->is_sought = true;
    to->displacement = one->displacement;
    to->compliance = one->compliance;
}

static void give_actuators(strain_rod *rod)
{
    rod->actuators = scene_actuator_count(&rod->open);
    for (int i = 0; i < rod->actuators; i++) {
        rod_actuator one = rod_actuator_of(&rod->rod, i);
        strain_pull *to = &rod->pulls[i];
        to->law = one.law;
        strain_spread(rod, one.offset, to->offset);
        strain_spread(rod, one.slope, to->slope);
        strain_spread(rod, one.pull, &to->pull);
        for (int k = 0; k < rod->nodes; k++) {
            to->first += rod->s[k] < one.start;
            to->count += one.start <= rod->s[k] && rod->s[k] <= one.end;
        }
        to->pull = strain_pull_within(rod, to, to->pull);
        if (i < rod->open.tendon_count && rod->open.tendons[i].displacement.is_given) {
            give_length(rod, i, &one);
        }
        to->friction = one.friction;
        to->rubs =
            i < rod->open.tendon_count && quantity_is_something(rod->open.tendons[i].friction);
    }
}

/* Laws along the rod and at places; forces that depend on the position are sought. */
static void give_laws(strain_rod *rod)
{
    rod_acting along[ROD_ALONG_MAX], places[ROD_AT_PLACES_MAX + ROD_AT_ENDS_MAX];
    rod->along_count = rod_acting_along(&rod->rod, along);
    rod->place_count = rod_acting_at_places(&rod->rod, places);
    rod->place_count += rod_acting_at_ends(&rod->rod, places + rod->place_count);
    for (int i = 0; i < rod->along_count; i++) {
        rod->along[i].law = along[i].law;
        rod->turns |= law_table[along[i].law].by_rotation;
        rod->is_pushed |= law_force_by_position(&law_table[along[i].law]);
        strain_spread(rod, along[i].numbers, rod->along[i].numbers);
    }
    for (int i = 0; i < rod->place_count; i++) {
        rod->places[i].law = places[i].law;
        rod->places[i].s = places[i].s;
        for (int k = 0; k < law_table[places[i].law].numbers; k++) {
            rod->places[i].numbers[k] = ad_row(places[i].numbers, k);
        }
    }
    rod->forces = strain_forces(&rod->open, rod->nodes);
    rod->is_placed = strain_is_placed(&rod->open);
}

static void give(strain_rod *rod)
{
    const rod_coefficients c = rod_coefficients_of(&rod->rod);
    strain_spread(rod, c.rest_strain, rod->rest_strain.x);
    strain_spread(rod, c.rest_curvature, rod->rest_curvature.x);
    strain_spread(rod, c.strain_compliance, rod->strain_compliance.x);
    strain_spread(rod, c.curvature_compliance, rod->curvature_compliance.x);
    give_actuators(rod);
    strain_torsion_give(rod);
    give_laws(rod);
    rod->start = rod_end_of(&rod->rod, 0, rod->rod.t);
    rod->end = rod_end_of(&rod->rod, 1, rod->rod.t);
    rod->holds_position = rod->end.hold.directions > 0;
    rod->holds_rotation = rod->end.holds_rotation;
    rod->held = strain_held(&rod->open);
}

/* ---- making -------------------------------------------------------------------------------- */

/* What is measured by scales is measured by those of the scene with numbers. */
static void begin(strain_rod *rod, const strain_settings *settings, ad_value s,
                  const ad_value *parameters)
{
    rod->open = *settings->open;
    rod->open.motion = SCENE_SPATIAL; /* everything in the frame of the world */
    scene_with(&rod->open, settings->count, settings->names, settings->values, &rod->one);
    rod->tape = s.tape;
    rod->mesh = settings->mesh;
    rod->rule = solve_gauss_rule_of(rod->mesh.stages);
    rod->nodes = strain_mesh_nodes(&rod->mesh);
    strain_mesh_places(&rod->mesh, rod->s);
    rod->at = rod_place(&rod->one, s, ad_scalar(s.tape, 0));
    rod->at.load_factor = settings->load ? *settings->load : rod->at.load_factor;
    rod->rod = rod_context_open(&rod->open, &rod->one, &rod->at, settings->count, settings->names,
                                parameters);
    const scene_properties made = scene_properties_of(&rod->one);
    for (int i = 0; i < 3; i++) {
        rod->shears = rod->shears || !scene_locks(made.strain_stiffness[i]);
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
    strain_rod *rod = status == AD_OK ? calloc(1, sizeof *rod) : NULL;
    if (status == AD_OK && !rod) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a rod in the strain form");
    }
    if (status == AD_OK) {
        begin(rod, settings, s, parameters);
        status = strain_check(&rod->one, true, error);
    }
    if (status == AD_OK) {
        give(rod);
        status = ad_tape_status(rod->tape, error);
    }
    if (status != AD_OK) {
        strain_rod_free(rod);
        return status;
    }
    *result = rod;
    return AD_OK;
}

void strain_rod_free(strain_rod *rod)
{
    free(rod);
}

ad_value strain_rod_rest(const strain_rod *rod)
{
    return strain_points(rod->nodes, rod->rest_curvature);
}
