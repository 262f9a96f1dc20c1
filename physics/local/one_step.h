/* What a filter or a controller asks of a robot: the state one sampling step later, and what is
 * seen of a state. A surrogate, the reduced rod itself and a linear model answer alike; so does
 * exported C. Nothing here needs a library, and nothing allocates.
 *
 *   x+ = f(x, u, h),  y = g(x, u)
 *
 * Inputs u are those of the scene's parameters that have ranges, in the scene's order: what an
 * actuator sets (pressures, tensions) and what a filter finds (a stiffness, a load at the tip). */
#ifndef PHYSICS_LOCAL_ONE_STEP_H
#define PHYSICS_LOCAL_ONE_STEP_H

/* Of many states at once; the matrices are row by row and may be NULL: not wanted. Returns 0, or
 * another number where there is no answer (not finite, no convergence); then next is not defined.
 */
typedef struct one_step {
    void *context; /* borrowed */
    int states, inputs;
    double step; /* s, the longest h */
    int shorter; /* whether any h in (0, step] has an answer; else only step */
    /* states [count][states], inputs [count][inputs] at the begin of the step; after
     * [count][inputs] at its end, between which they go linearly, or NULL: held. next
     * [count][states], not states; by_state [count][states][states], by_inputs
     * [count][states][inputs] (with `after`: of both ends moved together). */
    int (*advance)(void *context, int count, double h, const double *states, const double *inputs,
                   const double *after, double *next, double *by_state, double *by_inputs);
    /* How far x, u are outside of what the model was made for: at most 1 inside; NULL: anywhere. */
    double (*outside)(void *context, const double *state, const double *inputs);
    /* What the model does not know of itself: covariance [states][states] of what `next` is off by
     * it, as if apart from one step of h to the next. by_state as of that step; NULL: a
     * motion begins at that state, at rest, and covariance is not asked for. memory [doubts] goes
     * on with the motion. 0, or there is none, and memory is 0. doubts 0: nothing is said. */
    int doubts;
    int (*doubt)(void *context, double h, const double *state, const double *inputs,
                 const double *by_state, double *memory, double *covariance);
} one_step;

/* What is seen: values [count][values], by_state [count][values][states] (NULL: not wanted). */
typedef struct one_observation {
    void *context; /* borrowed */
    int states, inputs, values;
    int (*see)(void *context, int count, const double *states, const double *inputs, double *values,
               double *by_state);
} one_observation;

#endif
