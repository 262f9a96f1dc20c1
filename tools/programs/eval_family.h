/* cpinn-eval and cpinn-solve on families: answers for members with their errors, and how those of a
 * network compare with solved ones. */
#ifndef TOOLS_PROGRAMS_EVAL_FAMILY_H
#define TOOLS_PROGRAMS_EVAL_FAMILY_H

#include "tools/files/json.h"
#include "tools/library/cpinn.h"
#include "tools/programs/samples.h"
#include "tools/train/experiment.h"

typedef struct eval_family_options {
    const char *at, *members, *out; /* one of the first two, or verify, or none of them */
    int polish, verify, seed, threads;
    bool extrapolate, compile, derivatives;
    const ad_ranks *ranks; /* that share the members; the first writes; NULL: none */
} eval_family_options;

typedef struct eval_family {
    eval_family_options asked;
    cpinn_family *family;
    samples *shapes; /* borrowed */
    cpinn_family_check check;
} eval_family;

/* What is wrong with the options among themselves; NULL: nothing. */
const char *eval_family_conflict(const eval_family_options *asked);

/* Answers at the points of `shapes` or verifies, and writes what is asked for. The experiment and
 * the shapes outlive it. AD_BAD_INPUT with file and line, AD_BAD_ARGUMENT. */
ad_status eval_family_run(const eval_family_options *asked, const experiment *e, samples *shapes,
                          eval_family *result, ad_error *error);

/* The same answers without a network: members are solved, to a tolerance of the position over the
 * length. The scene outlives it; tolerance 0: CPINN_TOLERANCE. AD_BAD_ARGUMENT also where the
 * solver of members does not take the scene. */
ad_status eval_family_solve(const eval_family_options *asked, const scene *open, double tolerance,
                            samples *shapes, eval_family *result, ad_error *error);
void eval_family_free(eval_family *eval); /* not itself */

void eval_family_warn(const char *program, const eval_family *eval); /* on stderr */
void eval_family_print(const eval_family *eval);
void eval_family_json(json *to, const eval_family *eval);

/* 3 where an answer is not trusted, or one that is trusted is wrong; else 0. */
int eval_family_status(const eval_family *eval);

#endif
