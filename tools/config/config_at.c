/* A member of a family by the values of its parameters. */
#include "tools/config/config_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { VALUES_BYTES = 600 };

/* The names of all that have a range. */
static void open_names(const config *experiment, char *text, size_t size)
{
    size_t at = 0;
    text[0] = '\0';
    for (int i = 0; i < experiment->parameter_count && at < size; i++) {
        const config_parameter *parameter = &experiment->parameters[i];
        if (!isnan(parameter->range[0])) {
            at += (size_t)snprintf(text + at, size - at, "%s%s", at ? ", " : "", parameter->name);
        }
    }
}

/* Splits the next "name=value" off a text that is changed; *name NULL: there is none. */
static ad_status next_item(char **rest, char **name, double *number, ad_error *error)
{
    char *item = *rest, *comma = strchr(item, ','), *value;
    *rest = comma ? comma + 1 : item + strlen(item);
    *name = *item ? item + strspn(item, " ") : NULL;
    if (!*item) {
        return AD_OK;
    }
    if (comma) {
        *comma = '\0';
    }
    value = strchr(*name, '=');
    if (value) {
        value[0] = '\0';
        (*name)[strcspn(*name, " ")] = '\0';
        value += 1 + strspn(value + 1, " ");
        value[strcspn(value, " ")] = '\0';
    }
    return !value || config_parse_number(value, number) || !isfinite(*number)
               ? ad_fail(error, AD_BAD_INPUT, "--at %.80s: allowed: name=number, ...", *name)
               : AD_OK;
}

static ad_status close_one(config *experiment, const char *item, double number, ad_error *error)
{
    char path[CONFIG_PATH_MAX], names[VALUES_BYTES];
    snprintf(path, sizeof path, "parameters.%.60s", item);
    config_parameter *parameter = config_parameter_find(experiment, path);
    if (!parameter || isnan(parameter->range[0])) {
        open_names(experiment, names, sizeof names);
        return ad_fail(error, AD_BAD_INPUT,
                       "--at %.80s: no parameter of that name has a range, or it is given twice; "
                       "allowed: %.200s",
                       item, *names ? names : "none");
    }
    if (!(number >= parameter->range[0] && number <= parameter->range[1])) {
        return config_blame(experiment->source, error, path,
                            "--at has %g, outside its range; allowed: %g to %g", number,
                            parameter->range[0], parameter->range[1]);
    }
    parameter->range[0] = parameter->range[1] = parameter->identify = NAN;
    parameter->value = quantity_number(number);
    snprintf(path, sizeof path, "parameters.%.60s.scale", item);
    config_unplace(experiment->source, path); /* it went with the range */
    return AD_OK;
}

ad_status config_close(config *experiment, const char *at, ad_error *error)
{
    char names[VALUES_BYTES];
    char *text = strdup(at ? at : ""), *rest = text, *name = "";
    ad_status status = text ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    while (status == AD_OK && name) {
        double number = 0;
        status = next_item(&rest, &name, &number, error);
        status = status == AD_OK && name ? close_one(experiment, name, number, error) : status;
    }
    free(text);
    if (status != AD_OK) {
        return status;
    }
    open_names(experiment, names, sizeof names);
    return *names ? config_blame(experiment->source, error, "parameters",
                                 "the scene is a family, of which one member is wanted here; "
                                 "values are missing, by --at or --set, of %s",
                                 names)
                  : AD_OK;
}

ad_status config_at(const scene *family, const char *at, double *values, ad_error *error)
{
    char *text = strdup(at), *rest = text, *name = "";
    ad_status status = text ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (int i = 0; i < family->parameter_count; i++) {
        values[i] = NAN;
    }
    while (status == AD_OK && name) {
        double number = 0;
        status = next_item(&rest, &name, &number, error);
        for (int i = 0; status == AD_OK && name && i <= family->parameter_count; i++) {
            if (i == family->parameter_count) {
                status = ad_fail(error, AD_BAD_INPUT,
                                 "--at %.80s: no parameter of that name has a range", name);
            } else if (strcmp(family->parameters[i].name, name) == 0) {
                status = isnan(values[i])
                             ? AD_OK
                             : ad_fail(error, AD_BAD_INPUT, "--at %.80s: it is given twice", name);
                values[i] = number;
                break;
            }
        }
    }
    free(text);
    for (int i = 0; i < family->parameter_count && status == AD_OK; i++) {
        const scene_parameter *range = &family->parameters[i];
        status = isnan(values[i])
                     ? ad_fail(error, AD_BAD_INPUT, "--at: %s is missing; its range is %g to %g",
                               range->name, range->low, range->high)
                     : AD_OK;
    }
    return status;
}
