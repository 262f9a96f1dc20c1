/* Numbers that were found, with their standard deviations, as JSON. */
#ifndef TOOLS_PROGRAMS_ESTIMATES_H
#define TOOLS_PROGRAMS_ESTIMATES_H

#include "tools/files/json.h"

/* Opens an object with name, value and standard_deviation, to be closed. */
void estimate_open(json *to, const char *name, double value, double deviation);

/* "estimates": such objects [count], each with what else is known of it under the name `beside`. */
void estimates_json(json *to, int count, const char *const *names, const double *values,
                    const double *deviations, const char *beside, const double *known);

#endif
