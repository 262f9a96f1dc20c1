/* What the training of a one-step model says while it goes on, on stdout: a picture on a terminal,
 * if it is wanted, else lines at growing intervals. */
#ifndef TOOLS_PROGRAMS_SURROGATE_PROGRESS_H
#define TOOLS_PROGRAMS_SURROGATE_PROGRESS_H

#include "tools/programs/watch.h"
#include "tools/surrogate/training.h"

typedef struct surrogate_progress {
    bool quiet, pictures; /* to be set; the rest is 0 at first */
    const char *note;     /* too: of a picture */
    watch *watch;         /* from begin to end; NULL: lines */
    const train_settings *settings;
    surrogate_training *own;
    double began;       /* s, of the steps of this process */
    int64_t first_step; /* of it */
    double next, gap;   /* s, when to speak again */
} surrogate_progress;

/* A line that stays. */
void surrogate_progress_say(const surrogate_progress *p, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Before the first step of this process, after each, and after the last, whose picture stays. */
void surrogate_progress_begin(surrogate_progress *p, const train_settings *settings,
                              surrogate_training *t);
void surrogate_progress_step(surrogate_progress *p);
void surrogate_progress_end(surrogate_progress *p);

#endif
