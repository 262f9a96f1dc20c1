/* What a run says while it trains: one live line or a picture on a terminal, plain lines at growing
 * intervals in a pipe, and at the end error against run time. */
#ifndef TOOLS_PROGRAMS_PROGRESS_H
#define TOOLS_PROGRAMS_PROGRESS_H

#include "tools/programs/watch.h"

typedef struct progress {
    FILE *file;
    bool quiet;
    bool live;          /* a terminal */
    double started;     /* of this process */
    double next, gap;   /* when to speak again */
    int64_t first_step; /* of this process */
    int width;          /* of the live line last shown */
    double limit;       /* s after `started`, when it ends at the latest; 0: none */
    int window, stage;  /* at work after the last step, from 0 */
    int64_t stage_step;
    double window_began, stage_began; /* when they began, for this process */
    int64_t stage_first;              /* step of the stage at which this process took it up */
    bool window_whole;                /* this process has trained the window from its beginning */
    int windows_timed;                /* windows trained by this process from beginning to end */
    double windows_seconds;           /* that they took together */
    watch *watch;                     /* the picture in place of the live line; NULL: none */
    watch_shapes *shapes;
} progress;

progress progress_start(FILE *file, bool quiet, const trainer *t);

/* From now on with a picture, where the file can show one, until progress_end; `known` may be NULL.
 */
void progress_watch(progress *p, const trainer *t, const experiment *e, const reference *known);

/* To be called after every step. Prints only when it is time to. */
void progress_step(progress *p, const trainer *t, const experiment *e);

/* Removes the live line; the last picture stays. */
void progress_clear(progress *p);
void progress_end(progress *p, const trainer *t);

/* Prints a line that stays, in place of the live line. */
void progress_say(progress *p, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* When the error first fell below 1e-1, 1e-2, ...: a small table, from the history. With several
 * windows of time it begins with the last, when all of the time is covered. */
/* Errors of a family in the strain form over its fresh members, in the unit of a length in m. */
void progress_members(progress *p, const targets_errors *errors, double length);

void progress_error_table(FILE *file, const history *h, int windows);

#endif
