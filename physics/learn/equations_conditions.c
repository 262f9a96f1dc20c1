/* Equations inside, conditions at faces, and whether they make a model. */
#include "physics/learn/equations_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- residuals ------------------------------------------------------------------------------- */

/* model_value */
static ad_value record_value(const void *context, const domain_place *at)
{
    return equations_record_formula(context, at, NULL);
}

static bool has_field(const equations *e, quantity q)
{
    bool has = false;
    for (int field = 0; field < e->model->field_count; field++) {
        has = has || equations_order(e, q, field, 0) >= 0;
    }
    return has;
}

static ad_status needs_field(const equations *e, quantity q, ad_error *error)
{
    char list[EQUATIONS_LIST_BYTES];
    return has_field(e, q) ? AD_OK
                           : ad_fail(error, AD_BAD_INPUT,
                                     "has no field, so that nothing makes it zero; allowed: a "
                                     "formula of %s or their derivatives",
                                     equations_list_names(e, NAME_FIELD, list));
}

/* A residual at points of the model. */
static ad_status add_residual(equations *e, const char *what, int number, int set, quantity q,
                              ad_error *error)
{
    equations_formula *kept;
    char text[MODEL_NAME];
    ad_status status = equations_keep_formula(e, q, &kept, error);
    if (status == AD_OK) {
        snprintf(text, sizeof text, "%.16s %d", what, number);
        model_add_term(e->model, text, set, 1, equations_record_formula, kept);
        status = equations_model_status(e, error);
    }
    return status;
}

ad_status equations_add_inside(equations *e, const char *text, ad_error *error)
{
    quantity q;
    ad_status status = equations_still_open(e, error);
    status = status == AD_OK ? equations_read_formula(e, text, NAME_ANY, &q, error) : status;
    status = status == AD_OK ? needs_field(e, q, error) : status;
    if (status != AD_OK) {
        return status;
    }
    if (e->inside_set < 0) {
        e->inside_set = model_add_interior(e->model, "inside");
    }
    if (e->inside < MODEL_TERMS_MAX) { /* the model refuses more */
        e->equation[e->inside] = q;
    }
    return add_residual(e, "equation", ++e->inside, e->inside_set, q, error);
}

/* ---- conditions ------------------------------------------------------------------------------ */

static ad_status find_face(const equations *e, const char *text, double at, int *coordinate,
                           int *end, ad_error *error)
{
    const domain *d = &e->model->domain;
    const int i = *coordinate = domain_find(d, text);
    char list[EQUATIONS_LIST_BYTES];
    if (i < 0 || e->is_range[i]) {
        return ad_fail(error, AD_BAD_INPUT, "'%.40s' is no coordinate%s; allowed: %s", text,
                       i < 0 ? "" : " but a parameter",
                       equations_list_names(e, NAME_COORDINATE, list));
    }
    const double low = d->coordinates[i].low, high = d->coordinates[i].high;
    const double close = 1e-12 * (high - low);
    *end = fabs(at - high) <= close;
    if (d->coordinates[i].periodic) {
        return ad_fail(error, AD_BAD_INPUT, "%s is periodic and has no faces; allowed: none", text);
    }
    if ((!*end && !(fabs(at - low) <= close)) || (*end && i == d->time)) {
        char other[40] = ", where time begins";
        if (i != d->time) {
            snprintf(other, sizeof other, " or %g", high);
        }
        return ad_fail(error, AD_BAD_INPUT, "%s = %g is no face; allowed: %g%s", text, at, low,
                       other);
    }
    return AD_OK;
}

/* "u_xx" at a face of x: field and order. */
static ad_status find_normal(const equations *e, int coordinate, const char *what, int *field,
                             int *order, ad_error *error)
{
    int orders[DOMAIN_COORDINATES_MAX], others = 0;
    const char *of = e->model->domain.coordinates[coordinate].name;
    ad_status status = equations_find(e, what, field, orders, error);
    if (status != AD_OK) {
        return status;
    }
    *order = orders[coordinate];
    for (int i = 0; i < e->model->domain.count; i++) {
        others += i == coordinate ? 0 : orders[i];
    }
    const char *symbol = e->model->symbols[*field];
    return others == 0 ? AD_OK
                       : ad_fail(error, AD_BAD_INPUT,
                                 "%s is a derivative along a face of %s; allowed: %s, %s_%s, or "
                                 "zero: %s - (what it is)",
                                 what, of, symbol, symbol, of, what);
}

static ad_status add_value(equations *e, equations_condition c, const char *what, const char *text,
                           ad_error *error)
{
    quantity q;
    equations_formula *kept;
    char name_of[MODEL_NAME];
    ad_status status = find_normal(e, c.coordinate, what, &c.field, &c.order, error);
    for (int i = 0; i < e->condition_count && status == AD_OK; i++) {
        if (memcmp(&e->conditions[i], &c, sizeof c) == 0) {
            status = ad_fail(error, AD_BAD_INPUT, "%s is given twice there; allowed: once", what);
        }
    }
    if (status == AD_OK && e->condition_count == EQUATIONS_CONDITIONS_MAX) {
        status = ad_fail(error, AD_BAD_INPUT, "too many conditions; allowed: %d",
                         EQUATIONS_CONDITIONS_MAX);
    }
    if (status == AD_OK) {
        status =
            equations_read_formula(e, text, NAME_ANY & ~(NAME_FIELD | NAME_DERIVED), &q, error);
    }
    if (status == AD_OK) {
        status = equations_keep_formula(e, q, &kept, error);
    }
    if (status != AD_OK) {
        return status;
    }
    e->conditions[e->condition_count++] = c;
    snprintf(name_of, sizeof name_of, "condition %d", e->condition_count);
    const model_condition added = {c.field, 0, c.coordinate, c.order, record_value, kept};
    model_add_condition(e->model, name_of, added, c.end);
    return equations_model_status(e, error);
}

ad_status equations_add_condition(equations *e, const char *coordinate, double at, const char *what,
                                  const char *text, ad_error *error)
{
    equations_condition c = {0};
    quantity q;
    ad_status status = equations_still_open(e, error);
    status = status == AD_OK ? find_face(e, coordinate, at, &c.coordinate, &c.end, error) : status;
    if (status == AD_OK && strcmp(what, "zero") != 0) {
        status = add_value(e, c, what, text, error);
    } else if (status == AD_OK) {
        status = equations_read_formula(e, text, NAME_ANY, &q, error);
        status = status == AD_OK ? needs_field(e, q, error) : status;
        if (status == AD_OK && e->face[c.coordinate][c.end] == 0) {
            char face[MODEL_NAME];
            snprintf(face, sizeof face, "%.20s %s", coordinate, c.end ? "high" : "low");
            e->face[c.coordinate][c.end] = 1 + model_add_face(e->model, face, c.coordinate, c.end);
        }
        if (status == AD_OK) {
            status =
                add_residual(e, "zero", ++e->zeros, e->face[c.coordinate][c.end] - 1, q, error);
        }
    }
    if (status == AD_OK) {
        e->at[c.coordinate]++;
    }
    return status;
}

/* ---- all of them ----------------------------------------------------------------------------- */

/* The highest derivative of a field by a coordinate in the equations; -1: none has the field. */
static int highest(const equations *e, int field, int coordinate)
{
    int order = -1;
    for (int i = 0; i < e->inside && i < MODEL_TERMS_MAX; i++) {
        const int here = equations_order(e, e->equation[i], field, coordinate);
        order = here > order ? here : order;
    }
    return order;
}

/* A solution has as many conditions at the faces of a coordinate as derivatives by it, or fewer.
 * What data and unknowns leave open is not counted. */
static ad_status check_conditions(const equations *e, ad_error *error)
{
    const domain *d = &e->model->domain;
    for (int i = 0; i < d->count; i++) {
        int orders = 0;
        for (int field = 0; field < e->model->field_count; field++) {
            orders += highest(e, field, i);
        }
        if (e->at[i] > orders && !e->has_data) {
            return ad_fail(error, AD_BAD_INPUT,
                           "%d conditions at the ends of %s, by which the equations have %d "
                           "derivatives in all; allowed: that many at most",
                           e->at[i], d->coordinates[i].name, orders);
        }
        if (i == d->time && orders > 0 && e->at[i] == 0 && !e->has_data) {
            return ad_fail(error, AD_BAD_INPUT,
                           "nothing says how it begins; needed: conditions at %s = %g, or data",
                           d->coordinates[i].name, d->coordinates[i].low);
        }
    }
    return AD_OK;
}

static ad_status check_fields(const equations *e, ad_error *error)
{
    const physics_model *m = e->model;
    for (int i = 0; i < m->field_count; i++) {
        if (highest(e, i, 0) < 0) {
            return ad_fail(error, AD_BAD_INPUT,
                           "no equation has the field %s; allowed: fields of equations",
                           m->symbols[i]);
        }
    }
    return e->inside >= m->field_count || e->has_data
               ? AD_OK
               : ad_fail(error, AD_BAD_INPUT,
                         "%d fields and only %d equations inside; needed: one for each field",
                         m->field_count, e->inside);
}

ad_status equations_model(equations *e, const physics_model **model, ad_error *error)
{
    const physics_model *m = e->model;
    ad_status status = equations_model_status(e, error);
    *model = NULL;
    if (status == AD_OK && (m->domain.count == 0 || m->field_count == 0 || e->inside == 0)) {
        status = ad_fail(error, AD_BAD_INPUT, "there is no %s; needed: one at least",
                         m->domain.count == 0  ? "coordinate"
                         : m->field_count == 0 ? "field"
                                               : "equation inside");
    }
    status = status == AD_OK ? check_fields(e, error) : status;
    status = status == AD_OK ? check_conditions(e, error) : status;
    if (status == AD_OK && e->unknowns > 0 && !e->has_data) {
        char list[EQUATIONS_LIST_BYTES];
        status = ad_fail(error, AD_BAD_INPUT,
                         "nothing is measured that would say what %s is; needed: data, or a number",
                         equations_list_names(e, NAME_UNKNOWN, list));
    }
    if (status == AD_OK) {
        e->is_whole = true;
        *model = m;
    }
    return status;
}
