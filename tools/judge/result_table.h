/* Tables of results, as CSV and HDF5: some columns of words, then columns of numbers. And numbers
 * as people read them. */
#ifndef TOOLS_JUDGE_RESULT_TABLE_H
#define TOOLS_JUDGE_RESULT_TABLE_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct result_table {
    const char *const *names; /* [words + numbers], borrowed */
    size_t word_count, number_count;
    size_t rows, capacity;
    const char **words; /* [word_count][capacity], each borrowed until the table is written */
    double *numbers;    /* [number_count][capacity] */
} result_table;

/* An empty table for `capacity` rows. Without memory nothing is kept, and writing says so. */
result_table result_table_create(const char *const *names, size_t words, size_t numbers,
                                 size_t capacity);
void result_table_free(result_table *s);

void result_table_add(result_table *s, const char *const *words, const double *numbers);

/* To FOLDER/NAME.csv and FOLDER/NAME.h5. */
ad_status result_table_write_both(const result_table *s, const char *folder, const char *name,
                                  ad_error *error);

/* Seconds to two or three digits, at most four places; "-" where not finite. An error to two
 * digits, "-" likewise. */
enum { RESULT_TABLE_TEXT = 32 };
const char *result_table_seconds(double seconds, char text[RESULT_TABLE_TEXT]);
const char *result_table_error(double error, char text[RESULT_TABLE_TEXT]);

#endif
