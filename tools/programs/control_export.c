/* A loop that cpinn-control ran, as C. */
#include "tools/programs/control_run.h"
#include "tools/programs/export_loop.h"

#include <math.h>
#include <stdio.h>

enum { LINES = 8, LINE = 300 };

static void describe(const control_row *row, const char *model, char lines[LINES][LINE])
{
    const loop_report *r = &row->report;
    const control_settings *c = &row->control;
    snprintf(lines[0], LINE, "Model: %s.", model);
    snprintf(lines[1], LINE,
             "Verified in closed loop with a simulated robot of finer modes, %.4g s: the place was "
             "off the path",
             (double)r->done * c->period);
    snprintf(lines[2], LINE, "by %.3g mm rms, at most %.3g mm after the approach%s.", 1e3 * r->rms,
             1e3 * r->worst, r->diverged ? "; THE ROBOT DIVERGED" : "");
    for (int i = 0, at = 0; i < c->estimate_count && at < LINE - 100; i++) {
        at += snprintf(lines[3] + at, (size_t)(LINE - at), "%sFound %.60s: %.4g +- %.2g (%.4g).",
                       i ? " " : "", c->estimate[i], r->estimate[i], r->deviation[i], r->truth[i]);
    }
}

ad_status control_export(const config *of, const control_row *row, const char *model,
                         const surrogate_step *filter, const surrogate_step *controller,
                         const char *out, bool force, char said[256], ad_error *error)
{
    const loop_parts parts = loop_parts_of(row->loop);
    char lines[LINES][LINE] = {""}, name[EXPORT_LOOP_NAME + 1];
    const char *verified[LINES + 1] = {NULL};
    const export_step steps[2] = {{filter, parts.linear[0]}, {controller, parts.linear[1]}};
    ad_status status = export_loop_name(out, name, error);
    if (status == AD_OK && (row->control.method == CONTROL_SAMPLING ||
                            (!controller && (!parts.linear[0] || !parts.linear[1])))) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "--c: a loop with %s is not written as C; allowed: control.method "
                         "predictive with a trained one-step model, or control.model linear",
                         row->control.method == CONTROL_SAMPLING ? "sampling" : "the reduced rod");
    }
    if (status == AD_OK && controller && controller->states == 0) {
        status =
            ad_fail(error, AD_BAD_INPUT,
                    "--c: a loop with damped sines is not written as C; allowed: surrogate.kind "
                    "flow, polynomial, polynomial_flow, linear");
    }
    if (status == AD_OK && filter && row->control.period < (1 - 1e-9) * filter->step) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "--c: a loop with parts of a model's step is not written as C; allowed: "
                         "--inner with a model of control.period");
    }
    if (status == AD_OK && row->control.residual) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "--c: a loop with control.residual is not written as C; leave it out");
    }
    if (status != AD_OK) {
        return status;
    }
    describe(row, model, lines);
    for (int i = 0, count = 0; i < LINES; i++) {
        if (lines[i][0]) {
            verified[count++] = lines[i];
        }
    }
    export_loop x = {.name = name,
                     .about = of->settings.name,
                     .open = &of->scene,
                     .settings = parts.settings,
                     .filter = steps[0],
                     .controller = steps[1],
                     .sensors = parts.sensors,
                     .seen = parts.seen,
                     .parts = parts.looks,
                     .state = parts.state,
                     .inputs = parts.inputs,
                     .by_parameters = parts.by_parameters,
                     .verified = verified};
    status = export_loop_write(&x, out, force, said, error);
    export_loop_free(&x);
    return status;
}
