/* What was learned of a rod, as a file: the network with the names of its outputs and its inputs,
 * at rest formulas, the unknowns that were found with it, and how well all are known. */
#ifndef TOOLS_TRAIN_LEARNED_FILE_H
#define TOOLS_TRAIN_LEARNED_FILE_H

#include "autodiff/memory.h"
#include "tools/train/learned_net.h"

enum { LEARNED_COMMON_MAX = 48 };

typedef struct learned_names {
    int count;
    const char *name[LEARNED_WIDTH_MAX];
} learned_names;

typedef struct learned_file {
    learned_net net;
    learned_names inputs, outputs, unknowns; /* formulas; names; names */
    double value[LEARNED_OUTPUTS_MAX];       /* of the unknowns, SI */
    double *theta;                           /* [learned_net_count] */
    double *covariance; /* [n][n] of the unknowns, as log(z/(1 - z)) of the part z of a range, and
                         * theta */
    double noise;       /* of a measured number beside it, in its unit; NaN: not known */
    /* Of a motion: how values are seen by the state [seen_count][outputs], and which part of what
     * is not known comes anew in a second; at rest 0, NaN. */
    size_t seen_count;
    double *seen, anew;
    double trained; /* the largest deviation of these values where it was trained; at rest NaN */
    char *texts;    /* of the names */
    ad_memory memory;
} learned_file;

/* Atomic. AD_IO, AD_NO_MEMORY. */
ad_status learned_file_write(const learned_file *file, const char *path, ad_error *error);

/* Owned by the caller. AD_IO; AD_BAD_INPUT: no such file. */
ad_status learned_file_read(const char *path, learned_file *file, ad_error *error);
void learned_file_free(learned_file *file);

#endif
