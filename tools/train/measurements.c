#include "tools/train/measurements.h"

#include "physics/check/plausible.h"
#include "tools/files/table_file.h"
#include "tools/train/identify.h"
#include "tools/train/reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct measurements {
    int count;
    solve_measured set[TRAIN_DATA_MAX];
    double *numbers[TRAIN_DATA_MAX]; /* all of a set */
    size_t missing;
    bool tells_noise;
};

/* A file being read. */
typedef struct reading {
    const scene *open;
    const char *path;
    const table_file *table;
    const double *values[MODEL_COLUMNS_MAX]; /* of the quantity */
} reading;

int measurements_count(const measurements *measurements)
{
    return measurements->count;
}

size_t measurements_missing(const measurements *measurements)
{
    return measurements->missing;
}

bool measurements_tell_noise(const measurements *measurements)
{
    return measurements->tells_noise;
}

const solve_measured *measurements_sets(const measurements *measurements)
{
    return measurements->set;
}

void measurements_free(measurements *measurements)
{
    for (int i = 0; measurements && i < measurements->count; i++) {
        free(measurements->numbers[i]);
    }
    free(measurements);
}

/* ---- columns ------------------------------------------------------------------------------- */

/* The columns of each quantity: of rods the first, of beams the second name on. */
static const struct {
    const char *rod, *beam;
    int rod_columns;
} columns_of[TRAIN_QUANTITY_COUNT] = {
    [TRAIN_POSITION] = {"x", "w", 3},    [TRAIN_ROTATION] = {"qw", "slope", 4},
    [TRAIN_STRAIN] = {"v1", NULL, 3},    [TRAIN_CURVATURE] = {"u1", NULL, 3},
    [TRAIN_FORCE] = {"n1", "V", 3},      [TRAIN_MOMENT] = {"m1", "M", 3},
    [TRAIN_VELOCITY] = {"vx", "w_t", 3}, [TRAIN_ANGULAR_VELOCITY] = {"w1", "slope_t", 3}};

/* The columns of a quantity among those of the scene's model; false: this scene has none. */
static bool columns(const scene *rod_scene, train_quantity quantity, int *first, int *count)
{
    const scene_physics *physics = scene_physics_of(rod_scene);
    const bool beam = scene_is_beam(rod_scene);
    const char *name = beam ? columns_of[quantity].beam : columns_of[quantity].rod;
    *count = beam ? 1 : columns_of[quantity].rod_columns;
    for (int i = 0; name && i < physics->column_count; i++) {
        if (strcmp(physics->columns[i].name, name) == 0 &&
            (scene_is_dynamic(rod_scene) || !physics->columns[i].of_motion)) {
            *first = i;
            return true;
        }
    }
    return false;
}

/* Refuses a table without a column, or with one that has what is no number. */
static ad_status need(const reading *r, const char *name, table_numbers numbers, const char *what,
                      ad_error *error)
{
    const double *column;
    ad_status status = table_find(r->table, name, numbers, &column, error);
    return status != AD_OK || column
               ? status
               : ad_fail(error, AD_BAD_INPUT, "%s: column '%s' is missing; %s", r->path, name,
                         what);
}

static ad_status check_columns(reading *r, const solve_measured *set, ad_error *error)
{
    const scene *open = r->open;
    if (table_rows(r->table) == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed",
                       r->path);
    }
    ad_status status = need(r, "s", TABLE_FINITE, "the place along the rod in m", error);
    if (status == AD_OK && scene_is_dynamic(open)) {
        status = need(r, "t", TABLE_FINITE, "the time in s", error);
    }
    for (int i = 0; i < scene_known_count(open) && status == AD_OK; i++) {
        status =
            need(r, open->parameters[i].name, TABLE_FINITE,
                 "a parameter with a range that is not to be found has a value in each row", error);
    }
    for (int c = 0; c < set->columns && status == AD_OK; c++) {
        const char *name = scene_physics_of(open)->columns[set->column[c]].name;
        status = need(r, name, TABLE_MEASURED, "of a quantity all columns are needed", error);
        r->values[c] = table_column(r->table, name);
    }
    if (status != AD_OK) {
        return status;
    }
    for (int i = scene_known_count(open); i < open->parameter_count; i++) {
        if (table_column(r->table, open->parameters[i].name)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: column '%s' is a parameter that is to be found; leave it out, or "
                           "take `identify` away in the scene",
                           r->path, open->parameters[i].name);
        }
    }
    return AD_OK;
}

/* Positions in mm, of which chi squared would say nothing. */
static ad_status check_positions(const reading *r, ad_error *error)
{
    char text[SCENE_WARNING_TEXT];
    bool implausible;
    if (scene_positions_implausible(r->open, table_rows(r->table), r->values, &implausible, text) !=
        AD_OK) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu measured rows",
                       table_rows(r->table));
    }
    return implausible ? ad_fail(error, AD_BAD_INPUT, "%s: %s", r->path, text) : AD_OK;
}

/* ---- rows ---------------------------------------------------------------------------------- */

static ad_status check_number(const reading *r, size_t row, const char *name, double value,
                              double low, double high, ad_error *error)
{
    const size_t line = table_line(r->table, row);
    const double slack = REFERENCE_END_TOLERANCE * (high - low); /* files hold rounded numbers */
    char place[32];
    if (value >= low - slack && value <= high + slack) {
        return AD_OK;
    }
    snprintf(place, sizeof place, line ? "%zu" : "row %zu", line ? line : row + 1);
    return ad_fail(error, AD_BAD_INPUT, "%s:%s: %s is %g; allowed: %g to %g", r->path, place, name,
                   value, low, high);
}

/* A quaternion is unit to a few digits, as it was written. */
static ad_status check_rotation(const reading *r, size_t row, ad_error *error)
{
    double square = 0;
    for (int c = 0; c < 4; c++) {
        square += pow(r->values[c][row], 2);
    }
    return check_number(r, row, "the length of qw to qz", sqrt(square), 0.999, 1.001, error);
}

/* Of a row, numbers of the quantity that count: of a quaternion all four do, or none. */
static int count_numbers(const reading *r, const solve_measured *set, size_t row)
{
    int count = 0;
    for (int c = 0; c < set->columns; c++) {
        count += isfinite(r->values[c][row]) != 0;
    }
    return set->columns == 4 && count < 4 ? 0 : count;
}

/* s, t and known values of a row, which has to be within the scene whether it counts or not. */
static ad_status take_row(const reading *r, size_t row, double *s, double *t, double *known,
                          ad_error *error)
{
    const scene *open = r->open;
    const double length = scene_length(open), duration = scene_duration(open);
    const double from = table_column(r->table, "s")[row];
    ad_status status = check_number(r, row, "s", from, 0, length, error);
    *s = fmin(length, fmax(0, from));
    *t = 0;
    if (status == AD_OK && scene_is_dynamic(open)) {
        const double at = table_column(r->table, "t")[row];
        *t = fmin(duration, fmax(0, at));
        status = check_number(r, row, "t", at, 0, duration, error);
    }
    for (int k = 0; k < open->parameter_count && status == AD_OK; k++) {
        const scene_parameter *p = &open->parameters[k];
        known[k] = k < scene_known_count(open) ? table_column(r->table, p->name)[row] : 0;
        status = k < scene_known_count(open)
                     ? check_number(r, row, p->name, known[k], p->low, p->high, error)
                     : AD_OK;
    }
    return status;
}

/* numbers: s, t, known values of the rows that have a number, then their measured columns. */
static ad_status take_rows(const reading *r, solve_measured *set, double *numbers, size_t *missing,
                           ad_error *error)
{
    const size_t rows = table_rows(r->table), parameters = (size_t)r->open->parameter_count;
    double *s = numbers, *t = s + rows, *known = t + rows, *values = known + rows * parameters;
    ad_status status = AD_OK;
    for (size_t i = 0; i < rows && status == AD_OK; i++) {
        const size_t to = set->rows;
        const int count = count_numbers(r, set, i);
        status = take_row(r, i, s + to, t + to, known + to * parameters, error);
        if (status == AD_OK && count > 0 && set->columns == 4) {
            status = check_rotation(r, i, error);
        }
        for (int c = 0; c < set->columns; c++) {
            values[(size_t)c * rows + to] = r->values[c][i];
        }
        *missing += (size_t)(set->columns - count);
        set->rows += count > 0;
    }
    for (int c = 1; c < set->columns; c++) { /* columns follow one another */
        memmove(values + (size_t)c * set->rows, values + (size_t)c * rows,
                set->rows * sizeof *values);
    }
    set->s = s;
    set->t = t;
    set->known = known;
    set->values = values;
    return status != AD_OK || set->rows > 0
               ? status
               : ad_fail(error, AD_BAD_INPUT,
                         "%s: in every row a number is missing; at least one row is needed",
                         r->path);
}

static ad_status read_file(const scene *open, const train_data *file, int index,
                           measurements *measurements, char *key, ad_error *error)
{
    int first;
    table_file *table = NULL;
    solve_measured *set = &measurements->set[measurements->count];
    if (!columns(open, file->quantity, &first, &set->columns)) {
        snprintf(key, TRAIN_KEY_MAX, "data[%d].quantity", index);
        return ad_fail(error, AD_BAD_INPUT, "this scene has no %s",
                       train_quantity_names()[file->quantity]);
    }
    snprintf(key, TRAIN_KEY_MAX, "data[%d].file", index);
    for (int c = 0; c < set->columns; c++) {
        set->column[c] = first + c;
        set->noise[c] = file->noise > 0 ? file->noise : 1;
    }
    ad_status status = table_read(file->file, TABLE_MEASURED, &table, error);
    reading r = {.open = open, .path = file->file, .table = table};
    status = status == AD_OK ? check_columns(&r, set, error) : status;
    if (status == AD_OK) {
        const size_t rows = table_rows(table);
        double *numbers =
            malloc(rows * (size_t)(2 + open->parameter_count + set->columns) * sizeof *numbers);
        measurements->numbers[measurements->count++] = numbers;
        status = numbers
                     ? take_rows(&r, set, numbers, &measurements->missing, error)
                     : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu measured rows", rows);
    }
    if (status == AD_OK && file->quantity == TRAIN_POSITION) {
        status = check_positions(&r, error);
    }
    table_free(table);
    return status;
}

/* Unknowns are found from all files at once. One noise that is not known can be found, several
 * cannot; how much a number counts is its noise. */
static ad_status check_unknowns(const scene *open, const measurements *measurements,
                                const train_data *files, char *key, ad_error *error)
{
    size_t numbers = 0;
    for (int i = 0; i < measurements->count; i++) {
        const solve_measured *set = &measurements->set[i];
        const bool quaternion =
            files[i].quantity == TRAIN_ROTATION && set->columns == 4; /* three numbers */
        numbers += set->rows * (size_t)(set->columns - quaternion) - solve_measured_missing(set);
        if ((files[i].noise > 0) != (files[0].noise > 0) ||
            (!(files[i].noise > 0) && files[i].quantity != files[0].quantity)) {
            snprintf(key, TRAIN_KEY_MAX, "data[%d].noise", files[i].noise > 0 ? 0 : i);
            return ad_fail(error, AD_BAD_INPUT,
                           "is needed to find unknowns; it may be left out where nothing but one "
                           "quantity is measured, and then of all entries");
        }
        if (!(files[i].weight > 0) || files[i].weight != files[0].weight) {
            snprintf(key, TRAIN_KEY_MAX, "data[%d].weight", i);
            return ad_fail(error, AD_BAD_INPUT,
                           "is %g, of the first entry %g; allowed where there are unknowns: one "
                           "weight for all, above 0, since how much numbers count is their noise",
                           files[i].weight, files[0].weight);
        }
    }
    snprintf(key, TRAIN_KEY_MAX, "data");
    return identify_check(open->unknown_count, numbers, !measurements->tells_noise, error);
}

ad_status measurements_read(const scene *open, const train_settings *settings,
                            measurements **result, char key[TRAIN_KEY_MAX], ad_error *error)
{
    measurements *x = calloc(1, sizeof *x);
    ad_status status = x ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for measurements");
    *result = NULL;
    for (int i = 0; i < settings->data_count && status == AD_OK; i++) {
        x->tells_noise = settings->data[0].noise > 0;
        status = read_file(open, &settings->data[i], i, x, key, error);
    }
    if (status == AD_OK && open->unknown_count > 0) {
        status = check_unknowns(open, x, settings->data, key, error);
    }
    if (status != AD_OK) {
        measurements_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}
