/* What follows from the curvature: rotation, forces, strain, position, moment; and the residual. */
#include "physics/quaternion.h"
#include "physics/solve/strain_algebra.h"
#include "physics/solve/strain_form.h"
#include "physics/solve/strain_friction.h"

/* ---- from s = 0 on ------------------------------------------------------------------------- */

PROCESSOR_INLINE void turn_element(strain_form *x, int e, lanes q[4])
{
    const int n = x->kind.stages, parts = x->kind.substeps;
    strain_node *at = x->at + e * n;
    for (int i = 0; i < (n + 1) * parts; i++) {
        const int next = i / parts;
        lanes a[3][3];
        for (int k = 0; k < 3; k++) {
            for (int c = 0; c < 3; c++) {
                lanes sum = NO_LANES;
                for (int j = 0; j < n; j++) {
                    sum += x->magnus[i][k][j] * at[j].u[c];
                }
                a[k][c] = sum * x->width[e];
            }
        }
        step_on(a, q);
        if (next < n && i % parts == parts - 1) {
            memcpy(at[next].q, q, sizeof at[next].q);
            lanes_rotation_matrix(q, at[next].R);
        }
    }
    normalise(q);
}

/* Rotations of points and edges. */
PROCESSOR_INLINE void turn_all(strain_form *x)
{
    lanes q[4];
    memcpy(q, x->start_q, sizeof q);
    for (int e = 0; e <= x->kind.elements; e++) {
        strain_edge *edge = &x->edges[e];
        memcpy(edge->q, q, sizeof q);
        lanes_rotation_matrix(q, edge->R);
        if (e < x->kind.elements) {
            turn_over(edge, q);
            turn_element(x, e, q);
        }
    }
}

/* ---- forces from s = 1 back ---------------------------------------------------------------- */

/* N and M at s = 1 beyond what acts there. */
PROCESSOR_INLINE void load_end(strain_form *x, lanes N[3], lanes M[3])
{
    strain_edge *edge = &x->edges[x->kind.elements];
    memcpy(N, x->end_force, 3 * sizeof *N);
    memcpy(M, x->end_moment, 3 * sizeof *M);
    if (x->moment_at < 0) {
        lanes m[3], turn[3];
        turned_from(x->last.upright, edge->q, turn);
        for (int i = 0; i < 3; i++) {
            m[i] = -2 * x->last.spring[i] * turn[i];
        }
        lanes_to_world(edge->R, m, M);
    }
}

/* What laws at places do that do not depend on the position. */
static void act_at_edges(strain_form *x)
{
    for (int k = 0; k < x->place_count; k++) {
        const strain_place *place = &x->places[k];
        strain_edge *edge = &x->edges[place->edge];
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

void strain_form_load(strain_form *x)
{
    const acting *along = x->kind.along;
    for (int i = 0; along && along->count > 0 && i < x->nodes; i++) {
        strain_node *node = &x->at[i];
        acting_lanes at;
        acting_lanes_of(along, x->along + i * along->numbers, false, node->r, node->q, &at);
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

void strain_form_push(strain_form *x)
{
    for (int i = 0; i < x->nodes && x->is_pushed; i++) {
        push(x->kind.along, x->along + i * x->kind.along->numbers, x->at[i].r, x->at[i].q,
             &x->pushes[i]);
    }
    for (int k = 0; k < x->place_count; k++) {
        strain_place *place = &x->places[k];
        const strain_edge *edge = &x->edges[place->edge];
        if (place->acting->by_position) {
            push(place->acting, place->numbers, edge->r, edge->q, &place->push);
        }
    }
}

/* F and T at edges, and their changes by a turn. */
PROCESSOR_INLINE void load_edges(strain_form *x)
{
    for (int k = 0; k < x->place_count; k++) {
        for (int i = 0; i < 3 && x->places[k].unknown >= 0; i++) {
            x->edges[x->places[k].edge].force[i] += x->places[k].force[i];
        }
    }
    act_at_edges(x);
}

PROCESSOR_INLINE void load_element(strain_form *x, int e, const lanes end[3], lanes start[3])
{
    const int n = x->kind.stages;
    strain_node *at = x->at + e * n;
    lanes push[GAUSS_STAGES_MAX][3];
    for (int j = 0; j < n; j++) {
        memcpy(push[j], at[j].load[0], sizeof push[j]);
        for (int c = 0; c < 3 && x->push_at >= 0; c++) {
            push[j][c] += at[j].push[c];
        }
    }
    for (int c = 0; c < 3; c++) {
        start[c] = NO_LANES;
        for (int i = 0; i < n; i++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < n; j++) {
                sum += x->tail[i][j] * push[j][c];
            }
            at[i].N[c] = end[c] + sum * x->width[e];
            start[c] += x->rule.weights[i] * push[i][c];
        }
        start[c] = end[c] + start[c] * x->width[e];
    }
}

PROCESSOR_INLINE void load_all(strain_form *x, lanes M[3])
{
    lanes N[3], start[3];
    load_edges(x);
    load_end(x, N, M);
    for (int e = x->kind.elements; e >= 0; e--) {
        strain_edge *edge = &x->edges[e];
        for (int c = 0; c < 3; c++) {
            N[c] += edge->force[c];
        }
        memcpy(edge->N, N, sizeof edge->N);
        if (e > 0) {
            load_element(x, e - 1, N, start);
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
PROCESSOR_INLINE void find_strain(strain_form *x, int node)
{
    enum { STEPS = 6 };
    integer_lanes moving = ~*(const integer_lanes *)x->still;
    strain_node *at = &x->at[node];
    const strain_point *point = &x->points[node];
    lanes n[3], missing[3], step[3], inverse[3][3];
    pulling_by_v pull;
    if (!x->kind.shears) {
        memcpy(at->v, point->rest, sizeof at->v);
        return;
    }
    lanes_to_body(at->R, at->N, n);
    if (!pulls(x)) {
        for (int i = 0; i < 3; i++) {
            at->v[i] = point->rest[i] + point->compliance[i] * n[i];
        }
        return;
    }
    for (int k = 0; k < STEPS; k++) {
        pull_by_v(x, node, &pull);
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

PROCESSOR_INLINE void place_all(strain_form *x)
{
    const int n = x->kind.stages;
    lanes r[3];
    memcpy(r, x->start_r, sizeof r);
    for (int e = 0; e < x->kind.elements; e++) {
        strain_node *at = x->at + e * n;
        memcpy(x->edges[e].r, r, sizeof r);
        for (int i = 0; i < n; i++) {
            for (int c = 0; c < 3; c++) {
                lanes sum = NO_LANES;
                for (int j = 0; j < n; j++) {
                    sum += x->rule.matrix[i][j] * at[j].slope[c];
                }
                at[i].r[c] = r[c] + sum * x->width[e];
            }
        }
        for (int c = 0; c < 3; c++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < n; j++) {
                sum += x->rule.weights[j] * at[j].slope[c];
            }
            r[c] += sum * x->width[e];
        }
    }
    memcpy(x->edges[x->kind.elements].r, r, sizeof r);
}

PROCESSOR_INLINE void bend_element(strain_form *x, int e, const lanes end[3], lanes start[3])
{
    const int n = x->kind.stages;
    strain_node *at = x->at + e * n;
    lanes rate[GAUSS_STAGES_MAX][3];
    for (int j = 0; j < n; j++) {
        lanes_vector_cross(at[j].slope, at[j].N, rate[j]);
        for (int c = 0; c < 3; c++) {
            rate[j][c] += at[j].load[1][c];
        }
        for (int c = 0; c < 3 && x->is_pushed; c++) {
            rate[j][c] += x->pushes[e * n + j].moment[c];
        }
    }
    for (int c = 0; c < 3; c++) {
        start[c] = NO_LANES;
        for (int i = 0; i < n; i++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < n; j++) {
                sum += x->tail[i][j] * rate[j][c];
            }
            at[i].M[c] = end[c] + sum * x->width[e];
            start[c] += x->rule.weights[i] * rate[i][c];
        }
        start[c] = end[c] + start[c] * x->width[e];
    }
}

/* Moments at edges that depend on the place. */
PROCESSOR_INLINE void bend_edges(strain_form *x)
{
    for (int k = 0; k < x->place_count; k++) {
        const strain_place *place = &x->places[k];
        strain_edge *edge = &x->edges[place->edge];
        for (int i = 0; i < 3 && place->acting->moment_by_position; i++) {
            edge->moment[i] += place->push.moment[i];
            for (int j = 0; j < 3; j++) {
                edge->by_turn[1][i][j] += place->push.by_turn[1][i][j];
            }
        }
    }
}

PROCESSOR_INLINE void bend_all(strain_form *x, lanes M[3])
{
    lanes start[3];
    bend_edges(x);
    for (int e = x->kind.elements; e >= 0; e--) {
        strain_edge *edge = &x->edges[e];
        for (int c = 0; c < 3; c++) {
            M[c] += edge->moment[c];
        }
        memcpy(edge->M, M, sizeof edge->M);
        if (e > 0) {
            bend_element(x, e - 1, M, start);
            memcpy(M, start, 3 * sizeof *M);
        }
    }
}

/* ---- the residual -------------------------------------------------------------------------- */

PROCESSOR_INLINE void miss_end(strain_form *x)
{
    strain_edge *edge = &x->edges[x->kind.elements];
    if (x->force_at >= 0) {
        lanes off[3];
        for (int i = 0; i < 3; i++) {
            off[i] = edge->r[i] - x->held_r[i];
        }
        hold_row(&x->kind.end.hold, off, x->end_force, x->right + x->force_at);
    }
    if (x->moment_at >= 0) {
        lanes turn[4], R[3][3], world[3];
        lanes_quaternion_quotient(x->held_q, edge->q, turn);
        lanes_rotation_matrix(x->held_q, R);
        lanes_to_world(R, turn + 1, world);
        for (int i = 0; i < 3; i++) {
            x->right[x->moment_at + i] = 2 * world[i];
        }
    }
}

PROCESSOR_INLINE void miss_start(strain_form *x)
{
    strain_edge *edge = &x->edges[0];
    const static_end *at = &x->start;
    if (x->shift_at >= 0) {
        lanes off[3];
        for (int i = 0; i < 3; i++) {
            off[i] = edge->r[i] - at->position[i];
        }
        hold_row(&at->kind.hold, off, edge->N, x->right + x->shift_at);
    }
    if (x->turn_at >= 0) { /* in the body, as the spring is */
        lanes m[3], turn[3];
        lanes_to_body(edge->R, edge->M, m);
        turned_from(at->upright, edge->q, turn);
        for (int i = 0; i < 3; i++) {
            x->right[x->turn_at + i] = m[i] - 2 * at->spring[i] * turn[i];
        }
    }
}

PROCESSOR_INLINE void miss_points(strain_form *x)
{
    for (int i = 0; i < x->nodes; i++) {
        strain_node *at = &x->at[i];
        const strain_point *point = &x->points[i];
        lanes m[3];
        lanes_to_body(at->R, at->M, m);
        if (pulls(x)) {
            pulling_by_v pull;
            pull_by_v(x, i, &pull);
            for (int c = 0; c < 3; c++) {
                m[c] -= pull.wrench[3 + c];
            }
        }
        for (int c = 0; c < 3; c++) {
            x->right[3 * i + c] = at->u[c] - point->rest[3 + c] - point->compliance[3 + c] * m[c];
            if (x->push_at >= 0) {
                x->right[x->push_at + 3 * i + c] = at->push[c] - x->pushes[i].force[c];
            }
        }
    }
}

PROCESSOR_INLINE void miss_places(strain_form *x)
{
    for (int k = 0; k < x->place_count; k++) {
        const strain_place *place = &x->places[k];
        for (int c = 0; c < 3 && place->unknown >= 0; c++) {
            x->right[place->unknown + c] = place->force[c] - place->push.force[c];
        }
    }
}

PROCESSOR_INLINE void miss_angles(strain_form *x)
{
    measure_angles(x);
    for (int k = 0; k < x->rub_count; k++) {
        for (int i = 0; i < x->nodes; i++) {
            x->right[angle_at(x, i, k)] = x->rubs[k].angle[i] - x->rubs[k].measured[i];
        }
    }
}

/* By how much tendons are shorter than they may be. */
PROCESSOR_INLINE void miss_lengths(strain_form *x)
{
    for (int k = 0; k < x->tension_count; k++) {
        const strain_tension *of = &x->tensions[k];
        lanes left = of->allowed + x->kind.extents[of->actuator].compliance * of->pull;
        for (int i = 0; i < x->nodes; i++) {
            const strain_actuator *at = &x->actuators[i * x->kind.actuators + of->actuator];
            add_length(at, -of->share[i], x->at[i].v, x->at[i].u, &left);
        }
        x->right[x->tension_at + k] = left;
    }
}

static void give_tensions(strain_form *x)
{
    for (int k = 0; k < x->tension_count; k++) {
        const strain_tension *of = &x->tensions[k];
        for (int i = 0; i < x->nodes; i++) {
            lanes *given = x->actuators[i * x->kind.actuators + of->actuator].given;
            given[ACTUATOR_PULL] = NO_LANES;
            if (of->share[i] > 0) {
                given[ACTUATOR_PULL] = of->pull;
            }
        }
    }
}

/* Pulls by the angles that are sought, and tensions where those are. */
static void rub_pulls(strain_form *x)
{
    for (int k = 0; k < x->rub_count; k++) {
        const strain_rub *of = &x->rubs[k];
        const bool is_sought = x->kind.extents[of->actuator].has_length;
        for (int i = 0; i < x->nodes; i++) {
            lanes *pull = &x->actuators[i * x->kind.actuators + of->actuator].given[ACTUATOR_PULL];
            for (int lane = 0; lane < LANES; lane++) {
                of->left[i][lane] = exp(-of->friction[lane] * of->angle[i][lane]);
            }
            *pull = (is_sought ? *pull : of->pull[i]) * of->left[i];
        }
    }
}

PROCESSOR_INLINE void find_positions(strain_form *x, lanes M[3])
{
    give_tensions(x);
    rub_pulls(x);
    turn_all(x);
    if (x->turns) {
        strain_form_load(x);
    }
    if (!x->is_unloaded) {
        load_all(x, M);
    }
    for (int i = 0; i < x->nodes; i++) {
        find_strain(x, i);
        lanes_to_world(x->at[i].R, x->at[i].v, x->at[i].slope);
    }
    place_all(x);
}

FOR_EACH_PROCESSOR static void find_strains(strain_form *x)
{
    lanes M[3];
    find_positions(x, M);
}

FOR_EACH_PROCESSOR static void find_shape(strain_form *x)
{
    lanes M[3];
    find_positions(x, M);
    if (!x->is_unloaded) {
        strain_form_push(x);
        bend_all(x, M);
    }
    miss_points(x);
    miss_places(x);
    miss_angles(x);
    miss_lengths(x);
    miss_end(x);
    miss_start(x);
}

FOR_EACH_PROCESSOR static void find_places(strain_form *x)
{
    turn_all(x);
    for (int i = 0; i < x->nodes; i++) {
        lanes_to_world(x->at[i].R, x->at[i].v, x->at[i].slope);
    }
    place_all(x);
}

void strain_form_place(strain_form *x)
{
    find_places(x);
}

FOR_EACH_PROCESSOR static void take_angles(strain_form *x)
{
    turn_all(x);
    measure_angles(x);
    for (int k = 0; k < x->rub_count; k++) {
        memcpy(x->rubs[k].angle, x->rubs[k].measured, (size_t)x->nodes * sizeof(lanes));
    }
}

void strain_form_rub(strain_form *x)
{
    if (x->rub_count > 0) {
        take_angles(x);
    }
}

static void clear_edges(strain_form *x)
{
    for (int e = 0; e <= x->kind.elements; e++) { /* what is not loaded stays 0 */
        strain_edge *edge = &x->edges[e];
        memset(edge->force, 0, sizeof edge->force);
        memset(edge->moment, 0, sizeof edge->moment);
        memset(edge->by_turn, 0, sizeof edge->by_turn);
    }
}

void strain_form_shape(strain_form *x)
{
    clear_edges(x);
    find_shape(x);
}

void strain_form_strain(strain_form *x)
{
    clear_edges(x);
    find_strains(x);
}

/* ---- steps --------------------------------------------------------------------------------- */

static void subtract(lanes *from, const lanes *step, const lanes *share)
{
    for (int c = 0; c < 3; c++) {
        from[c] -= *share * step[c];
    }
}

FOR_EACH_PROCESSOR static void move(strain_form *x, const lanes *step, const lanes *share)
{
    for (int i = 0; i < x->nodes; i++) {
        subtract(x->at[i].u, step + 3 * i, share);
        if (x->push_at >= 0) {
            subtract(x->at[i].push, step + x->push_at + 3 * i, share);
        }
    }
    for (int k = 0; k < x->place_count; k++) {
        if (x->places[k].unknown >= 0) {
            subtract(x->places[k].force, step + x->places[k].unknown, share);
        }
    }
    for (int k = 0; k < x->rub_count; k++) {
        for (int i = 0; i < x->nodes; i++) {
            x->rubs[k].angle[i] -= *share * step[angle_at(x, i, k)];
        }
    }
    for (int k = 0; k < x->tension_count; k++) {
        x->tensions[k].pull -= *share * step[x->tension_at + k];
    }
    if (x->force_at >= 0) {
        subtract(x->end_force, step + x->force_at, share);
    }
    if (x->moment_at >= 0) {
        subtract(x->end_moment, step + x->moment_at, share);
    }
    if (x->shift_at >= 0) {
        subtract(x->start_r, step + x->shift_at, share);
    }
    if (x->turn_at >= 0) {
        lanes turn[3], q[4], next[4];
        for (int c = 0; c < 3; c++) {
            turn[c] = -*share * step[x->turn_at + c];
        }
        exponential(turn, q);
        lanes_quaternion_product(q, x->start_q, next);
        memcpy(x->start_q, next, sizeof next);
        normalise(x->start_q);
    }
}

void strain_form_move(strain_form *x, const lanes *step, const lanes *share)
{
    move(x, step, share);
}
