/* Tables from NumPy's arrays of numbers: .npy, and .npz, an archive of these. Format: NEP 1, "A
 * simple file format for NumPy arrays", versions 1 to 3.
 *
 * A row of the table is an index of the first dimension, of three dimensions one of the first two,
 * the second varying fastest. The last dimension of two or three becomes columns: of .npy c1, c2,
 * ..., of an array "p" of an archive p_1, p_2, ... An array of one dimension is a column. In an
 * archive one of fewer dimensions than another is the same in all rows that it does not tell apart.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tools/files/file_bytes.h"
#include "tools/files/table_parts.h"
#include "tools/files/zip.h"

enum { DIMENSIONS = 3, ARRAYS = 256, PROBLEM = 160 };

typedef struct array {
    char name[ZIP_NAME]; /* "": the only one */
    unsigned char *held; /* owned; NULL: those of a file */
    const unsigned char *numbers;
    char kind;    /* f, i, u, b; else no numbers */
    size_t bytes; /* of one */
    bool is_big, by_columns;
    int dimensions;
    size_t shape[DIMENSIONS];
    char problem[PROBLEM]; /* "": none */
} array;

/* ---- one array ----------------------------------------------------------------------------- */

/* Behind `key` in the description; NULL: it is not there. */
static const char *value_of(const char *text, const char *key)
{
    const char *at = strstr(text, key);
    at = at ? strchr(at + strlen(key), ':') : NULL;
    return at ? at + 1 + strspn(at + 1, " ") : NULL;
}

/* "'<f8'": byte order, kind, size. What is no number is left for whoever asks for it. */
static bool read_type(array *a, const char *text)
{
    char order, kind;
    unsigned bytes;
    if (!text || *text != '\'' || sscanf(text, "'%c%c%u'", &order, &kind, &bytes) != 3) {
        return text && (*text == '[' || *text == '\''); /* of structures, of objects */
    }
    const bool wide = bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8;
    if ((kind == 'f' && (bytes == 4 || bytes == 8)) || (strchr("iu", kind) && wide) ||
        (kind == 'b' && bytes == 1)) {
        a->kind = kind;
        a->bytes = bytes;
        a->is_big = order == '>';
    }
    return strchr("<>|=", order) != NULL;
}

static const char *read_shape(array *a, const char *text)
{
    static const char damaged[] = "has a damaged header";
    char *end;
    if (!text || *text != '(') {
        return damaged;
    }
    for (text += 1; *text != ')'; text += strspn(text, ", ")) {
        if (*text < '0' || *text > '9') {
            return damaged;
        }
        const unsigned long long size = strtoull(text, &end, 10);
        if (a->dimensions == DIMENSIONS) {
            return "has more than 3 dimensions";
        }
        a->shape[a->dimensions++] = (size_t)size;
        text = end;
    }
    return NULL;
}

/* How many numbers there are; false: more than memory has. */
static bool count_numbers(const array *a, size_t *count)
{
    *count = 1;
    for (int i = 0; i < a->dimensions; i++) {
        if (a->shape[i] > 0 && *count > SIZE_MAX / 64 / a->shape[i]) {
            return false;
        }
        *count *= a->shape[i];
    }
    return true;
}

/* NULL, or what is wrong with all of the file. */
static const char *read_array(array *a, const unsigned char *bytes, size_t size)
{
    static const char damaged[] = "has a damaged header";
    char text[4096];
    const size_t wide = size > 6 && bytes[6] > 1 ? 4 : 2; /* of the length, by version */
    if (size < 8 + wide || memcmp(bytes, "\x93NUMPY", 6) != 0) {
        return "is no NumPy array";
    }
    size_t length = bytes[8] + 256U * bytes[9], count;
    length += wide == 4 ? (size_t)bytes[10] << 16 | (size_t)bytes[11] << 24 : 0;
    if (length >= sizeof text || size - 8 - wide < length) {
        return damaged;
    }
    memcpy(text, bytes + 8 + wide, length);
    text[length] = '\0';
    const char *order = value_of(text, "'fortran_order'");
    if (!read_type(a, value_of(text, "'descr'")) || !order) {
        return damaged;
    }
    a->by_columns = strncmp(order, "True", 4) == 0;
    const char *problem = read_shape(a, value_of(text, "'shape'"));
    if (!a->kind) {
        snprintf(a->problem, sizeof a->problem, "%s",
                 "holds no real numbers; allowed: floats of 4 or 8 bytes, integers, booleans");
        return NULL;
    }
    if (problem) {
        return problem;
    }
    a->numbers = bytes + 8 + wide + length;
    const bool fits = count_numbers(a, &count) && (size - 8 - wide - length) / a->bytes >= count;
    return !fits        ? "is cut off: it has fewer numbers than its shape says"
           : count == 0 ? "is empty"
                        : NULL;
}

static double number_at(const array *a, size_t index)
{
    const unsigned char *at = a->numbers + index * a->bytes;
    uint64_t bits = 0;
    for (size_t i = 0; i < a->bytes; i++) {
        bits = bits << 8 | at[a->is_big ? i : a->bytes - 1 - i];
    }
    if (a->kind == 'f' && a->bytes == 4) {
        const uint32_t half = (uint32_t)bits;
        float value;
        memcpy(&value, &half, sizeof value);
        return value;
    }
    if (a->kind == 'f') {
        double value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    const unsigned unused = 64 - 8 * (unsigned)a->bytes;
    return a->kind == 'i' ? (double)((int64_t)(bits << unused) >> unused) : (double)bits;
}

/* Of an index of each dimension. */
static double element(const array *a, const size_t at[DIMENSIONS])
{
    size_t index = 0;
    for (int i = 0; i < a->dimensions; i++) {
        const int k = a->by_columns ? a->dimensions - 1 - i : i;
        index = index * a->shape[k] + at[k];
    }
    return number_at(a, index);
}

/* ---- the table ----------------------------------------------------------------------------- */

static size_t columns_of(const array *a)
{
    return *a->problem || a->dimensions < 2 ? 1 : a->shape[a->dimensions - 1];
}

/* Rows by the longest first dimension, and of these by the longest second of three. */
static void measure(array *arrays, int count, size_t *rows, size_t *inner)
{
    *rows = *inner = 0;
    for (int i = 0; i < count; i++) {
        const array *a = &arrays[i];
        *rows = !*a->problem && a->dimensions > 0 && a->shape[0] > *rows ? a->shape[0] : *rows;
    }
    for (int i = 0; i < count; i++) {
        const array *a = &arrays[i];
        const bool deep = !*a->problem && a->dimensions == 3 && a->shape[0] == *rows;
        *inner = deep && a->shape[1] > *inner ? a->shape[1] : *inner;
    }
    *inner = *inner > 0 ? *inner : 1;
    for (int i = 0; i < count; i++) {
        array *a = &arrays[i];
        if (!*a->problem && ((a->dimensions > 0 && a->shape[0] != *rows) ||
                             (a->dimensions == 3 && a->shape[1] != *inner))) {
            snprintf(a->problem, sizeof a->problem,
                     "has %zu rows, of others the file has %zu by %zu; allowed: as many, or one "
                     "number",
                     a->shape[0], *rows, *inner);
        }
    }
}

static ad_status fail_array(const table_wanted *wanted, const array *a, const char *problem,
                            ad_error *error)
{
    return ad_fail(error, *problem ? AD_BAD_INPUT : AD_NO_MEMORY, "%s: %s%.60s%s%s",
                   file_bytes_shown(wanted->path), *a->name ? "the array '" : "", a->name,
                   *a->name ? "' " : "", *problem ? problem : "out of memory");
}

/* One column; what is no number is found by the first row of it. */
static ad_status fill(const table_wanted *wanted, table_file *table, size_t column, const array *a,
                      size_t part, ad_error *error)
{
    ad_error reason = {.status = AD_OK};
    for (size_t row = 0; row < table->rows && !*a->problem; row++) {
        size_t at[DIMENSIONS] = {row / table->inner, row % table->inner, part};
        at[1] = a->dimensions == 2 ? part : at[1];
        const double value = element(a, at);
        table->values[column][row] = value;
        const bool wrong = wanted->numbers == TABLE_FINITE ? !isfinite(value) : isinf(value) != 0;
        if (wrong && wanted->numbers != TABLE_NONFINITE && reason.status == AD_OK) {
            ad_fail(&reason, AD_BAD_INPUT, "%s: column '%s' row %zu is not finite",
                    file_bytes_shown(wanted->path), table->names[column], row + 1);
        }
    }
    if (*a->problem) {
        fail_array(wanted, a, a->problem, &reason);
    }
    return reason.status == AD_OK || table_postpones(wanted, table, column, &reason)
               ? AD_OK
               : ad_fail(error, reason.status, "%s", reason.message);
}

static ad_status name_column(const table_wanted *wanted, table_file *table, size_t column,
                             const array *a, size_t part, ad_error *error)
{
    char name[ZIP_NAME + 24];
    const bool many = !*a->problem && a->dimensions > 1;
    snprintf(name, sizeof name, many ? "%s%s%zu" : "%s", *a->name ? a->name : "c",
             *a->name ? "_" : "", part + 1);
    if (!*a->name && !many) {
        snprintf(name, sizeof name, "c1");
    }
    const char *problem = table_name_problem(name, strlen(name));
    for (size_t k = 0; k < column && !problem; k++) {
        problem = strcmp(table->names[k], name) == 0 ? "has the name of another column" : NULL;
    }
    if (problem) {
        return fail_array(wanted, a, problem, error);
    }
    memcpy(table->names[column], name, strlen(name) + 1);
    return AD_OK;
}

static ad_status make_table(const table_wanted *wanted, array *arrays, int count,
                            table_file **result, ad_error *error)
{
    size_t rows, inner, columns = 0;
    measure(arrays, count, &rows, &inner);
    for (int i = 0; i < count && columns <= TABLE_MAX_COLUMNS; i++) {
        const size_t more = columns_of(&arrays[i]);
        columns = more > TABLE_MAX_COLUMNS ? more : columns + more;
    }
    if (columns > TABLE_MAX_COLUMNS || columns == 0) {
        return ad_fail(error, AD_BAD_INPUT, "%s: has %s columns; allowed: 1 to 1024",
                       file_bytes_shown(wanted->path), columns ? "too many" : "no");
    }
    table_file *table = table_create(wanted, columns, rows * inner);
    if (!table) {
        return ad_fail(error, AD_NO_MEMORY, "%s: out of memory for %zu columns of %zu rows",
                       file_bytes_shown(wanted->path), columns, rows * inner);
    }
    table->rows = rows * inner;
    table->inner = inner;
    ad_status status = AD_OK;
    for (size_t i = 0, column = 0; i < (size_t)count; i++) {
        const size_t parts = columns_of(&arrays[i]);
        for (size_t part = 0; part < parts && status == AD_OK; part++, column++) {
            status = name_column(wanted, table, column, &arrays[i], part, error);
            status =
                status == AD_OK ? fill(wanted, table, column, &arrays[i], part, error) : status;
        }
    }
    if (status != AD_OK) {
        table_free(table);
        return status;
    }
    *result = table;
    return AD_OK;
}

/* ---- files --------------------------------------------------------------------------------- */

ad_status table_from_npy(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                         table_file **table, ad_error *error)
{
    array one = {.name = ""};
    const char *problem = read_array(&one, bytes, size);
    problem = !problem && *one.problem ? one.problem : problem;
    return problem ? fail_array(wanted, &one, problem, error)
                   : make_table(wanted, &one, 1, table, error);
}

/* The next array of an archive. Arrays of texts, as the names of columns, are passed over where no
 * measurements are read. */
static const char *take_array(const table_wanted *wanted, zip_reader *archive, array *a,
                              bool *taken)
{
    size_t size;
    const char *problem = zip_next(archive, a->name, &a->held, &size);
    *taken = false;
    if (problem || !a->held) {
        a->name[0] = '\0';
        return problem;
    }
    const size_t length = strlen(a->name);
    if (length > 4 && strcmp(a->name + length - 4, ".npy") == 0) {
        a->name[length - 4] = '\0';
        problem = read_array(a, a->held, size);
        *taken = !*a->problem || wanted->numbers == TABLE_MEASURED;
    }
    return problem;
}

ad_status table_from_npz(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                         table_file **table, ad_error *error)
{
    zip_reader archive;
    array *arrays = calloc(ARRAYS, sizeof *arrays);
    int count = 0;
    const char *problem = arrays ? zip_open(&archive, bytes, size) : "";
    while (!problem && archive.left > 0) {
        bool taken;
        problem = count < ARRAYS - 1 ? take_array(wanted, &archive, &arrays[count], &taken)
                                     : "has too many arrays";
        if (!problem && !taken) {
            free(arrays[count].held);
            arrays[count] = (array){.name = ""};
        }
        count += !problem && taken;
    }
    ad_status status = problem && !arrays ? ad_fail(error, AD_NO_MEMORY, "out of memory")
                       : problem          ? fail_array(wanted, &arrays[count], problem, error)
                                          : make_table(wanted, arrays, count, table, error);
    for (int i = 0; arrays && i <= count; i++) {
        free(arrays[i].held);
    }
    free(arrays);
    return status;
}
