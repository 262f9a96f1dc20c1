/* What is exported: evaluators of a run, and points at which they are compared with the C. */
#include "tools/emit/export_model.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SCATTERED = 24, NOTABLE_MAX = 2 * (DOMAIN_PIECES_MAX + DOMAIN_WINDOWS_MAX) + 4 };

void export_model_free(export_model *x)
{
    evaluator_free(x->values);
    evaluator_free(x->jacobian);
    experiment_free(x->e);
    free(x->family_numbers);
    free(x->at);
    free(x->beyond);
}

/* ---- evaluators ------------------------------------------------------------------------------ */

static ad_status make_evaluators(export_model *x, const char *columns, ad_error *error)
{
    const experiment *e = x->e;
    const domain *d = &e->model->domain;
    const evaluator_model trained = experiment_trained(e);
    ad_status status = evaluator_create(&trained, columns, &x->values, error);
    if (status == AD_OK) {
        status = evaluator_create_jacobian(&trained, columns, &x->jacobian, error);
    }
    if (status != AD_OK) {
        return status;
    }
    x->inputs = d->count;
    x->outputs = evaluator_columns(x->values);
    for (int i = 0; i < d->count; i++) {
        const domain_coordinate *c = &d->coordinates[i];
        double high = i == d->time ? domain_window_time(d, e->window + 1) : c->high;
        x->lower[i] = c->low * c->scale;
        x->upper[i] = high * c->scale;
        if (x->single) {
            x->lower[i] = (double)(float)x->lower[i];
            x->upper[i] = (double)(float)x->upper[i];
        }
    }
    x->hash = checkpoint_hash(CHECKPOINT_HASH_START, e->parameters,
                              (size_t)trained.windows * e->count * sizeof *e->parameters);
    return AD_OK;
}

/* ---- points --------------------------------------------------------------------------------- */

/* Values of a coordinate where something begins or ends, and between them; in units of its scale.
 * Single precision cannot tell on which side of an inner one a point lies. */
static int list_notable(const export_model *x, int coordinate, double *list)
{
    const domain *d = &x->e->model->domain;
    bool is_time = coordinate == d->time;
    int parts = is_time ? x->e->window + 1 : coordinate == 0 ? domain_pieces(d) : 1, count = 0;
    for (int k = 0; k < parts; k++) {
        double low = d->coordinates[coordinate].low, high = d->coordinates[coordinate].high;
        if (is_time) {
            low = domain_window_time(d, k);
            high = domain_window_time(d, k + 1);
        } else if (coordinate == 0) {
            domain_piece(d, k, &low, &high);
        }
        if (k == 0 || !x->single) {
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
static double scattered(const export_model *x, int coordinate, size_t number)
{
    const double step = coordinate == 0 ? 0.7548776662466927 : 0.5698402909980532;
    double part = fmod(0.5 + step * (double)(number + 1), 1);
    return x->lower[coordinate] + part * (x->upper[coordinate] - x->lower[coordinate]);
}

static double *next_point(export_model *x)
{
    double *point = x->at + x->points * (size_t)x->inputs;
    for (int i = 0; i < x->inputs; i++) {
        point[i] = scattered(x, i, x->points);
    }
    x->points++;
    return point;
}

static void list_points(export_model *x)
{
    double notable[NOTABLE_MAX];
    for (int i = 0; i < x->inputs; i++) {
        int count = list_notable(x, i, notable);
        for (int k = 0; k < count; k++) {
            next_point(x)[i] = notable[k] * x->e->model->domain.coordinates[i].scale;
        }
        double range = x->upper[i] - x->lower[i];
        x->beyond[x->points] = x->beyond[x->points + 1] = true;
        next_point(x)[i] = x->lower[i] - 0.1 * range;
        next_point(x)[i] = x->upper[i] + 0.1 * range;
    }
    memcpy(next_point(x), x->lower, (size_t)x->inputs * sizeof *x->at);
    memcpy(next_point(x), x->upper, (size_t)x->inputs * sizeof *x->at);
    for (int k = 0; k < SCATTERED; k++) {
        next_point(x);
    }
    for (size_t k = 0; x->single && k < x->points * (size_t)x->inputs; k++) {
        x->at[k] = (double)(float)x->at[k];
    }
}

/* Inputs as the evaluator takes them [inputs][points], within their ranges. */
static void list_clamped(const export_model *x, double *list, const double **at)
{
    for (int i = 0; i < x->inputs; i++) {
        at[i] = list + (size_t)i * x->points;
        for (size_t k = 0; k < x->points; k++) {
            double value = x->at[k * (size_t)x->inputs + (size_t)i];
            list[(size_t)i * x->points + k] = fmin(fmax(value, x->lower[i]), x->upper[i]);
        }
    }
}

static double largest_of(const export_model *x, int column)
{
    double result = 0;
    for (size_t k = 0; k < x->points; k++) {
        result = fmax(result, fabs(x->expected[(size_t)column * x->points + k]));
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
static void set_scales(export_model *x)
{
    const domain *d = &x->e->model->domain;
    int columns = evaluator_columns(x->jacobian);
    for (int c = 0; c < columns; c++) {
        int derived = c - x->outputs, of = derived < 0 ? c : derived / x->inputs;
        x->scale[c] = export_natural_scale(x->e->scene, evaluator_column_unit(x->values, of)) /
                      (derived < 0 ? 1 : d->coordinates[derived % x->inputs].scale);
        for (int other = 0; other < columns; other++) {
            if (strcmp(evaluator_column_unit(x->jacobian, c),
                       evaluator_column_unit(x->jacobian, other)) == 0) {
                x->scale[c] = fmax(x->scale[c], largest_of(x, other));
            }
        }
    }
}

/* What rounding may change is measured; the formulas around the networks, arguments of sin and cos
 * and sums in another order have more roundings than the networks have numbers, hence the factor.
 */
static void set_tolerances(export_model *x, const double *change)
{
    const double unit = x->single ? (double)FLT_EPSILON : DBL_EPSILON, factor = 16, floor = 64;
    for (int c = 0; c < evaluator_columns(x->jacobian); c++) {
        x->tolerance[c] = factor * change[c] * (unit / DBL_EPSILON) + floor * unit * x->scale[c];
    }
}

static ad_status make_points(export_model *x, ad_error *error)
{
    const domain *d = &x->e->model->domain;
    size_t inputs = (size_t)x->inputs, columns = (size_t)x->outputs * (1 + inputs);
    size_t most = 2 * (size_t)(domain_pieces(d) + x->e->window + 1) + 6 * inputs + 2 + SCATTERED;
    const double *at[DOMAIN_COORDINATES_MAX];
    double *clamped = malloc((most * inputs + columns) * sizeof *clamped);
    double *change = clamped ? clamped + most * inputs : NULL;
    x->at = calloc(most * (inputs + columns) + 2 * columns, sizeof *x->at);
    x->beyond = calloc(most, sizeof *x->beyond);
    if (!clamped || !x->at || !x->beyond) {
        free(clamped);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the points of a self-test");
    }
    x->expected = x->at + most * inputs;
    x->scale = x->expected + most * columns;
    x->tolerance = x->scale + columns;
    list_points(x);
    list_clamped(x, clamped, at);
    ad_status status = evaluator_evaluate_at(x->jacobian, x->points, at, x->expected, error);
    for (size_t i = 0; status == AD_OK && i < columns * x->points; i++) {
        if (!isfinite(x->expected[i])) {
            status = ad_fail(error, AD_NOT_FINITE, "%s: the network has values that are not finite",
                             x->run);
        }
    }
    if (status == AD_OK) {
        status = evaluator_rounding(x->jacobian, x->points, at, change, error);
    }
    if (status == AD_OK) {
        set_scales(x);
        set_tolerances(x, change);
    }
    free(clamped);
    return status;
}

ad_status export_model_prepare(export_model *x, const char *columns, ad_error *error)
{
    ad_status status = make_evaluators(x, columns, error);
    return status == AD_OK ? make_points(x, error) : status;
}
