#include "physics/solve/events.h"

#include "physics/breaks.h"
#include "physics/sort.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Samples of time; points along the rod; numbers of a load, of v* and u*, and of an end. */
enum { SAMPLES = 2049, POINTS = 5, LOAD = 12, REST = 6, END = 13 };
enum { ALONG = LOAD + REST, NUMBERS = POINTS * ALONG + 2 * END };

_Static_assert(sizeof(solve_load) == LOAD * sizeof(double), "a load is its numbers");

/* Of the duration: how far before and after a break, whose place is exact, loads are those of
 * either side. */
static const double EVENTS_HALF_JUMP = 1e-12;

/* So many panels at most belong to what is narrow; more of them only to bounds that are wide, as
 * those of formulas of s and t are. */
enum { NARROW = 256 };

enum { EXTRA = SAMPLES }; /* place of one more */

typedef struct samples {
    double s[SAMPLES + 1], t[SAMPLES + 1];
    solve_load loads[SAMPLES + 1];
    solve_rest rest[SAMPLES + 1];
    solve_end_state ends[SAMPLES + 1];
    double numbers[SAMPLES + 1][NUMBERS]; /* all that acts */
} samples;

/* Those from `first` on, at their times. */
static ad_status take(const solve_rod *rod, samples *x, int first, int count, ad_error *error)
{
    ad_status status = AD_OK;
    for (int point = 0; status == AD_OK && point < POINTS; point++) {
        for (int i = first; i < first + count; i++) {
            x->s[i] = (point + 0.5) / POINTS;
        }
        status = solve_rod_loads(rod, (size_t)count, x->s + first, x->t + first, x->loads + first,
                                 error);
        if (status == AD_OK && rod->rest_moves) {
            status = solve_rod_rests(rod, (size_t)count, x->s + first, x->t + first,
                                     x->rest + first, error);
        }
        for (int i = first; i < first + count; i++) {
            double *to = x->numbers[i] + point * ALONG;
            memcpy(to, &x->loads[i], sizeof x->loads[i]);
            memcpy(to + LOAD, x->rest[i].strain, sizeof x->rest[i].strain);
            memcpy(to + LOAD + 3, x->rest[i].curvature, sizeof x->rest[i].curvature);
        }
    }
    for (int end = 0; status == AD_OK && end < 2; end++) {
        for (int i = first; i < first + count; i++) {
            x->s[i] = end;
        }
        status = solve_rod_ends(rod, end, (size_t)count, x->s + first, x->t + first,
                                x->ends + first, error);
        for (int i = first; i < first + count; i++) {
            double *to = x->numbers[i] + POINTS * ALONG + end * END;
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

/* Where between samples i and i + 1 most of the change is: from *early to *late. */
static ad_status bisect(const solve_rod *rod, samples *x, int i, double *early, double *late,
                        ad_error *error)
{
    double before[NUMBERS], after[NUMBERS];
    ad_status status = AD_OK;
    memcpy(before, x->numbers[i], sizeof before);
    memcpy(after, x->numbers[i + 1], sizeof after);
    *early = x->t[i];
    *late = x->t[i + 1];
    while (status == AD_OK && *late - *early > EVENTS_JUMP * rod->duration) {
        double *middle = x->numbers[EXTRA];
        x->t[EXTRA] = (*early + *late) / 2;
        status = take(rod, x, EXTRA, 1, error);
        bool is_later = distance(middle, before) < distance(after, middle);
        memcpy(is_later ? before : after, middle, sizeof before);
        *(is_later ? early : late) = x->t[EXTRA];
    }
    return status;
}

/* Jumps get two instants. */
static ad_status choose(const solve_rod *rod, samples *x, size_t *count, double *times,
                        ad_error *error)
{
    double largest = 0, sum = 0;
    ad_status status = AD_OK;
    for (int i = 1; i < SAMPLES; i++) {
        largest = fmax(largest, distance(x->numbers[i], x->numbers[0]));
    }
    for (int i = 0; status == AD_OK && i + 1 < SAMPLES && largest > 0; i++) {
        double next = distance(x->numbers[i + 1], x->numbers[i]);
        sum += next;
        if (next > largest / 2) {
            status = bisect(rod, x, i, &times[*count], &times[*count + 1], error);
            *count += 2;
            sum = 0;
        } else if (sum > largest / 2) {
            times[(*count)++] = x->t[i];
            sum = next;
        }
    }
    return status;
}

static ad_status check_finite(const solve_rod *rod, const samples *x, ad_error *error)
{
    for (int i = 0; i < SAMPLES; i++) {
        for (int k = 0; k < NUMBERS; k++) {
            if (!isfinite(x->numbers[i][k])) {
                return ad_fail(error, AD_NOT_FINITE,
                               "what loads, holds or shapes the rod is not finite at t = %g s",
                               x->t[i] * rod->scales.time);
            }
        }
    }
    return AD_OK;
}

/* ---- together ------------------------------------------------------------------------------ */

/* Instants [*count] that samples gave, and those before and after each break of the scene's
 * formulas and between their panels, which see what samples miss; of two that are one jump those of
 * the break. */
static ad_status add_breaks(const solve_rod *rod, size_t *count, double **times, ad_error *error)
{
    scene_breaks breaks;
    scene_panels panels = {0};
    const double scale = 1 / rod->scales.time, near = 2 * EVENTS_JUMP * rod->duration;
    ad_status status = scene_breaks_of(&rod->scene, "t", &breaks, error);
    status = status == AD_OK ? scene_panels_of(&rod->scene, "t", &panels, error) : status;
    if (status != AD_OK) {
        return status;
    }
    bool narrow = !panels.unresolved && panels.count > 1 && panels.count <= NARROW;
    size_t edges = narrow ? (size_t)panels.count - 1 : 0, kept = 0;
    double *all = malloc((*count + 2 * (size_t)breaks.count + edges + 1) * sizeof *all);
    if (!all) {
        scene_panels_free(&panels);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu instants", *count);
    }
    for (int i = 0; i < breaks.count; i++) {
        all[kept++] = fmax(0, breaks.place[i] * scale - EVENTS_HALF_JUMP * rod->duration);
        all[kept++] =
            fmin(rod->duration, breaks.place[i] * scale + EVENTS_HALF_JUMP * rod->duration);
    }
    const size_t sure = kept;
    for (size_t i = 0; i < *count + edges; i++) {
        double at = i < *count ? (*times)[i] : panels.edges[i - *count + 1] * scale;
        bool is_known = false;
        for (size_t k = 0; k < sure; k++) {
            is_known |= fabs(at - all[k]) <= near;
        }
        if (!is_known) {
            all[kept++] = at;
        }
    }
    scene_panels_free(&panels);
    sort_ascending(kept, all);
    free(*times);
    *times = all;
    *count = kept;
    return AD_OK;
}

ad_status solve_events_find(const solve_rod *rod, size_t *count, double **times, ad_error *error)
{
    *count = 0;
    *times = malloc(2 * SAMPLES * sizeof **times);
    samples *x = calloc(1, sizeof *x);
    ad_status status =
        *times && x ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %d samples", SAMPLES);
    for (int i = 0; status == AD_OK && i < SAMPLES; i++) {
        x->t[i] = rod->duration * i / (SAMPLES - 1);
    }
    status = status == AD_OK ? take(rod, x, 0, SAMPLES, error) : status;
    status = status == AD_OK ? check_finite(rod, x, error) : status;
    status = status == AD_OK ? choose(rod, x, count, *times, error) : status;
    status = status == AD_OK ? add_breaks(rod, count, times, error) : status;
    free(x);
    return status;
}
