/* Static equilibria of a rod: collocation (static_system.h), Newton's method (static_newton.h), and
 * continuation from the unstressed rod to the loaded one. */
#ifndef PHYSICS_SOLVE_STATIC_H
#define PHYSICS_SOLVE_STATIC_H

#include "physics/local/rod_model.h"
#include "physics/solve/solve.h"

typedef struct static_solution static_solution;

/* Follows the equilibria of the load, scaled from 0 to 1, from the unstressed rod on; where several
 * exist it finds the one that this path leads to. A manufactured scene starts from its own solution
 * instead. Then refines the mesh. AD_OK also when the path
 * ends early: report->load_fraction is then below 1, and the solution that of this load; or when
 * the tolerance is not met: report->estimate is above it. The rod must outlive the solution, and
 * `before`, an equilibrium whose tensions tendons with friction had before, while it is found;
 * NULL: they had none. */
ad_status static_solve(const solve_rod *rod, const solve_settings *settings,
                       const static_solution *before, static_solution **result,
                       solve_report *report, ad_error *error);
void static_free(static_solution *solution);

/* At n points s [n] within [0, 1]; out [n]. */
ad_status static_at(const static_solution *solution, size_t n, const double *s, solve_state *out,
                    ad_error *error);

/* Of a tendon whose length is given, by EI/L^2; 0 of others. */
double static_tension(const static_solution *solution, int tendon);

/* The tension of any tendon at s, with friction, by EI/L^2. */
double static_tension_at(const static_solution *solution, int tendon, double s);

ad_status static_energy(const static_solution *solution, solve_energy *energy, ad_error *error);

#endif
