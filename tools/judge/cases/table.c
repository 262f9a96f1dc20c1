/* Rows as text and as files. */
#include "tools/files/table_file.h"
#include "tools/judge/cases/cases.h"
#include "tools/judge/compare/compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- for people ---------------------------------------------------------------------------- */

void cases_print_heading(FILE *file, int width)
{
    fprintf(file, "%-*s  %-6s  %8s  %8s  %7s  %-27s  %s\n", width, "case", "method", "position",
            "rotation", "seconds", "size", "left out");
}

static const char *error_text(double error, char text[16])
{
    snprintf(text, 16, isnan(error) ? "-" : "%.1e", error);
    return text;
}

/* "1 equation", "2 equations" */
static void count_text(double count, const char *what, char text[32])
{
    snprintf(text, 32, "%.0f %s%s", count, what, count == 1 ? "" : "s");
}

static void size_text(const cases_row *row, char text[72])
{
    bool trained = row->method == CASES_PINN;
    char first[32], second[32];
    count_text(trained ? row->unknowns : row->points, trained ? "unknown" : "node", first);
    count_text(trained ? row->equations : row->steps, trained ? "equation" : "step", second);
    bool direct = !trained && row->steps == 0; /* a linear scene */
    snprintf(text, 72, isnan(row->points) ? "-" : direct ? "%s" : "%s, %s", first, second);
}

/* "time, shear" for "time; shear". */
static void print_left_out(FILE *file, const char *text)
{
    for (; *text; text++) {
        fputc(*text == ';' ? ',' : *text, file);
    }
}

void cases_print_row(FILE *file, const cases_row *row, int width)
{
    char position[16], rotation[16], seconds[COMPARE_SECONDS], size[72];
    size_text(row, size);
    fprintf(file, "%-*s  %-6s  %8s  %8s  %7s  %-27s  ", width,
            row->method == CASES_PINN ? row->name : "", cases_method_name(row->method),
            error_text(row->position, position), error_text(row->rotation, rotation),
            compare_seconds(row->seconds, seconds), size);
    print_left_out(file, *row->left_out ? row->left_out : "-");
    fputc('\n', file);
    if (row->outcome != CASES_SOLVED) {
        fprintf(file, "%*s  %s: %s\n", width, "", cases_outcome_name(row->outcome), row->text);
    }
}

/* ---- files --------------------------------------------------------------------------------- */

enum { WORDS = 4, NUMBERS = 8, COLUMNS = WORDS + NUMBERS };

ad_status cases_write(const cases_row *rows, size_t count, const char *folder, ad_error *error)
{
    static const char *const names[COLUMNS] = {
        "case",    "method",   "outcome",   "left_out",     "position_error", "rotation_error",
        "seconds", "unknowns", "equations", "instructions", "points",         "steps"};
    static const char *const endings[] = {"csv", "h5"};
    const char **words = calloc(WORDS * count + 1, sizeof *words);
    double *numbers = calloc(NUMBERS * count + 1, sizeof *numbers);
    const char *const *word_columns[COLUMNS] = {NULL};
    const double *columns[COLUMNS] = {NULL};
    char path[4096];
    ad_status status = words && numbers
                           ? AD_OK
                           : ad_fail(error, AD_NO_MEMORY, "out of memory for %zu cases", count);
    for (size_t i = 0; status == AD_OK && i < count; i++) {
        const cases_row *row = &rows[i];
        const char *told[WORDS] = {row->name, cases_method_name(row->method),
                                   cases_outcome_name(row->outcome),
                                   *row->left_out ? row->left_out : "nothing"};
        const double values[NUMBERS] = {row->position, row->rotation,  row->seconds,
                                        row->unknowns, row->equations, row->instructions,
                                        row->points,   row->steps};
        for (size_t k = 0; k < WORDS; k++) {
            words[k * count + i] = told[k];
        }
        for (size_t k = 0; k < NUMBERS; k++) {
            numbers[k * count + i] = values[k];
        }
    }
    for (size_t k = 0; status == AD_OK && k < COLUMNS; k++) {
        if (k < WORDS) {
            word_columns[k] = words + k * count;
        } else {
            columns[k] = numbers + (k - WORDS) * count;
        }
    }
    for (int i = 0; status == AD_OK && i < 2; i++) {
        snprintf(path, sizeof path, "%s/cases.%s", folder, endings[i]);
        status = table_write_words(path, names, columns, word_columns, COLUMNS, count, error);
    }
    free(words);
    free(numbers);
    return status;
}
