/* Families: what they are made of, and the network of one in the strain form. */
#include "tools/library/trained_family.h"

#include "autodiff/host.h"
#include "physics/solve/solve.h"
#include "tools/library/member_code.h"
#include "tools/prepare/config_experiment.h"
#include "tools/prepare/prepare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Members at a time: enough for all threads, and no more numbers than caches hold. */
enum { CHUNK = 512, CHUNK_NUMBERS = 1 << 20 };

/* ---- making -------------------------------------------------------------------------------- */

static ad_status keep_points(cpinn_family *family, const cpinn_family_settings *settings,
                             ad_error *error)
{
    const bool moves = scene_is_dynamic(&family->open);
    family->points = settings->points;
    AD_TAKE(family, s, settings->points + 1);
    if (moves) {
        AD_TAKE(family, t, settings->points + 1);
    }
    if (family->memory.is_short) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu points", settings->points);
    }
    for (size_t i = 0; i < settings->points; i++) {
        family->s[i] = settings->s[i];
        if (!(family->s[i] >= (i > 0 && !moves ? family->s[i - 1] : 0) &&
              family->s[i] <= family->length * (1 + 1e-12))) {
            return ad_fail(error, AD_BAD_ARGUMENT,
                           "s[%zu] = %g; allowed: %swithin the rod, 0 to %g m", i, family->s[i],
                           moves ? "" : "ascending, ", family->length);
        }
        if (moves) {
            family->t[i] = settings->t ? settings->t[i] : NAN;
            if (!(family->t[i] >= 0 &&
                  family->t[i] <= scene_duration(&family->open) * (1 + 1e-12))) {
                return ad_fail(error, AD_BAD_ARGUMENT, "t[%zu] = %g; allowed: 0 to %g s", i,
                               family->t[i], scene_duration(&family->open));
            }
        }
    }
    return AD_OK;
}

static solve_members_settings settings_of(const cpinn_family *family)
{
    return (solve_members_settings){.tolerance = family->tolerance,
                                    .threads = ad_pool_threads(family->pool),
                                    .points = family->points,
                                    .s = family->s,
                                    .ranks = ad_pool_ranks(family->pool)};
}

/* by_itself: neither a network nor compiled C gives it curvature. */
static ad_status create_solver(cpinn_family *family, bool by_itself, ad_error *error)
{
    solve_members_settings settings = settings_of(family);
    settings.own_curvature = by_itself;
    ad_status status =
        solve_members_create(&family->open, &settings, &family->solver, &family->why_not);
    if (status != AD_OK && status != AD_BAD_ARGUMENT) {
        return ad_fail(error, status, "%s", family->why_not.message);
    }
    family->nodes = family->solver ? solve_members_nodes(family->solver) : 0;
    family->numbers = family->solver ? solve_members_numbers(family->solver) : 0;
    return AD_OK;
}

static ad_status make_room(cpinn_family *family, ad_error *error)
{
    const size_t count = (size_t)family->count, width = family->points * (size_t)family->columns,
                 carried = family->points * family->more,
                 most = CHUNK_NUMBERS / (width + carried * (1 + count) + 1);
    family->chunk = most >= CHUNK ? CHUNK : most > 16 ? most / 16 * 16 : 16;
    AD_TAKE(family, curvature, family->chunk * family->numbers + 1);
    AD_TAKE(family, found, family->chunk * family->numbers + 1);
    AD_TAKE(family, values, family->chunk * width + 1);
    AD_TAKE(family, parameters, family->chunk * (size_t)family->count);
    AD_TAKE(family, which, family->chunk);
    AD_TAKE(family, refined, family->chunk);
    AD_TAKE(family, solved, family->chunk);
    AD_TAKE(family, carried, family->chunk * carried + 1);
    AD_TAKE(family, carried_by, family->chunk * carried * count + 1);
    AD_TAKE(family, unasked, family->chunk);
    return ad_memory_status(&family->memory, error, "out of memory for members of a family");
}

ad_status cpinn_family_prepare(const scene *open, double tolerance,
                               const cpinn_family_settings *settings, cpinn_family **result,
                               ad_error *error)
{
    *result = NULL;
    if (!scene_is_family(open)) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "the scene is no family: no parameter of it has a range");
    }
    cpinn_family *family = calloc(1, sizeof *family);
    if (!family) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a family");
    }
    family->open = *open;
    family->count = open->parameter_count;
    family->tolerance = tolerance > 0 ? tolerance : CPINN_TOLERANCE;
    family->extrapolate = settings->extrapolate;
    family->length = scene_length(open);
    ad_status status = ad_pool_open(settings->threads, &family->pool, error);
    status = status == AD_OK ? ad_pool_share(family->pool, settings->ranks, error) : status;
    status = status == AD_OK ? keep_points(family, settings, error) : status;
    if (status == AD_OK) {
        status = create_solver(family, tolerance > 0 && !settings->compile, error);
    }
    family->columns = family->solver ? SOLVE_MEMBERS_COLUMNS : solution_columns(open);
    family->forces = family->solver && settings->forces;
    family->more = family->forces ? solve_members_carried(family->solver) : 0;
    status = status == AD_OK ? make_room(family, error) : status;
    if (status != AD_OK) {
        cpinn_family_free(family);
        return status;
    }
    *result = family;
    return AD_OK;
}

void cpinn_family_attach(cpinn_family *family, const cpinn_family_network *network)
{
    family->network = *network;
}

/* ---- the network of a family in the strain form ---- */

typedef struct strain_network {
    family_network *network;
    const double *weights;
    size_t numbers;
} strain_network;

/* Numbers that only underflow has left make all that follows slow: of a rod that stays in a plane,
 * the curvature out of it. */
static const double SMALLEST = 1e-100;

static ad_status run_strain(void *context, size_t members, const double *parameters,
                            double *curvature, ad_error *error)
{
    const strain_network *network = context;
    ad_status status = family_network_run(network->network, network->weights, members, parameters,
                                          curvature, error);
    for (size_t i = 0; i < members * network->numbers; i++) {
        curvature[i] = fabs(curvature[i]) < SMALLEST ? 0 : curvature[i];
    }
    return status;
}

static void free_strain(void *context)
{
    strain_network *network = context;
    family_network_free(network->network);
    free(network);
}

static ad_status create_strain(const experiment *e, const cpinn_family *of,
                               cpinn_family_network *result, ad_error *error)
{
    const family *trained = targets_family(e->targets);
    if (family_nodes(trained) != of->nodes) {
        return ad_fail(error, AD_BAD_INPUT,
                       "the network has curvature at %zu places, the solver at %zu; train it anew",
                       family_nodes(trained), of->nodes);
    }
    strain_network *made = calloc(1, sizeof *made);
    ad_status status = made ? family_network_create(trained, e->mlp, e->pool, &made->network, error)
                            : ad_fail(error, AD_NO_MEMORY, "out of memory for a network");
    if (status != AD_OK) {
        free(made);
        return status;
    }
    made->weights = experiment_parameters(e);
    made->numbers = of->numbers;
    *result = (cpinn_family_network){.context = made, .curvature = run_strain, .free = free_strain};
    return AD_OK;
}

static ad_status create_code(const experiment *e, cpinn_family *family, ad_error *error)
{
    ad_error *why = &family->not_compiled;
    const solve_members_settings asked = settings_of(family);
    const ad_status status =
        !e ? member_code_create_solver(&family->open, family->forces, family->solver, &asked,
                                       &family->code, why)
        : !e->targets || !family->solver
            ? ad_fail(why, AD_BAD_ARGUMENT, "the network is not one of the strain form")
            : member_code_create(e, family->forces, family->points, family->s, &family->code, why);
    return status == AD_NO_MEMORY ? ad_fail(error, status, "%s", why->message) : AD_OK;
}

ad_status cpinn_family_of(const experiment *e, const cpinn_family_settings *settings,
                          cpinn_family **result, ad_error *error)
{
    cpinn_family_network network;
    const evaluator_model trained = experiment_trained(e);
    ad_status status = cpinn_family_prepare(e->scene, 0, settings, result, error);
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

ad_status cpinn_family_of_scene(const scene *open, double tolerance,
                                const cpinn_family_settings *settings, cpinn_family **result,
                                ad_error *error)
{
    ad_status status = cpinn_family_prepare(open, tolerance, settings, result, error);
    if (status != AD_OK) {
        return status;
    }
    cpinn_family *family = *result;
    const bool moves = scene_is_dynamic(open) && !scene_is_beam(open);
    family->solves_all = !family->solver && moves && open->memory_count == 0;
    if (family->solves_all) {
        family->tolerance = tolerance;
        ad_fail(&family->not_compiled, AD_BAD_ARGUMENT, "%s", family->why_not.message);
        return AD_OK;
    }
    status = !family->solver && moves
                 ? ad_fail(error, AD_BAD_ARGUMENT,
                           "members in motion do not have plays and lags of parameters yet; "
                           "allowed: formulas without them, or a scene of one member")
             : !family->solver   ? ad_fail(error, AD_BAD_ARGUMENT, "%s", family->why_not.message)
             : settings->compile ? create_code(NULL, family, error)
                                 : AD_OK;
    if (status != AD_OK) {
        cpinn_family_free(family);
        *result = NULL;
    }
    return status;
}

ad_status cpinn_family_file(const char *path, int count, const char *const *overrides,
                            double tolerance, const cpinn_family_settings *settings,
                            cpinn_family **result, ad_error *error)
{
    AD_LEAVE_HOST;
    config *read = NULL;
    *result = NULL;
    ad_status status = prepare_read(path, NULL, count, overrides, &read, error);
    if (status == AD_OK) {
        status = cpinn_family_of_scene(&read->scene, tolerance, settings, result, error);
    }
    if (status != AD_OK) {
        config_free(read);
        return status;
    }
    (*result)->settings = read;
    return AD_OK;
}

void cpinn_family_free(cpinn_family *family)
{
    if (family) {
        if (family->network.free) {
            family->network.free(family->network.context);
        }
        member_code_free(family->code);
        solve_members_free(family->solver);
        ad_pool_free(family->pool);
        experiment_free(family->owned);
        config_free(family->settings);
        ad_memory_free(&family->memory);
        free(family);
    }
}

/* ---- looking ------------------------------------------------------------------------------- */

int cpinn_family_parameters(const cpinn_family *family)
{
    return family->count;
}

const scene_parameter *cpinn_family_parameter(const cpinn_family *family, int index)
{
    return index >= 0 && index < family->count ? &family->open.parameters[index] : NULL;
}

int cpinn_family_columns(const cpinn_family *family)
{
    return family->columns + (int)family->more;
}

const char *cpinn_family_column_name(const cpinn_family *family, int column)
{
    return column >= 0 && column < cpinn_family_columns(family)
               ? scene_physics_of(&family->open)->columns[column].name
               : "";
}

const char *cpinn_family_without_error(const cpinn_family *family)
{
    return family->solver || family->solves_all ? "" : family->why_not.message;
}

const char *cpinn_family_not_compiled(const cpinn_family *family)
{
    return family->code ? "" : family->not_compiled.message;
}
