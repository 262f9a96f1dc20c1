/* What a run says while it trains: one live line or a picture on a terminal, plain lines at growing
 * intervals in a pipe, and at the end error against run time. */
#ifndef TOOLS_PROGRAMS_PROGRESS_H
#define TOOLS_PROGRAMS_PROGRESS_H

#include "tools/programs/watch.h"
#include "tools/train/session.h"

typedef struct progress {
    FILE *file;
    bool quiet;
    bool live;                        /* a terminal */
    const fit *of;                    /* borrowed */
    const char *note;                 /* a line below a picture's curves; NULL: none */
    double started;                   /* of this process */
    double next, gap;                 /* when to speak again */
    int64_t first_step;               /* of this process */
    int width;                        /* of the live line last shown */
    double limit;                     /* s after `started`, when it ends at the latest; 0: none */
    fit_place last;                   /* after the last step */
    double window_began, stage_began; /* when they began, for this process */
    int64_t stage_first;              /* step of the stage at which this process took it up */
    bool window_whole;                /* this process has trained the window from its beginning */
    int windows_timed;                /* windows trained by this process from beginning to end */
    double windows_seconds;           /* that they took together */
    watch *watch;                     /* the picture in place of the live line; NULL: none */
    watch_shapes *shapes;             /* in it; NULL: none */
    trainer *shaped;                  /* whose they are */
} progress;

progress progress_start(FILE *file, bool quiet, const fit *of, const char *note);

/* From now on with a picture, where the file can show one, until progress_end, and with shapes in
 * it, `known` among them, which may be NULL. */
void progress_watch_shapes(progress *p, trainer *t, const experiment *e, const reference *known);

/* session_train until it is over or a signal comes (tools/programs/signals.h), with a picture if
 * `watches`. */
ad_status progress_train(progress *p, session *s, bool watches, ad_error *error);

/* To be called after every step. Prints only when it is time to. */
void progress_step(progress *p);

/* Removes the live line; the last picture stays. */
void progress_clear(progress *p);
void progress_end(progress *p);

/* Prints a line that stays, in place of the live line. */
void progress_say(progress *p, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Errors of a family in the strain form over its fresh members, in the unit of a length in m. */
void progress_members(progress *p, const targets_errors *errors, double length);

/* When the error first fell below 1e-1, 1e-2, ...: a small table, from the history. With several
 * windows of time it begins with the last, when all of the time is covered. */
void progress_error_table(FILE *file, const history *h, int windows);

#endif
