/* cpinn-eval on one-step models: rollouts against the solver, as text, tables and pictures. */
#ifndef TOOLS_PROGRAMS_EVAL_ROLLOUTS_H
#define TOOLS_PROGRAMS_EVAL_ROLLOUTS_H

#include "tools/surrogate/rollouts.h"
#include "tools/surrogate/surrogate.h"

typedef struct eval_rollouts_options {
    const char *path, *out; /* of the run; a folder for files, or NULL */
    int count, seed, threads;
    double tolerance; /* of the worst error over 5 s by the length; NaN: none */
    const char *json; /* file, or - */
} eval_rollouts_options;

/* What is judged of a trained model; the result borrows from it. */
rollouts_subject eval_rollouts_subject(const surrogate *s, const one_step *model);

void eval_rollouts_print(FILE *file, const rollouts_report *report);

/* Judges, prints and writes; returns the exit status: 3 where the model diverges or is above the
 * tolerance, 2 with one line on stderr. */
int eval_rollouts_run(const char *program, const eval_rollouts_options *asked);

#endif
