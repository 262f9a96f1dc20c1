/* Families whose networks have the parameters as further coordinates, beside s and t. */
#include "tools/library/trained_family.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Members of one piece of work. */
enum { GROUP = 8, NAMES_MAX = MODEL_COLUMNS_MAX * (EVALUATOR_NAME_MAX + 1) };

typedef struct fields {
    int count, columns, threads;
    size_t points, nodes;
    double *s, *t, *places;           /* [points], [points] or NULL, [nodes] m */
    ad_pool *pool;                    /* of the family */
    evaluator **shapes, **curvatures; /* [threads] */
    evaluator **slopes;      /* [parameters][threads] of shapes; NULL until they are asked */
    evaluator_model trained; /* borrowed, as the next */
    const cpinn_family *family;
    double **room; /* [threads] coordinates and values of a group */
} fields;

static void fields_free(void *context)
{
    fields *x = context;
    for (int i = 0; i < x->threads; i++) {
        if (x->shapes) {
            evaluator_free(x->shapes[i]);
        }
        if (x->curvatures) {
            evaluator_free(x->curvatures[i]);
        }
        if (x->room) {
            free(x->room[i]);
        }
    }
    for (int i = 0; x->slopes && i < x->count * x->threads; i++) {
        evaluator_free(x->slopes[i]);
    }
    free(x->s);
    free(x->t);
    free(x->places);
    free(x->shapes);
    free(x->curvatures);
    free(x->slopes);
    free(x->room);
    free(x);
}

/* ---- one group of members ------------------------------------------------------------------ */

typedef struct batch {
    fields *x;
    evaluator **with;
    size_t members, points;
    int columns;
    const double *s, *t, *parameters;
    double *values; /* [members][points][columns] */
} batch;

static ad_status evaluate_group(const batch *of, size_t first, size_t members, int thread,
                                ad_error *error)
{
    const fields *x = of->x;
    const size_t rows = members * of->points;
    const double *at[2 + SCENE_PARAMETERS_MAX];
    double *to = x->room[thread];
    int coordinates = 0;
    for (int k = of->t ? -2 : -1; k < x->count; k++, to += rows) {
        for (size_t i = 0; i < rows; i++) {
            const size_t member = first + i / of->points, point = i % of->points;
            to[i] = k >= 0             ? of->parameters[member * (size_t)x->count + (size_t)k]
                    : coordinates == 0 ? of->s[point]
                                       : of->t[point];
        }
        at[coordinates++] = to;
    }
    ad_status status = evaluator_evaluate_at(of->with[thread], rows, at, to, error);
    double *values = of->values + first * of->points * (size_t)of->columns;
    for (size_t i = 0; i < rows && status == AD_OK; i++) {
        for (int c = 0; c < of->columns; c++) {
            values[i * (size_t)of->columns + (size_t)c] = to[(size_t)c * rows + i];
        }
    }
    return status;
}

static ad_status work(void *context, int item, int thread, ad_error *error)
{
    const batch *of = context;
    const size_t first = GROUP * (size_t)item, left = of->members - first;
    return evaluate_group(of, first, left < GROUP ? left : GROUP, thread, error);
}

static ad_status run(batch *of, ad_error *error)
{
    const size_t bytes = of->points * (size_t)of->columns * sizeof *of->values;
    const ad_dealt made = {of->values, GROUP * bytes, of->members * bytes};
    return ad_pool_deal(of->x->pool, (int)((of->members + GROUP - 1) / GROUP), work, of, 1, &made,
                        error);
}

static ad_status find_curvature(void *context, size_t members, const double *parameters,
                                double *curvature, ad_error *error)
{
    fields *x = context;
    batch of = {x, x->curvatures, members, x->nodes, 3, x->places, NULL, parameters, curvature};
    return run(&of, error);
}

static ad_status find_values(void *context, size_t members, const double *parameters,
                             double *values, ad_error *error)
{
    fields *x = context;
    batch of = {x, x->shapes, members, x->points, x->columns, x->s, x->t, parameters, values};
    return run(&of, error);
}

/* Columns of a shape, or their derivatives by a parameter. */
static void write_names(const fields *x, const char *by, char names[NAMES_MAX])
{
    size_t at = 0;
    names[0] = '\0';
    for (int i = 0; i < x->columns && at < NAMES_MAX; i++) {
        at += (size_t)snprintf(names + at, NAMES_MAX - at, "%s%s%s%s", i > 0 ? " " : "",
                               cpinn_family_column_name(x->family, i), *by ? "_" : "", by);
    }
}

static ad_status create_slopes(fields *x, ad_error *error)
{
    ad_status status = AD_OK;
    x->slopes = calloc((size_t)x->count * (size_t)x->threads, sizeof *x->slopes);
    if (!x->slopes) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of a family");
    }
    for (int k = 0; k < x->count && status == AD_OK; k++) {
        char names[NAMES_MAX];
        write_names(x, cpinn_family_parameter(x->family, k)->name, names);
        for (int i = 0; i < x->threads && status == AD_OK; i++) {
            status = evaluator_create(&x->trained, names, &x->slopes[k * x->threads + i], error);
        }
    }
    return status;
}

static ad_status find_jacobian(void *context, size_t members, const double *parameters,
                               double *jacobian, ad_error *error)
{
    fields *x = context;
    const size_t numbers = members * x->points * (size_t)x->columns, count = (size_t)x->count;
    double *values = malloc((numbers + 1) * sizeof *values);
    ad_status status = values ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    if (status == AD_OK && !x->slopes) {
        status = create_slopes(x, error);
    }
    for (size_t k = 0; k < count && status == AD_OK; k++) {
        batch of = {x,          x->slopes + k * (size_t)x->threads,
                    members,    x->points,
                    x->columns, x->s,
                    x->t,       parameters,
                    values};
        status = run(&of, error);
        for (size_t i = 0; i < numbers && status == AD_OK; i++) {
            jacobian[i * count + k] = values[i];
        }
    }
    free(values);
    return status;
}

/* ---- making -------------------------------------------------------------------------------- */

static double *copy(size_t count, const double *from)
{
    double *result = malloc((count + 1) * sizeof *result);
    if (result && count > 0) {
        memcpy(result, from, count * sizeof *from);
    }
    return result;
}

static ad_status create_evaluators(fields *x, ad_error *error)
{
    const size_t most = x->points > x->nodes ? x->points : x->nodes;
    const size_t rows = 2 + (size_t)x->count + (size_t)x->columns;
    char names[NAMES_MAX];
    ad_status status = AD_OK;
    write_names(x, "", names);
    for (int i = 0; i < x->threads && status == AD_OK; i++) {
        x->room[i] = malloc(GROUP * rows * (most + 1) * sizeof **x->room);
        status = x->room[i] ? evaluator_create(&x->trained, names, &x->shapes[i], error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", most);
        if (status == AD_OK && x->nodes > 0) {
            status = evaluator_create(&x->trained, "u1 u2 u3", &x->curvatures[i], error);
        }
    }
    return status;
}

ad_status cpinn_family_fields(const evaluator_model *trained, const cpinn_family *family,
                              cpinn_family_network *result, ad_error *error)
{
    solve_members *solver = cpinn_family_solver(family);
    const int threads = ad_pool_threads(cpinn_family_pool(family));
    fields *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a network");
    }
    x->threads = threads;
    x->trained = *trained;
    x->family = family;
    x->count = cpinn_family_parameters(family);
    x->columns = cpinn_family_columns(family);
    x->points = cpinn_family_points(family);
    x->nodes = solver ? solve_members_nodes(solver) : 0;
    x->s = copy(x->points, cpinn_family_s(family));
    x->t = cpinn_family_t(family) ? copy(x->points, cpinn_family_t(family)) : NULL;
    x->places = malloc((x->nodes + 1) * sizeof *x->places);
    x->pool = cpinn_family_pool(family);
    x->shapes = calloc((size_t)threads, sizeof *x->shapes);
    x->curvatures = calloc((size_t)threads, sizeof *x->curvatures);
    x->room = calloc((size_t)threads, sizeof *x->room);
    ad_status status = AD_OK;
    if (!x->s || (cpinn_family_t(family) && !x->t) || !x->places || !x->shapes || !x->curvatures ||
        !x->room) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a network");
    }
    if (status == AD_OK && solver) {
        solve_members_places(solver, x->places);
    }
    status = status == AD_OK ? create_evaluators(x, error) : status;
    if (status != AD_OK) {
        fields_free(x);
        return status;
    }
    *result = (cpinn_family_network){x, find_curvature, find_values, find_jacobian, fields_free};
    return AD_OK;
}
