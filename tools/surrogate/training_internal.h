/* The state of training; not for others. */
#ifndef SURROGATE_TRAINING_INTERNAL_H
#define SURROGATE_TRAINING_INTERNAL_H

#include "tools/surrogate/flow.h"
#include "tools/surrogate/physics_loss.h"

struct surrogate_training {
    const scene *open;
    const surrogate_settings *settings;
    const train_settings *training;
    ad_pool *pool;
    surrogate_training_info info; /* what the fit does not know */
    fit fit;
    surrogate_steps steps, held;
    surrogate_step step;
    double *numbers; /* of the step */
    double *gramian; /* [states][states] */
    double *work;    /* of the step */
    double held_linear;
    surrogate_step inner[SURROGATE_INNER]; /* the other nodes of polynomials; numbers behind */
    surrogate_flow *flow;                  /* NULL: linear */
    double *start;                         /* [parameters], of the stage at work */
    optim_optimizer *optimizer;
    int64_t shape[SURROGATE_SHAPE]; /* lent to a checkpoint */
    decoupled
        curve; /* damped sines, in place of steps, step and flow; of polynomials, their scales */
    double *scales; /* its numbers */
    excitation_rollouts motions, held_motions;
    physics_loss *physics, *held_loss; /* of the stage at work; errors of held-out steps */
};

/* How rollouts of so many steps are drawn for training. */
excitation_settings surrogate_excitation(const surrogate_training *t, int steps, int first,
                                         int count);

/* training_nodes.c. Node values of the steps behind `from`, which are of these motions: at the end
 * in place of the solved state. Steps without are left out. */
ad_status surrogate_add_nodes(surrogate_training *t, const excitation_rollouts *motions,
                              size_t from, surrogate_steps *steps, ad_error *error);
/* Models of the other nodes beside that of the end, which is known but for its network. */
ad_status surrogate_find_inner(surrogate_training *t, ad_error *error);

/* training_curve.c. Motions, the curve and its start; the loss of the stage at work; the mean error
 * of held-out steps for parameters (NULL: of states that stay), NaN where it is not finite. */
ad_status surrogate_prepare_curve(surrogate_training *t, int steps, int rollouts, int held,
                                  ad_error *error);
ad_status surrogate_make_physics(surrogate_training *t, ad_error *error);
double surrogate_held_error(surrogate_training *t, const double *parameters);

/* training_state.c; of fit_kind. */
ad_status surrogate_training_put(void *of, checkpoint *file, ad_error *error);
ad_status surrogate_training_get(void *of, const checkpoint *file, bool *at_work, ad_error *error);

#endif
