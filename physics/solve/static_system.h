/* The static rod on a mesh: collocation at Gauss points of elements (elements.h), where a path from
 * the unstressed rod has arrived. */
#ifndef PHYSICS_SOLVE_STATIC_SYSTEM_H
#define PHYSICS_SOLVE_STATIC_SYSTEM_H

#include "autodiff/memory.h"
#include "physics/local/static_rod.h"
#include "physics/solve/elements.h"

/* Where the path from the unstressed rod to the loaded one has arrived. */
typedef struct static_path {
    double load;         /* of the loads, and of the way of held ends from the unstressed shape */
    double ahead;        /* share of that way that they have gone before the loads */
    double imperfection; /* factor of the one that the scene names */
    double perturbation; /* body force per length */
    int director;        /* along d1 (0) or d2 (1) */
    double spring;       /* at the ends of a rod whose rotation none of them holds; EI/L */
    double twist_spring; /* the same about the tangent alone */
    double plane_spring; /* the same about the axes in the plane of the tangent and the director */
    double stretch;      /* axial compliance added; L^2/EI */
} static_path;

_Static_assert((int)STATIC_ROWS_MAX == (int)ELEMENTS_ROWS_MAX, "the same matrices");

typedef struct static_system {
    const solve_rod *rod;
    solve_elements mesh;
    solve_rod_points given; /* at the points of the mesh; sections with the stretch of the path */
    double *axial;          /* [points] axial compliance without it */
    acting perturbed;       /* what acts along the rod, and then a follower force */
    static_end full[2];     /* at full load */
    static_end bare[2];     /* unstressed */
    static_end ends[2];     /* where the path is */
    double turn[3];         /* rotation vector of the end s = 1 at full load, world; 0: none */
    double twist;           /* of the same end about its d3, beyond full[1]; rad */
    double (*chords)[3];    /* [CHORDS] of the unstressed rod, in turn; NULL without a turn */
    double arc[3];          /* their sum, turned in proportion to s */
    int *jump;              /* [elements + 1] at each edge, index of the rod's; -1: none */
    static_jump *jumps;     /* [jumps of the rod] where the path is */
    static_path path;
    double tensions[SOLVE_ACTUATORS_MAX]; /* of tendons whose length is given, by EI/L^2 */
    /* [elements][stages + 2][frictions of the rod]: angles that tendons with friction have turned
     * at the beginning of an element, at its points, at its end (static_friction.h) */
    double *angles;
    double *before; /* of these the logarithms of tensions by EI/L^2 that they had in */
    const struct static_system *earlier; /* that equilibrium; NULL: they had none */
    double *rate;                        /* [stages][rows] of an element */
    ad_memory memory;
} static_system;

/* Of held ends, and of what springs pull to. */
static inline double way_of(const static_path *path)
{
    return path->load + (1 - path->load) * path->ahead;
}

/* Elements between edges [elements + 1] from 0 to 1, each place of rod->jumps among them; the rod
 * must outlive the system. */
ad_status static_system_create(const solve_rod *rod, int stages, int elements, const double *edges,
                               static_system **result, ad_error *error);
void static_system_free(static_system *system);

/* y of the unstressed rod; of a manufactured scene its solution. */
ad_status static_system_guess(const static_system *system, double *y, ad_error *error);

/* y [stages + 2][rows] of an element: with which it begins, beyond what acts there; at its points
 * and its end. */
void static_system_values(const static_system *system, const double *y, int element,
                          double *values);

void static_system_set(static_system *system, const static_path *path);

/* Of the `point`th of actuators [..][those of the rod], at s, where the path is. */
solve_actuation static_system_actuation(const static_system *system,
                                        const solve_actuator *actuators, size_t point, double s);

/* What is given at the i-th of some points, s, where the path is; the section is theirs. And at the
 * i-th of the mesh. */
static_point static_system_given(const static_system *system, const solve_rod_points *given,
                                 size_t i, double s);
static_point static_system_point(const static_system *system, size_t i);

/* excess [actuators of the rod]: by how much a tendon whose length is given is longer at y, 0 of
 * the others. */
void static_system_excess(const static_system *system, const double *y, double *excess);

/* Left minus right sides [unknowns] of the equations of the mesh. */
void static_system_residual(static_system *system, const double *y, double *residual);

/* y_s [n][rows] for y at any s [n] in [0, 1], where the path is. */
ad_status static_system_rates(const static_system *system, size_t n, const double *s,
                              const double *y, double *rate, ad_error *error);

/* Derivatives at y, in the mesh. */
void static_system_linearise(static_system *system, const double *y);

#endif
