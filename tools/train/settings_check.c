/* Whether settings contradict each other or the scene, and whether a named reference is a solution
 * of this scene. */
#include "physics/learn/window_state.h"
#include "physics/scene/support.h"
#include "tools/train/settings_internal.h"

#include <math.h>
#include <sys/stat.h>

/* Settings of a stage that contradict each other or the experiment. */
static ad_status check_stage(const train_settings *settings, int index, char *key, ad_error *error)
{
    const train_stage *stage = &settings->stages[index];
    const optim_settings optim = optim_settings_own(&stage->optim);
    const char *problem = optim_settings_check(&optim);
    if (problem) {
        return train_refuse_stage(key, index, "", error, "%s", problem);
    }
    if (optim.warmup_steps > stage->steps) {
        return train_refuse_stage(key, index, "warmup_steps", error,
                                  "%lld steps are more than the %d steps of the stage",
                                  (long long)stage->optim.warmup_steps, stage->steps);
    }
    if (stage->stop_error > 0 && !train_names_reference(settings) && settings->members == 0) {
        return train_refuse_stage(key, index, "stop.error", error,
                                  "there is no reference to measure an error against; give "
                                  "reference.analytic, solve or file, or leave it out");
    }
    return AD_OK;
}

/* Some equation has to count. */
static bool has_weight(const train_settings *settings, const scene *rod_scene)
{
    bool has = false;
    for (int kind = 0; kind < ROD_RESIDUAL_COUNT; kind++) {
        rod_residual_kind k = (rod_residual_kind)kind;
        has = has || (rod_weight_of(&settings->weights, k) > 0 &&
                      scene_physics_of(rod_scene)->residual_rows(rod_scene, k) > 0);
    }
    return has;
}

/* Weights that follow training, and what they cannot be combined with. */
static ad_status check_weights(const train_settings *settings, char *key, ad_error *error)
{
    const problem_settings *losses = &settings->losses;
    bool moved = false;
    if (losses->adaptive.kind && losses->interior.resample_every > 0) {
        return train_refuse(key, "losses.interior.adaptive.kind", error,
                            "given beside losses.interior.resample_every, for which points have to "
                            "stay; allowed: one of the two");
    }
    for (int i = 0; i < settings->stage_count; i++) {
        moved =
            moved || optim_method_needs(settings->stages[i].optim.method) == OPTIM_NEEDS_GRADIENTS;
    }
    if (!moved && losses->balance) {
        return train_refuse(key, "losses.balance", error,
                            "weights are moved in stages of adam, and training.stages has none; "
                            "give one, or leave it out");
    }
    return AD_OK;
}

bool train_takes_loads_in_parts(const train_settings *settings, const scene *rod_scene)
{
    return !scene_is_dynamic(rod_scene) && !scene_is_manufactured(rod_scene) &&
           settings->data_count == 0 && settings->network.hidden_count == 0 &&
           optim_method_needs(settings->stages[0].optim.method) == OPTIM_NEEDS_SQUARES;
}

/* ---- reference ----------------------------------------------------------------------------- */

/* Whether a formula, 0 if not given, is this number for all s and t. */
static bool is_value(quantity q, double value)
{
    return quantity_is(quantity_or(q, quantity_number(0)), value);
}

static bool zero(const quantity *q)
{
    return !quantity_any_something(3, q);
}

static bool straight(const scene *rod_scene)
{
    scene_rest rest = scene_rest_of(rod_scene);
    bool turns = false;
    for (int i = 1; i < rod_scene->segment_count; i++) {
        turns = turns || !zero(rod_scene->segments[i].turn);
    }
    return !turns && zero(rest.curvature) && is_value(rest.strain[0], 0) &&
           is_value(rest.strain[1], 0) && is_value(rest.strain[2], 1);
}

/* d3 at the clamped start: the third column of R(q). */
static void clamped_tangent(const scene *rod_scene, double d3[3])
{
    double q[4];
    double square = 0;
    for (int i = 0; i < 4; i++) {
        q[i] = quantity_value(rod_scene->start.rotation[i], 0, 0);
        square += q[i] * q[i];
    }
    d3[0] = 2 * (q[1] * q[3] + q[0] * q[2]) / square;
    d3[1] = 2 * (q[2] * q[3] - q[0] * q[1]) / square;
    d3[2] = 1 - 2 * (q[1] * q[1] + q[2] * q[2]) / square;
}

/* |load . d3| / |load| of a constant load, 0 for none. */
static double along_tangent(const scene *rod_scene, const quantity *load)
{
    double d3[3];
    double dot = 0;
    double square = 0;
    clamped_tangent(rod_scene, d3);
    for (int i = 0; i < 3; i++) {
        double value = load[i].is_given ? quantity_value(load[i], 0, 0) : 0;
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
    if (!straight(rod_scene)) {
        return "needs a rod that is straight when unloaded";
    }
    if (quantity_any_something(3, loads->gravity) || loads->force[0].is_given ||
        loads->moment[0].is_given) {
        return "needs a rod without gravity and distributed loads";
    }
    if (quantity_any_something(3, loads->foundation)) {
        return "needs a rod without a foundation";
    }
    if (rod_scene->point_count + rod_scene->body_count + rod_scene->spring_count +
            scene_actuator_count(rod_scene) + rod_scene->tube_count >
        0) {
        return "needs a rod without points, bodies, springs, tendons, chambers and tubes";
    }
    return NULL;
}

static bool round_rod(const scene *rod_scene)
{
    scene_properties properties = scene_properties_of(rod_scene);
    double first = 0, second = 0;
    bool twists_alike = quantity_is_number(properties.curvature_stiffness[2], NULL);
    return twists_alike && quantity_is_number(properties.curvature_stiffness[0], &first) &&
           quantity_is_number(properties.curvature_stiffness[1], &second) &&
           fabs(first - second) <= 1e-12 * first;
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
    return round_rod(rod_scene)
               ? NULL
               : "needs equal bending stiffness about d1 and d2, the same all along";
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
    return round_rod(rod_scene)
               ? NULL
               : "needs equal bending stiffness about d1 and d2, the same all along";
}

bool train_names_reference(const train_settings *settings)
{
    return settings->reference != TRAIN_REFERENCE_NONE || settings->reference_file ||
           settings->reference_deflection.is_given || !isnan(settings->reference_tolerance);
}

static const char *solve_obstacle(const train_settings *settings, const scene *rod_scene)
{
    if (isnan(settings->reference_tolerance)) {
        return NULL;
    }
    if (settings->reference != TRAIN_REFERENCE_NONE || settings->reference_file ||
        settings->reference_deflection.is_given) {
        return "given beside another reference; allowed: one of them";
    }
    return scene_is_imperfect(rod_scene)
               ? "does not follow rod.rest.imperfection; give reference.file"
               : NULL;
}

static const char *reference_obstacle(const train_settings *settings, const scene *rod_scene)
{
    const char *problem = NULL;
    if (settings->reference == TRAIN_REFERENCE_NONE) {
        return NULL;
    }
    if (settings->reference_file) {
        return "given beside reference.file; allowed: one of the two";
    }
    if (rod_scene->rod.law) {
        return "is that of a linear rod, and rod.law is not; allowed: solve, or reference.file";
    }
    if (settings->reference == TRAIN_REFERENCE_MANUFACTURED) {
        return scene_is_manufactured(rod_scene) ? NULL : "needs the section manufactured";
    }
    problem = common_obstacle(rod_scene);
    if (problem) {
        return problem;
    }
    return settings->reference == TRAIN_REFERENCE_ELASTICA
               ? elastica_obstacle(rod_scene)
               : couple_obstacle(rod_scene, settings->reference == TRAIN_REFERENCE_ROLLUP);
}

static ad_status check_deflection(const train_settings *settings, const scene *rod_scene, char *key,
                                  ad_error *error)
{
    quantity deflection = settings->reference_deflection;
    const char *problem = NULL;
    if (!deflection.is_given) {
        return AD_OK;
    }
    ad_status status = quantity_check(deflection, error);
    if (!scene_is_beam(rod_scene)) {
        problem = "is that of a beam; for a rod in space give reference.analytic or reference.file";
    } else if (settings->reference_file || settings->reference != TRAIN_REFERENCE_NONE) {
        problem = "given beside another reference; allowed: one of them";
    } else if (quantity_depends_on(deflection, "t") && !scene_is_dynamic(rod_scene)) {
        problem = "depends on t, but the scene is static; give time.duration, or a formula "
                  "without t";
    }
    return problem ? train_refuse(key, "reference.deflection", error, "%s", problem) : status;
}

ad_status train_check_reference(const train_settings *settings, const scene *rod_scene,
                                char key[TRAIN_KEY_MAX], ad_error *error)
{
    if (scene_is_family(rod_scene) && train_names_reference(settings) &&
        isnan(settings->reference_tolerance)) {
        return train_refuse(key, "reference", error,
                            "is that of one scene, but parameters have ranges; allowed: "
                            "reference.solve, which solves some members");
    }
    struct stat status;
    const char *problem = solve_obstacle(settings, rod_scene);
    if (problem) {
        return train_refuse(key, "reference.solve", error, "%s", problem);
    }
    problem = reference_obstacle(settings, rod_scene);
    if (problem) {
        return train_refuse(key, "reference.analytic", error, "%s", problem);
    }
    ad_status deflection = check_deflection(settings, rod_scene, key, error);
    if (deflection != AD_OK) {
        return deflection;
    }
    if (settings->reference_file &&
        (stat(settings->reference_file, &status) != 0 || !S_ISREG(status.st_mode))) {
        return train_refuse(key, "reference.file", error,
                            "%s is not a file; paths are relative to the scene file",
                            settings->reference_file);
    }
    return AD_OK;
}

ad_status train_check_data(const train_settings *settings, char key[TRAIN_KEY_MAX], ad_error *error)
{
    for (int i = 0; i < settings->data_count; i++) {
        char field[TRAIN_KEY_MAX];
        snprintf(field, sizeof field, "data[%d]", i);
        if (!settings->data[i].file) {
            return train_refuse(key, field, error, "has no file; give one");
        }
    }
    return AD_OK;
}

static ad_status check_stages(const train_settings *settings, char *key, ad_error *error)
{
    ad_status status = check_weights(settings, key, error);
    for (int i = 0; i < settings->stage_count && status == AD_OK; i++) {
        status = check_stage(settings, i, key, error);
    }
    return status;
}

ad_status train_check_support(const train_settings *settings, const scene *rod_scene,
                              char key[TRAIN_KEY_MAX], ad_error *error)
{
    const support_form form = support_formulation(rod_scene);
    const char *found = "";
    ad_error reason;
    ad_status status = support_check(rod_scene, form, &found, &reason);
    if (status == AD_OK && settings->data_count > 0) {
        status = support_check_data(form, &found, &reason);
    }
    return status == AD_OK ? AD_OK : train_refuse(key, found, error, "%s", reason.message);
}

ad_status train_settings_check(const train_settings *settings, const scene *rod_scene,
                               char key[TRAIN_KEY_MAX], ad_error *error)
{
    const char *problem = nn_mlp_settings_check(&settings->network);
    if (problem) {
        return train_refuse(key, "network", error, "%s", problem);
    }
    const groups_settings *groups = &settings->groups;
    if (!scene_is_family(rod_scene) && (groups->inputs || groups->symmetry)) {
        return train_refuse(key, groups->inputs ? "network.inputs" : "network.symmetry", error,
                            "is of a family, and no parameter has a range");
    }
    const bool is_motion =
        rod_scene->formulation == SCENE_STRAIN_FORM && !scene_is_family(rod_scene);
    if (!is_motion &&
        settings->modes[0] + settings->modes[1] + settings->modes[2] + settings->modes[3] > 0) {
        return train_refuse(key, "network.modes", error,
                            "are of one motion in the strain form; leave them out");
    }
    if (is_motion) {
        ad_status status = train_check_motion(settings, key, error);
        status = status == AD_OK ? check_stages(settings, key, error) : status;
        return status == AD_OK ? train_check_reference(settings, rod_scene, key, error) : status;
    }
    if (rod_scene->formulation == SCENE_STRAIN_FORM) {
        if (!isnan(settings->tolerance)) {
            return train_refuse(key, "network.tolerance", error,
                                "is not of a family in the strain form, each of whose answers has "
                                "an error of its own; leave it out");
        }
        ad_status status = train_check_family(settings, rod_scene, key, error);
        return status == AD_OK ? check_stages(settings, key, error) : status;
    }
    if (settings->members > 0 || settings->members_file) {
        return train_refuse(key, settings->members > 0 ? "members.solved" : "members.file", error,
                            "belongs to families in the strain form; leave it out");
    }
    if (settings->losses.causal_slices > 0 && !scene_is_dynamic(rod_scene)) {
        return train_refuse(key, "losses.causal.slices", error,
                            "causal weighting follows time, but the scene is static; give "
                            "time.duration, or leave it out");
    }
    if (rod_scene->windows > 1 && scene_known_count(rod_scene) > WINDOW_STATE_PARAMETERS_MAX) {
        return train_refuse(
            key, "time.windows", error,
            "hand on the motion of all members, of which the scene has too many: %d "
            "parameters have ranges; allowed: %d, or time.windows: 1",
            scene_known_count(rod_scene), WINDOW_STATE_PARAMETERS_MAX);
    }
    if (!has_weight(settings, rod_scene)) {
        return train_refuse(key, "losses.interior.weights", error,
                            "every loss term of this scene has weight 0: nothing to learn");
    }
    if (scene_is_imperfect(rod_scene) && !train_takes_loads_in_parts(settings, rod_scene)) {
        return train_refuse(key, "rod.rest.imperfection", error,
                            "goes as the loads grow, which they do only for a network without "
                            "hidden layers and gauss_newton; leave out network.hidden and "
                            "training.stages, or this");
    }
    if (settings->rotation == SCENE_SIX && settings->windows > 1) {
        return train_refuse(key, "network.rotation", error,
                            "six numbers leave the sign of the quaternion open, which windows of "
                            "time hand on; allowed with time.windows above 1: quaternion, vector");
    }
    ad_status status = check_stages(settings, key, error);
    return status == AD_OK ? train_check_reference(settings, rod_scene, key, error) : status;
}

ad_status train_settings_check_model(const train_settings *settings, const physics_model *m,
                                     char key[TRAIN_KEY_MAX], ad_error *error)
{
    const char *problem = nn_mlp_settings_check(&settings->network);
    if (problem) {
        return train_refuse(key, "network", error, "%s", problem);
    }
    if (settings->data_count > 0) {
        return train_refuse(key, "data", error,
                            "are of a scene; give physics of one's own a term and a source");
    }
    if (!isnan(settings->tolerance)) {
        return train_refuse(key, "network.tolerance", error,
                            "is of a scene, whose error is estimated; leave it out");
    }
    if (train_names_reference(settings)) {
        return train_refuse(key, "reference", error,
                            "is of a scene; compare physics of one's own by the evaluator");
    }
    problem = problem_settings_check(&settings->losses, m);
    if (problem) {
        return train_refuse(key, "losses", error, "%s", problem);
    }
    return check_stages(settings, key, error);
}
