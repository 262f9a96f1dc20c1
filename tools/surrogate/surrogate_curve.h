/* A one-step model for any part of its step: a polynomial of time through what the model says of
 * Radau's nodes, at the last of which, the end, it is the model itself.
 *
 *   x(t) = x(0) + sum_i l_i(t) (x_i - x(0)),   l_i: 1 at node c_i, 0 at the others and at 0
 *
 * Nodes have the frame and hidden layers in common and differ in linear map and output layer, and
 * so at any t the curve is again a surrogate_step, with numbers of its own. */
#ifndef SURROGATE_CURVE_H
#define SURROGATE_CURVE_H

#include "tools/surrogate/surrogate_step.h"

enum { SURROGATE_NODES = 3, SURROGATE_INNER = SURROGATE_NODES - 1 };

/* Of order 5, as those of the reduced rod's steps; the last is 1. */
extern const double surrogate_nodes[SURROGATE_NODES];

/* numbers [surrogate_step_numbers] at t in (0, 1] of a step, for the model at its end; inner
 * [SURROGATE_INNER][surrogate_step_numbers] of the other nodes. */
void surrogate_curve_at(const surrogate_step *end, const double *inner, double t, double *numbers);

#endif
