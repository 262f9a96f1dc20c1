/* The section `plan` of a scene: what a robot must not touch, and where it is to go. Numbers that
 * are not given are NaN, texts NULL. */
#ifndef PLAN_PLAN_SETTINGS_H
#define PLAN_PLAN_SETTINGS_H

#include "physics/scene/scene.h"

#include <stdint.h>

enum { PLAN_ACTUATORS_MAX = 16, PLAN_VARIABLES_MAX = PLAN_ACTUATORS_MAX + 2, PLAN_UNKNOWN_MAX = 3 };

#define PLAN_UNIT_LIST(X) X(PLAN_M, "m", 1) X(PLAN_CM, "cm", 1e-2) X(PLAN_MM, "mm", 1e-3)
/* In the order of environment_side. */
#define PLAN_SIDE_LIST(X)                                                                          \
    X(PLAN_INSIDE, "inside")                                                                       \
    X(PLAN_OUTSIDE, "outside") X(PLAN_ANY_SIDE, "any")
#define PLAN_METHOD_LIST(X)                                                                        \
    X(PLAN_RRT_CONNECT, "rrt_connect")                                                             \
    X(PLAN_RRT_STAR, "rrt_star") X(PLAN_PRM, "prm")
#define PLAN_ENUM(value, ...) value,

typedef enum plan_unit { PLAN_UNIT_LIST(PLAN_ENUM) } plan_unit;
typedef enum plan_side { PLAN_SIDE_LIST(PLAN_ENUM) } plan_side;
typedef enum plan_method { PLAN_METHOD_LIST(PLAN_ENUM) } plan_method;

typedef struct plan_settings {
    const char *file; /* absolute once read */
    plan_unit unit;
    plan_side side;
    double position[3], rotation[4]; /* of the surface in the scene's axes: m, quaternion */
    double radius;                   /* of the robot, m */
    double from;                     /* s from which on it must not touch, m */
    double clearance;                /* m */
    int actuator_count, fixed_count, unknown_count;
    const char *actuators[PLAN_ACTUATORS_MAX]; /* parameters that move; none: all of them */
    const char *fixed[SCENE_PARAMETERS_MAX];   /* "name=value" of the others */
    const char *unknown[PLAN_UNKNOWN_MAX];     /* that may have any value of their ranges */
    double slide[2], turn[2];                  /* m, rad: of the base along and about its axis */
    int start_count, goal_count;
    double start[PLAN_VARIABLES_MAX], goal[PLAN_VARIABLES_MAX]; /* actuators, slide, turn */
    double goal_position[3], goal_tolerance;                    /* of the tip, m */
    plan_method method;
    int states; /* that are tried at most */
    int64_t seed;
} plan_settings;

plan_settings plan_settings_default(void);

#endif
