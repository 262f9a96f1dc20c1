/* Steps of time of a reduced rod by collocation, implicit Runge-Kutta methods of high order whose
 * unknowns are the accelerations of their stages: with a of stage i and q, v of the step's start,
 *
 *   v_i = v + h sum_j A_ij a_j,   q_i = q + c_i h v + h^2 sum_j (A^2)_ij a_j,
 *   residual(q_i, v_i, a_i, t + c_i h) = 0
 *
 * so that no mass matrix is inverted, and a stage costs two sums along the rod. Newton's method
 * with one matrix M + h lambda D + (h lambda)^2 K for each pair of eigenvalues of A (Butcher, BIT
 * 16, 1976). Radau IIA: order 2 stages - 1, damps what is too fast for its steps; Gauss' points
 * took more steps for the same error on every motion with waves; linearly implicit extrapolation,
 * which takes no iterations, was quicker only where a soft arm may be off by 5e-4 of its length. */
#ifndef PHYSICS_CHAIN_MODES_STEP_H
#define PHYSICS_CHAIN_MODES_STEP_H

#include "physics/chain/modes.h"

#include <stdint.h>

enum { COLLOCATION_STAGES_MAX = 7 };

typedef struct collocation collocation;

typedef struct collocation_counts {
    long steps, rejected, iterations, matrices;
} collocation_counts;

/* Borrows the model. stages: 3, 5 or 7. AD_NO_MEMORY. */
ad_status collocation_create(modes *m, int stages, collocation **result, ad_error *error);
void collocation_free(collocation *collocation);

/* One step from *t towards `end`, which it does not pass, no error of which is estimated to be
 * above `tolerance` in any mode; inputs as modes_at without any. q, v and stretches d of Maxwell
 * branches (modes_branch.c) [size]: before and after.
 * Work and dissipation are added to energy. AD_NOT_FINITE where steps become too small. */
ad_status collocation_next(collocation *collocation, double *t, double end, double tolerance,
                           double *q, double *v, double *d, solve_energy *energy, ad_error *error);

/* After it: q, v, d [size] and energy within the step, at a share of its length from 0 to 1, by the
 * polynomial through its stages. */
void collocation_within(const collocation *collocation, double share, double *q, double *v,
                        double *d, solve_energy *energy);

/* Inputs that ends of the rod follow: those of a bit of `which` go to where they are after the step
 * by Hermite's cubic, with the rates [inputs] by t before and after it. */
typedef struct collocation_path {
    uint64_t which;
    const double *before, *after;
} collocation_path;

/* For the steps and derivatives that follow; borrowed, NULL: all inputs go linearly. */
void collocation_follow(collocation *collocation, const collocation_path *path);

/* One step of length h by itself: the same whatever came before. The inputs go linearly to those
 * `after` it (NULL: they are held). Newton's method stops at the tolerance, of modes and rates.
 * AD_NOT_FINITE: it fails. */
ad_status collocation_once(collocation *collocation, double t, double h, const double *inputs,
                           const double *after, double tolerance, double *q, double *v, double *d,
                           ad_error *error);

/* Inputs of which the values after a step count by themselves: so many from the first on. */
typedef struct collocation_ends {
    int first, count;
} collocation_ends;

/* After a step with q, v, d of its start, along `count` directions: change [states + inputs +
 * ends.count][count], how the state at its start changes, q, v and those of d that there are,
 * inputs (at both ends of the step together), and, of `ends`, by how much more those after it.
 * Rows of the state become those at its end, by exact derivatives of the method's equations. inputs
 * and `after` as above. room [collocation_along_room]. */
ad_status collocation_along(collocation *collocation, double t, double h, const double *inputs,
                            const double *after, collocation_ends ends, const double *q,
                            const double *v, const double *d, int count, double *room,
                            double *change, ad_error *error);
size_t collocation_along_room(const collocation *collocation, int ends, int count);

collocation_counts collocation_counts_of(const collocation *collocation);

#endif
