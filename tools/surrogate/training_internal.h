/* The state of training; not for others. */
#ifndef SURROGATE_TRAINING_INTERNAL_H
#define SURROGATE_TRAINING_INTERNAL_H

#include "tools/surrogate/flow.h"

struct surrogate_training {
    const scene *open;
    const surrogate_settings *settings;
    const train_settings *training;
    ad_pool *pool;
    surrogate_training_info info;
    double began; /* wall time at which training would have begun without pause */
    surrogate_steps steps, held;
    surrogate_step step;
    double *numbers; /* of the step */
    double *gramian; /* [states][states] */
    double *work;    /* of the step */
    double held_linear;
    surrogate_flow *flow; /* NULL: linear */
    double *start;        /* [parameters], of the stage at work */
    optim_optimizer *optimizer;
    history rows;
    int64_t shape[SURROGATE_SHAPE]; /* lent to a checkpoint */
};

/* Of the stage at work, at t->start. */
ad_status surrogate_training_make_optimizer(surrogate_training *t, ad_error *error);

/* modes.c: modes that are left open, by the tolerance of the settings; text [256] for people. */
ad_status surrogate_choose_modes(const scene *open, surrogate_settings *settings, ad_pool *pool,
                                 uint64_t seed, char text[256], ad_error *error);

#endif
