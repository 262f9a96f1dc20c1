/* What scene_check asks of segments, and of what acts at places of a rod: points, bodies, springs,
 * tendons, chambers, tubes. Signs and finiteness are in the rows of their quantities. */
#include "physics/scene/scene_internal.h"

#include <math.h>
#include <stddef.h>

/* ---- the extent ------------------------------------------------------------------------------ */

ad_status scene_check_counts(const scene_checker *check)
{
    for (int i = 0; i < scene_list_count; i++) {
        int count = scene_list_length(check->scene, &scene_lists[i]);
        if (count < 0 || count > scene_lists[i].most) {
            *check->key = scene_lists[i].key;
            return ad_fail(check->error, AD_BAD_INPUT, "has %d entries; allowed: up to %d", count,
                           scene_lists[i].most);
        }
    }
    return AD_OK;
}

ad_status scene_check_extent(const scene_checker *check)
{
    const scene *given = check->scene;
    double sum = 0, length = scene_length(given);
    for (int i = 0; i < given->segment_count; i++) {
        if (!given->segments[i].length.is_given) {
            return scene_refuse_at(check, &given->segments[i].length,
                                   "missing; the length of this piece of the rod in m");
        }
        sum += given->segments[i].length.number;
    }
    if (given->segment_count == 0 && !given->rod.length.is_given) {
        return scene_refuse(check, "rod.length", "missing; the length of the undeformed rod in m");
    }
    if (given->segment_count > 1 && !given->names) {
        return scene_refuse(check, "segments",
                            "are joined by formulas; give the scene the names to make them with");
    }
    if (given->segment_count > 0 && !(fabs(sum - length) <= PLACE_ROUNDING * length)) {
        *check->key = "rod.length";
        return ad_fail(check->error, AD_BAD_INPUT,
                       "is %.10g m, but the segments are %.10g m long together; allowed: the same, "
                       "or segments alone",
                       length, sum);
    }
    const scene_range out = given->rod.inserted.is_given
                                ? scene_check_range(check, given->rod.inserted)
                                : (scene_range){0, 0};
    if (!(out.high <= (1 + PLACE_ROUNDING) * length)) {
        *check->key = "rod.inserted";
        return ad_fail(check->error, AD_BAD_INPUT,
                       "is %.10g m of a rod of %.10g m; allowed: up to its length", out.high,
                       length);
    }
    return AD_OK;
}

/* ---- segments -------------------------------------------------------------------------------- */

/* What is given for the whole rod in place of what follows from section and material would hold in
 * a piece of another section or material, too. */
static ad_status check_overrides(const scene_checker *check, int index)
{
    const scene_rod *whole = &check->scene->rod, *own = &check->scene->segments[index].rod;
    bool section = own->section != SCENE_SECTION_NONE || own->radius.is_given ||
                   own->inner_radius.is_given || own->width.is_given || own->height.is_given;
    bool elastic = section || own->youngs_modulus.is_given || own->poissons_ratio.is_given ||
                   own->shear_correction.is_given;
    bool heavy = section || own->density.is_given;
    const struct {
        const quantity *own, *whole;
        bool follows;
    } rows[] = {
        {own->shear_stiffness, whole->shear_stiffness, elastic},
        {&own->axial_stiffness, &whole->axial_stiffness, elastic},
        {own->bending_stiffness, whole->bending_stiffness, elastic},
        {&own->torsional_stiffness, &whole->torsional_stiffness, elastic},
        {&own->mass_per_length, &whole->mass_per_length, heavy},
        {own->rotary_inertia, whole->rotary_inertia, heavy},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].follows && rows[i].whole->is_given && !rows[i].own->is_given) {
            return scene_refuse_at(check, rows[i].own,
                                   "is given under rod, in place of what follows from the section "
                                   "and material of this piece; give it here, too, or not there");
        }
    }
    return AD_OK;
}

ad_status scene_check_segments(const scene_checker *check)
{
    const scene *given = check->scene;
    ad_status status = AD_OK;
    if (given->segment_count > 0 && quantity_any_something(3, given->segments[0].turn)) {
        return scene_refuse_at(check, given->segments[0].turn,
                               "turns the first piece, which has none before it; leave it out, or "
                               "give boundary.start.rotation");
    }
    for (int i = 0; i < given->segment_count && status == AD_OK; i++) {
        status = check_overrides(check, i);
    }
    return status;
}

/* ---- places ---------------------------------------------------------------------------------- */

static const char MISSING_PLACE[] = "missing; a place along the rod in m";
static const char OUTSIDE[] = "lies beyond the rod; allowed: 0 to its length";

static bool is_on_rod(const scene *given, quantity place)
{
    double rounding = PLACE_ROUNDING * scene_length(given);
    return place.number >= 0 && place.number <= scene_length(given) + rounding;
}

static ad_status check_point(const scene_checker *check, const quantity *at, bool loaded,
                             const char *outside)
{
    double length = scene_length(check->scene), rounding = PLACE_ROUNDING * length;
    if (!at->is_given) {
        return scene_refuse_at(check, at, MISSING_PLACE);
    }
    if (!(at->number > rounding && at->number < length - rounding)) {
        return scene_refuse_at(check, at, outside);
    }
    return loaded ? AD_OK
                  : scene_refuse_at(check, at, "neither a force nor a moment is given there");
}

static ad_status check_points(const scene_checker *check)
{
    const scene *given = check->scene;
    ad_status status = AD_OK;
    for (int i = 0; i < given->point_count && status == AD_OK; i++) {
        const scene_point *p = &given->points[i];
        bool loaded = quantity_any_given(3, p->load.force) || quantity_any_given(3, p->load.moment);
        status = check_point(check, &p->at, loaded,
                             "is not within the rod; allowed: 0 < at < length, and at the ends "
                             "loads.base, loads.tip");
    }
    return status;
}

static ad_status check_beam_points(const scene_checker *check)
{
    const scene_beam *beam = &check->scene->beam;
    ad_status status = AD_OK;
    for (int i = 0; i < beam->point_count && status == AD_OK; i++) {
        const scene_beam_point *p = &beam->points[i];
        bool loaded = p->load.force.is_given || p->load.moment.is_given;
        status = check_point(check, &p->at, loaded,
                             "is not within the beam; allowed: 0 < at < length, and at the ends "
                             "beam.base, beam.tip");
    }
    return status;
}

static ad_status check_bodies(const scene_checker *check)
{
    const scene *given = check->scene;
    for (int i = 0; i < given->body_count; i++) {
        const scene_body *body = &given->bodies[i];
        if (!body->at.is_given || !is_on_rod(given, body->at)) {
            return scene_refuse_at(check, &body->at, body->at.is_given ? OUTSIDE : MISSING_PLACE);
        }
        if (!body->mass.is_given) {
            return scene_refuse_at(check, &body->mass, "missing; the mass of the body in kg");
        }
        if (scene_is_beam(given) && quantity_any_something(3, body->magnetic_moment)) {
            return scene_refuse_at(check, body->magnetic_moment,
                                   "is of rods; allowed: a body of a beam without it");
        }
        if (scene_is_beam(given) && quantity_any_something(3, body->offset)) {
            return scene_refuse_at(check, body->offset,
                                   "is of rods; allowed: a body of a beam whose centre is on it");
        }
    }
    return AD_OK;
}

static ad_status check_springs(const scene_checker *check)
{
    const scene *given = check->scene;
    for (int i = 0; i < given->spring_count; i++) {
        const scene_spring *spring = &given->springs[i];
        if (!spring->at.is_given || !is_on_rod(given, spring->at)) {
            return scene_refuse_at(check, &spring->at,
                                   spring->at.is_given ? OUTSIDE : MISSING_PLACE);
        }
        if (!quantity_any_something(3, spring->stiffness) &&
            !quantity_any_something(3, spring->turning)) {
            return scene_refuse_at(check, spring->stiffness,
                                   "missing; a spring has a stiffness, or one against turning");
        }
    }
    return AD_OK;
}

/* ---- along the rod --------------------------------------------------------------------------- */

/* Guides may stand far off a thin backbone, but not farther than the rod is long. */
static ad_status check_guided(const scene_checker *check, int index)
{
    const scene *given = check->scene;
    const scene_actuator one = scene_actuator_of(given, index);
    const quantity *start = one.start, *end = one.end, *offset = one.offset;
    double length = scene_length(given);
    if (start->is_given && !is_on_rod(given, *start)) {
        return scene_refuse_at(check, start, "begins beyond the rod; allowed: 0 to its length");
    }
    if (end->is_given && !is_on_rod(given, *end)) {
        return scene_refuse_at(check, end, "ends beyond the rod; allowed: 0 to its length");
    }
    if (!(one.from < one.to)) {
        return scene_refuse_at(check, end->is_given ? end : start,
                               "it ends before it begins; allowed: start < end");
    }
    if (!offset[0].is_given) {
        return scene_refuse_at(check, offset,
                               "missing; two numbers or formulas of s along d1 and d2, in m");
    }
    for (int i = 0; i < 2; i++) {
        scene_range range = scene_range_within(given, offset[i], one.from, one.to);
        if (!(range.low >= -length && range.high <= length)) {
            return scene_refuse_at(check, offset,
                                   "is farther from the axis than the rod is long; it is in m");
        }
    }
    return AD_OK;
}

static ad_status check_tendons(const scene_checker *check)
{
    const scene *given = check->scene;
    ad_status status = AD_OK;
    for (int i = 0; i < given->tendon_count && status == AD_OK; i++) {
        const scene_tendon *tendon = &given->tendons[i];
        status = check_guided(check, i);
        if (status == AD_OK && tendon->tension.is_given == tendon->displacement.is_given) {
            bool both = tendon->tension.is_given;
            status = scene_refuse_at(check, both ? &tendon->displacement : &tendon->tension,
                                     both ? "given beside tension; allowed: one of the two"
                                          : "missing; give tension or displacement");
        }
        if (status == AD_OK && tendon->stiffness.is_given && !tendon->displacement.is_given) {
            status = scene_refuse_at(check, &tendon->stiffness,
                                     "is that of a tendon with a displacement; leave it out");
        }
    }
    return status;
}

static ad_status check_chambers(const scene_checker *check)
{
    const scene *given = check->scene;
    ad_status status = AD_OK;
    for (int i = 0; i < given->chamber_count && status == AD_OK; i++) {
        const scene_chamber *chamber = &given->chambers[i];
        status = check_guided(check, given->tendon_count + i);
        if (status == AD_OK && !chamber->pressure.is_given) {
            status = scene_refuse_at(check, &chamber->pressure, "missing; its pressure in Pa");
        }
        if (status == AD_OK && !chamber->area.is_given) {
            status = scene_refuse_at(check, &chamber->area,
                                     "missing; the area of the chamber's cross-section in m^2");
        }
    }
    return status;
}

/* ---- tubes ----------------------------------------------------------------------------------- */

/* What all of them ask of the scene. */
static ad_status check_scene_of_tubes(const scene_checker *check)
{
    const scene *given = check->scene;
    if (given->rod.model != SCENE_KIRCHHOFF) {
        return scene_refuse(check, "rod.model",
                            "tubes slide on the rod and take no shear and stretch from it; allowed "
                            "with tubes: kirchhoff");
    }
    if (!scene_end_holds_rotation(given->start.type)) {
        return scene_refuse(check, "boundary.start.type",
                            "tubes are turned against a base that is held; allowed with tubes: "
                            "clamped");
    }
    for (int i = 0; i < given->segment_count; i++) {
        if (quantity_any_something(3, given->segments[i].turn)) {
            return scene_refuse_at(check, given->segments[i].turn,
                                   "tubes do not go round a corner; allowed with tubes: no turn");
        }
    }
    return AD_OK;
}

static ad_status check_tube_section(const scene_checker *check, const scene_tube *tube, double end)
{
    const scene_rod *rod = &tube->rod;
    bool heavy = quantity_any_something(3, check->scene->loads.gravity);
    bool section = rod->radius.is_given, bends = rod->bending_stiffness[0].is_given;
    bool twists = rod->torsional_stiffness.is_given;
    if (section != rod->inner_radius.is_given) {
        return scene_refuse_at(check, section ? &rod->inner_radius : &rod->radius,
                               "missing; a tube has a radius and an inner_radius");
    }
    quantity wall = quantity_subtract(rod->radius, rod->inner_radius);
    if (section && !(scene_range_within(check->scene, wall, 0, end).low > 0)) {
        return scene_refuse_at(check, &rod->inner_radius, "must be less than the tube's radius");
    }
    if ((!bends || !twists) && !section) {
        return scene_refuse_at(check, bends ? &rod->torsional_stiffness : rod->bending_stiffness,
                               "missing; give section and material, or this stiffness itself");
    }
    if ((!bends || !twists) && !rod->youngs_modulus.is_given) {
        return scene_refuse_at(check, &rod->youngs_modulus,
                               "missing; the stiffness of the section follows from it");
    }
    if (!twists && !rod->poissons_ratio.is_given) {
        return scene_refuse_at(check, &rod->poissons_ratio,
                               "missing; the torsional stiffness follows from it");
    }
    if (heavy && !rod->mass_per_length.is_given && !(section && rod->density.is_given)) {
        return scene_refuse_at(check, section ? &rod->density : &rod->mass_per_length,
                               "missing; loads.gravity needs the mass of every tube");
    }
    return AD_OK;
}

static ad_status check_tubes(const scene_checker *check)
{
    const scene *given = check->scene;
    ad_status status = given->tube_count > 0 ? check_scene_of_tubes(check) : AD_OK;
    for (int i = 0; i < given->tube_count && status == AD_OK; i++) {
        const scene_tube *tube = &given->tubes[i];
        if (tube->end.is_given && !(is_on_rod(given, tube->end) && tube->end.number > 0)) {
            return scene_refuse_at(check, &tube->end,
                                   "is not on the rod, which reaches farther than every tube; "
                                   "allowed: above 0 up to its length");
        }
        status = check_tube_section(check, tube, scene_tube_end(given, i));
    }
    return status;
}

static bool is_whole(const scene *given, const scene_actuator *one)
{
    double rounding = PLACE_ROUNDING * scene_length(given);
    return one->from <= rounding && one->to >= scene_length(given) - rounding;
}

/* The loads that make a solution exact are smooth along the rod, and so is it. */
static ad_status check_manufactured(const scene_checker *check)
{
    static const char jumps[] = "makes the rod jump somewhere, but a manufactured solution is "
                                "smooth; leave it out";
    const scene *given = check->scene;
    const struct {
        int count;
        const quantity *first;
    } rows[] = {{given->segment_count, &given->segments[0].length},
                {given->point_count, &given->points[0].at},
                {given->body_count, &given->bodies[0].at},
                {given->spring_count, &given->springs[0].at}};
    if (!scene_is_manufactured(given)) {
        return AD_OK;
    }
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].count > 0) {
            return scene_refuse_at(check, rows[i].first, jumps);
        }
    }
    for (int i = 0; i < scene_actuator_count(given); i++) {
        const scene_actuator one = scene_actuator_of(given, i);
        if (!is_whole(given, &one)) {
            return scene_refuse_at(check, one.offset, jumps);
        }
    }
    return AD_OK;
}

ad_status scene_check_lists(const scene_checker *check)
{
    static scene_check_part *const parts[] = {check_manufactured, check_points,  check_beam_points,
                                              check_bodies,       check_springs, check_tendons,
                                              check_chambers,     check_tubes};
    ad_status status = AD_OK;
    for (size_t i = 0; i < sizeof parts / sizeof *parts && status == AD_OK; i++) {
        status = parts[i](check);
    }
    return status;
}
