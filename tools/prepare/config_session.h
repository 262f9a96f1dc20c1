/* A scene file in training. */
#ifndef TOOLS_PREPARE_CONFIG_SESSION_H
#define TOOLS_PREPARE_CONFIG_SESSION_H

#include "tools/prepare/config_experiment.h"
#include "tools/train/session.h"

/* session_prepare of what a file says, and with session_start after it. They take over `settings`,
 * also when they fail. */
ad_status config_session_prepare(config *settings, int threads, session *s, ad_error *error);
ad_status config_session_create(config *settings, int threads, session *s, ad_error *error);

#endif
