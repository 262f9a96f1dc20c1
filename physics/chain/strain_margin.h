/* For solve_members.c. */
#ifndef PHYSICS_CHAIN_STRAIN_MARGIN_H
#define PHYSICS_CHAIN_STRAIN_MARGIN_H

#include "physics/chain/strain_group.h"

/* As solve_members_margin, of at most LANES members; axis: the curvature that a plane has, or -1;
 * steps [members][count] of parameters, for derivatives. */
ad_status strain_group_margin(strain_group *group, size_t members, const double *parameters,
                              const double *curvature, int axis, const double *steps,
                              double *margin, double *by, ad_error *error);

#endif
