#include "tools/environment/environment.h"

ad_status environment_open(const environment_settings *settings, double length,
                           environment **result, ad_error *error)
{
    static const double units[] = {
#define UNIT(name, word, size) size,
        ENVIRONMENT_UNIT_LIST(UNIT)
#undef UNIT
    };
    surface *of = NULL;
    *result = NULL;
    ad_status status = surface_read(settings->file, units[settings->unit], &of, error);
    if (status == AD_OK && surface_check_size(of, length, error) != AD_OK) {
        surface_free(of);
        return AD_BAD_INPUT;
    }
    if (status == AD_OK) {
        surface_place(of, settings->position, settings->rotation);
        status = environment_create(of, settings->side, result, error);
    }
    return status;
}
