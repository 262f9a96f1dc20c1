/* A closed loop in simulation: the plant, sensors with rates, noise, delays and losses of their
 * own, the filter, the controller, and a record of all of it.
 *
 *   loop_create(&setup, &loop, &error);
 *   loop_run(loop, &report, &error);
 *   loop_free(loop);
 *
 * At sample k what has arrived is filtered and inputs are computed, which act from the sample
 * control->delay later on. With a period shorter than the step of the model there are as many
 * controllers as periods in a step, which take turns: each plans in steps of the model and has its
 * own plan of one step ago to start from. The same setup gives the same bits but for times. */
#ifndef CONTROL_LOOP_H
#define CONTROL_LOOP_H

#include "tools/control/clearance_observation.h"
#include "tools/control/control_settings.h"
#include "tools/control/linear_step.h"
#include "tools/control/plant.h"
#include "tools/control/regulator.h"
#include "tools/control/residual.h"
#include "tools/control/task_observation.h"
#include "tools/files/table_shapes.h"

typedef struct control_loop control_loop;

/* Everything is borrowed. */
typedef struct loop_setup {
    const control_settings *control; /* resolved */
    const surrogate_settings *model; /* resolved, or of control_model_of */
    const scene *nominal;            /* whose parameters with ranges are inputs */
    const scene *plant;              /* with control->changes */
    const double *truth;             /* [parameters of nominal] what they are in the plant; NaN: not
                                      * known */
    const one_step *surrogate;       /* for CONTROL_SURROGATE */
    const surroundings *around;      /* for a constrained clearance; NULL: none */
    const one_step *inner; /* the same in steps of a shorter period; NULL: surrogate's own */
} loop_setup;

/* Flags of all samples: of estimator.h, of controller.h, and what the loop did. */
enum { LOOP_FLAGS = 12 };
enum { LOOP_SQUARE, LOOP_BIAS, LOOP_CORRELATION, LOOP_BOUNDS };

typedef struct loop_report {
    long samples, done, judged; /* asked for; simulated before it ended; after the approach */
    bool diverged;              /* the place was a rod's length off, or the plant failed */
    double rms, worst;          /* m, of the true place off the path, after the approach */
    double approach;            /* m, worst before */
    double reach, reach_worst;  /* m, rms and at most: what the path is off where the place can be
                                 * at rest */
    double modes, modes_worst;  /* m, rms and at most: what the modes of the plant leave out of the
                                 * place, by one more of each; NaN: not known */
    double filter[2], control[2], both[2]; /* s a period: median, worst */
    double saturated;                      /* part of the samples with an input at a limit */
    /* Of the ranges of the inputs, from one sample to the next: mean and worst change, and the mean
     * of half the second difference, of which smooth motions have little. */
    double change[2], jitter;
    double violation[CONTROL_LIMITS_MAX]; /* worst, of each constraint, in its unit; 0: none */
    double violated[CONTROL_LIMITS_MAX];  /* part of the samples */
    double innovation[CONTROL_MEASUREMENTS_MAX]; /* mean normalised square of each sensor: 1 */
    /* Of the filter's windows, what part is beyond each bound of estimator_consistency, of the
     * sensor with most: mean square, bias, correlation; and estimator_doubt at the end. */
    double beyond[LOOP_BOUNDS], doubt;
    double estimate[CONTROL_INPUTS_MAX]; /* at the end, of control->estimate */
    double deviation[CONTROL_INPUTS_MAX];
    double truth[CONTROL_INPUTS_MAX];
    residual_reach residual; /* m, of control->residual; NaN: there is none */
    long filter_flags[LOOP_FLAGS], control_flags[LOOP_FLAGS], late; /* samples */
} loop_report;

/* AD_BAD_INPUT: what the loop cannot do, in a sentence; AD_NOT_FINITE: no equilibrium to start
 * from; AD_IO, AD_NO_MEMORY. */
ad_status loop_create(const loop_setup *setup, control_loop **result, ad_error *error);
void loop_free(control_loop *loop); /* NULL is allowed */

ad_status loop_run(control_loop *loop, loop_report *report, ad_error *error);

/* The task with centre, normal and heights that were found. */
const control_task *loop_task(const control_loop *loop);

/* What exported C is made of; borrowed from the loop. */
typedef struct loop_parts {
    const regulator_settings *settings;
    const linear_step *linear[2]; /* by samples, by steps of the horizon; NULL: another model */
    const kinematic_observation *sensors[CONTROL_MEASUREMENTS_MAX];
    const task_observation *seen;
    const kinematic_observation *observations[1 + CONTROL_LIMITS_MAX]; /* of its parts */
    const clearance_observation *clearance; /* of the one of them that is this; NULL: none */
    int clearance_part;
    const double *state, *inputs, *by_parameters; /* at sample 0 */
} loop_parts;
loop_parts loop_parts_of(const control_loop *loop);

/* The record: columns named, of report.done rows; SI units. */
int loop_columns(const control_loop *loop);
const char *loop_column_name(const control_loop *loop, int i);
const double *loop_column(const control_loop *loop, int i);

/* The robot in space, at up to 401 of the samples, as a table of shapes
 * (tools/files/table_shapes.h): t, s, x, y, z, qw to qz, u1 to u3, and estimated_x to _z, where the
 * filter believes that it is. Borrowed from the loop. */
const table_source *loop_shapes(const control_loop *loop);

#endif
