/* Methods of training against one another: which there are, training by each of them, what they
 * reached after how long, as tables, files and pictures. The parts of cpinn-bench. */
#ifndef TOOLS_JUDGE_COMPARE_H
#define TOOLS_JUDGE_COMPARE_H

#include "tools/judge/judge.h"
#include "tools/prepare/config_session.h"

#include <stdbool.h>

enum {
    COMPARE_NAME = JUDGE_NAME,
    COMPARE_METHODS_MAX = 32,
    COMPARE_NETWORKS_MAX = 32,
    COMPARE_CURVES_MAX = 32,
    COMPARE_SEEDS_MAX = 100,
    COMPARE_LIMITS = 5,
    COMPARE_GRID = 240
};

/* ---- methods and networks ------------------------------------------------------------------ */

typedef struct compare_method {
    char name[COMPARE_NAME];
    char stages[COMPARE_NAME]; /* "adam:300+lbfgs"; "": those of the config */
    char override[1024];       /* as for --set; "": none */
    bool is_solver;            /* classical, without a network */
} compare_method;

/* The ways to train that have a name, but for those whose optimiser is not there, separated by
 * commas; config, that of the file itself, and solver are not among them. */
void compare_method_names(char *text, size_t size);

/* One line for each, for --help. */
void compare_method_help(FILE *file);

/* "lbfgs,config,fast=adam:300+gauss_newton:60": names and definitions, separated by commas. A
 * definition is OPTIMIZER:STEPS joined by '+'; without STEPS the stage ends only by itself or by
 * the time limit. AD_BAD_INPUT: the line that the user reads. */
ad_status compare_methods_parse(const char *text, compare_method methods[COMPARE_METHODS_MAX],
                                int *count, ad_error *error);

typedef struct compare_network {
    char name[COMPARE_NAME]; /* as given */
    char hidden[256];        /* as for --set; "": the network of the config */
    char features[64];
} compare_network;

/* "2x16,f64,2x16+f8": hidden layers x width, random Fourier features without hidden layers, and
 * both. Features are those of the config where nothing is said. NULL: the network of the config
 * alone. */
ad_status compare_networks_parse(const char *text, compare_network networks[COMPARE_NETWORKS_MAX],
                                 int *count, ad_error *error);

/* "3x32", "f64", "3x32+f8", "p20" of polynomials of degree 20; "16-32-16" if the layers differ. */
void compare_network_name(char name[COMPARE_NAME], const nn_mlp_settings *network);

/* ---- runs ---------------------------------------------------------------------------------- */

/* Called after every step of training, and once more at its end. */
typedef ad_status compare_step(void *context, session *s, bool is_last, ad_error *error);

typedef struct compare_task {
    const char *path;             /* of the YAML file */
    const char *const *overrides; /* [override_count], as for --set */
    int override_count;
    bool is_solver;
    int threads;        /* of a network; 0: one for each processor. The solver has one */
    double seconds;     /* limit of training */
    compare_step *step; /* of training; NULL: nobody looks on */
    void *context;      /* of step */
} compare_task;

typedef struct compare_row {
    double seconds; /* of training and of preparing it, without evaluating errors */
    double step, loss, held_out;
    double errors[JUDGE_MEASURES]; /* NaN: the reference does not know, or windows are to come */
} compare_row;

typedef struct compare_run {
    int cell;
    uint64_t seed;
    compare_row *rows; /* [count], in time */
    size_t count, capacity;
    double seconds; /* as in the rows, at the end */
    int64_t steps;
    verdict verdict;
} compare_run;

/* Whether it has no answer, for another reason than the clock or a signal. */
bool compare_failed(const compare_run *run);

/* A scene trained by a method with a network. */
typedef struct compare_cell {
    int scene; /* cells of a scene follow one another */
    char scene_name[COMPARE_NAME], method[COMPARE_NAME], network[COMPARE_NAME];
    char form[JUDGE_FORM]; /* as judge_form has it */
    size_t parameters;
    double estimates[JUDGE_MEASURES]; /* of the errors of the reference itself; NaN: unknown */
} compare_cell;

typedef struct compare_results {
    judge_measure measure;
    const compare_cell *cells;
    int cell_count;
    compare_run *runs; /* of any order */
    int run_count;
} compare_results;

ad_status compare_run_add(compare_run *run, const compare_row *row, ad_error *error);
void compare_run_free(compare_run *run);

/* Prepares and takes one step, so that what cannot be trained is refused before anything is, and
 * what is loaded once is not charged to whoever comes first. Fills in names and parameters of the
 * cell but for the method; the seed that the config has. */
ad_status compare_rehearse(const compare_task *task, judge_measure measure, compare_cell *cell,
                           uint64_t *seed, ad_error *error);

/* Trains; rows come at step 1, after each 5% of time, and at the end of stages. By the solver,
 * which needs no seed, rows are those of ever more nodes, in the place of steps. What the method
 * itself cannot do is no error, the run says so. The task's step is called as well. `run` is freed
 * by the caller in any case. */
ad_status compare_do(const compare_task *task, judge_measure measure, compare_run *run,
                     ad_error *error);

/* ---- statistics ---------------------------------------------------------------------------- */

/* INFINITY stands for what was not reached, so it counts as larger than anything. */
typedef struct compare_spread {
    double median, low, high; /* NaN: of nothing */
} compare_spread;

/* Sorts the values, none of which is NaN. The median of an even number is the mean of two. */
compare_spread compare_spread_of(double *values, size_t count);

/* Smallest error of the rows until `seconds`; INFINITY before the first. */
double compare_best(const compare_run *run, judge_measure measure, double seconds);

/* Seconds of the first row with an error <= limit; INFINITY when there is none. */
double compare_reached(const compare_run *run, judge_measure measure, double limit);

extern const double compare_limits[COMPARE_LIMITS]; /* 1e-2 .. 1e-6 */

typedef struct compare_summary {
    int seeds, failed, warned;      /* runs; of them without an answer, with a warning */
    compare_spread error;           /* of the last rows; INFINITY: failed */
    double reached[COMPARE_LIMITS]; /* medians, s */
    double seconds;                 /* median */
    double steps_per_second;        /* median; NaN: no step was taken */
} compare_summary;

/* Over the runs of a cell, at most COMPARE_SEEDS_MAX. */
compare_summary compare_summarize(const compare_results *results, int cell);

/* Best error so far against time, over the runs of a cell; a run keeps its best when it is over.
 * Times are log-spaced, common to the cells of a scene, from its first row until the last row of
 * the cell; times at which the median is not known yet are left out. */
typedef struct compare_band {
    size_t count;
    double seconds[COMPARE_GRID + 1];
    compare_spread errors[COMPARE_GRID + 1];
} compare_band;

void compare_band_of(const compare_results *results, int cell, compare_band *band);

/* ---- curves of others ---------------------------------------------------------------------- */

typedef struct compare_curve {
    char name[COMPARE_NAME];
    double *seconds, *errors; /* [count]; owned */
    size_t count;
} compare_curve;

typedef struct compare_curves {
    int count;
    compare_curve curves[COMPARE_CURVES_MAX];
} compare_curves;

/* "FILE" or "NAME=FILE": a table (tools/files/table_file.h) with columns seconds and error, both
 * > 0. A column of words, name, makes several curves of it and does not go with NAME; without it
 * the curve is called NAME or as the file. Appends. */
ad_status compare_curves_read(compare_curves *curves, const char *text, ad_error *error);
void compare_curves_free(compare_curves *curves);

/* ---- output -------------------------------------------------------------------------------- */

/* One line for each cell, under a heading for each scene. */
void compare_print(FILE *file, const compare_results *results);

/* runs, summary and curves, each as .csv and .h5. */
ad_status compare_write(const compare_results *results, const char *folder, ad_error *error);

/* SCENE.gp, which makes SCENE.svg and SCENE.png by gnuplot_draw. note: a line under the title, may
 * be "". */
ad_status compare_plot_write(const compare_results *results, int scene,
                             const compare_curves *curves, const char *note, const char *folder,
                             ad_error *error);

#endif
