/* A scene in training: the experiment, and all that a trainer works with. */
#ifndef TOOLS_TRAIN_SESSION_H
#define TOOLS_TRAIN_SESSION_H

#include "tools/train/trainer.h"

typedef struct session {
    experiment *e;
    problem *problem;
    reference *known; /* NULL: the scene names none */
    trainer *trainer;
} session;

/* Takes over `settings`, also when it fails; then session_free is for the caller as well. Recording
 * and compiling count as training; the reference, which only measures, does not. */
ad_status session_create(config *settings, int threads, session *s, ad_error *error);
void session_free(session *s);

#endif
