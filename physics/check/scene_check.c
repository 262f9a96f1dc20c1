/* What a scene has to satisfy before physics is recorded from it. Every refusal names the YAML key
 * to blame and says what is allowed. */
#include "physics/numerics/sampling.h"
#include "physics/scene/scene_internal.h"
#include "physics/scene/support.h"

#include <math.h>
#include <stdio.h>

ad_status scene_refuse(const scene_checker *check, const char *key, const char *sentence)
{
    *check->key = check->segment < 0 ? key : scene_key_in_segment(check->segment, key);
    return ad_fail(check->error, AD_BAD_INPUT, "%s", sentence);
}

ad_status scene_refuse_at(const scene_checker *check, const quantity *q, const char *sentence)
{
    return scene_refuse(check, scene_key_of(check->scene, q), sentence);
}

scene_range scene_check_range(const scene_checker *check, quantity q)
{
    return check->piece ? scene_range_within(check->scene, q, check->piece->from, check->piece->to)
                        : scene_range_of(check->scene, q);
}

ad_status scene_check_pieces(const scene_checker *check, scene_check_part *part)
{
    ad_status status = AD_OK;
    bool segments = check->scene->segment_count > 0;
    for (int i = 0; i < scene_pieces(check->scene) && status == AD_OK; i++) {
        scene_piece piece = scene_piece_of(check->scene, i);
        scene_checker of_piece = *check;
        of_piece.piece = &piece;
        of_piece.segment = segments ? i : -1;
        status = part(&of_piece);
    }
    return status;
}

static bool is_dynamic(const scene_checker *check)
{
    return scene_is_dynamic(check->scene);
}

static ad_status check_extent(const scene_checker *check)
{
    ad_status status = scene_check_counts(check);
    if (status == AD_OK) {
        status = scene_check_quantities(check, true);
    }
    return status == AD_OK ? scene_check_extent(check) : status;
}

static ad_status check_others(const scene_checker *check)
{
    return scene_check_quantities(check, false);
}

/* ---- loads ----------------------------------------------------------------------------- */

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
    return AD_OK;
}

/* ---- time and the manufactured solution ---------------------------------------------------- */

static ad_status check_initial_state(const scene_checker *check)
{
    const scene *given = check->scene;
    if (given->initial.state == SCENE_GIVEN) {
        return AD_OK;
    }
    if (scene_is_manufactured(given)) {
        return scene_refuse(check, "initial.state",
                            "equilibrium is not where a manufactured solution starts; leave it "
                            "out");
    }
    return given->initial.position[0].is_given || given->beam.deflection.is_given ||
                   given->beam.slope.is_given
               ? scene_refuse(check, "initial.state",
                              "equilibrium says where the motion starts; leave initial.position "
                              "and initial.rotation out, of a beam beam.initial.deflection and "
                              "slope")
               : AD_OK;
}

static ad_status check_initial(const scene_checker *check)
{
    const scene *rod_scene = check->scene;
    const scene_initial *initial = &rod_scene->initial;
    bool position = quantity_any_given(3, initial->position);
    bool rotation = quantity_any_given(4, initial->rotation);
    if (position != rotation) {
        return scene_refuse(check, position ? "initial.rotation" : "initial.position",
                            "missing; position and rotation at t = 0 come together or not at all");
    }
    if (!is_dynamic(check) || position || scene_is_manufactured(rod_scene) ||
        initial->state == SCENE_EQUILIBRIUM) {
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

/* What no form takes, and what a form of the equations on the tape does not take. */
static ad_status check_support(const scene_checker *check)
{
    const scene_formulation form = check->scene->formulation;
    ad_error reason;
    ad_status status = support_check_any(check->scene, check->key, &reason);
    if (status == AD_OK && (form == SCENE_DISPLACEMENT || form == SCENE_POSE_STRAIN)) {
        status =
            support_check(check->scene, support_formulation(check->scene), check->key, &reason);
    }
    return status == AD_OK ? AD_OK : ad_fail(check->error, AD_BAD_INPUT, "%s", reason.message);
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
                             quantity_any_given(4, rod_scene->end.rotation) ||
                             quantity_any_given(3, rod_scene->end.rotation_vector) ||
                             rod_scene->end.twist.is_given},
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

static ad_status check_member(const scene *rod_scene, const char **key, ad_error *error)
{
    static scene_check_part *const of_rods[] = {check_extent,         check_others,
                                                scene_check_segments, scene_check_rod,
                                                scene_check_no_beam,  check_manufactured,
                                                scene_check_lists,    check_frames,
                                                scene_check_ends,     check_initial_state,
                                                check_initial,        check_time,
                                                check_support,        NULL};
    static scene_check_part *const of_beams[] = {check_extent,         check_others,
                                                 scene_check_segments, scene_check_rod,
                                                 scene_check_lists,    scene_check_beam,
                                                 check_initial_state,  check_time,
                                                 check_support,        NULL};
    const scene_checker check = {rod_scene, NULL, -1, key, error};
    ad_status status = AD_OK;
    for (scene_check_part *const *part = scene_is_beam(rod_scene) ? of_beams : of_rods;
         *part && status == AD_OK; part++) {
        status = (*part)(&check);
    }
    return status;
}

/* ---- families ------------------------------------------------------------------------------ */

enum { CORNERS_OF = 4 }; /* parameters at most: of more the middles of all faces stand for them */
enum { SPREAD = 64 };    /* members beside these */

const char *scene_common_key(const scene *open, bool to_be_found, const scene_parameter **which)
{
    const int known = scene_known_count(open);
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        const quantity *q = scene_field_of(open, field);
        const bool maps = !to_be_found && !scene_is_beam(open);
        bool common = field->rule == SCENE_ONE_NUMBER ||
                      ((field->rule == SCENE_PLACE || field->rule == SCENE_LENGTH) && !maps) ||
                      (field->rule == SCENE_EACH_NUMBER && scene_is_beam(open));
        for (int k = to_be_found ? known : 0;
             k < (to_be_found ? open->parameter_count : known) && common; k++) {
            if (quantity_any_depends_on(field->count, q, open->parameters[k].name)) {
                *which = &open->parameters[k];
                return field->key;
            }
        }
    }
    *which = to_be_found && open->place.is_given ? &open->parameters[known] : NULL;
    return *which ? "rod.length" : NULL;
}

/* What all members have to have in common; what measurements are placed by is no unknown. */
static ad_status check_common(const scene *family, const char **key, ad_error *error)
{
    const struct {
        quantity extent;
        const char *key;
    } extents[] = {{family->duration, "time.duration"}, {scene_whole_length(family), "rod.length"}};
    const scene_parameter *which = NULL;
    const char *common = scene_common_key(family, false, &which);
    const bool is_beam = scene_is_beam(family);
    const int fixed = is_beam ? 2 : scene_is_dynamic(family);
    if (family->unknown_count > 0 && family->rod.inserted.is_given &&
        (is_beam || quantity_depends_on(family->rod.inserted, "t") ||
         family->rod.feed_time.is_given)) {
        *key = "rod.inserted";
        return ad_fail(error, AD_BAD_INPUT,
                       "moves beside a parameter to be identified, whose measurements are along "
                       "what is outside; allowed: what stays");
    }
    if (common) {
        *key = common;
        return ad_fail(error, AD_BAD_INPUT,
                       "depends on %s, which has a range; allowed: one number for all members of "
                       "a family",
                       which->name);
    }
    for (int i = 0; i < fixed; i++) {
        for (int k = scene_known_count(family); k < family->parameter_count; k++) {
            if (quantity_any_depends_on(1, &extents[i].extent, family->parameters[k].name)) {
                *key = extents[i].key;
                return ad_fail(error, AD_BAD_INPUT,
                               "depends on %s, which is to be identified; allowed: a number, by "
                               "which measurements are placed",
                               family->parameters[k].name);
            }
        }
    }
    return AD_OK;
}

/* The member at these fractions of the ranges; an error says which it was. */
static ad_status check_at(const scene *family, const double *fractions, const char **key,
                          ad_error *error)
{
    double values[SCENE_PARAMETERS_MAX];
    char where[300] = "";
    size_t at = 0;
    scene member;
    ad_error reason;
    for (int i = 0; i < family->parameter_count; i++) {
        values[i] = scene_parameter_at(&family->parameters[i], fractions[i]);
        at += at < sizeof where
                  ? (size_t)snprintf(where + at, sizeof where - at, "%s%s=%g", i ? ", " : "",
                                     family->parameters[i].name, values[i])
                  : 0;
    }
    scene_member(family, values, &member);
    if (scene_is_dynamic(family) && family->unknown_count > 0) {
        scene_place_ends(family, &member);
    }
    ad_status status = check_member(&member, key, &reason);
    return status == AD_OK ? AD_OK
                           : ad_fail(error, status, "%s (of the member %s)", reason.message, where);
}

/* Fractions of the ranges: the middle; corners, or of many parameters the middles of faces; middles
 * of edges; and members spread over all. False: no more. */
static bool member_to_check(int number, int count, const double *spread, double *fractions)
{
    const int corners = count <= CORNERS_OF ? 1 << count : 2 * count;
    const int edges = count <= CORNERS_OF ? corners * count / 2 : 0;
    const int corner = number - 1, edge = corner - corners, drawn = edge - edges;
    const int along = edge >= 0 && drawn < 0 ? edge * 2 / corners : -1;
    for (int i = 0; i < count; i++) {
        int bit = i;
        int of = corner;
        if (along >= 0) { /* bits of the other parameters */
            of = edge % (corners / 2);
            bit = i > along ? i - 1 : i;
        }
        const bool of_corner = count <= CORNERS_OF && i != along;
        fractions[i] = number == 0       ? 0.5
                       : drawn >= 0      ? spread[i * SPREAD + drawn % SPREAD]
                       : of_corner       ? (of >> bit) & 1
                       : corner / 2 == i ? corner % 2
                                         : 0.5;
    }
    return drawn < SPREAD;
}

/* Points [count][SPREAD]; the sequence has fewer dimensions than a scene may have parameters, and
 * those beyond are the first ones backwards. */
static ad_status draw_spread(int count, double *spread, ad_error *error)
{
    const int most = SAMPLING_MAX_DIMENSION, drawn = count < most ? count : most;
    const ad_status status = sampling_fill(SAMPLING_SOBOL, NULL, drawn, SPREAD, spread, error);
    for (int i = drawn * SPREAD; status == AD_OK && i < count * SPREAD; i++) {
        spread[i] = spread[(i / SPREAD - drawn) * SPREAD + SPREAD - 1 - i % SPREAD];
    }
    return status;
}

static ad_status check_members(const scene *family, const char **key, ad_error *error)
{
    const int count = family->parameter_count;
    double fractions[SCENE_PARAMETERS_MAX], spread[SCENE_PARAMETERS_MAX * SPREAD];
    ad_status status = draw_spread(count, spread, error);
    ad_error reason = {AD_OK, ""}, another;
    const char *other;
    int checked = 0, refused = 0;
    for (; status == AD_OK && member_to_check(checked, count, spread, fractions); checked++) {
        refused += check_at(family, fractions, refused ? &other : key,
                            refused ? &another : &reason) != AD_OK;
    }
    return status == AD_OK && refused > 0
               ? ad_fail(error, reason.status, "%s; %d of %d members looked at are refused",
                         reason.message, refused, checked)
               : status;
}

ad_status scene_check(const scene *rod_scene, const char **key, ad_error *error)
{
    const char *ignored = NULL;
    key = key ? key : &ignored;
    if (!scene_is_open(rod_scene)) {
        return check_member(rod_scene, key, error);
    }
    if (scene_is_manufactured(rod_scene)) {
        *key = "manufactured";
        return ad_fail(error, AD_BAD_INPUT,
                       "is the solution of one scene, but parameters have ranges; allowed: numbers "
                       "in their place");
    }
    ad_status status = check_common(rod_scene, key, error);
    return status == AD_OK ? check_members(rod_scene, key, error) : status;
}
