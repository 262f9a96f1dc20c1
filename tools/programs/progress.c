#include "tools/programs/progress.h"

#include "physics/numerics/clock.h"
#include "tools/programs/signals.h"
#include "tools/programs/status_line.h"

#include <math.h>
#include <stdarg.h>
#include <sys/ioctl.h>
#include <unistd.h>

static const double live_interval = 0.2; /* s */

progress progress_start(FILE *file, bool quiet, const fit *of)
{
    progress p = {.file = file,
                  .quiet = quiet,
                  .live = isatty(fileno(file)),
                  .of = of,
                  .gap = 1,
                  .last = of->at};
    p.started = p.next = p.window_began = p.stage_began = clock_seconds(CLOCK_MONOTONIC);
    p.first_step = p.last.step;
    p.stage_first = p.last.stage_step;
    p.window_whole = p.last.window_step == 0;
    return p;
}

/* Columns of the terminal, less the one where the cursor wraps; a longer line could not be
 * overwritten. A log has room for all. */
static int room(const progress *p)
{
    struct winsize size;
    bool known = p->live && ioctl(fileno(p->file), TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
    return known ? size.ws_col - 1 : STATUS_LINE_WIDE;
}

void progress_clear(progress *p)
{
    if (p->width > 0) {
        fprintf(p->file, "\r%*s\r", p->width, "");
        p->width = 0;
    }
}

/* Notices when another window or stage begins, from which the time left is estimated. */
static void follow(progress *p, const fit_place *now_at, double now)
{
    const bool other = now_at->window != p->last.window;
    if (other) {
        if (p->window_whole) {
            p->windows_timed++;
            p->windows_seconds += now - p->window_began;
        }
        p->window_began = now;
        p->window_whole = true;
    }
    if (other || now_at->stage != p->last.stage || now_at->stage_step < p->last.stage_step) {
        p->stage_began = now;
        p->stage_first = now_at->stage_step;
    }
    p->last = *now_at;
}

static double time_left(const progress *p, double now, bool *at_most)
{
    const train_settings *settings = p->of->settings;
    const fit_place *at = &p->last;
    int64_t steps = at->stage_step - p->stage_first, all = at->step - p->first_step;
    const status_pace pace = {.stages = settings->stages,
                              .stage = at->stage,
                              .stage_count = settings->stage_count,
                              .stage_step = at->stage_step,
                              .stage_seconds = fit_stage_seconds(p->of),
                              .step_seconds = steps > 0 ? (now - p->stage_began) / (double)steps
                                              : all > 0 ? (now - p->started) / (double)all
                                                        : NAN,
                              .windows_left = p->of->windows - at->window - 1,
                              .windows_timed = p->windows_timed,
                              .windows_seconds = p->windows_seconds,
                              .window_seconds = now - p->window_began,
                              .repeats = at->part<1, .limit_left = p->limit> 0
                                             ? p->limit - (now - p->started)
                                             : INFINITY};
    return status_time_left(&pace, at_most);
}

/* The speed is that of points, if they are counted, else that of steps. */
static status_line line_of(const progress *p, double now)
{
    const train_settings *settings = p->of->settings;
    const fit *of = p->of;
    const fit_place *at = &of->at;
    const train_stage *stage = &settings->stages[at->stage];
    status_line line = {.optimizer = optim_method_name(stage->optim.method),
                        .window = at->window + 1,
                        .windows = p->of->windows,
                        .stage = at->stage + 1,
                        .stages = settings->stage_count,
                        .step = at->stage_step,
                        .steps = p->limit > 0 ? 0 : stage->steps,
                        .load_factor = at->part,
                        .loss = of->loss,
                        .held_out = of->held_out,
                        .error = of->error,
                        .steps_per_s = NAN};
    line.left = time_left(p, now, &line.at_most);
    line.points_per_s = of->points / (now - p->started);
    if (isnan(of->points)) {
        line.steps_per_s = (double)(at->step - p->first_step) / (now - p->started);
    }
    return line;
}

void progress_step(progress *p)
{
    if (p->quiet) {
        return;
    }
    double now = clock_seconds(CLOCK_MONOTONIC);
    follow(p, &p->of->at, now);
    if (p->of->state != FIT_RUNNING || now < p->next) {
        return;
    }
    const status_line status = line_of(p, now);
    char line[STATUS_LINE_SIZE];
    int columns = room(p), width = status_line_text(&status, columns, line);
    if (p->live) { /* blanks cover the rest of a longer line before */
        int before = p->width < columns ? p->width : columns;
        fprintf(p->file, "\r%-*s", before > width ? before : width, line);
        p->width = width;
        p->next = now + live_interval;
    } else {
        fprintf(p->file, "%s\n", line);
        p->next = now + p->gap;
        p->gap = fmin(1.5 * p->gap, 60);
    }
    fflush(p->file);
}

static bool stepped(void *context)
{
    progress_step(context);
    return !signals_caught();
}

ad_status progress_train(progress *p, session *s, ad_error *error)
{
    return session_train(s, stepped, p, error);
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

void progress_members(progress *p, const targets_errors *errors, double length)
{
    const double mm = 1e3 * length;
    if (isnan(errors->median)) {
        progress_say(p, "none of %d fresh members can be compared", TARGETS_FRESH);
        return;
    }
    progress_say(
        p,
        "largest error of a shape, over %d fresh members: median %.2g mm, 95 %% below %.2g "
        "mm, worst %.2g mm",
        TARGETS_FRESH, mm * errors->median, mm * errors->most, mm * errors->worst);
    if (isnan(errors->polished_median)) {
        return;
    }
    progress_say(p,
                 "after one step of Newton's method: median %.1e mm, 95 %% below %.1e mm, worst "
                 "%.2g mm",
                 mm * errors->polished_median, mm * errors->polished_most,
                 mm * errors->polished_worst);
}

void progress_error_table(FILE *file, const history *h, int windows)
{
    if (h->count == 0 || isnan(history_value(h, h->count - 1, "error"))) {
        return;
    }
    fprintf(file, "\n  %-33s after\n",
            !isnan(history_value(h, 0, "error_95")) ? "median error of members / length"
                                                    : "relative L2 error of position");
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
