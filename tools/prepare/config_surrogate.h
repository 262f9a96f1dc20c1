/* One-step models of scene files and checkpoints. */
#ifndef TOOLS_PREPARE_CONFIG_SURROGATE_H
#define TOOLS_PREPARE_CONFIG_SURROGATE_H

#include "tools/prepare/prepare.h"
#include "tools/surrogate/surrogate.h"

/* The trained model of DIR, DIR/checkpoint.h5 or any such file. AD_BAD_INPUT: it is not one of a
 * one-step model. */
ad_status surrogate_load(const char *path, surrogate **result, ad_error *error);

#endif
