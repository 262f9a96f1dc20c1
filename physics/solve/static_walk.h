/* One path of equilibria on one mesh, step by step of its arc length (static_arc.h). */
#ifndef PHYSICS_SOLVE_STATIC_WALK_H
#define PHYSICS_SOLVE_STATIC_WALK_H

#include "physics/solve/static_trace.h"

/* As static_trace_create, on a mesh whose y is the equilibrium under the full load where the path
 * arrives. *result: NULL where no path begins; its estimate is not filled in. Adds to *steps. */
ad_status static_walk(static_solution *mesh, const solve_settings *settings, const path_shape *path,
                      trace_goal goal, static_trace **result, long *steps, ad_error *error);

#endif
