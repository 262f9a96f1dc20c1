/* The equations of the reduced rod as those who learn from them share them; not for others. */
#ifndef SURROGATE_PHYSICS_INTERNAL_H
#define SURROGATE_PHYSICS_INTERNAL_H

#include "physics/chain/reduced.h"
#include "tools/surrogate/physics_loss.h"

/* z' = h f/x_s in the coordinates of the model m, along motions. */
typedef struct physics {
    const decoupled *m;
    const excitation_rollouts *motions;
    const double *center, *scale, *input_center, *input_scale;
} physics;

/* Of one thread. */
typedef struct physics_worker {
    reduced_rod *rod;
    double *given;                    /* [inputs of the network]: z, v */
    double *state, *input, *jacobian; /* of physics_rate */
    double *own;                      /* [more] */
} physics_worker;

physics physics_of(const decoupled *m, const excitation_rollouts *motions);
size_t physics_given(const decoupled *m); /* inputs of the network: z, v */

/* One for each thread of a pool; to be freed in any case. */
ad_status physics_workers_create(const scene *open, const int modes[4], const decoupled *m,
                                 int threads, size_t more, physics_worker **result,
                                 ad_error *error);
void physics_workers_free(int threads, physics_worker *workers);

/* w->given of step k of rollout i. */
void physics_take(const physics *physics, int i, int k, physics_worker *w);

/* rate [n] at z and t, and its derivatives by_z [n][n] (NULL: not wanted); false: there is no
 * answer. */
bool physics_rate(const physics *physics, physics_worker *w, double t, const double *z,
                  double *rate, double *by_z);

#endif
