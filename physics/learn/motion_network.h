/* The network of a motion (model_motion): a linear one of time alone, at instants. */
#ifndef PHYSICS_LEARN_MOTION_NETWORK_H
#define PHYSICS_LEARN_MOTION_NETWORK_H

#include "physics/learn/model.h"

typedef struct motion_network motion_network;

/* Borrows all three. AD_BAD_ARGUMENT: a network with hidden layers; AD_NO_MEMORY. */
ad_status motion_network_create(const physics_model *m, const nn_mlp *mlp, ad_pool *pool,
                                motion_network **result, ad_error *error);
void motion_network_free(motion_network *network); /* NULL is fine */

/* Goes to instants t [count] of a window, dimensionless. Allocates when they are more than before.
 */
ad_status motion_network_at(motion_network *network, int window, size_t count, const double *t,
                            ad_error *error);

/* y, y_t, y_tt [3][size] at one of them, for parameters of the network and the state [2 size] that
 * the window starts from; NULL: that of t = 0. */
void motion_network_state(const motion_network *network, size_t instant, const double *start,
                          const double *parameters, double *y);

/* The functions of time there, combinations of the network's, by which y is linear in the
 * parameters: [3][functions] of y and its derivatives; the bias of an output comes last. */
int motion_network_functions(const motion_network *network);
const double *motion_network_values(const motion_network *network, size_t instant, int derivative);

/* Columns of the model at points (s, t) of a window, dimensionless as the network's coordinates, in
 * any order: values [columns][points], in SI units. */
ad_status motion_network_observe(motion_network *network, int window, const double *start,
                                 const double *parameters, size_t points, const double *s,
                                 const double *t, int columns, double *values, ad_error *error);

/* How far a motion is off until the end of a window (model_motion), all before it included; first
 * that of the first window, then of the others in turn. */
ad_status motion_network_off(motion_network *network, int window, const double *start,
                             const double *parameters, model_motion_error *off, ad_error *error);

#endif
