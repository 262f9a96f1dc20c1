#include "tools/files/table_file.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "tools/files/file_bytes.h"
#include "tools/files/table_parts.h"

typedef enum table_format { FORMAT_CSV, FORMAT_HDF5, FORMAT_UNKNOWN } table_format;

static table_format format_of(const char *path)
{
    static const struct {
        const char *ending;
        table_format format;
    } known[] = {{".csv", FORMAT_CSV}, {".h5", FORMAT_HDF5}, {".hdf5", FORMAT_HDF5}};
    size_t length = strlen(path);
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        size_t ending = strlen(known[k].ending);
        if (length > ending && strcmp(path + length - ending, known[k].ending) == 0) {
            return known[k].format;
        }
    }
    return FORMAT_UNKNOWN;
}

static ad_status fail_format(const char *path, ad_status status, ad_error *error)
{
    return ad_fail(error, status,
                   "%s: the ending does not say what kind of table it is; allowed: .csv, .h5, "
                   ".hdf5",
                   file_bytes_shown(path));
}

/* A name made of these alone would be taken for a number. */
static bool looks_like_number(const char *name, size_t length)
{
    bool digits = false;
    for (size_t k = 0; k < length; k++) {
        digits = digits || (name[k] >= '0' && name[k] <= '9');
        if (!strchr("0123456789+-.eE", name[k])) {
            return false;
        }
    }
    return digits;
}

const char *table_name_problem(const char *name, size_t length)
{
    if (length == 0) {
        return "a column has no name";
    }
    if (length > TABLE_MAX_NAME) {
        return "the name of a column is longer than 63 bytes";
    }
    if (looks_like_number(name, length)) {
        return "a number stands where the name of a column must be";
    }
    if (name[0] == ' ' || name[length - 1] == ' ' || (length == 1 && name[0] == '.') ||
        (length == 2 && name[0] == '.' && name[1] == '.')) {
        return "the name of a column starts or ends with a blank, or is '.' or '..'";
    }
    for (size_t k = 0; k < length; k++) {
        if ((unsigned char)name[k] < ' ' || strchr(",\"'/#\x7f", name[k])) {
            return "the name of a column has a comma, quote, slash, '#' or control character";
        }
    }
    return NULL;
}

table_file *table_create(size_t columns, size_t rows)
{
    table_file *table = calloc(1, sizeof *table);
    if (!table) {
        return NULL;
    }
    table->columns = columns;
    table->names = calloc(columns, sizeof *table->names);
    table->values = calloc(columns, sizeof *table->values);
    bool complete = table->names && table->values;
    for (size_t k = 0; complete && k < columns; k++) {
        table->values[k] = calloc(rows > 0 ? rows : 1, sizeof **table->values);
        complete = table->values[k] != NULL;
    }
    if (!complete) {
        table_free(table);
        return NULL;
    }
    return table;
}

void table_free(table_file *table)
{
    if (!table) {
        return;
    }
    for (size_t k = 0; table->values && k < table->columns; k++) {
        free(table->values[k]);
    }
    free(table->values);
    free(table->names);
    free(table->lines);
    free(table);
}

ad_status table_read(const char *path, table_numbers numbers, table_file **table, ad_error *error)
{
    unsigned char *bytes = NULL;
    size_t size = 0, file_size = 0;
    table_format format = format_of(path);
    *table = NULL;
    if (format == FORMAT_UNKNOWN) {
        return fail_format(path, AD_BAD_INPUT, error);
    }
    ad_status status = file_bytes_read(path, 0, &bytes, &size, &file_size, error);
    if (status != AD_OK) {
        return status;
    }
    status = format == FORMAT_CSV ? table_from_csv(path, bytes, size, numbers, table, error)
                                  : table_from_hdf5(path, bytes, size, numbers, table, error);
    free(bytes);
    return status;
}

size_t table_rows(const table_file *table)
{
    return table->rows;
}

size_t table_columns(const table_file *table)
{
    return table->columns;
}

const char *table_name(const table_file *table, size_t index)
{
    return table->names[index];
}

const double *table_column(const table_file *table, const char *name)
{
    for (size_t k = 0; k < table->columns; k++) {
        if (strcmp(table->names[k], name) == 0) {
            return table->values[k];
        }
    }
    return NULL;
}

size_t table_line(const table_file *table, size_t row)
{
    return table->lines && row < table->rows ? table->lines[row] : 0;
}

static ad_status check_source(const char *path, const table_source *source, ad_error *error)
{
    const char *shown = file_bytes_shown(path);
    if (source->ncols == 0 || source->ncols > TABLE_MAX_COLUMNS) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%s: %zu columns; allowed: 1 to %d", shown,
                       source->ncols, TABLE_MAX_COLUMNS);
    }
    for (size_t k = 0; k < source->ncols; k++) {
        const char *problem = table_name_problem(source->names[k], strlen(source->names[k]));
        if (problem) {
            return ad_fail(error, AD_BAD_ARGUMENT, "%s: column %zu, '%.63s': %s", shown, k + 1,
                           source->names[k], problem);
        }
        for (size_t other = 0; other < k; other++) {
            if (strcmp(source->names[k], source->names[other]) == 0) {
                return ad_fail(error, AD_BAD_ARGUMENT,
                               "%s: columns %zu and %zu are both named '%s'; names must differ",
                               shown, other + 1, k + 1, source->names[k]);
            }
        }
    }
    return AD_OK;
}

ad_status table_write(const char *path, const char *const *names, const double *const *columns,
                      size_t ncols, size_t nrows, ad_error *error)
{
    table_source source = {names, columns, ncols, nrows};
    unsigned char *bytes = NULL;
    size_t size = 0;
    table_format format = format_of(path);
    if (format == FORMAT_UNKNOWN) {
        return fail_format(path, AD_BAD_ARGUMENT, error);
    }
    ad_status status = check_source(path, &source, error);
    if (status != AD_OK) {
        return status;
    }
    status = format == FORMAT_CSV ? table_to_csv(&source, &bytes, &size)
                                  : table_to_hdf5(&source, &bytes, &size);
    if (status != AD_OK) {
        return ad_fail(error, status, "%s: cannot be written: out of memory for %zu x %zu numbers",
                       file_bytes_shown(path), nrows, ncols);
    }
    status = file_bytes_write(path, bytes, size, 1, error);
    free(bytes);
    return status;
}
