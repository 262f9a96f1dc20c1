/* What ends hold, how they slide and what acts on them; whether a rod at rest is held at all. */
#include "physics/rod/rod.h"
#include "physics/scene/scene_internal.h"

#include <math.h>
#include <string.h>

/* One end with the keys that speak of it. */
typedef struct end_keys {
    const scene_end *end;
    const scene_load *load;
    const char *type;
    const char *position;
    const char *rotation;
    const char *rotation_vector; /* NULL: it has none */
    const char *force;
    const char *moment;
    const char *along;
    const char *across;
} end_keys;

static ad_status check_end_load(const scene_checker *check, const end_keys *keys)
{
    scene_end_type type = keys->end->type;
    bool force = quantity_any_given(3, keys->load->force);
    bool moment = quantity_any_given(3, keys->load->moment);
    const char *held = "acts on an end that is held against it; allowed: an end of type loaded";
    const char *guided = "acts on an end that does not turn; allowed: a force, or an end of type "
                         "loaded or roller";
    const char *free_end = "acts on an end declared free; allowed: an end of type loaded";
    if (type == SCENE_LOADED) {
        return force || moment || scene_is_manufactured(check->scene)
                   ? AD_OK
                   : scene_refuse(check, keys->type,
                                  "loaded, but no load is given there; say free");
    }
    if (scene_end_slides(type)) {
        return moment && type == SCENE_GUIDED ? scene_refuse(check, keys->moment, guided) : AD_OK;
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

/* By the quaternion, or by the vector from where the unstressed rod ends, which the other end has
 * to place then. */
static ad_status check_rotation(const scene_checker *check, const end_keys *keys)
{
    const scene_end *end = keys->end;
    bool vector = quantity_any_given(3, end->rotation_vector);
    if (vector && !keys->rotation_vector) {
        return scene_refuse(check, keys->rotation,
                            "missing; a rotation vector is for the end s = length");
    }
    if (vector && end->rotation[0].is_given) {
        return scene_refuse(check, keys->rotation_vector,
                            "given beside rotation; allowed: one of the two");
    }
    if (vector && !scene_end_holds_rotation(check->scene->start.type)) {
        return scene_refuse(check, keys->rotation_vector,
                            "turns the end from where the unstressed rod ends, but the end s = 0 "
                            "is not held; clamp it, or give rotation");
    }
    if (!vector && !end->rotation[0].is_given) {
        return scene_refuse(check, keys->rotation, "missing; the type of this end needs it");
    }
    return vector ? AD_OK : check_rotation_number(check, keys);
}

/* How the position of an end slides. */
static ad_status check_slide(const scene_checker *check, const end_keys *keys)
{
    const scene_end *end = keys->end;
    bool along = end->along[0].is_given, across = end->across[0].is_given;
    const quantity *given = along ? end->along : end->across;
    const char *key = along ? keys->along : keys->across;
    if (!scene_end_slides(end->type)) {
        return along || across ? scene_refuse(check, key,
                                              "says how an end slides, and this one does not; "
                                              "allowed for it: an end of type guided or roller")
                               : AD_OK;
    }
    if (along && across) {
        return scene_refuse(check, keys->across,
                            "given beside along, and an end slides in one way; allowed: one of "
                            "the two");
    }
    if (!along && !across) {
        return end->type == SCENE_ROLLER
                   ? scene_refuse(check, keys->along,
                                  "missing; a roller slides along a direction, or across one; say "
                                  "pinned for none, free for all")
                   : AD_OK;
    }
    return quantity_any_something(3, given)
               ? AD_OK
               : scene_refuse(check, key, "is zero; allowed: a direction that is not zero");
}

static ad_status check_end(const scene_checker *check, const end_keys *keys)
{
    const scene_end *end = keys->end;
    ad_status status = check_slide(check, keys);
    if (status == AD_OK && !scene_is_manufactured(check->scene)) {
        if (scene_end_is_placed(end->type) && !end->position[0].is_given) {
            return scene_refuse(check, keys->position, "missing; the type of this end needs it");
        }
        status = scene_end_holds_rotation(end->type) ? check_rotation(check, keys) : AD_OK;
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
    for (int i = 0; i < rod_scene->point_count; i++) {
        const scene_load *load = &rod_scene->points[i].load;
        if (load->frame == SCENE_DEAD &&
            (quantity_any_something(3, load->force) || quantity_any_something(3, load->moment))) {
            return true;
        }
    }
    return norm(moment) > 1e-9 * norm(g) * norm(chord) ||
           (dead &&
            (quantity_any_something(3, loads->force) || quantity_any_something(3, loads->moment)));
}

/* Whether the rod is straight and round, stays in a plane, and nothing tells one of its sides from
 * another, so that its spin moves nothing. */
static bool spins_in_place(const scene *given)
{
    const scene_properties properties = scene_properties_of(given);
    const scene_rest rest = scene_rest_of(given);
    const scene_loads *loads = &given->loads;
    double bending[2] = {0};
    bool round = true, follows = loads->frame == SCENE_FOLLOWER ||
                                 loads->base.frame == SCENE_FOLLOWER ||
                                 loads->tip.frame == SCENE_FOLLOWER;
    bool turned = quantity_any_given(3, loads->base.moment) ||
                  quantity_any_given(3, loads->tip.moment) || quantity_any_given(3, loads->moment);
    int sided = given->point_count + given->spring_count + scene_actuator_count(given);
    for (int i = 0; i < 2; i++) {
        round = round && quantity_is_number(properties.curvature_stiffness[i], &bending[i]);
    }
    return round && bending[0] == bending[1] && !follows && !turned && sided == 0 &&
           !quantity_any_something(2, rest.strain) && !quantity_any_something(3, rest.curvature) &&
           rod_plane_of(given).is_planar;
}

/* Motions of the whole rod, t + w x r with r by its length, against which something holds it. */
typedef struct held {
    double gram[6][6]; /* of t and w: sum of squares of what is held */
    int places;        /* of ends and springs: none, one, or several that are apart */
    double first[3];   /* of them */
    bool rotation;
} held;

static void hold_row(held *holds, const double row[6])
{
    for (int i = 0; i < 6; i++) {
        for (int j = 0; j < 6; j++) {
            holds->gram[i][j] += row[i] * row[j];
        }
    }
}

/* w . axis */
static void hold_turn(held *holds, const double axis[3])
{
    hold_row(holds, (double[6]){0, 0, 0, axis[0], axis[1], axis[2]});
}

/* The displacement at r, in some directions. */
static void hold_place(held *holds, const scene_hold *hold, const double r[3])
{
    for (int i = 0; i < 3 && hold->directions > 0; i++) {
        double e[3], unit[3] = {i == 0, i == 1, i == 2};
        scene_hold_part(hold, unit, e);
        hold_row(holds, (double[6]){e[0], e[1], e[2], r[1] * e[2] - r[2] * e[1],
                                    r[2] * e[0] - r[0] * e[2], r[0] * e[1] - r[1] * e[0]});
    }
    double off[3] = {r[0] - holds->first[0], r[1] - holds->first[1], r[2] - holds->first[2]};
    if (hold->directions > 0 && holds->places == 0) {
        memcpy(holds->first, r, sizeof holds->first);
        holds->places = 1;
    } else if (hold->directions > 0 && norm(off) > PLACE_ROUNDING) {
        holds->places = 2;
    }
}

static void hold_rotation(held *holds)
{
    for (int i = 0; i < 3; i++) {
        hold_turn(holds, (double[3]){i == 0, i == 1, i == 2});
    }
    holds->rotation = true;
}

/* Whether no motion is left: the pivots of the matrix, the largest first. */
static bool is_held(const held *holds)
{
    double a[6][6];
    bool done[6] = {false};
    memcpy(a, holds->gram, sizeof a);
    for (int step = 0; step < 6; step++) {
        int p = -1;
        for (int i = 0; i < 6; i++) {
            p = !done[i] && (p < 0 || a[i][i] > a[p][p]) ? i : p;
        }
        if (!(a[p][p] > 1e-12)) {
            return false;
        }
        done[p] = true;
        for (int i = 0; i < 6; i++) {
            double factor = a[i][p] / a[p][p];
            for (int j = 0; j < 6 && !done[i]; j++) {
                a[i][j] -= done[j] ? 0 : factor * a[p][j];
            }
        }
    }
    return true;
}

static bool all_positive(const quantity k[3])
{
    return quantity_is_something(k[0]) && quantity_is_something(k[1]) &&
           quantity_is_something(k[2]);
}

/* Where s is on a straight rod, from its beginning: on the line between its ends, or upright. */
static void place_of(const scene *given, double s, double r[3])
{
    double length = scene_length(given);
    chord_at(given, 0, r);
    bool placed = given->start.position[0].is_given && given->end.position[0].is_given &&
                  norm(r) > 1e-9 * length;
    for (int i = 0; i < 3; i++) {
        r[i] = (placed ? r[i] / length : i == 2) * s / length;
    }
}

static held held_of(const scene *given)
{
    const scene_end *ends[2] = {&given->start, &given->end};
    const scene_hold all = {.directions = 3};
    held holds = {.places = 0};
    double r[3];
    for (int i = 0; i < 2; i++) {
        const scene_hold hold = scene_hold_of(ends[i]);
        place_of(given, i * scene_length(given), r);
        hold_place(&holds, &hold, r);
        if (scene_end_holds_rotation(ends[i]->type)) {
            hold_rotation(&holds);
        }
    }
    for (int i = 0; i < given->spring_count; i++) {
        const scene_spring *spring = &given->springs[i];
        place_of(given, spring->at.number, r);
        if (all_positive(spring->stiffness)) {
            hold_place(&holds, &all, r);
        }
        if (all_positive(spring->turning)) {
            hold_rotation(&holds);
        }
    }
    for (int i = 0; i < 2 * 3; i++) { /* a foundation as if at both ends */
        const quantity k = given->loads.foundation[i / 2];
        scene_hold one = {1, {i / 2 == 0, i / 2 == 1, i / 2 == 2}};
        place_of(given, i % 2 * scene_length(given), r);
        if (k.is_given && scene_range_of(given, k).high > 0) {
            hold_place(&holds, &one, r);
        }
    }
    return holds;
}

/* Static equilibrium has to be unique up to buckling: no rigid motion may be left free. The spin of
 * a round rod about its own axis is free with two pinned ends, but moves nothing. */
static ad_status check_rigid_motion(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    held holds = held_of(rod_scene), spun = holds;
    double chord[3];
    if (scene_is_dynamic(check->scene) || is_held(&holds)) {
        return AD_OK;
    }
    place_of(rod_scene, scene_length(rod_scene), chord);
    hold_turn(&spun, chord);
    if (holds.places == 0) {
        return scene_refuse(
            check, "boundary",
            "nothing holds the rod, so a static scene leaves its position and rotation "
            "open; clamp one end");
    }
    if (holds.places == 1 && !holds.rotation) {
        return scene_refuse(
            check, "boundary",
            rod_scene->spring_count > 0
                ? "one place that is held leaves the rotation of a static rod open; clamp one end, "
                  "or give springs.turning"
                : "one pinned end leaves the rotation of a static rod open; clamp one end");
    }
    if (!is_held(&spun)) {
        return scene_refuse(check, "boundary",
                            "the ends leave this static rod free to move as a whole: all that "
                            "slides can do so at once; hold one of them in this direction");
    }
    if (!resists_spin(rod_scene) && !spins_in_place(rod_scene)) {
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
    enum { POINTS = 1000 };
    double sum = 0;
    for (int index = 0; index < scene_pieces(rod_scene); index++) {
        scene_piece piece = scene_piece_of(rod_scene, index);
        scene_rest rest = scene_rod_rest(&piece.rod);
        double length = piece.to - piece.from, mean = 0;
        for (int k = 0; k < POINTS; k++) {
            double strain[3];
            for (int i = 0; i < 3; i++) {
                strain[i] =
                    quantity_value(rest.strain[i], piece.from + (k + 0.5) / POINTS * length, 0);
            }
            mean += norm(strain) / POINTS;
        }
        sum += length * mean;
    }
    return sum;
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
    const scene_hold start = scene_hold_of(&rod_scene->start), end = scene_hold_of(&rod_scene->end);
    if (scene_is_manufactured(rod_scene) || (start.directions < 3 && end.directions < 3)) {
        return AD_OK;
    }
    double length = locked_length(rod_scene);
    for (int k = 0; k <= (scene_is_dynamic(check->scene) ? INSTANTS : 0); k++) {
        double chord[3];
        chord_at(rod_scene, scene_duration(rod_scene) * k / INSTANTS, chord);
        scene_hold_part(start.directions < 3 ? &start : &end, chord, chord);
        if (norm(chord) > (1 + 1e-6) * length) { /* of the midpoint rule */
            return scene_refuse(check, "boundary.end.position",
                                "the held ends are farther apart than the rod is long, and "
                                "rod.model or an infinite stiffness locks its stretch and shear");
        }
    }
    return AD_OK;
}

ad_status scene_check_ends(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    const end_keys ends[2] = {
        {&rod_scene->start, &rod_scene->loads.base, "boundary.start.type",
         "boundary.start.position", "boundary.start.rotation", NULL, "loads.base.force",
         "loads.base.moment", "boundary.start.along", "boundary.start.across"},
        {&rod_scene->end, &rod_scene->loads.tip, "boundary.end.type", "boundary.end.position",
         "boundary.end.rotation", "boundary.end.rotation_vector", "loads.tip.force",
         "loads.tip.moment", "boundary.end.along", "boundary.end.across"},
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
