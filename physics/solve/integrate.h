/* A rod's equations of motion through time: Runge-Kutta with error control, in SUNDIALS' ARKODE.
 *
 * Implicit: ESDIRK ARK5(4)8L[2]SAb of Kennedy and Carpenter (Appl. Numer. Math. 136, 2019), order
 * 5, L-stable. Vibrations far faster than the motion of interest, which stretch and shear bring
 * with them, are damped instead of followed. BDF would not do: beyond order 2 it is unstable where
 * eigenvalues lie beside the imaginary axis.
 * Explicit: ARK4(3)6L[2]SA of the same authors (Appl. Numer. Math. 44, 2003), order 4, which is
 * stable far up the imaginary axis. Follows every vibration of the mesh, which is best where the
 * motion has many of them, or the rod is thick; motion_compose.h has a quicker one for rods without
 * Kelvin-Voigt damping.
 */
#ifndef PHYSICS_SOLVE_INTEGRATE_H
#define PHYSICS_SOLVE_INTEGRATE_H

#include "physics/solve/events.h"
#include "physics/solve/motion.h"

typedef enum integrate_method { INTEGRATE_IMPLICIT, INTEGRATE_EXPLICIT } integrate_method;

typedef struct integrate_settings {
    integrate_method method;
    double tolerance; /* of each step, relative and absolute, in every row */
    long steps_max;   /* 0: as many as it takes */
    double step;      /* length of each, whatever its error; 0: as long as the tolerance allows */
    const solve_events *events; /* what no step may pass; NULL: nothing */
    solve_clock *clock;         /* takes the steps that are made; NULL: nobody asks */
} integrate_settings;

typedef struct integrate_counts {
    long steps, newton_steps, matrices, failures;
    double time; /* reached */
} integrate_counts;

/* From the initial state through times [count], ascending, >= 0, to states
 * [count][motion_size] and energies [count]; steps depend on the last of these times alone.
 * AD_NOT_FINITE when steps become too small or too many, and errors of formulas; counts->time then
 * says how far it came. */
ad_status motion_integrate(motion *m, const integrate_settings *settings, size_t count,
                           const double *times, double *states, solve_energy *energies,
                           integrate_counts *counts, ad_error *error);

/* How many steps for a unit of time the explicit method needs, lest a vibration of such a frequency
 * grow. */
double motion_explicit_steps(double frequency);

#endif
