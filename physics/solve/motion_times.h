/* The times at which a motion is looked at. Some are fixed: solutions are compared there, and
 * energies judged, whatever is asked for, so that no answer depends on the times of another. */
#ifndef PHYSICS_SOLVE_MOTION_TIMES_H
#define PHYSICS_SOLVE_MOTION_TIMES_H

#include "autodiff/ad.h"
#include "autodiff/memory.h"
#include "physics/solve/solve.h"

enum { MOTION_FIXED_TIMES = 32 }; /* equally spaced; the last is the end, the first is not 0 */

typedef struct motion_times {
    size_t count, fixed, given; /* all, each once; those that are fixed; those asked for */
    double *all;                /* [count] ascending */
    bool *aside;                /* [count] asked for, and not fixed */
    size_t *which;              /* [given] of all */
    ad_memory memory;
} motion_times;

/* given [count]: ascending, from 0 on; the last is the end. AD_NO_MEMORY. */
ad_status motion_times_create(size_t count, const double *given, motion_times *result,
                              ad_error *error);
void motion_times_free(motion_times *times);

/* Of energies [times->count] those at fixed times go to the report, and those asked for to `given`
 * [times->given]. */
void motion_times_energies(const motion_times *times, const solve_energy *energies,
                           solve_energy *given, solve_report *report);

#endif
