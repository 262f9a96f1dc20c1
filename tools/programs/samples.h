/* The points (s, t) at which a program is asked for a solution, and what the solution is there. */
#ifndef TOOLS_PROGRAMS_SAMPLES_H
#define TOOLS_PROGRAMS_SAMPLES_H

#include "autodiff/error.h"
#include "physics/model.h"
#include "tools/files/table_file.h"

typedef struct samples {
    size_t count;
    int columns;    /* the first of the scene's model */
    double *s, *t;  /* [count] m, s; one allocation, `s` owns it */
    double *values; /* [columns][count], SI units */
} samples;

/* Room for `count` points; zeros. AD_NO_MEMORY. */
ad_status samples_make(samples *p, size_t count, int columns, ad_error *error);
void samples_free(samples *p);

/* The points of --grid, "NSxNT" or "NS", NULL for the default, from s = 0 to the length and from
 * t = 0 to `until`. AD_BAD_ARGUMENT: it is neither, or too many points. */
ad_status samples_of_grid(samples *p, const char *grid, const scene *scene, double until,
                          int columns, ad_error *error);

/* The points of a table with columns s and, in motion, t, up to `until`. AD_BAD_INPUT with the
 * line: a point outside of the scene, a column that is missing. */
ad_status samples_of_file(samples *p, const char *path, const scene *scene, double until,
                          int columns, ad_error *error);

/* s, t and the columns, with their units, as a table that borrows them. */
typedef struct samples_table {
    const char *names[2 + MODEL_COLUMNS_MAX], *units[2 + MODEL_COLUMNS_MAX];
    const double *columns[2 + MODEL_COLUMNS_MAX];
    table_source table; /* of these */
} samples_table;
void samples_fill(const samples *p, const scene *scene, samples_table *result_table);

/* Write s, t and the columns, with their units, as a table (tools/files/table_file.h), or, with a
 * column radius, for ParaView (tools/files/shapes_vtk.h). */
ad_status samples_write(const samples *p, const scene *scene, const char *path, ad_error *error);

#endif
