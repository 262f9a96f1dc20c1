/* A path of equilibria as a whole: from the unstressed rod on by arc length (static_arc.h), with
 * the places where it turns back and where others cross it, and what is stable of it. */
#ifndef PHYSICS_SOLVE_STATIC_TRACE_H
#define PHYSICS_SOLVE_STATIC_TRACE_H

#include "physics/solve/static.h"
#include "physics/solve/static_path.h"

enum { TRACE_PLACES = 101 }; /* equally spaced along the rod, both ends among them */

typedef struct trace_point {
    double load, arclength; /* arc length of the path, not of the rod */
    int unstable;           /* modes; -1: not asked */
    solution_mark mark;
    double position[TRACE_PLACES][3];
} trace_point;

typedef struct static_trace {
    size_t count, room;
    trace_point *points; /* [count] */
    bool arrived;        /* at the full load; the last point is then there */
    double estimate;     /* of the error of the loads of marks; NaN: none, 1: not resolved */
} static_trace;

/* What a path is followed for: all marks; the equilibrium under the full load, with the first
 * bifurcation alone; or the first mark. */
typedef enum trace_goal { TRACE_WHOLE, TRACE_FULL_LOAD, TRACE_FIRST_MARK } trace_goal;

/* Follows the path of `path` from the unstressed rod to the full load: where the load turns back on
 * the way, on to the next equilibrium under the full load that is stable; without one to the first
 * that is not. settings->branch: at the so many-th bifurcation it leaves for the other path.
 * *result: NULL where the path has no beginning, as for a rod that floats without its loads. *end:
 * the equilibrium under the full load, NULL when not arrived. Adds to the Newton steps of the
 * report. AD_NO_MEMORY, or what the tape says of a formula. */
ad_status static_trace_create(const solve_rod *rod, const solve_settings *settings,
                              const path_shape *path, trace_goal goal, static_trace **result,
                              static_solution **end, solve_report *report, ad_error *error);
void static_trace_free(static_trace *trace);

/* Of the whole path: fills in limit_load, bifurcation_load and snapped of a report. */
void static_trace_report(const static_trace *trace, solve_report *report);

/* Unstable modes of the equilibrium of solution->y under the load of its system, as
 * physics/solve/stability.h counts them; -1: not asked. AD_NO_MEMORY, or what the tape says of a
 * formula. */
ad_status static_unstable(const static_solution *solution, int *count, ad_error *error);

/* The same of a planar scene, with those that leave the plane; where `motion` says planar, and
 * where these cannot be counted, *count stays. */
ad_status static_unstable_in_space(const static_solution *solution, int *count, ad_error *error);

/* Whether the equilibrium under the full load is known not to be stable, as stability_find says,
 * other than by flutter, which no other path evades. */
ad_status static_gives_way(const static_solution *solution, bool *lost, ad_error *error);

#endif
