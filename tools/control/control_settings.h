/* The section `control` of a scene: what a robot is to do, what is measured of it, and with which
 * model it is filtered and controlled. Numbers that are not given are NaN, texts NULL. */
#ifndef CONTROL_CONTROL_SETTINGS_H
#define CONTROL_CONTROL_SETTINGS_H

#include "tools/control/observation.h"
#include "tools/environment/environment_settings.h"
#include "tools/surrogate/surrogate_settings.h"

enum {
    CONTROL_INPUTS_MAX = SCENE_PARAMETERS_MAX,
    CONTROL_MEASUREMENTS_MAX = 8,
    CONTROL_POINTS_MAX = 64,
    CONTROL_LIMITS_MAX = 8,
    CONTROL_FAULTS_MAX = 16,
    CONTROL_CHANGES_MAX = 32,
    CONTROL_HEIGHTS = 8 /* waves of them around a path */
};

#define CONTROL_PATH_LIST(X)                                                                       \
    X(CONTROL_CIRCLE, "circle")                                                                    \
    X(CONTROL_EIGHT, "eight") X(CONTROL_POINTS, "points") X(CONTROL_FILE, "file")
#define CONTROL_SURFACE_LIST(X) X(CONTROL_PLANE, "plane") X(CONTROL_REACHABLE, "reachable")
#define CONTROL_MODEL_LIST(X)                                                                      \
    X(CONTROL_AUTOMATIC, "automatic")                                                              \
    X(CONTROL_SURROGATE, "surrogate") X(CONTROL_REDUCED, "reduced") X(CONTROL_LINEAR, "linear")
/* In the order of observation_what. */
#define CONTROL_SEEN_LIST(X)                                                                       \
    X(OBSERVATION_POSITION, "position")                                                            \
    X(OBSERVATION_ROTATION, "rotation")                                                            \
    X(OBSERVATION_DIRECTION, "direction")                                                          \
    X(OBSERVATION_VELOCITY, "velocity")                                                            \
    X(OBSERVATION_ANGULAR_VELOCITY, "angular_velocity")                                            \
    X(OBSERVATION_CURVATURE, "curvature") X(OBSERVATION_STRAIN, "strain")
#define CONTROL_LIMITED_LIST(X)                                                                    \
    CONTROL_SEEN_LIST(X) X(CONTROL_CLEARANCE, "clearance") /* from the environment */
#define CONTROL_FAULT_LIST(X)                                                                      \
    X(CONTROL_LOST, "lost")                                                                        \
    X(CONTROL_NOT_A_NUMBER, "nan") X(CONTROL_WILD, "wild") X(CONTROL_LATE, "late")
#define CONTROL_ENUM(value, text) value,

typedef enum control_path { CONTROL_PATH_LIST(CONTROL_ENUM) } control_path;
typedef enum control_surface { CONTROL_SURFACE_LIST(CONTROL_ENUM) } control_surface;
typedef enum control_model { CONTROL_MODEL_LIST(CONTROL_ENUM) } control_model;
typedef enum control_fault_kind { CONTROL_FAULT_LIST(CONTROL_ENUM) } control_fault_kind;

typedef struct control_point {
    double position[3]; /* m */
    double stay;        /* s */
} control_point;

typedef struct control_task {
    control_path path;
    double centre[3], normal[3]; /* m; of any length */
    control_surface surface;
    double heights[2 * CONTROL_HEIGHTS + 1]; /* m, along the unit normal: mean, then cos, sin of
                                              * multiples of the phase */
    double radius;                           /* m */
    double frequency;                        /* Hz */
    int point_count;
    control_point points[CONTROL_POINTS_MAX];
    double travel;    /* s from one point to the next */
    const char *file; /* absolute once read */
    double approach;  /* s */
} control_task;

typedef struct control_measurement {
    observation_what what;
    double at;       /* m */
    double noise;    /* standard deviation of each number, in its SI unit, rad */
    int every;       /* periods */
    int delay;       /* periods */
    double dropouts; /* part of them that is lost */
} control_measurement;

/* A number of what is seen of the rod that is kept in a range, as well as possible. */
enum { CONTROL_CLEARANCE = OBSERVATION_STRAIN + 1 }; /* of the whole rod: at least `low` */
typedef struct control_limit {
    int what;  /* observation_what, but for a rotation; CONTROL_CLEARANCE, once */
    double at; /* m */
    int axis;  /* 1 to 3 */
    double low, high;
} control_limit;

typedef struct control_fault {
    control_fault_kind kind;
    double from, lasts; /* s */
    int measurement;    /* from 0; -1: all */
} control_fault;

typedef struct control_settings {
    bool given; /* whether the scene has the section */
    double track_at;
    control_task task;
    double duration;
    double period;
    int horizon;
    control_model model;
    const char *residual; /* a file, absolute once read; NULL: the model as it is */
    double weight_rate, weight_effort;
    double accuracy; /* m; NAN: of the task (loop_create) */
    double offset;   /* 0 to 1: controller_settings.offset */
    int rate_count, low_count, high_count;
    double rate[CONTROL_INPUTS_MAX], low[CONTROL_INPUTS_MAX], high[CONTROL_INPUTS_MAX];
    environment_settings environment;
    double radius; /* of the robot, m */
    int limit_count;
    control_limit limits[CONTROL_LIMITS_MAX];
    int measurement_count;
    control_measurement measurements[CONTROL_MEASUREMENTS_MAX];
    int estimate_count;
    const char *estimate[CONTROL_INPUTS_MAX];
    int walk_count;
    double walk[CONTROL_INPUTS_MAX]; /* estimator_parameter.walk */
    int plant_modes[4];
    int change_count;
    const char *changes[CONTROL_CHANGES_MAX]; /* "key=value" */
    int delay;                                /* periods from a measurement to the input by it */
    int fault_count;
    control_fault faults[CONTROL_FAULTS_MAX];
    double tolerance_rms, tolerance_worst; /* m */
    int64_t seed;
} control_settings;

/* The resolved section `surrogate`, or where it is not given what the loop goes by in its place. */
surrogate_settings control_model_of(const surrogate_settings *given);

/* What a parameter with a range is to the loop. */
typedef enum control_role { CONTROL_INPUT, CONTROL_ESTIMATED, CONTROL_FIXED } control_role;
control_role control_role_of(const control_settings *settings, const surrogate_settings *model,
                             const char *name);

control_settings control_settings_default(void);

/* Of a scene and its one-step model, which may not be given: fills in what is open but for the
 * plane of the path, which the loop finds, and checks. estimate_given: also if it is empty.
 * AD_BAD_INPUT: `key` receives the key that is to blame, `error` the rest of the line. */
ad_status control_settings_resolve(control_settings *settings, const surrogate_settings *model,
                                   const scene *rod_scene, bool estimate_given,
                                   char key[TRAIN_KEY_MAX], ad_error *error);

#endif
