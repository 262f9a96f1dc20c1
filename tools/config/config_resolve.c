/* Defaults that follow from other keys, units, and paths; those of training are settled by its
 * library. */
#include "tools/config/config_parts.h"

#include "physics/expression.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void config_defaults(config *experiment)
{
    memset(experiment, 0, sizeof *experiment);
    scene_defaults(&experiment->scene);
    experiment->settings = train_settings_default();
}

/* ---- choices ------------------------------------------------------------------------------- */

static bool given(const config *experiment, const char *path)
{
    return config_given(experiment->source, path);
}

/* The file's name without folder and extension. */
static const char *stem(config_source *source)
{
    const char *file = config_source_file(source);
    const char *slash = strrchr(file, '/');
    char name[256];
    snprintf(name, sizeof name, "%.200s", slash ? slash + 1 : file);
    char *dot = strrchr(name, '.');
    if (dot && dot != name) {
        *dot = '\0';
    }
    return config_keep(source, *name ? name : "rod");
}

static ad_status resolve_name(config *experiment, ad_error *error)
{
    if (!experiment->settings.name) {
        experiment->settings.name = stem(experiment->source);
        if (!experiment->settings.name) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory");
        }
    }
    if (strchr(experiment->settings.name, '/') || experiment->settings.name[0] == '.' ||
        strlen(experiment->settings.name) > 100) {
        return config_blame(experiment->source, error, "name",
                            "names a folder in runs; allowed: up to 100 bytes, no slash, not "
                            "beginning with a point");
    }
    return AD_OK;
}

/* An end that is not held has no position and rotation; the start has defaults for what is held. */
static ad_status resolve_end(config *experiment, scene_end *end, const char *name, ad_error *error)
{
    bool exact = scene_is_manufactured(&experiment->scene);
    bool beam = scene_is_beam(&experiment->scene); /* has deflections, not positions */
    bool position = scene_end_holds_position(end->type);
    bool rotation = scene_end_holds_rotation(end->type);
    char path[CONFIG_PATH_MAX];
    const struct {
        const char *key;
        bool held;
        const char **texts;
        int count;
    } rows[] = {{"position", position, end->position, 3}, {"rotation", rotation, end->rotation, 4}};
    for (int i = 0; i < 2; i++) {
        snprintf(path, sizeof path, "boundary.%s.%s", name, rows[i].key);
        if (!exact && !beam && rows[i].held) {
            continue;
        }
        if (given(experiment, path)) {
            return config_blame(experiment->source, error, path,
                                beam ? "places a rod in space; a beam deflects along d2 from "
                                       "its straight axis, leave it out"
                                : exact
                                    ? "follows from the manufactured solution; leave it out"
                                    : "is not held by an end of this type; leave it out, or take "
                                      "clamped, pinned (position) or driven");
        }
        for (int k = 0; k < rows[i].count; k++) {
            rows[i].texts[k] = NULL;
        }
    }
    return AD_OK;
}

ad_status config_resolve_choices(config *experiment, ad_error *error)
{
    scene *rod_scene = &experiment->scene;
    const scene_beam_load *beam_tip = &rod_scene->beam.tip;
    bool tip = rod_scene->loads.tip.force[0] || rod_scene->loads.tip.moment[0] || beam_tip->force ||
               beam_tip->moment;
    if (!given(experiment, "boundary.end.type")) {
        rod_scene->end.type = tip || scene_is_manufactured(rod_scene) ? SCENE_LOADED : SCENE_FREE;
    }
    ad_status status = resolve_name(experiment, error);
    if (status == AD_OK) {
        status = resolve_end(experiment, &rod_scene->start, "start", error);
    }
    if (status == AD_OK) {
        status = resolve_end(experiment, &rod_scene->end, "end", error);
    }
    if (experiment->settings.windows > 0) {
        rod_scene->windows = experiment->settings.windows;
    }
    return status;
}

/* ---- physics ------------------------------------------------------------------------------- */

static void fill(double *field, double value, bool wanted)
{
    if (isnan(*field) && wanted) {
        *field = value;
    }
}

void config_fill_stiffness(scene *rod_scene)
{
    scene_rod *rod = &rod_scene->rod;
    scene_properties properties = scene_properties_of(rod_scene);
    bool massive = properties.mass_per_length > 0;
    bool sectioned = rod->section != SCENE_SECTION_NONE && !isnan(rod->density);
    fill(&rod->shear_correction, scene_shear_correction(rod), true);
    for (int i = 0; i < 2; i++) {
        fill(&rod->shear_stiffness[i], properties.strain_stiffness[i], true);
        fill(&rod->bending_stiffness[i], properties.curvature_stiffness[i], true);
    }
    fill(&rod->axial_stiffness, properties.strain_stiffness[2], true);
    fill(&rod->torsional_stiffness, properties.curvature_stiffness[2], true);
    fill(&rod->mass_per_length, properties.mass_per_length, massive);
    for (int i = 0; i < 3; i++) {
        fill(&rod->rotary_inertia[i], properties.rotary_inertia[i], sectioned);
    }
}

/* text times factor as a formula; a constant becomes a number. */
static const char *scaled(config_source *source, const char *text, double factor)
{
    double value = 0;
    char number[32];
    size_t size = strlen(text) + 64;
    char *product = malloc(size);
    const char *kept = NULL;
    if (!product) {
        return NULL;
    }
    if (expression_is_number(text, &value)) {
        config_number_text(value * factor, number);
        kept = config_keep(source, number);
    } else {
        config_number_text(factor, number);
        snprintf(product, size, "(%s)*%s", text, number);
        kept = config_keep(source, product);
    }
    free(product);
    return kept;
}

static ad_status resolve_units(config *experiment, ad_error *error)
{
    scene_loads *loads = &experiment->scene.loads;
    double length = experiment->scene.rod.length;
    double stiffness = scene_properties_of(&experiment->scene).curvature_stiffness[0];
    const struct {
        const char **texts;
        int power;
    } rows[] = {{loads->force, 3},       {loads->moment, 2},    {loads->base.force, 2},
                {loads->base.moment, 1}, {loads->tip.force, 2}, {loads->tip.moment, 1}};
    if (experiment->load_units == CONFIG_UNITS_SI) {
        return AD_OK;
    }
    if (scene_is_beam(&experiment->scene)) {
        return config_blame(experiment->source, error, "loads.units",
                            "scales the loads of rods in space; those of a beam are in SI");
    }
    if (isinf(stiffness)) {
        return config_blame(experiment->source, error, "loads.units",
                            "EI needs a finite bending stiffness about d1; allowed here: SI");
    }
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        double factor = stiffness / pow(length, rows[i].power);
        for (int k = 0; k < 3 && rows[i].texts[k]; k++) {
            rows[i].texts[k] = scaled(experiment->source, rows[i].texts[k], factor);
            if (!rows[i].texts[k]) {
                return ad_fail(error, AD_NO_MEMORY, "out of memory");
            }
        }
    }
    experiment->load_units = CONFIG_UNITS_SI;
    return config_check_scene(experiment, error);
}

/* Numbers only; physics normalises formulas. A quaternion that is unit already stays as it is, so
 * that writing and reading it again changes nothing. */
static ad_status normalize(config_source *source, const char *rotation[4], ad_error *error)
{
    double value[4];
    double square = 0;
    char number[32];
    for (int i = 0; i < 4; i++) {
        if (!rotation[i] || config_parse_number(rotation[i], &value[i])) {
            return AD_OK;
        }
        square += value[i] * value[i];
    }
    for (int i = 0; i < 4 && fabs(square - 1) > 1e-15; i++) {
        config_number_text(value[i] / sqrt(square), number);
        rotation[i] = config_keep(source, number);
        if (!rotation[i]) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory");
        }
    }
    return AD_OK;
}

/* The file relative to the folder of the scene file, made absolute, since
 * the resolved experiment is written to another folder. */
static ad_status resolve_reference(config *experiment, ad_error *error)
{
    const char *file = experiment->settings.reference_file;
    const char *scene_file = config_source_file(experiment->source);
    const char *slash = strrchr(scene_file, '/');
    char joined[4096];
    char folder[2048] = "";
    if (!file || *file == '/') {
        return AD_OK;
    }
    if (*scene_file != '/' && !getcwd(folder, sizeof folder)) {
        return ad_fail(error, AD_IO, "the current folder has no name that fits");
    }
    int length = snprintf(joined, sizeof joined, "%s%s%.*s%s", folder, *folder ? "/" : "",
                          slash ? (int)(slash - scene_file + 1) : 0, scene_file, file);
    if (length < 0 || (size_t)length >= sizeof joined) {
        return config_blame(experiment->source, error, "reference.file", "the path is too long");
    }
    experiment->settings.reference_file = config_keep(experiment->source, joined);
    return experiment->settings.reference_file ? AD_OK
                                               : ad_fail(error, AD_NO_MEMORY, "out of memory");
}

static ad_status resolve_training(config *experiment, ad_error *error)
{
    ad_error reason;
    char key[TRAIN_KEY_MAX];
    ad_status status =
        train_settings_resolve(&experiment->settings, &experiment->scene, key, &reason);
    return config_blame_training(experiment, status, key, &reason, error);
}

ad_status config_resolve_physics(config *experiment, ad_error *error)
{
    ad_status status = resolve_units(experiment, error);
    if (status == AD_OK) {
        status = normalize(experiment->source, experiment->scene.start.rotation, error);
    }
    if (status == AD_OK) {
        status = normalize(experiment->source, experiment->scene.end.rotation, error);
    }
    if (status == AD_OK) {
        status = resolve_training(experiment, error);
    }
    return status == AD_OK ? resolve_reference(experiment, error) : status;
}
