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

/* ---- formulas ------------------------------------------------------------------------------ */

static ad_status put_places(optimization *o, char *key, ad_error *error)
{
    const double length = scene_length(o->family);
    o->s = malloc(((size_t)o->settings->points + OPTIMIZE_PLACES_MAX) * sizeof *o->s);
    if (!o->s) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    }
    return optimize_put_places(o->settings, length, (size_t)o->settings->points, o->s, &o->points,
                               o->place, key, error);
}

static response_scope scope_of(const optimization *o, optimize_names *names)
{
    response_scope scope = optimize_scope(o->settings, o->family, o->s, o->place, names);
    for (int i = 0; i < o->cases.columns; i++) {
        names->column[i] = o->cases.name[i];
    }
    scope.columns = o->cases.columns;
    scope.around = o->around;
    return scope;
}

static ad_status read_constraint(const optimization *o, const response_scope *scope,
                                 const char *text, optimize_constraint *c, ad_error *error)
{
    const ad_status status =
        optimize_read_constraint(text, scope, o->points, &c->of, &c->low, &c->high, error);
    if (status != AD_OK) {
        return status;
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

static ad_status make_objective(optimization *o, const response_scope *scope, char *key,
                                ad_error *error)
{
    const optimize_settings *settings = o->settings;
    snprintf(key, OPTIMIZE_KEY_MAX, "optimize.%s", settings->minimize ? "minimize" : "maximize");
    if (settings->minimize && settings->maximize) {
        return ad_fail(error, AD_BAD_INPUT, "stands beside optimize.maximize; give one of them");
    }
    o->sign = settings->minimize ? 1 : -1;
    o->objective_scale = 1;
    const char *text =
        settings->minimize ? settings->minimize : response_raised(settings->maximize);
    ad_status status = response_create(text, scope, o->points, &o->objective, error);
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
    optimize_names names;
    const response_scope scope = status == AD_OK ? scope_of(o, &names) : (response_scope){0};
    status = status == AD_OK ? make_objective(o, &scope, key, error) : status;
    for (; status == AD_OK && o->constraints < settings->constraint_count; o->constraints++) {
        snprintf(key, OPTIMIZE_KEY_MAX, "optimize.constraints[%d]", o->constraints);
        status = read_constraint(o, &scope, settings->constraints[o->constraints],
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
    double *const numbers[] = {o->cases.values, o->s,          o->x,         o->at,
                               o->gradient,     o->row,        o->by,        o->multiplier,
                               o->given,        o->shapes,     o->jacobians, o->values,
                               o->partials,     o->objectives, o->margins,   o->by_margins};
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
