#include "physics/solve/events.h"

#include "physics/numerics/gauss.h"
#include "physics/numerics/sort.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- instants ------------------------------------------------------------------------------ */

static ad_status add(solve_events *e, double t, ad_error *error)
{
    if ((e->count & (e->count + 1)) == 0) { /* room for one less than a power of two */
        double *more = realloc(e->times, (2 * e->count + 1) * sizeof *more);
        if (!more) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for instants");
        }
        e->times = more;
    }
    e->times[e->count++] = t;
    return AD_OK;
}

/* Where between two times most of the change of a drive is: two instants, one jump. */
static ad_status add_jump(solve_events *e, size_t which, double early, double late, ad_error *error)
{
    const solve_drives *d = e->drives;
    double before = solve_drive_at(d, which, early), after = solve_drive_at(d, which, late);
    while (late - early > EVENTS_JUMP * d->duration) {
        double middle = (early + late) / 2, value = solve_drive_at(d, which, middle);
        bool is_later = fabs(value - before) < fabs(after - value);
        *(is_later ? &before : &after) = value;
        *(is_later ? &early : &late) = middle;
    }
    ad_status status = add(e, early, error);
    return status == AD_OK ? add(e, late, error) : status;
}

/* On one panel: an instant wherever any drive has changed by half of its range since the last;
 * before, sum: [drives]. */
static ad_status add_changes(solve_events *e, int panel, double *before, double *sum,
                             ad_error *error)
{
    const solve_drives *d = e->drives;
    const int parts = solve_drives_parts(d, panel);
    const double inside = solve_drives_inside(d), from = d->edges[panel] + inside;
    const double length = d->edges[panel + 1] - inside - from;
    ad_status status = AD_OK;
    for (int i = 0; i <= parts && status == AD_OK; i++) {
        double early = from + length * (i - 1) / parts, late = from + length * i / parts;
        bool is_due = false, jumps = false;
        for (size_t k = 0; k < d->count && status == AD_OK; k++) {
            double value = solve_drive_at(d, k, late), half = d->all[k].range / 2;
            double change = i > 0 ? fabs(value - before[k]) : 0;
            before[k] = value;
            sum[k] = i > 0 ? sum[k] + change : 0;
            is_due |= sum[k] > half;
            if (change > half) {
                jumps = true;
                status = add_jump(e, k, early, late, error);
            }
        }
        if (is_due) {
            status = status == AD_OK && !jumps ? add(e, early, error) : status;
            memset(sum, 0, d->count * sizeof *sum);
        }
    }
    return status;
}

static bool is_break(const solve_drives *d, double t)
{
    for (int i = 0; i < d->breaks; i++) {
        if (fabs(d->places[i] - t) <= solve_drives_inside(d)) {
            return true;
        }
    }
    return false;
}

/* Ascending; of those that are one jump, or closer, the sure ones alone, which are sorted. */
static void tidy(solve_events *e, size_t sure)
{
    const double near = 2 * EVENTS_JUMP * e->drives->duration;
    double *known = e->times;
    size_t kept = sure, at = 0;
    sort_ascending(e->count - sure, e->times + sure);
    for (size_t i = sure; i < e->count; i++) {
        double t = e->times[i];
        while (at + 1 < sure && known[at + 1] <= t) {
            at++;
        }
        bool is_known = sure > 0 && (fabs(known[at] - t) <= near ||
                                     (at + 1 < sure && fabs(known[at + 1] - t) <= near));
        if (!is_known && (kept == sure || t > e->times[kept - 1])) {
            e->times[kept++] = t;
        }
    }
    e->count = kept;
    sort_ascending(e->count, e->times);
}

static ad_status find(solve_events *e, ad_error *error)
{
    const solve_drives *d = e->drives;
    const double inside = solve_drives_inside(d);
    ad_status status = AD_OK;
    for (int p = 1; p < d->panels && status == AD_OK; p++) {
        bool jumps = is_break(d, d->edges[p]);
        status = add(e, d->edges[p] - (jumps ? inside : 0), error);
        status = status == AD_OK && jumps ? add(e, d->edges[p] + inside, error) : status;
    }
    const size_t sure = e->count;
    double *room = malloc((2 * d->count + 1) * sizeof *room);
    status = room ? status : ad_fail(error, AD_NO_MEMORY, "out of memory for instants");
    for (int p = 0; p < d->panels && status == AD_OK; p++) {
        status = add_changes(e, p, room, room + d->count, error);
    }
    free(room);
    tidy(e, sure);
    return status;
}

ad_status solve_events_create(const solve_rod *rod, solve_events **result, ad_error *error)
{
    solve_events *e = calloc(1, sizeof *e);
    *result = NULL;
    ad_status status = e ? solve_drives_create(rod, &e->drives, error)
                         : ad_fail(error, AD_NO_MEMORY, "out of memory for instants");
    status = status == AD_OK ? find(e, error) : status;
    if (status != AD_OK) {
        solve_events_free(e);
        return status;
    }
    *result = e;
    return AD_OK;
}

void solve_events_free(solve_events *e)
{
    if (e) {
        solve_drives_free(e->drives);
        free(e->times);
        free(e);
    }
}

double solve_events_before(const solve_events *e, double t)
{
    const double most = EVENTS_JUMP * e->drives->duration;
    for (size_t k = 1; k < e->count; k++) {
        const double before = e->times[k - 1], after = e->times[k];
        if (after - before <= most && before <= t && t <= after * (1 + DBL_EPSILON)) {
            return before;
        }
    }
    return t;
}

/* ---- whether steps have met it ------------------------------------------------------------- */

ad_status solve_clock_add(solve_clock *clock, double t, ad_error *error)
{
    if (clock->count == clock->room) {
        size_t room = 2 * clock->room + 64;
        double *more = realloc(clock->ends, room * sizeof *more);
        if (!more) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu steps", room);
        }
        clock->ends = more;
        clock->room = room;
    }
    clock->ends[clock->count++] = t;
    return AD_OK;
}

/* A step has met a drive where its sums are off by no more than a share of what the drive does
 * within it beyond a straight line; what is then left, error control and the next tolerance see.
 * Nothing is asked of steps in which a drive does less than a share of all that it does, or than so
 * much of its range in a unit of time. */
static const double SHARE = 0.05, LITTLE_OF_SIZE = 1e-3, LITTLE_OF_RANGE = 1e-4;

/* Parts of a panel, each with so many points of quadrature; a step no longer than a part sees what
 * the panel has. */
enum { CELLS = 32, POINTS = 4, QUANTILES = 8 };

/* A drive in one step, which is from -1/2 to 1/2: integrals of the drive and of it times the place;
 * and of how far it is from a straight line. */
typedef struct moments {
    double zeroth, first, beyond;
} moments;

typedef struct meeting {
    solve_events *e;
    const solve_clock *clock;
    const gauss_rule *rule;
    size_t which;
    double from, length, left, right; /* the step, and the drive at its ends */
    double wanted, passed;            /* of moments.beyond, for quantiles */
} meeting;

static double line_at(const meeting *in, double t)
{
    return in->left + (in->right - in->left) * (t - in->from) / in->length;
}

static ad_status add_cell(meeting *in, double from, double length, bool divides, moments *sum,
                          ad_error *error)
{
    double before = sum->beyond;
    for (int i = 0; i < in->rule->stages; i++) {
        double t = from + length * in->rule->nodes[i], weight = length * in->rule->weights[i];
        double value = solve_drive_at(in->e->drives, in->which, t) - line_at(in, t);
        sum->zeroth += weight * value;
        sum->first += weight * value * ((t - in->from) / in->length - 0.5);
        sum->beyond += weight * fabs(value);
    }
    in->passed += sum->beyond - before;
    if (divides && in->passed > in->wanted) {
        in->passed = 0;
        return add(in->e, from + length, error);
    }
    return AD_OK;
}

/* By quadrature on parts of panels; divides: with instants between equal shares of `wanted`. */
static ad_status integrate(meeting *in, int panel, bool divides, moments *sum, ad_error *error)
{
    const solve_drives *d = in->e->drives;
    const double inside = solve_drives_inside(d), end = in->from + in->length;
    ad_status status = AD_OK;
    *sum = (moments){0};
    for (int p = panel; p < d->panels && d->edges[p] < end && status == AD_OK; p++) {
        double low = fmax(in->from, d->edges[p] + inside);
        double high = fmin(end, d->edges[p + 1] - inside);
        double part = (d->edges[p + 1] - d->edges[p]) / CELLS;
        int cells = high > low ? 1 + (int)((high - low) / part) : 0;
        for (int i = 0; i < cells && status == AD_OK; i++) {
            double length = (high - low) / cells;
            status = add_cell(in, low + length * i, length, divides, sum, error);
        }
    }
    return status;
}

static moments seen_by_stages(const meeting *in)
{
    moments sum = {0};
    for (int i = 0; i < in->clock->stages; i++) {
        double at = in->clock->at[i], t = in->from + at * in->length;
        double weight = in->clock->weights[i] * in->length;
        double value = solve_drive_at(in->e->drives, in->which, t) - line_at(in, t);
        sum.zeroth += weight * value;
        sum.first += weight * value * (at - 0.5);
    }
    return sum;
}

/* One drive in one step. */
static ad_status meet(meeting *in, int panel, bool *missed, ad_error *error)
{
    const solve_drives *d = in->e->drives;
    const solve_drive *drive = &d->all[in->which];
    const double inside = solve_drives_inside(d);
    const double little = fmin(LITTLE_OF_SIZE * drive->size, LITTLE_OF_RANGE * drive->range);
    moments exact, seen;
    in->left = solve_drive_at(d, in->which, in->from + fmin(inside, in->length / 4));
    in->right = solve_drive_at(d, in->which, in->from + in->length - fmin(inside, in->length / 4));
    *missed = false;
    ad_status status = integrate(in, panel, false, &exact, error);
    if (status != AD_OK || exact.beyond <= little) {
        return status;
    }
    seen = seen_by_stages(in);
    double off = fmax(fabs(seen.zeroth - exact.zeroth), fabs(seen.first - exact.first));
    *missed = !(off <= SHARE * exact.beyond);
    if (*missed) {
        in->wanted = exact.beyond / QUANTILES;
        in->passed = 0;
        status = integrate(in, panel, true, &exact, error);
    }
    return status;
}

ad_status solve_events_meet(solve_events *e, const solve_clock *clock, size_t *missed,
                            const char **key, ad_error *error)
{
    const gauss_rule rule = solve_gauss_rule_of(POINTS);
    const solve_drives *d = e->drives;
    const size_t sure = e->count;
    meeting in = {.e = e, .clock = clock, .rule = &rule};
    ad_status status = AD_OK;
    int panel = 0;
    *missed = 0;
    for (size_t i = 0; d->count > 0 && i + 1 < clock->count && status == AD_OK; i++) {
        bool any = false;
        in.from = clock->ends[i];
        in.length = clock->ends[i + 1] - in.from;
        while (panel + 1 < d->panels && d->edges[panel + 1] <= in.from) {
            panel++;
        }
        if (in.length <= (d->edges[panel + 1] - d->edges[panel]) / CELLS) {
            continue;
        }
        for (in.which = 0; in.which < d->count && status == AD_OK; in.which++) {
            bool misses;
            status = meet(&in, panel, &misses, error);
            *key = misses ? d->all[in.which].key : *key;
            any |= misses;
        }
        *missed += any;
    }
    tidy(e, sure);
    return status;
}
