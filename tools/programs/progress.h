/* What a run says while it trains: one live line on a terminal, plain lines at growing
 * intervals in a pipe, and at the end error against run time. */
#ifndef TOOLS_PROGRAMS_PROGRESS_H
#define TOOLS_PROGRAMS_PROGRESS_H

#include "tools/train/session.h"

typedef struct progress {
    FILE *file;
    bool quiet;
    bool live;                        /* a terminal */
    const fit *of;                    /* borrowed */
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
} progress;

progress progress_start(FILE *file, bool quiet, const fit *of);

/* session_train until it is over or a signal comes (tools/programs/signals.h). */
ad_status progress_train(progress *p, session *s, ad_error *error);

/* To be called after every step. Prints only when it is time to. */
void progress_step(progress *p);

/* Removes the live line. */
void progress_clear(progress *p);

/* Prints a line that stays, in place of the live line. */
void progress_say(progress *p, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Errors of a family in the strain form over its fresh members, in the unit of a length in m. */
void progress_members(progress *p, const targets_errors *errors, double length);

/* When the error first fell below 1e-1, 1e-2, ...: a small table, from the history. With several
 * windows of time it begins with the last, when all of the time is covered. */
void progress_error_table(FILE *file, const history *h, int windows);

#endif
