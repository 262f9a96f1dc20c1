/* Shapes of a rod in a table: rows in blocks, one for each instant (column t) or member (column
 * member), all with the same number of points, and the columns x, y, z of where they are. */
#ifndef TOOLS_FILES_TABLE_SHAPES_H
#define TOOLS_FILES_TABLE_SHAPES_H

#include "tools/files/table_file.h"

typedef struct table_shapes {
    size_t frames, points;  /* blocks, and rows of each */
    const double *s, *t;    /* columns [frames points]; NULL: there is none */
    const double *member;   /* the same */
    const double *place[3]; /* x, y, z; all NULL: there are none */
} table_shapes;

/* The column of that name; NULL: there is none, or it holds words. */
const double *table_source_column(const table_source *table, const char *name);

/* AD_BAD_INPUT: no rows, or blocks of different size; a message without the file's name. */
ad_status table_shapes_of(const table_source *table, table_shapes *shapes, ad_error *error);

enum { TABLE_PATH_MAX = 4200 };

/* "NAME_shapes.h5" of "NAME.csv": where shapes of a table stand that has other rows. */
void table_shapes_beside(const char *path, char beside[TABLE_PATH_MAX]);

#endif
