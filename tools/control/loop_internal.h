#ifndef CONTROL_LOOP_INTERNAL_H
#define CONTROL_LOOP_INTERNAL_H

#include "tools/control/controller.h"
#include "tools/control/estimator.h"
#include "tools/control/loop.h"
#include "tools/control/mppi.h"
#include "tools/control/plant.h"
#include "tools/control/reduced_model.h"
#include "tools/control/resting.h"
#include "tools/control/task.h"

enum { LOOP_NAME = 64, LOOP_COLUMNS = 256, LOOP_SEEN = 3 + CONTROL_LIMITS_MAX };

/* What the controller sees: the place, then the constrained numbers. */
typedef struct loop_view {
    int count; /* of looks; the first is the place */
    look *looks[1 + CONTROL_LIMITS_MAX];
    int axis[1 + CONTROL_LIMITS_MAX];
    size_t states;
    int inputs, values;
    double *room; /* [4][1 + states] */
} loop_view;

struct control_loop {
    loop_setup of;
    control_settings control;
    double period, step; /* s: of the loop, of the model */
    int ratio;           /* steps over periods */
    int states, parameters;
    int input_count, inputs[CONTROL_INPUTS_MAX]; /* of the nominal parameters */
    double middle[SCENE_PARAMETERS_MAX];
    double reach;

    resting *rest;
    plant *robot;
    task_path *path;
    reduced_rod *rod;
    linear_step *linear[2]; /* by the period, by the step */
    one_step by_period, by_step;
    loop_view view;

    look *sensors[CONTROL_MEASUREMENTS_MAX];
    estimator_sensor sensor[CONTROL_MEASUREMENTS_MAX];
    estimator_parameter parameter[CONTROL_INPUTS_MAX];
    double noise[CONTROL_MEASUREMENTS_MAX][4];
    double *numbers; /* [4][states] rest, deviation, process, room; then [states][estimated] */
    void *filter_memory;
    estimator *filter;
    controller **controllers; /* [ratio], each memory of its own */
    struct {                  /* what they borrow */
        double rate[CONTROL_INPUTS_MAX], rest[CONTROL_INPUTS_MAX], smooth[CONTROL_INPUTS_MAX];
        double effort[CONTROL_INPUTS_MAX];
        double weight[LOOP_SEEN], soft[LOOP_SEEN], low[LOOP_SEEN], high[LOOP_SEEN];
        mppi_settings sampling;
    } plan;

    /* The record. */
    long samples, done;
    int columns;
    char names[LOOP_COLUMNS][LOOP_NAME];
    double *record; /* [columns][samples] */
};

int loop_see(void *context, int count, const double *states, const double *inputs, double *values,
             double *by_state);

#endif
