/* Beams of small deflection solved classically: collocation in s (beam_system.h), in motion also in
 * t (beam_motion.h), refined until the deflection stops changing. */
#ifndef PHYSICS_SOLVE_BEAM_SOLVER_H
#define PHYSICS_SOLVE_BEAM_SOLVER_H

#include "physics/solve/beam_system.h"
#include "physics/solve/solve.h"

typedef struct beam_solution beam_solution;

/* The columns of a beam, see physics/learn/model.h; dimensionless. */
typedef struct beam_state {
    double deflection, slope, shear, moment;
    double velocity, slope_rate; /* 0 if static */
} beam_state;

/* At times [count], ascending, in [0, duration]; a static beam takes none. settings->nodes: so many
 * at least, no estimate, and steps of time as short as waves of that many nodes ask for. Otherwise
 * nodes and steps together grow finer until two solutions differ by no more than the tolerance,
 * relative to the largest deflection; the finer is the solution, the difference the estimate. AD_OK
 * also when the finest do not meet the tolerance. The beam must outlive the solution. */
ad_status beam_solve(const solve_beam *beam, const solve_settings *settings, size_t count,
                     const double *times, beam_solution **result, solve_report *report,
                     ad_error *error);
void beam_free(beam_solution *solution);

/* Largest |w| at the nodes, at all times. */
double beam_largest(const beam_solution *solution);

/* At time `which` of those given (a static beam: 0) and n points s [n] within [0, 1]; out [n]. */
void beam_at(const beam_solution *solution, size_t which, size_t n, const double *s,
             beam_state *out);

#endif
