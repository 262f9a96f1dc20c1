/* Shared by static.c, static_guess.c, static_trace.c and static_walk.c; not for others. */
#ifndef PHYSICS_SOLVE_STATIC_INTERNAL_H
#define PHYSICS_SOLVE_STATIC_INTERNAL_H

#include "physics/solve/static.h"
#include "physics/solve/static_path.h"

/* A mesh of the rod and the equilibrium on it. */
struct static_solution {
    const solve_rod *rod;
    static_system *system;
    static_newton *newton;
    double *y; /* [unknowns] */
};

/* A mesh with edges [elements + 1]; y is not filled in. AD_NO_MEMORY, or what the tape says of a
 * formula. */
ad_status static_create(const solve_rod *rod, int stages, int elements, const double *edges,
                        static_solution **result, ad_error *error);

/* Halves elements whose last term is above the threshold, or all when there are none. Returns how
 * many elements there are then; edges [that + 1], allocated; NULL: no memory. */
int static_halve(const static_solution *solution, double threshold, double **edges);

/* The first mesh, with edges where something jumps: as many nodes as asked for, or enough for the
 * waves that the loads make and for all that is given along the rod. Fills in report->unresolved.
 */
ad_status static_begin(const solve_rod *rod, const solve_settings *settings, const path_shape *path,
                       static_solution **result, solve_report *report, ad_error *error);

/* From the guess of the settings to the equilibrium next to it, at full load; *found: there is
 * one, in solution->y. AD_NO_MEMORY, errors of the guess. */
ad_status static_from_guess(static_solution *solution, const solve_settings *settings,
                            const path_shape *path, bool *found, solve_report *report,
                            ad_error *error);

#endif
