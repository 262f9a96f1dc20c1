/* A quadratic program and its active rows, for qp.c and qp_active.c alone. */
#ifndef CONTROL_QP_INTERNAL_H
#define CONTROL_QP_INTERNAL_H

#include "tools/control/qp.h"

#include <stdbool.h>

/* With H = U'U, x0 = -H^-1 g and y = U(x - x0) the program is a least distance,
 *
 *   minimise 1/2 |y|^2   for   m_i y <= b_i - a_i x0,   m_i = a_i U^-1,
 *
 * which is solved by y = -sum of multipliers times m_i over the active rows, where
 * (M M' + softness) multipliers = -(b - A x0). A multiplier is negative where a lower bound holds.
 * Bounds of x are rows with a_i = e_i: number i < variables; row r of A has number variables + r.
 */
struct qp {
    int n, m, stride, most; /* most: of active rows */
    int limit, iterations, active;
    double tolerance;
    bool factored, least;    /* least: hard rows of A are expensive soft ones */
    const qp_bounds *bounds; /* while it is solved */
    double *U;               /* [n][stride] */
    double *inverse;         /* [n][stride] U^-1, an upper triangle */
    double *columns;         /* [n][stride] the same transposed */
    double *work;            /* [stride] */
    double *x0, *x, *best;   /* [stride]; best: the last solution with some of the rows left out */
    double *start;           /* [m] A x0 */
    double *length;          /* [m] |a_i| */
    double *M;               /* [most][stride] of active rows */
    double *L, *D;           /* M M' + softness = L D L'; columns of L [most][most], D [most] */
    double *gap, *soft;      /* [most] b - a x0 and softness of active rows */
    double *now, *next;      /* [most] multipliers of active rows */
    double *all;             /* [n + m] multipliers */
    int *row;                /* [most] numbers of active rows */
    int *side;               /* [n + m] 1: the upper bound is active, -1: the lower, 0: none */
};

/* result [stride] = sum of weights [count] times rows [count][stride]. */
void qp_combine(int count, int stride, const double *weights, const double *rows, double *result);
double qp_bound(const qp *qp, int row, int side);
bool qp_soft(const qp *qp, int r); /* row r of A */

/* Adds a row with a multiplier to the active ones. False: it depends on them, as
 * m = sum of next [active] times their m. */
bool qp_append(qp *qp, int row, int side, double multiplier);
void qp_drop(qp *qp, int i); /* active row i */
void qp_target(qp *qp);      /* next = the multipliers with which all active rows hold exactly */
void qp_point(qp *qp);       /* x of the multipliers `now` */
void qp_refine(qp *qp);      /* updates of L D L' add up errors: a step of iterative refinement */

#endif
