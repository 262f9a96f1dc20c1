#include "tools/programs/equation_picture.h"

#include "tools/picture/picture.h"
#include "tools/programs/picture_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 840, HEIGHT = 520, LEFT = 90, RIGHT = 730, TOP = 50, BOTTOM = 450 };
enum { ACROSS = 401, CURVES = 6, CELLS_ACROSS = 128, CELLS_DOWN = 80 };

/* From early to late, from low to high. */
static const char *const colours[] = {"30123b", "4669db", "1ae4b6", "a4fc3c", "faba39", "7a0403"};
enum { COLOURS = 6 };

typedef struct drawing {
    const cpinn_fit *fit;
    const domain *d;
    picture *p;
    int across, other; /* coordinates; other -1: there is one alone */
    size_t points, lines;
    double *x[DOMAIN_COORDINATES_MAX], *values; /* [lines][points] */
    double low, high;                           /* of the values */
} drawing;

static double part(double value, double low, double high)
{
    return high > low ? (value - low) / (high - low) : 0.5;
}

/* Along the first coordinate that is not time; against time if there is, else against a second. */
static void choose(drawing *w)
{
    const int time = w->d->time;
    w->across = time == 0 && w->d->count > 1 ? 1 : 0;
    w->other = w->d->count < 2 ? -1 : time >= 0 ? time : w->across == 0 ? 1 : 0;
    const bool map = w->other >= 0 && w->other != time;
    w->points = map ? CELLS_ACROSS : ACROSS;
    w->lines = map ? CELLS_DOWN : w->other < 0 ? 1 : CURVES;
}

static double at_part(const domain_coordinate *c, size_t k, size_t count)
{
    return count > 1 ? c->low + (c->high - c->low) * (double)k / (double)(count - 1) : c->high;
}

static ad_status evaluate(drawing *w, ad_error *error)
{
    const size_t all = w->points * w->lines, coordinates = (size_t)w->d->count;
    double *numbers = malloc((coordinates + 1) * all * sizeof *numbers);
    if (!numbers) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    for (size_t c = 0; c < coordinates; c++) {
        const domain_coordinate *of = &w->d->coordinates[c];
        w->x[c] = numbers + c * all;
        for (size_t k = 0; k < all; k++) {
            w->x[c][k] = (int)c == w->across    ? at_part(of, k % w->points, w->points)
                         : (int)c == w->other   ? at_part(of, k / w->points, w->lines)
                         : (int)c == w->d->time ? of->high
                                                : of->low + (of->high - of->low) / 2;
        }
    }
    w->values = numbers + coordinates * all;
    ad_status status = cpinn_fit_evaluate(w->fit, cpinn_fit_model(w->fit)->symbols[0], all,
                                          (const double *const *)w->x, w->values, NULL, error);
    w->low = INFINITY;
    w->high = -INFINITY;
    for (size_t k = 0; k < all && status == AD_OK; k++) {
        w->low = w->values[k] < w->low ? w->values[k] : w->low;
        w->high = w->values[k] > w->high ? w->values[k] : w->high;
    }
    if (!(w->low <= w->high)) {
        w->low = w->high = 0;
    }
    return status;
}

static void word(drawing *w, double x, double y, picture_align align, const char *format,
                 double number)
{
    char text[64];
    snprintf(text, sizeof text, format, number);
    picture_text(w->p, x, y, 14, align, picture_rgb("202020"), text);
}

/* A frame with numbers at its ends. */
static void draw_frame(drawing *w, double low, double high, const char *upwards, const char *title)
{
    const domain_coordinate *c = &w->d->coordinates[w->across];
    const double frame[] = {LEFT, TOP, LEFT, BOTTOM, RIGHT, BOTTOM, RIGHT, TOP, LEFT, TOP};
    picture_line(w->p, frame, 5, 1, picture_rgb("808080"));
    word(w, LEFT, BOTTOM + 22, PICTURE_MIDDLE, "%.4g", c->low);
    word(w, RIGHT, BOTTOM + 22, PICTURE_MIDDLE, "%.4g", c->high);
    word(w, LEFT - 8, BOTTOM, PICTURE_RIGHT, "%.4g", low);
    word(w, LEFT - 8, TOP + 10, PICTURE_RIGHT, "%.4g", high);
    const picture_colour ink = picture_rgb("202020");
    picture_text(w->p, (LEFT + RIGHT) / 2, BOTTOM + 40, 16, PICTURE_MIDDLE, ink, c->name);
    picture_text(w->p, LEFT - 8, (TOP + BOTTOM) / 2, 16, PICTURE_RIGHT, ink, upwards);
    picture_text(w->p, LEFT, TOP - 16, 16, PICTURE_LEFT, ink, title);
}

static void draw_curves(drawing *w, const char *title)
{
    const double margin = 0.05 * (w->high - w->low + (w->high > w->low ? 0 : 1));
    const double low = w->low - margin, high = w->high + margin;
    double points[2 * ACROSS];
    draw_frame(w, low, high, cpinn_fit_model(w->fit)->symbols[0], title);
    for (size_t line = 0; line < w->lines; line++) {
        const double *values = w->values + line * w->points;
        const picture_colour colour =
            picture_between(colours, COLOURS, w->lines > 1 ? (double)line / (CURVES - 1) : 0.2);
        size_t count = 0;
        for (size_t k = 0; k < w->points && isfinite(values[k]); k++, count++) {
            points[2 * k] = LEFT + (RIGHT - LEFT) * (double)k / (double)(w->points - 1);
            points[2 * k + 1] = BOTTOM - (BOTTOM - TOP) * part(values[k], low, high);
        }
        picture_line(w->p, points, count, 2, colour);
        if (w->other >= 0) {
            char text[96];
            snprintf(text, sizeof text, "%.20s = %.3g", w->d->coordinates[w->other].name,
                     w->x[w->other][line * w->points]);
            picture_text(w->p, RIGHT + 12, TOP + 14 + 22 * (double)line, 14, PICTURE_LEFT, colour,
                         text);
        }
    }
}

static void draw_map(drawing *w, const char *title)
{
    const domain_coordinate *up = &w->d->coordinates[w->other];
    const double high = (BOTTOM - TOP) / (double)w->lines,
                 wide = (RIGHT - LEFT) / (double)w->points;
    for (size_t k = 0; k < w->points * w->lines; k++) {
        const double x = LEFT + wide * (double)(k % w->points),
                     y = BOTTOM - high * ((double)(k / w->points) + 0.5);
        const double cell[] = {x, y, x + wide + 0.5, y};
        if (isfinite(w->values[k])) {
            picture_line(w->p, cell, 2, high + 0.5,
                         picture_between(colours, COLOURS, part(w->values[k], w->low, w->high)));
        }
    }
    const double rim[] = {LEFT - 4,   TOP - 4,   LEFT - 4, BOTTOM + 4, RIGHT + 4,
                          BOTTOM + 4, RIGHT + 4, TOP - 4,  LEFT - 4,   TOP - 4};
    picture_line(w->p, rim, 5, 8, picture_rgb("ffffff")); /* ends of lines are round */
    for (int k = 0; k < 100; k++) {
        const double y = BOTTOM - (BOTTOM - TOP) * (k + 0.5) / 100;
        const double bar[] = {RIGHT + 20, y, RIGHT + 36, y};
        picture_line(w->p, bar, 2, (BOTTOM - TOP) / 100.0 + 0.5,
                     picture_between(colours, COLOURS, k / 99.0));
    }
    word(w, RIGHT + 42, BOTTOM, PICTURE_LEFT, "%.3g", w->low);
    word(w, RIGHT + 42, TOP + 10, PICTURE_LEFT, "%.3g", w->high);
    draw_frame(w, up->low, up->high, up->name, title);
}

ad_status equation_picture_write(const cpinn_fit *fit, const char *title, const char *path,
                                 ad_error *error)
{
    drawing w = {.fit = fit, .d = &cpinn_fit_model(fit)->domain};
    char text[128];
    choose(&w);
    ad_status status = evaluate(&w, error);
    w.p = picture_create(WIDTH, HEIGHT);
    if (status == AD_OK && !w.p) {
        status = ad_fail(error, AD_NO_MEMORY, "out of memory for a picture");
    }
    if (status == AD_OK) {
        snprintf(text, sizeof text, "%.60s, estimated error %.1e", title,
                 cpinn_fit_summary(fit).estimate);
        if (w.lines == CELLS_DOWN) {
            draw_map(&w, text);
        } else {
            draw_curves(&w, text);
        }
        status = picture_file_write(w.p, path, error);
    }
    picture_free(w.p);
    free(w.x[0]);
    return status;
}
