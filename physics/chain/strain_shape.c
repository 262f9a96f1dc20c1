/* What follows from the curvature: rotation, forces, strain, position, moment; and the residual. */
#include "physics/chain/strain_form.h"
#include "physics/chain/strain_friction.h"
#include "physics/chain/strain_tubes.h"
#include "physics/local/strain_algebra.h"
#include "physics/numerics/quaternion.h"

/* ---- from s = 0 on ------------------------------------------------------------------------- */

PROCESSOR_INLINE void turn_element(strain_form *form, int e, lanes q[4])
{
    const int n = form->kind.stages, parts = form->kind.substeps;
    strain_node *at = form->at + e * n;
    for (int i = 0; i < (n + 1) * parts; i++) {
        const int next = i / parts;
        lanes a[3][3];
        step_terms(form, e, form->magnus[i][0], at->u, sizeof *at / sizeof(lanes), a);
        step_on(a, q);
        if (next < n && i % parts == parts - 1) {
            memcpy(at[next].q, q, sizeof at[next].q);
            lanes_rotation_matrix(q, at[next].R);
        }
    }
    normalise(q);
}

/* Rotations of points and edges. */
PROCESSOR_CALLED void turn_all(strain_form *form)
{
    lanes q[4];
    memcpy(q, form->start_q, sizeof q);
    for (int e = 0; e <= form->kind.elements; e++) {
        strain_edge *edge = &form->edges[e];
        memcpy(edge->q, q, sizeof q);
        lanes_rotation_matrix(q, edge->R);
        if (e < form->kind.elements) {
            turn_over(edge, q);
            turn_element(form, e, q);
        }
    }
}

/* ---- forces from s = 1 back ---------------------------------------------------------------- */

/* N and M at s = 1 beyond what acts there. */
PROCESSOR_INLINE void load_end(strain_form *form, lanes N[3], lanes M[3])
{
    strain_edge *edge = &form->edges[form->kind.elements];
    memcpy(N, form->end_force, 3 * sizeof *N);
    memcpy(M, form->end_moment, 3 * sizeof *M);
    if (form->moment_at < 0) {
        lanes m[3], turn[3];
        turned_from(form->last.upright, edge->q, turn);
        for (int i = 0; i < 3; i++) {
            m[i] = -2 * form->last.spring[i] * turn[i];
        }
        lanes_to_world(edge->R, m, M);
    }
}

/* What laws at places do that do not depend on the position. */
static void act_at_edges(strain_form *form)
{
    for (int k = 0; k < form->place_count; k++) {
        const strain_place *place = &form->places[k];
        strain_edge *edge = &form->edges[place->edge];
        acting_lanes at;
        acting_lanes_of(place->acting, place->numbers, false, edge->r, edge->q, &at);
        for (int i = 0; i < 3; i++) {
            edge->force[i] += at.wrench[i];
            edge->moment[i] += at.wrench[3 + i];
            for (int j = 0; j < 3; j++) {
                edge->by_turn[0][i][j] += at.by_turn[i][j];
                edge->by_turn[1][i][j] += at.by_turn[3 + i][j];
            }
        }
    }
}

void strain_form_load(strain_form *form)
{
    const acting *along = form->kind.along;
    for (int i = 0; along && along->count > 0 && i < form->nodes; i++) {
        strain_node *node = &form->at[i];
        acting_lanes at;
        acting_lanes_of(along, form->along + i * along->numbers, false, node->r, node->q, &at);
        memcpy(node->load, at.wrench, sizeof node->load);
        memcpy(node->load_by_turn, at.by_turn, sizeof node->load_by_turn);
    }
}

static void push(const acting *of, const lanes *numbers, const lanes r[3], const lanes q[4],
                 strain_push *to)
{
    acting_lanes at;
    acting_lanes_of(of, numbers, true, r, q, &at);
    memcpy(to->force, at.wrench, sizeof to->force);
    memcpy(to->moment, at.wrench + 3, sizeof to->moment);
    memcpy(to->by_position, at.by_position, sizeof to->by_position);
    memcpy(to->by_turn, at.by_turn, sizeof to->by_turn);
}

void strain_form_push(strain_form *form)
{
    for (int i = 0; i < form->nodes && form->is_pushed; i++) {
        push(form->kind.along, form->along + i * form->kind.along->numbers, form->at[i].r,
             form->at[i].q, &form->pushes[i]);
    }
    for (int k = 0; k < form->place_count; k++) {
        strain_place *place = &form->places[k];
        const strain_edge *edge = &form->edges[place->edge];
        if (place->acting->by_position) {
            push(place->acting, place->numbers, edge->r, edge->q, &place->push);
        }
    }
}

/* F and T at edges, and their changes by a turn. */
PROCESSOR_INLINE void load_edges(strain_form *form)
{
    for (int k = 0; k < form->place_count; k++) {
        for (int i = 0; i < 3 && form->places[k].unknown >= 0; i++) {
            form->edges[form->places[k].edge].force[i] += form->places[k].force[i];
        }
    }
    act_at_edges(form);
}

PROCESSOR_INLINE void load_element(strain_form *form, int e, const lanes end[3], lanes start[3])
{
    const int n = form->kind.stages;
    strain_node *at = form->at + e * n;
    lanes push[GAUSS_STAGES_MAX][3], force[GAUSS_STAGES_MAX][3];
    for (int j = 0; j < n; j++) {
        memcpy(push[j], at[j].load[0], sizeof push[j]);
        for (int c = 0; c < 3 && form->push_at >= 0; c++) {
            push[j][c] += at[j].push[c];
        }
    }
    integrate_back(form, e, push, end, force, start);
    for (int i = 0; i < n; i++) {
        memcpy(at[i].N, force[i], sizeof at[i].N);
    }
}

PROCESSOR_INLINE void load_all(strain_form *form, lanes M[3])
{
    lanes N[3], start[3];
    load_edges(form);
    load_end(form, N, M);
    for (int e = form->kind.elements; e >= 0; e--) {
        strain_edge *edge = &form->edges[e];
        for (int c = 0; c < 3; c++) {
            N[c] += edge->force[c];
        }
        memcpy(edge->N, N, sizeof edge->N);
        if (e > 0) {
            load_element(form, e - 1, N, start);
            memcpy(N, start, sizeof N);
        }
    }
}

/* ---- strains ------------------------------------------------------------------------------- */

/* (1 + C T_vv)^-1 */
PROCESSOR_INLINE void soften(const strain_point *point, const pulling_by_v *pull,
                             lanes inverse[3][3])
{
    lanes matrix[3][3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            matrix[i][j] = (i == j) + point->compliance[i] * pull->stiffness[BY_V[i][j]];
        }
    }
    invert(matrix, inverse);
}

/* Of what is still moving, the lanes in which a step was not so small that the next is rounding. */
PROCESSOR_INLINE bool goes_on(const lanes step[3], integer_lanes *moving)
{
    const integer_lanes size = (integer_lanes){0} + 0x7fffffffffffffffLL;
    const lanes small = NO_LANES + 1e-9;
    integer_lanes far = {0};
    long long any = 0;
    for (int i = 0; i < 3; i++) {
        far |= (lanes)((integer_lanes)step[i] & size) > small;
    }
    *moving &= far;
    for (int lane = 0; lane < LANES; lane++) {
        any |= (*moving)[lane];
    }
    return any != 0;
}

/* v under n, the pull of actuators and what a law is beyond the stiffness, by Newton's method from
 * where it was. */
PROCESSOR_INLINE void find_strain(strain_form *form, int node)
{
    enum { STEPS = 6 };
    integer_lanes moving = ~*(const integer_lanes *)form->still;
    strain_node *at = &form->at[node];
    const strain_point *point = &form->points[node];
    lanes n[3], missing[3], step[3], inverse[3][3];
    pulling_by_v pull;
    if (!form->kind.shears) {
        memcpy(at->v, point->rest, sizeof at->v);
        return;
    }
    lanes_to_body(at->R, at->N, n);
    if (!pulls(form)) {
        for (int i = 0; i < 3; i++) {
            at->v[i] = point->rest[i] + point->compliance[i] * n[i];
        }
        return;
    }
    for (int k = 0; k < STEPS; k++) {
        pull_by_v(form, node, &pull);
        soften(point, &pull, inverse);
        for (int i = 0; i < 3; i++) {
            missing[i] = at->v[i] - point->rest[i] - point->compliance[i] * (n[i] - pull.wrench[i]);
        }
        apply(inverse, missing, step);
        for (int i = 0; i < 3; i++) {
            at->v[i] -= (lanes)((integer_lanes)step[i] & moving);
        }
        if (!goes_on(step, &moving)) {
            break;
        }
    }
}

/* ---- position and moment ------------------------------------------------------------------- */

PROCESSOR_CALLED void place_all(strain_form *form)
{
    const int n = form->kind.stages;
    lanes r[3], slope[GAUSS_STAGES_MAX][3], place[GAUSS_STAGES_MAX][3];
    memcpy(r, form->start_r, sizeof r);
    for (int e = 0; e < form->kind.elements; e++) {
        strain_node *at = form->at + e * n;
        memcpy(form->edges[e].r, r, sizeof r);
        for (int j = 0; j < n; j++) {
            memcpy(slope[j], at[j].slope, sizeof slope[j]);
        }
        integrate_on(form, e, slope, form->edges[e].r, place, r);
        for (int i = 0; i < n; i++) {
            memcpy(at[i].r, place[i], sizeof at[i].r);
        }
    }
    memcpy(form->edges[form->kind.elements].r, r, sizeof r);
}

PROCESSOR_INLINE void bend_element(strain_form *form, int e, const lanes end[3], lanes start[3])
{
    const int n = form->kind.stages;
    strain_node *at = form->at + e * n;
    lanes rate[GAUSS_STAGES_MAX][3], moment[GAUSS_STAGES_MAX][3];
    for (int j = 0; j < n; j++) {
        lanes_vector_cross(at[j].slope, at[j].N, rate[j]);
        for (int c = 0; c < 3; c++) {
            rate[j][c] += at[j].load[1][c];
        }
        for (int c = 0; c < 3 && form->is_pushed; c++) {
            rate[j][c] += form->pushes[e * n + j].moment[c];
        }
    }
    integrate_back(form, e, rate, end, moment, start);
    for (int i = 0; i < n; i++) {
        memcpy(at[i].M, moment[i], sizeof at[i].M);
    }
}

/* Moments at edges that depend on the place. */
PROCESSOR_INLINE void bend_edges(strain_form *form)
{
    for (int k = 0; k < form->place_count; k++) {
        const strain_place *place = &form->places[k];
        strain_edge *edge = &form->edges[place->edge];
        for (int i = 0; i < 3 && place->acting->moment_by_position; i++) {
            edge->moment[i] += place->push.moment[i];
            for (int j = 0; j < 3; j++) {
                edge->by_turn[1][i][j] += place->push.by_turn[1][i][j];
            }
        }
    }
}

PROCESSOR_INLINE void bend_all(strain_form *form, lanes M[3])
{
    lanes start[3];
    bend_edges(form);
    for (int e = form->kind.elements; e >= 0; e--) {
        strain_edge *edge = &form->edges[e];
        for (int c = 0; c < 3; c++) {
            M[c] += edge->moment[c];
        }
        memcpy(edge->M, M, sizeof edge->M);
        if (e > 0) {
            bend_element(form, e - 1, M, start);
            memcpy(M, start, 3 * sizeof *M);
        }
    }
}

/* ---- the residual -------------------------------------------------------------------------- */

PROCESSOR_INLINE void miss_end(strain_form *form)
{
    strain_edge *edge = &form->edges[form->kind.elements];
    if (form->force_at >= 0) {
        lanes off[3];
        for (int i = 0; i < 3; i++) {
            off[i] = edge->r[i] - form->held_r[i];
        }
        hold_row(&form->kind.end.hold, off, form->end_force, form->right + form->force_at);
    }
    if (form->moment_at >= 0) {
        lanes turn[4], R[3][3], world[3];
        lanes_quaternion_quotient(form->held_q, edge->q, turn);
        lanes_rotation_matrix(form->held_q, R);
        lanes_to_world(R, turn + 1, world);
        for (int i = 0; i < 3; i++) {
            form->right[form->moment_at + i] = 2 * world[i];
        }
    }
}

PROCESSOR_INLINE void miss_points(strain_form *form)
{
    for (int i = 0; i < form->nodes; i++) {
        strain_node *at = &form->at[i];
        const strain_point *point = &form->points[i];
        lanes m[3];
        lanes_to_body(at->R, at->M, m);
        if (pulls(form)) {
            pulling_by_v pull;
            pull_by_v(form, i, &pull);
            for (int c = 0; c < 3; c++) {
                m[c] -= pull.wrench[3 + c];
            }
        }
        if (form->kind.tubes > 0) {
            lanes tubes[3];
            tube_moment(form, i, tubes);
            for (int c = 0; c < 3; c++) {
                m[c] -= tubes[c];
            }
        }
        for (int c = 0; c < 3; c++) {
            form->right[3 * i + c] =
                at->u[c] - point->rest[3 + c] - point->compliance[3 + c] * m[c];
            if (form->push_at >= 0) {
                form->right[form->push_at + 3 * i + c] = at->push[c] - form->pushes[i].force[c];
            }
        }
    }
}

PROCESSOR_INLINE void miss_places(strain_form *form)
{
    for (int k = 0; k < form->place_count; k++) {
        const strain_place *place = &form->places[k];
        for (int c = 0; c < 3 && place->unknown >= 0; c++) {
            form->right[place->unknown + c] = place->force[c] - place->push.force[c];
        }
    }
}

PROCESSOR_INLINE void miss_angles(strain_form *form)
{
    measure_angles(form);
    for (int k = 0; k < form->rub_count; k++) {
        for (int i = 0; i < form->nodes; i++) {
            form->right[angle_at(form, i, k)] = form->rubs[k].angle[i] - form->rubs[k].measured[i];
        }
    }
}

PROCESSOR_INLINE void miss_tubes(strain_form *form)
{
    for (int k = 0; k < form->kind.tubes; k++) {
        const strain_tube *of = &form->tubes[k];
        form->right[torsion_at(form, -1, k)] = of->base - of->base_measured;
        for (int i = 0; i < form->nodes; i++) {
            form->right[torsion_at(form, i, k)] = of->torsion[i] - of->measured[i];
        }
    }
}

/* By how much tendons are shorter than they may be. */
PROCESSOR_INLINE void miss_lengths(strain_form *form)
{
    for (int k = 0; k < form->tension_count; k++) {
        const strain_tension *of = &form->tensions[k];
        lanes left = of->allowed + of->compliance * of->pull;
        for (int i = 0; i < form->nodes; i++) {
            const strain_actuator *at = &form->actuators[i * form->kind.actuators + of->actuator];
            add_length(at, -of->share[i], form->at[i].v, form->at[i].u, &left);
        }
        form->right[form->tension_at + k] = left;
    }
}

static void give_tensions(strain_form *form)
{
    for (int k = 0; k < form->tension_count; k++) {
        const strain_tension *of = &form->tensions[k];
        for (int i = 0; i < form->nodes; i++) {
            lanes *given = form->actuators[i * form->kind.actuators + of->actuator].given;
            given[ACTUATOR_PULL] = NO_LANES;
            if (of->share[i] > 0) {
                given[ACTUATOR_PULL] = of->pull;
            }
        }
    }
}

/* Pulls by the angles that are sought, and tensions where those are. */
static void rub_pulls(strain_form *form)
{
    for (int k = 0; k < form->rub_count; k++) {
        const strain_rub *of = &form->rubs[k];
        const bool is_sought = form->kind.extents[of->actuator].has_length;
        for (int i = 0; i < form->nodes; i++) {
            lanes *pull =
                &form->actuators[i * form->kind.actuators + of->actuator].given[ACTUATOR_PULL];
            for (int lane = 0; lane < LANES; lane++) {
                of->left[i][lane] = exp(-of->friction[lane] * of->angle[i][lane]);
            }
            *pull = (is_sought ? *pull : of->pull[i]) * of->left[i];
        }
    }
}

PROCESSOR_CALLED void find_positions(strain_form *form, lanes M[3])
{
    give_tensions(form);
    rub_pulls(form);
    turn_all(form);
    if (form->turns) {
        strain_form_load(form);
    }
    if (!form->is_unloaded) {
        load_all(form, M);
    }
    for (int i = 0; i < form->nodes; i++) {
        find_strain(form, i);
        lanes_to_world(form->at[i].R, form->at[i].v, form->at[i].slope);
    }
    place_all(form);
}

FOR_EACH_PROCESSOR static void find_strains(strain_form *form)
{
    lanes M[3];
    find_positions(form, M);
}

FOR_EACH_PROCESSOR static void find_shape(strain_form *form)
{
    lanes M[3];
    find_positions(form, M);
    if (!form->is_unloaded) {
        strain_form_push(form);
        bend_all(form, M);
    }
    measure_tubes(form);
    miss_points(form);
    miss_places(form);
    miss_angles(form);
    miss_tubes(form);
    miss_lengths(form);
    miss_end(form);
}

FOR_EACH_PROCESSOR static void find_places(strain_form *form)
{
    turn_all(form);
    for (int i = 0; i < form->nodes; i++) {
        lanes_to_world(form->at[i].R, form->at[i].v, form->at[i].slope);
    }
    place_all(form);
}

void strain_form_place(strain_form *form)
{
    find_places(form);
}

FOR_EACH_PROCESSOR static void take_angles(strain_form *form)
{
    turn_all(form);
    measure_angles(form);
    for (int k = 0; k < form->rub_count; k++) {
        memcpy(form->rubs[k].angle, form->rubs[k].measured, (size_t)form->nodes * sizeof(lanes));
    }
}

void strain_form_rub(strain_form *form)
{
    if (form->rub_count > 0) {
        take_angles(form);
    }
}

static void clear_edges(strain_form *form)
{
    for (int e = 0; e <= form->kind.elements; e++) { /* what is not loaded stays 0 */
        strain_edge *edge = &form->edges[e];
        memset(edge->force, 0, sizeof edge->force);
        memset(edge->moment, 0, sizeof edge->moment);
        memset(edge->by_turn, 0, sizeof edge->by_turn);
    }
}

void strain_form_shape(strain_form *form)
{
    clear_edges(form);
    find_shape(form);
}

void strain_form_strain(strain_form *form)
{
    clear_edges(form);
    find_strains(form);
}

/* ---- steps --------------------------------------------------------------------------------- */

static void subtract(lanes *from, const lanes *step, const lanes *share)
{
    for (int c = 0; c < 3; c++) {
        from[c] -= *share * step[c];
    }
}

FOR_EACH_PROCESSOR static void move(strain_form *form, const lanes *step, const lanes *share)
{
    for (int i = 0; i < form->nodes; i++) {
        subtract(form->at[i].u, step + 3 * i, share);
        if (form->push_at >= 0) {
            subtract(form->at[i].push, step + form->push_at + 3 * i, share);
        }
    }
    for (int k = 0; k < form->place_count; k++) {
        if (form->places[k].unknown >= 0) {
            subtract(form->places[k].force, step + form->places[k].unknown, share);
        }
    }
    for (int k = 0; k < form->rub_count; k++) {
        for (int i = 0; i < form->nodes; i++) {
            form->rubs[k].angle[i] -= *share * step[angle_at(form, i, k)];
        }
    }
    for (int k = 0; k < form->kind.tubes; k++) {
        form->tubes[k].base -= *share * step[torsion_at(form, -1, k)];
        for (int i = 0; i < form->nodes; i++) {
            form->tubes[k].torsion[i] -= *share * step[torsion_at(form, i, k)];
        }
    }
    for (int k = 0; k < form->tension_count; k++) {
        form->tensions[k].pull -= *share * step[form->tension_at + k];
    }
    if (form->force_at >= 0) {
        subtract(form->end_force, step + form->force_at, share);
    }
    if (form->moment_at >= 0) {
        subtract(form->end_moment, step + form->moment_at, share);
    }
}

void strain_form_move(strain_form *form, const lanes *step, const lanes *share)
{
    move(form, step, share);
}
