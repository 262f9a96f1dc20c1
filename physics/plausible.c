#include "physics/plausible.h"

#include "physics/rod.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

/* What rods are made of. The softest gels that carry themselves have some 1e3 Pa, diamond has
 * 1.2e12; the lightest foams weigh 5 kg/m^3, osmium 22,600. */
static const double MODULUS[2] = {1e3, 2e12}, DENSITY[2] = {5, 2.3e4};

/* Below this modulus (Pa) a material is soft: rubber, gels, no structural one. */
static const double SOFT = 1e9;

/* Nobody has built a soft rod longer than this (m); shorter than the last, no continuum. */
static const double SOFT_LENGTH = 50, SHORTEST = 1e-6;

/* m/s^2; that of the sun is 274. */
static const double GRAVITY = 300;

/* Length over radius: what is shorter is no rod, and a hair of a metre has 3e4. */
static const double SLENDERNESS[2] = {2, 5e4};

/* Times what bends the rod. At 1 it bends by a large angle; cpinn-stress compares up to 1000, and
 * for moments up to 5 turns, 31. */
static const double LARGEST_LOAD = 1000, LARGEST_MOMENT = 100;

static void warn(scene_warnings *all, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static void warn(scene_warnings *all, const char *format, ...)
{
    va_list arguments;
    if (all->count == SCENE_WARNINGS_MAX) {
        return;
    }
    va_start(arguments, format);
    vsnprintf(all->texts[all->count++], SCENE_WARNING_TEXT, format, arguments);
    va_end(arguments);
}

/* A quantity in SI units, wherever it varies to. */
static void check_size(scene_warnings *all, const scene *rod_scene, quantity q,
                       const double range[2], const char *key, const char *unit, const char *less,
                       const char *more)
{
    if (!q.is_given) {
        return;
    }
    scene_range sizes = scene_range_of(rod_scene, q);
    if (sizes.low < range[0]) {
        warn(all, "%s: %.4g %s is %s; it is in %s", key, sizes.low, unit, less, unit);
    } else if (sizes.high > range[1]) {
        warn(all, "%s: %.4g %s is %s; it is in %s", key, sizes.high, unit, more, unit);
    }
}

static void check_material(scene_warnings *all, const scene *rod_scene)
{
    const scene_rod *rod = &rod_scene->rod;
    double length = scene_length(rod_scene), gravity = 0;
    check_size(all, rod_scene, rod->youngs_modulus, MODULUS, "rod.material.youngs_modulus", "Pa",
               "softer than a gel", "stiffer than diamond");
    check_size(all, rod_scene, rod->density, DENSITY, "rod.material.density", "kg/m^3",
               "lighter than foam", "heavier than any metal");
    if (length < SHORTEST) {
        warn(all, "rod.length: %.4g m is shorter than a cell; it is in m", length);
    } else if (length > SOFT_LENGTH && scene_range_of(rod_scene, rod->youngs_modulus).high < SOFT) {
        warn(all, "rod.length: %.4g m is very long for a material as soft as this; it is in m",
             length);
    }
    for (int i = 0; i < 3; i++) {
        double g =
            scene_mean(rod_scene, quantity_or(rod_scene->loads.gravity[i], quantity_number(0)));
        gravity += g * g;
    }
    if (sqrt(gravity) > GRAVITY) {
        warn(all, "loads.gravity: %.4g m/s^2 is more than on any planet (Earth: 9.81)",
             sqrt(gravity));
    }
}

static void check_slenderness(scene_warnings *all, const scene *rod_scene)
{
    const scene_rod *rod = &rod_scene->rod;
    double radius =
        rod->section == SCENE_RECTANGLE
            ? fmax(scene_mean(rod_scene, rod->width), scene_mean(rod_scene, rod->height)) / 2
            : scene_mean(rod_scene, rod->radius);
    double ratio = scene_length(rod_scene) / radius;
    if (ratio < SLENDERNESS[0]) {
        warn(all, "rod.section: the rod is only %.2g times as long as its radius", ratio);
    } else if (ratio > SLENDERNESS[1]) {
        warn(all, "rod.section: the rod is %.2g times as long as its radius, thinner than a hair",
             ratio);
    }
}

static void check_loads(scene_warnings *all, const scene *rod_scene)
{
    const rod_numbers n = rod_numbers_of(rod_scene);
    const struct {
        const char *key, *formula;
        double value, most;
    } rows[] = {{"loads.gravity", "the weight, rhoA g L^3/EI", n.weight, LARGEST_LOAD},
                {"loads.force", "the line load, f L^3/EI", n.distributed_force, LARGEST_LOAD},
                {"loads.tip, loads.base", "the force, F L^2/EI", n.tip_force, LARGEST_LOAD},
                {"loads.moment", "the line moment, l L^2/EI", n.distributed_moment, LARGEST_MOMENT},
                {"loads.tip, loads.base", "the moment, T L/EI", n.tip_moment, LARGEST_MOMENT}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].value > rows[i].most * (1 + 1e-9)) {
            warn(all, "%s: %s, is %.3g times what bends the rod by a large angle", rows[i].key,
                 rows[i].formula, rows[i].value);
        }
    }
}

scene_warnings scene_implausible(const scene *rod_scene)
{
    scene_warnings all = {.count = 0};
    quantity modulus = rod_scene->rod.youngs_modulus;
    if (modulus.is_given && !quantity_is(modulus, 1)) {
        check_material(&all, rod_scene);
    }
    if (rod_scene->rod.section != SCENE_SECTION_NONE) {
        check_slenderness(&all, rod_scene);
    }
    if (!scene_is_beam(rod_scene)) {
        check_loads(&all, rod_scene);
    }
    return all;
}
