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

/* One "name=value"; both are within the text that is changed. */
static ad_status close_one(config *experiment, char *item, ad_error *error)
{
    char path[CONFIG_PATH_MAX], names[VALUES_BYTES], *value = strchr(item, '=');
    double number = 0;
    if (value) {
        value[0] = '\0';
        item[strcspn(item, " ")] = '\0';
        value += 1 + strspn(value + 1, " ");
        value[strcspn(value, " ")] = '\0';
    }
    snprintf(path, sizeof path, "parameters.%.60s", item);
    config_parameter *parameter = value ? config_parameter_find(experiment, path) : NULL;
    if (!value || config_parse_number(value, &number)) {
        return ad_fail(error, AD_BAD_INPUT, "--at %.80s: allowed: name=number, ...", item);
    }
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
    char *text = strdup(at ? at : ""), *rest = NULL;
    ad_status status = text ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
    for (char *item = text ? strtok_r(text, ",", &rest) : NULL; item && status == AD_OK;
         item = strtok_r(NULL, ",", &rest)) {
        status = close_one(experiment, item + strspn(item, " "), error);
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
