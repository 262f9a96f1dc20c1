#include "tools/train/experiment.h"

#include "physics/scene/support.h"
#include "physics/solve/modes_model.h"
#include "tools/train/measured_terms.h"

#include <stdlib.h>
#include <string.h>

/* Whether the form takes what the scene has. */
static ad_status check_support(const experiment *e, ad_error *error)
{
    const char *key = "";
    ad_error reason;
    return support_check(e->scene, support_formulation(e->scene), &key, &reason) == AD_OK
               ? AD_OK
               : experiment_refuse(e, key, reason.message, error);
}

/* The model of a family in the strain form, learnt from members. */
static ad_status build_family(experiment *e, ad_error *error)
{
    const train_settings *settings = e->settings;
    const targets_settings members = {.solved = settings->members,
                                      .file = settings->members_file,
                                      .sampler = settings->losses.interior.sampler,
                                      .inputs = settings->groups,
                                      .ranks = settings->ranks};
    ad_status status = targets_create(e->scene, &members, e->pool, &e->targets, error);
    if (status == AD_OK) {
        const model_source source = targets_source(e->targets);
        const groups *inputs = family_groups(targets_family(e->targets));
        for (int i = 0; i < groups_count(inputs); i++) {
            e->settings->network.range[i] = groups_range(inputs, i);
        }
        status = family_model(targets_family(e->targets), &source,
                              settings->network.hidden_count == 0, &e->model, error);
    }
    if (status == AD_BAD_ARGUMENT) {
        char problem[sizeof error->message + 64];
        snprintf(problem, sizeof problem, "strain: %s; others by formulation: mixed",
                 error->message);
        status = experiment_refuse(e, "formulation", problem, error);
    }
    return status;
}

/* The model of one motion in the strain form. */
static ad_status build_motion(experiment *e, ad_error *error)
{
    ad_status status = modes_model_create(e->scene, e->settings->modes, &e->modes, error);
    e->model = e->modes ? modes_model_physics(e->modes) : NULL;
    return status;
}

static ad_status build_model(experiment *e, ad_error *error)
{
    if (e->model) {
        return AD_OK;
    }
    if (e->scene->formulation != SCENE_STRAIN_FORM) {
        return model_of_scene(e->scene, &e->settings->weights, &e->model, error);
    }
    ad_status status = check_support(e, error);
    return status != AD_OK              ? status
           : scene_is_dynamic(e->scene) ? build_motion(e, error)
                                        : build_family(e, error);
}

/* What stands against finding unknowns beside the network. */
static ad_status check_unknowns(const experiment *e, ad_error *error)
{
    const scene *open = e->scene;
    const train_settings *settings = e->settings;
    const scene_parameter *which = NULL;
    const char *common = scene_common_key(open, true, &which);
    const struct {
        bool is_so;
        const char *key, *problem;
    } obstacles[] = {
        {settings->data_count == 0, "data",
         "is needed, as there are parameters to be identified; give measurements, or a number"},
        {scene_is_family(open), "parameters",
         "have ranges beside those that are to be identified; cpinn-solve identifies them, a "
         "network takes numbers for the others"},
        {train_names_reference(settings) && !settings->reference_file, "reference",
         "is solved with numbers, but the scene has unknowns; allowed: file"},
        {common != NULL, common,
         "is to be identified, but has to be a number for a network; cpinn-solve identifies it"}};
    for (size_t i = 0; open->unknown_count > 0 && i < sizeof obstacles / sizeof *obstacles; i++) {
        if (obstacles[i].is_so) {
            return experiment_refuse(e, obstacles[i].key, obstacles[i].problem, error);
        }
    }
    return open->unknown_count > 0 ? check_support(e, error) : AD_OK;
}

static ad_status build(experiment *e, int threads, ad_error *error)
{
    train_settings *settings = e->settings;
    const scene *scene = e->scene;
    nn_rng rng = nn_rng_split(settings->seed, "network");
    ad_status status = ad_pool_open(threads, &e->pool, error);
    status = status == AD_OK ? check_unknowns(e, error) : status;
    status = status == AD_OK ? build_model(e, error) : status;
    if (status != AD_OK) {
        return status;
    }
    settings->network.inputs = e->model->inputs ? e->model->inputs : e->model->domain.count;
    settings->network.outputs = e->model->outputs;
    settings->network.scalars = e->model->scene.unknown_count;
    settings->network.pieces = domain_pieces(&e->model->domain);
    status = nn_mlp_create(&settings->network, &rng, &e->mlp, error);
    if (status != AD_OK) {
        return status;
    }
    e->count = nn_mlp_parameters(e->mlp);
    size_t numbers = e->count * (size_t)scene->windows;
    e->parameters = calloc(numbers, sizeof *e->parameters);
    size_t states = (size_t)scene->windows * window_state_numbers(e->model);
    e->starts = calloc(states + 1, sizeof *e->starts);
    if (!e->parameters || !e->starts) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu parameters", numbers);
    }
    nn_mlp_initialize(e->mlp, &rng, e->parameters);
    return window_state_create(e->model, e->mlp, e->pool, &e->window_state, error);
}

static void free_origin(const train_origin *origin)
{
    if (origin->free) {
        origin->free(origin->context);
    }
}

/* What it is of. */
static ad_status shell(const scene *rod_scene, train_settings *settings, const train_origin *origin,
                       experiment **result, ad_error *error)
{
    experiment *e = *result = calloc(1, sizeof *e);
    if (!e) {
        free_origin(origin);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an experiment");
    }
    e->scene = rod_scene;
    e->settings = settings;
    e->origin = *origin;
    return AD_OK;
}

/* own: NULL, for the model of the scene. */
static ad_status create(const scene *rod_scene, physics_model *own, train_settings *settings,
                        const train_origin *origin, int threads, experiment **result,
                        ad_error *error)
{
    ad_status status = shell(rod_scene, settings, origin, result, error);
    if (status == AD_OK) {
        (*result)->model = own;
        (*result)->is_lent = own != NULL;
        status = build(*result, threads, error);
    }
    if (status != AD_OK) {
        experiment_free(*result);
        *result = NULL;
    }
    return status;
}

ad_status experiment_create(const scene *rod_scene, train_settings *settings,
                            const train_origin *origin, int threads, experiment **result,
                            ad_error *error)
{
    return create(rod_scene, NULL, settings, origin, threads, result, error);
}

ad_status experiment_without_network(const scene *rod_scene, train_settings *settings,
                                     const train_origin *origin, experiment **result,
                                     ad_error *error)
{
    char key[TRAIN_KEY_MAX];
    ad_error reason;
    ad_status status = shell(rod_scene, settings, origin, result, error);
    if (status != AD_OK) {
        return status;
    }
    status = train_check_reference(settings, rod_scene, key, &reason);
    status = status == AD_BAD_INPUT ? experiment_refuse(*result, key, reason.message, error)
             : status != AD_OK      ? ad_fail(error, status, "%s", reason.message)
                                    : ad_pool_open(1, &(*result)->pool, error);
    if (status != AD_OK) {
        experiment_free(*result);
        *result = NULL;
    }
    return status;
}

ad_status experiment_of_model(physics_model *m, train_settings *settings,
                              const train_origin *origin, int threads, experiment **result,
                              ad_error *error)
{
    return create(&m->scene, m, settings, origin, threads, result, error);
}

void experiment_free(experiment *e)
{
    if (e) {
        window_state_free(e->window_state);
        targets_free(e->targets);
        ad_pool_free(e->pool);
        nn_mlp_free(e->mlp);
        modes_model_free(e->modes);
        if (!e->is_lent && !e->modes) {
            model_free(e->model);
        }
        measured_free(e->measured);
        free_origin(&e->origin);
        free(e->parameters);
        free(e->starts);
        free(e);
    }
}

ad_status experiment_refuse(const experiment *e, const char *key, const char *problem,
                            ad_error *error)
{
    const train_origin *origin = &e->origin;
    return origin->refuse ? origin->refuse(origin->context, key, problem, error)
                          : ad_fail(error, AD_BAD_INPUT, "%s: %s", key, problem);
}

const char *experiment_text_item(const experiment *e)
{
    return e->is_lent ? "physics/text" : "scene/yaml";
}

double *experiment_parameters(const experiment *e)
{
    return e->parameters + (size_t)e->window * e->count;
}

const double *experiment_member_values(const experiment *e, double *values)
{
    const scene *open = e->scene;
    const int known = scene_known_count(open);
    const double *scalars = experiment_parameters(e) + e->count - (size_t)open->unknown_count;
    scene_middle_values(open, values);
    for (int i = known; i < open->parameter_count; i++) {
        values[i] = scene_unknown_value(&open->parameters[i], open->guess[i], scalars[i - known]);
    }
    return values;
}

ad_status experiment_choose_member(const experiment *e, const char *at, double *values,
                                   ad_error *error)
{
    const scene *open = e->scene;
    experiment_member_values(e, values);
    return at ? scene_member_read(scene_known_count(open), open->parameters, false, at, values,
                                  error)
              : AD_OK;
}

ad_status experiment_field(const experiment *e, const double *member, field **result,
                           ad_error *error)
{
    double values[SCENE_PARAMETERS_MAX];
    const ad_status status = field_create(e->model, e->mlp, false, e->pool, result, error);
    if (status == AD_OK) {
        field_enter(*result, e->window, e->parameters, e->starts);
        field_member(*result, member ? member : experiment_member_values(e, values));
    }
    return status;
}

double experiment_until(const experiment *e)
{
    const domain *d = &e->model->domain;
    return d->time < 0 ? 0
           : e->model->has_scene && e->window + 1 == d->windows
               ? scene_duration(e->scene) /* to the last bit */
               : domain_window_time(d, e->window + 1) * d->coordinates[d->time].scale;
}

evaluator_model experiment_trained(const experiment *e)
{
    return (evaluator_model){.physics = e->model,
                             .mlp = e->mlp,
                             .windows = e->window + 1,
                             .parameters = e->parameters,
                             .starts = e->starts};
}

const double *experiment_start(const experiment *e)
{
    return e->starts + (size_t)e->window * window_state_numbers(e->model);
}

static ad_status add_data(experiment *e, ad_error *error)
{
    char key[TRAIN_KEY_MAX];
    ad_error reason;
    ad_status status = measured_add(e->model, e->settings, &e->measured, key, &reason);
    return status == AD_NO_MEMORY ? ad_fail(error, status, "%s", reason.message)
           : status != AD_OK      ? experiment_refuse(e, key, reason.message, error)
                                  : AD_OK;
}

/* Members of a file are as many as they are: least squares take them all. */
static ad_status draw_targets(experiment *e, ad_error *error)
{
    train_settings *settings = e->settings;
    ad_error reason;
    ad_status status = targets_draw(e->targets, settings->seed, &reason);
    if (status != AD_OK) {
        return settings->members_file && status == AD_BAD_INPUT
                   ? experiment_refuse(e, "members.file", reason.message, error)
                   : ad_fail(error, status, "%s", reason.message);
    }
    if (settings->members_file && settings->network.hidden_count == 0) {
        settings->losses.interior.points = (int)targets_drawn(e->targets).solved;
    }
    return AD_OK;
}

ad_status experiment_problem(experiment *e, problem **result, ad_error *error)
{
    bool reads = e->settings->data_count > 0 && !e->measured;
    ad_status status = e->is_lent ? AD_OK : check_support(e, error);
    status = status == AD_OK && reads ? add_data(e, error) : status;
    if (status == AD_OK && e->targets) {
        status = draw_targets(e, error);
    }
    return status == AD_OK ? problem_create(e->model, e->mlp, &e->settings->losses,
                                            e->settings->seed, e->pool, result, error)
                           : status;
}

ad_status experiment_next_window(experiment *e, ad_error *error)
{
    double *end = e->starts + ((size_t)e->window + 1) * window_state_numbers(e->model);
    ad_status status = window_state_run(e->window_state, e->window, experiment_start(e),
                                        experiment_parameters(e), end, error);
    e->window += status == AD_OK;
    return status;
}

/* ---- checkpoints --------------------------------------------------------------------------- */

enum { ITEM_NAME_MAX = NN_NAME_MAX + 48 };

static void item_name(const experiment *e, int window, const nn_view *view,
                      char name[ITEM_NAME_MAX])
{
    char group[24] = "";
    if (e->scene->windows > 1) {
        snprintf(group, sizeof group, "window%d/", window + 1);
    }
    snprintf(name, ITEM_NAME_MAX, "parameters/%snetwork/%s", group, view->name);
}

static void put_parameters(const experiment *e, int window, const double *parameters,
                           checkpoint *file)
{
    const nn_view *views;
    int count = nn_mlp_views(e->mlp, &views);
    for (int i = 0; i < count; i++) {
        char name[ITEM_NAME_MAX];
        item_name(e, window, &views[i], name);
        size_t shape[2] = {(size_t)views[i].rows, (size_t)views[i].columns};
        int rank = views[i].columns > 1 || strstr(name, "/weight") ? 2 : 1;
        checkpoint_put_doubles(file, name, parameters + views[i].offset, rank, shape);
    }
}

static const struct {
    const char *name;
    double *(*of)(nn_mlp *mlp, int *rows, int *columns);
} bases[] = {{"network/basis", nn_mlp_basis}, {"network/edge_basis", nn_mlp_edge_basis}};

static void put_features(const experiment *e, checkpoint *file)
{
    size_t frequencies;
    int rows, columns;
    const double *fourier = nn_mlp_fourier(e->mlp, &frequencies);
    if (fourier) {
        size_t inputs = (size_t)e->settings->network.inputs;
        size_t shape[2] = {frequencies / inputs, inputs};
        checkpoint_put_doubles(file, "network/fourier", fourier, 2, shape);
    }
    for (size_t i = 0; i < sizeof bases / sizeof *bases; i++) {
        const double *basis = bases[i].of(e->mlp, &rows, &columns);
        size_t shape[2] = {(size_t)rows, (size_t)columns};
        if (basis) {
            checkpoint_put_doubles(file, bases[i].name, basis, 2, shape);
        }
    }
}

/* Modes of a family. */
static void list_family(const experiment *e, family_array arrays[FAMILY_ARRAYS],
                        char names[FAMILY_ARRAYS][ITEM_NAME_MAX])
{
    family_arrays(targets_family(e->targets), arrays);
    for (int i = 0; i < FAMILY_ARRAYS; i++) {
        snprintf(names[i], ITEM_NAME_MAX, "family/%s", arrays[i].name);
    }
}

static void put_family(const experiment *e, checkpoint *file)
{
    family_array arrays[FAMILY_ARRAYS];
    char names[FAMILY_ARRAYS][ITEM_NAME_MAX];
    list_family(e, arrays, names);
    for (int i = 0; i < FAMILY_ARRAYS; i++) {
        const size_t shape[2] = {arrays[i].rows, arrays[i].columns};
        checkpoint_put_doubles(file, names[i], arrays[i].data, 2, shape);
    }
}

static ad_status get_family(experiment *e, const checkpoint *file, ad_error *error)
{
    family_array arrays[FAMILY_ARRAYS];
    char names[FAMILY_ARRAYS][ITEM_NAME_MAX];
    ad_status status = AD_OK;
    list_family(e, arrays, names);
    for (int i = 0; i < FAMILY_ARRAYS && status == AD_OK; i++) {
        const size_t numbers = arrays[i].rows * arrays[i].columns;
        status = checkpoint_get_doubles(file, names[i], arrays[i].data, numbers, error);
    }
    return status;
}

void experiment_put(experiment *e, const double *parameters, checkpoint *file)
{
    for (int i = 0; i < e->window; i++) {
        put_parameters(e, i, e->parameters + (size_t)i * e->count, file);
    }
    put_parameters(e, e->window, parameters, file);
    if (e->scene->windows > 1) {
        checkpoint_put_integer(file, "training/window", e->window);
    }
    put_features(e, file);
    if (e->targets) {
        put_family(e, file);
    }
}

static ad_status get_parameters(experiment *e, int window, const checkpoint *file, ad_error *error)
{
    const nn_view *views;
    int count = nn_mlp_views(e->mlp, &views);
    double *parameters = e->parameters + (size_t)window * e->count;
    ad_status status = AD_OK;
    for (int i = 0; i < count && status == AD_OK; i++) {
        char name[ITEM_NAME_MAX];
        item_name(e, window, &views[i], name);
        size_t numbers = (size_t)views[i].rows * (size_t)views[i].columns;
        status = checkpoint_get_doubles(file, name, parameters + views[i].offset, numbers, error);
    }
    return status;
}

static ad_status get_features(experiment *e, const checkpoint *file, ad_error *error)
{
    size_t frequencies;
    int rows, columns;
    double *fourier = nn_mlp_fourier(e->mlp, &frequencies);
    ad_status status = AD_OK;
    if (fourier) {
        status = checkpoint_get_doubles(file, "network/fourier", fourier, frequencies, error);
    }
    for (size_t i = 0; i < sizeof bases / sizeof *bases && status == AD_OK; i++) {
        double *basis = bases[i].of(e->mlp, &rows, &columns);
        size_t numbers = (size_t)rows * (size_t)columns;
        status = basis ? checkpoint_get_doubles(file, bases[i].name, basis, numbers, error) : AD_OK;
    }
    return status;
}

ad_status experiment_get(experiment *e, const checkpoint *file, ad_error *error)
{
    int windows = e->scene->windows;
    int64_t window = 0;
    ad_status status = AD_OK;
    if (windows > 1) {
        status = checkpoint_get_integer(file, "training/window", 0, windows - 1, &window, error);
    }
    for (int i = 0; i <= window && status == AD_OK; i++) {
        status = get_parameters(e, i, file, error);
    }
    status = status == AD_OK ? get_features(e, file, error) : status;
    status = status == AD_OK && e->targets ? get_family(e, file, error) : status;
    e->window = 0;
    while (status == AD_OK && e->window < window) {
        status = experiment_next_window(e, error);
    }
    return status;
}
