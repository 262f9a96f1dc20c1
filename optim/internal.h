/* What the files of this folder share; not for callers. */
#ifndef OPTIM_INTERNAL_H
#define OPTIM_INTERNAL_H

#include "optim.h"

/* ---- vector.c ---- */

/* rows * count zeros, or NULL when memory or size_t does not suffice. */
double *optim_vector_create(size_t rows, size_t count);

/* a . b over [count], always summed in the same order. */
double optim_dot(size_t count, const double *a, const double *b);

/* max |a_i| over [count]; a has to be finite. */
double optim_max_abs(size_t count, const double *a);

/* Whether a[count] holds neither NaN nor Inf. */
int optim_all_finite(size_t count, const double *a);

/* Whether value is an integer in [0, limit]. */
int optim_is_counter(double value, double limit);

/* Copies at most capacity of rows[row_count] to arrays and returns row_count. */
int optim_copy_rows(optim_array *arrays, int capacity, const optim_array *rows, int row_count);

#define OPTIM_COUNTER_LIMIT 9007199254740992.0 /* 2^53: integers are exact up to here */

/* ---- evaluate.c ---- */

/* NULL, or a static text that names the one out of its range. */
const char *optim_check_tolerances(double gradient, double function, double step);

/* An objective together with the bookkeeping every evaluation needs. */
typedef struct optim_evaluator {
    size_t count;
    optim_objective objective;
    void *context;
    double *evaluations; /* [1], counted up */
    double *best_value;  /* [1], lowered */
    double *best_x;      /* [count], follows best_value */
} optim_evaluator;

/* OPTIM_RUNNING, OPTIM_NOT_FINITE or OPTIM_STOPPED_BY_OBJECTIVE; value[1] and gradient[count] are
 * meaningful only for the first. */
optim_status optim_evaluate(const optim_evaluator *evaluator, const double *x, double *value,
                            double *gradient);

/* ---- line_search.c ---- */

typedef enum optim_line_result {
    OPTIM_LINE_WOLFE,     /* strong Wolfe point */
    OPTIM_LINE_DECREASE,  /* only a point of sufficient decrease */
    OPTIM_LINE_FAILED,    /* no acceptable point */
    OPTIM_LINE_NO_FINITE, /* no finite trial point */
    OPTIM_LINE_UNBOUNDED, /* still falling at maximum_step */
    OPTIM_LINE_STOPPED    /* by the objective */
} optim_line_result;

/* A point on the line: phi(step) and phi'(step). */
typedef struct optim_line_point {
    double step;
    double value;
    double slope;
    int finite;
} optim_line_point;

typedef struct optim_line {
    const optim_evaluator *evaluator;
    const double *origin;       /* [count] */
    const double *direction;    /* [count], descent */
    double value;               /* phi(0) */
    double slope;               /* phi'(0) < 0 */
    double sufficient_decrease; /* c1 */
    double curvature;           /* c2 */
    double maximum_step;        /* in multiples of the direction */
    int maximum_evaluations;
    double *x;            /* [count], work, then the chosen point */
    double *gradient;     /* [count], work, then its gradient */
    double *low_gradient; /* [count], work */
} optim_line;

/* Searches from `step` (> 0, at most maximum_step). For WOLFE, DECREASE and UNBOUNDED, chosen, x
 * and gradient describe the point found; otherwise they are meaningless. */
optim_line_result optim_line_search(const optim_line *line, double step, optim_line_point *chosen);

#endif
