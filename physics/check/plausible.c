#include "physics/check/plausible.h"

#include "physics/numerics/constants.h"
#include "physics/numerics/sort.h"
#include "physics/numerics/vector_size.h"
#include "physics/rod/rod.h"
#include "physics/scene/scene_field.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What rods are made of. The softest gels that carry themselves have some 1e3 Pa, diamond has
 * 1.2e12; the lightest foams weigh 5 kg/m^3, osmium 22,600. */
static const double MODULUS[2] = {1e3, 2e12}, DENSITY[2] = {5, 2.3e4};

/* Below this modulus (Pa) a material is soft: rubber, gels, no structural one. */
static const double SOFT = 1e9;

/* What weighs more is a metal (kg/m^3), which is no softer than the last (Pa): gels that are filled
 * with magnets have some 3,000 kg/m^3. */
static const double METAL = 5000, SOFTEST_METAL = 1e8;

/* Nobody has built a soft rod longer than this, and robots, wires and beams of any material are
 * shorter than the next (m): a length in mm. Shorter than the last, no continuum. */
static const double SOFT_LENGTH = 50, LONGEST = 100, SHORTEST = 1e-6;

/* m/s^2; that of the sun is 274. */
static const double GRAVITY = 300;

/* Length over radius: what is shorter is no rod, and a hair of a metre has 3e4. */
static const double SLENDERNESS[2] = {2, 5e4};

/* Times what bends the rod. At 1 it bends by a large angle; tools/bench/stress.sh compares up to
 * 1000, and for moments up to 5 turns, 31. */
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

/* A quantity in SI units, wherever it varies to within its piece. */
static void check_size(scene_warnings *all, const scene *rod_scene, quantity q, int index,
                       const double range[2], const char *key, const char *unit, const char *less,
                       const char *more)
{
    if (!q.is_given) {
        return;
    }
    scene_piece piece = scene_piece_of(rod_scene, index);
    scene_range sizes = scene_range_within(rod_scene, q, piece.from, piece.to);
    key = rod_scene->segment_count > 0 ? scene_key_in_segment(index, key) : key;
    if (sizes.low < range[0]) {
        warn(all, "%s: %.4g %s is %s; it is in %s", key, sizes.low, unit, less, unit);
    } else if (sizes.high > range[1]) {
        warn(all, "%s: %.4g %s is %s; it is in %s", key, sizes.high, unit, more, unit);
    }
}

static void check_material(scene_warnings *all, const scene *rod_scene)
{
    double length = scene_length(rod_scene), gravity = 0, hardest = 0;
    for (int i = 0; i < scene_pieces(rod_scene); i++) {
        const scene_piece piece = scene_piece_of(rod_scene, i);
        quantity modulus = piece.rod.youngs_modulus;
        check_size(all, rod_scene, modulus, i, MODULUS, "rod.material.youngs_modulus", "Pa",
                   "softer than a gel", "stiffer than diamond");
        check_size(all, rod_scene, piece.rod.density, i, DENSITY, "rod.material.density", "kg/m^3",
                   "lighter than foam", "heavier than any metal");
        scene_range range = scene_range_within(rod_scene, modulus, piece.from, piece.to);
        scene_range heavy = scene_range_within(rod_scene, piece.rod.density, piece.from, piece.to);
        hardest = fmax(hardest, modulus.is_given ? range.high : INFINITY);
        if (modulus.is_given && piece.rod.density.is_given && heavy.low > METAL &&
            range.low >= MODULUS[0] && range.low < SOFTEST_METAL) {
            warn(all, "%s: %.4g Pa is softer than any metal, and %.4g kg/m^3 are one; it is in Pa",
                 rod_scene->segment_count > 0
                     ? scene_key_in_segment(i, "rod.material.youngs_modulus")
                     : "rod.material.youngs_modulus",
                 range.low, heavy.low);
        }
    }
    if (length < SHORTEST) {
        warn(all, "rod.length: %.4g m is shorter than a cell; it is in m", length);
    } else if (length > SOFT_LENGTH && hardest < SOFT) {
        warn(all, "rod.length: %.4g m is very long for a material as soft as this; it is in m",
             length);
    } else if (length > LONGEST) {
        warn(all, "rod.length: %.4g m is longer than robots, wires and beams are; it is in m",
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

static double middle(const scene *rod_scene, const scene_piece *piece, quantity q)
{
    scene_range range = scene_range_within(rod_scene, q, piece->from, piece->to);
    return (range.low + range.high) / 2;
}

/* 0 without a section. */
static double radius_of(const scene *rod_scene, const scene_piece *piece)
{
    const scene_rod *rod = &piece->rod;
    return rod->section == SCENE_SECTION_NONE ? 0
           : rod->section == SCENE_RECTANGLE
               ? fmax(middle(rod_scene, piece, rod->width), middle(rod_scene, piece, rod->height)) /
                     2
               : middle(rod_scene, piece, rod->radius);
}

static void check_slenderness(scene_warnings *all, const scene *rod_scene)
{
    for (int i = 0; i < scene_pieces(rod_scene); i++) {
        const scene_piece piece = scene_piece_of(rod_scene, i);
        const char *key = "rod.section";
        double ratio = scene_length(rod_scene) / radius_of(rod_scene, &piece);
        key = rod_scene->segment_count > 0 ? scene_key_in_segment(i, key) : key;
        if (ratio < SLENDERNESS[0]) {
            warn(all, "%s: the rod is only %.2g times as long as its radius", key, ratio);
        } else if (isfinite(ratio) && ratio > SLENDERNESS[1]) {
            warn(all, "%s: the rod is %.2g times as long as its radius, thinner than a hair", key,
                 ratio);
        }
    }
}

/* Guides of a robot stand off its backbone by a few hundredths of the length. */
static const double FARTHEST_GUIDE = 0.25;

static void check_offset(scene_warnings *all, const scene *rod_scene, const quantity offset[2])
{
    double length = scene_length(rod_scene), far = 0;
    for (int i = 0; i < 2; i++) {
        scene_range range = scene_range_of(rod_scene, offset[i]);
        far = fmax(far, fmax(fabs(range.low), fabs(range.high)));
    }
    if (far > FARTHEST_GUIDE * length) {
        warn(all, "%s: %.4g m is %.2g of the length off the axis; it is in m",
             scene_key_of(rod_scene, offset), far, far / length);
    }
}

static void check_actuators(scene_warnings *all, const scene *rod_scene)
{
    for (int i = 0; i < scene_actuator_count(rod_scene); i++) {
        check_offset(all, rod_scene, scene_actuator_of(rod_scene, i).offset);
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
                {"loads.tip, loads.base", "the moment, T L/EI", n.tip_moment, LARGEST_MOMENT},
                {"loads.points, bodies", "the force, F L^2/EI", n.point_force, LARGEST_LOAD},
                {"loads.points", "the moment, T L/EI", n.point_moment, LARGEST_MOMENT},
                {scene_actuator_lists(rod_scene), "tension times offset, T L/EI", n.actuation,
                 LARGEST_MOMENT},
                {"tubes", "curvature times length", n.tubes, LARGEST_MOMENT}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].value > rows[i].most * (1 + 1e-9)) {
            warn(all, "%s: %s, is %.3g times what bends the rod by a large angle", rows[i].key,
                 rows[i].formula, rows[i].value);
        }
    }
}

/* The rod is inside of its tubes. */
static void check_tubes(scene_warnings *all, const scene *rod_scene)
{
    const quantity radius = rod_scene->rod.radius;
    for (int i = 0; i < rod_scene->tube_count && radius.is_given; i++) {
        const quantity inner = rod_scene->tubes[i].rod.inner_radius;
        double end = scene_tube_end(rod_scene, i);
        quantity gap = quantity_subtract(inner, radius);
        if (inner.is_given && scene_range_within(rod_scene, gap, 0, end).low < 0) {
            warn(all, "tubes[%d].section.inner_radius: is less than the radius of the rod inside",
                 i);
        }
    }
}

/* A quaternion is the same for a turn and for what is left to a whole one. */
static void check_turn(scene_warnings *all, const scene *rod_scene)
{
    double turn[3];
    if (rod_turn_is_doubtful(rod_scene, turn)) {
        double size = vector_length(turn);
        warn(all,
             "boundary.end.rotation: is taken as a turn of %.4g degrees about (%.3g, %.3g, %.3g); "
             "rotation_vector says others",
             size * 180 / PI, turn[0] / size, turn[1] / size, turn[2] / size);
    }
}

scene_warnings scene_implausible(const scene *rod_scene)
{
    scene_warnings all = {.count = 0};
    bool material = false;
    for (int i = 0; i < scene_pieces(rod_scene); i++) {
        quantity modulus = scene_piece_of(rod_scene, i).rod.youngs_modulus;
        material = material || (modulus.is_given && !quantity_is(modulus, 1));
    }
    if (material) {
        check_material(&all, rod_scene);
    }
    check_slenderness(&all, rod_scene);
    if (!scene_is_beam(rod_scene)) {
        check_loads(&all, rod_scene);
        check_actuators(&all, rod_scene);
        check_tubes(&all, rod_scene);
        check_turn(&all, rod_scene);
    }
    return all;
}

void scene_judge_sizes(const scene *rod_scene, verdict *result)
{
    const scene_warnings all = scene_implausible(rod_scene);
    char text[VERDICT_TEXT] = "";
    size_t at = 0;
    for (int i = 0; i < all.count && at + strlen(all.texts[i]) + 3 < sizeof text; i++) {
        at += (size_t)sprintf(text + at, "%s%s", i > 0 ? "; " : "", all.texts[i]);
    }
    if (at > 0) {
        verdict_add(result, VERDICT_IMPLAUSIBLE, "%s", text);
    }
}

/* ---- positions ----------------------------------------------------------------------------- */

/* Where a member is held at s = 0, or else at its end; without supports where it begins. */
static void widen(const scene *member, scene_range held[3])
{
    const quantity *at = scene_end_is_placed(member->start.type) ? member->start.position
                         : scene_end_is_placed(member->end.type) ? member->end.position
                                                                 : member->initial.position;
    for (int k = 0; k < 3; k++) {
        const scene_range here = scene_range_of(member, quantity_or(at[k], quantity_number(0)));
        held[k].low = fmin(held[k].low, here.low);
        held[k].high = fmax(held[k].high, here.high);
    }
}

/* The box of all places that the parameters may give to the end that is held. */
static void find_held(const scene *open, scene_range held[3])
{
    double parameters[SCENE_PARAMETERS_MAX];
    for (int k = 0; k < 3; k++) {
        held[k] = (scene_range){INFINITY, -INFINITY};
    }
    for (int corner = 0; corner < 2; corner++) {
        scene member;
        for (int i = 0; i < open->parameter_count; i++) {
            parameters[i] = corner ? open->parameters[i].high : open->parameters[i].low;
        }
        scene_member(open, parameters, &member);
        widen(&member, held);
    }
}

ad_status scene_positions_implausible(const scene *open, size_t rows, const double *const *position,
                                      bool *implausible, char text[SCENE_WARNING_TEXT])
{
    static const double FAR = 10;
    const int columns = scene_is_beam(open) ? 1 : 3;
    scene_range held[3] = {{0, 0}};
    size_t count = 0;
    double *far = malloc((rows + 1) * sizeof *far);
    *implausible = false;
    if (!far) {
        return AD_NO_MEMORY;
    }
    if (columns == 3) {
        find_held(open, held);
    }
    for (size_t i = 0; i < rows; i++) {
        double square = 0;
        for (int k = 0; k < columns; k++) {
            const double at = position[k][i];
            square += pow(fmax(0, fmax(held[k].low - at, at - held[k].high)), 2);
        }
        far[count] = sqrt(square) / scene_length(open);
        count += isfinite(far[count]);
    }
    sort_ascending(count, far);
    const double most = count > 0 ? far[count - 1 - (count - 1) / 4] : 0;
    free(far);
    if (most > FAR) {
        *implausible = true;
        snprintf(text, SCENE_WARNING_TEXT,
                 "positions lie some %.3g times the length, %g m, from where the rod is held; they "
                 "are in m%s",
                 most, scene_length(open), most > 10 * FAR ? ", not in mm" : "");
    }
    return AD_OK;
}
