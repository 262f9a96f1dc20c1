#include "tools/programs/status_line.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- text ---------------------------------------------------------------------------------- */

/* In the order in which they are shown. */
typedef enum part { PLACE, LOAD, LOSS, HELD_OUT, ERROR, LEFT, STEPS, SPEED, PARTS } part;

enum { LEVELS = 3 }; /* absent, short, long */

typedef char part_text[LEVELS][64];

/* 75 -> "1m15s" */
static void duration_text(double seconds, char text[24])
{
    long whole = (long)fmin(seconds + 0.5, 1e9);
    if (whole < 1) {
        snprintf(text, 24, "<1s");
    } else if (whole < 60) {
        snprintf(text, 24, "%lds", whole);
    } else if (whole < 3600) {
        snprintf(text, 24, "%ldm%02lds", whole / 60, whole % 60);
    } else if (whole < 360000) {
        snprintf(text, 24, "%ldh%02ldm", whole / 3600, whole / 60 % 60);
    } else {
        snprintf(text, 24, "%ldd%02ldh", whole / 86400, whole / 3600 % 24);
    }
}

static void place_text(const status_line *line, part_text text)
{
    char window[32] = "", step[48];
    int length = snprintf(step, sizeof step, "step %lld", (long long)line->step);
    if (line->steps > 0) {
        snprintf(step + length, sizeof step - (size_t)length, "/%d", line->steps);
    }
    if (line->windows > 1) {
        snprintf(window, sizeof window, "window %d/%d", line->window, line->windows);
    }
    snprintf(text[1], sizeof text[1], "%s", line->windows > 1 ? window : step);
    snprintf(text[2], sizeof text[2], "%s%s%s %d/%d %.20s", window, *window ? " " : "",
             line->optimizer, line->stage, line->stages, step);
}

static void number_text(const char *name, double value, part_text text)
{
    if (!isnan(value)) {
        snprintf(text[1], sizeof text[1], "%s %.2e", name, value);
    }
}

static void part_texts(const status_line *line, part_text texts[PARTS])
{
    char duration[24];
    memset(texts, 0, PARTS * sizeof *texts);
    place_text(line, texts[PLACE]);
    number_text("loss", line->loss, texts[LOSS]);
    number_text("held-out", line->held_out, texts[HELD_OUT]);
    number_text("error", line->error, texts[ERROR]);
    if (line->load_factor < 1) {
        snprintf(texts[LOAD][1], sizeof texts[LOAD][1], "load factor %.3g", line->load_factor);
    }
    if (!isnan(line->left)) {
        duration_text(line->left, duration);
        bool less = line->at_most && *duration != '<';
        snprintf(texts[LEFT][1], sizeof texts[LEFT][1], "%s%s left", less ? "<" : "", duration);
    }
    if (!isnan(line->steps_per_s)) {
        snprintf(texts[STEPS][1], sizeof texts[STEPS][1], "%.3g steps/s", line->steps_per_s);
    }
    if (!isnan(line->points_per_s)) {
        snprintf(texts[SPEED][1], sizeof texts[SPEED][1], "%.2fM points/s",
                 line->points_per_s / 1e6);
    }
}

/* The parts at their levels, two blanks between them; returns the length of all of it. */
static int join(part_text texts[PARTS], const int levels[PARTS], char line[STATUS_LINE_SIZE])
{
    int length = 0;
    line[0] = '\0';
    for (int i = 0; i < PARTS && length < STATUS_LINE_SIZE; i++) {
        const char *text = texts[i][levels[i]];
        if (*text) {
            length += snprintf(line + length, (size_t)(STATUS_LINE_SIZE - length), "%s%s",
                               length ? "  " : "", text);
        }
    }
    return length;
}

int status_line_text(const status_line *line, int width, char text[STATUS_LINE_SIZE])
{
    static const part order[] = {ERROR, LOSS, PLACE, LEFT, LOAD, PLACE, HELD_OUT, STEPS, SPEED};
    part_text texts[PARTS];
    int levels[PARTS] = {0};
    part_texts(line, texts);
    width = width < STATUS_LINE_WIDE ? width : STATUS_LINE_WIDE;
    for (size_t i = 0; i < sizeof order / sizeof *order; i++) {
        levels[order[i]]++;
        if (join(texts, levels, text) > width) {
            levels[order[i]]--;
        }
    }
    return join(texts, levels, text);
}

/* ---- time ---------------------------------------------------------------------------------- */

/* Of a stage from `step` on, in which so many seconds have been spent. */
static double stage_left(const train_stage *stage, int64_t step, double spent, double step_seconds)
{
    double left = fmax((double)(stage->steps - step), 0) * step_seconds;
    return stage->stop_seconds > 0 ? fmin(left, fmax(stage->stop_seconds - spent, 0)) : left;
}

double status_time_left(const status_pace *pace, bool *at_most)
{
    const train_stage *at_work = &pace->stages[pace->stage];
    double here = stage_left(at_work, pace->stage_step, pace->stage_seconds, pace->step_seconds);
    double window = 0; /* a whole one */
    *at_most = false;
    for (int i = 0; i < pace->stage_count; i++) {
        double stage = stage_left(&pace->stages[i], 0, 0, pace->step_seconds);
        window += stage;
        here += i > pace->stage ? stage : 0;
        *at_most =
            *at_most || optim_method_needs(pace->stages[i].optim.method) != OPTIM_NEEDS_GRADIENTS;
    }
    double left = here + (pace->windows_left > 0 ? pace->windows_left * window : 0);
    if (pace->windows_timed > 0) {
        double mean = pace->windows_seconds / pace->windows_timed;
        double usual = fmax(mean - pace->window_seconds, 0) + pace->windows_left * mean;
        left = fmin(left, usual); /* fmin takes the other where one is NaN */
        *at_most = false;
    }
    if (pace->repeats) {
        left = NAN;
    }
    if (isfinite(pace->limit_left) && !(left <= pace->limit_left)) {
        *at_most = true;
        left = fmax(pace->limit_left, 0);
    }
    return left;
}
