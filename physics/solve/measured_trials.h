/* What measured.c and measured_change.c share. */
#ifndef PHYSICS_SOLVE_MEASURED_TRIALS_H
#define PHYSICS_SOLVE_MEASURED_TRIALS_H

#include "autodiff/memory.h"
#include "physics/chain/solve_members.h"
#include "physics/scene/scene_values.h"
#include "physics/scene/view.h"
#include "physics/solve/measured_memory.h"

/* One row of one set; rows of an experiment follow one another, in the order of their times. */
typedef struct measured_row {
    const solve_measured *set;
    const scene_seen *view; /* NULL: none */
    size_t row;
    const double *known; /* [parameter_count], 0 for unknowns */
    int known_count;
    const solve_inputs *inputs; /* over time; NULL: none */
    size_t turn;                /* of inputs with a memory */
    double t;
    size_t residual; /* where its residuals begin */
    size_t place;    /* which of the places of members */
} measured_row;

struct solve_trials {
    scene open;
    scene_values names; /* its, where inputs have a memory */
    int unknowns;
    bool apart;  /* each experiment has values of its own */
    int columns; /* of the model: so many are needed */
    double tolerance;
    ad_pool *pool;
    size_t rows, residuals, experiments, every; /* of the experiments each so many-th counts */
    measured_row *row;
    scene_seen *views;      /* [sets] */
    double *known;          /* [rows][parameter_count] */
    trial_memory *inputs;   /* what they remember; NULL: nothing */
    size_t *first;          /* [experiments + 1] rows */
    double *at, *curvature; /* values of the last single trial by members, and its curvature, of
                             * those that count [][3 nodes]; NaN: none */
    double *nodes; /* [experiments] of motions, kept so that solutions change smoothly: nodes, modes
                    * (solve_trials_packed), steps between samples of inputs; 0: open */
    bool chooses;  /* these, where one trial is run */
    bool rough;    /* the run at hand */
    solve_members *members;       /* NULL: one by one */
    bool moves;                   /* some motion is by modes, */
    int modes[4], more;           /* by these and so many more of each */
    solve_recording **recordings; /* [threads of the pool]; NULL: there are none */
    size_t places;
    double *place;   /* [places] s, ascending, m */
    ad_error reason; /* why there was no solution, of the last run */
    ad_memory memory;
};

typedef struct trial_batch {
    solve_trials *x;
    const double *values;
    double *residuals;
    size_t trials, count;
    size_t *job;       /* [count] number of the trial times experiments, plus the experiment */
    ad_status *status; /* [count] */
    ad_error *error;   /* [count] */
} trial_batch;

/* How many experiments count. */
size_t solve_trials_counted(const solve_trials *trials);

/* parameters [parameter_count] of an experiment at trial values. */
void solve_trials_fill(const solve_trials *trials, const double *values, size_t experiment,
                       double *parameters);

/* The time of the rod of a row, within its motion. */
double solve_trials_time(const solve_trials *trials, const measured_row *row,
                         const double *parameters);

/* Residuals of one row, from the computed columns of the model, each `stride` numbers after the one
 * before, and the parameters of its trial. */
void solve_trials_compare(const solve_trials *trials, const measured_row *of,
                          const double *parameters, const double *computed, size_t stride,
                          double *residuals);
size_t solve_trials_row_residuals(const solve_trials *trials, const measured_row *of);

/* Residuals of an experiment become no numbers, 0 where it does not count. */
void solve_trials_clear(const solve_trials *trials, size_t experiment, double *residuals);

/* Modes where none are asked for: three times as many states as a filter has, and errors of some
 * 1e-5 of the length (the last row of a table in physics/chain/reduced.h is the first). */
static const int TRIALS_MODES[4] = {5, 3, 3, 2};

/* Whether motions are by modes, and what is asked of them. */
void solve_trials_find_modes(solve_trials *trials);

/* Those that are asked for, or the usual ones, with so many more. */
void solve_trials_modes(const solve_trials *trials, int modes[4]);

/* Modes and tolerance of an experiment without inputs: as many as are asked for, or as the first
 * solution took, which is kept as one number; none: as many as the tolerance asks for. */
void solve_trials_choose_modes(const solve_trials *trials, size_t experiment,
                               solve_settings *settings);
double solve_trials_packed(const int of[6]);

/* Of the tolerance, that of steps of time where nodes or modes are chosen. */
static const double TRIALS_STEPS = 1e-2;

/* So many modes more from now on. Of motions with inputs over time, which come last: rods with
 * them, in place of those there are; and residuals of one of them, by a thread of the pool. */
ad_status solve_trials_record(solve_trials *trials, int more, ad_error *error);
void solve_trials_forget(solve_trials *trials);
ad_status solve_trials_follow(solve_trials *trials, size_t experiment, int thread,
                              const double *parameters, double *residuals, ad_error *error);

/* Called for each row of an experiment with inputs: its columns, and how they change by each of the
 * unknowns, `change` [unknowns], `width` numbers apart; each column `stride` numbers after the one
 * before. */
typedef void solve_trials_taker(void *context, const measured_row *row, const double *columns,
                                const double *change, size_t width, size_t stride);
ad_status solve_trials_follow_change(solve_trials *trials, size_t experiment, int thread,
                                     const double *parameters, solve_trials_taker *take,
                                     void *context, ad_error *error);

/* Solves the jobs one by one; where there is no solution, residuals stay as they are: not numbers.
 */
ad_status solve_trials_jobs(trial_batch *batch, ad_error *error);

#endif
