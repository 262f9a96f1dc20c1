/* What sensors see of a reduced rod, from its kinematics (physics/chain/kinematics.h). Needs no
 * library and allocates nothing: exported C has this very text. */
#ifndef CONTROL_KINEMATIC_OBSERVATION_H
#define CONTROL_KINEMATIC_OBSERVATION_H

#include "physics/chain/kinematics.h"
#include "physics/local/one_step.h"

typedef enum observation_what {
    OBSERVATION_POSITION,  /* 3, m, world */
    OBSERVATION_ROTATION,  /* 4, unit quaternion, body to world; estimator_sensor.rotations */
    OBSERVATION_DIRECTION, /* 3, director d3 of the section, world: what a sensor of 5 coordinates
                            * sees */
    OBSERVATION_VELOCITY,  /* 3, m/s, world */
    OBSERVATION_ANGULAR_VELOCITY, /* 3, 1/s, body: a gyroscope */
    OBSERVATION_CURVATURE,        /* 3, 1/m, body: bending about d1, d2, twist */
    OBSERVATION_STRAIN            /* 3: shear along d1, d2, stretch v (1 at rest) */
} observation_what;

enum { OBSERVATION_ROWS = 3 }; /* rows of derivatives of a place that each of them needs */

/* All is borrowed. */
typedef struct kinematic_observation {
    observation_what what;
    kinematics rod; /* its rows are those of kinematic_observation_row at each place */
    int more;       /* states behind those of the rod, on which nothing depends */
    double *room;   /* [kinematic_observation_room] */
} kinematic_observation;

/* The first of OBSERVATION_ROWS rows of KINEMATICS_ROWS. */
int kinematic_observation_row(observation_what what);
size_t kinematic_observation_room(const kinematics *rod);

/* Values [places][3 or 4]; one call at a time. Derivatives of a rotation are those of the
 * quaternion. No answer where a value is not finite. */
one_observation kinematic_observation_of(kinematic_observation *observation);

#endif
