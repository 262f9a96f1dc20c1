#include "physics/local/drives.h"

#include "physics/scene/breaks.h"
#include "physics/scene/scene_walk.h"

#include <math.h>
#include <stdlib.h>

/* Places along the rod at which a formula of s and t counts. */
enum { PLACES = 5 };

/* Parts of the duration; of a panel at least so many, where there are few panels and where there
 * are many. */
enum { PARTS = 2048, OF_PANEL = 32, FEW = 256, OF_MANY = 8 };

/* Of the duration: jumps are known to rounding. */
static const double INSIDE = 1e-12;

double solve_drives_inside(const solve_drives *d)
{
    return INSIDE * d->duration;
}

double solve_drive_at(const solve_drives *d, size_t which, double t)
{
    return quantity_value(d->all[which].q, d->all[which].s, fmin(t * d->unit, d->end));
}

int solve_drives_parts(const solve_drives *d, int panel)
{
    double share = (d->edges[panel + 1] - d->edges[panel]) / d->duration;
    int least = d->panels <= FEW ? OF_PANEL : OF_MANY, by_length = (int)ceil(PARTS * share);
    return by_length > least ? by_length : least;
}

static void add_drive(void *context, const char *key, quantity q, quantity_interval s)
{
    solve_drives *d = context;
    int places = quantity_depends_on(q, "s") ? PLACES : 1;
    for (int i = 0; i < places; i++) {
        double at = s.low + (s.high - s.low) * (i + 0.5) / places;
        d->all[d->count++] = (solve_drive){.key = key, .q = q, .s = at};
    }
}

static ad_status find_panels(const solve_rod *rod, solve_drives *d, ad_error *error)
{
    scene_breaks breaks;
    scene_panels panels;
    ad_status status = scene_breaks_of(&rod->scene, "t", &breaks, error);
    status = status == AD_OK ? scene_panels_of(&rod->scene, "t", &panels, error) : status;
    if (status != AD_OK) {
        return status;
    }
    d->edges = panels.edges;
    d->panels = panels.count;
    d->unresolved = panels.unresolved;
    for (int i = 0; i <= panels.count; i++) {
        d->edges[i] /= d->unit;
    }
    d->edges[panels.count] = d->duration;
    d->places = malloc(((size_t)breaks.count + 1) * sizeof *d->places);
    for (int i = 0; i < breaks.count && d->places; i++) {
        d->places[d->breaks++] = breaks.place[i] / d->unit;
    }
    return d->places ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for instants");
}

/* Of its largest value: what a drive varies by is rounding. */
static const double ROUNDING = 1e-14;

/* Range and size of one drive. */
static ad_status measure(solve_drives *d, size_t which, ad_error *error)
{
    solve_drive *drive = &d->all[which];
    const double start = solve_drive_at(d, which, 0);
    double low = start, high = start;
    for (int p = 0; p < d->panels; p++) {
        const double inside = solve_drives_inside(d), from = d->edges[p] + inside;
        const double length = d->edges[p + 1] - inside - from;
        const int parts = solve_drives_parts(d, p);
        for (int i = 0; i <= parts; i++) {
            double t = from + length * i / parts, value = solve_drive_at(d, which, t);
            if (!isfinite(value)) {
                return ad_fail(error, AD_NOT_FINITE, "%s is not finite at t = %g s", drive->key,
                               t * d->unit);
            }
            low = fmin(low, value);
            high = fmax(high, value);
            drive->size += fabs(value - start) * length / parts;
        }
    }
    drive->range = high - low > ROUNDING * fmax(fabs(low), fabs(high)) ? high - low : 0;
    return AD_OK;
}

ad_status solve_drives_create(const solve_rod *rod, solve_drives **result, ad_error *error)
{
    size_t most = PLACES * scene_walk_formulas(&rod->scene, "t");
    solve_drives *d = calloc(1, sizeof *d);
    *result = NULL;
    if (d) {
        *d = (solve_drives){.unit = rod->scales.time,
                            .end = scene_duration(&rod->scene),
                            .duration = rod->duration};
        d->all = malloc((most + 1) * sizeof *d->all);
    }
    if (!d || !d->all) {
        solve_drives_free(d);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu formulas", most);
    }
    scene_walk(&rod->scene, "t", &(scene_walker){.formula = add_drive, .context = d});
    ad_status status = find_panels(rod, d, error);
    size_t formulas = d->count;
    d->count = 0;
    for (size_t i = 0; i < formulas && status == AD_OK; i++) { /* those that vary */
        d->all[d->count] = d->all[i];
        status = measure(d, d->count, error);
        d->count += d->all[d->count].range > 0;
    }
    if (status != AD_OK) {
        solve_drives_free(d);
        return status;
    }
    *result = d;
    return AD_OK;
}

void solve_drives_free(solve_drives *d)
{
    if (d) {
        free(d->all);
        free(d->edges);
        free(d->places);
        free(d);
    }
}
