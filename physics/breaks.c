#include "physics/breaks.h"

#include "physics/scene_field.h"

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

/* Formulas switch where they hold; of the numbers some are places along the rod. */
static void walk_fields(walk *at)
{
    const quantity_interval all = at->s;
    bool along = strcmp(at->coordinate, "s") == 0;
    for (int i = 0; i < scene_field_count; i++) {
        const scene_field *field = &scene_fields[i];
        const quantity *q = scene_field_of(at->scene, field);
        quantity_interval s = all;
        scene_field_span(at->scene, field, &s.low, &s.high);
        at->seen_count = s.low == at->s.low && s.high == at->s.high ? at->seen_count : 0;
        at->s = s;
        walk_over(at, field->key, field->count, q);
        if (along && field->rule == SCENE_PLACE && q->is_given) {
            insert(at, q->number);
        }
    }
}

static void walk_joints(walk *at)
{
    at->key = "segments";
    for (int i = 0; i < at->scene->segment_count && strcmp(at->coordinate, "s") == 0; i++) {
        insert(at, scene_joint(at->scene, i));
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
        walk_joints(&at);
    }
    return at.status;
}
