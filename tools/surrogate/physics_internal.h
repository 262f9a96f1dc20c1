/* What the files of the loss by the rod's equations share; not for others. */
#ifndef SURROGATE_PHYSICS_INTERNAL_H
#define SURROGATE_PHYSICS_INTERNAL_H

#include "physics/solve/reduced.h"
#include "tools/surrogate/physics_loss.h"

enum { NODES = DECOUPLED_NODES, CHUNKS = 16, AHEAD_MAX = 32 };

/* One step of a sequence. */
typedef struct physics_step {
    double *given;          /* [inputs of the network]: z, v */
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
    size_t count;    /* of beginnings */
    int (*begin)[2]; /* [count]: rollout, step */
    double *target;  /* of beginnings [count of rollouts][steps][NODES][n]: y; NULL: the defect */
    double integral[NODES][NODES]; /* the matrix of Radau's method */
    double *weight;                /* [n][n], symmetric */
    double *sums;  /* [CHUNKS + 1][2 + parameters]: value, how many have none, gradient; of
                    * chunks, then of all */
    double factor; /* of the loss */
    const double *parameters;
    bool derives;
    int64_t number; /* of the step of training */
    physics_worker *workers;
    const double *center, *scale, *input_center, *input_scale;
};

/* Without weights; *result is to be freed in any case. */
ad_status physics_open(const scene *open, const int modes[4], const excite_rollouts *motions,
                       const decoupled *m, const physics_loss_settings *settings, ad_pool *pool,
                       physics_loss **result, ad_error *error);

size_t physics_given(const decoupled *m); /* inputs of the network: z, v */

/* In coordinates of the model: state and inputs of a row of the motions. */
void physics_take_inputs(const physics_loss *x, size_t row, double *v);
void physics_take_state(const physics_loss *x, size_t row, double *z);

/* z' = h f/x_s at t, and its derivatives by z (NULL: not wanted); false: it has no answer. */
bool physics_rate(const physics_loss *x, physics_worker *w, const double *given, double t,
                  const double *z, double *rate, double *by_z);

#endif
