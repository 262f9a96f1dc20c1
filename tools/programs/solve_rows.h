/* cpinn-solve --rows: rows of commands in their order. */
#ifndef TOOLS_PROGRAMS_SOLVE_ROWS_H
#define TOOLS_PROGRAMS_SOLVE_ROWS_H

#include "physics/solve/rows.h"
#include "tools/programs/samples.h"

typedef struct rows_solved {
    size_t rows, reached; /* reached: under the whole load */
    double estimate;      /* the largest of them, over the length */
} rows_solved;

/* Solves the rows of a table, a column for each parameter, at the points of `shapes`, and fills
 * these, and a verdict whose sentences name the first row that they are of. Errors of
 * train_members_read and solve_rows. */
ad_status solve_rows_run(const scene *open, const char *path, const solve_settings *settings,
                         samples *shapes, rows_solved *solved, verdict *verdict, ad_error *error);

#endif
