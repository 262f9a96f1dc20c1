/* What is checked once everything is read: formulas with their places, the scene, the keys of
 * stages. */
#include "physics/scene/scene_memory.h"
#include "tools/config/config_parts.h"
#include "tools/train/measured_columns.h"

#include <math.h>
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

/* What a key is refused for, unless it is memory that has run out. */
static ad_status refuse(const config *experiment, const char *path, const ad_error *reason,
                        ad_error *error)
{
    return reason->status == AD_NO_MEMORY
               ? ad_fail(error, AD_NO_MEMORY, "%s", reason->message)
               : config_blame(experiment->source, error, path, "%s", reason->message);
}

/* Leaves the name of a parameter with a range open, and the scene a family. */
static ad_status open_parameter(config *experiment, const config_parameter *parameter,
                                const char *path, ad_error *error)
{
    scene *family = &experiment->scene;
    const double low = parameter->range[0], high = parameter->range[1];
    ad_error reason;
    if (!(low < high)) {
        return config_blame(experiment->source, error, path,
                            "has the range %g to %g; allowed: the lower value first, or in place "
                            "of {range: ...} the one value",
                            low, high);
    }
    if (parameter->scale == SCENE_LOG && !(low > 0)) {
        return config_blame(experiment->source, error, path,
                            "has the range %g to %g; allowed with scale log: values > 0", low,
                            high);
    }
    if (family->parameter_count == SCENE_PARAMETERS_MAX) {
        return config_blame(experiment->source, error, path,
                            "is one parameter with a range too many; allowed: %d",
                            SCENE_PARAMETERS_MAX);
    }
    if (parameter->identify < low || parameter->identify > high) {
        return config_blame(experiment->source, error, path,
                            "is to be identified from %g on, outside its range; allowed: %g to %g",
                            parameter->identify, low, high);
    }
    const bool known = isnan(parameter->identify);
    const scene_parameter added = {parameter->name, low, high, (scene_scale)parameter->scale};
    const double usual = known ? scene_parameter_at(&added, 0.5) : parameter->identify;
    const int at = known ? scene_known_count(family) : family->parameter_count;
    for (int i = family->parameter_count; i > at; i--) { /* unknowns come last */
        family->parameters[i] = family->parameters[i - 1];
        family->guess[i] = family->guess[i - 1];
    }
    family->parameters[at] = added;
    family->guess[at] = usual;
    family->parameter_count++;
    family->unknown_count += !known;
    return quantities_parameter(experiment->names, parameter->name, low, high, usual, &reason) ==
                   AD_OK
               ? AD_OK
               : refuse(experiment, path, &reason, error);
}

/* From so many times its lower end on the range of an unknown is meant in powers of ten. */
static const double WIDE = 100;

static ad_status define_parameter(config *experiment, config_parameter *parameter, ad_error *error)
{
    char path[CONFIG_PATH_MAX], scale[CONFIG_PATH_MAX];
    ad_error reason;
    snprintf(path, sizeof path, "parameters.%s", parameter->name);
    snprintf(scale, sizeof scale, "parameters.%s.scale", parameter->name);
    const bool open = !isnan(parameter->range[0]);
    if (!open && !parameter->value.is_given) {
        return config_blame(experiment->source, error, path, "has no range; allowed: %s",
                            "a number, a formula or {range: [low, high], scale: linear or log, "
                            "identify: number}");
    }
    if (open) {
        const bool wide = !isnan(parameter->identify) && parameter->range[0] > 0 &&
                          parameter->range[1] >= WIDE * parameter->range[0];
        if (parameter->scale == CONFIG_SCALE_OPEN) {
            parameter->scale = wide ? SCENE_LOG : SCENE_LINEAR;
        }
        return open_parameter(experiment, parameter, path, error);
    }
    if (config_given(experiment->source, scale) || !isnan(parameter->identify)) {
        return config_blame(experiment->source, error, isnan(parameter->identify) ? scale : path,
                            "scale and identify belong to a range, but the parameter has a value; "
                            "leave them out");
    }
    ad_status status =
        parse(experiment, config_key_find(CONFIG_PARAMETER_PATH), path, &parameter->value, error);
    if (status == AD_OK &&
        quantities_define(experiment->names, parameter->name, parameter->value, &reason) != AD_OK) {
        status = refuse(experiment, path, &reason, error);
    }
    return status;
}

static ad_status define_parameters(config *experiment, ad_error *error)
{
    ad_status status = AD_OK;
    for (int pass = 0; pass < 2 && status == AD_OK; pass++) { /* formulas come last */
        for (int i = 0; i < experiment->parameter_count && status == AD_OK; i++) {
            config_parameter *parameter = &experiment->parameters[i];
            if ((pass == 0) == !parameter->value.node) {
                status = define_parameter(experiment, parameter, error);
            }
        }
        if (status == AD_OK && pass == 0) {
            status = config_define_residual(experiment, error);
        }
    }
    return status;
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

/* Whether how measured points are seen depends on a parameter. */
static bool is_in_views(const config *experiment, const char *name)
{
    bool found = false;
    for (int i = 0; i < experiment->settings.data_count; i++) {
        const scene_view *view = &experiment->settings.data[i].view;
        found = found || scene_view_depends_on(view, name);
    }
    return found;
}

/* Whether formulas of columns that are measured have the name. */
static bool is_in_columns(const config *experiment, const char *name)
{
    bool found = false;
    for (int i = 0; i < experiment->settings.data_count; i++) {
        const train_data *data = &experiment->settings.data[i];
        found = found || measured_columns_name(data->columns, name) ||
                measured_columns_name(data->where, name);
    }
    return found;
}

static ad_status check_uses(const config *experiment, ad_error *error)
{
    char path[CONFIG_PATH_MAX];
    for (int i = 0; i < experiment->scene.parameter_count; i++) {
        const char *name = experiment->scene.parameters[i].name;
        if (!scene_uses(&experiment->scene, name) && !is_in_views(experiment, name) &&
            !config_residual_uses(experiment, name)) {
            snprintf(path, sizeof path, "parameters.%s", name);
            return config_blame(experiment->source, error, path,
                                "has a range, but no formula of the scene uses it");
        }
    }
    for (int i = 0; i < experiment->parameter_count; i++) {
        const config_parameter *set = &experiment->parameters[i];
        snprintf(path, sizeof path, "parameters.%s", set->name);
        if (config_overridden(experiment->source, path) &&
            !quantities_used(experiment->names, set->name) &&
            !is_in_columns(experiment, set->name)) {
            return config_blame(experiment->source, error, path, "no formula of the scene uses it");
        }
    }
    return AD_OK;
}

static ad_status remember(config *experiment, ad_error *error)
{
    const char *key = "";
    ad_error reason;
    config_residual *residual = &experiment->residual;
    const int inputs = config_residual_opens(experiment) ? residual->formula_count : 0;
    return scene_remember(&experiment->scene, inputs, residual->formula, &key, &reason) == AD_OK
               ? AD_OK
               : refuse(experiment, key, &reason, error);
}

ad_status config_parse_formulas(config *experiment, ad_error *error)
{
    ad_status status = config_define_tables(experiment, error);
    quantities_know_plays(experiment->names, true);
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
    status = status == AD_OK ? config_residual_inputs(experiment, error) : status;
    quantities_know_plays(experiment->names, false);
    status = status == AD_OK ? remember(experiment, error) : status;
    status = status == AD_OK ? config_check_residual(experiment, error) : status;
    return status == AD_OK ? check_uses(experiment, error) : status;
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

/* A key of another optimiser in a stage is a mistake, not something to pass over. */
static ad_status check_stage_keys(const config *experiment, int stage, ad_error *error)
{
    optim_method optimizer = experiment->settings.stages[stage].optim.method;
    char path[CONFIG_PATH_MAX], owners[160];
    for (int i = 0; i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        if (config_key_applies(experiment, key, stage)) {
            continue;
        }
        config_key_path(key, stage, path);
        if (config_given(experiment->source, path)) {
            optim_method_list(0, key->reads, owners, sizeof owners);
            return config_blame(experiment->source, error, path,
                                "belongs to optimizer %s, but this stage runs %s; leave it out",
                                owners, optim_method_name(optimizer));
        }
    }
    return AD_OK;
}

ad_status config_check_stages(const config *experiment, ad_error *error)
{
    ad_status status = AD_OK;
    for (int i = 0; i < experiment->settings.stage_count && status == AD_OK; i++) {
        status = check_stage_keys(experiment, i, error);
    }
    return status;
}
