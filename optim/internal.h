/* What the files of this folder share; not for callers. */
#ifndef OPTIM_INTERNAL_H
#define OPTIM_INTERNAL_H

#include "optimizer.h"

#include <stddef.h>

/* Memory of a method: vectors [rows][count] to which a pointer of it leads, or, with no rows,
 * [count] numbers within itself. Those with a name are its state. */
typedef struct optim_part {
    size_t offset, rows, count;
    const char *name;  /* NULL: work */
    const char *wrong; /* what is said of a number that is not finite; NULL: it may be any */
} optim_part;

#define OPTIM_WORK(type, field, rows, count)                                                       \
    {                                                                                              \
        offsetof(type, field), rows, count, NULL, NULL                                             \
    }
#define OPTIM_STATE(type, field, rows, count)                                                      \
    {                                                                                              \
        offsetof(type, field), rows, count, #field, #field " holds a number that is not finite"    \
    }
#define OPTIM_ANY(type, field, rows, count, name)                                                  \
    {                                                                                              \
        offsetof(type, field), rows, count, name, NULL                                             \
    }

enum { OPTIM_PARTS_MAX = 18 };

/* A method as optimizer.c sees it; `own` begins with 0 and has its parts. */
typedef struct optim_kind {
    size_t size; /* of what is its own */
    int (*parts)(size_t count, const optim_settings *settings, optim_part *part);
    /* Sets off from x[count], of what was checked. */
    void (*begin)(void *own, size_t count, const double *x, const optim_settings *settings);
    optim_status (*step)(void *own, const optim_target *target);
    void (*objective_changed)(void *own);
    const double *(*x)(const void *own);
    const double *(*best_x)(const void *own); /* NULL: x, the value never rises */
    optim_info (*inspect)(const void *own);
    const char *(*state_check)(const void *own); /* beyond what its parts say */
    const char *about, *advice;
    optim_needs needs;
    unsigned reads;                                       /* groups of settings */
    void (*defaults)(optim_settings *settings);           /* NULL, or changes those that differ */
    const char *(*check)(const optim_settings *settings); /* NULL, or beyond the limits of rows */
    double (*bytes)(const optim_settings *settings, size_t count); /* NULL: 6 vectors */
    size_t count_max;                                              /* 0: any */
} optim_kind;

#define OPTIM_KIND(code, name) extern const optim_kind optim_##name##_kind;
OPTIM_METHOD_LIST(OPTIM_KIND)
#undef OPTIM_KIND

/* ---- sums.c ---- */

/* Zeros for a method or the like of so many bytes and for its parts, in one piece of memory, which
 * the caller frees; NULL: out of memory. */
void *optim_room_create(size_t size, int parts, const optim_part *part);

/* Appends them; returns how many there are then. */
int optim_parts_add(int parts, optim_part *part, int more, const optim_part *of);

/* a . b over [count], always summed in the same order. */
double optim_dot(size_t count, const double *a, const double *b);

/* max |a_i| over [count]; a has to be finite. */
double optim_max_abs(size_t count, const double *a);

/* Whether a[count] holds neither NaN nor Inf. */
int optim_all_finite(size_t count, const double *a);

/* Whether value is an integer in [0, limit]. */
int optim_is_counter(double value, double limit);

#define OPTIM_COUNTER_LIMIT 9007199254740992.0 /* 2^53: integers are exact up to here */

/* ---- evaluation.c ---- */

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

/* ---- descent.c: descent along lines, its direction by a model H of the inverse Hessian ---- */

enum {
    OPTIM_EVALUATED, /* 1 when value and gradient belong to x */
    OPTIM_VALUE,
    OPTIM_BEST_VALUE,
    OPTIM_STEP,
    OPTIM_PAIRS, /* that the model holds; 0: there is no model, and steepest descent */
    OPTIM_ITERATIONS,
    OPTIM_EVALUATIONS,
    OPTIM_SKIPPED,
    OPTIM_RESETS,
    OPTIM_DESCENT_SCALARS
};

/* What a step along -H gradient has shown; s.y > 0. */
typedef struct optim_pair {
    const double *s;        /* [count], the step */
    const double *y;        /* [count], what it has changed in the gradient */
    double sy, ss, yy;      /* s.y, ... */
    double sbs;             /* s.B s with the inverse B of H, since B s = -step gradient */
    const double *gradient; /* [count], where it ended */
} optim_pair;

/* H. Its memory and the number of its pairs, scalar[OPTIM_PAIRS], are the method's own business. */
typedef struct optim_model {
    void (*apply)(void *self, const double *gradient, double *result); /* H gradient; has pairs */
    void (*learn)(void *self, const optim_pair *pair);
} optim_model;

typedef struct optim_descent {
    optim_settings settings;
    const optim_model *model;
    size_t count;
    double *x;                            /* [count] */
    double *gradient;                     /* [count], at x */
    double *best_x;                       /* [count] */
    double *direction;                    /* [count], work */
    double *trial_x;                      /* [count], work */
    double *trial_gradient;               /* [count], work */
    double *low_gradient;                 /* [count], work */
    double scalar[OPTIM_DESCENT_SCALARS]; /* in one array so that the state is nothing but arrays */
} optim_descent;

/* Of a method that begins with an optim_descent: those of that and `more` of its own. */
int optim_descent_parts(size_t count, int more, const optim_part *own, optim_part *part);

/* Sets off from x[count]. */
void optim_descent_begin(optim_descent *d, size_t count, const double *x,
                         const optim_settings *settings, const optim_model *model);
optim_status optim_descent_step(optim_descent *d, const optim_target *target);

/* Of what begins with an optim_descent. */
void optim_descent_objective_changed(void *own);
const double *optim_descent_x(const void *own);
optim_info optim_descent_inspect(const void *own);

/* Of methods along lines: that the curvature condition asks for more than the decrease. */
const char *optim_descent_check(const optim_settings *settings);

/* NULL, or what is impossible in a restored state. */
const char *optim_descent_check_scalars(const optim_descent *d, double pairs_max);

/* ---- Adam, with which others of its kind begin ---- */

enum {
    OPTIM_ADAM_STEPS,
    OPTIM_ADAM_EVALUATIONS,
    OPTIM_ADAM_VALUE,
    OPTIM_ADAM_GRADIENT_NORM,
    OPTIM_ADAM_LEARNING_RATE,
    OPTIM_ADAM_BEST_VALUE,
    OPTIM_ADAM_SCALARS
};

typedef struct optim_adam {
    optim_settings settings;
    size_t count;
    double *x;                         /* [count] */
    double *mean;                      /* [count], m of the paper */
    double *square;                    /* [count], v of the paper; of SOAP in its bases */
    double *best_x;                    /* [count] */
    double *gradient;                  /* [count], work */
    double *next_x;                    /* [count], work */
    double scalar[OPTIM_ADAM_SCALARS]; /* in one array so that the state is nothing but arrays */
} optim_adam;

int optim_adam_parts(size_t count, const optim_settings *settings, optim_part *part);
void optim_adam_begin(void *own, size_t count, const double *x, const optim_settings *settings);
void optim_adam_objective_changed(void *own);
const double *optim_adam_x(const void *own);
const double *optim_adam_best_x(const void *own);
optim_info optim_adam_inspect(const void *own);
const char *optim_adam_state_check(const void *own);

/* The first half of a step: value and gradient at x. */
optim_status optim_adam_evaluate(optim_adam *adam, const optim_target *target);

/* By what clip_norm scales that gradient. */
double optim_adam_clip(const optim_adam *adam);

#endif
