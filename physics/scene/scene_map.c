/* Lengths and places that differ from member to member, and what has come out of a port: the same
 * rods along another s, with the same places for all. */
#include "physics/scene/breaks.h"
#include "physics/scene/scene_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Fewest parameters of which not all corners are looked at, and members beside these. */
enum { CORNERS_OF = 9, SPREAD = 64, KNOTS_MAX = BREAKS_MAX };

/* A place that is one number along the other s. */
typedef struct knot {
    quantity x; /* m on the rod as it is written; of parameters */
    double at;  /* of the middle */
    const char *key;
} knot;

typedef struct mapping {
    const scene *given;
    double time; /* s, at which places are */
    scene middle;
    knot knots[KNOTS_MAX]; /* ascending, from where the rod is held to its tip */
    int count, known;
    double same;                         /* m; what is closer is one place */
    int which[SCENE_PARAMETERS_MAX], on; /* parameters on which places depend */
    const char **key;
    ad_error *error;
} mapping;

/* ---- growth -------------------------------------------------------------------------------- */

quantity scene_grown(quantity q, quantity growth, int power)
{
    if (!growth.is_given || !quantity_is_something(q) || quantity_is(q, INFINITY)) {
        return q;
    }
    return power > 0 ? quantity_multiply(q, growth) : quantity_divide(q, growth);
}

/* `otherwise` where it is not given. */
static double mapped_at(const scene *rod_scene, quantity q, double otherwise, const double *values,
                        double s, double t)
{
    const char *names[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < rod_scene->parameter_count; i++) {
        names[i] = rod_scene->parameters[i].name;
    }
    return q.is_given ? quantity_value_with(q, s, t, values ? rod_scene->parameter_count : 0, names,
                                            values)
                      : otherwise;
}

double scene_place_at(const scene *rod_scene, const double *values, double s, double t)
{
    return mapped_at(rod_scene, rod_scene->place, s, values, s, t);
}

double scene_growth_at(const scene *rod_scene, const double *values, double s, double t)
{
    return mapped_at(rod_scene, rod_scene->rod.growth, 1, values, s, t);
}

double scene_at_place(const scene *rod_scene, double place, double t)
{
    const double to = rod_scene->feed.to, port = scene_place_at(rod_scene, NULL, 0, t);
    const double end = scene_place_at(rod_scene, NULL, to, t);
    return place < end ? to * (place - port) / (end - port) : place - end + to;
}

double scene_s_of_place(const scene *open, const double *values, double place, double t)
{
    enum { HALVINGS = 60 };
    const double length = scene_length(open), same = 1e-9 * length;
    double low = 0, high = length, other[SCENE_PARAMETERS_MAX];
    if (!open->place.is_given) {
        return place;
    }
    for (int i = 0; i < HALVINGS; i++) {
        const double middle = (low + high) / 2;
        *(scene_place_at(open, values, middle, t) < place ? &low : &high) = middle;
    }
    const double s = low < same ? 0 : high > length - same ? length : high;
    bool fixed = fabs(scene_place_at(open, values, s, t) - place) <= same;
    for (int k = scene_known_count(open); k < open->parameter_count; k++) {
        for (int side = 0; side < 2 && fixed; side++) {
            memcpy(other, values, (size_t)open->parameter_count * sizeof *other);
            other[k] = side ? open->parameters[k].high : open->parameters[k].low;
            fixed = fabs(scene_place_at(open, other, s, t) - place) <= same;
        }
    }
    return fixed ? s : NAN;
}

/* ---- places -------------------------------------------------------------------------------- */

static bool is_place(const scene_field *field)
{
    return field->rule == SCENE_LENGTH || field->rule == SCENE_PLACE;
}

/* Whether it is an own number of each member, or of each time. */
static bool is_ranged(const scene *given, quantity q)
{
    bool depends = quantity_depends_on(q, "t");
    for (int i = 0; i < given->parameter_count; i++) {
        depends = depends || quantity_depends_on(q, given->parameters[i].name);
    }
    return depends;
}

/* Beside what is to be found only lengths are followed: what is measured between places stays where
 * it is. */
static bool is_needed(const scene *given)
{
    const bool finds = given->unknown_count > 0;
    bool needed = given->rod.inserted.is_given;
    for (int i = 0; i < scene_field_count && !needed; i++) {
        needed = (finds ? scene_fields[i].rule == SCENE_LENGTH : is_place(&scene_fields[i])) &&
                 is_ranged(given, *scene_field_of(given, &scene_fields[i]));
    }
    return needed;
}

/* Where segment `index` ends; of -1 where the first begins. */
static quantity joint_of(const scene *given, int index)
{
    quantity sum = quantity_number(0);
    for (int i = 0; i <= index; i++) {
        sum = quantity_add(sum, given->segments[i].length);
    }
    return sum;
}

quantity scene_whole_length(const scene *rod_scene)
{
    return rod_scene->rod.length.is_given ? rod_scene->rod.length
                                          : joint_of(rod_scene, rod_scene->segment_count - 1);
}

/* Of the member that is looked at: all in the middle but those of `which`, by fractions. */
static double value_of(const mapping *map, quantity q, const double *fractions)
{
    const char *names[SCENE_PARAMETERS_MAX];
    double values[SCENE_PARAMETERS_MAX];
    scene_middle_values(map->given, values);
    for (int i = 0; i < map->given->parameter_count; i++) {
        names[i] = map->given->parameters[i].name;
    }
    for (int i = 0; i < map->on && fractions; i++) {
        values[map->which[i]] =
            scene_parameter_at(&map->given->parameters[map->which[i]], fractions[i]);
    }
    return quantity_value_with(q, 0, map->time, map->given->parameter_count, names, values);
}

/* Corners of the ranges, if these are few, and members between; false: no more. */
static bool member_at(const mapping *map, int number, double *fractions)
{
    const int corners = map->on < CORNERS_OF ? 1 << map->on : 0;
    for (int i = 0; i < map->on; i++) {
        fractions[i] =
            number < corners ? (number >> i) & 1 : scene_spread_fraction(number - corners, i);
    }
    return number < corners + SPREAD;
}

static bool add(mapping *map, quantity x, const char *key)
{
    if (map->count < KNOTS_MAX) {
        map->knots[map->count++] = (knot){x, value_of(map, x, NULL), key};
    }
    for (int i = 0; i < map->given->parameter_count; i++) {
        bool listed = !quantity_depends_on(x, map->given->parameters[i].name);
        for (int k = 0; k < map->on && !listed; k++) {
            listed = map->which[k] == i;
        }
        if (!listed) {
            map->which[map->on++] = i;
        }
    }
    return map->count < KNOTS_MAX;
}

static int in_order(const void *a, const void *b)
{
    const double x = ((const knot *)a)->at, y = ((const knot *)b)->at;
    return (x > y) - (x < y);
}

/* All places that are written, the port and the tip among them. */
static ad_status list_places(mapping *map)
{
    const scene *given = map->given;
    const quantity length = scene_whole_length(given);
    const quantity port = given->rod.inserted.is_given
                              ? quantity_subtract(length, given->rod.inserted)
                              : quantity_number(0);
    bool fits = add(map, port, "rod.inserted") && add(map, length, "rod.length");
    for (int i = 0; i + 1 < given->segment_count && fits; i++) {
        fits = add(map, joint_of(given, i), "segments");
    }
    for (int i = 0; i < scene_field_count && fits; i++) {
        const quantity *q = scene_field_of(given, &scene_fields[i]);
        fits = scene_fields[i].rule != SCENE_PLACE || !q->is_given ||
               add(map, *q, scene_fields[i].key);
    }
    map->same = PLACE_ROUNDING * scene_length(&map->middle);
    return fits ? AD_OK
                : ad_fail(map->error, AD_BAD_INPUT,
                          "has more places than can follow a range; allowed: up to %d",
                          KNOTS_MAX - 1);
}

/* Where formulas switch in the middle, as far as that is no place above and the same for members:
 * what differs is a jump between points of meshes, as it is in all families. */
static ad_status list_switches(mapping *map)
{
    scene_breaks breaks[1 + SPREAD / 8];
    const int others = map->on > 0 ? SPREAD / 8 : 0, written = map->count;
    ad_status status = AD_OK;
    for (int m = 0; m <= others && status == AD_OK; m++) {
        double values[SCENE_PARAMETERS_MAX], fractions[SCENE_PARAMETERS_MAX];
        scene member;
        scene_middle_values(map->given, values);
        member_at(map, (map->on < CORNERS_OF ? 1 << map->on : 0) + m, fractions);
        for (int i = 0; i < map->on && m > 0; i++) {
            values[map->which[i]] =
                scene_parameter_at(&map->given->parameters[map->which[i]], fractions[i]);
        }
        scene_member(map->given, values, &member);
        status = scene_breaks_of(&member, "s", &breaks[m], map->error);
    }
    for (int i = 0; i < breaks[0].count && status == AD_OK; i++) {
        int seen = 0;
        bool is_new = true;
        for (int k = 0; k < written; k++) {
            is_new = is_new && fabs(map->knots[k].at - breaks[0].place[i]) > map->same;
        }
        for (int m = 1; m <= others && is_new; m++) {
            for (int k = 0; k < breaks[m].count; k++) {
                seen += fabs(breaks[m].place[k] - breaks[0].place[i]) <= map->same;
            }
        }
        if (is_new && seen == others) {
            add(map, quantity_number(breaks[0].place[i]), "rod");
        }
    }
    return status;
}

static bool moves_in_time(const mapping *map)
{
    return quantity_depends_on(map->given->rod.inserted, "t");
}

/* That two neighbours in the middle are neighbours, or one place, everywhere. */
static ad_status check_order(mapping *map, const knot *a, const knot *b)
{
    enum { TIMES = 257 };
    const bool one = b->at - a->at <= map->same;
    const int times = moves_in_time(map) ? TIMES : 1;
    double fractions[SCENE_PARAMETERS_MAX];
    for (int i = 0; i % times > 0 || member_at(map, i / times, fractions); i++) {
        map->time = times > 1 ? scene_duration(map->given) * (i % times) / (TIMES - 1) : 0;
        const double x = value_of(map, a->x, fractions), y = value_of(map, b->x, fractions);
        map->time = 0;
        if (one ? fabs(y - x) > map->same : y - x <= map->same) {
            *map->key = strcmp(b->key, "rod.length") == 0 ? a->key : b->key;
            return ad_fail(map->error, AD_BAD_INPUT,
                           "within the ranges places change their order: %s and %s are at %g m and "
                           "%g m in the middle, but at %g m and %g m of another member; allowed: "
                           "ranges in which they are in the same order, or always one",
                           a->key, b->key, a->at, b->at, x, y);
        }
    }
    return AD_OK;
}

/* Puts them in order, one of each place, and leaves out what is behind the port. */
static ad_status sort_knots(mapping *map)
{
    const double port = map->knots[0].at;
    ad_status status = AD_OK;
    qsort(map->knots, (size_t)map->count, sizeof *map->knots, in_order);
    for (int i = 0; i + 1 < map->count && status == AD_OK; i++) {
        /* two that stay behind may do as they like, unless one is the port */
        const bool behind = map->knots[i + 1].at < port - map->same;
        status = behind ? AD_OK : check_order(map, &map->knots[i], &map->knots[i + 1]);
    }
    for (int i = 0; i < map->count && status == AD_OK; i++) {
        const bool behind = map->knots[i].at < port - map->same;
        if (behind && is_ranged(map->given, map->knots[i].x)) {
            for (int k = i + 1; k < map->count && status == AD_OK; k++) {
                status = fabs(map->knots[k].at - port) <= map->same
                             ? check_order(map, &map->knots[i], &map->knots[k])
                             : AD_OK;
            }
        }
    }
    int kept = 0;
    for (int i = 0; i < map->count; i++) {
        const bool behind = map->knots[i].at < port - map->same;
        const bool again = kept > 0 && map->knots[i].at - map->knots[kept - 1].at <= map->same;
        if (!behind && !again) {
            map->knots[kept++] = map->knots[i];
        }
    }
    map->count = kept;
    return status;
}

/* ---- what moves through the port ------------------------------------------------------------ */

/* The parameter that a quantity is, and nothing else; -1: none. */
static int parameter_of(const mapping *map, quantity q)
{
    int found = -1, depends = 0;
    for (int i = 0; i < scene_known_count(map->given); i++) {
        if (quantity_depends_on(q, map->given->parameters[i].name)) {
            found = i;
            depends++;
        }
    }
    for (int side = 0; side < 3 && depends == 1; side++) {
        double fractions[SCENE_PARAMETERS_MAX];
        for (int i = 0; i < map->on; i++) {
            fractions[i] = 0.5 * side;
        }
        const double at = scene_parameter_at(&map->given->parameters[found], 0.5 * side);
        depends = fabs(value_of(map, q, fractions) - at) <= map->same ? 1 : 0;
    }
    return depends == 1 ? found : -1;
}

/* The speed of what comes out where its formula switches. */
static ad_status check_speed(mapping *map)
{
    const double duration = scene_duration(map->given), h = 1e-7 * duration;
    const quantity out = map->given->rod.inserted;
    scene alone = {.rod.length = quantity_number(1), .duration = map->given->duration};
    scene_breaks breaks;
    alone.loads.tip.force[0] = out;
    ad_status status = scene_breaks_of(&alone, "t", &breaks, map->error);
    for (int i = 0; i < breaks.count && status == AD_OK; i++) {
        const double t = breaks.place[i];
        const double before = quantity_value(out, 0, t - h) - quantity_value(out, 0, t - 2 * h);
        const double behind = quantity_value(out, 0, t + 2 * h) - quantity_value(out, 0, t + h);
        const double over = quantity_value(out, 0, t + h) - quantity_value(out, 0, t - h);
        const double allowed = 1e-3 * h / duration * quantity_value(out, 0, t);
        if (!(fabs(behind - before) <= allowed) || !(fabs(over - before - behind) <= allowed)) {
            *map->key = "rod.inserted";
            return ad_fail(map->error, AD_BAD_INPUT,
                           "jumps, or its speed does, at t = %g s; allowed: a formula whose speed "
                           "goes on, as no drive jumps",
                           t);
        }
    }
    return status;
}

/* Of a motion, after the knots are sorted. */
static ad_status find_feed(mapping *map, scene_feed *feed)
{
    const bool in_time = moves_in_time(map);
    const int parameter = parameter_of(map, map->given->rod.inserted);
    const bool follows = map->given->rod.feed_time.is_given && parameter >= 0;
    *feed = (scene_feed){0};
    if (!scene_is_dynamic(map->given) || !(in_time || follows)) {
        return AD_OK;
    }
    for (int i = 1; i < map->count; i++) {
        if (is_ranged(map->given, map->knots[i].x)) {
            *map->key = map->knots[i].key;
            return ad_fail(map->error, AD_BAD_INPUT,
                           "has a range in a rod that moves through its port; allowed: one number");
        }
    }
    feed->to = map->knots[1].at - map->knots[0].at;
    feed->by = in_time ? SCENE_FED_IN_TIME : parameter;
    return in_time ? check_speed(map) : AD_OK;
}

/* ---- along the other s --------------------------------------------------------------------- */

/* place and growth of the pieces between knots, joined at what is before. */
static void join(const mapping *map, quantity *place, quantity *growth)
{
    const quantity s = quantity_formula(map->given->names, "s");
    const double port = map->knots[0].at;
    for (int i = map->count - 2; i >= 0; i--) {
        const knot *a = &map->knots[i], *b = a + 1;
        const bool fixed = !is_ranged(map->given, a->x) && !is_ranged(map->given, b->x);
        const quantity begin = quantity_number(a->at - port);
        const quantity beyond = i > 0 ? quantity_subtract(s, begin) : s;
        const quantity grown =
            fixed ? quantity_number(1)
                  : quantity_scale(quantity_subtract(b->x, a->x), 1 / (b->at - a->at));
        const quantity at = !fixed     ? quantity_add(a->x, quantity_multiply(grown, beyond))
                            : port > 0 ? quantity_add(s, quantity_number(port))
                                       : s;
        const quantity end = quantity_number(b->at - port), past = quantity_subtract(s, end);
        const bool last = i == map->count - 2;
        const bool same_place = !last && place->node == at.node;
        const bool same_growth =
            !last && growth->node == grown.node && (grown.node || growth->number == grown.number);
        *place = last || same_place ? at : quantity_call("where", (quantity[]){past, *place, at});
        *growth = last || same_growth ? grown
                                      : quantity_call("where", (quantity[]){past, *growth, grown});
    }
}

static void drop(scene *of, int list, int index)
{
    const scene_list *from = &scene_lists[list];
    char *first = (char *)of + from->offset + (size_t)index * from->stride;
    int *count = (int *)(void *)((char *)of + from->count_offset);
    memmove(first, first + from->stride, (size_t)(*count - index - 1) * from->stride);
    --*count;
}

/* What acts behind the port, or ends there, does not act. */
static void drop_behind(const mapping *map, scene *result)
{
    const double port = map->knots[0].at + map->same, before = port - 2 * map->same;
    const scene *middle = &map->middle;
    for (int i = middle->point_count - 1; i >= 0; i--) {
        if (middle->points[i].at.number < before) {
            drop(result, 1, i);
        }
    }
    for (int i = middle->body_count - 1; i >= 0; i--) {
        if (middle->bodies[i].at.number < before) {
            drop(result, 2, i);
        }
    }
    for (int i = middle->spring_count - 1; i >= 0; i--) {
        if (middle->springs[i].at.number < before) {
            drop(result, 3, i);
        }
    }
    for (int i = scene_actuator_count(middle) - 1; i >= 0; i--) {
        const bool chamber = i >= middle->tendon_count;
        if (scene_actuator_of(middle, i).to <= port) {
            drop(result, chamber ? 5 : 4, chamber ? i - middle->tendon_count : i);
        }
    }
    for (int i = middle->segment_count - 2; i >= 0; i--) {
        if (scene_joint(middle, i) <= port) {
            drop(result, 0, 0); /* so many, from the first on */
        }
    }
    for (int k = 0; k < 3; k++) { /* what joined the first to those behind lies straight */
        result->segments[0].turn[k] = quantity_number(0);
    }
}

/* Places and lengths as numbers, all formulas along the other s. */
static void rewrite(const mapping *map, scene *result)
{
    const double port = map->knots[0].at, whole = map->knots[map->count - 1].at - port;
    double joint = 0;
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        quantity *q = (quantity *)(void *)((char *)result + field->offset);
        const bool per_length = strncmp(field->key, "loads.", 6) == 0 &&
                                (field->rule == SCENE_ALONG || field->rule == SCENE_EVERYWHERE);
        for (int k = 0; k < field->count && q[k].is_given; k++) {
            if (field->rule == SCENE_PLACE) {
                const double at = value_of(map, q[k], NULL) - port;
                q[k] = quantity_number(fmin(fmax(at, 0), whole));
            } else if (field->rule != SCENE_LENGTH) {
                q[k] = quantity_put(q[k], "s", result->place);
                q[k] = per_length ? scene_grown(q[k], result->rod.growth, 1) : q[k];
            }
        }
    }
    for (int i = 0; i < map->middle.segment_count; i++) {
        const double end = fmax(scene_joint(&map->middle, i) - port, 0);
        result->segments[i].length = quantity_number(end - joint);
        joint = end;
    }
    result->rod.length = quantity_number(whole);
    result->rod.inserted = (quantity){.is_given = false};
}

/* What is behind s = 0 stays as long as it is, for each member. */
static void grow_tubes(scene *result)
{
    const quantity base = quantity_put(result->rod.growth, "s", quantity_number(0));
    for (int i = 0; i < result->tube_count; i++) {
        scene_tube *tube = &result->tubes[i];
        tube->rod.growth = result->rod.growth;
        tube->transmission = scene_grown(tube->transmission, base, -1);
    }
}

ad_status scene_map(const scene *given, scene *mapped, const char **key, ad_error *error)
{
    *mapped = *given;
    if (!is_needed(given)) {
        return AD_OK;
    }
    mapping *map = calloc(1, sizeof *map);
    if (!map) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for places");
    }
    *map = (mapping){.given = given, .key = key, .error = error};
    scene_middle(given, &map->middle);
    *key = "rod.length";
    ad_status status = list_places(map);
    status = status == AD_OK ? list_switches(map) : status;
    status = status == AD_OK ? sort_knots(map) : status;
    if (status == AD_OK) {
        quantity growth = {.is_given = false};
        join(map, &mapped->place, &growth);
        const bool grows = !quantity_is(growth, 1);
        mapped->rod.growth = grows ? growth : (quantity){.is_given = false};
        rewrite(map, mapped);
        grow_tubes(mapped);
        drop_behind(map, mapped);
        status = find_feed(map, &mapped->feed);
        if (!grows && map->knots[0].at <= 0) {
            mapped->place = (quantity){.is_given = false};
        }
        status = status == AD_OK ? quantity_check(mapped->place, error) : status;
    }
    free(map);
    return status;
}
