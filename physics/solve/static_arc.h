/* Equilibria along the arc length of their path, which so goes on where the load turns back:
 * pseudo-arclength continuation (Keller, in Applications of Bifurcation Theory, 1977). Steps solve
 *
 *   F(y, load) = 0,   <tangent, (y, load) - (y, load)_0> = length,
 *
 * by Newton's method with the factors of F_y alone, which is singular at limit points only and at
 * bifurcations. */
#ifndef PHYSICS_SOLVE_STATIC_ARC_H
#define PHYSICS_SOLVE_STATIC_ARC_H

#include "physics/solve/static_path.h"

typedef struct static_arc static_arc;

/* A vector of the unknowns y and, last, the load factor: [unknowns + 1]. The product of two is the
 * mean over the points of the mesh of that of positions and quaternions, plus that of the loads. */
typedef struct arc_place {
    double *at;      /* y, load */
    double *tangent; /* of length 1 */
} arc_place;

/* The system and the shape of the path must outlive it. AD_NO_MEMORY, or what the tape says of a
 * formula. */
ad_status static_arc_create(static_system *system, const path_shape *path, static_arc **result,
                            ad_error *error);
void static_arc_free(static_arc *arc);

/* Length of a place's vectors. */
size_t static_arc_size(const static_arc *arc);

/* static_path_distance of two equilibria. */
double static_arc_distance(const static_arc *arc, const double *a, const double *b);

double static_arc_product(const static_arc *arc, const double *a, const double *b);

/* The equilibrium at a place, to rounding: `at` is the guess, and moves across `border` only, so
 * that <border, at> stays. false: not converged. Adds to *steps. */
bool static_arc_correct(static_arc *arc, const double *border, double *at, long *steps);

/* The tangent at place->at, an equilibrium, on the side of `forward`. false: F_y is singular. */
bool static_arc_tangent(static_arc *arc, const double *forward, arc_place *place);

/* A step of some length from one place to another; `before` is a place that came `distance` earlier
 * (NULL: none), by which it curves. *off: how far the guess was off, in position and quaternion. */
bool static_arc_step(static_arc *arc, const arc_place *before, double distance,
                     const arc_place *from, double length, arc_place *to, double *off, long *steps);

/* The direction [size] in which the equilibria of a place nearly give way beside the path, of
 * length 1, its largest displacement positive: what loads in proportion to its own displacements
 * bring about, by inverse iteration. false: F_y is singular. */
bool static_arc_weakest(static_arc *arc, const arc_place *place, double *direction);

/* How much resistance there is to such loads: goes through 0 where paths cross, and not at limit
 * points. NaN: F_y is singular. */
double static_arc_resistance(static_arc *arc, const arc_place *place, const double *direction);

#endif
