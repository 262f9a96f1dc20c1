/* cpinn-eval on one-step models: rollouts against the solver, as text, tables and pictures. */
#ifndef TOOLS_PROGRAMS_EVAL_ROLLOUTS_H
#define TOOLS_PROGRAMS_EVAL_ROLLOUTS_H

#include "autodiff/ranks.h"
#include "physics/scene/verdict.h"
#include "tools/surrogate/rollouts.h"
#include "tools/surrogate/surrogate.h"

typedef struct eval_rollouts_options {
    const char *path, *out; /* of the run; a folder for files, or NULL */
    int count, seed, threads;
    double tolerance;      /* of the worst error over 5 s by the length; NaN: none */
    const char *json;      /* file, or - */
    bool quiet;            /* prints errors, and what is not trusted on stderr */
    const ad_ranks *ranks; /* that share the rollouts; the first writes; NULL: none */
} eval_rollouts_options;

/* What is judged of a trained model; the result borrows from it. */
rollouts_subject eval_rollouts_subject(const surrogate *s, const one_step *model);

/* A training ends with so many rollouts, from the scene's seed plus this: */
enum { EVAL_ROLLOUTS_JUDGED = 16, EVAL_ROLLOUTS_SEED = 1000003 };
ad_status eval_rollouts_judge(const surrogate *s, int count, uint64_t seed, ad_pool *pool,
                              rollouts_report *report, ad_error *error);

/* Adds findings: it diverges, is off by more than its modes are, or these by more than
 * surrogate.tolerance, or the solver lost rollouts. loss and held_out of its training (NaN: not
 * known) tell what to try. */
void eval_rollouts_verdict(const rollouts_report *report, const surrogate_settings *settings,
                           double loss, double held_out, verdict *to);

/* The first of these alone; `try`: what to do about it, of a robot that is stable. */
void eval_rollouts_diverged(const rollouts_report *report, const char *try, verdict *to);

/* A row as texts: name, states, one step, 5 s, 1000 steps, diverged, one, 147, Jacobian. */
enum { EVAL_ROLLOUTS_CELLS = 9, EVAL_ROLLOUTS_CELL = 32 };
void eval_rollouts_heads(const rollouts_report *report,
                         char heads[EVAL_ROLLOUTS_CELLS][EVAL_ROLLOUTS_CELL]);
void eval_rollouts_cells(const rollouts_report *report, int row,
                         char cells[EVAL_ROLLOUTS_CELLS][EVAL_ROLLOUTS_CELL]);

void eval_rollouts_print(FILE *file, const rollouts_report *report);

/* Judges, prints and writes; returns the exit status: 3 where the model diverges or is above the
 * tolerance, 2 with one line on stderr. */
int eval_rollouts_run(const char *program, const eval_rollouts_options *asked);

#endif
