/* Minimisers on flat vectors of doubles: Adam, L-BFGS and the self-scaled Broyden method with a
 * strong Wolfe line search, Levenberg-Marquardt (Gauss-Newton with damping), and learning-rate
 * schedules. Knows nothing of networks; needs libc and libm only. optimizer.h has one interface
 * to all of them.
 *
 *     const char *why;
 *     optim_lbfgs_settings settings = optim_lbfgs_defaults();
 *     optim_lbfgs *lbfgs = optim_lbfgs_create(count, start, &settings, &why);
 *     optim_status status = OPTIM_RUNNING;
 *     while (status == OPTIM_RUNNING)
 *         status = optim_lbfgs_step(lbfgs, objective, context);
 *     memcpy(result, optim_lbfgs_best_x(lbfgs), count * sizeof *result);
 *     optim_lbfgs_free(lbfgs);
 *
 * Each optimiser owns a copy of its point. Steps allocate nothing, and all sums run in a fixed
 * order, so equal state and an equal objective give equal bits. */
#ifndef OPTIM_H
#define OPTIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- results ---- */

/* One row per result of a step: code, short name, sentence. */
#define OPTIM_STATUS_LIST(X)                                                                       \
    X(OPTIM_RUNNING, "running", "No stopping criterion has been met.")                             \
    X(OPTIM_GRADIENT_TOLERANCE, "gradient tolerance",                                              \
      "The largest gradient component is within gradient_tolerance.")                              \
    X(OPTIM_FUNCTION_TOLERANCE, "function tolerance",                                              \
      "The last steps changed the value relatively by no more than function_tolerance.")           \
    X(OPTIM_STEP_TOLERANCE, "step tolerance",                                                      \
      "The last step changed the point relatively by no more than step_tolerance.")                \
    X(OPTIM_LINE_SEARCH_FAILED, "line search failed",                                              \
      "No strong Wolfe point was found, along steepest descent either; rounding may be the "       \
      "limit.")                                                                                    \
    X(OPTIM_NO_FINITE_STEP, "no finite step",                                                      \
      "Every trial point of the line search gave a value or gradient that is not finite.")         \
    X(OPTIM_NOT_FINITE, "not finite",                                                              \
      "The value or gradient at the current point is not finite, or the next point would not be.") \
    X(OPTIM_UNBOUNDED, "unbounded",                                                                \
      "The value was still falling at distance maximum_step along a line.")                        \
    X(OPTIM_STOPPED_BY_OBJECTIVE, "stopped by objective", "The objective asked to stop.")          \
    X(OPTIM_BAD_STATE, "bad state", "The restored state holds a number out of its range.")         \
    X(OPTIM_DAMPING_OVERFLOW, "damping overflow",                                                  \
      "No step lowered the value up to the largest damping; rounding may be the limit.")

typedef enum optim_status {
#define OPTIM_STATUS_ENUM(code, name, sentence) code,
    OPTIM_STATUS_LIST(OPTIM_STATUS_ENUM)
#undef OPTIM_STATUS_ENUM
        OPTIM_STATUS_COUNT
} optim_status;

/* Short name and one-sentence explanation of a status; never NULL. */
const char *optim_status_name(optim_status status);
const char *optim_status_text(optim_status status);

/* ---- objective ---- */

/* What an objective returns. Any other nonzero number means the same as OPTIM_OBJECTIVE_STOP. */
enum {
    OPTIM_OBJECTIVE_OK = 0,
    OPTIM_OBJECTIVE_NOT_FINITE = 1, /* no finite value here: a line search backs away from it */
    OPTIM_OBJECTIVE_STOP = 2        /* end the run; the step returns OPTIM_STOPPED_BY_OBJECTIVE */
};

/* Writes f(x) to value[1] and df/dx to gradient[count] for x[count]. It must be a deterministic
 * function of x between two calls of optim_*_objective_changed. It need not check for NaN or Inf:
 * the optimisers do, on the value and on the squared gradient norm. */
typedef int (*optim_objective)(void *context, const double *x, double *value, double *gradient);

/* ---- state as a value ---- */

/* A named piece of live state. A checkpoint writes data[count], and to restore, creates the
 * optimiser with the same count and settings and fills data[count] in place. Pointers stay valid
 * until the optimiser is freed. Integers among the scalars are stored as exact doubles; values may
 * be +infinity before the first evaluation, so the file format has to carry that. */
typedef struct optim_array {
    const char *name; /* static text, unique within one optimiser */
    double *data;     /* [count], owned by the optimiser */
    size_t count;
} optim_array;

enum { OPTIM_STATE_CAPACITY = 12 }; /* enough room for every optimiser's arrays */

/* ---- learning-rate schedules ---- */

#define OPTIM_SCHEDULE_LIST(X)                                                                     \
    X(OPTIM_SCHEDULE_CONSTANT, "constant")                                                         \
    X(OPTIM_SCHEDULE_COSINE, "cosine")                                                             \
    X(OPTIM_SCHEDULE_EXPONENTIAL, "exponential")

typedef enum optim_schedule_kind {
#define OPTIM_SCHEDULE_ENUM(code, name) code,
    OPTIM_SCHEDULE_LIST(OPTIM_SCHEDULE_ENUM)
#undef OPTIM_SCHEDULE_ENUM
        OPTIM_SCHEDULE_COUNT
} optim_schedule_kind;

/* With w = warmup_steps, D = decay_steps, t = step - w, the rate at `step` is learning_rate times
 *
 * - warm-up, step < w: (step + 1) / (w + 1)
 * - constant: 1
 * - cosine: final_fraction + (1 - final_fraction) (1 + cos(pi min(t, D) / D)) / 2
 *   (Loshchilov & Hutter 2017, eq. 5, a single period)
 * - exponential: decay_factor ^ (t / D)
 *
 * All three are continuous at the end of the warm-up. */
typedef struct optim_schedule {
    optim_schedule_kind kind;
    double learning_rate;  /* > 0 */
    int64_t warmup_steps;  /* >= 0 */
    int64_t decay_steps;   /* >= 1; cosine and exponential */
    double final_fraction; /* [0, 1]; cosine */
    double decay_factor;   /* (0, 1]; exponential */
} optim_schedule;

optim_schedule optim_schedule_defaults(void);

/* NULL, or a static text that names the first bad field and its range. */
const char *optim_schedule_check(const optim_schedule *schedule);

/* The rate at step = 0, 1, 2, ...; a negative step counts as 0. The schedule has to pass the
 * check. */
double optim_schedule_rate(const optim_schedule *schedule, int64_t step);

/* ---- Adam: Kingma & Ba 2015, algorithm 1 ---- */

typedef struct optim_adam_settings {
    optim_schedule schedule;
    double beta1;              /* [0, 1) decay of the mean of the gradient */
    double beta2;              /* [0, 1) decay of the mean of its square */
    double epsilon;            /* > 0, added to sqrt(v_hat) */
    double clip_norm;          /* >= 0; scale the gradient down to this 2-norm; 0: never */
    double gradient_tolerance; /* >= 0; stop when max |g_i| is no larger */
} optim_adam_settings;

typedef struct optim_adam_info {
    int64_t steps;        /* completed updates */
    int64_t evaluations;  /* calls of the objective */
    double value;         /* before the last update: an Adam step evaluates, then moves */
    double gradient_norm; /* 2-norm at that point, before clipping */
    double learning_rate; /* used by the last update */
    double best_value;    /* lowest value evaluated; +infinity before the first */
} optim_adam_info;

typedef struct optim_adam optim_adam;

optim_adam_settings optim_adam_defaults(void);
const char *optim_adam_check(const optim_adam_settings *settings);

/* Copies x[count] and the settings. Returns NULL when something is wrong and then sets *why (unless
 * why is NULL) to a static text; nothing is left allocated. */
optim_adam *optim_adam_create(size_t count, const double *x, const optim_adam_settings *settings,
                              const char **why);
void optim_adam_free(optim_adam *adam); /* NULL is fine */

/* One evaluation and one update. On anything but OPTIM_RUNNING neither the point nor the moments
 * have changed. */
optim_status optim_adam_step(optim_adam *adam, optim_objective objective, void *context);

/* Call when the objective is no longer the same function and its values no longer compare: forgets
 * the best point. The moments stay, since averaging gradients of a varying objective is what Adam
 * is for. When points are merely resampled from one distribution the call may be left out. */
void optim_adam_objective_changed(optim_adam *adam);

const double *optim_adam_x(const optim_adam *adam);      /* [count], current point */
const double *optim_adam_best_x(const optim_adam *adam); /* [count], where best_value was found */
optim_adam_info optim_adam_get_info(const optim_adam *adam);

/* Fills at most `capacity` rows and returns how many there are. */
int optim_adam_state(optim_adam *adam, optim_array *arrays, int capacity);

/* After a restore: NULL, or a static text saying which array holds an impossible number. */
const char *optim_adam_state_check(const optim_adam *adam);

/* ---- SOAP: Vyas et al., ICLR 2025, algorithm 3 ---- */

/* Adam for matrices among the parameters, weights of layers, in the eigenvectors of what their
 * gradients G have in common: mean G G^T and mean G^T G, as Shampoo has them (Gupta, Koren, Singer
 * 2018). Between gradients the basis is turned by a step of orthogonal iteration. Other parameters
 * get Adam. */

enum { OPTIM_SOAP_SIDE_MAX = 1024 }; /* a longer side of a matrix keeps its basis */

/* x[offset ..], row-major. */
typedef struct optim_matrix {
    size_t offset, rows, columns;
} optim_matrix;

/* c[m][n] = a b + beta c, row-major; `a` is stored [k][m] where it is to be transposed, `b` [n][k].
 */
typedef void (*optim_multiply)(void *context, bool transpose_a, bool transpose_b, size_t m,
                               size_t n, size_t k, const double *a, const double *b, double beta,
                               double *c);

typedef struct optim_soap_settings {
    optim_adam_settings adam; /* beta2 also of the products of gradients */
    int basis_every;          /* >= 1, steps between turns of the bases */
    int matrix_count;
    const optim_matrix *matrices; /* in the order of their offsets, apart; copied */
    optim_multiply multiply;      /* NULL: plain loops */
    void *context;                /* of it */
} optim_soap_settings;

typedef struct optim_soap optim_soap;

optim_soap_settings optim_soap_defaults(void);
const char *optim_soap_check(const optim_soap_settings *settings);

/* As optim_adam_create and the functions below it; where a step is not finite, the run can only be
 * resumed from a state before it. Memory: 6 count doubles, and for a matrix of n rows and m columns
 * 2 (n^2 + m^2) and work. */
optim_soap *optim_soap_create(size_t count, const double *x, const optim_soap_settings *settings,
                              const char **why);
void optim_soap_free(optim_soap *soap); /* NULL is fine */
optim_status optim_soap_step(optim_soap *soap, optim_objective objective, void *context);
void optim_soap_objective_changed(optim_soap *soap);
const double *optim_soap_x(const optim_soap *soap);
const double *optim_soap_best_x(const optim_soap *soap);
optim_adam_info optim_soap_get_info(const optim_soap *soap);
int optim_soap_state(optim_soap *soap, optim_array *arrays, int capacity);
const char *optim_soap_state_check(const optim_soap *soap);

/* ---- descent along lines: Nocedal & Wright 2006, algorithms 3.5, 3.6 ---- */

/* What L-BFGS and the self-scaled Broyden method share: a step goes along -H gradient to a strong
 * Wolfe point. H is a model of the inverse Hessian, made of pairs s, y: a step, and what it has
 * changed in the gradient. */
typedef struct optim_descent_settings {
    double sufficient_decrease;   /* c1 in (0, 0.5) of the Wolfe conditions */
    double curvature;             /* c2 in (c1, 1) of the strong Wolfe conditions */
    int maximum_line_evaluations; /* 2 to 1000 in one line search */
    double maximum_step;          /* > 0; 2-norm of a step beyond which a still falling line
                                     counts as unbounded below */
    double gradient_tolerance;    /* >= 0; stop when max |g_i| is no larger */
    double function_tolerance;    /* [0, 1); stop when |f - f_before| is no larger than this
                                     times max(|f|, |f_before|); 0: only when f is unchanged */
    double step_tolerance;        /* [0, 1); stop when max |s_i| is no larger than this times
                                     max |x_i| */
    double curvature_threshold;   /* [0, 1); drop a pair unless s.y is larger than this times
                                     |s| |y| */
} optim_descent_settings;

typedef struct optim_descent_info {
    int64_t iterations;   /* completed, each ending in a strong Wolfe point */
    int64_t evaluations;  /* calls of the objective */
    int64_t pairs;        /* pairs (s, y) that the model is made of */
    int64_t skipped;      /* pairs dropped by curvature_threshold */
    int64_t resets;       /* models dropped after a failed line search */
    double value;         /* at the current point; +infinity before the first evaluation */
    double gradient_max;  /* max |g_i| at the current point; +infinity before the first */
    double gradient_norm; /* 2-norm at the current point; +infinity before the first */
    double step;          /* multiple of the search direction taken last */
    double best_value;    /* lowest value evaluated, trial points included; +infinity before */
} optim_descent_info;

optim_descent_settings optim_descent_defaults(void);
const char *optim_descent_check(const optim_descent_settings *settings);

/* ---- L-BFGS: Liu & Nocedal 1989; Nocedal & Wright 2006, algorithms 7.4, 7.5 ---- */

typedef struct optim_lbfgs_settings {
    int memory; /* 1 to 1000 pairs (s, y) kept */
    optim_descent_settings descent;
} optim_lbfgs_settings;

typedef struct optim_lbfgs optim_lbfgs;

optim_lbfgs_settings optim_lbfgs_defaults(void);
const char *optim_lbfgs_check(const optim_lbfgs_settings *settings);

/* As optim_adam_create. Memory: (2 memory + 7) count doubles. */
optim_lbfgs *optim_lbfgs_create(size_t count, const double *x, const optim_lbfgs_settings *settings,
                                const char **why);
void optim_lbfgs_free(optim_lbfgs *lbfgs); /* NULL is fine */

/* One iteration with its line search. A line search that finds no strong Wolfe point keeps what
 * decrease it found, drops the model and is repeated once along steepest descent; when that
 * fails as well the step says so. The current point, its value and its gradient always belong
 * together, whatever is returned, and its value never rises while the objective stays the same.
 * A step may be called again after any status. */
optim_status optim_lbfgs_step(optim_lbfgs *lbfgs, optim_objective objective, void *context);

/* Has to be called between steps when the objective has become another function (new loss weights,
 * new points). The next step evaluates the current point anew. The best point is forgotten, since
 * values of two functions do not compare. The model is dropped, since its pairs hold the curvature
 * of the old function, and the next y would be a difference of two functions' gradients.
 */
void optim_lbfgs_objective_changed(optim_lbfgs *lbfgs);

const double *optim_lbfgs_x(const optim_lbfgs *lbfgs); /* [count], current point */
const double *
optim_lbfgs_best_x(const optim_lbfgs *lbfgs); /* [count], where best_value was found */
optim_descent_info optim_lbfgs_get_info(const optim_lbfgs *lbfgs);

/* As optim_adam_state and optim_adam_state_check. The pairs are a ring of fixed size [memory]. */
int optim_lbfgs_state(optim_lbfgs *lbfgs, optim_array *arrays, int capacity);
const char *optim_lbfgs_state_check(const optim_lbfgs *lbfgs);

/* ---- self-scaled Broyden: Al-Baali 1998; Urban, Stefanou & Pons, J. Comput. Phys. 523 (2025) ----
 */

/* SSBroyden2 there. H is one matrix, to which every step adds its pair:
 *
 *     H+ = (H - H y y.H / y.H y + phi v v.) / tau + s s. / s.y
 *     v = sqrt(y.H y) (s / s.y - H y / y.H y)
 *
 * with phi between and beyond the BFGS and DFP formulas, and a scale tau that lets go of curvature
 * that H holds too large. At the first pair H = (s.y / y.y) I. */

enum { OPTIM_SSBROYDEN_COUNT_MAX = 10000 }; /* 0.4 GB for H */

typedef struct optim_ssbroyden optim_ssbroyden;

/* As optim_adam_create. Memory: count (count + 1) / 2 + 10 count doubles. */
optim_ssbroyden *optim_ssbroyden_create(size_t count, const double *x,
                                        const optim_descent_settings *settings, const char **why);
void optim_ssbroyden_free(optim_ssbroyden *ssb); /* NULL is fine */

/* As optim_lbfgs_step and optim_lbfgs_objective_changed. */
optim_status optim_ssbroyden_step(optim_ssbroyden *ssb, optim_objective objective, void *context);
void optim_ssbroyden_objective_changed(optim_ssbroyden *ssb);

const double *optim_ssbroyden_x(const optim_ssbroyden *ssb);      /* [count], current point */
const double *optim_ssbroyden_best_x(const optim_ssbroyden *ssb); /* [count], of best_value */
optim_descent_info optim_ssbroyden_get_info(const optim_ssbroyden *ssb);

/* As optim_adam_state and optim_adam_state_check. H is part of the state, its lower triangle row by
 * row. */
int optim_ssbroyden_state(optim_ssbroyden *ssb, optim_array *arrays, int capacity);
const char *optim_ssbroyden_state_check(const optim_ssbroyden *ssb);

/* ---- Levenberg-Marquardt: Levenberg 1944, Marquardt 1963, Transtrum & Sethna 2012 ---- */

/* For a value that is a sum of squares |r(x)|^2 with J = dr/dx. A step minimises
 * |r + J step|^2 + damping step.D step. The damping rises until a step lowers the value, also when
 * the value is not finite or the step cannot be computed, and falls afterwards. */

/* A linear model of the residuals at a point. The optimiser does not need to know how it stores J.
 * Functions return what an optim_objective does, unless said otherwise. */
typedef struct optim_linear_model {
    void *context;

    /* |r(x)|^2 */
    int (*evaluate)(void *context, const double *x, double *value);

    /* Remembers r and J at x; value[1], J^T r [count] and the diagonal of J^T J [count]. */
    int (*linearize)(void *context, const double *x, double *value, double *jtr, double *diagonal);

    /* step[count] for J and r as remembered and a diagonal D = scale[count] > 0, the same for every
     * damping until J is another. OPTIM_OBJECTIVE_STOP: as of an objective; another number that is
     * not 0: this damping is too small for a step to be found. */
    int (*solve)(void *context, double damping, const double *scale, double *step);

    /* NULL: not to be had. As linearize, but J as remembered is kept, for a step by the chord
     * method: value[1] and J^T r [count] at x, with J as it is at x. */
    int (*refresh)(void *context, const double *x, double *value, double *jtr);
} optim_linear_model;

/* D: the unit matrix (Levenberg), or the diagonal of J^T J (Marquardt). */
#define OPTIM_SCALING_LIST(X)                                                                      \
    X(OPTIM_SCALING_IDENTITY, "identity")                                                          \
    X(OPTIM_SCALING_DIAGONAL, "diagonal")

typedef enum optim_scaling {
#define OPTIM_SCALING_ENUM(code, name) code,
    OPTIM_SCALING_LIST(OPTIM_SCALING_ENUM)
#undef OPTIM_SCALING_ENUM
        OPTIM_SCALING_COUNT
} optim_scaling;

/* Dampings are in units of the largest diagonal entry of J^T J for identity, of 1 for diagonal. */
typedef struct optim_gauss_newton_settings {
    optim_scaling scaling;
    double initial_damping;    /* > 0 */
    double maximum_damping;    /* > initial_damping; where it gives up */
    double damping_increase;   /* > 1; factor after a step that is not taken */
    double damping_decrease;   /* (0, 1); factor after one that is and does half of what the model
                                  predicts; its power 2/3 or 1/3 after one that does less */
    double gradient_tolerance; /* >= 0; stop when max |2 J^T r|_i is no larger */
    double function_tolerance; /* [0, 1); stop when three steps in turn lower the value relatively
                                * by no more, and were predicted to lower it by half at most: a far
                                * start begins with small steps that promise much */
    double step_tolerance;     /* [0, 1); as in L-BFGS */
} optim_gauss_newton_settings;

typedef struct optim_gauss_newton_info {
    int64_t iterations;   /* steps taken */
    int64_t evaluations;  /* calls of evaluate and linearize */
    int64_t rejected;     /* steps that did not lower the value */
    int64_t not_finite;   /* steps to where it is not finite */
    int64_t unsolved;     /* dampings for which the model found no step */
    double value;         /* at the current point; +infinity before the first evaluation */
    double gradient_max;  /* max |2 J^T r|_i before the last step; +infinity before the first */
    double gradient_norm; /* |2 J^T r| there; NaN before the first step, also after a restore */
    double damping;       /* for the next step, as added to the diagonal: not in units */
    double step;          /* 2-norm of the last step */
} optim_gauss_newton_info;

typedef struct optim_gauss_newton optim_gauss_newton;

optim_gauss_newton_settings optim_gauss_newton_defaults(void);
const char *optim_gauss_newton_check(const optim_gauss_newton_settings *settings);

/* As optim_adam_create. Memory: 7 count doubles. */
optim_gauss_newton *optim_gauss_newton_create(size_t count, const double *x,
                                              const optim_gauss_newton_settings *settings,
                                              const char **why);
void optim_gauss_newton_free(optim_gauss_newton *gn); /* NULL is fine */

/* One step: the model at the current point, then dampings until one lowers the value. The value
 * never rises while the objective stays the same. When no damping does, OPTIM_DAMPING_OVERFLOW or,
 * when no trial was finite, OPTIM_NO_FINITE_STEP; the point has not moved then. After
 * OPTIM_STOPPED_BY_OBJECTIVE the state is that before the step, which may be taken again. */
optim_status optim_gauss_newton_step(optim_gauss_newton *gn, const optim_linear_model *model);

/* As optim_lbfgs_objective_changed; the damping stays. */
void optim_gauss_newton_objective_changed(optim_gauss_newton *gn);

const double *optim_gauss_newton_x(const optim_gauss_newton *gn); /* [count], current and best */
optim_gauss_newton_info optim_gauss_newton_get_info(const optim_gauss_newton *gn);

/* As optim_adam_state and optim_adam_state_check. The model is not part of the state: a step
 * makes it anew, where J was computed. */
int optim_gauss_newton_state(optim_gauss_newton *gn, optim_array *arrays, int capacity);
const char *optim_gauss_newton_state_check(const optim_gauss_newton *gn);

/* ---- linear systems by products alone ---- */

/* y[count] = A x[count] for a symmetric positive semidefinite A. Not 0: stop, with that code. */
typedef int (*optim_product)(void *context, const double *x, double *y);

/* An approximation U diag(lambda) U^T of A of low rank from products with random vectors, and a
 * preconditioner for A + damping I made of it. Frangella, Tropp & Udell, "Randomized Nystrom
 * preconditioning", SIAM J. Matrix Anal. Appl. 44 (2023) 718; for networks that solve differential
 * equations Rathore, Lei, Frangella, Lu & Udell, arXiv:2402.01868 (2024). */
typedef struct optim_nystrom optim_nystrom;

/* random [rank][count]: independent standard normal numbers, which are not kept as they are; rank
 * in [1, count]. NULL: out of memory. Memory: 2 rank count doubles. */
optim_nystrom *optim_nystrom_create(size_t count, size_t rank, const double *random);
void optim_nystrom_free(optim_nystrom *n); /* NULL is fine */

/* The approximation of this A, in `rank` products; 0, or the product's code. */
int optim_nystrom_update(optim_nystrom *n, optim_product product, void *context);

const double *optim_nystrom_eigenvalues(const optim_nystrom *n);       /* [rank], >= 0, falling */
void optim_nystrom_diagonal(const optim_nystrom *n, double *diagonal); /* [count], of U..U^T */

/* z = P^-1 r, P = U (diag(lambda) + damping) U^T / (lambda_last + damping) + (I - U U^T);
 * z may not be r. */
void optim_nystrom_apply(const optim_nystrom *n, double damping, const double *r, double *z);

/* Conjugate gradients for (A + damping I) x = b from x = 0. */
typedef struct optim_cg optim_cg;

optim_cg *optim_cg_create(size_t count); /* NULL: out of memory. Memory: 4 count doubles */
void optim_cg_free(optim_cg *cg);        /* NULL is fine */

typedef struct optim_cg_result {
    int code;        /* 0, or the product's */
    int iterations;  /* products */
    double residual; /* sqrt(r^T P^-1 r), relative to its beginning */
} optim_cg_result;

/* Until the residual is within tolerance, after `most` iterations, or where rounding ends it: x is
 * the best of all points that as many products span. */
optim_cg_result optim_cg_solve(optim_cg *cg, optim_product product, void *context, double damping,
                               const optim_nystrom *preconditioner, const double *b,
                               double tolerance, int most, double *x);

#ifdef __cplusplus
}
#endif

#endif
