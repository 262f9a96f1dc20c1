/* When what acts on a rod changes. A rod at rest lets steps of time grow beyond any blow, which
 * they would then pass without having met it. */
#ifndef PHYSICS_SOLVE_EVENTS_H
#define PHYSICS_SOLVE_EVENTS_H

#include "physics/solve/rod_model.h"

/* Of the duration: a jump lies between two instants that are no further apart. */
static const double EVENTS_JUMP = 1e-9;

/* times [count], ascending, in [0, duration]: instants that no step may pass. Between two of them
 * loads, prescribed ends and rest shape change by no more than half of their largest change, but
 * for jumps, which have one just before and one just after. Breaks of the scene's formulas
 * (physics/breaks.h) are among them, and so are the edges of their panels on which samples miss
 * something; what no panels are found for is reported as unresolved (solve.c). *times is freed by
 * the caller, also after a failure. AD_NO_MEMORY; AD_NOT_FINITE, with the instant; errors of
 * formulas. */
ad_status solve_events_find(const solve_rod *rod, size_t *count, double **times, ad_error *error);

#endif
