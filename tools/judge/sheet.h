/* Tables of results, as CSV and HDF5: some columns of words, then columns of numbers. And numbers
 * as people read them. */
#ifndef TOOLS_JUDGE_SHEET_H
#define TOOLS_JUDGE_SHEET_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stddef.h>

enum { SHEET_COLUMNS_MAX = 24 };

typedef struct sheet {
    const char *const *names; /* [words + numbers], borrowed */
    size_t word_count, number_count;
    size_t rows, capacity;
    const char **words; /* [word_count][capacity], each borrowed until the sheet is written */
    double *numbers;    /* [number_count][capacity] */
} sheet;

/* An empty sheet for `capacity` rows. Without memory nothing is kept, and writing says so. */
sheet sheet_create(const char *const *names, size_t words, size_t numbers, size_t capacity);
void sheet_free(sheet *s);

void sheet_add(sheet *s, const char *const *words, const double *numbers);

/* To the file `path`; to FOLDER/NAME.csv and FOLDER/NAME.h5. */
ad_status sheet_write(const sheet *s, const char *path, ad_error *error);
ad_status sheet_write_both(const sheet *s, const char *folder, const char *name, ad_error *error);

/* Seconds to two or three digits, at most four places; "-" where not finite. An error to two
 * digits, "-" likewise. */
enum { SHEET_TEXT = 32 };
const char *sheet_seconds(double seconds, char text[SHEET_TEXT]);
const char *sheet_error(double error, char text[SHEET_TEXT]);

#endif
