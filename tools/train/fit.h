/* The one loop of all that is fitted: stages of an optimiser, one step at a time, with rows of
 * history, and the reason for which each ends; where there are several windows all stages again in
 * each. Its place is kept in a checkpoint, so that what is resumed computes the same bits:
 *
 *   training/step         steps over all windows and stages
 *   training/stage        number of the stage at work, from 0; number of stages when it is over
 *   training/window_step  steps within the window at work; where there are several
 *   training/stage_step   steps within the stage
 *   training/seconds, training/stage_seconds  time so far, doubles
 *   optimizer/...         the state of the optimiser at work */
#ifndef TOOLS_TRAIN_FIT_H
#define TOOLS_TRAIN_FIT_H

#include "tools/train/history.h"
#include "tools/train/train_settings.h"

#include <stdio.h>

/* Whoever filled in scene and settings: can write them as text, knows where a key stands, and holds
 * their memory. All may be NULL; without `write` there are no checkpoints, without `write_physics`
 * no classical solution is kept between runs. */
typedef struct train_origin {
    void *context;
    ad_status (*write)(void *context, FILE *file); /* everything, as it is now */
    ad_status (*write_physics)(void *context,
                               FILE *file); /* what a classical solution depends on */
    ad_status (*refuse)(void *context, const char *key, const char *problem,
                        ad_error *error); /* AD_BAD_INPUT, and the line with the key's place */
    ad_status (*continues)(void *context, const char *path, const char *text, int64_t stage,
                           ad_error *error); /* may this go on where a run, of which the file at
                                              * `path` holds the text, has come to the stage? */
    void (*free)(void *context);
} train_origin;

/* What it writes, allocated; NULL when it cannot, or memory runs out. */
char *train_origin_text(const train_origin *origin);

/* The item of a checkpoint that says it. */
void train_origin_put(const train_origin *origin, const char *item, checkpoint *file);

typedef enum fit_state {
    FIT_RUNNING,
    FIT_OVER,
    FIT_NOT_FINITE /* a number stopped being finite; the last checkpoint is good */
} fit_state;

typedef struct fit_place {
    int64_t step, window_step, stage_step; /* done: in all, in the window, in the stage */
    int window, stage;                     /* at work, from 0 */
    double part;                           /* of loads that is at work; 1: all */
} fit_place;

/* What is fitted. NULL: nothing of the kind. */
typedef struct fit_kind {
    /* Makes the optimiser of the stage at work, `by`, from where the fit has come to. */
    ad_status (*start)(void *of, ad_error *error);
    /* A step of it. *taken false: it was given up, and all is as before. */
    ad_status (*step)(void *of, optim_status *status, bool *taken, ad_error *error);
    /* Adds a row of history with columns stage, from 1, and loss and held_out; may set held_out and
     * error. */
    ad_status (*row)(void *of, ad_error *error);
    /* What held_out of a row compares with. */
    double (*trained)(const void *of, size_t row);
    /* The stage has ended: takes its point over. Sets *again where it is to start again. */
    ad_status (*end)(void *of, optim_status status, bool *again, ad_error *error);
    /* All stages have ended: the window at work begins, or the fit is over. */
    ad_status (*turn)(void *of, ad_error *error);
    /* In a checkpoint, which borrows: what the fit does not know. `get` comes before the stage at
     * work starts, *at_work false: without a state of its optimiser; `got` behind that and the
     * rows. */
    ad_status (*put)(void *of, checkpoint *file, ad_error *error);
    ad_status (*get)(void *of, const checkpoint *file, bool *at_work, ad_error *error);
    ad_status (*got)(void *of, const checkpoint *file, ad_error *error);
} fit_kind;

typedef struct fit {
    const train_settings *settings; /* borrowed, with its stages */
    const ad_ranks *ranks;          /* borrowed; NULL: none */
    const fit_kind *kind;
    void *of;                   /* of the kind */
    const train_origin *origin; /* borrowed: writes what is asked for; NULL: nobody does */
    const char *text_item;      /* of a checkpoint, that keeps it */
    optim_optimizer *by;        /* of the kind; NULL: none is at work */
    int windows;
    fit_state state;
    fit_place at, before;             /* now, and before the last step */
    int steps;                        /* that the stage at work may take */
    double loss, gradient_norm, rate; /* as the optimiser says, after the last step */
    double held_out, error;           /* at the last row; NaN: not known */
    double points;                    /* evaluated by this process; NaN: not counted */
    const char *ended;                /* why the last stage ended; NULL: none has */
    const char *reason;               /* of the kind, set by its step: to end the stage now */
    history rows;
    double held_out_ratio; /* of held-out to training loss at the last row */
    bool interpolates; /* it is above stop.held_out_ratio of the stage, or 100 where that is 0 */

    double started, stage_started; /* wall time at which they would have begun without pause */
    double still;                  /* wall time at which the clock stands; NaN: it runs */
    double best_held_out;          /* of all rows of the window */
    int rows_apart;  /* of this stage: held-out loss far above, and no new minimum, in turn */
    char apart[128]; /* that this has been so for too long */
} fit;

/* Of a loss: residuals of 1e-10, a few digits above what rounding leaves of equations with second
 * derivatives. Below, a ratio of losses is one of rounding errors. */
#define FIT_ROUNDING_LOSS 1e-20

/* At its first stage, which fit_start starts. The rows have no columns yet; fit_free frees them. */
fit fit_of(const train_settings *settings, const ad_ranks *ranks, const fit_kind *kind, void *of);
ad_status fit_start(fit *f, ad_error *error);
void fit_free(fit *f);

/* One step, a row of history when it is due or a stage ends, and then what comes next. */
ad_status fit_step(fit *f, ad_error *error);

/* A row of history now. */
ad_status fit_add_row(fit *f, ad_error *error);

/* Of wall time, what is resumed among it. The clock stands still while a row is made, which a user
 * asks for and which is no part of the fit, and once the fit is over. */
double fit_seconds(const fit *f);
double fit_stage_seconds(const fit *f);

/* The window that a row comes from, from 0. */
int fit_row_window(const fit *f, size_t row);

/* Takes note of a row of history: does the network interpolate? */
void fit_watch(fit *f, size_t row);

/* Writes a checkpoint; place NULL: only computes what is in it, on ranks that do not write. */
ad_status fit_save(fit *f, const file_place *place, ad_error *error);

/* Goes on where it ends, at any time. AD_BAD_INPUT: impossible. */
ad_status fit_restore(fit *f, const checkpoint *file, ad_error *error);

#endif
