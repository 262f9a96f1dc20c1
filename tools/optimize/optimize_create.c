/* What is asked for, read: who gives each parameter its value, formulas and their bounds. */
#include "tools/optimize/optimize_parts.h"

#include "physics/numerics/sampling.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- parameters ---------------------------------------------------------------------------- */

enum { NOBODY = -1 };

/* The parameters of a list get their role. */
static ad_status give(optimization *o, const char *list, int count, const char *const *names,
                      optimize_role role, int *number, char *key, ad_error *error)
{
    *number = 0;
    for (int i = 0; i < count; i++) {
        const int p = scene_parameter_find(o->family, names[i]);
        snprintf(key, OPTIMIZE_KEY_MAX, "optimize.%s[%d]", list, i);
        if (p < 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "'%s' is no parameter with a range; allowed: those under parameters",
                           names[i]);
        }
        if (o->index[p] != NOBODY) {
            return ad_fail(error, AD_BAD_INPUT,
                           "'%s' comes twice; a parameter is in variables, each, box or the cases",
                           names[i]);
        }
        o->role[p] = role;
        o->index[p] = (*number)++;
    }
    return AD_OK;
}

static ad_status give_roles(optimization *o, char *key, ad_error *error)
{
    const optimize_settings *settings = o->settings;
    int boxes;
    for (int p = 0; p < o->parameters; p++) {
        o->index[p] = NOBODY;
    }
    for (int c = 0; c < o->cases.columns; c++) {
        if (o->cases.parameter[c] >= 0) {
            o->role[o->cases.parameter[c]] = OPTIMIZE_CASE;
            o->index[o->cases.parameter[c]] = c;
        }
    }
    ad_status status =
        give(o, "box", settings->box_count, settings->box, OPTIMIZE_BOX, &boxes, key, error);
    if (status == AD_OK) {
        status = give(o, "each", settings->each_count, settings->each, OPTIMIZE_EACH, &o->each, key,
                      error);
    }
    if (status == AD_OK) {
        status = give(o, "variables", settings->variable_count, settings->variables,
                      OPTIMIZE_SHARED, &o->shared, key, error);
    }
    for (int p = 0; p < o->parameters && status == AD_OK; p++) {
        if (o->index[p] != NOBODY) {
            continue;
        }
        if (settings->variable_count > 0 || settings->each_count > 0) {
            snprintf(key, OPTIMIZE_KEY_MAX, "optimize.variables");
            return ad_fail(error, AD_BAD_INPUT,
                           "nothing says which value '%s' has; name it under variables, each or "
                           "box, in the cases, or give it a number in place of its range",
                           o->family->parameters[p].name);
        }
        o->role[p] = OPTIMIZE_SHARED; /* all that is left is chosen */
        o->index[p] = o->shared++;
    }
    if (status == AD_OK && o->shared + o->each == 0) {
        snprintf(key, OPTIMIZE_KEY_MAX, "optimize.variables");
        return ad_fail(error, AD_BAD_INPUT, "there is nothing to choose; give parameters a range");
    }
    return status;
}

/* ---- places -------------------------------------------------------------------------------- */

/* Points along the rod, and the named places among them: the end is the first. */
static ad_status put_places(optimization *o, char *key, ad_error *error)
{
    const optimize_settings *settings = o->settings;
    const double length = scene_length(o->family);
    const size_t even = (size_t)settings->points;
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
    o->s = malloc((even + OPTIMIZE_PLACES_MAX) * sizeof *o->s);
    if (!o->s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    o->points = sampling_along(length, even, (size_t)settings->place_count + 1, at, o->s);
    for (int i = 0; i <= settings->place_count; i++) {
        for (size_t j = 0; j < o->points; j++) {
            if (o->s[j] == at[i]) {
                o->place[i] = j;
            }
        }
    }
    return AD_OK;
}

/* ---- formulas ------------------------------------------------------------------------------ */

static ad_status make(optimization *o, const char *text, response **result, ad_error *error)
{
    const char *parameter[OPTIMIZE_NAMES_MAX], *column[OPTIMIZE_NAMES_MAX];
    const char *place[OPTIMIZE_PLACES_MAX + 1] = {"tip"};
    double at[OPTIMIZE_PLACES_MAX + 1];
    for (int i = 0; i < o->parameters; i++) {
        parameter[i] = o->family->parameters[i].name;
    }
    for (int i = 0; i < o->cases.columns; i++) {
        column[i] = o->cases.name[i];
    }
    for (int i = 0; i < o->settings->place_count; i++) {
        place[1 + i] = o->settings->places[i].name;
    }
    for (int i = 0; i <= o->settings->place_count; i++) {
        at[i] = o->s[o->place[i]];
    }
    const response_scope scope = {.family = o->family,
                                  .parameters = o->parameters,
                                  .parameter = parameter,
                                  .columns = o->cases.columns,
                                  .column = column,
                                  .places = 1 + o->settings->place_count,
                                  .place = place,
                                  .at = at,
                                  .s = o->s,
                                  .around = o->around,
                                  .radius = o->settings->radius};
    return response_create(text, &scope, o->points, result, error);
}

/* "tip.z >= 0.1", "0.1 <= tip.z <= 0.2", "tip.z = 0.1": the formula and its bounds. */
static ad_status read_constraint(optimization *o, const char *text, optimize_constraint *c,
                                 ad_error *error)
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
    c->low = -INFINITY;
    c->high = INFINITY;
    if (parts == 3) {
        const bool up = sign[0] == '<' && sign[1] == '<', down = sign[0] == '>' && sign[1] == '>';
        c->low = up ? bound[0] : bound[1];
        c->high = up ? bound[1] : bound[0];
        if ((!up && !down) || c->low > c->high) {
            return ad_fail(error, AD_BAD_INPUT,
                           "has no bounds one below the other; write 0.1 <= FORMULA <= 0.2");
        }
    } else {
        c->low = sign[0] == '<' ? -INFINITY : bound[0];
        c->high = sign[0] == '>' ? INFINITY : bound[0];
    }
    ad_status status = make(o, part[middle], &c->of, error);
    if (status != AD_OK) {
        return status;
    }
    const response_kind kind = response_kind_of(c->of);
    if ((kind == RESPONSE_MAX && isfinite(c->low)) || (kind == RESPONSE_MIN && isfinite(c->high))) {
        return ad_fail(error, AD_BAD_INPUT,
                       "keeps a max from being small or a min from being large; allowed: "
                       "max(...) <= NUMBER, min(...) >= NUMBER");
    }
    c->rows = response_rows(c->of);
    c->by_shared = !response_needs_shape(c->of) && o->cases.columns == 0;
    for (int p = 0; p < o->parameters; p++) {
        c->by_shared =
            c->by_shared && (o->role[p] == OPTIMIZE_SHARED || !response_needs_parameter(c->of, p));
    }
    c->scale = 1;
    return AD_OK;
}

static ad_status make_objective(optimization *o, char *key, ad_error *error)
{
    const optimize_settings *settings = o->settings;
    snprintf(key, OPTIMIZE_KEY_MAX, "optimize.%s", settings->minimize ? "minimize" : "maximize");
    if (settings->minimize && settings->maximize) {
        return ad_fail(error, AD_BAD_INPUT, "stands beside optimize.maximize; give one of them");
    }
    o->sign = settings->minimize ? 1 : -1;
    o->objective_scale = 1;
    ad_status status =
        make(o, settings->minimize ? settings->minimize : settings->maximize, &o->objective, error);
    if (status == AD_OK &&
        response_kind_of(o->objective) == (settings->minimize ? RESPONSE_MIN : RESPONSE_MAX)) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "makes the least value least, or the largest largest; allowed: max to be "
                         "made small, min to be made large");
    }
    return status;
}

ad_status optimize_create(const optimize_settings *settings, const scene *family,
                          const environment *around, optimization **result, char key[64],
                          ad_error *error)
{
    optimization *o = calloc(1, sizeof *o);
    *result = NULL;
    if (!o || !(o->scenario = calloc(OPTIMIZE_SCENARIOS_MAX, sizeof *o->scenario))) {
        free(o);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    o->settings = settings;
    o->family = family;
    o->around = around;
    o->parameters = family->parameter_count;
    ad_status status = optimize_read_cases(settings, family, &o->cases, key, error);
    status = status == AD_OK ? give_roles(o, key, error) : status;
    status = status == AD_OK ? put_places(o, key, error) : status;
    status = status == AD_OK ? make_objective(o, key, error) : status;
    for (; status == AD_OK && o->constraints < settings->constraint_count; o->constraints++) {
        snprintf(key, OPTIMIZE_KEY_MAX, "optimize.constraints[%d]", o->constraints);
        status = read_constraint(o, settings->constraints[o->constraints],
                                 &o->constraint[o->constraints], error);
    }
    o->scenarios = o->cases.count;
    for (size_t i = 0; i < o->cases.count; i++) {
        o->scenario[i].of = i;
        for (int b = 0; b < settings->box_count && status == AD_OK; b++) {
            o->scenario[i].box[b] = scene_parameter_at(
                &family->parameters[scene_parameter_find(o->family, settings->box[b])], 0.5);
        }
    }
    status = status == AD_OK ? optimize_shape(o, error) : status;
    if (status != AD_OK) {
        optimize_free(o);
        return status;
    }
    *result = o;
    return AD_OK;
}

void optimize_free(optimization *o)
{
    if (!o) {
        return;
    }
    response_free(o->objective);
    for (int i = 0; i < OPTIMIZE_CONSTRAINTS_MAX; i++) {
        response_free(o->constraint[i].of);
    }
    double *const numbers[] = {o->cases.values, o->s,      o->x,          o->at,        o->gradient,
                               o->row,          o->by,     o->multiplier, o->given,     o->shapes,
                               o->jacobians,    o->values, o->partials,   o->objectives};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        free(numbers[i]);
    }
    free(o->is_solved);
    free(o->scenario);
    free(o);
}

/* ---- asking -------------------------------------------------------------------------------- */

const double *optimize_places(const optimization *o, size_t *points)
{
    *points = o->points;
    return o->s;
}

size_t optimize_cases(const optimization *o)
{
    return o->cases.count;
}

int optimize_columns(const optimization *o)
{
    return o->cases.columns;
}

const char *optimize_column_name(const optimization *o, int column)
{
    return o->cases.name[column];
}

bool optimize_column_is_parameter(const optimization *o, int column)
{
    return o->cases.parameter[column] >= 0;
}

double optimize_column(const optimization *o, size_t which, int column)
{
    return o->cases.values[which * (size_t)o->cases.columns + (size_t)column];
}

optimize_role optimize_role_of(const optimization *o, int parameter)
{
    return o->role[parameter];
}

double optimize_parameter(const optimization *o, size_t which, int parameter)
{
    double parameters[OPTIMIZE_NAMES_MAX];
    optimize_given(o, o->x, which, parameters);
    return parameters[parameter];
}

double optimize_case_objective(const optimization *o, size_t which)
{
    return o->objectives[which];
}
