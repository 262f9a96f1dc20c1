/* Tables as HDF5; the layout is in table_file.h. */
#include <hdf5.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "tools/files/file_bytes.h"
#include "tools/files/hdf5_image.h"
#include "tools/files/table_parts.h"

typedef struct hdf5_reader {
    const table_wanted *wanted;
    size_t file_size;
    table_file *table; /* made with the first column that can be read */
    size_t columns;    /* how many there will be */
    ad_error *error;   /* not NULL */
} hdf5_reader;

static ad_status refuse(const hdf5_reader *reader, const char *column, const char *problem)
{
    return ad_fail(reader->error, AD_BAD_INPUT,
                   "%s: column '%.63s' %s; allowed: one-dimensional float64 datasets of one length "
                   "at the root",
                   file_bytes_shown(reader->wanted->path), column, problem);
}

/* Number of rows of a column, or an error. */
static ad_status check_column(const hdf5_reader *reader, hid_t dataset, const char *name,
                              size_t *rows)
{
    hsize_t extent = 0;
    bool words = table_wants_words(reader->wanted, name);
    hid_t type = H5Dget_type(dataset), space = H5Dget_space(dataset);
    bool is_double = type >= 0 && H5Tget_class(type) == H5T_FLOAT &&
                     H5Tget_size(type) == sizeof(double) &&
                     (H5Tequal(type, H5T_IEEE_F64LE) > 0 || H5Tequal(type, H5T_IEEE_F64BE) > 0);
    bool is_word = type >= 0 && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 &&
                   H5Tget_size(type) >= 1 && H5Tget_size(type) <= TABLE_MAX_NAME + 1;
    size_t width = is_word ? H5Tget_size(type) : sizeof(double);
    bool is_line = space >= 0 && H5Sget_simple_extent_type(space) == H5S_SIMPLE &&
                   H5Sget_simple_extent_ndims(space) == 1 &&
                   H5Sget_simple_extent_dims(space, &extent, NULL) == 1;
    hdf5_image_close(space);
    hdf5_image_close(type);
    if (!(words ? is_word : is_double)) {
        return refuse(reader, name,
                      words ? "does not hold strings of up to 63 bytes" : "is not float64");
    }
    if (!is_line) {
        return refuse(reader, name, "is not one-dimensional");
    }
    const char *problem =
        extent > 0 ? hdf5_image_storage_problem(dataset, extent, width, reader->file_size) : NULL;
    if (problem) {
        return refuse(reader, name, problem);
    }
    *rows = (size_t)extent;
    return AD_OK;
}

/* Strings of any fixed length become words, which are longer by a zero byte. */
static ad_status read_words(const hdf5_reader *reader, hid_t dataset, const char *name,
                            size_t column)
{
    table_file *table = reader->table;
    if (!table_hold_words(table, column, table->rows)) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory for %zu words",
                       file_bytes_shown(reader->wanted->path), table->rows);
    }
    hid_t type = hdf5_image_text_type(TABLE_MAX_NAME + 1);
    bool read = type >= 0 && (table->rows == 0 || H5Dread(dataset, type, H5S_ALL, H5S_ALL,
                                                          H5P_DEFAULT, table->words[column]) >= 0);
    hdf5_image_close(type);
    return read ? AD_OK : refuse(reader, name, "cannot be read, the file is damaged");
}

static ad_status make_table(hdf5_reader *reader, size_t rows)
{
    reader->table = table_create(reader->wanted, reader->columns, rows);
    if (!reader->table) {
        return ad_fail(reader->error, AD_NO_MEMORY, "%s: out of memory for %zu x %zu numbers",
                       file_bytes_shown(reader->wanted->path), rows, reader->columns);
    }
    reader->table->rows = rows;
    return AD_OK;
}

/* The table has as many rows as the first column that can be read. */
static ad_status count_rows(hdf5_reader *reader, hid_t dataset, const char *name, size_t column)
{
    size_t rows = 0;
    ad_status status = check_column(reader, dataset, name, &rows);
    (void)column;
    return status == AD_OK ? make_table(reader, rows)
           : status == AD_BAD_INPUT && reader->wanted->numbers == TABLE_MEASURED ? AD_OK
                                                                                 : status;
}

static ad_status read_column(hdf5_reader *reader, hid_t dataset, const char *name, size_t column)
{
    const table_numbers numbers = reader->wanted->numbers;
    size_t rows = 0;
    ad_status status = check_column(reader, dataset, name, &rows);
    if (status != AD_OK) {
        return status;
    }
    if (rows != reader->table->rows) {
        return refuse(reader, name, "has another length than the first column");
    }
    if (table_wants_words(reader->wanted, name)) {
        return read_words(reader, dataset, name, column);
    }
    double *values = reader->table->values[column];
    if (rows > 0 &&
        H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
        return refuse(reader, name, "cannot be read, the file is damaged");
    }
    for (size_t row = 0; numbers != TABLE_NONFINITE && row < rows; row++) {
        if (!isfinite(values[row]) && !(numbers == TABLE_MEASURED && isnan(values[row]))) {
            return ad_fail(reader->error, AD_BAD_INPUT,
                           "%s: column '%s' row %zu: %g is not finite; allowed: finite numbers",
                           file_bytes_shown(reader->wanted->path), name, row + 1, values[row]);
        }
    }
    return AD_OK;
}

typedef ad_status visit(hdf5_reader *reader, hid_t dataset, const char *name, size_t column);

static ad_status visit_link(hdf5_reader *reader, hid_t root, size_t column, bool by_creation,
                            visit *does)
{
    char name[TABLE_MAX_NAME + 1];
    if (!hdf5_image_link_name(root, column, by_creation, name, sizeof name)) {
        return ad_fail(
            reader->error, AD_BAD_INPUT,
            "%s: object %zu is a link elsewhere, has a second name, or one longer than %d "
            "bytes; "
            "allowed: one-dimensional float64 datasets at the root",
            file_bytes_shown(reader->wanted->path), column + 1, TABLE_MAX_NAME);
    }
    const char *problem = table_name_problem(name, strlen(name));
    if (problem) {
        return ad_fail(reader->error, AD_BAD_INPUT, "%s: object %zu: %s",
                       file_bytes_shown(reader->wanted->path), column + 1, problem);
    }
    hid_t object = H5Oopen(root, name, H5P_DEFAULT);
    ad_status status = object < 0 || H5Iget_type(object) != H5I_DATASET
                           ? refuse(reader, name, "is not a dataset")
                           : does(reader, object, name, column);
    hdf5_image_close(object);
    if (reader->table) {
        strcpy(reader->table->names[column], name);
    }
    return status;
}

/* Whether a group tracks in which order its links were made. */
static bool tracks_creation(hid_t group)
{
    unsigned flags = 0;
    hid_t creation = H5Gget_create_plist(group);
    bool tracked = creation >= 0 && H5Pget_link_creation_order(creation, &flags) >= 0 &&
                   (flags & H5P_CRT_ORDER_TRACKED) != 0;
    hdf5_image_close(creation);
    return tracked;
}

static ad_status read_columns(hid_t file, void *context)
{
    hdf5_reader *reader = context;
    H5G_info_t info;
    const char *shown = file_bytes_shown(reader->wanted->path);
    hid_t root = file < 0 ? H5I_INVALID_HID : H5Gopen2(file, "/", H5P_DEFAULT);
    if (root < 0 || H5Gget_info(root, &info) < 0) {
        hdf5_image_close(root);
        return ad_fail(reader->error, AD_BAD_INPUT, "%s: is not an HDF5 file, or is damaged",
                       shown);
    }
    ad_status status = AD_OK;
    if (info.nlinks == 0 || info.nlinks > TABLE_MAX_COLUMNS) {
        status = ad_fail(reader->error, AD_BAD_INPUT,
                         "%s: has %llu columns; allowed: 1 to %d float64 datasets at the root",
                         shown, (unsigned long long)info.nlinks, TABLE_MAX_COLUMNS);
    }
    bool by_creation = tracks_creation(root);
    reader->columns = (size_t)info.nlinks;
    for (size_t k = 0; status == AD_OK && !reader->table && k < info.nlinks; k++) {
        status = visit_link(reader, root, k, by_creation, count_rows);
    }
    if (status == AD_OK && !reader->table) {
        status = make_table(reader, 0);
    }
    for (size_t k = 0; status == AD_OK && k < info.nlinks; k++) {
        status = visit_link(reader, root, k, by_creation, read_column);
        if (status != AD_OK && table_postpones(reader->wanted, reader->table, k, reader->error)) {
            status = AD_OK;
        }
    }
    hdf5_image_close(root);
    return status;
}

ad_status table_from_hdf5(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                          table_file **table, ad_error *error)
{
    ad_error reason = {.message = ""};
    hdf5_reader reader = {.wanted = wanted, .file_size = size, .table = NULL, .error = &reason};
    ad_status status = hdf5_image_read(bytes, size, read_columns, &reader);
    if (status == AD_NO_MEMORY && reason.status != AD_NO_MEMORY) { /* HDF5 had none */
        ad_fail(&reason, status, "%s: out of memory", file_bytes_shown(wanted->path));
    }
    if (status != AD_OK) {
        table_free(reader.table);
        return ad_fail(error, status, "%s", reason.message);
    }
    *table = reader.table;
    return AD_OK;
}

/* A column of `rows` values of the type, which are `values`; unit may be NULL. */
static bool write_values(hid_t file, const char *name, hid_t stored, hid_t given,
                         const void *values, size_t rows, const char *unit)
{
    hid_t dataset =
        hdf5_image_dataset(file, name, stored, given, 1, (const hsize_t[]){rows}, values);
    bool written = dataset >= 0 && (!unit || hdf5_image_text(dataset, "units", unit));
    hdf5_image_close(dataset);
    return written;
}

static bool write_words(hid_t file, const char *name, const char *const *words, size_t rows,
                        const char *unit)
{
    size_t size;
    char *text = hdf5_image_words(words, rows, &size);
    hid_t type = hdf5_image_text_type(size);
    bool written = text && write_values(file, name, type, type, text, rows, unit);
    hdf5_image_close(type);
    free(text);
    return written;
}

static bool write_columns(hid_t file, const void *context)
{
    const table_source *source = context;
    bool written = true;
    for (size_t k = 0; written && k < source->ncols; k++) {
        const char *name = source->names[k], *unit = source->units ? source->units[k] : NULL;
        const char *const *words = source->words ? source->words[k] : NULL;
        written = words ? write_words(file, name, words, source->nrows, unit)
                        : write_values(file, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                                       source->columns[k], source->nrows, unit);
    }
    return written;
}

ad_status table_to_hdf5(const table_source *source, unsigned char **bytes, size_t *size)
{
    size_t width = 0;
    for (size_t k = 0; k < source->ncols; k++) {
        width += source->words && source->words[k] ? TABLE_MAX_NAME + 1 : sizeof(double);
    }
    return hdf5_image_write(0, source->nrows * width, write_columns, source, bytes, size);
}
