/* Defaults of a scene, the texts of its enumerations, and the stiffness and inertia that follow
 * from section and material. */
#include "physics/scene/scene_internal.h"
#include "physics/scene/section.h"

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
SCENE_NAMES(scene_state_names, SCENE_STATE_LIST)
SCENE_NAMES(scene_scale_names, SCENE_SCALE_LIST)

void scene_defaults(scene *rod_scene)
{
    memset(rod_scene, 0, sizeof *rod_scene);
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        quantity *to = (quantity *)(void *)((char *)rod_scene + field->offset);
        for (int k = 0; k < field->count; k++) {
            to[k] = scene_field_otherwise(field, k);
        }
    }
    rod_scene->start.type = SCENE_CLAMPED;
    rod_scene->end.type = SCENE_FREE;
    rod_scene->windows = 1;
}

/* ---- along the rod and in time ----------------------------------------------------------------
 */

enum { SCENE_SAMPLES = 64, SCENE_MEAN_SAMPLES = 16 };

scene_range scene_range_within(const scene *rod_scene, quantity q, double from, double to)
{
    int along = quantity_depends_on(q, "s") ? SCENE_SAMPLES : 0;
    int in_time = quantity_depends_on(q, "t") ? SCENE_SAMPLES : 0;
    scene_range range = {INFINITY, -INFINITY};
    for (int i = 0; i <= along; i++) {
        for (int j = 0; j <= in_time; j++) {
            quantity_interval value = quantity_span(q, from + (to - from) * i / SCENE_SAMPLES,
                                                    scene_duration(rod_scene) * j / SCENE_SAMPLES);
            range.low = !(value.low >= range.low) ? value.low : range.low;
            range.high = !(value.high <= range.high) ? value.high : range.high;
            if (isnan(value.low)) {
                return (scene_range){NAN, NAN};
            }
        }
    }
    return range;
}

/* A little before the next piece begins, whose numbers hold there. */
static double scene_end_of(const scene_piece *piece, const scene *rod_scene)
{
    return piece->to < scene_length(rod_scene) ? nextafter(piece->to, 0) : piece->to;
}

scene_range scene_range_of(const scene *rod_scene, quantity q)
{
    scene_range range = {INFINITY, -INFINITY};
    for (int i = 0; i < scene_pieces(rod_scene); i++) {
        scene_piece piece = scene_piece_of(rod_scene, i);
        scene_range within =
            scene_range_within(rod_scene, q, piece.from, scene_end_of(&piece, rod_scene));
        if (isnan(within.low)) {
            return within;
        }
        range.low = fmin(range.low, within.low);
        range.high = fmax(range.high, within.high);
    }
    return range;
}

/* By the midpoint rule in every piece; one number for many does not need to be the exact mean.
 * Pieces in which it is infinite are left out, unless all are. */
static double scene_average(const scene *rod_scene, quantity q, bool of_logarithm)
{
    double sum = 0, length = 0;
    for (int k = 0; k < scene_pieces(rod_scene); k++) {
        scene_piece piece = scene_piece_of(rod_scene, k);
        double span = piece.to - piece.from, share = 0;
        for (int i = 0; i < SCENE_MEAN_SAMPLES; i++) {
            double s = piece.from + span * (i + 0.5) / SCENE_MEAN_SAMPLES;
            double value = quantity_value(q, s, 0);
            share += (of_logarithm ? log(value) : value) / SCENE_MEAN_SAMPLES;
        }
        if (!isinf(share)) {
            sum += share * span;
            length += span;
        }
    }
    return length > 0 ? sum / length : INFINITY;
}

double scene_mean_stiffness(const scene *rod_scene, quantity stiffness)
{
    double value = 0;
    return quantity_is_number(stiffness, &value) ? value
                                                 : exp(scene_average(rod_scene, stiffness, true));
}

double scene_mean(const scene *rod_scene, quantity q)
{
    double value = 0;
    return quantity_is_number(q, &value) ? value : scene_average(rod_scene, q, false);
}

/* ---- the scene --------------------------------------------------------------------------------
 */

bool scene_is_manufactured(const scene *rod_scene)
{
    return rod_scene->manufactured.position[0].is_given;
}

scene_hold scene_hold_of(const scene_end *end)
{
    scene_hold hold = {.directions = scene_end_is_placed(end->type) ? 3 : 0};
    const quantity *given = end->along[0].is_given ? end->along : end->across;
    double square = 0;
    if (!scene_end_slides(end->type)) {
        return hold;
    }
    hold.directions = end->along[0].is_given ? 2 : end->across[0].is_given ? 1 : 0;
    for (int i = 0; i < 3 && hold.directions > 0; i++) {
        hold.axis[i] = given[i].number;
        square += given[i].number * given[i].number;
    }
    for (int i = 0; i < 3 && hold.directions > 0; i++) {
        hold.axis[i] /= sqrt(square);
    }
    return hold;
}

void scene_hold_part(const scene_hold *hold, const double x[3], double part[3])
{
    const double *a = hold->axis, dot = a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
    for (int i = 0; i < 3; i++) {
        part[i] = hold->directions == 1   ? dot * a[i]
                  : hold->directions == 2 ? x[i] - dot * a[i]
                  : hold->directions == 3 ? x[i]
                                          : 0;
    }
}

bool scene_couples_inertia(const scene *rod_scene)
{
    bool couples = quantity_is_something(rod_scene->loads.added_mass);
    for (int i = 0; i < rod_scene->body_count; i++) {
        couples = couples || quantity_any_something(3, rod_scene->bodies[i].offset);
    }
    return couples;
}

bool scene_locks_strains(const scene *rod_scene)
{
    bool locks = false;
    for (int i = 0; i < scene_pieces(rod_scene) && !scene_is_beam(rod_scene); i++) {
        const scene_piece piece = scene_piece_of(rod_scene, i);
        const scene_properties properties = scene_rod_properties(&piece.rod);
        for (int k = 0; k < 3; k++) {
            locks = locks || scene_locks(properties.strain_stiffness[k]);
        }
    }
    return locks;
}

bool scene_locks_somewhere(const scene *rod_scene)
{
    bool locks = false;
    for (int i = 0; i < scene_pieces(rod_scene); i++) {
        const scene_piece piece = scene_piece_of(rod_scene, i);
        const scene_properties properties = scene_rod_properties(&piece.rod);
        locks = locks || scene_is_locked(&properties);
    }
    return locks;
}

bool scene_has_displaced_tendons(const scene *rod_scene)
{
    for (int i = 0; i < rod_scene->tendon_count; i++) {
        if (rod_scene->tendons[i].displacement.is_given) {
            return true;
        }
    }
    return false;
}

bool scene_has_rubbing_tendons(const scene *rod_scene)
{
    for (int i = 0; i < rod_scene->tendon_count; i++) {
        if (quantity_is_something(rod_scene->tendons[i].friction)) {
            return true;
        }
    }
    return false;
}

bool scene_is_imperfect(const scene *rod_scene)
{
    scene_rest rest = scene_rest_of(rod_scene);
    return quantity_any_something(3, rest.imperfection);
}

static bool model_locks(scene_model model, int strain)
{
    return (model == SCENE_KIRCHHOFF && strain < 2) || (model != SCENE_COSSERAT && strain == 2);
}

static void stiffness_of(const scene_rod *rod, const scene_section_geometry *section,
                         scene_properties *properties)
{
    const quantity one = quantity_number(1), infinity = quantity_number(INFINITY);
    quantity youngs = rod->youngs_modulus;
    quantity shear = quantity_divide(
        youngs, quantity_multiply(quantity_number(2), quantity_add(one, rod->poissons_ratio)));
    quantity correction = quantity_or(rod->shear_correction, scene_shear_correction(rod));
    quantity corrected = quantity_multiply(quantity_multiply(correction, shear), section->area);
    for (int i = 0; i < 2; i++) {
        properties->strain_stiffness[i] = quantity_or(rod->shear_stiffness[i], corrected);
        properties->curvature_stiffness[i] = quantity_or(
            rod->bending_stiffness[i], quantity_multiply(youngs, section->second_moment[i]));
    }
    properties->strain_stiffness[2] =
        quantity_or(rod->axial_stiffness, quantity_multiply(youngs, section->area));
    properties->curvature_stiffness[2] =
        quantity_or(rod->torsional_stiffness, quantity_multiply(shear, section->torsion_constant));
    for (int i = 0; i < 3; i++) {
        if (model_locks(rod->model, i)) {
            properties->strain_stiffness[i] = infinity;
        }
    }
}

void scene_take_law(scene_rod *rod, const scene_law *law)
{
    quantity *const of[SCENE_LAW_STRAINS] = {&rod->shear_stiffness[0],   &rod->shear_stiffness[1],
                                             &rod->axial_stiffness,      &rod->bending_stiffness[0],
                                             &rod->bending_stiffness[1], &rod->torsional_stiffness};
    rod->law = law;
    for (int i = 0; i < SCENE_LAW_STRAINS; i++) {
        if (!model_locks(rod->model, i)) {
            *of[i] = quantity_or(*of[i], quantity_number(law->stiffness[i]));
        }
    }
}

static quantity damping_of(quantity given, quantity by_material, quantity stiffness)
{
    const quantity zero = quantity_number(0);
    return scene_locks(stiffness) ? zero : quantity_or(quantity_or(given, by_material), zero);
}

static void dampings_of(const scene_rod *rod, const scene_section_geometry *section,
                        scene_properties *properties)
{
    quantity twice = quantity_scale(quantity_add(quantity_number(1), rod->poissons_ratio), 2);
    quantity eta = rod->viscosity, in_shear = quantity_divide(eta, twice);
    quantity correction = quantity_or(rod->shear_correction, scene_shear_correction(rod));
    quantity sheared = quantity_multiply(quantity_multiply(correction, in_shear), section->area);
    const quantity strain[3] = {sheared, sheared, quantity_multiply(eta, section->area)};
    const quantity curvature[3] = {quantity_multiply(eta, section->second_moment[0]),
                                   quantity_multiply(eta, section->second_moment[1]),
                                   quantity_multiply(in_shear, section->torsion_constant)};
    for (int i = 0; i < 3; i++) {
        quantity stiff = properties->strain_stiffness[i], bent = properties->curvature_stiffness[i];
        quantity relaxing = quantity_multiply(rod->relaxation_time, stiff);
        properties->strain_damping[i] =
            damping_of(rod->strain_damping[i], quantity_or(strain[i], relaxing), stiff);
        relaxing = quantity_multiply(rod->relaxation_time, bent);
        properties->curvature_damping[i] =
            damping_of(rod->curvature_damping[i], quantity_or(curvature[i], relaxing), bent);
    }
    const quantity zero = quantity_number(0);
    const bool branches = rod->maxwell_ratio.is_given && rod->maxwell_time.is_given;
    properties->maxwell_ratio = branches ? rod->maxwell_ratio : zero;
    properties->maxwell_rate =
        branches ? quantity_divide(quantity_number(1), rod->maxwell_time) : zero;
}

/* A beam bends about d1 and shears along d2; an Euler-Bernoulli beam has no rotary inertia. */
static void lock_beam(const scene_rod *rod, scene_properties *properties)
{
    const quantity zero = quantity_number(0), infinity = quantity_number(INFINITY);
    bool shears = rod->model == SCENE_TIMOSHENKO;
    properties->strain_stiffness[0] = infinity;
    properties->curvature_stiffness[1] = properties->curvature_stiffness[2] = infinity;
    properties->rotary_inertia[1] = properties->rotary_inertia[2] = zero;
    if (!shears) {
        properties->strain_stiffness[1] = infinity;
        properties->rotary_inertia[0] = zero;
    }
}

scene_properties scene_rod_properties(const scene_rod *rod)
{
    const quantity zero = quantity_number(0); /* static and weightless: never used */
    scene_section_geometry section = scene_section_geometry_of(rod);
    scene_properties properties;
    stiffness_of(rod, &section, &properties);
    quantity mass =
        quantity_or(rod->mass_per_length, quantity_multiply(rod->density, section.area));
    quantity polar = quantity_add(section.second_moment[0], section.second_moment[1]);
    const quantity moments[3] = {section.second_moment[0], section.second_moment[1], polar};
    properties.mass_per_length = quantity_or(mass, zero);
    for (int i = 0; i < 3; i++) {
        quantity inertia = quantity_multiply(rod->density, moments[i]);
        properties.rotary_inertia[i] =
            quantity_or(quantity_or(rod->rotary_inertia[i], inertia), zero);
    }
    if (rod->model == SCENE_EULER_BERNOULLI || rod->model == SCENE_TIMOSHENKO) {
        lock_beam(rod, &properties);
    }
    dampings_of(rod, &section, &properties);
    properties.mass_per_length = scene_grown(properties.mass_per_length, rod->growth, 1);
    for (int i = 0; i < 3; i++) {
        quantity *const over[] = {&properties.strain_stiffness[i],
                                  &properties.curvature_stiffness[i], &properties.strain_damping[i],
                                  &properties.curvature_damping[i]};
        for (size_t k = 0; k < sizeof over / sizeof *over; k++) {
            *over[k] = scene_grown(*over[k], rod->growth, -1);
        }
        properties.rotary_inertia[i] = scene_grown(properties.rotary_inertia[i], rod->growth, 1);
    }
    return properties;
}

bool scene_is_locked(const scene_properties *properties)
{
    for (int i = 0; i < 3; i++) {
        if (scene_locks(properties->strain_stiffness[i]) ||
            scene_locks(properties->curvature_stiffness[i])) {
            return true;
        }
    }
    return false;
}
