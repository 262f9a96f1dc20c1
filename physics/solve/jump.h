/* Where something acts at single places of a rod, in numbers: concentrated loads, joints, rigid
 * bodies, springs; at s = 0, at s = 1, or within. With F, T what the outside does to the rod there,
 *
 *   N(s+) = N(s-) - F,   m(s+) = turn* (m(s-) - T) turn,   q(s+) = q(s-) turn
 *
 * F in the world, T and m in body components, T that of the rotation before the joint. Sources and
 * dimensionless units: physics/rod_internal.h (rod_points.c), physics/solve/rod_model.h. */
#ifndef PHYSICS_SOLVE_JUMP_H
#define PHYSICS_SOLVE_JUMP_H

#include "physics/rod_internal.h"

enum {
    SOLVE_JUMPS_MAX = SCENE_SEGMENTS_MAX + SCENE_POINTS_MAX + SCENE_BODIES_MAX + SCENE_SPRINGS_MAX
};

/* All that acts at one s. */
typedef struct solve_jump {
    double s;
    bool turns;        /* false: turn is 1 */
    double turn[4];    /* of a joint, from the frame before to the frame after */
    double mass;       /* of bodies; 0 if static, as their inertia */
    double inertia[3]; /* about the directors */
    int spring_count;  /* of the springs below */
    int springs[SCENE_SPRINGS_MAX];
} solve_jump;

/* Of the energy 1/2 stiffness (r - anchor)^2 + 1/2 turning phi^2, phi from upright to q. */
typedef struct solve_spring {
    double stiffness[3], turning[3];
    double anchor[3];   /* under the full load */
    double unloaded[3]; /* where the unstressed rod is */
    double upright[4];
} solve_spring;

typedef struct solve_jumps {
    int count, spring_count;
    bool loads_move;                /* with t */
    solve_jump at[SOLVE_JUMPS_MAX]; /* s ascending, each once */
    solve_spring springs[SCENE_SPRINGS_MAX];
} solve_jumps;

/* s [count] of them. */
void solve_jump_places(const solve_jumps *jumps, double *s);

/* Fills all but the poses of the springs. Returns, of t, the loads at each place as rows of a
 * solve_load (rod_model.h), weights of bodies among them, and then anchor, unloaded, upright of
 * each spring; `any`: whether there are rows. */
ad_value solve_jumps_record(const rod_context *rod, solve_jumps *jumps, bool *any);

/* Spring `x` on a rod at position r with its anchor at `anchor`: the force on the rod. */
void solve_spring_force(const solve_spring *x, const double anchor[3], const double r[3],
                        double force[3]);

/* Its moment on the rod at rotation q, of any length but 0, in body components; by_turn [i][j]
 * (or NULL): the derivative of component i by a rotation q exp(eta/2) about director j. */
void solve_spring_moment(const solve_spring *x, const double q[4], double moment[3],
                         double (*by_turn)[3]);

double solve_spring_energy(const solve_spring *x, const double anchor[3], const double r[3],
                           const double q[4]);

#endif
