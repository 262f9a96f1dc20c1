/* An experiment: the YAML file, read and checked. What it leaves open to measurements, as the size
 * of a network, stays open, and nothing is solved: that is tools/prepare/prepare.h.
 *
 * One table of keys (config_keys.c) holds path, type, unit, default, range and help of every key
 * and drives the reader, --set, --help, --print-config and the resolved config.yaml of a run. */
#ifndef TOOLS_CONFIG_CONFIG_H
#define TOOLS_CONFIG_CONFIG_H

#include "tools/control/control_settings.h"
#include "tools/optimize/optimize_settings.h"
#include "tools/plan/plan_settings.h"
#include "tools/train/learned_file.h"
#include "tools/train/train_settings.h"

#include <stdio.h>

/* Units of the forces and moments under loads: SI, or EI/L^3, EI/L^2 (distributed force, moment)
 * and EI/L^2, EI/L (at the ends), EI the bending stiffness about d1 and L the length. */
typedef enum config_load_units { CONFIG_UNITS_SI, CONFIG_UNITS_EI } config_load_units;

enum { CONFIG_PARAMETERS_MAX = 64, CONFIG_PARAMETER_BYTES = 48 };

enum { CONFIG_SCALE_OPEN = -1 };

/* A name for the formulas of the scene. One with a range stays open in them: the scene is then a
 * family (scene.parameters), and what needs one member of it asks config_read_member. */
typedef struct config_parameter {
    char name[CONFIG_PARAMETER_BYTES];
    quantity value;  /* not given beside a range */
    double range[2]; /* NaN: a value */
    int scale;       /* scene_scale of the range; CONFIG_SCALE_OPEN: not given */
    double identify; /* where the search for an unknown begins; NaN: it is none */
    bool of_key;     /* named after a key that has a range in place of a number */
} config_parameter;

enum { CONFIG_TABLES_MAX = 16 };

/* A function of one argument for the formulas of the scene, by its name. */
typedef struct config_table {
    const char *name;
    const char *file; /* relative to the YAML file; NULL once read */
    int x_count, y_count;
    double x[QUANTITY_TABLE_MAX], y[QUANTITY_TABLE_MAX];
} config_table;

/* The law of rod.law; `file` is NULL once read. */
typedef struct config_law {
    const char *file;
    int count; /* of its numbers; 0: the rod is linear */
    double numbers[SCENE_LAW_NUMBERS_MAX];
    scene_law law; /* that the scene points to */
} config_law;

/* Names of formulas that a network says of what is known; without a file they are 0. */
typedef struct config_residual {
    const char *outputs; /* lines "name=how large it may be"; NULL: none */
    int input_count;     /* 0: all parameters that are known */
    const char *inputs[LEARNED_INPUTS_MAX];
    int formula_count; /* those of the file, else the inputs */
    quantity formula[LEARNED_INPUTS_MAX];
    int hidden_count, hidden[LEARNED_LAYERS_MAX];
    const char *file;    /* relative to the YAML file, absolute once read; NULL: not learned */
    learned_file *saved; /* what it holds */
} config_residual;

typedef struct config {
    quantities *names; /* of the formulas of the scene */
    int table_count;
    config_table tables[CONFIG_TABLES_MAX];
    config_law law;
    config_residual residual;
    int parameter_count;
    config_parameter parameters[CONFIG_PARAMETERS_MAX]; /* in their order */
    struct scene scene;      /* loads in SI, whatever the YAML scaled; what section and material
                              * determine is left to scene_properties_of */
    bool is_mapped;          /* the scene is what scene_map made of */
    struct scene as_written; /* this one */
    bool is_chosen;          /* what trains a network of it (prepare_training) */
    train_settings settings; /* reference_file is relative to the YAML file, absolute once read */
    surrogate_settings surrogate;
    control_settings control;     /* task.file as settings.reference_file */
    plan_settings plan;           /* file as settings.reference_file */
    optimize_settings optimize;   /* its file as settings.reference_file */
    config_load_units load_units; /* SI once read: the scene's loads are already converted */
    struct config_source *source; /* texts and places; opaque */
} config;

/* Read `path` (or `text` of that name when text is not NULL), then apply `count` overrides
 * "key=value" in order; the value is YAML, so lists are [a, b], and null takes a key, or every
 * key of a section, back to its default. Keys of a list count from 0: training.stages[0].steps,
 * loads.tip.force[2]. Everything is checked, formulas and contradictions included. On failure
 * *config is NULL and error->message is the whole line: `file:line:column: key: what is wrong; what
 * is allowed`, where
 * `--set key=value` stands for file:line:column when the override is to blame.
 * AD_BAD_INPUT, AD_IO (file), AD_NO_MEMORY. The overrides are not kept. */
ad_status config_read(const char *path, const char *text, int count, const char *const *overrides,
                      config **config, ad_error *error);
/* The same of one member of a family, `at` its place as "tension=2, stiffness=1": every parameter
 * that has a range has to be given, within it. `at` NULL: none, so that a file with such
 * parameters is refused. */
ad_status config_read_member(const char *path, const char *text, int count,
                             const char *const *overrides, const char *at, config **config,
                             ad_error *error);
/* The same of a scene and settings that a program has filled in, whose texts are copied: checked,
 * so that it can be written like one of a file. The end s = length is of the type
 * that the scene says. Keys stand in messages behind settings->name, or "scene". */
ad_status config_create(const scene *rod_scene, const train_settings *settings, config **result,
                        ad_error *error);
void config_free(config *config);

/* A prepared experiment as YAML, every default filled in, each key with its help as a comment
 * when `help` is set. Stiffness and inertia that follow from section and material stay null, with
 * their numbers as a comment. Reading it back gives the same experiment. */
ad_status config_write(const config *config, FILE *file, bool help);

/* What a classical solution depends on, in the same form: the scene without its network, training
 * and formulation, and the reference. The same for every way to write the same scene. */
ad_status config_write_physics(const config *config, FILE *file);

/* Whether a key was given; whether any of `control`, of `plan` was. */
bool config_gives(const config *config, const char *key);
bool config_controls(const config *config);
bool config_plans(const config *config);

/* Keys of stages against their optimisers, once these are chosen. AD_BAD_INPUT as config_read. */
ad_status config_check_stages(const config *config, ad_error *error);

/* `work` where numbers have a point, whatever the user's language. */
typedef ad_status config_work(config *config, const void *context, ad_error *error);
ad_status config_with_points(config *config, config_work *work, const void *context,
                             ad_error *error);

/* The next output of residual: its name and how large it may be, `length` characters of a line;
 * `lines` goes on behind it. False: there is none. */
bool config_residual_output(const char **lines, char name[CONFIG_PARAMETER_BYTES],
                            const char **size, size_t *length);

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
