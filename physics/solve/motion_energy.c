/* Energy and power of a rod in motion, and its state between nodes. */
#include "physics/solve/motion_internal.h"

#include "physics/solve/lobatto.h"
#include "physics/solve/quaternion.h"

/* ---- energy -------------------------------------------------------------------------------- */

/* Power of what holds an end: what its node's prescribed acceleration asks for beyond the rest. */
static double holding_power(const motion *m, int end)
{
    const solve_end *given = &m->rod->ends[end];
    const solve_end_state *now = &m->ends[end];
    size_t i = motion_end_node(m, end);
    const solve_section *section = &m->materials[i].section;
    const double *inertia = section->rotary_inertia, *w = now->spin;
    double power = 0;
    for (int k = 0; k < 3; k++) {
        double mass = m->weight[i] * section->mass;
        double force = mass * now->acceleration[k] - m->force[i][k] - m->push[i][k];
        double moment =
            m->weight[i] * inertia[k] * now->spin_rate[k] - m->torque[i][k] - m->turn[i][k];
        power += given->holds_position ? force * now->velocity[k] : 0;
        power += given->holds_rotation ? moment * w[k] : 0; /* w x rhoJ w does no work */
    }
    return power;
}

/* Of all sections as they are: strain energy, the power that damping takes, and that which a
 * changing rest shape puts in. */
typedef struct section_sums {
    double energy, dissipation, reshaping;
} section_sums;

static section_sums sum_sections(const motion *m)
{
    section_sums sum = {0};
    for (int e = 0; e < m->elements; e++) {
        for (int k = 0; k <= m->degree; k++) {
            const motion_strained *at = &m->sections[e * (m->degree + 1) + k];
            const solve_rest *rest = &m->rest[e * m->degree + k];
            const solve_section *section = &m->materials[e * m->degree + k].section;
            double weight = m->element_weight[k];
            for (int i = 0; i < 3; i++) {
                double strain = at->v[i] - rest->strain[i], kse = section->strain_stiffness[i];
                double bend = at->u[i] - rest->curvature[i], kbt = section->curvature_stiffness[i];
                double bse = section->strain_damping[i], bbt = section->curvature_damping[i];
                double elastic_n = kse * strain, elastic_m = kbt * bend;
                double viscous_n = at->n[i] - elastic_n, viscous_m = at->m[i] - elastic_m;
                sum.energy += 0.5 * weight * (elastic_n * strain + elastic_m * bend);
                sum.dissipation += bse > 0 ? weight * viscous_n * viscous_n / bse : 0;
                sum.dissipation += bbt > 0 ? weight * viscous_m * viscous_m / bbt : 0;
                sum.reshaping -= weight * (elastic_n * rest->strain_rate[i] +
                                           elastic_m * rest->curvature_rate[i]);
            }
        }
    }
    return sum;
}

motion_energy motion_energy_of(motion *m, const double *state)
{
    motion_energy energy = {0};
    motion_set_nodes(m, state);
    motion_internal_forces(m);
    energy.strain = sum_sections(m).energy;
    for (size_t i = 0; i < m->nodes; i++) {
        const solve_section *section = &m->materials[i].section;
        const double *inertia = section->rotary_inertia;
        const double *V = m->flow[i], *w = m->spin[i];
        double spinning =
            inertia[0] * w[0] * w[0] + inertia[1] * w[1] * w[1] + inertia[2] * w[2] * w[2];
        energy.kinetic += 0.5 * m->weight[i] * (section->mass * vector_dot(V, V) + spinning);
    }
    return energy;
}

/* Only then what holds it does work. */
static bool end_moves(const motion *m, int end)
{
    const solve_end *given = &m->rod->ends[end];
    const solve_end_state *now = &m->ends[end];
    return (given->holds_position && vector_dot(now->velocity, now->velocity) > 0) ||
           (given->holds_rotation && vector_dot(now->spin, now->spin) > 0);
}

motion_power motion_power_of(motion *m, const double *state)
{
    motion_power power = {0};
    bool moves = end_moves(m, 0) || end_moves(m, 1);
    motion_set_nodes(m, state);
    motion_outside_forces(m);
    if (m->is_damped || moves || m->rod->rest_moves) {
        motion_internal_forces(m);
        section_sums sum = sum_sections(m);
        power.load = sum.reshaping;
        power.dissipation = sum.dissipation;
    }
    for (size_t i = 0; i < m->nodes; i++) {
        const double *V = m->flow[i], *w = m->spin[i];
        double resisted = m->weight[i] * vector_dot(m->resistance[i], V); /* part of the push */
        power.load += vector_dot(m->push[i], V) + vector_dot(m->turn[i], w) + resisted;
        power.dissipation += resisted;
    }
    power.load += moves ? holding_power(m, 0) + holding_power(m, 1) : 0;
    return power;
}

/* ---- samples ------------------------------------------------------------------------------- */

static void sample_node(const motion *m, int element, int k, double scale, solve_state *to)
{
    size_t node = (size_t)(element * m->degree + k);
    const motion_strained *at = &m->sections[element * (m->degree + 1) + k];
    for (int i = 0; i < 4; i++) {
        to->rotation[i] += scale * m->pose[node][MOTION_LANE_Q + i];
    }
    for (int i = 0; i < 3; i++) {
        to->position[i] += scale * m->pose[node][i];
        to->velocity[i] += scale * m->flow[node][i];
        to->spin[i] += scale * m->spin[node][i];
        to->strain[i] += scale * at->v[i];
        to->curvature[i] += scale * at->u[i];
        to->force[i] += scale * at->n[i];
        to->moment[i] += scale * at->m[i];
    }
}

void motion_samples(motion *m, const double *state, size_t n, const double *s, solve_state *out)
{
    double values[LOBATTO_DEGREE_MAX + 1];
    motion_set_nodes(m, state);
    motion_internal_forces(m);
    for (size_t i = 0; i < n; i++) {
        int element = (int)(s[i] * m->elements);
        element = element < 0 ? 0 : element < m->elements ? element : m->elements - 1;
        double at = 2 * (s[i] * m->elements - element) - 1;
        out[i] = (solve_state){0};
        solve_lobatto_interpolation(m->degree, m->points, m->point_weights, at, values);
        for (int k = 0; k <= m->degree; k++) {
            sample_node(m, element, k, values[k], &out[i]);
        }
        quaternion_normalize(out[i].rotation);
    }
}
