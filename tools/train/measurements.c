#include "tools/train/measurements.h"

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
    bool tells_noise;
};

/* A file being read. */
typedef struct reading {
    const scene *open;
    const char *path;
    const table_file *table;
} reading;

int measurements_count(const measurements *x)
{
    return x->count;
}

bool measurements_tell_noise(const measurements *x)
{
    return x->tells_noise;
}

const solve_measured *measurements_sets(const measurements *x)
{
    return x->set;
}

void measurements_free(measurements *x)
{
    for (int i = 0; x && i < x->count; i++) {
        free(x->numbers[i]);
    }
    free(x);
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

bool measurements_columns(const scene *rod_scene, train_quantity quantity, int *first, int *count)
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

static ad_status missing(const reading *r, const char *name, const char *what, ad_error *error)
{
    return ad_fail(error, AD_BAD_INPUT, "%s: column '%s' is missing; %s", r->path, name, what);
}

static ad_status check_columns(const reading *r, const solve_measured *set, ad_error *error)
{
    const scene *open = r->open;
    if (table_rows(r->table) == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed",
                       r->path);
    }
    if (!table_column(r->table, "s")) {
        return missing(r, "s", "the place along the rod in m", error);
    }
    if (scene_is_dynamic(open) && !table_column(r->table, "t")) {
        return missing(r, "t", "the time in s", error);
    }
    for (int i = 0; i < scene_known_count(open); i++) {
        if (!table_column(r->table, open->parameters[i].name)) {
            return missing(r, open->parameters[i].name,
                           "a parameter with a range that is not to be found has a value in each "
                           "row",
                           error);
        }
    }
    for (int i = scene_known_count(open); i < open->parameter_count; i++) {
        if (table_column(r->table, open->parameters[i].name)) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: column '%s' is a parameter that is to be found; leave it out, or "
                           "take `identify` away in the scene",
                           r->path, open->parameters[i].name);
        }
    }
    for (int c = 0; c < set->columns; c++) {
        const char *name = scene_physics_of(open)->columns[set->column[c]].name;
        if (!table_column(r->table, name)) {
            return missing(r, name, "of a quantity all columns are needed", error);
        }
    }
    return AD_OK;
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

/* Rows of s, t, known values; then the measured columns. */
static ad_status take_rows(const reading *r, solve_measured *set, double *numbers, ad_error *error)
{
    const scene *open = r->open;
    const size_t rows = set->rows, parameters = (size_t)open->parameter_count;
    const double length = scene_length(open), duration = scene_duration(open);
    const double *from = table_column(r->table, "s"), *at = table_column(r->table, "t");
    double *s = numbers, *t = s + rows, *known = t + rows, *values = known + rows * parameters;
    ad_status status = AD_OK;
    for (size_t i = 0; i < rows && status == AD_OK; i++) {
        s[i] = fmin(length, fmax(0, from[i]));
        t[i] = scene_is_dynamic(open) ? fmin(duration, fmax(0, at[i])) : 0;
        status = check_number(r, i, "s", from[i], 0, length, error);
        if (status == AD_OK && scene_is_dynamic(open)) {
            status = check_number(r, i, "t", at[i], 0, duration, error);
        }
        for (size_t k = 0; k < parameters && status == AD_OK; k++) {
            const scene_parameter *p = &open->parameters[k];
            const double *column =
                k < (size_t)scene_known_count(open) ? table_column(r->table, p->name) : NULL;
            known[i * parameters + k] = column ? column[i] : 0;
            status =
                column ? check_number(r, i, p->name, column[i], p->low, p->high, error) : AD_OK;
        }
    }
    for (int c = 0; c < set->columns; c++) {
        memcpy(values + (size_t)c * rows,
               table_column(r->table, scene_physics_of(open)->columns[set->column[c]].name),
               rows * sizeof *values);
    }
    set->s = s;
    set->t = t;
    set->known = known;
    set->values = values;
    return status;
}

/* A quaternion is unit to a few digits, as it was written. */
static ad_status check_rotations(const reading *r, const solve_measured *set, ad_error *error)
{
    for (size_t i = 0; i < set->rows; i++) {
        double square = 0;
        for (int c = 0; c < set->columns; c++) {
            square += pow(set->values[(size_t)c * set->rows + i], 2);
        }
        ad_status status =
            check_number(r, i, "the length of qw to qz", sqrt(square), 0.999, 1.001, error);
        if (status != AD_OK) {
            return status;
        }
    }
    return AD_OK;
}

static ad_status read_file(const scene *open, const train_data *file, int index, measurements *x,
                           char *key, ad_error *error)
{
    int first;
    table_file *table = NULL;
    solve_measured *set = &x->set[x->count];
    if (!measurements_columns(open, file->quantity, &first, &set->columns)) {
        snprintf(key, TRAIN_KEY_MAX, "data[%d].quantity", index);
        return ad_fail(error, AD_BAD_INPUT, "this scene has no %s",
                       train_quantity_names()[file->quantity]);
    }
    snprintf(key, TRAIN_KEY_MAX, "data[%d].file", index);
    for (int c = 0; c < set->columns; c++) {
        set->column[c] = first + c;
        set->noise[c] = file->noise > 0 ? file->noise : 1;
    }
    ad_status status = table_read(file->file, TABLE_FINITE, &table, error);
    const reading r = {open, file->file, table};
    status = status == AD_OK ? check_columns(&r, set, error) : status;
    if (status == AD_OK) {
        set->rows = table_rows(table);
        double *numbers = malloc(set->rows * (size_t)(2 + open->parameter_count + set->columns) *
                                 sizeof *numbers);
        x->numbers[x->count++] = numbers;
        status = numbers ? take_rows(&r, set, numbers, error)
                         : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu measured rows",
                                   set->rows);
    }
    if (status == AD_OK && set->columns == 4) {
        status = check_rotations(&r, set, error);
    }
    table_free(table);
    return status;
}

/* Unknowns are found from all files at once. One noise that is not known can be found, several
 * cannot; how much a number counts is its noise. */
static ad_status check_unknowns(const scene *open, const measurements *x, const train_data *files,
                                char *key, ad_error *error)
{
    size_t numbers = 0;
    for (int i = 0; i < x->count; i++) {
        const solve_measured *set = &x->set[i];
        const bool quaternion =
            files[i].quantity == TRAIN_ROTATION && set->columns == 4; /* three numbers */
        numbers += set->rows * (size_t)(set->columns - quaternion);
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
    return identify_check(open->unknown_count, numbers, !x->tells_noise, error);
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
