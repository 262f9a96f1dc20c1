/* Fresh members of a family at rest, solved classically: how far a network of s and the parameters
 * is from them, whatever its residuals are. */
#ifndef TOOLS_TRAIN_WITNESS_H
#define TOOLS_TRAIN_WITNESS_H

#include "tools/train/experiment.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { WITNESS_MEMBERS = 32 };

/* Largest distances between shapes over the length, of members that have a solution without a
 * warning; NaN: none has. */
typedef struct witness_errors {
    double median, most, worst; /* most: 95 % are below */
    int compared;               /* of WITNESS_MEMBERS */
} witness_errors;

/* Of the networks with the experiment's parameters. Errors are those of a field, and AD_NO_MEMORY.
 */
ad_status witness_members(const experiment *e, witness_errors *result, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
