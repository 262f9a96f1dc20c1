/* Members of a family of scenes: the values of its parameters. */
#include "physics/scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

double scene_parameter_at(const scene_parameter *parameter, double fraction)
{
    return parameter->scale == SCENE_LOG
               ? parameter->low * pow(parameter->high / parameter->low, fraction)
               : parameter->low + (parameter->high - parameter->low) * fraction;
}

bool scene_parameter_holds(const scene_parameter *parameter, double value)
{
    const double slack = 1e-12 * fmax(fabs(parameter->low), fabs(parameter->high));
    return value >= parameter->low - slack && value <= parameter->high + slack;
}

double scene_parameter_fraction(const scene_parameter *parameter, double value)
{
    return parameter->scale == SCENE_LOG
               ? log(value / parameter->low) / log(parameter->high / parameter->low)
               : (value - parameter->low) / (parameter->high - parameter->low);
}

double scene_parameter_slope(const scene_parameter *parameter, double value)
{
    return parameter->scale == SCENE_LOG ? value * log(parameter->high / parameter->low)
                                         : parameter->high - parameter->low;
}

double scene_spread_fraction(int number, int i)
{
    const double drawn = (number + 1) * sqrt(2 + 3 * i);
    return drawn - floor(drawn);
}

double scene_unknown_scalar(const scene_parameter *parameter, double guess)
{
    static const double EDGE = 1e-2;
    const double z = fmin(1 - EDGE, fmax(EDGE, scene_parameter_fraction(parameter, guess)));
    return log(z / (1 - z));
}

double scene_unknown_value(const scene_parameter *parameter, double guess, double scalar)
{
    const double y = scalar + scene_unknown_scalar(parameter, guess);
    return scene_parameter_at(parameter, 1 / (1 + exp(-y)));
}

void scene_member(const scene *family, const double *values, scene *member)
{
    const char *names[SCENE_PARAMETERS_MAX];
    if (!scene_is_open(family)) {
        *member = *family;
        return;
    }
    for (int i = 0; i < family->parameter_count; i++) {
        names[i] = family->parameters[i].name;
    }
    scene_with(family, family->parameter_count, names, values, member);
    member->parameter_count = member->unknown_count = member->memory_count = 0;
    if (member->formulation == SCENE_STRAIN_FORM) { /* which is one of families */
        member->formulation = SCENE_MIXED;
    }
}

const double *scene_middle_values(const scene *family, double *values)
{
    for (int i = 0; i < family->parameter_count; i++) {
        values[i] = i < scene_known_count(family) ? scene_parameter_at(&family->parameters[i], 0.5)
                                                  : family->guess[i];
    }
    return values;
}

void scene_middle(const scene *family, scene *member)
{
    double values[SCENE_PARAMETERS_MAX];
    scene_member(family, scene_middle_values(family, values), member);
}

void scene_place_ends(const scene *family, scene *member)
{
    scene middle;
    scene_middle(family, &middle);
    memcpy(member->start.position, middle.start.position, sizeof middle.start.position);
    memcpy(member->end.position, middle.end.position, sizeof middle.end.position);
}

/* ---- as text --------------------------------------------------------------------------------- */

/* The parameters without a value, "a, b". */
static void list_missing(int count, const scene_parameter *parameters, const double *values,
                         char text[300])
{
    size_t at = 0;
    text[0] = '\0';
    for (int i = 0; i < count && at < 300; i++) {
        if (isnan(values[i])) {
            at += (size_t)snprintf(text + at, 300 - at, "%s%s", at ? ", " : "", parameters[i].name);
        }
    }
}

static int find(int count, const scene_parameter *parameters, const char *name, size_t length)
{
    for (int i = 0; i < count; i++) {
        if (strlen(parameters[i].name) == length &&
            strncmp(parameters[i].name, name, length) == 0) {
            return i;
        }
    }
    return -1;
}

int scene_parameter_find(const scene *family, const char *name)
{
    return find(family->parameter_count, family->parameters, name, strlen(name));
}

/* One "name=value" at the beginning of `text`; returns what follows it, NULL: an error. */
static const char *read_one(int count, const scene_parameter *parameters, bool any_value,
                            const char *text, double *values, ad_error *error)
{
    char missing[300], *end = NULL;
    const size_t length = strcspn(text, "=, ");
    const char *equals = text + length + strspn(text + length, " ");
    const double value = *equals == '=' ? strtod(equals + 1, &end) : 0;
    const bool is_number = end && end > equals + 1 && isfinite(value);
    const char *next = is_number ? end + strspn(end, " ") : text;
    if (!is_number || (*next && *next != ',')) {
        ad_fail(error, AD_BAD_INPUT, "member '%.80s': allowed: name=number, name=number, ...",
                text);
        return NULL;
    }
    const int index = find(count, parameters, text, length);
    if (index < 0 || !isnan(values[index])) {
        list_missing(count, parameters, values, missing);
        ad_fail(error, AD_BAD_INPUT, "member: %.*s %s; allowed: %s", (int)fmin((double)length, 60),
                text, index < 0 ? "is no parameter with a range" : "is given twice",
                *missing ? missing : "nothing more");
        return NULL;
    }
    const scene_parameter *parameter = &parameters[index];
    if (!any_value && !scene_parameter_holds(parameter, value)) {
        ad_fail(error, AD_BAD_INPUT, "member: %s = %g is outside its range; allowed: %g to %g",
                parameter->name, value, parameter->low, parameter->high);
        return NULL;
    }
    values[index] = value;
    return *next ? next + 1 : next;
}

ad_status scene_member_read(int count, const scene_parameter *parameters, bool any_value,
                            const char *text, double *values, ad_error *error)
{
    char missing[300];
    for (int i = 0; i < count; i++) {
        values[i] = NAN;
    }
    for (text += strspn(text, " "); *text; text += strspn(text, " ")) {
        text = read_one(count, parameters, any_value, text, values, error);
        if (!text) {
            return AD_BAD_INPUT;
        }
    }
    list_missing(count, parameters, values, missing);
    return *missing ? ad_fail(error, AD_BAD_INPUT,
                              "the scene is a family, of which one member is wanted: values are "
                              "missing of %s",
                              missing)
                    : AD_OK;
}
