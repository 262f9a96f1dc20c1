/* Equilibria of a static system in the strain form (strain_form.h), whose points are those of the
 * system: for solvers that know equilibria by their y. */
#ifndef PHYSICS_SOLVE_STRAIN_NEWTON_H
#define PHYSICS_SOLVE_STRAIN_NEWTON_H

#include "physics/solve/static_system.h"

typedef struct strain_newton strain_newton;

/* The system must outlive it. AD_NO_MEMORY; AD_BAD_ARGUMENT: too many nodes. */
ad_status strain_newton_create(static_system *system, strain_newton **result, ad_error *error);
void strain_newton_free(strain_newton *newton); /* NULL is allowed */

/* As static_newton_solve. */
bool strain_newton_solve(strain_newton *newton, double *y, long *steps);

#endif
