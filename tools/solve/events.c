#include "tools/solve/events.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Samples of time; points along the rod; numbers of a load and an end. */
enum { SAMPLES = 2049, POINTS = 5, LOAD = 12, END = 13, NUMBERS = POINTS * LOAD + 2 * END };

_Static_assert(sizeof(solve_load) == LOAD * sizeof(double), "a load is its numbers");

typedef struct samples {
    double s[SAMPLES], t[SAMPLES];
    solve_load loads[SAMPLES];
    solve_end_state ends[SAMPLES];
    double numbers[SAMPLES][NUMBERS];
} samples;

/* All that acts, by sample. */
static ad_status take(const solve_rod *rod, samples *x, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < SAMPLES; i++) {
        x->t[i] = rod->duration * i / (SAMPLES - 1);
    }
    for (int point = 0; status == AD_OK && point < POINTS; point++) {
        for (int i = 0; i < SAMPLES; i++) {
            x->s[i] = (point + 0.5) / POINTS;
        }
        status = solve_rod_loads(rod, SAMPLES, x->s, x->t, x->loads, error);
        for (int i = 0; i < SAMPLES; i++) {
            memcpy(x->numbers[i] + point * LOAD, &x->loads[i], sizeof x->loads[i]);
        }
    }
    for (int end = 0; status == AD_OK && end < 2; end++) {
        status = solve_rod_ends(rod, end, SAMPLES, x->t, x->ends, error);
        for (int i = 0; i < SAMPLES; i++) {
            double *to = x->numbers[i] + POINTS * LOAD + end * END;
            memcpy(to, x->ends[i].position, 3 * sizeof *to);
            memcpy(to + 3, x->ends[i].rotation, 4 * sizeof *to);
            memcpy(to + 7, x->ends[i].force, 3 * sizeof *to);
            memcpy(to + 10, x->ends[i].moment, 3 * sizeof *to);
        }
    }
    return status;
}

static double distance(const double *p, const double *q)
{
    double sum = 0;
    for (int i = 0; i < NUMBERS; i++) {
        sum += (p[i] - q[i]) * (p[i] - q[i]);
    }
    return sqrt(sum);
}

static size_t choose(const samples *x, double *times)
{
    size_t count = 0;
    double largest = 0, sum = 0;
    for (int i = 1; i < SAMPLES; i++) {
        largest = fmax(largest, distance(x->numbers[i], x->numbers[0]));
    }
    for (int i = 1; i + 1 < SAMPLES && largest > 0; i++) {
        double next = distance(x->numbers[i + 1], x->numbers[i]);
        sum += next;
        if (sum > largest / 2) {
            times[count++] = x->t[i];
            sum = next;
        }
    }
    return count;
}

static ad_status check_finite(const solve_rod *rod, const samples *x, ad_error *error)
{
    for (int i = 0; i < SAMPLES; i++) {
        for (int k = 0; k < NUMBERS; k++) {
            if (!isfinite(x->numbers[i][k])) {
                return ad_fail(error, AD_NOT_FINITE,
                               "what loads or holds the rod is not finite at t = %g s",
                               x->t[i] * rod->scales.time);
            }
        }
    }
    return AD_OK;
}

ad_status events_find(const solve_rod *rod, size_t *count, double **times, ad_error *error)
{
    *count = 0;
    *times = malloc(SAMPLES * sizeof **times);
    samples *x = malloc(sizeof *x);
    ad_status status = *times && x
                           ? take(rod, x, error)
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for samples of time");
    status = status == AD_OK ? check_finite(rod, x, error) : status;
    if (status == AD_OK) {
        *count = choose(x, *times);
    }
    free(x);
    return status;
}
