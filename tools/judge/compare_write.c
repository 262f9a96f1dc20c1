/* Results as text and as tables of files. */
#include "tools/judge/compare.h"

#include "tools/judge/result_table.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- terminal ------------------------------------------------------------------------------ */

/* Columns of the first three, for the longest name. */
typedef struct widths {
    int method, network, form;
} widths;

static widths widths_of(const compare_results *results)
{
    widths w = {(int)strlen("method"), (int)strlen("network"), (int)strlen("form")};
    for (int i = 0; i < results->cell_count; i++) {
        int method = (int)strlen(results->cells[i].method);
        int network = (int)strlen(results->cells[i].network);
        int form = (int)strlen(results->cells[i].form);
        w.method = method > w.method ? method : w.method;
        w.network = network > w.network ? network : w.network;
        w.form = form > w.form ? form : w.form;
    }
    return w;
}

static void print_heading(FILE *file, const compare_results *results, int cell, widths w)
{
    fprintf(file, "\n%s: %s, medians over seeds (smallest .. largest)\n\n",
            results->cells[cell].scene_name, judge_measure_text(results->measure));
    fprintf(file, "  %*s seconds to an error of\n", w.method + w.network + w.form + 19, "");
    fprintf(file, "  %-*s %-*s %-*s %6s %7s", w.method, "method", w.network, "network", w.form,
            "form", "params", "steps/s");
    for (int k = 0; k < COMPARE_LIMITS; k++) {
        fprintf(file, " %6.0e", compare_limits[k]);
    }
    fprintf(file, "  error at the end\n");
}

static void print_end(FILE *file, const compare_summary *summary)
{
    char text[32];
    const compare_spread *error = &summary->error;
    if (summary->seeds == 0) {
        fprintf(file, "  not run\n");
        return;
    }
    fprintf(file, "  %s", result_table_error(error->median, text));
    if (summary->seeds > 1) {
        fprintf(file, " (%s", result_table_error(error->low, text));
        fprintf(file, " .. %s)", result_table_error(error->high, text));
    }
    if (summary->failed) {
        fprintf(file, ", %d of %d failed", summary->failed, summary->seeds);
    }
    if (summary->warned) {
        fprintf(file, ", %d of %d with a warning", summary->warned, summary->seeds);
    }
    fputc('\n', file);
}

static void print_cell(FILE *file, const compare_results *results, int cell, widths w)
{
    char text[32];
    const compare_cell *of = &results->cells[cell];
    double estimate = of->estimates[results->measure];
    compare_summary summary = compare_summarize(results, cell);
    snprintf(text, sizeof text, of->parameters > 0 ? "%zu" : "-", of->parameters);
    fprintf(file, "  %-*s %-*s %-*s %6s", w.method, of->method, w.network, of->network, w.form,
            of->form, text);
    snprintf(text, sizeof text, isnan(summary.steps_per_second) ? "-" : "%.0f",
             summary.steps_per_second);
    fprintf(file, " %7s", text);
    for (int k = 0; k < COMPARE_LIMITS; k++) {
        fprintf(file, " %6s", result_table_seconds(summary.reached[k], text));
    }
    print_end(file, &summary);
    if (summary.error.low <= estimate) {
        fprintf(
            file,
            "    the reference itself is off by an estimated %.1e; true errors may be as large\n",
            estimate);
    }
}

void compare_print(FILE *file, const compare_results *results)
{
    widths w = widths_of(results);
    for (int i = 0; i < results->cell_count; i++) {
        if (i == 0 || results->cells[i].scene != results->cells[i - 1].scene) {
            print_heading(file, results, i, w);
        }
        print_cell(file, results, i, w);
    }
}

/* ---- files --------------------------------------------------------------------------------- */

enum { WORDS = 3 };

#define CELL_NAMES   "scene", "method", "network"
#define COUNT(names) (sizeof(names) / sizeof *(names)-WORDS)

static void add(result_table *s, const compare_cell *cell, const double *numbers)
{
    result_table_add(s, (const char *const[WORDS]){cell->scene_name, cell->method, cell->network},
                     numbers);
}

static ad_status finish(result_table *s, const char *folder, const char *name, ad_error *error)
{
    ad_status status = result_table_write_both(s, folder, name, error);
    result_table_free(s);
    return status;
}

static ad_status write_runs(const compare_results *results, const char *folder, ad_error *error)
{
    static const char *const names[] = {CELL_NAMES,  "seed",          "seconds", "step",
                                        "error",     "held_out",      "loss",    "position_error",
                                        "tip_error", "rotation_error"};
    size_t rows = 0;
    for (int i = 0; i < results->run_count; i++) {
        rows += results->runs[i].count;
    }
    result_table s = result_table_create(names, WORDS, COUNT(names), rows);
    for (int i = 0; i < results->run_count; i++) {
        const compare_run *run = &results->runs[i];
        for (size_t k = 0; k < run->count; k++) {
            const compare_row *row = &run->rows[k];
            add(&s, &results->cells[run->cell],
                (const double[]){(double)run->seed, row->seconds, row->step,
                                 row->errors[results->measure], row->held_out, row->loss,
                                 row->errors[JUDGE_POSITION], row->errors[JUDGE_TIP],
                                 row->errors[JUDGE_ROTATION]});
        }
    }
    return finish(&s, folder, "runs", error);
}

static ad_status write_summary(const compare_results *results, const char *folder, ad_error *error)
{
    static const char *const names[] = {CELL_NAMES,        "parameters",      "seeds",
                                        "failed",          "seconds",         "steps_per_second",
                                        "error_median",    "error_low",       "error_high",
                                        "seconds_to_1e-2", "seconds_to_1e-3", "seconds_to_1e-4",
                                        "seconds_to_1e-5", "seconds_to_1e-6", "warnings"};
    result_table s = result_table_create(names, WORDS, COUNT(names), (size_t)results->cell_count);
    for (int i = 0; i < results->cell_count; i++) {
        compare_summary summary = compare_summarize(results, i);
        double numbers[COUNT(names)] = {(double)results->cells[i].parameters,
                                        summary.seeds,
                                        summary.failed,
                                        summary.seconds,
                                        summary.steps_per_second,
                                        summary.error.median,
                                        summary.error.low,
                                        summary.error.high};
        memcpy(numbers + 8, summary.reached, sizeof summary.reached);
        numbers[8 + COMPARE_LIMITS] = summary.warned;
        add(&s, &results->cells[i], numbers);
    }
    return finish(&s, folder, "summary", error);
}

static ad_status write_curves(const compare_results *results, const char *folder, ad_error *error)
{
    static const char *const names[] = {CELL_NAMES, "seconds", "median", "low", "high"};
    compare_band *band = malloc(sizeof *band);
    if (!band) {
        return ad_fail(error, AD_NO_MEMORY, "out of memory for curves");
    }
    result_table s = result_table_create(names, WORDS, COUNT(names),
                                         (size_t)results->cell_count * (COMPARE_GRID + 1));
    for (int i = 0; i < results->cell_count; i++) {
        compare_band_of(results, i, band);
        for (size_t k = 0; k < band->count; k++) {
            const compare_spread *spread = &band->errors[k];
            add(&s, &results->cells[i],
                (const double[]){band->seconds[k], spread->median, spread->low, spread->high});
        }
    }
    free(band);
    return finish(&s, folder, "curves", error);
}

ad_status compare_write(const compare_results *results, const char *folder, ad_error *error)
{
    ad_status status = write_runs(results, folder, error);
    if (status == AD_OK) {
        status = write_summary(results, folder, error);
    }
    return status == AD_OK ? write_curves(results, folder, error) : status;
}
