#include "tools/prepare/prepare.h"

#include "physics/rod/strain.h"
#include "physics/scene/support.h"
#include "physics/solve/solve.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What the library says of `key` of bad input; of anything else there is no place to blame. */
static ad_status blame(const config *config, ad_status status, const char *key,
                       const ad_error *reason, ad_error *error)
{
    return status == AD_OK          ? AD_OK
           : status == AD_BAD_INPUT ? config_refuse(config, key, reason->message, error)
                                    : ad_fail(error, status, "%s", reason->message);
}

/* ---- formulation --------------------------------------------------------------------------- */

/* One motion is learnt by its strain modes in a tenth of the time that the mixed form takes to the
 * same error, where they take it and nothing is given that only the other has. */
static bool takes_modes(const config *config)
{
    static const char *const of_mixed[] = {"network.rotation",
                                           "network.fourier.features",
                                           "network.fourier.wavenumber",
                                           "network.fourier.frequency",
                                           "losses.interior.weights.strain",
                                           "losses.interior.weights.curvature",
                                           "losses.interior.weights.force",
                                           "losses.interior.weights.moment"};
    const train_settings *settings = &config->settings;
    const problem_settings *losses = &settings->losses;
    /* Of windows that are given, up to that of the largest degree (settings_motion.c). */
    const double longest = 2.0 / 3;
    ad_error unused;
    const bool are_short =
        settings->windows == 0 || scene_duration(&config->scene) / settings->windows <=
                                      longest * rod_scales_of(&config->scene).time;
    bool takes = are_short && scene_is_dynamic(&config->scene) &&
                 settings->network.hidden_count <= 0 && losses->causal_slices == 0 &&
                 losses->adaptive.kind == PROBLEM_ADAPTIVE_NONE &&
                 losses->balance == PROBLEM_BALANCE_NONE && losses->interior.resample_every == 0 &&
                 support_check(&config->scene, SUPPORT_STRAIN_MOTION, NULL, &unused) == AD_OK;
    for (int i = 0; i < settings->stage_count; i++) {
        const train_stage *stage = &settings->stages[i];
        takes = takes && train_may_take(stage, OPTIM_GAUSS_NEWTON) &&
                (stage->linear_algebra == TRAIN_LINEAR_AUTOMATIC ||
                 stage->linear_algebra == TRAIN_NORMAL_EQUATIONS);
    }
    for (size_t i = 0; i < sizeof of_mixed / sizeof *of_mixed; i++) {
        takes = takes && !config_gives(config, of_mixed[i]);
    }
    return takes;
}

/* A family is learnt from its members where they can be solved by the thousand: in a hundredth of
 * the time, to a hundredth of the error, that waves of s and the parameters take. */
static ad_status choose_formulation(config *config, ad_error *error)
{
    scene *of = &config->scene, middle;
    if (config_gives(config, "formulation") || of->unknown_count > 0 ||
        config->settings.data_count > 0) {
        return AD_OK;
    }
    if (!scene_is_family(of)) {
        of->formulation = takes_modes(config) ? SCENE_STRAIN_FORM : of->formulation;
        return AD_OK;
    }
    scene_middle(of, &middle);
    ad_status status = strain_takes(&middle, error);
    of->formulation = status == AD_OK ? SCENE_STRAIN_FORM : of->formulation;
    return status == AD_NO_MEMORY ? status : AD_OK;
}

/* ---- choices ------------------------------------------------------------------------------- */

/* Whether a reduced rod is asked for the motion, and no network. */
static bool is_stepped(const config *config)
{
    return config_controls(config) || optimize_motion_is_given(&config->optimize);
}

/* Of unknowns every trial has its own equilibrium, of a one-step model the members follow from the
 * one in the middle of the ranges. */
static ad_status check_start(const config *config, ad_error *error)
{
    const bool steps = surrogate_is_given(&config->surrogate) || is_stepped(config) ||
                       config->scene.unknown_count > 0;
    return config->scene.initial.state != SCENE_EQUILIBRIUM || !scene_is_family(&config->scene) ||
                   steps
               ? AD_OK
               : config_refuse(config, "initial.state",
                               "is solved for before training, but the scene is a family, whose "
                               "members have one each; allowed: given, no parameter with a range, "
                               "or a one-step model",
                               error);
}

/* Of a one-step model; what trains it is among it. */
static ad_status choose_surrogate(config *config, ad_error *error)
{
    ad_error reason;
    char key[TRAIN_KEY_MAX];
    const ad_status status = surrogate_settings_resolve(&config->surrogate, &config->settings,
                                                        &config->scene, key, &reason);
    return blame(config, status, key, &reason, error);
}

static ad_status choose_control(config *config, ad_error *error)
{
    const surrogate_settings model = control_model_of(&config->surrogate);
    ad_error reason;
    char key[TRAIN_KEY_MAX];
    const ad_status status =
        control_settings_resolve(&config->control, &model, &config->scene,
                                 config_gives(config, "control.estimate"), key, &reason);
    return blame(config, status, key, &reason, error);
}

static ad_status choose(config *config, const void *context, ad_error *error)
{
    (void)context;
    ad_error reason;
    char key[TRAIN_KEY_MAX];
    train_close_compared(&config->settings, &config->scene);
    ad_status status =
        blame(config, train_check_data(&config->settings, key, &reason), key, &reason, error);
    if (status == AD_OK && surrogate_is_given(&config->surrogate)) {
        status = choose_surrogate(config, error);
    }
    return status == AD_OK && config_controls(config) ? choose_control(config, error) : status;
}

ad_status prepare_choices(config *config, ad_error *error)
{
    return config_with_points(config, choose, NULL, error);
}

/* A one-step model has been chosen and checked. */
static ad_status choose_training(config *config, const void *context, ad_error *error)
{
    (void)context;
    ad_error reason;
    char key[TRAIN_KEY_MAX];
    ad_status status = check_start(config, error);
    status = status == AD_OK ? choose_formulation(config, error) : status;
    if (status == AD_OK && !surrogate_is_given(&config->surrogate)) {
        status = train_settings_resolve(&config->settings, &config->scene, key, &reason);
        status = blame(config, status, key, &reason, error);
    }
    status = status == AD_OK ? config_check_stages(config, error) : status;
    if (status == AD_OK && !surrogate_is_given(&config->surrogate)) {
        status = train_settings_check(&config->settings, &config->scene, key, &reason);
        status = blame(config, status, key, &reason, error);
    }
    return status;
}

ad_status prepare_training(config *config, ad_error *error)
{
    ad_status status =
        config->is_chosen ? AD_OK : config_with_points(config, choose_training, NULL, error);
    config->is_chosen = status == AD_OK;
    return status;
}

/* ---- the beginning ------------------------------------------------------------------------- */

static ad_status settle(config *config, ad_error *error)
{
    ad_error reason;
    scene *of = &config->scene, middle;
    if (of->initial.state != SCENE_EQUILIBRIUM || (scene_is_open(of) && !scene_is_family(of))) {
        return AD_OK; /* of unknowns every trial does */
    }
    scene_middle(of, &middle);
    ad_status status = solve_settle(&middle, config->names, &reason);
    memcpy(of->initial.settled, middle.initial.settled, sizeof of->initial.settled);
    status = status == AD_BAD_ARGUMENT ? AD_BAD_INPUT : status;
    return blame(config, status, "initial.state", &reason, error);
}

static ad_status check_ends(const config *config, ad_error *error)
{
    ad_error reason;
    const char *key = "";
    scene member;
    scene_middle(&config->scene, &member);
    const ad_status status = scene_physics_of(&member)->check(&member, &key, &reason);
    return blame(config, status, key, &reason, error);
}

static ad_status begin(config *config, const void *context, ad_error *error)
{
    (void)context;
    const ad_status status = settle(config, error);
    return status == AD_OK ? check_ends(config, error) : status;
}

ad_status prepare_start(config *config, ad_error *error)
{
    return config_with_points(config, begin, NULL, error);
}

/* ---- all of it ----------------------------------------------------------------------------- */

ad_status prepare_config(config *config, ad_error *error)
{
    const ad_status status = prepare_choices(config, error);
    return status == AD_OK ? prepare_start(config, error) : status;
}

/* What was read with `status`. */
static ad_status prepare(ad_status status, config **x, ad_error *error)
{
    status = status == AD_OK ? prepare_choices(*x, error) : status;
    status = status == AD_OK ? prepare_start(*x, error) : status;
    if (status != AD_OK) {
        config_free(*x);
        *x = NULL;
    }
    return status;
}

ad_status prepare_read(const char *path, const char *text, int count, const char *const *overrides,
                       config **result, ad_error *error)
{
    return prepare(config_read(path, text, count, overrides, result, error), result, error);
}

ad_status prepare_read_member(const char *path, const char *text, int count,
                              const char *const *overrides, const char *at, config **result,
                              ad_error *error)
{
    return prepare(config_read_member(path, text, count, overrides, at, result, error), result,
                   error);
}

ad_status prepare_create(const scene *rod_scene, const train_settings *settings, config **result,
                         ad_error *error)
{
    return prepare(config_create(rod_scene, settings, result, error), result, error);
}

static ad_status read_plant(const char *path, int count, const char *const *overrides,
                            const config *nominal, config **plant, ad_error *error)
{
    const control_settings *c = &nominal->control;
    char reason[sizeof error->message];
    const char **all = malloc((size_t)(count + c->change_count + 2) * sizeof *all);
    if (!all) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for the keys of a plant");
    }
    if (count > 0) {
        memcpy(all, overrides, (size_t)count * sizeof *all);
    }
    for (int i = 0; i < c->change_count; i++) {
        const char *key = c->changes[i];
        const size_t word = strcspn(key, ".=[");
        if ((word == 7 && memcmp(key, "control", word) == 0) ||
            (word == 9 && memcmp(key, "surrogate", word) == 0)) {
            free(all);
            return ad_fail(error, AD_BAD_INPUT,
                           "%.200s: control.plant.set: %.200s: is nothing of the robot; allowed: "
                           "keys of the scene other than control and surrogate",
                           path, key);
        }
        all[count++] = key;
    }
    all[count++] = "control=null"; /* names that it has may be numbers now */
    if (surrogate_is_given(&nominal->surrogate)) {
        all[count++] = "surrogate=null";
    }
    const ad_status status =
        prepare(config_read(path, NULL, count, all, plant, error), plant, error);
    free(all);
    if (status == AD_OK) {
        return AD_OK;
    }
    snprintf(reason, sizeof reason, "%s", error->message);
    return ad_fail(error, status == AD_NO_MEMORY ? status : AD_BAD_INPUT,
                   "%.200s: control.plant.set: %.280s", path, reason);
}

ad_status prepare_read_robot(const char *path, int count, const char *const *overrides,
                             config **nominal, config **plant, ad_error *error)
{
    ad_status status = prepare_read(path, NULL, count, overrides, nominal, error);
    if (status == AD_OK && !config_controls(*nominal)) {
        status = choose_control(*nominal, error);
    }
    return status == AD_OK && plant ? read_plant(path, count, overrides, *nominal, plant, error)
                                    : status;
}
