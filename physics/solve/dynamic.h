/* The motion of a rod: spectral elements in s (motion.h), steps of t (integrate.h,
 * motion_compose.h), both refined until the position stops changing. */
#ifndef PHYSICS_SOLVE_DYNAMIC_H
#define PHYSICS_SOLVE_DYNAMIC_H

#include "physics/solve/integrate.h"

typedef struct dynamic_solution dynamic_solution;

/* From the initial state through times [count], ascending, in [0, duration], in units of
 * rod->scales.time. settings->nodes: one mesh of at least so many nodes, settings->tolerance that
 * of time steps, no estimate. Otherwise steps and then the mesh grow finer until the error is
 * estimated to be below the tolerance, in position and in what a rotation moves over a tenth of the
 * rod, relative L2 over s and t; and nowhere above
 * SOLVE_PEAK tolerances. The solution is that on the finest mesh. The estimate is the last distance
 * between two meshes; more where distances fall slowly, as those of motions with waves that have
 * kinks do; less, where three meshes show that their errors are at right angles. AD_OK also when
 * the work that a solution may cost, or the finest mesh, does not meet the tolerance:
 * report->estimate is then above. That work is counted in forces, so that results do not depend on
 * the machine. Locked strains are stiff ones. What they give way by is in the estimate, by a
 * solution whose locks are softer; 1e-6 is about the best to ask of them, and
 * minutes where a load jumps and sets them ringing. AD_BAD_INPUT: no rotary inertia. The rod must
 * outlive the solution. */
ad_status dynamic_solve(const solve_rod *rod, const solve_settings *settings, size_t count,
                        const double *times, dynamic_solution **result, solve_report *report,
                        ad_error *error);
void dynamic_free(dynamic_solution *solution);

/* At time `which` of those given and n points s [n] within [0, 1]; out [n]. */
ad_status dynamic_at(const dynamic_solution *solution, size_t which, size_t n, const double *s,
                     solve_state *out, ad_error *error);

/* Of two motions, or an error: relative L2 over s and t, and the largest over the length. */
typedef struct motion_apart {
    double l2, most;
} motion_apart;

/* What is seen of each at so many equally spaced places and `count` times: x, y
 * [count][MOTION_COMPARED]; positions, and rotations by what they move over a tenth of the rod. */
enum { MOTION_COMPARED = 33 };
motion_apart motion_compare(size_t count, const solve_state *state, const solve_state *y);

/* The error that the last of `count` distances between solutions, each finer than the one before,
 * leaves, by that distance. Those of a motion with waves that no mesh resolves fall slowly, and
 * what is yet to come adds up to distance (ratio + ratio^2 + ...), if the solutions approach the
 * limit from one side. */
double motion_left_over(int count, const double *distance);

/* [count] */
const solve_energy *dynamic_energies(const dynamic_solution *solution);

#endif
