/* Whether the ranks of a training are about to train the same. */
#ifndef TOOLS_PROGRAMS_TRAIN_RANKS_H
#define TOOLS_PROGRAMS_TRAIN_RANKS_H

#include "autodiff/ranks.h"
#include "tools/config/config.h"

/* ranks_compare (tools/programs/program_ranks.h) of the settings, the files that are read later,
 * and the checkpoint that is gone on from; NULL: a new run. Without settings `status` has an error.
 */
ad_status train_ranks_compare(const ad_ranks *ranks, const config *settings, const char *checkpoint,
                              ad_status status, ad_error *error);

#endif
