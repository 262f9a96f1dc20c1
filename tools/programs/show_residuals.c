/* cpinn-show: rows of cpinn-solve --residuals. */
#include "tools/files/file_bytes.h"
#include "tools/files/table_shapes.h"
#include "tools/programs/show_source.h"
#include "tools/train/judged.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PLACE = 3, ROWS_MAX = 20000, COMPONENTS_MAX = MODEL_COLUMNS_MAX };

/* Rows in turn of one entry of the scene's list `data`. */
typedef struct entry {
    size_t first, rows; /* of the table */
    size_t worst;       /* of the rows that count */
    int complete;       /* numbers of a row that has all */
    const char *unit;
    judged_set says;
} entry;

typedef struct shown {
    json *to;
    const table_source *table;
    const char *const *file, *const *judged;
    const double *data, *distance;
    int components;
    const char *name[COMPONENTS_MAX], *unit[COMPONENTS_MAX];
    const double *measured[COMPONENTS_MAX], *computed[COMPONENTS_MAX];
    int entries;
    entry entry[TRAIN_DATA_MAX];
    size_t count, *kept; /* rows on the page */
    double *few;         /* [rows] */
} shown;

static const char *const needed[] = {"data", "pose", "marker", "s", "distance", "deviation"};

bool show_is_residuals(const table_file *table)
{
    bool is = table_words(table, "file") && table_words(table, "judged");
    for (size_t k = 0; k < sizeof needed / sizeof *needed; k++) {
        is = is && table_column(table, needed[k]);
    }
    return is;
}

/* ---- columns ------------------------------------------------------------------------------- */

static const double *column_of(const shown *x, const char *name, const char *ending)
{
    char text[TABLE_MAX_NAME + 1];
    snprintf(text, sizeof text, "%.30s%.30s", name, ending);
    return table_source_column(x->table, text);
}

static void find_components(shown *x)
{
    for (size_t k = 0; k < x->table->ncols && x->components < COMPONENTS_MAX; k++) {
        const char *name = x->table->names[k];
        const double *computed = column_of(x, name, "_computed");
        if (computed) {
            x->name[x->components] = name;
            x->unit[x->components] = x->table->units[k];
            x->measured[x->components] = x->table->columns[k];
            x->computed[x->components++] = computed;
        }
    }
}

/* What a page has beside these columns: values of the scene's parameters. */
static bool is_known(const shown *x, const char *name)
{
    bool other = strcmp(name, "t") == 0 || strstr(name, "_in_scene") || strstr(name, "_computed");
    for (size_t k = 0; k < sizeof needed / sizeof *needed; k++) {
        other = other || strcmp(name, needed[k]) == 0;
    }
    for (int k = 0; k < x->components; k++) {
        other = other || strcmp(name, x->name[k]) == 0;
    }
    return !other;
}

/* ---- entries ------------------------------------------------------------------------------- */

static int count_numbers(const shown *x, size_t row)
{
    int count = 0;
    for (int k = 0; k < x->components; k++) {
        count += isfinite(x->measured[k][row]) != 0;
    }
    return count;
}

/* Of rotations the difference is an angle, and no components are computed. */
static const char *unit_of(const shown *x, size_t row)
{
    for (int k = 0; k < x->components; k++) {
        if (isfinite(x->measured[k][row])) {
            return x->name[k][0] == 'q' ? "rad" : x->unit[k];
        }
    }
    return "";
}

/* Whether a row is further off; nothing is further than where there is no solution. */
static bool is_worse(const shown *x, size_t row, size_t than)
{
    return !isnan(x->distance[than]) && !(x->distance[row] <= x->distance[than]);
}

/* How far rows are off in which nothing is missing that others have. */
static void judge_entry(shown *x, entry *of)
{
    size_t rows = 0;
    of->unit = unit_of(x, of->first);
    of->worst = of->first;
    for (size_t row = of->first; row < of->first + of->rows; row++) {
        const int numbers = count_numbers(x, row);
        of->complete = numbers > of->complete ? numbers : of->complete;
    }
    for (size_t row = of->first; row < of->first + of->rows; row++) {
        if (count_numbers(x, row) == of->complete) {
            of->worst = rows == 0 || is_worse(x, row, of->worst) ? row : of->worst;
            x->few[rows++] = x->distance[row];
        }
    }
    measured_distances(rows, x->few, &of->says);
}

static void find_entries(shown *x)
{
    for (size_t row = 0; row < x->table->nrows; row++) {
        if ((row == 0 || x->data[row] != x->data[row - 1]) && x->entries < TRAIN_DATA_MAX) {
            x->entry[x->entries++] = (entry){.first = row};
        }
        x->entry[x->entries - 1].rows++;
    }
    for (int i = 0; i < x->entries; i++) {
        judge_entry(x, &x->entry[i]);
    }
}

/* Evenly, and the worst of each entry. */
static void keep_rows(shown *x)
{
    const size_t rows = x->table->nrows, every = (rows + ROWS_MAX - 1) / ROWS_MAX;
    int at = 0;
    for (size_t row = 0; row < rows; row++) {
        at += at + 1 < x->entries && row == x->entry[at + 1].first;
        if (row % every == 0 || row == x->entry[at].worst) {
            x->kept[x->count++] = row;
        }
    }
}

/* ---- the data of the page ------------------------------------------------------------------ */

/* Numbers of the rows that are kept; less: NULL, or what is taken off. */
static void put_kept(const shown *x, const char *name, const char *unit, const double *values,
                     const double *less)
{
    for (size_t i = 0; i < x->count; i++) {
        x->few[i] = values[x->kept[i]] - (less ? less[x->kept[i]] : 0);
    }
    show_column(x->to, name, unit, x->few, x->count, false);
}

static size_t kept_before(const shown *x, size_t row)
{
    size_t count = 0;
    while (count < x->count && x->kept[count] < row) {
        count++;
    }
    return count;
}

static void put_entries(const shown *x)
{
    json_open(x->to, "entries", '[');
    for (int i = 0; i < x->entries; i++) {
        const entry *of = &x->entry[i];
        json_open(x->to, NULL, '{');
        json_text(x->to, "file", x->file[of->first]);
        json_text(x->to, "judged", x->judged[of->first]);
        json_integer(x->to, "data", (int64_t)x->data[of->first]);
        json_text(x->to, "unit", of->unit);
        json_integer(x->to, "first", (int64_t)kept_before(x, of->first));
        json_integer(x->to, "end", (int64_t)kept_before(x, of->first + of->rows));
        json_integer(x->to, "worst_row", (int64_t)kept_before(x, of->worst));
        json_integer(x->to, "rows", (int64_t)of->says.rows);
        json_integer(x->to, "missing", (int64_t)(of->rows - of->says.rows));
        json_number(x->to, "rms", of->says.rms);
        json_number(x->to, "mean", of->says.mean);
        json_number(x->to, "median", of->says.median);
        json_number(x->to, "worst", of->says.worst);
        json_number(x->to, "deviation", table_source_column(x->table, "deviation")[of->first]);
        json_close(x->to, '}');
    }
    json_close(x->to, ']');
}

static void put_list(const shown *x, const char *name, const char *const *columns, size_t count)
{
    json_open(x->to, name, '[');
    for (size_t k = 0; k < count; k++) {
        const double *values = table_source_column(x->table, columns[k]);
        if (values) {
            put_kept(x, columns[k], "", values, NULL);
        }
    }
    json_close(x->to, ']');
}

/* What was measured and what is computed, in the axes of the scene. */
static void put_places(const shown *x)
{
    const double *places[2 * PLACE];
    for (int k = 0; k < 2 * PLACE; k++) {
        static const char *const axes[] = {"x", "y", "z"};
        const char *ending = k < PLACE ? "" : "_computed";
        char seen[40];
        snprintf(seen, sizeof seen, "%s_in_scene", ending);
        places[k] = column_of(x, axes[k % PLACE], seen);
        places[k] = places[k] ? places[k] : column_of(x, axes[k % PLACE], ending);
        if (!places[k]) {
            return;
        }
    }
    json_open(x->to, "places", '[');
    for (int k = 0; k < 2 * PLACE; k++) {
        put_kept(x, "", "m", places[k], NULL);
    }
    json_close(x->to, ']');
}

static void put_rows(const shown *x, const table_shapes *shapes)
{
    static const char *const numbers[] = {"pose", "marker", "s", "t", "distance"};
    json *to = x->to;
    json_open(to, "residuals", '{');
    json_integer(to, "rows", (int64_t)x->count);
    json_integer(to, "rows_of", (int64_t)x->table->nrows);
    put_entries(x);
    put_list(x, "columns", numbers, sizeof numbers / sizeof *numbers);
    json_open(to, "components", '[');
    for (int k = 0; k < x->components; k++) {
        if (x->name[k][0] != 'q') {
            put_kept(x, x->name[k], x->unit[k], x->measured[k], x->computed[k]);
        }
    }
    json_close(to, ']');
    json_open(to, "known", '[');
    for (size_t k = 0; k < x->table->ncols; k++) {
        if (is_known(x, x->table->names[k])) {
            put_kept(x, x->table->names[k], "", x->table->columns[k], NULL);
        }
    }
    json_close(to, ']');
    put_places(x);
    if (shapes && shapes->member) {
        json_open(to, "poses", '[');
        for (size_t i = 0; i < shapes->frames; i++) {
            json_integer(to, NULL, (int64_t)shapes->member[i * shapes->points]);
        }
        json_close(to, ']');
    }
    json_close(to, '}');
}

/* ---- all ----------------------------------------------------------------------------------- */

static ad_status put_all(showing *showing, const shown *x, ad_error *error)
{
    char path[TABLE_PATH_MAX];
    table_shapes shapes;
    table_shapes_beside(showing->source, path);
    if (access(path, F_OK) != 0) {
        put_rows(x, NULL);
        return AD_OK;
    }
    ad_error reason;
    ad_status status = table_read(path, TABLE_NONFINITE, &showing->ghost, error);
    table_build *read =
        status == AD_OK ? show_read_table_of(showing->ghost,
                                             showing->settings ? &showing->settings->scene : NULL)
                        : NULL;
    if (status == AD_OK && !read) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    if (status == AD_OK && table_shapes_of(&read->table, &shapes, &reason) != AD_OK) {
        status = ad_fail(error, AD_BAD_INPUT, "%s: %s", file_bytes_shown(path), reason.message);
    }
    if (status == AD_OK) {
        put_rows(x, &shapes);
        status = show_poses(x->to, &read->table, error);
    }
    free(read);
    return status;
}

ad_status show_residuals(showing *showing, const table_source *table, ad_error *error)
{
    shown x = {.to = &showing->to,
               .table = table,
               .file = table_words(showing->table, "file"),
               .judged = table_words(showing->table, "judged"),
               .data = table_source_column(table, "data"),
               .distance = table_source_column(table, "distance")};
    if (table->nrows == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows to be shown", showing->source);
    }
    x.kept = malloc(table->nrows * sizeof *x.kept);
    x.few = malloc(table->nrows * sizeof *x.few);
    ad_status status =
        x.kept && x.few ? AD_OK
                        : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu rows", table->nrows);
    if (status == AD_OK) {
        find_components(&x);
        find_entries(&x);
        keep_rows(&x);
        status = put_all(showing, &x, error);
    }
    if (status == AD_OK && showing->settings) {
        show_settings(&showing->to, showing->settings);
    }
    free(x.kept);
    free(x.few);
    return status;
}
