#include "tools/surrogate/settings.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define SURROGATE_NAME(name, text) text,
const char *const *surrogate_kind_names(void)
{
    static const char *const names[] = {SURROGATE_KIND_LIST(SURROGATE_NAME) NULL};
    return names;
}

const char *const *surrogate_hold_names(void)
{
    static const char *const names[] = {SURROGATE_HOLD_LIST(SURROGATE_NAME) NULL};
    return names;
}
#undef SURROGATE_NAME

surrogate_settings surrogate_settings_default(void)
{
    return (surrogate_settings){.step = NAN, .tolerance = 2e-3, .solved = 20000};
}

bool surrogate_is_given(const surrogate_settings *settings)
{
    return !isnan(settings->step);
}

static bool names(int count, const char *const *all, const char *name)
{
    for (int i = 0; i < count; i++) {
        if (strcmp(all[i], name) == 0) {
            return true;
        }
    }
    return false;
}

bool surrogate_names_parameter(const surrogate_settings *settings, const char *name)
{
    return names(settings->parameter_count, settings->parameters, name);
}
