/* What table_file.c and its formats, table_csv.c and so on, share; not for other files. */
#ifndef TOOLS_FILES_TABLE_PARTS_H
#define TOOLS_FILES_TABLE_PARTS_H

#include "tools/files/table_file.h"

#include <stdbool.h>

struct table_file {
    size_t rows, columns;
    size_t inner; /* rows of one index, of an array of three dimensions; else 1 */
    char (*names)[TABLE_MAX_NAME + 1];  /* [columns] */
    double **values;                    /* [columns], each [rows]; NULL for words */
    char (**words)[TABLE_MAX_NAME + 1]; /* [columns], each [rows] or NULL */
    const char ***pointers;             /* [columns], to the words */
    size_t *lines;                      /* [rows], of a CSV file; NULL: of others */
    ad_error *problems; /* [columns], of TABLE_MEASURED: what is no number; of others all AD_OK */
    char *path;         /* as messages have it */
};

/* What to read. */
typedef struct table_wanted {
    const char *path; /* named in messages */
    table_numbers numbers;
    const char *const *words; /* columns of words, ended by NULL; NULL: none */
} table_wanted;

bool table_wants_words(const table_wanted *wanted, const char *name);

/* Turn a column into one of words, all empty, with room for `rows`. */
bool table_hold_words(table_file *table, size_t column, size_t rows);

/* What is wrong with a column's name of `length` bytes, NULL if nothing is. */
const char *table_name_problem(const char *name, size_t length);

/* The same of a word in a column of words. */
const char *table_word_problem(const char *word, size_t length);

/* Room for `columns` columns of `rows` values, names empty; NULL when memory ran out. */
table_file *table_create(const table_wanted *wanted, size_t columns, size_t rows);

/* Whether what is wrong with a column can wait until somebody asks for it; the table keeps it. */
bool table_postpones(const table_wanted *wanted, table_file *table, size_t column,
                     const ad_error *reason);

/* bytes [size] are followed by a zero byte. */
ad_status table_from_csv(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                         table_file **table, ad_error *error);
ad_status table_from_hdf5(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                          table_file **table, ad_error *error);

/* An array is a table of columns c1, c2, ...; of several, each has columns of its name. */
ad_status table_from_npy(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                         table_file **table, ad_error *error);
ad_status table_from_npz(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                         table_file **table, ad_error *error);

ad_status table_from_c3d(const table_wanted *wanted, const unsigned char *bytes, size_t size,
                         table_file **table, ad_error *error);

/* The file as bytes, owned by the caller; AD_NO_MEMORY or AD_IO, without a message. */
ad_status table_to_csv(const table_source *source, unsigned char **bytes, size_t *size);
ad_status table_to_hdf5(const table_source *source, unsigned char **bytes, size_t *size);
ad_status table_to_npz(const table_source *source, unsigned char **bytes, size_t *size);

/* Whether the table stays below the 4 GiB that a zip archive without extensions holds. */
bool table_fits_npz(const table_source *source);

#endif
