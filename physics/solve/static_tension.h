/* Tensions of tendons whose displacement is given: the length over the rod, int |p'| ds, is that in
 * the unstressed rod less the displacement, and more by tension over stiffness; or the tendon is
 * slack, shorter than that and without tension. */
#ifndef PHYSICS_SOLVE_STATIC_TENSION_H
#define PHYSICS_SOLVE_STATIC_TENSION_H

#include "physics/solve/static_system.h"

/* How equilibria of given tensions are found: solve makes y [unknowns] one and leaves the
 * derivatives factored; step writes to `moved` where one Newton step with them leads. */
typedef struct static_tension_newton {
    bool (*solve)(void *context, double *y, long *steps);
    void (*step)(void *context, const double *y, double *moved);
    void *context;
} static_tension_newton;

/* y: the guess, then the equilibrium in which tensions and lengths agree, to rounding; moved
 * [unknowns] is overwritten. By Newton's method on the tensions, which are at their best where no
 * tendon pushes. false: not converged, and the tensions are as before. */
bool static_tension_solve(static_system *system, const static_tension_newton *newton, double *y,
                          double *moved, long *steps);

#endif
