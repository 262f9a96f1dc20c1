#include "tools/optimize/optimize_settings.h"

#include <math.h>

optimize_settings optimize_settings_default(void)
{
    optimize_settings x = {.motion = {.intervals = 40, .modes = {3, 1, 0, 0}},
                           .environment = ENVIRONMENT_DEFAULT,
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

bool optimize_motion_is_given(const optimize_settings *settings)
{
    return settings->motion.start || settings->motion.end;
}
