#include "physics/solve/measured_trials.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void solve_trials_forget(solve_trials *trials)
{
    for (int i = 0; trials->recordings && i < ad_pool_threads(trials->pool); i++) {
        solve_recording_free(trials->recordings[i]);
    }
    free(trials->recordings);
    trials->recordings = NULL;
}

/* One rod has all values of the unknowns, as a family has those of its parameters. */
static ad_status check(const scene *open, ad_error *error)
{
    scene family = *open;
    const char *key = "";
    ad_error reason;
    scene_place_ends(open, &family);
    family.unknown_count = 0;
    const ad_status status = scene_check(&family, &key, &reason);
    return status == AD_OK ? AD_OK
                           : ad_fail(error, status,
                                     "%s: %s; a recording with inputs over time is followed by one "
                                     "rod for all values",
                                     key, reason.message);
}

ad_status solve_trials_record(solve_trials *trials, int more, ad_error *error)
{
    int modes[4];
    trials->more = more;
    solve_trials_forget(trials);
    if (!trials->row[trials->rows - 1].inputs) {
        return AD_OK;
    }
    solve_trials_modes(trials, modes);
    const int threads = ad_pool_threads(trials->pool);
    trials->recordings = calloc((size_t)threads, sizeof(solve_recording *));
    ad_status status = trials->recordings ? check(&trials->open, error)
                                          : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (int i = 0; i < threads && status == AD_OK; i++) {
        status = solve_recording_create(&trials->open, modes, trials->places, trials->place,
                                        &trials->recordings[i], error);
    }
    return status;
}

/* Of an experiment, as solve_recording_run has it: its rows in the order of their times, which
 * delays may change. */
typedef struct following {
    solve_recording *by;
    const solve_inputs *inputs;
    const double *parameters, *t;
    const size_t *places;
    size_t rows;
    const measured_row **row; /* [rows] */
} following;

static void free_rows(following *f)
{
    free((void *)f->t);
    free(f->row);
}

static ad_status run(const following *f, int parts, double *values, ad_error *error)
{
    return solve_recording_run(f->by, f->inputs, f->parameters, parts, f->rows, f->t, f->places,
                               values, error);
}

/* Twice as many steps between samples as long as that changes something. */
static ad_status refine(const solve_trials *trials, const following *f, int *parts, double *values,
                        double *finer, ad_error *error)
{
    enum { PARTS_MAX = 16, COLUMNS = 7 };
    ad_status status = AD_OK;
    for (bool coarse = true; status == AD_OK && coarse && *parts < PARTS_MAX;) {
        status = run(f, 2 * *parts, finer, error);
        coarse = false;
        for (size_t i = 0; i < COLUMNS * f->rows && status == AD_OK; i++) {
            const double unit = i < 3 * f->rows ? scene_length(&trials->open) : 1;
            coarse = coarse || fabs(values[i] - finer[i]) > trials->tolerance * unit;
            values[i] = finer[i];
        }
        *parts *= coarse ? 2 : 1;
    }
    return status;
}

/* Times and places of the rows of an experiment, for free_rows. */
static ad_status open_rows(const solve_trials *trials, size_t experiment, int thread,
                           const double *parameters, following *f, ad_error *error)
{
    const size_t first = trials->first[experiment], rows = trials->first[experiment + 1] - first;
    double *t = malloc(rows * (sizeof(double) + sizeof(size_t)));
    size_t *places = t ? (size_t *)(void *)(t + rows) : NULL;
    const measured_row **row = malloc(rows * sizeof *row);
    for (size_t i = 0; i < rows && t && row; i++) {
        const measured_row *of = &trials->row[first + i];
        const double time = solve_trials_time(trials, of, parameters);
        size_t at = i;
        for (; at > 0 && t[at - 1] > time; at--) {
            t[at] = t[at - 1];
            row[at] = row[at - 1];
        }
        t[at] = time;
        row[at] = of;
    }
    for (size_t i = 0; i < rows && t && row; i++) {
        places[i] = row[i]->place;
    }
    *f = (following){
        trials->recordings[thread], trials->row[first].inputs, parameters, t, places, rows, row};
    return t && row ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", rows);
}

ad_status solve_trials_follow(solve_trials *trials, size_t experiment, int thread,
                              const double *parameters, double *residuals, ad_error *error)
{
    following f;
    ad_status status = open_rows(trials, experiment, thread, parameters, &f, error);
    const size_t width = (size_t)scene_physics_of(&trials->open)->column_count * f.rows;
    double *values = status == AD_OK ? malloc(2 * width * sizeof *values) : NULL;
    int parts = trials->nodes[experiment] > 0 ? (int)trials->nodes[experiment] : 1;
    if (status == AD_OK) {
        status = values ? run(&f, parts, values, error)
                        : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", f.rows);
    }
    if (status == AD_OK && trials->chooses && trials->nodes[experiment] == 0) {
        status = refine(trials, &f, &parts, values, values + width, error);
        trials->nodes[experiment] = parts;
    }
    for (size_t i = 0; i < f.rows && status == AD_OK; i++) {
        solve_trials_compare(trials, f.row[i], parameters, values + i, f.rows,
                             residuals + f.row[i]->residual);
    }
    free_rows(&f);
    free(values);
    return status;
}

ad_status solve_trials_follow_change(solve_trials *trials, size_t experiment, int thread,
                                     const double *parameters, solve_trials_taker *take,
                                     void *context, ad_error *error)
{
    following f;
    ad_status status = open_rows(trials, experiment, thread, parameters, &f, error);
    const size_t width = (size_t)scene_physics_of(&trials->open)->column_count * f.rows;
    const size_t unknowns = (size_t)trials->unknowns;
    double *values = status == AD_OK ? calloc((1 + unknowns) * width, sizeof *values) : NULL;
    if (status == AD_OK) {
        status = values
                     ? solve_recording_change(f.by, f.inputs, parameters,
                                              (int)fmax(1, trials->nodes[experiment]), f.rows, f.t,
                                              f.places, values, unknowns, values + width, error)
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", f.rows);
    }
    for (size_t i = 0; i < f.rows && status == AD_OK; i++) {
        take(context, f.row[i], values + i, values + width + i, width, f.rows);
    }
    free_rows(&f);
    free(values);
    return status;
}
