/* The rows of history.csv: grown in memory, appended to the file, kept in the checkpoint. */
#ifndef TOOLS_TRAIN_HISTORY_H
#define TOOLS_TRAIN_HISTORY_H

#include "tools/files/checkpoint.h"

#include <stdio.h>

enum { HISTORY_COLUMNS_MAX = 32 };

typedef struct history {
    const char *names[HISTORY_COLUMNS_MAX]; /* static texts */
    int columns;
    double *rows; /* [count][columns] */
    size_t count, capacity;
} history;

void history_free(history *h);

/* Append one row [columns]; AD_NO_MEMORY leaves the history as it was. */
ad_status history_add(history *h, const double *row, ad_error *error);

/* Value of a column in a row; NaN when there is no such column. */
double history_value(const history *h, size_t row, const char *column);

/* One line of CSV, `row` < count; -1 for the line of names. NaN: an empty field. */
void history_print(const history *h, long row, FILE *file);

void history_put(const history *h, checkpoint *file);
ad_status history_get(history *h, const checkpoint *file, ad_error *error);

/* Value of a column in the last row that a file has; NaN where there is none. */
double history_last(const checkpoint *file, const char *column);

#endif
