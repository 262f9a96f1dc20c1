/* The line that says how a training is going: what it shows where there is little room, and the
 * time that is left. */
#ifndef TOOLS_PROGRAMS_STATUS_LINE_H
#define TOOLS_PROGRAMS_STATUS_LINE_H

#include "tools/train/train_settings.h"

/* Numbers that are not known are NaN and are not shown. */
typedef struct status_line {
    const char *optimizer; /* of the stage at work */
    int window, windows;   /* from 1; not shown where there is one */
    int stage, stages;     /* from 1 */
    int64_t step;          /* within the stage */
    int steps;             /* of the stage; 0: the time decides, not the number of steps */
    double load_factor;    /* not shown where it is 1 */
    double loss, held_out;
    double error;        /* against the reference, relative */
    double left;         /* s */
    bool at_most;        /* `left` is an upper bound */
    double points_per_s; /* evaluated */
    double steps_per_s;
} status_line;

enum { STATUS_LINE_SIZE = 256, STATUS_LINE_WIDE = STATUS_LINE_SIZE - 1 };

/* The line of at most `width` columns. What matters most is placed first: error, loss, window or
 * step, time left; what then does not fit is left out, the speed first of all. Returns its length.
 */
int status_line_text(const status_line *line, int width, char text[STATUS_LINE_SIZE]);

/* What the time left is estimated from; times in s. */
typedef struct status_pace {
    const train_stage *stages; /* [stage_count] */
    int stage, stage_count;    /* the stage at work, from 0 */
    int64_t stage_step;
    double stage_seconds;   /* spent in the stage at work */
    double step_seconds;    /* that a step takes; NaN: not known yet */
    int windows_left;       /* after the window at work */
    int windows_timed;      /* that were trained from beginning to end while being timed */
    double windows_seconds; /* they took together */
    double window_seconds;  /* spent in the window at work */
    bool repeats;           /* the stage at work will be repeated, it is not known how often */
    double limit_left;      /* when training ends in any case; INFINITY: no limit */
} status_pace;

/* Seconds until the last stage of the last window ends, NaN when that cannot be said. Windows that
 * were timed say how long the others will take. Without one the steps of all stages are counted, or
 * stop.seconds where they come first, which is an upper bound if stages may end by themselves. */
double status_time_left(const status_pace *pace, bool *at_most);

#endif
