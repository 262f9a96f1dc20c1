/* The section `control`, once the scene and its one-step model are known. */
#include "tools/config/config_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
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
    if (status == AD_OK) {
        status =
            config_absolute(experiment, "control.residual", &experiment->control.residual, error);
    }
    return status == AD_OK ? config_absolute(experiment, "control.task.file",
                                             &experiment->control.task.file, error)
                           : status;
}

static ad_status read_plant(const char *path, int count, const char *const *overrides,
                            const config *nominal, config **plant, ad_error *error)
{
    const control_settings *c = &nominal->control;
    char reason[sizeof error->message];
    const char **all = malloc((size_t)(count + c->change_count + 3) * sizeof *all);
    if (!all) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the keys of a plant");
    }
    if (count > 0) {
        memcpy(all, overrides, (size_t)count * sizeof *all);
    }
    for (int i = 0; i < c->change_count; i++) {
        const char *key = c->changes[i];
        const size_t word = strcspn(key, ".=[");
        if ((word == 7 && memcmp(key, "control", word) == 0) ||
            (word == 9 && memcmp(key, "surrogate", word) == 0)) {
            free(all);
            return ad_fail(error, AD_BAD_INPUT,
                           "%.200s: control.plant.set: %.200s: is nothing of the robot; allowed: "
                           "keys of the scene other than control and surrogate",
                           path, key);
        }
        all[count++] = key;
    }
    all[count++] = "control=null"; /* names that it has may be numbers now */
    all[count++] = "time.windows=1";
    if (surrogate_is_given(&nominal->surrogate)) {
        all[count++] = "surrogate=null";
    }
    ad_status status = config_read(path, NULL, count, all, plant, error);
    free(all);
    if (status == AD_OK) {
        return AD_OK;
    }
    snprintf(reason, sizeof reason, "%s", error->message);
    return ad_fail(error, status == AD_NO_MEMORY ? status : AD_BAD_INPUT,
                   "%.200s: control.plant.set: %.280s", path, reason);
}

ad_status config_read_robot(const char *path, int count, const char *const *overrides,
                            config **nominal, config **plant, ad_error *error)
{
    ad_status status = config_read(path, NULL, count, overrides, nominal, error);
    if (status == AD_OK && !config_controls(*nominal)) {
        status = config_resolve_control(*nominal, error);
    }
    return status == AD_OK ? read_plant(path, count, overrides, *nominal, plant, error) : status;
}
