/* When what acts on a rod changes, and whether steps of time have met it. A rod at rest lets steps
 * grow beyond any blow, which they would then pass without having met it. */
#ifndef PHYSICS_SOLVE_EVENTS_H
#define PHYSICS_SOLVE_EVENTS_H

#include "physics/local/drives.h"

/* Of the duration: a jump lies between two instants that are no further apart. */
static const double EVENTS_JUMP = 1e-9;

/* Instants that no step may pass. Between two of them no drive of the rod (drives.h) changes by
 * more than half of its range, but for jumps, which have one just before and one just after; all
 * edges of panels are among them. */
typedef struct solve_events {
    solve_drives *drives;
    size_t count;
    double *times; /* [count] ascending, in [0, duration] */
} solve_events;

/* Errors of solve_drives_create. The rod must outlive the result. */
ad_status solve_events_create(const solve_rod *rod, solve_events **result, ad_error *error);
void solve_events_free(solve_events *e);

/* When formulas are looked at for what acts at t: just before, where something jumps then. */
double solve_events_before(const solve_events *e, double t);

/* Which steps were taken, and where in a step of length h what acts was asked for: its integral is
 * then taken for h times the sum of weights times values at at[] h. */
enum { EVENTS_STAGES_MAX = 8 };

typedef struct solve_clock {
    int stages;
    double at[EVENTS_STAGES_MAX], weights[EVENTS_STAGES_MAX];
    size_t count, room;
    double *ends; /* [count] of steps, from the beginning of the first on */
} solve_clock;

/* AD_NO_MEMORY */
ad_status solve_clock_add(solve_clock *clock, double t, ad_error *error);

/* The steps that did not meet their drives: whose sums are not the integrals of a drive, and of it
 * times t, which adaptive quadrature finds apart from all steps. *missed: how many; there are then
 * more instants where these drives vary. *key: of one of them. AD_NO_MEMORY. */
ad_status solve_events_meet(solve_events *e, const solve_clock *clock, size_t *missed,
                            const char **key, ad_error *error);

#endif
