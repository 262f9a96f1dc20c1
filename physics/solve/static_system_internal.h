/* What the files of the static system share: making it and its path (static_system.c), its
 * equations and their derivatives (static_equations.c). Not for others. */
#ifndef PHYSICS_SOLVE_STATIC_SYSTEM_INTERNAL_H
#define PHYSICS_SOLVE_STATIC_SYSTEM_INTERNAL_H

#include "physics/solve/static_system.h"

#include <sundials/sundials_band.h>

typedef double jacobian[STATIC_ROWS_MAX][STATIC_ROWS_MAX];

struct static_system {
    const solve_rod *rod;
    gauss_rule rule;
    int elements, stages;
    int rows, start_rows, end_rows; /* of y, of the conditions at s = 0, 1 */
    int lower, above;          /* diagonals of the band below, and above with those of pivoting */
    double *edges;             /* [elements + 1] */
    double *points;            /* [elements][stages], s */
    solve_section *sections;   /* the same points; with the stretch of the path */
    double *axial;             /* [elements][stages] axial compliance without it */
    solve_rest *rest;          /* the same points */
    acting perturbed;          /* what acts along the rod, and then a follower force */
    double *along;             /* [elements][stages][numbers of what acts along it] */
    solve_actuator *actuators; /* [elements][stages][those of the rod], at full load */
    static_end full[2];        /* at full load */
    static_end bare[2];        /* unstressed */
    static_end ends[2];        /* where the path is */
    double turn[3];            /* rotation vector of the end s = 1 at full load, world; 0: none */
    double twist;              /* of the same end about its d3, beyond full[1]; rad */
    double (*chords)[3];       /* [CHORDS] of the unstressed rod, in turn; NULL without a turn */
    double arc[3];             /* their sum, turned in proportion to s */
    int *jump;                 /* [elements + 1] at each edge, index of the rod's; -1: none */
    static_jump *jumps;        /* [jumps of the rod] where the path is */
    static_path path;
    double tensions[SOLVE_ACTUATORS_MAX]; /* of tendons whose length is given */
    /* [elements][stages + 2][frictions of the rod]: angles that tendons with friction have turned
     * at the beginning of an element, at its points, at its end (static_friction.h) */
    double *angles;
    double *rate;     /* [elements][stages][rows] */
    jacobian *by_y;   /* [elements][stages] */
    double *factor;   /* [elements][inner][inner], column-major */
    int *pivots;      /* [elements][inner] */
    double *by_start; /* [elements][rows][inner]: how the inner y follow the start */
    double *inner;    /* [elements][inner] */
    jacobian *across; /* [elements] of y beyond the edge where an element begins */
    double start[STATIC_END_ROWS_MAX][STATIC_ROWS_MAX], end[STATIC_END_ROWS_MAX][STATIC_ROWS_MAX];
    realtype **band; /* of y at the edges */
    sunindextype *band_pivots;
    double *right; /* [elements + 1][rows] */
};

/* Of held ends, and of what springs pull to. */
static inline double way_of(const static_path *path)
{
    return path->load + (1 - path->load) * path->ahead;
}

static inline size_t inner_rows(const static_system *system)
{
    return (size_t)(system->stages * system->rows);
}

static inline double width(const static_system *system, int element)
{
    return system->edges[element + 1] - system->edges[element];
}

/* Index of the y at edge `element`; the inner ones of the element follow. */
static inline size_t edge(const static_system *system, int element)
{
    return (size_t)element * (inner_rows(system) + (size_t)system->rows);
}

/* What is given at the i-th of the points. */
static_point static_system_point(const static_system *system, size_t i);

#endif
