#include "tools/train/measurements.h"

#include "tools/files/table_file.h"
#include "tools/train/reference.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct measurements {
    int count;
    solve_measured set[TRAIN_DATA_MAX];
    double *numbers[TRAIN_DATA_MAX]; /* all of a set */
};

/* A file being read. */
typedef struct reading {
    const scene *open;
    const char *path;
    const table_file *table;
    int columns; /* that the model has in this scene */
} reading;

int measurements_count(const measurements *x)
{
    return x->count;
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

train_noise measurements_kind(const scene *open, int column)
{
    static const char *const units[TRAIN_NOISE_COUNT] = {"m", NULL,  "",    "1/m",
                                                         "N", "N m", "m/s", "1/s"};
    const scene_physics *physics = scene_physics_of(open);
    int kind = TRAIN_NOISE_POSITION;
    if ((column >= physics->position_columns &&
         column < physics->position_columns + physics->rotation_columns) ||
        strcmp(physics->columns[column].unit, "rad") == 0) {
        return TRAIN_NOISE_ROTATION;
    }
    while (kind + 1 < TRAIN_NOISE_COUNT &&
           (!units[kind] || strcmp(units[kind], physics->columns[column].unit) != 0)) {
        kind++;
    }
    return (train_noise)kind;
}

/* ---- columns ------------------------------------------------------------------------------- */

static ad_status missing(const reading *r, const char *name, const char *what, ad_error *error)
{
    return ad_fail(error, AD_BAD_INPUT, "%s: column '%s' is missing; %s", r->path, name, what);
}

static int model_column_of(const reading *r, const char *name)
{
    const model_column *columns = scene_physics_of(r->open)->columns;
    int i = r->columns - 1;
    while (i >= 0 && strcmp(columns[i].name, name) != 0) {
        i--;
    }
    return i;
}

static int parameter_of(const scene *open, const char *name)
{
    int i = open->parameter_count - 1;
    while (i >= 0 && strcmp(open->parameters[i].name, name) != 0) {
        i--;
    }
    return i;
}

/* Every column has a meaning. */
static ad_status check_names(const reading *r, ad_error *error)
{
    char allowed[360] = "s, t";
    size_t used = strlen(allowed);
    for (int i = 0; i < r->columns && used < sizeof allowed; i++) {
        used += (size_t)snprintf(allowed + used, sizeof allowed - used, ", %s",
                                 scene_physics_of(r->open)->columns[i].name);
    }
    for (size_t i = 0; i < table_columns(r->table); i++) {
        const char *name = table_name(r->table, i);
        const int parameter = parameter_of(r->open, name);
        if (parameter >= 0 && r->open->is_unknown[parameter]) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: column '%s' is a parameter that is to be found; leave it out, or "
                           "take `identify` away in the scene",
                           r->path, name);
        }
        if (parameter < 0 && model_column_of(r, name) < 0 && strcmp(name, "s") != 0 &&
            strcmp(name, "t") != 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s: column '%s' is not one of this scene; allowed: %s, and its "
                           "parameters",
                           r->path, name, allowed);
        }
    }
    return AD_OK;
}

static ad_status find_measured(const reading *r, const train_data *file, solve_measured *set,
                               ad_error *error)
{
    const scene_physics *physics = scene_physics_of(r->open);
    const int first = physics->position_columns, after = first + physics->rotation_columns;
    int rotations = 0;
    const char *absent = NULL;
    for (int c = 0; c < r->columns; c++) {
        const char *name = physics->columns[c].name;
        const bool has = table_column(r->table, name) != NULL;
        if (has) {
            set->noise[set->columns] = file->noise[measurements_kind(r->open, c)];
            set->column[set->columns++] = c;
        }
        if (c >= first && c < after) {
            rotations += has;
            absent = has ? absent : name;
        }
    }
    if (rotations > 0 && absent) {
        return missing(r, absent, "of a rotation all four are needed", error);
    }
    return set->columns > 0
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "%s: nothing is measured; columns beside s, t and parameters are those "
                         "that cpinn-eval writes, as x, y, z",
                         r->path);
}

static ad_status check_columns(const reading *r, ad_error *error)
{
    const scene *open = r->open;
    ad_status status = check_names(r, error);
    if (status == AD_OK && table_rows(r->table) == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed",
                       r->path);
    }
    if (status == AD_OK && !table_column(r->table, "s")) {
        return missing(r, "s", "the place along the rod in m", error);
    }
    if (status == AD_OK && scene_is_dynamic(open) && !table_column(r->table, "t")) {
        return missing(r, "t", "the time in s", error);
    }
    for (int i = 0; status == AD_OK && i < open->parameter_count; i++) {
        if (!open->is_unknown[i] && !table_column(r->table, open->parameters[i].name)) {
            return missing(r, open->parameters[i].name,
                           "a parameter with a range that is not to be found has a value in each "
                           "row",
                           error);
        }
    }
    return status;
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
            const double *column = open->is_unknown[k] ? NULL : table_column(r->table, p->name);
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

static ad_status read_file(const scene *open, const train_data *file, measurements *x,
                           ad_error *error)
{
    table_file *table = NULL;
    solve_measured *set = &x->set[x->count];
    reading r = {.open = open, .path = file->file};
    while (r.columns < scene_physics_of(open)->column_count &&
           (scene_is_dynamic(open) || !scene_physics_of(open)->columns[r.columns].of_motion)) {
        r.columns++;
    }
    ad_status status = table_read(file->file, TABLE_FINITE, &table, error);
    r.table = table;
    status = status == AD_OK ? check_columns(&r, error) : status;
    status = status == AD_OK ? find_measured(&r, file, set, error) : status;
    if (status == AD_OK) {
        set->rows = table_rows(table);
        double *numbers = malloc(set->rows * (size_t)(2 + open->parameter_count + set->columns) *
                                 sizeof *numbers);
        x->numbers[x->count++] = numbers;
        status = numbers ? take_rows(&r, set, numbers, error)
                         : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu measured rows",
                                   set->rows);
    }
    table_free(table);
    return status;
}

ad_status measurements_read(const scene *open, int count, const train_data *files,
                            measurements **result, ad_error *error)
{
    measurements *x = calloc(1, sizeof *x);
    ad_status status = x ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for measurements");
    *result = NULL;
    for (int i = 0; i < count && status == AD_OK; i++) {
        status = read_file(open, &files[i], x, error);
    }
    if (status != AD_OK) {
        measurements_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}
