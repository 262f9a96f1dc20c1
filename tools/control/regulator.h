/* Filter and controller of a robot together: what is measured in, inputs out, sample by sample.
 * Plain C without library but libm, nothing is allocated, bounded time: simulated loops and
 * exported C have this very text.
 *
 *   regulator *x = regulator_init(memory, &settings);        regulator_size(&settings) bytes
 *   regulator_start(x, state, inputs, by_parameters);
 *   each sample:
 *       regulator_measure(x, sensor, age, values);           what has arrived, in any order
 *       flags = regulator_control(x, reference, inputs);     to be applied `delay` samples from now
 *       regulator_prepare(x);                                the long part, until the next sample
 *
 * Where samples are shorter than the step of the controller's model there are as many controllers
 * as samples in a step, which take turns: each plans in steps of its model and begins with its own
 * plan of one step ago. The filter's model goes by samples.
 *
 * A filter that has been outside of what its model was made for, and contradicted by what is
 * measured, for REGULATOR_LOST samples in turn begins again as the first regulator_start said; so
 * does one that is for as long where no robot can be, whatever is measured: REGULATOR_FAR times the
 * deviations at the start away from it. The controllers forget then what they have learned.
 *
 * The filter is told the inputs that act; faults have the answers that estimator.h and controller.h
 * state, and flags. Inputs are always finite and within their limits. One is for one thread at a
 * time. */
#ifndef CONTROL_REGULATOR_H
#define CONTROL_REGULATOR_H

#include "tools/control/controller.h"
#include "tools/control/estimator.h"

#include <stdbool.h>

/* Flags: those of the filter, those of the controller so many bits up, and of both together. */
enum {
    REGULATOR_CONTROLLER = 16,
    REGULATOR_LATE = 1 << 25,
    REGULATOR_AGAIN = 1 << 26, /* the filter was lost, and begins again */
    REGULATOR_LOST = 30,       /* samples outside of the model and against what is measured */
    REGULATOR_FAR = 1000000,   /* times its scale: no state or input of a robot */
    REGULATOR_CYCLE_MAX = 1 << 20,
    REGULATOR_DELAY_MAX = 100,
    REGULATOR_TURNS_MAX = 100
};

/* Arrays are borrowed. */
typedef struct regulator_settings {
    estimator_settings estimator;
    controller_settings controller; /* its delay is `delay` with one controller, else 0 */
    int turns;                      /* controllers, which take turns: 1 and more */
    int delay;                      /* samples from a measurement to the inputs by it */
    const double *rate; /* [controlled] largest change from one sample to the next, where turns are
                         * taken; NULL: any */
} regulator_settings;

typedef struct regulator regulator;

/* What is wrong with settings, NULL: nothing; static text. Else regulator_size is not defined. */
const char *regulator_refusal(const regulator_settings *settings);

/* Bytes; memory as aligned as malloc's, which stays where it is. */
size_t regulator_size(const regulator_settings *settings);
regulator *regulator_init(void *memory, const regulator_settings *settings);

/* Sample 0: as estimator_start, with inputs that act until the first answer does; nothing is left
 * of what was before. Returns 0 or ESTIMATOR_BAD_START, also of inputs that regulator_applied
 * ignores: all goes on as before. */
int regulator_start(regulator *regulator, const double *state, const double *inputs,
                    const double *by_parameters);

/* As estimator_measure. */
int regulator_measure(regulator *regulator, int sensor, int age, const double *values);

/* In two parts, to be timed: what was measured is taken; inputs [controlled] follow from it.
 * reference [horizon][observation.values] as controller_sample has it, steps of the controller's
 * model after the inputs act, or NULL: what it was, one step on. Both return flags of this sample.
 */
int regulator_filter(regulator *regulator);
int regulator_plan(regulator *regulator, const double *reference, double *inputs);

/* Both of them. */
int regulator_control(regulator *regulator, const double *reference, double *inputs);

/* In place of regulator_plan where there is no time for it, nor to prepare what follows: the last
 * plan goes on, at its end held; or what was answered before is held, where nothing else can be
 * sent any more. Returns REGULATOR_LATE. */
int regulator_late(regulator *regulator, bool held, double *inputs);

/* The filter's prediction, and that with what the controller can do beforehand. The next call does
 * it where it was not called, and the next answer has its flags. */
void regulator_predict(regulator *regulator);
void regulator_prepare(regulator *regulator);

/* What acts from the present sample on where it was not what was answered [controlled]: before
 * regulator_prepare. Not finite, or REGULATOR_FAR times their range away: ignored. */
void regulator_applied(regulator *regulator, const double *inputs);

/* For what they say; to be called by nobody else for what they do. */
estimator *regulator_estimator(const regulator *regulator);
controller *regulator_controller(const regulator *regulator); /* of the last answer */

#endif
