/* The error of a collocated rod at rest by its defect (defect.h). */
#ifndef PHYSICS_SOLVE_STATIC_DEFECT_H
#define PHYSICS_SOLVE_STATIC_DEFECT_H

#include "physics/solve/static_system.h"

/* error_of_y: largest of the position, in lengths, and of the turn about the tangent, rad, at the
 * points of a system that is solved by y. Infinite where it is not finite, or the derivatives are
 * singular. AD_NO_MEMORY, errors of what is given. */
ad_status static_defect(static_system *system, const solve_quadrature *quadrature, const double *y,
                        double *error_of_y, ad_error *error);

#endif
