/* The one loop of all that is fitted: stages of an optimiser, one step at a time, with rows of
 * history, and the reason for which each ends; where there are several windows all stages again in
 * each. Its place is kept in a checkpoint, so that what is resumed computes the same bits:
 *
 *   training/step         steps over all windows and stages
 *   training/stage        number of the stage at work, from 0; number of stages when it is over
 *   training/window_step  steps within the window at work; where there are several
 *   training/stage_step   steps within the stage
 *   training/seconds, training/stage_seconds  wall time so far, doubles
 *   optimizer/...         the state of the optimiser at work */
#ifndef TOOLS_TRAIN_FIT_H
#define TOOLS_TRAIN_FIT_H

#include "tools/train/history.h"
#include "tools/train/train_settings.h"

#ifdef __cplusplus
extern "C" {
#endif

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
    /* A reason of its own for the stage to end; NULL: none. */
    const char *(*reason)(void *of, optim_status status);
    /* The stage has ended: takes its point over. Sets *again where it is to start again. */
    ad_status (*end)(void *of, optim_status status, bool *again, ad_error *error);
    /* All stages have ended: the window at work begins, or the fit is over. */
    ad_status (*turn)(void *of, ad_error *error);
} fit_kind;

typedef struct fit {
    const train_settings *settings; /* borrowed, with its stages */
    const ad_ranks *ranks;          /* borrowed; NULL: none */
    const fit_kind *kind;
    void *of;            /* of the kind */
    optim_optimizer *by; /* of the kind; NULL: none is at work */
    int windows;
    fit_state state;
    fit_place at, before;             /* now, and before the last step */
    int steps;                        /* that the stage at work may take */
    double loss, gradient_norm, rate; /* as the optimiser says, after the last step */
    double held_out, error;           /* at the last row; NaN: not known */
    double points;                    /* evaluated by this process; NaN: not counted */
    const char *ended;                /* why the last stage ended; NULL: none has */
    history rows;
    double held_out_ratio; /* of held-out to training loss at the last row */
    bool interpolates; /* it is above stop.held_out_ratio of the stage, or 100 where that is 0 */

    double started, stage_started; /* wall time at which they would have begun without pause */
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

double fit_seconds(const fit *f); /* of wall time, what is resumed among it */
double fit_stage_seconds(const fit *f);

/* The window that a row comes from, from 0. */
int fit_row_window(const fit *f, size_t row);

/* Takes note of a row of history: does the network interpolate? */
void fit_watch(fit *f, size_t row);

/* The held-out loss of rows to come has nothing to do with that of those before. */
void fit_forget_held_out(fit *f);

/* In a checkpoint. fit_get takes the place over; fit_go_on starts its stage if there is one, with
 * what the file says of its optimiser, if that is `at_work`; fit_get_rows the history, and what
 * stages look at of it. AD_BAD_INPUT: impossible. */
void fit_put(const fit *f, checkpoint *file);
ad_status fit_get(fit *f, const checkpoint *file, ad_error *error);
ad_status fit_go_on(fit *f, bool at_work, const checkpoint *file, ad_error *error);
ad_status fit_get_rows(fit *f, const checkpoint *file, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
