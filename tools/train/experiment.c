#include "tools/train/experiment.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int thread_count(int threads)
{
    if (threads > 0) {
        return threads;
    }
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    return processors > 0 ? (int)processors : 1;
}

static ad_status build(experiment *e, int threads, ad_error *error)
{
    config *settings = e->settings;
    nn_rng rng = nn_rng_split(settings->seed, "network");
    settings->network.inputs = rod_network_inputs(&settings->scene);
    settings->network.outputs = model_of(&settings->scene)->network_outputs(&settings->scene);
    ad_status status = nn_mlp_create(&settings->network, &rng, &e->mlp, error);
    if (status != AD_OK) {
        return status;
    }
    e->count = nn_mlp_parameters(e->mlp);
    size_t numbers = e->count * (size_t)settings->scene.windows;
    e->parameters = calloc(numbers, sizeof *e->parameters);
    e->starts = calloc((size_t)settings->scene.windows * ROD_WINDOW_NUMBERS, sizeof *e->starts);
    if (!e->parameters || !e->starts) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for %zu parameters", numbers);
    }
    nn_mlp_initialize(e->mlp, &rng, e->parameters);
    e->pool = ad_pool_create(thread_count(threads));
    if (!e->pool) {
        return ad_fail(error, AD_NO_MEMORY, "%d threads could not be started",
                       thread_count(threads));
    }
    return AD_OK;
}

ad_status experiment_create(config *settings, int threads, experiment **result, ad_error *error)
{
    *result = NULL;
    experiment *e = calloc(1, sizeof *e);
    if (!e) {
        config_free(settings);
        return ad_fail(error, AD_NO_MEMORY, "out of memory for an experiment");
    }
    e->settings = settings;
    ad_status status = build(e, threads, error);
    if (status != AD_OK) {
        experiment_free(e);
        return status;
    }
    *result = e;
    return AD_OK;
}

void experiment_free(experiment *e)
{
    if (e) {
        ad_pool_free(e->pool);
        nn_mlp_free(e->mlp);
        config_free(e->settings);
        free(e->parameters);
        free(e->starts);
        free(e->yaml);
        free(e);
    }
}

char *experiment_yaml(const experiment *e)
{
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    if (!file) {
        return NULL;
    }
    ad_status status = config_write(e->settings, file, false);
    if (fclose(file) != 0 || status != AD_OK) {
        free(text);
        return NULL;
    }
    return text;
}

double *experiment_parameters(const experiment *e)
{
    return e->parameters + (size_t)e->window * e->count;
}

rod_window experiment_window(const experiment *e)
{
    return (rod_window){e->window, e->starts + (size_t)e->window * ROD_WINDOW_NUMBERS};
}

ad_status experiment_next_window(experiment *e, ad_error *error)
{
    const scene *scene = &e->settings->scene;
    const rod_window window = experiment_window(e);
    ad_status status = model_of(scene)->window_end(
        scene, &window, e->mlp, experiment_parameters(e), e->pool,
        e->starts + ((size_t)e->window + 1) * ROD_WINDOW_NUMBERS, error);
    e->window += status == AD_OK;
    return status;
}

/* ---- checkpoints --------------------------------------------------------------------------- */

enum { ITEM_NAME_MAX = NN_NAME_MAX + 48 };

static void item_name(const experiment *e, int window, const nn_view *view,
                      char name[ITEM_NAME_MAX])
{
    char group[24] = "";
    if (e->settings->scene.windows > 1) {
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

static void put_features(const experiment *e, checkpoint *file)
{
    size_t frequencies;
    int rows, columns;
    const double *fourier = nn_mlp_fourier(e->mlp, &frequencies);
    const double *basis = nn_mlp_basis(e->mlp, &rows, &columns);
    if (fourier) {
        size_t inputs = (size_t)e->settings->network.inputs;
        size_t shape[2] = {frequencies / inputs, inputs};
        checkpoint_put_doubles(file, "network/fourier", fourier, 2, shape);
    }
    if (basis) {
        size_t shape[2] = {(size_t)rows, (size_t)columns};
        checkpoint_put_doubles(file, "network/basis", basis, 2, shape);
    }
}

void experiment_put(experiment *e, const double *parameters, checkpoint *file)
{
    if (!e->yaml) {
        e->yaml = experiment_yaml(e);
    }
    checkpoint_put_text(file, "scene/yaml", e->yaml); /* NULL is refused and remembered */
    for (int i = 0; i < e->window; i++) {
        put_parameters(e, i, e->parameters + (size_t)i * e->count, file);
    }
    put_parameters(e, e->window, parameters, file);
    if (e->settings->scene.windows > 1) {
        checkpoint_put_integer(file, "training/window", e->window);
    }
    put_features(e, file);
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
    double *basis = nn_mlp_basis(e->mlp, &rows, &columns);
    ad_status status = AD_OK;
    if (fourier) {
        status = checkpoint_get_doubles(file, "network/fourier", fourier, frequencies, error);
    }
    if (basis && status == AD_OK) {
        size_t numbers = (size_t)rows * (size_t)columns;
        status = checkpoint_get_doubles(file, "network/basis", basis, numbers, error);
    }
    return status;
}

ad_status experiment_get(experiment *e, const checkpoint *file, ad_error *error)
{
    int windows = e->settings->scene.windows;
    int64_t window = 0;
    ad_status status = AD_OK;
    if (windows > 1) {
        status = checkpoint_get_int64(file, "training/window", &window, 1, error);
    }
    if (status == AD_OK && (window < 0 || window >= windows)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "checkpoint: training/window is %lld; 0 to %d are possible",
                       (long long)window, windows - 1);
    }
    for (int i = 0; i <= window && status == AD_OK; i++) {
        status = get_parameters(e, i, file, error);
    }
    status = status == AD_OK ? get_features(e, file, error) : status;
    e->window = 0;
    while (status == AD_OK && e->window < window) {
        status = experiment_next_window(e, error);
    }
    return status;
}

/* The resolved scene of a checkpoint. When only its reference file is to blame the scene is read
 * without it, and `warning` receives the reason. */
static ad_status read_scene(const char *path, const char *text, int count,
                            const char *const *overrides, config **settings, char warning[512],
                            ad_error *error)
{
    char name[4096 + 16];
    snprintf(name, sizeof name, "%s:scene/yaml", path);
    ad_status status = config_read(name, text, count, overrides, settings, error);
    warning[0] = '\0';
    if (status != AD_BAD_INPUT) {
        return status;
    }
    char stops[CONFIG_STAGES_MAX][48]; /* no error to stop at without the reference */
    const char **more = malloc(((size_t)count + 1 + CONFIG_STAGES_MAX) * sizeof *more);
    if (!more) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the scene of a checkpoint");
    }
    for (int i = 0; i < count; i++) {
        more[i] = overrides[i];
    }
    more[count] = "reference.file=null";
    for (int i = 0; i <= CONFIG_STAGES_MAX && status != AD_OK; i++) {
        status = config_read(name, text, count + 1 + i, more, settings, NULL);
        if (i < CONFIG_STAGES_MAX) {
            snprintf(stops[i], sizeof stops[i], "training.stages[%d].stop.error=0", i);
            more[count + 1 + i] = stops[i];
        }
    }
    if (status == AD_OK) {
        snprintf(warning, 512, "%s", error ? error->message : "the reference file is gone");
    }
    free(more);
    return status;
}

static ad_status restore(const checkpoint *file, const char *path, int count,
                         const char *const *overrides, int threads, experiment **result,
                         ad_error *error)
{
    const char *text;
    config *settings = NULL;
    char warning[512];
    ad_error reason;
    ad_status status = checkpoint_get_text(file, "scene/yaml", &text, error);
    if (status != AD_OK) {
        return status;
    }
    status = read_scene(path, text, count, overrides, &settings, warning, &reason);
    if (status != AD_OK) {
        return ad_fail(error, status, "%s", reason.message);
    }
    status = experiment_create(settings, threads, result, error);
    if (status == AD_OK) {
        snprintf((*result)->warning, sizeof(*result)->warning, "%s", warning);
        status = experiment_get(*result, file, error);
    }
    return status;
}

ad_status experiment_open(const char *path, int count, const char *const *overrides, int threads,
                          experiment **result, checkpoint **file, ad_error *error)
{
    char found[4096];
    struct stat info;
    checkpoint *opened = NULL;
    bool folder = stat(path, &info) == 0 && S_ISDIR(info.st_mode);
    *result = NULL;
    if (file) {
        *file = NULL;
    }
    int length = snprintf(found, sizeof found, "%s%s", path, folder ? "/checkpoint.h5" : "");
    if (length < 0 || (size_t)length >= sizeof found) {
        return ad_fail(error, AD_BAD_ARGUMENT, "%.200s...: the path is too long", path);
    }
    ad_status status = checkpoint_open(found, &opened, error);
    if (status == AD_OK) {
        status = restore(opened, found, count, overrides, threads, result, error);
    }
    if (status != AD_OK) {
        experiment_free(*result);
        *result = NULL;
    }
    if (status == AD_OK && file) {
        *file = opened;
    } else {
        checkpoint_free(opened);
    }
    return status;
}
