/* The fluid that moves with the nodes of a rod, by the law of its added mass. */
#include "physics/solve/motion_internal.h"

#include "physics/local/inertia.h"
#include "physics/numerics/quaternion.h"

#include <string.h>

static inertia_motion motion_of(const motion *m, size_t i, double R[3][3], double spin[3],
                                size_t *node)
{
    static const double still[3] = {0};
    double q[4], own[3][3];
    acting_on at;
    *node = motion_section_at(m, i, q, &at);
    rotation_matrix(at.rotation, R);
    rotation_matrix(m->pose[*node] + MOTION_LANE_Q, own);
    to_world(own, m->spin[*node], spin);
    return (inertia_motion){(const double(*)[3])R, m->flow[*node], spin, still, still};
}

void motion_find_fluid(motion *m)
{
    memset(m->fluid, 0, m->nodes * sizeof *m->fluid);
    for (size_t i = 0; i < m->points; i++) {
        const inertia fluid = {.added = m->point_weight[i] * m->made[i].added_mass};
        double R[3][3], own[3][3], spin[3], wrench[6], unused[3][3], mass[3][3], moment[3];
        size_t node;
        const inertia_motion at = motion_of(m, i, R, spin, &node);
        inertia_wrench_with_fluid(&fluid, at, wrench);
        inertia_mass(&fluid, at.R, unused, mass);
        rotation_matrix(m->pose[node] + MOTION_LANE_Q, own);
        to_body(own, wrench + 3, moment);
        for (int k = 0; k < 3; k++) {
            m->fluid[node].force[k] += wrench[k];
            m->fluid[node].moment[k] += moment[k];
            for (int c = 0; c < 3; c++) {
                m->fluid[node].mass[k][c] += mass[k][c];
            }
        }
    }
}

double motion_fluid_energy(const motion *m)
{
    double energy = 0;
    for (size_t i = 0; i < m->points && m->has_fluid; i++) {
        const inertia fluid = {.added = m->point_weight[i] * m->made[i].added_mass};
        double R[3][3], spin[3];
        size_t node;
        energy += inertia_energy(&fluid, motion_of(m, i, R, spin, &node));
    }
    return energy;
}

/* x of a symmetric, positive A x = b. */
static void solve_three(double A[3][3], const double b[3], double x[3])
{
    double minors[3][3];
    for (int k = 0; k < 3; k++) {
        vector_cross(A[(k + 1) % 3], A[(k + 2) % 3], minors[k]);
    }
    const double determinant = vector_dot(A[0], minors[0]);
    for (int k = 0; k < 3; k++) {
        x[k] = (minors[0][k] * b[0] + minors[1][k] * b[1] + minors[2][k] * b[2]) / determinant;
    }
}

/* The part of x that an end leaves free. */
static void leave_free(const scene_hold *hold, double x[3])
{
    double held[3];
    scene_hold_part(hold, x, held);
    for (int k = 0; k < 3; k++) {
        x[k] -= held[k];
    }
}

/* P M P + H of a symmetric mass, with H the part that an end holds and P that which it leaves. */
static void hold_mass(const scene_hold *hold, double mass[3][3])
{
    double half[3][3], held[3];
    for (int k = 0; k < 3; k++) {
        leave_free(hold, mass[k]);
    }
    for (int k = 0; k < 3; k++) {
        const double unit[3] = {k == 0, k == 1, k == 2};
        for (int c = 0; c < 3; c++) {
            half[k][c] = mass[c][k];
        }
        leave_free(hold, half[k]);
        scene_hold_part(hold, unit, held);
        for (int c = 0; c < 3; c++) {
            half[k][c] += held[c];
        }
    }
    memcpy(mass, half, sizeof half);
}

void motion_accelerate(const motion *m, size_t i, const double force[3], double acceleration[3])
{
    const motion_fluid *fluid = &m->fluid[i];
    double mass[3][3], right[3], held[3];
    memcpy(mass, fluid->mass, sizeof mass);
    for (int k = 0; k < 3; k++) {
        mass[k][k] += m->mass[i];
        right[k] = force[k] + fluid->force[k];
    }
    for (int end = 0; end < 2; end++) {
        const scene_hold *hold = &m->rod->ends[end].hold;
        if (i != motion_end_node(m, end) || hold->directions == 0) {
            continue;
        }
        scene_hold_part(hold, m->ends[end].acceleration, held);
        for (int k = 0; k < 3; k++) {
            right[k] -= vector_dot(mass[k], held);
        }
        leave_free(hold, right);
        hold_mass(hold, mass);
    }
    solve_three(mass, right, acceleration);
}
