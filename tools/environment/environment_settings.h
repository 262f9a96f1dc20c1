/* What a scene says of the surface that a robot must not touch. */
#ifndef ENVIRONMENT_ENVIRONMENT_SETTINGS_H
#define ENVIRONMENT_ENVIRONMENT_SETTINGS_H

#define ENVIRONMENT_UNIT_LIST(X)                                                                   \
    X(ENVIRONMENT_M, "m", 1) X(ENVIRONMENT_CM, "cm", 1e-2) X(ENVIRONMENT_MM, "mm", 1e-3)
/* inside of a closed surface, or around it; any: of one that may be open, on the side on which the
 * robot starts */
#define ENVIRONMENT_SIDE_LIST(X)                                                                   \
    X(ENVIRONMENT_INSIDE, "inside")                                                                \
    X(ENVIRONMENT_OUTSIDE, "outside") X(ENVIRONMENT_ANY, "any")
#define ENVIRONMENT_ENUM(value, ...) value,

typedef enum environment_unit { ENVIRONMENT_UNIT_LIST(ENVIRONMENT_ENUM) } environment_unit;
typedef enum environment_side { ENVIRONMENT_SIDE_LIST(ENVIRONMENT_ENUM) } environment_side;

typedef struct environment_settings {
    const char *file; /* .stl, .obj; absolute once read, NULL: not given */
    environment_unit unit;
    environment_side side;
    double position[3], rotation[4]; /* of the file in the scene's axes: m, quaternion */
} environment_settings;

#define ENVIRONMENT_DEFAULT ((environment_settings){.rotation = {1, 0, 0, 0}})

#endif
