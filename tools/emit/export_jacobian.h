/* Shapes of members (solve_members.h) of a given curvature, and their derivatives by the
 * parameters. */
#ifndef TOOLS_EMIT_EXPORT_JACOBIAN_H
#define TOOLS_EMIT_EXPORT_JACOBIAN_H

#include "autodiff/ad.h"
#include "physics/scene/scene.h"

typedef struct export_jacobian export_jacobian;

/* places [nodes] of the curvature and s [points] of the shape, over the length; columns which
 * [columns] of strain_rod_columns. The scene's names and formulas and the pool outlive it.
 * AD_BAD_ARGUMENT: what the strain form on a tape does not know (strain_check); AD_NO_MEMORY. */
ad_status export_jacobian_create(const scene *open, size_t nodes, const double *places,
                                 size_t points, const double *s, int columns, const int *which,
                                 ad_pool *pool, export_jacobian **result, ad_error *error);
void export_jacobian_free(export_jacobian *jacobian); /* NULL is allowed */

/* values [members][points][columns], or NULL, of curvature [members][nodes][3], 1/m; the rest as
 * solve_members_jacobian. */
ad_status export_jacobian_run(export_jacobian *derivatives, size_t members,
                              const double *parameters, const double *curvature, double *values,
                              double *jacobian, ad_error *error);

#endif
