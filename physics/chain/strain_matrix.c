/* The derivatives of the strain form, column by column: what a change of one unknown does to
 * rotations, forces, positions and moments, in that order. Turns of sections are vectors in the
 * world: phi' = R du. */
#include "physics/chain/strain_form.h"
#include "physics/chain/strain_friction.h"
#include "physics/chain/strain_tubes.h"
#include "physics/local/strain_algebra.h"

/* ---- at a point ---------------------------------------------------------------------------- */

/* How v follows n and u, in the body: V_n, V_u, and T_uv V_n, T_uu + T_uv V_u of actuators. */
typedef struct yielding {
    lanes by_n[3][3], by_u[3][3], moment_by_n[3][3], moment_by_u[3][3];
} yielding;

PROCESSOR_INLINE void yield_at(strain_form *form, int node, yielding *to)
{
    const strain_point *point = &form->points[node];
    memset(to, 0, sizeof *to);
    for (int i = 0; i < 3; i++) {
        to->by_n[i][i] = point->compliance[i];
    }
    if (!pulls(form)) {
        return;
    }
    lanes soft[3][3], inverse[3][3], by_u[3][3], turned[3][3], more[3][3];
    pulling pull;
    pull_all(form, node, &pull);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            soft[i][j] = (i == j) + point->compliance[i] * pull.stiffness[law_entry(i, j)];
            by_u[i][j] = turned[j][i] = pull.stiffness[law_entry(i, 3 + j)];
        }
    }
    invert(soft, inverse);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            to->by_n[i][j] = inverse[i][j] * point->compliance[j];
        }
    }
    multiply(to->by_n, by_u, to->by_u);
    multiply(turned, to->by_n, to->moment_by_n);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            to->by_u[i][j] = -to->by_u[i][j];
        }
    }
    multiply(turned, to->by_u, more);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            to->moment_by_u[i][j] = pull.stiffness[law_entry(3 + i, 3 + j)] + more[i][j];
        }
    }
}

PROCESSOR_INLINE void add(lanes to[3][3], lanes from[3][3])
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            to[i][j] += from[i][j];
        }
    }
}

/* r' and the rate of M. */
PROCESSOR_INLINE void differentiate_rates(strain_form *form, int node, yielding *yield)
{
    strain_node *at = &form->at[node];
    lanes part[3][3];
    cross_matrix(at->slope, -1, at->P);
    cross_matrix(at->slope, 1, at->H);
    if (form->kind.shears) {
        multiply(at->R, yield->by_n, part);
        multiply_turned(part, at->R, at->Q);
        multiply(at->R, yield->by_u, at->S);
        times_cross(at->Q, at->N, part);
        add(at->P, part);
        cross_times(at->N, -1, at->Q, part);
        add(at->H, part);
        cross_times(at->N, -1, at->S, at->K);
    }
    cross_times(at->N, -1, at->P, at->G);
    if (form->turns) {
        add(at->G, at->load_by_turn[1]);
    }
    if (form->is_pushed) {
        add(at->G, form->pushes[node].by_turn[1]);
    }
}

PROCESSOR_CALLED void differentiate_point(strain_form *form, int node)
{
    strain_node *at = &form->at[node];
    const strain_point *point = &form->points[node];
    lanes part[3][3];
    yielding yield;
    yield_at(form, node, &yield);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            at->L[i][j] = (i == j) + point->compliance[3 + i] * yield.moment_by_u[i][j];
        }
    }
    if (form->is_unloaded) {
        return;
    }
    differentiate_rates(form, node, &yield);
    multiply_turned(yield.moment_by_n, at->R, at->Z);
    for (int i = 0; i < 3; i++) {
        const lanes soft = point->compliance[3 + i];
        for (int j = 0; j < 3; j++) {
            at->T[i][j] = soft * at->R[j][i];
            at->Z[i][j] *= soft;
        }
    }
    times_cross(at->Z, at->N, at->Y);
    times_cross(at->T, at->M, part);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            at->Y[i][j] -= part[i][j];
        }
    }
}

/* ---- lengths of tendons ---------------------------------------------------------------------- */

PROCESSOR_CALLED void differentiate_lengths(strain_form *form)
{
    for (int k = 0; k < form->tension_count; k++) {
        const strain_tension *of = &form->tensions[k];
        for (int i = 0; i < form->nodes; i++) {
            lanes unused[LAW_STIFFNESS];
            if (of->share[i] > 0) { /* beyond it stays 0 */
                differentiate_length(form, i, of->actuator, of->along[i], unused);
            }
        }
    }
}

/* Whether a change of what is sought changes pulls at given strains. */
PROCESSOR_INLINE bool seeks_pulls(const strain_form *form)
{
    return form->tension_count + form->rub_count > 0;
}

/* Whether anything moves points beside what is there. */
PROCESSOR_INLINE bool moves_points(const strain_form *form, const strain_sources *sources)
{
    return sources || seeks_pulls(form);
}

/* What a change of tensions, angles and what is given makes of r' and of the equation: it pulls
 * with the sign of -N, and takes from the moment of tendons, in the body. */
PROCESSOR_CALLED void change_pulls(strain_form *form, const strain_sources *sources,
                                   const lanes *direction)
{
    for (int i = 0; i < form->nodes && moves_points(form, sources); i++) {
        lanes wrench[6] = {NO_LANES, NO_LANES, NO_LANES, NO_LANES, NO_LANES, NO_LANES}, force[3];
        lanes *slope = form->pulled[i][0], *row = form->pulled[i][1];
        memset(form->pulled[i], 0, sizeof form->pulled[i]);
        if (sources) {
            memcpy(slope, sources->points[i].slope, sizeof sources->points[i].slope);
            memcpy(row, sources->points[i].row, sizeof sources->points[i].row);
        }
        if (!seeks_pulls(form)) {
            continue;
        }
        for (int k = 0; k < form->tension_count; k++) {
            const strain_tension *of = &form->tensions[k];
            lanes more = direction[form->tension_at + k];
            rub(form, of->actuator, i, &more);
            for (int c = 0; c < 6; c++) {
                wrench[c] += more * of->along[i][c];
            }
        }
        change_rubbed(form, i, direction, wrench);
        for (int c = 0; c < 6; c++) {
            wrench[c] = -wrench[c];
        }
        lanes_to_world(form->at[i].R, wrench, force);
        add_applied(form->at[i].Q, force, slope);
        add_applied(form->at[i].Z, force, row);
        for (int c = 0; c < 3; c++) {
            row[c] -= form->points[i].compliance[3 + c] * wrench[3 + c];
        }
    }
}

/* ---- ends ---------------------------------------------------------------------------------- */

/* 2 vec(p* q) by a turn of q in the world: dq = (0, phi) q/2. */
PROCESSOR_INLINE void quotient_by_turn(const lanes p[4], const lanes q[4], lanes by[3][3])
{
    for (int c = 0; c < 3; c++) {
        lanes unit[4] = {NO_LANES, NO_LANES, NO_LANES, NO_LANES}, turned[4], both[4];
        unit[1 + c] += 1;
        lanes_quaternion_product(unit, q, turned);
        lanes_quaternion_quotient(p, turned, both);
        for (int i = 0; i < 3; i++) {
            by[i][c] = both[1 + i];
        }
    }
}

/* M at s = 1 by a turn, or the condition of the turn. */
PROCESSOR_CALLED void differentiate_end(strain_form *form)
{
    strain_edge *edge = &form->edges[form->kind.elements];
    lanes given[3], world[3], turn[3], by[3][3], R[3][3], upright[4];
    memset(form->by_end, 0, sizeof form->by_end);
    if (form->moment_at >= 0) {
        quotient_by_turn(form->held_q, edge->q, by);
        lanes_rotation_matrix(form->held_q, R);
        multiply(R, by, form->held);
        return;
    }
    in_all_lanes(4, form->last.upright, upright); /* M = -R spring 2 vec(p* q) */
    quotient_by_turn(upright, edge->q, by);
    turned_from(form->last.upright, edge->q, turn);
    for (int i = 0; i < 3; i++) {
        given[i] = -2 * form->last.spring[i] * turn[i];
        for (int j = 0; j < 3; j++) {
            by[i][j] *= -form->last.spring[i];
        }
    }
    multiply(edge->R, by, form->by_end);
    lanes_to_world(edge->R, given, world);
    cross_matrix(world, -1, by);
    add(form->by_end, by);
}

/* ---- columns ------------------------------------------------------------------------------- */

/* What changes at a point, and at an edge before what acts there. */
typedef struct changed {
    lanes turn[3], force[3], slope[3], position[3], moment[3];
} changed;

/* Three of a direction; 0 where these are not sought. */
PROCESSOR_INLINE void take(const lanes *direction, int first, lanes to[3])
{
    for (int k = 0; k < 3; k++) {
        to[k] = NO_LANES;
        if (first >= 0) {
            to[k] = direction[first + k];
        }
    }
}

/* Adds three of what sources have, or takes them away. */
#define ADD_SOURCE(of, to)                                                                         \
    if (sources) {                                                                                 \
        add_lanes(3, sources->of, to);                                                             \
    }
#define SUBTRACT_SOURCE(of, to)                                                                    \
    for (int source = 0; source < 3 && sources; source++) {                                        \
        (to)[source] -= sources->of[source];                                                       \
    }

PROCESSOR_CALLED void change_turns(strain_form *form, const strain_sources *sources,
                                   const lanes *direction, changed *points, changed *edges)
{
    const int n = form->kind.stages;
    lanes turn[3], end[3], rate[GAUSS_STAGES_MAX][3], at[GAUSS_STAGES_MAX][3];
    memset(turn, 0, sizeof turn);
    ADD_SOURCE(start[1], turn)
    for (int e = 0; e <= form->kind.elements; e++) {
        memcpy(edges[e].turn, turn, sizeof turn);
        if (e == form->kind.elements) {
            break;
        }
        if (sources) {
            memcpy(end, turn, sizeof end);
            turn_by_steps(form, sources->steps, e, direction + 3 * e * n, end, at);
        } else {
            for (int j = 0; j < n; j++) {
                apply(form->at[e * n + j].R, direction + 3 * (e * n + j), rate[j]);
            }
            integrate_on(form, e, rate, turn, at, end);
        }
        for (int j = 0; j < n; j++) {
            memcpy(points[e * n + j].turn, at[j], sizeof at[j]);
        }
        memcpy(turn, end, sizeof turn);
    }
}

PROCESSOR_CALLED void change_forces(strain_form *form, const strain_sources *sources,
                                    const lanes *direction, changed *points, changed *edges)
{
    const int n = form->kind.stages;
    lanes N[3], start[3], rate[GAUSS_STAGES_MAX][3], at[GAUSS_STAGES_MAX][3];
    take(direction, form->force_at, N);
    for (int e = form->kind.elements; e >= 0; e--) {
        add_applied(form->edges[e].by_turn[0], edges[e].turn, N);
        ADD_SOURCE(edges[e][0], N)
        for (int i = 0; i < form->place_count; i++) {
            for (int k = 0; k < 3 && form->places[i].edge == e && form->places[i].unknown >= 0;
                 k++) {
                N[k] += direction[form->places[i].unknown + k];
            }
        }
        memcpy(edges[e].force, N, sizeof N);
        if (e == 0) {
            break;
        }
        for (int j = 0; j < n; j++) {
            const int node = (e - 1) * n + j;
            take(direction, form->push_at < 0 ? -1 : form->push_at + 3 * node, rate[j]);
            ADD_SOURCE(points[node].load[0], rate[j])
            if (form->follows) {
                add_applied(form->at[node].load_by_turn[0], points[node].turn, rate[j]);
            }
        }
        integrate_back(form, e - 1, rate, N, at, start);
        for (int j = 0; j < n; j++) {
            memcpy(points[(e - 1) * n + j].force, at[j], sizeof at[j]);
        }
        memcpy(N, start, sizeof N);
    }
}

PROCESSOR_CALLED void change_places(strain_form *form, const strain_sources *sources,
                                    const lanes *direction, changed *points, changed *edges)
{
    const int n = form->kind.stages;
    lanes r[3], end[3], rate[GAUSS_STAGES_MAX][3], at[GAUSS_STAGES_MAX][3];
    memset(r, 0, sizeof r);
    ADD_SOURCE(start[0], r)
    for (int e = 0; e <= form->kind.elements; e++) {
        memcpy(edges[e].position, r, sizeof r);
        if (e == form->kind.elements) {
            break;
        }
        for (int j = 0; j < n; j++) {
            const int node = e * n + j;
            apply(form->at[node].P, points[node].turn, rate[j]);
            if (form->kind.shears) {
                add_applied(form->at[node].Q, points[node].force, rate[j]);
                add_applied(form->at[node].S, direction + 3 * node, rate[j]);
            }
            if (moves_points(form, sources)) {
                add_lanes(3, form->pulled[node][0], rate[j]);
                memcpy(points[node].slope, rate[j], sizeof rate[j]);
            }
        }
        integrate_on(form, e, rate, r, at, end);
        for (int j = 0; j < n; j++) {
            memcpy(points[e * n + j].position, at[j], sizeof at[j]);
        }
        memcpy(r, end, sizeof r);
    }
}

PROCESSOR_CALLED void change_moments(strain_form *form, const strain_sources *sources,
                                     const lanes *direction, changed *points, changed *edges)
{
    const int n = form->kind.stages;
    lanes M[3], start[3], rate[GAUSS_STAGES_MAX][3], at[GAUSS_STAGES_MAX][3];
    take(direction, form->moment_at, M);
    add_applied(form->by_end, edges[form->kind.elements].turn, M);
    for (int e = form->kind.elements; e >= 0; e--) {
        add_applied(form->edges[e].by_turn[1], edges[e].turn, M);
        ADD_SOURCE(edges[e][1], M)
        for (int i = 0; i < form->place_count; i++) {
            if (form->places[i].edge == e && form->places[i].acting->moment_by_position) {
                add_applied(form->places[i].push.by_position[1], edges[e].position, M);
            }
        }
        memcpy(edges[e].moment, M, sizeof M);
        if (e == 0) {
            break;
        }
        for (int j = 0; j < n; j++) {
            const int node = (e - 1) * n + j;
            apply(form->at[node].G, points[node].turn, rate[j]);
            add_applied(form->at[node].H, points[node].force, rate[j]);
            if (form->kind.shears) {
                add_applied(form->at[node].K, direction + 3 * node, rate[j]);
            }
            if (form->is_pushed) {
                add_applied(form->pushes[node].by_position[1], points[node].position, rate[j]);
            }
            if (moves_points(form, sources)) { /* it moves the slope alone */
                lanes more[3];
                lanes_vector_cross(form->pulled[node][0], form->at[node].N, more);
                add_lanes(3, more, rate[j]);
            }
            ADD_SOURCE(points[node].load[1], rate[j])
        }
        integrate_back(form, e - 1, rate, M, at, start);
        for (int j = 0; j < n; j++) {
            memcpy(points[(e - 1) * n + j].moment, at[j], sizeof at[j]);
        }
        memcpy(M, start, sizeof M);
    }
}

/* A force that is sought, less what the laws make of the place. */
PROCESSOR_INLINE void push_row(const strain_push *push, const lanes force[3],
                               const lanes position[3], const lanes turn[3], lanes row[3])
{
    for (int k = 0; k < 3; k++) {
        row[k] = force[k];
        for (int i = 0; i < 3; i++) {
            row[k] -= push->by_position[0][k][i] * position[i] + push->by_turn[0][k][i] * turn[i];
        }
    }
}

PROCESSOR_CALLED void rows_of_points(strain_form *form, const strain_sources *sources,
                                     const lanes *direction, changed *points, lanes *to)
{
    for (int i = 0; i < form->nodes; i++) {
        strain_node *at = &form->at[i];
        lanes row[3], moved[3];
        apply(at->Y, points[i].turn, row);
        add_applied(at->Z, points[i].force, row);
        add_applied(at->L, direction + 3 * i, row);
        apply(at->T, points[i].moment, moved);
        for (int k = 0; k < 3; k++) {
            to[3 * i + k] = row[k] - moved[k];
        }
        if (moves_points(form, sources)) {
            add_lanes(3, form->pulled[i][1], to + 3 * i);
        }
        if (form->push_at >= 0) {
            push_row(&form->pushes[i], direction + form->push_at + 3 * i, points[i].position,
                     points[i].turn, to + form->push_at + 3 * i);
            SUBTRACT_SOURCE(points[i].push, to + form->push_at + 3 * i)
        }
    }
}

/* How the strains (v, u) of a point change: v with the slope, less its turn. */
PROCESSOR_CALLED void change_strains(strain_form *form, int node, const lanes *direction,
                                     const changed *at, lanes strains[6])
{
    lanes turned[3], by[3];
    lanes_vector_cross(at->turn, form->at[node].slope, turned);
    for (int c = 0; c < 3; c++) {
        by[c] = at->slope[c] - turned[c];
    }
    lanes_to_body(form->at[node].R, by, strains);
    memcpy(strains + 3, direction + 3 * node, 3 * sizeof *strains);
}

/* Whether no point asks another, neither how it is turned. */
static bool is_apart(const strain_form *form)
{
    return form->is_unloaded && !form->kind.shears;
}

/* The same there: turned with the section, strains change by what acts at the point alone. */
PROCESSOR_INLINE void change_strains_apart(strain_form *form, const strain_sources *sources,
                                           int node, const lanes *direction, lanes strains[6])
{
    memset(strains, 0, 3 * sizeof *strains);
    if (moves_points(form, sources)) {
        lanes_to_body(form->at[node].R, form->pulled[node][0], strains);
    }
    memcpy(strains + 3, direction + 3 * node, 3 * sizeof *strains);
}

/* By how much tendons become shorter than they may be; points NULL: each is apart. */
PROCESSOR_CALLED void rows_of_lengths(strain_form *form, const strain_sources *sources,
                                      const lanes *direction, changed *points, lanes *to)
{
    for (int k = 0; k < form->tension_count; k++) {
        to[form->tension_at + k] = form->tensions[k].compliance * direction[form->tension_at + k];
        if (sources) {
            to[form->tension_at + k] += sources->lengths[k];
        }
    }
    for (int i = 0; i < form->nodes && form->tension_count > 0; i++) {
        lanes strains[6];
        if (points) {
            change_strains(form, i, direction, &points[i], strains);
        } else {
            change_strains_apart(form, sources, i, direction, strains);
        }
        for (int k = 0; k < form->tension_count; k++) {
            const strain_tension *of = &form->tensions[k];
            for (int c = 0; c < 6 && of->share[i] > 0; c++) {
                to[form->tension_at + k] -= of->share[i] * of->along[i][c] * strains[c];
            }
        }
    }
}

/* Places where laws act and ends, whose conditions are about edges. */
PROCESSOR_CALLED void rows_of_edges(strain_form *form, const strain_sources *sources,
                                    const lanes *direction, changed *edges, lanes *to)
{
    changed *last = &edges[form->kind.elements];
    for (int i = 0; i < form->place_count; i++) {
        const strain_place *place = &form->places[i];
        if (place->unknown >= 0) {
            push_row(&place->push, direction + place->unknown, edges[place->edge].position,
                     edges[place->edge].turn, to + place->unknown);
            SUBTRACT_SOURCE(places[i], to + place->unknown)
        }
    }
    SUBTRACT_SOURCE(end[0], last->position)
    if (form->force_at >= 0) {
        hold_row(&form->kind.end.hold, last->position, direction + form->force_at,
                 to + form->force_at);
    }
    if (form->moment_at >= 0) {
        apply(form->held, last->turn, to + form->moment_at);
        SUBTRACT_SOURCE(end[1], to + form->moment_at)
    }
}

PROCESSOR_CALLED void rows_of_tubes(strain_form *form, const strain_sources *sources,
                                    const lanes *direction, lanes *to)
{
    for (int k = 0; k < form->kind.tubes; k++) {
        rows_of_tube(form, k, sources ? sources->tubes + k * form->nodes : NULL,
                     sources ? sources->bases + k : NULL, direction, to);
    }
}

PROCESSOR_INLINE void change_apart(strain_form *form, const strain_sources *sources,
                                   const lanes *direction, lanes *to)
{
    change_pulls(form, sources, direction);
    for (int i = 0; i < form->nodes; i++) {
        apply(form->at[i].L, direction + 3 * i, to + 3 * i);
        if (moves_points(form, sources)) {
            add_lanes(3, form->pulled[i][1], to + 3 * i);
        }
    }
    rows_of_lengths(form, sources, direction, NULL, to);
    rows_of_tubes(form, sources, direction, to);
}

/* The matrix times a direction [unknowns], and sources, NULL: none. */
PROCESSOR_INLINE void change(strain_form *form, const strain_sources *sources,
                             const lanes *direction, lanes *to)
{
    changed *points = form->columns, *edges = points + form->nodes;
    change_pulls(form, sources, direction);
    change_turns(form, sources, direction, points, edges);
    change_forces(form, sources, direction, points, edges);
    change_places(form, sources, direction, points, edges);
    change_moments(form, sources, direction, points, edges);
    rows_of_points(form, sources, direction, points, to);
    rows_of_lengths(form, sources, direction, points, to);
    for (int i = 0; i < form->nodes && form->rub_count > 0; i++) {
        change_strains(form, i, direction, &points[i], form->strained[i]);
        memcpy(form->turned[i], points[i].turn, sizeof form->turned[i]);
    }
    rows_of_angles(form, sources ? sources->tangents : NULL, direction, to);
    rows_of_tubes(form, sources, direction, to);
    rows_of_edges(form, sources, direction, edges, to);
}

PROCESSOR_INLINE void differentiate(strain_form *form)
{
    for (int i = 0; i < form->nodes; i++) {
        differentiate_point(form, i);
    }
    differentiate_lengths(form);
    differentiate_end(form);
}

FOR_EACH_PROCESSOR static void linearise(strain_form *form)
{
    differentiate(form);
}

void strain_form_linearise(strain_form *form)
{
    linearise(form);
}

FOR_EACH_PROCESSOR static void change_all(strain_form *form, const lanes *direction, lanes *result)
{
    if (is_apart(form)) {
        change_apart(form, NULL, direction, result);
    } else {
        change(form, NULL, direction, result);
    }
}

void strain_form_apply(strain_form *form, const lanes *direction, lanes *result)
{
    change_all(form, direction, result);
}

/* A torsion changes its own rows, and what the tube adds to those of curvatures. */
FOR_EACH_PROCESSOR static void change_torsion(strain_form *form, int tube, const lanes *direction,
                                              lanes *result)
{
    memset(result, 0, (size_t)form->tension_at * sizeof *result);
    rows_of_tube(form, tube, NULL, NULL, direction, result);
}

void strain_form_apply_torsion(strain_form *form, int tube, const lanes *direction, lanes *result)
{
    change_torsion(form, tube, direction, result);
}

/* Where each point is apart curvatures alone change lengths. */
FOR_EACH_PROCESSOR static void change_lengths(strain_form *form, const lanes *direction,
                                              lanes *result)
{
    if (!is_apart(form)) {
        change(form, NULL, direction, result);
        return;
    }
    for (int k = 0; k < form->tension_count; k++) {
        const strain_tension *of = &form->tensions[k];
        lanes sum = NO_LANES;
        for (int i = 0; i < form->nodes; i++) {
            const lanes *u = direction + 3 * i;
            for (int c = 0; c < 3 && of->share[i] > 0; c++) {
                sum -= of->share[i] * of->along[i][3 + c] * u[c];
            }
        }
        result[form->tension_at + k] = sum;
    }
}

void strain_form_apply_lengths(strain_form *form, const lanes *direction, lanes *result)
{
    change_lengths(form, direction, result);
}

FOR_EACH_PROCESSOR static void change_given(strain_form *form, const strain_sources *sources,
                                            const lanes *direction, lanes *result,
                                            lanes (*strains)[6], lanes (*carried)[6])
{
    changed *points = form->columns;
    const bool apart = is_apart(form);
    if (apart) {
        change_apart(form, sources, direction, result);
    } else {
        change(form, sources, direction, result);
    }
    for (int i = 0; i < form->nodes; i++) {
        if (apart) {
            change_strains_apart(form, sources, i, direction, strains[i]);
        } else {
            change_strains(form, i, direction, &points[i], strains[i]);
        }
        if (carried) { /* nothing, where points are apart */
            memset(carried[i], 0, sizeof carried[i]);
        }
        if (carried && !apart) {
            memcpy(carried[i], points[i].force, sizeof points->force);
            memcpy(carried[i] + 3, points[i].moment, sizeof points->moment);
        }
    }
}

void strain_form_change(strain_form *form, const strain_sources *sources, const lanes *direction,
                        lanes *result, lanes (*strains)[6], lanes (*carried)[6])
{
    change_given(form, sources, direction, result, strains, carried);
}

FOR_EACH_PROCESSOR static void find_steps(strain_form *form, lanes (*steps)[3][3][3])
{
    const int n = form->kind.stages;
    for (int k = 0; k < form->kind.elements * (n + 1); k++) {
        const int e = k / (n + 1), i = k % (n + 1);
        strain_node *at = form->at + e * n;
        lanes a[3][3], q[4], R[3][3];
        step_terms(form, e, form->magnus[i][0], at->u, sizeof *at / sizeof(lanes), a);
        memcpy(q, form->edges[e].q, sizeof q);
        turn_over(&form->edges[e], q);
        lanes_rotation_matrix(q, R);
        step_change(a, i > 0 ? at[i - 1].R : R, steps[k]);
    }
}

void strain_form_steps(strain_form *form, lanes (*steps)[3][3][3])
{
    find_steps(form, steps);
}
