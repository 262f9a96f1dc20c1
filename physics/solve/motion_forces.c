/* Forces on the nodes of a rod, and their accelerations. */
#include "physics/solve/motion_internal.h"

#include "physics/solve/quaternion.h"

#include <math.h>
#include <string.h>

/* ---- internal forces ----------------------------------------------------------------------- */

/* y [n][LANES] = matrix [n][n] x. Sums have the same order, so the same bits, on any processor. */
FOR_EACH_PROCESSOR static void apply(int n, const double *matrix, double (*x)[LANES],
                                     double (*y)[LANES])
{
    for (int i = 0; i < n; i += 2) { /* two rows at once: a sum waits for its last addition */
        const double *row = matrix + i * n, *next = i + 1 < n ? row + n : row;
        lanes sum = {0}, next_sum = {0};
        for (int j = 0; j < n; j++) {
            lanes at = *(const lanes *)x[j];
            sum += row[j] * at;
            next_sum += next[j] * at;
        }
        memcpy(y[i], &sum, sizeof sum);
        if (i + 1 < n) {
            memcpy(y[i + 1], &next_sum, sizeof next_sum);
        }
    }
}

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

void motion_set_nodes(motion *m, const double *state)
{
    for (size_t i = 0; i < m->nodes; i++) {
        set_node(m, i, state + i * MOTION_ROWS);
    }
    for (int end = 0; end < 2; end++) {
        size_t i = motion_end_node(m, end);
        if (m->rod->ends[end].holds_position) {
            memcpy(m->pose[i], m->ends[end].position, 3 * sizeof(double));
            memcpy(m->flow[i], m->ends[end].velocity, 3 * sizeof(double));
        }
        if (m->rod->ends[end].holds_rotation) {
            memcpy(m->pose[i] + MOTION_LANE_Q, m->ends[end].rotation, 4 * sizeof(double));
            memcpy(m->spin[i], m->ends[end].spin, 3 * sizeof(double));
        }
    }
    for (size_t i = 0; i < m->nodes; i++) {
        const double *w = m->spin[i], half[3] = {0.5 * w[0], 0.5 * w[1], 0.5 * w[2]};
        quaternion_times_vector(m->pose[i] + MOTION_LANE_Q, half, m->flow[i] + MOTION_LANE_Q);
        rotation_matrix(m->pose[i] + MOTION_LANE_Q, m->R[i]);
    }
}

/* Rates of strain: v_t = R^T V_s + v x w, u_t = 2 vec(q_t* q_s + q* q_ts). */
static void add_damping(const motion *m, size_t node, const double *slope, const double *rate,
                        motion_strained *at)
{
    const solve_section *section = &m->materials[node].section;
    double v_t[3], turning[3], p[4], p_t[4];
    double(*R)[3] = m->R[node];
    to_body(R, rate, v_t);
    vector_cross(at->v, m->spin[node], turning);
    quaternion_quotient(m->flow[node] + MOTION_LANE_Q, slope + MOTION_LANE_Q, p);
    quaternion_quotient(m->pose[node] + MOTION_LANE_Q, rate + MOTION_LANE_Q, p_t);
    for (int i = 0; i < 3; i++) {
        at->n[i] += section->strain_damping[i] * (v_t[i] + turning[i]);
        at->m[i] += section->curvature_damping[i] * 2 * (p[i + 1] + p_t[i + 1]);
    }
}

/* Strains, n and m at point k of an element; what they exert there, times the quadrature's weight:
 * `wrench` on r_s and q_s, m->torque on q itself. */
static void section_at(motion *m, size_t node, int k, motion_strained *at, double *wrench)
{
    const solve_section *section = &m->materials[node].section;
    const solve_rest *rest = &m->rest[node];
    const double *slope = m->slope[k], *q = m->pose[node] + MOTION_LANE_Q;
    double(*R)[3] = m->R[node];
    double p[4], cross_n[3], cross_m[3], weight = m->element_weight[k];
    to_body(R, slope, at->v);
    quaternion_quotient(q, slope + MOTION_LANE_Q, p);
    for (int i = 0; i < 3; i++) {
        at->u[i] = 2 * p[i + 1];
        at->n[i] = section->strain_stiffness[i] * (at->v[i] - rest->strain[i]);
        at->m[i] = section->curvature_stiffness[i] * (at->u[i] - rest->curvature[i]);
    }
    if (m->is_damped) {
        add_damping(m, node, slope, m->slope_rate[k], at);
    }
    to_world(R, at->n, wrench);
    quaternion_times_vector(q, at->m, wrench + MOTION_LANE_Q);
    wrench[LANES - 1] = 0;
    for (int i = 0; i < LANES; i++) {
        wrench[i] *= weight;
    }
    /* vec(q* q_s) varies by -vec(turn p) with q itself: torque p_0 m + u/2 x m */
    vector_cross(at->v, at->n, cross_n);
    vector_cross(at->u, at->m, cross_m);
    for (int i = 0; i < 3; i++) {
        m->torque[node][i] += weight * (p[0] * at->m[i] + 0.5 * cross_m[i] + cross_n[i]);
    }
}

void motion_internal_forces(motion *m)
{
    int n = m->degree + 1;
    memset(m->force, 0, m->nodes * sizeof *m->force);
    memset(m->torque, 0, m->nodes * sizeof *m->torque);
    for (int e = 0; e < m->elements; e++) {
        size_t first = (size_t)(e * m->degree);
        apply(n, m->derivative, m->pose + first, m->slope);
        if (m->is_damped) {
            apply(n, m->derivative, m->flow + first, m->slope_rate);
        }
        for (int k = 0; k < n; k++) {
            section_at(m, first + (size_t)k, k, &m->sections[e * n + k], m->wrench[k]);
        }
        apply(n, m->transposed, m->wrench, m->slope);
        for (int j = 0; j < n; j++) {
            for (int i = 0; i < LANES; i++) {
                m->force[first + (size_t)j][i] -= m->slope[j][i];
            }
        }
    }
    for (size_t i = 0; i < m->nodes; i++) {
        double turn[4];
        quaternion_quotient(m->pose[i] + MOTION_LANE_Q, m->force[i] + MOTION_LANE_Q, turn);
        for (int k = 0; k < 3; k++) {
            m->torque[i][k] += turn[k + 1];
        }
    }
}

/* ---- loads --------------------------------------------------------------------------------- */

/* Where it fails the rate is not a number, and so the step. */
static void resist(motion *m)
{
    ad_error ignored;
    for (size_t i = 0; i < m->nodes; i++) {
        memcpy(m->velocity[i], m->flow[i], sizeof m->velocity[i]);
    }
    if (solve_rod_resistance(m->rod, m->nodes, m->s, m->time, (const double(*)[3])m->velocity,
                             m->resistance, &ignored) != AD_OK) {
        m->resistance[0][0] = NAN;
    }
    for (size_t i = 0; i < m->nodes; i++) {
        for (int k = 0; k < 3; k++) {
            m->push[i][k] -= m->weight[i] * m->resistance[i][k];
        }
    }
}

void motion_outside_forces(motion *m)
{
    for (size_t i = 0; i < m->nodes; i++) {
        const solve_load *load = &m->load[i];
        double force[3] = {0}, moment[3];
        if (m->rod->has_body_load) {
            to_world(m->R[i], load->body_force, force);
        }
        to_body(m->R[i], load->moment, moment);
        for (int k = 0; k < 3; k++) {
            m->push[i][k] = m->weight[i] * (load->force[k] + force[k]);
            m->turn[i][k] = m->weight[i] * (moment[k] + load->body_moment[k]);
        }
    }
    for (int end = 0; end < 2; end++) {
        const solve_end *given = &m->rod->ends[end];
        const solve_end_state *now = &m->ends[end];
        size_t i = motion_end_node(m, end);
        double force[3], moment[3], sign = end ? 1 : -1;
        to_world(m->R[i], now->force, force);
        to_body(m->R[i], now->moment, moment);
        for (int k = 0; k < 3; k++) {
            m->push[i][k] += given->holds_position
                                 ? 0
                                 : sign * (given->force_is_body ? force[k] : now->force[k]);
            m->turn[i][k] += given->holds_rotation
                                 ? 0
                                 : sign * (given->moment_is_body ? now->moment[k] : moment[k]);
        }
    }
    if (m->rod->resists) {
        resist(m);
    }
}

void motion_rate(motion *m, const double *state, double *rate)
{
    motion_set_nodes(m, state);
    motion_internal_forces(m);
    motion_outside_forces(m);
    for (size_t i = 0; i < m->nodes; i++) {
        double *to = rate + i * MOTION_ROWS, by = 1 / m->weight[i], gyroscopic[3];
        const motion_material *made = &m->materials[i];
        const double *w = m->spin[i], *q = state + i * MOTION_ROWS + MOTION_Q;
        const double *inertia = made->section.rotary_inertia;
        const double half[3] = {0.5 * w[0], 0.5 * w[1], 0.5 * w[2]};
        const double momentum[3] = {inertia[0] * w[0], inertia[1] * w[1], inertia[2] * w[2]};
        vector_cross(w, momentum, gyroscopic);
        quaternion_times_vector(q, half, to + MOTION_Q);
        for (int k = 0; k < 3; k++) {
            to[MOTION_R + k] = m->flow[i][k];
            to[MOTION_V + k] = by * (m->force[i][k] + m->push[i][k]) * made->by_mass;
            to[MOTION_W + k] =
                (by * (m->torque[i][k] + m->turn[i][k]) - gyroscopic[k]) * made->by_inertia[k];
        }
    }
    for (int end = 0; end < 2; end++) {
        double *to = rate + motion_end_node(m, end) * MOTION_ROWS;
        for (int row = 0; row < MOTION_ROWS; row++) {
            to[row] = motion_is_held(m, motion_end_node(m, end), row) ? 0 : to[row];
        }
    }
}
