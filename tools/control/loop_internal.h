#ifndef CONTROL_LOOP_INTERNAL_H
#define CONTROL_LOOP_INTERNAL_H

#include "tools/control/equilibria.h"
#include "tools/control/loop.h"
#include "tools/control/plant.h"
#include "tools/control/reduced_model.h"
#include "tools/control/regulator.h"
#include "tools/control/residual.h"
#include "tools/control/task.h"
#include "tools/control/task_observation.h"

enum { LOOP_NAME = 64, LOOP_COLUMNS = 256, LOOP_SEEN = 3 + CONTROL_LIMITS_MAX };

/* loop_shapes.c; blocks of PLANT_POINTS rows. */
enum { LOOP_SHAPE_COLUMNS = 15 };
typedef struct loop_record_of_shapes {
    observation *observation; /* as the filter believes */
    long every;               /* samples from one shape to the next */
    size_t room;              /* rows */
    double *values;           /* [LOOP_SHAPE_COLUMNS][room] */
    const double *columns[LOOP_SHAPE_COLUMNS];
    table_source table;
} loop_record_of_shapes;

ad_status loop_shapes_create(control_loop *loop, ad_error *error);
void loop_shapes_free(control_loop *loop);

/* At sample k, if it is one of those that are kept. */
ad_status loop_shapes_take(control_loop *loop, long k, ad_error *error);

/* Models, sensors and the settings of the filter but for its deviations and process noise, and
 * nothing to control. */
ad_status loop_create_filter(const loop_setup *setup, control_loop **result, ad_error *error);

/* Deviations and process noise of the filter, by the sizes [states] in the room of loop->numbers.
 */
void loop_fill_noise(control_loop *loop);

/* The state in loop->numbers, at rest for inputs by the reduced rod, becomes that where the filter
 * begins: at rest with the residual, where there is one and it has such a state. Behind it come its
 * derivatives by what is estimated. */
ad_status loop_begin(control_loop *loop, const double *inputs, ad_error *error);

enum { LOOP_TRUE_PLACE = 4, LOOP_INPUTS = 10 }; /* first columns of the record */

struct control_loop {
    loop_setup of;
    control_settings control;
    double period, step; /* s: of the loop, of the model */
    int ratio;           /* steps over periods */
    int states, parameters;
    int input_count, inputs[CONTROL_INPUTS_MAX]; /* of the nominal parameters */
    double middle[SCENE_PARAMETERS_MAX];
    equilibria_reach reach;

    equilibria *rest;
    plant *robot;
    task_path *path;
    reduced_rod *rod;
    linear_step *linear[2]; /* by the period, by the step */
    residual *beyond;       /* NULL: none */
    one_step by_period, by_step;
    observation *observations[1 + CONTROL_LIMITS_MAX]; /* what the controller sees: the place,
                                                          limited numbers */
    clearance_observation clearance;                   /* of one of these */
    int clearance_part;                                /* which; 0: there is none */
    task_observation seen;
    int values;

    observation *sensors[CONTROL_MEASUREMENTS_MAX];
    estimator_sensor sensor[CONTROL_MEASUREMENTS_MAX];
    estimator_parameter parameter[CONTROL_INPUTS_MAX];
    double noise[CONTROL_MEASUREMENTS_MAX][4];
    double *numbers; /* [4][states] rest, deviation, process, room; then [states][estimated] */
    regulator_settings settings;
    regulator *both; /* and its memory */
    struct {         /* what controllers borrow */
        double rate[CONTROL_INPUTS_MAX], turns[CONTROL_INPUTS_MAX], rest[CONTROL_INPUTS_MAX],
            smooth[CONTROL_INPUTS_MAX];
        double effort[CONTROL_INPUTS_MAX];
        double weight[LOOP_SEEN], soft[LOOP_SEEN], low[LOOP_SEEN], high[LOOP_SEEN];
    } plan;

    /* The record: t, three places, inputs, then what differs from loop to loop. */
    long samples, done;
    int columns;
    char names[LOOP_COLUMNS][LOOP_NAME];
    double *record; /* [columns][samples] */
    loop_record_of_shapes shapes;
};

#endif
