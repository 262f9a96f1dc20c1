/* Shapes that a program asks for: the points (s, t), of a family also the members; and what is
 * answered (tools/library/answer.h), as a table that files and pictures are made of. */
#ifndef TOOLS_PROGRAMS_SAMPLES_H
#define TOOLS_PROGRAMS_SAMPLES_H

#include "physics/model.h"
#include "tools/files/table_file.h"
#include "tools/library/answer.h"

typedef struct samples {
    size_t count;       /* points of a shape */
    size_t members;     /* shapes; 0: the one shape of a scene */
    double *s, *t;      /* [count] m, s; one allocation, `s` owns it */
    double *parameters; /* [members][parameters], owned */
    const scene *of;    /* of what is answered: whose columns these are, borrowed; */
    int columns;        /* the first of its model, */
    double *values;     /* [columns][rows], SI units, */
    cpinn_answer *said; /* [members], */
    double seconds;     /* that the answers took */
} samples;

/* Points at s = 0, t = 0. AD_NO_MEMORY. */
ad_status samples_make(samples *p, size_t count, ad_error *error);
void samples_free(samples *p);

/* Points of all shapes, one shape after the other. */
size_t samples_rows(const samples *p);

/* The points of --grid, "NSxNT" or "NS", NULL for the default, from s = 0 to the length and from
 * t = 0 to `until`. AD_BAD_ARGUMENT: it is neither, or too many points. */
ad_status samples_of_grid(samples *p, const char *grid, const scene *scene, double until,
                          ad_error *error);

/* The points of a table with columns s and, in motion, t, up to `until`. AD_BAD_INPUT with the
 * line: a point outside of the scene, a column that is missing. */
ad_status samples_of_file(samples *p, const char *path, const scene *scene, double until,
                          ad_error *error);

/* Fills values and, of members, what is said. AD_NO_MEMORY, errors of who answers. */
ad_status samples_ask(samples *p, const answer *a, ad_error *error);

/* s, t and the columns, with their units, as a table that borrows them; of members their numbers
 * from 1 come first, and no t at rest. `told`: what is said of members follows. */
enum { SAMPLES_COLUMNS_MAX = 3 + MODEL_COLUMNS_MAX + 5 };
typedef struct samples_table {
    table_source table; /* of these */
    const char *names[SAMPLES_COLUMNS_MAX], *units[SAMPLES_COLUMNS_MAX];
    const double *columns[SAMPLES_COLUMNS_MAX];
    const char *const *words[SAMPLES_COLUMNS_MAX];
    double *numbers;    /* of columns that have one number for each member or point */
    const char **texts; /* source and reason */
} samples_table;
ad_status samples_fill(const samples *p, bool told, samples_table *to, ad_error *error);
void samples_table_free(samples_table *to); /* not itself */

/* Write that table, with all that is said (tools/files/table_file.h), or, with a column radius, for
 * ParaView (tools/files/shapes_vtk.h). */
ad_status samples_write(const samples *p, const char *path, ad_error *error);

#endif
