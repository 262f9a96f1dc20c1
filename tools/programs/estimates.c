#include "tools/programs/estimates.h"

void estimate_open(json *to, const char *name, double value, double deviation)
{
    json_open(to, NULL, '{');
    json_text(to, "name", name);
    json_number(to, "value", value);
    json_number(to, "standard_deviation", deviation);
}

void estimates_json(json *to, int count, const char *const *names, const double *values,
                    const double *deviations, const char *beside, const double *known)
{
    json_open(to, "estimates", '[');
    for (int k = 0; k < count; k++) {
        estimate_open(to, names[k], values[k], deviations[k]);
        json_number(to, beside, known[k]);
        json_close(to, '}');
    }
    json_close(to, ']');
}
