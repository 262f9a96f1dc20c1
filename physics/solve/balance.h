/* Whether all loads on a whole rod or beam at rest and the forces and moments at its ends add up to
 * nothing. The loads are those of the scene, integrated by quadrature of their own
 * (physics/local/quadrature.h), so that it also sees what lies between the points of a solution.
 * Motions have energy and momentum instead: physics/solve/motion_balance.h. */
#ifndef PHYSICS_SOLVE_BALANCE_H
#define PHYSICS_SOLVE_BALANCE_H

#include "physics/local/rod_model.h"
#include "physics/solve/beam_model.h"
#include "physics/solve/solve.h"

/* As solve_balance (solve.h), of a rod or beam that is there. */
ad_status solve_balance_rod(const solve_rod *rod, solve_shape *shape, const void *context,
                            double *balance, ad_error *error);
ad_status solve_balance_beam(const solve_beam *beam, solve_shape *shape, const void *context,
                             double *balance, ad_error *error);

#endif
