#include "tools/programs/surrogate_progress.h"

#include "tools/train/clock.h"

#include <math.h>
#include <stdarg.h>

void surrogate_progress_say(const surrogate_progress *p, const char *format, ...)
{
    va_list arguments;
    if (p->quiet) {
        return;
    }
    if (p->watch) {
        watch_hide(p->watch);
    }
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
    putchar('\n');
    fflush(stdout);
    if (p->watch) {
        watch_show(p->watch);
    }
}

void surrogate_progress_begin(surrogate_progress *p, const train_settings *settings,
                              surrogate_training *t)
{
    const history *h = surrogate_training_history(t);
    p->settings = settings;
    p->own = t;
    p->began = train_seconds();
    p->first_step = surrogate_training_inspect(t).step;
    p->gap = 1;
    p->watch = p->pictures && !p->quiet ? watch_create(stdout, settings->name) : NULL;
    if (p->watch) {
        watch_record_rows(p->watch, h);
    }
}

/* ---- a step -------------------------------------------------------------------------------- */

static void draw(surrogate_progress *p, const status_line *line, const char *over)
{
    watch_draw(p->watch, &(watch_view){.line = *line,
                                       .over = over,
                                       .rows = surrogate_training_history(p->own),
                                       .note = p->note});
}

static void draw_step(surrogate_progress *p, const surrogate_training_info *info)
{
    const train_stage *stage = &p->settings->stages[info->stage];
    const double pace = (double)(info->step - p->first_step) / (train_seconds() - p->began);
    status_line line = {.optimizer = optim_method_name(stage->optimizer),
                        .windows = 1,
                        .stage = info->stage + 1,
                        .stages = p->settings->stage_count,
                        .step = info->stage_step,
                        .steps = stage->steps,
                        .load_factor = 1,
                        .loss = info->loss,
                        .held_out = info->held_out,
                        .error = NAN,
                        .points_per_s = NAN,
                        .steps_per_s = pace};
    line.left = status_time_left(&(status_pace){.stages = p->settings->stages,
                                                .stage = info->stage,
                                                .stage_count = p->settings->stage_count,
                                                .stage_step = info->stage_step,
                                                .step_seconds = 1 / pace,
                                                .limit_left = INFINITY},
                                 &line.at_most);
    draw(p, &line, NULL);
}

static void say_step(surrogate_progress *p, const surrogate_training_info *info)
{
    const train_stage *stage = &p->settings->stages[info->stage];
    char held_out[32] = "-"; /* before the first row of the history */
    if (!isnan(info->held_out)) {
        snprintf(held_out, sizeof held_out, "%.3e", info->held_out);
    }
    surrogate_progress_say(p, "%-9s stage %d/%d step %lld/%d  loss %.3e  held-out %s  %.1f s",
                           optim_method_name(stage->optimizer), info->stage + 1,
                           p->settings->stage_count, (long long)info->stage_step, stage->steps,
                           info->loss, held_out, info->seconds);
}

void surrogate_progress_step(surrogate_progress *p)
{
    const surrogate_training_info info = surrogate_training_inspect(p->own);
    const double now = train_seconds();
    if (p->watch) {
        watch_record(p->watch, info.seconds, info.loss);
    }
    if (info.done) {
        return;
    }
    if (p->watch && watch_is_due(p->watch)) {
        draw_step(p, &info);
    } else if (!p->watch && now >= p->next) {
        say_step(p, &info);
        p->next = now + p->gap;
        p->gap = fmin(1.5 * p->gap, 60);
    }
}

void surrogate_progress_end(surrogate_progress *p)
{
    const surrogate_training_info info = surrogate_training_inspect(p->own);
    if (p->watch && info.step > p->first_step) {
        char over[64];
        const status_line line = {.loss = info.loss, .held_out = info.held_out, .error = NAN};
        snprintf(over, sizeof over, "%lld steps in %.2f s", (long long)info.step, info.seconds);
        draw(p, &line, over);
    }
    watch_free(p->watch);
    p->watch = NULL;
}
