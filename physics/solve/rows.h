/* Equilibria of one rod under rows of commands in their order, as a robot goes through them: the
 * tensions that friction has left in tendons (solve_settings.before) go from row to row. */
#ifndef PHYSICS_SOLVE_ROWS_H
#define PHYSICS_SOLVE_ROWS_H

#include "physics/solve/solve.h"

/* Is given each row in turn: the member with its values, its solution and report, as of
 * solution_create. One that ends below the whole load leaves nothing to the next. */
typedef ad_status solve_row_taken(void *context, size_t row, const scene *member,
                                  const solution *solved, const solve_report *report,
                                  ad_error *error);

/* parameters [rows][parameter_count] of a scene at rest, in SI, among them what plays were before
 * (physics/scene/scene_memory.h); its formulas must outlive the call.
 * Errors as of solution_create, and what `take` returns. */
ad_status solve_rows(const scene *open, const solve_settings *settings, size_t rows,
                     const double *parameters, solve_row_taken *take, void *context,
                     ad_error *error);

/* Of a rod at rest, in N: the tension of a tendon, counted from 0, at s (m), with what friction
 * leaves of it there. */
double solution_tension_at(const solution *solution, int tendon, double s);

#endif
