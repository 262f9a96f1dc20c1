#include "tools/programs/residual_scene.h"

#include "tools/prepare/prepare.h"

#include <stdio.h>
#include <string.h>

enum { OVERRIDES_MAX = 256, TEXT = 160 };

void residual_scene_free(residual_scene *of)
{
    config_free(of->open);
    of->open = NULL;
}

/* Twice: for the names of outputs, and with outputs that are unknown. */
ad_status residual_scene_open(const char *path, const cli_list *given, residual_scene *result,
                              ad_error *error)
{
    const char *overrides[OVERRIDES_MAX];
    char text[LEARNED_OUTPUTS_MAX][TEXT], name[CONFIG_PARAMETER_BYTES];
    int count = 0;
    *result = (residual_scene){.outputs = 0};
    for (; count < given->count && count < OVERRIDES_MAX - LEARNED_OUTPUTS_MAX - 1; count++) {
        overrides[count] = given->texts[count];
    }
    overrides[count++] = "residual.file=null";
    config *physics = NULL;
    ad_status status = prepare_read(path, NULL, count, overrides, &physics, error);
    if (status != AD_OK) {
        return status;
    }
    const char *lines = physics->residual.outputs, *size;
    size_t length;
    while (config_residual_output(&lines, name, &size, &length)) {
        char *to = text[result->outputs];
        memcpy(result->name[result->outputs++], name, sizeof name);
        snprintf(to, TEXT, "parameters.%s={identify: 0, range: [-%.*s, %.*s]}", name, (int)length,
                 size, (int)length, size);
        overrides[count++] = to;
    }
    config_free(physics);
    return prepare_read(path, NULL, count, overrides, &result->open, error);
}
