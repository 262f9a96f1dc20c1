#include "tools/optimize/optimize_settings.h"

#include <math.h>

optimize_settings optimize_settings_default(void)
{
    optimize_settings x = {.environment = ENVIRONMENT_DEFAULT,
                           .radius = NAN,
                           .points = 33,
                           .starts = 8,
                           .tolerance = 1e-8,
                           .seed = 1};
    for (int i = 0; i < OPTIMIZE_PLACES_MAX; i++) {
        x.places[i].at = NAN;
    }
    return x;
}

bool optimize_is_given(const optimize_settings *settings)
{
    return settings->minimize || settings->maximize;
}
