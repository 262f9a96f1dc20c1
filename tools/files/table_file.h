/* Tables: named columns of numbers, all of one length, as CSV, HDF5, NumPy's .npz or C3D. Columns
 * that the caller names may hold words instead. The file's ending decides: ".csv", ".h5", ".hdf5";
 * ".npz"; ".npy" and ".c3d", which are read only.
 *
 * CSV: one line of column names, then one line of numbers for each row, fields separated by commas,
 *   blanks around a field ignored, empty lines and lines whose first character is '#' skipped. A
 *   field that begins with a double quote ends with the next one, so that texts may have commas.
 * Lines end in LF or CR LF; a UTF-8 byte order mark may come first. Numbers are decimal with a
 * point whatever the locale is ("-1.5e-3"), or the words nan, inf, infinity in any case. A name or
 * word that begins with '=', '+', '-' or '@', which a spreadsheet would run as a formula, is
 * written behind an apostrophe and read without it. HDF5: each column a one-dimensional float64
 * dataset at the root, named as the column, no other objects; words are strings of fixed length in
 * UTF-8, and a unit is the dataset's attribute "units". .npz: each column an array of float64, or
 * of strings; where there are units, the arrays "columns" and "units" hold the names of the columns
 * in order and their units. For Python: table = numpy.load("rod.npz"); dict(zip(table["columns"],
 * table["units"])) Written files keep the order of the columns; others are read in the order of
 * their links' creation if they track it, else of their names. Column names: 1 to 63 bytes, not a
 * number, no comma, quote, slash, '#' or control character, no blank at either end, not "." or
 * "..".
 *
 * .npy, and .npz that others wrote: arrays of floats, integers or booleans of up to three
 *   dimensions, of either order of bytes and of dimensions. A row is an index of the first
 *   dimension, of three dimensions one of the first two (table_inner). The last dimension of two or
 *   three are columns, c1, c2, ... of .npy, of an array p of .npz p_1, p_2, ... In .npz an array of
 *   fewer dimensions is the same in all rows that it does not tell apart.
 *
 * Where measured numbers are read (TABLE_MEASURED), CSV may have no line of names: its columns are
 * c1, c2, ... So are those whose name cannot be one.
 *
 * C3D, what cameras saw of markers, https://www.c3d.org: a row for each frame, the column t in s
 *   from the first one by POINT:RATE, and of each marker LABEL.x, LABEL.y, LABEL.z in metres by
 *   POINT:UNITS (m, cm, mm; as they stand where the file says none). In labels a run of other than
 *   letters and digits is one underscore: "Tip - 1" gives Tip_1.x. Without a label of its own a
 *   marker is marker_1, by its place. A marker that was lost, with a negative residual, is NaN.
 *   Numbers of Intel, DEC and MIPS. A POINT:SCALE < 0 tells that frames hold reals: these are in
 *   the file's unit, and the scale is not applied to them; one > 0 is that of integers. */
#ifndef TOOLS_FILES_TABLE_FILE_H
#define TOOLS_FILES_TABLE_FILE_H

#include <stddef.h>

#include "autodiff/error.h"

#define TABLE_MAX_NAME    63
#define TABLE_MAX_COLUMNS 1024
#define TABLE_MAX_LINE    65536 /* bytes of one CSV line */

typedef enum table_numbers {
    TABLE_FINITE,    /* refuse nan and inf, naming where they are */
    TABLE_NONFINITE, /* accept them */
    TABLE_MEASURED   /* nan, an empty field: a number that is missing, NaN. What is no number is
                      * refused where table_find is asked for its column, not before */
} table_numbers;

typedef struct table_file table_file;

/* Read `path`; the caller owns `*table`, which is NULL after an error. A header without rows is a
 * table of 0 rows. Errors: AD_IO (cannot be read), AD_NO_MEMORY, AD_BAD_INPUT with the message
 * "file:line:column: what is wrong; what is allowed" (bytes counted from 1), for HDF5
 * "file: column 'name': ..." with rows counted from 1. */
ad_status table_read(const char *path, table_numbers numbers, table_file **table, ad_error *error);
void table_free(table_file *table);

size_t table_rows(const table_file *table);
size_t table_inner(const table_file *table); /* rows of one first index of an array of three
                                              * dimensions; else 1 */
size_t table_columns(const table_file *table);
/* Name of a column, 0 <= index < table_columns; belongs to the table. */
const char *table_name(const table_file *table, size_t index);
/* Values [table_rows] of the column of that name, NULL if there is none or it has what is no
 * number; belong to the table. */
const double *table_column(const table_file *table, const char *name);

/* The same of a table that was read as TABLE_MEASURED: AD_OK with NULL if there is no such column.
 * AD_BAD_INPUT, with file, line and byte as above: it has what is no number; `numbers` is
 * TABLE_FINITE, and one is missing. */
ad_status table_find(const table_file *table, const char *name, table_numbers numbers,
                     const double **column, ad_error *error);

/* The same, but the columns named in `words`, which ends with NULL, hold words if the file has
 * them: table_words gives them, table_column NULL. A word has 1 to 63 bytes; in CSV it ends at a
 * comma, there are no quotes. */
ad_status table_read_words(const char *path, table_numbers numbers, const char *const *words,
                           table_file **table, ad_error *error);
const char *const *table_words(const table_file *table, const char *name);

/* The line of a CSV file, from 1, on which a row, from 0, stands; 0 for a row of other files. */
size_t table_line(const table_file *table, size_t row);

/* Whether table_write could put a file there, asked before the work that fills it: of its ending
 * and its folder. AD_BAD_ARGUMENT, AD_IO, AD_NO_MEMORY. */
ad_status table_check_path(const char *path, ad_error *error);

/* A table to be written. */
typedef struct table_source {
    const char *const *names;     /* [ncols] */
    const double *const *columns; /* [ncols], each [nrows] */
    const char *const *const
        *words; /* NULL, or [ncols]: in place of the numbers of a column where
                   not NULL, [nrows]; as names are, but may look like numbers */
    size_t ncols, nrows;
    const char *const *units; /* NULL, or [ncols]: "m", "" of a pure number; CSV leaves them out */
} table_source;

/* A table that is put together column by column. It borrows all that it is given, and stays where
 * it is. */
typedef struct table_build {
    table_source table; /* of these */
    const char *names[TABLE_MAX_COLUMNS], *units[TABLE_MAX_COLUMNS];
    const double *columns[TABLE_MAX_COLUMNS];
    const char *const *words[TABLE_MAX_COLUMNS];
} table_build;

void table_begin(table_build *to, size_t rows);
/* Numbers [rows], or words in their place; unit NULL: the table has none, unless another column
 * has. More than TABLE_MAX_COLUMNS are left out. */
void table_add(table_build *to, const char *name, const char *unit, const double *numbers,
               const char *const *words);

/* Write the table to `path`, atomically (tools/files/file_bytes.h). CSV numbers are the shortest of
 * 15 to 17 digits that read back to the same double; NaN loses its payload in CSV, not in HDF5.
 * Errors: AD_BAD_ARGUMENT (ending, names, more than 4 GiB as .npz), AD_IO (no place for a file),
 * AD_NOT_WRITTEN (the disk is full or fails), AD_NO_MEMORY; a file
 * that was there is then untouched. */
ad_status table_write(const char *path, const table_source *table, ad_error *error);

#endif
