/* What the files of a residual share; not for others. */
#ifndef CONTROL_RESIDUAL_INTERNAL_H
#define CONTROL_RESIDUAL_INTERNAL_H

#include "autodiff/dense.h"
#include "autodiff/memory.h"
#include "tools/control/residual.h"
#include "tools/train/learned_net.h"

struct residual {
    one_step of;
    size_t states, inputs, seen, count; /* seen: by the network; count: of its numbers */
    learned_net net;
    learned_tape *tape;
    ad_pool *pool;      /* of one thread */
    double *theta;      /* [count] */
    double *covariance; /* [count][count] of theta */
    residual_reach reach;
    double noise, anew;  /* anew: 1/s, as residual_doubt says */
    size_t values;       /* that were seen; 0: nothing is learned */
    double *sight;       /* [values][states] of these by the state, in the mean */
    double *turn;        /* [states][values] */
    double *room, *rest; /* rest: of residual_settle */
    int *pivots;
    size_t points;             /* for which there is room */
    double *x, *y, *by_x;      /* [seen][points], [states][points], [seen][states][points] */
    double *by_theta, *change; /* [count][states]; [states][count] */
    ad_memory memory;
};

/* The network at points, in y and by_x; by theta, or NULL, of one point alone. Whether there is
 * memory. */
bool residual_say(residual *residual, size_t points, const double *states, const double *inputs,
                  bool by_x, double *by_theta);

/* The change of the next state by each number [states][count]: the model's own times that of the
 * state, and that of the network by its numbers. Whether there is memory. */
bool residual_push(residual *residual, double h, const double *state, const double *inputs,
                   const double *by_state, const double *before, double *after);

/* Room for what so many values that are seen say of a state. AD_NO_MEMORY. */
ad_status residual_see(residual *residual, size_t values, ad_error *error);

/* The turn by what is seen and the sizes of states. Whether there is one. */
bool residual_turn(residual *residual);

/* Of changes S of a state, with C the covariance of the numbers: what is seen by H is as uncertain
 * as H S C S^T H^T. What is not seen stays as uncertain as before anything was learned, and so is
 * left out: the state turns with what is seen as T = D H^T (H D H^T)^-1, D squares of its sizes,
 * and is uncertain by T H S C S^T H^T T^T. Of this the part h `anew` is as if it came in each step
 * of h: then what is seen is as uncertain, on runs that were learned from, as by the numbers, which
 * do not change from step to step. The largest deviation of what is seen goes to `reach`. */
void residual_doubt(residual *residual, double h, const double *change, double *covariance);

#endif
