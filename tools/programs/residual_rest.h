/* What a rod at rest leaves of its measurements, learned by a program: the table of physics alone,
 * a network alone and both, and the file. */
#ifndef TOOLS_PROGRAMS_RESIDUAL_REST_H
#define TOOLS_PROGRAMS_RESIDUAL_REST_H

#include "tools/programs/fit_run.h"

typedef struct residual_rest_asked {
    const char *scene, *out;
    const cli_list *overrides;
    int steps, folds, left_out, choices, threads;
    uint64_t seed;
    const char *json; /* a file, "-", NULL: none */
    fit_run *run;
} residual_rest_asked;

/* Whether the scene has what is learned at rest: names under residual.outputs. */
bool residual_rest_is_meant(const config *settings);

/* AD_BAD_INPUT, with the place in the scene; errors of learned_rest. */
ad_status residual_rest(const residual_rest_asked *asked, ad_error *error);

#endif
