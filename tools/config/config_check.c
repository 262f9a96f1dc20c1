/* What is checked once everything is read: formulas with their places, the scene, the training, and
 * whether a named reference is a solution of this scene. */
#include "tools/config/config_parts.h"

#include "physics/expression.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>

ad_status config_check_expressions(const config *experiment, ad_error *error)
{
    ad_error reason;
    char path[CONFIG_PATH_MAX];
    for (int i = 0; i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        const char *texts[4] = {NULL};
        int count = key->entries_max ? key->entries_max : 1;
        if (key->type != CONFIG_EXPRESSION) {
            continue;
        }
        memcpy(texts, (const char *)experiment + key->offset, (size_t)count * sizeof *texts);
        for (int k = 0; k < count && texts[k]; k++) {
            ad_status status = expression_check(texts[k], NULL, &reason);
            if (status == AD_NO_MEMORY) {
                return ad_fail(error, status, "%s", reason.message);
            }
            if (status != AD_OK) {
                snprintf(path, sizeof path, key->entries_max ? "%s[%d]" : "%s", key->path, k);
                return config_blame(experiment->source, error, path, "%s", reason.message);
            }
        }
    }
    return AD_OK;
}

ad_status config_check_scene(const config *experiment, ad_error *error)
{
    ad_error reason;
    const char *key = "";
    ad_status status = scene_check(&experiment->scene, &key, &reason);
    if (status == AD_NO_MEMORY) {
        return ad_fail(error, status, "%s", reason.message);
    }
    if (status != AD_OK) {
        return config_blame(experiment->source, error, key, "%s", reason.message);
    }
    return AD_OK;
}

ad_status config_check_ends(const config *experiment, ad_error *error)
{
    ad_error reason;
    const char *key = "";
    const scene *rod_scene = &experiment->scene;
    ad_status status = model_of(rod_scene)->check(rod_scene, &key, &reason);
    if (status == AD_BAD_INPUT) {
        return config_blame(experiment->source, error, key, "%s", reason.message);
    }
    return status == AD_OK ? AD_OK : ad_fail(error, status, "%s", reason.message);
}

/* ---- training ------------------------------------------------------------------------------ */

/* A key of another optimiser in a stage is a mistake, not something to pass over. */
static ad_status check_stage_keys(const config *experiment, int stage, ad_error *error)
{
    config_optimizer optimizer = experiment->stages[stage].optimizer;
    char path[CONFIG_PATH_MAX], owners[64];
    for (int i = 0; i < config_key_count; i++) {
        const config_key *key = &config_keys[i];
        if (!config_key_in_stage(key) || config_key_applies(key, optimizer)) {
            continue;
        }
        snprintf(path, sizeof path, "training.stages[%d].%s", stage, strstr(key->path, "[].") + 3);
        if (config_given(experiment->source, path)) {
            config_key_optimizers(key, owners, sizeof owners);
            return config_blame(experiment->source, error, path,
                                "belongs to optimizer %s, but this stage runs %s; leave it out",
                                owners, config_optimizer_name(optimizer));
        }
    }
    return AD_OK;
}

/* Settings of a stage that contradict each other or the experiment. */
static ad_status check_stage(const config *experiment, int index, ad_error *error)
{
    const config_stage *stage = &experiment->stages[index];
    bool adam = stage->optimizer == CONFIG_ADAM;
    char path[CONFIG_PATH_MAX];
    const char *problem = adam ? optim_adam_check(&stage->adam)
                          : stage->optimizer == CONFIG_GAUSS_NEWTON
                              ? optim_gauss_newton_check(&stage->gauss_newton)
                              : optim_lbfgs_check(&stage->lbfgs);
    if (problem) {
        snprintf(path, sizeof path, "training.stages[%d]", index);
        return config_blame(experiment->source, error, path, "%s", problem);
    }
    if (adam && stage->adam.schedule.warmup_steps > stage->steps) {
        snprintf(path, sizeof path, "training.stages[%d].warmup_steps", index);
        return config_blame(experiment->source, error, path,
                            "%lld steps are more than the %d steps of the stage",
                            (long long)stage->adam.schedule.warmup_steps, stage->steps);
    }
    if (stage->stop_error > 0 && !config_names_reference(experiment)) {
        snprintf(path, sizeof path, "training.stages[%d].stop.error", index);
        return config_blame(experiment->source, error, path,
                            "there is no reference to measure an error against; give "
                            "reference.analytic, solve or file, or leave it out");
    }
    return AD_OK;
}

/* Some equation has to count. */
static bool has_weight(const config *experiment)
{
    const problem_settings *losses = &experiment->losses;
    const physics_model *model = model_of(&experiment->scene);
    const struct {
        rod_residual_kind kind;
        double weight;
    } rows[] = {{ROD_STRAIN, losses->strain_weight},  {ROD_CURVATURE, losses->curvature_weight},
                {ROD_FORCE, losses->force_weight},    {ROD_MOMENT, losses->moment_weight},
                {ROD_START, losses->boundary_weight}, {ROD_END, losses->boundary_weight},
                {ROD_INITIAL, losses->initial_weight}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].weight > 0 && model->residual_rows(&experiment->scene, rows[i].kind) > 0) {
            return true;
        }
    }
    return false;
}

/* Weights that follow training, and what they cannot be combined with. */
static ad_status check_weights(const config *experiment, ad_error *error)
{
    const problem_settings *losses = &experiment->losses;
    const char *key = losses->balance ? "losses.balance" : "losses.self_adaptive.rate";
    bool adaptive = losses->self_adaptive_rate > 0, moved = false;
    const struct {
        const char *key;
        int steps;
    } fresh[] = {{"losses.interior.resample_every", losses->interior.resample_every},
                 {"losses.boundary.resample_every", losses->boundary.resample_every},
                 {"losses.initial.resample_every", losses->initial.resample_every}};
    for (int i = 0; adaptive && i < 3; i++) {
        if (fresh[i].steps > 0) {
            return config_blame(experiment->source, error, fresh[i].key,
                                "losses.self_adaptive.rate gives every point a weight of its own, "
                                "so points have to stay; allowed beside it: 0");
        }
    }
    if (adaptive && (losses->balance || losses->causal_slices)) {
        return config_blame(experiment->source, error, "losses.self_adaptive.rate",
                            "given beside %s, which moves the same weights; allowed: one of the "
                            "two",
                            losses->balance ? "losses.balance" : "losses.causal.slices");
    }
    for (int i = 0; i < experiment->stage_count; i++) {
        moved = moved || experiment->stages[i].optimizer == CONFIG_ADAM;
    }
    if (!moved && (adaptive || losses->balance)) {
        return config_blame(experiment->source, error, key,
                            "weights are moved in stages of adam, and training.stages has none; "
                            "give one, or leave it out");
    }
    return AD_OK;
}

bool config_takes_loads_in_parts(const config *experiment)
{
    const scene *rod_scene = &experiment->scene;
    return !scene_is_dynamic(rod_scene) && !scene_is_manufactured(rod_scene) &&
           experiment->network.hidden_count == 0 &&
           experiment->stages[0].optimizer == CONFIG_GAUSS_NEWTON;
}

ad_status config_check_training(const config *experiment, ad_error *error)
{
    const char *problem = nn_mlp_settings_check(&experiment->network);
    ad_status status = AD_OK;
    if (problem) {
        return config_blame(experiment->source, error, "network", "%s", problem);
    }
    if (experiment->losses.causal_slices > 0 && !scene_is_dynamic(&experiment->scene)) {
        return config_blame(experiment->source, error, "losses.causal.slices",
                            "causal weighting follows time, but the scene is static; give "
                            "time.duration, or leave it out");
    }
    if (!has_weight(experiment)) {
        return config_blame(experiment->source, error, "losses.interior.weights",
                            "every loss term of this scene has weight 0: nothing to learn");
    }
    if (scene_is_imperfect(&experiment->scene) && !config_takes_loads_in_parts(experiment)) {
        return config_blame(experiment->source, error, "rod.rest.imperfection",
                            "goes as the loads grow, which they do only for a network without "
                            "hidden layers and gauss_newton; leave out network.hidden and "
                            "training.stages, or this");
    }
    status = check_weights(experiment, error);
    for (int i = 0; i < experiment->stage_count && status == AD_OK; i++) {
        status = check_stage_keys(experiment, i, error);
        if (status == AD_OK) {
            status = check_stage(experiment, i, error);
        }
    }
    return status;
}

/* ---- reference ----------------------------------------------------------------------------- */

/* Whether a formula, 0 if not given, is this number for all s and t. */
static bool is_value(const char *text, double value)
{
    double number = 0;
    return (!text || expression_is_number(text, &number)) && number == value;
}

static bool zero(const char *const *texts)
{
    return is_value(texts[0], 0) && is_value(texts[1], 0) && is_value(texts[2], 0);
}

static bool straight(const scene_rod *rod)
{
    return zero(rod->rest_curvature) && is_value(rod->rest_strain[0], 0) &&
           is_value(rod->rest_strain[1], 0) && is_value(rod->rest_strain[2], 1);
}

/* d3 at the clamped start: the third column of R(q). */
static void clamped_tangent(const scene *rod_scene, double d3[3])
{
    double q[4];
    double square = 0;
    for (int i = 0; i < 4; i++) {
        q[i] = expression_evaluate(rod_scene->start.rotation[i], 0, 0);
        square += q[i] * q[i];
    }
    d3[0] = 2 * (q[1] * q[3] + q[0] * q[2]) / square;
    d3[1] = 2 * (q[2] * q[3] - q[0] * q[1]) / square;
    d3[2] = 1 - 2 * (q[1] * q[1] + q[2] * q[2]) / square;
}

/* |load . d3| / |load| of a constant load, 0 for none. */
static double along_tangent(const scene *rod_scene, const char *const *load)
{
    double d3[3];
    double dot = 0;
    double square = 0;
    clamped_tangent(rod_scene, d3);
    for (int i = 0; i < 3; i++) {
        double value = load[i] ? expression_evaluate(load[i], 0, 0) : 0;
        dot += value * d3[i];
        square += value * value;
    }
    return square > 0 ? fabs(dot) / sqrt(square) : 0;
}

/* What all closed forms share: a static, straight, weightless rod, clamped at s = 0, loaded at the
 * tip by a dead load. The sentence says what else there is, NULL when nothing. */
static const char *common_obstacle(const scene *rod_scene)
{
    const scene_loads *loads = &rod_scene->loads;
    const double *gravity = loads->gravity;
    if (scene_is_beam(rod_scene)) {
        return "is a shape of rods in space; for a beam give reference.deflection";
    }
    if (scene_is_manufactured(rod_scene)) {
        return "the scene has a manufactured solution; allowed: manufactured";
    }
    if (scene_is_dynamic(rod_scene)) {
        return "is a static shape, but the scene has a duration";
    }
    if (rod_scene->start.type != SCENE_CLAMPED || rod_scene->end.type != SCENE_LOADED) {
        return "needs a clamped start and a loaded end";
    }
    if (loads->tip.frame != SCENE_DEAD) {
        return "needs a dead load at the tip";
    }
    if (!straight(&rod_scene->rod)) {
        return "needs a rod that is straight when unloaded";
    }
    if (gravity[0] != 0 || gravity[1] != 0 || gravity[2] != 0 || loads->force[0] ||
        loads->moment[0]) {
        return "needs a rod without gravity and distributed loads";
    }
    return NULL;
}

static bool round_rod(const scene *rod_scene)
{
    scene_properties properties = scene_properties_of(rod_scene);
    const double *stiffness = properties.curvature_stiffness;
    return fabs(stiffness[0] - stiffness[1]) <= 1e-12 * stiffness[0];
}

static const char *elastica_obstacle(const scene *rod_scene)
{
    const scene_load *tip = &rod_scene->loads.tip;
    if (rod_scene->rod.model != SCENE_KIRCHHOFF) {
        return "needs rod.model kirchhoff, without shear and stretch";
    }
    if (!zero(tip->moment)) {
        return "needs a tip force without a moment";
    }
    if (zero(tip->force)) {
        return "needs a tip force that is not zero";
    }
    if (along_tangent(rod_scene, tip->force) > 1e-12) {
        return "needs a tip force perpendicular to the clamped tangent";
    }
    return round_rod(rod_scene) ? NULL : "needs equal bending stiffness about d1 and d2";
}

static const char *couple_obstacle(const scene *rod_scene, bool planar)
{
    const scene_load *tip = &rod_scene->loads.tip;
    if (!zero(tip->force)) {
        return "needs a tip moment without a force";
    }
    if (zero(tip->moment)) {
        return "needs a tip moment that is not zero";
    }
    if (planar && along_tangent(rod_scene, tip->moment) > 1e-12) {
        return "needs a tip moment perpendicular to the clamped tangent; helix allows any";
    }
    return round_rod(rod_scene) ? NULL : "needs equal bending stiffness about d1 and d2";
}

bool config_names_reference(const config *experiment)
{
    return experiment->reference != CONFIG_REFERENCE_NONE || experiment->reference_file ||
           experiment->reference_deflection || !isnan(experiment->reference_tolerance);
}

static const char *solve_obstacle(const config *experiment)
{
    if (isnan(experiment->reference_tolerance)) {
        return NULL;
    }
    if (experiment->reference != CONFIG_REFERENCE_NONE || experiment->reference_file ||
        experiment->reference_deflection) {
        return "given beside another reference; allowed: one of them";
    }
    return scene_is_imperfect(&experiment->scene)
               ? "does not follow rod.rest.imperfection; give reference.file"
               : NULL;
}

static const char *reference_obstacle(const config *experiment)
{
    const scene *rod_scene = &experiment->scene;
    const char *problem = NULL;
    if (experiment->reference == CONFIG_REFERENCE_NONE) {
        return NULL;
    }
    if (experiment->reference_file) {
        return "given beside reference.file; allowed: one of the two";
    }
    if (experiment->reference == CONFIG_REFERENCE_MANUFACTURED) {
        return scene_is_manufactured(rod_scene) ? NULL : "needs the section manufactured";
    }
    problem = common_obstacle(rod_scene);
    if (problem) {
        return problem;
    }
    return experiment->reference == CONFIG_REFERENCE_ELASTICA
               ? elastica_obstacle(rod_scene)
               : couple_obstacle(rod_scene, experiment->reference == CONFIG_REFERENCE_ROLLUP);
}

static ad_status check_deflection(const config *experiment, ad_error *error)
{
    expression_use use = {false, false};
    const char *text = experiment->reference_deflection;
    const char *problem = NULL;
    if (!text) {
        return AD_OK;
    }
    ad_status status = expression_check(text, &use, error);
    if (!scene_is_beam(&experiment->scene)) {
        problem = "is that of a beam; for a rod in space give reference.analytic or reference.file";
    } else if (experiment->reference_file || experiment->reference != CONFIG_REFERENCE_NONE) {
        problem = "given beside another reference; allowed: one of them";
    } else if (use.t && !scene_is_dynamic(&experiment->scene)) {
        problem = "depends on t, but the scene is static; give time.duration, or a formula "
                  "without t";
    }
    return problem ? config_blame(experiment->source, error, "reference.deflection", "%s", problem)
                   : status;
}

ad_status config_check_reference(const config *experiment, ad_error *error)
{
    struct stat status;
    const char *problem = solve_obstacle(experiment);
    if (problem) {
        return config_blame(experiment->source, error, "reference.solve", "%s", problem);
    }
    problem = reference_obstacle(experiment);
    if (problem) {
        return config_blame(experiment->source, error, "reference.analytic", "%s", problem);
    }
    ad_status deflection = check_deflection(experiment, error);
    if (deflection != AD_OK) {
        return deflection;
    }
    if (experiment->reference_file &&
        (stat(experiment->reference_file, &status) != 0 || !S_ISREG(status.st_mode))) {
        return config_blame(experiment->source, error, "reference.file",
                            "%s is not a file; paths are relative to the scene file",
                            experiment->reference_file);
    }
    return AD_OK;
}
