#include "physics/scene/breaks.h"

#include "physics/scene/scene_field.h"
#include "physics/scene/scene_walk.h"

#include <math.h>
#include <string.h>

/* Of the range: places that are closer are one, written in two ways. */
static const double SAME = 4e-13;

enum { SEEN_MAX = 64 };

typedef struct finding {
    const char *coordinate;
    double end;             /* of the range, from 0 */
    quantity_interval s, t; /* where to look */
    const char *key;        /* of the formulas at hand */
    int seen_count;         /* expressions looked at already, in the same range */
    const struct quantity_node *seen[SEEN_MAX];
    scene_breaks *result;
    ad_status status;
    ad_error *error;
} finding;

static void insert(finding *in, double place)
{
    scene_breaks *breaks = in->result;
    int i = breaks->count;
    if (!(place > SAME * in->end && place < (1 - SAME) * in->end)) {
        return;
    }
    for (int k = 0; k < breaks->count; k++) {
        if (fabs(breaks->place[k] - place) <= SAME * in->end) {
            return;
        }
    }
    if (breaks->count == BREAKS_MAX) {
        breaks->unresolved = breaks->unresolved ? breaks->unresolved : in->key;
        return;
    }
    for (; i > 0 && breaks->place[i - 1] > place; i--) {
        breaks->place[i] = breaks->place[i - 1];
    }
    breaks->place[i] = place;
    breaks->count++;
}

static bool is_seen(finding *in, quantity expression)
{
    for (int i = 0; i < in->seen_count; i++) {
        if (in->seen[i] == expression.node) {
            return true;
        }
    }
    if (in->seen_count < SEEN_MAX) {
        in->seen[in->seen_count++] = expression.node;
    }
    return false;
}

static void find_switches(quantity expression, void *context)
{
    finding *in = context;
    double places[BREAKS_MAX];
    if (in->status == AD_OK) {
        in->status = quantity_check(expression, in->error);
    }
    if (in->status != AD_OK || !quantity_depends_on(expression, in->coordinate) ||
        is_seen(in, expression)) {
        return;
    }
    int count = quantity_sign_changes(expression, in->coordinate, in->s, in->t, BREAKS_MAX, places);
    for (int i = 0; i < count; i++) {
        insert(in, places[i]);
    }
    if (count < 0 && !in->result->unresolved) {
        in->result->unresolved = in->key;
    }
}

static void look_into(void *context, const char *key, quantity q, quantity_interval s)
{
    finding *in = context;
    bool same = in->s.low == s.low && in->s.high == s.high;
    in->seen_count = same ? in->seen_count : 0;
    in->s = s;
    in->key = key;
    quantity_switches(q, find_switches, in);
}

static void add_place(void *context, const char *key, double s)
{
    finding *in = context;
    in->key = key;
    insert(in, s);
}

ad_status scene_breaks_of(const scene *rod_scene, const char *coordinate, scene_breaks *result,
                          ad_error *error)
{
    double length = scene_length(rod_scene), duration = scene_duration(rod_scene);
    finding in = {.coordinate = coordinate,
                  .end = strcmp(coordinate, "s") == 0 ? length : duration,
                  .t = {0, duration},
                  .result = result,
                  .status = AD_OK,
                  .error = error};
    const scene_walker walker = {.formula = look_into, .place = add_place, .context = &in};
    *result = (scene_breaks){.count = 0};
    if (in.end > 0) {
        scene_walk(rod_scene, coordinate, &walker);
    }
    return in.status;
}

static ad_status breaks_at(const scene *family, const char *coordinate, const double *values,
                           scene_breaks *result, ad_error *error)
{
    scene member;
    scene_member(family, values, &member);
    return scene_breaks_of(&member, coordinate, result, error);
}

ad_status scene_breaks_moved(const scene *family, const char *coordinate, const double *values,
                             double part, scene_breaks *now, int *moved_by, ad_error *error)
{
    const bool along = strcmp(coordinate, "s") == 0;
    const double still = 1e-8 * part * (along ? scene_length(family) : scene_duration(family));
    double beside[SCENE_PARAMETERS_MAX];
    scene_breaks there;
    ad_status status = breaks_at(family, coordinate, values, now, error);
    *moved_by = -1;
    for (int k = 0; k < family->parameter_count && status == AD_OK && *moved_by < 0; k++) {
        const scene_parameter *of = &family->parameters[k];
        memcpy(beside, values, (size_t)family->parameter_count * sizeof *beside);
        beside[k] += part * (of->high - of->low);
        status = breaks_at(family, coordinate, beside, &there, error);
        bool stay = status == AD_OK && there.count == now->count;
        for (int i = 0; i < now->count && stay; i++) {
            stay = fabs(there.place[i] - now->place[i]) <= still;
        }
        *moved_by = stay ? -1 : k;
    }
    return status;
}

/* By more than a thousandth of its largest size. */
static bool jumps_by(const scene *rod_scene, quantity q, double change)
{
    scene_range range = scene_range_of(rod_scene, q);
    return fabs(change) > 1e-3 * fmax(fabs(range.low), fabs(range.high));
}

static bool acts_at_place(const scene_field *field)
{
    return field->rule == SCENE_AT_END || field->rule == SCENE_AT_PLACE;
}

double scene_breaks_before(const scene_breaks *breaks, double length, double s)
{
    double before = s / length;
    for (int i = 0; i < breaks->count; i++) {
        before = s == breaks->place[i] ? before * (1 - 1e-15) : before;
    }
    return before;
}

bool scene_is_sudden(const scene *rod_scene, const scene_breaks *in_time)
{
    const double near = 1e-9 * scene_duration(rod_scene);
    const scene_initial *initial = &rod_scene->initial;
    bool unstressed = initial->state == SCENE_GIVEN && !initial->position[0].is_given &&
                      !rod_scene->beam.deflection.is_given;
    bool sudden = false;
    for (int i = 0; i < scene_field_count && !sudden; i++) {
        const scene_field *field = &scene_fields[i];
        const quantity *q = scene_field_of(rod_scene, field);
        for (int k = 0; acts_at_place(field) && k < field->count; k++) {
            if (!quantity_is_something(q[k])) {
                continue;
            }
            sudden |= unstressed && jumps_by(rod_scene, q[k], quantity_value(q[k], 0, near));
            for (int b = 0; b < in_time->count && quantity_depends_on(q[k], "t"); b++) {
                double at = in_time->place[b], before = quantity_value(q[k], 0, at - near);
                sudden |= jumps_by(rod_scene, q[k], quantity_value(q[k], 0, at + near) - before);
            }
        }
    }
    return sudden;
}

/* Of a quantity as far as time has been looked at: largest size, rate and jump of the rate, and the
 * rate at last. */
typedef struct change {
    double size, rate, kink, last;
} change;

/* From one time to another, by samples within. */
static void look_between(quantity q, double s, double from, double to, change *found)
{
    enum { SAMPLES = 64 };
    double step = (to - from) / SAMPLES, before = quantity_value(q, s, from + 0.5 * step);
    found->size = fmax(found->size, fabs(before));
    for (int i = 1; i < SAMPLES; i++) {
        double value = quantity_value(q, s, from + (i + 0.5) * step),
               rate = (value - before) / step;
        found->size = fmax(found->size, fabs(value));
        found->rate = fmax(found->rate, fabs(rate));
        found->kink = i == 1 ? fmax(found->kink, fabs(rate - found->last)) : found->kink;
        found->last = rate;
        before = value;
    }
}

/* At places along its part of the rod where it depends on s. */
static double rise_of(const scene *rod_scene, const scene_field *field, const scene_panels *panels)
{
    enum { PLACES = 5 };
    /* kinks; no kinks, of the rate; what moves the rod as a whole excites its waves less */
    static const double SHARPER = 3, ROUNDED = 0.25, ALL_ALONG = 4;
    const quantity *q = scene_field_of(rod_scene, field);
    const bool held = field->rule == SCENE_HELD; /* the rod moves with it from the start */
    double from = 0, to = scene_length(rod_scene);
    change found = {0};
    scene_field_span(rod_scene, field, &from, &to);
    for (int k = 0; k < field->count; k++) {
        const int places = !q[k].is_given ? 0 : quantity_depends_on(q[k], "s") ? PLACES : 1;
        for (int i = 0; i < places; i++) {
            found.last = held ? NAN : 0;
            for (int p = 0; p < panels->count; p++) {
                look_between(q[k], from + (to - from) * (i + 0.5) / places, panels->edges[p],
                             panels->edges[p + 1], &found);
            }
        }
    }
    const double kink = found.kink > ROUNDED * found.rate ? SHARPER * found.kink : 0;
    const double rate = fmax(found.rate, kink);
    const double local = held || acts_at_place(field) ? 1 : ALL_ALONG;
    return rate > 0 ? local * found.size / rate : INFINITY;
}

ad_status scene_rise_time(const scene *rod_scene, double *rise, ad_error *error)
{
    scene_panels panels;
    ad_status status = scene_panels_of(rod_scene, "t", &panels, error);
    *rise = INFINITY;
    for (int i = 0; i < scene_field_count && status == AD_OK; i++) {
        const scene_field *field = &scene_fields[i];
        if (quantity_any_depends_on(field->count, scene_field_of(rod_scene, field), "t")) {
            *rise = fmin(*rise, rise_of(rod_scene, field, &panels));
        }
    }
    if (status == AD_OK) {
        scene_panels_free(&panels);
    }
    return status;
}
