/* Curves of other programs, from files. */
#include "tools/judge/compare.h"

#include "tools/files/file_bytes.h"
#include "tools/files/table_file.h"

#include <stdlib.h>
#include <string.h>

/* A table and where it is from. */
typedef struct source {
    const char *path;
    table_file *table;
    const double *seconds, *errors;
    const char *const *names; /* NULL: one curve */
} source;

static ad_status fail_at(const source *file, size_t row, const char *column, double value,
                         ad_error *error)
{
    size_t line = table_line(file->table, row);
    char place[32];
    snprintf(place, sizeof place, line ? ":%zu" : ": row %zu", line ? line : row + 1);
    return ad_fail(error, AD_BAD_INPUT,
                   "%s%s: %s is %g; allowed: > 0, since both axes are logarithmic",
                   file_bytes_shown(file->path), place, column, value);
}

static ad_status check(const source *file, bool named, ad_error *error)
{
    const char *path = file_bytes_shown(file->path);
    if (!file->seconds || !file->errors) {
        return ad_fail(
            error, AD_BAD_INPUT,
            "%s: column '%s' is missing; a curve has columns seconds, error, and name if "
            "there are several",
            path, file->seconds ? "error" : "seconds");
    }
    if (table_rows(file->table) == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: there are no rows; at least one is needed", path);
    }
    if (named && file->names) {
        return ad_fail(error, AD_BAD_INPUT,
                       "--curve: %s names its curves in a column; allowed: --curve %s", path, path);
    }
    for (size_t row = 0; row < table_rows(file->table); row++) {
        if (!(file->seconds[row] > 0)) {
            return fail_at(file, row, "seconds", file->seconds[row], error);
        }
        if (!(file->errors[row] > 0)) {
            return fail_at(file, row, "error", file->errors[row], error);
        }
    }
    return AD_OK;
}

/* The curve of that name among those from `first` on, made if there is none. */
static ad_status find(compare_curves *curves, int first, const char *name, size_t rows,
                      compare_curve **found, ad_error *error)
{
    for (int i = 0; i < curves->count; i++) {
        *found = &curves->curves[i];
        if (strcmp((*found)->name, name) == 0) {
            return i >= first
                       ? AD_OK
                       : ad_fail(error, AD_BAD_INPUT, "--curve: two curves are called %s", name);
        }
    }
    if (curves->count == COMPARE_CURVES_MAX) {
        return ad_fail(error, AD_BAD_INPUT, "--curve: more than %d curves", COMPARE_CURVES_MAX);
    }
    compare_curve *made = &curves->curves[curves->count];
    made->count = 0;
    made->seconds = calloc(2 * rows, sizeof *made->seconds);
    if (!made->seconds) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a curve of %zu points", rows);
    }
    made->errors = made->seconds + rows;
    snprintf(made->name, sizeof made->name, "%s", name);
    curves->count++;
    *found = made;
    return AD_OK;
}

static ad_status take(compare_curves *curves, const source *file, const char *name, ad_error *error)
{
    int first = curves->count;
    size_t rows = table_rows(file->table);
    for (size_t row = 0; row < rows; row++) {
        compare_curve *curve = NULL;
        ad_status status =
            find(curves, first, file->names ? file->names[row] : name, rows, &curve, error);
        if (status != AD_OK) {
            return status;
        }
        curve->seconds[curve->count] = file->seconds[row];
        curve->errors[curve->count++] = file->errors[row];
    }
    return AD_OK;
}

ad_status compare_curves_read(compare_curves *curves, const char *text, ad_error *error)
{
    const char *equals = strchr(text, '=');
    char name[COMPARE_NAME], given[COMPARE_NAME];
    source file = {.path = equals ? equals + 1 : text};
    if (equals == text || (equals && equals - text >= COMPARE_NAME) || *file.path == '\0') {
        return ad_fail(
            error, AD_BAD_INPUT,
            "--curve %.200s: allowed: FILE.csv or NAME=FILE.csv, a name of up to %d bytes", text,
            COMPARE_NAME - 1);
    }
    judge_name_of_file(name, file.path);
    if (equals) {
        snprintf(given, sizeof given, "%.*s", (int)(equals - text), text);
        judge_name(name, given);
    }
    const char *const words[] = {"name", NULL};
    ad_status status = table_read_words(file.path, TABLE_FINITE, words, &file.table, error);
    if (status != AD_OK) {
        return status;
    }
    file.seconds = table_column(file.table, "seconds");
    file.errors = table_column(file.table, "error");
    file.names = table_words(file.table, "name");
    status = check(&file, equals != NULL, error);
    if (status == AD_OK) {
        status = take(curves, &file, name, error);
    }
    table_free(file.table);
    return status;
}

void compare_curves_free(compare_curves *curves)
{
    for (int i = 0; i < curves->count; i++) {
        free(curves->curves[i].seconds);
    }
    curves->count = 0;
}
