/* What scene_check asks of every quantity by itself: what it depends on, and its range. */
#include "physics/scene/scene_internal.h"
#include "physics/scene/support.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Whether it may depend on s or t; if it may not, what to say. */
typedef struct rule_row {
    bool along_s, in_time;
    const char *of_s, *of_t;
} rule_row;

static rule_row rule_of(const scene *given, const scene_field *field)
{
    static const char one[] = "depends on s or t; allowed: one number";
    static const char at_end[] = "depends on s, but it belongs to one end; allowed: a formula of t";
    const scene_end *end = field->part == SCENE_OF_START ? &given->start : &given->end;
    switch (field->rule) {
    case SCENE_ONE_NUMBER:
    case SCENE_EACH_NUMBER:
    case SCENE_LENGTH:
    case SCENE_PLACE:
        return (rule_row){false, strcmp(field->key, "rod.inserted") == 0, one, one};
    case SCENE_ALONG:
        return (rule_row){true, false, NULL,
                          "depends on t, but it may not change with time; allowed: a formula of s"};
    case SCENE_IN_TIME:
        return (rule_row){false, true,
                          "depends on s, but it is the same all along; allowed: a formula of t",
                          NULL};
    case SCENE_AT_END:
        return (rule_row){false, true, at_end, NULL};
    case SCENE_AT_PLACE:
        return (rule_row){false, true,
                          "depends on s, but it belongs to one place; allowed: a formula of t",
                          NULL};
    case SCENE_HELD:
        return (rule_row){false, end->type == SCENE_DRIVEN, at_end,
                          "depends on t, but the end stands still; allowed: numbers, or an end of "
                          "type driven"};
    case SCENE_AT_START:
        return (rule_row){true, false, NULL,
                          "depends on t, but it holds at t = 0; allowed: a formula of s"};
    case SCENE_EVERYWHERE:
        break;
    }
    return (rule_row){true, true, NULL, NULL};
}

/* Where it holds. */
static scene_range range_of(const scene *given, const scene_field *field, quantity q)
{
    quantity_interval s = {0, scene_length(given)}, t = {0, scene_duration(given)};
    bool part = scene_field_span(given, field, &s.low, &s.high);
    return scene_range_between(
        q, s, t, part ? scene_range_within(given, q, s.low, s.high) : scene_range_of(given, q));
}

/* NULL, or what its values must be. */
static const char *beyond_bounds(const scene *given, const scene_field *field, quantity q)
{
    if (field->bounds == SCENE_ANY) {
        return NULL;
    }
    bool varies = quantity_depends_on(q, "s");
    scene_range x = range_of(given, field, q);
    bool finite = isfinite(x.low) && isfinite(x.high);
    switch (field->bounds) {
    case SCENE_FINITE:
        return finite ? NULL : "must be finite";
    case SCENE_POSITIVE:
        return finite && x.low > 0 ? NULL
               : varies            ? "must be finite and > 0 all along"
                                   : "must be a finite number > 0";
    case SCENE_NOT_NEGATIVE:
        return finite && x.low >= 0 ? NULL
               : varies             ? "must be finite and >= 0 all along"
                                    : "must be finite and >= 0";
    case SCENE_STIFFNESS:
        return scene_locks(q) || (finite && x.low > 0) ? NULL
                                                       : "must be > 0; .inf locks that strain";
    case SCENE_POISSON:
        return x.low > -1 && x.high <= 0.5 ? NULL : "must be > -1 and <= 0.5";
    case SCENE_ANY:
        break;
    }
    return NULL;
}

/* Whether it is a number at places within, else where it is not; it may be infinite at single ones.
 */
static bool is_number(const scene *given, quantity q, double *s, double *t)
{
    enum { PLACES = 11 };
    *s = *t = NAN;
    const bool along = quantity_depends_on(q, "s"), moves = quantity_depends_on(q, "t");
    for (int i = 0; i < (along ? PLACES : 1); i++) {
        for (int k = 0; k < (moves ? PLACES : 1); k++) {
            const double at = (i + 0.5) / PLACES * scene_length(given);
            const double then = (k + 0.5) / PLACES * scene_duration(given);
            const double value = quantity_value(q, at, then);
            *s = along ? at : NAN;
            *t = moves ? then : NAN;
            if (isnan(value) || (!along && !moves && isinf(value))) {
                return false;
            }
        }
    }
    return true;
}

/* s, t: where it is none, NaN: it does not depend on them. */
static ad_status refuse_number(const scene_checker *check, const char *key, double s, double t)
{
    char place[40] = "", then[40] = "";
    if (!isnan(s)) {
        snprintf(place, sizeof place, ", and is not at s = %g m", s);
    }
    if (!isnan(t)) {
        snprintf(then, sizeof then, "%s t = %g s", isnan(s) ? ", and is not at" : ",", t);
    }
    *check->key = key;
    return ad_fail(check->error, AD_BAD_INPUT, "must be finite%s%s", place, then);
}

static ad_status check_entry(const scene_checker *check, const scene_field *field, quantity entry)
{
    rule_row rule = rule_of(check->scene, field);
    bool moves = quantity_depends_on(entry, "t");
    double s, t;
    ad_status status = quantity_check(entry, check->error);
    if (status != AD_OK) {
        *check->key = field->key;
        return status;
    }
    if (quantity_depends_on(entry, "s") && !rule.along_s) {
        return scene_refuse(check, field->key, rule.of_s);
    }
    if (moves && !rule.in_time) {
        return scene_refuse(check, field->key, rule.of_t);
    }
    if (moves && !scene_is_dynamic(check->scene)) {
        char sentence[sizeof check->error->message];
        support_sentence(support_feature_find("a formula of time"), SUPPORT_MIXED, sentence,
                         sizeof sentence);
        return scene_refuse(check, field->key, sentence);
    }
    if (quantity_calls(entry, "within") && isnan(range_of(check->scene, field, entry).low)) {
        return scene_refuse(check, field->key,
                            "goes beyond the rows of its table somewhere along the rod or in time; "
                            "give a table that covers them");
    }
    if (field->bounds == SCENE_ANY && !is_number(check->scene, entry, &s, &t)) {
        return refuse_number(check, field->key, s, t);
    }
    const char *beyond = beyond_bounds(check->scene, field, entry);
    return beyond ? scene_refuse(check, field->key, beyond) : AD_OK;
}

static ad_status check_field(const scene_checker *check, const scene_field *field)
{
    const quantity *entries = scene_field_of(check->scene, field);
    ad_status status = AD_OK;
    if (!quantity_any_given(field->count, entries)) {
        return AD_OK;
    }
    for (int i = 0; i < field->count && status == AD_OK; i++) {
        status = entries[i].is_given ? check_entry(check, field, entries[i])
                                     : scene_refuse(check, field->key,
                                                    "some entries are missing; give all or none");
    }
    return status;
}

ad_status scene_check_quantities(const scene_checker *check, bool of_extent)
{
    ad_status status = AD_OK;
    for (int i = 0; i < scene_field_count && status == AD_OK; i++) {
        const scene_field *field = &scene_fields[i];
        bool extent = field->part == SCENE_OF_EXTENT,
             shared = extent || field->part == SCENE_OF_ROD;
        if (extent == of_extent &&
            (shared || (field->part == SCENE_OF_BEAM) == scene_is_beam(check->scene))) {
            status = check_field(check, field);
        }
    }
    return status;
}
