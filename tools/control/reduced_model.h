/* The reduced rod (physics/chain/reduced.h) as a one-step model, and its linearisation at an
 * equilibrium: what a surrogate is compared with, and what takes its place before it is trained. */
#ifndef CONTROL_REDUCED_MODEL_H
#define CONTROL_REDUCED_MODEL_H

#include "physics/chain/reduced.h"
#include "tools/control/linear_step.h"

/* Steps of length h in (0, step], each one step of Radau's method, of whole states, with those of
 * inputs with a memory. Borrows the rod, one whose loads do not depend on time. */
one_step reduced_one_step(reduced_rod *rod, double step);

/* x+ = x_e + A (x - x_e) + B (u - u_e) with A, B of one step of length h at a state of rest; other
 * lengths have no answer, nor has `after`. Free with linear_step_free; NULL is allowed.
 * AD_NO_MEMORY, AD_NOT_FINITE: the model has no answer there. */
ad_status linear_step_create(const one_step *of, double h, const double *state,
                             const double *inputs, linear_step **result, ad_error *error);
void linear_step_free(linear_step *step);

#endif
