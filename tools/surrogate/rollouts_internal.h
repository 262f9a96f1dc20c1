/* What the files of rollouts share; not for others. */
#ifndef SURROGATE_ROLLOUTS_INTERNAL_H
#define SURROGATE_ROLLOUTS_INTERNAL_H

#include "autodiff/memory.h"
#include "physics/chain/reduced.h"
#include "tools/surrogate/excitation.h"
#include "tools/surrogate/rollouts.h"

/* A model in rollouts; tips are those of its own modes. */
typedef struct rollouts_runner {
    const rollouts_subject *subject;
    const excitation_rollouts *truth;
    double (*tips)[3]; /* [count][steps + 1] of the solver */
    reduced_rod *rod;  /* the tip of a state */
    double length;
    double *errors; /* [count * steps] */
    double *state;  /* [2][states] */
    ad_memory memory;
} rollouts_runner;

/* Sorts the errors. */
void rollouts_median_and_worst(size_t count, double *errors, double result[2]);

/* Errors of rollout i after one step from each of its states, infinite where there is none; how
 * many. */
int rollouts_one_steps(const rollouts_runner *runner, const one_step *model, int i, int steps,
                       double *errors);

/* Errors of rollout i from begin to end or divergence, which a report (or NULL) keeps; returns
 * whether it diverges. */
bool rollouts_roll(const rollouts_runner *runner, const one_step *model, int i, int steps,
                   double *errors, int *count, rollouts_report *report);

ad_status rollouts_time_model(const rollouts_runner *runner, const one_step *model,
                              rollouts_row *row, ad_error *error);

/* rollouts_rod.c. A rod whose output is the tip; the rows of the rod itself. */
ad_status rollouts_make_rod(const scene *open, const int modes[4], reduced_rod **rod,
                            ad_error *error);
ad_status rollouts_judge_rod(rollouts_runner *runner, ad_pool *pool, rollouts_report *report,
                             ad_error *error);

#endif
