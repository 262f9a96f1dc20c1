#include "tools/files/table_file.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/files/file_bytes.h"
#include "tools/files/table_parts.h"

typedef ad_status read_bytes(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                             table_file **table, ad_error *error);
typedef ad_status write_bytes(const table_source *source, unsigned char **bytes, size_t *size);

/* Kinds of tables; those without a function are not read, or not written. */
typedef struct table_format {
    const char *ending;
    read_bytes *read;
    write_bytes *write;
} table_format;

static const table_format formats[] = {{".csv", table_from_csv, table_to_csv},
                                       {".h5", table_from_hdf5, table_to_hdf5},
                                       {".hdf5", table_from_hdf5, table_to_hdf5},
                                       {".npz", table_from_npz, table_to_npz},
                                       {".npy", table_from_npy, NULL},
                                       {".c3d", table_from_c3d, NULL}};

static const table_format *format_of(const char *path)
{
    const size_t length = strlen(path);
    for (size_t k = 0; k < sizeof formats / sizeof *formats; k++) {
        const size_t ending = strlen(formats[k].ending);
        if (length > ending && strcmp(path + length - ending, formats[k].ending) == 0) {
            return &formats[k];
        }
    }
    return NULL;
}

static ad_status fail_format(const char *path, bool written, ad_error *error)
{
    const table_format *format = format_of(path);
    char endings[64] = "", what[64] = "the ending does not say what kind of table it is";
    for (size_t k = 0; k < sizeof formats / sizeof *formats; k++) {
        if (written ? formats[k].write != NULL : formats[k].read != NULL) {
            strcat(strcat(endings, *endings ? ", " : ""), formats[k].ending);
        }
    }
    if (format) {
        snprintf(what, sizeof what, "%s is %s", format->ending,
                 written ? "read, not written" : "written, not read");
    }
    return ad_fail(error, written ? AD_BAD_ARGUMENT : AD_BAD_INPUT, "%s: %s; allowed: %s",
                   file_bytes_shown(path), what, endings);
}

/* A name made of these alone would be taken for a number, but not e1. */
static bool looks_like_number(const char *name, size_t length)
{
    bool digits = false;
    for (size_t k = 0; k < length; k++) {
        digits = digits || (name[k] >= '0' && name[k] <= '9');
        if (!strchr("0123456789+-.eE", name[k])) {
            return false;
        }
    }
    return digits && name[0] != 'e' && name[0] != 'E';
}

typedef enum spelling { SPELLING_FINE, SPELLING_BLANK, SPELLING_BYTE } spelling;

static spelling spelling_of(const char *text, size_t length)
{
    if (text[0] == ' ' || text[length - 1] == ' ' || (length == 1 && text[0] == '.') ||
        (length == 2 && text[0] == '.' && text[1] == '.')) {
        return SPELLING_BLANK;
    }
    for (size_t k = 0; k < length; k++) {
        if ((unsigned char)text[k] < ' ' || strchr(",\"'/#\x7f", text[k])) {
            return SPELLING_BYTE;
        }
    }
    return SPELLING_FINE;
}

const char *table_name_problem(const char *name, size_t length)
{
    static const char *const problems[] = {
        NULL, "the name of a column starts or ends with a blank, or is '.' or '..'",
        "the name of a column has a comma, quote, slash, '#' or control character"};
    static const char mark[] = "\xef\xbb\xbf";
    if (length == 0) {
        return "a column has no name";
    }
    if (length > TABLE_MAX_NAME) {
        return "the name of a column is longer than 63 bytes";
    }
    if (length >= strlen(mark) && memcmp(name, mark, strlen(mark)) == 0) {
        return "the name of a column starts with a byte order mark";
    }
    if (looks_like_number(name, length)) {
        return "a number stands where the name of a column must be";
    }
    return problems[spelling_of(name, length)];
}

const char *table_word_problem(const char *word, size_t length)
{
    static const char *const problems[] = {
        NULL, "the word starts or ends with a blank, or is '.' or '..'",
        "the word has a comma, quote, slash, '#' or control character"};
    if (length == 0) {
        return "a word is missing";
    }
    return length > TABLE_MAX_NAME ? "the word is longer than 63 bytes"
                                   : problems[spelling_of(word, length)];
}

table_file *table_create(const table_wanted *wanted, size_t columns, size_t rows)
{
    table_file *table = calloc(1, sizeof *table);
    if (!table) {
        return NULL;
    }
    table->columns = columns;
    table->inner = 1;
    table->names = calloc(columns, sizeof *table->names);
    table->values = calloc(columns, sizeof *table->values);
    table->words = calloc(columns, sizeof *table->words);
    table->pointers = calloc(columns, sizeof *table->pointers);
    table->problems = calloc(columns, sizeof *table->problems);
    table->path = strdup(file_bytes_shown(wanted->path));
    bool complete = table->names && table->values && table->words && table->pointers &&
                    table->problems && table->path;
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

bool table_postpones(const table_wanted *wanted, table_file *table, size_t column,
                     const ad_error *reason)
{
    if (reason->status != AD_BAD_INPUT || wanted->numbers != TABLE_MEASURED) {
        return false;
    }
    table->problems[column] = *reason;
    return true;
}

bool table_wants_words(const table_wanted *wanted, const char *name)
{
    for (const char *const *word = wanted->words; word && *word; word++) {
        if (strcmp(*word, name) == 0) {
            return true;
        }
    }
    return false;
}

bool table_hold_words(table_file *table, size_t column, size_t rows)
{
    rows = rows > 0 ? rows : 1;
    table->words[column] = calloc(rows, sizeof *table->words[column]);
    table->pointers[column] = calloc(rows, sizeof *table->pointers[column]);
    if (!table->words[column] || !table->pointers[column]) {
        return false;
    }
    for (size_t row = 0; row < rows; row++) {
        table->pointers[column][row] = table->words[column][row];
    }
    free(table->values[column]);
    table->values[column] = NULL;
    return true;
}

void table_free(table_file *table)
{
    if (!table) {
        return;
    }
    for (size_t k = 0; k < table->columns; k++) {
        if (table->values) {
            free(table->values[k]);
        }
        if (table->words) {
            free(table->words[k]);
        }
        if (table->pointers) {
            free(table->pointers[k]);
        }
    }
    free(table->words);
    free(table->pointers);
    free(table->values);
    free(table->names);
    free(table->lines);
    free(table->problems);
    free(table->path);
    free(table);
}

ad_status table_read(const char *path, table_numbers numbers, table_file **table, ad_error *error)
{
    return table_read_words(path, numbers, NULL, table, error);
}

ad_status table_read_words(const char *path, table_numbers numbers, const char *const *words,
                           table_file **table, ad_error *error)
{
    const table_wanted wanted = {path, numbers, words};
    unsigned char *bytes = NULL;
    size_t size = 0, file_size = 0;
    const table_format *format = format_of(path);
    *table = NULL;
    if (!format || !format->read) {
        return fail_format(path, false, error);
    }
    ad_status status = file_bytes_read(path, 0, &bytes, &size, &file_size, error);
    if (status != AD_OK) {
        return status;
    }
    status = format->read(&wanted, bytes, size, table, error);
    free(bytes);
    return status;
}

size_t table_rows(const table_file *table)
{
    return table->rows;
}

size_t table_inner(const table_file *table)
{
    return table->inner;
}

size_t table_columns(const table_file *table)
{
    return table->columns;
}

const char *table_name(const table_file *table, size_t index)
{
    return table->names[index];
}

static size_t find_column(const table_file *table, const char *name)
{
    size_t k = 0;
    while (k < table->columns && strcmp(table->names[k], name) != 0) {
        k++;
    }
    return k;
}

const double *table_column(const table_file *table, const char *name)
{
    size_t k = find_column(table, name);
    return k < table->columns && table->problems[k].status == AD_OK ? table->values[k] : NULL;
}

ad_status table_find(const table_file *table, const char *name, table_numbers numbers,
                     const double **column, ad_error *error)
{
    const size_t k = find_column(table, name);
    *column = NULL;
    if (k == table->columns) {
        return AD_OK;
    }
    if (table->problems[k].status != AD_OK) {
        return ad_fail(error, AD_BAD_INPUT, "%s", table->problems[k].message);
    }
    for (size_t row = 0; numbers == TABLE_FINITE && row < table->rows; row++) {
        const size_t line = table_line(table, row);
        if (!isfinite(table->values[k][row])) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%s:%s%zu: column '%s' has no number; allowed there: a number in each "
                           "row",
                           table->path, line ? "" : " row ", line ? line : row + 1, name);
        }
    }
    *column = table->values[k];
    return AD_OK;
}

const char *const *table_words(const table_file *table, const char *name)
{
    size_t k = find_column(table, name);
    return k < table->columns ? table->pointers[k] : NULL;
}

size_t table_line(const table_file *table, size_t row)
{
    return table->lines && row < table->rows ? table->lines[row] : 0;
}

static ad_status check_words(const char *path, const table_source *source, size_t column,
                             ad_error *error)
{
    const char *const *words = source->words ? source->words[column] : NULL;
    for (size_t row = 0; words && row < source->nrows; row++) {
        const char *problem = table_word_problem(words[row], strlen(words[row]));
        if (problem) {
            return ad_fail(error, AD_BAD_ARGUMENT, "%s: column '%s' row %zu, '%.63s': %s",
                           file_bytes_shown(path), source->names[column], row + 1, words[row],
                           problem);
        }
    }
    return AD_OK;
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
        ad_status status = check_words(path, source, k, error);
        if (status != AD_OK) {
            return status;
        }
    }
    return AD_OK;
}

ad_status table_check_path(const char *path, ad_error *error)
{
    const table_format *format = format_of(path);
    return format && format->write ? file_bytes_check(path, error) : fail_format(path, true, error);
}

void table_begin(table_build *to, size_t rows)
{
    to->table = (table_source){
        .names = to->names, .columns = to->columns, .words = to->words, .nrows = rows};
}

void table_add(table_build *to, const char *name, const char *unit, const double *numbers,
               const char *const *words)
{
    const size_t k = to->table.ncols;
    if (k < TABLE_MAX_COLUMNS) {
        to->names[k] = name;
        to->units[k] = unit ? unit : "";
        to->columns[k] = numbers;
        to->words[k] = words;
        to->table.units = unit ? to->units : to->table.units;
        to->table.ncols++;
    }
}

ad_status table_write(const char *path, const table_source *table, ad_error *error)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    const table_format *format = format_of(path);
    if (!format || !format->write) {
        return fail_format(path, true, error);
    }
    if (format->write == table_to_npz && !table_fits_npz(table)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%s: %zu x %zu numbers are more than 4 GiB; allowed there: .h5, .hdf5, .csv",
                       file_bytes_shown(path), table->nrows, table->ncols);
    }
    ad_status status = check_source(path, table, error);
    if (status != AD_OK) {
        return status;
    }
    status = format->write(table, &bytes, &size);
    if (status != AD_OK) {
        return ad_fail(error, status, "%s: cannot be written: out of memory for %zu x %zu numbers",
                       file_bytes_shown(path), table->nrows, table->ncols);
    }
    status = file_bytes_write(path, bytes, size, error);
    free(bytes);
    return status;
}
