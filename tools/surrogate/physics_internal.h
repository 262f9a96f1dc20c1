/* What the files of the loss by the rod's equations share; not for others. */
#ifndef SURROGATE_PHYSICS_INTERNAL_H
#define SURROGATE_PHYSICS_INTERNAL_H

#include "physics/solve/reduced.h"
#include "tools/surrogate/physics_loss.h"

enum { NODES = DECOUPLED_NODES, CHUNKS = 16, AHEAD_MAX = 32 };

/* One step of a sequence. */
typedef struct physics_step {
    double *given;          /* [order]: z, v, 1 */
    double *hidden, *a;     /* of the network */
    double *y, *rate, *n;   /* [NODES][n] */
    double *by_z;           /* [NODES][n][n] of n */
    double *residual, *end; /* [NODES][n]; error [n] at the end of the step */
} physics_step;

typedef struct physics_worker {
    reduced_rod *rod;
    double *memory;
    physics_step steps[AHEAD_MAX];
    double *adjoint[4]; /* [n] each */
    double *to_a, *to_hidden, *to_given, *state, *input, *jacobian;
} physics_worker;

struct physics_loss {
    const scene *scene;
    const excite_rollouts *motions;
    excite_rollouts moved; /* motions off which states were moved */
    const decoupled *m;
    physics_loss_settings settings;
    ad_pool *pool;
    size_t count;     /* of beginnings */
    int (*begin)[2];  /* [count]: rollout, step */
    double *flow;     /* [NODES][n][order] to the nodes */
    double *target;   /* of beginnings [count of rollouts][steps][NODES][n]: y; NULL: the defect */
    double *zero;     /* [n][n + inputs + 1] */
    double *integral; /* [NODES][NODES][n][n] */
    double *weight;   /* [n][n], symmetric */
    double *sums;     /* [CHUNKS + 1][2 + parameters]: value, how many have none, gradient; of
                       * chunks, then of all */
    double factor;    /* of the loss */
    const double *parameters;
    bool derives;
    int64_t number; /* of the step of training */
    physics_worker *workers;
    const double *center, *scale, *input_center, *input_scale;
    const double *mean, *linear; /* [n][n + inputs + 1]: A, B, c; of the base, or 0 */
};

/* Without weights; *result is to be freed in any case. */
ad_status physics_open(const scene *open, const int modes[4], const excite_rollouts *motions,
                       const decoupled *m, const physics_loss_settings *settings, ad_pool *pool,
                       physics_loss **result, ad_error *error);

size_t physics_order(const decoupled *m); /* columns of a flow: z, v, 1 */

/* In coordinates of the model: state and inputs of a row of the motions. */
void physics_take_inputs(const physics_loss *x, size_t row, double *v);
void physics_take_state(const physics_loss *x, size_t row, double *z);

/* What f has beside the linear flow, h f/x_s - A z - B v - c, and its derivatives by z (NULL: not
 * wanted); false: it has no answer. */
bool physics_remainder(const physics_loss *x, physics_worker *w, const double *given, double t,
                       const double *z, double *rest, double *by_z);

void physics_base(const physics_loss *x, const double *flow, const double *given, double *z);

#endif
