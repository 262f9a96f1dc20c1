#include "physics/solve/motion_times.h"

#include "physics/solve/motion.h"

#include <math.h>
#include <stdlib.h>

/* The fixed times up to the last, and aside of them those given. */
static void place(motion_times *times, const double *given)
{
    double last = times->given > 0 ? given[times->given - 1] : 0;
    size_t fixed = 1, next = 0;
    while (fixed <= MOTION_FIXED_TIMES || next < times->given) {
        double stop = fixed < MOTION_FIXED_TIMES   ? last * (double)fixed / MOTION_FIXED_TIMES
                      : fixed > MOTION_FIXED_TIMES ? INFINITY
                                                   : last;
        double t = next < times->given && given[next] < stop ? given[next] : stop;
        if (times->count == 0 || t > times->all[times->count - 1]) {
            times->aside[times->count] = t < stop;
            times->fixed += t == stop;
            times->all[times->count++] = t;
        }
        fixed += t == stop;
        for (; next < times->given && given[next] <= t; next++) {
            times->which[next] = times->count - 1;
        }
    }
}

ad_status motion_times_create(size_t count, const double *given, motion_times *result,
                              ad_error *error)
{
    const size_t most = count + MOTION_FIXED_TIMES;
    *result = (motion_times){.given = count};
    AD_TAKE(result, all, most);
    AD_TAKE(result, aside, most);
    AD_TAKE(result, which, count);
    if (result->memory.is_short) {
        motion_times_free(result);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", count);
    }
    place(result, given);
    return AD_OK;
}

void motion_times_free(motion_times *times)
{
    ad_memory_free(&times->memory);
    *times = (motion_times){0};
}

/* The largest mismatch over the largest energy; not a number if one is none. The energy has a part
 * of its own that what rounding leaves of a rod at rest is small beside. */
static void report_energies(size_t count, const solve_energy *energies, solve_report *report)
{
    double mismatch = 0, largest = 0;
    for (size_t i = 0; i < count; i++) {
        const solve_energy *e = &energies[i];
        mismatch = motion_larger(mismatch, fabs(e->mismatch));
        largest = fmax(largest, fmax(e->kinetic + e->strain, fmax(fabs(e->work), e->dissipated)));
    }
    report->energy = largest + SOLVE_ENERGY_ROUNDING / SOLVE_ENERGY_ALLOWED;
    report->energy_mismatch = mismatch / report->energy;
}

void motion_times_energies(const motion_times *times, const solve_energy *energies,
                           solve_energy *given, solve_report *report)
{
    solve_energy judged[MOTION_FIXED_TIMES];
    size_t count = 0;
    for (size_t i = 0; i < times->count; i++) {
        if (!times->aside[i]) {
            judged[count++] = energies[i];
        }
    }
    report_energies(count, judged, report);
    for (size_t i = 0; i < times->given; i++) {
        given[i] = energies[times->which[i]];
    }
}
