/* Where solutions of equations of one's own are asked for, and what they are there: a table of
 * coordinates, fields and their estimated errors. */
#ifndef TOOLS_PROGRAMS_EQUATION_PLACES_H
#define TOOLS_PROGRAMS_EQUATION_PLACES_H

#include "tools/files/table_file.h"
#include "tools/library/cpinn.h"

typedef struct equation_places {
    const physics_model *model; /* borrowed */
    size_t count;
    double *x[DOMAIN_COORDINATES_MAX]; /* [coordinates][count]; one allocation, of x[0] */
} equation_places;

/* "101x51": so many points along the coordinates in their order, ends included, the last one
 * varying fastest; NULL: the usual ones. AD_BAD_ARGUMENT: no such grid, or too many points. */
ad_status equation_places_grid(equation_places *p, const physics_model *m, const char *grid,
                               ad_error *error);

/* Rows of a table with a column of each coordinate. AD_BAD_INPUT, AD_IO. */
ad_status equation_places_read(equation_places *p, const physics_model *m, const table_file *table,
                               const char *path, ad_error *error);
void equation_places_free(equation_places *p);

/* Writes coordinates, fields, and the estimated errors of fields, error_u, as a table. */
ad_status equation_places_write(const equation_places *p, const cpinn_fit *fit, const char *path,
                                ad_error *error);

/* A table of what is known of some fields at some places. */
typedef struct equation_reference {
    const char *path;
    table_file *table;
    equation_places at;
} equation_reference;

/* AD_BAD_INPUT, AD_IO: no such table. */
ad_status equation_reference_open(const char *path, const physics_model *m,
                                  equation_reference *known, ad_error *error);
void equation_reference_free(equation_reference *known);

/* How far a solution is from it where both are known: the root mean square over that of the field
 * in the table, and the largest difference over the same, of the field that is worst; NULL: no
 * number is. */
typedef struct equation_difference {
    size_t count;
    double relative, largest;
    const char *field;
} equation_difference;

ad_status equation_reference_compare(const equation_reference *known, const cpinn_fit *fit,
                                     equation_difference *difference, ad_error *error);

#endif
