/* What the files of robots in steps share; not installed. */
#ifndef TOOLS_LIBRARY_STEPPER_H
#define TOOLS_LIBRARY_STEPPER_H

#include "tools/library/cpinn.h"
#include "tools/prepare/config_surrogate.h"

/* States that a thread takes at a time: eight vectors of eight. */
enum { STEPPER_MEMBERS = 64 };

/* Of one thread. */
typedef struct stepper_worker {
    one_step model;
    reduced_rod *rod; /* looked at in its tip */
    kinematics tip;
    double *seen, *room; /* [STEPPER_MEMBERS][KINEMATICS_SEEN], [kinematics_room] */
} stepper_worker;

struct cpinn_stepper {
    surrogate *trained; /* NULL: the reduced rod itself, */
    config *settings;   /* of these */
    const scene *scene;
    const surrogate_settings *given; /* modes, which inputs are slow, how they move in a step */
    double step;
    int states, inputs;
    ad_pool *pool;
    stepper_worker *workers; /* [threads] */
};

/* Of at most STEPPER_MEMBERS states, by one thread. next: not numbers of those without an answer.
 * cpinn_stepper_see leaves what it sees in worker->seen. */
void cpinn_stepper_take(const cpinn_stepper *stepper, const stepper_worker *worker, int members,
                        const double *states, const double *inputs, const double *after,
                        double *next, double *by_state, double *by_inputs);
void cpinn_stepper_see(const stepper_worker *worker, int members, const double *states);

#endif
