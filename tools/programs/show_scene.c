/* What a scene says beside the motion of its rod, as data of a page: sections, ends, loads and
 * actuators. */
#include "tools/programs/section_size.h"
#include "tools/programs/show.h"

#include <math.h>
#include <stdlib.h>

/* A scene at each kept instant. */
typedef struct drawn {
    json *to;
    const scene *of;
    const double *values; /* of a family: [frames of the table][parameter_count] */
    const show_kept *kept;
    show_drawn *live; /* NULL: all is known */
    double *numbers;  /* [3][frames] */
    double *along;    /* [points] */
} drawn;

double show_value(const scene *of, const double *member, quantity q, double s, double t)
{
    const char *names[SCENE_PARAMETERS_MAX];
    for (int i = 0; i < of->parameter_count; i++) {
        names[i] = of->parameters[i].name;
    }
    return !q.is_given
               ? 0
               : quantity_value(member ? quantity_with(q, of->parameter_count, names, member) : q,
                                s, t);
}

static double value_at(const drawn *drawn, quantity q, double s, size_t frame)
{
    const size_t count = (size_t)drawn->of->parameter_count;
    return show_value(drawn->of,
                      drawn->values ? drawn->values + drawn->kept->frame[frame] * count : NULL, q,
                      s, drawn->kept->t[frame]);
}

static void add_live(const drawn *drawn, const char *name, const char *unit, quantity q, double s)
{
    show_drawn *live = drawn->live;
    const int room = live->room > 0 ? 2 * live->room : 64;
    export_drawn *list = live->count < live->room
                             ? live->list
                             : realloc(live->list, (size_t)room * sizeof *live->list);
    live->room = list && live->count == live->room ? room : live->room;
    live->list = list ? list : live->list;
    json_open(drawn->to, NULL, '{');
    json_text(drawn->to, "name", name);
    json_text(drawn->to, "unit", unit);
    json_integer(drawn->to, "live", live->count);
    json_close(drawn->to, '}');
    if (live->count < live->room) {
        live->list[live->count] = (export_drawn){.of = q, .s = s};
    }
    live->count++;
}

/* At all instants. */
static void put_over_time(const drawn *drawn, const char *name, const char *unit, quantity q,
                          double s)
{
    if (drawn->live && q.is_given && q.node) {
        add_live(drawn, name, unit, q, s);
        return;
    }
    for (size_t i = 0; i < drawn->kept->frames; i++) {
        drawn->numbers[i] = value_at(drawn, q, s, i);
    }
    show_column(drawn->to, name, unit, drawn->numbers, drawn->kept->frames, false);
}

static void put_along(const drawn *drawn, const char *name, quantity q, double scale)
{
    for (size_t i = 0; i < drawn->kept->points; i++) {
        drawn->along[i] = scale * value_at(drawn, q, drawn->kept->s[i], 0);
    }
    show_column(drawn->to, name, "m", drawn->along, drawn->kept->points, false);
}

/* ---- the rod ------------------------------------------------------------------------------- */

/* One of several that lie in one another, from s = 0 on. */
static void put_tube(const drawn *drawn, double end, quantity radius)
{
    json_open(drawn->to, NULL, '{');
    json_number(drawn->to, "end", end);
    json_open(drawn->to, "radius", '[');
    put_along(drawn, "radius", radius, 1);
    json_close(drawn->to, ']');
    json_close(drawn->to, '}');
}

static void put_section(const drawn *drawn)
{
    const scene_piece piece = scene_piece_of(drawn->of, 0);
    json_text(drawn->to, "section", scene_section_names()[piece.rod.section]);
    json_open(drawn->to, "tubes", '[');
    for (int i = 0; i < drawn->of->tube_count; i++) {
        if (i == 0) {
            put_tube(drawn, scene_length(drawn->of), piece.rod.radius);
        }
        put_tube(drawn, scene_tube_end(drawn->of, i), drawn->of->tubes[i].rod.radius);
    }
    json_close(drawn->to, ']');
    json_open(drawn->to, "half", '[');
    for (int k = 0; k < 2; k++) {
        for (size_t i = 0; i < drawn->kept->points; i++) {
            drawn->along[i] = section_half(drawn->of, drawn->kept->s[i], k == 1);
        }
        show_column(drawn->to, k ? "height" : "width", "m", drawn->along, drawn->kept->points,
                    false);
    }
    json_close(drawn->to, ']');
}

/* ---- loads --------------------------------------------------------------------------------- */

/* An arrow at a place; nothing where it is never anything. */
static void put_arrow(const drawn *drawn, const char *name, const char *unit, double s,
                      const quantity vector[3], scene_frame frame)
{
    if (!quantity_any_something(3, vector)) {
        return;
    }
    json_open(drawn->to, NULL, '{');
    json_text(drawn->to, "name", name);
    json_text(drawn->to, "unit", unit);
    json_number(drawn->to, "s", s);
    json_text(drawn->to, "frame", scene_frame_names()[frame]);
    json_open(drawn->to, "vector", '[');
    for (int k = 0; k < 3; k++) {
        put_over_time(drawn, "", unit, vector[k], s);
    }
    json_close(drawn->to, ']');
    json_close(drawn->to, '}');
}

static void put_load(const drawn *drawn, const char *name, double s, const scene_load *load)
{
    put_arrow(drawn, name, "N", s, load->force, load->frame);
    put_arrow(drawn, name, "N m", s, load->moment, load->frame);
}

static void put_loads(const drawn *drawn)
{
    enum { PLACES = 11 };
    const scene *of = drawn->of;
    const double length = scene_length(of);
    json_open(drawn->to, "arrows", '[');
    if (scene_end_takes_force(of->start.type)) {
        put_load(drawn, "base", 0, &of->loads.base);
    }
    if (scene_end_takes_force(of->end.type)) {
        put_load(drawn, "tip", length, &of->loads.tip);
    }
    for (int i = 0; i < of->point_count; i++) {
        put_load(drawn, "point", value_at(drawn, of->points[i].at, 0, 0), &of->points[i].load);
    }
    for (int i = 0; i < PLACES; i++) {
        const double s = length * i / (PLACES - 1);
        put_arrow(drawn, "line load", "N/m", s, of->loads.force, of->loads.frame);
        put_arrow(drawn, "line moment", "N m/m", s, of->loads.moment, of->loads.frame);
    }
    json_close(drawn->to, ']');
}

/* ---- actuators and bodies ------------------------------------------------------------------ */

/* A line along the rod at a body offset, and what acts in it. */
static void put_guided(const drawn *drawn, const scene_actuator *one)
{
    json_open(drawn->to, NULL, '{');
    json_text(drawn->to, "kind", one->name);
    json_number(drawn->to, "start", one->from);
    json_number(drawn->to, "end", one->to);
    json_open(drawn->to, "offset", '[');
    put_along(drawn, "d1", one->offset[0], 1);
    put_along(drawn, "d2", one->offset[1], 1);
    json_close(drawn->to, ']');
    json_open(drawn->to, "acts", '[');
    const bool is_force = !one->tendon && value_at(drawn, one->chamber->area, 0, 0) == 1;
    put_over_time(drawn, one->name, is_force ? "N" : one->unit, one->given, 0);
    json_close(drawn->to, ']');
    json_close(drawn->to, '}');
}

static void put_actuators(const drawn *drawn)
{
    json_open(drawn->to, "guided", '[');
    for (int i = 0; i < scene_actuator_count(drawn->of); i++) {
        const scene_actuator one = scene_actuator_of(drawn->of, i);
        put_guided(drawn, &one);
    }
    json_close(drawn->to, ']');
    json_open(drawn->to, "bodies", '[');
    for (int i = 0; i < drawn->of->body_count; i++) {
        json_open(drawn->to, NULL, '{');
        const double s = value_at(drawn, drawn->of->bodies[i].at, 0, 0);
        json_number(drawn->to, "s", s);
        json_number(drawn->to, "radius", section_ball(drawn->of, s));
        json_number(drawn->to, "mass", value_at(drawn, drawn->of->bodies[i].mass, 0, 0));
        json_close(drawn->to, '}');
    }
    json_close(drawn->to, ']');
}

ad_status show_scene(json *to, const scene *of, const double *values, const show_kept *kept,
                     show_drawn *live, ad_error *error)
{
    if (kept->frames == 0) {
        return AD_OK; /* a picture, no page */
    }
    drawn x = {.to = to, .of = of, .values = values, .kept = kept, .live = live};
    x.numbers = malloc((kept->frames + kept->points) * sizeof *x.numbers + 1);
    if (!x.numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
    }
    x.along = x.numbers + kept->frames;
    json_open(to, "scene", '{');
    json_text(to, "model", scene_model_names()[of->rod.model]);
    json_number(to, "length", scene_length(of));
    json_number(to, "duration", scene_duration(of));
    json_text(to, "start", scene_end_names()[of->start.type]);
    json_text(to, "end", scene_end_names()[of->end.type]);
    put_section(&x);
    json_open(to, "gravity", '[');
    for (int k = 0; k < 3; k++) {
        json_number(to, NULL, value_at(&x, of->loads.gravity[k], 0, 0));
    }
    json_close(to, ']');
    put_loads(&x);
    put_actuators(&x);
    json_close(to, '}');
    free(x.numbers);
    return !live || live->count <= live->room
               ? AD_OK
               : ad_fail(error, AD_NO_MEMORY, "out of memory for a report");
}
