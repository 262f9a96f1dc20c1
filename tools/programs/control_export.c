/* A loop that cpinn-control ran, as C. */
#include "tools/emit/export_loop.h"
#include "tools/programs/cli.h"
#include "tools/programs/control_run.h"
#include "tools/programs/eval_rollouts.h"
#include "tools/programs/export_files.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LINES = 8, LINE = 300, ROLLOUTS = 8, SHORT_ROLLOUTS = 2 /* of a filter: many steps */ };

/* Rollouts of a trained model that no training saw, beside the solver. */
static ad_status verify(const surrogate *s, const char *whose, int count, char line[LINE],
                        verdict *to, ad_error *error)
{
    one_step model;
    rollouts_report x = {0};
    ad_status status = surrogate_one_step(s, &model, error);
    if (status != AD_OK) {
        return status;
    }
    const rollouts_subject subject = eval_rollouts_subject(s, &model);
    ad_pool *pool = ad_pool_create(1);
    status = pool ? rollouts_judge(&subject, count, 0, pool, &x, error)
                  : ad_fail(error, AD_NO_MEMORY, "out of memory for rollouts");
    double(*const e)[2] = x.rows[ROLLOUTS_MODEL].error;
    snprintf(
        line, LINE,
        "%s beside the solver, %% of the length, median / worst of %d rollouts:\n *   one step "
        "%.2g / %.2g, %.3g s %.2g / %.2g, %d steps %.2g / %.2g;\n *   its modes leave out %.2g / "
        "%.2g; diverged %d.",
        whose, x.count, 100 * e[ROLLOUTS_ONE][0], 100 * e[ROLLOUTS_ONE][1],
        x.steps[ROLLOUTS_SHORT] * x.step, 100 * e[ROLLOUTS_SHORT][0], 100 * e[ROLLOUTS_SHORT][1],
        x.steps[ROLLOUTS_LONG], 100 * e[ROLLOUTS_LONG][0], 100 * e[ROLLOUTS_LONG][1],
        100 * x.rows[ROLLOUTS_FINER].error[ROLLOUTS_SHORT][0],
        100 * x.rows[ROLLOUTS_FINER].error[ROLLOUTS_SHORT][1], x.rows[ROLLOUTS_MODEL].diverged);
    if (status == AD_OK) {
        eval_rollouts_diverged(&x, "train it longer, or within smaller ranges", to);
    }
    ad_pool_free(pool);
    rollouts_free(&x);
    surrogate_one_step_free(&model);
    return status;
}

static export_step step_of(const surrogate *s, const linear_step *linear)
{
    return (export_step){.surrogate = s ? &s->step : NULL, .linear = s ? NULL : linear};
}

static void describe(const control_row *row, const char *model, char lines[LINES][LINE])
{
    const loop_report *r = &row->report;
    const control_settings *c = &row->control;
    snprintf(lines[0], LINE, "Model: %s.", model);
    snprintf(lines[1], LINE,
             "Verified in closed loop with a simulated robot of %d, %d, %d, %d modes, %.4g s: the "
             "place was off the path",
             c->plant_modes[0], c->plant_modes[1], c->plant_modes[2], c->plant_modes[3],
             (double)r->done * c->period);
    snprintf(lines[2], LINE, "by %.3g mm rms, at most %.3g mm after the approach%s.", 1e3 * r->rms,
             1e3 * r->worst, r->diverged ? "; THE ROBOT DIVERGED" : "");
    for (int i = 0, at = 0; i < c->estimate_count && at < LINE - 100; i++) {
        at += snprintf(lines[3] + at, (size_t)(LINE - at), "%sFound %.60s: %.4g +- %.2g (%.4g).",
                       i ? " " : "", c->estimate[i], r->estimate[i], r->deviation[i], r->truth[i]);
    }
}

/* Whether the self-test agrees, whose first line is `said`. Without a compiler the files are as
 * good all the same, with a warning. */
static ad_status check(const export_loop *loop, const export_texts texts, char said[256],
                       ad_error *error)
{
    char *lines = NULL;
    ad_status status = export_texts_check(texts, loop->name, "c11", &lines, error);
    snprintf(said, 256, "%.*s", lines ? (int)strcspn(lines, "\n") : 12,
             lines ? lines : "not compiled");
    free(lines);
    if (status == AD_IO) {
        cli_warn("cpinn-control", "the C has not been compiled and checked: %s", error->message);
        status = AD_OK;
    }
    return status;
}

static ad_status write_files(export_loop *loop, const export_out *to, char said[256],
                             ad_error *error)
{
    export_texts texts = {{.bytes = NULL}};
    ad_status status = export_files_check(to, error);
    status = status == AD_OK ? export_loop_record(loop, error) : status;
    if (status == AD_OK) {
        status = export_texts_write_all(texts, export_loop_write, loop, error);
    }
    status = status == AD_OK ? check(loop, texts, said, error) : status;
    status = status == AD_OK ? export_files_put(to, texts, error) : status;
    export_texts_free(texts);
    return status;
}

ad_status control_export(const config *of, const control_row *row, const char *model,
                         const surrogate *filter, const surrogate *controller, const char *out,
                         bool force, char said[256], verdict *found, ad_error *error)
{
    const loop_parts parts = loop_parts_of(row->loop);
    char lines[LINES][LINE] = {""};
    export_out to = {.option = "--c", .path = out, .force = force};
    const char *verified[LINES + 1] = {NULL};
    const export_step steps[2] = {step_of(filter, parts.linear[0]),
                                  step_of(controller, parts.linear[1])};
    ad_status status = export_files_name(&to, error);
    if (status == AD_OK && export_loop_takes(to.name)) {
        status = ad_fail(error, AD_BAD_ARGUMENT,
                         "--c %s: the C has functions of its own called %s_...; allowed: any other "
                         "name",
                         out, to.name);
    }
    if (status == AD_OK && (row->control.residual || (!controller && !parts.linear[1]))) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "--c: a loop with %s is not written as C; allowed: a trained one-step "
                         "model, or control.model linear, without residual",
                         row->control.residual ? "control.residual" : "the reduced rod");
    }
    if (status == AD_OK && filter && filter->settings.kind == SURROGATE_POLYNOMIAL &&
        row->control.period < (1 - 1e-9) * filter->settings.step) {
        status = ad_fail(error, AD_BAD_INPUT,
                         "--c: a loop with parts of a model's step is not written as C; allowed: "
                         "--inner with a model of control.period");
    }
    if (status == AD_OK && controller) {
        status = verify(controller, "The controller's model", ROLLOUTS, lines[4], found, error);
    }
    if (status == AD_OK && filter && filter != controller) {
        status = verify(filter, "The filter's model", SHORT_ROLLOUTS, lines[5], found, error);
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
    export_loop x = {.name = to.name,
                     .about = of->settings.name,
                     .open = &of->scene,
                     .settings = parts.settings,
                     .filter = steps[0],
                     .controller = steps[1],
                     .sensors = parts.sensors,
                     .seen = parts.seen,
                     .parts = parts.observations,
                     .clearance = parts.clearance,
                     .clearance_part = parts.clearance_part,
                     .state = parts.state,
                     .inputs = parts.inputs,
                     .by_parameters = parts.by_parameters,
                     .verified = verified};
    status = write_files(&x, &to, said, error);
    export_loop_free(&x);
    return status;
}
