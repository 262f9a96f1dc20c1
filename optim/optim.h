/* Minimisers on flat vectors of doubles: what they minimise, how a step ends. Their settings are in
 * methods.h. There
 * are Adam, SOAP, L-BFGS and the self-scaled Broyden method with a strong Wolfe line search,
 * Levenberg-Marquardt (Gauss-Newton with damping), and learning-rate schedules. optimizer.h runs
 * them. Knows nothing of networks; needs libc and libm only. */
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
 * function of x between two calls of optim_objective_changed. It need not check for NaN or Inf:
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

const char *const *optim_schedule_names(void); /* NULL at the end */

/* With w = warmup_steps, D = decay_steps, t = step - w, the rate at `step` is learning_rate times
 *
 * - warm-up, step < w: (step + 1) / (w + 1)
 * - constant: 1
 * - cosine: final_fraction + (1 - final_fraction) (1 + cos(pi min(t, D) / D)) / 2
 *   (Loshchilov & Hutter 2017, eq. 5, a single period)
 * - exponential: decay_factor ^ (t / D)
 *
 * All three are continuous at the end of the warm-up: optim_schedule_rate. */

/* ---- Adam: Kingma & Ba 2015, algorithm 1 ---- */

/* A step evaluates, then moves. On anything but OPTIM_RUNNING neither the point nor the moments
 * have changed. The moments stay when the objective has changed, since averaging gradients of a
 * varying objective is what Adam is for; when points are merely resampled from one distribution
 * optim_objective_changed may be left out. */

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

/* Where a step is not finite, the run can only be resumed from a state before it. Memory: 6 count
 * doubles, and for a matrix of n rows and m columns 2 (n^2 + m^2) and work. */

/* ---- descent along lines: Nocedal & Wright 2006, algorithms 3.5, 3.6 ---- */

/* What L-BFGS and the self-scaled Broyden method share: a step goes along -H gradient to a strong
 * Wolfe point. H is a model of the inverse Hessian, made of pairs s, y: a step, and what it has
 * changed in the gradient. maximum_step is a 2-norm. function_tolerance is of |f - f_before| to
 * max(|f|, |f_before|), 0: only when f is unchanged; step_tolerance of max |s_i| to max |x_i|. A
 * pair is dropped unless s.y is larger than curvature_threshold times |s| |y|. */

/* ---- L-BFGS: Liu & Nocedal 1989; Nocedal & Wright 2006, algorithms 7.4, 7.5 ---- */

/* One iteration with its line search. A line search that finds no strong Wolfe point keeps what
 * decrease it found, drops the model and is repeated once along steepest descent; when that
 * fails as well the step says so. The current point, its value and its gradient always belong
 * together, whatever is returned, and its value never rises while the objective stays the same.
 * A step may be called again after any status. The pairs are a ring of fixed size [memory]. They
 * are dropped when the objective has changed: they hold the curvature of the old function, and the
 * next y would be a difference of two gradients. Memory: (2 memory + 7) count doubles. */

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

/* Steps are as those of L-BFGS. H is part of the state, its lower triangle row by row. Memory:
 * count (count + 1) / 2 + 10 count doubles. */

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

const char *const *optim_scaling_names(void);

/* Dampings are in units of the largest diagonal entry of J^T J for identity, of 1 for diagonal.
 * damping_decrease is the factor after a step that does half of what the model predicts; its power
 * 2/3 or 1/3 after one that does less. By function_tolerance it stops when three steps in turn
 * lower the value relatively by no more, and were predicted to lower it by half at most. A far
 * start begins with small steps that promise much. */

/* A step: the model at the current point, then dampings until one lowers the value. The value never
 * rises while the objective stays the same. When no damping does, OPTIM_DAMPING_OVERFLOW or, when
 * no trial was finite, OPTIM_NO_FINITE_STEP; the point has not moved then. After
 * OPTIM_STOPPED_BY_OBJECTIVE the state is that before the step, which may be taken again. The
 * damping stays when the objective has changed. The model is not part of the state: a step makes it
 * anew, where J was computed. Memory: 7 count doubles. */

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
