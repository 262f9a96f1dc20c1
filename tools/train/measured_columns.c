#include "tools/train/measured_columns.h"

#include "physics/quantity/quantity_within.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NAME = 64, FORMULA = 1024, OWNED_MAX = 256 };

/* A column of the file that formulas use. */
typedef struct used_column {
    char name[NAME];
    const double *values; /* NULL: an index */
    int index;            /* 1, 2 */
} used_column;

struct measured_columns {
    const table_file *table;
    const char *lines;
    quantities *names;
    int used_count;
    used_column used[QUANTITY_OPEN_MAX];
    int owned_count;
    double *owned[OWNED_MAX];
    char stray[NAME];
};

ad_status measured_columns_create(const table_file *table, const quantities *outer,
                                  const char *lines, measured_columns **result, ad_error *error)
{
    measured_columns *x = calloc(1, sizeof *x);
    *result = x;
    if (x) {
        x->table = table;
        x->lines = lines ? lines : "";
        x->names = quantities_create_within(outer);
    }
    if (!x || !x->names) {
        measured_columns_free(x);
        *result = NULL;
        return ad_fail(error, AD_NO_MEMORY, "out of memory for columns");
    }
    return AD_OK;
}

void measured_columns_free(measured_columns *x)
{
    for (int i = 0; x && i < x->owned_count; i++) {
        free(x->owned[i]);
    }
    if (x) {
        quantities_free(x->names);
    }
    free(x);
}

/* ---- lines --------------------------------------------------------------------------------- */

static const char *next_line(const char *line)
{
    const char *end = strchr(line, '\n');
    return end ? end + 1 : line + strlen(line);
}

/* The line of a name; NULL: there is none. */
static const char *line_of(const measured_columns *x, const char *name)
{
    const size_t length = strlen(name);
    const char *line = x->lines;
    while (*line && !(strncmp(line, name, length) == 0 && line[length] == '=')) {
        line = next_line(line);
    }
    return *line ? line : NULL;
}

bool measured_columns_say(const measured_columns *x, const char *name)
{
    return line_of(x, name) != NULL;
}

const char *measured_columns_stray(measured_columns *x, int count, const char *const *known)
{
    for (const char *line = x->lines; *line; line = next_line(line)) {
        bool found = false;
        snprintf(x->stray, sizeof x->stray, "%.*s", (int)strcspn(line, "="), line);
        for (int i = 0; i < count && !found; i++) {
            found = strcmp(known[i], x->stray) == 0;
        }
        if (!found) {
            return x->stray;
        }
    }
    return NULL;
}

/* ---- columns of the file ------------------------------------------------------------------- */

/* By name, or c1, c2, ... by number. *values NULL: there is none. */
static ad_status find_in_file(const measured_columns *x, const char *name, const double **values,
                              ad_error *error)
{
    char *end = NULL;
    ad_status status = table_find(x->table, name, TABLE_MEASURED, values, error);
    if (status != AD_OK || *values || name[0] != 'c' || name[1] < '1' || name[1] > '9') {
        return status;
    }
    const unsigned long number = strtoul(name + 1, &end, 10);
    return *end || number > table_columns(x->table)
               ? AD_OK
               : table_find(x->table, table_name(x->table, number - 1), TABLE_MEASURED, values,
                            error);
}

bool measured_columns_have(const measured_columns *x, const char *name)
{
    for (size_t k = 0; k < table_columns(x->table); k++) {
        if (strcmp(table_name(x->table, k), name) == 0) {
            return true;
        }
    }
    return measured_columns_say(x, name);
}

static bool is_used(const measured_columns *x, const char *name)
{
    for (int i = 0; i < x->used_count; i++) {
        if (strcmp(x->used[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

/* Make a name that a formula has one that is open, if it is a column of the file. */
static ad_status use(measured_columns *x, const char *name, ad_error *error)
{
    used_column column = {.index = strcmp(name, "i1") == 0 ? 1 : strcmp(name, "i2") == 0 ? 2 : 0};
    ad_status status = is_used(x, name) ? AD_OK : find_in_file(x, name, &column.values, error);
    if (status != AD_OK || is_used(x, name) || (!column.values && column.index == 0)) {
        return status;
    }
    snprintf(column.name, sizeof column.name, "%s", name);
    status = quantities_coordinate(x->names, name, error);
    if (status == AD_OK) {
        x->used[x->used_count++] = column;
    }
    return status;
}

/* Names of the file's columns, as many as there is room for. */
static void list_names(const measured_columns *x, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (size_t k = 0; k < table_columns(x->table) && used + 40 < size; k++) {
        used += (size_t)snprintf(text + used, size - used, "%s%.*s", k ? ", " : "",
                                 (int)(size - used - 20), table_name(x->table, k));
    }
}

/* A name that is no column has to be one of the scene. */
static ad_status check_known(const measured_columns *x, const char *name, ad_error *error)
{
    char names[200];
    ad_error reason;
    if (is_used(x, name) || quantity_check(quantity_formula(x->names, name), &reason) == AD_OK) {
        return AD_OK;
    }
    list_names(x, names, sizeof names);
    return ad_fail(error, AD_BAD_INPUT,
                   "'%.60s' is no column of the file, nor a number of the scene; columns are i1, "
                   "i2, c1 to c%zu, %s",
                   name, table_columns(x->table), names);
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

/* The next name from *at on that is no function's, behind which *at is then; false: there is none.
 */
static bool next_name(const char **at, char name[NAME])
{
    static const char letters[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789.";
    while (**at) {
        const char *from = *at;
        const size_t length = strspn(from, letters);
        *at += length > 0 ? length : 1;
        if (is_letter(*from) && length < NAME && from[length] != '(') {
            snprintf(name, NAME, "%.*s", (int)length, from);
            return true;
        }
    }
    return false;
}

bool measured_columns_name(const char *formulas, const char *name)
{
    char found[NAME];
    bool has = false;
    while (formulas && !has && next_name(&formulas, found)) {
        has = strcmp(found, name) == 0;
    }
    return has;
}

/* All columns of the file that a formula names. */
static ad_status use_all(measured_columns *x, const char *formula, ad_error *error)
{
    char name[NAME];
    ad_status status = AD_OK;
    while (status == AD_OK && next_name(&formula, name)) {
        status = use(x, name, error);
        status = status == AD_OK ? check_known(x, name, error) : status;
    }
    return status;
}

/* ---- values -------------------------------------------------------------------------------- */

static double *make_room(measured_columns *x, ad_error *error)
{
    const size_t rows = table_rows(x->table);
    double *values = x->owned_count < OWNED_MAX ? malloc((rows + 1) * sizeof *values) : NULL;
    if (!values) {
        ad_fail(error, AD_NO_MEMORY, "out of memory for columns of %zu rows", rows);
        return NULL;
    }
    return x->owned[x->owned_count++] = values;
}

ad_status measured_columns_compute(measured_columns *x, const char *formula, const double **values,
                                   ad_error *error)
{
    const char *names[QUANTITY_OPEN_MAX];
    double at[QUANTITY_OPEN_MAX] = {0}; /* the first two are where others have s and t */
    ad_status status = use_all(x, formula, error);
    const quantity q = status == AD_OK ? quantity_formula(x->names, formula) : quantity_number(0);
    status = status == AD_OK ? quantity_check(q, error) : status;
    double *to = status == AD_OK ? make_room(x, error) : NULL;
    if (!to) {
        return status == AD_OK ? AD_NO_MEMORY : status;
    }
    const size_t inner = table_inner(x->table);
    for (size_t row = 0; row < table_rows(x->table); row++) {
        bool missing = false;
        for (int i = 0; i < x->used_count; i++) {
            const used_column *of = &x->used[i];
            names[i] = of->name;
            at[i] = of->values       ? of->values[row]
                    : of->index == 1 ? (double)(row / inner + 1)
                                     : (double)(row % inner + 1);
            missing = missing || (isnan(at[i]) && quantity_depends_on(q, of->name));
        }
        to[row] = missing ? NAN : quantity_value_with(q, at[0], at[1], x->used_count, names, at);
        if (!missing && !isfinite(to[row])) {
            return ad_fail(error, AD_BAD_INPUT,
                           "'%.120s' is not a finite number in row %zu of the file", formula,
                           row + 1);
        }
    }
    *values = to;
    return AD_OK;
}

ad_status measured_columns_find(measured_columns *x, const char *name, const double **values,
                                ad_error *error)
{
    char formula[FORMULA];
    ad_error reason;
    const char *line = line_of(x, name);
    if (!line) {
        return find_in_file(x, name, values, error);
    }
    line += strlen(name) + 1;
    snprintf(formula, sizeof formula, "%.*s", (int)strcspn(line, "\n"), line);
    const ad_status status = measured_columns_compute(x, formula, values, &reason);
    return status == AD_OK ? AD_OK : ad_fail(error, status, "%s: %s", name, reason.message);
}
