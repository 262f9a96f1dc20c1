/* Derivatives of shapes by the parameters, LANES members and parameters at a time: with the
 * residual F(u, p) of what is sought and the shape G(u, p),
 *
 *   dG/dp = G_p - G_u F_u^-1 F_p                                   (implicit function theorem)
 *
 * on the mesh on which curvature is given, and exact ones of it. Force and moment in the rod are of
 * the shape, too. F_p and G_p follow from
 * derivatives of what is given (solve_rod_create_changes) and of laws by their numbers
 * (physics/law/law.h). */
#ifndef PHYSICS_CHAIN_STRAIN_JACOBIAN_H
#define PHYSICS_CHAIN_STRAIN_JACOBIAN_H

#include "physics/chain/strain_group.h"

typedef struct strain_jacobian strain_jacobian;

/* Of a group, which outlives it, with parameters; changes are its rod's, and the jacobian's from
 * then on, also after an error. AD_NO_MEMORY, errors of formulas. */
ad_status strain_jacobian_create(strain_group *group, solve_rod *changes, strain_jacobian **result,
                                 ad_error *error);
void strain_jacobian_free(strain_jacobian *jacobian); /* NULL is allowed */

/* Each may be NULL. */
typedef struct strain_derived {
    double *jacobian; /* [members][outputs][SOLVE_MEMBERS_COLUMNS][count - from] */
    double *forces;   /* [members][outputs][solve_members_carried] */
    double *by;       /* [members][outputs][solve_members_carried][count - from] */
} strain_derived;

/* Of `members`, at most LANES, as solve_members_forces. */
ad_status strain_jacobian_run(strain_jacobian *of, size_t members, const double *parameters,
                              const double *curvature, int from, const strain_derived *to,
                              ad_error *error);

#endif
