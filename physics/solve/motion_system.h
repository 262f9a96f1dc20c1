/* The linear systems of implicit time steps for a rod's equations of motion, as SUNDIALS asks for
 * them: (I - gamma J) x = b with J = d rate/d state.
 *
 * Rates of position and rotation are known in V and w, and local to their node. Eliminating them
 * leaves 6 unknowns a node instead of 13: V and w with
 *   (I - gamma (D + K A)) (dV, dw) = right side,   A = d(r, q)/d(V, w)
 * whose columns are difference quotients of accelerations, along motions of one node, or of several
 * that share no element, in which dr and dq follow dV and dw by A. V is taken in the frame of the
 * body at its node: a rod is stiff along its directors, so that the matrix hardly changes while the
 * rod turns, and one serves for many steps. */
#ifndef PHYSICS_SOLVE_MOTION_SYSTEM_H
#define PHYSICS_SOLVE_MOTION_SYSTEM_H

#include "physics/solve/motion.h"

#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

typedef struct motion_system motion_system;

/* Borrows both. AD_NO_MEMORY, AD_NO_BLAS. */
ad_status motion_system_create(motion *m, SUNContext context, motion_system **result,
                               ad_error *error);
void motion_system_free(motion_system *system);

/* To hand to an integrator; owned by `system`. The matrix is a shell: motion_system_form makes the
 * real one. */
SUNMatrix motion_system_matrix(motion_system *system);
SUNLinearSolver motion_system_solver(motion_system *system);

/* The present iterate [motion_size] and its rate: systems are formed and solved there. */
void motion_system_at(motion_system *system, const double *state, const double *rate);

/* The matrix and its factors; 0, or not when it is singular. */
int motion_system_form(motion_system *system, double gamma);

#endif
