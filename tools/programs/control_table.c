#include "tools/programs/control_run.h"

#include "tools/programs/control_judge.h"
#include "tools/programs/estimates.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const filter_flags[LOOP_FLAGS] = {
    "missing", "not_finite", "late",         "outlier",    "inflated", "no_answer",
    "outside", "at_edge",    "inconsistent", "bad_inputs", "bad_call"};
static const char *const control_flags[LOOP_FLAGS] = {"no_state",   "outside",  "held",
                                                      "no_model",   "qp_limit", "no_qp",
                                                      "soft_limit", "others",   "reference"};

static const double MILLI = 1e3, MICRO = 1e6;

static void print_task(const control_settings *c, const control_task *task)
{
    static const char *const words[] = {"circle", "figure eight", "set points", "path of a file"};
    printf("  %-10s %s", "task", words[task->path]);
    if (task->path == CONTROL_CIRCLE || task->path == CONTROL_EIGHT) {
        printf(" of %.4g mm at %.4g Hz about (%.5g, %.5g, %.5g) m across (%.3g, %.3g, %.3g)%s",
               MILLI * task->radius, task->frequency, task->centre[0], task->centre[1],
               task->centre[2], task->normal[0], task->normal[1], task->normal[2],
               task->surface == CONTROL_REACHABLE ? ", on what can be reached" : "");
    }
    printf(", by the place at %.4g m; approach %.4g s\n", c->track_at, task->approach);
}

void control_print_head(const config *of, const control_row *row, const char *model)
{
    const control_settings *c = &row->control;
    const int *modes = c->plant_modes;
    printf("%s: %ld periods of %.4g ms\n", of->settings.name, row->report.samples,
           MILLI * c->period);
    print_task(c, loop_task(row->loop));
    if (!isnan(row->report.reach)) {
        printf(
            "  %-10s %.2g mm rms, at most %.2g mm, off the path where the place can be at rest\n",
            "reach", MILLI * row->report.reach, MILLI * row->report.reach_worst);
    }
    printf("  %-10s modes %d, %d, %d, %d", "plant", modes[0], modes[1], modes[2], modes[3]);
    if (!isnan(row->report.modes)) {
        printf(", which leave out %.2g mm rms, at most %.2g mm", MILLI * row->report.modes,
               MILLI * row->report.modes_worst);
    }
    for (int i = 0; i < c->change_count; i++) {
        printf("%s %s", i ? "," : ";", c->changes[i]);
    }
    printf("\n  %-10s %s\n\n", "model", model);
}

/* ---- the table ----------------------------------------------------------------------------- */

static void print_estimates(const control_row *row)
{
    for (int i = 0; i < row->control.estimate_count; i++) {
        printf("%s%s %.4g +- %.2g", i ? ", " : "", row->control.estimate[i],
               row->report.estimate[i], row->report.deviation[i]);
        if (!isnan(row->report.truth[i])) {
            printf(" (%.4g)", row->report.truth[i]);
        }
    }
}

void control_print(int count, const control_row *rows)
{
    printf("%-22s %18s  %27s  %9s  %s\n", "", "error (mm)", "time a period (us)", "rate", "");
    printf("%-22s %8s %9s  %8s %8s %9s  %9s  %s\n", "", "rms", "worst", "filter", "control",
           "worst", "(Hz)", "estimate (truth)");
    for (int i = 0; i < count; i++) {
        const control_row *row = &rows[i];
        const loop_report *r = &row->report;
        printf("%-22s ", row->name);
        if (!row->loop) {
            printf("%s\n", row->why.message);
            continue;
        }
        if (r->diverged) {
            printf("%8s %9s  ", "-", "diverged");
        } else {
            printf("%8.3g %9.3g  ", MILLI * r->rms, MILLI * r->worst);
        }
        printf("%8.3g %8.3g %9.4g  %9.4g  ", MICRO * r->filter[0], MICRO * r->control[0],
               MICRO * r->both[1], 1 / r->both[0]);
        print_estimates(row);
        putchar('\n');
    }
}

static void print_flags(const char *title, const char *const *names, const long *counts)
{
    bool any = false;
    for (int i = 0; i < LOOP_FLAGS; i++) {
        if (counts[i] > 0) {
            if (any) {
                printf(", ");
            } else {
                printf("  %-10s ", title);
            }
            printf("%s %ld", names[i], counts[i]);
            any = true;
        }
    }
    if (any) {
        puts(" samples");
    }
}

void control_print_details(const control_row *row)
{
    const loop_report *r = &row->report;
    const control_settings *c = &row->control;
    printf("\n  %-10s at most %.3g mm off in the approach\n", "approach", MILLI * r->approach);
    printf(
        "  %-10s change by %.3g %% of their ranges a sample (mean), at most by %.3g %%; to and fro "
        "%.2g %%\n",
        "inputs", 100 * r->change[0], 100 * r->change[1], 100 * r->jitter);
    if (r->saturated > 0) {
        printf("  %-10s at a limit in %.3g %% of the periods\n", "inputs", 100 * r->saturated);
    }
    for (int i = 0; i < c->limit_count; i++) {
        printf("  constraint %d: violated in %.3g %% of the periods, by at most %.3g\n", i,
               100 * r->violated[i], r->violation[i]);
    }
    printf("  %-10s normalised squares of innovations, 1 if consistent:", "filter");
    for (int i = 0; i < c->measurement_count; i++) {
        if (isnan(r->innovation[i])) {
            printf("%s -", i ? "," : ""); /* nothing has arrived */
        } else {
            printf("%s %.3g", i ? "," : "", r->innovation[i]);
        }
    }
    printf("\n  %-10s beyond its bounds: mean square %.3g %%, bias %.3g %%, correlation %.3g %% of "
           "the windows; deviations taken %.2g times\n",
           "", 100 * r->beyond[LOOP_SQUARE], 100 * r->beyond[LOOP_BIAS],
           100 * r->beyond[LOOP_CORRELATION], r->doubt);
    print_flags("filter", filter_flags, r->filter_flags);
    print_flags("controller", control_flags, r->control_flags);
    if (r->late > 0) {
        printf("  %-10s late in %ld samples\n", "controller", r->late);
    }
}

/* ---- JSON ---------------------------------------------------------------------------------- */

static void json_flags(json *to, const char *title, const char *const *names, const long *counts)
{
    json_open(to, title, '{');
    for (int i = 0; i < LOOP_FLAGS && names[i]; i++) {
        json_integer(to, names[i], counts[i]);
    }
    json_close(to, '}');
}

static void json_times(json *to, const char *title, const double times[2])
{
    json_open(to, title, '{');
    json_number(to, "median", times[0]);
    json_number(to, "worst", times[1]);
    json_close(to, '}');
}

void control_json(int count, const control_row *rows, json *to)
{
    json_open(to, "loops", '[');
    for (int i = 0; i < count; i++) {
        const control_row *row = &rows[i];
        const loop_report *r = &row->report;
        json_open(to, NULL, '{');
        json_text(to, "name", row->name);
        json_text(to, "error", row->loop ? NULL : row->why.message);
        if (row->loop) {
            json_integer(to, "samples", r->done);
            json_integer(to, "diverged", r->diverged);
            json_number(to, "rms", r->rms);
            json_number(to, "worst", r->worst);
            json_number(to, "approach", r->approach);
            json_number(to, "reach", r->reach);
            json_number(to, "reach_worst", r->reach_worst);
            json_number(to, "modes", r->modes);
            json_number(to, "modes_worst", r->modes_worst);
            json_number(to, "saturated", r->saturated);
            json_open(to, "change", '{');
            json_number(to, "mean", r->change[0]);
            json_number(to, "worst", r->change[1]);
            json_number(to, "jitter", r->jitter);
            json_close(to, '}');
            json_times(to, "filter_seconds", r->filter);
            json_times(to, "control_seconds", r->control);
            json_times(to, "seconds", r->both);
            estimates_json(to, row->control.estimate_count, row->control.estimate, r->estimate,
                           r->deviation, "truth", r->truth);
            json_open(to, "innovations", '[');
            for (int k = 0; k < row->control.measurement_count; k++) {
                json_number(to, NULL, r->innovation[k]);
            }
            json_close(to, ']');
            json_open(to, "beyond", '{');
            json_number(to, "square", r->beyond[LOOP_SQUARE]);
            json_number(to, "bias", r->beyond[LOOP_BIAS]);
            json_number(to, "correlation", r->beyond[LOOP_CORRELATION]);
            json_close(to, '}');
            json_number(to, "doubt", r->doubt);
            control_residual_json(&r->residual, to);
            json_open(to, "constraints", '[');
            for (int k = 0; k < row->control.limit_count; k++) {
                json_open(to, NULL, '{');
                json_number(to, "violated", r->violated[k]);
                json_number(to, "worst", r->violation[k]);
                json_close(to, '}');
            }
            json_close(to, ']');
            json_flags(to, "filter_flags", filter_flags, r->filter_flags);
            json_flags(to, "control_flags", control_flags, r->control_flags);
            json_integer(to, "late", r->late);
        }
        json_close(to, '}');
    }
    json_close(to, ']');
}
