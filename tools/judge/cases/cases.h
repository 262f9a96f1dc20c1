/* A case, solved by a network and classically: what cpinn-cases is made of. */
#ifndef TOOLS_JUDGE_CASES_CASES_H
#define TOOLS_JUDGE_CASES_CASES_H

#include "autodiff/error.h"

#include <stdbool.h>
#include <stdio.h>

enum { CASES_NAME = 64, CASES_TEXT = 512 };

typedef enum cases_method { CASES_PINN, CASES_SOLVER, CASES_METHODS } cases_method;

const char *cases_method_name(cases_method method); /* "pinn", "solver" */

#define CASES_OUTCOME_LIST(X)                                                                      \
    X(CASES_SOLVED, "solved")                                                                      \
    X(CASES_DOUBTED, "doubted")         /* to the end, but the method itself says what is wrong */ \
    X(CASES_REFUSED, "refused")         /* before anything was computed */                         \
    X(CASES_STOPPED, "stopped")         /* on the way, with a reason */                            \
    X(CASES_OUT_OF_TIME, "out of time") /* its error is that of what there was */                  \
    X(CASES_CRASHED, "crashed")

#define CASES_ENUM(name, text) name,
typedef enum cases_outcome { CASES_OUTCOME_LIST(CASES_ENUM) CASES_OUTCOME_COUNT } cases_outcome;
#undef CASES_ENUM

const char *cases_outcome_name(cases_outcome outcome);

/* Numbers are NaN where there are none. */
typedef struct cases_row {
    char name[CASES_NAME]; /* of the case: that of its file */
    cases_method method;
    cases_outcome outcome;
    double position; /* relative L2 error over the points of the reference; a beam's deflection */
    double rotation; /* root mean square of the angle, rad */
    double seconds;  /* from reading the file to the solution, without comparing it */
    double unknowns; /* of a network: its outputs */
    double equations;
    double instructions;   /* of value and gradient of the loss, per step */
    double points;         /* collocation points of a network, nodes of the solver */
    double steps;          /* of the optimiser; of Newton's method, in motion of time */
    char left_out[64];     /* what the scene does not need and so is not there, separated by ';' */
    char text[CASES_TEXT]; /* one line that says why, unless solved */
} cases_row;

typedef struct cases_task {
    const char *path; /* of the YAML file */
    cases_method method;
    int threads;    /* of a network; 0: one for each processor */
    double seconds; /* limit */
} cases_task;

/* The name of a case: of its file, without folders and ending, as one that fits a file of words. */
void cases_name(const char *path, char name[CASES_NAME]);

/* In a process of its own, so that the others go on whatever happens here. AD_IO, AD_NO_MEMORY:
 * there is no such process. */
ad_status cases_run(const cases_task *task, cases_row *row, ad_error *error);

/* The table for people, as wide as the longest name. */
void cases_print_heading(FILE *file, int width);
void cases_print_row(FILE *file, const cases_row *row, int width);

/* cases.csv and cases.h5. */
ad_status cases_write(const cases_row *rows, size_t count, const char *folder, ad_error *error);

/* cases.gp, which makes cases.svg and cases.png: error over run time, a number for each case. */
ad_status cases_plot_write(const cases_row *rows, size_t count, const char *folder,
                           ad_error *error);

#endif
