/* A motion by strain modes (modes.h): as many modes and as short steps (modes_step.h) as a
 * tolerance asks for. */
#ifndef PHYSICS_SOLVE_MODES_MOTION_H
#define PHYSICS_SOLVE_MODES_MOTION_H

#include "physics/chain/modes.h"
#include "physics/solve/dynamic.h"

/* Of a step: of order 9. With 3, of order 5, motions took as long for a tenth of the accuracy. */
enum { MODES_MOTION_STAGES = 5 };

/* What a state consists of: q, q_t, stretches of Maxwell branches. */
enum { MODES_MOTION_STATES = 3 };

typedef struct modes_solution modes_solution;

/* As dynamic_solve; settings->modes: those numbers, without estimate. Each solution has more modes
 * of the strains whose last ones matter, more Gauss points and shorter steps than the one before,
 * until the last is estimated to be within the tolerance: by the distance of the last two, less
 * where distances have fallen from one pair to the next. Modes that stay 0, as those out of the
 * plane of a motion, are left out. AD_BAD_INPUT: a scene that modes cannot take. */
ad_status modes_motion_solve(solve_rod *rod, const solve_settings *settings, size_t count,
                             const double *times, modes_solution **result, solve_report *report,
                             ad_error *error);
void modes_motion_free(modes_solution *solution);

/* As dynamic_at, dynamic_energies. */
ad_status modes_motion_at(const modes_solution *solution, size_t which, size_t n, const double *s,
                          solve_state *out, ad_error *error);
const solve_energy *modes_motion_energies(const modes_solution *solution);

#endif
