/* One mesh on which members are solved (members.h): what they are given there, shapes between its
 * points, and curvature from a coarser one. */
#ifndef PHYSICS_SOLVE_STRAIN_LEVEL_H
#define PHYSICS_SOLVE_STRAIN_LEVEL_H

#include "physics/solve/members.h"
#include "physics/solve/strain_form.h"

/* Where a shape is wanted: s in an element, from its beginning on, or from a point on. */
typedef struct strain_output {
    int element, from; /* a point of the element; -1: its beginning */
    double magnus[3][GAUSS_STAGES_MAX], interpolate[GAUSS_STAGES_MAX], integrate[GAUSS_STAGES_MAX];
} strain_output;

typedef struct strain_level {
    int stages, elements, outputs;
    double *edges, *s; /* [elements + 1], [nodes] */
    strain_form *form;
    lanes (*loads)[4][3]; /* [nodes] at full load, as the next */
    lanes *pulls;         /* [nodes][actuators] */
    lanes (*jumps)[4][3]; /* [elements + 1] */
    lanes end_force[3], end_moment[3];
    strain_output *output; /* [outputs] */
    double (
        *prolong)[GAUSS_STAGES_MAX]; /* [nodes] from the points of an element of a coarser one */
    double (*integral)[GAUSS_STAGES_MAX]; /* the same of integrals from its beginning */
    int *parent;                          /* [nodes] that element */
} strain_level;

/* On `elements` elements between edges, of a rod with open names; s [outputs] within [0, 1].
 * `from`: the coarser one; NULL: none. is_rigid: for positions alone. AD_NO_MEMORY, errors of
 * formulas. */
ad_status strain_level_create(const solve_rod *rod, int stages, int elements, const double *edges,
                              const strain_level *from, bool is_rigid, int outputs, const double *s,
                              strain_level *result, ad_error *error);
void strain_level_free(strain_level *x); /* not x itself */

/* Gives LANES members what they have: parameters [LANES][count]. room: doubles for the largest part
 * at all points of LANES members. */
ad_status strain_level_give(strain_level *x, const solve_rod *rod, int count,
                            const double *parameters, double *room, ad_error *error);
size_t strain_level_room(const strain_level *x, const solve_rod *rod);

/* Loads and pulls at a factor for each lane. */
void strain_level_load(strain_level *x, const lanes *factor);

/* The unstressed rod. */
void strain_level_rest(strain_level *x);

/* Curvature and strain from the coarser one. */
void strain_level_refine(strain_level *x, const strain_level *from);

/* Positions [nodes][3] of its points by the coarser one. */
void strain_level_foresee(const strain_level *x, const strain_level *from, lanes *positions);

/* values [outputs][SOLVE_MEMBERS_COLUMNS] of one lane after the other, dimensionless. */
void strain_level_evaluate(const strain_level *x, lanes *values);

#endif
