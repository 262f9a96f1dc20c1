/* The static rod as a first-order system in s, written out in plain C, and its conditions at the
 * ends. With n = R^T N, v = v* + Kse^-1 n, u = u* + Kbt^-1 m, or where actuators and tubes
 * pull the strains of actuation.h,
 *
 *   r_s = R v,   q_s = q (0, u)/2,   N_s = -f,   m_s = -u x m - v x n - R^T l
 *
 * and of each tube theta_i', m_i' of physics/rod/rod.h (Antman, Nonlinear Problems of Elasticity,
 * ch. 8). A locked strain is a compliance of 0, and laws outside of the rod are a part of f and l.
 * |q| is constant along any solution, so one end of the rod sets it to 1. */
#ifndef PHYSICS_LOCAL_STATIC_ROD_H
#define PHYSICS_LOCAL_STATIC_ROD_H

#include "physics/local/actuation.h"

/* y: r, q, N, m; then theta, m_i of each tube. */
enum { STATIC_R = 0, STATIC_Q = 3, STATIC_N = 7, STATIC_M = 10, STATIC_TUBES = 13 };
enum { STATIC_ROWS_MAX = STATIC_TUBES + 2 * SCENE_TUBES_MAX };

/* Conditions at s = 0, 1; and one of each tube. */
enum { STATIC_START_ROWS = 7, STATIC_END_ROWS = 6 };
enum { STATIC_END_ROWS_MAX = STATIC_START_ROWS + SCENE_TUBES_MAX };

/* Rows of y, of the conditions at an end (0, 1). */
static inline int static_rows(const solve_rod *rod)
{
    return STATIC_TUBES + 2 * rod->tubes;
}

static inline int static_end_rows(const solve_rod *rod, int end)
{
    return (end ? STATIC_END_ROWS : STATIC_START_ROWS) + rod->tubes;
}

/* By how much the end s = 1 is turned on about its d3 at t = 0; rad. */
double static_twist(const solve_rod *rod);

/* What the equations need at one s. */
typedef struct static_point {
    solve_rest rest;
    const acting *acting;             /* along the rod; NULL: nothing */
    double numbers[ACTING_ALONG_MAX]; /* of it, on the path */
    const double *compliance;         /* [6]; 0: locked */
    solve_actuation actuation;
    int tubes; /* of the actuators */
} static_point;

/* What pulls there at state y, which must outlive it, as the point must. */
solve_actuation static_actuation(const static_point *at, const double *y);

/* y_s, and d y_s/d y where jacobian is not NULL. */
void static_rate(const static_point *at, const double *y, double *rate,
                 double (*jacobian)[STATIC_ROWS_MAX]);

/* What an end is held to. Springs about the directors turn a rod, whose rotation no end holds, to
 * `upright`. */
typedef struct static_end {
    solve_end kind;
    double position[3], rotation[4];
    double spring[3], upright[4];
    int tubes;
    double turned[SCENE_TUBES_MAX], softness[SCENE_TUBES_MAX]; /* theta = turned + softness m_i */
} static_end;

/* rows [static_end_rows], 0 where the end (0, 1) is met, and their derivatives by y. */
void static_end_residual(const static_end *at, int end, const double *y, double *rows,
                         double (*jacobian)[STATIC_ROWS_MAX]);

/* What acts at one place, by the path to the full load, on a state of so many rows. A joint without
 * a turn: NULL. */
typedef struct static_jump {
    int rows;
    const double *turn; /* quaternion [4] or NULL */
    const acting *acting;
    double numbers[SOLVE_JUMP_NUMBERS_MAX];
} static_jump;

/* y just after the place from y just before it, and the derivative by that where by_y is not NULL
 * (physics/local/jump.h). */
void static_jump_over(const static_jump *at, const double *before, double *after,
                      double (*by_y)[STATIC_ROWS_MAX]);

/* v and u of a state y. */
void static_strains(const static_point *at, const double *y, double *strain, double *curvature);

/* n = R^T N */
void static_body_force(const double *y, double *force);

#endif
