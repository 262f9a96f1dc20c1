/* Training of one-step models: solved steps of the reduced rod, a model of the kind that the scene
 * asks for, an optimiser, until its stages are over.
 *
 *   surrogate_training *t;
 *   surrogate_training_create(&scene, &settings, &training, pool, &t, &error);
 *   fit *f = surrogate_training_fit(t);
 *   while (f->state == FIT_RUNNING) {
 *       fit_step(f, &error);
 *   }
 *   surrogate_training_step_of(t)->numbers ...
 *   surrogate_training_free(t);
 *
 * In a checkpoint: surrogate/shape and surrogate/numbers, the model as it is now; parameters,
 * history/table, and what tools/train/fit.h says.
 * Solved steps are drawn anew, by the seed. */
#ifndef SURROGATE_TRAINING_H
#define SURROGATE_TRAINING_H

#include "tools/surrogate/surrogate.h"
#include "tools/train/fit.h"

typedef struct surrogate_training surrogate_training;

typedef struct surrogate_training_info {
    size_t parameters;           /* that are optimised */
    size_t solved;               /* steps to learn from */
    double prepared;             /* s, of what comes before the first step */
    char frame[256], modes[256]; /* what was found of the robot, for people */
} surrogate_training_info;

/* Settings are resolved, modes may be open: they are chosen here. All is borrowed. AD_BAD_INPUT,
 * AD_NOT_FINITE: no steps can be solved, AD_NO_MEMORY. */
ad_status surrogate_training_create(const scene *open, surrogate_settings *settings,
                                    const train_settings *training, ad_pool *pool,
                                    surrogate_training **result, ad_error *error);
void surrogate_training_free(surrogate_training *t); /* NULL is fine */

/* A step that is AD_NOT_FINITE leaves the state as it was. Losses are over that of the linear map
 * alone; held out: of other rollouts. */
fit *surrogate_training_fit(surrogate_training *t);
const surrogate_training_info *surrogate_training_inspect(const surrogate_training *t);

/* The model as it is now, with the best parameters so far; borrowed, until the next step. NULL: its
 * output layer is not finite. */
const surrogate_step *surrogate_training_step_of(surrogate_training *t);

#endif
