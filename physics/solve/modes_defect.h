/* The error of a motion by few strain modes, from its residual in the equations of more of them. */
#ifndef PHYSICS_SOLVE_MODES_DEFECT_H
#define PHYSICS_SOLVE_MODES_DEFECT_H

#include "physics/chain/modes.h"
#include "physics/learn/model.h"

typedef struct modes_defect modes_defect;

/* Of motions of `own` that start from initial [2 size], by so many modes, no fewer of any strain.
 * Borrows rod and start. AD_NO_MEMORY, errors of formulas. */
ad_status modes_defect_create(solve_rod *rod, const modes *own, const double *initial,
                              const modes_counts *counts, modes_defect **result, ad_error *error);
void modes_defect_free(modes_defect *defect); /* NULL is fine */

/* As model_motion.off. */
ad_status modes_defect_follow(modes_defect *defect, double begin, double end, size_t count,
                              const double *y, model_motion_error *off, ad_error *error);

#endif
