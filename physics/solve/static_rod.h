/* The static rod as a first-order system in s, written out in plain C, and its conditions at the
 * ends. With n = R^T N, v = v* + Kse^-1 n, u = u* + Kbt^-1 m,
 * where tendons and chambers pull the strains of actuation.h,
 *
 *   r_s = R v,   q_s = q (0, u)/2,   N_s = -f,   m_s = -u x m - v x n - R^T l
 *
 * (Antman, Nonlinear Problems of Elasticity, ch. 8; physics/rod.h). A locked strain is a compliance
 * of 0, and a foundation is a part -K (r - r0) of f. |q| is constant along any solution, so one end
 * of the rod sets it to 1. */
#ifndef PHYSICS_SOLVE_STATIC_ROD_H
#define PHYSICS_SOLVE_STATIC_ROD_H

#include "physics/solve/actuation.h"

/* y: r, q, N, m. */
enum { STATIC_R = 0, STATIC_Q = 3, STATIC_N = 7, STATIC_M = 10, STATIC_ROWS = 13 };
enum { STATIC_START_ROWS = 7, STATIC_END_ROWS = 6 }; /* conditions at s = 0, 1 */

/* What the equations need at one s. */
typedef struct static_point {
    solve_rest rest;
    solve_load load;
    const solve_foundation *foundation;                     /* NULL: none */
    const double *strain_compliance, *curvature_compliance; /* [3]; 0: locked */
    solve_actuation actuation;
} static_point;

/* y_s, and d y_s/d y where jacobian is not NULL. */
void static_rate(const static_point *at, const double *y, double *rate,
                 double (*jacobian)[STATIC_ROWS]);

/* What an end is held to. Springs about the directors turn a rod, whose rotation no end holds, to
 * `upright`. */
typedef struct static_end {
    solve_end kind;
    double position[3], rotation[4], force[3], moment[3];
    double spring[3], upright[4];
} static_end;

/* rows [STATIC_START_ROWS or STATIC_END_ROWS], 0 where the end (0, 1) is met, and their derivatives
 * by y. */
void static_end_residual(const static_end *at, int end, const double *y, double *rows,
                         double (*jacobian)[STATIC_ROWS]);

/* What acts at one place, by the path to the full load. A joint without a turn and no springs: NULL
 * and 0. */
typedef struct static_jump {
    const double *turn; /* quaternion [4] or NULL */
    solve_load load;
    int springs;
    const solve_spring *spring[SCENE_SPRINGS_MAX];
    double anchor[SCENE_SPRINGS_MAX][3];
} static_jump;

/* y just after the place from y just before it, and the derivative by that where by_y is not NULL
 * (physics/solve/jump.h). */
void static_jump_over(const static_jump *at, const double *before, double *after,
                      double (*by_y)[STATIC_ROWS]);

/* v and u of a state y. */
void static_strains(const static_point *at, const double *y, double *strain, double *curvature);

/* n = R^T N */
void static_body_force(const double *y, double *force);

#endif
