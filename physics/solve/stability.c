#include "physics/solve/stability.h"

#include "physics/local/actuation.h"
#include "physics/numerics/quaternion.h"
#include "physics/rod/rod_internal.h"
#include "physics/scene/breaks.h"
#include "physics/solve/stability_matrix.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { ELEMENTS = STABILITY_POINTS };

/* The second variation. The unknowns of a node: turns about the directors `axis`, a displacement in
 * the directors of the base, the force in the element behind it, of which the last node has none,
 * and phi of each tube. */
typedef struct variation {
    int axes, axis[3]; /* the rod turns about these directors */
    int dims;          /* components of a displacement: 2 or 3 */
    int tubes;
    stability_matrix matrix; /* of so many nodes as edges */
    double load_factor;
    double left;                           /* of the stiffness of sections */
    double base[3][3];                     /* R where the rod begins */
    double stiffness[3][3];                /* K of the element, with that of tendons */
    double softness[3][3];                 /* C, the same */
    double coupling[3][3];                 /* of strains and curvatures, by tendons */
    solve_actuator *actuators;             /* [elements][those of the rod], SI; NULL: none */
    const solve_rod *rod;                  /* where there are any */
    double rest[ELEMENTS][ACTUATION_ROWS]; /* v*, u* of the rod, SI; with tubes or a law */
    double edge[ELEMENTS + 1];             /* m */
    double step;                           /* length of the element at hand */
    double typical;                        /* bending stiffness of the rod */
} variation;

/* R(q)^T R(p) e_k */
static void turned(const double p[4], const double q[4], int k, double result[3])
{
    double turn[4], R[3][3];
    quaternion_quotient(q, p, turn);
    rotation_matrix(turn, R);
    for (int i = 0; i < 3; i++) {
        result[i] = R[i][k];
    }
}

/* Every break is an edge. */
_Static_assert((int)BREAKS_MAX < (int)ELEMENTS, "more breaks than elements");

/* edges [ELEMENTS + 1] of elements, m: those between two places where something acts or jumps are
 * alike, and as many as make the longest of all shortest. */
static ad_status place_elements(const scene *rod_scene, double *edges, ad_error *error)
{
    double length = scene_length(rod_scene), ends[ELEMENTS + 1] = {0};
    int parts[ELEMENTS], pieces = 1;
    scene_breaks breaks;
    ad_status status = scene_breaks_of(rod_scene, "s", &breaks, error);
    if (status != AD_OK) {
        return status;
    }
    for (int i = 0; i < breaks.count; i++) {
        ends[pieces++] = breaks.place[i];
    }
    ends[pieces] = length;
    for (int i = 0; i < pieces; i++) {
        parts[i] = 1;
    }
    for (int more = ELEMENTS - pieces; more > 0; more--) {
        int longest = 0;
        for (int i = 1; i < pieces; i++) {
            double here = (ends[i + 1] - ends[i]) / parts[i];
            longest = here > (ends[longest + 1] - ends[longest]) / parts[longest] ? i : longest;
        }
        parts[longest]++;
    }
    for (int i = 0; i < pieces; i++) {
        for (int k = 0; k < parts[i]; k++) {
            *edges++ = ends[i] + (ends[i + 1] - ends[i]) * k / parts[i];
        }
    }
    *edges = length;
    return AD_OK;
}

/* The element that ends at s or holds it. */
static int element_at(const variation *variation, double s)
{
    int k = 0;
    while (k < ELEMENTS - 1 && variation->edge[k + 1] < s) {
        k++;
    }
    return k;
}

static double middle(const double *edges, int k)
{
    return edges[k] + 0.5 * (edges[k + 1] - edges[k]);
}

/* ---- the rows of the matrix ----------------------------------------------------------------- */

static int row_of_turn(const variation *variation, int node)
{
    return node * variation->matrix.size;
}

static int row_of_displacement(const variation *variation, int node)
{
    return node * variation->matrix.size + variation->axes;
}

static int row_of_force(const variation *variation, int node)
{
    return node * variation->matrix.size + variation->axes + variation->dims;
}

static int row_of_tube(const variation *variation, int tube, int node)
{
    return node * variation->matrix.size + variation->axes + 2 * variation->dims + tube;
}

/* The director of the base along which component j of a displacement is. */
static int displaced(const variation *variation, int j)
{
    return variation->axes == 1 && j >= variation->axis[0] ? j + 1 : j; /* within the plane */
}

/* Stiffness K, in the world, against displacements of two nodes, or of one. */
static void add_stiffness(variation *variation, int node, int other, double K[3][3], double factor)
{
    for (int i = 0; i < variation->dims; i++) {
        for (int j = node == other ? i : 0; j < variation->dims; j++) {
            double sum = 0;
            for (int v = 0; v < 3; v++) {
                for (int w = 0; w < 3; w++) {
                    sum += variation->base[v][displaced(variation, i)] * K[v][w] *
                           variation->base[w][displaced(variation, j)];
                }
            }
            stability_matrix_add(&variation->matrix, row_of_displacement(variation, node) + i,
                                 row_of_displacement(variation, other) + j, factor * sum);
        }
    }
}

/* What one unknown is in the middle of an element: eta, a = eta_s + u x eta, R^T nu; or of a tube,
 * else -1, phi and its derivative. */
typedef struct direction {
    int place;
    double eta[3], bend[3], pull[3];
    int tube;
    double phi[2];
} direction;

/* eta x n - R^T nu, and what tendons add: the force against which strains are at their best. */
static void strain_by(const variation *variation, const direction *d, const double turned_n[3],
                      double force[3])
{
    to_world((double(*)[3])variation->coupling, d->bend, force);
    for (int i = 0; i < 3; i++) {
        force[i] = turned_n[i] - d->pull[i] + force[i];
    }
}

/* The bilinear form of two directions at a state. */
static double energy_of(const variation *variation, const solve_state *state, const direction *p,
                        const direction *q)
{
    const double *v = state->strain, *n = state->force, *m = state->moment;
    double pn[3], qn[3], pv[3], qv[3], ab[3], ba[3], ps[3], qs[3], sum = 0;
    vector_cross(p->eta, n, pn);
    vector_cross(q->eta, n, qn);
    strain_by(variation, p, pn, ps);
    strain_by(variation, q, qn, qs);
    vector_cross(p->eta, v, pv);
    vector_cross(q->eta, v, qv);
    vector_cross(p->bend, q->eta, ab);
    vector_cross(q->bend, p->eta, ba);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            sum += variation->stiffness[i][j] * p->bend[i] * q->bend[j];
        }
        for (int j = 0; j < 3; j++) {
            sum -= variation->softness[i][j] * ps[i] * qs[j];
        }
        sum += (pn[i] * qv[i] + qn[i] * pv[i]) / 2; /* -n.(eta x (eta x v)) */
    }
    return sum + (vector_dot(m, ab) + vector_dot(m, ba)) / 2 - vector_dot(p->pull, qv) -
           vector_dot(q->pull, pv);
}

/* What tubes have of the same form. */
static double energy_of_tubes(const variation *variation, const solve_actuation *pulling,
                              const solve_state *state, const direction *p, const direction *q)
{
    double sum = 0;
    for (int i = 0; i < variation->tubes; i++) {
        double own[2][5] = {{0}};
        const direction *both[2] = {p, q};
        for (int d = 0; d < 2; d++) {
            memcpy(own[d], both[d]->bend, sizeof both[d]->bend);
            memcpy(own[d] + 3, both[d]->phi, both[d]->tube == i ? sizeof both[d]->phi : 0);
        }
        int actuator = pulling->count - variation->tubes + i;
        if (solve_tube_is_here(pulling, actuator)) {
            sum += solve_tube_variation(pulling, actuator, state->curvature, own[0], own[1]);
        }
    }
    return sum;
}

/* Director `axis`, in the frame before all joints, in that of the element: eta does not jump. */
static void unturned(const double joints[4], int axis, double result[3])
{
    double R[3][3];
    rotation_matrix(joints, R);
    memcpy(result, R[axis], sizeof R[axis]);
}

/* Tendons and tubes of element k. */
static solve_actuation pulling_in(const variation *variation, const solve_state *state, int k)
{
    solve_actuation pulling = {.count = 0};
    if (variation->actuators) {
        double s = middle(variation->edge, k) / variation->edge[ELEMENTS];
        pulling = solve_actuation_at(variation->rod, variation->actuators, (size_t)k, s,
                                     variation->load_factor);
        pulling.rest = variation->rest[k];
        pulling.length = pulling.unit_force = 1; /* SI */
        pulling.tubes = state->tubes;
    }
    return pulling;
}

/* Element k, with the state in its middle; base: the rotation of the first; joints: the product of
 * the turns before. */
static void add_element(variation *variation, int k, const solve_state *state, const double base[4],
                        const double joints[4])
{
    const solve_actuation pulling = pulling_in(variation, state, k);
    direction all[3 * 3 + 2 * SCENE_TUBES_MAX];
    int count = 0;
    for (int side = 0; side < 2; side++) {
        for (int j = 0; j < variation->axes; j++) {
            direction *d = &all[count++];
            double about[3];
            *d = (direction){.place = row_of_turn(variation, k + side) + j, .tube = -1};
            unturned(joints, variation->axis[j], about);
            for (int i = 0; i < 3; i++) {
                d->eta[i] = 0.5 * about[i];
            }
            vector_cross(state->curvature, d->eta, d->bend);
            for (int i = 0; i < 3; i++) {
                d->bend[i] += (side ? 1 : -1) * about[i] / variation->step;
            }
        }
    }
    for (int j = 0; j < variation->dims; j++) {
        direction *d = &all[count++];
        *d = (direction){.place = row_of_force(variation, k) + j, .tube = -1};
        turned(base, state->rotation, displaced(variation, j), d->pull);
        stability_matrix_add(&variation->matrix, d->place,
                             row_of_displacement(variation, k + 1) + j, 1);
        stability_matrix_add(&variation->matrix, d->place, row_of_displacement(variation, k) + j,
                             -1);
    }
    for (int i = 0; i < 2 * variation->tubes; i++) {
        int side = i % 2;
        all[count++] = (direction){.place = row_of_tube(variation, i / 2, k + side),
                                   .tube = i / 2,
                                   .phi = {0.5, (side ? 1 : -1) / variation->step}};
    }
    for (int i = 0; i < count; i++) {
        for (int j = i; j < count; j++) {
            double energy = energy_of(variation, state, &all[i], &all[j]) +
                            energy_of_tubes(variation, &pulling, state, &all[i], &all[j]);
            stability_matrix_add(&variation->matrix, all[i].place, all[j].place,
                                 variation->step * energy);
        }
    }
}

/* ---- what holds the rod ---------------------------------------------------------------------- */

/* A spring beyond all else, in units of the rod: what is held is held by it. */
static const double stiff = 1e12;

static void hold_end(variation *variation, const scene_end *end, int node)
{
    const scene_hold hold = scene_hold_of(end);
    double length = variation->edge[ELEMENTS], by_length = stiff * variation->typical / length,
           K[3][3];
    for (int i = 0; i < 3; i++) {
        double unit[3] = {i == 0, i == 1, i == 2};
        scene_hold_part(&hold, unit, K[i]);
    }
    add_stiffness(variation, node, node, K, by_length / (length * length));
    for (int j = 0; j < variation->axes && scene_end_holds_rotation(end->type); j++) {
        stability_matrix_add(&variation->matrix, row_of_turn(variation, node) + j,
                             row_of_turn(variation, node) + j, by_length);
    }
}

/* Over stiffness/length of the rod: what holds it at its start where neither end holds a turn. A
 * rod between two pins may turn about the line between them: where nothing resists that, it is 0
 * that the energy changes by, which rounding would count. */
static const double LOOSE = 1e-6;

static void hold_turn(variation *variation, const scene *rod_scene)
{
    if (variation->axes == 1 || scene_end_holds_rotation(rod_scene->start.type) ||
        scene_end_holds_rotation(rod_scene->end.type)) {
        return;
    }
    for (int j = 0; j < variation->axes; j++) {
        stability_matrix_add(&variation->matrix, row_of_turn(variation, 0) + j,
                             row_of_turn(variation, 0) + j,
                             LOOSE * variation->typical / variation->edge[ELEMENTS]);
    }
}

/* A tube at its base, where a straight part behind it may twist; and what is beyond its end. */
static void hold_tubes(variation *variation, const scene *rod_scene)
{
    double held = stiff * variation->typical / variation->edge[ELEMENTS];
    for (int i = 0; i < variation->tubes; i++) {
        const scene_tube *tube = &rod_scene->tubes[i];
        quantity torsion = scene_tube_properties(tube).curvature_stiffness[2];
        double softness = quantity_value(tube->transmission, 0, 0) / quantity_value(torsion, 0, 0);
        int base = row_of_tube(variation, i, 0);
        stability_matrix_add(&variation->matrix, base, base, softness > 0 ? 1 / softness : held);
        for (int node = 1; node <= ELEMENTS; node++) {
            int row = row_of_tube(variation, i, node);
            bool beyond = middle(variation->edge, node - 1) > scene_tube_end(rod_scene, i);
            stability_matrix_add(&variation->matrix, row, row, beyond ? held : 0);
        }
    }
}

/* a . B b */
static double form_of(const double a[3], double B[3][3], const double b[3])
{
    double Bb[3];
    to_world(B, b, Bb);
    return vector_dot(a, Bb);
}

/* Minus what a moment changes by with a turn, and what a force does; at `within` in element k,
 * where the unknown turns are about these axes of the world. */
static void add_turning(variation *variation, int k, double within, double factor,
                        double by[2][3][3], double (*about)[3])
{
    const double weight[2] = {1 - within, within};
    for (int i = 0; i < 2 * variation->axes; i++) {
        const int row = row_of_turn(variation, k + i / variation->axes) + i % variation->axes;
        const double part = -factor * weight[i / variation->axes];
        for (int j = 0; j <= i; j++) {
            const double both =
                form_of(about[i], by[1], about[j]) + form_of(about[j], by[1], about[i]);
            stability_matrix_add(&variation->matrix, row,
                                 row_of_turn(variation, k + j / variation->axes) +
                                     j % variation->axes,
                                 part * weight[j / variation->axes] * both / 2);
        }
        for (int j = 0; j < 2 * variation->dims; j++) {
            const int d = displaced(variation, j % variation->dims);
            const double along[3] = {variation->base[0][d], variation->base[1][d],
                                     variation->base[2][d]};
            stability_matrix_add(
                &variation->matrix, row,
                row_of_displacement(variation, k + j / variation->dims) + j % variation->dims,
                part * weight[j / variation->dims] / variation->rod->scales.length *
                    form_of(along, by[0], about[i]));
        }
    }
}

/* Laws outside of the rod at `within` in element k, whose middle has the state: displacements are
 * linear in the element, and the rotation goes on by its curvature. Numbers count by the scales of
 * the rod, the matrix in SI. */
static void add_acting(variation *variation, const acting *of, const double *full, int k,
                       double within, double factor, const solve_state *state,
                       const double joints[4])
{
    const rod_scales *scale = &variation->rod->scales;
    const double step = variation->edge[k + 1] - variation->edge[k];
    double turn[4] = {1}, q[4], r[3], R[3][3], K[3][3], by[2][3][3], about[6][3];
    double numbers[SOLVE_JUMP_NUMBERS_MAX];
    acting_change change = {.wrench = {0}};
    rotation_matrix(state->rotation, R);
    to_world(R, state->strain, r);
    for (int i = 0; i < 3; i++) {
        const double on = (within - 0.5) * step;
        turn[1 + i] = 0.5 * state->curvature[i] * on;
        r[i] = (state->position[i] + r[i] * on) / scale->length;
    }
    quaternion_normalize(turn);
    quaternion_product(state->rotation, turn, q);
    quaternion_normalize(q);
    rotation_matrix(q, R);
    acting_on_way(of, full, variation->load_factor, variation->load_factor, numbers);
    acting_differentiate(of, numbers, (acting_on){r, q, NULL}, 1, &change);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            K[i][j] = -(change.by_position[i][j] + change.by_position[j][i]) / 2;
            by[0][i][j] = change.by_turn[i][j];
            by[1][i][j] = change.by_turn[3 + i][j];
        }
    }
    if (of->by_position) {
        const double unit = factor * scale->force / scale->length;
        add_stiffness(variation, k, k, K, unit * (1 - within) * (1 - within));
        add_stiffness(variation, k, k + 1, K, unit * (1 - within) * within);
        add_stiffness(variation, k + 1, k + 1, K, unit * within * within);
    }
    if (of->by_rotation) {
        for (int i = 0; i < 2 * variation->axes; i++) {
            double body[3];
            unturned(joints, variation->axis[i % variation->axes], body);
            to_world(R, body, about[i]);
        }
        add_turning(variation, k, within, factor * scale->moment, by, about);
    }
}

static void take_section(variation *variation, const scene_properties *p, int k)
{
    double s = middle(variation->edge, k), bending[3];
    variation->step = variation->edge[k + 1] - variation->edge[k];
    memset(variation->stiffness, 0, sizeof variation->stiffness);
    memset(variation->softness, 0, sizeof variation->softness);
    for (int i = 0; i < 3; i++) {
        bending[i] = quantity_value(p->curvature_stiffness[i], s, 0);
    }
    double soft = fmin(bending[0], bending[1]);
    soft = isfinite(soft) ? soft : variation->typical;
    for (int i = 0; i < 3; i++) { /* a locked curvature is a very stiff one */
        variation->stiffness[i][i] = variation->left * fmin(bending[i], 1e6 * soft);
        variation->softness[i][i] = 1 / quantity_value(p->strain_stiffness[i], s, 0);
    }
}

/* Tendons resist being turned, and a law is as stiff as where it is. */
static void take_tendons(variation *variation, const solve_state *state, int k)
{
    solve_actuation pulling = pulling_in(variation, state, k);
    double strains[ACTUATION_ROWS];
    pulling.tubes = NULL; /* their own directions have it all */
    memcpy(strains, state->strain, sizeof state->strain);
    memcpy(strains + 3, state->curvature, sizeof state->curvature);
    solve_actuation_stiffen(&pulling, strains, variation->stiffness, variation->softness,
                            variation->coupling);
}

/* values [columns][ELEMENTS] in the middles of the elements. */
static solve_state state_in(const variation *variation, const double *values, int k)
{
    size_t columns = offsetof(solve_state, tubes) / sizeof(double) + 2 * (size_t)variation->tubes;
    solve_state state = {.tubes = {0}};
    for (size_t column = 0; column < columns; column++) {
        ((double *)&state)[column] = values[column * ELEMENTS + (size_t)k];
    }
    return state;
}

/* The product of the turns of the joints before s, m. */
static void joints_before(const scene *rod_scene, double s, double turn[4])
{
    static const double identity[4] = {1};
    memcpy(turn, identity, sizeof identity);
    for (int i = 0; i < rod_joint_count(rod_scene); i++) {
        rod_joint joint = rod_joint_of(rod_scene, i);
        double before[4];
        memcpy(before, turn, sizeof before);
        if (joint.turns && joint.s * scene_length(rod_scene) < s) {
            quaternion_product(before, joint.turn, turn);
        }
    }
}

/* Whether all laws that depend on the shape have an energy, and with it a second variation. */
static bool has_energies(const acting *of)
{
    bool has = true;
    for (int i = 0; i < of->count; i++) {
        const law *one = &law_table[of->law[i]];
        has = has && (one->has_energy || !law_depends_on_shape(one));
    }
    return has;
}

/* Along the rod, at two points of Gauss in each element; and at places. */
static ad_status add_laws(variation *variation, const scene *rod_scene, const double *values,
                          ad_error *error)
{
    enum { POINTS = 2 };
    static const double within[POINTS] = {0.21132486540518713, 0.78867513459481287};
    const solve_jumps *jumps = &variation->rod->jumps;
    const acting *along = &variation->rod->along;
    const double length = variation->edge[ELEMENTS];
    double s[ELEMENTS], numbers[ELEMENTS * ACTING_ALONG_MAX], joints[4];
    for (int k = 0; k < ELEMENTS; k++) {
        s[k] = middle(variation->edge, k) / length;
    }
    ad_status status = solve_rod_along(variation->rod, ELEMENTS, s, 0, numbers, error);
    for (int k = 0; k < ELEMENTS && status == AD_OK && along->count > 0; k++) {
        const solve_state state = state_in(variation, values, k);
        const double part = (variation->edge[k + 1] - variation->edge[k]) / (POINTS * length);
        joints_before(rod_scene, middle(variation->edge, k), joints);
        for (int i = 0; i < POINTS; i++) {
            add_acting(variation, along, numbers + k * along->numbers, k, within[i], part, &state,
                       joints);
        }
    }
    for (int i = 0; i < jumps->count && status == AD_OK; i++) {
        const double place = jumps->at[i].s * length;
        const int k = element_at(variation, place);
        const solve_state state = state_in(variation, values, k);
        joints_before(rod_scene, middle(variation->edge, k), joints);
        add_acting(variation, &jumps->at[i].acting, solve_jump_numbers(jumps, jumps->number, i), k,
                   (place - variation->edge[k]) / (variation->edge[k + 1] - variation->edge[k]), 1,
                   &state, joints);
    }
    return status;
}

static ad_status assemble(variation *variation, const scene *rod_scene, const double *values,
                          ad_error *error)
{
    const scene_properties properties = scene_properties_of(rod_scene);
    double base[4];
    variation->typical = rod_scales_of(rod_scene).moment * scene_length(rod_scene);
    for (int k = 0; k < ELEMENTS; k++) {
        solve_state state = state_in(variation, values, k);
        double joints[4];
        if (k == 0) {
            memcpy(base, state.rotation, sizeof base);
            rotation_matrix(base, variation->base);
        }
        take_section(variation, &properties, k);
        if (variation->actuators) {
            take_tendons(variation, &state, k);
        }
        joints_before(rod_scene, middle(variation->edge, k), joints);
        add_element(variation, k, &state, base, joints);
    }
    for (int j = 0; j < variation->dims;
         j++) { /* no element, no force: one direction, that counts */
        stability_matrix_add(&variation->matrix, row_of_force(variation, ELEMENTS) + j,
                             row_of_force(variation, ELEMENTS) + j, -1);
    }
    hold_end(variation, &rod_scene->start, 0);
    hold_end(variation, &rod_scene->end, ELEMENTS);
    hold_turn(variation, rod_scene);
    hold_tubes(variation, rod_scene);
    return variation->rod ? add_laws(variation, rod_scene, values, error) : AD_OK;
}

static void set_rest(variation *variation, const scene *rod_scene)
{
    const scene_rest rest = scene_rest_of(rod_scene);
    for (int k = 0; k < ELEMENTS; k++) {
        for (int i = 0; i < 3; i++) {
            variation->rest[k][i] = quantity_value(rest.strain[i], middle(variation->edge, k), 0);
            variation->rest[k][3 + i] =
                quantity_value(rest.curvature[i], middle(variation->edge, k), 0);
        }
    }
}

ad_status stability_points(const scene *rod_scene, double *s, ad_error *error)
{
    double edges[ELEMENTS + 1];
    ad_status status = place_elements(rod_scene, edges, error);
    for (int k = 0; k < ELEMENTS && status == AD_OK; k++) {
        s[k] = middle(edges, k);
    }
    return status;
}

ad_status stability_count_with(const scene *rod_scene, double load_factor, double left,
                               const double *values, int *count, ad_error *error)
{
    *count = -1;
    if (scene_is_beam(rod_scene)) {
        return AD_OK;
    }
    rod_plane plane = rod_plane_of(rod_scene);
    if (!rod_has_energy(rod_scene, plane.is_planar)) {
        return AD_OK;
    }
    variation x = {.axes = plane.is_planar ? 1 : 3,
                   .axis = {plane.is_planar ? plane.director : 0, 1, 2},
                   .dims = plane.is_planar ? 2 : 3,
                   .tubes = rod_scene->tube_count,
                   .load_factor = load_factor,
                   .left = left};
    ad_status status = place_elements(rod_scene, x.edge, error);
    if (status == AD_OK) {
        status =
            stability_matrix_create(ELEMENTS + 1, x.axes + 2 * x.dims + x.tubes, &x.matrix, error);
    }
    solve_rod *rod = NULL;
    bool pulled = rod_scene->tendon_count + rod_scene->tube_count > 0 || rod_scene->rod.law;
    if (status == AD_OK && pulled) {
        double s[ELEMENTS];
        for (int k = 0; k < ELEMENTS; k++) {
            s[k] = middle(x.edge, k);
        }
        status = solve_actuation_in_si(rod_scene, ELEMENTS, s, &rod, &x.actuators, error);
        set_rest(&x, rod_scene);
    } else if (status == AD_OK && (rod_has_law_along(rod_scene, law_depends_on_shape) ||
                                   rod_has_law_at_places(rod_scene, law_depends_on_shape))) {
        status = solve_rod_create(rod_scene, &rod, error);
    }
    bool is_known = status == AD_OK;
    for (int i = 0; rod && i < rod->jumps.count && is_known; i++) {
        is_known = has_energies(&rod->jumps.at[i].acting);
    }
    is_known = is_known && (!rod || has_energies(&rod->along));
    x.rod = rod;
    status = is_known ? assemble(&x, rod_scene, values, error) : status;
    if (is_known && status == AD_OK) {
        int found = stability_matrix_negative(&x.matrix); /* each force has one of its own */
        *count = found < 0 ? -1 : found - x.dims * (ELEMENTS + 1);
    }
    stability_matrix_free(&x.matrix);
    free(x.actuators);
    solve_rod_free(rod);
    return status;
}

ad_status stability_count(const scene *rod_scene, const double *values, int *count, ad_error *error)
{
    return stability_count_with(rod_scene, 1, 1, values, count, error);
}

static bool has_no_energy(const law *one)
{
    return law_depends_on_shape(one) && !one->has_energy;
}

const char *stability_without_margin(const scene *rod_scene)
{
    const bool follows = rod_has_law_along(rod_scene, has_no_energy) ||
                         rod_has_law_at_places(rod_scene, has_no_energy);
    return scene_is_dynamic(rod_scene) || scene_is_beam(rod_scene)
               ? "has a margin of rods at rest alone"
           : scene_has_displaced_tendons(rod_scene) || scene_has_rubbing_tendons(rod_scene)
               ? "has no margin with tendons of given length or with friction"
           : rod_scene->rod.law ? "has no margin with a law of the section"
           : follows || !rod_has_energy(rod_scene, rod_plane_of(rod_scene).is_planar)
               ? "has no margin where loads have no energy, as those that follow the rod and, in "
                 "space, moments"
               : NULL;
}
