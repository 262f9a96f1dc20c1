/* A rod in motion on one mesh: which elements, and which way through time. */
#ifndef PHYSICS_SOLVE_MOTION_MESH_H
#define PHYSICS_SOLVE_MOTION_MESH_H

#include "physics/solve/integrate.h"

/* Where elements have to end: s [count], ascending, within (0, 1). */
typedef struct motion_places {
    int count;
    double *place;
    const char *unresolved; /* a formula's key, as that of scene_panels; NULL: none */
} motion_places;

/* Where what the rod is made of, its rest shape or its loads jump, and where something acts; around
 * what is narrow but smooth they lie close together.
 * AD_NO_MEMORY; the result is freed by the caller with free(places->place). */
ad_status motion_places_of(const solve_rod *rod, motion_places *places, ad_error *error);

/* Elements that have together at least so many intervals between nodes, none across a place. lock:
 * as motion_create. */
ad_status motion_mesh(const solve_rod *rod, const motion_places *places, double lock, int intervals,
                      motion **result, ad_error *error);

/* Through which times, and what is found there. */
typedef struct motion_record {
    size_t count;
    double *times;          /* [count] */
    double *states;         /* [count][nodes][MOTION_ROWS] */
    solve_energy *energies; /* [count] */
} motion_record;

/* How finely time is divided. */
typedef struct motion_steps {
    double tolerance; /* of adaptive steps */
    double shortened; /* steps that are composed of flows: so much shorter than the longest */
    bool follows;     /* every vibration of the mesh, where implicit steps took too long; set */
    bool is_composed; /* the last steps were: they shorten with the mesh; set */
    double work;      /* of the last, in forces on one node, which take some 40 ns; set */
} motion_steps;

/* The implicit method has as many steps as cost what following all vibrations would; where they do
 * not suffice that it is, from then on. So no choice costs more than twice the better one. Adds
 * steps to the report, and sets its time. Errors of motion_integrate. */
ad_status motion_go(motion *m, motion_steps *by, const motion_record *to, solve_report *report,
                    ad_error *error);

#endif
