#include "tools/surrogate/surrogate_settings.h"

#include "physics/scene/support.h"
#include "tools/surrogate/surrogate_step.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define SURROGATE_NAME(name, text) text,
const char *const *surrogate_kind_names(void)
{
    static const char *const names[] = {SURROGATE_KIND_LIST(SURROGATE_NAME) NULL};
    return names;
}

#undef SURROGATE_NAME

surrogate_settings surrogate_settings_default(void)
{
    return (surrogate_settings){.step = NAN, .tolerance = 5e-3, .solved = 20000};
}

bool surrogate_is_given(const surrogate_settings *settings)
{
    return !isnan(settings->step);
}

bool surrogate_is_among(int count, const char *const *all, const char *name)
{
    for (int i = 0; i < count; i++) {
        if (strcmp(all[i], name) == 0) {
            return true;
        }
    }
    return false;
}

bool surrogate_names_parameter(const surrogate_settings *settings, const char *name)
{
    return surrogate_is_among(settings->parameter_count, settings->parameters, name);
}

/* ---- what is open, and checks -------------------------------------------------------------- */

/* Steps of the optimiser, and the network, that were measured to be worth their time. */
enum { STEPS = 4000, WIDTH = 64 };

static ad_status refuse(char key[TRAIN_KEY_MAX], const char *which, ad_error *error,
                        const char *problem)
{
    snprintf(key, TRAIN_KEY_MAX, "%s", which);
    return ad_fail(error, AD_BAD_INPUT, "%s", problem);
}

/* Names of one list: with ranges, once, and not in the other list. */
static ad_status check_names(const char *list, int count, const char *const *all, int other_count,
                             const char *const *other, const scene *of, char key[TRAIN_KEY_MAX],
                             ad_error *error)
{
    char problem[256], where[TRAIN_KEY_MAX];
    for (int i = 0; i < count; i++) {
        const char *what = scene_parameter_find(of, all[i]) < 0 ? "is no parameter with a range"
                           : surrogate_is_among(i, all, all[i]) ? "is there twice"
                           : surrogate_is_among(other_count, other, all[i])
                               ? "is among the other list as well"
                               : NULL;
        if (what) {
            snprintf(where, sizeof where, "surrogate.%s[%d]", list, i);
            snprintf(problem, sizeof problem,
                     "%.60s %s; allowed: each name under parameters that has a range, once, in "
                     "inputs or in parameters",
                     all[i], what);
            return refuse(key, where, error, problem);
        }
    }
    return AD_OK;
}

/* Every parameter with a range is an input or a parameter; inputs that are not given are all that
 * are left. */
static ad_status resolve_names(surrogate_settings *settings, const scene *of,
                               char key[TRAIN_KEY_MAX], ad_error *error)
{
    char problem[256];
    const bool given = settings->input_count > 0;
    ad_status status = check_names("inputs", settings->input_count, settings->inputs,
                                   settings->parameter_count, settings->parameters, of, key, error);
    if (status == AD_OK) {
        status = check_names("parameters", settings->parameter_count, settings->parameters,
                             settings->input_count, settings->inputs, of, key, error);
    }
    for (int i = 0; i < of->parameter_count && status == AD_OK; i++) {
        const char *name = of->parameters[i].name;
        if (surrogate_is_among(settings->input_count, settings->inputs, name) ||
            surrogate_names_parameter(settings, name)) {
            continue;
        }
        if (given) {
            snprintf(problem, sizeof problem,
                     "do not hold %.60s, which has a range; allowed: every such parameter in "
                     "inputs or in parameters, or a value in place of its range",
                     name);
            status = refuse(key, "surrogate.inputs", error, problem);
        } else {
            settings->inputs[settings->input_count++] = name;
        }
    }
    return status;
}

/* Of polynomials, with three nodes in place of an end. */
enum { NODES_STEPS = 2000 };

static train_stage usual_stage(const surrogate_settings *settings)
{
    train_stage stage = train_stage_default();
    stage.optim.method = OPTIM_SSBROYDEN;
    stage.steps = settings->kind == SURROGATE_POLYNOMIAL ? NODES_STEPS : STEPS;
    return stage;
}

static ad_status check_scene(const scene *of, char key[TRAIN_KEY_MAX], ad_error *error)
{
    const char *found = "";
    ad_error reason;
    if (support_check(of, SUPPORT_ONE_STEP, &found, &reason) != AD_OK) {
        return refuse(key, found, error, reason.message);
    }
    if (of->parameter_count == 0 || of->parameter_count > SURROGATE_INPUTS_MAX / 2) {
        return refuse(key, "parameters", error,
                      "have no range, or too many: those with ranges are the inputs of a one-step "
                      "model; allowed: 1 to 32");
    }
    return AD_OK;
}

static ad_status check_training(const surrogate_settings *settings, const train_settings *training,
                                char key[TRAIN_KEY_MAX], ad_error *error)
{
    const nn_mlp_settings *network = &training->network;
    if (settings->kind != SURROGATE_LINEAR &&
        (network->hidden_count < 1 || network->hidden_count > SURROGATE_LAYERS_MAX)) {
        return refuse(key, "network.hidden", error,
                      "of a one-step model has 1 to 4 layers; for none surrogate.kind: linear");
    }
    if (network->activation != NN_TANH) {
        return refuse(key, "network.activation", error, "of a one-step model is tanh");
    }
    for (int i = 0; i < training->stage_count; i++) {
        char where[TRAIN_KEY_MAX];
        if (training->stages[i].stop_error > 0) {
            snprintf(where, sizeof where, "training.stages[%d].stop.error", i);
            return refuse(key, where, error,
                          "is against a reference, which a one-step model has not; leave it out");
        }
        if (optim_method_needs(training->stages[i].optim.method) == OPTIM_NEEDS_SQUARES) {
            char others[160];
            optim_method_list(1u << OPTIM_NEEDS_GRADIENTS | 1u << OPTIM_NEEDS_ONE_FUNCTION, 0,
                              others, sizeof others);
            snprintf(key, TRAIN_KEY_MAX, "training.stages[%d].optimizer", i);
            return ad_fail(error, AD_BAD_INPUT,
                           "is %s, for which the output layer is not found in every evaluation as "
                           "that of a one-step model is; allowed: %s",
                           optim_method_name(training->stages[i].optim.method), others);
        }
    }
    if (training->members > 0 || training->members_file) { /* data: what filters go through */
        return refuse(key, "members.solved", error,
                      "is of networks of a scene; a one-step model learns from steps that it has "
                      "solved, surrogate.solved; leave it out");
    }
    return train_names_reference(training)
               ? refuse(key, "reference", error,
                        "is of networks of a scene; a one-step model is compared by rollouts; "
                        "leave it out")
               : AD_OK;
}

ad_status surrogate_settings_resolve(surrogate_settings *settings, train_settings *training,
                                     scene *rod_scene, char key[TRAIN_KEY_MAX], ad_error *error)
{
    nn_mlp_settings *network = &training->network;
    if (network->hidden_count == TRAIN_OPEN) {
        network->hidden_count = settings->kind == SURROGATE_LINEAR ? 0 : 2;
        network->hidden[0] = network->hidden[1] = WIDTH;
    }
    train_close_stage(&training->stages[0], usual_stage(settings));
    ad_status status = check_scene(rod_scene, key, error);
    status = status == AD_OK ? resolve_names(settings, rod_scene, key, error) : status;
    status = status == AD_OK ? check_training(settings, training, key, error) : status;
    if (status != AD_OK) {
        return status;
    }
    training->windows = rod_scene->windows = 1;
    return train_settings_resolve(training, rod_scene, key, error);
}
