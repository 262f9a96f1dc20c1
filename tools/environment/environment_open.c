#include "tools/environment/environment.h"

ad_status surface_open(const environment_settings *settings, surface **result, ad_error *error)
{
    static const double units[] = {
#define UNIT(name, word, size) size,
        ENVIRONMENT_UNIT_LIST(UNIT)
#undef UNIT
    };
    const ad_status status = surface_read(settings->file, units[settings->unit], result, error);
    if (status == AD_OK) {
        surface_place(*result, settings->position, settings->rotation);
    }
    return status;
}

ad_status environment_open(const environment_settings *settings, double length,
                           environment **result, ad_error *error)
{
    surface *of = NULL;
    *result = NULL;
    ad_status status = surface_open(settings, &of, error);
    if (status == AD_OK && surface_check_size(of, length, error) != AD_OK) {
        surface_free(of);
        return AD_BAD_INPUT;
    }
    return status == AD_OK ? environment_create(of, settings->side, result, error) : status;
}
