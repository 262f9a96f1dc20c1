/* A rod's equations of motion through time by composing flows that are known exactly: nodes that
 * move freely, and forces that change their velocities (motion.h); and drag, in the middle of a
 * step, which is then of order 2 in the drag: steps that follow all vibrations are so short that
 * this is far below what meshes miss.
 *
 * SRKN 6b of Blanes and Moan (J. Comput. Appl. Math. 142, 2002, table 2): order 4 with 6 forces a
 * step, reversible, and symplectic where forces have a potential: the energy of every vibration
 * stays what it is, however long it goes on. Stable for frequencies up to 5/step. Steps are
 * equal between the instants at which something must end. */
#ifndef PHYSICS_SOLVE_MOTION_COMPOSE_H
#define PHYSICS_SOLVE_MOTION_COMPOSE_H

#include "physics/solve/integrate.h"

/* As motion_integrate, of a motion that is separable. settings->step: none is longer; 0: as long as
 * the fastest vibration allows. */
ad_status motion_compose(motion *m, const integrate_settings *settings, size_t count,
                         const double *times, double *states, solve_energy *energies,
                         integrate_counts *counts, ad_error *error);

/* How many steps for a unit of time it takes at least, with such a fastest vibration. */
double motion_compose_steps(double frequency);

#endif
