/* A recording of a real robot gone through again by the filter: what it would have known at each
 * sample, how well the model predicts the next sample from there, and how well what comes after,
 * with inputs as they were recorded.
 *
 *   replay_settings settings = {.ahead = 1};
 *   replay_run(&setup, sets, measured, inputs, &settings, &report, &error);
 */
#ifndef CONTROL_REPLAY_H
#define CONTROL_REPLAY_H

#include "physics/solve/measured.h"
#include "tools/control/loop.h"

typedef struct replay_settings {
    double ahead; /* s, > 0 */
    double drift; /* m/sqrt(s): how fast what the model misses of a marker walks, which the filter
                   * then estimates for each (marker_drift.h); 0: it does not */
    double fade;  /* s, in which that is forgotten; 0: never */
} replay_settings;

typedef struct replay_report {
    size_t samples, judged, rollouts; /* judged: with a measurement, after the first `ahead` s */
    double period;                    /* s */
    /* m, rms over markers of the distance from where they were measured: of predictions one sample
     * ahead, and `ahead` s; and of markers that are believed to stay, for comparison. */
    double step, step_still, ahead, ahead_still;
    double noise;                        /* m, of the markers, rms, as it is stated */
    double estimate[CONTROL_INPUTS_MAX]; /* at the end, of control->estimate */
    double deviation[CONTROL_INPUTS_MAX];
    double recorded[CONTROL_INPUTS_MAX]; /* what the file says of it; NaN: nothing */
    double doubt;                        /* as estimator_doubt */
    long refused;                        /* measurements beyond the gate */
    residual_reach residual;             /* as of loop_report */
    double seconds;                      /* of the filter, a sample */
} replay_report;

/* Of the nominal scene, with model and estimate of setup->control; its plant, task and sensors do
 * not count. Markers are those of all sets with these inputs: positions, each at one place, with
 * its noise. Before its first sample the robot rested. AD_BAD_INPUT: samples that
 * are not evenly spaced, or too few for `ahead`; a set of another quantity, of several places, or
 * seen beside the axis, in other axes or late; more sets than a filter has sensors; AD_NOT_FINITE:
 * no equilibrium to start from; others as loop_create. */
ad_status replay_run(const loop_setup *setup, int sets, const solve_measured *measured,
                     const solve_inputs *inputs, const replay_settings *settings,
                     replay_report *report, ad_error *error);

#endif
