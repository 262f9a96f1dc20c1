/* What moves with the nodes of a rod beside their own mass and inertia, by laws of motion: a fluid,
 * and what bodies beside the axis have more than others. */
#include "physics/solve/motion_internal.h"

#include "physics/local/inertia.h"
#include "physics/numerics/quaternion.h"

#include <math.h>
#include <string.h>

/* A section with the rotation q at a node, without acceleration; R, spin: room. */
static inertia_motion motion_of(const motion *m, size_t node, const double q[4], double R[3][3],
                                double spin[3])
{
    static const double still[3] = {0};
    double own[3][3];
    rotation_matrix(q, R);
    rotation_matrix(m->pose[node] + MOTION_LANE_Q, own);
    to_world(own, m->spin[node], spin);
    return (inertia_motion){(const double(*)[3])R, m->flow[node], spin, still, still};
}

/* Of one thing that moves with a node. */
typedef struct part {
    inertia what;
    size_t node;
    double q[4]; /* of its section */
} part;

static int part_count(const motion *m)
{
    const int fluids = quantity_is_something(m->rod->scene.loads.added_mass) ? (int)m->points : 0;
    return m->has_added ? fluids + m->rod->jumps.count : 0;
}

/* False: nothing is there. Places come first. */
static bool part_at(const motion *m, int i, part *to)
{
    const solve_jumps *jumps = &m->rod->jumps;
    to->what = (inertia){0};
    if (i < jumps->count) {
        const double *body = solve_jump_body(jumps, jumps->number, i);
        to->node = m->places[i].node;
        motion_rotation_before(m, i, to->q);
        memcpy(to->what.eccentric, body + 4, sizeof to->what.eccentric);
        to->what.is_beside = jumps->at[i].beside;
        return to->what.is_beside;
    }
    acting_on at;
    const size_t point = (size_t)(i - jumps->count);
    to->node = motion_section_at(m, point, to->q, &at);
    memmove(to->q, at.rotation, sizeof to->q);
    to->what.added = m->point_weight[point] * m->made[point].added_mass;
    return true;
}

/* Blocks of the world, those of turns in the frame of the node. */
static void add_matrix(const inertia_matrix *by, double own[3][3], double to[6][6])
{
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            to[i][k] += by->mass[i][k];
            for (int a = 0; a < 3; a++) {
                to[i][3 + k] += by->coupling[i][a] * own[a][k];
                to[3 + k][i] += by->coupling[i][a] * own[a][k];
                for (int b = 0; b < 3; b++) {
                    to[3 + i][3 + k] += own[a][i] * by->rotary[a][b] * own[b][k];
                }
            }
        }
    }
}

void motion_find_added(motion *m)
{
    const int count = part_count(m);
    memset(m->added, 0, m->nodes * sizeof *m->added);
    for (int i = 0; i < count; i++) {
        double R[3][3], own[3][3], spin[3], wrench[6], moment[3];
        part one;
        if (!part_at(m, i, &one)) {
            continue;
        }
        motion_added *to = &m->added[one.node];
        const inertia_motion at = motion_of(m, one.node, one.q, R, spin);
        inertia_wrench_coupled(&one.what, at, wrench);
        const inertia_matrix by = inertia_matrix_coupled(&one.what, at.R);
        rotation_matrix(m->pose[one.node] + MOTION_LANE_Q, own);
        to_body(own, wrench + 3, moment);
        to->any = true;
        for (int k = 0; k < 3; k++) {
            to->wrench[k] += wrench[k];
            to->wrench[3 + k] += moment[k];
        }
        add_matrix(&by, own, to->mass);
    }
}

double motion_added_energy(const motion *m)
{
    const int count = part_count(m);
    double energy = 0;
    for (int i = 0; i < count; i++) {
        double R[3][3], spin[3];
        part one;
        if (part_at(m, i, &one)) {
            energy += inertia_energy(&one.what, motion_of(m, one.node, one.q, R, spin));
        }
    }
    return energy;
}

/* x of a symmetric, positive A x = b, which is lost (Cholesky). */
static void solve_six(double A[6][6], double x[6])
{
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k <= i; k++) {
            for (int j = 0; j < k; j++) {
                A[i][k] -= A[i][j] * A[k][j];
            }
            A[i][k] = i == k ? sqrt(A[i][i]) : A[i][k] / A[k][k];
        }
        for (int j = 0; j < i; j++) {
            x[i] -= A[i][j] * x[j];
        }
        x[i] /= A[i][i];
    }
    for (int i = 5; i >= 0; i--) {
        for (int j = i + 1; j < 6; j++) {
            x[i] -= A[j][i] * x[j];
        }
        x[i] /= A[i][i];
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
    double mass[6][6];
    memcpy(mass, added->mass, sizeof mass);
    for (int k = 0; k < 3; k++) {
        mass[k][k] += m->mass[i];
        mass[3 + k][3 + k] += m->inertia[i][k];
    }
    for (int k = 0; k < 6; k++) {
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
    solve_six(mass, acceleration);
}

void motion_added_wrench(const motion *m, size_t i, const double acceleration[6], double wrench[6])
{
    for (int k = 0; k < 6; k++) {
        wrench[k] = m->added[i].wrench[k] - row_product(m->added[i].mass[k], acceleration);
    }
}
