/* LANES members at a time: following their loads on a coarse mesh, then one step on finer ones,
 * which says what the coarser was worth (members.h). */
#ifndef PHYSICS_SOLVE_STRAIN_GROUP_H
#define PHYSICS_SOLVE_STRAIN_GROUP_H

#include "physics/solve/strain_level.h"

enum { STRAIN_LEVELS_MAX = 7 };

typedef struct strain_group {
    solve_rod *rod;
    int count; /* of parameters */
    double tolerance;
    bool has_energy;                       /* all loads do: the matrix is that of an energy */
    int levels, solved;                    /* solved: of them, those with equations */
    strain_level level[STRAIN_LEVELS_MAX]; /* from coarse to fine */
    double *parameters;                    /* [LANES][count] */
    double *room;
    lanes *start, *before; /* [3 nodes] of a path: where it goes on from, and how it came there */
    lanes *placed;         /* [3 nodes + 3] positions before a step */
    lanes *values;         /* [outputs][SOLVE_MEMBERS_COLUMNS] */
} strain_group;

/* Meshes between edges [elements + 1] within [0, 1], for shapes at s [outputs] there. The rod is
 * the group's from then on, also after an error. AD_NO_MEMORY, errors of formulas. */
ad_status strain_group_create(solve_rod *rod, bool has_energy, int count, double tolerance,
                              int elements, const double *edges, int outputs, const double *s,
                              strain_group **result, ad_error *error);
void strain_group_free(strain_group *x);

/* `members` of them, at most LANES: as solve_members_solve. */
ad_status strain_group_solve(strain_group *x, size_t members, const double *parameters,
                             double *values, solve_member *results, ad_error *error);

#endif
