/* Defaults that follow from other keys, units, and paths; others are chosen in tools/prepare. */
#include "tools/config/config_parts.h"

#include "physics/scene/section.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void config_defaults(config *experiment)
{
    memset(experiment, 0, sizeof *experiment);
    scene_defaults(&experiment->scene);
    experiment->settings = train_settings_default();
    for (int i = experiment->settings.stage_count; i < TRAIN_STAGES_MAX; i++) {
        experiment->settings.stages[i] = train_stage_default();
    }
    for (int i = 0; i < CONFIG_PARAMETERS_MAX; i++) {
        experiment->parameters[i].range[0] = experiment->parameters[i].range[1] = NAN;
        experiment->parameters[i].identify = NAN;
    }
    experiment->surrogate = surrogate_settings_default();
    experiment->control = control_settings_default();
    experiment->plan = plan_settings_default();
    experiment->optimize = optimize_settings_default();
    for (int i = 0; i < CONFIG_TABLES_MAX; i++) {
        experiment->tables[i].x[0] = experiment->tables[i].y[0] = NAN;
    }
    experiment->law.numbers[0] = NAN;
    experiment->residual.hidden_count = 1;
    experiment->residual.hidden[0] = 16;
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
    bool position = scene_end_is_placed(end->type);
    bool rotation = scene_end_holds_rotation(end->type);
    char path[CONFIG_PATH_MAX];
    const struct {
        const char *key;
        bool held;
        quantity *entries;
        int count;
    } rows[] = {{"position", position, end->position, 3},
                {"rotation", rotation, end->rotation, 4},
                {"rotation_vector", rotation, end->rotation_vector, 3},
                {"twist", rotation, &end->twist, 1}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
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
            rows[i].entries[k] = (quantity){.is_given = false};
        }
    }
    return AD_OK;
}

void config_resolve_end_type(config *experiment)
{
    scene *rod_scene = &experiment->scene;
    const scene_beam_load *beam_tip = &rod_scene->beam.tip;
    const scene_load *rod_tip = &rod_scene->loads.tip;
    bool tip = rod_tip->force[0].is_given || rod_tip->moment[0].is_given ||
               beam_tip->force.is_given || beam_tip->moment.is_given;
    if (!given(experiment, "boundary.end.type")) {
        rod_scene->end.type = tip || scene_is_manufactured(rod_scene) ? SCENE_LOADED : SCENE_FREE;
    }
}

ad_status config_resolve_choices(config *experiment, ad_error *error)
{
    scene *rod_scene = &experiment->scene;
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

static void fill(quantity *field, quantity value, bool wanted)
{
    if (wanted) {
        *field = quantity_or(*field, value);
    }
}

static void fill_piece(scene_rod *rod)
{
    scene_properties properties = scene_rod_properties(rod);
    bool massive = quantity_is_something(properties.mass_per_length);
    bool sectioned = rod->section != SCENE_SECTION_NONE && rod->density.is_given;
    fill(&rod->shear_correction, scene_shear_correction(rod), true);
    for (int i = 0; i < 2; i++) {
        fill(&rod->shear_stiffness[i], properties.strain_stiffness[i], true);
        fill(&rod->bending_stiffness[i], properties.curvature_stiffness[i], true);
    }
    fill(&rod->axial_stiffness, properties.strain_stiffness[2], true);
    fill(&rod->torsional_stiffness, properties.curvature_stiffness[2], true);
    fill(&rod->mass_per_length, properties.mass_per_length, massive);
    for (int i = 0; i < 3; i++) {
        fill(&rod->strain_damping[i], properties.strain_damping[i], true);
        fill(&rod->curvature_damping[i], properties.curvature_damping[i], true);
        fill(&rod->rotary_inertia[i], properties.rotary_inertia[i], sectioned);
    }
}

void config_fill_stiffness(scene *rod_scene)
{
    for (int i = 0; i < rod_scene->segment_count; i++) {
        scene_rod rod = scene_piece_of(rod_scene, i).rod;
        fill_piece(&rod);
        rod_scene->segments[i].rod = rod;
    }
    if (rod_scene->segment_count == 0) {
        fill_piece(&rod_scene->rod);
    }
    rod_scene->rod.length = quantity_number(scene_length(rod_scene));
}

/* By a stiffness over a power of the length. */
static void scale_load(quantity *entries, quantity stiffness, quantity power)
{
    for (int i = 0; i < 3; i++) {
        entries[i] = quantity_multiply(entries[i], quantity_divide(stiffness, power));
    }
}

static ad_status resolve_units(config *experiment, ad_error *error)
{
    scene *given = &experiment->scene;
    scene_loads *loads = &given->loads;
    const quantity length = scene_whole_length(given);
    quantity bending = scene_properties_of(&experiment->scene).curvature_stiffness[0];
    const struct {
        quantity *entries;
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
    if (quantity_depends_on(bending, "s") || scene_locks(bending)) {
        return config_blame(experiment->source, error, "loads.units",
                            "EI needs a finite bending stiffness about d1, the same all along; "
                            "allowed here: SI");
    }
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        scale_load(rows[i].entries, bending, quantity_power(length, rows[i].power));
    }
    for (int i = 0; i < given->point_count; i++) {
        scale_load(given->points[i].load.force, bending, quantity_power(length, 2));
        scale_load(given->points[i].load.moment, bending, length);
    }
    experiment->load_units = CONFIG_UNITS_SI;
    return config_check_scene(experiment, error);
}

/* Numbers only; physics normalises formulas. A quaternion that is unit already stays as it is, so
 * that writing and reading it again changes nothing. */
static void normalize(quantity rotation[4])
{
    double value[4];
    double square = 0;
    for (int i = 0; i < 4; i++) {
        if (rotation[i].node || !quantity_is_number(rotation[i], &value[i])) {
            return;
        }
        square += value[i] * value[i];
    }
    for (int i = 0; i < 4 && fabs(square - 1) > 1e-15; i++) {
        rotation[i] = quantity_number(value[i] / sqrt(square));
    }
}

ad_status config_absolute(config *experiment, const char *path, const char **file, ad_error *error)
{
    const char *scene_file = config_source_file(experiment->source);
    const char *slash = strrchr(scene_file, '/');
    char joined[4096];
    char folder[2048] = "";
    if (!*file || **file == '/') {
        return AD_OK;
    }
    if (*scene_file != '/' && !getcwd(folder, sizeof folder)) {
        return ad_fail(error, AD_IO, "the current folder has no name that fits");
    }
    int length = snprintf(joined, sizeof joined, "%s%s%.*s%s", folder, *folder ? "/" : "",
                          slash ? (int)(slash - scene_file + 1) : 0, scene_file, *file);
    if (length < 0 || (size_t)length >= sizeof joined) {
        return config_blame(experiment->source, error, path, "the path is too long");
    }
    *file = config_keep(experiment->source, joined);
    return *file ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory");
}

/* The same of a file in the folder of data. */
static ad_status find_data(config *experiment, const char *path, const char **file, ad_error *error)
{
    const char *folder = experiment->settings.data_folder;
    char joined[4096];
    if (*file && **file != '/' && folder) {
        const int length = snprintf(joined, sizeof joined, "%s/%s", folder, *file);
        if (length < 0 || (size_t)length >= sizeof joined) {
            return config_blame(experiment->source, error, path, "the path is too long");
        }
        *file = config_keep(experiment->source, joined);
        if (!*file) {
            return ad_fail(error, AD_NO_MEMORY, "out of memory");
        }
    }
    return config_absolute(experiment, path, file, error);
}

/* Paths of files that are read later. */
static ad_status resolve_files(config *experiment, ad_error *error)
{
    train_settings *settings = &experiment->settings;
    ad_status status = AD_OK;
    for (int i = 0; status == AD_OK && i < settings->data_count; i++) {
        char path[32];
        snprintf(path, sizeof path, "data[%d].file", i);
        status = find_data(experiment, path, &settings->data[i].file, error);
    }
    const struct {
        const char *path, **file;
    } files[] = {{"members.file", &settings->members_file},
                 {"reference.file", &settings->reference_file},
                 {"control.residual", &experiment->control.residual},
                 {"control.task.file", &experiment->control.task.file},
                 {"control.environment.file", &experiment->control.environment.file},
                 {"plan.environment.file", &experiment->plan.environment.file},
                 {"optimize.environment.file", &experiment->optimize.environment.file},
                 {"plan.roadmap.file", &experiment->plan.roadmap},
                 {"optimize.file", &experiment->optimize.file}};
    for (size_t i = 0; status == AD_OK && i < sizeof files / sizeof *files; i++) {
        status = config_absolute(experiment, files[i].path, files[i].file, error);
    }
    return status;
}

/* Lengths and places of a family become those of its middle, last of all that is done to the
 * scene. */
static ad_status map_places(config *experiment, ad_error *error)
{
    const char *key = "rod.length";
    ad_error reason;
    experiment->as_written = experiment->scene;
    const ad_status status = scene_map(&experiment->as_written, &experiment->scene, &key, &reason);
    experiment->is_mapped = experiment->scene.place.is_given;
    if (status != AD_OK) {
        return config_blame(experiment->source, error, key, "%s", reason.message);
    }
    if (experiment->is_mapped && experiment->settings.data_count > 0 &&
        experiment->scene.unknown_count == 0 &&
        (scene_is_family(&experiment->scene) || experiment->scene.feed.to > 0)) {
        return config_blame(experiment->source, error, "data",
                            "are measured along a rod whose lengths or places have ranges, or that "
                            "moves through its port; allowed: numbers, or cpinn-solve with a "
                            "parameter to be identified");
    }
    if (experiment->is_mapped && experiment->settings.reference_file) {
        return config_blame(experiment->source, error, "reference.file",
                            "is of one rod from its base on, but lengths or places have ranges, or "
                            "the rod is inserted in part; allowed: solve");
    }
    /* What follows the time was checked as it is written: along it lengths and loads change. */
    return experiment->scene.feed.by == SCENE_FED_IN_TIME ? AD_OK
                                                          : config_check_scene(experiment, error);
}

ad_status config_resolve_physics(config *experiment, ad_error *error)
{
    ad_status status = resolve_units(experiment, error);
    normalize(experiment->scene.start.rotation);
    normalize(experiment->scene.end.rotation);
    if (status == AD_OK && config_has(experiment, "surrogate.") &&
        !surrogate_is_given(&experiment->surrogate)) {
        return config_blame(experiment->source, error, "surrogate.step",
                            "is not given beside other keys of the section; allowed: a number > 0 "
                            "(s)");
    }
    status = status == AD_OK ? map_places(experiment, error) : status;
    return status == AD_OK ? resolve_files(experiment, error) : status;
}
