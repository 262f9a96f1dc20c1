/* Solutions of equations of one's own: made, kept, read and evaluated.
 *
 * A file is a checkpoint (tools/files/checkpoint.h) with the items
 *   fit/coordinates   table, a column for each: low, high, kind (axis_kind)
 *   fit/units         text, a line for each of them
 *   fit/fields        table, a column for each, of the number of its row
 *   fit/unknowns      table, a column for each: value, standard deviation; where there are some
 *   fit/numbers       doubles, as patches_write has them
 *   fit/tolerance     double
 *   verdict           text */
#include "tools/library/cpinn.h"

#include "autodiff/host.h"
#include "tools/config/config_equations.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef enum axis_kind { AXIS_COORDINATE, AXIS_PERIODIC, AXIS_TIME, AXIS_RANGE } axis_kind;

enum { FIT_BYTES = 64 };

struct cpinn_fit {
    equations *equations;   /* borrowed or one of these: */
    config_equations *file; /* NULL: of no file */
    equations *own;         /* NULL; of a solution that was read */
    const physics_model *model;
    patches *patches;
    double tolerance;
    verdict verdict;
};

void cpinn_fit_free(cpinn_fit *fit)
{
    if (fit) {
        patches_free(fit->patches);
        equations_free(fit->own);
        config_equations_free(fit->file);
        free(fit);
    }
}

const verdict *cpinn_fit_verdict(const cpinn_fit *fit)
{
    return &fit->verdict;
}

const physics_model *cpinn_fit_model(const cpinn_fit *fit)
{
    return fit->model;
}

const char *cpinn_fit_coordinate(const cpinn_fit *fit, int index)
{
    const domain *d = &fit->model->domain;
    return index >= 0 && index < d->count ? d->coordinates[index].name : NULL;
}

const char *cpinn_fit_field(const cpinn_fit *fit, int index)
{
    return index >= 0 && index < fit->model->field_count ? fit->model->symbols[index] : NULL;
}

const char *cpinn_fit_unknown(const cpinn_fit *fit, int index)
{
    const physics_model *m = fit->model;
    return index >= 0 && index < m->own_unknown_count ? m->own_unknowns[index].name : NULL;
}

double cpinn_fit_tolerance(const cpinn_fit *fit)
{
    return fit->tolerance;
}

patches_summary cpinn_fit_summary(const cpinn_fit *fit)
{
    return patches_summarize(fit->patches);
}

/* ---- making ---------------------------------------------------------------------------------- */

static void judge(cpinn_fit *fit)
{
    const patches_summary s = patches_summarize(fit->patches);
    const bool whole = s.done >= 1;
    const int percent = (int)(100 * s.done);
    if (s.end == PATCHES_STOPPED) {
        verdict_add(&fit->verdict, VERDICT_UNFINISHED, "it was asked to stop at %d %% of the time",
                    percent);
    } else if (s.end == PATCHES_TIME_OVER && !whole) {
        verdict_add(&fit->verdict, VERDICT_TIME_LIMIT,
                    "after %.3g s it has come to %d %% of the time; give it more seconds, or a "
                    "larger tolerance",
                    s.seconds, percent);
    } else if (s.end == PATCHES_DIVERGED) {
        verdict_add(&fit->verdict, whole ? VERDICT_NOT_CONVERGED : VERDICT_UNFINISHED,
                    "steps found no solution beyond %d %% of the time; look whether there is one",
                    percent);
    } else if (s.end != PATCHES_CONVERGED) {
        verdict_add(&fit->verdict, VERDICT_ESTIMATE_ABOVE_TOLERANCE,
                    "the estimated error %.1e is above the tolerance %.1e: %s", s.estimate,
                    fit->tolerance,
                    s.end == PATCHES_TIME_OVER ? "the time was over"
                                               : "finer patches did not lower it enough");
    }
}

static ad_status make(cpinn_fit **fit, ad_error *error)
{
    *fit = calloc(1, sizeof **fit);
    return *fit ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a fit");
}

static ad_status hand_over(cpinn_fit *made, ad_status status, cpinn_fit **fit)
{
    if (status != AD_OK) {
        cpinn_fit_free(made);
    }
    *fit = status == AD_OK ? made : NULL;
    return status;
}

/* Solves what `fit` has been made of. */
static ad_status solve(cpinn_fit *fit, double seconds, const cpinn_fit_options *options,
                       ad_error *error)
{
    ad_pool *pool;
    ad_status status = ad_pool_open(options->threads, &pool, error);
    if (status != AD_OK) {
        return status;
    }
    const patches_settings settings = {.tolerance = fit->tolerance,
                                       .seconds = seconds,
                                       .pool = pool,
                                       .progress = options->progress,
                                       .context = options->context};
    status = patches_fit(fit->model, &settings, &fit->patches, error);
    ad_pool_free(pool);
    if (status == AD_OK) {
        judge(fit);
    }
    return status;
}

static const cpinn_fit_options *options_or(const cpinn_fit_options *options)
{
    static const cpinn_fit_options usual = {0};
    return options ? options : &usual;
}

ad_status cpinn_fit_equations(equations *e, const cpinn_fit_options *options, cpinn_fit **fit,
                              ad_error *error)
{
    AD_LEAVE_HOST;
    const cpinn_fit_options *o = options_or(options);
    cpinn_fit *made;
    *fit = NULL;
    ad_status status = make(&made, error);
    if (status == AD_OK) {
        made->equations = e;
        made->tolerance = o->tolerance > 0 ? o->tolerance : CONFIG_FIT_TOLERANCE;
        status = equations_model(e, &made->model, error);
        status = status == AD_OK
                     ? solve(made, o->seconds > 0 ? o->seconds : CONFIG_FIT_SECONDS, o, error)
                     : status;
        status = hand_over(made, status, fit);
    }
    return status;
}

ad_status cpinn_fit_file(const char *path, int count, const char *const *overrides,
                         const cpinn_fit_options *options, cpinn_fit **fit, ad_error *error)
{
    AD_LEAVE_HOST;
    const cpinn_fit_options *o = options_or(options);
    cpinn_fit *made;
    *fit = NULL;
    ad_status status = make(&made, error);
    if (status != AD_OK) {
        return status;
    }
    status = config_equations_read(path, NULL, count, overrides, &made->file, error);
    if (status == AD_OK) {
        made->equations = made->file->equations;
        made->model = made->file->model;
        made->tolerance = o->tolerance > 0 ? o->tolerance : made->file->tolerance;
        status = solve(made, o->seconds > 0 ? o->seconds : made->file->seconds, o, error);
    }
    return hand_over(made, status, fit);
}

/* ---- evaluating ------------------------------------------------------------------------------ */

/* Places within a range, to rounding: *inside [count], where some are not exactly, else `x`. */
static ad_status bring_inside(const domain_coordinate *c, size_t count, const double *x,
                              double **made, const double **inside, ad_error *error)
{
    const double slack = EVALUATOR_BEYOND * (c->high - c->low);
    bool exact = true;
    *inside = x;
    for (size_t i = 0; i < count && !c->periodic; i++) {
        if (x[i] < c->low - slack || x[i] > c->high + slack) {
            return ad_fail(error, AD_BAD_INPUT, "%s is %g; allowed: %g to %g", c->name, x[i],
                           c->low, c->high);
        }
        exact = exact && x[i] >= c->low && x[i] <= c->high;
    }
    if (!exact) {
        *inside = *made = malloc(count * sizeof **made);
        if (!*made) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory for places");
        }
        for (size_t i = 0; i < count; i++) {
            (*made)[i] = x[i] < c->low ? c->low : x[i] > c->high ? c->high : x[i];
        }
    }
    return AD_OK;
}

ad_status cpinn_fit_evaluate(const cpinn_fit *fit, const char *name, size_t count,
                             const double *const *x, double *values, double *errors,
                             ad_error *error)
{
    AD_LEAVE_HOST;
    int field = 0, orders[DOMAIN_COORDINATES_MAX];
    double *made[DOMAIN_COORDINATES_MAX] = {NULL};
    const double *places[DOMAIN_COORDINATES_MAX];
    const domain *d = &fit->model->domain;
    ad_status status = equations_find(fit->equations, name, &field, orders, error);
    for (int i = 0; i < d->count && status == AD_OK; i++) {
        status = bring_inside(&d->coordinates[i], count, x[i], &made[i], &places[i], error);
    }
    if (status == AD_OK) {
        patches_evaluate(fit->patches, field, orders, count, places, values, errors);
    }
    for (int i = 0; i < d->count; i++) {
        free(made[i]);
    }
    return status;
}

/* ---- keeping --------------------------------------------------------------------------------- */

static axis_kind kind_of(const cpinn_fit *fit, int coordinate)
{
    const domain *d = &fit->model->domain;
    return equations_is_range(fit->equations, coordinate) ? AXIS_RANGE
           : coordinate == d->time                        ? AXIS_TIME
           : d->coordinates[coordinate].periodic          ? AXIS_PERIODIC
                                                          : AXIS_COORDINATE;
}

/* What checkpoints borrow until they are written. */
typedef struct kept {
    double coordinates[3 * DOMAIN_COORDINATES_MAX], fields[MODEL_FIELDS_MAX];
    double unknowns[2 * MODEL_UNKNOWNS_MAX];
    const char *names[DOMAIN_COORDINATES_MAX], *symbols[MODEL_FIELDS_MAX];
    const char *unknown[MODEL_UNKNOWNS_MAX];
    char units[DOMAIN_COORDINATES_MAX * FIT_BYTES];
    double *numbers;
} kept;

static void put_names(checkpoint *file, const cpinn_fit *fit, kept *k)
{
    const physics_model *m = fit->model;
    const size_t coordinates = (size_t)m->domain.count, fields = (size_t)m->field_count,
                 unknowns = (size_t)m->own_unknown_count;
    const patches_summary s = patches_summarize(fit->patches);
    for (size_t i = 0; i < coordinates; i++) {
        const domain_coordinate *c = &m->domain.coordinates[i];
        const size_t used = strlen(k->units);
        k->names[i] = c->name;
        k->coordinates[i] = c->low;
        k->coordinates[coordinates + i] = c->high;
        k->coordinates[2 * coordinates + i] = kind_of(fit, (int)i);
        snprintf(k->units + used, sizeof k->units - used, "%.40s\n", c->unit);
    }
    for (size_t i = 0; i < fields; i++) {
        k->symbols[i] = m->symbols[i];
        k->fields[i] = (double)i;
    }
    for (size_t i = 0; i < unknowns; i++) {
        k->unknown[i] = m->own_unknowns[i].name;
        k->unknowns[i] = s.unknown[i];
        k->unknowns[unknowns + i] = s.deviation[i];
    }
    checkpoint_put_table(file, "fit/coordinates", k->coordinates, 3, coordinates, k->names);
    checkpoint_put_text(file, "fit/units", k->units);
    checkpoint_put_table(file, "fit/fields", k->fields, 1, fields, k->symbols);
    if (unknowns > 0) {
        checkpoint_put_table(file, "fit/unknowns", k->unknowns, 2, unknowns, k->unknown);
    }
}

ad_status cpinn_fit_save(const cpinn_fit *fit, const char *path, ad_error *error)
{
    AD_LEAVE_HOST;
    kept k = {.units = ""};
    const size_t count = patches_numbers(fit->patches);
    const file_place place = {.path = path};
    checkpoint *file = checkpoint_create(CPINN_VERSION);
    ad_status status = AD_OK;
    k.numbers = malloc(count * sizeof *k.numbers);
    if (!file || !k.numbers) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for %s", path);
    } else {
        patches_write(fit->patches, k.numbers);
        put_names(file, fit, &k);
        checkpoint_put_doubles(file, "fit/numbers", k.numbers, 1, &count);
        checkpoint_put_double(file, "fit/tolerance", fit->tolerance);
        report_put_verdict(file, &fit->verdict);
        status = checkpoint_write(file, &place, error);
    }
    checkpoint_free(file);
    free(k.numbers);
    return status;
}

/* ---- reading --------------------------------------------------------------------------------- */

/* The columns of a table of `rows`, whose numbers [rows][columns] it fills in; `most` columns. */
static ad_status get_table(const checkpoint *file, const char *item, size_t rows, size_t most,
                           double *numbers, size_t *columns, ad_error *error)
{
    int rank = 0;
    size_t shape[CHECKPOINT_MAX_RANK] = {0};
    if (!checkpoint_shape(file, item, &rank, shape) || rank != 2 || shape[0] != rows ||
        shape[1] < 1 || shape[1] > most || !checkpoint_column(file, item, 0)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%s is missing or no such table; allowed: files of cpinn-fit --save", item);
    }
    *columns = shape[1];
    return checkpoint_get_doubles(file, item, numbers, rows * shape[1], error);
}

static ad_status read_coordinates(const checkpoint *file, equations *e, ad_error *error)
{
    double numbers[3 * DOMAIN_COORDINATES_MAX];
    const char *units;
    size_t count;
    ad_status status =
        get_table(file, "fit/coordinates", 3, DOMAIN_COORDINATES_MAX, numbers, &count, error);
    status = status == AD_OK ? checkpoint_get_text(file, "fit/units", &units, error) : status;
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        const double low = numbers[i], high = numbers[count + i], kind = numbers[2 * count + i];
        const char *name = checkpoint_column(file, "fit/coordinates", i);
        char unit[FIT_BYTES];
        const size_t length = strcspn(units, "\n");
        snprintf(unit, sizeof unit, "%.*s", (int)(length < FIT_BYTES ? length : 0), units);
        units += length + (units[length] == '\n');
        const equations_coordinate c = {
            name, unit, low, high, kind == AXIS_PERIODIC, kind == AXIS_TIME};
        status = kind == AXIS_RANGE ? equations_add_range(e, name, low, high, error)
                                    : equations_add_coordinate(e, &c, error);
    }
    return status;
}

static ad_status read_names(const checkpoint *file, equations *e, ad_error *error)
{
    double numbers[2 * MODEL_UNKNOWNS_MAX + MODEL_FIELDS_MAX];
    size_t count = 0;
    ad_status status = read_coordinates(file, e, error);
    if (status == AD_OK) {
        status = get_table(file, "fit/fields", 1, MODEL_FIELDS_MAX, numbers, &count, error);
    }
    for (size_t i = 0; i < count && status == AD_OK; i++) {
        status = equations_add_field(e, checkpoint_column(file, "fit/fields", i), error);
    }
    if (status == AD_OK && checkpoint_has(file, "fit/unknowns")) {
        status = get_table(file, "fit/unknowns", 2, MODEL_UNKNOWNS_MAX, numbers, &count, error);
        for (size_t i = 0; i < count && status == AD_OK; i++) {
            status = equations_add_unknown(e, checkpoint_column(file, "fit/unknowns", i),
                                           numbers[i], error);
        }
    }
    return status;
}

static ad_status read_numbers(const checkpoint *file, cpinn_fit *fit, ad_error *error)
{
    int rank = 0;
    size_t shape[CHECKPOINT_MAX_RANK] = {0};
    if (!checkpoint_shape(file, "fit/numbers", &rank, shape) || rank != 1) {
        return ad_fail(error, AD_BAD_INPUT, "fit/numbers is missing");
    }
    double *numbers = malloc((shape[0] ? shape[0] : 1) * sizeof *numbers);
    ad_status status = numbers ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a fit");
    if (status == AD_OK) {
        status = checkpoint_get_doubles(file, "fit/numbers", numbers, shape[0], error);
    }
    if (status == AD_OK) {
        status = patches_read(fit->model, shape[0], numbers, &fit->patches, error);
    }
    if (status == AD_OK) {
        status = checkpoint_get_doubles(file, "fit/tolerance", &fit->tolerance, 1, error);
    }
    free(numbers);
    return status == AD_OK ? report_get_verdict(file, &fit->verdict, error) : status;
}

ad_status cpinn_fit_open(const char *path, cpinn_fit **fit, ad_error *error)
{
    AD_LEAVE_HOST;
    checkpoint *file = NULL;
    cpinn_fit *made;
    ad_error why;
    *fit = NULL;
    ad_status status = make(&made, error);
    if (status != AD_OK) {
        return status;
    }
    status = checkpoint_open(path, &file, error);
    if (status == AD_OK) {
        made->equations = made->own = equations_create();
        status = made->own ? read_names(file, made->own, &why)
                           : ad_fail(&why, AD_NO_MEMORY, "out of memory for a fit");
        made->model = made->own ? equations_so_far(made->own) : NULL;
        status = status == AD_OK ? read_numbers(file, made, &why) : status;
        if (status != AD_OK) {
            ad_fail(error, status, "%.200s: %s", path, why.message);
        }
    }
    checkpoint_free(file);
    return hand_over(made, status, fit);
}
