/* Defaults of a scene, the texts of its enumerations, and the stiffness and inertia that follow
 * from section and material. */
#include "physics/scene.h"

#include "physics/expression.h"

#include <math.h>
#include <string.h>

#define SCENE_TEXT(name, text) text,
#define SCENE_NAMES(function, LIST)                                                                \
    const char *const *function(void)                                                              \
    {                                                                                              \
        static const char *const names[] = {LIST(SCENE_TEXT) NULL};                                \
        return names;                                                                              \
    }

SCENE_NAMES(scene_model_names, SCENE_MODEL_LIST)
SCENE_NAMES(scene_section_names, SCENE_SECTION_LIST)
SCENE_NAMES(scene_end_names, SCENE_END_LIST)
SCENE_NAMES(scene_frame_names, SCENE_FRAME_LIST)
SCENE_NAMES(scene_formulation_names, SCENE_FORMULATION_LIST)
SCENE_NAMES(scene_rotation_names, SCENE_ROTATION_LIST)
SCENE_NAMES(scene_enforcement_names, SCENE_ENFORCEMENT_LIST)
SCENE_NAMES(scene_motion_names, SCENE_MOTION_LIST)

static void rod_defaults(scene_rod *rod)
{
    rod->length = NAN;
    rod->radius = rod->inner_radius = rod->width = rod->height = NAN;
    rod->youngs_modulus = rod->poissons_ratio = rod->density = rod->shear_correction = NAN;
    rod->shear_stiffness[0] = rod->shear_stiffness[1] = NAN;
    rod->bending_stiffness[0] = rod->bending_stiffness[1] = NAN;
    rod->axial_stiffness = rod->torsional_stiffness = rod->mass_per_length = NAN;
    for (int i = 0; i < 3; i++) {
        rod->rotary_inertia[i] = NAN;
        rod->rest_strain[i] = i == 2 ? "1" : "0";
        rod->rest_curvature[i] = rod->imperfection[i] = "0";
    }
}

void scene_defaults(scene *rod_scene)
{
    memset(rod_scene, 0, sizeof *rod_scene);
    rod_defaults(&rod_scene->rod);
    rod_scene->start.type = SCENE_CLAMPED;
    for (int i = 0; i < 3; i++) {
        rod_scene->start.position[i] = "0";
    }
    for (int i = 0; i < 4; i++) {
        rod_scene->start.rotation[i] = i == 0 ? "1" : "0";
    }
    rod_scene->end.type = SCENE_FREE;
    rod_scene->windows = 1;
}

bool scene_is_manufactured(const scene *rod_scene)
{
    return rod_scene->manufactured.position[0] != NULL;
}

bool scene_locks_strains(const scene *rod_scene)
{
    scene_properties properties = scene_properties_of(rod_scene);
    const double *stiffness = properties.strain_stiffness;
    return !scene_is_beam(rod_scene) &&
           (isinf(stiffness[0]) || isinf(stiffness[1]) || isinf(stiffness[2]));
}

bool scene_is_imperfect(const scene *rod_scene)
{
    bool given = false;
    for (int i = 0; i < 3; i++) {
        const char *text = rod_scene->rod.imperfection[i];
        double value = 0;
        given = given || (text && !(expression_is_number(text, &value) && value == 0));
    }
    return given;
}

static double given_or(double given, double otherwise)
{
    return isnan(given) ? otherwise : given;
}

static void stiffness_of(const scene_rod *rod, const scene_section_geometry *section,
                         scene_properties *properties)
{
    double youngs = rod->youngs_modulus;
    double shear = youngs / (2 * (1 + rod->poissons_ratio));
    double correction = given_or(rod->shear_correction, scene_shear_correction(rod));
    for (int i = 0; i < 2; i++) {
        properties->strain_stiffness[i] =
            given_or(rod->shear_stiffness[i], correction * shear * section->area);
        properties->curvature_stiffness[i] =
            given_or(rod->bending_stiffness[i], youngs * section->second_moment[i]);
    }
    properties->strain_stiffness[2] = given_or(rod->axial_stiffness, youngs * section->area);
    properties->curvature_stiffness[2] =
        given_or(rod->torsional_stiffness, shear * section->torsion_constant);
    if (rod->model != SCENE_COSSERAT) {
        properties->strain_stiffness[2] = INFINITY;
    }
    if (rod->model == SCENE_KIRCHHOFF) {
        properties->strain_stiffness[0] = properties->strain_stiffness[1] = INFINITY;
    }
}

/* A beam bends about d1 and shears along d2; an Euler-Bernoulli beam has no rotary inertia. */
static void lock_beam(const scene_rod *rod, scene_properties *properties)
{
    bool shears = rod->model == SCENE_TIMOSHENKO;
    properties->strain_stiffness[0] = INFINITY;
    properties->curvature_stiffness[1] = properties->curvature_stiffness[2] = INFINITY;
    properties->rotary_inertia[1] = properties->rotary_inertia[2] = 0;
    if (!shears) {
        properties->strain_stiffness[1] = INFINITY;
        properties->rotary_inertia[0] = 0;
    }
}

scene_properties scene_properties_of(const scene *rod_scene)
{
    const scene_rod *rod = &rod_scene->rod;
    scene_section_geometry section = scene_section_geometry_of(rod);
    scene_properties properties;
    stiffness_of(rod, &section, &properties);
    double mass = given_or(rod->mass_per_length, rod->density * section.area);
    double polar = section.second_moment[0] + section.second_moment[1];
    double moments[3] = {section.second_moment[0], section.second_moment[1], polar};
    properties.mass_per_length = given_or(mass, 0); /* static and weightless: never used */
    for (int i = 0; i < 3; i++) {
        double inertia = given_or(rod->rotary_inertia[i], rod->density * moments[i]);
        properties.rotary_inertia[i] = given_or(inertia, 0);
    }
    if (scene_is_beam(rod_scene)) {
        lock_beam(rod, &properties);
    }
    return properties;
}

bool scene_is_locked(const scene_properties *properties)
{
    for (int i = 0; i < 3; i++) {
        if (isinf(properties->strain_stiffness[i]) || isinf(properties->curvature_stiffness[i])) {
            return true;
        }
    }
    return false;
}
