/* What scene_check asks of the rod itself. */
#include "physics/rod/rod.h"
#include "physics/scene/scene_internal.h"

#include <math.h>

/* A dimension of the section: the shapes (bits) that have it. */
static ad_status check_sizes(const scene_checker *check, const scene_rod *rod, bool complete)
{
    const struct {
        const char *key;
        quantity value;
        unsigned shapes;
    } rows[] = {
        {"rod.section.radius", rod->radius, 1U << SCENE_CIRCLE | 1U << SCENE_TUBE},
        {"rod.section.inner_radius", rod->inner_radius, 1U << SCENE_TUBE},
        {"rod.section.width", rod->width, 1U << SCENE_RECTANGLE},
        {"rod.section.height", rod->height, 1U << SCENE_RECTANGLE},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        bool has = rows[i].shapes >> rod->section & 1;
        if (has && complete && !rows[i].value.is_given) {
            return scene_refuse(check, rows[i].key, "missing; the section's shape needs it");
        }
        if (!has && rows[i].value.is_given) {
            return scene_refuse(
                check, rows[i].key,
                "the section's shape has no such size; circle: radius, tube: radius and "
                "inner_radius, rectangle: width and height");
        }
    }
    return AD_OK;
}

static ad_status check_section(const scene_checker *check)
{
    const scene_rod *rod = &check->piece->rod;
    ad_status status = check_sizes(check, rod, true);
    if (status != AD_OK) {
        return status;
    }
    quantity wall = quantity_subtract(rod->radius, rod->inner_radius);
    if (rod->section == SCENE_TUBE && !(scene_check_range(check, wall).low > 0)) {
        return scene_refuse(check, "rod.section.inner_radius",
                            "must be less than rod.section.radius");
    }
    return AD_OK;
}

/* One row per stiffness: what it is made of when it is not given, and whether the model locks it.
 */
typedef struct stiffness_row {
    const char *key;
    int count;
    const quantity *values;
    bool locked;
    bool needs_poisson;
} stiffness_row;

static ad_status check_derived_stiffness(const scene_checker *check, const stiffness_row *row)
{
    const scene_rod *rod = &check->piece->rod;
    if (rod->section == SCENE_SECTION_NONE) {
        return scene_refuse(check, row->key,
                            "missing; give rod.section and rod.material, or this stiffness itself");
    }
    if (!rod->youngs_modulus.is_given) {
        return scene_refuse(check, "rod.material.youngs_modulus",
                            "missing; the stiffness of the section follows from it");
    }
    if (row->needs_poisson && !rod->poissons_ratio.is_given) {
        return scene_refuse(check, "rod.material.poissons_ratio",
                            "missing; shear and torsional stiffness follow from it");
    }
    return AD_OK;
}

static ad_status check_stiffness_row(const scene_checker *check, const stiffness_row *row)
{
    int found = 0;
    for (int i = 0; i < row->count; i++) {
        quantity value = row->values[i];
        found += value.is_given;
        if (row->locked && value.is_given && !scene_locks(value)) {
            return scene_refuse(
                check, row->key,
                "contradicts rod.model, which locks this strain; leave it out, or take "
                "model cosserat");
        }
    }
    return found || row->locked ? AD_OK : check_derived_stiffness(check, row);
}

/* Some piece has to bend. */
static bool bends_somewhere(const scene *given)
{
    bool bends = false;
    for (int i = 0; i < scene_pieces(given); i++) {
        const scene_piece piece = scene_piece_of(given, i);
        const scene_properties properties = scene_rod_properties(&piece.rod);
        bends = bends || !scene_locks(properties.curvature_stiffness[0]) ||
                !scene_locks(properties.curvature_stiffness[1]);
    }
    return bends;
}

static ad_status check_stiffness(const scene_checker *check)
{
    const scene_rod *rod = &check->piece->rod;
    const stiffness_row rows[] = {
        {"rod.stiffness.bending", 2, rod->bending_stiffness, false, false},
        {"rod.stiffness.torsion", 1, &rod->torsional_stiffness, scene_is_beam(check->scene), true},
        {"rod.stiffness.axial", 1, &rod->axial_stiffness, rod->model != SCENE_COSSERAT, false},
        {"rod.stiffness.shear", 2, rod->shear_stiffness,
         rod->model == SCENE_KIRCHHOFF || rod->model == SCENE_EULER_BERNOULLI, true},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        ad_status status = check_stiffness_row(check, &rows[i]);
        if (status != AD_OK) {
            return status;
        }
    }
    if (scene_is_beam(check->scene)) {
        return AD_OK; /* scene_check_beam looks at what is left of them */
    }
    return bends_somewhere(check->scene) ? AD_OK
                                         : scene_refuse(check, "rod.stiffness.bending",
                                                        "at least one of the two must be finite");
}

/* The law needs every number it is made of, and one of the ways to give it. */
static ad_status check_material_damping(const scene_checker *check)
{
    const scene_rod *rod = &check->piece->rod;
    if (rod->maxwell_ratio.is_given != rod->maxwell_time.is_given) {
        return rod->maxwell_ratio.is_given
                   ? scene_refuse(check, "rod.material.maxwell.time", "missing; a time in s")
                   : scene_refuse(check, "rod.material.maxwell.ratio", "missing; a number >= 0");
    }
    const char *key =
        rod->viscosity.is_given ? "rod.material.viscosity" : "rod.material.relaxation_time";
    quantity given = quantity_or(rod->viscosity, rod->relaxation_time);
    if (!given.is_given) {
        return AD_OK;
    }
    if (rod->viscosity.is_given && rod->relaxation_time.is_given) {
        return scene_refuse(check, "rod.material.relaxation_time",
                            "given beside rod.material.viscosity; allowed: one of the two");
    }
    if (quantity_any_given(3, rod->strain_damping) ||
        quantity_any_given(3, rod->curvature_damping)) {
        return scene_refuse(check, key,
                            "given beside rod.damping; allowed: damping by the material, or by "
                            "rod.damping");
    }
    if (!rod->viscosity.is_given) {
        return AD_OK;
    }
    if (rod->section == SCENE_SECTION_NONE) {
        return scene_refuse(check, key,
                            "needs the integrals of rod.section; give it, or take "
                            "rod.material.relaxation_time or rod.damping");
    }
    return rod->poissons_ratio.is_given
               ? AD_OK
               : scene_refuse(check, "rod.material.poissons_ratio",
                              "missing; damping of shear and twist by rod.material.viscosity "
                              "follows from it");
}

static ad_status check_damping(const scene_checker *check)
{
    const scene_rod *rod = &check->piece->rod;
    const char *locked =
        "damps a strain that rod.model or an infinite stiffness locks; allowed for it: 0";
    scene_properties properties = scene_rod_properties(&check->piece->rod);
    const struct {
        const char *key;
        const quantity *damping, *stiffness;
    } rows[] = {{"rod.damping.strain", rod->strain_damping, properties.strain_stiffness},
                {"rod.damping.curvature", rod->curvature_damping, properties.curvature_stiffness}};
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 3; i++) {
            if (quantity_is_something(rows[k].damping[i]) && scene_locks(rows[k].stiffness[i])) {
                return scene_refuse(check, rows[k].key, locked);
            }
        }
    }
    return check_material_damping(check);
}

static ad_status check_inertia(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    const scene_rod *rod = &check->piece->rod;
    bool heavy = quantity_any_something(3, rod_scene->loads.gravity);
    bool follows = rod->section != SCENE_SECTION_NONE && rod->density.is_given;
    bool massive = follows || rod->mass_per_length.is_given;
    bool rotary = rod->rotary_inertia[0].is_given;
    if ((heavy || scene_is_dynamic(check->scene)) && !massive) {
        return scene_refuse(check,
                            rod->section == SCENE_SECTION_NONE ? "rod.inertia.mass_per_length"
                                                               : "rod.material.density",
                            scene_is_dynamic(check->scene)
                                ? "missing; a dynamic scene needs the rod's mass"
                                : "missing; loads.gravity needs the rod's mass");
    }
    if (scene_is_dynamic(check->scene) && !follows && !rotary &&
        rod->model != SCENE_EULER_BERNOULLI) {
        return scene_refuse(
            check, "rod.inertia.rotary",
            "missing; give rho I about d1, d2, d3, or [0, 0, 0] to leave rotary inertia "
            "out");
    }
    return AD_OK;
}

/* Length, bending stiffness and mass are the units of all else. Products of a few powers of them
 * stay finite within these ranges, which hold any rod there is. */
static ad_status check_units(const scene_checker *check)
{
    const scene_rod *rod = &check->piece->rod;
    scene_properties properties = scene_rod_properties(&check->piece->rod);
    scene_range bending[2], youngs = scene_check_range(check, rod->youngs_modulus);
    bool made = !rod->bending_stiffness[0].is_given;
    bool odd_material = made && !(youngs.low >= 1e-30 && youngs.high <= 1e30);
    bool dynamic = scene_is_dynamic(check->scene);
    double unit_of_time = dynamic ? rod_scales_of(check->scene).time : 1;
    for (int i = 0; i < 2; i++) {
        bending[i] = scene_check_range(check, properties.curvature_stiffness[i]);
    }
    double softest = fmin(bending[0].low, bending[1].low); /* infinite: locked here */
    const struct {
        const char *key, *what, *unit;
        double value, low, high;
    } rows[] = {
        {"rod.length", "length", "m", scene_length(check->scene), 1e-30, 1e30},
        {odd_material ? "rod.material.youngs_modulus"
         : made       ? "rod.section"
                      : "rod.stiffness.bending",
         "bending stiffness", "N m^2", isinf(softest) && !scene_is_beam(check->scene) ? 1 : softest,
         1e-60, 1e60},
        {rod->mass_per_length.is_given ? "rod.inertia.mass_per_length" : "rod.material.density",
         "mass", "kg/m", dynamic ? scene_mean(check->scene, properties.mass_per_length) : 1, 1e-60,
         1e60},
        {"time.duration", "motion", "L^2 (rhoA/EI)^(1/2) long",
         dynamic ? scene_duration(check->scene) / unit_of_time : 1, 1e-12, 1e12},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (!(rows[i].value >= rows[i].low && rows[i].value <= rows[i].high)) {
            scene_refuse(check, rows[i].key, "");
            return ad_fail(check->error, AD_BAD_INPUT,
                           "the rod's %s is %g %s, beyond what can be computed with; allowed: %g "
                           "to %g",
                           rows[i].what, rows[i].value, rows[i].unit, rows[i].low, rows[i].high);
        }
    }
    return AD_OK;
}

/* A strain of a beam is locked all along, or nowhere. */
static ad_status check_locks(const scene_checker *check)
{
    scene_piece first = scene_piece_of(check->scene, 0);
    const scene_properties before = scene_rod_properties(&first.rod);
    const scene_properties here = scene_rod_properties(&check->piece->rod);
    bool shear = scene_locks(before.strain_stiffness[1]) != scene_locks(here.strain_stiffness[1]);
    bool bending =
        scene_locks(before.curvature_stiffness[0]) != scene_locks(here.curvature_stiffness[0]);
    return scene_is_beam(check->scene) && (shear || bending)
               ? scene_refuse(check, shear ? "rod.stiffness.shear" : "rod.stiffness.bending",
                              "is infinite in some segments of a beam and not in others; allowed: "
                              ".inf in all of them, or a large number")
               : AD_OK;
}

/* The stiffness of every piece is that of the law at rest, or locked. */
static ad_status check_law(const scene_checker *check)
{
    const scene_law *law = check->scene->rod.law;
    const scene_properties properties = scene_rod_properties(&check->piece->rod);
    const char *why = !law                           ? NULL
                      : scene_is_beam(check->scene)  ? "a beam of small deflection is linear"
                      : check->scene->tube_count > 0 ? "tubes are linear"
                                                     : NULL;
    for (int i = 0; i < SCENE_LAW_STRAINS && law && !why; i++) {
        quantity of =
            i < 3 ? properties.strain_stiffness[i] : properties.curvature_stiffness[i - 3];
        if (!scene_locks(of) && !quantity_is(of, law->stiffness[i])) {
            why = "the law has a stiffness of its own beside rod.stiffness; allowed: one of the "
                  "two, or a stiffness of .inf";
        }
    }
    return why ? scene_refuse(check, "rod.law", why) : AD_OK;
}

static ad_status check_piece(const scene_checker *check)
{
    static scene_check_part *const parts[] = {check_section, check_stiffness, check_damping,
                                              check_inertia, check_locks,     check_law};
    ad_status status = AD_OK;
    for (size_t i = 0; i < sizeof parts / sizeof *parts && status == AD_OK; i++) {
        status = parts[i](check);
    }
    return status;
}

ad_status scene_check_rod(const scene_checker *check)
{
    const scene_rod *whole = &check->scene->rod;
    ad_status status = whole->section == SCENE_SECTION_NONE || check->scene->segment_count == 0
                           ? AD_OK
                           : check_sizes(check, whole, false);
    if (status == AD_OK) {
        status = scene_check_pieces(check, check_piece);
    }
    return status == AD_OK ? scene_check_pieces(check, check_units) : status;
}
