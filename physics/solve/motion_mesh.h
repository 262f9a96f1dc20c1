/* A rod in motion on one mesh: which elements, and which way through time. */
#ifndef PHYSICS_SOLVE_MOTION_MESH_H
#define PHYSICS_SOLVE_MOTION_MESH_H

#include "physics/local/quadrature.h"
#include "physics/solve/integrate.h"

/* Elements that have together at least so many intervals between nodes, none across a place, and
 * halved where what is given along the rod is so narrow that they would miss more of it than the
 * tolerance. lock: as motion_create. */
ad_status motion_mesh(const solve_rod *rod, const solve_quadrature *places, double lock,
                      double tolerance, int intervals, motion **result, ad_error *error);

/* Through which times, and what is found there. */
typedef struct motion_record {
    size_t count;
    double *times;          /* [count] */
    double *states;         /* [count][motion_size] */
    solve_energy *energies; /* [count] */
} motion_record;

/* How finely time is divided. */
typedef struct motion_steps {
    double tolerance; /* of adaptive steps */
    double shortened; /* steps that are composed of flows: so much shorter than the longest */
    const solve_events *events; /* what no step may pass */
    solve_clock clock;          /* the last steps; `ends` is freed by the owner; set */
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
