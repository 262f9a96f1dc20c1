/* The network of what physics leaves: numbers y = size N(x; theta) of inputs x, tanh in hidden
 * layers. theta [count] are of size 1 before anything is measured: a weight is its theta over the
 * root of how many numbers its unit adds, so that theta^2 is what a ridge adds to squares. */
#ifndef TOOLS_TRAIN_LEARNED_NET_H
#define TOOLS_TRAIN_LEARNED_NET_H

#include "physics/quantity/quantity.h"

#include <stdint.h>

/* Inputs and outputs of scenes at rest, and of any. */
enum {
    LEARNED_INPUTS_MAX = 32,
    LEARNED_OUTPUTS_MAX = 64,
    LEARNED_WIDTH_MAX = 128,
    LEARNED_LAYERS_MAX = 4
};

typedef struct learned_net {
    int inputs, outputs, hidden_count;
    int hidden[LEARNED_LAYERS_MAX];   /* widths */
    double middle[LEARNED_WIDTH_MAX]; /* of inputs, in their units */
    double half[LEARNED_WIDTH_MAX];   /* (x - middle)/half enters; > 0 */
    double size[LEARNED_WIDTH_MAX];   /* in the units of y */
} learned_net;

size_t learned_net_count(const learned_net *net); /* of theta */

/* Where a search begins: hidden units drawn by the seed, all outputs 0. */
void learned_net_draw(const learned_net *net, uint64_t seed, double *theta);

/* A formula of its own for each output, y[outputs] of x[inputs] (formulas). */
void learned_net_formula(const learned_net *net, const double *theta, const quantity *x,
                         quantity *y);

/* The same on the tape, over many x at once. Depends on the shape of the net alone. */
typedef struct learned_tape learned_tape;
ad_status learned_tape_create(const learned_net *net, learned_tape **result, ad_error *error);
void learned_tape_free(learned_tape *tape); /* NULL is allowed */

/* x[inputs][points], y[outputs][points]; dy/dtheta by_theta[count][outputs][points] and dy/dx
 * by_x[inputs][outputs][points], or NULL. Does not allocate after the first run of as many points.
 */
ad_status learned_tape_run(learned_tape *tape, const learned_net *net, size_t points,
                           const double *x, const double *theta, double *y, double *by_theta,
                           double *by_x, ad_error *error);

#endif
