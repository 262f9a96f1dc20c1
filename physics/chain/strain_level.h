/* One mesh on which members are solved (solve_members.h): what they are given there, shapes between
 * its points, and curvature from a coarser one. */
#ifndef PHYSICS_CHAIN_STRAIN_LEVEL_H
#define PHYSICS_CHAIN_STRAIN_LEVEL_H

#include "autodiff/memory.h"
#include "physics/chain/strain_form.h"
#include "physics/local/rod_model.h"

/* Where a shape is wanted: s in an element, from its beginning on, or from a point on. */
typedef struct strain_output {
    int element, from; /* a point of the element; -1: its beginning */
    double magnus[3][GAUSS_STAGES_MAX], interpolate[GAUSS_STAGES_MAX], integrate[GAUSS_STAGES_MAX];
} strain_output;

/* What one mesh has at the points of another: in which of its elements each lies, and of the values
 * at that element's points the polynomial and its integral from the beginning. */
typedef struct strain_link {
    int *element;                         /* [nodes] */
    double (*value)[GAUSS_STAGES_MAX];    /* [nodes] */
    double (*integral)[GAUSS_STAGES_MAX]; /* [nodes], by the width of the element */
} strain_link;

typedef struct strain_level {
    int stages, elements, outputs;
    double *edges, *s; /* [elements + 1], [nodes] */
    strain_form *form;
    lanes *pulls;                       /* [nodes][actuators] at full load */
    lanes displaced[SCENE_TENDONS_MAX]; /* of tensions that are sought: by which they are pulled */
    lanes (*curved)[3], turned[SCENE_TUBES_MAX]; /* [tubes][nodes] k of tubes, at full load */
    lanes (*bent)[2][3];    /* [nodes] u* and the imperfection, which the full load takes away */
    lanes *along, *numbers; /* of laws along the rod and at places: those of the form */
    lanes bare_r[3], bare_q[4], full_r[3], full_q[4]; /* s = 1 of the unstressed rod; held */
    strain_output *output;                            /* [outputs] */
    ad_memory memory;
} strain_level;

/* On `elements` elements between edges, of a rod with open names; s [outputs] within [0, 1].
 * is_rigid: for positions alone. AD_NO_MEMORY, errors of formulas. */
ad_status strain_level_create(const solve_rod *rod, int stages, int elements, const double *edges,
                              bool is_rigid, int outputs, const double *s, strain_level *result,
                              ad_error *error);
void strain_level_free(strain_level *level); /* not itself */

/* Gives LANES members what they have: parameters [LANES][count]. room: doubles for the largest part
 * at all points of LANES members. */
ad_status strain_level_give(strain_level *level, const solve_rod *rod, int count,
                            const double *parameters, double *room, ad_error *error);
size_t strain_level_room(const strain_level *level, const solve_rod *rod);

/* Whether nothing acts but what pulls within the section, and all that a level was given is the
 * same at the points of each element, so that strains are. */
bool strain_level_is_uniform(const strain_level *level);

/* The same in two steps, for derivatives: values of a part, those of strain_level_part_room, and
 * these put where what they are derivatives of is put on another such level: of each lane those by
 * one of `count` parameters, which [LANES]. rod: of solve_rod_create_changes, with which the level
 * was made, so that all else there is 0. */
enum { STRAIN_PARTS = 7 };
bool strain_level_is_open(const solve_rod *rod, int part); /* whether it depends on a parameter */
size_t strain_level_part_room(const strain_level *level, const solve_rod *rod, int part);
ad_status strain_level_find(const strain_level *level, const solve_rod *rod, int part, int count,
                            const double *parameters, double *room, double *values,
                            ad_error *error);
void strain_level_give_changes(strain_level *level, const solve_rod *rod, int count,
                               const int *which, const double *const *values);

/* Loads and pulls at a factor for each lane. */
void strain_level_load(strain_level *level, const lanes *factor);

/* The unstressed rod. */
void strain_level_rest(strain_level *level);

/* AD_NO_MEMORY. */
ad_status strain_link_create(const strain_level *from, const strain_level *to, strain_link *result,
                             ad_error *error);
void strain_link_free(strain_link *link); /* not itself */

/* Curvature and strain from the other mesh. */
void strain_level_refine(const strain_link *link, const strain_level *from, strain_level *to);

/* Positions [nodes of `to`][3] of its points by the other mesh. */
void strain_level_foresee(const strain_link *link, const strain_level *from, const strain_level *to,
                          lanes *positions);

/* Numbers [nodes][width] of one mesh at the points of the other. */
void strain_level_sample(const strain_link *link, const strain_level *from, const strain_level *to,
                         int width, const lanes *numbers, lanes *sampled);

/* values [outputs][SOLVE_MEMBERS_COLUMNS] of one lane after the other, dimensionless. */
void strain_level_evaluate(const strain_level *level, lanes *values);

#endif
