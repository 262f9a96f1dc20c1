/* cpinn-show: what a robot consists of in a picture. */
#include "tools/programs/section_size.h"
#include "tools/programs/show.h"
#include "tools/programs/show_pose.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { DISCS = 10 };

typedef struct robot {
    picture *p;
    const show_shapes *x;
    const show_look *look;
    const picture_ring *rings;
    const double *arc;
    const double *member;
    double frame, t;
} robot;

static double value(const robot *r, quantity q, double s)
{
    return show_value(r->x->of, r->member, q, s, r->t);
}

/* The ring at an arc length, between those there are. */
static picture_ring ring_at(const robot *r, double s)
{
    size_t k = 0;
    while (k + 2 < r->x->count && r->arc[k + 1] < s) {
        k++;
    }
    picture_ring ring = r->rings[k];
    if (r->x->count > 1) {
        const picture_ring *next = &r->rings[k + 1];
        const double part = fmin(1, fmax(0, (s - r->arc[k]) / (r->arc[k + 1] - r->arc[k])));
        for (int i = 0; i < 3; i++) {
            ring.place[i] += part * (next->place[i] - ring.place[i]);
        }
        if (part > 0.5) {
            memcpy(ring.director, next->director, sizeof ring.director);
        }
    }
    return ring;
}

/* ---- rod, ends, bodies --------------------------------------------------------------------- */

static void draw_plate(const robot *r, const picture_ring *at, double sign, double radius,
                       double thick, picture_colour colour)
{
    const picture_paint paint = {colour, 1, true};
    picture_ring ends[2] = {*at, *at};
    for (int e = 0; e < 2; e++) {
        ends[e].half[0] = ends[e].half[1] = radius;
        for (int k = 0; k < 3; k++) {
            ends[e].place[k] += (sign < 0   ? e - 1
                                 : sign > 0 ? e
                                            : e - 0.5) *
                                thick * at->director[2][k];
        }
    }
    picture_tube(r->p, ends, 2, 2 * r->look->sides, false, &paint);
}

/* From the axis to the furthest tendon; 0 where all are within the rod. */
static double guides_of(const show_shapes *shapes)
{
    double most = 0;
    for (int i = 0; shapes->of && i < shapes->of->tendon_count; i++) {
        const scene_tendon *tendon = &shapes->of->tendons[i];
        const double *member = show_member(shapes, 0);
        most = fmax(most, hypot(show_value(shapes->of, member, tendon->offset[0], 0, 0),
                                show_value(shapes->of, member, tendon->offset[1], 0, 0)));
    }
    return most > shapes->radius ? most : 0;
}

static void draw_end(const robot *r, scene_end_type type, size_t k, double sign)
{
    const picture_ring *at = &r->rings[k];
    const double half = fmax(at->half[0], at->half[1]);
    const double guides = 1.35 * guides_of(r->x);
    const picture_paint paint = {picture_rgb("565e69"), 1, true};
    if (type == SCENE_PINNED || type == SCENE_ROLLER) {
        picture_ball(r->p, at->place, 1.6 * half, &paint);
    } else if (scene_end_holds_rotation(type)) {
        const double wide = fmax(guides, fmin(1.7 * half, half + 0.05 * r->x->size));
        draw_plate(r, at, sign, wide, 0.028 * r->x->size, paint.colour);
    }
}

/* A round tube from s = 0 to an end. */
static void draw_tube(const robot *r, double end, quantity radius, picture_colour colour)
{
    enum { MOST = 256 };
    const picture_paint paint = {colour, 1, true};
    picture_ring rings[MOST];
    size_t count = 0;
    while (count < r->x->count && count < MOST - 1 && r->arc[count] < end) {
        rings[count] = r->rings[count];
        count++;
    }
    rings[count++] = ring_at(r, end);
    for (size_t k = 0; k < count; k++) {
        rings[k].half[0] = rings[k].half[1] =
            r->x->thicker * value(r, radius, fmin(end, r->arc[k]));
    }
    picture_tube(r->p, rings, count, r->look->sides, false, &paint);
}

static void draw_rod(const robot *r)
{
    static const char *const metals[] = {"d8a23a", "c96f4a", "7aa870"};
    const scene *of = r->x->of;
    const bool guided =
        of && (of->chamber_count > 0 || (of->tendon_count > 0 && guides_of(r->x) == 0));
    const bool inside = guided && r->look->ends;
    const picture_colour light = {0.55F * r->look->tube.red + 0.45F,
                                  0.55F * r->look->tube.green + 0.45F,
                                  0.55F * r->look->tube.blue + 0.45F};
    const picture_paint paint = {inside ? light : r->look->tube, inside ? 0.34F : r->look->opacity,
                                 true};
    const bool rectangle = of && scene_piece_of(of, 0).rod.section == SCENE_RECTANGLE;
    for (size_t k = 0; k + 1 < r->x->count && r->x->left; k++) { /* by how far each piece is */
        const double left = fmin(show_left(r->x, r->frame, k), show_left(r->x, r->frame, k + 1));
        picture_paint near = paint;
        near.colour = show_nearness((left - r->x->least) / (r->x->most - r->x->least));
        picture_tube(r->p, r->rings + k, 2, r->look->sides, rectangle, &near);
    }
    if (r->x->left) {
        return;
    }
    if (!of || of->tube_count == 0) {
        picture_tube(r->p, r->rings, r->x->count, r->look->sides, rectangle, &paint);
        return;
    }
    draw_tube(r, scene_length(of), scene_piece_of(of, 0).rod.radius, r->look->tube);
    for (int i = 0; i < of->tube_count; i++) {
        draw_tube(r, scene_tube_end(of, i), of->tubes[i].rod.radius, picture_rgb(metals[i % 3]));
    }
}

static void draw_bodies(const robot *r)
{
    const scene *of = r->x->of;
    const picture_paint paint = {picture_rgb("4a505a"), 1, true};
    for (int i = 0; i < of->body_count; i++) {
        const double s = value(r, of->bodies[i].at, 0);
        picture_ball(r->p, ring_at(r, s).place, section_ball(of, s), &paint);
    }
}

/* ---- actuators ----------------------------------------------------------------------------- */

double show_room(const show_shapes *shapes)
{
    const bool loaded = shapes->of && shapes->members &&
                        scene_end_takes_force(shapes->of->end.type) &&
                        quantity_any_something(3, shapes->of->loads.tip.force);
    return fmax(loaded ? 0.8 * SHOW_ARROW * shapes->size : shapes->radius, 1.3 * guides_of(shapes));
}

static void draw_guided(const robot *r, const scene_actuator *one, double radius,
                        picture_colour colour)
{
    enum { MOST = 256 };
    double places[MOST][3];
    size_t count = 0;
    const picture_paint paint = {colour, 1, false};
    for (size_t k = 0; k < r->x->count + 2 && count < MOST; k++) { /* its ends, and between */
        const double s = k == 0 ? one->from : k > r->x->count ? one->to : r->arc[k - 1];
        if (k > 0 && k <= r->x->count && (s <= one->from || s >= one->to)) {
            continue;
        }
        const picture_ring at = ring_at(r, s);
        for (int i = 0; i < 3; i++) {
            places[count][i] = at.place[i] + value(r, one->offset[0], s) * at.director[0][i] +
                               value(r, one->offset[1], s) * at.director[1][i];
        }
        count++;
    }
    picture_thread(r->p, places[0], count, radius, &paint);
}

static double strongest(const robot *r, bool chambers)
{
    double most = 0;
    for (int i = 0; i < scene_actuator_count(r->x->of); i++) {
        const scene_actuator one = scene_actuator_of(r->x->of, i);
        most = !one.tendon == chambers ? fmax(most, value(r, one.given, 0)) : most;
    }
    return most;
}

static picture_colour strength(const char *const hex[2], double acts, double most)
{
    return picture_between(hex, 2, most > 0 ? 0.15 + 0.85 * fmax(acts, 0) / most : 0.6);
}

static const char *const tendon_colours[] = {"d9c7a8", "e8590c"};
static const char *const chamber_colours[] = {"9fc4d8", "e8590c"};

static void draw_actuators(const robot *r)
{
    const double most[2] = {strongest(r, false), strongest(r, true)};
    for (int i = 0; i < scene_actuator_count(r->x->of); i++) {
        const scene_actuator one = scene_actuator_of(r->x->of, i);
        const bool chamber = !one.tendon;
        draw_guided(r, &one, chamber ? 0.24 * r->x->radius : 0.0034 * r->x->size,
                    strength(chamber ? chamber_colours : tendon_colours, value(r, one.given, 0),
                             most[chamber]));
    }
}

/* Discs that guide tendons which run outside of the rod. */
static void draw_discs(const robot *r)
{
    const double guides = guides_of(r->x), length = scene_length(r->x->of);
    const picture_colour grey = picture_rgb("cdd3db"), rod = r->look->tube;
    const picture_colour disc = {0.7F * grey.red + 0.3F * rod.red,
                                 0.7F * grey.green + 0.3F * rod.green,
                                 0.7F * grey.blue + 0.3F * rod.blue};
    for (int i = 1; i <= DISCS && guides > 0; i++) {
        const picture_ring at = ring_at(r, length * i / DISCS);
        draw_plate(r, &at, i == DISCS ? -1 : 0, 1.22 * guides, 0.011 * r->x->size, disc);
    }
}

/* ---- loads --------------------------------------------------------------------------------- */

static double vector_at(const robot *r, const scene_load *load, const quantity vector[3],
                        const picture_ring *at, double s, double result[3])
{
    double size = 0, local[3];
    for (int k = 0; k < 3; k++) {
        local[k] = value(r, vector[k], s);
        size = hypot(size, local[k]);
    }
    for (int k = 0; k < 3; k++) {
        result[k] = load->frame == SCENE_FOLLOWER
                        ? local[0] * at->director[0][k] + local[1] * at->director[1][k] +
                              local[2] * at->director[2][k]
                        : local[k];
    }
    return size;
}

/* Force and moment at a place, as arrows of a fixed length with their sizes. */
static void draw_load(const robot *r, const scene_load *load, double s)
{
    const picture_ring at = ring_at(r, s);
    for (int kind = 0; kind < 2; kind++) {
        double vector[3], seen[3], head[3];
        char text[40];
        const double size = vector_at(r, load, kind ? load->moment : load->force, &at, s, vector);
        if (!(size > 0)) {
            continue;
        }
        for (int k = 0; k < 3; k++) {
            vector[k] *= SHOW_ARROW * r->x->size / size;
            head[k] = at.place[k] + vector[k];
        }
        const picture_paint paint = {picture_rgb(kind ? "7a4fb0" : "c92a2a"), 1, true};
        picture_arrow(r->p, at.place, vector, 0.005 * r->x->size, kind ? 2 : 1, &paint);
        show_with_unit(size, kind ? "N m" : "N", 3, text, sizeof text);
        picture_project(r->p, head, seen);
        if (!r->x->members) { /* many would be in each other's way */
            picture_text(r->p, seen[0] + 8, seen[1] - 6, 15, PICTURE_LEFT, paint.colour, text);
        }
    }
}

static void draw_loads(const robot *r)
{
    const scene *of = r->x->of;
    if (scene_end_takes_force(of->end.type)) {
        draw_load(r, &of->loads.tip, scene_length(of));
    }
    for (int i = 0; i < of->point_count; i++) {
        draw_load(r, &of->points[i].load, value(r, of->points[i].at, 0));
    }
}

void show_robot(picture *p, const show_shapes *shapes, double frame, const show_look *look,
                picture_ring *rings, double *arc)
{
    const robot r = {
        p, shapes, look, rings, arc, show_member(shapes, frame), frame, show_time(shapes, frame)};
    show_pose(shapes, frame, rings, arc);
    draw_rod(&r);
    if (shapes->of && !shapes->deflection && look->ends) {
        draw_end(&r, shapes->of->start.type, 0, -1);
        draw_end(&r, shapes->of->end.type, shapes->count - 1, 1);
        draw_bodies(&r);
        draw_discs(&r);
        draw_actuators(&r);
        draw_loads(&r);
    }
}

/* ---- words --------------------------------------------------------------------------------- */

static void write_kind(const robot *r, bool chambers, double y)
{
    char text[200] = "", part[40];
    const scene *of = r->x->of;
    int count = 0;
    for (int i = 0; i < scene_actuator_count(of); i++) {
        const scene_actuator one = scene_actuator_of(of, i);
        if (!one.tendon != chambers) {
            continue;
        }
        const bool is_force = chambers && value(r, one.chamber->area, 0) == 1;
        const size_t used = strlen(text);
        show_with_unit(value(r, one.given, 0), is_force ? "N" : one.unit, 3, part, sizeof part);
        snprintf(text + used, sizeof text - used, "%s%s", count++ > 0 ? ", " : "", part);
    }
    const double line[2][2] = {{24, y - 5}, {48, y - 5}};
    picture_line(r->p, line[0], 2, 5,
                 picture_rgb(chambers ? chamber_colours[1] : tendon_colours[1]));
    char words[260];
    snprintf(words, sizeof words, "%s%s %s", chambers ? "chamber" : "tendon", count > 1 ? "s" : "",
             text);
    picture_text(r->p, 58, y, 15, PICTURE_LEFT, picture_rgb("343a46"), words);
}

void show_actuation(picture *p, const show_shapes *shapes, double frame, double y)
{
    const robot r = {
        .p = p, .x = shapes, .member = show_member(shapes, frame), .t = show_time(shapes, frame)};
    if (shapes->of && shapes->of->tendon_count > 0) {
        write_kind(&r, false, y);
        y += 24;
    }
    if (shapes->of && shapes->of->chamber_count > 0) {
        write_kind(&r, true, y);
    }
}

double show_round(double size)
{
    const double power = pow(10, floor(log10(size))), digit = size / power;
    return power * (digit < 1.5 ? 1 : digit < 3.5 ? 2 : digit < 7.5 ? 5 : 10);
}

void show_with_unit(double value, const char *unit, int digits, char *text, size_t size)
{
    static const struct {
        const char *prefix;
        double factor;
    } rows[] = {{"G", 1e9},         {"M", 1e6},  {"k", 1e3},   {"", 1},     {"m", 1e-3},
                {"\302\265", 1e-6}, {"n", 1e-9}, {"p", 1e-12}, {"f", 1e-15}};
    const size_t count = sizeof rows / sizeof *rows;
    value = fabs(value) < rows[count - 1].factor ? 0 : value; /* what rounding leaves */
    size_t row = strcmp(unit, "m") == 0 || strcmp(unit, "s") == 0 ? 3 : 0; /* no kilometres */
    while (row + 1 < count && fabs(value) < 0.9999 * rows[row].factor) {
        row++;
    }
    row = value == 0 ? 3 : row;
    snprintf(text, size, "%.*g %s%s", digits, value / rows[row].factor, rows[row].prefix, unit);
}
