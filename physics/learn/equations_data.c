/* Data of equations: measured numbers at places. */
#include "physics/learn/equations_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static ad_value record_measured(const void *context, const domain_place *at, const ad_value *fields)
{
    const equations_formula *f = context;
    const ad_value value = equations_record_name(f->owner, &f->owner->names[f->of], at, fields);
    return ad_scale(ad_sub(value, at->data), 1 / f->noise);
}

/* The measured places, again and again where more are asked for. */
static ad_status fill_measured(void *context, const model_draw *draw, ad_error *error)
{
    const equations_formula *f = context;
    const size_t coordinates = (size_t)f->owner->model->domain.count;
    (void)error;
    for (size_t i = 0; i < draw->count; i++) {
        for (size_t c = 0; c < coordinates; c++) {
            draw->x[c * draw->count + i] = f->places[c * f->rows + i % f->rows];
        }
        draw->data[i] = f->values[i % f->rows];
    }
    return AD_OK;
}

/* What is measured of one column, at places where its number is one. */
static ad_status add_measured(equations *e, int of, size_t rows, const double *const *places,
                              const double *values, double noise, ad_error *error)
{
    const size_t coordinates = (size_t)e->model->domain.count;
    equations_formula *kept;
    size_t count = 0;
    double squares = 0;
    char text[MODEL_NAME];
    for (size_t i = 0; i < rows; i++) {
        count += !isnan(values[i]);
        squares += isnan(values[i]) ? 0 : values[i] * values[i];
    }
    if (count == 0 || !isfinite(squares)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "the column %s has %s; allowed: finite numbers, NaN where none is known",
                       e->names[of].text, count ? "what is not finite" : "no number");
    }
    ad_status status = equations_keep_formula(e, quantity_number(0), &kept, error);
    if (status == AD_OK) {
        kept->places = malloc(count * coordinates * sizeof *kept->places);
        kept->values = malloc(count * sizeof *kept->values);
        kept->of = of;
        kept->rows = count;
        kept->noise = noise > 0 ? noise : squares > 0 ? sqrt(squares / (double)count) : 1;
        if (!kept->places || !kept->values) {
            status = ad_fail(error, AD_NO_MEMORY, "out of memory for data");
        }
    }
    if (status != AD_OK) {
        return status;
    }
    for (size_t i = 0, to = 0; i < rows; i++) {
        if (!isnan(values[i])) {
            for (size_t c = 0; c < coordinates; c++) {
                kept->places[c * count + to] = places[c][i];
            }
            kept->values[to++] = values[i];
        }
    }
    const model_source source = {
        .rows = 1, .fill = fill_measured, .context = kept, .points = count};
    snprintf(text, sizeof text, "data %.20s", e->names[of].text);
    const int set = model_add_given(e->model, text, &source);
    model_add_term(e->model, text, set, 1, record_measured, kept);
    e->has_data = true;
    return equations_model_status(e, error);
}

static ad_status check_places(const domain_coordinate *c, size_t rows, const double *places,
                              ad_error *error)
{
    const double beyond = 1e-9 * (c->high - c->low);
    for (size_t i = 0; i < rows; i++) {
        if (!(places[i] >= c->low - beyond && places[i] <= c->high + beyond)) {
            return ad_fail(error, AD_BAD_INPUT, "row %zu has %s = %g; allowed: %g to %g", i + 1,
                           c->name, places[i], c->low, c->high);
        }
    }
    return AD_OK;
}

/* "error_u" of a field u, as solutions are written. */
static bool is_error(const equations *e, const char *text)
{
    const bool begins = strncmp(text, "error_", 6) == 0;
    const int of = begins ? equations_find_name(e, text + 6, strlen(text + 6)) : -1;
    return of >= 0 && e->names[of].kind == NAME_FIELD &&
           equations_find_name(e, text, strlen(text)) < 0;
}

ad_status equations_add_data(equations *e, size_t rows, int count, const char *const *names,
                             const double *const *columns, double noise, ad_error *error)
{
    const domain *d = &e->model->domain;
    const double *places[DOMAIN_COORDINATES_MAX] = {NULL};
    int of[MODEL_COLUMNS_MAX], measured = 0;
    char list[EQUATIONS_LIST_BYTES];
    ad_status status = equations_still_open(e, error);
    if (status == AD_OK && (rows < 1 || !(noise >= 0) || !isfinite(noise))) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%zu rows with noise %g; allowed: 1 row at least, noise 0 or more", rows,
                         noise);
    }
    for (int i = 0; i < count && status == AD_OK; i++) {
        const int coordinate = domain_find(d, names[i]);
        if (is_error(e, names[i])) {
            continue;
        }
        status = coordinate < 0
                     ? equations_know_words(e, names[i], error)
                     : check_places(&d->coordinates[coordinate], rows, columns[i], error);
        const int known = equations_find_name(e, names[i], strlen(names[i]));
        if (coordinate >= 0) {
            places[coordinate] = columns[i];
        } else if (status == AD_OK && known >= 0 && e->names[known].kind == NAME_FIELD &&
                   measured < MODEL_COLUMNS_MAX) {
            of[measured++] = i;
        } else if (status == AD_OK) {
            status = ad_fail(
                error, AD_BAD_INPUT,
                "the column '%.40s' is nothing of the model; allowed: %s, and "
                "derivatives of fields",
                names[i], equations_list_names(e, NAME_COORDINATE | NAME_RANGE | NAME_FIELD, list));
        }
    }
    for (int i = 0; i < d->count && status == AD_OK; i++) {
        if (!places[i]) {
            status =
                ad_fail(error, AD_BAD_INPUT, "there is no column %s; needed: one of each of %s",
                        d->coordinates[i].name,
                        equations_list_names(e, NAME_COORDINATE | NAME_RANGE, list));
        }
    }
    if (status == AD_OK && measured == 0) {
        status = ad_fail(error, AD_BAD_INPUT, "there is no column of a field; needed: one of %s",
                         equations_list_names(e, NAME_FIELD, list));
    }
    for (int i = 0; i < measured && status == AD_OK; i++) {
        status = add_measured(e, equations_find_name(e, names[of[i]], strlen(names[of[i]])), rows,
                              places, columns[of[i]], noise, error);
    }
    return status;
}
