#include "tools/train/judged.h"

#include "physics/numerics/sort.h"
#include "tools/files/file_bytes.h"
#include "tools/files/table_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t most_of(const scene *open, const solve_measured *set)
{
    size_t most = 1;
    for (size_t row = 0; row < set->rows; row++) {
        const size_t count = solve_measured_residuals(open, set, row);
        most = count > most ? count : most;
    }
    return most;
}

static double square_of(size_t count, const double *residuals)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        sum += residuals[i] * residuals[i];
    }
    return sum;
}

/* Returns how many residuals the set has. */
static size_t judge_set(const scene *open, const solve_measured *set, const double *residuals,
                        double *distances, judged_set *result)
{
    const size_t all = most_of(open, set);
    double squares = 0;
    for (size_t row = 0; row < set->rows; row++) {
        const size_t count = solve_measured_residuals(open, set, row);
        const double square = square_of(count, residuals + result->numbers);
        result->numbers += count;
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

/* The scene and its residuals [of all sets], the caller's to free, with room for `rows` more. */
static ad_status solve_all(const scene *open, const measurements *data, const double *values,
                           int threads, double **residuals, size_t *numbers, size_t *rows,
                           ad_error *error)
{
    const solve_measured *sets = measurements_sets(data);
    const int count = measurements_count(data) + measurements_held_out(data);
    solve_trials *trials = NULL;
    *residuals = NULL;
    *rows = 0;
    ad_status status = solve_trials_create(open, count, sets, 0, threads, &trials, error);
    for (int i = 0; i < count; i++) {
        *rows += sets[i].rows;
    }
    if (status == AD_OK) {
        *numbers = solve_trials_residuals(trials);
        *residuals = malloc((*numbers + *rows + 1) * sizeof **residuals);
        status = *residuals
                     ? solve_trials_run(trials, 1, values, false, *residuals, error)
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu residuals", *numbers);
    }
    solve_trials_free(trials);
    return status;
}

ad_status measured_judge(const scene *open, const measurements *data, const double *values,
                         int threads, judged *result, ad_error *error)
{
    const solve_measured *sets = measurements_sets(data);
    const int fitted = measurements_count(data), count = fitted + measurements_held_out(data);
    size_t numbers = 0, rows = 0, at = 0;
    double *residuals;
    *result = (judged){.count = 0};
    ad_status status = solve_all(open, data, values, threads, &residuals, &numbers, &rows, error);
    for (int i = 0; status == AD_OK && i < count; i++) {
        judged_set *to = &result->set[result->count++];
        *to = (judged_set){.entry = measurements_entry(data, i), .held_out = i >= fitted};
        at += judge_set(open, &sets[i], residuals + at, residuals + numbers, to);
    }
    free(residuals);
    return status;
}

/* ---- rows ---------------------------------------------------------------------------------- */

/* A table of all rows being filled: column c of the model stands in 2 c and 2 c + 1. */
typedef struct row_table {
    const scene *open;
    size_t rows, row;
    double *s, *t, *distance, *known, *columns; /* known [parameters][rows] */
    const char **file, **judged;
    bool used[MODEL_COLUMNS_MAX];
} row_table;

static void take_set(row_table *to, const solve_measured *set, const char *file, bool held_out,
                     const double **residuals)
{
    const size_t parameters = (size_t)to->open->parameter_count;
    for (size_t row = 0; row < set->rows; row++, to->row++) {
        const size_t count = solve_measured_residuals(to->open, set, row);
        const double *r = *residuals;
        to->s[to->row] = set->s[row];
        to->t[to->row] = set->t[row];
        to->file[to->row] = file;
        to->judged[to->row] = held_out ? "held_out" : "fitted";
        to->distance[to->row] = set->noise[0] * sqrt(square_of(count, r));
        for (size_t i = 0; i < parameters; i++) {
            to->known[i * to->rows + to->row] = set->known[row * parameters + i];
        }
        for (int c = 0; c < set->columns; c++) {
            const size_t at = 2 * (size_t)set->column[c] * to->rows + to->row;
            const double measured = set->values[(size_t)c * set->rows + row];
            const bool is_told = set->columns != 4 && !isnan(measured);
            to->columns[at] = measured;
            to->columns[at + to->rows] = is_told ? measured + *r++ * set->noise[c] : NAN;
            to->used[set->column[c]] = true;
        }
        *residuals += count;
    }
}

static ad_status write_rows(const row_table *from, const char *path, ad_error *error)
{
    const scene *open = from->open;
    const scene_physics *physics = scene_physics_of(open);
    char computed[MODEL_COLUMNS_MAX][40];
    table_build *to = malloc(sizeof *to);
    if (!to) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a table");
    }
    table_begin(to, from->rows);
    table_add(to, "file", NULL, NULL, from->file);
    table_add(to, "judged", NULL, NULL, from->judged);
    table_add(to, "s", NULL, from->s, NULL);
    if (scene_is_dynamic(open)) {
        table_add(to, "t", NULL, from->t, NULL);
    }
    for (int i = 0; i < scene_known_count(open); i++) {
        table_add(to, open->parameters[i].name, NULL, from->known + (size_t)i * from->rows, NULL);
    }
    for (int c = 0; c < physics->column_count; c++) {
        const double *values = from->columns + 2 * (size_t)c * from->rows;
        snprintf(computed[c], sizeof computed[c], "%s_computed", physics->columns[c].name);
        if (from->used[c]) {
            table_add(to, physics->columns[c].name, NULL, values, NULL);
            table_add(to, computed[c], NULL, values + from->rows, NULL);
        }
    }
    table_add(to, "distance", NULL, from->distance, NULL);
    const ad_status status = table_write(path, &to->table, error);
    free(to);
    return status;
}

ad_status measured_write(const scene *open, const measurements *data,
                         const train_settings *settings, const double *values, int threads,
                         const char *path, ad_error *error)
{
    const solve_measured *sets = measurements_sets(data);
    const int fitted = measurements_count(data), count = fitted + measurements_held_out(data);
    const size_t wide = 2 * (size_t)scene_physics_of(open)->column_count;
    size_t numbers = 0, rows = 0;
    double *residuals;
    ad_status status = solve_all(open, data, values, threads, &residuals, &numbers, &rows, error);
    const size_t size = (3 + (size_t)open->parameter_count + wide) * rows + 1;
    double *room = malloc(size * sizeof *room);
    const char **texts = malloc((2 * rows + 1) * sizeof *texts);
    if (status == AD_OK && (!room || !texts)) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", rows);
    }
    if (status == AD_OK) {
        for (size_t i = 0; i < size; i++) {
            room[i] = NAN;
        }
        row_table to = {.open = open,
                        .rows = rows,
                        .s = room,
                        .t = room + rows,
                        .distance = room + 2 * rows,
                        .known = room + 3 * rows,
                        .columns = room + (3 + (size_t)open->parameter_count) * rows,
                        .file = texts,
                        .judged = texts + rows};
        const double *at = residuals;
        for (int i = 0; i < count; i++) {
            const char *file = settings->data[measurements_entry(data, i)].file;
            take_set(&to, &sets[i], file_bytes_name(file), i >= fitted, &at);
        }
        status = write_rows(&to, path, error);
    }
    free(residuals);
    free(room);
    free(texts);
    return status;
}
