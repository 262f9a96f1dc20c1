#include "tools/train/judged.h"

#include "physics/numerics/sort.h"
#include "physics/numerics/vector_size.h"
#include "tools/train/judged_rows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static size_t most_of(const scene *open, const solve_measured *set)
{
    size_t most = 1;
    for (size_t row = 0; row < set->rows; row++) {
        const size_t count = solve_measured_residuals(open, set, row);
        most = count > most ? count : most;
    }
    return most;
}

const char *measured_how(const scene *open, bool held_out)
{
    return held_out ? "held_out" : open->unknown_count == 0 ? "compared" : "fitted";
}

void measured_distances(size_t rows, double *distances, judged_set *result)
{
    double sum = 0, squares = 0;
    for (size_t i = 0; i < rows; i++) {
        sum += distances[i];
        squares += distances[i] * distances[i];
    }
    result->rows = rows;
    result->mean = sum / (double)rows;
    result->rms = sqrt(squares / (double)rows);
    result->median = result->worst = NAN;
    if (isfinite(squares) && rows > 0) {
        sort_ascending(rows, distances);
        result->median = (distances[(rows - 1) / 2] + distances[rows / 2]) / 2;
        result->worst = distances[rows - 1];
    }
}

/* Returns how many residuals the set has. */
static size_t judge_set(const scene *open, const solve_measured *set, const double *residuals,
                        double *distances, judged_set *result)
{
    const size_t all = most_of(open, set);
    size_t rows = 0;
    for (size_t row = 0; row < set->rows; row++) {
        const size_t count = solve_measured_residuals(open, set, row);
        const double square = vector_square(count, residuals + result->numbers);
        result->numbers += count;
        result->chi_squared += square;
        result->unsolved += isnan(square) != 0;
        if (count == all) {
            distances[rows++] = set->noise[0] * sqrt(square);
        }
    }
    measured_distances(rows, distances, result);
    return result->numbers;
}

/* What was measured, and points of shapes behind it, at values. */
static ad_status solve_all(const judged_found *x, int count, const solve_measured *sets,
                           int threads, double **residuals, ad_error *unsolved, ad_error *error)
{
    solve_trials *trials = NULL;
    ad_status status = solve_trials_create(x->open, count, sets, 0, threads, &trials, error);
    if (status == AD_OK) {
        const size_t numbers = solve_trials_residuals(trials);
        *residuals = malloc((numbers + 1) * sizeof **residuals);
        status = *residuals
                     ? solve_trials_run(trials, 1, x->values, false, *residuals, error)
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu residuals", numbers);
        snprintf(unsolved->message, sizeof unsolved->message, "%s", solve_trials_reason(trials));
    }
    solve_trials_free(trials);
    return status;
}

static ad_status solve(const judged_found *x, int threads, double **residuals, ad_error *unsolved,
                       ad_error *error)
{
    const int points = x->poses ? x->poses->sets : 0;
    solve_measured *all = malloc((size_t)(x->count + points + 1) * sizeof *all);
    if (!all) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for measurements");
    }
    for (int i = 0; i < x->count + points; i++) {
        all[i] = i < x->count ? x->sets[i] : x->poses->set[i - x->count];
    }
    const ad_status status =
        solve_all(x, x->count + points, all, threads, residuals, unsolved, error);
    free(all);
    return status;
}

static ad_status judge_all(const judged_found *x, const double *residuals, judged *result,
                           ad_error *error)
{
    size_t most = 1, at = 0;
    for (int i = 0; i < x->count; i++) {
        most = x->sets[i].rows > most ? x->sets[i].rows : most;
    }
    double *distances = malloc(most * sizeof *distances);
    for (int i = 0; i < x->count && distances; i++) {
        judged_set *to = &result->set[result->count++];
        *to = (judged_set){.entry = measurements_entry(x->data, i), .held_out = i >= x->fitted};
        at += judge_set(x->open, &x->sets[i], residuals + at, distances, to);
    }
    free(distances);
    return distances ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", most);
}

ad_status measured_judge(const scene *open, const measurements *data,
                         const train_settings *settings, const double *values, double deviation,
                         int threads, judged *result, judged_rows **rows, ad_error *error)
{
    judged_found x = {.open = open,
                      .data = data,
                      .settings = settings,
                      .values = values,
                      .deviation = deviation,
                      .sets = measurements_sets(data),
                      .fitted = measurements_count(data)};
    double *residuals = NULL;
    x.count = x.fitted + measurements_held_out(data);
    *result = (judged){.count = 0};
    ad_status status =
        rows ? measured_poses_create(open, data, settings, values, &x.poses, error) : AD_OK;
    status = status == AD_OK ? solve(&x, threads, &residuals, &result->unsolved, error) : status;
    status = status == AD_OK ? judge_all(&x, residuals, result, error) : status;
    if (rows) {
        *rows = NULL;
        status = status == AD_OK ? measured_rows_create(&x, residuals, rows, error) : status;
    }
    measured_poses_free(x.poses);
    free(residuals);
    return status;
}
