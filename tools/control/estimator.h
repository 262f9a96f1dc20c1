/* What state a robot is in, and which slow parameters it has, from what is seen of it: a
 * square-root sigma-point Kalman filter on a one_step model (unscented: Julier and Uhlmann, Proc.
 * IEEE 92, 2004; cubature: Arasaratnam and Haykin, IEEE Trans. Automatic Control 54, 2009).
 *
 *   void *memory = malloc(estimator_size(&settings));
 *   estimator *x = estimator_init(memory, &settings);
 *   estimator_start(x, state, inputs, NULL);
 *   each sample:
 *       estimator_measure(x, sensor, age, values);    what has arrived, in any order
 *       flags = estimator_update(x);
 *       ... estimator_state(x), estimator_inputs(x): to control by ...
 *       flags |= estimator_predict(x, inputs, NULL);  what acts until the next sample
 *
 * Unknown are the states of the model and some of its inputs, "parameters", which walk randomly:
 * the logarithm of one whose range is positive, else its place in the range. They never leave it.
 *
 * A measurement belongs to the sample it was taken at, `age` samples ago. The filter stays behind
 * by the shortest delay of its sensors, from where the model alone leads to the present state;
 * beyond that it keeps past samples and goes on again from the one that was measured, so that
 * delays of whole samples are exact: the same as if the measurements had come in time. A sample
 * takes one prediction and as many more as delays differ by, most of it in estimator_predict. What
 * it needs is the caller's memory; no function allocates or prints, each does a bounded amount of
 * work, and the answer is the same bits again.
 *
 * Faults have answers, and flags that say so; the estimate is finite always, and the covariance
 * positive definite by construction (all of it is sums of squares, nothing is subtracted):
 *
 * A measurement that is missing: the model alone goes on. One that is not finite, or a rotation
 * that is none, or one of which the observation has no answer: as missing. One that is too late:
 * not used.
 *
 * An outlier, beyond `gate`: not used; after `patience` of them in a row deviations of states
 * become 1.5 times as large each time, up to `largest`, until one is used again.
 *
 * The model has no answer, or one with `outside` above 2: it is asked for the mean alone, whose
 * answer is taken; if it has none, either, the mean stays. Deviations of states become 1.1 times as
 * large.
 *
 * Inputs that are not finite: the last ones are held. A start that is none: not taken. */
#ifndef CONTROL_ESTIMATOR_H
#define CONTROL_ESTIMATOR_H

#include "physics/local/one_step.h"

#include <stddef.h>
#include <stdint.h>

enum {
    ESTIMATOR_SENSORS_MAX = 16,
    ESTIMATOR_PARAMETERS_MAX = 16,
    ESTIMATOR_VALUES_MAX = 24, /* of a sensor */
    ESTIMATOR_WINDOW_MAX = 1000
};

/* Flags: what happened in a sample. */
enum {
    ESTIMATOR_MISSING = 1,        /* a measurement that was to be here by this sample */
    ESTIMATOR_NOT_FINITE = 2,     /* a measurement, or no rotation */
    ESTIMATOR_LATE = 4,           /* a measurement older than the filter keeps */
    ESTIMATOR_OUTLIER = 8,        /* a measurement beyond the gate */
    ESTIMATOR_INFLATED = 16,      /* the covariance was made larger */
    ESTIMATOR_NO_ANSWER = 32,     /* of the model or a observation */
    ESTIMATOR_OUTSIDE = 64,       /* the mean is where the model was not made for */
    ESTIMATOR_AT_EDGE = 128,      /* a parameter is at an end of its range */
    ESTIMATOR_INCONSISTENT = 256, /* normalised innovations of a sensor are out of bounds */
    ESTIMATOR_BAD_INPUTS = 512,   /* given to estimator_predict: the last ones are held */
    ESTIMATOR_BAD_CALL = 1024,    /* no such sensor, or a sample that has been measured */
    ESTIMATOR_BAD_START = 2048    /* given to estimator_start: it is not taken */
};

typedef struct estimator_parameter {
    int input;        /* which of the model's inputs */
    double low, high; /* its range */
    double deviation; /* at the start: of the logarithm if low > 0, else in half ranges; 0: a
                       * uniform distribution's */
    double walk; /* the same, by sqrt(s); 0: 0.003 if low > 0, else 0.03 times estimator_process */
} estimator_parameter;

typedef struct estimator_sensor {
    one_observation observation; /* context borrowed */
    int rotations;       /* 1: values are unit quaternions, 4 each, of which either sign will do */
    const double *noise; /* standard deviations, in units of values; of rotations 3 each, rad, about
                          * the axes of what is seen */
    int every;           /* samples from one measurement to the next; 0: 1 */
    int phase;           /* taken at samples k with k % every == phase */
    int delay;           /* samples until it arrives */
    int depends;         /* values depend on the first so many states alone, which saves time; 0: on
                          * all, and on inputs */
} estimator_sensor;

/* All arrays are borrowed as long as the estimator lives. */
typedef struct estimator_settings {
    one_step model;
    double period; /* s, from sample to sample; 0: model.step; else model.shorter is needed */
    int parameters, sensors;
    const estimator_parameter *parameter; /* [parameters] */
    const estimator_sensor *sensor;       /* [sensors] */
    const double *deviation;              /* [states] at the start */
    const double *process;                /* [states] what the model leaves out, by sqrt(s) */
    double adapt; /* up to so many times `process` as innovations ask for, which are consistent then
                   * though the model is off; 1: as given; 0: 100 */
    const double *largest; /* [states] deviations never exceed it, as when nothing is seen for long;
                            * NULL: 100 times those at the start */
    int late; /* samples by which a measurement may come later than its delay, and is used */
    double alpha, beta, kappa; /* sigma points; alpha 0: cubature, which is 1, 0, 0. beta and kappa
                                * are not negative */
    double gate;               /* chance of a good measurement to be refused; 0: 1e-6 */
    int patience;              /* 0: 10 */
    int window;                /* innovations of which the mean is watched; 0: 50 */
} estimator_settings;

typedef struct estimator estimator;

/* What is wrong with settings, NULL: nothing; static text. Else estimator_size is not defined. */
const char *estimator_refusal(const estimator_settings *settings);

/* Bytes; memory as aligned as malloc's, which stays where it is. Settings are copied, their arrays
 * borrowed. */
size_t estimator_size(const estimator_settings *settings);
estimator *estimator_init(void *memory, const estimator_settings *settings);

/* Sample 0: state [states], inputs [model.inputs], of which the parameters are taken, too; those
 * outside their ranges at the nearer end. by_parameters (or NULL) [states][parameters]: how the
 * state depends on the parameters, as an equilibrium does; both are uncertain together then.
 * Returns 0, or ESTIMATOR_BAD_START and all is as before: a state that is not finite or is none
 * that the model may answer (beyond 1e12 times the largest deviation), or inputs that are not
 * finite. */
int estimator_start(estimator *estimator, const double *state, const double *inputs,
                    const double *by_parameters);

/* values [observation.values] seen `age` samples ago, or the sensor's delay: age < 0. Once for a
 * sensor and sample: a second one replaces a first that is not used yet, and is refused after. */
int estimator_measure(estimator *estimator, int sensor, int age, const double *values);

/* Takes all that was measured since. */
int estimator_update(estimator *estimator);

/* One sample on: inputs [model.inputs] from now on until then, of which estimated ones are not
 * read; after [model.inputs] as in one_step.h, or NULL. */
int estimator_predict(estimator *estimator, const double *inputs, const double *after);

/* At the present sample; deviations and covariance are those of the shortest delay before. */
int64_t estimator_sample(const estimator *estimator);
const double *estimator_state(const estimator *estimator); /* [states] */
/* [model.inputs] last given, estimated. */
const double *estimator_inputs(const estimator *estimator);
double estimator_parameter_now(const estimator *estimator, int i);
/* In units of the parameter, and taken estimator_doubt times: what the model leaves out stays as it
 * is, and so does not average out as noise does. At most that of the whole range. */
double estimator_parameter_deviation(const estimator *estimator, int i);
double estimator_deviation(const estimator *estimator, int i); /* of state i */
/* Of what is seen, by[states] its derivatives by the state. */
double estimator_deviation_along(const estimator *estimator, const double *by);
void estimator_covariance(const estimator *estimator,
                          double *p);                 /* [n][n], n = states + parameters */
double estimator_outside(const estimator *estimator); /* one_step.h: at most 1 inside */
double estimator_process(const estimator *estimator); /* times what was given: 1 to `adapt` */
double estimator_doubt(const estimator *estimator);   /* its mean over the last measurements */

/* Normalised innovations squared, nu^T S^-1 nu, over the number of values: 1 in the mean. */
typedef struct estimator_consistency {
    double last, mean; /* of the window */
    double low, high;  /* bounds of the mean, exceeded by chance once in 1,000 */
    /* Of the window, too: the square of the mean of innovations, normalised, times their number,
     * over the number of values; and their correlation with those before. Where the model is right
     * these are 1 and 0 in the mean, and beyond the bounds by chance once in 1,000. */
    double bias, bias_high, correlation, correlation_high;
    int count; /* in the window */
    int64_t used, missing, not_finite, late, outliers;
} estimator_consistency;

estimator_consistency estimator_sensor_now(const estimator *estimator, int sensor);

#endif
