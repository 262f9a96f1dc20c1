/* The residuals of a problem around a point, for Gauss-Newton, in the form that suits their number:
 *
 *   normal_equations   (J^T J + damping D) step = -J^T r, J^T J summed without J
 *   kernel             step = -D^-1 J^T z, (J D^-1 J^T + damping) z = r, with J in memory:
 *                      for fewer residuals than parameters
 *   matrix_free        the first by conjugate gradients, from products with J^T J alone: for any
 *                      number of parameters; D the unit matrix only
 *   separate           the first where J^T J is the same for every output of the network but for a
 *                      factor, as of linear networks in the strain form: one matrix for all of
 * them, computed once; D of its diagonal
 *
 * The optimiser sees none of this: optim_linear_model. */
#ifndef TOOLS_TRAIN_LINEAR_MODEL_H
#define TOOLS_TRAIN_LINEAR_MODEL_H

#include "tools/train/train_settings.h"

typedef struct linear_model linear_model;

typedef struct linear_model_info {
    train_linear_algebra form; /* never automatic */
    size_t parameters, rows;   /* rows of J: residuals times points */
    size_t inner;              /* products for an entry of J^T J */
    size_t order;              /* separate: rows of the matrix of an output */
    double bytes;              /* of its matrices, or of vectors and workspaces */
    int64_t factors;           /* matrices factored */
    int64_t failed;            /* of them not positive definite */
    int64_t solves;            /* matrix_free: systems solved */
    int64_t iterations;        /* of conjugate gradients, in all */
} linear_model_info;

/* Choose a form for the problem and count its bytes: where nothing is said, matrix_free for what
 * needs more bytes than there may be, or seconds a step by the kernel; AD_BAD_INPUT when it needs
 * too many, with what to do, the key being named by the stage. Compiles what the problem needs for
 * least squares. */
ad_status linear_model_plan(problem *p, const train_stage *stage, int number,
                            linear_model_info *plan, ad_error *error);

/* Floating-point operations of a step whose first damping is taken, at most: J^T J or J J^T and a
 * factor; matrix_free: of the products that there may be, each one of J and one of J^T. */
double linear_model_flops(const linear_model_info *plan);

/* matrix_free: a system is solved once its residual, by the norm of the preconditioner's inverse,
 * has fallen to this part, or after 200 products. Looser ones were measured to need more steps,
 * tighter ones more time. */
#define LINEAR_MODEL_TOLERANCE 1e-3

ad_status linear_model_create(problem *p, const linear_model_info *plan, ad_pool *pool,
                              linear_model **result, ad_error *error);
void linear_model_free(linear_model *m); /* NULL is fine */

/* What optim_linear_model asks for. While the pool of threads is watched, see ad_pool_watch, what
 * is computed may be of no meaning; solve then is OPTIM_OBJECTIVE_STOP. */
ad_status linear_model_linearize(linear_model *m, const double *x, double *value, double *jtr,
                                 double *diagonal, ad_error *error);
int linear_model_solve(linear_model *m, double damping, const double *scale, double *step);

/* Whether J should be kept while x moves: solutions need nothing of the residuals but J^T r, and
 * J^T J is so large that computing it is most of a step. Where it is small, the quadratic
 * convergence of new ones was measured to be worth more. */
bool linear_model_keeps(const linear_model *m);

/* Remember J^T r at another x beside that J; jtr [count]. */
void linear_model_refresh(linear_model *m, const double *jtr);

linear_model_info linear_model_inspect(const linear_model *m);

/* One line for people, with sizes. */
void linear_model_describe(const linear_model_info *info, char text[160]);

#endif
