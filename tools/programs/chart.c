#include "tools/programs/chart.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Cells left of the plane, for numbers and the axis; below it. */
enum { LEFT = 7, BELOW = 2, APART = 10 };

enum { QUARTERS = 4 };

/* ---- ranges -------------------------------------------------------------------------------- */

typedef struct range {
    double low, high;
} range;

static range none(void)
{
    return (range){INFINITY, -INFINITY};
}

static void reach(range *r, double value)
{
    if (isfinite(value)) {
        r->low = fmin(r->low, value);
        r->high = fmax(r->high, value);
    }
}

/* NaN: a gap. */
static double height(double value)
{
    return value > 0 ? log10(value) : NAN;
}

/* Of what is to be seen: up in quarters of a decade, so that it stays for a while, and so far that
 * a power of ten is among it. */
static void ranges_of(const chart *what, range *across, range *up)
{
    *across = *up = none();
    for (int k = 0; k < what->count; k++) {
        const chart_series *s = &what->series[k];
        for (int i = 0; i < s->points; i++) {
            reach(across, s->x[i]);
            reach(up, height(s->y[i]));
        }
    }
    *across = across->low <= across->high ? *across : (range){0, 1};
    across->low = across->low < 0.1 * across->high ? 0 : across->low;
    across->high = fmax(across->high, across->low > 0 ? 1.01 * across->low : 1e-3);
    *up = up->low <= up->high ? *up : (range){-1, 0};
    up->low = floor(QUARTERS * up->low) / QUARTERS;
    up->high = fmax(ceil(QUARTERS * up->high) / QUARTERS, up->low + 1);
}

/* 1, 2 or 5 times a power of ten, at least `least`. */
static double round_step(double least)
{
    const double power = pow(10, floor(log10(least)));
    const double steps[] = {1, 2, 5, 10};
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        if (steps[i] * power >= least * (1 - 1e-9)) {
            return steps[i] * power;
        }
    }
    return 10 * power;
}

/* ---- axes ---------------------------------------------------------------------------------- */

static void draw_decades(canvas *c, const canvas_view *view)
{
    const double tall = view->top - view->bottom;
    const int first = (int)ceil(view->bottom), last = (int)floor(view->top);
    const int every = tall > view->rows / 2.0 ? (int)ceil(2 * tall / view->rows) : 1;
    for (int i = 0; i < view->rows; i++) {
        canvas_put(c, view->column - 1, view->row + i, CANVAS_DIM, 0x2502); /* │ */
    }
    for (int decade = first; decade <= last; decade += every) {
        char text[16];
        const double down = (CANVAS_DOWN * view->rows - 1) * (view->top - decade) / tall;
        const int row = view->row + (int)lround(down) / CANVAS_DOWN;
        const int length = snprintf(text, sizeof text, "1e%+03d", decade);
        canvas_text(c, view->column - 1 - length, row, CANVAS_DIM, text);
        canvas_put(c, view->column - 1, row, CANVAS_DIM, 0x2524); /* ┤ */
    }
}

static void draw_abscissa(canvas *c, const canvas_view *view, const char *unit)
{
    const double wide = view->right - view->left;
    const int row = view->row + view->rows;
    const double step = round_step(wide * APART / view->columns);
    int behind = 0;
    canvas_put(c, view->column - 1, row, CANVAS_DIM, 0x2514); /* └ */
    for (int i = 0; i < view->columns; i++) {
        canvas_put(c, view->column + i, row, CANVAS_DIM, 0x2500); /* ─ */
    }
    for (double at = step * ceil(view->left / step - 1e-9); at <= view->right; at += step) {
        char text[32];
        const double across = (CANVAS_ACROSS * view->columns - 1) * (at - view->left) / wide;
        const int column = view->column + (int)lround(across) / CANVAS_ACROSS;
        const bool last = at + step > view->right;
        const int length = snprintf(text, sizeof text, "%.6g%s%s", fabs(at) < 1e-9 * step ? 0 : at,
                                    last ? " " : "", last ? unit : "");
        const int most = view->column + view->columns - length;
        const int begin = column - 1 < most ? column - 1 : most;
        canvas_put(c, column, row, CANVAS_DIM, 0x2534); /* ┴ */
        if (begin > behind) {
            behind = canvas_text(c, begin, row + 1, CANVAS_DIM, text);
        }
    }
}

static void draw_series(canvas *c, const canvas_view *view, const chart_series *s)
{
    double before = NAN;
    for (int i = 0; i < s->points; i++) {
        const bool joined = isfinite(before);
        const double up = height(s->y[i]);
        canvas_line(c, view, s->colour, s->x[joined ? i - 1 : i], joined ? before : up, s->x[i],
                    up);
        before = up;
    }
}

void chart_draw(canvas *c, const chart *what, int column, int row, int columns, int rows)
{
    canvas_view view = {
        .column = column + LEFT, .row = row, .columns = columns - LEFT, .rows = rows - BELOW};
    range across, up;
    if (columns < CHART_COLUMNS || rows < CHART_ROWS) {
        return;
    }
    ranges_of(what, &across, &up);
    view.left = across.low;
    view.right = across.high;
    view.bottom = up.low;
    view.top = up.high;
    draw_decades(c, &view);
    draw_abscissa(c, &view, what->x_unit);
    for (int k = 0; k < what->count; k++) {
        draw_series(c, &view, &what->series[k]);
    }
}
