/* From a scene file to training, and from a checkpoint back to its experiment. */
#ifndef TOOLS_PREPARE_CONFIG_EXPERIMENT_H
#define TOOLS_PREPARE_CONFIG_EXPERIMENT_H

#include "tools/prepare/prepare.h"
#include "tools/train/experiment.h"
#include "tools/train/identify.h"
#include "tools/train/judged.h"

/* Of what a file says; its `free` is for the settings as well. */
train_origin config_origin(config *settings);

/* experiment_create of what a file says. Takes over `settings`, also when it fails. */
ad_status config_experiment_create(config *settings, int threads, experiment **result,
                                   ad_error *error);

/* Restore an experiment by itself from a checkpoint: DIR, DIR/checkpoint.h5 or any such file.
 * `overrides` as for config_read, of what a run may change (config_continues). *file (may be NULL)
 * receives the opened checkpoint. A reference file that is no longer there is no error: the
 * experiment then has no reference, and says so in `warning`. */
ad_status config_experiment_open(const char *path, int count, const char *const *overrides,
                                 int threads, experiment **result, checkpoint **file,
                                 ad_error *error);

/* The unknowns of a scene from its data. threads: 0 means one per processor. modes [4]: of the
 * reduced rod by which recordings with inputs over time are followed, as reduced_settings has them;
 * NULL: the usual. AD_BAD_INPUT: there are none, or no data; errors of identify, with the place of
 * the key that is to blame. fit (may be NULL): how far the scene is from each file with them, where
 * the search has ended. */
ad_status config_identify(const config *settings, int threads, const int *modes,
                          const least_squares_runner *runner, identified *found, judged *fit,
                          ad_error *error);

/* A table of what was measured and what is computed at values [unknown_count] of the unknowns
 * (measured_write). Errors as of this and config_identify. */
ad_status config_residuals(const config *settings, int threads, const int *modes,
                           const double *values, const char *path, ad_error *error);

#endif
