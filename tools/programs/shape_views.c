#include "tools/programs/shape_views.h"

#include <math.h>
#include <stdio.h>

enum { X, Y, Z, AXES = SHAPE_VIEWS_AXES };

typedef struct box {
    double low[AXES], high[AXES];
} box;

/* Of all places, in steps of a tenth of the length so that it stays for a while; what is far off,
 * while a network has learnt nothing, is not seen. */
static box box_of(const shape_views *w)
{
    const double length = w->length, step = length / 10;
    const bool beam = w->beam;
    box b;
    for (int axis = 0; axis < AXES; axis++) {
        const double base = w->places[0][0][axis];
        double least = base, most = base;
        for (int k = 0; k < w->count; k++) {
            for (int i = 0; i < w->points; i++) {
                const double at = w->places[k][i][axis];
                if (fabs(at - base) < 3 * length) {
                    least = fmin(least, at);
                    most = fmax(most, at);
                }
            }
        }
        if (beam) {
            b.low[axis] = least;
            b.high[axis] = most > least ? most : least + 1e-9 * length;
        } else {
            b.low[axis] = step * floor(least / step - 0.1);
            b.high[axis] = step * ceil(most / step + 0.1);
        }
    }
    return b;
}

static double extent(const box *b, int axis)
{
    return b->high[axis] - b->low[axis];
}

static double range_of(const shape_views *w, int axis)
{
    double least = INFINITY, most = -INFINITY;
    for (int k = 0; k < w->count; k++) {
        for (int i = 0; i < w->points; i++) {
            least = fmin(least, w->places[k][i][axis]);
            most = fmax(most, w->places[k][i][axis]);
        }
    }
    return most - least;
}

/* The axis to the right and the one up, of one view or two; up is z if it can be. */
static int choose_views(const shape_views *w, int axes[2][2])
{
    const double flat = 0.02 * w->length;
    const double range[AXES] = {range_of(w, X), range_of(w, Y), range_of(w, Z)};
    const int most = range[X] >= range[Y] && range[X] >= range[Z] ? X
                     : range[Y] >= range[Z]                       ? Y
                                                                  : Z;
    const int least = range[Y] <= range[X] && range[Y] <= range[Z] ? Y
                      : range[Z] <= range[X]                       ? Z
                                                                   : X;
    if (!(range[least] > flat)) {
        axes[0][0] = least == X ? Y : X;
        axes[0][1] = least == Z ? Y : Z;
        return 1;
    }
    axes[0][0] = most == Z ? X : most;
    axes[0][1] = Z;
    axes[1][0] = most == X ? X : Y;
    axes[1][1] = most == Z ? Z : most == X ? Y : X;
    return 2;
}

/* Dots for a metre where both axes have the same. */
static double scale_of(const box *b, const int axes[2], int columns, int rows)
{
    return fmin((CANVAS_ACROSS * columns - 1) / extent(b, axes[0]),
                (CANVAS_DOWN * rows - 1) / extent(b, axes[1]));
}

static canvas_view view_of(const box *b, const int axes[2], double scale, int column, int row,
                           int columns, int rows)
{
    canvas_view view = {.column = column, .row = row, .columns = columns, .rows = rows};
    const double wide = scale > 0 ? (CANVAS_ACROSS * columns - 1) / scale : extent(b, axes[0]);
    const double tall = scale > 0 ? (CANVAS_DOWN * rows - 1) / scale : extent(b, axes[1]);
    const double across = (b->low[axes[0]] + b->high[axes[0]]) / 2;
    const double up = (b->low[axes[1]] + b->high[axes[1]]) / 2;
    view.left = across - wide / 2;
    view.right = across + wide / 2;
    view.bottom = up - tall / 2;
    view.top = up + tall / 2;
    return view;
}

canvas_colour shape_views_colour(const shape_views *w, int k)
{
    static const canvas_colour in_time[] = {CANVAS_BLUE, CANVAS_CYAN, CANVAS_GREEN, CANVAS_YELLOW,
                                            CANVAS_RED};
    const int colours = (int)(sizeof in_time / sizeof *in_time);
    return w->count == 1 ? CANVAS_GREEN
                         : in_time[(2 * k * (colours - 1) + w->count - 1) / (2 * (w->count - 1))];
}

static void draw_view(const shape_views *w, canvas *c, const canvas_view *view, const int axes[2])
{
    for (int i = 0; i < w->known; i++) {
        const double *at = w->known_places[i];
        canvas_line(c, view, CANVAS_DIM, at[axes[0]], at[axes[1]], at[axes[0]], at[axes[1]]);
    }
    for (int k = 0; k < w->count; k++) {
        for (int i = 1; i < w->points; i++) {
            const double *from = w->places[k][i - 1], *to = w->places[k][i];
            canvas_line(c, view, shape_views_colour(w, k), from[axes[0]], from[axes[1]],
                        to[axes[0]], to[axes[1]]);
        }
    }
}

/* ---- captions ------------------------------------------------------------------------------ */

static void draw_axes(canvas *c, int column, int row, const int axes[2])
{
    static const char names[] = "xyz";
    canvas_put(c, column, row, CANVAS_DIM, (unsigned char)names[axes[1]]);
    canvas_put(c, column + 1, row, CANVAS_DIM, 0x2191); /* ↑ */
    canvas_put(c, column + 3, row, CANVAS_DIM, (unsigned char)names[axes[0]]);
    canvas_put(c, column + 4, row, CANVAS_DIM, 0x2192); /* → */
}

/* A round length, at the right end. */
static void draw_scale(canvas *c, int column, int row, int columns, double scale)
{
    char text[32];
    const double most = columns / 6.0 * CANVAS_ACROSS / scale; /* m */
    const double power = pow(10, floor(log10(most)));
    const double length = power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
    const int cells = (int)lround(length * scale / CANVAS_ACROSS);
    const int size = length < 0.01 ? snprintf(text, sizeof text, " %g mm", 1e3 * length)
                                   : snprintf(text, sizeof text, " %g m", length);
    const int begin = column + columns - size - cells;
    for (int i = 0; i < cells; i++) {
        canvas_put(c, begin + i, row, CANVAS_DIM, /* ├─┤ */
                   i == 0           ? 0x251c
                   : i == cells - 1 ? 0x2524
                                    : 0x2500);
    }
    canvas_text(c, begin + cells, row, CANVAS_DIM, text);
}

/* Of a beam, whose deflection has a scale of its own. */
static void draw_deflection(const shape_views *w, canvas *c, int column, int row, int columns,
                            int rows)
{
    static const int axes[2] = {X, Z};
    char text[80];
    const box b = box_of(w);
    const canvas_view view = view_of(&b, axes, 0, column, row, columns, rows);
    draw_view(w, c, &view, axes);
    snprintf(text, sizeof text, "deflection %.3g to %.3g m over %.3g m", b.low[Z], b.high[Z],
             extent(&b, X));
    canvas_text(c, column, row + rows, CANVAS_DIM, text);
}

void shape_views_draw(const shape_views *w, canvas *c, int column, int row, int columns, int rows)
{
    int axes[2][2];
    if (w->count == 0 || rows < 3 || columns < 16) {
        return;
    }
    rows--; /* for axes and scale */
    if (w->beam) {
        draw_deflection(w, c, column, row, columns, rows);
        return;
    }
    const box b = box_of(w);
    const int views = choose_views(w, axes);
    double scale = scale_of(&b, axes[0], columns, rows);
    int wide = columns, tall = rows;
    bool beside = false;
    if (views == 2) {
        const int half = (columns - 1) / 2, low = rows / 2;
        const double side =
            fmin(scale_of(&b, axes[0], half, rows), scale_of(&b, axes[1], half, rows));
        const double above =
            fmin(scale_of(&b, axes[0], columns, low), scale_of(&b, axes[1], columns, low));
        beside = side >= above;
        scale = fmax(side, above);
        wide = beside ? half : columns;
        tall = beside ? rows : low;
    }
    draw_scale(c, column, row + rows, columns, scale);
    for (int i = 0; i < views; i++) {
        const int left = column + (beside ? i * (wide + 1) : 0),
                  top = row + (beside ? 0 : i * tall);
        const canvas_view view = view_of(&b, axes[i], scale, left, top, wide, tall);
        draw_view(w, c, &view, axes[i]);
        draw_axes(c, left, top + tall - (beside || i == views - 1 ? 0 : 1), axes[i]);
    }
}
