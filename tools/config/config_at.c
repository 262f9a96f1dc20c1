/* A member of a family by the values of its parameters. */
#include "tools/config/config_parts.h"

#include <math.h>

ad_status config_close(config *experiment, const char *at, ad_error *error)
{
    scene_parameter open[CONFIG_PARAMETERS_MAX];
    config_parameter *which[CONFIG_PARAMETERS_MAX];
    double values[CONFIG_PARAMETERS_MAX];
    char path[CONFIG_PATH_MAX];
    ad_error reason;
    int count = 0;
    for (int i = 0; i < experiment->parameter_count; i++) {
        config_parameter *parameter = &experiment->parameters[i];
        if (!isnan(parameter->range[0])) {
            which[count] = parameter;
            open[count++] = (scene_parameter){parameter->name, parameter->range[0],
                                              parameter->range[1], SCENE_LINEAR};
        }
    }
    ad_status status = scene_member_read(count, open, false, at ? at : "", values, &reason);
    if (status != AD_OK) {
        return config_blame(experiment->source, error, "parameters", "%s; give a number for each",
                            reason.message);
    }
    for (int i = 0; i < count; i++) {
        which[i]->range[0] = which[i]->range[1] = which[i]->identify = NAN;
        which[i]->value = quantity_number(values[i]);
        snprintf(path, sizeof path, "parameters.%s.scale", which[i]->name);
        config_unplace(experiment->source, path); /* it went with the range */
    }
    if (count > 0 && experiment->scene.formulation == SCENE_STRAIN_FORM) {
        experiment->scene.formulation = SCENE_MIXED; /* that is one of families */
    }
    return AD_OK;
}
