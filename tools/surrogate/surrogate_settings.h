/* The section `surrogate` of a scene: a one-step model of the robot, the state of its reduced rod a
 * sampling step later. What is left open is filled in by surrogate_settings_resolve. */
#ifndef SURROGATE_SURROGATE_SETTINGS_H
#define SURROGATE_SURROGATE_SETTINGS_H

#include "tools/train/train_settings.h"

/* Name in C, name in YAML; one row of surrogate_kind_names each. */
#define SURROGATE_KIND_LIST(X)                                                                     \
    X(SURROGATE_FLOW, "flow")     /* linear map + network, regression on solved steps */           \
    X(SURROGATE_LINEAR, "linear") /* the linear map alone */                                       \
    /* curves in time, learned from the rod's equations, a method of Radau: surrogate_curve.h */   \
    X(SURROGATE_POLYNOMIAL, "polynomial")
#define SURROGATE_HOLD_LIST(X)                                                                     \
    X(SURROGATE_CONSTANT, "constant") /* inputs stay while a step lasts */                         \
    X(SURROGATE_RAMP, "linear")       /* go linearly to those of its end */

#define SURROGATE_ENUM(name, text) name,
typedef enum surrogate_kind_id {
    SURROGATE_KIND_LIST(SURROGATE_ENUM) SURROGATE_KIND_COUNT
} surrogate_kind_id;
typedef enum surrogate_hold { SURROGATE_HOLD_LIST(SURROGATE_ENUM) } surrogate_hold;
#undef SURROGATE_ENUM
const char *const *surrogate_kind_names(void);

/* Texts belong to whoever fills them in. */
typedef struct surrogate_settings {
    double step; /* s; NaN: the scene has no such section */
    surrogate_kind_id kind;
    surrogate_hold hold;
    int modes[4];     /* bending, twist, stretch, shear; all 0: open */
    double tolerance; /* of the tip over the length, by which modes are chosen */
    int input_count, parameter_count;
    const char *inputs[SCENE_PARAMETERS_MAX];     /* actuated; none: all that are no parameters */
    const char *parameters[SCENE_PARAMETERS_MAX]; /* slow ones, which stay for a rollout */
    int solved;                                   /* steps to learn from */
} surrogate_settings;

surrogate_settings surrogate_settings_default(void);

/* Whether a scene has the section; whether a name is one of its parameters. */
bool surrogate_is_given(const surrogate_settings *settings);
bool surrogate_names_parameter(const surrogate_settings *settings, const char *name);

/* Whether a name is one of names [count]. */
bool surrogate_is_among(int count, const char *const *names, const char *name);

/* Fills in what is open, network and stages (where they are not given) among it, and checks.
 * AD_BAD_INPUT: `key` receives the key that is to blame, `error` the rest of the line. */
ad_status surrogate_settings_resolve(surrogate_settings *settings, train_settings *training,
                                     scene *rod_scene, char key[TRAIN_KEY_MAX], ad_error *error);

#endif
