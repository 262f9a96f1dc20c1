/* What is checked once everything is read: formulas with their places, the scene, the training. */
#include "tools/config/config_parts.h"

#include <stdlib.h>
#include <string.h>

/* What is wrong with the formula is told in `error`. */
static ad_status parse(const config *experiment, const config_key *key, const char *path,
                       quantity *q, ad_error *error)
{
    ad_error reason;
    double number = 0;
    char allowed[300];
    if (!q->node) {
        return AD_OK; /* a number, which was looked at when it was read */
    }
    *q = quantity_parsed(*q);
    ad_status status = quantity_check(*q, &reason);
    if (status == AD_BAD_INPUT) {
        return config_blame(experiment->source, error, path, "%s", reason.message);
    }
    if (status != AD_OK) {
        return ad_fail(error, status, "%s", reason.message);
    }
    if (quantity_is_number(*q, &number) && !config_in_range(key, number)) {
        config_key_entry_allowed(key, allowed, sizeof allowed);
        return config_blame(experiment->source, error, path,
                            "is the formula of a number %g, which is out of range; allowed: %s",
                            number, allowed);
    }
    return AD_OK;
}

/* Leaves the name of a parameter open. */
static ad_status open_parameter(config *experiment, int open, const config_parameter *parameter,
                                const char *path, ad_error *error)
{
    ad_error reason;
    if (!quantity_is_number(parameter->value, &experiment->open_values[open])) {
        return config_blame(experiment->source, error, path,
                            "is a formula; allowed of a parameter that is to vary: a number");
    }
    return quantities_coordinate(experiment->names, parameter->name, &reason) == AD_OK
               ? AD_OK
               : config_blame(experiment->source, error, path, "%s", reason.message);
}

/* Which of the open names a parameter is; -1: none. */
static int open_index(const config *experiment, const char *name)
{
    int i = experiment->open_count - 1;
    while (i >= 0 && strcmp(experiment->open_names[i], name) != 0) {
        i--;
    }
    return i;
}

static ad_status define_parameters(config *experiment, ad_error *error)
{
    const config_key *key = config_key_find(CONFIG_PARAMETER_PATH);
    char path[CONFIG_PATH_MAX];
    for (int i = 0; i < experiment->parameter_count; i++) {
        config_parameter *parameter = &experiment->parameters[i];
        ad_error reason;
        snprintf(path, sizeof path, "parameters.%s", parameter->name);
        ad_status status = parse(experiment, key, path, &parameter->value, error);
        const int open = open_index(experiment, parameter->name);
        if (status == AD_OK && open >= 0) {
            status = open_parameter(experiment, open, parameter, path, error);
        } else if (status == AD_OK && quantities_define(experiment->names, parameter->name,
                                                        parameter->value, &reason)) {
            status = config_blame(experiment->source, error, path, "%s", reason.message);
        }
        if (status != AD_OK) {
            return status;
        }
    }
    return AD_OK;
}

static ad_status parse_field(config *experiment, const config_key *key, int index, ad_error *error)
{
    char path[CONFIG_PATH_MAX], entry[CONFIG_PATH_MAX + 16];
    config_key_path(key, index, path);
    quantity *field = config_field(experiment, key, path);
    int count = key->entries_max ? key->entries_max : 1;
    ad_status status = AD_OK;
    for (int k = 0; k < count && status == AD_OK; k++) {
        snprintf(entry, sizeof entry, key->entries_max ? "%s[%d]" : "%s", path, k);
        status = parse(experiment, key, entry, field + k, error);
    }
    return status;
}

/* Keeps the scene with its open names; that which is checked and resolved has their values. */
static ad_status close_scene(config *experiment, ad_error *error)
{
    char path[CONFIG_PATH_MAX];
    if (experiment->open_count == 0) {
        return AD_OK;
    }
    experiment->open = malloc(sizeof *experiment->open);
    if (!experiment->open) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a scene");
    }
    *experiment->open = experiment->scene;
    for (int i = 0; i < experiment->open_count; i++) {
        const char *name = experiment->open_names[i];
        bool known = false;
        for (int k = 0; k < experiment->parameter_count; k++) {
            known = known || strcmp(experiment->parameters[k].name, name) == 0;
        }
        snprintf(path, sizeof path, known ? "parameters.%s" : "parameters", name);
        if (!known || !scene_uses(experiment->open, name)) {
            return config_blame(experiment->source, error, path,
                                known ? "no formula of the scene uses it" : "has no %s", name);
        }
    }
    if (experiment->load_units != CONFIG_UNITS_SI) {
        return config_blame(experiment->source, error, "loads.units",
                            "are those of one member; allowed with parameters that vary: SI");
    }
    scene_with(experiment->open, experiment->open_count, experiment->open_names,
               experiment->open_values, &experiment->scene);
    return AD_OK;
}

ad_status config_parse_formulas(config *experiment, ad_error *error)
{
    ad_status status = config_define_tables(experiment, error);
    if (status == AD_OK) {
        status = define_parameters(experiment, error);
    }
    for (int i = 0; i < config_key_count && status == AD_OK; i++) {
        const config_key *key = &config_keys[i];
        int fields = key->type == CONFIG_QUANTITY ? config_key_fields(experiment, key) : 0;
        for (int index = 0; index < fields && status == AD_OK; index++) {
            status = parse_field(experiment, key, index, error);
        }
    }
    return status == AD_OK ? close_scene(experiment, error) : status;
}

ad_status config_check_scene(const config *experiment, ad_error *error)
{
    ad_error reason;
    const char *key = "";
    ad_status status = scene_check(&experiment->scene, &key, &reason);
    if (status == AD_NO_MEMORY) {
        return ad_fail(error, status, "%s", reason.message);
    }
    if (status != AD_OK) {
        return config_blame(experiment->source, error, key, "%s", reason.message);
    }
    return AD_OK;
}

ad_status config_check_ends(const config *experiment, ad_error *error)
{
    ad_error reason;
    const char *key = "";
    const scene *rod_scene = &experiment->scene;
    ad_status status = scene_physics_of(rod_scene)->check(rod_scene, &key, &reason);
    if (status == AD_BAD_INPUT) {
        return config_blame(experiment->source, error, key, "%s", reason.message);
    }
    return status == AD_OK ? AD_OK : ad_fail(error, status, "%s", reason.message);
}

/* A key of another optimiser in a stage is a mistake, not something to pass over. */
static ad_status check_stage_keys(const config *experiment, int stage, ad_error *error)
{
    optim_method optimizer = experiment->settings.stages[stage].optimizer;
    char path[CONFIG_PATH_MAX], owners[64];
    for (int i = 0; i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        if (config_key_applies(experiment, key, stage)) {
            continue;
        }
        config_key_path(key, stage, path);
        if (config_given(experiment->source, path)) {
            config_key_optimizers(key, owners, sizeof owners);
            return config_blame(experiment->source, error, path,
                                "belongs to optimizer %s, but this stage runs %s; leave it out",
                                owners, optim_method_name(optimizer));
        }
    }
    return AD_OK;
}

ad_status config_blame_training(const config *experiment, ad_status status, const char *key,
                                const ad_error *reason, ad_error *error)
{
    return status == AD_OK ? AD_OK
           : status == AD_BAD_INPUT
               ? config_blame(experiment->source, error, key, "%s", reason->message)
               : ad_fail(error, status, "%s", reason->message);
}

ad_status config_check_training(const config *experiment, ad_error *error)
{
    ad_error reason;
    char key[TRAIN_KEY_MAX];
    for (int i = 0; i < experiment->settings.stage_count; i++) {
        ad_status status = check_stage_keys(experiment, i, error);
        if (status != AD_OK) {
            return status;
        }
    }
    ad_status status =
        train_settings_check(&experiment->settings, &experiment->scene, key, &reason);
    return config_blame_training(experiment, status, key, &reason, error);
}
