/* A rod's equations of motion through time.
 *
 * Implicit Runge-Kutta of order 5, L-stable, with error control: ESDIRK ARK5(4)8L[2]SAb of Kennedy
 * and Carpenter (Appl. Numer. Math. 136, 2019) in SUNDIALS' ARKODE. Vibrations far faster than the
 * motion of interest, which stretch and shear bring with them, are damped instead of followed. BDF
 * would not do: beyond order 2 it is unstable where eigenvalues lie beside the imaginary axis. */
#ifndef TOOLS_SOLVE_INTEGRATE_H
#define TOOLS_SOLVE_INTEGRATE_H

#include "tools/solve/motion.h"

/* At one of the times asked for. kinetic + strain - work + dissipated is constant but for errors of
 * integration. */
typedef struct integrate_energy {
    double kinetic, strain;
    double work;       /* of loads, and of what drives the ends, since t = 0 */
    double dissipated; /* by damping and drag since t = 0, >= 0 */
} integrate_energy;

typedef struct integrate_counts {
    long steps, newton_steps, matrices, failures;
    double time; /* reached */
} integrate_counts;

/* From the initial state through times [count], ascending, >= 0, to states
 * [count][nodes][MOTION_ROWS] and energies [count] (NULL: not wanted). tolerance: of each step,
 * relative and absolute, in every row. AD_NOT_FINITE when steps become too small, and errors of
 * formulas; counts->time then says how far it came. */
ad_status integrate(motion *m, double tolerance, size_t count, const double *times, double *states,
                    integrate_energy *energies, integrate_counts *counts, ad_error *error);

#endif
