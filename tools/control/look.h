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
#include "tools/control/kinematic_look.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct look_sensor {
    look_what what;
    int count;       /* of places */
    const double *s; /* [count] m */
} look_sensor;

typedef struct look look;

/* modes [4] as in reduced_settings. AD_BAD_INPUT: also a start that depends on t or inputs;
 * AD_BAD_ARGUMENT and others as reduced_create. */
ad_status look_create(const scene *rod_scene, const int modes[4], const look_sensor *sensor,
                      look **result, ad_error *error);
void look_free(look *look); /* NULL is allowed */

/* Borrows x, which is for one thread at a time. */
one_look look_of(look *look);
const kinematic_look *look_kinematics(const look *look); /* for exported C */

/* Of the first so many states alone the values depend: the modes, where no rates are seen. */
int look_depends_on(const look *look);

/* For estimator_settings of a reduced rod with so many modes: deviation and process [2 modes] from
 * the sizes of states [2 modes], rms over motions of the rod. At the start modes are known to 2 %
 * of them. What the model leaves out changes modes by 0.1 % and rates by 2 % of their size in a
 * second: twice what 18 states leave out of 30 (a silicone arm that moves at up to 0.8 m/s, whose
 * filter is consistent with 1 %). Wrong loads or damping are ten to a hundred times more: adapt =
 * 100. */
void look_noise(int modes, const double *size, double *deviation, double *process);

#ifdef __cplusplus
}
#endif

#endif
