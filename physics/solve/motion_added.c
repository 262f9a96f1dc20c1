/* What moves with the nodes of a rod beside their own mass and inertia, by laws of motion: a fluid,
 * and what bodies beside the axis have more than others. */
#include "physics/solve/motion_internal.h"

#include "physics/local/inertia.h"
#include "physics/numerics/processor.h"
#include "physics/numerics/quaternion.h"

#include <string.h>

/* A section with the rotation q at a node, without acceleration. */
typedef struct section {
    double R[3][3], own[3][3], spin[3]; /* of the section, of the node, in the world */
} section;

static inertia_motion motion_of(const motion *m, size_t node, const double q[4], section *at)
{
    rotation_matrix(q, at->R);
    rotation_matrix(m->pose[node] + MOTION_LANE_Q, at->own);
    to_world(at->own, m->spin[node], at->spin);
    return (inertia_motion){(const double(*)[3])at->R, m->flow[node], at->spin, NULL, NULL};
}

/* The bodies of a place, which stand before its joint; false: none is beside the axis. */
static bool bodies_at(const motion *m, int place, inertia *what, double q[4])
{
    const solve_jumps *jumps = &m->rod->jumps;
    if (!jumps->at[place].beside) {
        return false;
    }
    *what = solve_jump_body(jumps, jumps->number, place);
    what->mass = 0;
    memset(what->rotary, 0, sizeof what->rotary);
    motion_rotation_before(m, place, q);
    return true;
}

static bool has_fluid(const motion *m)
{
    return m->has_added && quantity_is_something(m->rod->scene.loads.added_mass);
}

static inertia fluid_at(const motion *m, size_t point)
{
    return (inertia){.added = m->point_weight[point] * m->made[point].added_mass};
}

static void add_wrench(const inertia *what, inertia_motion at, double own[3][3], motion_added *to)
{
    double wrench[6], moment[3];
    inertia_wrench_coupled(what, at, wrench);
    to_body(own, wrench + 3, moment);
    to->any = true;
    for (int k = 0; k < 3; k++) {
        to->wrench[k] += wrench[k];
        to->wrench[3 + k] += moment[k];
    }
}

/* Blocks of the world, those of turns in the frame of the node. */
static void add_matrix(const inertia_matrix *by, double own[3][3], motion_added *to)
{
    to->couples = true;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            to->mass[i][k] += by->mass[i][k];
            for (int a = 0; a < 3; a++) {
                to->mass[i][3 + k] += by->coupling[i][a] * own[a][k];
                to->mass[3 + k][i] += by->coupling[i][a] * own[a][k];
                for (int b = 0; b < 3; b++) {
                    to->mass[3 + i][3 + k] += own[a][i] * by->rotary[a][b] * own[b][k];
                }
            }
        }
    }
}

static void add_bodies(motion *m)
{
    for (int i = 0; i < m->rod->jumps.count; i++) {
        inertia what;
        section room;
        double q[4];
        if (bodies_at(m, i, &what, q)) {
            const size_t node = m->places[i].node;
            const inertia_motion at = motion_of(m, node, q, &room);
            const inertia_matrix by = inertia_matrix_coupled(&what, at.R);
            add_wrench(&what, at, room.own, &m->added[node]);
            add_matrix(&by, room.own, &m->added[node]);
        }
    }
}

static void add_fluid(motion *m)
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const inertia unit = {.added = 1};
    const inertia_matrix in_body = inertia_matrix_coupled(&unit, axes);
    for (size_t i = 0; i < m->points; i++) {
        const inertia what = fluid_at(m, i);
        section room;
        double q[4], turned[3][3];
        acting_on on;
        const size_t node = motion_section_at(m, i, q, &on);
        const inertia_motion at = motion_of(m, node, on.rotation, &room);
        add_wrench(&what, at, room.own, &m->added[node]);
        inertia_turn_block(at.R, in_body.mass[0], turned);
        for (int k = 0; k < 3; k++) {
            for (int c = 0; c < 3; c++) {
                m->added[node].mass[k][c] += what.added * turned[k][c];
            }
        }
    }
}

void motion_find_added(motion *m)
{
    memset(m->added, 0, m->nodes * sizeof *m->added);
    add_bodies(m);
    if (has_fluid(m)) {
        add_fluid(m);
    }
}

double motion_added_energy(const motion *m)
{
    const size_t fluids = has_fluid(m) ? m->points : 0;
    section room;
    inertia what;
    double energy = 0, q[4];
    for (int i = 0; i < m->rod->jumps.count && m->has_added; i++) {
        if (bodies_at(m, i, &what, q)) {
            energy += inertia_energy(&what, motion_of(m, m->places[i].node, q, &room));
        }
    }
    for (size_t i = 0; i < fluids; i++) {
        acting_on on;
        const size_t node = motion_section_at(m, i, q, &on);
        what = fluid_at(m, i);
        energy += inertia_energy(&what, motion_of(m, node, on.rotation, &room));
    }
    return energy;
}

/* x [size] of a symmetric, positive A x = b, both of which are lost. */
PROCESSOR_INLINE void solve_small(int size, double A[6][6], double x[6])
{
    for (int i = 0; i < size; i++) {
        const double pivot = 1 / A[i][i];
        for (int k = i + 1; k < size; k++) {
            const double by = A[k][i] * pivot;
            for (int j = i + 1; j < size; j++) {
                A[k][j] -= by * A[i][j];
            }
            x[k] -= by * x[i];
        }
        A[i][i] = pivot;
    }
    for (int i = size - 1; i >= 0; i--) {
        for (int j = i + 1; j < size; j++) {
            x[i] -= A[i][j] * x[j];
        }
        x[i] *= A[i][i];
    }
}

/* The part of x [6] that an end leaves free. */
static void leave_free(const solve_end *end, double x[6])
{
    double held[3];
    scene_hold_part(&end->hold, x, held);
    for (int k = 0; k < 3; k++) {
        x[k] -= held[k];
        x[3 + k] = end->holds_rotation ? 0 : x[3 + k];
    }
}

/* P M P + 1 - P of a symmetric mass, with P the part that an end leaves free. */
static void hold_mass(const solve_end *end, double mass[6][6])
{
    double half[6][6];
    for (int k = 0; k < 6; k++) {
        leave_free(end, mass[k]);
    }
    for (int k = 0; k < 6; k++) {
        double unit[6] = {0};
        unit[k] = 1;
        for (int c = 0; c < 6; c++) {
            half[k][c] = mass[c][k];
        }
        leave_free(end, half[k]);
        leave_free(end, unit);
        for (int c = 0; c < 6; c++) {
            half[k][c] += (c == k) - unit[c];
        }
    }
    memcpy(mass, half, sizeof half);
}

static double row_product(const double row[6], const double x[6])
{
    return vector_dot(row, x) + vector_dot(row + 3, x + 3);
}

void motion_accelerate(const motion *m, size_t i, const double wrench[6], double acceleration[6])
{
    const motion_added *added = &m->added[i];
    const double *inertia = m->inertia[i];
    const double own[6] = {m->mass[i], m->mass[i], m->mass[i], inertia[0], inertia[1], inertia[2]};
    double mass[6][6];
    for (int k = 0; k < 6; k++) {
        for (int c = 0; c < 6; c++) {
            mass[k][c] = added->mass[k][c] + (k == c ? own[k] : 0);
        }
        acceleration[k] = wrench[k] + added->wrench[k];
    }
    for (int side = 0; side < 2; side++) {
        const solve_end *end = &m->rod->ends[side];
        double held[6], loose[6];
        if (i != motion_end_node(m, side) || (end->hold.directions == 0 && !end->holds_rotation)) {
            continue;
        }
        memcpy(held, m->ends[side].acceleration, 3 * sizeof *held);
        memcpy(held + 3, m->ends[side].spin_rate, 3 * sizeof *held);
        memcpy(loose, held, sizeof loose);
        leave_free(end, loose);
        for (int k = 0; k < 6; k++) {
            held[k] -= loose[k];
        }
        for (int k = 0; k < 6; k++) {
            acceleration[k] -= row_product(mass[k], held);
        }
        leave_free(end, acceleration);
        hold_mass(end, mass);
    }
    if (added->couples) {
        solve_small(6, mass, acceleration);
        return;
    }
    solve_small(3, mass, acceleration);
    for (int k = 3; k < 6; k++) {
        acceleration[k] /= mass[k][k];
    }
}

void motion_added_wrench(const motion *m, size_t i, const double acceleration[6], double wrench[6])
{
    for (int k = 0; k < 6; k++) {
        wrench[k] = m->added[i].wrench[k] - row_product(m->added[i].mass[k], acceleration);
    }
}
