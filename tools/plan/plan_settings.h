/* The section `plan` of a scene: what a robot must not touch, and where it is to go. Numbers that
 * are not given are NaN, texts NULL. */
#ifndef PLAN_PLAN_SETTINGS_H
#define PLAN_PLAN_SETTINGS_H

#include "physics/scene/scene.h"
#include "tools/environment/environment_settings.h"

#include <stdint.h>

enum {
    PLAN_ACTUATORS_MAX = 16,
    PLAN_VARIABLES_MAX = PLAN_ACTUATORS_MAX + 2,
    PLAN_UNKNOWN_MAX = 3,
    PLAN_GOALS_MAX = 16
};

#define PLAN_METHOD_LIST(X)                                                                        \
    X(PLAN_RRT_CONNECT, "rrt_connect")                                                             \
    X(PLAN_RRT_STAR, "rrt_star") X(PLAN_PRM, "prm")
#define PLAN_ENUM(value, ...) value,

typedef enum plan_method { PLAN_METHOD_LIST(PLAN_ENUM) } plan_method;

/* Where to go. */
typedef struct plan_goal {
    int count;                            /* of actuators; 0: a place of the tip */
    double actuators[PLAN_VARIABLES_MAX]; /* and slide, turn */
    double position[3], tolerance;        /* m */
    double direction[3], angle;           /* of the rod at its tip, any: NaN; off by so much, rad */
} plan_goal;

typedef struct plan_settings {
    environment_settings environment;
    double radius;    /* of the robot, m */
    double from;      /* s from which on it must not touch, m */
    double clearance; /* m */
    int actuator_count, fixed_count, unknown_count;
    const char *actuators[PLAN_ACTUATORS_MAX]; /* parameters that move; none: all of them */
    const char *fixed[SCENE_PARAMETERS_MAX];   /* "name=value" of the others */
    const char *unknown[PLAN_UNKNOWN_MAX];     /* that may have any value of their ranges */
    double slide[2], turn[2];                  /* m, rad: of the base along and about its axis */
    int start_count, goal_count;
    double start[PLAN_VARIABLES_MAX]; /* actuators, slide, turn */
    plan_goal goal;
    plan_goal goals[PLAN_GOALS_MAX]; /* [goal_count], in place of one; in this order */
    const char *roadmap; /* a file in place of the method; absolute once read, NULL: none */
    int roadmap_nodes;
    plan_method method;
    int states; /* that are tried at most, for each goal */
    int64_t seed;
} plan_settings;

plan_settings plan_settings_default(void);

#endif
