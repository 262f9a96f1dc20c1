/* What sensors see of a reduced rod, from its kinematics (physics/solve/kinematics.h). Needs no
 * library and allocates nothing: exported C has this very text. */
#ifndef CONTROL_KINEMATIC_LOOK_H
#define CONTROL_KINEMATIC_LOOK_H

#include "physics/solve/kinematics.h"
#include "physics/solve/one_step.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum look_what {
    LOOK_POSITION,         /* 3, m, world */
    LOOK_ROTATION,         /* 4, unit quaternion, body to world; estimator_sensor.rotations */
    LOOK_DIRECTION,        /* 3, director d3 of the section, world: what a sensor of 5 coordinates
                            * sees */
    LOOK_VELOCITY,         /* 3, m/s, world */
    LOOK_ANGULAR_VELOCITY, /* 3, 1/s, body: a gyroscope */
    LOOK_CURVATURE,        /* 3, 1/m, body: bending about d1, d2, twist */
    LOOK_STRAIN            /* 3: shear along d1, d2, stretch v (1 at rest) */
} look_what;

enum { LOOK_ROWS = 3 }; /* rows of derivatives of a place that each of them needs */

/* All is borrowed. */
typedef struct kinematic_look {
    look_what what;
    kinematics rod; /* its rows are those of kinematic_look_row at each place */
    double *room;   /* [kinematic_look_room] */
} kinematic_look;

/* The first of LOOK_ROWS rows of KINEMATICS_ROWS. */
int kinematic_look_row(look_what what);
size_t kinematic_look_room(const kinematics *rod);

/* Values [places][3 or 4]; one call at a time. Derivatives of a rotation are those of the
 * quaternion. No answer where a value is not finite. */
one_look kinematic_look_of(kinematic_look *look);

#ifdef __cplusplus
}
#endif

#endif
