#include "tools/train/judged.h"

#include "physics/numerics/sort.h"

#include <math.h>
#include <stdlib.h>

/* How many residuals a row has. */
static int count_of(const solve_measured *set, size_t row)
{
    int count = set->columns == 4 ? -1 : 0; /* a quaternion has three */
    for (int c = 0; c < set->columns; c++) {
        count += !isnan(set->values[(size_t)c * set->rows + row]);
    }
    return count;
}

static int most_of(const solve_measured *set)
{
    int most = 1;
    for (size_t row = 0; row < set->rows; row++) {
        const int count = count_of(set, row);
        most = count > most ? count : most;
    }
    return most;
}

static double square_of(int count, const double *residuals)
{
    double sum = 0;
    for (int i = 0; i < count; i++) {
        sum += residuals[i] * residuals[i];
    }
    return sum;
}

/* Returns how many residuals the set has. */
static size_t judge_set(const solve_measured *set, const double *residuals, double *distances,
                        judged_set *result)
{
    const int all = most_of(set);
    double squares = 0;
    for (size_t row = 0; row < set->rows; row++) {
        const int count = count_of(set, row);
        const double square = square_of(count, residuals + result->numbers);
        result->numbers += (size_t)count;
        result->chi_squared += square;
        if (count == all) {
            const double distance = set->noise[0] * sqrt(square);
            distances[result->rows++] = distance;
            result->mean += distance;
            squares += distance * distance;
        }
    }
    const double rows = (double)result->rows;
    result->mean /= rows;
    result->rms = sqrt(squares / rows);
    result->median = result->worst = NAN;
    if (isfinite(squares) && result->rows > 0) {
        sort_ascending(result->rows, distances);
        result->median = (distances[(result->rows - 1) / 2] + distances[result->rows / 2]) / 2;
        result->worst = distances[result->rows - 1];
    }
    return result->numbers;
}

ad_status measured_judge(const scene *open, const measurements *data, const double *values,
                         int threads, judged *result, ad_error *error)
{
    const solve_measured *sets = measurements_sets(data);
    const int fitted = measurements_count(data), count = fitted + measurements_held_out(data);
    solve_trials *trials = NULL;
    size_t rows = 0, at = 0;
    *result = (judged){.count = 0};
    ad_status status = solve_trials_create(open, count, sets, 0, threads, &trials, error);
    for (int i = 0; i < count; i++) {
        rows += sets[i].rows;
    }
    const size_t numbers = status == AD_OK ? solve_trials_residuals(trials) : 0;
    double *residuals = malloc((numbers + rows + 1) * sizeof *residuals);
    if (status == AD_OK && !residuals) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu residuals", numbers);
    }
    if (status == AD_OK) {
        status = solve_trials_run(trials, 1, values, false, residuals, error);
    }
    for (int i = 0; status == AD_OK && i < count; i++) {
        judged_set *to = &result->set[result->count++];
        *to = (judged_set){.entry = measurements_entry(data, i), .held_out = i >= fitted};
        at += judge_set(&sets[i], residuals + at, residuals + numbers, to);
    }
    free(residuals);
    solve_trials_free(trials);
    return status;
}
