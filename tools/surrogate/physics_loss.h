/* What a one-step model of decoupled.h is trained with, as published: the mean square of z' - f at
 * random times of steps along motions of the reduced rod, x' = f(x, u). States that stay have a
 * loss of 1.
 *
 *   physics_prepare(&scene, &motions, seed, &model, numbers);
 *   physics_loss_create(&scene, modes, &motions, &model, &settings, pool, &loss, &error);
 *   physics_loss_draw(loss, step);
 *   physics_loss_evaluate(loss, parameters, &value, gradient);      an optim_objective */
#ifndef SURROGATE_PHYSICS_LOSS_H
#define SURROGATE_PHYSICS_LOSS_H

#include "physics/scene/scene.h"
#include "tools/surrogate/decoupled.h"
#include "tools/surrogate/excitation.h"

typedef struct physics_loss_settings {
    int batch; /* beginnings that an evaluation takes, drawn anew for every step; 0: all */
    int most;  /* of all beginnings so many, evenly; 0: all */
    uint64_t seed;
} physics_loss_settings;

typedef struct physics_loss physics_loss;

/* Fills in the numbers of m [decoupled_numbers]: centers, scales, and parameters to begin with,
 * small but not 0, since alpha = 0 never learns. */
void physics_prepare(const scene *open, const excitation_rollouts *motions, uint64_t seed,
                     const decoupled *m, double *numbers);

/* Node values nodes [count][steps][DECOUPLED_NODES][states] of the steps of motions, by the
 * equations of the rod alone. They are those of one step of Radau's method of order 5, found by
 * Newton's method; not a number where that fails. Of m only the scales are used. */
ad_status physics_collocate(const scene *open, const int modes[4],
                            const excitation_rollouts *motions, const decoupled *m, ad_pool *pool,
                            double *nodes, ad_error *error);

/* Borrows all but the settings. AD_BAD_ARGUMENT: there is no step. */
ad_status physics_loss_create(const scene *open, const int modes[4],
                              const excitation_rollouts *motions, const decoupled *m,
                              const physics_loss_settings *settings, ad_pool *pool,
                              physics_loss **result, ad_error *error);
void physics_loss_free(physics_loss *loss); /* NULL is fine */

/* The batch and the times of a step of training follow from the seed and its number; without
 * batches it is the same function in every step. */
void physics_loss_draw(physics_loss *loss, int64_t step);

/* An optim_objective of the parameters [decoupled_parameters]; the same bits for any number of
 * threads. */
int physics_loss_evaluate(void *loss, const double *parameters, double *value, double *gradient);

#endif
