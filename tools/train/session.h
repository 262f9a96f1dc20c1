/* A scene in training: the experiment, all that a trainer works with, and the way from the first
 * step to the last, with or without a folder in which the run is kept. */
#ifndef TOOLS_TRAIN_SESSION_H
#define TOOLS_TRAIN_SESSION_H

#include "tools/train/least_squares.h"
#include "tools/train/run.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct session session;

/* What is fitted, a trainer or a model of another kind. All is borrowed. */
typedef struct session_subject {
    fit *fit;
    const train_origin *origin;
    const char *text_item; /* of a checkpoint: what `origin` wrote */
    void *context;
    ad_status (*save)(session *s, const file_place *place,
                      ad_error *error); /* NULL: only computes */
    ad_status (*restore)(session *s, const checkpoint *file, ad_error *error);
} session_subject;

struct session {
    experiment *e;
    struct problem *problem;
    reference *known;        /* NULL: the scene names none */
    struct trainer *trainer; /* NULL: not started */
    double prepared;         /* s, of wall time that recording and compiling took */

    session_subject of; /* of session_start, or the caller's in a session that is 0 but for it */
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

/* Of descents, which it borrows as it does the origin: all that `origin` writes has to be the same
 * when they go on. For a session that is 0 but for it. */
session_subject session_of_descents(least_squares *ls, const train_origin *origin);

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

#ifdef __cplusplus
}
#endif

#endif
