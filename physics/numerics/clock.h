/* How long things take; for reports and time limits only, never in numerics. */
#ifndef PHYSICS_NUMERICS_CLOCK_H
#define PHYSICS_NUMERICS_CLOCK_H

#include <time.h>

/* Seconds of a clock of the system: CLOCK_MONOTONIC never goes back. */
static inline double clock_seconds(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#endif
