/* Training as a state machine: one optimiser step at a time, through the stages of an experiment,
 * in every window of its time anew, with all of its state in a checkpoint, so that a resumed run
 * computes the same bits.
 *
 * Items in a checkpoint beside those of tools/train/experiment.h and fit.h (integers unless said):
 *   training/optimizer   1 while an optimiser's state is stored under optimizer/
 *   estimate             trainer_estimate, double
 *   training/kernels     text, ad_dense_kernels: of another processor the last digits differ
 *   training/loads/...   doubles part, reached, before, increment, solved [2, parameters] of
 *                        optim/continuation.h; where the loads may come in parts */
#ifndef TOOLS_TRAIN_TRAINER_H
#define TOOLS_TRAIN_TRAINER_H

#include "physics/scene/verdict.h"
#include "tools/train/fit.h"
#include "tools/train/fresh_members.h"
#include "tools/train/learnt_balance.h"
#include "tools/train/reference.h"

typedef struct trainer trainer;

/* Of the weighted, dimensionless loss, for loads of order one; solutions that are right to about a
 * percent lie below. */
#define TRAINER_LARGE_LOSS 1e-2

/* What is measured beside what the fit knows. */
typedef struct trainer_info {
    double points;           /* per evaluation of the loss */
    reference_errors errors; /* of a family in the strain form the position is members.median */
    targets_errors members;  /* of such a family, else NaN */
    bool solved;             /* the last stage ended with a small loss, at rest in a stable shape if
                              * that can be told */
    char account[160];       /* what its optimiser has to say of its steps; may be empty */
    problem_fusing fused;    /* programs whose elementwise work is compiled by now */
    char kernels[32];        /* of a resumed run whose steps so far were computed with other kernels
                              * than ad_dense_kernels: theirs; else empty */
    learnt_balance balance;  /* when training is over; else NaN */
    model_motion_error motion; /* then: of one motion in the strain form */
    fresh_errors fresh;        /* of a family of rods at rest in mixed form, then; else NaN */
    double estimate;           /* then: experiment_error, of a family the largest of some fresh
                                * members; NaN: not known, or one of the two above is */
    char unknown[160];         /* why it is not known; empty: it is not asked for */
} trainer_info;

/* Whether a motion in the strain form that has been trained takes more modes, or a larger degree in
 * time, to be estimated within its tolerance: those to try next. */
bool trainer_needs(const trainer *t, int modes[4], int *degree);

/* `problem_` and `known` (NULL: no reference) are those of the experiment's first window; the
 * trainer takes them on from window to window, and they must outlive it. seconds: wall time already
 * spent on preparing, counted as training. */
ad_status trainer_create(experiment *e, problem *problem_, reference *known, double seconds,
                         trainer **result, ad_error *error);
void trainer_free(trainer *t);

/* One step of the optimiser of the stage at hand, then a row of history when one is due or a stage
 * ends. After FIT_NOT_FINITE, error says which term, where, and what to try. */
ad_status trainer_step(trainer *t, ad_error *error);

/* Within a step of Gauss-Newton `asked` (NULL: nobody) is called again and again, by any thread;
 * when it is true the step is given up: trainer_step returns AD_OK with everything as it was before
 * it, the number of steps too. */
void trainer_watch_stop(trainer *t, bool (*asked)(void *context), void *context);

const trainer_info *trainer_inspect(const trainer *t);
fit *trainer_fit(trainer *t);

/* Seconds of training after which the elementwise work of its programs is compiled (problem_fuse)
 * that no earlier run has kept: a compiler takes some, so a run that ends before had little to win.
 * The steps go on meanwhile, and have the same bits. */
#define TRAINER_FUSE_AFTER 10

/* The folder where compiled programs are kept, of at least 4000 bytes; what leads to it is made, if
 * `make`. False: there is none. */
bool trainer_fuse_folder(char *path, bool make);

/* How the stage's optimiser computes its steps, in a few words; empty: nothing to tell. */
void trainer_describe(const trainer *t, char text[160]);

/* The error to expect of the position over the length, or of a beam's deflection over its largest:
 * when training is over how far the solver's equations move the network's shape or motion
 * (experiment_error), of a family at rest that of the worst of fresh members, of one motion in the
 * strain form by its residual in more modes. Of networks without hidden layers in mixed form, in
 * motion or of one scene, from residuals at points never trained on, at any time. NaN: not known.
 */
double trainer_estimate(const trainer *t);

/* The verdict on training as it stands, worst reason first: unfinished; or, of training that is
 * over, that the network interpolates its points, that residuals are still large, in whichever
 * window they are largest, that the estimated error is, that the scene has jumps that are not
 * known, that a motion is out of balance, and that a shape at rest is not stable. And the remark
 * that errors are below that of the reference; where they are larger than both estimated errors
 * allow that is a warning, and the reference is removed from the cache. */
void trainer_verdict(const trainer *t, verdict *result);

/* The parameters to evaluate: the best of the stage so far, or the current ones where points or
 * weights change so that losses do not compare. */
const double *trainer_parameters(const trainer *t);

#endif
