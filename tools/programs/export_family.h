/* A family of rods at rest as C: a network that says the curvature of a member, the equation that
 * polishes it, the shape that follows. What cpinn-export writes of a run of the strain form. */
#ifndef TOOLS_PROGRAMS_EXPORT_FAMILY_H
#define TOOLS_PROGRAMS_EXPORT_FAMILY_H

#include "physics/strain.h"

#include <stdio.h>

typedef struct export_family {
    const char *name;                   /* a C identifier */
    const char *about;                  /* of the comment of the header: a few words */
    const scene *open;                  /* with parameters that have ranges */
    strain_mesh mesh;                   /* of the curvature */
    bool single;                        /* float in place of double */
    int places;                         /* of the shape */
    const double *s;                    /* [places], ascending, of the length; the last one 1 */
    int columns, which[STRAIN_COLUMNS]; /* of the shape, of strain_rod_columns */
    /* Records the curvature times the length [3][nodes], at coordinates x [parameters], 0 to 1 over
     * their ranges; with `weights`, its parameters. */
    ad_value (*network)(const void *context, ad_tape *tape, const ad_value *x);
    const void *context;
    const double *weights;
    double mesh_error; /* m, of equilibria on the mesh: comes to each distance */
    size_t workspace;  /* numbers of the functions; by export_family_write_source, as the next */
    int state;         /* numbers of the state of the rod */
    int forces, held;  /* that are sought before and after the curvature */
    bool follows;      /* forces follow the rod */
    bool placed;       /* a law depends on the position, or the end is held */
    /* Of the self-test: members with their parameters, float numbers where `single`; the curvature
     * times the length by the network, and after `steps`; tips then and their derivatives. */
    int members, steps;
    const double *parameters, *curvature, *polished; /* [members][parameters], [3 nodes] twice */
    const double *tips, *jacobian;                   /* [columns], [columns][parameters] */
    double scale[STRAIN_COLUMNS];                    /* of each of the columns */
    /* Differences from these that cc has measured, by the scales: of the curvature by the network
     * and after a step, then of each column and its derivatives. NaN: not measured. */
    const double *values, *derivatives; /* [1 + columns] */
} export_family;

/* Texts of the C: lines, NULL at the end. */
extern const char *const export_family_types[], *const export_family_functions[];
extern const char *const export_family_selftest[];

/* NAME.c, and then NAME.h and NAME_selftest.c. AD_BAD_ARGUMENT: strain_check; AD_NO_MEMORY. */
ad_status export_family_write_source(export_family *x, FILE *file, ad_error *error);
void export_family_write_header(const export_family *x, FILE *file);
void export_family_write_selftest(const export_family *x, FILE *file);

#endif
