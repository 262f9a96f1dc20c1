/* What training is told besides the scene: network, points and weights of the loss, optimisers,
 * when to save, and what to compare with.
 *
 * train_settings_default leaves open what follows from the scene; train_settings_resolve fills that
 * in by the rules that were measured to be best. A program fills in what it wants to choose in
 * between. Fields are named in messages by their keys in a scene file, as "losses.interior.points".
 */
#ifndef TOOLS_TRAIN_TRAIN_SETTINGS_H
#define TOOLS_TRAIN_TRAIN_SETTINGS_H

#include "nn/nn.h"
#include "optim/optimizer.h"
#include "physics/learn/groups.h"
#include "physics/learn/problem.h"
#include "physics/scene/scene.h"
#include "physics/scene/view.h"
#include "tools/train/targets.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { TRAIN_STAGES_MAX = 32, TRAIN_KEY_MAX = 64 };

/* The value of an integer or a choice that is left open; of counts of points and steps it is 0, of
 * numbers NaN. */
enum { TRAIN_OPEN = -1 };

/* How a Gauss-Newton step is computed; tools/train/linear_model.h says what each form is. */
#define TRAIN_LINEAR_ALGEBRA_LIST(X)                                                               \
    X(TRAIN_LINEAR_AUTOMATIC, "automatic")                                                         \
    X(TRAIN_NORMAL_EQUATIONS, "normal_equations")                                                  \
    X(TRAIN_KERNEL, "kernel")                                                                      \
    X(TRAIN_MATRIX_FREE, "matrix_free")                                                            \
    X(TRAIN_SEPARATE, "separate")

/* A closed form that is known to solve the scene. */
#define TRAIN_REFERENCE_LIST(X)                                                                    \
    X(TRAIN_REFERENCE_NONE, "none")                                                                \
    X(TRAIN_REFERENCE_ELASTICA, "elastica")                                                        \
    X(TRAIN_REFERENCE_ROLLUP, "rollup")                                                            \
    X(TRAIN_REFERENCE_HELIX, "helix")                                                              \
    X(TRAIN_REFERENCE_MANUFACTURED, "manufactured")

#define TRAIN_ENUM(name, text) name,
typedef enum train_linear_algebra {
    TRAIN_LINEAR_ALGEBRA_LIST(TRAIN_ENUM) TRAIN_LINEAR_ALGEBRA_COUNT
} train_linear_algebra;
typedef enum train_reference { TRAIN_REFERENCE_LIST(TRAIN_ENUM) } train_reference;
#undef TRAIN_ENUM

/* Texts of each enumeration in the order of its values, NULL at the end. */
const char *const *train_linear_algebra_names(void);
const char *const *train_reference_names(void);
const char *const *train_targets_names(void);

/* One optimiser for a number of steps; stages run in turn. */
typedef struct train_stage {
    optim_settings optim; /* method, steps, learning_rate, warmup_steps, clip_norm and
                           * function_tolerance of train_settings_default: open (TRAIN_OPEN, NaN);
                           * decay_steps 0: the steps after warm-up; scaling TRAIN_OPEN,
                           * initial_damping and defaults that are a method's own NaN: open */
    int steps;
    targets_kind targets;                /* of a family in the strain form */
    train_linear_algebra linear_algebra; /* of gauss_newton */
    double stop_loss;                    /* the stage ends when the loss falls below; 0: never */
    double stop_error;                   /* the same for the error against the reference */
    double stop_seconds;                 /* and for its wall time; not reproducible */
    double stop_held_out_ratio; /* held-out over training loss of a network that interpolates */
} train_stage;

/* What is measured, as the columns x to z, qw to qz, v1 to v3, u1, n1, m1, vx, w1 of a rod, w,
 * slope, V, M, w_t, slope_t of a beam. */
#define TRAIN_QUANTITY_LIST(X)                                                                     \
    X(TRAIN_POSITION, "position")                                                                  \
    X(TRAIN_ROTATION, "rotation")                                                                  \
    X(TRAIN_STRAIN, "strain")                                                                      \
    X(TRAIN_CURVATURE, "curvature")                                                                \
    X(TRAIN_FORCE, "force")                                                                        \
    X(TRAIN_MOMENT, "moment")                                                                      \
    X(TRAIN_VELOCITY, "velocity")                                                                  \
    X(TRAIN_ANGULAR_VELOCITY, "angular_velocity")
#define TRAIN_ENUM(name, text) name,
typedef enum train_quantity { TRAIN_QUANTITY_LIST(TRAIN_ENUM) TRAIN_QUANTITY_COUNT } train_quantity;
#undef TRAIN_ENUM
const char *const *train_quantity_names(void);

enum { TRAIN_DATA_MAX = 32 };

/* What of the distances is least: squares, or the logarithm of Cauchy's distribution, by which few
 * that are far off count little. */
#define TRAIN_LOSS_LIST(X)                                                                         \
    X(TRAIN_SQUARES, "squares")                                                                    \
    X(TRAIN_CAUCHY, "cauchy")
#define TRAIN_ENUM(name, text) name,
typedef enum train_loss { TRAIN_LOSS_LIST(TRAIN_ENUM) } train_loss;
#undef TRAIN_ENUM

/* A file of measurements (tools/train/measurements.h). */
typedef struct train_data {
    const char *file;
    const char *columns;     /* lines "name=formula of the file's columns"; NULL: as they are */
    int from, to, every;     /* rows that count, from 1; to 0: the last */
    const char *where;       /* those where this formula of the file's columns is > 0; NULL: all */
    scene_view view;         /* how the rod is seen */
    train_loss robust;       /* of the distances */
    int marker_count;        /* of view.marker */
    double rate;             /* rows a second, where no column is t; 0: not known */
    int held_out;            /* 1: judged after the fit, not fitted */
    train_quantity quantity; /* TRAIN_OPEN: not given */
    double noise;            /* standard deviation of a number, SI; 0: not known */
    double weight;           /* of the term; NaN: open */
} train_data;

/* Texts belong to whoever fills them in and must outlive the training. */
typedef struct train_settings {
    const char *name;          /* of the experiment; may be NULL */
    nn_mlp_settings network;   /* inputs and outputs follow from the scene; hidden_count,
                                * fourier_features and degree TRAIN_OPEN: open; range follows */
    double fourier_wavenumber; /* largest along s; rad/m; NaN: open */
    double fourier_frequency;  /* largest in time; rad/s; NaN: open, and in a static scene */
    double fourier_parameters; /* largest along parameters with ranges, radians in half of one (of
                                * its logarithm); NaN: open */
    int windows;               /* of time, scene.windows; 0: open */
    int rotation;              /* of the network, a scene_rotation; TRAIN_OPEN: open */
    groups_settings groups;    /* inputs of the network of a family */
    int modes[4];              /* of one motion in the strain form: bending, twist, stretch, shear;
                                * all 0: open */
    double tolerance;          /* of the estimated error, of the length, for the verdict; modes and
                                * degree of one motion in the strain form are as large as it takes;
                                * NaN: not given */
    rod_weights weights;       /* of the loss terms */
    problem_settings losses;   /* points of the interior, the boundary and held out and
                                * adaptive.every 0, the sampler
                                * of the interior TRAIN_OPEN: open */
    int members;               /* solved ones of a family in the strain form; 0: open */
    const char *members_file;  /* or a table of them, a column for each parameter; NULL: none */
    const char *data_folder; /* where relative files are while they are read; NULL: at the scene */
    int data_count;
    train_data data[TRAIN_DATA_MAX];
    uint64_t seed; /* fixes everything random */
    int stage_count;
    train_stage stages[TRAIN_STAGES_MAX];
    int checkpoint_every;      /* steps */
    double checkpoint_seconds; /* or after so much wall time, whichever is first */
    int checkpoint_keep;       /* how many checkpoints are kept */
    int output_every;          /* steps between rows of the history; 0: open */
    train_reference reference;
    const char *reference_file;    /* CSV or HDF5 with the model's columns of position and rotation;
                                    * NULL: none */
    double reference_tolerance;    /* of a classical solution, of the position over the length; 0:
                                    * open, NaN: no such reference */
    quantity reference_deflection; /* of a beam, formula of s and t; not given: none */
    const ad_ranks *ranks;         /* borrowed; processes that share the training; NULL: none */
} train_settings;

/* The measured recipe: random waves and one stage of Gauss-Newton, up to 200 steps, in as many
 * windows of time as the scene needs; no reference. */
train_settings train_settings_default(void);

/* A stage of adam with its defaults; and the one of scenes that give none. */
train_stage train_stage_default(void);
train_stage train_usual_stage(void);

/* Fills in what train_stage_default leaves to the method. */
void train_close_own(train_stage *stage);

/* Fills in what train_settings_default leaves open of its one stage: from the usual stage of a kind
 * of scene, or where an optimiser was chosen from train_stage_default. */
void train_close_stage(train_stage *stage, train_stage usual);

/* Whether the stage's optimiser is this one or open. */
bool train_may_take(const train_stage *stage, optim_method optimizer);

/* Fill in what is open of data and reference, which a network of the scene has no part in. */
void train_close_compared(train_settings *settings, const scene *rod_scene);

/* Fill in what else is open, from a scene that passes scene_check and loads in SI; sets windows and
 * rotation of the scene as well. AD_BAD_INPUT: `key` receives the key of the field that is to
 * blame, `error` the rest of the line. Doing it again changes nothing. */
ad_status train_settings_resolve(train_settings *settings, scene *rod_scene,
                                 char key[TRAIN_KEY_MAX], ad_error *error);

/* The same for physics of one's own: waves and points by the number of coordinates, in one window,
 * without a reference. fourier_wavenumber, in radians per unit of the SI, counts for every
 * coordinate but time. */
ad_status train_settings_resolve_model(train_settings *settings, const physics_model *m,
                                       char key[TRAIN_KEY_MAX], ad_error *error);

/* Whether settings contradict each other or the scene, and whether the reference is one of this
 * scene; both have to be resolved. Errors as above. */
ad_status train_settings_check(const train_settings *settings, const scene *rod_scene,
                               char key[TRAIN_KEY_MAX], ad_error *error);

/* The same for physics of one's own. */
ad_status train_settings_check_model(const train_settings *settings, const physics_model *m,
                                     char key[TRAIN_KEY_MAX], ad_error *error);

/* Of that the reference alone; and that there are files of all data. */
ad_status train_check_reference(const train_settings *settings, const scene *rod_scene,
                                char key[TRAIN_KEY_MAX], ad_error *error);
ad_status train_check_data(const train_settings *settings, char key[TRAIN_KEY_MAX],
                           ad_error *error);

bool train_names_reference(const train_settings *settings);

/* Whether training may come to the loads in parts, optim/continuation.h: at rest, where a network
 * without hidden layers is found by Gauss-Newton from 0, the unloaded rod. */
bool train_takes_loads_in_parts(const train_settings *settings, const scene *rod_scene);

#ifdef __cplusplus
}
#endif

#endif
