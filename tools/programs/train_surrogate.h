/* cpinn-train of a scene with the section surrogate. */
#ifndef TOOLS_PROGRAMS_TRAIN_SURROGATE_H
#define TOOLS_PROGRAMS_TRAIN_SURROGATE_H

#include "autodiff/ranks.h"
#include "physics/scene/verdict.h"
#include "tools/config/config.h"

typedef struct train_surrogate_options {
    const char *program, *out, *json; /* out, json: NULL: default, none */
    int threads;
    bool resume, quiet, explain;
    const ad_ranks *ranks; /* that share the work; the first prints and writes; NULL: none */
} train_surrogate_options;

/* Takes over `settings`. Returns the exit status. */
int train_surrogate(const train_surrogate_options *asked, config *settings);

#endif
