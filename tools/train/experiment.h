/* An experiment made ready: its network, parameters and threads; and its way into and out of a
 * checkpoint.
 *
 * Items of a checkpoint (tools/files/checkpoint.h), beside the network's parameters
 * "parameters/network/layer0/weight" [rows, columns] and so on; where time has several windows
 * "parameters/window1/network/layer0/weight" for each window begun, counted from 1:
 *   scene/yaml                 the resolved experiment, reads back as it is
 *   network/fourier            [features, inputs] frequencies, where there are any
 *   network/basis              [rows, 1 + inputs + 2 features] nn_mlp_basis, where there is one
 *   optimizer/...              state of the optimiser at work, optim.h
 *   points/...                 point sets [coordinates, points], problem.h
 *   causal/..., balance/..., self_adaptive/...  weights that follow training, where there are any
 *   generators/...             uint64 [4] states of the random generators
 *   training/...               stage, step, seconds: tools/train/trainer.h
 *   history/table              rows of history.csv, with its columns */
#ifndef TOOLS_TRAIN_EXPERIMENT_H
#define TOOLS_TRAIN_EXPERIMENT_H

#include "physics/field.h"
#include "physics/problem.h"
#include "tools/config/config.h"
#include "tools/files/checkpoint.h"

typedef struct experiment {
    config *settings; /* owned */
    ad_pool *pool;
    nn_mlp *mlp;
    double *parameters; /* [windows][count]; the first window's are initialised from the seed */
    double *starts;     /* [windows][ROD_WINDOW_NUMBERS], of the windows begun but the first */
    size_t count;
    int window;        /* the one at work, from 0; those before have their parameters */
    char *yaml;        /* the text that experiment_put lent to a checkpoint */
    char warning[512]; /* why a restored experiment has lost its reference file; "": it has not */
} experiment;

/* Takes over `settings`, also when it fails. threads: 0 means one per processor. */
ad_status experiment_create(config *settings, int threads, experiment **result, ad_error *error);
void experiment_free(experiment *e);

/* Restore an experiment by itself from a checkpoint: DIR, DIR/checkpoint.h5 or any such file.
 * `overrides` as for config_read. *file (may be NULL) receives the opened checkpoint. A reference
 * file that is no longer there is no error: the experiment then has no reference, and says so in
 * `warning`. */
ad_status experiment_open(const char *path, int count, const char *const *overrides, int threads,
                          experiment **result, checkpoint **file, ad_error *error);

/* The window at work: its network's parameters [count], and what the physics knows of it. */
double *experiment_parameters(const experiment *e);
rod_window experiment_window(const experiment *e);

/* Go to the next window, from the state in which the one at work ends. */
ad_status experiment_next_window(experiment *e, ad_error *error);

/* scene/yaml, parameters, the window at work and frequencies to and from a checkpoint; `parameters`
 * are those of the window at work, and they and the experiment are borrowed until the checkpoint is
 * written; what fails shows when it is written. Frequencies become part of a recording: get comes
 * before anything is made of the network. */
void experiment_put(experiment *e, const double *parameters, checkpoint *file);
ad_status experiment_get(experiment *e, const checkpoint *file, ad_error *error);

/* The resolved scene as YAML, allocated; NULL when memory runs out. */
char *experiment_yaml(const experiment *e);

#endif
