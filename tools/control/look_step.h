/* What sensors see of a reduced rod, with derivatives by its state: plain C without library but
 * libm, nothing is allocated. Exported C contains this very text; look.h makes it from a scene. */
#ifndef CONTROL_LOOK_STEP_H
#define CONTROL_LOOK_STEP_H

#include "physics/solve/kinematics.h"

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

/* Values are those of items, one behind the other; each is something at one of the rod's places. */
typedef struct look_item {
    int what, place;
    int row; /* first of its three in `rod.row`, which has those of looks alone */
} look_item;

typedef struct look_step {
    kinematics rod;
    int items, values;
    const look_item *item; /* [items] */
} look_step;

/* 3, or 4; and which rows of kinematics.h, from the first on of a place. */
int look_step_values(int what);
int look_step_row(int what);

/* Doubles of room for look_step_see, which is for one call at a time. */
size_t look_step_room(const look_step *x);

/* As one_look.see (one_step.h), inputs are not needed: values [count][values], by_state (or NULL)
 * [count][values][states]. Not 0: something seen is not finite. */
int look_step_see(const look_step *x, double *room, int count, const double *states, double *values,
                  double *by_state);

#ifdef __cplusplus
}
#endif

#endif
