/* A family of rods at rest as C: a network that says the curvature of a member, the equation that
 * polishes it, the shape that follows. What cpinn-export writes of a run of the strain form. */
#ifndef TOOLS_PROGRAMS_EXPORT_FAMILY_H
#define TOOLS_PROGRAMS_EXPORT_FAMILY_H

#include "physics/strain.h"

#include <stdio.h>

typedef struct export_family {
    const char *name;  /* a C identifier */
    const char *about; /* of the comment of the header: a few words */
    const scene *open; /* with parameters that have ranges */
    strain_mesh mesh;  /* of the curvature */
    int places;        /* of the shape */
    const double *s;   /* [places], ascending, of the length; the last one 1 */
    /* Records the curvature times the length [3][nodes], at coordinates x [parameters], 0 to 1 over
     * their ranges; with `weights`, its parameters. */
    ad_value (*network)(const void *context, ad_tape *tape, const ad_value *x);
    const void *context;
    const double *weights;
    double mesh_error; /* m, of equilibria on the mesh: comes to each distance */
    size_t workspace;  /* numbers of the functions; by export_family_write_source, as the next */
    int state;         /* numbers of the state of the rod */
    bool follows;      /* forces follow the rod */
    /* Of the self-test: members, their curvature times the length after a step from the network's,
     * and positions of their tips then, m. */
    int members;
    const double *parameters, *polished, *tips; /* [members][parameters], [3 nodes], [3] */
} export_family;

enum { EXPORT_FAMILY_COLUMNS = 19 };

/* Texts of the C: lines, NULL at the end. */
extern const char *const export_family_types[], *const export_family_functions[];
extern const char *const export_family_selftest[];

/* NAME.c, and then NAME.h and NAME_selftest.c. AD_BAD_ARGUMENT: strain_check; AD_NO_MEMORY. */
ad_status export_family_write_source(export_family *x, FILE *file, ad_error *error);
void export_family_write_header(const export_family *x, FILE *file);
void export_family_write_selftest(const export_family *x, FILE *file);

#endif
