/* The section `residual`: names of formulas that a network says, of a file or not learned yet. */
#include "tools/config/config_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The next of lines "name=formula": its name, and the rest; false: there is none. */
bool config_residual_output(const char **lines, char name[CONFIG_PARAMETER_BYTES],
                            const char **size, size_t *length)
{
    const char *line = *lines;
    if (!line || !*line) {
        return false;
    }
    const size_t end = strcspn(line, "=");
    snprintf(name, CONFIG_PARAMETER_BYTES, "%.*s", (int)end, line);
    *size = line + end + 1;
    *length = strcspn(*size, "\n");
    *lines = *size + *length + ((*size)[*length] == '\n');
    return true;
}

/* ---- the file ------------------------------------------------------------------------------ */

/* Unknowns that were found with the network have these values. */
static ad_status take_unknowns(config *experiment, const learned_file *saved, ad_error *error)
{
    for (int i = 0; i < saved->unknowns.count; i++) {
        char path[CONFIG_PATH_MAX], scale[CONFIG_PATH_MAX];
        snprintf(path, sizeof path, "parameters.%s", saved->unknowns.name[i]);
        config_parameter *found = config_parameter_find(experiment, path);
        if (!found) {
            return config_blame(experiment->source, error, "residual.file",
                                "was learned with '%s' as an unknown, which this scene has not",
                                saved->unknowns.name[i]);
        }
        if (!isnan(found->identify)) {
            found->value = quantity_number(saved->value[i]);
            found->range[0] = found->range[1] = found->identify = NAN;
            found->scale = CONFIG_SCALE_OPEN;
            snprintf(scale, sizeof scale, "parameters.%s.scale", found->name);
            config_unplace(experiment->source, scale); /* it went with the range */
        }
    }
    return AD_OK;
}

ad_status config_take_residual(config *experiment, ad_error *error)
{
    config_residual *residual = &experiment->residual;
    ad_error reason;
    if (!residual->file) {
        return AD_OK;
    }
    ad_status status = config_absolute(experiment, "residual.file", &residual->file, error);
    if (status != AD_OK) {
        return status;
    }
    residual->saved = calloc(1, sizeof *residual->saved);
    status = residual->saved ? learned_file_read(residual->file, residual->saved, &reason)
                             : ad_fail(&reason, AD_NO_MEMORY, "out of memory for a residual");
    if (status != AD_OK) {
        return status == AD_NO_MEMORY
                   ? ad_fail(error, status, "%s", reason.message)
                   : config_blame(experiment->source, error, "residual.file", "%s", reason.message);
    }
    const learned_file *saved = residual->saved;
    if (!isnan(saved->anew) || saved->net.inputs > LEARNED_INPUTS_MAX ||
        saved->net.outputs > LEARNED_OUTPUTS_MAX) {
        return config_blame(experiment->source, error, "residual.file",
                            "%s is of a robot in motion, for control.residual; allowed: what "
                            "cpinn-residual has learned at rest",
                            residual->file);
    }
    return take_unknowns(experiment, residual->saved, error);
}

/* ---- names of formulas --------------------------------------------------------------------- */

/* Formulas of the file's inputs, and of its outputs. */
static ad_status make_formulas(config *experiment, quantity *y, ad_error *error)
{
    const learned_file *saved = experiment->residual.saved;
    quantity *x = experiment->residual.formula;
    ad_error reason;
    experiment->residual.formula_count = saved->net.inputs;
    for (int i = 0; i < saved->net.inputs; i++) {
        x[i] = quantity_formula(experiment->names, saved->inputs.name[i]);
        if (quantity_check(x[i], &reason) != AD_OK) {
            return config_blame(experiment->source, error, "residual.file",
                                "its input '%s' is no formula of this scene: %s",
                                saved->inputs.name[i], reason.message);
        }
    }
    learned_net_formula(&saved->net, saved->theta, x, y);
    return AD_OK;
}

static int find(const learned_names *names, const char *name)
{
    for (int i = 0; i < names->count; i++) {
        if (strcmp(names->name[i], name) == 0) {
            return i;
        }
    }
    return -1;
}

static ad_status define(config *experiment, const char *name, const quantity *y, ad_error *error)
{
    const learned_file *saved = experiment->residual.saved;
    const int at = saved ? find(&saved->outputs, name) : -1;
    char path[CONFIG_PATH_MAX];
    ad_error reason;
    snprintf(path, sizeof path, "parameters.%s", name);
    if (config_parameter_find(experiment, path)) {
        return AD_OK; /* it is open, to be learned, or has a value of its own */
    }
    if (saved && at < 0) {
        return config_blame(experiment->source, error, "residual.outputs",
                            "has '%s', which %s has not learned", name, experiment->residual.file);
    }
    const quantity value = saved ? y[at] : quantity_number(0);
    const ad_status status = quantities_define(experiment->names, name, value, &reason);
    return status == AD_OK || status == AD_NO_MEMORY
               ? status
               : config_blame(experiment->source, error, "residual.outputs", "%s", reason.message);
}

ad_status config_define_residual(config *experiment, ad_error *error)
{
    const config_residual *residual = &experiment->residual;
    quantity y[LEARNED_OUTPUTS_MAX];
    char name[CONFIG_PARAMETER_BYTES];
    const char *lines = residual->outputs, *size;
    size_t length;
    int count = 0;
    if (!lines) {
        return residual->file || residual->input_count > 0
                   ? config_blame(experiment->source, error, "residual.outputs",
                                  "are missing; give names for the formulas of the scene, each "
                                  "with how large it may be, as {bend: 0.5}")
                   : AD_OK;
    }
    ad_status status = residual->saved ? make_formulas(experiment, y, error) : AD_OK;
    while (status == AD_OK && config_residual_output(&lines, name, &size, &length)) {
        char *end;
        const double most = strtod(size, &end);
        if (end != size + length || !(most > 0) || !isfinite(most)) {
            return config_blame(experiment->source, error, "residual.outputs",
                                "says '%s: %.*s'; allowed: how large it may be, a number > 0", name,
                                (int)length, size);
        }
        if (++count > LEARNED_OUTPUTS_MAX) {
            return config_blame(experiment->source, error, "residual.outputs",
                                "has more than %d names; allowed: up to so many",
                                LEARNED_OUTPUTS_MAX);
        }
        status = define(experiment, name, y, error);
    }
    return status;
}

ad_status config_check_residual(const config *experiment, ad_error *error)
{
    char name[CONFIG_PARAMETER_BYTES];
    const char *lines = experiment->residual.outputs, *size;
    size_t length;
    while (config_residual_output(&lines, name, &size, &length)) {
        if (!quantities_used(experiment->names, name)) {
            return config_blame(experiment->source, error, "residual.outputs",
                                "has '%s', but no formula of the scene uses it", name);
        }
    }
    return AD_OK;
}

/* Formulas are read once: each reading of a play is another one. */
ad_status config_residual_inputs(config *experiment, ad_error *error)
{
    config_residual *residual = &experiment->residual;
    for (int i = 0; i < residual->input_count && !residual->saved; i++) {
        char path[CONFIG_PATH_MAX];
        ad_error reason;
        snprintf(path, sizeof path, "residual.inputs[%d]", i);
        residual->formula[i] = quantity_formula(experiment->names, residual->inputs[i]);
        residual->formula_count = i + 1;
        if (quantity_check(residual->formula[i], &reason) != AD_OK) {
            return config_blame(experiment->source, error, path, "%s", reason.message);
        }
    }
    return AD_OK;
}

bool config_residual_opens(const config *experiment)
{
    char name[CONFIG_PARAMETER_BYTES];
    const char *lines = experiment->residual.outputs, *size;
    size_t length;
    bool opens = false;
    while (config_residual_output(&lines, name, &size, &length)) {
        opens = opens || scene_parameter_find(&experiment->scene, name) >= 0;
    }
    return opens;
}

/* Also by plays and lags, which are states where nothing is learned yet. */
static bool uses(const config *experiment, quantity q, const char *name)
{
    int count;
    const quantity_play *plays = quantities_plays(experiment->names, &count);
    bool found = quantity_depends_on(q, name);
    for (int i = 0; i < count && !found; i++) {
        found =
            quantity_depends_on(q, plays[i].name) && strcmp(plays[i].name, name) != 0 &&
            (uses(experiment, plays[i].input, name) || uses(experiment, plays[i].constant, name));
    }
    return found;
}

bool config_residual_uses(const config *experiment, const char *name)
{
    const config_residual *residual = &experiment->residual;
    bool found = residual->outputs && residual->formula_count == 0;
    for (int i = 0; i < residual->formula_count && !found; i++) {
        found = uses(experiment, residual->formula[i], name);
    }
    return found;
}
