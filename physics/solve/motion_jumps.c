/* What acts at single places of a rod in motion: loads, springs, bodies, joints. */
#include "autodiff/dense.h"
#include "physics/local/mesh.h"
#include "physics/numerics/quaternion.h"
#include "physics/solve/motion_internal.h"

#include <math.h>
#include <string.h>

/* ---- places -------------------------------------------------------------------------------- */

ad_status motion_place_jumps(motion *m, ad_error *error)
{
    const solve_jumps *jumps = &m->rod->jumps;
    int edge = 0;
    for (int k = 0; k < jumps->count; k++) {
        while (edge < m->elements && m->edge[edge] < jumps->at[k].s - SOLVE_SAME_PLACE) {
            edge++;
        }
        if (fabs(m->edge[edge] - jumps->at[k].s) > SOLVE_SAME_PLACE) {
            return ad_fail(error, AD_BAD_ARGUMENT, "s = %g, where something acts, is no edge",
                           jumps->at[k].s);
        }
        m->places[k] = (motion_place){
            .edge = edge, .node = (size_t)(edge * m->degree), .before = {1}, .after = {1}};
    }
    return AD_OK;
}

/* ---- bodies and joints --------------------------------------------------------------------- */

/* Of a symmetric matrix: eigenvalues, and the rotation p whose columns are the eigenvectors, so
 * that matrix = R(p) diag(values) R(p)^T. */
static void principal_axes(double a[3][3], double values[3], double p[4])
{
    double axes[3][3], third[3];
    ad_dense_diagonalize(3, a[0], axes[0]);
    vector_cross(axes[0], axes[1], third);
    for (int i = 0; i < 3; i++) {
        values[i] = a[i][i];
        axes[2][i] = third[i]; /* right-handed */
    }
    quaternion_of_matrix((const double(*)[3])axes, p);
    for (int i = 1; i < 4; i++) { /* axes are rows */
        p[i] = -p[i];
    }
}

/* The elements that meet at a joint turn with one rigid node, whose inertia is the sum of theirs.
 * Its frame is that of the principal axes. */
static void set_joint(motion *m, int k)
{
    const solve_jump *jump = &m->rod->jumps.at[k];
    const inertia body = solve_jump_body(&m->rod->jumps, m->rod->jumps.number, k);
    motion_place *place = &m->places[k];
    size_t n = (size_t)m->degree + 1, after = (size_t)place->edge * n, before = after - 1;
    double R[3][3], sum[3][3], p[4];
    rotation_matrix(jump->turn, R);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            sum[i][j] = i == j ? body.rotary[i] +
                                     m->point_weight[before] * m->made[before].rotary_inertia[i]
                               : 0;
            for (int c = 0; c < 3; c++) {
                sum[i][j] +=
                    R[i][c] * R[j][c] * m->point_weight[after] * m->made[after].rotary_inertia[c];
            }
        }
    }
    principal_axes(sum, m->inertia[place->node], p);
    const double back[4] = {p[0], -p[1], -p[2], -p[3]};
    memcpy(place->before, back, sizeof back);
    quaternion_product(back, jump->turn, place->after);
    place->turns = true;
    m->frame[place->edge - 1][1] = place->before;
    m->frame[place->edge][0] = place->after;
}

void motion_add_bodies(motion *m)
{
    const solve_jumps *jumps = &m->rod->jumps;
    for (int k = 0; k < jumps->count; k++) {
        const inertia body = solve_jump_body(jumps, jumps->number, k);
        size_t node = m->places[k].node;
        m->mass[node] += body.mass;
        for (int i = 0; i < 3; i++) {
            m->inertia[node][i] += body.rotary[i];
        }
        if (jumps->at[k].turns) {
            set_joint(m, k);
        }
    }
}

void motion_turn_node(const motion *m, int k, const double rotation[4], const double spin[3],
                      double *state)
{
    const motion_place *place = &m->places[k];
    const double *p = place->before, back[4] = {p[0], -p[1], -p[2], -p[3]};
    double *to = state + place->node * MOTION_ROWS, R[3][3];
    if (place->turns) {
        quaternion_product(rotation, back, to + MOTION_Q);
        rotation_matrix(p, R);
        to_world(R, spin, to + MOTION_W);
    }
}

ad_status motion_turn_initial(const motion *m, double *state, ad_error *error)
{
    ad_status status = AD_OK;
    for (int k = 0; k < m->rod->jumps.count && status == AD_OK; k++) {
        double before = m->rod->jumps.at[k].s * (1 - 1e-14);
        solve_initial given;
        if (m->places[k].turns) {
            status = solve_rod_initial(m->rod, 1, &before, &given, error);
            motion_turn_node(m, k, given.rotation, given.spin, state);
        }
    }
    return status;
}

const double (*motion_rows_of(const motion *m, int element, double (*nodes)[LANES],
                              double (*room)[LANES]))[LANES]
{
    const double *const *frame = m->frame[element];
    double(*rows)[LANES] = nodes + element * m->degree;
    if (!frame[0] && !frame[1]) {
        return (const double(*)[LANES])rows;
    }
    memcpy(room, rows, ((size_t)m->degree + 1) * sizeof *room);
    for (int side = 0; side < 2; side++) {
        if (frame[side]) {
            int k = side ? m->degree : 0;
            quaternion_product(rows[k] + MOTION_LANE_Q, frame[side], room[k] + MOTION_LANE_Q);
        }
    }
    return (const double(*)[LANES])room;
}

const double *motion_frame_of(const motion *m, int element, int k)
{
    return k == 0 ? m->frame[element][0] : k == m->degree ? m->frame[element][1] : NULL;
}

/* ---- forces -------------------------------------------------------------------------------- */

void motion_rotation_before(const motion *m, int k, double q[4])
{
    const double *node = m->pose[m->places[k].node] + MOTION_LANE_Q;
    if (m->places[k].turns) {
        quaternion_product(node, m->places[k].before, q);
    } else {
        memcpy(q, node, 4 * sizeof *q);
    }
}

/* A vector in the body frame before place k, in the frame of the node. */
static void to_node(const motion *m, int k, double vector[3])
{
    double R[3][3], turned[3];
    if (m->places[k].turns) {
        rotation_matrix(m->places[k].before, R);
        to_world(R, vector, turned);
        memcpy(vector, turned, sizeof turned);
    }
}

void motion_act_at_places(motion *m, int kinds, double (*force)[3], double (*torque)[3])
{
    const solve_jumps *jumps = &m->rod->jumps;
    for (int k = 0; k < jumps->count; k++) {
        const size_t node = m->places[k].node;
        double q[4], R[3][3], wrench[6] = {0}, moment[3];
        if (!(kinds & jumps->at[k].acting.kinds)) {
            continue;
        }
        motion_rotation_before(m, k, q);
        rotation_matrix(q, R);
        acting_wrench(&jumps->at[k].acting, solve_jump_numbers(jumps, m->number, k),
                      (acting_on){m->pose[node], q, m->flow[node]}, kinds, 1, wrench);
        to_body(R, wrench + 3, moment);
        to_node(m, k, moment);
        for (int c = 0; c < 3; c++) {
            force[node][c] += wrench[c];
            torque[node][c] += moment[c];
        }
    }
}

void motion_place_force(const motion *m, int k, double force[3])
{
    const solve_jumps *jumps = &m->rod->jumps;
    const size_t node = m->places[k].node;
    double q[4], wrench[6] = {0};
    motion_rotation_before(m, k, q);
    acting_wrench(&jumps->at[k].acting, solve_jump_numbers(jumps, m->number, k),
                  (acting_on){m->pose[node], q, m->flow[node]}, ACTING_ALL, 1, wrench);
    memcpy(force, wrench, 3 * sizeof *force);
}

double motion_places_energy(const motion *m)
{
    const solve_jumps *jumps = &m->rod->jumps;
    double energy = 0;
    for (int k = 0; k < jumps->count; k++) {
        double q[4];
        motion_rotation_before(m, k, q);
        energy += acting_energy(&jumps->at[k].acting, solve_jump_numbers(jumps, m->number, k),
                                (acting_on){m->pose[m->places[k].node], q, NULL});
    }
    return energy;
}
