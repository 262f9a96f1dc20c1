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

/* experiment_without_network of what a file says; takes over `settings`, also when it fails. */
ad_status config_experiment_without_network(config *settings, experiment **result, ad_error *error);

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
 * the key that is to blame. */
ad_status config_identify(const config *settings, int threads, const int *modes,
                          const least_squares_runner *runner, identified *found, ad_error *error);

/* How far the scene is from each file of its data; rows (may be NULL): row by row, as of
 * measured_judge. found: of config_identify, or with count 0, of a scene without unknowns, of whose
 * data all may be held out. Errors as above. */
ad_status config_judge(const config *settings, int threads, const int *modes,
                       const identified *found, judged *result, judged_rows **rows,
                       ad_error *error);

#endif
