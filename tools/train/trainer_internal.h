/* What trainer.c (steps and stages), trainer_state.c (checkpoints) and trainer_verdict.c share; not
 * for callers. */
#ifndef TOOLS_TRAIN_TRAINER_INTERNAL_H
#define TOOLS_TRAIN_TRAINER_INTERNAL_H

#include "optim/continuation.h"
#include "tools/train/stage_optimizer.h"
#include "tools/train/trainer.h"

enum { TRAINER_DRAWN = 5 }; /* state of a generator, and how many points it has drawn */

struct trainer {
    experiment *e;
    problem *problem;
    reference *known;
    optimizer *optimizer;     /* of the stage at hand, or NULL */
    optim_continuation loads; /* no memory: all loads at once */
    fit fit;
    trainer_info info;
    bool losses_compare; /* points and weights stay, so the best point is the best */
    char balance_names[MODEL_TERMS_MAX][32]; /* of columns, per term */
    double size;                  /* what a large loss is relative to: trainer_measure_size */
    double evaluated;             /* loss of the last evaluation */
    bool (*asked)(void *context); /* whether to stop: trainer_watch_stop */
    void *asked_context;
    double began;   /* wall clock at which this process began to train */
    bool lasts;     /* TRAINER_FUSE_AFTER seconds are over */
    bool has_cache; /* programs are compiled and kept in `compiled` */
    char compiled[4000];
    uint64_t drawn[PROBLEM_STATE_MAX][TRAINER_DRAWN]; /* lent to a checkpoint */
    ad_error failure; /* why an evaluation failed for another reason than its numbers */
};

/* Columns of the history of a family in the strain form: errors over fresh members, and where they
 * stand. */
enum { TRAINER_MEMBERS = 6 };
const char *trainer_members_name(int column);
double *trainer_members_error(trainer_info *info, int column);

/* The problem and the reference go where the experiment is. Points of the reference in windows
 * before `from` have been compared already. */
ad_status trainer_enter_window(trainer *t, int from, ad_error *error);

/* Apply the part of the loads that is at work, if it is not all of them. */
void trainer_apply_loads(trainer *t);

/* The loss is a square, so where loads are small it is as well without any training: t->size is 1,
 * or the loss of the network 0, in a motion at least the square of its loads, if that is less. And
 * what is missing turns a rod that is soft in twist so much the further, and a beam on a stiff
 * foundation moves that much less. */
ad_status trainer_measure_size(trainer *t, ad_error *error);

/* Whether a loss is that of a scene as good as solved. */
bool trainer_is_small(const trainer *t, double loss);

/* stability_count of the shape at hand, under the part of the loads at work; -1 also where memory
 * lacks. */
int trainer_unstable_modes(const trainer *t);

/* Of fit_kind. */
ad_status trainer_put(void *of, checkpoint *file, ad_error *error);
ad_status trainer_get(void *of, const checkpoint *file, bool *at_work, ad_error *error);
ad_status trainer_got(void *of, const checkpoint *file, ad_error *error);

/* Takes over programs that are kept compiled; has them compiled when the run has lasted. */
void trainer_fuse(trainer *t);

void trainer_forget_optimizer(trainer *t);

/* What is measured when training is over. */
ad_status trainer_measure_end(trainer *t, ad_error *error);

/* Of the last stage half the steps are for unknowns that are held. */
void trainer_limit_steps(trainer *t);

#endif
