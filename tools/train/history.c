#include "tools/train/history.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ITEM "history/table"

void history_free(history *h)
{
    free(h->rows);
    h->rows = NULL;
    h->count = h->capacity = 0;
}

static ad_status make_room(history *h, size_t rows, ad_error *error)
{
    if (rows <= h->capacity) {
        return AD_OK;
    }
    size_t capacity = rows < 64 ? 64 : rows + rows / 2;
    double *larger = realloc(h->rows, capacity * (size_t)h->columns * sizeof *larger);
    if (!larger) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a history of %zu rows", rows);
    }
    h->rows = larger;
    h->capacity = capacity;
    return AD_OK;
}

ad_status history_add(history *h, const double *row, ad_error *error)
{
    ad_status status = make_room(h, h->count + 1, error);
    if (status == AD_OK) {
        memcpy(h->rows + h->count * (size_t)h->columns, row, (size_t)h->columns * sizeof *row);
        h->count++;
    }
    return status;
}

double history_value(const history *h, size_t row, const char *column)
{
    for (int i = 0; i < h->columns; i++) {
        if (strcmp(h->names[i], column) == 0) {
            return h->rows[row * (size_t)h->columns + (size_t)i];
        }
    }
    return NAN;
}

void history_print(const history *h, long row, FILE *file)
{
    for (int i = 0; i < h->columns; i++) {
        const char *end = i + 1 < h->columns ? "," : "\n";
        if (row < 0) {
            fprintf(file, "%s%s", h->names[i], end);
            continue;
        }
        double value = h->rows[(size_t)row * (size_t)h->columns + (size_t)i];
        if (isnan(value)) {
            fputs(end, file);
        } else {
            fprintf(file, "%.10g%s", value, end);
        }
    }
}

void history_put(const history *h, checkpoint *file)
{
    checkpoint_put_table(file, ITEM, h->rows, h->count, (size_t)h->columns, h->names);
}

ad_status history_get(history *h, const checkpoint *file, ad_error *error)
{
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK];
    if (!checkpoint_shape(file, ITEM, &rank, shape) || rank != 2 ||
        shape[1] != (size_t)h->columns) {
        return ad_fail(error, AD_BAD_INPUT, "checkpoint: %s is missing or of another shape", ITEM);
    }
    for (int i = 0; i < h->columns; i++) {
        const char *name = checkpoint_column(file, ITEM, (size_t)i);
        if (!name || strcmp(name, h->names[i]) != 0) {
            return ad_fail(error, AD_BAD_INPUT, "checkpoint: column %d of %s is not %s", i + 1,
                           ITEM, h->names[i]);
        }
    }
    ad_status status = make_room(h, shape[0], error);
    if (status == AD_OK) {
        status = checkpoint_get_doubles(file, ITEM, h->rows, shape[0] * shape[1], error);
    }
    h->count = status == AD_OK ? shape[0] : 0;
    return status;
}

double history_last(const checkpoint *file, const char *column)
{
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK];
    if (!checkpoint_shape(file, ITEM, &rank, shape) || rank != 2 || shape[0] == 0) {
        return NAN;
    }
    size_t numbers = shape[0] * shape[1];
    double *rows = malloc(numbers * sizeof *rows), result = NAN;
    if (rows && checkpoint_get_doubles(file, ITEM, rows, numbers, NULL) == AD_OK) {
        for (size_t c = 0; c < shape[1]; c++) {
            const char *name = checkpoint_column(file, ITEM, c);
            if (name && strcmp(name, column) == 0) {
                result = rows[numbers - shape[1] + c];
            }
        }
    }
    free(rows);
    return result;
}
