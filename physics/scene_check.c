/* What a scene has to satisfy before physics is recorded from it. Every refusal names the YAML key
 * to blame and says what is allowed. */
#include "physics/scene_internal.h"

#include <math.h>

ad_status scene_refuse(const scene_checker *check, const char *key, const char *sentence)
{
    if (check->key) {
        *check->key = key;
    }
    return ad_fail(check->error, AD_BAD_INPUT, "%s", sentence);
}

static bool is_dynamic(const scene_checker *check)
{
    return scene_is_dynamic(check->scene);
}

/* ---- formulas ------------------------------------------------------------------------------ */

ad_status scene_check_group(const scene_checker *check, const scene_group *group)
{
    if (!quantity_any_given(group->count, group->entries)) {
        return AD_OK;
    }
    for (int i = 0; i < group->count; i++) {
        quantity entry = group->entries[i];
        if (!entry.is_given) {
            return scene_refuse(check, group->key, "some entries are missing; give all or none");
        }
        ad_status status = quantity_check(entry, check->error);
        if (status != AD_OK) {
            *check->key = group->key;
            return status;
        }
        if (quantity_depends_on(entry, "s") && !group->s_allowed) {
            return scene_refuse(check, group->key, group->s_sentence);
        }
        if (quantity_depends_on(entry, "t") && !group->t_allowed) {
            return scene_refuse(check, group->key, group->t_sentence);
        }
        if (quantity_depends_on(entry, "t") && !is_dynamic(check)) {
            return scene_refuse(check, group->key,
                                "depends on t, but the scene is static; give time.duration, or a "
                                "formula without t");
        }
    }
    return AD_OK;
}

static ad_status check_groups(const scene_checker *check, int count, const scene_group *groups)
{
    ad_status status = AD_OK;
    for (int i = 0; i < count && status == AD_OK; i++) {
        status = scene_check_group(check, &groups[i]);
    }
    return status;
}

#define AT_END           "depends on s, but it belongs to one end; allowed: a formula of t"
#define AT_START_OF_TIME "depends on t, but it holds at t = 0; allowed: a formula of s"
#define IN_SPACE         "depends on s, but it is the same all along; allowed: a formula of t"
#define ALONG            "depends on t, but it may not change with time; allowed: a formula of s"
#define ONE_NUMBER       "depends on s or t; allowed: one number"

/* What is looked at before any other number: everything is sampled over the length and duration. */
static ad_status check_extent(const scene_checker *check)
{
    const scene *given = check->scene;
    const scene_group groups[] = {
        {"rod.length", 1, &given->rod.length, false, false, ONE_NUMBER, ONE_NUMBER},
        {"time.duration", 1, &given->duration, false, false, ONE_NUMBER, ONE_NUMBER},
    };
    double length = 0, duration = 0;
    ad_status status = check_groups(check, 2, groups);
    if (status != AD_OK) {
        return status;
    }
    if (!given->rod.length.is_given) {
        return scene_refuse(check, "rod.length", "missing; the length of the undeformed rod in m");
    }
    if (!quantity_is_number(given->rod.length, &length) || !(length > 0 && isfinite(length))) {
        return scene_refuse(check, "rod.length", "must be a finite number > 0");
    }
    quantity_is_number(given->duration, &duration);
    return duration >= 0 && isfinite(duration)
               ? AD_OK
               : scene_refuse(check, "time.duration",
                              "must be finite and >= 0; 0 is a static scene");
}

/* Section, material and what follows from them: of s. */
static ad_status check_numbers(const scene_checker *check)
{
    const scene *given = check->scene;
    const scene_rod *rod = &given->rod;
    const scene_group groups[] = {
        {"rod.section.radius", 1, &rod->radius, true, false, NULL, ALONG},
        {"rod.section.inner_radius", 1, &rod->inner_radius, true, false, NULL, ALONG},
        {"rod.section.width", 1, &rod->width, true, false, NULL, ALONG},
        {"rod.section.height", 1, &rod->height, true, false, NULL, ALONG},
        {"rod.material.youngs_modulus", 1, &rod->youngs_modulus, true, false, NULL, ALONG},
        {"rod.material.poissons_ratio", 1, &rod->poissons_ratio, true, false, NULL, ALONG},
        {"rod.material.density", 1, &rod->density, true, false, NULL, ALONG},
        {"rod.material.shear_correction", 1, &rod->shear_correction, true, false, NULL, ALONG},
        {"rod.material.viscosity", 1, &rod->viscosity, true, false, NULL, ALONG},
        {"rod.material.relaxation_time", 1, &rod->relaxation_time, true, false, NULL, ALONG},
        {"rod.stiffness.shear", 2, rod->shear_stiffness, true, false, NULL, ALONG},
        {"rod.stiffness.axial", 1, &rod->axial_stiffness, true, false, NULL, ALONG},
        {"rod.stiffness.bending", 2, rod->bending_stiffness, true, false, NULL, ALONG},
        {"rod.stiffness.torsion", 1, &rod->torsional_stiffness, true, false, NULL, ALONG},
        {"rod.inertia.mass_per_length", 1, &rod->mass_per_length, true, false, NULL, ALONG},
        {"rod.inertia.rotary", 3, rod->rotary_inertia, true, false, NULL, ALONG},
        {"rod.damping.strain", 3, rod->strain_damping, true, false, NULL, ALONG},
        {"rod.damping.curvature", 3, rod->curvature_damping, true, false, NULL, ALONG},
        {"loads.gravity", 3, given->loads.gravity, false, true, IN_SPACE, NULL},
        {"loads.drag", 1, &given->loads.drag, true, false, NULL, ALONG},
    };
    return check_groups(check, (int)(sizeof groups / sizeof *groups), groups);
}

static ad_status check_formulas(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    const scene_loads *loads = &rod_scene->loads;
    const scene_initial *initial = &rod_scene->initial;
    const scene_manufactured *exact = &rod_scene->manufactured;
    const scene_group groups[] = {
        {"rod.rest.strain", 3, rod_scene->rod.rest_strain, true, true, NULL, NULL},
        {"rod.rest.curvature", 3, rod_scene->rod.rest_curvature, true, true, NULL, NULL},
        {"rod.rest.imperfection", 3, rod_scene->rod.imperfection, true, false, NULL, ALONG},
        {"loads.force", 3, loads->force, true, true, NULL, NULL},
        {"loads.moment", 3, loads->moment, true, true, NULL, NULL},
        {"loads.base.force", 3, loads->base.force, false, true, AT_END, NULL},
        {"loads.base.moment", 3, loads->base.moment, false, true, AT_END, NULL},
        {"loads.tip.force", 3, loads->tip.force, false, true, AT_END, NULL},
        {"loads.tip.moment", 3, loads->tip.moment, false, true, AT_END, NULL},
        {"initial.position", 3, initial->position, true, false, NULL, AT_START_OF_TIME},
        {"initial.rotation", 4, initial->rotation, true, false, NULL, AT_START_OF_TIME},
        {"initial.velocity", 3, initial->velocity, true, false, NULL, AT_START_OF_TIME},
        {"initial.angular_velocity", 3, initial->angular_velocity, true, false, NULL,
         AT_START_OF_TIME},
        {"manufactured.position", 3, exact->position, true, true, NULL, NULL},
        {"manufactured.rotation", 4, exact->rotation, true, true, NULL, NULL},
        {"manufactured.angles", 3, exact->angles, true, true, NULL, NULL},
    };
    return check_groups(check, (int)(sizeof groups / sizeof *groups), groups);
}

/* ---- loads and ends ------------------------------------------------------------------------ */

ad_status scene_check_drag(const scene_checker *check)
{
    scene_range drag = scene_range_of(check->scene, check->scene->loads.drag);
    return drag.low >= 0 && isfinite(drag.high)
               ? AD_OK
               : scene_refuse(check, "loads.drag", "must be finite and >= 0");
}

static ad_status check_frames(const scene_checker *check)
{
    const scene_loads *loads = &check->scene->loads;
    const struct {
        const char *key;
        scene_frame frame;
        const quantity *force;
        const quantity *moment;
    } rows[] = {
        {"loads.frame", loads->frame, loads->force, loads->moment},
        {"loads.base.frame", loads->base.frame, loads->base.force, loads->base.moment},
        {"loads.tip.frame", loads->tip.frame, loads->tip.force, loads->tip.moment},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].frame == SCENE_FOLLOWER && !quantity_any_given(3, rows[i].force) &&
            !quantity_any_given(3, rows[i].moment)) {
            return scene_refuse(
                check, rows[i].key,
                "follower, but there is no force or moment to follow; give one, or leave "
                "frame out");
        }
    }
    for (int i = 0; i < 3; i++) {
        scene_range gravity = scene_range_of(check->scene, loads->gravity[i]);
        if (!isfinite(gravity.low) || !isfinite(gravity.high)) {
            return scene_refuse(check, "loads.gravity", "must be finite");
        }
    }
    return scene_check_drag(check);
}

/* One end with the keys that speak of it. */
typedef struct end_keys {
    const scene_end *end;
    const scene_load *load;
    const char *type;
    const char *position;
    const char *rotation;
    const char *force;
    const char *moment;
} end_keys;

static ad_status check_end_load(const scene_checker *check, const end_keys *keys)
{
    scene_end_type type = keys->end->type;
    bool force = quantity_any_given(3, keys->load->force);
    bool moment = quantity_any_given(3, keys->load->moment);
    const char *held = "acts on an end that is held against it; allowed: an end of type loaded";
    const char *free_end = "acts on an end declared free; allowed: an end of type loaded";
    if (type == SCENE_LOADED) {
        return force || moment || scene_is_manufactured(check->scene)
                   ? AD_OK
                   : scene_refuse(check, keys->type,
                                  "loaded, but no load is given there; say free");
    }
    if (force || moment) {
        return scene_refuse(check, force ? keys->force : keys->moment,
                            type == SCENE_FREE ? free_end : held);
    }
    return AD_OK;
}

static ad_status check_rotation_number(const scene_checker *check, const end_keys *keys)
{
    double square = 0;
    for (int i = 0; i < 4; i++) {
        double value = 0;
        if (!quantity_is_number(keys->end->rotation[i], &value)) {
            return AD_OK;
        }
        square += value * value;
    }
    return square > 0
               ? AD_OK
               : scene_refuse(check, keys->rotation,
                              "is zero; allowed: a quaternion (w, x, y, z) that is not zero");
}

static ad_status check_end(const scene_checker *check, const end_keys *keys)
{
    const scene_end *end = keys->end;
    bool driven = end->type == SCENE_DRIVEN;
    const char *fixed = "depends on t, but the end stands still; allowed: numbers, or an end of "
                        "type driven";
    const scene_group groups[] = {
        {keys->position, 3, end->position, false, driven, AT_END, fixed},
        {keys->rotation, 4, end->rotation, false, driven, AT_END, fixed},
    };
    ad_status status = check_groups(check, 2, groups);
    if (status != AD_OK) {
        return status;
    }
    if (!scene_is_manufactured(check->scene)) {
        if (scene_end_holds_position(end->type) && !end->position[0].is_given) {
            return scene_refuse(check, keys->position, "missing; the type of this end needs it");
        }
        if (scene_end_holds_rotation(end->type) && !end->rotation[0].is_given) {
            return scene_refuse(check, keys->rotation, "missing; the type of this end needs it");
        }
        status = scene_end_holds_rotation(end->type) ? check_rotation_number(check, keys) : AD_OK;
    }
    return status != AD_OK ? status : check_end_load(check, keys);
}

/* end - start at time t. */
static void chord_at(const scene *rod_scene, double t, double chord[3])
{
    for (int i = 0; i < 3; i++) {
        chord[i] = quantity_value(rod_scene->end.position[i], 0, t) -
                   quantity_value(rod_scene->start.position[i], 0, t);
    }
}

static double norm(const double a[3])
{
    return hypot(hypot(a[0], a[1]), a[2]);
}

/* Whether a dead load acts that is not along the line through two pinned ends, so that turning the
 * rod about this line is resisted. */
static bool resists_spin(const scene *rod_scene)
{
    const scene_loads *loads = &rod_scene->loads;
    double g[3], chord[3], moment[3];
    bool dead = loads->frame == SCENE_DEAD;
    if (scene_is_manufactured(rod_scene)) {
        return false;
    }
    chord_at(rod_scene, 0, chord);
    for (int i = 0; i < 3; i++) {
        g[i] = quantity_value(loads->gravity[i], 0, 0);
    }
    for (int i = 0; i < 3; i++) {
        moment[i] = g[(i + 1) % 3] * chord[(i + 2) % 3] - g[(i + 2) % 3] * chord[(i + 1) % 3];
    }
    return norm(moment) > 1e-9 * norm(g) * norm(chord) ||
           (dead &&
            (quantity_any_something(3, loads->force) || quantity_any_something(3, loads->moment)));
}

/* Static equilibrium has to be unique up to buckling: no rigid motion may be left free. The spin of
 * a round rod about its own axis is free with two pinned ends, but moves nothing. */
static ad_status check_rigid_motion(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    if (is_dynamic(check) || scene_end_holds_rotation(rod_scene->start.type) ||
        scene_end_holds_rotation(rod_scene->end.type)) {
        return AD_OK;
    }
    if (!scene_end_holds_position(rod_scene->start.type) &&
        !scene_end_holds_position(rod_scene->end.type)) {
        return scene_refuse(
            check, "boundary",
            "nothing holds the rod, so a static scene leaves its position and rotation "
            "open; clamp one end");
    }
    if (!scene_end_holds_position(rod_scene->start.type) ||
        !scene_end_holds_position(rod_scene->end.type)) {
        return scene_refuse(
            check, "boundary",
            "one pinned end leaves the rotation of a static rod open; clamp one end");
    }
    if (!resists_spin(rod_scene)) {
        return scene_refuse(
            check, "boundary",
            "two pinned ends leave this static rod free to spin about the line between them; give "
            "gravity or a dead distributed load across it, or clamp one end");
    }
    return AD_OK;
}

/* Length of a rod whose strains are all locked at v*(s), by the midpoint rule. */
static double locked_length(const scene *rod_scene)
{
    enum { PIECES = 1000 };
    double length = scene_length(rod_scene), sum = 0;
    for (int k = 0; k < PIECES; k++) {
        double strain[3];
        for (int i = 0; i < 3; i++) {
            quantity given = quantity_or(rod_scene->rod.rest_strain[i], quantity_number(i == 2));
            strain[i] = quantity_value(given, (k + 0.5) / PIECES * length, 0);
        }
        sum += norm(strain) / PIECES;
    }
    return length * sum;
}

/* A rod that neither shears nor stretches does not reach farther than its length. (Without stretch
 * alone it may: a sheared rod is longer.) */
static ad_status check_reach(const scene_checker *check)
{
    enum { INSTANTS = 64 };
    const scene *rod_scene = check->scene;
    scene_properties properties = scene_properties_of(rod_scene);
    for (int i = 0; i < 3; i++) {
        if (!scene_locks(properties.strain_stiffness[i])) {
            return AD_OK;
        }
    }
    if (scene_is_manufactured(rod_scene) || !scene_end_holds_position(rod_scene->start.type) ||
        !scene_end_holds_position(rod_scene->end.type)) {
        return AD_OK;
    }
    double length = locked_length(rod_scene);
    for (int k = 0; k <= (is_dynamic(check) ? INSTANTS : 0); k++) {
        double chord[3];
        chord_at(rod_scene, scene_duration(rod_scene) * k / INSTANTS, chord);
        if (norm(chord) > (1 + 1e-6) * length) { /* of the midpoint rule */
            return scene_refuse(check, "boundary.end.position",
                                "the held ends are farther apart than the rod is long, and "
                                "rod.model or an infinite stiffness locks its stretch and shear");
        }
    }
    return AD_OK;
}

static ad_status check_ends(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    const end_keys ends[2] = {
        {&rod_scene->start, &rod_scene->loads.base, "boundary.start.type",
         "boundary.start.position", "boundary.start.rotation", "loads.base.force",
         "loads.base.moment"},
        {&rod_scene->end, &rod_scene->loads.tip, "boundary.end.type", "boundary.end.position",
         "boundary.end.rotation", "loads.tip.force", "loads.tip.moment"},
    };
    ad_status status = check_end(check, &ends[0]);
    if (status == AD_OK) {
        status = check_end(check, &ends[1]);
    }
    if (status == AD_OK) {
        status = check_rigid_motion(check);
    }
    return status == AD_OK ? check_reach(check) : status;
}

/* ---- time and the manufactured solution ---------------------------------------------------- */

static ad_status check_initial(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    const scene_initial *initial = &rod_scene->initial;
    bool position = quantity_any_given(3, initial->position);
    bool rotation = quantity_any_given(4, initial->rotation);
    bool velocity = quantity_any_given(3, initial->velocity);
    if (!is_dynamic(check) &&
        (position || rotation || velocity || quantity_any_given(3, initial->angular_velocity))) {
        return scene_refuse(
            check, "initial",
            "a static scene has no initial state; give time.duration, or leave it out");
    }
    if (position != rotation) {
        return scene_refuse(check, position ? "initial.rotation" : "initial.position",
                            "missing; position and rotation at t = 0 come together or not at all");
    }
    if (!is_dynamic(check) || position || scene_is_manufactured(rod_scene)) {
        return AD_OK;
    }
    if (!scene_end_holds_rotation(rod_scene->start.type) &&
        !scene_end_holds_rotation(rod_scene->end.type)) {
        return scene_refuse(
            check, "initial.position",
            "missing; without a clamped or driven end the pose at t = 0 is unknown");
    }
    return AD_OK;
}

static ad_status check_time(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    if (rod_scene->windows < 1 || rod_scene->windows > SCENE_WINDOWS_MAX) {
        return scene_refuse(check, "time.windows", "must be 1 to 1024");
    }
    if (rod_scene->windows > 1 && !is_dynamic(check)) {
        return scene_refuse(check, "time.windows",
                            "windows divide the duration, but the scene is static; give "
                            "time.duration, or leave it out");
    }
    if (rod_scene->windows > 1 && rod_scene->initial_enforcement == SCENE_SOFT) {
        return scene_refuse(check, "time.windows",
                            "every window starts exactly where the one before ends, but the "
                            "initial state is soft; take enforcement.initial hard, or 1 window");
    }
    return AD_OK;
}

static ad_status check_imperfection(const scene_checker *check)
{
    bool fixed = scene_is_dynamic(check->scene) || scene_is_manufactured(check->scene);
    return fixed && scene_is_imperfect(check->scene)
               ? scene_refuse(check, "rod.rest.imperfection",
                              "goes as the loads of a static scene grow, but this one moves or is "
                              "manufactured; leave it out, or give rod.rest.curvature")
               : AD_OK;
}

static ad_status check_manufactured(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    const scene_manufactured *exact = &rod_scene->manufactured;
    const scene_loads *loads = &rod_scene->loads;
    const scene_initial *initial = &rod_scene->initial;
    bool rotation = quantity_any_given(4, exact->rotation);
    bool angles = quantity_any_given(3, exact->angles);
    const char *derived = "follows from the manufactured solution; leave it out";
    const struct {
        const char *key;
        bool is_given;
    } rows[] = {
        {"loads.force", quantity_any_given(3, loads->force)},
        {"loads.moment", quantity_any_given(3, loads->moment)},
        {"loads.base",
         quantity_any_given(3, loads->base.force) || quantity_any_given(3, loads->base.moment)},
        {"loads.tip",
         quantity_any_given(3, loads->tip.force) || quantity_any_given(3, loads->tip.moment)},
        {"initial", quantity_any_given(3, initial->position) ||
                        quantity_any_given(4, initial->rotation) ||
                        quantity_any_given(3, initial->velocity) ||
                        quantity_any_given(3, initial->angular_velocity)},
        {"boundary.end", quantity_any_given(3, rod_scene->end.position) ||
                             quantity_any_given(4, rod_scene->end.rotation)},
    };
    if (!scene_is_manufactured(rod_scene)) {
        return rotation || angles
                   ? scene_refuse(check, "manufactured.position",
                                  "missing; a manufactured solution needs the position")
                   : AD_OK;
    }
    if (rotation == angles) {
        return scene_refuse(check, rotation ? "manufactured.angles" : "manufactured.rotation",
                            rotation ? "given beside rotation; allowed: one of the two"
                                     : "missing; give rotation or angles");
    }
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].is_given) {
            return scene_refuse(check, rows[i].key, derived);
        }
    }
    return AD_OK;
}

typedef ad_status scene_part(const scene_checker *check);

ad_status scene_check(const scene *rod_scene, const char **key, ad_error *error)
{
    static scene_part *const of_rods[] = {
        check_extent,   check_numbers,      scene_check_rod,    scene_check_no_beam,
        check_formulas, check_manufactured, check_frames,       check_ends,
        check_initial,  check_time,         check_imperfection, NULL};
    static scene_part *const of_beams[] = {check_extent,     check_numbers, scene_check_rod,
                                           scene_check_beam, check_time,    NULL};
    const char *ignored = NULL;
    const scene_checker check = {rod_scene, key ? key : &ignored, error};
    ad_status status = AD_OK;
    for (scene_part *const *part = scene_is_beam(rod_scene) ? of_beams : of_rods;
         *part && status == AD_OK; part++) {
        status = (*part)(&check);
    }
    return status;
}
