/* Energy and power of a rod in motion, and its state between nodes. */
#include "physics/solve/motion_internal.h"

#include "physics/law/law_numbers.h"
#include "physics/local/lobatto.h"
#include "physics/numerics/quaternion.h"
#include "physics/numerics/sort.h"

#include <string.h>

/* ---- energy -------------------------------------------------------------------------------- */

/* By what the added inertia of an end's node resists. */
static void holding_added(const motion *m, int end, double wrench[6])
{
    const size_t i = motion_end_node(m, end);
    const solve_end *given = &m->rod->ends[end];
    static const double none[3] = {0};
    double acts[6], acceleration[6], held[3], resists[6] = {0};
    number_law_rotary_inertia_wrench(none, m->spin[i], none, none, m->inertia[i], resists);
    for (int k = 0; k < 3; k++) {
        acts[k] = m->force[i][k] + m->push[i][k];
        acts[3 + k] = m->torque[i][k] + m->turn[i][k] + resists[3 + k];
    }
    motion_accelerate(m, i, acts, acceleration);
    scene_hold_part(&given->hold, m->ends[end].acceleration, held);
    for (int k = 0; k < 3; k++) {
        acceleration[k] += held[k];
        acceleration[3 + k] += given->holds_rotation ? m->ends[end].spin_rate[k] : 0;
    }
    motion_added_wrench(m, i, acceleration, wrench);
}

/* Power of what holds an end: what its node's prescribed acceleration asks for beyond the rest. */
static double holding_power(const motion *m, int end)
{
    const solve_end *given = &m->rod->ends[end];
    const solve_end_state *now = &m->ends[end];
    size_t i = motion_end_node(m, end);
    const double *inertia = m->inertia[i], *w = now->spin;
    double power = 0, force[3], held[3], added[6] = {0};
    if (m->has_added) {
        holding_added(m, end, added);
    }
    for (int k = 0; k < 3; k++) {
        force[k] = m->mass[i] * now->acceleration[k] - m->force[i][k] - m->push[i][k] - added[k];
        double moment = inertia[k] * now->spin_rate[k] - m->torque[i][k] - m->turn[i][k];
        moment -= added[3 + k];
        power += given->holds_rotation ? moment * w[k] : 0; /* w x rhoJ w does no work */
    }
    scene_hold_part(&given->hold, force, held);
    return power + vector_dot(held, now->velocity);
}

/* Of all sections as they are: strain energy, the power that damping takes, and that which a
 * changing rest shape puts in. */
typedef struct section_sums {
    double energy, dissipation, reshaping;
} section_sums;

static void add_point(const motion *m, int element, int k, section_sums *sum)
{
    const motion_block *at = motion_block_of(m, element, k);
    const solve_rest *rest = &m->rest[element * (m->degree + 1) + k];
    const int lane = k % LANES;
    const double weight = at->weight[lane];
    double off[MOTION_STRAINS], rate[MOTION_STRAINS], stiffness[MOTION_STRAINS];
    double damping[MOTION_STRAINS], elastic[MOTION_STRAINS], viscous[MOTION_STRAINS] = {0};
    double energy = at->law_energy[lane];
    double stretched[MOTION_STRAINS], branch[MOTION_STRAINS], held[MOTION_STRAINS] = {0};
    for (int i = 0; i < MOTION_STRAINS; i++) {
        off[i] = at->strain[i][lane] - at->rest[i][lane];
        rate[i] = at->rate[i][lane];
        stiffness[i] = at->stiffness[i][lane];
        damping[i] = at->damping[i][lane];
        elastic[i] = at->law[i][lane];
        stretched[i] = off[i] - at->memory[i][lane];
        branch[i] = at->branch[i][lane];
    }
    number_law_elastic_energy(stretched, stretched + MOTION_U, branch, &energy);
    number_law_elastic_wrench(stretched, stretched + MOTION_U, branch, held);
    number_law_elastic_energy(off, off + MOTION_U, stiffness, &energy);
    number_law_elastic_wrench(off, off + MOTION_U, stiffness, elastic);
    number_law_damping_wrench(rate, rate + MOTION_U, damping, viscous);
    sum->energy += weight * energy;
    for (int i = 0; i < MOTION_STRAINS; i++) {
        sum->dissipation +=
            weight * (viscous[i] * rate[i] + at->relaxing[lane] * held[i] * stretched[i]);
        elastic[i] += held[i];
    }
    sum->reshaping -= weight * (vector_dot(elastic, rest->strain_rate) +
                                vector_dot(elastic + MOTION_U, rest->curvature_rate));
}

static section_sums sum_sections(const motion *m)
{
    section_sums sum = {0};
    for (int e = 0; e < m->elements; e++) {
        for (int k = 0; k <= m->degree; k++) {
            add_point(m, e, k, &sum);
        }
    }
    return sum;
}

motion_energy motion_energy_of(motion *m, const double *state)
{
    motion_set_nodes(m, state);
    return motion_energy_now(m);
}

motion_energy motion_energy_now(motion *m)
{
    motion_energy energy = {0};
    motion_internal_forces(m);
    energy.strain = sum_sections(m).energy + motion_places_energy(m) + motion_along_energy(m);
    for (size_t i = 0; i < m->nodes; i++) {
        static const double none[3] = {0};
        const double *V = m->flow[i];
        energy.kinetic += 0.5 * m->mass[i] * vector_dot(V, V);
        number_law_rotary_inertia_energy(none, m->spin[i], none, none, m->inertia[i],
                                         &energy.kinetic);
    }
    energy.kinetic += motion_added_energy(m);
    return energy;
}

/* Only then what holds it does work. */
static bool end_moves(const motion *m, int end)
{
    const solve_end *given = &m->rod->ends[end];
    const solve_end_state *now = &m->ends[end];
    return (given->hold.directions == 3 && vector_dot(now->velocity, now->velocity) > 0) ||
           (given->holds_rotation && vector_dot(now->spin, now->spin) > 0);
}

motion_power motion_power_of(motion *m, const double *state)
{
    motion_set_nodes(m, state);
    return motion_power_now(m);
}

motion_power motion_power_now(motion *m)
{
    motion_power power = {0};
    bool moves = end_moves(m, 0) || end_moves(m, 1);
    if (moves && m->has_added) {
        motion_find_added(m);
    }
    motion_outside_forces(m);
    if (m->is_damped || m->is_pulled || moves || m->rod->rest_moves) {
        motion_internal_forces(m);
        section_sums sum = sum_sections(m);
        power.load = sum.reshaping + motion_pull_power(m);
        power.dissipation = sum.dissipation;
    }
    for (size_t i = 0; i < m->nodes; i++) {
        power.load += vector_dot(m->push[i], m->flow[i]) + vector_dot(m->turn[i], m->spin[i]);
    }
    for (size_t i = 0; m->rod->along.by_velocity && i < m->points; i++) { /* part of the push */
        double resisted = m->point_weight[i] * vector_dot(m->resistance[i], m->velocity[i]);
        power.load += resisted;
        power.dissipation += resisted;
    }
    power.load += moves ? holding_power(m, 0) + holding_power(m, 1) : 0;
    return power;
}

/* ---- samples ------------------------------------------------------------------------------- */

/* The spring in the place of a lock rings about what the rod carries. */
static bool is_locked(const solve_section *made, int strain)
{
    return !(made->stiffness[strain] > 0);
}

static void sample_node(const motion *m, int element, int k, double scale, solve_state *to)
{
    size_t node = (size_t)element * m->degree + k;
    const motion_block *at = motion_block_of(m, element, k);
    const solve_section *made = &m->made[element * (m->degree + 1) + k];
    const double *frame = motion_frame_of(m, element, k);
    const int lane = k % LANES;
    double q[4], spin[3], R[3][3];
    memcpy(q, m->pose[node] + MOTION_LANE_Q, sizeof q);
    memcpy(spin, m->spin[node], sizeof spin);
    if (frame) {
        quaternion_product(m->pose[node] + MOTION_LANE_Q, frame, q);
        rotation_matrix(frame, R);
        to_body(R, m->spin[node], spin);
    }
    for (int i = 0; i < 4; i++) {
        to->rotation[i] += scale * q[i];
    }
    for (int i = 0; i < 3; i++) {
        to->position[i] += scale * m->pose[node][i];
        to->velocity[i] += scale * m->flow[node][i];
        to->spin[i] += scale * spin[i];
        to->strain[i] += scale * at->strain[i][lane];
        to->curvature[i] += scale * at->strain[MOTION_U + i][lane];
        to->force[i] += is_locked(made, i) ? NAN : scale * at->stress[i][lane];
        to->moment[i] +=
            is_locked(made, MOTION_U + i) ? NAN : scale * at->stress[MOTION_U + i][lane];
    }
}

void motion_samples(motion *m, const double *state, size_t n, const double *s, solve_state *out)
{
    double values[LOBATTO_DEGREE_MAX + 1];
    motion_set_nodes(m, state);
    motion_internal_forces(m);
    for (size_t i = 0; i < n; i++) {
        int element = (int)sort_cell((size_t)m->elements, m->edge, s[i], true);
        double from = m->edge[element], to = m->edge[element + 1];
        double at = 2 * (s[i] - from) / (to - from) - 1;
        out[i] = (solve_state){0};
        solve_lobatto_interpolation(m->degree, m->abscissas, m->weights, at, values);
        for (int k = 0; k <= m->degree; k++) {
            sample_node(m, element, k, values[k], &out[i]);
        }
        quaternion_normalize(out[i].rotation);
    }
}
