/* Fresh members of a family at rest, solved classically: how far a network of s and the parameters
 * is from them, whatever its residuals are. */
#ifndef TOOLS_TRAIN_FRESH_MEMBERS_H
#define TOOLS_TRAIN_FRESH_MEMBERS_H

#include "tools/train/experiment.h"

enum { FRESH_MEMBERS = 32 };

/* Largest distances between shapes over the length, of members that have a solution without a
 * warning; NaN: none has. */
typedef struct fresh_errors {
    double median, most, worst; /* most: 95 % are below */
    int compared;               /* of FRESH_MEMBERS */
} fresh_errors;

/* Of the networks with the experiment's parameters. Errors are those of a field, and AD_NO_MEMORY.
 */
ad_status fresh_members_compare(const experiment *e, fresh_errors *result, ad_error *error);

#endif
