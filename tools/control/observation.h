/* What sensors see of a reduced rod, as one_observation for a filter or a controller.
 *
 *   const observation_sensor sensor = {.what = OBSERVATION_POSITION, .count = 1, .s = &tip};
 *   observation_create(&scene, modes, &sensor, &x, &error);
 *   settings.sensor[0].observation = observation_of(x);
 *   observation_free(x);
 *
 * The state is that of physics/chain/reduced.h with these modes. */
#ifndef CONTROL_OBSERVATION_H
#define CONTROL_OBSERVATION_H

#include "physics/scene/scene.h"
#include "tools/control/kinematic_observation.h"

typedef struct observation_sensor {
    observation_what what;
    int count;       /* of places */
    const double *s; /* [count] m */
} observation_sensor;

typedef struct observation observation;

/* modes [4] as in reduced_settings. AD_BAD_INPUT: also a start that depends on t or inputs;
 * AD_BAD_ARGUMENT and others as reduced_create. */
ad_status observation_create(const scene *rod_scene, const int modes[4],
                             const observation_sensor *sensor, observation **result,
                             ad_error *error);
void observation_free(observation *observation); /* NULL is allowed */

/* Borrows x, which is for one thread at a time. */
one_observation observation_of(observation *observation);
const kinematic_observation *
observation_kinematics(const observation *observation); /* for exported C */

/* Of the first so many states alone the values depend: the modes, where no rates are seen. */
int observation_depends_on(const observation *observation);

/* For estimator_settings of a reduced rod with so many modes: deviation and process [2 modes] from
 * the sizes of states [2 modes], rms over motions of the rod. At the start modes are known to 2 %
 * of them. What the model leaves out changes modes by 0.1 % and rates by 2 % of their size in a
 * second: twice what 18 states leave out of 30 (a silicone arm that moves at up to 0.8 m/s, whose
 * filter is consistent with 1 %). Wrong loads or damping are ten to a hundred times more: adapt =
 * 100. */
void observation_noise(int modes, const double *size, double *deviation, double *process);

#endif
