/* Results as text and as tables of files. */
#include "tools/judge/compare/compare.h"

#include "tools/files/table_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- terminal ------------------------------------------------------------------------------ */

const char *compare_seconds(double seconds, char text[COMPARE_SECONDS])
{
    if (!isfinite(seconds)) {
        return "-";
    }
    int digits = seconds < 0.00095  ? 4
                 : seconds < 0.0995 ? 3
                 : seconds < 9.995  ? 2
                 : seconds < 99.95  ? 1
                                    : 0;
    snprintf(text, COMPARE_SECONDS, "%.*f", digits, seconds);
    return text;
}

static const char *error_text(double error, char text[32])
{
    snprintf(text, 32, isfinite(error) ? "%.1e" : "-", error);
    return text;
}

/* Columns of the first two, for the longest name. */
typedef struct widths {
    int method, network;
} widths;

static widths widths_of(const compare_results *results)
{
    widths w = {(int)strlen("method"), (int)strlen("network")};
    for (int i = 0; i < results->cell_count; i++) {
        int method = (int)strlen(results->cells[i].method);
        int network = (int)strlen(results->cells[i].network);
        w.method = method > w.method ? method : w.method;
        w.network = network > w.network ? network : w.network;
    }
    return w;
}

static void print_heading(FILE *file, const compare_results *results, int cell, widths w)
{
    fprintf(file, "\n%s: %s, medians over seeds (smallest .. largest)\n\n",
            results->cells[cell].scene_name, compare_measure_text(results->measure));
    fprintf(file, "  %*s seconds to an error of\n", w.method + w.network + 18, "");
    fprintf(file, "  %-*s %-*s %6s %7s", w.method, "method", w.network, "network", "params",
            "steps/s");
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
    fprintf(file, "  %s", error_text(error->median, text));
    if (summary->seeds > 1) {
        fprintf(file, " (%s", error_text(error->low, text));
        fprintf(file, " .. %s)", error_text(error->high, text));
    }
    if (summary->failed) {
        fprintf(file, ", %d of %d failed", summary->failed, summary->seeds);
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
    fprintf(file, "  %-*s %-*s %6s", w.method, of->method, w.network, of->network, text);
    snprintf(text, sizeof text, isnan(summary.steps_per_second) ? "-" : "%.0f",
             summary.steps_per_second);
    fprintf(file, " %7s", text);
    for (int k = 0; k < COMPARE_LIMITS; k++) {
        fprintf(file, " %6s", compare_seconds(summary.reached[k], text));
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

enum { WORDS = 3, COLUMNS_MAX = 24 };

/* A table under construction: scene, method and network, then numbers. */
typedef struct sheet {
    const char *names[COLUMNS_MAX];
    int columns; /* the three words included */
    size_t rows, capacity;
    const char **words; /* [WORDS][capacity] */
    double *numbers;    /* [columns - WORDS][capacity] */
} sheet;

static bool sheet_create(sheet *s, const char *const *names, int count, size_t capacity)
{
    static const char *const words[WORDS] = {"scene", "method", "network"};
    *s = (sheet){.columns = WORDS + count, .capacity = capacity > 0 ? capacity : 1};
    memcpy(s->names, words, sizeof words);
    memcpy(s->names + WORDS, names, (size_t)count * sizeof *names);
    s->words = calloc(WORDS * s->capacity, sizeof *s->words);
    s->numbers = calloc((size_t)count * s->capacity, sizeof *s->numbers);
    return s->words && s->numbers;
}

static void sheet_free(sheet *s)
{
    free(s->words);
    free(s->numbers);
}

static void sheet_add(sheet *s, const compare_cell *cell, const double *numbers)
{
    const char *const words[WORDS] = {cell->scene_name, cell->method, cell->network};
    for (size_t k = 0; k < WORDS; k++) {
        s->words[k * s->capacity + s->rows] = words[k];
    }
    for (size_t k = 0; k < (size_t)(s->columns - WORDS); k++) {
        s->numbers[k * s->capacity + s->rows] = numbers[k];
    }
    s->rows++;
}

static ad_status sheet_write(const sheet *s, const char *folder, const char *name, ad_error *error)
{
    static const char *const endings[] = {"csv", "h5"};
    const double *numbers[COLUMNS_MAX] = {NULL};
    const char *const *words[COLUMNS_MAX] = {NULL};
    char path[4096];
    ad_status status = AD_OK;
    for (int k = 0; k < s->columns; k++) {
        size_t at = (size_t)(k < WORDS ? k : k - WORDS) * s->capacity;
        if (k < WORDS) {
            words[k] = s->words + at;
        } else {
            numbers[k] = s->numbers + at;
        }
    }
    for (int i = 0; status == AD_OK && i < 2; i++) {
        snprintf(path, sizeof path, "%s/%s.%s", folder, name, endings[i]);
        status =
            table_write_words(path, s->names, numbers, words, (size_t)s->columns, s->rows, error);
    }
    return status;
}

static ad_status no_memory(const char *name, ad_error *error)
{
    return ad_fail(error, AD_NO_MEMORY, "out of memory for %s.csv", name);
}

static ad_status write_runs(const compare_results *results, const char *folder, ad_error *error)
{
    static const char *const names[] = {"seed",           "seconds",   "step",
                                        "error",          "held_out",  "loss",
                                        "position_error", "tip_error", "rotation_error"};
    sheet s;
    size_t rows = 0;
    for (int i = 0; i < results->run_count; i++) {
        rows += results->runs[i].count;
    }
    bool made = sheet_create(&s, names, (int)(sizeof names / sizeof *names), rows);
    for (int i = 0; made && i < results->run_count; i++) {
        const compare_run *run = &results->runs[i];
        for (size_t k = 0; k < run->count; k++) {
            const compare_row *row = &run->rows[k];
            sheet_add(&s, &results->cells[run->cell],
                      (const double[]){(double)run->seed, row->seconds, row->step,
                                       row->errors[results->measure], row->held_out, row->loss,
                                       row->errors[COMPARE_POSITION], row->errors[COMPARE_TIP],
                                       row->errors[COMPARE_ROTATION]});
        }
    }
    ad_status status = made ? sheet_write(&s, folder, "runs", error) : no_memory("runs", error);
    sheet_free(&s);
    return status;
}

static ad_status write_summary(const compare_results *results, const char *folder, ad_error *error)
{
    static const char *const names[] = {
        "parameters",       "seeds",           "failed",          "seconds",
        "steps_per_second", "error_median",    "error_low",       "error_high",
        "seconds_to_1e-2",  "seconds_to_1e-3", "seconds_to_1e-4", "seconds_to_1e-5",
        "seconds_to_1e-6"};
    sheet s;
    bool made =
        sheet_create(&s, names, (int)(sizeof names / sizeof *names), (size_t)results->cell_count);
    for (int i = 0; made && i < results->cell_count; i++) {
        compare_summary summary = compare_summarize(results, i);
        double numbers[sizeof names / sizeof *names] = {(double)results->cells[i].parameters,
                                                        summary.seeds,
                                                        summary.failed,
                                                        summary.seconds,
                                                        summary.steps_per_second,
                                                        summary.error.median,
                                                        summary.error.low,
                                                        summary.error.high};
        memcpy(numbers + 8, summary.reached, sizeof summary.reached);
        sheet_add(&s, &results->cells[i], numbers);
    }
    ad_status status =
        made ? sheet_write(&s, folder, "summary", error) : no_memory("summary", error);
    sheet_free(&s);
    return status;
}

static ad_status write_curves(const compare_results *results, const char *folder, ad_error *error)
{
    static const char *const names[] = {"seconds", "median", "low", "high"};
    sheet s;
    compare_band *band = malloc(sizeof *band);
    bool made = sheet_create(&s, names, (int)(sizeof names / sizeof *names),
                             (size_t)results->cell_count * (COMPARE_GRID + 1)) &&
                band;
    for (int i = 0; made && i < results->cell_count; i++) {
        compare_band_of(results, i, band);
        for (size_t k = 0; k < band->count; k++) {
            const compare_spread *spread = &band->errors[k];
            sheet_add(
                &s, &results->cells[i],
                (const double[]){band->seconds[k], spread->median, spread->low, spread->high});
        }
    }
    ad_status status = made ? sheet_write(&s, folder, "curves", error) : no_memory("curves", error);
    sheet_free(&s);
    free(band);
    return status;
}

ad_status compare_write(const compare_results *results, const char *folder, ad_error *error)
{
    ad_status status = write_runs(results, folder, error);
    if (status == AD_OK) {
        status = write_summary(results, folder, error);
    }
    return status == AD_OK ? write_curves(results, folder, error) : status;
}
