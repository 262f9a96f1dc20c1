/* Physics of one's own in checkpoints: the equations are a program's functions and cannot be
 * written, but what they are about can, so that another model is not taken for the one that was
 * trained. */
#ifndef TOOLS_TRAIN_EXPERIMENT_OWN_H
#define TOOLS_TRAIN_EXPERIMENT_OWN_H

#include "tools/train/experiment.h"

typedef struct experiment_own {
    const physics_model *model;
    const train_settings *settings; /* resolved */
} experiment_own;

/* `own` is borrowed. A line of YAML each for coordinates, fields, sets of points, terms with their
 * weights, and the network; a run goes on where all of these are the same. */
train_origin experiment_own_origin(experiment_own *own);

/* Whether the checkpoint holds a run of this physics and network. AD_BAD_INPUT, with the first line
 * that differs; `path` is that of the checkpoint. */
ad_status experiment_own_check(const experiment_own *own, const char *path, const checkpoint *file,
                               ad_error *error);

#endif
