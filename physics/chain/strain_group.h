/* LANES members at a time: following their loads on a coarse mesh, then one step on finer ones,
 * which says what the coarser was worth (solve_members.h). */
#ifndef PHYSICS_CHAIN_STRAIN_GROUP_H
#define PHYSICS_CHAIN_STRAIN_GROUP_H

#include "autodiff/memory.h"
#include "physics/chain/solve_members.h"
#include "physics/chain/strain_level.h"

enum { STRAIN_LEVELS_MAX = 10 };

/* Positions are taken from a mesh so many beyond that of the equations: r between points of a mesh
 * that has u to 1e-6 may be known to 1e-5. */
enum { STRAIN_BEYOND = 2 };

typedef struct strain_group {
    solve_rod *rod;
    int count; /* of parameters */
    double tolerance;
    bool is_uniform;                       /* strains are the same all along an element */
    int levels, solved;                    /* solved: of them, those with equations */
    strain_level level[STRAIN_LEVELS_MAX]; /* from coarse to fine */
    strain_link link[STRAIN_LEVELS_MAX];   /* to each from the one before */
    int modes;                             /* the level on which curvature is given and taken, */
    strain_link sample[STRAIN_LEVELS_MAX]; /* to it from each, */
    strain_link beyond, back;              /* and from it to the one that has its positions */
    double *parameters;                    /* [LANES][count] */
    double *room;
    lanes *start, *before; /* [3 nodes] of a path: where it goes on from, and how it came there */
    lanes *placed, *other; /* [3 nodes + 3] positions before a step, */
    double *outputs, *each, *growth; /* [LANES][outputs] s, over the length, parameters [count] for
                                      * each, and growth there */
    lanes *values;                   /* [outputs][SOLVE_MEMBERS_COLUMNS] */
    ad_memory memory;
} strain_group;

/* How many numbers a member has at a point: its curvature, and the torsions of its tubes, these
 * over the scale of bending stiffness; and the k-th. */
static inline int strain_group_width(const strain_group *group)
{
    return 3 + group->rod->tubes;
}

static inline lanes *strain_number(const strain_form *form, int node, int k)
{
    return k < 3 ? &form->at[node].u[k] : &form->tubes[k - 3].torsion[node];
}

/* Meshes between edges [elements + 1] within [0, 1], for shapes at s [outputs] there;
 * own_curvature: as of solve_members_settings. The rod is the group's from then on, also after an
 * error. AD_NO_MEMORY, errors of formulas. */
ad_status strain_group_create(solve_rod *rod, int count, double tolerance, bool own_curvature,
                              int elements, const double *edges, int outputs, const double *s,
                              strain_group **result, ad_error *error);
void strain_group_free(strain_group *group);

/* Curvature is given and taken on this level, 0 < level < solved. AD_NO_MEMORY. */
ad_status strain_group_choose(strain_group *group, int modes, ad_error *error);

/* `members` of them, at most LANES: as solve_members_curvature and solve_members_refine. */
ad_status strain_group_solve(strain_group *group, size_t members, const double *parameters,
                             double *values, double *curvature, solve_member *results,
                             ad_error *error);
ad_status strain_group_refine(strain_group *group, size_t members, const double *parameters,
                              const double *curvature, int steps, double *values, double *refined,
                              solve_answer *answers, ad_error *error);

/* ---- for strain_answer.c, strain_jacobian.c ------------------------------------------------ */

/* Where members are fewer than lanes, all of them again. */
ad_status strain_group_parameters(strain_group *group, size_t members, const double *parameters,
                                  ad_error *error);

/* The level on which curvature is given has that of these members under the whole load, and forces
 * that are sought as far as these are known without a step; and the finer one its shape. */
ad_status strain_group_take(strain_group *group, size_t members, const double *parameters,
                            const double *curvature, ad_error *error);
void strain_group_place(strain_group *group);

/* Newton's step in `right`, and its largest change of curvature, of no number where there is none;
 * of lanes that are left out it is 0. */
void strain_group_step(strain_form *form, const bool *taken, lanes *length);
void strain_group_measure(const strain_form *form, lanes *length);

/* Positions [3 nodes + 3] of the points and the end; how far [LANES] each rod is from such, at its
 * points and, of what has `more`, at its end: `moved` becomes that if it is less. */
void strain_group_keep(const strain_form *form, lanes *to);
void strain_group_compare(const strain_form *form, const lanes *before, bool more, double *moved);

/* group->values, of a level, in SI; and those of one lane. */
void strain_group_evaluate(strain_group *group, int k);
void strain_group_put(const strain_group *group, int lane, double *values);

#endif
