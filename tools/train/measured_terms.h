/* Measured data as terms of the loss: a file of rows, one for each place, with columns as
 * cpinn-eval names them. The terms are "data0_position" and so on, by the list of the settings. */
#ifndef TOOLS_TRAIN_MEASURED_TERMS_H
#define TOOLS_TRAIN_MEASURED_TERMS_H

#include "physics/learn/model.h"
#include "tools/train/train_settings.h"

typedef struct measured measured;

/* Reads the files and adds a set of points and a term for each to the model of a scene, which
 * borrows the result. The residual of a row is the difference of its columns, of rotations the
 * rotation vector between them, over the noise; without one over what is natural: the length, a
 * radian, the scene's force, moment, time, of beams the largest number of the file. A window of
 * time has the rows within it. AD_BAD_INPUT: `key` receives the key to blame. */
ad_status measured_add(physics_model *m, const train_settings *settings, measured **result,
                       char key[TRAIN_KEY_MAX], ad_error *error);
void measured_free(measured *measured);

/* Whether noise is given. */
bool measured_tells_noise(const measured *measured);

/* Of one without noise: by what residuals of the terms are divided, SI; with noise: 1. */
double measured_unit(const measured *measured);

/* Numbers without a value: among those that the terms have, and among those of the files, whose
 * rows without any the terms have not. */
size_t measured_missing(const measured *measured);
size_t measured_fields_missing(const measured *measured);

#endif
