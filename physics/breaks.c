#include "physics/breaks.h"

#include "physics/scene_field.h"

#include <stddef.h>
#include <string.h>

/* Of the range: places that are closer are one, written in two ways. */
static const double SAME = 4e-13;

enum { SEEN_MAX = 64 };

typedef struct walk {
    const scene *scene;
    const char *coordinate;
    quantity_interval s, t; /* where to look */
    double end;             /* of the range, from 0 */
    const char *key;        /* of the formulas at hand */
    int seen_count;         /* expressions looked at already, in the same range */
    const struct quantity_node *seen[SEEN_MAX];
    scene_breaks *result;
    ad_status status;
    ad_error *error;
} walk;

static void insert(walk *at, double place)
{
    scene_breaks *breaks = at->result;
    int i = breaks->count;
    if (!(place > SAME * at->end && place < (1 - SAME) * at->end)) {
        return;
    }
    for (int k = 0; k < breaks->count; k++) {
        if (fabs(breaks->place[k] - place) <= SAME * at->end) {
            return;
        }
    }
    if (breaks->count == BREAKS_MAX) {
        breaks->unresolved = breaks->unresolved ? breaks->unresolved : at->key;
        return;
    }
    for (; i > 0 && breaks->place[i - 1] > place; i--) {
        breaks->place[i] = breaks->place[i - 1];
    }
    breaks->place[i] = place;
    breaks->count++;
}

/* ---- formulas -------------------------------------------------------------------------------- */

static bool is_seen(walk *at, quantity expression)
{
    for (int i = 0; i < at->seen_count; i++) {
        if (at->seen[i] == expression.node) {
            return true;
        }
    }
    if (at->seen_count < SEEN_MAX) {
        at->seen[at->seen_count++] = expression.node;
    }
    return false;
}

static void visit(quantity expression, void *context)
{
    walk *at = context;
    double places[BREAKS_MAX];
    if (at->status == AD_OK) {
        at->status = quantity_check(expression, at->error);
    }
    if (at->status != AD_OK || !quantity_depends_on(expression, at->coordinate) ||
        is_seen(at, expression)) {
        return;
    }
    int count = quantity_sign_changes(expression, at->coordinate, at->s, at->t, BREAKS_MAX, places);
    for (int i = 0; i < count; i++) {
        insert(at, places[i]);
    }
    if (count < 0 && !at->result->unresolved) {
        at->result->unresolved = at->key;
    }
}

static void walk_over(walk *at, const char *key, int count, const quantity *q)
{
    at->key = key;
    for (int i = 0; i < count; i++) {
        if (quantity_depends_on(q[i], at->coordinate)) {
            quantity_switches(q[i], visit, at);
        }
    }
}

/* A place along the rod that is given as a number. */
static void walk_to(walk *at, const char *key, quantity place)
{
    double s = 0;
    at->key = key;
    if (strcmp(at->coordinate, "s") == 0 && quantity_is_number(place, &s)) {
        insert(at, s);
    }
}

static void walk_fields(walk *at)
{
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        walk_over(at, field->key, field->count, scene_field_of(at->scene, field));
    }
}

/* ---- lists ----------------------------------------------------------------------------------- */

/* What a segment gives of a rod counts within it alone. */
static void walk_segment(walk *at, const scene_segment *segment, double first, double last)
{
    const quantity_interval s = at->s;
    at->seen_count = 0;
    at->s = (quantity_interval){first, fmin(last, s.high)};
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        size_t begin = offsetof(scene, rod);
        if (field->offset >= begin && field->offset < begin + sizeof(scene_rod)) {
            const char *rod = (const char *)&segment->rod;
            walk_over(at, "segments", field->count,
                      (const quantity *)(const void *)(rod + field->offset - begin));
        }
    }
    walk_over(at, "segments", 3, segment->turn);
    at->s = s;
    at->seen_count = 0;
}

static void walk_segments(walk *at)
{
    double first = 0;
    for (int i = 0; i < at->scene->segment_count; i++) {
        double last = first + at->scene->segments[i].length.number;
        walk_segment(at, &at->scene->segments[i], first, last);
        walk_to(at, "segments", quantity_number(last));
        first = last;
    }
}

static void walk_load(walk *at, const char *key, const scene_load *load)
{
    walk_over(at, key, 3, load->force);
    walk_over(at, key, 3, load->moment);
}

static void walk_attached(walk *at)
{
    const scene *given = at->scene;
    for (int i = 0; i < given->point_count; i++) {
        walk_to(at, "loads.points", given->points[i].at);
        walk_load(at, "loads.points", &given->points[i].load);
    }
    for (int i = 0; i < given->body_count; i++) {
        walk_to(at, "bodies", given->bodies[i].at);
    }
    for (int i = 0; i < given->spring_count; i++) {
        walk_to(at, "springs", given->springs[i].at);
    }
}

static void walk_actuators(walk *at)
{
    const scene *given = at->scene;
    for (int i = 0; i < given->tendon_count; i++) {
        const scene_tendon *tendon = &given->tendons[i];
        walk_to(at, "tendons", tendon->start);
        walk_to(at, "tendons", tendon->end);
        walk_over(at, "tendons", 2, tendon->offset);
        walk_over(at, "tendons", 1, &tendon->tension);
        walk_over(at, "tendons", 1, &tendon->displacement);
        walk_over(at, "tendons", 1, &tendon->friction);
    }
    for (int i = 0; i < given->chamber_count; i++) {
        const scene_chamber *chamber = &given->chambers[i];
        walk_to(at, "chambers", chamber->start);
        walk_to(at, "chambers", chamber->end);
        walk_over(at, "chambers", 2, chamber->offset);
        walk_over(at, "chambers", 1, &chamber->pressure);
        walk_over(at, "chambers", 1, &chamber->area);
    }
}

ad_status scene_breaks_of(const scene *rod_scene, const char *coordinate, scene_breaks *result,
                          ad_error *error)
{
    double length = scene_length(rod_scene), duration = scene_duration(rod_scene);
    walk at = {.scene = rod_scene,
               .coordinate = coordinate,
               .s = {0, length},
               .t = {0, duration},
               .end = strcmp(coordinate, "s") == 0 ? length : duration,
               .result = result,
               .status = AD_OK,
               .error = error};
    *result = (scene_breaks){.count = 0};
    if (at.end > 0) {
        walk_fields(&at);
        walk_segments(&at);
        walk_attached(&at);
        walk_actuators(&at);
    }
    return at.status;
}
