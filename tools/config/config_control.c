/* The section `control`, once the scene and its one-step model are known. */
#include "tools/config/config_parts.h"

#include <math.h>
#include <string.h>

bool config_has(const config *experiment, const char *section)
{
    const size_t length = strlen(section);
    char path[CONFIG_PATH_MAX];
    bool any = false;
    for (int i = 0; i < config_key_count && !any; i++) {
        const config_key *key = &config_keys[i];
        const config_list *list = config_list_of(key->path);
        if (strncmp(key->path, section, length) == 0) {
            config_key_path(key, 0, path);
            any = config_given(experiment->source, list ? list->path : path);
        }
    }
    return any;
}

bool config_controls(const config *experiment)
{
    return config_has(experiment, "control.");
}

ad_status config_resolve_control(config *experiment, ad_error *error)
{
    const surrogate_settings model = control_model_of(&experiment->surrogate);
    ad_error reason;
    char key[TRAIN_KEY_MAX];
    ad_status status = control_settings_resolve(
        &experiment->control, &model, &experiment->scene,
        config_given(experiment->source, "control.estimate"), key, &reason);
    status = config_blame_training(experiment, status, key, &reason, error);
    return status == AD_OK ? config_absolute(experiment, "control.task.file",
                                             &experiment->control.task.file, error)
                           : status;
}
