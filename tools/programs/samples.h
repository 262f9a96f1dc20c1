/* Shapes that a program asks for: the points (s, t), of a family also the members; and what is
 * answered (tools/library/answer.h), as a table that files and pictures are made of. */
#ifndef TOOLS_PROGRAMS_SAMPLES_H
#define TOOLS_PROGRAMS_SAMPLES_H

#include "autodiff/memory.h"
#include "physics/learn/model.h"
#include "tools/files/table_file.h"
#include "tools/library/answer.h"

typedef struct samples {
    size_t count;       /* points of a shape */
    size_t members;     /* shapes; 0: the one shape of a scene */
    double *s, *t;      /* [count] m, s; one allocation, `s` owns it */
    double *parameters; /* [members, or 1][parameters], owned; NULL: of no family */
    const scene *of;    /* of what is answered: whose columns these are, borrowed; */
    int columns;        /* the first of its model, */
    double *values;     /* [columns][rows], SI units, */
    bool derives;       /* whether wanted are, where who answers has them: */
    double *slopes;     /* [columns][parameters][rows], derivatives of values by parameters; NULL */
    cpinn_answer *said; /* [members], */
    double seconds;     /* that the answers took */
} samples;

/* Points at s = 0, t = 0. AD_NO_MEMORY. */
ad_status samples_make(samples *p, size_t count, ad_error *error);
void samples_free(samples *p);

/* Points of all shapes, one shape after the other. */
size_t samples_rows(const samples *p);

/* Where: by --grid, "NSxNT" or "NS", or by --points, a table with columns s and, in motion, t. */
typedef struct samples_asked {
    const char *grid, *points;
} samples_asked;

/* Points of a file, of a grid from s = 0 to the length and from t = 0 to `until`, or of the usual
 * grid (NULL: 101 points at rest, 51x21 in motion). AD_BAD_ARGUMENT: it is no grid, or too many
 * points; AD_BAD_INPUT with the line: a point outside of the scene, a column that is missing. */
ad_status samples_choose(samples *p, const samples_asked *asked, const char *usual,
                         const scene *scene, double until, ad_error *error);

/* CLI_BAD with one line where both are given, or one of them though nothing `needs` points. */
int samples_check(const char *program, const samples_asked *asked, bool needs);

/* Fills values and, of members, what is said, and slopes where they are wanted. AD_NO_MEMORY,
 * errors of who answers. */
ad_status samples_ask(samples *p, const answer *a, ad_error *error);

/* s, t and the columns, with their units, as a table that borrows them; of members their numbers
 * from 1 come first, and no t at rest. `told`: what is said of members follows, and derivatives. */
typedef struct samples_table {
    table_build of;
    double *numbers;    /* of columns that have one number for each member or point */
    const char **texts; /* source and reason */
    char (*names)[TABLE_MAX_NAME + 1]; /* of derivatives: x_by_pull */
    ad_memory memory;
} samples_table;
ad_status samples_fill(const samples *p, bool told, samples_table *to, ad_error *error);
void samples_table_free(samples_table *to); /* not itself */

/* Write that table, with all that is said (tools/files/table_file.h), or, with a column radius, for
 * ParaView (tools/files/shapes_vtk.h). */
ad_status samples_write(const samples *p, const char *path, ad_error *error);

#endif
