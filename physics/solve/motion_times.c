#include "physics/solve/motion_times.h"

#include "physics/solve/motion.h"

#include <math.h>
#include <stdlib.h>

/* The fixed times up to the last, and aside of them those given. */
static void place(motion_times *x, const double *given)
{
    double last = x->given > 0 ? given[x->given - 1] : 0;
    size_t fixed = 1, next = 0;
    while (fixed <= MOTION_FIXED_TIMES || next < x->given) {
        double stop = fixed < MOTION_FIXED_TIMES   ? last * (double)fixed / MOTION_FIXED_TIMES
                      : fixed > MOTION_FIXED_TIMES ? INFINITY
                                                   : last;
        double t = next < x->given && given[next] < stop ? given[next] : stop;
        if (x->count == 0 || t > x->all[x->count - 1]) {
            x->aside[x->count] = t < stop;
            x->fixed += t == stop;
            x->all[x->count++] = t;
        }
        fixed += t == stop;
        for (; next < x->given && given[next] <= t; next++) {
            x->which[next] = x->count - 1;
        }
    }
}

ad_status motion_times_create(size_t count, const double *given, motion_times *result,
                              ad_error *error)
{
    const size_t most = count + MOTION_FIXED_TIMES;
    *result = (motion_times){.given = count,
                             .all = malloc(most * sizeof *result->all),
                             .aside = malloc(most * sizeof *result->aside),
                             .which = malloc((count + 1) * sizeof *result->which)};
    if (!result->all || !result->aside || !result->which) {
        motion_times_free(result);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu times", count);
    }
    place(result, given);
    return AD_OK;
}

void motion_times_free(motion_times *x)
{
    free(x->all);
    free(x->aside);
    free(x->which);
    *x = (motion_times){0};
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

void motion_times_energies(const motion_times *x, const solve_energy *energies, solve_energy *given,
                           solve_report *report)
{
    solve_energy judged[MOTION_FIXED_TIMES];
    size_t count = 0;
    for (size_t i = 0; i < x->count; i++) {
        if (!x->aside[i]) {
            judged[count++] = energies[i];
        }
    }
    report_energies(count, judged, report);
    for (size_t i = 0; i < x->given; i++) {
        given[i] = energies[x->which[i]];
    }
}
