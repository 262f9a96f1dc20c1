#include "tools/programs/eval_rollouts.h"

#include "tools/files/json.h"
#include "tools/files/table_file.h"
#include "tools/prepare/config_surrogate.h"
#include "tools/programs/cli.h"
#include "tools/surrogate/growth.h"
#include "tools/train/run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

rollouts_subject eval_rollouts_subject(const surrogate *s, const one_step *model)
{
    rollouts_subject subject = {.scene = s->scene,
                                .model = model,
                                .name = surrogate_kind_names()[s->settings.kind],
                                .linear = s->settings.hold == SURROGATE_RAMP};
    memcpy(subject.modes, s->settings.modes, sizeof subject.modes);
    for (int i = 0; i < model->inputs; i++) {
        subject.constant |= (uint32_t)surrogate_is_parameter(s, i) << i;
    }
    return subject;
}

/* ---- the verdict --------------------------------------------------------------------------- */

/* What to try where rollouts are off: the losses are squares. */
static const char *advice(surrogate_kind_id kind, double loss, double held_out)
{
    return kind == SURROGATE_LINEAR ? "try surrogate.kind: flow"
           : held_out > 2 * loss
               ? "held-out steps are off by far more than those that were learnt: try more of them "
                 "(surrogate.solved)"
               : "try a longer training, a wider network (network.hidden) or a smaller range of "
                 "the parameters";
}

void eval_rollouts_diverged(const rollouts_report *report, const char *try, verdict *to)
{
    char unstable[400] = "";
    if (!(report->growth <= SURROGATE_STABLE)) {
        snprintf(unstable, sizeof unstable,
                 "the robot has no stable rest with its inputs in the middle (deviations grow by a "
                 "factor of %.4g a step), so try %s",
                 report->growth, surrogate_steadier);
    }
    if (report->rows[ROLLOUTS_MODEL].diverged > 0) {
        verdict_add(to, VERDICT_DIVERGED,
                    "%d of %d rollouts of %d steps leave the solver by more than a quarter of "
                    "the length; %s; loops by the reduced rod need no model (surrogate: null)",
                    report->rows[ROLLOUTS_MODEL].diverged, report->count,
                    report->steps[ROLLOUTS_LONG], *unstable ? unstable : try);
    }
}

void eval_rollouts_verdict(const rollouts_report *report, const surrogate_settings *settings,
                           double loss, double held_out, verdict *to)
{
    const rollouts_row *row = &report->rows[ROLLOUTS_MODEL];
    const char *try = advice(settings->kind, loss, held_out);
    eval_rollouts_diverged(report, try, to);
    const double own = row->error[ROLLOUTS_SHORT][ROLLOUTS_MEDIAN];
    const double modes = report->rows[ROLLOUTS_FINER].error[ROLLOUTS_SHORT][ROLLOUTS_MEDIAN];
    if (!(modes <= settings->tolerance)) {
        verdict_add(to, VERDICT_ESTIMATE_ABOVE_TOLERANCE,
                    "%d, %d, %d, %d modes leave out %.2g %% of the length (median; "
                    "surrogate.tolerance %.2g %%), which errors beside the solver of as many do "
                    "not show; try more (surrogate.modes)",
                    settings->modes[0], settings->modes[1], settings->modes[2], settings->modes[3],
                    100 * modes, 100 * settings->tolerance);
    }
    if (report->lost > 0) {
        verdict_add(to, VERDICT_ERROR_UNKNOWN,
                    "%ld of %d rollouts end early, where the solver found no further step: errors "
                    "there are not known; try a shorter surrogate.step, or smaller ranges of the "
                    "parameters",
                    report->lost, report->count);
    }
    if (settings->kind != SURROGATE_LINEAR && !(own <= modes)) {
        verdict_add(to, VERDICT_NOT_CONVERGED,
                    "rollouts of 5 s are off the solver by %.2g %% of the length (median), "
                    "more than the %.2g %% that modes leave out; %s",
                    100 * own, 100 * modes, try);
    }
}

/* ---- text ---------------------------------------------------------------------------------- */

enum { CELL = EVAL_ROLLOUTS_CELL };

static void percent(const double error[2], char text[CELL])
{
    snprintf(text, CELL, isnan(error[ROLLOUTS_WORST]) ? "-" : "%.2g / %.2g",
             100 * error[ROLLOUTS_MEDIAN], 100 * error[ROLLOUTS_WORST]);
}

static void microseconds(double seconds, char text[CELL])
{
    snprintf(text, CELL, isnan(seconds) ? "-" : seconds < 9.95e-5 ? "%.3g" : "%.0f", 1e6 * seconds);
}

/* The fastest row of the rod itself that is no worse over 5 s. */
static const rollouts_row *rod_as_good(const rollouts_report *report)
{
    const rollouts_row *rows[2] = {&report->rows[ROLLOUTS_ROD], &report->rows[ROLLOUTS_ROD_TWICE]};
    for (int i = 0; i < 2; i++) {
        if (rows[i]->error[ROLLOUTS_SHORT][ROLLOUTS_WORST] <=
            report->rows[ROLLOUTS_MODEL].error[ROLLOUTS_SHORT][ROLLOUTS_WORST]) {
            return rows[i];
        }
    }
    return NULL;
}

void eval_rollouts_heads(const rollouts_report *report, char heads[EVAL_ROLLOUTS_CELLS][CELL])
{
    static const char *const names[] = {"",         "states", "one step", "",        "",
                                        "diverged", "one",    "147",      "Jacobian"};
    for (int k = 0; k < EVAL_ROLLOUTS_CELLS; k++) {
        snprintf(heads[k], CELL, "%s", names[k]);
    }
    snprintf(heads[3], CELL, "%g s", report->steps[ROLLOUTS_SHORT] * report->step);
    snprintf(heads[4], CELL, "%d steps", report->steps[ROLLOUTS_LONG]);
}

void eval_rollouts_cells(const rollouts_report *report, int r,
                         char cells[EVAL_ROLLOUTS_CELLS][CELL])
{
    const rollouts_row *row = &report->rows[r];
    snprintf(cells[0], CELL, "%s", row->name);
    snprintf(cells[1], CELL, "%d", row->states);
    for (int k = 0; k < ROLLOUTS_SPANS; k++) {
        percent(row->error[k], cells[2 + k]);
    }
    snprintf(cells[5], CELL, r == ROLLOUTS_FINER ? "-" : "%d", row->diverged);
    microseconds(row->alone, cells[6]);
    microseconds(row->together, cells[7]);
    microseconds(row->jacobian, cells[8]);
}

static void print_cells(FILE *file, char cells[EVAL_ROLLOUTS_CELLS][CELL])
{
    static const int widths[] = {-24, 7, 19, 19, 19, 10, 9, 9, 10};
    for (int k = 0; k < EVAL_ROLLOUTS_CELLS; k++) {
        fprintf(file, "%*s", widths[k], cells[k]);
    }
    fputc('\n', file);
}

void eval_rollouts_print(FILE *file, const rollouts_report *report)
{
    const rollouts_row *model = &report->rows[ROLLOUTS_MODEL], *rod = rod_as_good(report);
    char cells[EVAL_ROLLOUTS_CELLS][CELL];
    fprintf(file,
            "error of the tip in %% of the length (%g m), median / worst of %d rollouts with steps "
            "of %g s;\ntimes of a step in us of one core\n",
            report->length, report->count, report->step);
    eval_rollouts_heads(report, cells);
    print_cells(file, cells);
    for (int r = 0; r < ROLLOUTS_ROWS; r++) {
        eval_rollouts_cells(report, r, cells);
        print_cells(file, cells);
    }
    eval_rollouts_heads(report, cells);
    fprintf(file, "%s in mm: one step %.2g / %.2g", model->name,
            1e3 * report->length * model->error[ROLLOUTS_ONE][0],
            1e3 * report->length * model->error[ROLLOUTS_ONE][1]);
    if (!isnan(model->error[ROLLOUTS_SHORT][1])) {
        fprintf(file, ", %s %.2g / %.2g", cells[3],
                1e3 * report->length * model->error[ROLLOUTS_SHORT][0],
                1e3 * report->length * model->error[ROLLOUTS_SHORT][1]);
    }
    fputc('\n', file);
    if (rod) {
        fprintf(file, "the %s is at least as exact and takes %.3g times as long\n", rod->name,
                rod->alone / model->alone);
    }
    if (!isnan(report->outside)) {
        fprintf(file, "outside of the range of training: %.2g %% of the steps\n",
                100 * report->outside);
    }
    if (report->lost > 0) {
        fprintf(file, "%ld rollouts end early: the solver found no further step\n", report->lost);
    }
}

/* ---- files --------------------------------------------------------------------------------- */

enum { NUMBERS = 11 };
static const char *const number_names[] = {"model",          "states",       "one_step_median",
                                           "one_step_worst", "short_median", "short_worst",
                                           "long_median",    "long_worst",   "diverged",
                                           "seconds",        "seconds_147",  "seconds_jacobian"};

static void numbers_of(const rollouts_row *row, double numbers[NUMBERS])
{
    const double diverged = row->diverged;
    numbers[0] = row->states;
    memcpy(numbers + 1, row->error, sizeof row->error);
    memcpy(numbers + 7, (const double[]){diverged, row->alone, row->together, row->jacobian},
           4 * sizeof *numbers);
}

static ad_status write_table(const rollouts_report *report, const char *path, ad_error *error)
{
    const char *words[ROLLOUTS_ROWS];
    double columns[NUMBERS][ROLLOUTS_ROWS], numbers[NUMBERS];
    table_build to;
    for (int r = 0; r < ROLLOUTS_ROWS; r++) {
        words[r] = report->rows[r].name;
        numbers_of(&report->rows[r], numbers);
        for (int k = 0; k < NUMBERS; k++) {
            columns[k][r] = numbers[k];
        }
    }
    table_begin(&to, ROLLOUTS_ROWS);
    table_add(&to, number_names[0], NULL, NULL, words);
    for (int k = 0; k < NUMBERS; k++) {
        table_add(&to, number_names[1 + k], NULL, columns[k], NULL);
    }
    return table_write(path, &to.table, error);
}

static ad_status write_files(const rollouts_report *report, const char *folder, ad_error *error)
{
    static const char *const endings[] = {"csv", "h5"};
    char path[4096];
    ad_status status = run_make_folder(folder, error);
    for (int i = 0; status == AD_OK && i < 2; i++) {
        snprintf(path, sizeof path, "%s/rollouts.%s", folder, endings[i]);
        status = write_table(report, path, error);
    }
    return status;
}

static ad_status write_json(const eval_rollouts_options *asked, const surrogate *s,
                            const rollouts_report *report, ad_error *error)
{
    json to;
    json_begin(&to);
    json_text(&to, "checkpoint", asked->path);
    json_text(&to, "kind", surrogate_kind_names()[s->settings.kind]);
    json_integer(&to, "rollouts", report->count);
    json_number(&to, "step", report->step);
    json_number(&to, "length", report->length);
    json_integer(&to, "short_steps", report->steps[ROLLOUTS_SHORT]);
    json_integer(&to, "long_steps", report->steps[ROLLOUTS_LONG]);
    json_number(&to, "outside", report->outside);
    json_number(&to, "solver_seconds", report->solver);
    json_integer(&to, "lost", report->lost);
    json_number(&to, "tolerance", asked->tolerance);
    json_open(&to, "rows", '[');
    for (int r = 0; r < ROLLOUTS_ROWS; r++) {
        double numbers[NUMBERS];
        numbers_of(&report->rows[r], numbers);
        json_open(&to, NULL, '{');
        json_text(&to, number_names[0], report->rows[r].name);
        for (int k = 0; k < NUMBERS; k++) {
            json_number(&to, number_names[1 + k], numbers[k]);
        }
        json_close(&to, '}');
    }
    json_close(&to, ']');
    return json_end(&to, asked->json, error);
}

/* ---- all of it ----------------------------------------------------------------------------- */

ad_status eval_rollouts_judge(const surrogate *s, int count, uint64_t seed, ad_pool *pool,
                              rollouts_report *report, ad_error *error)
{
    one_step model;
    ad_status status = surrogate_one_step(s, &model, error);
    if (status == AD_OK) {
        const rollouts_subject subject = eval_rollouts_subject(s, &model);
        status = rollouts_judge(&subject, count, seed, pool, report, error);
        surrogate_one_step_free(&model);
    }
    return status;
}

static ad_status report_of(const eval_rollouts_options *asked, const surrogate *s,
                           rollouts_report *report, ad_error *error)
{
    ad_pool *pool = NULL;
    ad_status status = ad_pool_open(asked->threads, &pool, error);
    status = status == AD_OK ? ad_pool_share(pool, asked->ranks, error) : status;
    if (status == AD_OK) {
        status = eval_rollouts_judge(s, asked->count, (uint64_t)asked->seed, pool, report, error);
    }
    ad_pool_free(pool);
    return status;
}

int eval_rollouts_run(const char *program, const eval_rollouts_options *asked)
{
    const bool printed = !asked->quiet && !json_is_printed(asked->json);
    surrogate *s = NULL;
    rollouts_report report = {0};
    ad_error error = {.message = ""};
    ad_status result = json_check_path(asked->json, &error);
    result = result == AD_OK ? surrogate_load(asked->path, &s, &error) : result;
    result = result == AD_OK ? report_of(asked, s, &report, &error) : result;
    if (result == AD_OK && asked->out && ad_ranks_is_first(asked->ranks)) {
        result = write_files(&report, asked->out, &error);
    }
    if (result == AD_OK && asked->json) {
        result = write_json(asked, s, &report, &error);
    }
    if (result == AD_OK && printed) {
        eval_rollouts_print(stdout, &report);
    }
    const bool fails = result == AD_OK && rollouts_fail(&report, asked->tolerance);
    if (fails && (printed || asked->quiet)) {
        fprintf(printed ? stdout : stderr, "not trusted: %s\n",
                report.rows[ROLLOUTS_MODEL].diverged > 0 ? "rollouts diverge"
                                                         : "worse than --tolerance");
    }
    rollouts_free(&report);
    surrogate_free(s);
    return result != AD_OK ? cli_fail_error(program, &error) : fails ? 3 : 0;
}
