/* A scene in training: the experiment, all that a trainer works with, and the way from the first
 * step to the last, with or without a folder in which the run is kept. */
#ifndef TOOLS_TRAIN_SESSION_H
#define TOOLS_TRAIN_SESSION_H

#include "tools/train/fit.h"
#include "tools/train/run.h"

typedef struct session session;

struct session {
    experiment *e;
    struct problem *problem;
    reference *known;        /* NULL: the scene names none */
    struct trainer *trainer; /* NULL: not started */
    double prepared;         /* s, of wall time that recording and compiling took */

    fit *fit;           /* of session_start, or the caller's in a session that is 0 but for it */
    run_folder *folder; /* lent by session_begin; NULL: the run is in memory alone */
    double last_save;
    int64_t saved_step;
};

/* Everything but the trainer; arguments as for experiment_create. Also after a failure
 * session_free is for the caller. */
ad_status session_prepare(const scene *rod_scene, train_settings *settings,
                          const train_origin *origin, int threads, session *s, ad_error *error);

/* The same of physics of one's own; see experiment_of_model. */
ad_status session_prepare_model(physics_model *m, train_settings *settings,
                                const train_origin *origin, int threads, session *s,
                                ad_error *error);

/* The trainer. Recording and compiling count as training; the reference, which only measures, does
 * not. */
ad_status session_start(session *s, ad_error *error);
void session_free(session *s);

/* Where the pool is shared among ranks (autodiff/ranks.h), all of them call everything here; the
 * first one alone writes. */

/* Keep the run in a folder that has got its names by run_name. A new one is made and gets its first
 * checkpoint, so that whatever a killed process leaves can be resumed; `resume`: training goes
 * on where the checkpoint in it ends. AD_BAD_INPUT: there is a run already; or what is to be
 * resumed is another one. */
ad_status session_begin(session *s, run_folder *folder, bool resume, ad_error *error);

/* After each step. False: stop after this step. */
typedef bool (*session_stepped)(void *context);

/* Step by step until training is over or `stepped` (may be NULL) wants to stop, with rows of
 * history and checkpoints on the way and at the end. Afterwards what is trained is still running if
 * it was stopped. Errors are those of its step, and of files. */
ad_status session_train(session *s, session_stepped stepped, void *context, ad_error *error);

#endif
