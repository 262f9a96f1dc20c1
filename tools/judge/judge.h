/* A scene by a method: what cpinn-bench and cpinn-cases share. A scene is trained or
 * solved as the programs do it, and a row says how that ended, how wrong the answer is and what it
 * took. */
#ifndef TOOLS_JUDGE_JUDGE_H
#define TOOLS_JUDGE_JUDGE_H

#include "tools/prepare/config_session.h"

enum { JUDGE_NAME = 64, JUDGE_FORM = 40 }; /* bytes of a name and of a form, the end included */

typedef enum judge_method { JUDGE_NETWORK, JUDGE_SOLVER, JUDGE_METHODS } judge_method;

const char *judge_method_name(judge_method method); /* "network", "solver" */

/* Errors against the reference of the scene. */
typedef enum judge_measure {
    JUDGE_POSITION, /* relative L2 error over all points; a beam's deflection */
    JUDGE_TIP,      /* largest error at s = length, over the length */
    JUDGE_ROTATION, /* root mean square of the angle, rad */
    JUDGE_MEASURES
} judge_measure;

const char *judge_measure_name(judge_measure measure); /* "tip", as on the command line */
const char *judge_measure_text(judge_measure measure); /* in words */
void judge_measures(const reference_errors *from, double errors[JUDGE_MEASURES]);

/* `text` as a name that fits a file of words (tools/files/table_file.h): other bytes become '_'.
 * And that of a file, without folders and ending. */
void judge_name(char name[JUDGE_NAME], const char *text);
void judge_name_of_file(char name[JUDGE_NAME], const char *path);

/* ---- tasks and rows ------------------------------------------------------------------------ */

/* Called after every step of training, and once more at its end, when the trainer has a row of the
 * last step. */
typedef ad_status judge_step(void *context, session *s, bool is_last, ad_error *error);

typedef struct judge_task {
    const char *path;             /* of the YAML file */
    const char *const *overrides; /* [override_count], as for --set */
    int override_count;
    judge_method method;
    int threads;      /* of a network; 0: one for each processor. The solver has one */
    double seconds;   /* limit of training */
    double patience;  /* s, of wall time: a process that takes longer is killed */
    judge_step *step; /* of training; NULL: nobody looks on */
    void *context;    /* of step */
} judge_task;

/* Numbers are NaN where there are none. No pointers: rows come from other processes. */
typedef struct judge_row {
    verdict verdict;
    double errors[JUDGE_MEASURES]; /* of a motion, once all its windows are trained */
    double seconds;                /* from reading the file to the answer, without comparing it */
    double unknowns;               /* of a network: its outputs */
    double equations;
    double instructions;   /* of value and gradient of the loss, per step */
    double points;         /* collocation points of a network, nodes of the solver */
    double steps;          /* of the optimiser; of Newton's method, in motion of time */
    char form[JUDGE_FORM]; /* of the answer, as judge_form has it; "": it was refused before */
    char left_out[64];     /* what the scene does not need and so is not there, separated by ';' */
} judge_row;

/* A row before anything is known. */
judge_row judge_row_empty(void);

/* Reads the scene of a task. *seconds (may be NULL) receives how long that took. */
ad_status judge_read(const judge_task *task, config **settings, double *seconds, ad_error *error);

/* The scene of a task, for the solver, and its reference: NULL without one, and unless `own` where
 * it is the solver's. Also after a failure the caller frees both. */
ad_status judge_open(const judge_task *task, bool own, experiment **e, reference **known,
                     double *seconds, ad_error *error);

/* Does the task in this process. What goes wrong is in the verdict of the row too. Training that a
 * signal (tools/judge/signals.h) or the limit ends is no error. */
ad_status judge_by_network(const judge_task *task, judge_row *row, ad_error *error);
ad_status judge_by_solver(const judge_task *task, judge_row *row, ad_error *error);

/* Does it in a process of its own, so that others can go on whatever happens there; `step` is lost
 * on that process. AD_IO, AD_NO_MEMORY: there is no such process; all else is in the verdict. */
ad_status judge_run(const judge_task *task, judge_row *row, ad_error *error);

/* ---- what a scene is made of --------------------------------------------------------------- */

/* Form of the equations and functions by which a method answers a scene: "strain modes by
 * polynomials", "mixed form by random waves", "mixed form by a network" (with hidden layers),
 * "spectral elements", "collocation". */
void judge_form(const experiment *e, judge_method method, char text[JUDGE_FORM]);

/* The form of a row, or the method where there is none. */
const char *judge_form_of(const judge_row *row, judge_method method);

/* Form, unknowns, equations, instructions and points of a network. */
void judge_describe(const session *s, judge_row *row);
void judge_left_out(const scene *rod_scene, judge_method method, char text[64]);

#endif
