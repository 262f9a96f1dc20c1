#include "tools/programs/progress.h"

#include "tools/train/clock.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

static const double live_interval = 0.2; /* s */

progress progress_start(FILE *file, bool quiet, const trainer *t)
{
    progress p = {.file = file, .quiet = quiet, .live = isatty(fileno(file)), .gap = 1};
    p.started = wall_seconds();
    p.next = p.started;
    p.first_step = trainer_inspect(t).step;
    return p;
}

/* Columns of the terminal, less the one where the cursor wraps; a longer line could not be
 * overwritten. */
static int room(const progress *p, int most)
{
    struct winsize size;
    bool known = ioctl(fileno(p->file), TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
    return known && size.ws_col - 1 < most ? size.ws_col - 1 : most;
}

void progress_clear(progress *p)
{
    if (p->width > 0) {
        fprintf(p->file, "\r%*s\r", p->width, "");
        p->width = 0;
    }
}

/* 75 -> "1m15s" */
static const char *duration_text(double seconds, char text[32])
{
    if (!isfinite(seconds)) {
        return "?";
    }
    long whole = (long)(seconds + 0.5);
    if (whole < 60) {
        snprintf(text, 32, "%lds", whole);
    } else if (whole < 3600) {
        snprintf(text, 32, "%ldm%02lds", whole / 60, whole % 60);
    } else {
        snprintf(text, 32, "%ldh%02ldm", whole / 3600, whole / 60 % 60);
    }
    return text;
}

static const char *number_text(double value, char text[32])
{
    snprintf(text, 32, isnan(value) ? "-" : "%.2e", value);
    return text;
}

static int write_line(const progress *p, const trainer *t, const experiment *e, char *line,
                      size_t size)
{
    trainer_info info = trainer_inspect(t);
    const config_stage *stage = &e->settings->stages[info.stage];
    double spent = wall_seconds() - p->started;
    double rate = (double)(info.step - p->first_step) / spent;
    double remaining = (double)(stage->steps - info.stage_step) / rate;
    remaining = p->limit > 0 ? fmin(remaining, fmax(p->limit - spent, 0)) : remaining;
    char left[32], error[32], held[32], steps[16] = "", window[32] = "";
    if (p->limit <= 0) { /* or time decides */
        snprintf(steps, sizeof steps, "/%d", stage->steps);
    }
    if (e->settings->scene.windows > 1) {
        snprintf(window, sizeof window, "window %d/%d ", info.window + 1,
                 e->settings->scene.windows);
    }
    return snprintf(
        line, size,
        "%s%-5s %d/%d step %lld%s  loss %.2e  held-out %s  error %s  %s left  %.2fM points/s",
        window, config_optimizer_name(stage->optimizer), info.stage + 1, e->settings->stage_count,
        (long long)info.stage_step, steps, info.loss, number_text(info.held_out, held),
        number_text(info.errors.position, error), duration_text(remaining, left),
        (double)info.evaluations * info.points / spent / 1e6);
}

void progress_step(progress *p, const trainer *t, const experiment *e)
{
    double now = wall_seconds();
    if (p->quiet || now < p->next || trainer_inspect(t).state != TRAINER_RUNNING) {
        return;
    }
    char line[256];
    int width = write_line(p, t, e, line, sizeof line);
    if (p->live) {
        width = room(p, width < (int)sizeof line ? width : (int)sizeof line - 1);
        fprintf(p->file, "\r%-*.*s", p->width, width, line);
        p->width = width;
        p->next = now + live_interval;
    } else {
        fprintf(p->file, "%s\n", line);
        p->next = now + p->gap;
        p->gap = fmin(1.5 * p->gap, 60);
    }
    fflush(p->file);
}

void progress_say(progress *p, const char *format, ...)
{
    if (p->quiet) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    progress_clear(p);
    vfprintf(p->file, format, arguments);
    fputc('\n', p->file);
    fflush(p->file);
    va_end(arguments);
}

void progress_error_table(FILE *file, const history *h, int windows)
{
    if (h->count == 0 || isnan(history_value(h, h->count - 1, "error"))) {
        return;
    }
    fprintf(file, "\n  relative L2 error of position     after\n");
    double best = INFINITY, best_seconds = 0, limit = 0.1;
    for (size_t i = 0; i < h->count; i++) {
        double error = history_value(h, i, "error"), seconds = history_value(h, i, "seconds");
        if (windows > 1 && history_value(h, i, "window") < windows) {
            continue;
        }
        for (; error < limit && limit > 1e-15; limit /= 10) {
            fprintf(file, "    below %-8.0e %21.2f s  (step %.0f)\n", limit, seconds,
                    history_value(h, i, "step"));
        }
        if (error < best) {
            best = error;
            best_seconds = seconds;
        }
    }
    fprintf(file, "    best  %-8.2e %21.2f s\n", best, best_seconds);
    size_t last = h->count - 1;
    fprintf(file, "    last  %-8.2e %21.2f s", history_value(h, last, "error"),
            history_value(h, last, "seconds"));
    double tip = history_value(h, last, "tip_error"),
           angle = history_value(h, last, "rotation_error");
    if (!isnan(tip)) {
        fprintf(file, "   tip error / length %.2e", tip);
    }
    if (!isnan(angle)) {
        fprintf(file, "   rotation %.2e rad", angle);
    }
    fputc('\n', file);
}
