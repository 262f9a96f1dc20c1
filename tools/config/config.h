/* An experiment: the YAML file, read, checked, every default filled in.
 *
 * One table of keys (config_keys.c) holds path, type, unit, default, range and help of every key
 * and drives the reader, --set, --help, --print-config and the resolved config.yaml of a run. */
#ifndef TOOLS_CONFIG_CONFIG_H
#define TOOLS_CONFIG_CONFIG_H

#include "nn/nn.h"
#include "optim/optim.h"
#include "physics/problem.h"
#include "physics/scene.h"

#include <stdint.h>
#include <stdio.h>

enum { CONFIG_STAGES_MAX = 32 };

typedef enum config_optimizer {
    CONFIG_ADAM,
    CONFIG_LBFGS,
    CONFIG_GAUSS_NEWTON,
    CONFIG_SSBROYDEN,
    CONFIG_OPTIMIZER_COUNT
} config_optimizer;

const char *config_optimizer_name(config_optimizer optimizer);

/* How a Gauss-Newton step is computed; tools/train/linear_model.h says what each form is. */
#define CONFIG_LINEAR_ALGEBRA_LIST(X)                                                              \
    X(CONFIG_LINEAR_AUTOMATIC, "automatic")                                                        \
    X(CONFIG_NORMAL_EQUATIONS, "normal_equations")                                                 \
    X(CONFIG_KERNEL, "kernel")                                                                     \
    X(CONFIG_MATRIX_FREE, "matrix_free")

#define CONFIG_LINEAR_ALGEBRA_ENUM(code, name) code,
typedef enum config_linear_algebra {
    CONFIG_LINEAR_ALGEBRA_LIST(CONFIG_LINEAR_ALGEBRA_ENUM) CONFIG_LINEAR_ALGEBRA_COUNT
} config_linear_algebra;
#undef CONFIG_LINEAR_ALGEBRA_ENUM

/* Units of the forces and moments under loads: SI, or EI/L^3, EI/L^2 (distributed force, moment)
 * and EI/L^2, EI/L (at the ends), EI the bending stiffness about d1 and L the length. */
typedef enum config_load_units { CONFIG_UNITS_SI, CONFIG_UNITS_EI } config_load_units;

typedef struct config_stage {
    config_optimizer optimizer;
    int steps;
    optim_adam_settings adam;                 /* its schedule included */
    optim_lbfgs_settings lbfgs;               /* but for the memory also those of ssbroyden */
    optim_gauss_newton_settings gauss_newton; /* its tolerances are those of lbfgs */
    config_linear_algebra linear_algebra;     /* of gauss_newton */
    double stop_loss;           /* the stage ends when the loss falls below; 0: never */
    double stop_error;          /* the same for the error against the reference */
    double stop_seconds;        /* and for its wall time; not reproducible */
    double stop_held_out_ratio; /* held-out over training loss of a network that interpolates */
} config_stage;

typedef enum config_reference {
    CONFIG_REFERENCE_NONE,
    CONFIG_REFERENCE_ELASTICA,
    CONFIG_REFERENCE_ROLLUP,
    CONFIG_REFERENCE_HELIX,
    CONFIG_REFERENCE_MANUFACTURED
} config_reference;

typedef struct config {
    const char *name;
    scene scene; /* loads in SI, whatever the YAML scaled; what section and material determine is
                  * left to scene_properties_of */
    config_load_units load_units; /* SI once read: the scene's loads are already converted */
    nn_mlp_settings network;      /* inputs and outputs are filled in by the physics */
    double fourier_wavenumber;    /* 1/m; network.fourier_bandwidth in SI */
    double fourier_frequency;     /* rad/s; NaN in a static scene */
    problem_settings losses;
    uint64_t seed;
    int stage_count;
    config_stage stages[CONFIG_STAGES_MAX];
    int checkpoint_every;      /* steps */
    double checkpoint_seconds; /* or after so much wall time, whichever is first */
    int checkpoint_keep;       /* how many checkpoints are kept */
    int output_every;          /* steps between rows of history.csv */
    config_reference reference;
    const char *reference_file; /* CSV or HDF5 with the model's columns of position and rotation;
                                 * relative to the YAML file, absolute once read; NULL: none */
    double reference_tolerance; /* of a classical solution, of the position over the length; NaN:
                                 * none */
    const char *reference_deflection; /* of a beam, formula of s and t; NULL: none */
    struct config_source *source;     /* texts and places; opaque */
} config;

bool config_names_reference(const config *config);

/* Whether training may come to the loads in parts, optim/continuation.h: at rest, where a network
 * without hidden layers is found by Gauss-Newton from 0, the unloaded rod. */
bool config_takes_loads_in_parts(const config *config);

/* Read `path` (or `text` of that name when text is not NULL), then apply `count` overrides
 * "key=value" in order; the value is YAML, so lists are [a, b], and null takes a key, or every
 * key of a section, back to its default. Keys of a list count from 0: training.stages[0].steps,
 * loads.tip.force[2]. Everything is checked, expressions and contradictions included. On failure
 * *config is NULL and error->message is the whole line: `file:line:column: key: what is wrong; what
 * is allowed`, where
 * `--set key=value` stands for file:line:column when the override is to blame.
 * AD_BAD_INPUT, AD_IO (file), AD_NO_MEMORY. The overrides are not kept. */
ad_status config_read(const char *path, const char *text, int count, const char *const *overrides,
                      config **config, ad_error *error);
void config_free(config *config);

/* The resolved experiment as YAML, every default filled in, each key with its help as a comment
 * when `help` is set. Stiffness and inertia that follow from section and material stay null, with
 * their numbers as a comment. Reading it back gives the same experiment. */
ad_status config_write(const config *config, FILE *file, bool help);

/* What a classical solution depends on, in the same form: the scene without its network, training
 * and formulation, and the reference. The same for every way to write the same scene. */
ad_status config_write_physics(const config *config, FILE *file);

/* Blame `key` for something found after reading: the line as of config_read. */
ad_status config_refuse(const config *config, const char *key, const char *problem,
                        ad_error *error);

/* May `now` go on where an experiment `before` has come to its stage `stage`? Stages not begun may
 * change, come and go; of the stage at work everything but the optimiser
 * and the memory of L-BFGS; name, checkpoint, output
 * and reference always. AD_BAD_INPUT names the first key that may not, and both values. */
ad_status config_continues(const config *before, const config *now, int stage, ad_error *error);

/* All keys by section: path, type, unit, default, range, help. */
void config_help(FILE *file);

#endif
