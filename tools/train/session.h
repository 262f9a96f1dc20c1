/* A scene in training: the experiment, and all that a trainer works with. */
#ifndef TOOLS_TRAIN_SESSION_H
#define TOOLS_TRAIN_SESSION_H

#include "tools/train/trainer.h"

typedef struct session {
    experiment *e;
    problem *problem;
    reference *known; /* NULL: the scene names none */
    trainer *trainer; /* NULL: not started */
    double prepared;  /* s, of wall time that recording and compiling took */
} session;

/* Everything but the trainer; arguments as for experiment_create. Also after a failure
 * session_free is for the caller. */
ad_status session_prepare(const scene *rod_scene, train_settings *settings,
                          const train_origin *origin, int threads, session *s, ad_error *error);

/* The trainer. Recording and compiling count as training; the reference, which only measures, does
 * not. */
ad_status session_start(session *s, ad_error *error);
void session_free(session *s);

#endif
