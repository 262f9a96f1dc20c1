/* Medians and spreads over seeds. */
#include "tools/judge/compare.h"

#include "physics/numerics/sort.h"

#include <math.h>
#include <stdlib.h>

const double compare_limits[COMPARE_LIMITS] = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6};

compare_spread compare_spread_of(double *values, size_t count)
{
    if (count == 0) {
        return (compare_spread){NAN, NAN, NAN};
    }
    sort_ascending(count, values);
    double low = values[(count - 1) / 2], high = values[count / 2];
    return (compare_spread){low == high ? low : low + (high - low) / 2, values[0],
                            values[count - 1]};
}

double compare_best(const compare_run *run, judge_measure measure, double seconds)
{
    double best = INFINITY;
    for (size_t i = 0; i < run->count && run->rows[i].seconds <= seconds; i++) {
        double error = run->rows[i].errors[measure];
        best = error < best ? error : best;
    }
    return best;
}

double compare_reached(const compare_run *run, judge_measure measure, double limit)
{
    for (size_t i = 0; i < run->count; i++) {
        if (run->rows[i].errors[measure] <= limit) {
            return run->rows[i].seconds;
        }
    }
    return INFINITY;
}

/* The error that a run leaves behind. */
static double last_error(const compare_run *run, judge_measure measure)
{
    double error = run->count > 0 && !compare_failed(run)
                       ? run->rows[run->count - 1].errors[measure]
                       : INFINITY;
    return isnan(error) ? INFINITY : error;
}

/* Runs of the cell into `runs`; returns how many. */
static int runs_of(const compare_results *results, int cell,
                   const compare_run *runs[COMPARE_SEEDS_MAX])
{
    int count = 0;
    for (int i = 0; i < results->run_count && count < COMPARE_SEEDS_MAX; i++) {
        if (results->runs[i].cell == cell) {
            runs[count++] = &results->runs[i];
        }
    }
    return count;
}

compare_summary compare_summarize(const compare_results *results, int cell)
{
    const compare_run *runs[COMPARE_SEEDS_MAX];
    double values[COMPARE_SEEDS_MAX];
    compare_summary summary = {.seeds = runs_of(results, cell, runs)};
    size_t count = (size_t)summary.seeds, rated = 0;
    for (size_t i = 0; i < count; i++) {
        summary.failed += compare_failed(runs[i]);
        summary.warned += verdict_outcome_of(&runs[i]->verdict) == VERDICT_WARNING;
        values[i] = last_error(runs[i], results->measure);
    }
    summary.error = compare_spread_of(values, count);
    for (int k = 0; k < COMPARE_LIMITS; k++) {
        for (size_t i = 0; i < count; i++) {
            values[i] = compare_reached(runs[i], results->measure, compare_limits[k]);
        }
        summary.reached[k] = compare_spread_of(values, count).median;
    }
    for (size_t i = 0; i < count; i++) {
        values[i] = runs[i]->seconds;
    }
    summary.seconds = compare_spread_of(values, count).median;
    for (size_t i = 0; i < count; i++) {
        if (runs[i]->steps > 0 && runs[i]->seconds > 0) {
            values[rated++] = (double)runs[i]->steps / runs[i]->seconds;
        }
    }
    summary.steps_per_second = compare_spread_of(values, rated).median;
    return summary;
}

/* Earliest and latest row of the runs of a scene, or of a cell if cell >= 0. */
static bool extent(const compare_results *results, int scene, int cell, double *first, double *last)
{
    *first = INFINITY;
    *last = -INFINITY;
    for (int i = 0; i < results->run_count; i++) {
        const compare_run *run = &results->runs[i];
        bool wanted = cell >= 0 ? run->cell == cell : results->cells[run->cell].scene == scene;
        if (wanted && run->count > 0) {
            *first = fmin(*first, run->rows[0].seconds);
            *last = fmax(*last, run->rows[run->count - 1].seconds);
        }
    }
    return *first <= *last;
}

static void band_add(const compare_results *results, int cell, double seconds, compare_band *band)
{
    const compare_run *runs[COMPARE_SEEDS_MAX];
    double values[COMPARE_SEEDS_MAX];
    int count = runs_of(results, cell, runs);
    for (int i = 0; i < count; i++) {
        values[i] = compare_best(runs[i], results->measure, seconds);
    }
    compare_spread spread = compare_spread_of(values, (size_t)count);
    if (isfinite(spread.median)) {
        band->seconds[band->count] = seconds;
        band->errors[band->count++] = spread;
    }
}

void compare_band_of(const compare_results *results, int cell, compare_band *band)
{
    double first, last, begin, end;
    band->count = 0;
    if (!extent(results, -1, cell, &begin, &end) ||
        !extent(results, results->cells[cell].scene, -1, &first, &last)) {
        return;
    }
    for (int i = 0; i < COMPARE_GRID; i++) {
        double seconds = first * pow(last / first, (double)i / (COMPARE_GRID - 1));
        if (seconds >= begin && seconds < end) {
            band_add(results, cell, seconds, band);
        }
    }
    band_add(results, cell, end, band);
}
