#include "tools/programs/equation_places.h"

#include "tools/programs/cli.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static ad_status make(equation_places *p, const physics_model *m, size_t count, ad_error *error)
{
    const size_t coordinates = m->domain.count > 0 ? (size_t)m->domain.count : 1;
    *p = (equation_places){.model = m, .count = count};
    double *numbers = calloc((count ? count : 1) * coordinates, sizeof *numbers);
    if (!numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for points");
    }
    for (size_t i = 0; i < coordinates; i++) {
        p->x[i] = numbers + i * count;
    }
    return AD_OK;
}

void equation_places_free(equation_places *p)
{
    free(p->x[0]);
    p->x[0] = NULL;
}

/* Points along each coordinate; false: the text is no such grid. */
static bool read_grid(const char *text, int coordinates, size_t *along)
{
    static const size_t usual[] = {0, 201, 101, 41};
    for (int i = 0; i < coordinates; i++) {
        char *end = NULL;
        const long count =
            text ? strtol(text, &end, 10) : (long)(coordinates < 4 ? usual[coordinates] : 13);
        if (count < 1 || (text && (end == text || *end != (i + 1 < coordinates ? 'x' : '\0')))) {
            return false;
        }
        along[i] = (size_t)count;
        text = text ? end + 1 : NULL;
    }
    return true;
}

ad_status equation_places_grid(equation_places *p, const physics_model *m, const char *grid,
                               ad_error *error)
{
    const domain *d = &m->domain;
    size_t along[DOMAIN_COORDINATES_MAX], count = 1;
    bool good = read_grid(grid, d->count, along);
    for (int i = 0; i < d->count && good; i++) {
        good = along[i] <= CLI_GRID_MAX / count;
        count *= good ? along[i] : 1;
    }
    if (!good) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "--grid %.40s; allowed: %d numbers of points, as in %s, %d points in all",
                       grid, d->count,
                       d->count == 1   ? "201"
                       : d->count == 2 ? "101x51"
                                       : "41x41x21",
                       CLI_GRID_MAX);
    }
    ad_status status = make(p, m, count, error);
    for (size_t k = 0; k < count && status == AD_OK; k++) {
        size_t rest = k;
        for (int i = d->count - 1; i >= 0; rest /= along[i--]) {
            const domain_coordinate *c = &d->coordinates[i];
            const size_t steps = along[i] > 1 ? along[i] - 1 : 1, step = rest % along[i];
            p->x[i][k] = step == steps ? c->high
                                       : c->low + (c->high - c->low) * (double)step / (double)steps;
        }
    }
    return status;
}

static ad_status check_range(const domain_coordinate *c, const table_file *table,
                             const double *column, const char *path, ad_error *error)
{
    const double slack = EVALUATOR_BEYOND * (c->high - c->low);
    for (size_t i = 0; i < table_rows(table); i++) {
        if (!(column[i] >= c->low - slack && column[i] <= c->high + slack)) {
            return ad_fail(error, AD_BAD_INPUT, "%.200s: row %zu has %s = %g; allowed: %g to %g",
                           path, i + 1, c->name, column[i], c->low, c->high);
        }
    }
    return AD_OK;
}

ad_status equation_places_read(equation_places *p, const physics_model *m, const table_file *table,
                               const char *path, ad_error *error)
{
    const domain *d = &m->domain;
    ad_status status = make(p, m, table_rows(table), error);
    for (int i = 0; i < d->count && status == AD_OK; i++) {
        const double *column = table_column(table, d->coordinates[i].name);
        if (!column) {
            status = ad_fail(error, AD_BAD_INPUT,
                             "%.200s: has no column %s; needed: one of each coordinate", path,
                             d->coordinates[i].name);
        } else {
            memcpy(p->x[i], column, p->count * sizeof *column);
            status = check_range(&d->coordinates[i], table, column, path, error);
        }
    }
    return status;
}

ad_status equation_places_write(const equation_places *p, const cpinn_fit *fit, const char *path,
                                ad_error *error)
{
    const physics_model *m = p->model;
    char names[MODEL_FIELDS_MAX][TABLE_MAX_NAME + 1];
    const size_t fields = (size_t)m->field_count;
    table_build *table = malloc(sizeof *table);
    double *values = malloc(2 * fields * (p->count ? p->count : 1) * sizeof *values);
    ad_status status =
        table && values ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a table");
    if (status == AD_OK) {
        table_begin(table, p->count);
        for (int i = 0; i < m->domain.count; i++) {
            table_add(table, m->domain.coordinates[i].name, m->domain.coordinates[i].unit, p->x[i],
                      NULL);
        }
    }
    for (size_t i = 0; i < fields && status == AD_OK; i++) {
        double *here = values + i * p->count, *errors = here + fields * p->count;
        status = cpinn_fit_evaluate(fit, m->symbols[i], p->count, (const double *const *)p->x, here,
                                    errors, error);
        table_add(table, m->symbols[i], "", here, NULL);
    }
    for (size_t i = 0; i < fields && status == AD_OK; i++) {
        snprintf(names[i], sizeof names[i], "error_%s", m->symbols[i]);
        table_add(table, names[i], "", values + (fields + i) * p->count, NULL);
    }
    status = status == AD_OK ? table_write(path, &table->table, error) : status;
    free(values);
    free(table);
    return status;
}

/* Of one field, where both are known. */
static ad_status compare_field(const equation_places *p, const cpinn_fit *fit, const char *field,
                               const double *known, double *values, equation_difference *worst,
                               ad_error *error)
{
    double squares = 0, off = 0, largest = 0;
    size_t count = 0;
    ad_status status =
        cpinn_fit_evaluate(fit, field, p->count, (const double *const *)p->x, values, NULL, error);
    for (size_t i = 0; i < p->count && status == AD_OK; i++) {
        const double difference = fabs(values[i] - known[i]);
        if (!isnan(difference)) {
            count++;
            squares += known[i] * known[i];
            off += difference * difference;
            largest = fmax(largest, difference);
        }
    }
    const double relative = squares > 0 ? sqrt(off / squares) : sqrt(off);
    if (status == AD_OK && count > 0 && !(relative <= worst->relative)) {
        const double size = squares > 0 ? sqrt(squares / (double)count) : 1;
        *worst = (equation_difference){count, relative, largest / size, field};
    }
    return status;
}

ad_status equation_reference_open(const char *path, const physics_model *m,
                                  equation_reference *known, ad_error *error)
{
    bool any = false;
    *known = (equation_reference){.path = path};
    ad_status status = table_read(path, TABLE_NONFINITE, &known->table, error);
    if (status == AD_OK) {
        status = equation_places_read(&known->at, m, known->table, path, error);
    }
    for (int i = 0; i < m->field_count && status == AD_OK; i++) {
        any = any || table_column(known->table, m->symbols[i]);
    }
    return status != AD_OK || any ? status
                                  : ad_fail(error, AD_BAD_INPUT,
                                            "%.200s: has no column of a field; needed: a column %s",
                                            path, m->symbols[0]);
}

void equation_reference_free(equation_reference *known)
{
    equation_places_free(&known->at);
    table_free(known->table);
    known->table = NULL;
}

ad_status equation_reference_compare(const equation_reference *known, const cpinn_fit *fit,
                                     equation_difference *difference, ad_error *error)
{
    const physics_model *m = cpinn_fit_model(fit);
    double *values = malloc((known->at.count ? known->at.count : 1) * sizeof *values);
    ad_status status =
        values ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a reference");
    *difference = (equation_difference){.relative = -1};
    for (int i = 0; i < m->field_count && status == AD_OK; i++) {
        const double *column = table_column(known->table, m->symbols[i]);
        status = column ? compare_field(&known->at, fit, m->symbols[i], column, values, difference,
                                        error)
                        : AD_OK;
    }
    free(values);
    return status;
}
