#include "tools/files/table_shapes.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

const double *table_source_column(const table_source *table, const char *name)
{
    for (size_t k = 0; k < table->ncols; k++) {
        if (strcmp(table->names[k], name) == 0) {
            return table->words && table->words[k] ? NULL : table->columns[k];
        }
    }
    return NULL;
}

/* Rows from `first` on that are of one instant and one member. */
static size_t block(const table_shapes *shapes, size_t first, size_t rows)
{
    size_t end = first + 1;
    while (end < rows && (!shapes->t || shapes->t[end] == shapes->t[first]) &&
           (!shapes->member || shapes->member[end] == shapes->member[first])) {
        end++;
    }
    return end - first;
}

ad_status table_shapes_of(const table_source *table, table_shapes *shapes, ad_error *error)
{
    static const char *const places[] = {"x", "y", "z"};
    table_shapes x = {.s = table_source_column(table, "s"),
                      .t = table_source_column(table, "t"),
                      .member = table_source_column(table, "member")};
    bool placed = true;
    for (int k = 0; k < 3; k++) {
        x.place[k] = table_source_column(table, places[k]);
        placed = placed && x.place[k];
    }
    if (!placed) {
        memset(x.place, 0, sizeof x.place);
    }
    if (table->nrows == 0) {
        return ad_fail(error, AD_BAD_INPUT, "there are no rows; at least one is needed");
    }
    x.points = block(&x, 0, table->nrows);
    for (size_t row = 0; row < table->nrows; row += x.points, x.frames++) {
        if (block(&x, row, table->nrows) != x.points) {
            return ad_fail(error, AD_BAD_INPUT,
                           "rows %zu to %zu are of one instant or member, and the first %zu are; "
                           "allowed: as many points for each",
                           row + 1, row + block(&x, row, table->nrows), x.points);
        }
    }
    *shapes = x;
    return AD_OK;
}

void table_shapes_beside(const char *path, char beside[TABLE_PATH_MAX])
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    snprintf(beside, TABLE_PATH_MAX, "%.*s_shapes.h5",
             (int)(dot ? (size_t)(dot - path) : strlen(path)), path);
}
