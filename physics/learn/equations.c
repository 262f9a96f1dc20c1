/* Names, formulas and residuals of equations that are given as text. */
#include "physics/learn/equations_internal.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

equations *equations_create(void)
{
    equations *e = calloc(1, sizeof *e);
    if (e) {
        e->model = model_create();
        e->quantities = quantities_create_open();
        e->inside_set = -1;
    }
    if (e && (!e->model || !e->quantities)) {
        equations_free(e);
        e = NULL;
    }
    return e;
}

void equations_free(equations *e)
{
    while (e && e->formulas) {
        equations_formula *next = e->formulas->next;
        free(e->formulas->places);
        free(e->formulas->values);
        free(e->formulas);
        e->formulas = next;
    }
    if (e) {
        model_free(e->model);
        quantities_free(e->quantities);
    }
    free(e);
}

/* ---- names ----------------------------------------------------------------------------------- */

int equations_find_name(const equations *e, const char *text, size_t length)
{
    for (int i = 0; i < e->name_count; i++) {
        if (strlen(e->names[i].text) == length && strncmp(e->names[i].text, text, length) == 0) {
            return i;
        }
    }
    return -1;
}

/* Those of some kinds, without derivatives, "x, t". */
const char *equations_list_names(const equations *e, int kinds, char list[EQUATIONS_LIST_BYTES])
{
    size_t used = 0;
    list[0] = '\0';
    for (int i = 0; i < e->name_count && used < EQUATIONS_LIST_BYTES; i++) {
        const equations_name *n = &e->names[i];
        bool derived = false;
        for (int k = 0; k < e->model->domain.count; k++) {
            derived = derived || n->orders[k] > 0;
        }
        if ((n->kind & kinds) && !derived) {
            used += (size_t)snprintf(list + used, EQUATIONS_LIST_BYTES - used, "%s%s",
                                     used ? ", " : "", n->text);
        }
    }
    return list[0] ? list : "none yet";
}

ad_status equations_still_open(const equations *e, ad_error *error)
{
    return e->is_whole ? ad_fail(error, AD_BAD_INPUT,
                                 "the model is made already; allowed: everything before that")
                       : AD_OK;
}

/* What the model refuses of itself, kept there, too. */
ad_status equations_model_status(const equations *e, ad_error *error)
{
    const ad_error *own = &e->model->error;
    return own->status == AD_OK ? AD_OK : ad_fail(error, AD_BAD_INPUT, "%s", own->message);
}

/* A name that is open in formulas, or none of them (NAME_PARAMETER). */
static ad_status add_name(equations *e, const char *text, name_kind kind, int index,
                          const int *orders, ad_error *error)
{
    ad_status status = equations_still_open(e, error);
    if (status == AD_OK && (e->name_count == EQUATIONS_NAMES_MAX || strchr(text, '.'))) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "'%.40s' is one name too many, or no name; allowed: %d of letters, "
                         "digits and _, beginning with a letter",
                         text, EQUATIONS_NAMES_MAX);
    }
    if (status == AD_OK && kind != NAME_PARAMETER) {
        status = quantities_coordinate(e->quantities, text, error);
    }
    if (status != AD_OK) {
        return status;
    }
    equations_name *n = &e->names[e->name_count++];
    *n = (equations_name){.kind = kind, .index = index};
    snprintf(n->text, sizeof n->text, "%s", text);
    if (orders) {
        memcpy(n->orders, orders, sizeof n->orders);
    }
    return AD_OK;
}

/* The text of `length` as a derivative of a field, or of a parameter where `any`: the longest name
 * of one that stands before an underscore. -1: none does. */
static int derivative_of(const equations *e, const char *text, size_t length, bool any, int *orders,
                         bool *is_readable)
{
    int found = -1;
    size_t longest = 0;
    for (int i = 0; i < e->name_count; i++) {
        const equations_name *n = &e->names[i];
        const size_t size = strlen(n->text);
        const bool base =
            (n->kind == NAME_FIELD && strcmp(n->text, e->model->symbols[n->index]) == 0) ||
            (any && n->kind == NAME_PARAMETER);
        if (base && size > longest && size + 1 < length && text[size] == '_' &&
            strncmp(text, n->text, size) == 0) {
            found = i;
            longest = size;
        }
    }
    *is_readable =
        found >= 0 && domain_read_orders(&e->model->domain, text + longest + 1,
                                         length - longest - 1, EQUATIONS_ORDER_MAX, orders);
    return found;
}

/* Makes an open name of a word that is a derivative; any other word is left to the formula. */
static ad_status know_word(equations *e, const char *word, size_t length, ad_error *error)
{
    int orders[DOMAIN_COORDINATES_MAX] = {0};
    char text[EQUATIONS_NAME_BYTES], list[EQUATIONS_LIST_BYTES];
    bool is_readable;
    const int of = equations_find_name(e, word, length) >= 0 || length >= sizeof text
                       ? -1
                       : derivative_of(e, word, length, true, orders, &is_readable);
    if (of < 0) {
        return AD_OK;
    }
    const equations_name *base = &e->names[of];
    const bool is_field = base->kind == NAME_FIELD;
    snprintf(text, sizeof text, "%.*s", (int)length, word);
    if (!is_field && (quantity_calls(base->q, "where") || quantity_calls(base->q, "step"))) {
        return ad_fail(error, AD_BAD_INPUT,
                       "'%s': %s jumps, and its derivative would leave that out; allowed: a field "
                       "%s with the equation that it is this formula",
                       text, base->text, base->text);
    }
    return is_readable ? add_name(e, text, is_field ? NAME_FIELD : NAME_DERIVED,
                                  is_field ? base->index : of, orders, error)
                       : ad_fail(error, AD_BAD_INPUT,
                                 "'%s' is no derivative; allowed behind %s_ are coordinates, %d "
                                 "times at most: %s",
                                 text, base->text, EQUATIONS_ORDER_MAX,
                                 equations_list_names(e, NAME_COORDINATE | NAME_RANGE, list));
}

ad_status equations_find(const equations *e, const char *text, int *field,
                         int orders[DOMAIN_COORDINATES_MAX], ad_error *error)
{
    const int known = equations_find_name(e, text, strlen(text));
    char list[EQUATIONS_LIST_BYTES];
    bool is_readable = known >= 0 && e->names[known].kind == NAME_FIELD;
    memset(orders, 0, DOMAIN_COORDINATES_MAX * sizeof *orders);
    int of = known;
    if (is_readable) {
        memcpy(orders, e->names[known].orders, sizeof e->names[known].orders);
    } else if (known < 0) {
        of = derivative_of(e, text, strlen(text), false, orders, &is_readable);
    }
    *field = is_readable ? e->names[of].index : -1;
    return is_readable ? AD_OK
                       : ad_fail(error, AD_BAD_INPUT,
                                 "'%.40s' is no field and no derivative of one; allowed: %s, and "
                                 "behind an underscore what it is differentiated by",
                                 text, equations_list_names(e, NAME_FIELD, list));
}

/* ---- formulas -------------------------------------------------------------------------------- */

/* Words of a formula, of which those that are derivatives become names. */
ad_status equations_know_words(equations *e, const char *text, ad_error *error)
{
    ad_status status = AD_OK;
    while (*text && status == AD_OK) {
        size_t length = 0;
        while (isalnum((unsigned char)text[length]) || text[length] == '_') {
            length++;
        }
        if (length > 0 && !isdigit((unsigned char)text[0])) {
            status = know_word(e, text, length, error);
        }
        text += length > 0 ? length : 1;
    }
    return status;
}

/* A formula that is left with some kinds of names; `q` lives as long as the equations. */
ad_status equations_read_formula(equations *e, const char *text, int kinds, quantity *q,
                                 ad_error *error)
{
    char list[EQUATIONS_LIST_BYTES];
    ad_error why;
    ad_status status = equations_know_words(e, text, error);
    if (status == AD_OK) {
        *q = quantity_formula(e->quantities, text);
        status = quantity_check(*q, &why);
        if (status != AD_OK) {
            const bool derives = (kinds & NAME_FIELD) && e->model->field_count > 0 &&
                                 e->model->domain.count > 0 && strstr(why.message, "unknown name");
            ad_fail(error, status, "%s%s%s%s%s", why.message,
                    derives ? ", and derivatives as " : "", derives ? e->model->symbols[0] : "",
                    derives ? "_" : "", derives ? e->model->domain.coordinates[0].name : "");
        }
    }
    for (int i = 0; i < e->name_count && status == AD_OK; i++) {
        const equations_name *n = &e->names[i];
        if (!(n->kind & kinds) && quantity_depends_on(*q, n->text)) {
            status =
                ad_fail(error, AD_BAD_INPUT, "%s stands where only %s %s allowed", n->text,
                        kinds ? equations_list_names(e, kinds, list) : "numbers and parameters",
                        kinds ? "and numbers are" : "are");
        }
    }
    return status;
}

ad_status equations_keep_formula(equations *e, quantity q, equations_formula **kept,
                                 ad_error *error)
{
    *kept = calloc(1, sizeof **kept);
    if (!*kept) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a formula");
    }
    **kept = (equations_formula){.next = e->formulas, .owner = e, .q = q};
    e->formulas = *kept;
    return AD_OK;
}

static ad_value record_quantity(const equations *e, quantity q, const domain_place *at,
                                const ad_value *fields)
{
    quantity_binding bindings[EQUATIONS_NAMES_MAX];
    int count = 0;
    for (int i = 0; i < e->name_count; i++) {
        if (quantity_depends_on(q, e->names[i].text)) {
            bindings[count++] = (quantity_binding){
                e->names[i].text, equations_record_name(e, &e->names[i], at, fields)};
        }
    }
    return quantity_record(q, at->tape, count, bindings);
}

ad_value equations_record_name(const equations *e, const equations_name *n, const domain_place *at,
                               const ad_value *fields)
{
    if (n->kind == NAME_UNKNOWN) {
        return ad_row(at->unknowns, n->index);
    }
    if (n->kind == NAME_COORDINATE || n->kind == NAME_RANGE) {
        return at->x[n->index];
    }
    ad_value value = n->kind == NAME_FIELD ? fields[n->index]
                                           : record_quantity(e, e->names[n->index].q, at, fields);
    for (int i = 0; i < e->model->domain.count; i++) {
        value = n->orders[i] > 0 ? ad_derivative(value, at->x[i], n->orders[i]) : value;
    }
    return value;
}

ad_value equations_record_formula(const void *context, const domain_place *at,
                                  const ad_value *fields)
{
    const equations_formula *f = context;
    return record_quantity(f->owner, f->q, at, fields);
}

int equations_order(const equations *e, quantity q, int field, int coordinate)
{
    int highest = -1;
    for (int i = 0; i < e->name_count; i++) {
        const equations_name *n = &e->names[i];
        int order = -1;
        if (n->kind == NAME_FIELD && n->index == field && quantity_depends_on(q, n->text)) {
            order = n->orders[coordinate];
        } else if (n->kind == NAME_DERIVED && quantity_depends_on(q, n->text)) {
            order = equations_order(e, e->names[n->index].q, field, coordinate);
            order += order >= 0 ? n->orders[coordinate] : 0;
        }
        highest = order > highest ? order : highest;
    }
    return highest;
}

ad_status equations_number(equations *e, const char *text, double *value, ad_error *error)
{
    quantity q;
    ad_status status = equations_read_formula(e, text, 0, &q, error);
    if (status == AD_OK) {
        quantity_is_number(q, value);
    }
    return status;
}

/* ---- adding ---------------------------------------------------------------------------------- */

static ad_status check_range(const char *text, double low, double high, ad_error *error)
{
    bool fine = isfinite(low) && isfinite(high) && high - low > 0 && isfinite(high - low);
    return fine ? AD_OK
                : ad_fail(error, AD_BAD_INPUT,
                          "the range of %.40s goes from %g to %g; allowed: two finite numbers, the "
                          "smaller one first",
                          text, low, high);
}

static ad_status add_coordinate(equations *e, const equations_coordinate *c, name_kind kind,
                                ad_error *error)
{
    const int index = e->model->domain.count;
    ad_status status = check_range(c->name, c->low, c->high, error);
    if (status == AD_OK && index == DOMAIN_COORDINATES_MAX) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "too many coordinates; allowed: %d, with the ranges "
                         "of parameters",
                         DOMAIN_COORDINATES_MAX);
    }
    if (status == AD_OK) {
        status = add_name(e, c->name, kind, index, NULL, error);
    }
    if (status != AD_OK) {
        return status;
    }
    snprintf(e->units[index], sizeof e->units[index], "%s", c->unit ? c->unit : "");
    model_add_coordinate(e->model, c->name, e->units[index], c->low, c->high, 1);
    return equations_model_status(e, error);
}

ad_status equations_add_coordinate(equations *e, const equations_coordinate *c, ad_error *error)
{
    const domain *d = &e->model->domain;
    const int index = d->count;
    if (c->time && d->time >= 0) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%.40s is a second coordinate of time, beside %s; "
                       "allowed: one",
                       c->name, d->coordinates[d->time].name);
    }
    if (c->time && c->periodic) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%.40s is periodic and time; allowed: one of both, since what has a start "
                       "does not repeat itself",
                       c->name);
    }
    ad_status status = add_coordinate(e, c, NAME_COORDINATE, error);
    if (status == AD_OK && c->time) {
        model_set_time(e->model, index);
    }
    if (status == AD_OK && c->periodic) {
        model_set_periodic(e->model, index);
    }
    return status == AD_OK ? equations_model_status(e, error) : status;
}

ad_status equations_add_range(equations *e, const char *text, double low, double high,
                              ad_error *error)
{
    const int index = e->model->domain.count;
    const equations_coordinate c = {text, "", low, high, false, false};
    ad_status status = add_coordinate(e, &c, NAME_RANGE, error);
    if (status == AD_OK) {
        e->is_range[index] = true;
    }
    return status;
}

ad_status equations_add_parameter(equations *e, const char *text, const char *formula,
                                  ad_error *error)
{
    quantity q;
    ad_status status = equations_still_open(e, error);
    status = status == AD_OK ? equations_read_formula(e, formula, NAME_ANY, &q, error) : status;
    if (status == AD_OK) {
        status = quantities_define(e->quantities, text, q, error);
    }
    if (status == AD_OK) {
        status = add_name(e, text, NAME_PARAMETER, 0, NULL, error);
    }
    if (status == AD_OK) {
        e->names[e->name_count - 1].q = q;
    }
    return status;
}

ad_status equations_add_unknown(equations *e, const char *text, double guess, ad_error *error)
{
    if (!isfinite(guess)) {
        return ad_fail(error, AD_BAD_INPUT, "the guess of %.40s is %g; allowed: a finite number",
                       text, guess);
    }
    ad_status status = add_name(e, text, NAME_UNKNOWN, e->unknowns, NULL, error);
    if (status == AD_OK) {
        e->unknowns++;
        model_add_unknown(e->model, text, "", guess);
        status = equations_model_status(e, error);
    }
    return status;
}

ad_status equations_add_field(equations *e, const char *text, ad_error *error)
{
    ad_status status = equations_still_open(e, error);
    if (status == AD_OK && (e->model->field_count == MODEL_FIELDS_MAX ||
                            strlen(text) >= sizeof e->model->symbols[0])) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "the field '%.40s': allowed: %d, with names of 1 to 7 letters", text,
                         MODEL_FIELDS_MAX);
    }
    if (status == AD_OK) {
        status = add_name(e, text, NAME_FIELD, e->model->field_count, NULL, error);
    }
    if (status == AD_OK) {
        model_add_field(e->model, text, 1);
        status = equations_model_status(e, error);
    }
    return status;
}

bool equations_is_range(const equations *e, int coordinate)
{
    return e->is_range[coordinate];
}

const physics_model *equations_so_far(const equations *e)
{
    return e->model;
}
