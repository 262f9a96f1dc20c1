/* What residual and derivatives of the strain form share: tendons and chambers at a point, the sums
 * of physics/rod.h, and the conditions of a held end. For functions that are compiled
 * FOR_EACH_PROCESSOR. */
#ifndef PHYSICS_SOLVE_STRAIN_INLINE_H
#define PHYSICS_SOLVE_STRAIN_INLINE_H

#include "physics/solve/magnus.h"
#include "physics/solve/strain_form.h"

/* Of all actuators at a point: force and moment, and where they are asked for the derivatives
 * T_vv, T_vu, T_uu of their energy. */
typedef struct pulling {
    lanes force[3], moment[3], by_v[3][3], by_u[3][3], turning[3][3];
} pulling;

PROCESSOR_INLINE void pull_tendon(const strain_actuator *a, const lanes v[3], const lanes u[3],
                                  bool derive, pulling *sum)
{
    const lanes x = a->offset[0], y = a->offset[1];
    const lanes path[3] = {v[0] - u[2] * y + a->slope[0], v[1] + u[2] * x + a->slope[1],
                           v[2] + u[0] * y - u[1] * x};
    const lanes square = path[0] * path[0] + path[1] * path[1] + path[2] * path[2];
    lanes by;
    inverse_root(&square, &by);
    const lanes t[3] = {path[0] * by, path[1] * by, path[2] * by}, pull = a->pull;
    for (int i = 0; i < 3; i++) {
        sum->force[i] += pull * t[i];
    }
    sum->moment[0] += pull * y * t[2];
    sum->moment[1] -= pull * x * t[2];
    sum->moment[2] += pull * (x * t[1] - y * t[0]);
    lanes D[3][3], E[3][3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            D[i][j] = pull * by * ((i == j) - t[i] * t[j]);
            sum->by_v[i][j] += D[i][j];
        }
    }
    if (derive) { /* p' changes by -r x du */
        for (int i = 0; i < 3; i++) {
            E[i][0] = D[i][2] * y;
            E[i][1] = -D[i][2] * x;
            E[i][2] = D[i][1] * x - D[i][0] * y;
            for (int j = 0; j < 3; j++) {
                sum->by_u[i][j] += E[i][j];
            }
        }
        for (int j = 0; j < 3; j++) {
            sum->turning[0][j] += y * E[2][j];
            sum->turning[1][j] -= x * E[2][j];
            sum->turning[2][j] += x * E[1][j] - y * E[0][j];
        }
    }
}

PROCESSOR_INLINE void pull_all(strain_form *x, int node, bool derive, pulling *sum)
{
    strain_node *at = &x->at[node];
    memset(sum, 0, sizeof *sum);
    for (int i = 0; i < x->kind.actuators; i++) {
        const strain_actuator *a = &x->actuators[node * x->kind.actuators + i];
        if (!x->kind.extents[i].is_chamber) {
            pull_tendon(a, at->v, at->u, derive, sum);
        } else {
            sum->force[2] += a->pull;
            sum->moment[0] += a->pull * a->offset[1];
            sum->moment[1] -= a->pull * a->offset[0];
        }
    }
}

/* The part of a that an end holds. */
PROCESSOR_INLINE void held_part(const scene_hold *hold, const lanes a[3], lanes part[3])
{
    const double *d = hold->axis;
    const lanes along = a[0] * d[0] + a[1] * d[1] + a[2] * d[2];
    for (int i = 0; i < 3; i++) {
        const double held[4] = {0, 0, 1, 1}, axial[4] = {0, d[i], -d[i], 0};
        part[i] = held[hold->directions] * a[i] + axial[hold->directions] * along;
    }
}

/* Of a position off by `off` and a force beyond what is given. */
PROCESSOR_INLINE void hold_row(const scene_hold *hold, const lanes off[3], const lanes beyond[3],
                               lanes row[3])
{
    lanes held[2][3];
    held_part(hold, off, held[0]);
    held_part(hold, beyond, held[1]);
    for (int i = 0; i < 3; i++) {
        row[i] = held[0][i] + beyond[i] - held[1][i];
    }
}

PROCESSOR_INLINE void turn_over(strain_edge *edge, lanes q[4])
{
    if (edge->turns) {
        lanes turn[4], next[4];
        for (int i = 0; i < 4; i++) {
            turn[i] = NO_LANES + edge->turn[i];
        }
        lanes_quaternion_product(q, turn, next);
        memcpy(q, next, sizeof next);
    }
}

/* Integrals over an element of rate [stages]: to its points and to its end from its beginning,
 * where `from` is known, */
PROCESSOR_INLINE void integrate_on(strain_form *x, int e, lanes (*rate)[3], const lanes from[3],
                                   lanes (*to)[3], lanes end[3])
{
    const int n = x->kind.stages;
    for (int k = 0; k < 3; k++) {
        lanes all = NO_LANES;
        for (int i = 0; i < n; i++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < n; j++) {
                sum += x->rule.matrix[i][j] * rate[j][k];
            }
            to[i][k] = from[k] + x->width[e] * sum;
            all += x->rule.weights[i] * rate[i][k];
        }
        end[k] = from[k] + x->width[e] * all;
    }
}

/* and from its points and its beginning to its end, where `end` is known. */
PROCESSOR_INLINE void integrate_back(strain_form *x, int e, lanes (*rate)[3], const lanes end[3],
                                     lanes (*to)[3], lanes start[3])
{
    const int n = x->kind.stages;
    for (int k = 0; k < 3; k++) {
        lanes all = NO_LANES;
        for (int i = 0; i < n; i++) {
            lanes sum = NO_LANES;
            for (int j = 0; j < n; j++) {
                sum += x->tail[i][j] * rate[j][k];
            }
            to[i][k] = end[k] + x->width[e] * sum;
            all += x->rule.weights[i] * rate[i][k];
        }
        start[k] = end[k] + x->width[e] * all;
    }
}

#endif
