/* Work and precision of the solver: a scene solved with more and more nodes. */
#ifndef TOOLS_JUDGE_SWEEP_H
#define TOOLS_JUDGE_SWEEP_H

#include "physics/solve/solve.h"

/* Told of each solution, in the order of nodes: the seconds that it took, the median of a few, of a
 * motion those of one. Returns its error in the measure of the caller; NaN: there is enough. */
typedef double solve_sweep_row(void *context, int nodes, double seconds, const solution *solved);

/* By collocation from 2 nodes on (5 in motion, with ever finer steps of time), until the error is
 * that of rounding or the nodes are as many as the tables in sweep.c. Solutions that do not reach
 * the whole load are passed over. `count` and `times` as for solution_create. */
ad_status solve_sweep(const scene *rod_scene, size_t count, const double *times,
                      solve_sweep_row *row, void *context, ad_error *error);

#endif
