/* Families: what they are made of, and the network of one in the strain form. */
#include "tools/library/trained_family.h"

#include "autodiff/host.h"
#include "physics/solve/solve.h"
#include "tools/library/member_code.h"
#include "tools/prepare/config_experiment.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Members at a time: enough for all threads, and no more numbers than caches hold. */
enum { CHUNK = 512, CHUNK_NUMBERS = 1 << 20 };

/* ---- making -------------------------------------------------------------------------------- */

static ad_status keep_points(cpinn_family *x, const cpinn_family_settings *settings,
                             ad_error *error)
{
    const bool moves = scene_is_dynamic(&x->open);
    x->points = settings->points;
    x->s = malloc((settings->points + 1) * sizeof *x->s);
    x->t = moves ? malloc((settings->points + 1) * sizeof *x->t) : NULL;
    if (!x->s || (moves && !x->t)) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", settings->points);
    }
    for (size_t i = 0; i < settings->points; i++) {
        x->s[i] = settings->s[i];
        if (!(x->s[i] >= (i > 0 && !moves ? x->s[i - 1] : 0) &&
              x->s[i] <= x->length * (1 + 1e-12))) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "s[%zu] = %g; allowed: %swithin the rod, 0 to %g m", i, x->s[i],
                           moves ? "" : "ascending, ", x->length);
        }
        if (moves) {
            x->t[i] = settings->t ? settings->t[i] : NAN;
            if (!(x->t[i] >= 0 && x->t[i] <= scene_duration(&x->open) * (1 + 1e-12))) {
                return ad_fail(error, AD_BAD_ARGUMENT, "t[%zu] = %g; allowed: 0 to %g s", i,
                               x->t[i], scene_duration(&x->open));
            }
        }
    }
    return AD_OK;
}

static ad_status create_solver(cpinn_family *x, ad_error *error)
{
    const solve_members_settings settings = {.tolerance = CPINN_TOLERANCE,
                                             .threads = ad_pool_threads(x->pool),
                                             .points = x->points,
                                             .s = x->s,
                                             .ranks = ad_pool_ranks(x->pool)};
    ad_status status = solve_members_create(&x->open, &settings, &x->solver, &x->why_not);
    if (status != AD_OK && status != AD_BAD_ARGUMENT) {
        return ad_fail(error, status, "%s", x->why_not.message);
    }
    x->nodes = x->solver ? solve_members_nodes(x->solver) : 0;
    return AD_OK;
}

static ad_status make_room(cpinn_family *x, ad_error *error)
{
    const size_t width = x->points * (size_t)x->columns, most = CHUNK_NUMBERS / (width + 1);
    x->chunk = most >= CHUNK ? CHUNK : most > 16 ? most / 16 * 16 : 16;
    x->curvature = malloc((3 * x->chunk * x->nodes + 1) * sizeof *x->curvature);
    x->values = malloc((x->chunk * width + 1) * sizeof *x->values);
    x->parameters = malloc(x->chunk * (size_t)x->count * sizeof *x->parameters);
    x->which = malloc(x->chunk * sizeof *x->which);
    x->refined = malloc(x->chunk * sizeof *x->refined);
    x->solved = malloc(x->chunk * sizeof *x->solved);
    return x->curvature && x->values && x->parameters && x->which && x->refined && x->solved
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for members of a family");
}

ad_status cpinn_family_prepare(const scene *open, const cpinn_family_settings *settings,
                               cpinn_family **result, ad_error *error)
{
    *result = NULL;
    if (!scene_is_family(open)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the scene is no family: no parameter of it has a range");
    }
    cpinn_family *x = calloc(1, sizeof *x);
    if (!x) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    }
    x->open = *open;
    x->count = open->parameter_count;
    x->extrapolate = settings->extrapolate;
    x->length = scene_length(open);
    ad_status status = ad_pool_open(settings->threads, &x->pool, error);
    status = status == AD_OK ? ad_pool_share(x->pool, settings->ranks, error) : status;
    status = status == AD_OK ? keep_points(x, settings, error) : status;
    if (status == AD_OK) {
        status = create_solver(x, error);
    }
    x->columns = x->solver ? SOLVE_MEMBERS_COLUMNS : solution_columns(open);
    status = status == AD_OK ? make_room(x, error) : status;
    if (status != AD_OK) {
        cpinn_family_free(x);
        return status;
    }
    *result = x;
    return AD_OK;
}

void cpinn_family_attach(cpinn_family *x, const cpinn_family_network *network)
{
    x->network = *network;
}

/* ---- the network of a family in the strain form ---- */

typedef struct strain_network {
    family_network *network;
    const double *weights;
    size_t nodes;
} strain_network;

/* Numbers that only underflow has left make all that follows slow: of a rod that stays in a plane,
 * the curvature out of it. */
static const double SMALLEST = 1e-100;

static ad_status run_strain(void *context, size_t members, const double *parameters,
                            double *curvature, ad_error *error)
{
    const strain_network *x = context;
    ad_status status =
        family_network_run(x->network, x->weights, members, parameters, curvature, error);
    for (size_t i = 0; i < members * 3 * x->nodes; i++) {
        curvature[i] = fabs(curvature[i]) < SMALLEST ? 0 : curvature[i];
    }
    return status;
}

static void free_strain(void *context)
{
    strain_network *x = context;
    family_network_free(x->network);
    free(x);
}

static ad_status create_strain(const experiment *e, const cpinn_family *x,
                               cpinn_family_network *result, ad_error *error)
{
    const family *trained = targets_family(e->targets);
    if (family_nodes(trained) != x->nodes) {
        return ad_fail(error, AD_BAD_INPUT,
                       "the network has curvature at %zu places, the solver at %zu; train it anew",
                       family_nodes(trained), x->nodes);
    }
    strain_network *made = calloc(1, sizeof *made);
    ad_status status = made ? family_network_create(trained, e->mlp, e->pool, &made->network, error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for a network");
    if (status != AD_OK) {
        free(made);
        return status;
    }
    made->weights = experiment_parameters(e);
    made->nodes = x->nodes;
    *result = (cpinn_family_network){.context = made, .curvature = run_strain, .free = free_strain};
    return AD_OK;
}

static ad_status create_code(const experiment *e, cpinn_family *x, ad_error *error)
{
    ad_error *why = &x->not_compiled;
    ad_status status =
        !e->targets || !x->solver
            ? ad_fail(why, AD_BAD_ARGUMENT, "the network is not one of the strain form")
            : member_code_create(e, x->points, x->s, &x->code, why);
    return status == AD_NO_MEMORY ? ad_fail(error, status, "%s", why->message) : AD_OK;
}

ad_status cpinn_family_of(const experiment *e, const cpinn_family_settings *settings,
                          cpinn_family **result, ad_error *error)
{
    cpinn_family_network network;
    const evaluator_model trained = experiment_trained(e);
    ad_status status = cpinn_family_prepare(e->scene, settings, result, error);
    if (status != AD_OK) {
        return status;
    }
    if (settings->ranks) {
        status = ad_pool_share(e->pool, settings->ranks, error);
    }
    status = status != AD_OK ? status
             : e->targets    ? create_strain(e, *result, &network, error)
                             : cpinn_family_fields(&trained, *result, &network, error);
    if (status == AD_OK) {
        cpinn_family_attach(*result, &network);
        status = settings->compile ? create_code(e, *result, error) : AD_OK;
    }
    if (status != AD_OK) {
        cpinn_family_free(*result);
        *result = NULL;
    }
    return status;
}

ad_status cpinn_family_open(const char *path, const cpinn_family_settings *settings,
                            cpinn_family **result, ad_error *error)
{
    AD_LEAVE_HOST;
    experiment *e = NULL;
    *result = NULL;
    ad_status status = config_experiment_open(path, 0, NULL, settings->threads, &e, NULL, error);
    if (status == AD_OK) {
        status = cpinn_family_of(e, settings, result, error);
    }
    if (status != AD_OK) {
        experiment_free(e);
        return status;
    }
    (*result)->owned = e;
    return AD_OK;
}

void cpinn_family_free(cpinn_family *x)
{
    if (x) {
        if (x->network.free) {
            x->network.free(x->network.context);
        }
        member_code_free(x->code);
        solve_members_free(x->solver);
        ad_pool_free(x->pool);
        experiment_free(x->owned);
        free(x->s);
        free(x->t);
        free(x->curvature);
        free(x->values);
        free(x->parameters);
        free(x->which);
        free(x->refined);
        free(x->solved);
        free(x);
    }
}

/* ---- looking ------------------------------------------------------------------------------- */

int cpinn_family_parameters(const cpinn_family *x)
{
    return x->count;
}

const scene_parameter *cpinn_family_parameter(const cpinn_family *x, int index)
{
    return index >= 0 && index < x->count ? &x->open.parameters[index] : NULL;
}

int cpinn_family_columns(const cpinn_family *x)
{
    return x->columns;
}

const char *cpinn_family_column_name(const cpinn_family *x, int column)
{
    return column >= 0 && column < x->columns ? scene_physics_of(&x->open)->columns[column].name
                                              : "";
}

const char *cpinn_family_without_error(const cpinn_family *x)
{
    return x->solver ? "" : x->why_not.message;
}

bool cpinn_family_is_compiled(const cpinn_family *x)
{
    return x->code != NULL;
}

const char *cpinn_family_not_compiled(const cpinn_family *x)
{
    return x->code ? "" : x->not_compiled.message;
}

solve_members *cpinn_family_solver(const cpinn_family *x)
{
    return x->solver;
}

const scene *cpinn_family_scene(const cpinn_family *x)
{
    return &x->open;
}

ad_pool *cpinn_family_pool(const cpinn_family *x)
{
    return x->pool;
}

size_t cpinn_family_points(const cpinn_family *x)
{
    return x->points;
}

const double *cpinn_family_s(const cpinn_family *x)
{
    return x->s;
}

const double *cpinn_family_t(const cpinn_family *x)
{
    return x->t;
}
