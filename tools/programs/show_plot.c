/* cpinn-show: shapes as pictures, .svg and .png of some instants, .gif, .mp4 and .webm of all. */
#include "tools/files/file_bytes.h"
#include "tools/picture/images.h"
#include "tools/programs/picture_file.h"
#include "tools/programs/show_pose.h"
#include "tools/programs/show_source.h"
#include "tools/programs/signals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    INSTANTS = 8,
    FOLLOWED = 6,
    MEMBERS = 9,
    TRAIL = 600,
    GIF_RATE = 20,
    MOVIE_RATE = 30,
    GIF_IMAGES = 1000
};

typedef struct tip {
    const double *place;
    double seen[3], part; /* of the colours */
} tip;

typedef struct drawing {
    show_shapes shapes, other; /* `other`: a reference, where it has frames */
    picture *p;
    picture_ring *rings;
    double *arc;
    const char *const *labels;
    const showing *from;
    tip *tips;    /* [tip_count] of `from` */
    bool flat;    /* of areas: as few of them as will do */
    bool follows; /* a wanted path: earlier instants are seen through */
} drawing;

static const char *const times[] = {"c3d7ee", "7fb0dd", "2f7fc1", "0b4f8a"};
static const char *const kinds[] = {"3b4cc0", "2c8fbd", "27a684", "7fb93c",
                                    "e3b022", "e2711d", "b8232f"};
static const char *const shades[] = {"440154", "3b528b", "21918c", "5ec962", "fde725"};
static const char glass[] = "8a97a8";
static const char ink[] = "343a46", soft[] = "79838f", trail[] = "d6336c", wanted[] = "37b24d";

/* ---- camera -------------------------------------------------------------------------------- */

/* Against gravity, where there is one for all; else z, of what lies in the plane of x and y then
 * y. */
static void up_of(const show_shapes *shapes, double up[3])
{
    double size = 0;
    for (int k = 0; k < 3; k++) {
        const double one = shapes->of ? show_value(shapes->of, show_member(shapes, 0),
                                                   shapes->of->loads.gravity[k], 0, 0)
                                      : 0;
        const double last =
            shapes->of
                ? show_value(shapes->of, show_member(shapes, (double)(shapes->at.frames - 1)),
                             shapes->of->loads.gravity[k], 0, 0)
                : 0;
        up[k] = one == last ? -one : NAN;
        size = hypot(size, up[k]);
    }
    const bool flat = shapes->high[2] - shapes->low[2] < 1e-6 * shapes->size;
    for (int k = 0; k < 3; k++) {
        up[k] = size > 0 ? up[k] / size : k == (flat ? 1 : 2);
    }
}

/* The corners of the box, and every place of some frames with room for the thickness. */
static size_t places_of(const drawing *d, double *places, size_t most)
{
    const show_shapes *shapes = &d->shapes;
    const double room = show_room(shapes);
    size_t count = 0;
    for (size_t i = 0; i < 40; i++) {
        const double frame = (double)(shapes->at.frames - 1) * (double)i / 39;
        for (size_t k = 0; k < shapes->count && count + 70 <= most;
             k += shapes->count > 40 ? 3 : 1) {
            double place[3];
            show_place(shapes, frame, k, place);
            for (int side = 0; side < 6 && isfinite(place[0] + place[1] + place[2]); side++) {
                memcpy(places + 3 * count, place, sizeof place);
                places[3 * count++ + (size_t)(side / 2)] += side % 2 ? room : -room;
            }
        }
    }
    for (size_t i = 0; i < 60 && d->other.at.frames > 0; i++) {
        show_place(&d->other, (double)(d->other.at.frames - 1) * (double)i / 59, d->other.count - 1,
                   places + 3 * count++);
    }
    const surface *const wall = d->from->wall;
    for (size_t i = 0; wall && i < wall->corners && count < most; i += 1 + wall->corners / 500) {
        memcpy(places + 3 * count++, wall->corner + 3 * i, 3 * sizeof *places);
    }
    for (size_t i = 0; i < d->from->tip_count && count < most; i += 10) {
        memcpy(places + 3 * count++, d->from->tips + 4 * i, 3 * sizeof *places);
    }
    return count;
}

/* From the side along which shapes are widest, turned a little. */
static double azimuth_of(const double *places, size_t count, const double centre[3],
                         const double up[3], const double along[3])
{
    double side[3], front[3], a = 0, b = 0, c = 0, ahead[2] = {0, 0};
    picture_level(up, side, front);
    for (size_t i = 0; i < count; i++) {
        double x = 0, y = 0;
        for (int k = 0; k < 3; k++) {
            x += (places[3 * i + (size_t)k] - centre[k]) * side[k];
            y += (places[3 * i + (size_t)k] - centre[k]) * front[k];
        }
        a += x * x;
        b += x * y;
        c += y * y;
    }
    for (int k = 0; k < 3; k++) {
        ahead[0] += along[k] * side[k];
        ahead[1] += along[k] * front[k];
    }
    double azimuth = 0.5 * atan2(2 * b, a - c) + 1.57079632679489662;
    if (-sin(azimuth) * ahead[0] + cos(azimuth) * ahead[1] < 0) { /* to the right */
        azimuth += 3.14159265358979324;
    }
    return azimuth - 0.42;
}

static ad_status place_camera(drawing *d, ad_error *error)
{
    enum { MOST = 12000 };
    const show_shapes *shapes = &d->shapes;
    double *places = malloc(sizeof *places * 3 * MOST), up[3], centre[3], first[3], last[3];
    if (!places) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    size_t count = places_of(d, places, MOST - 400);
    double lowest = INFINITY;
    up_of(shapes, up);
    show_place(shapes, (double)(shapes->at.frames - 1), 0, first);
    show_place(shapes, (double)(shapes->at.frames - 1), shapes->count - 1, last);
    for (int k = 0; k < 3; k++) {
        centre[k] = (shapes->low[k] + shapes->high[k]) / 2;
        last[k] -= first[k];
    }
    picture_look(d->p, centre, up, azimuth_of(places, count, centre, up, last), 0.36);
    for (size_t i = 0; i < count; i++) {
        lowest = fmin(lowest, places[3 * i] * up[0] + places[3 * i + 1] * up[1] +
                                  places[3 * i + 2] * up[2]);
    }
    const double height = lowest - 0.035 * shapes->size, shown = (double)count;
    for (size_t i = 0; i < (size_t)shown && count < MOST; i += 31) { /* and shadows */
        double above = -height;
        for (int k = 0; k < 3; k++) {
            above += places[3 * i + (size_t)k] * up[k];
        }
        for (int k = 0; k < 3; k++) {
            places[3 * count + (size_t)k] = places[3 * i + (size_t)k] - above * up[k];
        }
        count++;
    }
    picture_fit(d->p, count, places, 0.80);
    picture_floor(d->p, height, show_round(shapes->size / 8), 0.95 * shapes->size);
    free(places);
    return AD_OK;
}

/* ---- around the robot ---------------------------------------------------------------------- */

static void draw_axes(picture *p)
{
    static const char *const names[] = {"x", "y", "z"}, *const colours[] = {"d33d38", "2f9e4c",
                                                                            "2b6bd0"};
    const double x = 50, y = picture_height(p) - 50;
    for (int k = 0; k < 3; k++) {
        const double right = picture_axis(p, 0)[k], up = picture_axis(p, 1)[k];
        const double line[2][2] = {{x, y}, {x + 30 * right, y - 30 * up}};
        picture_line(p, line[0], 2, 2.4, picture_rgb(colours[k]));
        picture_text(p, x + 40 * right, y - 40 * up + 5, 15, PICTURE_MIDDLE,
                     picture_rgb(colours[k]), names[k]);
    }
}

static void draw_scale(const drawing *d)
{
    picture *p = d->p;
    const double bar = show_round(120 / picture_scale(p)), wide = bar * picture_scale(p);
    const double right = picture_width(p) - 26, low = picture_height(p) - 30;
    const double line[4][2] = {
        {right - wide, low - 5}, {right - wide, low}, {right, low}, {right, low - 5}};
    char text[64];
    picture_line(p, line[0], 4, 2, picture_rgb(ink));
    show_with_unit(bar, "m", 3, text, sizeof text);
    picture_text(p, right - wide / 2, low - 9, 15, PICTURE_MIDDLE, picture_rgb(ink), text);
    if (d->shapes.enlarged > 1) {
        snprintf(text, sizeof text, "deflections %g times enlarged", d->shapes.enlarged);
        picture_text(p, right, low + 20, 13, PICTURE_RIGHT, picture_rgb(soft), text);
    }
}

static picture_colour colour_of_time(double part)
{
    return picture_between(times, 4, part);
}

static picture_colour colour_of_tip(double part)
{
    return picture_between(shades, 5, part);
}

/* What colours mean: from ends[0] to ends[1]. */
static void draw_bar(picture *p, double left, const char *name, const double ends[2],
                     const char *unit, picture_colour (*colour)(double))
{
    enum { PIECES = 24 };
    const double wide = 150, y = 34;
    char text[40];
    for (int i = 0; i < PIECES; i++) {
        const double line[2][2] = {{left + wide * i / PIECES, y},
                                   {left + wide * (i + 1) / PIECES, y}};
        picture_line(p, line[0], 2, 8, colour((double)i / (PIECES - 1)));
    }
    picture_text(p, left - 14, y + 5, 15, PICTURE_RIGHT, picture_rgb(ink), name);
    for (int k = 0; k < 2; k++) {
        if (strcmp(unit, "m") == 0 || strcmp(unit, "s") == 0) {
            show_with_unit(ends[k], unit, 3, text, sizeof text);
        } else {
            snprintf(text, sizeof text, "%.3g%s%s", ends[k], *unit ? " " : "", unit);
        }
        picture_text(p, left + k * wide, y + 24, 15, k ? PICTURE_RIGHT : PICTURE_LEFT,
                     picture_rgb(ink), text);
    }
}

/* Colours of instants, from the first to the last; or of what is left, from the least on. */
static void draw_colours(const drawing *d)
{
    const show_shapes *const shapes = &d->shapes;
    const double ends[2] = {shapes->left ? shapes->least : show_time(shapes, 0),
                            shapes->left ? shapes->most
                                         : show_time(shapes, (double)(shapes->at.frames - 1))};
    draw_bar(d->p, picture_width(d->p) - 176, shapes->left ? "left" : "", ends,
             shapes->left ? "m" : "s", shapes->left ? show_nearness : colour_of_time);
}

/* Where the last point is, in mm. */
static void write_tip(const drawing *d, double frame)
{
    const show_shapes *shapes = &d->shapes;
    double place[3];
    char text[96];
    show_place(shapes, frame, shapes->count - 1, place);
    for (int k = 0; k < 3; k++) { /* no -0 */
        place[k] = round(1e4 * place[k]) == 0 ? 0 : 1e3 * place[k];
    }
    snprintf(text, sizeof text, "tip (%.1f, %.1f, %.1f) mm", place[0], place[1], place[2]);
    picture_text(d->p, 24, 34, 15, PICTURE_LEFT, picture_rgb(ink), text);
}

/* The way of the last point of shapes, up to a frame. */
static void draw_trail(const drawing *d, const show_shapes *shapes, double until)
{
    double places[TRAIL][3];
    const size_t last = (size_t)until, step = last / (TRAIL - 2) + 1;
    size_t count = 0;
    const picture_paint paint = {picture_rgb(trail), 1, false};
    for (size_t frame = 0; frame <= last && count < TRAIL - 1; frame += step) {
        show_place(shapes, (double)frame, shapes->count - 1, places[count++]);
    }
    show_place(shapes, until, shapes->count - 1, places[count++]);
    picture_thread(d->p, places[0], count, 0.0028 * d->shapes.size, &paint);
}

/* The whole way of the last point of others, dashed. */
static void draw_wanted(const drawing *d)
{
    double places[TRAIL][3], before[3], way = 0;
    const double dash = 0.03 * d->shapes.size;
    const show_shapes *shapes = &d->other;
    const picture_paint paint = {picture_rgb(wanted), 1, false};
    size_t count = 0;
    for (size_t frame = 0; frame < shapes->at.frames; frame++) {
        double step = 0;
        show_place(shapes, (double)frame, shapes->count - 1, places[count]);
        for (int k = 0; k < 3 && frame > 0; k++) {
            step = hypot(step, places[count][k] - before[k]);
        }
        memcpy(before, places[count], sizeof before);
        way += step;
        if (fmod(way, 2 * dash) < dash && count + 1 < TRAIL) {
            count++;
        } else {
            picture_thread(d->p, places[0], count, 0.0042 * d->shapes.size, &paint);
            count = 0;
        }
    }
    picture_thread(d->p, places[0], count, 0.0042 * d->shapes.size, &paint);
}

static int farthest_first(const void *a, const void *b)
{
    const double x = ((const tip *)a)->seen[2], y = ((const tip *)b)->seen[2];
    return (x < y) - (x > y);
}

/* The tips of a workspace. */
static void draw_tips(const drawing *d)
{
    const size_t count = d->from->tip_count;
    for (size_t i = 0; i < count; i++) {
        picture_project(d->p, d->tips[i].place, d->tips[i].seen);
    }
    qsort(d->tips, count, sizeof *d->tips, farthest_first);
    for (size_t i = 0; i < count; i++) {
        const double *seen = d->tips[i].seen;
        const double dot[2][2] = {{seen[0] - 0.1, seen[1]}, {seen[0] + 0.1, seen[1]}};
        picture_line(d->p, dot[0], 2, 4, colour_of_tip(d->tips[i].part));
    }
    if (count > 0) {
        char name[40];
        snprintf(name, sizeof name, "tips: %s", d->from->tips_name);
        draw_bar(d->p, 38 + picture_text_width(15, name), name, d->from->tip_ends,
                 d->from->tips_unit, colour_of_tip);
    }
}

static ad_status take_tips(drawing *d, ad_error *error)
{
    const size_t count = d->from->tip_count;
    const double *ends = d->from->tip_ends, wide = ends[1] - ends[0];
    d->tips = malloc((count + 1) * sizeof *d->tips);
    for (size_t i = 0; i < count && d->tips; i++) {
        const double *from = d->from->tips + 4 * i;
        const double part = wide > 0 ? (from[3] - ends[0]) / wide : 0;
        d->tips[i] = (tip){.place = from, .part = fmin(1, fmax(0, part))};
    }
    return d->tips ? AD_OK : ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
}

static void draw_around(const drawing *d, double frame, bool is_still)
{
    const show_shapes *shapes = &d->shapes;
    const bool moves = shapes->at.t && shapes->at.frames > 1;
    draw_tips(d);
    if (d->from->wall) {
        const picture_paint paint = {picture_rgb(glass), 0.12F, false};
        picture_mesh(d->p, d->from->wall->corner, d->from->wall->triangle, d->from->wall->triangles,
                     &paint);
    }
    if (moves) {
        draw_trail(d, shapes, frame);
    }
    if (d->other.at.frames > 0) {
        draw_wanted(d);
    }
    draw_axes(d->p);
    draw_scale(d);
    if (d->from->tip_count == 0 && (moves || shapes->at.frames == 1)) {
        write_tip(d, frame);
        show_actuation(d->p, shapes, frame, 60);
    }
    if (shapes->left || (moves && is_still)) {
        draw_colours(d);
    } else if (!is_still) {
        char text[48];
        if (shapes->at.t) {
            show_with_unit(show_time(shapes, frame), "s", 3, text, sizeof text);
        }
        picture_text(d->p, picture_width(d->p) - 26, 34, 15, PICTURE_RIGHT, picture_rgb(ink),
                     d->labels      ? d->labels[(size_t)frame]
                     : shapes->at.t ? text
                                    : "");
    }
}

/* ---- stills -------------------------------------------------------------------------------- */

static void draw_robot(const drawing *d, double frame, picture_colour colour, bool is_main)
{
    const bool ghost = d->follows && !is_main;
    const show_look look = {colour, ghost ? 0.2F : 1, is_main, d->flat ? 12 : 24};
    if (d->shapes.count > 1) {
        show_robot(d->p, &d->shapes, frame, &look, d->rings, d->arc);
    } else {
        double place[3];
        const picture_paint paint = {colour, 1, true};
        show_place(&d->shapes, frame, 0, place);
        picture_ball(d->p, place, 0.02 * d->shapes.size, &paint);
    }
}

/* Whether the last point of a frame is where that of one already drawn is, or of the last. */
static bool is_hidden(const drawing *d, double frame, const double *drawn, size_t count)
{
    const show_shapes *shapes = &d->shapes;
    double place[3], other[3];
    show_place(shapes, frame, shapes->count - 1, place);
    for (size_t i = 0; i <= count; i++) {
        double apart = 0;
        show_place(shapes, i < count ? drawn[i] : (double)(shapes->at.frames - 1),
                   shapes->count - 1, other);
        for (int k = 0; k < 3; k++) {
            apart = hypot(apart, place[k] - other[k]);
        }
        if (apart < 2.2 * shapes->radius) {
            return true;
        }
    }
    return false;
}

static void draw_still(const drawing *d)
{
    const show_shapes *shapes = &d->shapes;
    const size_t frames = shapes->at.frames, most = d->follows     ? FOLLOWED
                                                    : shapes->at.t ? INSTANTS
                                                                   : MEMBERS;
    const size_t count = frames < most ? frames : most;
    double drawn[INSTANTS + MEMBERS];
    size_t done = 0;
    for (size_t i = 0; i < count; i++) {
        const double part = count > 1 ? (double)i / (double)(count - 1) : 1;
        const double frame = floor(part * (double)(frames - 1));
        const picture_colour colour = shapes->at.t || count == 1
                                          ? picture_between(times, 4, count > 1 ? part : 0.75)
                                          : picture_between(kinds, 7, part);
        if (i + 1 == count || !is_hidden(d, frame, drawn, done)) {
            draw_robot(d, frame, colour, i + 1 == count || (!shapes->at.t && !d->flat));
            drawn[done++] = frame;
        }
    }
    draw_around(d, (double)(frames - 1), true);
}

/* ---- movies -------------------------------------------------------------------------------- */

typedef struct film {
    const drawing *of;
    double seconds; /* of the film */
    int rate;       /* images a second */
    size_t images;
    unsigned char *rgb;
} film;

static ad_status draw_image(const film *f, size_t number, ad_error *error)
{
    const drawing *d = f->of;
    const show_shapes *shapes = &d->shapes;
    const double part = f->images > 1 ? (double)number / (double)(f->images - 1) : 0;
    double frame = part * (double)(shapes->at.frames - 1);
    if (shapes->at.t) { /* frames need not be evenly spaced in time */
        const size_t last = shapes->at.frames - 1;
        const double from = show_time(shapes, 0),
                     t = from + part * (show_time(shapes, (double)last) - from);
        size_t k = 0;
        while (k + 1 < last && show_time(shapes, (double)k + 1) < t) {
            k++;
        }
        const double a = show_time(shapes, (double)k), b = show_time(shapes, (double)k + 1);
        frame = (double)k + (b > a ? fmin(1, fmax(0, (t - a) / (b - a))) : 0);
    } else {
        frame = floor(frame + 0.5);
    }
    picture_clear(d->p);
    ad_status status = place_camera((drawing *)d, error);
    if (status != AD_OK) {
        return status;
    }
    draw_robot(d, frame, picture_between(times, 4, 0.75), true);
    draw_around(d, frame, false);
    return picture_pixels(d->p, 2, f->rgb, error);
}

static ad_status interrupted(ad_error *error)
{
    return signals_caught() ? ad_fail(error, AD_IO, "stopped by a signal") : AD_OK;
}

static ad_status write_movie(const film *f, const char *path, ad_error *error)
{
    image_movie *movie = NULL;
    ad_status status = image_movie_begin(path, picture_width(f->of->p), picture_height(f->of->p),
                                         f->rate, &movie, error);
    for (size_t k = 0; status == AD_OK && k < f->images; k++) {
        status = draw_image(f, k, error);
        status = status == AD_OK ? interrupted(error) : status;
        status = status == AD_OK ? image_movie_add(movie, f->rgb, error) : status;
    }
    status = status == AD_OK ? image_movie_end(movie, error) : status;
    image_movie_free(movie);
    return status;
}

/* As long as the motion, `slow` times; members of a family eight seconds. */
static ad_status write_film(const drawing *d, const char *path, bool is_gif, double slow,
                            ad_error *error)
{
    enum { MEMBERS_SECONDS = 8 };
    const show_shapes *shapes = &d->shapes;
    film f = {.of = d, .rate = is_gif ? GIF_RATE : MOVIE_RATE};
    f.seconds =
        shapes->at.t
            ? slow * (show_time(shapes, (double)(shapes->at.frames - 1)) - show_time(shapes, 0))
            : slow * MEMBERS_SECONDS;
    if (shapes->at.frames < 2 || !(f.seconds > 0)) {
        return ad_fail(error, AD_BAD_INPUT, "nothing moves; allowed: .svg, .png");
    }
    if (f.seconds * f.rate > (is_gif ? GIF_IMAGES : 1e6)) {
        return ad_fail(error, AD_BAD_INPUT,
                       "%g s are too long for %s; allowed: up to %g, by --slow", f.seconds,
                       is_gif ? "a .gif" : "a movie", (is_gif ? GIF_IMAGES : 1e6) / f.rate);
    }
    f.images = (size_t)lround(f.seconds * f.rate) + 1;
    f.rgb = malloc(3 * (size_t)picture_width(d->p) * (size_t)picture_height(d->p));
    if (!f.rgb) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    signals_catch();
    ad_status status = write_movie(&f, path, error);
    free(f.rgb);
    return status;
}

/* ---- all ----------------------------------------------------------------------------------- */

static const char *const endings[] = {".svg", ".png", ".gif", ".mp4", ".webm"};

/* Which of the endings; -1: none. */
static int ending_of(const char *path)
{
    const char *dot = path ? strrchr(path, '.') : NULL;
    for (int k = 0; dot && k < 5; k++) {
        if (strcmp(dot, endings[k]) == 0) {
            return k;
        }
    }
    return -1;
}

bool show_is_plot(const char *path)
{
    return ending_of(path) >= 0;
}

ad_status show_plot(const showing *from, const table_source *table, const char *const *labels,
                    const table_source *other, ad_error *error)
{
    static const int sizes[][2] = {{960, 640}, {960, 640}, {720, 480}, {1280, 720}, {1280, 720}};
    const int kind = ending_of(from->out);
    drawing d = {
        .labels = labels, .from = from, .flat = kind == 0, .follows = from->wanted != NULL};
    ad_error unused;
    ad_status status =
        show_shapes_create(table, from->of, from->members, d.flat ? 33 : 121, &d.shapes, error);
    if (status != AD_OK) {
        return status;
    }
    other = from->wanted ? from->wanted : from->reference_path ? other : NULL;
    if (other && show_shapes_create(other, NULL, NULL, 2, &d.other, &unused) != AD_OK) {
        d.other.at.frames = 0;
    }
    d.p = picture_create(sizes[kind][0], sizes[kind][1]);
    d.rings = malloc(d.shapes.count * sizeof *d.rings);
    d.arc = malloc(d.shapes.count * sizeof *d.arc);
    status = d.p && d.rings && d.arc ? place_camera(&d, error)
                                     : ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    status = status == AD_OK ? take_tips(&d, error) : status;
    if (status == AD_OK && kind >= 2) {
        status = write_film(&d, from->out, kind == 2, from->slow, error);
    } else if (status == AD_OK) {
        draw_still(&d);
        status = picture_file_write(d.p, from->out, error);
    }
    picture_free(d.p);
    free(d.rings);
    free(d.arc);
    free(d.tips);
    return status;
}
