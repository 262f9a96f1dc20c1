#include "tools/programs/watch.h"

#include "tools/programs/chart.h"
#include "tools/programs/terminal.h"
#include "tools/train/clock.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SERIES = 3, RECORDS = 1024 };

/* Rows that a picture may have however narrow it is. */
enum { LEAST_TALL = 24 };

/* Between drawings: s, and processor time over that of drawing. */
static const double least_interval = 0.1, rest = 200;

typedef struct curve {
    int count;
    double x[RECORDS], y[RECORDS];
} curve;

struct watch {
    const char *title;
    terminal terminal;
    canvas picture;
    double next;                /* s */
    double began, ended, spent; /* s of processor time: of the last drawing */
    int stride, skipped;
    curve curves[SERIES]; /* of the loss one of `stride` records; the others as they are drawn */
};

watch *watch_create(FILE *file, const char *title)
{
    watch *w = calloc(1, sizeof *w);
    if (w && !terminal_begin(&w->terminal, file)) {
        free(w);
        return NULL;
    }
    if (w) {
        w->title = title;
        w->stride = 1;
        w->next = train_seconds() + least_interval;
    }
    return w;
}

void watch_free(watch *w)
{
    free(w);
}

/* ---- curves -------------------------------------------------------------------------------- */

enum { HELD_OUT, LOSS, ERROR }; /* in the order in which they cover each other */

static const struct {
    const char *name, *column;
    canvas_colour colour;
} series[SERIES] = {[LOSS] = {"loss", "loss", CANVAS_CYAN},
                    [HELD_OUT] = {"held-out", "held_out", CANVAS_MAGENTA},
                    [ERROR] = {"error", "error", CANVAS_YELLOW}};

void watch_record(watch *w, double seconds, double loss)
{
    curve *kept = &w->curves[LOSS];
    if (++w->skipped < w->stride) {
        return;
    }
    w->skipped = 0;
    kept->x[kept->count] = seconds;
    kept->y[kept->count++] = loss;
    if (kept->count == RECORDS) {
        kept->count /= 2;
        w->stride *= 2;
        for (int i = 0; i < kept->count; i++) {
            kept->x[i] = kept->x[2 * i];
            kept->y[i] = kept->y[2 * i];
        }
    }
}

void watch_record_rows(watch *w, const history *h)
{
    for (size_t row = 0; row < h->count; row++) {
        watch_record(w, history_value(h, row, "seconds"), history_value(h, row, "loss"));
    }
}

/* Every so many rows, the last one among them. */
static void take_column(curve *to, const history *h, const char *column)
{
    const size_t apart = (h->count + RECORDS - 1) / RECORDS;
    to->count = 0;
    for (size_t row = h->count ? (h->count - 1) % apart : 0; row < h->count; row += apart) {
        to->x[to->count] = history_value(h, row, "seconds");
        to->y[to->count++] = history_value(h, row, column);
    }
}

static void draw_curves(watch *w, const history *h, int column, int row, int columns, int rows)
{
    chart what = {.x_unit = "s", .count = SERIES};
    for (int k = 0; k < SERIES; k++) {
        curve *from = &w->curves[k];
        if (k != LOSS) {
            take_column(from, h, series[k].column);
        }
        what.series[k] = (chart_series){from->count, from->x, from->y, series[k].colour};
    }
    chart_draw(&w->picture, &what, column, row, columns, rows);
}

/* ---- the picture --------------------------------------------------------------------------- */

/* The colours of the curves, and their numbers; where there is no room for all, without that at
 * points never trained on. */
static void draw_legend(canvas *c, int row, const status_line *line)
{
    enum { WIDE = 60 };
    const double numbers[SERIES] = {[LOSS] = line->loss,
                                    [HELD_OUT] = c->columns < WIDE ? NAN : line->held_out,
                                    [ERROR] = line->error};
    static const int order[SERIES] = {LOSS, HELD_OUT, ERROR};
    for (int i = 0, column = 0; i < SERIES; i++) {
        const int k = order[i];
        char text[48];
        if (isnan(numbers[k])) {
            continue;
        }
        snprintf(text, sizeof text, " %s %.2e", series[k].name, numbers[k]);
        canvas_put(c, column++, row, series[k].colour, 0x2501); /* ━ */
        canvas_put(c, column++, row, series[k].colour, 0x2501);
        column = canvas_text(c, column, row, CANVAS_PLAIN, text) + 2;
    }
}

static void draw_head(canvas *c, const char *title, const watch_view *view)
{
    const status_line *line = &view->line;
    const int begin = canvas_text(c, 0, 0, CANVAS_GREEN, title) + 2;
    char text[STATUS_LINE_SIZE] = "";
    status_line others = *line;
    others.loss = others.error = others.held_out = NAN; /* they have a line of their own */
    if (!view->over && c->columns > begin) {
        status_line_text(&others, c->columns - begin, text);
    }
    canvas_text(c, begin, 0, CANVAS_PLAIN, view->over ? view->over : text);
    draw_legend(c, 1, line);
}

/* Side by side where it is wide, one above the other where it is tall, else curves alone. */
static void draw_body(watch *w, const watch_view *view)
{
    canvas *c = &w->picture;
    const int top = c->rows > 18 ? 3 : 2, rows = c->rows - top, columns = c->columns;
    if (view->shapes && columns >= 64) {
        const int left = columns * 11 / 20;
        draw_curves(w, view->rows, 0, top, left, rows);
        watch_shapes_draw(view->shapes, c, left + 2, top, columns - left - 2, rows);
    } else if (view->shapes && rows >= 18) {
        draw_curves(w, view->rows, 0, top, columns, rows / 2);
        watch_shapes_draw(view->shapes, c, 0, top + rows / 2, columns, rows - rows / 2);
    } else {
        draw_curves(w, view->rows, 0, top, columns, rows - (view->note != NULL));
    }
    if (view->note) {
        canvas_text(c, 0, c->rows - 1, CANVAS_DIM, view->note);
    }
}

/* Of all threads. */
static double processor_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

bool watch_is_due(watch *w)
{
    if (train_seconds() < w->next) {
        return false;
    }
    w->began = processor_seconds();
    return w->began - w->ended >= rest * w->spent;
}

void watch_draw(watch *w, const watch_view *view)
{
    int columns, rows;
    terminal_room(&w->terminal, &columns, &rows);
    const int most = 3 * columns / 10 > LEAST_TALL ? 3 * columns / 10 : LEAST_TALL;
    canvas_clear(&w->picture, columns, rows < most ? rows : most);
    draw_head(&w->picture, w->title, view);
    draw_body(w, view);
    watch_show(w);
    w->next = train_seconds() + least_interval;
    w->ended = processor_seconds();
    w->spent = w->ended - w->began;
}

void watch_hide(watch *w)
{
    terminal_clear(&w->terminal);
}

void watch_show(watch *w)
{
    if (w->picture.rows > 0) {
        terminal_show(&w->terminal, &w->picture);
    }
}
