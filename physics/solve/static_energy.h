/* The energy of a static rod. */
#ifndef PHYSICS_SOLVE_STATIC_ENERGY_H
#define PHYSICS_SOLVE_STATIC_ENERGY_H

#include "physics/solve/solve.h"
#include "physics/solve/static_system.h"

/* Of the solution y [unknowns] under the whole load, by EI/L. AD_NO_MEMORY, or what the tape says
 * of a formula. */
ad_status static_energy_of(const static_system *system, const double *y, solve_energy *energy,
                           ad_error *error);

#endif
