/* A scene at rest whose names under residual.outputs are unknowns, behind the others. */
#ifndef TOOLS_PROGRAMS_RESIDUAL_SCENE_H
#define TOOLS_PROGRAMS_RESIDUAL_SCENE_H

#include "tools/config/config.h"
#include "tools/programs/cli.h"

typedef struct residual_scene {
    config *open; /* owned */
    int outputs;
    char name[LEARNED_OUTPUTS_MAX][CONFIG_PARAMETER_BYTES];
} residual_scene;

/* Without residual.file, of which unknowns are found anew. Freed by residual_scene_free, also on
 * failure. Errors of prepare_read. */
ad_status residual_scene_open(const char *path, const cli_list *overrides, residual_scene *result,
                              ad_error *error);
void residual_scene_free(residual_scene *of);

#endif
