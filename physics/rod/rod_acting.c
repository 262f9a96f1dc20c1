/* What acts on a rod from outside by a law of its place, its rotation or its velocity: which laws a
 * scene has, and what numbers they are given. */
#include "physics/rod/rod_internal.h"
#include "physics/scene/scene_rows.h"

#include <math.h>
#include <string.h>

static const double ACTING_ZEROS[4] = {0, 0, 0, 0};

/* ---- along the rod ------------------------------------------------------------------------- */

#define GIVEN(law, term, member, ...)                                                              \
    {law, term, offsetof(scene, loads.member),                                                     \
     sizeof((scene *)0)->loads.member / sizeof(quantity), __VA_ARGS__},
static const rod_given GIVENS[] = {SCENE_LAW_ROWS(GIVEN)};

/* The weight, a load, and that of a manufactured scene are laws, too. */
_Static_assert(sizeof GIVENS / sizeof *GIVENS + 5 <= ROD_ALONG_MAX, "too many laws along a rod");

int rod_givens(const rod_given **given)
{
    *given = GIVENS;
    return sizeof GIVENS / sizeof *GIVENS;
}

const quantity *rod_given_of(const rod_given *given, const scene *of)
{
    return (const quantity *)((const char *)of + given->offset);
}

double rod_given_scale(const rod_given *given, int i, const rod_scales *by)
{
    return pow(by->length, given->unit[i].length) * pow(by->time, given->unit[i].time) /
           (given->is_factor ? 1 : by->force);
}

static bool acts(const rod_given *given, const scene *of)
{
    return quantity_any_something(given->count, rod_given_of(given, of)) &&
           (scene_is_dynamic(of) || law_table[given->law].kind != LAW_DISSIPATES);
}

/* Whether a scene has a law that is given `first` and what follows it; *last: one after these. */
static bool is_on(const rod_given *first, const scene *of, const rod_given **last)
{
    bool on = false, whole = true;
    for (*last = first; *last < GIVENS + sizeof GIVENS / sizeof *GIVENS; ++*last) {
        if ((*last)->law != first->law) {
            break;
        }
        on = on || (!(*last)->is_factor && acts(*last, of));
        whole = whole && (!(*last)->is_factor || acts(*last, of));
    }
    return on && whole;
}

/* To rows; returns how many. Of a load all but factors grow with it. */
static int put_numbers(const rod_context *rod, const rod_given *given, ad_value s, ad_value *row)
{
    for (int i = 0; i < given->count; i++) {
        row[i] = rod_quantities(rod, 1, rod_given_of(given, rod->scene) + i, ACTING_ZEROS,
                                rod_given_scale(given, i, &rod->scales), s, rod->t);
        if (law_table[given->law].kind == LAW_LOADS && !given->is_factor) {
            row[i] = ad_mul(rod->at.load_factor, row[i]);
        }
    }
    return given->count;
}

static ad_value numbers_of(const rod_context *rod, const rod_given *first, const rod_given *last)
{
    const law *of = &law_table[first->law];
    ad_value row[LAW_NUMBERS_MAX];
    int rows = 0;
    for (const rod_given *given = first; given < last; given++) {
        rows += put_numbers(rod, given, rod->s, row + rows);
    }
    const ad_value numbers = ad_stack(rows, row);
    if (of->kind != LAW_STORES) {
        return numbers;
    }
    /* From where the unstressed rod is; a shift from there is 0. */
    const ad_value place = rod_position_to_world(rod, rod_undeformed(rod, rod->s).position);
    const int shift = of->numbers - rows - 3;
    const ad_value all[3] = {ad_zeros(rod->tape, shift > 0 ? shift : 1), numbers, place};
    return shift > 0 ? ad_stack(3, all) : ad_stack(2, all + 1);
}

/* A load at s, under the load factor, in its own frame: of the world, or of the rod. */
static ad_value load_at(const rod_context *rod, const quantity *given, bool axial, bool follows,
                        double length, ad_value s)
{
    const double unit = axial ? rod->scales.moment : rod->scales.force;
    const ad_value load = rod_quantities(rod, 3, given, ACTING_ZEROS, length / unit, s, rod->t);
    const ad_value now = ad_mul(rod->at.load_factor, load);
    return follows ? rod_keep_in_plane(rod, now, axial)
                   : (axial ? rod_axial_from_world : rod_from_world)(rod, now);
}

/* Force and moment of a load: at the place `at`; or per length, `by` which they are made numbers.
 */
static int add_load(const rod_context *rod, const scene_load *load, double by, double at,
                    ad_value s, rod_acting *acting)
{
    const bool follows = load->frame == SCENE_FOLLOWER;
    int count = 0;
    if (quantity_any_something(3, load->force)) {
        acting[count++] = (rod_acting){follows ? LAW_FOLLOWER_FORCE : LAW_FORCE, at,
                                       load_at(rod, load->force, false, follows, by, s)};
    }
    if (quantity_any_something(3, load->moment)) {
        acting[count++] = (rod_acting){follows ? LAW_FOLLOWER_MOMENT : LAW_MOMENT, at,
                                       load_at(rod, load->moment, true, follows, by, s)};
    }
    return count;
}

static ad_value weight_of(const rod_context *rod, quantity mass)
{
    quantity pull[3];
    for (int i = 0; i < 3; i++) {
        pull[i] = quantity_multiply(mass, rod->scene->loads.gravity[i]);
    }
    return rod_quantities(rod, 3, pull, ACTING_ZEROS, rod->scales.length / rod->scales.force,
                          rod->s, rod->t);
}

ad_value rod_weight(const rod_context *rod)
{
    quantity mass = rod->properties.mass_per_length;
    if (quantity_is_something(rod->scene->loads.buoyancy)) {
        mass = quantity_subtract(mass, rod->scene->loads.buoyancy);
    }
    ad_value weight = weight_of(rod, mass);
    for (int i = 0; i < rod->scene->tube_count; i++) {
        const scene_properties made = scene_tube_properties(&rod->scene->tubes[i]);
        const double end = scene_tube_end(rod->scene, i) / rod->scales.length;
        const ad_value more = weight_of(rod, made.mass_per_length);
        weight = ad_add(weight, rod_within(rod, 0, end, more, ad_zeros(rod->tape, 3)));
    }
    return ad_mul(rod->at.load_factor, rod_from_world(rod, weight));
}

int rod_acting_along(const rod_context *rod, rod_acting *acting)
{
    const scene_loads *loads = &rod->scene->loads;
    const rod_given *first, *next;
    int count = 0;
    for (int left = rod_givens(&first); left > 0; left -= (int)(next - first), first = next) {
        if (is_on(first, rod->scene, &next)) {
            acting[count++] =
                (rod_acting){.law = first->law, .numbers = numbers_of(rod, first, next)};
        }
    }
    if (quantity_any_something(3, loads->gravity)) {
        acting[count++] = (rod_acting){.law = LAW_FORCE, .numbers = rod_weight(rod)};
    }
    scene_load load = {.frame = loads->frame};
    memcpy(load.force, loads->force, sizeof load.force);
    memcpy(load.moment, loads->moment, sizeof load.moment);
    return count + add_load(rod, &load, rod->scales.length, 0, rod->s, acting + count);
}

/* ---- at places ----------------------------------------------------------------------------- */

/* Of [3] numbers with that unit. */
static ad_value stiffness_of(const rod_context *rod, const quantity *given, double unit)
{
    const ad_value zero = ad_scalar(rod->tape, 0);
    return rod_quantities(rod, 3, given, ACTING_ZEROS, 1 / unit, zero, zero);
}

/* An anchor that is given sets out from where the unstressed rod is. */
static ad_value spring_numbers(const rod_context *rod, const scene_spring *given, ad_value position)
{
    const double length = rod->scales.length;
    const ad_value place = rod_position_to_world(rod, position), zero = ad_scalar(rod->tape, 0);
    ad_value shift = ad_zeros(rod->tape, 3);
    if (quantity_any_given(3, given->anchor)) {
        shift = rod_quantities(rod, 3, given->anchor, ACTING_ZEROS, 1 / length, zero, zero);
        shift = ad_mul(rod->at.load_factor, ad_sub(shift, place));
    }
    return ad_stack(3, (ad_value[]){shift,
                                    stiffness_of(rod, given->stiffness, rod->scales.force / length),
                                    place});
}

static int add_points(const rod_context *rod, rod_acting *acting)
{
    int count = 0;
    for (int i = 0; i < rod->scene->point_count; i++) {
        const scene_point *point = &rod->scene->points[i];
        const double s = point->at.number / rod->scales.length;
        count += add_load(rod, &point->load, 1, s, ad_scalar(rod->tape, s), acting + count);
    }
    return count;
}

/* Weights of bodies. Beside the axis R c, of energy -(R c) . f as a magnetic moment c in a field f.
 */
static int add_weights(const rod_context *rod, rod_acting *acting)
{
    const quantity *gravity = rod->scene->loads.gravity;
    int count = 0;
    for (int i = 0; i < rod->scene->body_count && quantity_any_something(3, gravity); i++) {
        const rod_body_data body = rod_body_of(rod, i, rod->t);
        acting[count++] = (rod_acting){LAW_FORCE, body.s, body.weight};
        if (body.is_beside) {
            acting[count++] =
                (rod_acting){LAW_MAGNET, body.s,
                             ad_stack(2, (const ad_value[]){body.world_weight, body.offset})};
        }
    }
    return count;
}

/* A field acts on magnets at places by the same laws: moments by the length are those per length.
 */
static bool is_field(const rod_given *given, const scene *of)
{
    const law_name law = given->law;
    return (law == LAW_MAGNET || law == LAW_MAGNET_GRADIENT) && !given->is_factor &&
           acts(given, of);
}

static int add_magnets(const rod_context *rod, rod_acting *acting)
{
    const double length = rod->scales.length;
    const rod_given *given;
    int count = 0;
    for (int i = 0; i < rod->scene->body_count; i++) {
        const scene_body *body = &rod->scene->bodies[i];
        const ad_value s = ad_scalar(rod->tape, body->at.number / length);
        for (int left = rod_givens(&given); left > 0; left--, given++) {
            ad_value row[LAW_NUMBERS_MAX];
            if (is_field(given, rod->scene) && quantity_any_something(3, body->magnetic_moment)) {
                const int rows = put_numbers(rod, given, s, row);
                row[rows] = rod_quantities(rod, 3, body->magnetic_moment, ACTING_ZEROS, 1 / length,
                                           s, rod->t);
                acting[count++] =
                    (rod_acting){given->law, body->at.number / length, ad_stack(rows + 1, row)};
            }
        }
    }
    return count;
}

int rod_acting_at_places(const rod_context *rod, rod_acting *acting)
{
    int count = add_points(rod, acting);
    count += add_weights(rod, acting + count);
    count += add_magnets(rod, acting + count);
    for (int i = 0; i < rod->scene->spring_count; i++) {
        const scene_spring *given = &rod->scene->springs[i];
        const double s = given->at.number / rod->scales.length;
        const rod_pose pose = rod_undeformed(rod, ad_scalar(rod->tape, s));
        if (quantity_any_something(3, given->stiffness)) {
            acting[count++] =
                (rod_acting){LAW_SPRING, s, spring_numbers(rod, given, pose.position)};
        }
        if (quantity_any_something(3, given->turning)) {
            const ad_value k = stiffness_of(rod, given->turning, rod->scales.moment);
            acting[count++] =
                (rod_acting){LAW_TURNING_SPRING, s, ad_stack(2, (ad_value[]){k, pose.rotation})};
        }
    }
    return count;
}

int rod_acting_at_ends(const rod_context *rod, rod_acting *acting)
{
    int count = 0;
    for (int end = 0; end < 2; end++) {
        const rod_end_data given = rod_end_of(rod, end, rod->t);
        const double sign = end ? 1 : -1; /* N(0) and m(0) are against what acts */
        if (given.hold.directions < 3 && !ad_is_constant(given.force, 0)) {
            acting[count++] = (rod_acting){given.force_is_body ? LAW_FOLLOWER_FORCE : LAW_FORCE,
                                           end, ad_scale(given.force, sign)};
        }
        if (!given.holds_rotation && !ad_is_constant(given.moment, 0)) {
            acting[count++] = (rod_acting){given.moment_is_world ? LAW_MOMENT : LAW_FOLLOWER_MOMENT,
                                           end, ad_scale(given.moment, sign)};
        }
    }
    return count;
}

/* ---- on the tape --------------------------------------------------------------------------- */

static void put_rows(ad_value vector, int count, ad_value *rows)
{
    for (int i = 0; i < count; i++) {
        rows[i] = ad_row(vector, i);
    }
}

rod_wrench rod_acting_wrench(const rod_context *rod, const rod_acting *at, rod_pose pose,
                             ad_value velocity)
{
    const law *of = &law_table[at->law];
    ad_value given[LAW_GIVEN_MAX], wrench[LAW_WRENCH];
    rod_wrench x = {ad_zeros(rod->tape, 3), ad_zeros(rod->tape, 3)};
    if (of->along_axes) {
        pose.position = rod_position_to_world(rod, pose.position);
        pose.rotation = rod_rotation_to_world(rod, pose.rotation);
        velocity = rod_to_world(rod, velocity);
    }
    put_rows(pose.position, 3, given);
    put_rows(pose.rotation, 4, given + 3);
    put_rows(velocity, 3, given + 7);
    put_rows(at->numbers, of->numbers, given + LAW_STATE);
    law_record(at->law, rod->tape, given, NULL, wrench, NULL);
    if (of->has_force) {
        x.force = ad_stack(3, wrench);
        x.force =
            of->along_axes ? rod_from_world(rod, x.force) : rod_keep_in_plane(rod, x.force, false);
    }
    if (of->has_moment) {
        x.moment = ad_rotate_inverse(pose.rotation, ad_stack(3, wrench + 3));
        x.moment = rod_keep_in_plane(rod, x.moment, true);
    }
    return x;
}

bool rod_has_law_along(const scene *given, bool (*which)(const law *of))
{
    const rod_given *first, *next;
    bool any = false;
    for (int left = rod_givens(&first); left > 0; left -= (int)(next - first), first = next) {
        any = (is_on(first, given, &next) && which(&law_table[first->law])) || any;
    }
    return any;
}

bool rod_has_law_at_places(const scene *given, bool (*which)(const law *of))
{
    const rod_given *row;
    bool any = false, magnets = false;
    for (int i = 0; i < given->spring_count; i++) {
        const scene_spring *spring = &given->springs[i];
        any |= quantity_any_something(3, spring->stiffness) && which(&law_table[LAW_SPRING]);
        any |= quantity_any_something(3, spring->turning) && which(&law_table[LAW_TURNING_SPRING]);
    }
    for (int i = 0; i < given->body_count; i++) {
        magnets |= quantity_any_something(3, given->bodies[i].magnetic_moment);
        any |= quantity_any_something(3, given->bodies[i].offset) &&
               quantity_any_something(3, given->loads.gravity) && which(&law_table[LAW_MAGNET]);
    }
    for (int left = rod_givens(&row); left > 0 && magnets; left--, row++) {
        any |= is_field(row, given) && which(&law_table[row->law]);
    }
    return any;
}
