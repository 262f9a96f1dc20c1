#include "tools/judge/sweep.h"

#include "physics/numerics/sort.h"
#include "tools/train/clock.h"

#include <math.h>

enum { REPEATS = 5 };

static const int at_rest[] = {2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 96, 128, 192, 256};
static const int moving[] = {5, 7, 9, 11, 13, 17, 21};
static const double rounding = 1e-14;

/* Everything counts, the scene's formulas included. */
static ad_status solve_repeatedly(const scene *rod_scene, const solve_settings *settings,
                                  size_t count, const double *times, solution **solved,
                                  solve_report *report, double *median, ad_error *error)
{
    double seconds[REPEATS] = {0};
    int repeats = scene_is_dynamic(rod_scene) ? 1 : REPEATS;
    ad_status status = AD_OK;
    for (int i = 0; i < repeats && status == AD_OK; i++) {
        solution_free(*solved);
        double start = train_seconds();
        status = solution_create(rod_scene, settings, count, times, solved, report, error);
        seconds[i] = train_seconds() - start;
    }
    sort_ascending((size_t)repeats, seconds);
    *median = seconds[repeats / 2];
    return status;
}

ad_status solve_sweep(const scene *rod_scene, size_t count, const double *times,
                      solve_sweep_row *row, void *context, ad_error *error)
{
    const bool dynamic = scene_is_dynamic(rod_scene);
    const size_t rows = dynamic ? sizeof moving / sizeof *moving : sizeof at_rest / sizeof *at_rest;
    solve_settings settings = {.tolerance = 1e-1};
    for (size_t i = 0; i < rows; i++) {
        solution *solved = NULL;
        solve_report report;
        double seconds = 0, found = INFINITY;
        settings.nodes = dynamic ? moving[i] : at_rest[i];
        settings.tolerance /= 10;
        ad_status status =
            solve_repeatedly(rod_scene, &settings, count, times, &solved, &report, &seconds, error);
        if (status == AD_OK && (dynamic || report.load_fraction == 1)) {
            found = row(context, report.nodes, seconds, solved);
        }
        solution_free(solved);
        if (status != AD_OK || !(found >= rounding)) {
            return status;
        }
    }
    return AD_OK;
}
