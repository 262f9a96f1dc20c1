/* A small dense strictly convex quadratic program, for the condensed problem of a predictive
 * controller (some 10 to 100 variables, a few hundred rows):
 *
 *   minimise 1/2 x'Hx + g'x   for   lower <= x <= upper,   row_lower <= Ax <= row_upper,
 *
 * where a row may be soft: it may be violated by v at the cost v^2/(2 softness), which needs no
 * further variable. By the dual active-set method (Goldfarb and Idnani 1983) in the form of a
 * least distance with an LDL' of the active rows (Arnstroem, Bemporad, Axehill, "A dual active-set
 * solver for embedded quadratic programming using recursive LDL' updates", 2022): started from the
 * rows that were active at the last solution, of which a controller changes few.
 *
 * Debian has no such solver as a C library (OSQP, DAQP, qpOASES, HPIPM are in Python's wheels at
 * most), and one with sources of its own could not be part of exported C.
 *
 * The caller's memory, no allocation, a limit of iterations, no state but the active rows. */
#ifndef CONTROL_QP_H
#define CONTROL_QP_H

#include <stddef.h>

typedef struct qp qp;

typedef struct qp_settings {
    int variables, rows; /* rows of A; rows 0 is allowed */
    int iterations;      /* at most, rows added or dropped; 0: 10 + 3 (variables + rows) */
    double tolerance;    /* of a bound, relative to its size (at least 1); 0: 1e-10 */
} qp_settings;

typedef struct qp_bounds {
    const double *lower, *upper;         /* [variables]; infinite: none. lower <= upper */
    const double *A;                     /* [rows][stride], 0 beyond its columns */
    const double *row_lower, *row_upper; /* [rows]; infinite: none */
    const double *softness;              /* [rows]; 0: hard; NULL: all are hard */
} qp_bounds;

typedef enum qp_status {
    QP_SOLVED,
    QP_LIMIT,      /* of iterations: x is the best known point that meets the hard bounds, if
                    * `inside` was given, else the last one, which may not */
    QP_INFEASIBLE, /* no point meets the hard rows: x is inside of lower and upper and violates
                    * the rows by the least squares, nearly (as soft ones that are expensive) */
    QP_BAD         /* H is not positive definite, a number is not finite, lower > upper: x is
                    * `inside`, or zero cut to its bounds */
} qp_status;

/* Bytes; memory as aligned as malloc's, which stays where it is. */
size_t qp_size(const qp_settings *settings);
qp *qp_init(void *memory, const qp_settings *settings);

/* H [variables][stride], stride = small_matrix_stride(variables) (small_matrix.h), of which the
 * upper triangle is read. It may be done before g is known. QP_BAD: not positive definite, and
 * qp_solve will answer so until another one is. */
qp_status qp_factor(qp *qp, const double *H);

/* With g [variables]. `inside` [variables] is a point that meets all hard bounds, or NULL: with it
 * x is never worse than it. x [variables], not `inside`. The rows that were active at the end of
 * the last call are tried first. */
qp_status qp_solve(qp *qp, const double *g, const qp_bounds *bounds, const double *inside,
                   double *result);
/* Of the bounds number first .. first + count - 1 (of variables, then of rows) each is tried next
 * as the one `by` later was now, the last ones as now: a problem that goes on in time. */
void qp_shift(qp *qp, int first, int count, int by);

int qp_iterations(const qp *qp); /* of the last qp_solve */
/* The last one may drop rows beyond the limit, each of them once. */
int qp_iterations_most(const qp *qp);
/* Multipliers of the last qp_solve, [variables + rows], first of lower <= x <= upper and then of
 * the rows: negative where the lower bound holds, positive where the upper one does;
 * Hx + g + multipliers + A'multipliers = 0. */
const double *qp_multipliers(const qp *qp);

#endif
