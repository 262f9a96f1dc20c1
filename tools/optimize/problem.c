/* The problem as IPOPT sees it: an objective and rows of constraints by variables z, with their
 * derivatives. */
#include "physics/numerics/vector_size.h"
#include "tools/optimize/descent.h"
#include "tools/optimize/optimize_parts.h"

#include "physics/chain/solve_members.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = SOLVE_MEMBERS_COLUMNS };

static size_t variables_of_case(const optimization *o)
{
    return (size_t)o->shared + (size_t)o->each;
}

/* The place among all variables of the k-th of a scenario's. */
static size_t variable_of(const optimization *o, size_t scenario, size_t k)
{
    return k < (size_t)o->shared ? k : k + o->scenario[scenario].of * (size_t)o->each;
}

/* Rows that a constraint has of a scenario. */
static size_t rows_of(const optimization *o, int constraint, size_t scenario)
{
    const optimize_constraint *c = &o->constraint[constraint];
    return c->by_shared && scenario > 0 ? 0 : c->rows;
}

static size_t top_of(const optimization *o, size_t scenario)
{
    return o->n - o->tops + (o->tops > 1 ? scenario : 0);
}

static bool resize(void *place, size_t count, size_t size)
{
    void **kept = place;
    void *more = realloc(*kept, (count + 1) * size);
    *kept = more ? more : *kept;
    return more != NULL;
}

ad_status optimize_shape(optimization *o, ad_error *error)
{
    const response_kind kind = response_kind_of(o->objective);
    const bool worst = o->settings->over == OPTIMIZE_WORST || o->settings->box_count > 0;
    const size_t P = (size_t)o->parameters, before = o->n - o->tops, members = o->scenarios;
    size_t most = response_rows(o->objective);
    o->tops = worst ? 1 : kind == RESPONSE_MAX || kind == RESPONSE_MIN ? members : 0;
    o->n = (size_t)o->shared + (size_t)o->each * o->cases.count + o->tops;
    o->m = o->tops > 0 ? members * most : 0;
    o->nonzeros = o->m * (variables_of_case(o) + 1);
    for (int i = 0; i < o->constraints; i++) {
        for (size_t e = 0; e < members; e++) {
            o->m += rows_of(o, i, e);
            o->nonzeros += rows_of(o, i, e) * variables_of_case(o);
        }
        most = o->constraint[i].rows > most ? o->constraint[i].rows : most;
    }
    const size_t shape = members * o->points * COLUMNS;
    const bool fits = resize(&o->x, o->n, sizeof *o->x) && resize(&o->at, o->n, sizeof *o->at) &&
                      resize(&o->gradient, o->n, sizeof *o->gradient) &&
                      resize(&o->row, o->m, sizeof *o->row) &&
                      resize(&o->multiplier, o->m, sizeof *o->multiplier) &&
                      resize(&o->by, o->nonzeros, sizeof *o->by) &&
                      resize(&o->given, members * P, sizeof *o->given) &&
                      resize(&o->shapes, shape, sizeof *o->shapes) &&
                      resize(&o->jacobians, shape * P, sizeof *o->jacobians) &&
                      resize(&o->margins, SOLVE_MARGINS * members, sizeof *o->margins) &&
                      resize(&o->by_margins, SOLVE_MARGINS * members * P, sizeof *o->by_margins) &&
                      resize(&o->is_solved, members, sizeof *o->is_solved) &&
                      resize(&o->objectives, members, sizeof *o->objectives) &&
                      resize(&o->values, most, sizeof *o->values) &&
                      resize(&o->partials, most * P, sizeof *o->partials);
    for (size_t i = before; i < o->n && fits; i++) {
        o->x[i] = 0.5;
    }
    o->known = false;
    return fits ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu members", members);
}

void optimize_given(const optimization *o, const double *x, size_t scenario, double *parameters)
{
    const optimize_scenario *at = &o->scenario[scenario];
    for (int p = 0; p < o->parameters; p++) {
        const scene_parameter *of = &o->family->parameters[p];
        const int i = o->index[p];
        const size_t each = (size_t)o->shared + at->of * (size_t)o->each + (size_t)i;
        switch (o->role[p]) {
        case OPTIMIZE_SHARED:
            parameters[p] = scene_parameter_at(of, x[i]);
            break;
        case OPTIMIZE_EACH:
            parameters[p] = scene_parameter_at(of, x[each]);
            break;
        case OPTIMIZE_CASE:
            parameters[p] = optimize_column(o, at->of, i);
            break;
        case OPTIMIZE_BOX:
            parameters[p] = at->box[i];
            break;
        }
    }
}

/* The derivatives of a row by the variables of its case, `to` [shared + each], added times a
 * factor. */
static void add_by_variables(const optimization *o, size_t scenario, const double *by_parameters,
                             double factor, double *shared, double *each)
{
    for (int p = 0; p < o->parameters; p++) {
        double *to = o->role[p] == OPTIMIZE_SHARED ? shared
                     : o->role[p] == OPTIMIZE_EACH ? each
                                                   : NULL;
        if (to) {
            const double value = o->given[scenario * (size_t)o->parameters + (size_t)p];
            to[o->index[p]] +=
                factor * by_parameters[p] * scene_parameter_slope(&o->family->parameters[p], value);
        }
    }
}

static ad_status evaluate(optimization *o, const response *r, size_t scenario)
{
    const size_t P = (size_t)o->parameters, shape = o->points * COLUMNS;
    const response_shape at = {.points = o->points,
                               .place = o->place,
                               .values = o->shapes + scenario * shape,
                               .jacobian = o->jacobians + scenario * shape * P,
                               .parameters = o->given + scenario * P,
                               .columns = o->cases.values +
                                          o->scenario[scenario].of * (size_t)o->cases.columns,
                               .margin = o->margins + SOLVE_MARGINS * scenario,
                               .by_margin = o->by_margins + SOLVE_MARGINS * scenario * P};
    return response_evaluate(r, &at, o->values, o->sloped ? o->partials : NULL, &o->why);
}

/* The rows of a formula, times `factor`, and where they are known their derivatives; then one by a
 * top of -1. */
static void put_rows(optimization *o, size_t scenario, size_t rows, double factor, bool topped,
                     const double *x, size_t *row, size_t *entry)
{
    const size_t width = variables_of_case(o);
    for (size_t i = 0; i < rows; i++) {
        double *by = o->by + *entry;
        o->row[(*row)++] = factor * o->values[i] - (topped ? x[top_of(o, scenario)] : 0);
        if (!o->sloped) {
            continue;
        }
        memset(by, 0, width * sizeof *by);
        add_by_variables(o, scenario, o->partials + i * (size_t)o->parameters, factor, by,
                         by + o->shared);
        *entry += width;
        if (topped) {
            o->by[(*entry)++] = -1;
        }
    }
}

/* The value of the objective of a scenario: the largest or least of its rows. */
static double objective_of(const optimization *o)
{
    double value = o->values[0];
    for (size_t i = 1; i < response_rows(o->objective); i++) {
        value = o->sign > 0 ? fmax(value, o->values[i]) : fmin(value, o->values[i]);
    }
    return value;
}

static ad_status put_scenario(optimization *o, const double *x, size_t e, size_t *row,
                              size_t *entry)
{
    const double factor = o->sign * o->objective_scale;
    ad_status status = evaluate(o, o->objective, e);
    if (status != AD_OK) {
        return status;
    }
    o->objectives[e] = objective_of(o);
    if (o->tops > 0) {
        put_rows(o, e, response_rows(o->objective), factor, true, x, row, entry);
    } else {
        const double share = factor / (double)o->scenarios;
        if (o->sloped) {
            add_by_variables(o, e, o->partials, share, o->gradient,
                             o->gradient + variable_of(o, e, (size_t)o->shared));
        }
        o->value += share * o->values[0];
    }
    for (int i = 0; i < o->constraints && status == AD_OK; i++) {
        const optimize_constraint *c = &o->constraint[i];
        const size_t rows = rows_of(o, i, e);
        status = rows > 0 ? evaluate(o, c->of, e) : AD_OK;
        if (status == AD_OK) {
            put_rows(o, e, rows, c->scale, false, x, row, entry);
        }
    }
    return status;
}

/* Rows of a scenario that is not solved. */
static void skip_rows(optimization *o, size_t e, size_t *row, size_t *entry)
{
    const size_t width = variables_of_case(o);
    const size_t topped = o->tops > 0 ? response_rows(o->objective) : 0;
    size_t rows = topped;
    for (int i = 0; i < o->constraints; i++) {
        rows += rows_of(o, i, e);
    }
    for (size_t i = 0; i < rows; i++) {
        o->row[*row + i] = NAN;
    }
    *row += rows;
    *entry += rows * width + topped;
}

/* What formulas have beside shapes, where one has it. */
static ad_status find_margins(optimization *o, bool slopes)
{
    bool wanted = response_needs_stability(o->objective);
    for (int i = 0; i < o->constraints; i++) {
        wanted = wanted || response_needs_stability(o->constraint[i].of);
    }
    return wanted ? o->solver->margin(o->solver->of, o->scenarios, o->given, o->margins,
                                      slopes ? o->by_margins : NULL, &o->why)
                  : AD_OK;
}

static bool find(optimization *o, const double *x, bool slopes)
{
    if (o->known && (o->sloped || !slopes) && memcmp(o->at, x, o->n * sizeof *x) == 0) {
        return o->solved;
    }
    memcpy(o->at, x, o->n * sizeof *x);
    o->known = true;
    o->sloped = slopes;
    o->solved = false;
    for (size_t e = 0; e < o->scenarios; e++) {
        optimize_given(o, x, e, o->given + e * (size_t)o->parameters);
    }
    o->members += o->scenarios;
    if (o->solver->solve(o->solver->of, o->scenarios, o->given, o->shapes,
                         slopes ? o->jacobians : NULL, o->is_solved, &o->why) != AD_OK ||
        find_margins(o, slopes) != AD_OK) {
        return false;
    }
    o->value = 0;
    memset(o->gradient, 0, o->n * sizeof *o->gradient);
    for (size_t i = o->n - o->tops; i < o->n; i++) {
        o->gradient[i] = 1 / (double)o->tops;
        o->value += x[i] / (double)o->tops;
    }
    size_t row = 0, entry = 0;
    bool all = true;
    for (size_t e = 0; e < o->scenarios; e++) {
        if (!o->is_solved[e]) {
            o->objectives[e] = NAN;
            skip_rows(o, e, &row, &entry);
        } else if (put_scenario(o, x, e, &row, &entry) != AD_OK) {
            return false;
        }
        all = all && o->is_solved[e];
    }
    o->solved = all && isfinite(o->value) && vector_is_finite(o->n, o->gradient) &&
                vector_is_finite(o->m, o->row) && (!slopes || vector_is_finite(o->nonzeros, o->by));
    return o->solved;
}

bool optimize_look(optimization *o, const double *x)
{
    return find(o, x, false);
}

bool optimize_at(void *o, const double *x)
{
    return find(o, x, true);
}

void optimize_visit(const optimization *o, optimize_visitor *visit, void *context)
{
    size_t row = 0;
    for (size_t e = 0; e < o->scenarios; e++) {
        row += o->tops > 0 ? response_rows(o->objective) : 0;
        for (int i = 0; i < o->constraints; i++) {
            for (size_t k = 0; k < rows_of(o, i, e); k++, row++) {
                visit(context, i, e, row);
            }
        }
    }
}

/* Of variables and rows. */
static void find_limits(const optimization *o, double *x_low, double *x_high, double *row_low,
                        double *row_high)
{
    size_t row = 0;
    for (size_t i = 0; i < o->n; i++) {
        const bool is_top = i >= o->n - o->tops;
        x_low[i] = is_top ? -INFINITY : 0;
        x_high[i] = is_top ? INFINITY : 1;
    }
    for (size_t e = 0; e < o->scenarios; e++) {
        for (size_t i = 0; o->tops > 0 && i < response_rows(o->objective); i++, row++) {
            row_low[row] = -INFINITY;
            row_high[row] = 0;
        }
        for (int i = 0; i < o->constraints; i++) {
            const optimize_constraint *c = &o->constraint[i];
            for (size_t k = 0; k < rows_of(o, i, e); k++, row++) {
                row_low[row] = c->scale * c->low;
                row_high[row] = c->scale * c->high;
            }
        }
    }
}

static void put_entries(const optimization *o, size_t e, size_t rows, bool topped, int *row,
                        int *column, size_t *at, size_t *now)
{
    for (size_t i = 0; i < rows; i++, (*now)++) {
        for (size_t k = 0; k < variables_of_case(o); k++, (*at)++) {
            row[*at] = (int)*now;
            column[*at] = (int)variable_of(o, e, k);
        }
        if (topped) {
            row[*at] = (int)*now;
            column[(*at)++] = (int)top_of(o, e);
        }
    }
}

/* Places of the derivatives. */
static void find_entries(const optimization *o, int *row, int *column)
{
    size_t at = 0, now = 0;
    for (size_t e = 0; e < o->scenarios; e++) {
        if (o->tops > 0) {
            put_entries(o, e, response_rows(o->objective), true, row, column, &at, &now);
        }
        for (int i = 0; i < o->constraints; i++) {
            put_entries(o, e, rows_of(o, i, e), false, row, column, &at, &now);
        }
    }
}

ad_status optimize_descend(optimization *o, int *steps, bool *converged, ad_error *error)
{
    double *limits = malloc((2 * o->n + 2 * o->m + 1) * sizeof *limits);
    int *entries = malloc((2 * o->nonzeros + 1) * sizeof *entries);
    ad_status status = limits && entries
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for an optimisation");
    if (status == AD_OK) {
        double *high = limits + o->n, *row_low = high + o->n, *row_high = row_low + o->m;
        find_limits(o, limits, high, row_low, row_high);
        find_entries(o, entries, entries + o->nonzeros);
        const descent d = {.n = o->n,
                           .m = o->m,
                           .nonzeros = o->nonzeros,
                           .x_low = limits,
                           .x_high = high,
                           .row_low = row_low,
                           .row_high = row_high,
                           .row_of = entries,
                           .column_of = entries + o->nonzeros,
                           .at = optimize_at,
                           .of = o,
                           .value = &o->value,
                           .gradient = o->gradient,
                           .row = o->row,
                           .by = o->by,
                           .why = &o->why,
                           .x = o->x,
                           .multiplier = o->multiplier};
        status = optimize_descent(&d, steps, converged, error);
    }
    free(limits);
    free(entries);
    return status;
}
