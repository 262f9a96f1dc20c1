/* One-step models of scene files and checkpoints. */
#ifndef TOOLS_CONFIG_CONFIG_SURROGATE_H
#define TOOLS_CONFIG_CONFIG_SURROGATE_H

#include "tools/config/config.h"
#include "tools/surrogate/surrogate.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The section of a scene, filled in and checked; in place of what a network of the scene itself
 * would need. */
ad_status config_resolve_surrogate(config *config, ad_error *error);

/* The trained model of DIR, DIR/checkpoint.h5 or any such file. AD_BAD_INPUT: it is not one of a
 * one-step model. */
ad_status surrogate_load(const char *path, surrogate **result, ad_error *error);

#ifdef __cplusplus
}
#endif

#endif
