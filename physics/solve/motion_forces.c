/* Forces on the nodes of a rod, and their accelerations. */
#include "physics/solve/motion_internal.h"

#include "physics/law/law_numbers.h"
#include "physics/law/laws_lanes.h"
#include "physics/local/lobatto.h"
#include "physics/numerics/quaternion.h"

#include <math.h>
#include <string.h>

/* ---- internal forces ----------------------------------------------------------------------- */

static void set_node(motion *m, size_t node, const double *state)
{
    double *pose = m->pose[node], *flow = m->flow[node], *spin = m->spin[node];
    memcpy(pose + MOTION_LANE_Q, state + MOTION_Q, 4 * sizeof(double));
    quaternion_normalize(pose + MOTION_LANE_Q);
    for (int k = 0; k < 3; k++) {
        pose[k] = state[MOTION_R + k];
        flow[k] = state[MOTION_V + k];
        spin[k] = state[MOTION_W + k];
    }
}

void motion_hold_ends(motion *m)
{
    for (int end = 0; end < 2; end++) {
        size_t i = motion_end_node(m, end);
        motion_hold_part(m, end, m->ends[end].position, m->ends[end].velocity, m->pose[i],
                         m->flow[i]);
        if (m->rod->ends[end].holds_rotation) {
            memcpy(m->pose[i] + MOTION_LANE_Q, m->ends[end].rotation, 4 * sizeof(double));
            memcpy(m->spin[i], m->ends[end].spin, 3 * sizeof(double));
        }
    }
}

/* Those of branches, from behind the nodes. */
static void set_memory(motion *m, const double *memory)
{
    for (int b = 0; b < m->elements * m->blocks; b++) {
        for (int lane = 0; lane < LANES; lane++) {
            const int k = b % m->blocks * LANES + lane, last = k < m->degree ? k : m->degree;
            const size_t point = (size_t)(b / m->blocks) * ((size_t)m->degree + 1) + (size_t)last;
            for (int i = 0; i < MOTION_STRAINS; i++) {
                m->block[b].memory[i][lane] = memory[point * MOTION_STRAINS + (size_t)i];
            }
        }
    }
}

void motion_set_nodes(motion *m, const double *state)
{
    if (m->has_branch) {
        set_memory(m, state + m->nodes * MOTION_ROWS);
    }
    for (size_t i = 0; i < m->nodes; i++) {
        set_node(m, i, state + i * MOTION_ROWS);
    }
    motion_hold_ends(m);
    for (size_t i = 0; i < m->nodes; i++) {
        const double *w = m->spin[i], half[3] = {0.5 * w[0], 0.5 * w[1], 0.5 * w[2]};
        quaternion_times_vector(m->pose[i] + MOTION_LANE_Q, half, m->flow[i] + MOTION_LANE_Q);
    }
}

/* slope [MOTION_LANES] of poses (or flows) of an element's nodes, at the points of a block, where
 * the element has length 2. */
PROCESSOR_INLINE void differentiate(const motion *m, int block, const double (*pose)[LANES],
                                    lanes slope[MOTION_LANES])
{
    int stride = m->blocks * LANES;
    for (int c = 0; c < MOTION_LANES; c++) {
        slope[c] = (lanes){0};
    }
    for (int j = 0; j <= m->degree; j++) {
        lanes by = *(const lanes *)(m->derivative + j * stride + block * LANES);
        for (int c = 0; c < MOTION_LANES; c++) {
            slope[c] += by * pose[j][c];
        }
    }
}

/* Components `first` to `first + count` of rows [degree + 1] at the points of a block. */
PROCESSOR_INLINE void gather(const motion *m, int block, int first, int count,
                             const double (*rows)[LANES], lanes *to)
{
    const double *row[LANES];
    for (int lane = 0; lane < LANES; lane++) {
        int k = block * LANES + lane;
        row[lane] = rows[k < m->degree ? k : m->degree] + first;
    }
    for (int c = 0; c < count; c++) {
        to[c] = LANES_OF(row, c);
    }
}

/* Strain and stress of an element, without damping. */
FOR_EACH_PROCESSOR static void strain_element(motion *m, int element)
{
    double room[LOBATTO_DEGREE_MAX + 1][LANES];
    const double(*pose)[LANES] = motion_rows_of(m, element, m->pose, room);
    const double scale = 2 / (m->edge[element + 1] - m->edge[element]);
    for (int b = 0; b < m->blocks; b++) {
        motion_block *at = &m->block[element * m->blocks + b];
        lanes slope[MOTION_LANES], R[3][3], p[4], off[MOTION_STRAINS];
        differentiate(m, b, pose, slope);
        for (int c = 0; c < MOTION_LANES; c++) {
            slope[c] *= scale;
        }
        gather(m, b, MOTION_LANE_Q, 4, pose, at->q);
        lanes_rotation_matrix(at->q, R);
        lanes_to_body(R, slope, at->strain);
        lanes_quaternion_quotient(at->q, slope + MOTION_LANE_Q, p);
        at->along = p[0];
        for (int i = 0; i < 3; i++) {
            at->strain[MOTION_U + i] = 2 * p[i + 1];
        }
        for (int i = 0; i < MOTION_STRAINS; i++) {
            off[i] = at->strain[i] - at->rest[i];
        }
        memset(at->stress, 0, sizeof at->stress);
        lanes_law_elastic_wrench(off, off + MOTION_U, at->stiffness, at->stress);
    }
}

void motion_branch_stress(const motion *m, const motion_block *at, lanes stress[MOTION_STRAINS])
{
    lanes off[MOTION_STRAINS], branch[MOTION_STRAINS];
    const lanes softer = 1 / (1 + m->following * at->relaxing);
    for (int i = 0; i < MOTION_STRAINS; i++) {
        off[i] = at->strain[i] - at->rest[i] - at->memory[i];
        branch[i] = softer * at->branch[i];
    }
    lanes_law_elastic_wrench(off, off + MOTION_U, branch, stress);
}

/* Strains of a lane. */
static void strains_of(const motion_block *at, int lane, double strains[MOTION_STRAINS])
{
    for (int i = 0; i < MOTION_STRAINS; i++) {
        strains[i] = at->strain[i][lane];
    }
}

/* And of a law beyond the stiffness. */
static void bend_element(motion *m, int element)
{
    for (int k = 0; k <= m->degree; k++) {
        motion_block *at = motion_block_of(m, element, k);
        const int lane = k % LANES;
        double strains[ACTUATION_ROWS], wrench[ACTUATION_ROWS];
        const solve_actuation law = {.law = m->rod->scene.rod.law,
                                     .length = m->rod->scales.length,
                                     .unit_force = m->rod->scales.force,
                                     .rest =
                                         (const double *)&m->rest[element * (m->degree + 1) + k]};
        strains_of(at, lane, strains);
        at->law_energy[lane] = solve_law_energy(&law, strains, wrench, NULL);
        for (int i = 0; i < MOTION_STRAINS; i++) {
            at->law[i][lane] = wrench[i];
            at->stress[i][lane] += wrench[i];
        }
    }
}

/* Rates of strain: v_t = R^T V_s + v x w, u_t = 2 vec(q_t* q_s + q* q_ts). */
FOR_EACH_PROCESSOR static void damp_element(motion *m, int element)
{
    double room[2][LOBATTO_DEGREE_MAX + 1][LANES];
    const double(*pose)[LANES] = motion_rows_of(m, element, m->pose, room[0]);
    const double(*flow)[LANES] = motion_rows_of(m, element, m->flow, room[1]);
    const double scale = 2 / (m->edge[element + 1] - m->edge[element]);
    for (int b = 0; b < m->blocks; b++) {
        motion_block *at = &m->block[element * m->blocks + b];
        lanes slope[MOTION_LANES], rate[MOTION_LANES], R[3][3], v_t[3], turning[3];
        lanes spin[4], q_t[4] = {{0}}, p[4], p_t[4];
        differentiate(m, b, pose, slope);
        differentiate(m, b, flow, rate);
        gather(m, b, MOTION_LANE_Q, 4, flow, q_t);
        lanes_quaternion_quotient(at->q, q_t, spin);
        for (int i = 1; i < 4; i++) {
            spin[i] *= 2;
        }
        lanes_rotation_matrix(at->q, R);
        lanes_to_body(R, rate, v_t);
        lanes_vector_cross(at->strain, spin + 1, turning);
        lanes_quaternion_quotient(q_t, slope + MOTION_LANE_Q, p);
        lanes_quaternion_quotient(at->q, rate + MOTION_LANE_Q, p_t);
        for (int i = 0; i < 3; i++) {
            at->rate[i] = scale * v_t[i] + turning[i];
            at->rate[MOTION_U + i] = 2 * scale * (p[i + 1] + p_t[i + 1]);
        }
        lanes_law_damping_wrench(at->rate, at->rate + MOTION_U, at->damping, at->stress);
    }
}

/* Actuators at point k of an element, and its strains. */
static solve_actuation actuation_at(const motion *m, int element, int k, double *strains)
{
    const motion_block *at = motion_block_of(m, element, k);
    const int lane = k % LANES;
    const size_t point = (size_t)element * (m->degree + 1) + k;
    solve_actuation pulling = solve_actuation_at(m->rod, m->actuators, point, m->point_s[point], 1);
    pulling.tensions = m->tensions;
    strains_of(at, lane, strains);
    return pulling;
}

/* Tensions of tendons whose length is given, by how much longer they are; none pushes. */
static void set_tensions(motion *m)
{
    double longer[SOLVE_ACTUATORS_MAX] = {0};
    for (size_t point = 0; point < m->points; point++) {
        int element = (int)point / (m->degree + 1), k = (int)point % (m->degree + 1);
        double strains[ACTUATION_ROWS], rest[ACTUATION_ROWS];
        const solve_actuation pulling = actuation_at(m, element, k, strains);
        memcpy(rest, m->rest[point].strain, 3 * sizeof *rest);
        memcpy(rest + 3, m->rest[point].curvature, 3 * sizeof *rest);
        for (int i = 0; i < m->rod->actuators; i++) {
            if (m->rod->extents[i].has_length) {
                longer[i] +=
                    m->point_weight[point] * (solve_actuation_length(&pulling, i, strains) -
                                              solve_actuation_length(&pulling, i, rest));
            }
        }
    }
    for (int i = 0; i < m->rod->actuators; i++) {
        if (m->rod->extents[i].has_length) {
            m->tensions[i] =
                fmax(0, (longer[i] + m->displacement[i]) / m->rod->extents[i].compliance);
        }
    }
}

/* n and m of actuators of an element. */
static void pull_element(motion *m, int element)
{
    for (int k = 0; k <= m->degree; k++) {
        motion_block *at = motion_block_of(m, element, k);
        const int lane = k % LANES;
        double strains[ACTUATION_ROWS], wrench[ACTUATION_ROWS];
        const solve_actuation pulling = actuation_at(m, element, k, strains);
        solve_actuation_wrench(&pulling, strains, wrench, NULL);
        for (int i = 0; i < MOTION_STRAINS; i++) {
            at->pull[i][lane] = wrench[i];
        }
    }
}

/* What n and m exert on r_s and q_s at the points of an element, times weights: m->wrench. And
 * torque [blocks][3] on q itself: vec(q* q_s) varies by -vec(turn p), so p_0 m + u/2 x m. */
PROCESSOR_INLINE void wrench_of(motion *m, int element, int block, lanes torque[3])
{
    const motion_block *at = &m->block[element * m->blocks + block];
    const lanes *n = at->stress, *moment = at->stress + MOTION_U, *u = at->strain + MOTION_U;
    const double scale = 2 / (m->edge[element + 1] - m->edge[element]);
    int stride = m->blocks * LANES;
    lanes R[3][3], q[4], wrench[MOTION_LANES], cross_n[3], cross_m[3], weight = at->weight;
    memcpy(q, at->q, sizeof q);
    lanes_rotation_matrix(q, R);
    lanes_to_world(R, n, wrench);
    lanes_quaternion_times_vector(q, moment, wrench + MOTION_LANE_Q);
    for (int c = 0; c < MOTION_LANES; c++) {
        *(lanes *)(m->wrench + c * stride + block * LANES) = scale * weight * wrench[c];
    }
    lanes_vector_cross(at->strain, n, cross_n);
    lanes_vector_cross(u, moment, cross_m);
    for (int i = 0; i < 3; i++) {
        torque[i] = weight * (at->along * moment[i] + 0.5 * cross_m[i] + cross_n[i]);
    }
}

/* A torque at point k of an element, added to that of its node. */
static inline void add_torque(motion *m, int element, int k, const double torque[3])
{
    const double *frame = motion_frame_of(m, element, k);
    double R[3][3], turned[3], *to = m->torque[element * m->degree + k];
    if (frame) {
        rotation_matrix(frame, R);
        to_world(R, torque, turned);
    }
    for (int i = 0; i < 3; i++) {
        to[i] += frame ? turned[i] : torque[i];
    }
}

/* Forces on the nodes of an element, added to the others'. */
FOR_EACH_PROCESSOR static void push_element(motion *m, int element)
{
    enum { BLOCKS_MAX = LOBATTO_DEGREE_MAX / LANES + 1 };
    lanes torque[BLOCKS_MAX][3];
    int stride = m->blocks * LANES;
    for (int b = 0; b < m->blocks; b++) {
        wrench_of(m, element, b, torque[b]);
    }
    for (int b = 0; b < m->blocks; b++) {
        lanes force[MOTION_LANES], turn[4], q[4];
        for (int c = 0; c < MOTION_LANES; c++) {
            force[c] = (lanes){0};
        }
        for (int j = 0; j <= m->degree; j++) {
            lanes by = *(const lanes *)(m->transposed + j * stride + b * LANES);
            for (int c = 0; c < MOTION_LANES; c++) {
                force[c] -= by * m->wrench[c * stride + j];
            }
        }
        memcpy(q, m->block[element * m->blocks + b].q, sizeof q);
        lanes_quaternion_quotient(q, force + MOTION_LANE_Q, turn);
        for (int lane = 0; lane < LANES && b * LANES + lane <= m->degree; lane++) {
            const int k = b * LANES + lane;
            double total[3];
            for (int i = 0; i < 3; i++) {
                m->force[element * m->degree + k][i] += force[i][lane];
                total[i] = torque[b][i][lane] + turn[i + 1][lane];
            }
            add_torque(m, element, k, total);
        }
    }
}

static void clear_forces(motion *m)
{
    memset(m->force, 0, m->nodes * sizeof *m->force);
    memset(m->torque, 0, m->nodes * sizeof *m->torque);
}

/* What actuators exert on nodes, for their power. */
static void pull_nodes(motion *m)
{
    clear_forces(m);
    for (int e = 0; e < m->elements; e++) {
        strain_element(m, e);
    }
    if (m->rod->lengths > 0) {
        set_tensions(m);
    }
    for (int e = 0; e < m->elements; e++) {
        pull_element(m, e);
        for (int b = e * m->blocks; b < (e + 1) * m->blocks; b++) {
            memcpy(m->block[b].stress, m->block[b].pull, sizeof m->block[b].stress);
        }
        push_element(m, e);
    }
    memcpy(m->pull_force, m->force, m->nodes * sizeof *m->force);
    memcpy(m->pull_torque, m->torque, m->nodes * sizeof *m->torque);
}

static void add_pull(motion *m, int element)
{
    for (int b = element * m->blocks; b < (element + 1) * m->blocks; b++) {
        for (int i = 0; i < MOTION_STRAINS; i++) {
            m->block[b].stress[i] += m->block[b].pull[i];
        }
    }
}

double motion_pull_power(const motion *m)
{
    double power = 0;
    for (size_t i = 0; i < m->nodes && m->is_pulled; i++) {
        power +=
            vector_dot(m->pull_force[i], m->flow[i]) + vector_dot(m->pull_torque[i], m->spin[i]);
    }
    return power;
}

/* ---- what acts along the rod --------------------------------------------------------------- */

size_t motion_section_at(const motion *m, size_t i, double q[4], acting_on *at)
{
    const size_t n = (size_t)m->degree + 1, node = i / n * (n - 1) + i % n;
    const double *frame = motion_frame_of(m, (int)(i / n), (int)(i % n));
    const double *own = m->pose[node] + MOTION_LANE_Q;
    if (frame) {
        quaternion_product(own, frame, q);
    }
    *at = (acting_on){m->pose[node], frame ? q : own, m->flow[node]};
    return node;
}

static void act_along(motion *m, int kinds, double (*force)[3], double (*torque)[3])
{
    const acting *along = &m->rod->along;
    for (size_t i = 0; i < m->points && (kinds & along->kinds); i++) {
        double q[4], wrench[6] = {0}, R[3][3], moment[3];
        acting_on at;
        const size_t node = motion_section_at(m, i, q, &at);
        acting_wrench(along, m->along + i * (size_t)along->numbers, at, kinds, m->point_weight[i],
                      wrench);
        for (int k = 0; k < 3; k++) {
            force[node][k] += wrench[k];
        }
        if (along->has_moment) {
            rotation_matrix(m->pose[node] + MOTION_LANE_Q, R);
            to_body(R, wrench + 3, moment);
            for (int k = 0; k < 3; k++) {
                torque[node][k] += moment[k];
            }
        }
    }
}

double motion_along_energy(const motion *m)
{
    const acting *along = &m->rod->along;
    double energy = 0;
    for (size_t i = 0; i < m->points && along->count > 0; i++) {
        double q[4];
        acting_on at;
        motion_section_at(m, i, q, &at);
        energy +=
            m->point_weight[i] * acting_energy(along, m->along + i * (size_t)along->numbers, at);
    }
    return energy;
}

void motion_internal_forces(motion *m)
{
    if (m->is_pulled) {
        pull_nodes(m);
    }
    clear_forces(m);
    for (int e = 0; e < m->elements; e++) {
        strain_element(m, e);
        if (m->rod->scene.rod.law) {
            bend_element(m, e);
        }
        if (m->is_damped) {
            damp_element(m, e);
        }
        for (int b = e * m->blocks; m->has_branch && b < (e + 1) * m->blocks; b++) {
            motion_branch_stress(m, &m->block[b], m->block[b].stress);
        }
        if (m->is_pulled) {
            add_pull(m, e);
        }
        push_element(m, e);
    }
    motion_act_at_places(m, ACTING_STORES, m->force, m->torque);
    act_along(m, ACTING_STORES, m->force, m->torque);
}

/* ---- loads --------------------------------------------------------------------------------- */

void motion_find_resistance(motion *m)
{
    const acting *along = &m->rod->along;
    for (size_t i = 0; i < m->points; i++) {
        double q[4], wrench[6] = {0};
        acting_on at;
        const size_t node = motion_section_at(m, i, q, &at);
        acting_wrench(along, m->along + i * (size_t)along->numbers, at, ACTING_DISSIPATES, -1,
                      wrench);
        memcpy(m->velocity[i], m->flow[node], sizeof m->velocity[i]);
        memcpy(m->resistance[i], wrench, sizeof m->resistance[i]);
    }
}

static void resist(motion *m)
{
    const size_t n = (size_t)m->degree + 1;
    motion_find_resistance(m);
    for (size_t i = 0; i < m->points; i++) {
        for (int k = 0; k < 3; k++) {
            m->push[i / n * (n - 1) + i % n][k] -= m->point_weight[i] * m->resistance[i][k];
        }
    }
}

void motion_loads(motion *m)
{
    memset(m->push, 0, m->nodes * sizeof *m->push);
    memset(m->turn, 0, m->nodes * sizeof *m->turn);
    motion_act_at_places(m, ACTING_LOADS, m->push, m->turn);
    act_along(m, ACTING_LOADS, m->push, m->turn);
}

void motion_outside_forces(motion *m)
{
    motion_loads(m);
    if (m->rod->along.by_velocity) {
        resist(m);
    }
}

/* ---- rates --------------------------------------------------------------------------------- */

/* z_t [points][MOTION_STRAINS]. */
static void remember(const motion *m, double *rate)
{
    const int n = m->degree + 1;
    for (size_t point = 0; point < m->points; point++) {
        const int k = (int)point % n, lane = k % LANES;
        const motion_block *at = motion_block_of(m, (int)point / n, k);
        for (int i = 0; i < MOTION_STRAINS; i++) {
            rate[point * MOTION_STRAINS + (size_t)i] =
                at->relaxing[lane] *
                (at->strain[i][lane] - at->rest[i][lane] - at->memory[i][lane]);
        }
    }
}

void motion_rate_following(motion *m, double gamma, const double *state, double *rate)
{
    m->following = gamma;
    motion_rate(m, state, rate);
    m->following = 0;
}

void motion_rate(motion *m, const double *state, double *rate)
{
    motion_set_nodes(m, state);
    motion_internal_forces(m);
    motion_outside_forces(m);
    if (m->has_branch) {
        remember(m, rate + m->nodes * MOTION_ROWS);
    }
    if (m->has_added) {
        motion_find_added(m);
    }
    for (size_t i = 0; i < m->nodes; i++) {
        static const double none[3] = {0};
        double *to = rate + i * MOTION_ROWS, wrench[6], resists[6] = {0}; /* -w x J w */
        const double *w = m->spin[i], *q = state + i * MOTION_ROWS + MOTION_Q;
        const double half[3] = {0.5 * w[0], 0.5 * w[1], 0.5 * w[2]};
        number_law_rotary_inertia_wrench(none, w, none, none, m->inertia[i], resists);
        quaternion_times_vector(q, half, to + MOTION_Q);
        for (int k = 0; k < 3; k++) {
            wrench[k] = m->force[i][k] + m->push[i][k];
            wrench[3 + k] = m->torque[i][k] + m->turn[i][k] + resists[3 + k];
            to[MOTION_R + k] = m->flow[i][k];
            to[MOTION_V + k] = wrench[k] * m->by_mass[i];
            to[MOTION_W + k] = wrench[3 + k] * m->by_inertia[i][k];
        }
        if (m->has_added && m->added[i].any) {
            double acceleration[6];
            motion_accelerate(m, i, wrench, acceleration);
            memcpy(to + MOTION_V, acceleration, 3 * sizeof *to);
            memcpy(to + MOTION_W, acceleration + 3, 3 * sizeof *to);
        }
    }
    for (int end = 0; end < 2; end++) {
        static const double still[3] = {0};
        double *to = rate + motion_end_node(m, end) * MOTION_ROWS;
        motion_hold_part(m, end, still, still, to + MOTION_R, to + MOTION_V);
        if (m->rod->ends[end].holds_rotation) {
            memset(to + MOTION_Q, 0, 4 * sizeof *to);
            memset(to + MOTION_W, 0, 3 * sizeof *to);
        }
    }
}
