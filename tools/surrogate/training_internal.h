/* The state of training; not for others. */
#ifndef SURROGATE_TRAINING_INTERNAL_H
#define SURROGATE_TRAINING_INTERNAL_H

#include "tools/surrogate/flow.h"

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
};

/* collocate.c. Node values nodes [count][steps][SURROGATE_NODES][states] of the steps of motions,
 * by the equations of the rod alone. They are those of one step of Radau's method, found by
 * Newton's method; the first is not a number where that fails. */
ad_status surrogate_collocate(surrogate_training *t, const excitation_rollouts *motions,
                              double *nodes, ad_error *error);

/* training_nodes.c. Node values of the steps behind `from`, which are of these motions: at the end
 * in place of the solved state. Steps without are left out. */
ad_status surrogate_add_nodes(surrogate_training *t, const excitation_rollouts *motions,
                              size_t from, surrogate_steps *steps, ad_error *error);
/* Models of the other nodes beside that of the end, which is known but for its network. */
ad_status surrogate_find_inner(surrogate_training *t, ad_error *error);

/* training_state.c; of fit_kind. */
ad_status surrogate_training_put(void *of, checkpoint *file, ad_error *error);
ad_status surrogate_training_get(void *of, const checkpoint *file, bool *at_work, ad_error *error);

#endif
