/* Trained models: by training, or from a checkpoint. */
#include "tools/library/cpinn.h"

#include "autodiff/host.h"
#include "tools/prepare/config_session.h"
#include "tools/train/experiment_own.h"
#include "tools/train/report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NAME_MAX_ = 32 };

struct cpinn_model {
    session s; /* of an opened model the experiment alone */
    run_folder folder;
    cpinn_options options;
    verdict verdict;
    double estimate;
    char names[HISTORY_COLUMNS_MAX][NAME_MAX_]; /* of the history */
    int columns;
    size_t count;
    double *rows;             /* [count][columns] */
    train_settings *settings; /* of physics of one's own: */
    physics_model *physics;   /* of one's own, as networks have it */
    experiment_own own;
};

const char *cpinn_version(void)
{
    return CPINN_VERSION;
}

void cpinn_free(cpinn_model *model)
{
    if (model) {
        run_end(&model->folder);
        session_free(&model->s);
        free(model->rows);
        free(model->settings);
        model_free(model->physics);
        free(model);
    }
}

static ad_status make(cpinn_model **model, ad_error *error)
{
    *model = calloc(1, sizeof **model);
    return *model ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a model");
}

/* `model` where the status is AD_OK, else nothing. */
static ad_status hand_over(cpinn_model *made, ad_status status, cpinn_model **model)
{
    if (status != AD_OK) {
        cpinn_free(made);
    }
    *model = status == AD_OK ? made : NULL;
    return status;
}

/* ---- training ------------------------------------------------------------------------------ */

static bool report_step(void *context)
{
    const cpinn_model *model = context;
    const fit_place *before = &trainer_fit(model->s.trainer)->before;
    const fit *f = trainer_fit(model->s.trainer);
    const trainer_info *now = trainer_inspect(model->s.trainer);
    const cpinn_progress progress = {.step = f->at.step,
                                     .window = before->window + 1,
                                     .windows = model->s.e->scene->windows,
                                     .stage = before->stage + 1,
                                     .stages = model->s.e->settings->stage_count,
                                     .load_factor = before->part,
                                     .loss = f->loss,
                                     .held_out = f->held_out,
                                     .error = now->errors.position,
                                     .seconds = fit_seconds(f)};
    return model->options.progress(model->options.context, &progress);
}

static ad_status keep_history(cpinn_model *model, ad_error *error)
{
    const history *h = &trainer_fit(model->s.trainer)->rows;
    size_t numbers = h->count * (size_t)h->columns;
    model->rows = malloc((numbers + 1) * sizeof *model->rows);
    if (!model->rows) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the history of training");
    }
    if (numbers > 0) {
        memcpy(model->rows, h->rows, numbers * sizeof *model->rows);
    }
    model->count = h->count;
    model->columns = h->columns;
    for (int i = 0; i < h->columns; i++) {
        snprintf(model->names[i], NAME_MAX_, "%s", h->names[i]);
    }
    return AD_OK;
}

/* From the first step to the last. */
static ad_status go_through(cpinn_model *model, ad_error *error)
{
    session *s = &model->s;
    ad_status status = session_train(s, model->options.progress ? report_step : NULL, model, error);
    if (status != AD_OK) {
        return status;
    }
    memcpy(experiment_parameters(s->e), trainer_parameters(s->trainer),
           s->e->count * sizeof(double));
    trainer_verdict(s->trainer, &model->verdict);
    model->estimate = trainer_estimate(s->trainer);
    return keep_history(model, error);
}

/* In memory, or in the folder of the options. */
static ad_status begin(cpinn_model *model, ad_error *error)
{
    const cpinn_options *o = &model->options;
    ad_status status = o->folder ? run_name(&model->folder, o->folder, error) : AD_OK;
    return status == AD_OK && o->folder ? session_begin(&model->s, &model->folder, o->resume, error)
                                        : status;
}

static ad_status train(cpinn_model *model, config *settings, ad_error *error)
{
    ad_status status = config_session_create(settings, model->options.threads, &model->s, error);
    status = status == AD_OK ? begin(model, error) : status;
    return status == AD_OK ? go_through(model, error) : status;
}

static ad_status train_config(config *settings, const cpinn_options *options, cpinn_model **model,
                              ad_error *error)
{
    cpinn_model *made;
    ad_status status = make(&made, error);
    if (status != AD_OK) {
        config_free(settings);
        return status;
    }
    made->options = options ? *options : (cpinn_options){.threads = 0};
    return hand_over(made, train(made, settings, error), model);
}

ad_status cpinn_train_file(const char *path, int count, const char *const *overrides,
                           const cpinn_options *options, cpinn_model **model, ad_error *error)
{
    AD_LEAVE_HOST;
    config *settings;
    *model = NULL;
    ad_status status = prepare_read(path, NULL, count, overrides, &settings, error);
    if (status == AD_OK && surrogate_is_given(&settings->surrogate)) {
        config_free(settings);
        return ad_fail(error, AD_BAD_INPUT,
                       "%s: surrogate: is of a one-step model, which the program cpinn-train "
                       "trains; allowed: a scene without that section",
                       path);
    }
    return status == AD_OK ? train_config(settings, options, model, error) : status;
}

ad_status cpinn_train_scene(const scene *rod_scene, const train_settings *settings,
                            const cpinn_options *options, cpinn_model **model, ad_error *error)
{
    AD_LEAVE_HOST;
    const train_settings usual = train_settings_default();
    config *made;
    *model = NULL;
    ad_status status = prepare_create(rod_scene, settings ? settings : &usual, &made, error);
    return status == AD_OK ? train_config(made, options, model, error) : status;
}

/* ---- physics of one's own ------------------------------------------------------------------- */

/* Settings resolved and checked. */
static ad_status settle(train_settings *settings, physics_model *physics, ad_error *error)
{
    char key[TRAIN_KEY_MAX];
    ad_error why;
    ad_status status = model_check(physics, error);
    if (status != AD_OK) {
        return status;
    }
    if (physics->has_scene) { /* and so resolved before the model was made of it */
        status = train_settings_check(settings, &physics->scene, key, &why);
    } else {
        status = train_settings_resolve_model(settings, physics, key, &why);
        status =
            status == AD_OK ? train_settings_check_model(settings, physics, key, &why) : status;
    }
    return status == AD_OK ? AD_OK : ad_fail(error, status, "%s: %s", key, why.message);
}

/* A model with its own settings, which are resolved. */
static ad_status make_own(physics_model *physics, const train_settings *settings,
                          cpinn_model **result, ad_error *error)
{
    cpinn_model *made;
    ad_status status = make(&made, error);
    if (status != AD_OK) {
        return status;
    }
    made->settings = malloc(sizeof *made->settings);
    if (!made->settings) {
        return hand_over(made, ad_fail(error, AD_NO_MEMORY, "out of memory for settings"), result);
    }
    *made->settings = settings ? *settings : train_settings_default();
    status = model_for_network(physics, &made->physics, error);
    made->own = (experiment_own){.model = made->physics, .settings = made->settings};
    return hand_over(made, status == AD_OK ? settle(made->settings, made->physics, error) : status,
                     result);
}

static ad_status train_own(cpinn_model *model, physics_model *physics, ad_error *error)
{
    const train_origin origin = experiment_own_origin(&model->own);
    session *s = &model->s;
    ad_status status =
        session_prepare_model(physics, model->settings, &origin, model->options.threads, s, error);
    status = status == AD_OK ? session_start(s, error) : status;
    status = status == AD_OK ? begin(model, error) : status;
    return status == AD_OK ? go_through(model, error) : status;
}

ad_status cpinn_train_physics(physics_model *physics, const train_settings *settings,
                              const cpinn_options *options, cpinn_model **model, ad_error *error)
{
    AD_LEAVE_HOST;
    ad_status status = make_own(physics, settings, model, error);
    if (status != AD_OK) {
        return status;
    }
    cpinn_model *made = *model;
    made->options = options ? *options : (cpinn_options){.threads = 0};
    return hand_over(made, train_own(made, made->physics, error), model);
}

ad_status cpinn_save(cpinn_model *model, const char *path, ad_error *error)
{
    AD_LEAVE_HOST;
    if (!model->s.trainer) {
        return ad_fail(error, AD_BAD_ARGUMENT,
                       "%s: the model was opened from a checkpoint; copy that file", path);
    }
    return fit_save(model->s.fit, &(file_place){.path = path}, error);
}

/* ---- opening ------------------------------------------------------------------------------- */

static ad_status read_history(cpinn_model *model, const checkpoint *file, ad_error *error)
{
    static const char item[] = "history/table";
    int rank;
    size_t shape[CHECKPOINT_MAX_RANK];
    if (!checkpoint_shape(file, item, &rank, shape) || rank != 2 ||
        shape[1] > HISTORY_COLUMNS_MAX) {
        return ad_fail(error, AD_BAD_INPUT, "checkpoint: %s is missing or of another shape", item);
    }
    size_t numbers = shape[0] * shape[1];
    model->rows = malloc((numbers + 1) * sizeof *model->rows);
    if (!model->rows) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the history of training");
    }
    model->count = shape[0];
    model->columns = (int)shape[1];
    for (int i = 0; i < model->columns; i++) {
        const char *name = checkpoint_column(file, item, (size_t)i);
        snprintf(model->names[i], NAME_MAX_, "%s", name ? name : "");
    }
    return checkpoint_get_doubles(file, item, model->rows, numbers, error);
}

static ad_status read_end(cpinn_model *model, const checkpoint *file, ad_error *error)
{
    ad_status status = read_history(model, file, error);
    model->estimate = NAN;
    checkpoint_get_doubles(file, "estimate", &model->estimate, 1, NULL);
    return status == AD_OK ? report_get_verdict(file, &model->verdict, error) : status;
}

ad_status cpinn_open(const char *path, cpinn_model **model, ad_error *error)
{
    AD_LEAVE_HOST;
    cpinn_model *made;
    checkpoint *file = NULL;
    *model = NULL;
    ad_status status = make(&made, error);
    if (status != AD_OK) {
        return status;
    }
    status = config_experiment_open(path, 0, NULL, 1, &made->s.e, &file, error);
    status = status == AD_OK ? read_end(made, file, error) : status;
    checkpoint_free(file);
    return hand_over(made, status, model);
}

static ad_status open_own(cpinn_model *model, physics_model *physics, const char *path,
                          ad_error *error)
{
    char found[4096];
    checkpoint *file;
    const train_origin origin = experiment_own_origin(&model->own);
    ad_status status = run_open_checkpoint(path, found, &file, error);
    if (status == AD_OK) {
        status = experiment_own_check(&model->own, found, file, error);
    }
    if (status == AD_OK) {
        status = experiment_of_model(physics, model->settings, &origin, 1, &model->s.e, error);
    }
    if (status == AD_OK) {
        status = experiment_get(model->s.e, file, error);
    }
    status = status == AD_OK ? read_end(model, file, error) : status;
    checkpoint_free(file);
    return status;
}

ad_status cpinn_open_physics(const char *path, physics_model *physics,
                             const train_settings *settings, cpinn_model **model, ad_error *error)
{
    AD_LEAVE_HOST;
    ad_status status = make_own(physics, settings, model, error);
    return status == AD_OK
               ? hand_over(*model, open_own(*model, (*model)->physics, path, error), model)
               : status;
}

/* ---- looking ------------------------------------------------------------------------------- */

const verdict *cpinn_verdict(const cpinn_model *model)
{
    return &model->verdict;
}

double cpinn_estimate(const cpinn_model *model)
{
    return model->estimate;
}

const scene *cpinn_scene(const cpinn_model *model)
{
    return model->s.e->scene;
}

const train_settings *cpinn_settings(const cpinn_model *model)
{
    return model->s.e->settings;
}

size_t cpinn_history_rows(const cpinn_model *model)
{
    return model->count;
}

int cpinn_history_columns(const cpinn_model *model)
{
    return model->columns;
}

const char *cpinn_history_name(const cpinn_model *model, int column)
{
    return column >= 0 && column < model->columns ? model->names[column] : "";
}

double cpinn_history_value(const cpinn_model *model, size_t row, const char *column)
{
    for (int i = 0; i < model->columns && row < model->count; i++) {
        if (strcmp(model->names[i], column) == 0) {
            return model->rows[row * (size_t)model->columns + (size_t)i];
        }
    }
    return NAN;
}

ad_status cpinn_evaluator(const cpinn_model *model, const char *names, evaluator **result,
                          ad_error *error)
{
    AD_LEAVE_HOST;
    const evaluator_model trained = experiment_trained(model->s.e);
    return evaluator_create(&trained, names, result, error);
}
