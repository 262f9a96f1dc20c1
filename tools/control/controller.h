/* Predictive control with a one-step model: the inputs of the next samples that make what is seen
 * follow a path, of which the first is applied.
 *
 *   minimise   sum_i 1/2 |g(x_{i+1}) + bias - r_i|^2 by weight, the last one times `terminal`
 *            + sum_i 1/2 |(u_i - u_{i-1})/span|^2 by smooth + 1/2 |(u_i - rest)/span|^2 by effort
 *            + what soft limits of the outputs cost,
 *   x_{i+1} = f(x_i, u_i) + drift,   lower <= u <= upper,   |u_i - u_{i-1}| <= rate,
 *
 * for i = 0 .. horizon - 1, where inputs from `moves` - 1 on are held. With a delay d the plan
 * begins d samples after the state it is computed from: what is applied until then is decided.
 *
 *   controller *c = controller_init(memory, &settings);      // controller_size(&settings) bytes
 *   each sample:  controller_feedback(c, &now, inputs);      // short: a state in, inputs out
 *                 controller_prepare(c);                     // long: until the next sample
 *
 * The plan is found by real-time iterations of the Gauss-Newton method (Diehl, Bock, Schloeder
 * 2005), each with one quadratic program.
 *
 * The caller's memory, no allocation, bounded time (given the model's), no global state; the same
 * calls give the same bits. Inputs that are answered are always finite and within lower, upper and
 * rate; what was wrong is told by flags. One controller is for one thread at a time. */
#ifndef CONTROL_CONTROLLER_H
#define CONTROL_CONTROLLER_H

#include "physics/local/one_step.h"

#include <stddef.h>

typedef struct controller controller;

/* All arrays and contexts are borrowed as long as the controller lives; with m controlled inputs
 * and v = observation.values. */
typedef struct controller_settings {
    one_step model;
    one_observation observation; /* values: what is tracked or limited */
    int horizon;                 /* samples ahead */
    int moves;      /* of them with inputs of their own; later ones hold the last; 0: all */
    int delay;      /* samples from a state to when its answer is applied; 1: with the next */
    int iterations; /* of Gauss-Newton within one feedback; 0: 1 */
    int qp_limit;   /* of iterations of a quadratic program (qp.h), which bounds the worst time;
                     * 0: its default */

    int controlled;              /* m */
    const int *inputs;           /* [m] which of the model's inputs are controlled */
    const double *others;        /* [model.inputs] what the other inputs are, until told */
    const double *lower, *upper; /* [m] finite, lower < upper */
    const double *rate;          /* [m] largest change from one sample to the next; NULL: any */
    const double *rest;   /* [m] where `effort` pulls and what is applied at first, before any
                           * answer; NULL: lower, upper cut at 0 */
    const double *smooth; /* [m] weights of changes; NULL: 0 */
    const double *effort; /* [m] weights of inputs; NULL: 0. Some of both: else what is best
                           * is not unique, and 1e-9 of the largest is added */

    const double *weight; /* [v] of squares of what is seen (1/unit^2); 0: not tracked */
    double terminal;      /* times weight at the end of the horizon; 0: 1 */
    const double *soft_lower,
        *soft_upper;           /* [v] limits of what is seen, infinite: none; NULL: none */
    const double *soft_weight; /* [v] of squares of their violation; with limits */

    double offset;  /* 0 to 1, of a sample's error of prediction that is added to `drift` and
                     * `bias` (low pass): with more than 0 no constant mismatch or load leaves a
                     * constant error but what `effort` asks for; 0: they stay 0 */
    double outside; /* a state further outside (model.outside) is not used, as if it were missing;
                     * 0: all are used, flagged above 1 */
    int coast;      /* samples without a state for which the model's own prediction is used; after
                     * them inputs are held; 0: horizon */
} controller_settings;

/* Of one sample. */
typedef struct controller_sample {
    const double *state;    /* [model.states] or NULL: missing */
    const double *others;   /* [model.inputs], of which the controlled ones are not read, as a
                             * filter finds them; NULL: as before */
    const double *measured; /* [v] what is seen at the state's time, for `offset`; NaN: missing;
                             * NULL: none */
    /* [horizon][v]: row i is wanted at (delay + i + 1) steps after the state's time. NaN: no wish.
     * NULL: as before, one sample on. */
    const double *reference;
    const double *margin; /* [v] by which soft limits are kept farther off, as what is seen is not
                           * known exactly; ends that would pass each other meet; NULL: 0 */
} controller_sample;

/* Flags of an answer. 0: all is well. What is done about each is said here. */
enum {
    CONTROLLER_STATE = 1,   /* no state, or one that is not finite: coasts on the prediction */
    CONTROLLER_OUTSIDE = 2, /* a state outside what the model was made for (above 1); used unless
                             * above `outside`, then coasts */
    CONTROLLER_HELD = 4,    /* inputs are held: too long without a state, or without a plan */
    CONTROLLER_MODEL = 8, /* model or observation gave no answer or not a finite one: the plan goes
                           * on as it was, one sample on, at its end held */
    CONTROLLER_QP_LIMIT = 16,  /* best point that was known and allowed */
    CONTROLLER_QP = 32,        /* the program had no answer: the plan goes on as it was */
    CONTROLLER_SOFT = 64,      /* a soft limit, with its margin, is violated in the plan */
    CONTROLLER_OTHERS = 128,   /* `others` not finite: the last ones are used */
    CONTROLLER_REFERENCE = 256 /* an entry of the reference is infinite: no wish there */
};

/* What is wrong with settings, NULL: nothing; static text. Else controller_size is not defined. */
const char *controller_refusal(const controller_settings *settings);

/* Bytes; memory as aligned as malloc's, which stays where it is. Settings are copied, their arrays
 * borrowed. */
size_t controller_size(const controller_settings *settings);
controller *controller_init(void *memory, const controller_settings *settings);

/* As controller_init has left it, but with inputs [m] that are and were applied. */
void controller_start(controller *c, const double *inputs);
/* Forgets what the model was found to leave out, and what was foreseen: where the states before
 * were none of the robot's. The plan goes on. */
void controller_forget(controller *c);

/* inputs [m]: to be applied `delay` samples after the state's time. Returns flags. */
int controller_feedback(controller *c, const controller_sample *now, double *inputs);
/* What can be done before the next state is known, for the next controller_feedback, which does it
 * itself if this was not called or failed: returned are CONTROLLER_MODEL, CONTROLLER_QP or 0. */
int controller_prepare(controller *c);
/* The next `count` samples pass without a call (a late program); the host applied the first
 * `count` rows of the plan in them. */
void controller_skip(controller *c, int count);
/* What really was or will be applied in place of an answer, inputs [m]: `ago` 0 is the last answer,
 * 1 the one before it. Not finite, or too old to matter: ignored. */
void controller_applied(controller *c, int ago, const double *inputs);

/* [horizon][m] what is applied from now on, if nothing else is computed: row 0 is for the sample
 * after the one of the last answer. */
const double *controller_plan(const controller *c);
double controller_cost(const controller *c); /* of the last plan, by the linear model */
/* Of the last quadratic program: rows added or dropped; and their bound. */
int controller_iterations(const controller *c);
int controller_iterations_most(const controller *c);

#endif
