/* Segments: what holds for each, and what holds along the whole rod, which switches from one to the
 * next at their joints. */
#include "physics/scene/scene_internal.h"

#include <math.h>
#include <stddef.h>

int scene_pieces(const scene *rod_scene)
{
    return rod_scene->segment_count > 0 ? rod_scene->segment_count : 1;
}

double scene_joint(const scene *rod_scene, int index)
{
    double sum = 0;
    for (int i = 0; i <= index; i++) {
        sum += rod_scene->segments[i].length.number;
    }
    return sum;
}

/* ---- one piece ------------------------------------------------------------------------------- */

static void inherit(int count, quantity *to, const quantity *from)
{
    bool given = quantity_any_given(count, to);
    for (int i = 0; i < count && !given; i++) {
        to[i] = from[i];
    }
}

/* Sizes that the section of the piece has. */
static void inherit_section(scene_rod *rod, const scene_rod *whole)
{
    rod->section = rod->section == SCENE_SECTION_NONE ? whole->section : rod->section;
    if (rod->section == SCENE_RECTANGLE) {
        inherit(1, &rod->width, &whole->width);
        inherit(1, &rod->height, &whole->height);
    } else if (rod->section != SCENE_SECTION_NONE) {
        inherit(1, &rod->radius, &whole->radius);
    }
    if (rod->section == SCENE_TUBE) {
        inherit(1, &rod->inner_radius, &whole->inner_radius);
    }
}

/* Damping is that by the material, in one of two ways, or given by itself: a piece that chooses one
 * has nothing of the others. */
static void inherit_damping(scene_rod *rod, const scene_rod *whole)
{
    bool by_itself =
        quantity_any_given(3, rod->strain_damping) || quantity_any_given(3, rod->curvature_damping);
    bool by_material = rod->viscosity.is_given || rod->relaxation_time.is_given;
    if (!by_itself && !by_material) {
        rod->viscosity = whole->viscosity;
        rod->relaxation_time = whole->relaxation_time;
    }
    inherit(1, &rod->maxwell_ratio, &whole->maxwell_ratio);
    inherit(1, &rod->maxwell_time, &whole->maxwell_time);
    if (!by_material) {
        inherit(3, rod->strain_damping, whole->strain_damping);
        inherit(3, rod->curvature_damping, whole->curvature_damping);
    }
}

static scene_rod rod_of(const scene *rod_scene, int index)
{
    const scene_rod *whole = &rod_scene->rod;
    if (rod_scene->segment_count == 0) {
        return *whole;
    }
    scene_rod rod = rod_scene->segments[index].rod;
    rod.model = whole->model;
    rod.law = whole->law;
    rod.growth = whole->growth;
    rod.length = rod_scene->segments[index].length;
    inherit_section(&rod, whole);
    inherit(1, &rod.youngs_modulus, &whole->youngs_modulus);
    inherit(1, &rod.poissons_ratio, &whole->poissons_ratio);
    inherit(1, &rod.density, &whole->density);
    inherit(1, &rod.shear_correction, &whole->shear_correction);
    inherit(2, rod.shear_stiffness, whole->shear_stiffness);
    inherit(1, &rod.axial_stiffness, &whole->axial_stiffness);
    inherit(2, rod.bending_stiffness, whole->bending_stiffness);
    inherit(1, &rod.torsional_stiffness, &whole->torsional_stiffness);
    inherit(1, &rod.mass_per_length, &whole->mass_per_length);
    inherit(3, rod.rotary_inertia, whole->rotary_inertia);
    inherit(3, rod.rest_strain, whole->rest_strain);
    inherit(3, rod.rest_curvature, whole->rest_curvature);
    inherit(3, rod.imperfection, whole->imperfection);
    inherit_damping(&rod, whole);
    return rod;
}

scene_piece scene_piece_of(const scene *rod_scene, int index)
{
    bool last = index == scene_pieces(rod_scene) - 1;
    scene_piece piece = {.from = scene_joint(rod_scene, index - 1),
                         .to = last ? scene_length(rod_scene) : scene_joint(rod_scene, index),
                         .rod = rod_of(rod_scene, index)};
    for (int i = 0; i < 3 && index > 0; i++) {
        piece.turn[i] = rod_scene->segments[index].turn[i].number;
    }
    return piece;
}

/* ---- tubes ----------------------------------------------------------------------------------- */

scene_properties scene_tube_properties(const scene_tube *tube)
{
    scene_rod rod = tube->rod;
    rod.model = SCENE_KIRCHHOFF;
    rod.section = rod.radius.is_given ? SCENE_TUBE : SCENE_SECTION_NONE;
    return scene_rod_properties(&rod);
}

double scene_tube_end(const scene *rod_scene, int index)
{
    double length = scene_length(rod_scene);
    return fmin(length, quantity_or(rod_scene->tubes[index].end, quantity_number(length)).number);
}

/* ---- the whole rod --------------------------------------------------------------------------- */

static bool is_same(quantity a, quantity b)
{
    return a.is_given == b.is_given && a.node == b.node && (a.node || a.number == b.number);
}

/* The quantity at `offset` of every piece [pieces][stride bytes]: the same all along, or by
 * where(s - joint, behind, before), at a joint what it is before. */
static quantity join(const scene *rod_scene, const char *pieces, size_t stride, size_t offset)
{
    int last = rod_scene->segment_count - 1;
    const char *at = pieces + (size_t)last * stride + offset;
    quantity behind = *(const quantity *)(const void *)at, joined = behind;
    for (int i = last - 1; i >= 0; i--) {
        at -= stride;
        quantity before = *(const quantity *)(const void *)at;
        if (!is_same(before, behind)) {
            quantity s = quantity_formula(rod_scene->names, "s");
            quantity past = quantity_subtract(s, quantity_number(scene_joint(rod_scene, i)));
            joined = quantity_call("where", (quantity[]){past, joined, before});
        }
        behind = before;
    }
    return joined;
}

/* Both are nothing but quantities. */
_Static_assert(sizeof(scene_properties) % sizeof(quantity) == 0, "quantities alone");
_Static_assert(sizeof(scene_rest) % sizeof(quantity) == 0, "quantities alone");

static void join_all(const scene *rod_scene, const void *pieces, size_t size, void *joined)
{
    for (size_t offset = 0; offset < size; offset += sizeof(quantity)) {
        *(quantity *)(void *)((char *)joined + offset) = join(rod_scene, pieces, size, offset);
    }
}

scene_properties scene_properties_of(const scene *rod_scene)
{
    scene_properties pieces[SCENE_SEGMENTS_MAX], joined;
    if (rod_scene->segment_count == 0) {
        return scene_rod_properties(&rod_scene->rod);
    }
    for (int i = 0; i < rod_scene->segment_count; i++) {
        scene_rod rod = rod_of(rod_scene, i);
        pieces[i] = scene_rod_properties(&rod);
    }
    join_all(rod_scene, pieces, sizeof joined, &joined);
    return joined;
}

scene_rest scene_rod_rest(const scene_rod *rod)
{
    scene_rest rest;
    for (int i = 0; i < 3; i++) {
        rest.strain[i] = quantity_or(rod->rest_strain[i], quantity_number(i == 2));
        rest.curvature[i] = quantity_or(rod->rest_curvature[i], quantity_number(0));
        rest.imperfection[i] = quantity_or(rod->imperfection[i], quantity_number(0));
        rest.strain[i] = scene_grown(rest.strain[i], rod->growth, 1);
        rest.curvature[i] = scene_grown(rest.curvature[i], rod->growth, 1);
        rest.imperfection[i] = scene_grown(rest.imperfection[i], rod->growth, 1);
    }
    return rest;
}

bool scene_measures_from_rest(const scene *rod_scene)
{
    bool measures = quantity_any_something(3, rod_scene->loads.foundation);
    for (int i = 0; i < rod_scene->spring_count; i++) {
        const scene_spring *spring = &rod_scene->springs[i];
        measures = measures || quantity_any_something(3, spring->turning) ||
                   !quantity_any_given(3, spring->anchor);
    }
    return measures;
}

bool scene_rests_straight(const scene *rod_scene)
{
    bool straight = true;
    for (int i = 0; i < scene_pieces(rod_scene) && straight; i++) {
        const scene_piece piece = scene_piece_of(rod_scene, i);
        const scene_rod *rod = &piece.rod;
        straight = !quantity_any_something(3, rod->rest_curvature) &&
                   !quantity_any_something(3, rod->imperfection);
        for (int k = 0; k < 3; k++) {
            straight = straight && piece.turn[k] == 0 &&
                       (!rod->rest_strain[k].is_given || quantity_is(rod->rest_strain[k], k == 2));
        }
    }
    return straight;
}

bool scene_has_branch(const scene *rod_scene)
{
    bool any = false;
    for (int i = 0; i < scene_pieces(rod_scene); i++) {
        any |= scene_piece_of(rod_scene, i).rod.maxwell_ratio.is_given;
    }
    return any;
}

scene_rest scene_rest_of(const scene *rod_scene)
{
    scene_rest pieces[SCENE_SEGMENTS_MAX], joined;
    if (rod_scene->segment_count == 0) {
        return scene_rod_rest(&rod_scene->rod);
    }
    for (int i = 0; i < rod_scene->segment_count; i++) {
        scene_rod rod = rod_of(rod_scene, i);
        pieces[i] = scene_rod_rest(&rod);
    }
    join_all(rod_scene, pieces, sizeof joined, &joined);
    return joined;
}
