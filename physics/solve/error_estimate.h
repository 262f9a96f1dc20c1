/* The error of a shape or a motion that is known, such as that of a network: how far the equations
 * would move it.
 *
 * At rest Newton's method for the equations of the rod starts from the shape itself; what it moves
 * the position by is the error. Its first step is the linearised answer to the residuals, the
 * others what is not linear of it, and an equilibrium of several is the one next to the shape. In
 * motion the equations are integrated from the same start, since the correction of a motion is a
 * motion itself. Beams are linear. The solver's tolerance follows from what is found. */
#ifndef PHYSICS_SOLVE_ERROR_ESTIMATE_H
#define PHYSICS_SOLVE_ERROR_ESTIMATE_H

#include "physics/solve/solve.h"

/* *estimate: of the largest error of the position over the length, or of a deflection over the
 * largest; what the solver leaves of its own, and what a learned law's misfit
 * to its data does, is added. NaN: not known, and `error` says why: no
 * solver takes the scene, or none solves it well enough. In motion until `end` (s; at rest it is
 * not read). `answer` gives all columns of solution_columns; at rest its times are NULL.
 * The scene must pass scene_check and the check of its model. AD_NO_MEMORY, errors of the answer
 * and of formulas. */
ad_status solve_error_estimate(const scene *rod_scene, double end, solve_known_motion *answer,
                               void *context, double *estimate, ad_error *error);

#endif
