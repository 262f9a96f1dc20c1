/* Families whose networks have the parameters as further coordinates, beside s and t. */
#include "autodiff/memory.h"
#include "tools/library/trained_family.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Members of one piece of work. */
enum { GROUP = 8, NAMES_MAX = MODEL_COLUMNS_MAX * (EVALUATOR_NAME_MAX + 1) };

typedef struct fields {
    const cpinn_family *of;           /* owns it */
    int threads;                      /* of its pool */
    double *places;                   /* [nodes] m */
    evaluator **shapes, **curvatures; /* [threads] */
    evaluator **slopes;      /* [parameters][threads] of shapes; NULL until they are asked */
    evaluator_model trained; /* borrowed */
    double **room;           /* [threads] coordinates and values of a group */
    ad_memory memory;
} fields;

static void fields_free(void *context)
{
    fields *fields = context;
    for (int i = 0; i < fields->threads; i++) {
        if (fields->shapes) {
            evaluator_free(fields->shapes[i]);
        }
        if (fields->curvatures) {
            evaluator_free(fields->curvatures[i]);
        }
    }
    for (int i = 0; fields->slopes && i < fields->of->count * fields->threads; i++) {
        evaluator_free(fields->slopes[i]);
    }
    ad_memory_free(&fields->memory);
    free(fields);
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
    const fields *fields = of->x;
    const size_t rows = members * of->points;
    const double *at[2 + SCENE_PARAMETERS_MAX];
    double *to = fields->room[thread];
    int coordinates = 0;
    for (int k = of->t ? -2 : -1; k < fields->of->count; k++, to += rows) {
        for (size_t i = 0; i < rows; i++) {
            const size_t member = first + i / of->points, point = i % of->points;
            to[i] = k >= 0 ? of->parameters[member * (size_t)fields->of->count + (size_t)k]
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
    return ad_pool_deal(of->x->of->pool, (int)((of->members + GROUP - 1) / GROUP), work, of, 1,
                        &made, error);
}

static ad_status find_curvature(void *context, size_t members, const double *parameters,
                                double *curvature, ad_error *error)
{
    fields *fields = context;
    const size_t nodes = fields->of->nodes, width = fields->of->numbers / nodes;
    batch of = {fields, fields->curvatures, members,  nodes, (int)width, fields->places,
                NULL,   parameters,         curvature};
    const ad_status status = run(&of, error);
    const double torsion = 1 / solve_members_torsion(fields->of->solver);
    for (size_t i = 0; i < members * nodes * width; i++) {
        curvature[i] *= i % width < 3 ? 1 : torsion;
    }
    return status;
}

/* At the points of the family, its columns or as many derivatives. */
static ad_status run_shapes(fields *fields, evaluator **with, size_t members,
                            const double *parameters, double *values, ad_error *error)
{
    const cpinn_family *of = fields->of;
    batch x = {fields, with, members, of->points, of->columns, of->s, of->t, parameters, values};
    return run(&x, error);
}

static ad_status find_values(void *context, size_t members, const double *parameters,
                             double *values, ad_error *error)
{
    fields *fields = context;
    return run_shapes(fields, fields->shapes, members, parameters, values, error);
}

/* Columns of a shape, or their derivatives by a parameter. */
static void write_names(const fields *fields, const char *by, char names[NAMES_MAX])
{
    size_t at = 0;
    names[0] = '\0';
    for (int i = 0; i < fields->of->columns && at < NAMES_MAX; i++) {
        at += (size_t)snprintf(names + at, NAMES_MAX - at, "%s%s%s%s", i > 0 ? " " : "",
                               cpinn_family_column_name(fields->of, i), *by ? "_" : "", by);
    }
}

static ad_status create_slopes(fields *fields, ad_error *error)
{
    ad_status status = AD_OK;
    AD_TAKE(fields, slopes, (size_t)fields->of->count * (size_t)fields->threads);
    if (fields->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for derivatives of a family");
    }
    for (int k = 0; k < fields->of->count && status == AD_OK; k++) {
        char names[NAMES_MAX];
        write_names(fields, fields->of->open.parameters[k].name, names);
        for (int i = 0; i < fields->threads && status == AD_OK; i++) {
            status = evaluator_create(&fields->trained, names,
                                      &fields->slopes[k * fields->threads + i], error);
        }
    }
    return status;
}

static ad_status find_jacobian(void *context, size_t members, const double *parameters,
                               double *jacobian, ad_error *error)
{
    fields *fields = context;
    const size_t numbers = members * fields->of->points * (size_t)fields->of->columns,
                 count = (size_t)fields->of->count;
    double *values = malloc((numbers + 1) * sizeof *values);
    ad_status status = values ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    if (status == AD_OK && !fields->slopes) {
        status = create_slopes(fields, error);
    }
    for (size_t k = 0; k < count && status == AD_OK; k++) {
        status = run_shapes(fields, fields->slopes + k * (size_t)fields->threads, members,
                            parameters, values, error);
        for (size_t i = 0; i < numbers && status == AD_OK; i++) {
            jacobian[i * count + k] = values[i];
        }
    }
    free(values);
    return status;
}

/* ---- making -------------------------------------------------------------------------------- */

static ad_status create_evaluators(fields *fields, ad_error *error)
{
    const cpinn_family *of = fields->of;
    const size_t most = of->points > of->nodes ? of->points : of->nodes;
    const size_t rows = 2 + (size_t)of->count + (size_t)of->columns;
    char names[NAMES_MAX];
    ad_status status = AD_OK;
    char strains[NAMES_MAX] = "u1 u2 u3";
    for (int i = 1; i <= of->open.tube_count; i++) {
        snprintf(strains + strlen(strains), sizeof strains - strlen(strains), " mt%d", i);
    }
    write_names(fields, "", names);
    for (int i = 0; i < fields->threads && status == AD_OK; i++) {
        AD_TAKE(fields, room[i], GROUP * rows * (most + 1));
        status = ad_memory_status(&fields->memory, error, "out of memory for %zu points", most);
        if (status == AD_OK) {
            status = evaluator_create(&fields->trained, names, &fields->shapes[i], error);
        }
        if (status == AD_OK && of->nodes > 0) {
            status = evaluator_create(&fields->trained, strains, &fields->curvatures[i], error);
        }
    }
    return status;
}

ad_status cpinn_family_fields(const evaluator_model *trained, const cpinn_family *family,
                              cpinn_family_network *result, ad_error *error)
{
    fields *fields = calloc(1, sizeof *fields);
    if (!fields) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a network");
    }
    fields->of = family;
    fields->threads = ad_pool_threads(family->pool);
    fields->trained = *trained;
    AD_TAKE(fields, places, family->nodes + 1);
    AD_TAKE(fields, shapes, (size_t)fields->threads);
    AD_TAKE(fields, curvatures, (size_t)fields->threads);
    AD_TAKE(fields, room, (size_t)fields->threads);
    ad_status status = AD_OK;
    if (fields->memory.is_short) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a network");
    }
    if (status == AD_OK && family->solver) {
        solve_members_places(family->solver, fields->places);
    }
    status = status == AD_OK ? create_evaluators(fields, error) : status;
    if (status != AD_OK) {
        fields_free(fields);
        return status;
    }
    *result =
        (cpinn_family_network){fields, find_curvature, find_values, find_jacobian, fields_free};
    return AD_OK;
}
