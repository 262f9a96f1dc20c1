/* What sensors see of a reduced rod, as one_look for a filter or a controller.
 *
 *   const look_sensor sensor = {.what = LOOK_POSITION, .count = 1, .s = &tip};
 *   look_create(&scene, modes, &sensor, &x, &error);
 *   settings.sensor[0].look = look_of(x);
 *   look_free(x);
 *
 * The state is that of physics/solve/reduced.h with these modes. */
#ifndef CONTROL_LOOK_H
#define CONTROL_LOOK_H

#include "physics/scene.h"
#include "tools/control/one_step.h"

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

typedef struct look_sensor {
    look_what what;
    int count;       /* of places */
    const double *s; /* [count] m */
} look_sensor;

typedef struct look look;

/* modes [4] as in reduced_settings. AD_BAD_INPUT, AD_BAD_ARGUMENT and others as reduced_create. */
ad_status look_create(const scene *rod_scene, const int modes[4], const look_sensor *sensor,
                      look **result, ad_error *error);
void look_free(look *x); /* NULL is allowed */

/* Values [count][what's]; borrows x, which is for one thread at a time. Of LOOK_ROTATION by_state
 * has the derivatives of the quaternion. */
one_look look_of(look *x);

/* Of the first so many states alone the values depend: the modes, where no rates are seen. */
int look_depends_on(const look *x);

/* The reduced rod itself as a model; borrows the reduced rod. */
struct reduced_rod;
one_step look_reduced_rod(struct reduced_rod *rod, double step);

#ifdef __cplusplus
}
#endif

#endif
