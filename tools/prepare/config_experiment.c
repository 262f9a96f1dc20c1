#include "tools/prepare/config_session.h"

#include "tools/files/file_bytes.h"
#include "tools/train/measurements.h"
#include "tools/train/robust.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- making -------------------------------------------------------------------------------- */

static ad_status write_all(void *context, FILE *file)
{
    return config_write(context, file, false);
}

static ad_status write_physics(void *context, FILE *file)
{
    return config_write_physics(context, file);
}

static void free_config(void *context)
{
    config_free(context);
}

static ad_status refuse(void *context, const char *key, const char *problem, ad_error *error)
{
    return config_refuse(context, key, problem, error);
}

static ad_status continues(void *context, const char *path, const char *text, int64_t stage,
                           ad_error *error)
{
    static const char *const anywhere[] = {"reference.file=null"}; /* it may have moved */
    config *before;
    ad_error why;
    ad_status status = config_read(path, text, 1, anywhere, &before, error);
    status = status == AD_OK ? prepare_choices(before, error) : status;
    status = status == AD_OK ? prepare_training(before, error) : status;
    if (status != AD_OK) {
        config_free(before);
        return status;
    }
    int count = before->settings.stage_count;
    status =
        config_continues(before, context, stage < 0 || stage > count ? count : (int)stage, &why);
    if (status != AD_OK) {
        ad_fail(error, status, "%s: %s", file_bytes_shown(path), why.message);
    }
    config_free(before);
    return status;
}

train_origin config_origin(config *settings)
{
    return (train_origin){.context = settings,
                          .write = write_all,
                          .write_physics = write_physics,
                          .refuse = refuse,
                          .continues = continues,
                          .free = free_config};
}

/* What is to be trained; frees settings that fail. */
static ad_status choose(config *settings, ad_error *error)
{
    const ad_status status = prepare_training(settings, error);
    if (status != AD_OK) {
        config_free(settings);
    }
    return status;
}

ad_status config_experiment_create(config *settings, int threads, experiment **result,
                                   ad_error *error)
{
    const train_origin origin = config_origin(settings);
    *result = NULL;
    const ad_status status = choose(settings, error);
    if (status != AD_OK) {
        return status;
    }
    return experiment_create(&settings->scene, &settings->settings, &origin, threads, result,
                             error);
}

ad_status config_experiment_without_network(config *settings, experiment **result, ad_error *error)
{
    const train_origin origin = config_origin(settings);
    return experiment_without_network(&settings->scene, &settings->settings, &origin, result,
                                      error);
}

ad_status config_session_prepare(config *settings, int threads, session *s, ad_error *error)
{
    const train_origin origin = config_origin(settings);
    const ad_status status = choose(settings, error);
    if (status != AD_OK) {
        *s = (session){.e = NULL};
        return status;
    }
    return session_prepare(&settings->scene, &settings->settings, &origin, threads, s, error);
}

ad_status config_session_create(config *settings, int threads, session *s, ad_error *error)
{
    ad_status status = config_session_prepare(settings, threads, s, error);
    return status == AD_OK ? session_start(s, error) : status;
}

/* ---- unknowns ------------------------------------------------------------------------------ */

static ad_status check_unknowns(const config *settings, ad_error *error)
{
    const scene *open = &settings->scene;
    char key[80];
    if (open->unknown_count == 0) {
        return config_refuse(settings, "parameters",
                             "have no unknown; give one as {identify: GUESS, range: [LOW, HIGH]}",
                             error);
    }
    snprintf(key, sizeof key, "parameters.%s", open->parameters[scene_known_count(open)].name);
    return settings->settings.data_count > 0
               ? AD_OK
               : config_refuse(settings, key,
                               "is to be identified, but there are no measurements; give data, or "
                               "a value",
                               error);
}

/* By squares, or by what else some files are. */
static ad_status find(const scene *open, const train_data *files, const measurements *data,
                      const identify_settings *asked, identified *found, ad_error *error)
{
    const int count = measurements_count(data);
    const solve_measured *sets = measurements_sets(data);
    bool robust[TRAIN_DATA_MAX], any = false;
    for (int i = 0; i < count; i++) {
        robust[i] = files[measurements_entry(data, i)].robust == TRAIN_CAUCHY;
        any = any || robust[i];
    }
    return any ? identify_robust(open, count, sets, robust, asked, found, error)
               : identify(open, count, sets, asked, found, error);
}

/* What is wrong with data, with the place of its key. */
static ad_status blame(const config *settings, ad_status status, const char *key,
                       const ad_error *reason, ad_error *error)
{
    return status == AD_OK ? AD_OK
           : status == AD_BAD_INPUT || status == AD_IO
               ? config_refuse(settings, key, reason->message, error)
               : ad_fail(error, status, "%s", reason->message);
}

ad_status config_identify(const config *settings, int threads, const int *modes,
                          const least_squares_runner *runner, identified *found, ad_error *error)
{
    const scene *open = &settings->scene;
    measurements *data = NULL;
    char key[TRAIN_KEY_MAX] = "data";
    ad_error reason = {.message = ""};
    ad_status status = check_unknowns(settings, error);
    if (status != AD_OK) {
        return status;
    }
    status = measurements_read(open, &settings->settings, &data, key, &reason);
    if (status == AD_OK) {
        const identify_settings asked = {.threads = threads,
                                         .noise_is_scaled = !measurements_tell_noise(data),
                                         .runner = runner};
        snprintf(key, sizeof key, "data");
        if (modes) {
            measurements_set_modes(data, modes);
        }
        status = find(open, settings->settings.data, data, &asked, found, &reason);
        found->missing = measurements_missing(data);
    }
    measurements_free(data);
    return blame(settings, status, key, &reason, error);
}

ad_status config_judge(const config *settings, int threads, const int *modes,
                       const identified *found, judged *result, judged_rows **rows, ad_error *error)
{
    const scene *open = &settings->scene;
    const train_settings *given = &settings->settings;
    const char *const nobody[] = {NULL};
    measurements *data = NULL;
    char key[TRAIN_KEY_MAX] = "data";
    ad_error reason = {.message = ""};
    ad_status status = found->count > 0
                           ? measurements_read(open, given, &data, key, &reason)
                           : measurements_read_beside(open, given, 0, nobody, &data, key, &reason);
    if (status == AD_OK) {
        const double deviation = found->count > 0                ? found->noise_factor
                                 : measurements_tell_noise(data) ? 1
                                                                 : NAN;
        snprintf(key, sizeof key, "data");
        if (modes) {
            measurements_set_modes(data, modes);
        }
        status = measured_judge(open, data, given, found->value, deviation, threads, result, rows,
                                &reason);
    }
    measurements_free(data);
    return blame(settings, status, key, &reason, error);
}

/* ---- restoring ----------------------------------------------------------------------------- */

static ad_status read_trained(const char *name, const char *text, int count,
                              const char *const *overrides, config **settings, ad_error *error)
{
    ad_status status = prepare_read(name, text, count, overrides, settings, error);
    return status == AD_OK ? choose(*settings, error) : status;
}

/* The resolved scene of a checkpoint. When only its reference file is to blame the scene is read
 * without it, and `warning` receives the reason. */
static ad_status read_scene(const char *path, const char *text, int count,
                            const char *const *overrides, config **settings, char warning[512],
                            ad_error *error)
{
    char name[4096 + 16];
    snprintf(name, sizeof name, "%s:scene/yaml", path);
    ad_status status = read_trained(name, text, count, overrides, settings, error);
    warning[0] = '\0';
    if (status != AD_BAD_INPUT) {
        return status;
    }
    char stops[TRAIN_STAGES_MAX][48]; /* no error to stop at without the reference */
    const char **more = malloc(((size_t)count + 1 + TRAIN_STAGES_MAX) * sizeof *more);
    if (!more) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the scene of a checkpoint");
    }
    for (int i = 0; i < count; i++) {
        more[i] = overrides[i];
    }
    more[count] = "reference.file=null";
    for (int i = 0; i <= TRAIN_STAGES_MAX && status != AD_OK; i++) {
        status = read_trained(name, text, count + 1 + i, more, settings, NULL);
        if (i < TRAIN_STAGES_MAX) {
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
    status = config_experiment_create(settings, threads, result, error);
    if (status == AD_OK) {
        snprintf((*result)->warning, sizeof(*result)->warning, "%s", warning);
        status = experiment_get(*result, file, error);
    }
    if (status == AD_OK && count > 0) {
        status = continues(settings, path, text, -1, error);
    }
    return status;
}

ad_status config_experiment_open(const char *path, int count, const char *const *overrides,
                                 int threads, experiment **result, checkpoint **file,
                                 ad_error *error)
{
    char found[4096];
    checkpoint *opened = NULL;
    *result = NULL;
    if (file) {
        *file = NULL;
    }
    ad_status status = run_open_checkpoint(path, found, &opened, error);
    if (status == AD_OK && checkpoint_has(opened, "surrogate/numbers")) {
        status = ad_fail(
            error, AD_BAD_INPUT,
            "%s: is of a one-step model, which is opened as such, not as a network of a scene",
            found);
    }
    if (status == AD_OK && checkpoint_has(opened, "physics/text")) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "%s: is of physics of one's own, whose equations are in the program that "
                         "trained it; there cpinn_open_physics opens it",
                         file_bytes_shown(found));
    }
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
