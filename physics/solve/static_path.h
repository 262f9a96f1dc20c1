/* The path of equilibria from the unstressed rod to the loaded one: what grows along it, and
 * following it step by step in the load. */
#ifndef PHYSICS_SOLVE_STATIC_PATH_H
#define PHYSICS_SOLVE_STATIC_PATH_H

#include "physics/solve/solve.h"
#include "physics/solve/static_newton.h"

/* How far a solution may be off its guess, in position and quaternion: more could be another
 * equilibrium. */
static const double PATH_OFF_MAX = 0.4;

/* A path with parameter first .. last: from -1 to 0 an imperfection grows, to 1 the loads, and it
 * goes away again; beyond that the perturbation does. */
typedef struct path_shape {
    double first, last, perturbation, stretch;
    bool traced;    /* past limit points, along a branch or from a guess: not where the load leads
                     * by itself */
    double longest; /* step */
    bool may_buckle;
    bool may_snap;         /* held at both ends and bent by its loads or its rest shape */
    bool known;            /* from a manufactured shape, at full load */
    bool spins, twists;    /* no end holds the rotation; and a round, straight rod may also twist */
    bool twisted;          /* an end is: the ends bend the rod first, from -1 to 0 */
    bool planar, squeezed; /* stays in a plane; both ends hold the position */
    int director;
    double size;       /* of the loads: what turns the rod by so many radians */
    double turn;       /* of a held end, rad; counted apart, as the rod turns with it */
    double wavenumber; /* of the solution */
} path_shape;

/* Of a scene. AD_NO_MEMORY, or what the tape says of a formula. */
ad_status static_path_shape(const solve_rod *rod, const solve_settings *settings, path_shape *path,
                            ad_error *error);

static_path static_path_at(const path_shape *path, double parameter);

/* The same rod under a share of its loads, with nothing added that would change its equilibria: no
 * stretch, and springs only against what a load does not resist. Whether there is such a path. */
static_path static_path_of_load(const path_shape *path, double load);
bool static_path_is_true(const path_shape *path);

/* Largest difference of position and quaternion of a, b [unknowns]; of a itself where b is NULL;
 * not a number where one is none. */
double static_path_distance(size_t rows, size_t unknowns, const double *a, const double *b);

/* y [unknowns]: receives the solution at the end of the path, or where it stops: report->
 * load_fraction is then below 1. *leaps: whether a step went elsewhere than those before it, as
 * one across a limit point would. Adds to the steps of the report. AD_NO_MEMORY, or what the tape
 * says of a formula. */
ad_status static_path_follow(static_system *system, static_newton *newton, const path_shape *path,
                             double *y, bool *leaps, solve_report *report, ad_error *error);

#endif
