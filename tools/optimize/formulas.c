/* Formulas of an optimisation: places that they name, and their bounds. */
#include "tools/optimize/optimize_parts.h"

#include "physics/numerics/sampling.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- places -------------------------------------------------------------------------------- */

/* Points along the rod, and the named places among them: the end is the first. */
ad_status optimize_put_places(const optimize_settings *settings, double length, size_t even,
                              double *s, size_t *points, size_t *place_of,
                              char key[OPTIMIZE_KEY_MAX], ad_error *error)
{
    double at[OPTIMIZE_PLACES_MAX + 1] = {length};
    for (int i = 0; i < settings->place_count; i++) {
        const optimize_place *place = &settings->places[i];
        snprintf(key, OPTIMIZE_KEY_MAX, "optimize.places[%d]", i);
        if (!place->name || isnan(place->at)) {
            return ad_fail(error, AD_BAD_INPUT, "has no name, or no place; give it both");
        }
        if (strcmp(place->name, "tip") == 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "is called tip, which is the end of the rod; choose another name");
        }
        if (place->at < 0 || place->at > length) {
            return ad_fail(error, AD_BAD_INPUT, "is at %g m; allowed: 0 to %g m", place->at,
                           length);
        }
        at[1 + i] = place->at;
    }
    *points = sampling_along(length, even, (size_t)settings->place_count + 1, at, s);
    for (int i = 0; i <= settings->place_count; i++) {
        for (size_t j = 0; j < *points; j++) {
            if (s[j] == at[i]) {
                place_of[i] = j;
            }
        }
    }
    return AD_OK;
}

/* ---- formulas ------------------------------------------------------------------------------ */

response_scope optimize_scope(const optimize_settings *settings, const scene *family,
                              const double *s, const size_t *place_of, optimize_names *names)
{
    for (int i = 0; i < family->parameter_count; i++) {
        names->parameter[i] = family->parameters[i].name;
    }
    for (int i = 0; i <= settings->place_count; i++) {
        names->place[i] = i == 0 ? "tip" : settings->places[i - 1].name;
        names->at[i] = s[place_of[i]];
    }
    return (response_scope){.family = family,
                            .parameters = family->parameter_count,
                            .parameter = names->parameter,
                            .column = names->column,
                            .places = 1 + settings->place_count,
                            .place = names->place,
                            .at = names->at,
                            .s = s,
                            .radius = settings->radius};
}

/* "tip.z >= 0.1", "0.1 <= tip.z <= 0.2", "tip.z = 0.1": the formula and its bounds. */
ad_status optimize_read_constraint(const char *text, const response_scope *scope, size_t points,
                                   response **of, double *low, double *high, ad_error *error)
{
    char copy[400], *part[3] = {copy};
    char sign[2] = {0};
    int parts = 1;
    if (snprintf(copy, sizeof copy, "%s", text) >= (int)sizeof copy) {
        return ad_fail(error, AD_BAD_INPUT, "is longer than %zu characters", sizeof copy - 1);
    }
    for (char *p = copy; *p; p++) {
        if (*p == '<' || *p == '>' || *p == '=') {
            if (parts == 3) {
                return ad_fail(error, AD_BAD_INPUT, "has more than two comparisons");
            }
            sign[parts - 1] = *p;
            *p = '\0';
            while (p[1] == '=') {
                *++p = '\0';
            }
            part[parts++] = p + 1;
        }
    }
    if (parts == 1) {
        return ad_fail(error, AD_BAD_INPUT,
                       "compares nothing; allowed: FORMULA <= NUMBER, >=, =, or both bounds, "
                       "0.1 <= FORMULA <= 0.2");
    }
    double bound[2];
    quantities *names = quantities_create();
    const int middle = parts == 3 ? 1 : 0;
    bool numbers = names != NULL;
    for (int i = 0, k = 0; i < parts && numbers; i++) {
        if (i != middle) {
            numbers = quantity_is_number(quantity_formula(names, part[i]), &bound[k++]);
        }
    }
    quantities_free(names);
    if (!numbers) {
        return ad_fail(error, AD_BAD_INPUT,
                       "is to compare with a number; write FORMULA <= NUMBER, with all that "
                       "varies in the formula");
    }
    *low = -INFINITY;
    *high = INFINITY;
    if (parts == 3) {
        const bool up = sign[0] == '<' && sign[1] == '<', down = sign[0] == '>' && sign[1] == '>';
        *low = up ? bound[0] : bound[1];
        *high = up ? bound[1] : bound[0];
        if ((!up && !down) || *low > *high) {
            return ad_fail(error, AD_BAD_INPUT,
                           "has no bounds one below the other; write 0.1 <= FORMULA <= 0.2");
        }
    } else {
        *low = sign[0] == '<' ? -INFINITY : bound[0];
        *high = sign[0] == '>' ? INFINITY : bound[0];
    }
    const char *formula = isinf(*high) ? response_raised(part[middle]) : part[middle];
    ad_status status = response_create(formula, scope, points, of, error);
    if (status != AD_OK) {
        return status;
    }
    const response_kind kind = response_kind_of(*of);
    if ((kind == RESPONSE_MAX && isfinite(*low)) || (kind == RESPONSE_MIN && isfinite(*high))) {
        return ad_fail(error, AD_BAD_INPUT,
                       "keeps a max from being small or a min from being large; allowed: "
                       "max(...) <= NUMBER, min(...) >= NUMBER");
    }
    return AD_OK;
}
