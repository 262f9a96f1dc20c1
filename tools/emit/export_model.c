/* What is exported: evaluators of a run, and points at which they are compared with the C. */
#include "tools/emit/export_model.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SCATTERED = 24, NOTABLE_MAX = 2 * (DOMAIN_PIECES_MAX + DOMAIN_WINDOWS_MAX) + 4 };

void export_model_free(export_model *model)
{
    evaluator_free(model->values);
    evaluator_free(model->jacobian);
    experiment_free(model->e);
    free(model->family_numbers);
    free(model->at);
    free(model->beyond);
}

/* ---- evaluators ------------------------------------------------------------------------------ */

static ad_status make_evaluators(export_model *model, const char *columns, ad_error *error)
{
    const experiment *e = model->e;
    const domain *d = &e->model->domain;
    const evaluator_model trained = experiment_trained(e);
    ad_status status = evaluator_create(&trained, columns, &model->values, error);
    if (status == AD_OK) {
        status = evaluator_create_jacobian(&trained, columns, &model->jacobian, error);
    }
    if (status != AD_OK) {
        return status;
    }
    model->inputs = d->count;
    model->outputs = evaluator_columns(model->values);
    for (int i = 0; i < d->count; i++) {
        const domain_coordinate *c = &d->coordinates[i];
        double high = i == d->time ? domain_window_time(d, e->window + 1) : c->high;
        model->lower[i] = c->low * c->scale;
        model->upper[i] = high * c->scale;
        if (model->single) {
            model->lower[i] = (double)(float)model->lower[i];
            model->upper[i] = (double)(float)model->upper[i];
        }
    }
    model->hash = checkpoint_hash(CHECKPOINT_HASH_START, e->parameters,
                                  (size_t)trained.windows * e->count * sizeof *e->parameters);
    return AD_OK;
}

/* ---- points --------------------------------------------------------------------------------- */

/* Values of a coordinate where something begins or ends, and between them; in units of its scale.
 * Single precision cannot tell on which side of an inner one a point lies. */
static int list_notable(const export_model *model, int coordinate, double *list)
{
    const domain *d = &model->e->model->domain;
    bool is_time = coordinate == d->time;
    int parts = is_time ? model->e->window + 1 : coordinate == 0 ? domain_pieces(d) : 1, count = 0;
    for (int k = 0; k < parts; k++) {
        double low = d->coordinates[coordinate].low, high = d->coordinates[coordinate].high;
        if (is_time) {
            low = domain_window_time(d, k);
            high = domain_window_time(d, k + 1);
        } else if (coordinate == 0) {
            domain_piece(d, k, &low, &high);
        }
        if (k == 0 || !model->single) {
            list[count++] = low;
        }
        list[count++] = low + 0.37 * (high - low);
        if (k == parts - 1) {
            list[count++] = high;
        }
    }
    return count;
}

/* Somewhere in the range, the same every time (the plastic number's sequence). */
static double scattered(const export_model *model, int coordinate, size_t number)
{
    const double step = coordinate == 0 ? 0.7548776662466927 : 0.5698402909980532;
    double part = fmod(0.5 + step * (double)(number + 1), 1);
    return model->lower[coordinate] + part * (model->upper[coordinate] - model->lower[coordinate]);
}

static double *next_point(export_model *model)
{
    double *point = model->at + model->points * (size_t)model->inputs;
    for (int i = 0; i < model->inputs; i++) {
        point[i] = scattered(model, i, model->points);
    }
    model->points++;
    return point;
}

static void list_points(export_model *model)
{
    double notable[NOTABLE_MAX];
    for (int i = 0; i < model->inputs; i++) {
        int count = list_notable(model, i, notable);
        for (int k = 0; k < count; k++) {
            next_point(model)[i] = notable[k] * model->e->model->domain.coordinates[i].scale;
        }
        double range = model->upper[i] - model->lower[i];
        model->beyond[model->points] = model->beyond[model->points + 1] = true;
        next_point(model)[i] = model->lower[i] - 0.1 * range;
        next_point(model)[i] = model->upper[i] + 0.1 * range;
    }
    memcpy(next_point(model), model->lower, (size_t)model->inputs * sizeof *model->at);
    memcpy(next_point(model), model->upper, (size_t)model->inputs * sizeof *model->at);
    for (int k = 0; k < SCATTERED; k++) {
        next_point(model);
    }
    for (size_t k = 0; model->single && k < model->points * (size_t)model->inputs; k++) {
        model->at[k] = (double)(float)model->at[k];
    }
}

/* Inputs as the evaluator takes them [inputs][points], within their ranges. */
static void list_clamped(const export_model *model, double *list, const double **at)
{
    for (int i = 0; i < model->inputs; i++) {
        at[i] = list + (size_t)i * model->points;
        for (size_t k = 0; k < model->points; k++) {
            double value = model->at[k * (size_t)model->inputs + (size_t)i];
            list[(size_t)i * model->points + k] =
                fmin(fmax(value, model->lower[i]), model->upper[i]);
        }
    }
}

static double largest_of(const export_model *model, int column)
{
    double result = 0;
    for (size_t k = 0; k < model->points; k++) {
        result = fmax(result, fabs(model->expected[(size_t)column * model->points + k]));
    }
    return result;
}

double export_natural_scale(const scene *of, const char *unit)
{
    scene middle;
    scene_middle(of, &middle);
    const rod_scales scales = rod_scales_of(&middle);
    const struct {
        const char *unit;
        double scale;
    } rows[] = {{"", 1},
                {"m", scales.length},
                {"1/m", 1 / scales.length},
                {"N", scales.force},
                {"N m", scales.moment}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows && !scene_is_beam(of); i++) {
        if (strcmp(unit, rows[i].unit) == 0) {
            return rows[i].scale;
        }
    }
    return 0;
}

/* The scale of a column is the largest value of all that have its unit, or what a rod has by
 * itself, EI/L^2 of a force: a force that is nothing but rounding is small beside these, not large
 * beside itself. */
static void set_scales(export_model *model)
{
    const domain *d = &model->e->model->domain;
    int columns = evaluator_columns(model->jacobian);
    for (int c = 0; c < columns; c++) {
        int derived = c - model->outputs, of = derived < 0 ? c : derived / model->inputs;
        model->scale[c] =
            export_natural_scale(model->e->scene, evaluator_column_unit(model->values, of)) /
            (derived < 0 ? 1 : d->coordinates[derived % model->inputs].scale);
        for (int other = 0; other < columns; other++) {
            if (strcmp(evaluator_column_unit(model->jacobian, c),
                       evaluator_column_unit(model->jacobian, other)) == 0) {
                model->scale[c] = fmax(model->scale[c], largest_of(model, other));
            }
        }
    }
}

/* What rounding may change is measured; the formulas around the networks, arguments of sin and cos
 * and sums in another order have more roundings than the networks have numbers, hence the factor.
 */
static void set_tolerances(export_model *model, const double *change)
{
    const double unit = model->single ? (double)FLT_EPSILON : DBL_EPSILON, factor = 16, floor = 64;
    for (int c = 0; c < evaluator_columns(model->jacobian); c++) {
        model->tolerance[c] =
            factor * change[c] * (unit / DBL_EPSILON) + floor * unit * model->scale[c];
    }
}

static ad_status make_points(export_model *model, ad_error *error)
{
    const domain *d = &model->e->model->domain;
    size_t inputs = (size_t)model->inputs, columns = (size_t)model->outputs * (1 + inputs);
    size_t most =
        2 * (size_t)(domain_pieces(d) + model->e->window + 1) + 6 * inputs + 2 + SCATTERED;
    const double *at[DOMAIN_COORDINATES_MAX];
    double *clamped = malloc((most * inputs + columns) * sizeof *clamped);
    double *change = clamped ? clamped + most * inputs : NULL;
    model->at = calloc(most * (inputs + columns) + 2 * columns, sizeof *model->at);
    model->beyond = calloc(most, sizeof *model->beyond);
    if (!clamped || !model->at || !model->beyond) {
        free(clamped);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the points of a self-test");
    }
    model->expected = model->at + most * inputs;
    model->scale = model->expected + most * columns;
    model->tolerance = model->scale + columns;
    list_points(model);
    list_clamped(model, clamped, at);
    ad_status status =
        evaluator_evaluate_at(model->jacobian, model->points, at, model->expected, error);
    for (size_t i = 0; status == AD_OK && i < columns * model->points; i++) {
        if (!isfinite(model->expected[i])) {
            status = ad_fail(error, AD_NOT_FINITE, "%s: the network has values that are not finite",
                             model->run);
        }
    }
    if (status == AD_OK) {
        status = evaluator_rounding(model->jacobian, model->points, at, change, error);
    }
    if (status == AD_OK) {
        set_scales(model);
        set_tolerances(model, change);
    }
    free(clamped);
    return status;
}

ad_status export_model_prepare(export_model *model, const char *columns, ad_error *error)
{
    ad_status status = make_evaluators(model, columns, error);
    return status == AD_OK ? make_points(model, error) : status;
}
