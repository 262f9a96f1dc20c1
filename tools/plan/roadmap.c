#include "tools/plan/roadmap.h"

#include "tools/files/checkpoint.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* "pull_1 0 to 4, slide -0.15 to 0.05" */
static void name_variables(const plan_robot *robot, char *text, size_t size)
{
    size_t at = 0;
    *text = '\0';
    for (int k = 0; k < robot->count && at < size; k++) {
        at += (size_t)snprintf(text + at, size - at, "%s%s %.9g to %.9g", k ? ", " : "",
                               robot->names[k], robot->low[k], robot->high[k]);
    }
}

enum { VARIABLES_TEXT = 2048 };

/* ---- the file -------------------------------------------------------------------------------- */

static ad_status write_file(const roadmap_settings *settings, const plan_robot *robot,
                            double needed, const ompl_roadmap *of, ad_error *error)
{
    char variables[VARIABLES_TEXT];
    name_variables(robot, variables, sizeof variables);
    checkpoint *const cp = checkpoint_create(CPINN_VERSION);
    if (!cp) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a roadmap");
    }
    (void)checkpoint_put_text(cp, "variables", variables);
    (void)checkpoint_put_uint64(cp, "surface", &settings->surface, 0, NULL);
    (void)checkpoint_put_uint64(cp, "shapes", &settings->shapes, 0, NULL);
    (void)checkpoint_put_double(cp, "needed", needed);
    (void)checkpoint_put_doubles(cp, "nodes", of->node, 2,
                                 (const size_t[2]){of->nodes, (size_t)robot->count});
    (void)checkpoint_put_uint64(cp, "edges", of->edge, 2, (const size_t[2]){of->edges, 2});
    const ad_status status = checkpoint_write(cp, &(file_place){.path = settings->file}, error);
    checkpoint_free(cp);
    return status;
}

static ad_status refuse(const roadmap_settings *settings, const char *why, ad_error *error)
{
    return ad_fail(error, AD_BAD_INPUT, "%.300s: %.600s", settings->file, why);
}

/* How many rows an item of so many columns has. */
static size_t rows_of(const checkpoint *cp, const char *name, size_t columns)
{
    int rank = 0;
    size_t shape[CHECKPOINT_MAX_RANK] = {0};
    return checkpoint_shape(cp, name, &rank, shape) && rank == 2 && shape[1] == columns ? shape[0]
                                                                                        : 0;
}

static ad_status take(const checkpoint *cp, const roadmap_settings *settings,
                      const plan_robot *robot, ompl_roadmap *to, double *needed, uint64_t seals[2],
                      ad_error *error)
{
    char variables[VARIABLES_TEXT], why[VARIABLES_TEXT];
    const char *its = NULL;
    const size_t count = (size_t)robot->count;
    name_variables(robot, variables, sizeof variables);
    if (checkpoint_get_text(cp, "variables", &its, NULL) != AD_OK || !checkpoint_has(cp, "nodes")) {
        return refuse(settings, "is no roadmap; allowed: one, or no file, which is then made",
                      error);
    }
    if (strcmp(its, variables) != 0) {
        snprintf(why, sizeof why,
                 "is a roadmap of other variables: %.200s; allowed: %.200s, or another file", its,
                 variables);
        return refuse(settings, why, error);
    }
    to->nodes = rows_of(cp, "nodes", count);
    to->edges = rows_of(cp, "edges", 2);
    to->node = malloc((to->nodes * count + 1) * sizeof *to->node);
    to->edge = malloc((2 * to->edges + 1) * sizeof *to->edge);
    if (!to->node || !to->edge) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a roadmap");
    }
    ad_status status = checkpoint_get_doubles(cp, "nodes", to->node, to->nodes * count, error);
    if (status == AD_OK) {
        status = checkpoint_get_uint64(cp, "edges", to->edge, 2 * to->edges, error);
    }
    if (status == AD_OK) {
        status = checkpoint_get_doubles(cp, "needed", needed, 1, error);
    }
    for (int k = 0; k < 2 && status == AD_OK; k++) {
        status = checkpoint_get_uint64(cp, k ? "shapes" : "surface", &seals[k], 1, error);
    }
    for (size_t i = 0; i < 2 * to->edges && status == AD_OK; i++) {
        if (to->edge[i] >= to->nodes) {
            return refuse(settings, "has an edge of a node that there is not", error);
        }
    }
    for (size_t i = 0; i < to->nodes * count && status == AD_OK; i++) {
        if (!(to->node[i] >= robot->low[i % count] && to->node[i] <= robot->high[i % count])) {
            return refuse(settings, "has a node beyond the ranges of its variables", error);
        }
    }
    return status;
}

static ad_status read_file(const roadmap_settings *settings, const plan_robot *robot, double needed,
                           ompl_roadmap *to, roadmap *result, ad_error *error)
{
    checkpoint *cp = NULL;
    uint64_t seals[2] = {0, 0};
    ad_status status = checkpoint_open(settings->file, &cp, error);
    status =
        status == AD_OK ? take(cp, settings, robot, to, &result->needed, seals, error) : status;
    checkpoint_free(cp);
    result->source = seals[0] != settings->surface  ? ROADMAP_OTHER_SURFACE
                     : seals[1] != settings->shapes ? ROADMAP_OTHER_SHAPES
                     : !(result->needed >= needed)  ? ROADMAP_NEARER
                                                    : ROADMAP_KEPT;
    return status;
}

/* ---- searches -------------------------------------------------------------------------------- */

ad_status roadmap_open(const roadmap_settings *settings, const plan_robot *robot,
                       const ompl_search *how, double needed, const ad_status *failed,
                       roadmap *result, ad_error *error)
{
    ompl_roadmap of = {.nodes = 0};
    *result = (roadmap){.source = ROADMAP_MADE, .needed = needed};
    ad_status status;
    if (access(settings->file, F_OK) == 0) {
        status = read_file(settings, robot, needed, &of, result, error);
    } else {
        status = ompl_roadmap_make(how, settings->nodes, &of, error);
        status = status == AD_OK ? *failed : status;
        status = status == AD_OK ? write_file(settings, robot, needed, &of, error) : status;
    }
    if (status == AD_OK) {
        const bool known = result->source <= ROADMAP_KEPT;
        result->nodes = of.nodes;
        result->edges = of.edges;
        result->needed = known ? result->needed : needed;
        status = ompl_map_create(how, &of, known, &result->map, error);
    }
    free(of.node);
    free(of.edge);
    return status;
}

void roadmap_close(roadmap *of)
{
    ompl_map_free(of->map);
    of->map = NULL;
}

ad_status roadmap_find(roadmap *of, const ompl_search *search, double needed, double **way,
                       size_t *length, size_t *looked, ad_error *error)
{
    const bool forget = !(of->needed >= needed);
    of->needed = forget ? needed : of->needed;
    return ompl_map_find(of->map, search, forget, way, length, looked, error);
}
