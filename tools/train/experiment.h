/* An experiment made ready: its network, parameters and threads; and its way into and out of a
 * checkpoint.
 *
 * Items of a checkpoint (tools/files/checkpoint.h), beside the network's parameters
 * "parameters/network/layer0/weight" [rows, columns] and so on; where time has several windows
 * "parameters/window1/network/layer0/weight" for each window begun, counted from 1:
 *   scene/yaml                 what its origin writes: the resolved experiment, reads back as it is
 *   physics/text               in its place of physics of one's own: experiment_own.h
 *   network/fourier            [features, inputs] frequencies, where there are any
 *   network/basis              [rows, 1 + inputs + 2 features] nn_mlp_basis, where there is one
 *   network/edge_basis         the same, nn_mlp_edge_basis, where s is in several pieces
 *   family/affine, modes, project, scale  of a family in the strain form: physics/learn/family.h
 *   optimizer/...              state of the optimiser at work, optim.h
 *   points/...                 uint64 [5]: the state of the generator before it drew the points of
 * a set, and their number; or, where they have moved, [coordinates, points] data/... of points,
 * [rows, points], problem.h causal/..., balance/...  weights that follow
 * training, where there are any generators/...             uint64 [4] states of the random
 * generators training/...               stage, step, seconds: tools/train/trainer.h history/table
 * rows of history.csv, with its columns */
#ifndef TOOLS_TRAIN_EXPERIMENT_H
#define TOOLS_TRAIN_EXPERIMENT_H

#include "physics/learn/evaluator.h"
#include "physics/learn/field.h"
#include "physics/learn/problem.h"
#include "physics/learn/window_state.h"
#include "tools/files/checkpoint.h"
#include "tools/train/fit.h"
#include "tools/train/targets.h"

#include <stdio.h>

typedef struct experiment {
    const struct scene *scene; /* these two belong to the origin */
    train_settings *settings;
    train_origin origin; /* owned */
    ad_pool *pool;
    physics_model *model; /* owned, unless lent to experiment_of_model, or of `modes` */
    bool is_lent;
    nn_mlp *mlp;
    struct modes_model *modes; /* of one motion in the strain form, owns the model; else NULL */
    struct targets *targets;   /* of a family in the strain form; else NULL */
    struct measured *measured; /* the data of the model's terms; once there is a problem */
    struct window_state *window_state; /* from window to window */
    double *parameters; /* [windows][count]; the first window's are initialised from the seed */
    double *starts;     /* [windows][window_state_numbers], of the windows begun but the first */
    size_t count;
    int window;        /* the one at work, from 0; those before have their parameters */
    char warning[512]; /* why a restored experiment has lost its reference file; "": it has not */
} experiment;

/* Scene and settings are resolved and checked, and live as long as `origin`, which is taken over,
 * also when this fails. The network's inputs and outputs are filled in. threads: 0 means one per
 * processor. */
ad_status experiment_create(const scene *rod_scene, train_settings *settings,
                            const train_origin *origin, int threads, experiment **result,
                            ad_error *error);
/* The same of a model that its owner has put together, of a scene with further terms or without
 * one; borrowed. */
ad_status experiment_of_model(physics_model *m, train_settings *settings,
                              const train_origin *origin, int threads, experiment **result,
                              ad_error *error);
/* The same without network, model and problem: what a reference needs that is compared with
 * solutions alone. Settings are as they were read. */
ad_status experiment_without_network(const scene *rod_scene, train_settings *settings,
                                     const train_origin *origin, experiment **result,
                                     ad_error *error);
void experiment_free(experiment *e);

/* The problem that its model and losses are, in the first window. The first call reads the files of
 * data and adds their terms to the model; of a family in the strain form members are drawn. */
ad_status experiment_problem(experiment *e, problem **result, ad_error *error);

/* Of the window at work: its network's parameters [count], and the state from which it starts
 * [window_state_numbers], which the first window has not. */
double *experiment_parameters(const experiment *e);
const double *experiment_start(const experiment *e);

/* Values [parameter_count] of the scene's parameters: of a family the middle ones, and unknowns as
 * they are found so far. */
const double *experiment_member_values(const experiment *e, double *values);

/* The same with known ones as "NAME=VALUE,..." gives them; NULL: the middle. */
ad_status experiment_choose_member(const experiment *e, const char *at, double *values,
                                   ad_error *error);

/* The networks up to the window at work, of a family of the member with these values (NULL: those
 * above). To be freed by field_free. */
ad_status experiment_field(const experiment *e, const double *member, field **result,
                           ad_error *error);

/* When that window ends, s; 0 at rest. */
double experiment_until(const experiment *e);

/* The networks of the windows so far, for an evaluator; borrowed from the experiment. */
evaluator_model experiment_trained(const experiment *e);

/* Go to the next window, from the state in which the one at work ends. */
ad_status experiment_next_window(experiment *e, ad_error *error);

/* The text, parameters, the window at work and frequencies to and from a checkpoint; `parameters`
 * are those of the window at work, and they and the experiment are borrowed until the checkpoint is
 * written; what fails shows when it is written. Frequencies become part of a recording: get comes
 * before anything is made of the network. */
void experiment_put(experiment *e, const double *parameters, checkpoint *file);
ad_status experiment_get(experiment *e, const checkpoint *file, ad_error *error);

/* Blame a key for something found after reading. */
ad_status experiment_refuse(const experiment *e, const char *key, const char *problem,
                            ad_error *error);

/* The item of a checkpoint that holds what the origin writes. */
const char *experiment_text_item(const experiment *e);

#endif
