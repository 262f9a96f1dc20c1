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

/* Panels that are narrow are those on which something differs from what samples would have it by so
 * much of the largest change. Bounds that are wide, as those of formulas of s and t are, make
 * others short. */
static const double UNSEEN = 1e-4;

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

static double largest_change(const samples *x)
{
    double largest = 0;
    for (int i = 1; i < SAMPLES; i++) {
        largest = fmax(largest, distance(x->numbers[i], x->numbers[0]));
    }
    return largest;
}

/* Jumps get two instants. */
static ad_status choose(const solve_rod *rod, samples *x, size_t *count, double *times,
                        ad_error *error)
{
    double largest = largest_change(x), sum = 0;
    ad_status status = AD_OK;
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

/* How far numbers at t are from the line between samples before and after. */
static double off_line(const samples *x, double t, const double *numbers)
{
    double step = x->t[1], line[NUMBERS];
    int i = (int)fmin(t / step, SAMPLES - 2);
    double share = t / step - i;
    for (int k = 0; k < NUMBERS; k++) {
        line[k] = (1 - share) * x->numbers[i][k] + share * x->numbers[i + 1][k];
    }
    return distance(numbers, line);
}

/* Which panels [count], edges in units of time, are narrow: looked at in two places each. */
static ad_status find_narrow(const solve_rod *rod, const samples *x, int count, const double *edges,
                             bool *narrow, ad_error *error)
{
    enum { EACH = 2, BATCH = SAMPLES / EACH };
    double largest = largest_change(x), *off = calloc((size_t)count, sizeof *off);
    samples *within = calloc(1, sizeof *within);
    ad_status status =
        off && within ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %d panels", count);
    for (int first = 0; status == AD_OK && first < count; first += BATCH) {
        int here = count - first < BATCH ? count - first : BATCH;
        for (int i = 0; i < here * EACH; i++) {
            const double *edge = edges + first + i / EACH;
            within->t[i] = edge[0] + (edge[1] - edge[0]) * (i % EACH + 0.25) / EACH;
        }
        status = take(rod, within, 0, here * EACH, error);
        for (int i = 0; status == AD_OK && i < here * EACH; i++) {
            double *to = &off[first + i / EACH];
            *to = fmax(*to, off_line(x, within->t[i], within->numbers[i]));
            largest = fmax(largest, distance(within->numbers[i], x->numbers[0]));
        }
    }
    for (int i = 0; status == AD_OK && i < count; i++) {
        narrow[i] = off[i] > UNSEEN * largest;
    }
    free(off);
    free(within);
    return status;
}

/* The edges of narrow panels and of their neighbours, *edges [*count]; freed by the caller, also
 * after a failure. */
static ad_status find_edges(const solve_rod *rod, const samples *x, int *count, double **edges,
                            ad_error *error)
{
    scene_panels panels = {0};
    ad_status status = scene_panels_of(&rod->scene, "t", &panels, error);
    bool *narrow = calloc((size_t)panels.count + 3, sizeof *narrow);
    *edges = panels.edges;
    *count = 0;
    if (status != AD_OK || !narrow) {
        free(narrow);
        return status != AD_OK ? status : ad_fail(error, AD_NO_MEMORY, "out of memory for panels");
    }
    for (int i = 0; i <= panels.count; i++) {
        panels.edges[i] /= rod->scales.time;
    }
    status = find_narrow(rod, x, panels.count, panels.edges, narrow + 1, error);
    for (int i = 1; i < panels.count; i++) {
        if (narrow[i - 1] || narrow[i] || narrow[i + 1] || narrow[i + 2]) {
            panels.edges[(*count)++] = panels.edges[i];
        }
    }
    free(narrow);
    return status;
}

/* Instants [*count] that samples gave, and those before and after each break of the scene's
 * formulas and between their narrow panels, which see what samples miss; of two that are one jump
 * those of the break. */
static ad_status add_breaks(const solve_rod *rod, const samples *x, size_t *count, double **times,
                            ad_error *error)
{
    scene_breaks breaks;
    double *edges = NULL, *all = NULL;
    int edge_count = 0;
    size_t kept = 0;
    const double scale = 1 / rod->scales.time, near = 2 * EVENTS_JUMP * rod->duration;
    ad_status status = scene_breaks_of(&rod->scene, "t", &breaks, error);
    status = status == AD_OK ? find_edges(rod, x, &edge_count, &edges, error) : status;
    if (status == AD_OK) {
        all = malloc((*count + 2 * (size_t)breaks.count + (size_t)edge_count + 1) * sizeof *all);
        status = all ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for instants");
    }
    if (status != AD_OK) {
        free(edges);
        return status;
    }
    for (int i = 0; i < breaks.count; i++) {
        all[kept++] = fmax(0, breaks.place[i] * scale - EVENTS_HALF_JUMP * rod->duration);
        all[kept++] =
            fmin(rod->duration, breaks.place[i] * scale + EVENTS_HALF_JUMP * rod->duration);
    }
    const size_t sure = kept;
    for (size_t i = 0; i < *count + (size_t)edge_count; i++) {
        double at = i < *count ? (*times)[i] : edges[i - *count];
        bool is_known = false;
        for (size_t k = 0; k < sure; k++) {
            is_known |= fabs(at - all[k]) <= near;
        }
        if (!is_known) {
            all[kept++] = at;
        }
    }
    free(edges);
    sort_ascending(kept, all);
    free(*times);
    *times = all;
    *count = kept;
    return AD_OK;
}

ad_status solve_events_find(const solve_rod *rod, size_t *count, double **times, ad_error *error)
{
    *count = 0;
    *times = malloc(sizeof **times * 2 * SAMPLES);
    samples *x = calloc(1, sizeof *x);
    ad_status status =
        *times && x ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %d samples", SAMPLES);
    for (int i = 0; status == AD_OK && i < SAMPLES; i++) {
        x->t[i] = rod->duration * i / (SAMPLES - 1);
    }
    status = status == AD_OK ? take(rod, x, 0, SAMPLES, error) : status;
    status = status == AD_OK ? check_finite(rod, x, error) : status;
    status = status == AD_OK ? choose(rod, x, count, *times, error) : status;
    status = status == AD_OK ? add_breaks(rod, x, count, times, error) : status;
    free(x);
    return status;
}
