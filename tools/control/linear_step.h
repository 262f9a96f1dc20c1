/* A linear one-step model of one length of step. Needs no library and allocates nothing: exported C
 * has this very text. */
#ifndef CONTROL_LINEAR_STEP_H
#define CONTROL_LINEAR_STEP_H

#include "physics/local/one_step.h"

/* next + by_state x + by_inputs u; arrays are borrowed. */
typedef struct linear_step {
    int states, inputs;
    double h;
    const double *next;                 /* [states] */
    const double *by_state, *by_inputs; /* [states][states], [states][inputs] */
} linear_step;

/* Borrows x. There is no answer for other lengths, nor for inputs of the end. */
one_step linear_one_step(const linear_step *step);

#endif
